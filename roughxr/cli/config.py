"""Options of a command in a file: ``--write-config FILE`` writes it with comments, ``--config FILE`` reads it.

A file is TOML, one option a line: ``sphere_radius = "3 um"``. It may come from a stranger, so that it sets neither the
scheduler, which runs code, nor a file that is written.
"""

from __future__ import annotations

import argparse
import json
import shlex
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..vocabulary.text import did_you_mean

_HEADER = """\
# Options of `roughxr run` for --config. Remove the # before an option to set it.
# An option on the command line replaces that of this file.
"""

#: Name under which a parser keeps the options that a file may set.
_FILE_OPTIONS = "file_options"


def add_options(command: argparse.ArgumentParser, options: Sequence[argparse.Action]) -> None:
    """Add ``--config`` and ``--write-config`` to a command, for some of its options."""
    command.add_argument("--config", metavar="FILE", help="read options from a file that --write-config wrote")
    help = "write a file of all options with their meaning, to edit, and end"
    command.add_argument("--write-config", metavar="FILE", action=_Write, default=options, help=help)
    command.set_defaults(**{_FILE_OPTIONS: options})


class _Write(argparse.Action):
    """Write the file of options, and end."""

    def __call__(self, parser, namespace, values, option_string=None):
        path = Path(values)
        if path.exists():
            parser.error(f"{path}: expected the name of a new file, found an existing one")
        path.write_text(file_text(self.default), encoding="utf-8")
        print(f"written to {path}; edit it, then: {parser.prog} SCAN --config {path}")
        parser.exit()


def file_text(options: Sequence[argparse.Action]) -> str:
    """Return a file of options, all of them commented out."""
    entries = []
    for option in options:
        default = option.default if option.default is not None else option.metavar or option.dest
        value = json.dumps(list(default) if isinstance(default, tuple) else default, ensure_ascii=False)
        entries.append(f"\n# {str(option.help) % vars(option)}\n# {option.dest} = {value}\n")
    return _HEADER + "".join(entries)


def repeating_command(options: argparse.Namespace, file: str, output: str | Path) -> str:
    """Return the command that repeats the run of one file, with the options of a ``--config`` file written out."""
    words = ["roughxr", "run", file]
    for option in getattr(options, _FILE_OPTIONS):
        value = getattr(options, option.dest)
        if value == option.default:
            continue
        words.append(option.option_strings[0])
        if value is not True:
            values = value if isinstance(value, list) else [value]
            words += [str(single) for part in values for single in (part if isinstance(part, tuple) else [part])]
    return shlex.join([*words, "-o", str(output)])


def with_file(words: Any, parser: argparse.ArgumentParser) -> Any:
    """Return the words of a command line with those of its ``--config`` file before them."""
    options = parser.get_default(_FILE_OPTIONS)
    if options is None or words is None:
        return words
    only_config = argparse.ArgumentParser(add_help=False)
    only_config.add_argument("--config")
    path = only_config.parse_known_args(words)[0].config
    return words if path is None else [*words, *_file_words(Path(path), options, parser, words)]


def _file_words(path: Path, options: Sequence[argparse.Action], parser: argparse.ArgumentParser, words) -> list[str]:
    """Return the options of a file, as words of a command line, that this command line does not have."""
    flags = {option.dest: option.option_strings for option in options}
    try:
        entries = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        parser.error(f"{path}: {str(error.strerror).lower()}")
    except ValueError as error:
        parser.error(f'{path}: expected lines such as sphere_radius = "3 um", found: {error}')
    stated = tuple(word.partition("=")[0] for word in words if word.startswith("--") and word != "--")
    added: list[str] = []
    for name, value in entries.items():
        dest = name.replace("-", "_")
        if dest not in flags:
            parser.error(f"{path}: {name}: no option of a file{did_you_mean(dest, flags)}")
        is_stated = any(flag.startswith(stated) for flag in flags[dest])  # also shortened, as --humid
        if value is False or is_stated:
            continue
        values = [] if value is True else value if isinstance(value, list) else [value]
        added += [flags[dest][0], *map(str, values)]
    return added
