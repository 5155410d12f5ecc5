"""Conversion of command-line arguments to numbers and quantities, and printing of errors and warnings."""

from __future__ import annotations

import copy
import glob
import os
import shlex
import sys
from argparse import ArgumentTypeError, Namespace
from collections.abc import Mapping
from typing import Any, TextIO

from ...mechanics.vocabulary.refusal import FailedSubregions, Refusal
from ...mechanics.vocabulary.text import Argument, Phrase, printable

#: Errors of invalid input, of the operating system, of missing packages and of places that failed; others are bugs.
EXPECTED_ERRORS = (Refusal, OSError, ImportError, FailedSubregions)

#: Control characters that may be printed.
_LINES = "\n\t"


class Printable:
    """A stream that escapes control characters, so that text of a file cannot control the terminal."""

    def __init__(self, stream: TextIO):
        self.stream = stream

    def write(self, text: str) -> int:
        """Write text with its control characters escaped."""
        return self.stream.write(printable(text, keep=_LINES))

    def __getattr__(self, name: str):
        return getattr(self.stream, name)


def error_text(error: BaseException) -> str:
    """Return an error's text; the operating system's errors begin with the file's name."""
    name = getattr(error, "filename", None)
    return str(error) if name is None else f"{name}: {error_reason(error)}"


def error_reason(error: BaseException) -> str:
    """Return an error's text without the file's name."""
    if isinstance(error, Refusal):
        return error.reason
    if isinstance(error, OSError) and error.errno is not None:
        return str(error.strerror).lower()
    return str(error)


#: Attributes of the parsed command line other than options.
_NO_OPTIONS = {"command", "line", "debug", "scan", "run", "file"}


#: Options that name one file, or several, to read.
FILES = ("scan", "file", "run", "finer", "indenter")

#: Options that name files which a command reads, and files which it writes.
_INPUTS = (*FILES, "config")
_OUTPUTS = ("output", "parameters", "picture", "dem")


def refuse_inputs_as_outputs(options: Namespace) -> None:
    """Raise if a command would write to a file that it reads, under whatever name."""
    values = {name: getattr(options, name, None) or [] for name in (*_INPUTS, *_OUTPUTS)}
    values["dem"] = [file for _, file in values["dem"]]
    files = {name: [value] if isinstance(value, str) else value for name, value in values.items()}
    read = [file for name in _INPUTS for file in files[name] if os.path.isfile(file)]
    for name in _OUTPUTS:
        for file in filter(os.path.isfile, files[name]):
            if any(os.path.samefile(file, other) for other in read):
                raise Refusal(name, "another file than those that are read", file)


def expand_wildcards(options: Namespace) -> None:
    """Replace quoted wildcards of files, which no shell has expanded; raise for one that fits no file."""
    for name in FILES:
        value = getattr(options, name, None)
        if value is None:
            continue
        files: list[str] = []
        for file in value if isinstance(value, list) else [value]:
            is_file = os.path.exists(file) or not glob.has_magic(file)
            matches = [file] if is_file else sorted(glob.glob(file))
            if not matches:
                raise Refusal(name, "files that fit the wildcards", f"none by {file}")
            files += matches
        if isinstance(value, list):
            setattr(options, name, files)
        elif len(files) > 1:
            raise Refusal(name, "one file", f"{len(files)} by {value}: {', '.join(files[:4])}", "name one of them")
        else:
            setattr(options, name, files[0])


def error_in_shell(error: BaseException, options: Namespace) -> str:
    """Return an error's text with arguments written as options: what was expected and what to do, never what was found.

    The operating system's errors name files alone.
    """
    if isinstance(error, OSError):
        return error_text(error)
    if not isinstance(error, Refusal):
        return in_shell(str(error), options)
    flags = _flags(options)
    worded = copy.copy(error)
    worded.expected, worded.advice = (in_shell(words, options) for words in (error.expected, error.advice))
    if isinstance(error.what, str):  # a path is no name of an argument
        worded.what = flags.get(error.what, in_shell(error.what, options))
    worded.where = tuple(flags.get(name, name) for name in error.where)
    return str(worded)


def _flags(options: Namespace) -> dict[str, str]:
    """Return the options of a command by the names of functions' arguments."""
    flags = {name: "--" + name.replace("_", "-") for name in set(vars(options)) - _NO_OPTIONS}
    for option, argument in (("fill", "method"), ("dem", "code"), ("remove", "share")):
        if option in flags:
            flags.setdefault(argument, f"--{option}")
    return flags


def in_shell(text: Any, options: Namespace) -> Any:
    """Return an error's or a warning's text with the arguments that it names written as options of a command."""
    if not isinstance(text, Phrase):
        return text
    flags = _flags(options)
    return "".join(_option(part, flags) if isinstance(part, Argument) else part for part in text.parts)


def _option(argument: Argument, flags: Mapping[str, str]) -> str:
    """Return an argument as an option of the command, as in Python where the command has none."""
    if argument.name not in flags:
        return str(argument)
    values = argument.value if isinstance(argument.value, tuple) else (argument.value,)
    return shlex.join([flags[argument.name], *(str(value) for value in values if value not in (None, ...))])


def print_error(message: object, printed: set[str] | None = None) -> None:
    """Print an error's or a warning's text without its location in the code, unless the set ``printed`` has it."""
    if printed is None or str(message) not in printed:
        print(f"roughxr: {printable(str(message), keep=_LINES)}", file=sys.stderr)
    if printed is not None:
        printed.add(str(message))


def number(text: str) -> float | str:
    """Return text as a number where it is one, else unchanged, as a quantity with units."""
    try:
        return float(text)
    except ValueError:
        return text


def share(text: str) -> float:
    """Return a number that may be stated in per cent, as an option of `argparse`."""
    try:
        return float(text.removesuffix("%")) / 100 if text.endswith("%") else float(text)
    except ValueError as error:
        expected = "a number without a unit, or per cent as 90%"
        raise ArgumentTypeError(f"expected {expected}, found {text!r}") from error


def numbers(value: Any) -> Any:
    """Return text as a number or quantity, a list of texts as a tuple of them, and other values unchanged."""
    if isinstance(value, list):
        return numbers(value[0]) if len(value) == 1 else tuple(map(number, value))
    return number(value) if isinstance(value, str) else value
