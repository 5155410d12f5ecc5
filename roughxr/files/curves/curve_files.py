"""Force-distance curves and force volumes in microscopes' files, most of them read through afmformats."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...mechanics.vocabulary.refusal import Refusal, shown
from ...mechanics.vocabulary.text import Argument, Phrase
from ...mechanics.vocabulary.units import factor, positive
from ..images.channel import UnreadableScan, first_bytes, read_in_process, refuse_stated
from ..images.force_curve_formats import TEXTS, ZIP, curve_format
from ..images.netcdf import HDF5
from ..images.plain import decoded, separators
from ..images.recognition import call_naming_file
from ..storage import open_locked_raw
from . import curve_reader, exported_curves
from .forces import Calibration, has_units
from .segments import approach_and_retraction

BRANCHES = ("loading", "retraction")


class CurveFile(NamedTuple):
    """A file of curves whose samples are not read yet."""

    path: Path
    kind: str
    known: dict[str, float]  # calibration stated by the caller, m/V or m/A and N/m
    format: str
    curves: list[dict[str, float]]  # values stated by the file for each curve


def curve_kind(path: Path, family: str, given: Calibration) -> str | None:
    """Return the kind of a file of curves, by its content; None for any other file."""
    kind, head = curve_format(path), first_bytes(path, 4096)
    if head.startswith(ZIP):
        return "zip"
    if head.startswith(HDF5):
        with open_locked_raw(path) as file:
            return "hdf5" if getattr(file, "software", "") == "afmformats" else None
    return kind or (_nt_mdt(head, given) if family == "text" else None)


def _nt_mdt(head: bytes, given: Calibration) -> str | None:
    """Return "nt-mdt" for three bare columns of numbers whose sensitivity is per current, else None."""
    first = decoded(head).splitlines()[0]
    bare = len(first.split(separators(first)[0])) == 3 and not any(letter.isalpha() for letter in first)
    if given.sensitivity is None or not bare:
        return None
    try:
        positive(given.sensitivity, "nm/nA", "sensitivity")
    except Refusal:
        return None
    return "nt-mdt"


def open_curve_file(path: Path, kind: str, given: Calibration) -> CurveFile:
    """Return a file of curves without reading its samples; raise if the calibration is unknown."""
    stated = _stated_calibration(path, kind, given)
    answer = _reader_answer(path, kind, {})
    used = {name: stated[name] for name in _needed(path, kind, answer, stated)}
    answer = _reader_answer(path, kind, used) if used else answer
    curves = answer["curves"]
    if not curves:
        raise UnreadableScan(path, "force-distance curves", "none")
    for name in (name for name in stated if name not in used):
        own = [curve[name] for curve in curves if name in curve]
        if own or name == "sensitivity":  # a spring constant given with forces corrects the displacement for bending
            option = name.replace(" ", "_")
            otherwise = "; if the file's calibration is wrong, multiply the forces by the ratio"
            value = shown(own[0]) if own else "none with forces"
            refuse_stated(path, option, getattr(given, option), value, otherwise=otherwise)
    return CurveFile(path, kind, used, answer["format"], [{**stated, **curve} for curve in curves])


def _stated_calibration(path: Path, kind: str, given: Calibration) -> dict[str, float]:
    """Return the caller's calibration under afmformats' names, in m/V (m/A) and N/m."""
    for option in ("units", "pulls"):
        if getattr(given, option) is not None:
            refuse_stated(path, option, getattr(given, option))
    known = {}
    if given.sensitivity is not None:
        has_units(given.sensitivity)
        known["sensitivity"] = positive(given.sensitivity, _per_volt(kind), "sensitivity")
    if given.spring_constant is not None:
        known["spring constant"] = positive(given.spring_constant, "N/m", "spring_constant")
    return known


def _per_volt(kind: str) -> str:
    return "m/A" if kind == "nt-mdt" else "m/V"


def _needed(path: Path, kind: str, answer: dict[str, Any], stated: dict[str, float]) -> list[str]:
    """Return the names of the calibration values that the file does not state; raise if the caller does not either."""
    needed = answer.get("missing", [])
    lacking = [name.replace(" ", "_") for name in needed if name not in stated]
    if lacking:
        units = {"sensitivity": "50 nm/nA" if kind == "nt-mdt" else "50 nm/V", "spring_constant": "0.2 N/m"}
        advice = Phrase("give ", Argument(lacking[0], units[lacking[0]]))
        for name in lacking[1:]:
            advice = Phrase(advice, ", ", Argument(name, units[name]))
        raise UnreadableScan(path, "forces", f"deflections without {' and '.join(lacking)}", advice)
    return needed


def _reader_answer(path: Path, kind: str, known: dict[str, float], **which: int) -> dict[str, Any]:
    if kind in exported_curves.READERS:
        return call_naming_file(path, exported_curves.read, path, kind, known, **which)
    texts = {name: words for name, words in TEXTS.items() if name not in exported_curves.READERS}
    return read_in_process(
        path, curve_reader, "afmformats", extra="curves", kind=kind, known=known, texts=texts, **which
    )


def read_curves(file: CurveFile, first: int = 0, last: int | None = None) -> xr.Dataset:
    """Return curves of a file, in the form of `open_curves`."""
    curves = file.curves[first:last]
    samples = _reader_answer(file.path, file.kind, file.known, first=first, last=first + len(curves))["samples"]
    branches = [_branches(**curve) for curve in samples]
    size = max((curve[0].size for both in branches for curve in both if curve is not None), default=0)
    values = np.full((2, len(branches), 2, size), np.nan)
    for number, both in enumerate(branches):
        for branch, curve in enumerate(both):
            if curve is not None:
                values[:, number, branch, : curve[0].size] = curve
    dims = "subregion", "branch", "sample"
    made = {"piezo": (dims, values[0] * factor("m", "nm")), "force": (dims, values[1] * factor("N", "nN"))}
    coords = {"subregion": np.arange(first, first + len(curves)), "branch": list(BRANCHES), **_places(curves)}
    return xr.Dataset(made, coords, {"source_format": file.format, **calibration(file)})


def _branches(
    piezo: np.ndarray, force: np.ndarray, segment: np.ndarray | None = None, paused: np.ndarray | None = None
) -> list[tuple[np.ndarray, np.ndarray] | None]:
    """Return travel and force on approach and retraction, None for a branch that is not there."""
    parts = approach_and_retraction(piezo, segment, paused)
    return [None if part is None else (piezo[part], force[part]) for part in parts]


def _places(curves: list[dict[str, float]]) -> dict[str, Any]:
    """Return the places of the curves; empty unless the file states every place."""
    if not all(f"position {axis}" in curve for curve in curves for axis in "xy"):
        return {}
    return {
        f"subregion_{axis}": ("subregion", [curve[f"position {axis}"] * factor("m", "nm") for curve in curves])
        for axis in "xy"
    }


def calibration(file: CurveFile) -> dict[str, float | str]:
    """Return spring constant (N/m) and sensitivity of a file's curves, as attributes; raise if curves differ."""
    known: dict[str, Any] = {}
    for name in ("spring constant", "sensitivity"):
        values = {curve.get(name) for curve in file.curves}
        if len(values) > 1:
            raise UnreadableScan(file.path, f"one {name} in a file", len(values), "split it")
        value = values.pop()
        if value is not None:
            known[name.replace(" ", "_")] = value
    if "sensitivity" in known:
        units = "nm/nA" if file.kind == "nt-mdt" else "nm/V"
        known["sensitivity"] = float(f"{known['sensitivity'] * factor(_per_volt(file.kind), units):.12g}")
        known["sensitivity_units"] = units
    return known
