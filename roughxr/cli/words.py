"""The shell's arguments as numbers and quantities, and errors and warnings as text for the shell."""

from __future__ import annotations

import linecache
import re
import sys
import traceback
from argparse import Namespace
from pathlib import Path
from typing import Any, TextIO

from ..vocabulary.text import printable

#: Kinds of errors with which roughxr refuses its input.
REFUSALS = (ValueError, TypeError, OSError, ImportError, RuntimeError)

_PACKAGE = Path(__file__).parents[1]

#: Control characters that may be printed.
_LINES = "\n\t"


class Printable:
    """A stream for others' text: nothing in it moves the terminal's cursor or changes its colours."""

    def __init__(self, stream: TextIO):
        self.stream = stream

    def write(self, text: str) -> int:
        """Write text with its control characters written out."""
        return self.stream.write(printable(text, keep=_LINES))

    def __getattr__(self, name: str):
        return getattr(self.stream, name)


def is_refusal(error: BaseException) -> bool:
    """Return whether an error is the system's or raised by roughxr itself; any other is a bug or a library's."""
    if isinstance(error, OSError) and error.errno is not None:
        return True
    frames = traceback.extract_tb(error.__traceback__)
    if not isinstance(error, REFUSALS) or not frames or _PACKAGE not in Path(frames[-1].filename).parents:
        return False
    return linecache.getline(frames[-1].filename, frames[-1].lineno or 0).strip().startswith("raise")


def in_words(error: BaseException) -> str:
    """Return an error's text; of the system's own errors the file's name first."""
    name = getattr(error, "filename", None)
    if not isinstance(error, OSError) or error.errno is None or name is None:
        return str(error)
    return f"{name}: {str(error.strerror).lower()}"


#: Attributes of the parsed command line that are no options.
_NO_OPTIONS = {"command", "line", "debug", "scan", "run", "file"}


def in_shell(text: str, options: Namespace) -> str:
    """Return an error's or a warning's text with arguments of functions written as the options of a command."""
    flags = {name: "--" + name.replace("_", "-") for name in set(vars(options)) - _NO_OPTIONS}
    if "fill" in flags:
        flags.setdefault("method", "--fill")
    any_name = "|".join(sorted(flags, key=len, reverse=True))

    def written(match: re.Match[str]) -> str:
        values = re.sub(r"['\"]([^'\" ]+)['\"]", r"\1", (match[2] or "").strip("()…")).replace(",", "")
        return f"{flags[match[1]]} {values}".strip()

    text = re.sub(rf"\b({any_name})=(\([^()]*\)|'[^']*'|[^\s,;():]*)", written, text)
    text = re.sub(rf"(^|: )({any_name}): ", lambda match: f"{match[1]}{flags[match[2]]}: ", text)
    longer = "|".join(name for name in flags if "_" in name)
    return re.sub(rf"(?<![-\w./])({longer})\b", lambda match: flags[match[1]], text) if longer else text


def tell(message: object, printed: set[str] | None = None) -> None:
    """Print an error's or a warning's text without its place in the code, once for a set ``printed``."""
    if printed is None or str(message) not in printed:
        print(f"roughxr: {printable(str(message), keep=_LINES)}", file=sys.stderr)
    if printed is not None:
        printed.add(str(message))


def number(text: str) -> float | str:
    """Return plain numbers as numbers; anything else is a quantity with its own units."""
    try:
        return float(text)
    except ValueError:
        return text


def numbers(value: Any) -> Any:
    """Return the value of a word or of several: a number, a quantity, or a pair of them; others as they are."""
    if isinstance(value, list):
        return numbers(value[0]) if len(value) == 1 else tuple(map(number, value))
    return number(value) if isinstance(value, str) else value
