"""Text: control characters, suggestions for misspelt words, arguments that it names, and warnings."""

from __future__ import annotations

import sys
import unicodedata
import warnings
from collections.abc import Callable, Iterable
from itertools import chain
from typing import Any, NamedTuple, Self

#: Categories of characters that move the cursor, colour or hide what is printed, or turn its direction.
_CONTROL_CATEGORIES = {"Cc", "Cf", "Cs", "Co", "Zl", "Zp"}


def printable(text: str, *, keep: str = "") -> str:
    r"""Return text with control characters escaped, except those in ``keep``."""
    if text.isascii() and text.isprintable():
        return text
    hidden = {
        character for character in set(text) - set(keep) if unicodedata.category(character) in _CONTROL_CATEGORIES
    }
    return text.translate({ord(character): character.encode("unicode_escape").decode("ascii") for character in hidden})


def did_you_mean(value: Any, allowed: Iterable[Any]) -> str:
    """Return a question that suggests the most similar of some words, empty where none is similar."""
    from difflib import get_close_matches

    near = get_close_matches(str(value).lower(), [str(name) for name in allowed], n=1)
    return f" (did you mean {near[0]}?)" if near else ""


class Argument(NamedTuple):
    """An argument that a text names: bare, with a value, or with ``...`` for any value."""

    name: str
    value: Any = None

    def __str__(self) -> str:
        if self.value is None:
            return self.name
        return f"{self.name}=" if self.value is ... else f"{self.name}={self.value!r}"


class Phrase(str):
    """Text that names arguments as Python does; its parts let a door name them in its own way."""

    parts: tuple[Any, ...]

    def __new__(cls, *parts: object) -> Self:
        """Return the text of parts, which are texts, phrases and arguments."""
        phrase = super().__new__(cls, "".join(map(str, parts)))
        nested = (part.parts if isinstance(part, Phrase) else (part,) for part in parts)
        phrase.parts = tuple(chain.from_iterable(nested))
        return phrase


class RoughxrWarning(UserWarning):
    """What a user should know of a file or a result; all warnings of the package are of this class.

    Examples
    --------
    >>> import warnings
    >>> import roughxr
    >>> warnings.simplefilter("error", roughxr.RoughxrWarning)  # stop instead of warning
    """


class IncompleteResult(RoughxrWarning):
    """A result without some of its places or samples, or without the surface beyond an edge.

    Examples
    --------
    >>> import warnings
    >>> import roughxr
    >>> warnings.simplefilter("error", roughxr.IncompleteResult)  # stop instead of warning
    """


def warn(words: str, category: type[Warning] = RoughxrWarning, *, what: str = "") -> None:
    """Warn, of an argument if one is named, at the line of the user's code that called the package."""
    if what:
        words = Phrase(Argument(what), ": ", words)
    frame = sys._getframe().f_back
    depth = 2
    above = 2
    while frame:  # xarray calls the package, too, to open a file
        if str(frame.f_globals.get("__name__")).partition(".")[0] in (__package__.partition(".")[0], "xarray"):
            above = depth + 1
        frame = frame.f_back
        depth = depth + 1
    warnings.warn(words, category, stacklevel=above)


def without_warnings(solve: Callable, *arguments: Any, **options: Any) -> Any:
    """Return the result of a function without its warnings to the user."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return solve(*arguments, **options)
