"""Sizes of vendors' files by their own headers: a longer file has bytes inserted, which would shift its heights.

Facts from WaveMetrics' technical note 3 (Igor waves), Gwyddion's descriptions of formats, and files of Asylum and
Nanosurf. Asylum's waves end with thumbnails and a list of them, whose length is the last number of the file.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path

#: Bytes of the header of an NT-MDT file, of an Igor wave before its parts, and at the end of Asylum's waves.
_MDT_HEADER = 33
_IGOR_HEADER = 64
_ASYLUM_END = re.compile(rb" ?(\d{4}) MFP3D$")

#: Bytes of a height in a BCR file by its kind, and of a header that does not state its size.
_BCR_BYTES = {"bcrf": 4, "bcrstm": 2}
_BCR_HEADER = 2048


def excess(path: Path, code: str) -> str:
    """Return that a file of a format is longer than its header states; empty if it is not, or its header is silent."""
    stated_size = {"ibw": _igor_size, "ezd": _nanosurf_size, "mdt": _mdt_size, "bcr": _bcr_size}.get(code)
    if stated_size is None:
        return ""
    data = path.read_bytes()
    try:
        stated = stated_size(data)
    except (ValueError, KeyError, IndexError, struct.error):
        return ""  # a damaged header, which the reader reports
    if len(data) <= stated:
        return ""
    return f"expected a file of {stated:,} bytes, as its header states, found {len(data):,}: damaged"


def _igor_size(data: bytes) -> int:
    """Return the end of an Igor wave of version 5, of Asylum's with its thumbnails."""
    parts = struct.unpack("<13i" if data[0] else ">13i", data[4:56])
    if end := _ASYLUM_END.search(data[-16:]):
        listed = data[-int(end[1]) :]
        starts = [int(start) for start in re.findall(rb"FileStart:(\d+);", listed)]
        length = re.search(rb"DataLength:(\d+);", listed)
        if starts and length:
            return max(starts) + int(length[1]) + len(listed)
    return _IGOR_HEADER + sum(parts)


def _nanosurf_size(data: bytes) -> int:
    """Return the end of a Nanosurf file: its header, and the images that this lists."""
    text, mark, _ = data.partition(b"#!")
    size = len(text) + len(mark)
    for section in re.findall(rb"^\[DataSet-\d+:\d+\]\s*$(.*?)(?=^\[|\Z)", text, re.MULTILINE | re.DOTALL):
        entries = dict(re.findall(rb"^(Points|Lines|SaveBits)=(\d+)", section, re.MULTILINE))
        size += int(entries[b"Points"]) * int(entries[b"Lines"]) * int(entries[b"SaveBits"]) // 8
    return size


def _mdt_size(data: bytes) -> int:
    """Return the end of the last frame of an NT-MDT file."""
    (last,) = struct.unpack_from("<H", data, 12)
    end = _MDT_HEADER
    for _ in range(last + 1):
        (size,) = struct.unpack_from("<I", data, end)
        end += size
    return end


def _bcr_size(data: bytes) -> int:
    """Return the end of a BCR file, whose header lists its size and the pixels."""
    head = data[:_BCR_HEADER].decode("latin-1").splitlines()
    entries = {name.strip(): value.strip() for name, equals, value in (line.partition("=") for line in head) if equals}
    pixels = int(entries["xpixels"]) * int(entries["ypixels"])
    return int(entries.get("headersize", _BCR_HEADER)) + pixels * _BCR_BYTES[entries["fileformat"]]
