"""Read NanoScope's force curves and volumes, and the texts that JPK and NanoScope Analysis export, without a library.

Answers are those of `curve_reader.read`. In NanoScope's files each curve is its extension, then its retraction, both
from contact outwards. Force = count × V/LSB × deflection sensitivity × spring constant. Integers of four bytes may have
fractional bits, which the trigger shows: the force reaches its threshold in contact.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from io import StringIO
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.units import converts, factor
from ..images.channel import first_bytes, refuse_other_size
from ..images.nanoscope_header import LARGEST_HEADER, SCALED, SENSITIVITY, Block, header_blocks, header_values
from ..images.plain import decoded
from . import curve_reader

#: A curve: values stated in its header, and a function that reads its columns.
Curve = dict[str, Any]

#: JPK's columns of the height, sensors first.
_JPK_SENSORS = ("strainGaugeHeight", "capacitiveSensorHeight", "measuredHeight")
_JPK_HEIGHTS = (*_JPK_SENSORS, *(f"smoothed{name[0].upper()}{name[1:]}" for name in _JPK_SENSORS), "height")

#: NanoScope Analysis' columns of the ramp, sensors first.
_RAMPS = ("Height_Sensor", "Calc_Ramp")

#: Possible numbers of fractional bits of integers of four bytes.
_POSSIBLE_BITS = (0, 8, 16)


def read(path: Path, kind: str, known: dict[str, float], first: int = 0, last: int | None = None) -> dict[str, Any]:
    """Return the headers of a file of curves, or its curves from ``first`` to before ``last``."""
    stat = path.stat()
    name, curves, missing = _opened(path, kind, tuple(known.items()), stat.st_mtime_ns, stat.st_size)
    return {"missing": list(missing)} if missing else curve_reader.answer(name, curves, kind, first, last)


@lru_cache(maxsize=1)
def _opened(path: Path, kind: str, known: tuple, *_state: int) -> tuple[str, list[Curve], tuple[str, ...]]:
    """Return the name of a file's format, its curves, and the names of calibration values that it lacks."""
    name, reader = READERS[kind]
    calibration = dict(known)
    curves = list(reader(path, calibration))
    needed = {name for curve in curves for name in curve.pop("needed") if name not in curve["metadata"]}
    return name, curves, tuple(sorted(needed))


def _jpk_text(path: Path, known: dict[str, float]) -> Iterator[Curve]:
    """Yield the curve of a text exported by JPK's programs."""
    stated: dict[str, str] = {}  # above a segment
    segments = []
    lines = decoded(path.read_bytes()).splitlines()
    for is_head, part in groupby(lines, lambda line: line.startswith("#") or not line.strip()):
        if is_head:
            entries = (line[1:].partition(":") for line in part)
            stated = stated | {key.strip(): value.strip() for key, _, value in entries}
        else:
            segments.append(_jpk_segment(stated, list(part), known))
    sizes = [segment.height.size for segment in segments]
    columns = {
        "height (measured)": np.concatenate([segment.height for segment in segments]),
        "force": np.concatenate([segment.force for segment in segments]),
        "segment": np.repeat(np.arange(len(segments)), sizes),
        "paused": np.repeat([segment.is_pause for segment in segments], sizes),
    }
    places = {f"position {axis}": stated.get(f"{axis}Position", "") for axis in "xy"}
    metadata = segments[-1].calibration | {name: float(place) for name, place in places.items() if _is_number(place)}
    yield {"metadata": metadata, "data": columns, "needed": segments[-1].needed}


class _Segment(NamedTuple):
    """A segment of a JPK text."""

    is_pause: bool
    calibration: dict[str, float]
    needed: list[str]  # names of the calibration that its deflection needs
    height: np.ndarray  # m
    force: np.ndarray  # N, NaN without its calibration


def _jpk_segment(stated: dict[str, str], lines: list[str], known: dict[str, float]) -> _Segment:
    """Return the segment in lines of numbers, by the headers above."""
    names = stated.get("columns", "").split()
    units = dict(zip(names, stated.get("units", "").split()))
    height = next((name for name in _JPK_HEIGHTS if name in units), None)
    if height is None or not converts(units[height], "m") or units.get("vDeflection") not in _DEFLECTIONS:
        raise Refusal("", "columns of height and vDeflection with units", ", ".join(names))
    values = dict(zip(names, np.loadtxt(lines, ndmin=2).T))
    calibration = _jpk_calibration(stated, known)
    newtons, needed = _newtons(units["vDeflection"], calibration)
    metres = factor(units[height], "m")
    is_pause = stated.get("segment") == "pause"
    return _Segment(is_pause, calibration, needed, values[height] * metres, values["vDeflection"] * newtons)


