"""Recognize files of force curves or of several scans, and refuse them with advice."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

from .channel import COPY_AGAIN, UnreadableScan, first_bytes, is_igor

#: First bytes of NanoScope's force curves and force volumes; its images begin with "\*File list".
NANOSCOPE = b"\\*Force file list"

#: Words in the first lines of text files of curves, by format.
TEXTS = {
    "afmformats": b"# afmformats",
    "workshop": b"Force-Distance Curve",
    "chiaro": b"Device:\tChiaro",
    "jpk text": b"# TEXT EXPORT",
    "nanoscope text": b'Force file list"',
}

#: Columns that NanoScope Analysis exports without a header.
_NANOSCOPE_COLUMNS = b"Calc_Ramp_Ex_"

#: Ends of the names of two Igor waves that are one curve of Asylum's: deflection, and sensor of the piezo.
PAIR = ("Defl", "ZSnsr")

#: First bytes of a zip file.
ZIP = b"PK\x03\x04"

#: Names of the metadata in a container of contact.engineering, in the order of preference.
METADATA = ("index.json", "meta.yml")


def curve_format(path: Path) -> str:
    """Return the format of a file's force curves, empty if there are none."""
    head = first_bytes(path, 4096)
    if head.startswith(NANOSCOPE):
        return "nanoscope"
    if head.startswith(ZIP):
        _refuse_cut_archive(path)
        names = _zip_names(path)
        return "jpk" if "header.properties" in names and any("segments/" in name for name in names) else ""
    if is_igor(head):  # images have a third dimension, of channels
        samples, columns, layers, _ = struct.unpack("<4i" if head[0] else ">4i", head[132:148])
        is_one_of_two = columns == 0 and path.stem.endswith(PAIR)
        return "igor" if is_one_of_two or (samples > columns > 1 and layers == 0) else ""
    if _NANOSCOPE_COLUMNS in head:
        return "nanoscope text"
    return next((name for name, words in TEXTS.items() if words in head), "")


def without_second_waves(paths: list[Path]) -> list[Path]:
    """Return files without the sensors' waves of curves whose deflections are among them."""
    deflection, sensor = PAIR
    curves = {path.with_stem(path.stem.removesuffix(deflection) + sensor) for path in paths if path.stem.endswith(PAIR)}
    return [path for path in paths if not path.stem.endswith(sensor) or path not in curves]


def refuse_curves(path: Path) -> None:
    """Raise for a file of force curves or a container of scans, with advice on how to open it."""
    kind = curve_format(path)
    if set(METADATA) & set(_zip_names(path)):
        advice = "in Python, open it with roughxr.scans.open_container"
        raise UnreadableScan(path, "one image", "a container of several topographies", advice)
    if kind:
        advice = (
            "read them with `roughxr measured`, in Python with roughxr.open_pull_off or roughxr.measured.open_curves"
        )
        raise UnreadableScan(path, "an image of heights", f"force-distance curves ({kind})", advice)


def _refuse_cut_archive(path: Path) -> None:
    """Raise for a zip file whose list of members, at its end, is missing."""
    if not zipfile.is_zipfile(path):
        expected = "an archive with the list of its members at the end"
        raise UnreadableScan(path, expected, f"none in {path.stat().st_size:,} bytes: cut short", COPY_AGAIN)


def _zip_names(path: Path) -> list[str]:
    """Return the names of the files in a zip file; none for other files."""
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.namelist()
    except (zipfile.BadZipFile, OSError, NotImplementedError, UnicodeDecodeError):  # damaged, or of a later version
        return []
