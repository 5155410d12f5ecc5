"""Vendors' images, read through SurfaceTopography by `reader_process`: this file imports nothing of roughxr."""

from __future__ import annotations

import io
import json
import os
import re
import struct
import zipfile
from functools import lru_cache
from typing import Any

import numpy as np

#: SurfaceTopography readers that are not used: of formats with other readers in this package, and of formats without
#: a signature, which would accept any file (a height map of unknown size, bare text, archives of arrays).
UNUSED = {"asc", "xyz", "nc", "h5", "gwy", "jpk", "npy", "npz", "mat", "hgt", "nms"}


def read(path: str, index: int | None = None) -> dict[str, Any]:
    """Return the images of a file or, for ``index`` (counted over images of all dimensions), the heights of one."""
    stat = os.stat(path)
    reader, errors = _opened(path, stat.st_mtime_ns, stat.st_size)
    if reader is None:
        return {"errors": errors}
    if index is not None:
        return _heights(reader.channels[index])
    return {"format": reader.format(), "images": [_image(channel) for channel in reader.channels]}


@lru_cache(maxsize=1)
def _opened(path: str, *_state: int) -> tuple[Any, dict[str, str]]:
    """Return the first reader of SurfaceTopography that accepts a file, or None and the error of each."""
    from SurfaceTopography import IO

    with open(path, "rb") as file:
        head = file.read(512)
    errors = {}
    for reader in IO.readers:
        name = reader.format()
        if name in UNUSED or reader.can_read(head) == IO.MagicMatch.NO:
            continue
        try:
            mended = {"di": _with_micro_signs, "ibw": _with_ended_labels, "x3p": _as_standard_x3p}.get(name, str)
            return IO.open_topography(mended(path), format=name), {}
        except Exception as error:  # readers fail in various ways on other formats
            errors[name] = " ".join(str(error).split()) or type(error).__name__
    return None, errors


def _with_micro_signs(path: str) -> Any:
    """Return a NanoScope file with "µm" where it has "~m", by which SurfaceTopography does not scale."""
    with open(path, "rb") as file:
        header, end, data = file.read().partition(b"\x1a")
    return io.BytesIO(header.replace(b"~m", b"\xb5m") + end + data) if b"~m" in header else path


def _with_ended_labels(path: str) -> Any:
    """Return an Igor wave of version 5 whose labels have no bytes beyond their end, which would become their name."""
    with open(path, "rb") as file:
        wave = file.read()
    if wave[:2] not in (b"\5\0", b"\0\5"):
        return path
    sizes = struct.unpack_from("<12i" if wave[0] else ">12i", wave, 4)
    begin = 64 + sum(sizes[:8])
    end = min(begin + sum(sizes[8:]), len(wave))
    labels = (wave[at : min(at + 32, end)] for at in range(begin, end, 32))
    ended = b"".join(label.partition(b"\0")[0].ljust(len(label), b"\0") for label in labels)
    return io.BytesIO(wave[:begin] + ended + wave[end:])


def _as_standard_x3p(path: str) -> Any:
    """Return an X3P file with the revision's hyphen, with a date or none, and with heights in a member."""
    with zipfile.ZipFile(path) as archive:
        text = archive.read("main.xml").decode("utf-8", "replace")  # before other members, which other zip files have
        members = {name: archive.read(name) for name in archive.namelist()}
    mended = re.sub(r"(ISO5436\s*)[\u2010-\u2015](\s*2000)", r"\1-\2", text)
    mended = re.sub(r"(<(?:\w+:)?Date>)([^<]+)(</(?:\w+:)?Date>)", _date_or_empty, mended)
    listed = re.search(r"<(\w+:)?DataList>.*?</(\w+:)?DataList>", mended, re.DOTALL)
    if listed:
        data = re.findall(r"<(?:\w+:)?Datum\s*(?:/>|>([^<]*)</(?:\w+:)?Datum>)", listed[0])
        heights = [float(cell.split(";")[-1]) if cell.strip() else np.nan for cell in data]
        members["bindata/listed.bin"] = np.array(heights, "<f8").tobytes()
        link = "<DataLink><PointDataLink>bindata/listed.bin</PointDataLink></DataLink>"
        mended = mended[: listed.start()] + link + mended[listed.end() :]
        mended = re.sub(r"(<CZ>.*?<DataType>)\w(</DataType>)", r"\1D\2", mended, flags=re.DOTALL)
    if mended == text:
        return path
    members["main.xml"] = mended.encode()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    packed.seek(0)
    return packed


def _date_or_empty(element: re.Match) -> str:
    """Return an X3P element of a date, empty if it states none ("N/A"), which SurfaceTopography refuses."""
    from dateutil import parser

    try:
        parser.parse(element[2])
    except (ValueError, OverflowError):
        return element[1] + element[3]
    return element[0]


def _image(info: Any) -> dict[str, Any]:
    lateral, units = info.unit if isinstance(info.unit, tuple) else (info.unit, info.unit)
    header = info.info.model_dump(exclude_none=True) if hasattr(info.info, "model_dump") else dict(info.info)
    return {
        "name": str(info.name),
        "dim": int(info.dim),
        "lateral_units": lateral,
        "units": units,
        "data_unit": info.data_unit if isinstance(info.data_unit, str) else None,
        "points": tuple(map(int, info.nb_grid_pts)),
        "size": None if info.physical_sizes is None else tuple(map(float, info.physical_sizes)),
        "header": json.loads(json.dumps(header, default=str)),
    }


def _heights(info: Any) -> dict[str, Any]:
    topography = info.topography()
    unit = topography.unit[-1] if isinstance(topography.unit, tuple) else topography.unit
    return {"unit": unit, "heights": np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan)}