#: Values that make a force of a voltage, by afmformats' names.
_CALIBRATION = ["sensitivity", "spring constant"]

#: Size of a unit of deflection, N, m or V, and the values that make a force of it.
_DEFLECTIONS: dict[str, tuple[float, list[str]]] = {
    "pN": (1e-12, []),
    "nN": (1e-9, []),
    "uN": (1e-6, []),
    "N": (1.0, []),
    "nm": (1e-9, _CALIBRATION[1:]),
    "m": (1.0, _CALIBRATION[1:]),
    "V": (1.0, _CALIBRATION),
}


def _newtons(unit: str, calibration: dict[str, float]) -> tuple[float, list[str]]:
    """Return the force of a unit of deflection, NaN without its calibration, and the names of this."""
    size, needed = _DEFLECTIONS[unit]
    return size * math.prod(calibration.get(name, np.nan) for name in needed), needed


def _jpk_calibration(stated: dict[str, str], known: dict[str, float]) -> dict[str, float]:
    """Return sensitivity (m/V) and spring constant (N/m) that a segment states, or that the caller does."""
    keys = {"sensitivity": "sensitivity", "spring constant": "springConstant"}
    return {name: float(stated[key]) for name, key in keys.items() if _is_number(stated.get(key, ""))} | known


def _is_number(text: str) -> bool:
    try:
        return np.isfinite(float(text))
    except ValueError:
        return False


def _nanoscope_text(path: Path, known: dict[str, float]) -> Iterator[Curve]:
    """Yield the curve of a text exported by NanoScope Analysis."""
    lines = decoded(path.read_bytes()).splitlines()
    first = next((k for k, line in enumerate(lines) if "_Ex" in line and not line.lstrip('"').startswith("\\")), None)
    if first is None:
        raise Refusal("", "columns of the extension, such as Calc_Ramp_Ex_nm and Defl_pN_Ex", "none")
    header = header_values([line.strip().strip('"') for line in lines[:first]])
    table = pd.read_csv(StringIO("\n".join(lines[first:])), sep="\t", skipinitialspace=True, dtype=str)
    table = table.apply(lambda column: pd.to_numeric(column.str.replace(",", "."), errors="coerce"))
    calibration = _nanoscope_calibration(header, "Sens. DeflSens") | known
    branches = [_text_branch(table, branch, calibration) for branch in ("Ex", "Rt")]
    height, force, needed = zip(*branches)
    columns = {"height (measured)": np.concatenate(height), "force": np.concatenate(force)}
    columns["segment"] = np.repeat([0, 1], [part.size for part in height])
    yield {"metadata": calibration, "data": columns, "needed": needed[0]}


