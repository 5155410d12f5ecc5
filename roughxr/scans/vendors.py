"""Vendors' formats, read through SurfaceTopography (extra ``afm``).

SurfaceTopography indexes heights as [x, y] with y counted downwards from the top of the picture; its
heights, sizes and orientation agree with Gwyddion's. What is added here: a reader is believed only where
the first bytes are that format's own, and redundant statements in a header must agree.
"""

from __future__ import annotations

import logging
import re
import struct
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .channel import Channel, UnreadableScan, direction_in, is_length, optional

#: SurfaceTopography readers that are not asked: formats read elsewhere in this package, and formats without
#: a signature, which would take any file (a height map of unknown size, bare text, archives of arrays).
_NOT_ASKED = {"asc", "xyz", "nc", "h5", "gwy", "npy", "npz", "mat", "hgt", "nms"}


def channels(path: Path) -> list[Channel]:
    """Return the images in a vendor's file.

    Raises
    ------
    UnreadableScan
        If no reader takes the file: what each said.
    """
    with path.open("rb") as file:
        head = file.read(512)
    if head[:2] in (b"\x05\0", b"\0\x05") and not is_igor(head):
        raise UnreadableScan(path, "expected an Igor wave whose header sums to zero, found a damaged header")
    reader = _reader(path, head)
    images = [one for one in reader.channels if one.dim == 2]
    if not images:
        raise UnreadableScan(path, f"expected an image of heights, found a {reader.format()} file without one")
    return [_channel(one, reader.format()) for one in images]


def _reader(path: Path, head: bytes) -> Any:
    """Return SurfaceTopography's reader of a file, the first that takes it."""
    io = optional("SurfaceTopography.IO")
    # readers that try a file and find it another's may say so on standard error, through this log
    logging.getLogger("tifffile").addHandler(logging.NullHandler())
    said = {}
    for reader in io.readers:
        name = reader.format()
        if name in _NOT_ASKED or reader.can_read(head) == io.MagicMatch.NO:
            continue
        try:
            return io.open_topography(str(path), format=name)
        except Exception as error:  # every reader fails in its own way on another's file
            said[name] = " ".join(str(error).split()) or type(error).__name__
    raise UnreadableScan(path, f"expected an AFM image, found none: {_reasons(said, head)}")


#: First bytes by which a file is one format's, whatever the other readers say of it.
SIGNATURES = {
    "di": (b"\\*File list", b"\\*EC File list"),
    "ps": (b"II*\0", b"MM\0*"),
    "sur": (b"DIGITAL SURF", b"DSCOMPRESSED"),
    "ibw": (b"\x05\0", b"\0\x05", b"\x02\0", b"\0\x02"),
    "ezd": (b"[DataSet]",),
    "mi": (b"fileType",),
    "wsxm": (b"WSxM file copyright",),
}

#: Formats that begin as text, and are none.
TEXT_SIGNATURES = tuple(start for name in ("di", "ezd", "mi", "wsxm") for start in SIGNATURES[name])


def is_park(path: Path) -> bool:
    """Return whether a file is a TIFF whose first page carries Park's private tag 50432."""
    with path.open("rb") as file:
        order = {b"II*\0": "<", b"MM\0*": ">"}.get(file.read(4))
        if order is None:
            return False
        file.seek(struct.unpack(f"{order}I", file.read(4))[0])
        (count,) = struct.unpack(f"{order}H", file.read(2))
        entries = file.read(12 * count)
    return 50432 in (tag for tag, *_ in struct.iter_unpack(f"{order}H10s", entries))


def is_igor(head: bytes) -> bool:
    """Return whether bytes begin an Igor wave of version 5: 384 header bytes whose 16-bit sum is zero."""
    if len(head) < 384 or head[:2] not in (b"\x05\0", b"\0\x05"):
        return False
    order = "<i2" if head[0] else ">i2"
    return int(np.frombuffer(head[:384], order).sum(dtype=np.int64)) & 0xFFFF == 0


def _reasons(said: dict[str, str], head: bytes) -> str:
    own = [name for name, starts in SIGNATURES.items() if head.startswith(starts) and name in said]
    if own:
        return f"it begins as {own[0]}, but: {said[own[0]][:300]}"
    return "it begins like no known format"


def _channel(info: Any, format_name: str) -> Channel:
    lateral, units = info.unit if isinstance(info.unit, tuple) else (info.unit, info.unit)
    kind = info.data_unit if isinstance(info.data_unit, str) else units
    columns, rows = info.nb_grid_pts
    header = dict(info.info.model_dump(exclude_none=True)) if hasattr(info.info, "model_dump") else dict(info.info)
    raw = header.get("raw_metadata") or {}
    # SurfaceTopography converts heights to the lateral unit; a channel of no length keeps its own
    units = units if kind is None or is_length(kind) else kind
    return Channel(
        name=info.name,
        units=units,
        shape=(rows, columns),
        size=None if info.physical_sizes is None else tuple(map(float, info.physical_sizes)),
        lateral_units=lateral,
        read=partial(_rows, info, units),
        direction=_direction(info.name, raw),
        header={"format": format_name, **header},
        remark=_remark(raw, format_name),
    )


def _rows(info: Any, units: str | None) -> np.ndarray:
    topography = info.topography()
    found = topography.unit[-1] if isinstance(topography.unit, tuple) else topography.unit
    if is_length(units) and found != units:
        raise ValueError(f"{info.name}: its heights are stated in {units!r}, but read in {found!r}")
    return np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan).T


def _direction(name: str, raw: Any) -> str:
    """Return trace or retrace from the header where it is stated (Bruker, Park), else from the name."""
    if not isinstance(raw, dict):
        return direction_in(name)
    line = str(raw.get("line direction", "")).lower()
    if line in ("trace", "retrace"):
        return line
    if raw.get("forward") in (0, 1):
        return "trace" if raw["forward"] else "retrace"
    return direction_in(name)


def _remark(raw: Any, format_name: str) -> str:
    """Return what must be known about the size: an Igor wave states its step, and a nominal size too."""
    if format_name != "ibw" or not isinstance(raw, dict) or "ScanSize" not in raw:
        return ""
    nominal = re.sub(r"[^0-9.eE+-]", "", str(raw["ScanSize"]))
    return f"lateral size is the stored step times the pixels; the header's nominal ScanSize is {nominal} m"
