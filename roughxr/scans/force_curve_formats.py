"""Recognize files of force curves or of several scans, and refuse them with advice on how to open them."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

from .channel import UnreadableScan, first_bytes

#: First bytes of NanoScope's force curves and force volumes; its images begin with "\*File list".
NANOSCOPE = b"\\*Force file list"

#: Words in the first lines of text files of curves, by the name of their format.
TEXTS = {"afmformats": b"# afmformats", "workshop": b"Force-Distance Curve", "chiaro": b"Device:\tChiaro"}

#: First bytes of a zip file.
ZIP = b"PK\x03\x04"

#: Names of the metadata of a container of contact.engineering, the first that is there.
METADATA = ("index.json", "meta.yml")

_READ_BY = "read them with `roughxr measured`, in Python with roughxr.open_pull_off or roughxr.measured.open_curves"

_NOT_READ = (
    "not read: export the curves as text from NanoScope Analysis, or give `roughxr measured` a table of pull-off "
    "forces or a PeakForce adhesion image"
)


def curves_in(path: Path) -> str:
    """Return the format of a file's force curves, empty if it has none of a known format."""
    head = first_bytes(path, 4096)
    if head.startswith(NANOSCOPE):
        return "nanoscope"
    if head.startswith(ZIP):
        return "jpk" if _is_jpk(path) else ""
    if is_wave_of_columns(head):
        return "igor"
    return next((name for name, words in TEXTS.items() if words in head), "")


def refuse_curves(path: Path) -> None:
    """Raise for a file of force curves or a container of scans, with advice on how to open it."""
    kind = curves_in(path)
    if kind == "nanoscope":
        refuse_nanoscope(path)
    if set(METADATA) & set(_zip_names(path)):
        raise UnreadableScan(
            path,
            "expected one image, found a container of several topographies; open it with roughxr.scans.open_container",
        )
    if kind:
        raise UnreadableScan(path, f"expected an image of heights, found force-distance curves ({kind}); {_READ_BY}")


def refuse_nanoscope(path: Path) -> None:
    """Raise for NanoScope's force curves, which roughxr does not read."""
    if first_bytes(path, len(NANOSCOPE)) == NANOSCOPE:
        raise UnreadableScan(path, f"found Bruker's force curves (NanoScope), which are {_NOT_READ}")


def is_wave_of_columns(head: bytes) -> bool:
    """Return whether an Igor wave of version 5 has two dimensions, as curves have; images have a third, of channels."""
    if len(head) < 384 or head[:2] not in (b"\x05\0", b"\0\x05"):
        return False
    samples, columns, layers, _ = struct.unpack("<4i" if head[0] else ">4i", head[132:148])
    return samples > columns > 1 and layers == 0


def _zip_names(path: Path) -> list[str]:
    """Return the names that a zip file lists, none of any other file."""
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.namelist()
    except (zipfile.BadZipFile, OSError):
        return []


def _is_jpk(path: Path) -> bool:
    """Return whether an archive holds JPK's segments of curves."""
    names = _zip_names(path)
    return "header.properties" in names and any("segments/" in name for name in names)