def _text_branch(
    table: pd.DataFrame, branch: str, calibration: dict[str, float]
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return height (m) and force (N) of a branch, and the names of the calibration that its deflection needs."""
    named = {_column_quantity(name, branch): table[name].to_numpy() for name in table if f"_{branch}" in name}
    ramp = next((key for prefix in _RAMPS for key in named if key[0] == prefix and converts(key[1], "m")), None)
    deflection = next((("Defl", unit) for unit in _DEFLECTIONS if ("Defl", unit) in named), None)
    if ramp is None or deflection is None:
        raise Refusal("", f"columns Calc_Ramp_{branch}_nm and Defl_pN_{branch}", ", ".join(table))
    newtons, needed = _newtons(deflection[1], calibration)
    return -named[ramp] * factor(ramp[1], "m"), named[deflection] * newtons, needed


def _column_quantity(name: str, branch: str) -> tuple[str, str]:
    """Return quantity and units of a column, "Calc_Ramp_Ex_nm" or "Defl_pN_Ex"."""
    before, _, after = name.strip().partition(f"_{branch}")
    if after:
        return before, after.strip("_")
    quantity, _, unit = before.rpartition("_")
    return quantity, unit


def _nanoscope_calibration(header: dict[str, str], quantity: str) -> dict[str, float]:
    """Return sensitivity (m/V; without units nm/V) and spring constant (N/m) of a header."""
    values: dict[str, float] = {}
    sensitivity = SENSITIVITY.match(header.get(quantity.lower(), ""))
    if sensitivity and sensitivity["units"] in ("nm/V", ""):
        values["sensitivity"] = float(sensitivity["value"]) * 1e-9
    if _is_number(header.get("spring constant", "")):
        values["spring constant"] = float(header["spring constant"])
    return values


class _Quantity(NamedTuple):
    """A quantity of all curves of a NanoScope file."""

    counts: np.ndarray  # (curves, samples), on disk
    factor: float  # of a count, in V, m or N
    sensitivity: str  # its name


def _nanoscope(path: Path, known: dict[str, float]) -> Iterator[Curve]:
    """Yield the curves of NanoScope's force curves and volumes."""
    blocks = header_blocks(first_bytes(path, LARGEST_HEADER))
    header = {key: value for block in blocks if "image list" not in block.title for key, value in block.values.items()}
    scans = [block.values for block in blocks if block.title.lower() == "ciao image list"]
    deflection, sensor = _force_images(blocks)
    values = header | deflection
    count = _curve_count(header, scans)
    sizes = _sample_counts(values)
    forces = _stored(path, deflection, count, sum(sizes))
    bits = _fractional_bits(forces, sizes, header) if forces.counts.itemsize == 4 else 0
    metadata = _nanoscope_calibration(values, forces.sensitivity) | known
    newtons = forces.factor / 2**bits
    for name in _CALIBRATION:
        newtons *= metadata.get(name, np.nan)
    columns = partial(_nanoscope_columns, forces._replace(factor=newtons), _heights(path, sensor, values, count), sizes)
    for number in range(count):
        places = _place(number, count, header, scans) if count > 1 else {}
        yield {"metadata": {**metadata, **places}, "data": partial(columns, number), "needed": _CALIBRATION}


def _heights(path: Path, sensor: dict[str, str] | None, values: dict[str, str], count: int) -> _Quantity | np.ndarray:
    """Return the heights of all curves in m by a sensor, else those of each, in the order of time, by the ramp."""
    sizes = _sample_counts(values)
    if sensor is None:
        return (_sine_heights if _is_peak_force(values) else _ramp_heights)(values, sizes)
    measured = _stored(path, sensor, count, sum(sizes))
    metres = _nanoscope_calibration(values, measured.sensitivity).get("sensitivity", np.nan)
    return measured._replace(factor=-measured.factor * metres)


def _nanoscope_columns(
    forces: _Quantity, heights: _Quantity | np.ndarray, sizes: tuple[int, int], number: int
) -> dict[str, np.ndarray]:
    """Return the samples of a curve in the order of time."""
    # a branch that stopped at the trigger is filled up to half of the stored samples
    stored = forces.counts.shape[1]
    retraction = stored // 2 if stored > sum(sizes) else sizes[0]
    in_time = np.r_[sizes[0] - 1 : -1 : -1, retraction : retraction + sizes[1]]
    force = (forces.counts[number] * forces.factor)[in_time]
    height = (heights.counts[number] * heights.factor)[in_time] if isinstance(heights, _Quantity) else heights
    return {"height (measured)": height, "force": force, "segment": np.repeat([0, 1], sizes)}


def _force_images(blocks: list[Block]) -> tuple[dict[str, str], dict[str, str] | None]:
    """Return the values of the curves' deflections, and of their heights by a sensor, if there is one."""
    images = [block.values for block in blocks if "force image list" in block.title.lower()]
    titles = [image.get("image data", "unnamed") for image in images]
    deflection = next((image for image, title in zip(images, titles) if "Defl" in title), None)
    sensor = next((image for image, title in zip(images, titles) if "ZSensor" in title), None)
    if deflection is None:
        raise Refusal("", "curves of the deflection", ", ".join(titles) or "none", "capture the deflection")
    return deflection, sensor


def _is_peak_force(header: dict[str, str]) -> bool:
    """Return whether curves are those of PeakForce tapping, captured with an image."""
    return header.get("peakforce capture") == "Allow" and header.get("operating mode") == "Image"


def _sample_counts(values: dict[str, str]) -> tuple[int, int]:
    """Return the numbers of samples of the extension and of the retraction."""
    counts = [int(word) for word in values["samps/line"].split() if word.isdecimal()]
    if values.get("samps/line, retrace") == str(counts[0]):  # of the retraction
        counts = counts[::-1]
    return counts[0], counts[-1]


def _curve_count(header: dict[str, str], scans: list[dict[str, str]]) -> int:
    """Return the number of curves."""
    is_volume = "volume" in header.get("operating mode", "").lower() or header.get("start context") == "FVOL"
    if not (is_volume or _is_peak_force(header)):
        return 1
    per_line = header.get("force/line", "").split()
    if per_line and int(per_line[0]) > 0 and not _is_peak_force(header):  # the image may be finer
        return int(per_line[0]) ** 2
    return int(scans[0]["samps/line"].split()[0]) * int(scans[0]["number of lines"])


def _entry(pattern: re.Pattern, header: dict[str, str], name: str) -> re.Match:
    """Return an entry of a header; raise KeyError if it is missing or has another form."""
    entry = pattern.match(header.get(name, ""))
    if entry is None:
        raise KeyError(name)
    return entry


def _stored(path: Path, image: dict[str, str], count: int, samples: int) -> _Quantity:
    """Return a quantity of the curves; the width of its integers is their size over their number."""
    offset = int(image["data offset"])
    length = int(image["data length"])
    scale = _entry(SCALED, image, "z scale")
    width = length // (samples * count)
    if width not in (2, 4):
        raise Refusal("", f"{count} × {samples} integers of 2 or 4 bytes", f"{width} bytes for each")
    refuse_other_size(path, offset + samples * count * width, may_be_longer=True)
    stored = length // (width * count)  # with filler
    stored = stored if path.stat().st_size >= offset + stored * count * width else samples
    counts = np.memmap(path, f"<i{width}", "r", offset, (count, stored))
    return _Quantity(counts, float(scale["lsb"]), scale["quantity"] or "")


def _fractional_bits(stored: _Quantity, sizes: tuple[int, int], header: dict[str, str]) -> int:
    """Return the number of fractional bits of integers of four bytes, by the trigger if there is a relative one."""
    default = 0 if len(stored.counts) == 1 else 8  # of a curve, of a volume
    stated = SCALED.match(header.get("trig threshold deflection", ""))
    has_trigger = header.get("trigger mode") == "Relative" and not _is_peak_force(header)
    threshold = float(stated["value"]) if stated and has_trigger else 0.0
    # number of curves of a volume that show the trigger
    extensions = np.asarray(stored.counts[:16, : sizes[0]], float) * stored.factor
    far = np.median(extensions[:, -max(sizes[0] // 4, 1) :], axis=1)
    reached = np.median(extensions.max(axis=1) - far)
    if min(threshold, reached) <= 0:
        return default
    return min(_POSSIBLE_BITS, key=lambda bits: abs(np.log(reached / 2**bits / threshold)))


def _ramp_heights(values: dict[str, str], sizes: tuple[int, int]) -> np.ndarray:
    """Return the heights (m) of extension and retraction, in the order of time."""
    ramp = _entry(SCALED, values, "ramp size" if "ramp size" in values else "ramp size zsweep")
    length = float(ramp["value"]) * float(_entry(SENSITIVITY, values, "sens. zsens")["value"]) * 1e-9
    step = length / max(max(sizes) - 1, 1)
    extension, retraction = (step * np.arange(size) for size in sizes)
    return np.concatenate([extension[::-1], retraction])


def _sine_heights(values: dict[str, str], sizes: tuple[int, int]) -> np.ndarray:
    """Return the heights (m) of a period of PeakForce tapping, lowest at the synchronisation."""
    amplitude = float(values["peak force amplitude"].removesuffix("nm")) * 1e-9
    period = sum(sizes)
    lowest = float(sizes[0])
    points = values.get("sample points", "")
    synchronisation = values.get("sync distance qnm", "")
    if _is_number(synchronisation) and float(synchronisation) > 0 and _is_number(points):
        lowest = float(synchronisation) * (1.0 if float(points) == sizes[0] else period / float(points))
    return -amplitude * np.cos(2 * np.pi * (np.arange(period) - lowest) / period)


def _place(number: int, count: int, header: dict[str, str], scans: list[dict[str, str]]) -> dict[str, float]:
    """Return the place (m) of a curve of a volume, from the lower left corner, rows upwards."""
    scan_size = (scans[0] if scans else header).get("scan size", "").replace("~", "µ").split()
    if len(scan_size) < 2 or not converts(scan_size[-1], "m") or not float(scan_size[0]) > 0:
        return {}
    columns = int(scans[0]["samps/line"].split()[0]) if _is_peak_force(header) else round(count**0.5)
    pixel = float(scan_size[0]) * factor(scan_size[-1], "m") / columns
    row, column = divmod(number, columns)
    return {"position x": (column + 0.5) * pixel, "position y": (row + 0.5) * pixel}


#: Names and readers of the formats, by kind.
READERS: dict[str, tuple[str, Callable[[Path, dict[str, float]], Iterator[Curve]]]] = {
    "nanoscope": ("Bruker NanoScope (force curves)", _nanoscope),
    "jpk text": ("JPK Instruments (text)", _jpk_text),
    "nanoscope text": ("Bruker NanoScope Analysis (text)", _nanoscope_text),
}
