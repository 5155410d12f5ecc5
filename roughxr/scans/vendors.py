"""Vendors' formats, read through SurfaceTopography (extra ``afm``) in a process that is ended when it takes too long.

A reader is used only where the first bytes are those of its format, and redundant statements in a header must agree.
"""

from __future__ import annotations

import re
import struct
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from . import vendor_reader
from .channel import Channel, UnreadableScan, asked, direction_in, first_bytes, is_length


def channels(path: Path) -> list[Channel]:
    """Return the images in a vendor's file."""
    head = first_bytes(path, 512)
    if head[:2] in (b"\x05\0", b"\0\x05") and not is_igor(head):
        raise UnreadableScan(path, "expected a header with a valid checksum, found a damaged one (Igor wave)")
    answer = asked(path, vendor_reader, "SurfaceTopography")
    if "said" in answer:
        raise UnreadableScan(path, f"expected an AFM image, found none: {_reasons(answer['said'], head)}")
    kind, images = answer["format"], [(k, one) for k, one in enumerate(answer["images"]) if one["dim"] == 2]
    if not images:
        raise UnreadableScan(path, f"expected an image of heights, found a {kind} file without one")
    doubt = _length_doubt(path, kind, images[0][1]["header"])
    return [_channel(path, k, one, kind)._replace(doubt=doubt) for k, one in images]


def formats() -> list[tuple[str, str]]:
    """Return names and endings of the vendors' formats that are read, none without the extra."""
    if find_spec("SurfaceTopography") is None:
        return []
    from SurfaceTopography import IO

    known = [one for one in IO.readers if one.format() not in vendor_reader.NOT_ASKED]
    return sorted((one.name(), ", ".join(f".{ending}" for ending in one.file_extensions())) for one in known)


def _length_doubt(path: Path, format_name: str, header: dict[str, Any]) -> str:
    """Return how a header and the file's length contradict each other, empty where they agree or cannot be compared."""
    length = path.stat().st_size
    stated = {"di": _bruker_length, "sur": _digital_surf_length, "ibw": _igor_length}.get(format_name)
    expected = stated(path, header.get("raw_metadata") or {}) if stated else None
    if expected is None or expected == length:
        return ""
    return f"its header describes {expected} bytes, the file has {length}: damaged, or other data appended"


def _bruker_length(path: Path, _raw: Any) -> int | None:
    """Return where the last block of data ends."""
    data = path.read_bytes()
    header = data[: data.find(b"\x1a") + 1 or len(data)]
    blocks = re.findall(rb"\\Data offset: (\d+)\s+\\Data length: (\d+)", header)
    return max((int(offset) + int(length) for offset, length in blocks), default=None)


def _digital_surf_length(path: Path, raw: Any) -> int | None:
    """Return 512 bytes of header, the comments, and the points."""
    if first_bytes(path, 12) != b"DIGITAL SURF" or raw.get("nb_objects", 1) > 1:  # else compressed, or of several
        return None
    return 512 + raw["comment_size"] + raw["private_size"] + raw["nb_points"] * raw["itemsize"] // 8


def _igor_length(path: Path, _raw: Any) -> int | None:
    """Return None where the note is where the header says; it is text, and what follows it is not accounted for."""
    with path.open("rb") as file:
        head = file.read(64)
        _, _, wave, formula, note, *_ = struct.unpack("<hh15i" if head[0] else ">hh15i", head)
        file.seek(64 + wave + formula)
        text = file.read(note)
    return 64 + wave + formula if re.search(rb"[\x00-\x08\x0e-\x1f]", text) else None


#: First bytes that belong to one format only, whatever other readers make of the file.
SIGNATURES = {
    "di": (b"\\*File list", b"\\*EC File list"),
    "ps": (b"II*\0", b"MM\0*"),
    "sur": (b"DIGITAL SURF", b"DSCOMPRESSED"),
    "ibw": (b"\x05\0", b"\0\x05", b"\x02\0", b"\0\x02"),
    "ezd": (b"[DataSet]",),
    "mi": (b"fileType",),
    "wsxm": (b"WSxM file copyright",),
}

#: Signatures of formats that begin with text but are not text files.
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
    return "it begins like no known format (`roughxr info --formats` lists them)"


def _channel(path: Path, index: int, image: dict[str, Any], format_name: str) -> Channel:
    columns, rows = image["points"]
    raw = image["header"].get("raw_metadata") or {}
    # SurfaceTopography converts heights to the lateral unit; a channel of no length keeps its own
    kind = image["data_unit"] or image["units"]
    units = image["units"] if kind is None or is_length(kind) else kind
    return Channel(
        name=image["name"],
        units=units,
        shape=(rows, columns),
        size=image["size"],
        lateral_units=image["lateral_units"],
        read=partial(_rows, path, index, units),
        direction=_direction(image["name"], raw),
        header={"format": format_name, **image["header"]},
        remark=_remark(raw, format_name),
    )


def _rows(path: Path, index: int, units: str | None) -> np.ndarray:
    answer = asked(path, vendor_reader, "SurfaceTopography", index=index)
    if is_length(units) and answer["unit"] != units:
        raise ValueError(f"image {index}: expected heights in {units!r}, as listed, found {answer['unit']!r}: damaged")
    return answer["heights"].T


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
    """Return a remark on the size: an Igor wave states its step, and a nominal size too."""
    if format_name != "ibw" or not isinstance(raw, dict) or "ScanSize" not in raw:
        return ""
    nominal = re.sub(r"[^0-9.eE+-]", "", str(raw["ScanSize"]))
    return f"lateral size is the stored step times the pixels; the header's nominal ScanSize is {nominal} m"
