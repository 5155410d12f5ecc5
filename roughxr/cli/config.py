"""The options of `run` in a file of TOML: read before those of the shell, and written out to be edited."""

from __future__ import annotations

import argparse
import json
import textwrap
from pathlib import Path
from typing import Any

from .options import run_parser
from .spelling import meant, option_names


def with_config(words: list[str]) -> list[str]:
    """Return the words of a command with the options of its configuration file before them, so that theirs prevail."""
    if words[:1] != ["run"]:
        return words
    of_file = argparse.ArgumentParser(prog="roughxr run", add_help=False, allow_abbrev=False)
    of_file.add_argument("--config")
    file, rest = of_file.parse_known_args(words[1:])
    if file.config is None:
        return words
    given = [word for name, value in _stated(file.config).items() for word in _words(name, value)]
    scans = next((k for k, word in enumerate(rest) if word.startswith("-")), len(rest))
    return ["run", *rest[:scans], *given, *rest[scans:]]


def _stated(path: str) -> dict[str, Any]:
    """Return the options in a file, by the names that the shell has for them."""
    import tomllib

    try:
        stated = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(
            f'{path}: expected TOML with text in quotes, such as humidity = "50 %", found an error: {error}'
        ) from error
    known = option_names(run_parser())
    for name in stated:
        if name.replace("_", "-") not in known:
            raise ValueError(f"{path}: expected options of `roughxr run`, found {name!r}{meant(name, known)}")
    return {name.replace("_", "-"): value for name, value in stated.items()}


def _words(name: str, value: Any) -> list[str]:
    """Return an option's value as it is typed."""
    if isinstance(value, bool):
        return [f"--{name}"] * value
    if isinstance(value, list) and len(value) != 1:
        return [f"--{name}", *map(str, value)]
    return [f"--{name}={value[0] if isinstance(value, list) else value}"]


def write(options: argparse.Namespace) -> None:
    """Write each option of `run` as a commented line of TOML, with its help."""
    if Path(options.output).exists():
        raise ValueError(f"{options.output}: exists already, and may hold your options; give another name")
    lines = ['# Options of roughxr run. Remove the # before each option that you set. Text may have units: "3 um".']
    for action in run_parser()._actions:
        name = max(action.option_strings, key=len, default="").removeprefix("--")
        if name in ("", "help", "config", "output", "quiet"):
            continue
        words = (action.help or "") % {"default": action.default}
        lines += ["", *textwrap.wrap(words, 100, initial_indent="# ", subsequent_indent="# ")]
        lines += [f"# {name} = {json.dumps('' if action.default is None else action.default)}"]
    Path(options.output).write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"written to {options.output}")
