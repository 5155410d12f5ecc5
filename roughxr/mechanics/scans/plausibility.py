"""Warnings about implausible scans: wrong units, a default size, recording faults."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary.schema import pixel
from ..vocabulary.text import RoughxrWarning

#: Least correlation of neighbouring pixels; below, the data are garbled or pure noise.
_LEAST_CORRELATION = 0.1

#: Least number of lines for a correlation: with fewer it may be chance.
_FEWEST_LINES = 16

#: A scar is a line that differs from its neighbours this many times more than any line in the other direction.
_SCAR_RATIO = 3.0

#: Heights wrapped around if neighbours differ by this share of the range, …
_WRAPPED_JUMP = 0.9

#: … in at least this many pairs, …
_FEWEST_WRAPS = 8

#: … and this share of the heights lies in the middle half of the range, where a grating of two levels has hardly any.
_BETWEEN_SHARE = 0.2


#: What is implausible, in words, by its key.
_WORDS = {
    "mark": "{value:.6g} nm at {marked} of {known} pixels, {gap:.4g} nm off all others, which range over {relief:.4g} "
    "nm: if it marks missing pixels, replace it by nan (in the file, or its export as text), then fill them "
    "(ds.contact.fill(), in a shell --fill linear)",
    "unit pixel": "one pixel is exactly 1 {unit} along {axis}: the scan size may never have been set",
    "oblong pixels": "pixels are not square: {dx:g} x {dy:g} nm",
    "coarse pixels": "pixels of {pixel:.4g} nm are too coarse to resolve the contacts of small spheres",
    "flat": "all heights are equal",
    "relief": "heights range over {relief:.4g} nm, more than the lateral {width:.4g} nm",
    "slope": "the slope exceeds 1 (45°) between {share:.3g} % of neighbouring pixels",
    "clipped": "{count} of {pixels} pixels have exactly the {end} value, {level:.6g} nm: clipped by the recorder",
    "wrapped": "{jumps} pairs of neighbouring heights differ by the whole range, {relief:.4g} nm, although most "
    "heights lie between: values wrapped around, as where 16 bits overflow",
    "jump": "the heights jump from line {line} to line {next_line} along {axis}: a scan fault, or an edge",
    "scar": "line {line}, counted along {axis}, differs from its neighbours {ratio:.2g} times more than the median "
    "line: a scan fault",
    "noise": "neighbouring heights are uncorrelated (correlation {correlation:.2g}): a damaged header, or nothing but "
    "noise",
    "unrelated lines": "neighbouring lines along {axis} are uncorrelated (correlation {correlation:.2g}): a damaged "
    "header, or lines that are not levelled to each other",
}


class Doubt(NamedTuple):
    """An implausible property of a scan, by its key, with its numbers."""

    key: str
    numbers: dict[str, Any]

    def __str__(self) -> str:
        return _WORDS[self.key].format(**self.numbers)


class ImplausibleScan(RoughxrWarning):
    """A file's statement about a scan is improbable; the scan is read as stated.

    Examples
    --------
    >>> import warnings
    >>> import roughxr
    >>> warnings.simplefilter("error", roughxr.ImplausibleScan)  # stop instead of warning
    """


def missing_mark(height: np.ndarray, least: float = 0.0) -> list[Doubt]:
    """Return a doubt if one value is many ranges of all others, and over ``least`` nm, away from them."""
    known = np.isfinite(height)
    for value in _ends(height, known):
        others = known & (height != value)  # no copies: a map may fill much of the memory
        low, high = _ends(height, others)
        relief = high - low
        gap = max(low - value, value - high)
        # least distance of a mark of missing pixels from all heights, in ranges of these
        if relief > 0 and gap > max(10.0 * relief, least):
            marked = known.sum() - others.sum()
            numbers = {"value": value, "marked": marked, "known": known.sum(), "gap": gap, "relief": relief}
            return [Doubt("mark", numbers)]
    return []


def _ends(height: np.ndarray, chosen: np.ndarray) -> tuple[float, float]:
    """Return the lowest and the highest of some heights, infinite ones if there are none."""
    return height.min(where=chosen, initial=np.inf), height.max(where=chosen, initial=-np.inf)


def doubts(ds: xr.Dataset) -> list[Doubt]:
    """Return the implausible properties of a scan."""
    return [*size_doubts(ds), *_height_doubts(ds["height"].values, pixel(ds))]


def size_doubts(ds: xr.Dataset) -> list[Doubt]:
    """Return the implausible properties of the lateral size, without reading the heights."""
    doubts = []
    steps = pixel(ds)
    for axis, step in zip("xy", steps):
        for unit, length in (("nm", 1.0), ("um", 1e3), ("mm", 1e6), ("m", 1e9)):
            if abs(step / length - 1) < 1e-9:
                doubts.append(Doubt("unit pixel", {"unit": unit, "axis": axis}))
    if abs(steps[0] - steps[1]) > 1e-6 * steps[0]:
        doubts.append(Doubt("oblong pixels", {"dx": steps[0], "dy": steps[1]}))
    # largest pixel, nm, that resolves contacts of spheres of some micrometres
    if min(steps) > 1000.0:
        doubts.append(Doubt("coarse pixels", {"pixel": min(steps)}))
    return doubts


def _height_doubts(height: np.ndarray, steps: tuple[float, float]) -> list[Doubt]:
    relief = np.nanmax(height) - np.nanmin(height)
    if relief == 0:
        return [Doubt("flat", {})]
    doubts = missing_mark(height)
    width = min(step * (n - 1) for step, n in zip(steps, height.shape))
    if relief > width:
        doubts.append(Doubt("relief", {"relief": relief, "width": width}))
    share = max(np.mean(_steps(height, axis) > step) for axis, step in enumerate(steps))
    if share > 0.01:
        doubts.append(Doubt("slope", {"share": 100 * share}))
    doubts += faults(height)
    return doubts + (_garbled(height) if min(height.shape) >= _FEWEST_LINES else [])


def faults(height: np.ndarray) -> list[Doubt]:
    """Return the recording faults: clipped or wrapped heights, shifted lines."""
    if np.nanmin(height) == np.nanmax(height):
        return []
    finite = np.isfinite(height)
    if not finite.all():
        height = height[np.ix_(finite.any(axis=1), finite.any(axis=0))]  # lines without any height are neither
    lines = (_scar(height) or _line_jump(height)) if min(height.shape) >= _FEWEST_LINES else []
    return [*_clipped(height), *_wrapped(height), *lines]


def _clipped(height: np.ndarray) -> list[Doubt]:
    """Return a doubt if many pixels share the highest or lowest value, as at the end of a converter's range."""
    known = np.isfinite(height)
    ends = []
    for which, place in (("highest", 1), ("lowest", 0)):
        level = _ends(height, known)[place]
        others = known & (height != level)
        ends.append(
            (which, level, known.sum() - others.sum(), np.count_nonzero(height == _ends(height, others)[place]))
        )
    # heights are clipped if this share of the pixels has the highest or lowest value, and this many times more than the
    # next value
    return [
        Doubt("clipped", {"count": count, "pixels": height.size, "end": which, "level": level})
        for which, level, count, next_count in ends
        if count > max(5e-4 * height.size, 3.0 * next_count)
    ]


