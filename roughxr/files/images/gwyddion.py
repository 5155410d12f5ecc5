"""Gwyddion's own formats, both with rows from the top: ``.gsf`` through gsffile (extra ``afm``), and ``.gwy``.

Format: http://gwyddion.net/documentation/user-guide-en/gwyfile-format.html. ``.gwy`` has a reader of its own, since
SurfaceTopography lists images of heights only, and gwyfile hangs on truncated files.
"""

from __future__ import annotations

import struct
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .channel import Channel, UnreadableScan, optional, refuse_other_size, stated_direction

GSF = b"Gwyddion Simple Field 1.0\n"
GWY = b"GWYP"
OLD_GWY = b"GWYO"

#: NumPy's types of a component of one value, and of the items of an array.
_NUMBERS = {"b": "?", "c": "S1", "i": "<i4", "q": "<i8", "d": "<f8"}


def gsf_channels(path: Path) -> list[Channel]:
    """Return the one image of a Gwyddion Simple Field file."""
    values, header = optional("gsffile").read_gsf(path)
    return [
        Channel(
            name=header.get("Title", "Topography"),
            units=header.get("ZUnits"),
            shape=values.shape,
            # not the format's default of 1 m
            size=(header["XReal"], header["YReal"]) if {"XReal", "YReal"} <= set(header) else None,
            lateral_units=header.get("XYUnits"),
            read=partial(np.asarray, values, dtype=float),
            direction=stated_direction(header.get("Title", "")),
            header=header,
        )
    ]


def gwy_channels(path: Path) -> list[Channel]:
    """Return the images of a Gwyddion file, with masked pixels missing."""
    data = path.read_bytes()
    if data.startswith(OLD_GWY):
        raise UnreadableScan(path, "a file of Gwyddion 2", "one of Gwyddion 1, GWYO", "open and save it in Gwyddion")
    container, end = _object(data, len(GWY), len(data))
    refuse_other_size(path, end)
    numbers = sorted(int(key.split("/")[1]) for key in container if _is_field(key))
    return [_gwy_channel(container, number) for number in numbers]


def _is_field(key: str) -> bool:
    parts = key.split("/")
    return len(parts) == 3 and parts[0] == "" and parts[1].isdigit() and parts[2] == "data"


def _gwy_channel(container: dict[str, Any], number: int) -> Channel:
    field = container[f"/{number}/data"]
    title = container.get(f"/{number}/data/title", f"channel {number}")
    size = field.get("xreal"), field.get("yreal")
    return Channel(
        name=title,
        units=field.get("si_unit_z", {}).get("unitstr") or None,
        shape=(int(field["yres"]), int(field["xres"])),
        size=None if None in size else size,
        lateral_units=field.get("si_unit_xy", {}).get("unitstr") or None,
        read=partial(_gwy_rows, field, container.get(f"/{number}/mask")),
        direction=stated_direction(title),
        header=container.get(f"/{number}/meta", {}),
    )


def _gwy_rows(field: dict[str, Any], mask: dict[str, Any] | None) -> np.ndarray:
    shape = int(field["yres"]), int(field["xres"])
    rows = field["data"].reshape(shape).astype(float)
    return rows if mask is None else np.where(mask["data"].reshape(shape) > 0, np.nan, rows)


def _object(data: bytes, start: int, stop: int) -> tuple[dict[str, Any], int]:
    """Return the components of the object at ``start``, and its end."""
    _, at = _text(data, start, stop)
    end = at + 4 + struct.unpack_from("<I", data, at)[0]
    if end > stop:
        raise ValueError(f"an object at byte {start} is longer than what contains it")
    at = at + 4
    components = {}
    while at < end:
        name, at = _text(data, at, end)
        components[name], at = _component(data, chr(data[at]), at + 1, end)
    return components, end


def _component(data: bytes, kind: str, at: int, stop: int) -> tuple[Any, int]:
    """Return the value of a component of a kind (capitals are arrays), and its end."""
    count = 1
    start = at
    if kind.isupper():
        count = struct.unpack_from("<I", data, at)[0]
        start = at + 4
    if kind.lower() in _NUMBERS:
        dtype = np.dtype(_NUMBERS[kind.lower()])
        end = start + count * dtype.itemsize
        if end > stop:
            raise ValueError(f"a component at byte {at} is longer than the object that contains it")
        array = np.frombuffer(data, dtype, count, start)
        value = array if kind.isupper() else array[0].item()
        return (value.decode("latin-1") if isinstance(value, bytes) else value), end  # text of one letter, by gwyfile
    read = {"s": _text, "o": _object}[kind.lower()]
    values = []
    end = start
    for _ in range(count):
        value, end = read(data, end, stop)
        values.append(value)
    return (values if kind.isupper() else values[0]), end


def _text(data: bytes, start: int, stop: int) -> tuple[str, int]:
    """Return the text up to a zero byte, in UTF-8 or Latin-1 (of older programs), and its end."""
    end = data.index(b"\0", start, stop)
    text = data[start:end]
    try:
        return text.decode(), end + 1
    except UnicodeDecodeError:
        return text.decode("latin-1"), end + 1
