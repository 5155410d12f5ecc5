"""Plain numbers: text matrices and ``.npy`` arrays, first row at the top; the caller gives missing sizes and units.

A text matrix does not state its number of rows, so that a truncated file looks complete. If its header states the size,
pixels must therefore be square, unless the caller gives the size as well.
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import numpy as np

from ..vocabulary.text import warn
from ..vocabulary.units import factor
from .channel import Channel, UnreadableScan, stated_direction

NPY = b"\x93NUMPY"

#: First bytes of text in UTF-16.
_UTF16 = (b"\xff\xfe", b"\xfe\xff")

# "Width: 10.00 µm" as Gwyddion writes it into the comments above the numbers
_ENTRY = re.compile(r"^\s*#+\s*([^:]+):\s*(.*?)\s*$")
_LENGTH = re.compile(r"^([-+0-9.eE]+)\s*(\S+)$")


def npy_channels(path: Path) -> list[Channel]:
    """Return the one image of a ``.npy`` file; its size and units must be given."""
    values = np.load(path, mmap_mode="r", allow_pickle=False)
    if values.ndim != 2 or values.dtype.kind not in "fiu":
        raise UnreadableScan(path, f"expected a matrix of real numbers, found shape {values.shape} of {values.dtype}")
    if (size := path.stat().st_size - values.offset) != values.nbytes:
        raise UnreadableScan(path, f"expected {values.nbytes} bytes of data, found {size}: damaged")
    read = partial(np.array, values, dtype=float)
    return [Channel(path.stem, None, values.shape, None, None, read)]


def is_text(head: bytes) -> bool:
    """Return whether bytes look like text of numbers: no control characters, and a digit."""
    head = decoded(head[: len(head) // 2 * 2]).encode() if head.startswith(_UTF16) else head
    return not re.search(rb"[\x00-\x08\x0e-\x1f]", head) and bool(re.search(rb"\d", head))


def text_channels(path: Path) -> list[Channel]:
    """Return the one image of a text matrix: columns along x, rows from the top."""
    text = decoded(path.read_bytes())
    header = {match[1]: match[2] for match in map(_ENTRY.match, text.splitlines()[:100]) if match}
    rows = _matrix(path, text)
    if not text.endswith("\n"):
        warn(f"{path.name}: the last line has no line end; if the file was cut short, its last number is wrong")
    size, lateral_units = _size(header)
    name = header.get("Channel", path.stem)
    return [
        Channel(
            name=name,
            units=header.get("Value units"),
            shape=rows.shape,
            size=size,
            lateral_units=lateral_units,
            read=lambda: rows,
            direction=stated_direction(name),
            header=header,
            counted=False,
        )
    ]


def decoded(data: bytes) -> str:
    """Return the text of a file in UTF-8, UTF-16 (spreadsheets' "Unicode text") or Latin-1 (older programs)."""
    if data.startswith(_UTF16):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # older programs write the micro sign so


def _size(header: dict[str, str]) -> tuple[tuple[float, float] | None, str | None]:
    """Return the size of width and height, and their common units, from a Gwyddion header."""
    lengths = [_LENGTH.match(header.get(key, "")) for key in ("Width", "Height")]
    known = [match.groups() for match in lengths if match]
    if len(known) < 2:
        return None, None
    (width, x_units), (height, y_units) = known
    if x_units != y_units:
        return (float(width), float(height) * factor(y_units, x_units)), x_units
    return (float(width), float(height)), x_units


def _matrix(path: Path, text: str) -> np.ndarray:
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise UnreadableScan(path, "expected a matrix of numbers, found no line of numbers")
    delimiter, decimal_comma = separators(lines[0])
    if decimal_comma:
        lines = [line.replace(",", ".") for line in lines]
    try:
        rows = np.loadtxt([line.rstrip(" \t" + (delimiter or "")) for line in lines], delimiter=delimiter, ndmin=2)
    except ValueError as error:
        raise UnreadableScan(
            path, f"expected a matrix of numbers, found: {error} (a table of pull-offs is read by `roughxr measured`)"
        ) from error
    if rows.shape[1] == 3 and rows.shape[0] > 3:
        raise UnreadableScan(path, "expected a matrix of heights, found three columns (x, y, z?): map them to a grid")
    return rows


def separators(line: str) -> tuple[str | None, bool]:
    """Return the delimiter of a line of numbers (None is white space) and whether its comma is decimal."""
    if ";" in line:
        return ";", "," in line
    if "," not in line:
        return None, False
    if "\t" in line or re.search(r"\d,\d+\s+[-+\d]", line):
        return None, True
    return ",", False