def _wrapped(height: np.ndarray) -> list[Doubt]:
    """Return a doubt if neighbours lie at opposite ends of the range and most heights between: an overflow."""
    low = np.nanmin(height)
    high = np.nanmax(height)
    jumps = sum(int((_steps(height, axis) > _WRAPPED_JUMP * (high - low)).sum()) for axis in (0, 1))
    middle = 0.5 * (low + high)
    quarter = 0.25 * (high - low)
    between = np.mean((height > middle - quarter) & (height < middle + quarter))
    if jumps < _FEWEST_WRAPS or between < _BETWEEN_SHARE:
        return []
    return [Doubt("wrapped", {"jumps": jumps, "relief": high - low})]


def _outlying_line(height: np.ndarray, deviations: Callable[[np.ndarray], np.ndarray]) -> tuple[float, int, str, float]:
    """Return the most outlying line's deviation over the median, its number and axis, and the ratio across."""
    worst = []
    for axis, lines in zip("xy", (height, height.T)):
        far = deviations(lines)
        worst.append((np.nanmax(far) / max(np.nanmedian(far), 1e-12), int(np.nanargmax(far)), axis))
    return *max(worst), min(worst)[0]


def _line_jump(height: np.ndarray) -> list[Doubt]:
    """Return a doubt if heights jump between two lines, and not in the other direction."""
    median = np.median if np.isfinite(height).all() else np.nanmedian  # in a third of the time
    ratio, line, axis, across = _outlying_line(
        height, lambda z: np.abs(median(np.diff(z, axis=0), axis=1, overwrite_input=True))
    )
    # a fault is a jump between lines of this many times the median jump, and `_SCAR_RATIO` times any in the other
    # direction
    if ratio < max(10.0, _SCAR_RATIO * across):
        return []
    return [Doubt("jump", {"line": line, "next_line": line + 1, "axis": axis})]


