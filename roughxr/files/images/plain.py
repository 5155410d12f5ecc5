"""Plain numbers: text and ``.npy`` arrays, first row at the top; the caller gives missing sizes and units.

Text is a matrix, or three columns x, y, z of points on a grid. Most do not state their number of rows, so that a
truncated file looks complete. If its header states the size, pixels must therefore be square, unless the caller gives
the size as well.
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import numpy as np

from ...mechanics.vocabulary.text import warn
from ...mechanics.vocabulary.units import factor
from .channel import Channel, UnreadableScan, first_bytes, refuse_other_size, stated_direction
from .formats import refuse_not_read

NPY = b"\x93NUMPY"

#: First bytes of text in UTF-16.
_UTF16 = (b"\xff\xfe", b"\xfe\xff")

#: "Width: 10.00 µm", as Gwyddion writes it above the numbers; "h=18 w=24", several in a line; and their values.
_ENTRY = re.compile(r"^\s*([^:=]+):\s*(.*?)\s*$")
_ENTRIES = re.compile(r"([A-Za-z][\w-]*)\s*=\s*(.*?)\s*(?=[\s,;]+[A-Za-z][\w-]*\s*=|$)")
_LENGTH = re.compile(r"^([-+0-9.eE]+)\s*([^\s\d]\S*)$")

#: The lines that Gwyddion writes above the numbers, always in this order, in any of its languages; and a line.
_GWYDDION = ("channel", "width", "height", "value units")
_TRANSLATED = re.compile(r"^#\s*([^:：]+?)\s*[:：]\s*(.*?)\s*$")

#: Longest line of a header, characters: searching longer ones for entries would take hours.
_LONGEST_LINE = 1000

#: Bytes of a text in which its first number stands.
_HEADING_BYTES = 2**16

#: Advice for a text that is no image.
_READ_TABLE = "a table of pull-offs is read by `roughxr measured`"

#: Names of the sides in a header.
_SIDES = (("width", "w"), ("height", "h"))

#: A line of numbers, its first cells perhaps empty; and the heading of three columns of points.
_NUMBERS = re.compile(r"[\s,;]*[-+]?(\d|[.,]\d|(nan|inf)\b)", re.IGNORECASE)
_HEADING = re.compile(r"\W*x(?![a-z]).*\by(?![a-z]).*\b(z(?![a-z])|height|topography)", re.IGNORECASE)


def npy_channels(path: Path) -> list[Channel]:
    """Return the one image of a ``.npy`` file; its size and units must be given."""
    values = np.load(path, mmap_mode="r", allow_pickle=False)
    if values.ndim != 2 or values.dtype.kind not in "fiu":
        raise UnreadableScan(path, "a matrix of real numbers", f"shape {values.shape} of {values.dtype}")
    refuse_other_size(path, values.offset + values.nbytes)
    read = partial(np.array, values, dtype=float)
    return [Channel(path.stem, None, values.shape, None, None, read)]


def is_text(head: bytes) -> bool:
    """Return whether bytes look like text: no control characters."""
    head = decoded(head[: len(head) // 2 * 2]).encode() if head.startswith(_UTF16) else head
    return not re.search(rb"[\x00-\x08\x0e-\x1f]", head)


def has_digit(path: Path) -> bool:
    """Return whether there is a digit near the beginning of a text, after a heading however long."""
    return bool(re.search(rb"\d", first_bytes(path, _HEADING_BYTES)))


def text_without_numbers(path: Path) -> str:
    """Return the first line of a text without a digit near its beginning; nothing for any other file."""
    head = first_bytes(path, 512)
    if not is_text(head) or has_digit(path):
        return ""
    return decoded(head).strip().partition("\n")[0][:60]


def text_channels(path: Path) -> list[Channel]:
    """Return the one image of a text."""
    refuse_not_read(path)
    text = decoded(path.read_bytes())
    lines = [line for line in text.splitlines() if line.strip()]
    first = next((k for k, line in enumerate(lines) if _NUMBERS.match(line)), len(lines))
    header, heading = _header(path, lines[:first])
    numbers = _matrix(path, [line for line in lines[first:] if not line.lstrip().startswith("#")])
    if not text.endswith("\n"):
        warn(f"{path.name}: the last line has no line end; if the file was cut short, its last number is wrong")
    units = header.get("value units")
    (size, lateral_units) = _size(header)
    if numbers.shape[1] == 3 and numbers.shape[0] > 3:
        rows, extent = _on_grid(path, numbers)
        stated = re.findall(r"[\[(/_]\s*([^\])/\s,;]+)", heading)
        if len(stated) == 3 and stated[0] == stated[1]:
            size = extent
            lateral_units = stated[0]
            units = stated[2]
    else:
        rows = _counted(path, numbers, header)
    name = header.get("channel", path.stem)
    counted = rows is not numbers
    return [
        Channel(name, units, rows.shape, size, lateral_units, lambda: rows, stated_direction(name), header, counted)
    ]


def decoded(data: bytes) -> str:
    """Return the text of a file in UTF-8, UTF-16 (spreadsheets' "Unicode text") or Latin-1 (older programs)."""
    if data.startswith(_UTF16):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # older programs write the micro sign so


def _header(path: Path, lines: list[str]) -> tuple[dict[str, str], str]:
    """Return what the lines above the numbers state, its names in small letters, and the heading of points."""
    header = gwyddion_header(lines)
    heading = ""
    for line in lines:
        content = line.lstrip("# \t")
        if len(content) > _LONGEST_LINE:
            raise UnreadableScan(path, f"header lines of at most {_LONGEST_LINE} characters", f"{len(content)} in one")
        entry = _ENTRY.match(content)
        entries = [entry.groups()] if entry else _ENTRIES.findall(content)
        header = {name.strip().lower(): value for name, value in entries} | header
        if _HEADING.match(content):
            heading = content
        elif not entries and not line.lstrip().startswith("#"):
            raise UnreadableScan(path, "a matrix of numbers", f"{content[:60]!r}", _READ_TABLE)
    return header, heading


def is_gwyddion_text(head: bytes) -> bool:
    """Return whether the first bytes of a file are Gwyddion's lines above the numbers of an exported text."""
    return head.startswith(b"#") and bool(gwyddion_header(decoded(head).splitlines()))


def gwyddion_header(lines: list[str]) -> dict[str, str]:
    """Return what Gwyddion's lines above the numbers state, under their English names; empty if they are not there."""
    matches = [_TRANSLATED.match(line[:_LONGEST_LINE]) for line in lines[: len(_GWYDDION)]]
    values = [match[2] for match in matches if match]
    if any(match and match[1].lower() in ("width", "height") for match in matches[:1] + matches[3:]):
        return {}  # of another program, in another order
    if len(values) < len(_GWYDDION) or not all(_LENGTH.match(value.replace(",", ".")) for value in values[1:3]):
        return {}
    header = dict(zip(_GWYDDION, values))
    return header | {side: header[side].replace(",", ".") for side in ("width", "height")}


def _sides(header: dict[str, str]) -> list[str]:
    """Return what a header states of width and height."""
    return [next((header[name] for name in names if name in header), "") for names in _SIDES]


def _size(header: dict[str, str]) -> tuple[tuple[float, float] | None, str | None]:
    """Return the size of width and height, and their common units, where a header states them."""
    lengths = [match.groups() for match in map(_LENGTH.match, _sides(header)) if match]
    if len(lengths) < 2:
        return None, None
    (width, x_units), (height, y_units) = lengths
    if x_units != y_units:
        return (float(width), float(height) * factor(y_units, x_units)), x_units
    return (float(width), float(height)), x_units


def _counted(path: Path, numbers: np.ndarray, header: dict[str, str]) -> np.ndarray:
    """Return a matrix of as many columns and rows as its header states, the same matrix where it states none."""
    sides = _sides(header)
    if not all(map(str.isdecimal, sides)):
        return numbers
    columns, rows = map(int, sides)
    if numbers.shape != (rows, columns) and (1 not in numbers.shape or numbers.size != rows * columns):
        expected = f"{columns} columns and {rows} rows, as its header states"
        raise UnreadableScan(path, expected, f"{numbers.shape[1]} columns and {numbers.shape[0]} rows")
    return numbers.reshape(rows, columns)


def _matrix(path: Path, lines: list[str]) -> np.ndarray:
    if not lines:
        raise UnreadableScan(path, "a matrix of numbers", "no line of numbers")
    delimiter, decimal_comma = separators(lines[0])
    if decimal_comma:
        lines = [line.replace(",", ".") for line in lines]
    if re.match(r"\s*[\t,;]", lines[0]):  # the empty corner of a matrix with axes
        lines[0] = f"nan{lines[0].lstrip(' ')}"
    try:
        rows = np.loadtxt([line.rstrip(" \t" + (delimiter or "")) for line in lines], delimiter=delimiter, ndmin=2)
    except ValueError as error:
        raise UnreadableScan(path, "a matrix of numbers", f"another text: {error}", _READ_TABLE) from error
    if _has_axes(rows):
        fault = "coordinates in its first row and column"
        raise UnreadableScan(path, "a matrix of heights", fault, "delete both; their range is the size")
    return rows


def _has_axes(rows: np.ndarray) -> bool:
    """Return whether the first row and column are evenly spaced, unlike the next row, from a corner 0 or empty."""

    def even(values: np.ndarray) -> bool:
        steps = np.diff(values)
        return steps.size > 1 and bool(steps[0] != 0 and np.ptp(steps) < 1e-3 * abs(steps[0]))

    corner = rows[0, 0]
    return (
        min(rows.shape) > 3
        and (corner == 0 or np.isnan(corner))
        and even(rows[0, 1:])
        and even(rows[1:, 0])
        and not even(rows[1, 1:])
    )


def _on_grid(path: Path, points: np.ndarray) -> tuple[np.ndarray, tuple[float, float]]:
    """Return points x, y, z of a grid as rows from the top, and the size of their pixels together."""
    places = points[:, :2] - points[:, :2].min(axis=0)
    number = np.zeros(0, dtype=int)
    extent = places.max(axis=0)
    if (extent > 0).all() and np.isfinite(extent).all():
        shares = places / extent
        shape = np.array([np.unique(np.round(column, 9)).size for column in shares.T])
        steps = np.rint(shares * (shape - 1)).astype(int)
        # largest distance of a point from its grid's point, in steps: coordinates are rounded
        if np.abs(shares * (shape - 1) - steps).max() < 0.3 and len(points) == shape.prod():
            number = np.unique(np.ravel_multi_index(tuple(steps.T), tuple(shape)), return_index=True)[1]
    if number.size < len(points):
        fault = "three columns that are not the points of a whole grid"
        advice = "interpolate them, or write nan where there is no height"
        raise UnreadableScan(path, "a matrix of heights", fault, advice)
    width, height = (extent * shape / (shape - 1)).tolist()
    return points[number, 2].reshape(shape).T[::-1], (width, height)


def separators(line: str) -> tuple[str | None, bool]:
    """Return the delimiter of a line of numbers (None is white space) and whether its comma is decimal."""
    if ";" in line:
        return ";", "," in line
    if "," not in line:
        return None, False
    if "\t" in line or re.search(r"\d,\d+\s+[-+\d]", line):
        return None, True
    return ",", False
