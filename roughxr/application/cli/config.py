"""Options of a command in a file: ``--write-config FILE`` writes it with comments, ``--config FILE`` reads it.

A file is TOML, one option a line: ``sphere_radius = "3 um"``. It may come from a stranger, so that it sets neither the
scheduler, which runs code, nor a file that is written, and its values are never read as words of a command line.
"""

from __future__ import annotations

import argparse
import json
import shlex
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...mechanics.vocabulary.text import did_you_mean

_HEADER = """\
# Options of `roughxr run` for --config. Remove the # before an option to set it.
# An option on the command line replaces that of this file.
"""

#: Name under which a parser keeps the options that a file may set.
_FILE_OPTIONS = "file_options"

#: Largest size of a file, bytes: hundreds of times that of all options with their help.
_LARGEST = 2**20


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
        if str(value).startswith("-"):
            words[-1] += f"={value}"
        elif value is not True:
            values = value if isinstance(value, list) else [value]
            words += [str(single) for part in values for single in (part if isinstance(part, tuple) else [part])]
    return shlex.join([*words, "-o", str(output)])


def namespace_of_file(words: Sequence[str], parser: argparse.ArgumentParser) -> argparse.Namespace | None:
    """Return the options of the ``--config`` file of a command line, which argparse then takes as its defaults."""
    options = parser.get_default(_FILE_OPTIONS)
    if options is None:
        return None
    only_config = argparse.ArgumentParser(add_help=False)
    only_config.add_argument("--config")
    path = only_config.parse_known_args(words)[0].config
    if path is None:
        return None
    by_name = {option.dest: option for option in options}
    values = {}
    for name, value in _entries(Path(path), parser).items():
        option = by_name.get(name.replace("-", "_"))
        if option is None:
            parser.error(f"{path}: {name}: no option of a file{did_you_mean(name.replace('-', '_'), by_name)}")
        try:
            values[option.dest] = _value(option, value)
        except (argparse.ArgumentTypeError, ValueError) as error:
            parser.error(f"{path}: {name}: {error}")
    for group in parser._mutually_exclusive_groups:
        group.required = group.required and not any(option.dest in values for option in group._group_actions)
    return argparse.Namespace(**values)


def _entries(path: Path, parser: argparse.ArgumentParser) -> dict[str, Any]:
    """Return the entries of a file of options."""
    try:
        if path.exists() and not path.is_file():
            parser.error(f"{path}: expected a file, found a folder, pipe or device")
        with path.open("rb") as file:
            text = file.read(_LARGEST + 1)
        if len(text) > _LARGEST:
            parser.error(f"{path}: expected a file of options of at most {_LARGEST >> 10} KiB, found a larger one")
        return tomllib.loads(text.decode())
    except OSError as error:
        parser.error(f"{path}: {str(error.strerror).lower()}")
    except (ValueError, RecursionError) as error:
        parser.error(f'{path}: expected lines such as sphere_radius = "3 um", found: {error}')


def _value(option: argparse.Action, value: Any) -> Any:
    """Return the value of an option in a file, as argparse returns that of a command line."""
    if option.nargs == 0:
        if not isinstance(value, bool):
            raise argparse.ArgumentTypeError(f"expected true or false, found {value!r}")
        return value
    if option.nargs is None:
        return _single_value(option, value)
    values = value if isinstance(value, list) else [value]
    if not values:
        raise argparse.ArgumentTypeError("expected at least one value, found none")
    return [_single_value(option, single) for single in values]


def _single_value(option: argparse.Action, value: Any) -> Any:
    """Return one value of an option in a file."""
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        kind = "several values" if isinstance(value, list) else f"{value!r}"
        raise argparse.ArgumentTypeError(f"expected text or a number, found {kind}")
    converted = option.type(str(value)) if callable(option.type) else str(value)
    if option.choices and converted not in option.choices:
        raise argparse.ArgumentTypeError(f"expected one of {', '.join(option.choices)}, found {value!r}")
    return converted