def _scar(height: np.ndarray) -> list[Doubt]:
    """Return a doubt if one line differs from its neighbours, and none in the other direction (unlike debris)."""
    ratio, line, axis, across = _outlying_line(height, _differences_from_neighbours)
    if ratio < _SCAR_RATIO * across:
        return []
    return [Doubt("scar", {"line": line + 1, "axis": axis, "ratio": ratio})]


def _differences_from_neighbours(lines: np.ndarray) -> np.ndarray:
    """Return the rms difference of each line but the outer ones from the mean of its neighbours."""
    differences = lines[:-2] + lines[2:]
    differences *= -0.5
    differences += lines[1:-1]
    np.square(differences, out=differences)
    return np.sqrt(np.nanmean(differences, axis=1))


def _steps(height: np.ndarray, axis: int) -> np.ndarray:
    """Return the absolute differences of neighbouring heights."""
    steps = np.diff(height, axis=axis)
    return np.abs(steps, out=steps)


def _garbled(height: np.ndarray) -> list[Doubt]:
    """Return a doubt if neighbouring heights, or whole lines, are uncorrelated."""
    alike = _neighbour_correlations(height)
    if max(alike) < _LEAST_CORRELATION:
        return [Doubt("noise", {"correlation": max(alike)})]
    if min(alike) < _LEAST_CORRELATION:
        axis = "xy"[alike.index(max(alike))]
        return [Doubt("unrelated lines", {"axis": axis, "correlation": min(alike)})]
    return []


def is_noise(ds: xr.Dataset) -> bool:
    """Return whether neighbouring heights of a scan are uncorrelated, along x and along y."""
    height = ds["height"].values
    return min(height.shape) >= _FEWEST_LINES and max(_neighbour_correlations(height)) < _LEAST_CORRELATION


def _neighbour_correlations(height: np.ndarray) -> list[float]:
    """Return the correlations of neighbouring heights along x and y, those of ranks, which few spikes do not affect."""
    part = np.ascontiguousarray(height[:512, :512])
    order = np.where(np.isfinite(part), part, np.nanmedian(part)).ravel().argsort(kind="stable")
    ranks = np.empty(part.shape)
    ranks.flat[order] = np.linspace(-1, 1, part.size)
    ranks -= ranks.mean()
    pairs = (ranks[1:], ranks[:-1]), (ranks[:, 1:], ranks[:, :-1])
    return [float((first * second).mean() / (ranks**2).mean()) for first, second in pairs]
