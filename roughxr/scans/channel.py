"""One image of a file, in the form that every reader returns, and the choice among several."""

from __future__ import annotations

import importlib.util
import re
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from ..vocabulary.text import printable
from ..vocabulary.units import factor
from . import reader_process


class UnreadableScan(ValueError):
    """A file that is no scan, or a damaged one: the message names the file, the reason and what to do."""

    def __init__(self, path: Any, reason: str):
        super().__init__(printable(f"{path}: {reason}"))


class Channel(NamedTuple):
    """One image of a file, before any label: what the file says, and nothing else.

    ``read`` returns the values as (rows, columns) in ``units``, the top row of the picture first, NaN where
    the file has no value. ``size`` is the lateral size (along x, along y) in ``lateral_units``. What the
    file does not state is None. ``counted`` is False where the file does not state its number of pixels; ``doubt``
    tells where its header and its length contradict each other.
    """

    name: str
    units: str | None
    shape: tuple[int, int]
    size: tuple[float, float] | None
    lateral_units: str | None
    read: Callable[[], np.ndarray]
    direction: str = ""
    header: Mapping[str, Any] = {}
    remark: str = ""
    counted: bool = True
    doubt: str = ""

    @property
    def is_length(self) -> bool:
        """Whether the values are lengths."""
        return is_length(self.units)

    @property
    def is_topography(self) -> bool:
        """Whether the values are lengths of the surface, and not of the lever: an amplitude in nm is no height."""
        lever = re.search("ampl|defl|error|phase|fric|lateral", self.name, re.IGNORECASE)
        return self.is_length and not lever


def is_length(units: str | None) -> bool:
    """Return whether ``units`` convert to nm."""
    if not units or not str(units).isalpha():
        return False  # one word: "~m" or "10 nm" would convert to something, but not to what was meant
    try:
        return factor(str(units), "nm") > 0
    except ValueError:
        return False


def direction_in(name: str) -> str:
    """Return "trace" or "retrace" where a channel's name says so, else ""."""
    if re.search("retrace|backward", name, re.IGNORECASE):
        return "retrace"
    return "trace" if re.search("trace|forward", name, re.IGNORECASE) else ""


def optional(module: str) -> ModuleType:
    """Return a module of the ``afm`` extra; raise with advice where it is not installed."""
    try:
        with warnings.catch_warnings(action="ignore"):  # that it runs without MPI is no news to anyone here
            return importlib.import_module(module)
    except ImportError as error:
        raise not_installed(module.partition(".")[0], error) from error


def not_installed(package: str, found: Any, extra: str = "afm") -> ImportError:
    """Return the error that says how to install an extra."""
    return ImportError(
        f"this file needs {package}, found {found}; install it with: "
        f'pip install {package}, or in a clone of roughxr, with all similar packages: pip install ".[{extra}]"'
    )


def asked(path: Path, reader: ModuleType, package: str, *, extra: str = "afm", **question: Any) -> dict[str, Any]:
    """Return what a reader says of a file, in a process that can be ended; raise where its package is missing."""
    if importlib.util.find_spec(package) is None:
        raise not_installed(package, "none", extra)
    try:
        return reader_process.ask(path, str(reader.__file__), **question)
    except reader_process.ReadingFailed as failure:
        raise UnreadableScan(path, str(failure)) from None
    except ImportError as error:
        raise not_installed(package, error, extra) from error


def first_bytes(path: Path, count: int) -> bytes:
    """Return the first bytes of a file, at most so many."""
    with path.open("rb") as file:
        return file.read(count)


#: What to do where a file states no units.
_STATE_UNITS = "if it holds heights, state their units with height_units="


def choose(channels: list[Channel], channel: str | int | None, direction: str | None, path: Path) -> Channel:
    """Return the channel asked for by name or place, and by direction; by default the first topography."""
    if direction not in (None, "trace", "retrace"):
        raise ValueError(f"direction: expected 'trace' or 'retrace', found {direction!r}")
    fitting = along(named(channels, channel), direction)
    if not fitting or (isinstance(channel, str) and len(fitting) > 1):
        found = "several" if fitting else "none"
        advice = "choose one with channel=, by name or number" if any(one.units for one in channels) else _STATE_UNITS
        wanted = "a topography" if channel is None else f"channel {channel!r}"
        wanted += f" with direction {direction!r}" if direction else ""
        raise UnreadableScan(path, f"expected {wanted}, found {found} among {listing(channels)}; {advice}")
    first = fitting[0]
    if not first.is_length:
        advice = f"choose one with channel=: {listing(channels)}" if first.units else _STATE_UNITS
        found = f"{first.name!r} in units of {first.units or 'nothing'}"
        raise UnreadableScan(path, f"expected a channel of heights, found {found}; {advice}")
    return first


def named(channels: list[Channel], channel: str | int | None) -> list[Channel]:
    """Return the channels of a name, or the one of a number; without either the topographies."""
    if channel is None:
        return [one for one in channels if one.is_topography]
    if isinstance(channel, str):
        exact = [one for one in channels if one.name == channel]
        return exact or [one for one in channels if _stem(one.name) == _stem(channel)]
    return [channels[channel]] if 0 <= int(channel) < len(channels) else []


def along(channels: list[Channel], direction: str | None) -> list[Channel]:
    """Return the channels of a direction; by default the forward one of a pair of equal name."""
    if direction is None:
        return [one for one in channels if one.direction != "retrace"] or channels
    return [one for one in channels if one.direction == direction]


def _stem(name: str) -> str:
    """Return a channel's name without its direction and its capitals: HeightRetrace is Height too."""
    return re.sub("[ _-]*(retrace|trace|forward|backward)[ _-]*", "", name.lower())


def listing(channels: list[Channel]) -> str:
    """Return the channels as one line: number, name, direction, units."""
    words = (f"{i}: {one.name!r} {one.direction} [{one.units or '?'}]" for i, one in enumerate(channels))
    return printable(", ".join(" ".join(word.split()) for word in words))
