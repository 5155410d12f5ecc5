"""`Channel`, one image of a file as every reader returns it, and the choice among several."""

from __future__ import annotations

import importlib
import importlib.util
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, NoReturn, TypeVar

import numpy as np

from ...mechanics.scans.plausibility import missing_mark
from ...mechanics.vocabulary.refusal import Refusal, shown
from ...mechanics.vocabulary.schema import SMALLEST_LENGTH, one_of
from ...mechanics.vocabulary.text import Argument, Phrase, printable
from ...mechanics.vocabulary.units import converts, factor, is_whole
from . import reader_process

#: Names of images in lengths that are not heights of the surface: of the lever, or derived from a force curve.
_NO_HEIGHT = re.compile(
    "ampl|defl|error|phase|fric|lateral|deform|indent|background|contact|adhes|dissip|stiff|modul|snap|separation|"
    "slope|mask",
    re.IGNORECASE,
)

#: What a file has several of: images, variables, columns.
_Item = TypeVar("_Item")

#: Names of images of heights.
_HEIGHT = re.compile(r"height|topo|z[ _-]*(sensor|axis|range|scan|piezo)|^z$|\bz\b", re.IGNORECASE)


class UnreadableScan(Refusal):
    """A file that is not a scan, or is damaged, in the fields of `Refusal`.

    ``what`` and ``path`` are the file, ``where`` are its format and the line, column, member or option concerned.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import roughxr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "scan.spm"
    ...     _ = path.write_bytes(b"not a scan")
    ...     try:
    ...         roughxr.open_scan(path)
    ...     except roughxr.scans.UnreadableScan as refusal:
    ...         print(refusal.expected)
    an AFM image
    """

    def __init__(self, path: Any, *fields: object, where: tuple[str, ...] = ()):
        super().__init__(path, *fields)  # type: ignore[arg-type]
        self.path = path
        self.where = where

    def __str__(self) -> str:
        return printable(super().__str__())

    @classmethod
    def of(cls, path: Any, refusal: Refusal) -> UnreadableScan:
        """Return the refusal of what was read from a file as one of the file."""
        where = (str(refusal.what), *refusal.where) if str(refusal.what) else refusal.where
        return cls(path, refusal.expected, refusal.found, refusal.advice, where=where)


class Channel(NamedTuple):
    """One image of a file with the file's own statements, not yet labelled.

    ``read`` returns the values as (rows, columns) in ``units``, the top row of the picture first, NaN where
    the file has no value. ``size`` is the lateral size (along x, along y) in ``lateral_units``. Missing statements are
    None. ``counted`` is False if the file does not state its number of pixels.
    """

    name: str
    units: str | None
    shape: tuple[int, int]
    size: tuple[float, float] | None
    lateral_units: str | None
    read: Callable[[], np.ndarray]
    direction: str = ""
    header: Mapping[str, Any] = {}
    counted: bool = True

    @property
    def is_length(self) -> bool:
        """Whether the values are lengths."""
        return is_length(self.units)

    @property
    def is_topography(self) -> bool:
        """Whether the values are heights of the surface: not an amplitude or a deformation in nm."""
        return self.is_length and not _NO_HEIGHT.search(self.name)


def is_length(units: str | None) -> bool:
    """Return whether ``units`` convert to nm."""
    return bool(units) and str(units).isalpha() and converts(str(units), "nm")  # not "10 nm", which is no unit


def stated_direction(name: str) -> str:
    """Return "trace" or "retrace" if a channel's name states it, else ""."""
    if re.search(r"retrace|backward|\bbwd\b", name, re.IGNORECASE):
        return "retrace"
    return "trace" if re.search(r"trace|forward|\bfwd\b", name, re.IGNORECASE) else ""


def optional(module: str) -> ModuleType:
    """Return a module of the ``afm`` extra; raise with advice if it is not installed."""
    try:
        with warnings.catch_warnings(action="ignore"):  # a notice that MPI is missing
            return importlib.import_module(module)
    except ImportError as error:
        raise _not_installed(module.partition(".")[0], error) from error


def _not_installed(package: str, reason: Any, extra: str = "afm") -> ImportError:
    return ImportError(
        f"this file needs {package}, found {reason}; install it with: "
        f'pip install {package}, or in a clone of roughxr, with all similar packages: pip install ".[{extra}]"'
    )


