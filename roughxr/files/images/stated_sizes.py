"""Sizes of vendors' files by their own headers: a longer file has bytes inserted, which would shift its heights.

Facts from WaveMetrics' technical note 3 (Igor waves), Gwyddion's descriptions of formats, ISO 25178-71, and files of
Agilent, Asylum, Bruker, Digital Surf, Nanosurf, Park and WSxM. Asylum's waves end with thumbnails and a list of them,
whose length is the last number of the file. JPK's images and HDF5 may be longer than what they list, by their formats.
"""

from __future__ import annotations

import io
import operator
import re
import struct
from collections.abc import Callable
from pathlib import Path

from .channel import refuse_other_size
from .nanoscope_header import header_blocks

#: Bytes of the header of an NT-MDT file, of an Igor wave before its parts, and at the end of Asylum's waves.
_MDT_HEADER = 33
_IGOR_HEADER = 64
_ASYLUM_END = re.compile(rb" ?(\d{4}) MFP3D$")

#: Bytes of a height in a BCR file by its kind, and of a header that does not state its size.
_BCR_BYTES = {"bcrf": 4, "bcrstm": 2}
_BCR_HEADER = 2048

#: End of an Agilent header: its last line, which states the kind of data.
_AGILENT_END = re.compile(rb"^data {10}(\w*)\r?\n", re.MULTILINE)

#: End of a WSxM header, its entries, and bytes of a height by their kind.
_WSXM_END = re.compile(rb"^\[Header end\]\r?\n", re.MULTILINE)
_WSXM_ENTRY = re.compile(rb"^\s*(Number of rows|Number of columns|Image Data Type): *(\w+)", re.MULTILINE)
_WSXM_BYTES = {b"short": 2, b"integer": 2, b"float": 4, b"double": 8}

#: Bytes of a Digital Surf header, places of its numbers, and first bytes of a further object.
_SURF_HEADER = 512
_SURF_BITS = 98
_SURF_SHAPE = 108
_SURF_ZONES = 334
_SURF_OBJECTS = (b"DIGITAL SURF", b"DSCOMPRESSED")

#: Header of a binary ISO 25178-71 file, and bytes of a height by its kind.
_ISO_HEADER = struct.Struct("<8s10s12s12sHHddddBBB")
_ISO_BYTES = (1, 2, 4, 4, 1, 2, 4, 8)

#: Text in ASCII, as the standard asks for, up to an end-of-file mark.
_TEXT = re.compile(rb"[\t\r\n -~]*[\0\x1a]*")

#: Bytes of an entry of a TIFF directory.
_TIFF_ENTRY = 12


def refuse_longer(path: Path, code: str) -> None:
    """Raise if a file of a format is longer than its header states; its reader reports a shorter one."""
    if code not in _STATED_SIZES:
        return
    data = path.read_bytes()
    try:
        stated = _STATED_SIZES[code](data)
    except (ValueError, KeyError, IndexError, struct.error):  # a damaged header, which the reader reports
        return
    if len(data) > stated:
        refuse_other_size(path, stated)


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


def _nanoscope_size(data: bytes) -> int:
    """Return the end of the last block of a NanoScope file."""
    values = [block.values for block in header_blocks(data) if {"data offset", "data length"} <= set(block.values)]
    return max(int(block["data offset"]) + int(block["data length"]) for block in values)


def _agilent_size(data: bytes) -> int:
    """Return the end of an Agilent file: its header, and the buffers that this lists."""
    end = _AGILENT_END.search(data)
    if end is None:
        raise ValueError("no data")
    header = data[: end.start()]
    shape = dict(re.findall(rb"^(xPixels|yPixels) +(\d+)", header, re.MULTILINE))
    buffers = len(re.findall(rb"^bufferLabel", header, re.MULTILINE))
    pixels = int(shape[b"xPixels"]) * int(shape[b"yPixels"])
    return end.end() + buffers * pixels * (4 if end[1] == b"BINARY_32" else 2)


def _wsxm_size(data: bytes) -> int:
    """Return the end of a WSxM file: its header, and one image."""
    end = _WSXM_END.search(data)
    if end is None:
        raise ValueError("no data")
    entries = dict(_WSXM_ENTRY.findall(data[: end.start()]))
    pixels = int(entries[b"Number of rows"]) * int(entries[b"Number of columns"])
    return end.end() + pixels * _WSXM_BYTES[entries[b"Image Data Type"]]


def _surf_size(data: bytes) -> int:
    """Return the end of a Digital Surf file's heights, or of the file if a further object follows these."""
    (bits,) = struct.unpack_from("<H", data, _SURF_BITS)
    columns, rows = struct.unpack_from("<ii", data, _SURF_SHAPE)
    zones = struct.unpack_from("<HH", data, _SURF_ZONES)
    end = _SURF_HEADER + sum(zones) + columns * rows * bits // 8
    return len(data) if data.startswith(_SURF_OBJECTS, end) else end


def _iso_size(data: bytes) -> int:
    """Return the end of the heights of an ISO 25178-71 file, or of the file if text follows these, or is all."""
    if not data.startswith(b"bISO"):
        return len(data)
    *_, points, profiles, _, _, _, _, _, kind, _ = _ISO_HEADER.unpack_from(data)
    end = _ISO_HEADER.size + points * profiles * _ISO_BYTES[kind]
    return len(data) if _TEXT.fullmatch(data, end) else end


def _park_size(data: bytes) -> int:
    """Return the end of what the one directory of a Park TIFF lists."""
    from tifffile import TiffFile  # of the reader that has read the file

    with TiffFile(io.BytesIO(data)) as file:
        page = file.pages.first
    tags = page.tags.values()
    directory_end = max(tag.offset for tag in tags) + _TIFF_ENTRY + 4  # and the place of the next directory
    values = (tag.valueoffset + tag.valuebytecount for tag in tags)
    return max(directory_end, *values, *map(operator.add, page.dataoffsets, page.databytecounts))


#: What returns the size that a file of a format states.
_STATED_SIZES: dict[str, Callable[[bytes], int]] = {
    "bcr": _bcr_size,
    "di": _nanoscope_size,
    "ezd": _nanosurf_size,
    "ibw": _igor_size,
    "mdt": _mdt_size,
    "mi": _agilent_size,
    "ps": _park_size,
    "sdf": _iso_size,
    "sur": _surf_size,
    "wsxm": _wsxm_size,
}
