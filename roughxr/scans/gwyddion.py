"""Gwyddion's own formats: ``.gsf`` through gsffile, ``.gwy`` through gwyfile (extra ``afm``).

Formats: http://gwyddion.net/documentation/user-guide-en/file-formats.html. Both store rows from the top.
"""

from __future__ import annotations

import struct
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .channel import Channel, UnreadableScan, direction_in, optional

GSF = b"Gwyddion Simple Field 1.0\n"
GWY = b"GWYP"
OLD_GWY = b"GWYO"


def gsf_channels(path: Path) -> list[Channel]:
    """Return the one image of a Gwyddion Simple Field file."""
    values, header = optional("gsffile").read_gsf(path)
    return [
        Channel(
            name=header.get("Title", "Topography"),
            units=header.get("ZUnits"),
            shape=values.shape,
            # the format's default of 1 m is a size that nobody stated
            size=(header["XReal"], header["YReal"]) if {"XReal", "YReal"} <= set(header) else None,
            lateral_units=header.get("XYUnits"),
            read=partial(np.asarray, values, dtype=float),
            direction=direction_in(header.get("Title", "")),
            header=header,
        )
    ]


def gwy_channels(path: Path) -> list[Channel]:
    """Return the images of a Gwyddion file, with masked pixels missing."""
    data = path.read_bytes()
    if data.startswith(OLD_GWY):
        raise UnreadableScan(path, "expected a Gwyddion 2 file, found Gwyddion 1's GWYO; open and save it in Gwyddion")
    if _object_end(data, len(GWY), len(data)) != len(data):
        raise UnreadableScan(path, "expected one Gwyddion object as long as the file, found another length: damaged")
    container = optional("gwyfile").objects.GwyObject.frombuffer(data[len(GWY) :])
    numbers = sorted(int(key.split("/")[1]) for key in container if _is_field(key))
    return [_gwy_channel(container, number) for number in numbers]


def _is_field(key: str) -> bool:
    parts = key.split("/")
    return len(parts) == 3 and parts[0] == "" and parts[1].isdigit() and parts[2] == "data"


def _gwy_channel(container: Any, number: int) -> Channel:
    field = container[f"/{number}/data"]
    title = container.get(f"/{number}/data/title", f"channel {number}")
    size = (field.xreal, field.yreal)
    return Channel(
        name=title,
        units=_unit(field.si_unit_z),
        shape=(field["yres"], field["xres"]),
        size=None if None in size else size,
        lateral_units=_unit(field.si_unit_xy),
        read=partial(_gwy_rows, field, container.get(f"/{number}/mask")),
        direction=direction_in(title),
        header=dict(container.get(f"/{number}/meta", {})),
    )


def _unit(si_unit: Any) -> str | None:
    return (si_unit.unitstr or None) if si_unit is not None else None


def _gwy_rows(field: Any, mask: Any) -> np.ndarray:
    rows = np.array(field.data, dtype=float)
    return rows if mask is None else np.where(np.asarray(mask.data) > 0, np.nan, rows)


#: Bytes of a component of one value, and of one item of a component of many.
_ONE = {b"b": 1, b"c": 1, b"i": 4, b"q": 8, b"d": 8}
_MANY = {b"C": 1, b"I": 4, b"Q": 8, b"D": 8}


def _object_end(data: bytes, start: int, stop: int) -> int:
    """Return where the object at ``start`` ends, or raise ValueError if its components do not fill it."""
    at = data.index(b"\0", start, stop) + 1
    (length,) = struct.unpack_from("<I", data, at)
    at, end = at + 4, at + 4 + length
    if end > stop:
        raise ValueError(f"an object of {length} bytes at byte {start} is longer than what holds it")
    while at < end:
        at = _component_end(data, at, end)
    return end


def _component_end(data: bytes, start: int, stop: int) -> int:
    """Return where the named component at ``start`` ends."""
    at = data.index(b"\0", start, stop) + 2
    kind = data[at - 1 : at]
    count = 1
    if kind in b"SO" or kind in _MANY:
        (count,) = struct.unpack_from("<I", data, at)
        at += 4
    if kind in _ONE or kind in _MANY:
        at += count * {**_ONE, **_MANY}[kind]
    else:
        step = {b"s": _text_end, b"S": _text_end, b"o": _object_end, b"O": _object_end}[kind]
        for _ in range(count):
            at = step(data, at, stop)
    if at > stop:
        raise ValueError(f"a component at byte {start} is longer than the object that holds it")
    return at


def _text_end(data: bytes, start: int, stop: int) -> int:
    return data.index(b"\0", start, stop) + 1