def read_in_process(
    path: Path, reader: ModuleType, package: str, *, extra: str = "afm", **options: Any
) -> dict[str, Any]:
    """Read a file with ``reader`` in a separate process; raise if its package is missing."""
    if importlib.util.find_spec(package) is None:
        raise _not_installed(package, "none", extra)
    try:
        return reader_process.answer(path, str(reader.__file__), **options)
    except reader_process.ReadingFailed as failure:
        raise UnreadableScan(path, *failure.args) from None


def file_name(path: Path) -> str:
    """Return the name of a file for attributes and messages, which hold UTF-8 alone."""
    return printable(path.name)


def first_bytes(path: Path, count: int) -> bytes:
    """Return the first ``count`` bytes of a file."""
    with path.open("rb") as file:
        return file.read(count)


#: First bytes of Igor's waves of version 5.
IGOR = (b"\x05\0", b"\0\x05")


def is_igor(head: bytes) -> bool:
    """Return whether bytes begin an Igor wave of version 5: 384 header bytes whose 16-bit sum is zero."""
    if len(head) < 384 or head[:2] not in IGOR:
        return False
    order = "<i2" if head[0] else ">i2"
    return int(np.frombuffer(head[:384], order).sum(dtype=np.int64)) & 0xFFFF == 0


def refuse_other_size(path: Path, stated: int, size: int | None = None, *, may_be_longer: bool = False) -> None:
    """Raise unless a file, or its data, have as many bytes as the file states; more bytes would shift the heights."""
    size = path.stat().st_size if size is None else size
    if size == stated or (size > stated and may_be_longer):
        return
    fault = "cut short" if size < stated else "damaged"
    raise UnreadableScan(path, f"{stated:,} bytes, as its header states", f"{size:,}: {fault}", COPY_AGAIN)


def only_one(path: Path, fitting: Sequence[_Item], wanted: str, listed: str, advice: str) -> _Item:
    """Return the only image, variable or column that fits; raise with a list of all if there are none or several."""
    if len(fitting) != 1:
        raise UnreadableScan(path, wanted, f"{len(fitting) or 'none'} among {listed}", advice)
    return fitting[0]


def refuse_stated(path: Path, option: str, given: object, stated: str = "", *, otherwise: str = "") -> NoReturn:
    """Raise for an option whose value the file states."""
    expected = f"{stated}, as the file states" if stated else "none: the file states it"
    advice = Phrase("leave ", Argument(option, ...), f" out{otherwise}")
    raise UnreadableScan(path, expected, shown(given), advice, where=(option,))


@contextmanager
def naming_file(path: Path) -> Iterator[None]:
    """Name a file in what is refused of its content."""
    try:
        yield
    except UnreadableScan:
        raise
    except Refusal as refusal:
        raise UnreadableScan.of(path, refusal) from refusal


#: Advice for a file of which a part is missing.
COPY_AGAIN = "copy the whole file again from where it was recorded"

#: Advice for a file without units.
_STATE_UNITS = Phrase("if these are heights, state their units, ", Argument("height_units", ...))


def choose(channels: list[Channel], channel: str | int | None, direction: str | None, path: Path) -> Channel:
    """Return the channel with this name or number and direction; by default the first image of heights."""
    fitting = channels_in_direction(channels_named(channels, channel), direction)
    advice = _STATE_UNITS
    if any(image.units for image in channels):
        advice = Phrase("choose one by name or number, ", Argument("channel", ...))
    wanted = "an image of heights" if channel is None else f"channel {channel!r}"
    if direction:
        wanted = Phrase(wanted, " with ", Argument("scan_direction"), f" {direction!r}")
    first = only_one(path, fitting if isinstance(channel, str) else fitting[:1], wanted, listing(channels), advice)
    if not first.is_length:
        fault = f"{first.name!r} in units of {first.units or 'nothing'}"
        advice = _STATE_UNITS
        if first.units:
            advice = Phrase("choose one, ", Argument("channel", ...), f", of {listing(channels)}")
        raise UnreadableScan(path, "a channel of heights", fault, advice)
    return first


