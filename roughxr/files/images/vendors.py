"""Vendors' formats, read through SurfaceTopography (extra ``afm``) in a separate process with a time limit.

A reader is used only if the file begins with its signature.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...mechanics.vocabulary.refusal import Refusal
from . import formats, stated_sizes, vendor_reader
from .channel import IGOR, Channel, UnreadableScan, first_bytes, is_igor, is_length, read_in_process, stated_direction
from .microscopes import TIFF, is_park

#: First bytes that belong to one format only, even if other readers accept the file.
SIGNATURES: dict[str, tuple[bytes, ...]] = {
    "di": (b"\\*File list", b"\\*EC File list"),
    "ps": TIFF,
    "sur": (b"DIGITAL SURF", b"DSCOMPRESSED"),
    "ibw": (b"\x05\0", b"\0\x05", b"\x02\0", b"\0\x02"),
    "ezd": (b"[DataSet]",),
    "mi": (b"fileType",),
    "wsxm": (b"WSxM file copyright",),
    "sdf": (b"aISO-1.0", b"bISO-1.0"),
    "mdt": (b"\x01\xb0\x93\xff",),
    "bcr": (b"fileformat = bcr",),
}

#: Signatures of formats that begin with text but are not text files.
TEXT_SIGNATURES = tuple(start for name in ("di", "ezd", "mi", "wsxm", "sdf", "bcr") for start in SIGNATURES[name])


def channels(path: Path) -> list[Channel]:
    """Return the images in a vendor's file."""
    head = first_bytes(path, 512)
    if head[:2] in IGOR and not is_igor(head):
        raise UnreadableScan(path, "a header with a valid checksum", "a damaged one", where=("Igor wave",))
    _refuse_variant(path, head)
    answer = read_in_process(path, vendor_reader, "SurfaceTopography")
    kind = answer.get("format", "ps" if is_park(path) else "")
    stated_sizes.refuse_longer(path, kind)
    if "errors" in answer:
        formats.refuse_not_read(path)
        code = code_of(head)
        reason = answer["errors"][code][:300] if code in answer["errors"] else "it begins like no known format"
        raise UnreadableScan(path, "an AFM image", f"none: {reason}")
    images = [(k, image) for k, image in enumerate(answer["images"]) if image["dim"] == 2]
    if not images:
        raise UnreadableScan(path, "an image of heights", "other quantities alone, such as currents")
    return [_channel(path, k, image, kind) for k, image in images]


def code_of(head: bytes) -> str:
    """Return the format that bytes begin, empty where their signature alone does not tell."""
    certain = (name for name, starts in SIGNATURES.items() if name != "ps" and head.startswith(starts))
    code = next(certain, "")
    return code if code != "ibw" or is_igor(head) else ""


#: Place of the units of heights in a Digital Surf header.
_SURF_UNITS = slice(212, 228)


def _refuse_variant(path: Path, head: bytes) -> None:
    """Raise for a variant of a format that its reader cannot read."""
    code = code_of(head)
    if head.startswith(b"DSCOMPRESSED"):
        raise UnreadableScan(path, "heights without compression", "compressed ones", "save it without compression")
    if code == "sur":
        units = head[_SURF_UNITS].decode("latin-1").strip("\0 ")
        if not is_length(units):
            raise UnreadableScan(path, "heights", f"another quantity, in {units or 'no units'!r}")
    if code == "mi":
        header = path.read_bytes().partition(b"data  ")[0].decode("latin-1").splitlines()
        names = {line.split()[0] for line in header if line.strip()}
        if lacking := [name for name in ("xLength", "yLength") if name not in names]:
            fault = f"no {' and '.join(lacking)} in its header"
            raise UnreadableScan(path, "the size of the image", fault, "save it as .gwy")


def _channel(path: Path, index: int, image: dict[str, Any], kind: str) -> Channel:
    columns, rows = image["points"]
    raw = image["header"].get("raw_metadata")
    raw = raw if isinstance(raw, dict) else {}
    # SurfaceTopography converts heights to the lateral unit, but not other channels
    stated = image["data_unit"] or image["units"]
    length = stated is None or is_length(stated)
    return Channel(
        name=image["name"],
        units=image["units"] if length else stated,
        shape=(rows, columns),
        size=image["size"],
        lateral_units=image["lateral_units"],
        read=partial(_rows, path, index, image["units"] if length else None),
        direction=_direction(image["name"], raw),
        header={"format": kind, **image["header"]},
    )


def _rows(path: Path, index: int, units: str | None) -> np.ndarray:
    answer = read_in_process(path, vendor_reader, "SurfaceTopography", index=index)
    if units and answer["unit"] != units:
        raise Refusal(f"image {index}", f"heights in {units!r}, as listed", f"{answer['unit']!r}: damaged")
    return answer["heights"].T


def _direction(name: str, raw: dict[str, Any]) -> str:
    """Return trace or retrace from the header where it is stated (Bruker, Park), else from the name."""
    line = str(raw.get("line direction", "")).lower()
    if line in ("trace", "retrace"):
        return line
    if raw.get("forward") in (0, 1):
        return "trace" if raw["forward"] else "retrace"
    return stated_direction(name)