def tied_images(channels: list[Channel], chosen: Channel, direction: str | None) -> list[Channel]:
    """Return the images of heights between which a file leaves the choice; none if one is to be preferred.

    A sensor's image is preferred to the piezo voltage of the same movement, without a warning. Two images of one name
    are trace and retrace.
    """
    fitting = channels_in_direction(channels_named(channels, None), direction)
    tied = [image for image in fitting if _is_sensor(image) == _is_sensor(chosen)]
    is_tied = len(tied) > 2 or len({_stem(image.name) for image in tied}) == 2
    return tied if is_tied else []


def _is_sensor(channel: Channel) -> bool:
    return bool(re.search("sensor|measured", channel.name, re.IGNORECASE))


def channels_named(channels: list[Channel], channel: str | int | None) -> list[Channel]:
    """Return the channels with this name or number; without either, those named as heights, else all lengths."""
    if channel is None:
        surfaces = [image for image in channels if image.is_topography]
        return [image for image in surfaces if _HEIGHT.search(image.name)] or surfaces
    if isinstance(channel, str):
        exact = [image for image in channels if image.name in (channel, channel.lstrip("/"))]
        return exact or [image for image in channels if _stem(image.name) == _stem(channel)]
    if not is_whole(channel):
        raise Refusal("channel", "a name or a whole number", shown(channel))
    return [channels[channel]] if 0 <= channel < len(channels) else []


def channels_in_direction(channels: list[Channel], direction: str | None) -> list[Channel]:
    """Return the channels in this direction; by default all that are not retrace, or all."""
    if direction is None:
        return [image for image in channels if image.direction != "retrace"] or channels
    one_of(direction, ("trace", "retrace"), "scan_direction")
    return [image for image in channels if image.direction == direction]


def _stem(name: str) -> str:
    """Return a channel's name without direction and capitals: "HeightRetrace" becomes "height"."""
    return re.sub(r"[ _-]*\(?(retrace|trace|forward|backward|\bfwd\b|\bbwd\b)\)?[ _-]*", "", name.lower())


def listing(channels: list[Channel], listed: Sequence[Channel] | None = None) -> str:
    """Return channels as one line: number, name, direction, units; of very many the first ones, as of a movie."""
    numbers = range(len(channels)) if listed is None else map(channels.index, listed)
    lines = []
    for number in numbers:
        image = channels[number]
        line = f"{number}: {image.name!r} {image.direction} [{image.units or '?'}]"
        lines.append(" ".join(line.split()))
    # most images in a list
    most_listed = 32
    more = len(lines) - most_listed
    return printable(", ".join(lines if more <= 0 else [*lines[:most_listed], f"… and {more} more"]))


def refuse_absurd(height: np.ndarray, width: float, path: Any) -> None:
    """Raise UnreadableScan if heights are infinite, include a missing-pixel mark, or have an impossible range.

    A range over a thousand widths, or a thousandth of a nanometre, is impossible; heights may all be equal.
    """
    low, high = (np.nanmin(height), np.nanmax(height)) if np.isfinite(height).any() else (0.0, 0.0)
    refuse_small(path, "heights over", high - low or np.inf)
    expected = f"heights that suit a scan {width:g} nm wide"
    if mark := missing_mark(height, width) if high - low > width else []:
        raise UnreadableScan(path, expected, str(mark[0]))
    # largest range of heights, in scan sizes; beyond, the file is damaged
    if np.isinf(height).any() or high - low > 1e3 * width:
        raise UnreadableScan(path, expected, f"{low:g} to {high:g} nm: damaged")


def refuse_small(path: Any, what: str, length: float) -> None:
    """Raise for heights or pixels (nm) that are smaller than atoms."""
    if length < SMALLEST_LENGTH:
        raise UnreadableScan(path, f"{what} at least {SMALLEST_LENGTH:g} nm", f"{length:.3g} nm: wrong units?")


def length_factor(path: Path, units: Any, what: str, advice: str = "", *, where: tuple[str, ...] = ()) -> float:
    """Return nm per unit of what a file states; raise unless its units are those of a length."""
    if not is_length(units):
        raise UnreadableScan(path, what, repr(units) if units else "none", advice, where=where)
    return factor(str(units), "nm")
