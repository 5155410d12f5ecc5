"""Offset between measured and predicted places: the shift of best correlation.

Zero-normalised cross-correlation of normal scores over common pixels, at all shifts at once (Padfield, IEEE Trans.
Image Process. 21 (2012) 2706). The p-value accounts for the number of independent shifts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..statistics.places import correlogram, independent_places, mean_spacing, normal_scores
from ..statistics.sampling import Samples

#: Largest offset along each axis, as a share of the prediction's extent.
_FARTHEST = 0.25

#: Least number of common places for a correlation.
_FEWEST = 9


class Grid(NamedTuple):
    """A prediction on a grid of places."""

    first: np.ndarray  # x and y of the first place, nm
    steps: np.ndarray  # along x and y, nm
    values: np.ndarray  # (x, y), NaN where nothing is known


class Match(NamedTuple):
    """A shift, nm, to be added to measured places, and the correlation there."""

    shift: tuple[float, float]
    predicted: np.ndarray  # at each measured place, NaN beyond the prediction
    correlation: float  # of the normal scores of both
    p_value: float  # of such a correlation arising by chance at any of the shifts


def best_match(predicted: Samples, measured: Samples) -> Match | None:
    """Return the prediction at the measured places after the best shift; None if places have too little in common.

    A prediction that is not on a grid must be at the measured places.
    """
    grid = _grid(predicted)
    shift = (0.0, 0.0)
    tried = 1.0
    if grid is None:
        if predicted.places.shape != measured.places.shape or not np.allclose(predicted.places, measured.places):
            return None
        at_measured = predicted.values
    else:
        best = _best_shift(grid, measured)
        if best is None:
            return None
        shift, tried = best
        at_measured = _interpolated(grid, measured.places + np.asarray(shift))
    both = np.isfinite(at_measured)
    if both.sum() < _FEWEST:
        return None
    scores = normal_scores(at_measured[both]), normal_scores(measured.values[both])
    varied = np.ptp(at_measured[both]) and np.ptp(measured.values[both])
    correlation = float(np.corrcoef(*scores)[0, 1]) if varied else 0.0
    independent = _independent_pairs(*scores, measured.places[both])
    return Match(shift, at_measured, correlation, _p_value(correlation, independent, tried))


def _grid(predicted: Samples) -> Grid | None:
    """Return samples on a uniform grid as a map, None for others."""
    axes = [np.unique(np.round(axis, 6)) for axis in predicted.places.T]
    if any(axis.size < 2 or not np.allclose(np.diff(axis), axis[1] - axis[0], rtol=1e-4) for axis in axes):
        return None
    first, steps = (np.array(ends) for ends in zip(*((axis[0], axis[1] - axis[0]) for axis in axes)))
    values = np.full([axis.size for axis in axes], np.nan)
    values[tuple(np.rint((predicted.places - first) / steps).astype(int).T)] = predicted.values
    return Grid(first, steps, values)


def _independent_pairs(first: np.ndarray, second: np.ndarray, places: np.ndarray) -> float:
    """Return the effective number of pairs of two correlated fields, n² / Σᵢⱼ ρ₁(dᵢⱼ) ρ₂(dᵢⱼ).

    Bartlett, J. R. Stat. Soc. 98 (1935) 536; Clifford, Richardson & Hémon, Biometrics 45 (1989) 123.
    """
    first_scales = correlogram(first, places)
    other = correlogram(second, places)
    alike = np.cumprod((first_scales.correlation > 0) & (other.correlation > 0)).astype(bool)
    common = (first_scales.pairs * first_scales.correlation * other.correlation)[alike].sum()
    return float(np.clip(first.size**2 / (first.size + 2 * common), 1.0, first.size))


def _p_value(correlation: float, independent: float, tried: float) -> float:
    """Return the p-value of the best correlation among independent shifts, by Fisher's transform."""
    from scipy.stats import norm

    if independent <= 3:
        return 1.0
    single = norm.sf(np.arctanh(min(correlation, 1 - 1e-12)) * np.sqrt(independent - 3))
    return float(min(1.0, tried * single))


def _interpolated(grid: Grid, places: np.ndarray) -> np.ndarray:
    """Return the map interpolated at places, NaN outside it and next to missing values."""
    from scipy.ndimage import map_coordinates

    at = (places - grid.first) / grid.steps
    inside = np.clip(at, 0, np.array(grid.values.shape) - 1)  # guards against rounding only
    near = (np.abs(inside - at) < 1e-6).all(axis=1)
    return np.where(near, map_coordinates(grid.values, inside.T, order=1), np.nan)


def _best_shift(grid: Grid, measured: Samples) -> tuple[tuple[float, float], float] | None:
    """Return the shift, nm, of the largest correlation, and the number of independent shifts that were tried."""
    origin = measured.places.min(axis=0)
    (scores, present) = _binned(measured, grid.steps)
    known = np.isfinite(grid.values)
    own = np.zeros(grid.values.shape)
    own[known] = normal_scores(grid.values[known])
    correlation, overlap = _correlations(own, known, scores, present)
    start = (origin - grid.first) / grid.steps  # of the measured map, in steps of the grid
    lags = [np.arange(n) - (m - 1) for n, m in zip(correlation.shape, scores.shape)]
    shifts = [(lag - first) * step for lag, first, step in zip(lags, start, grid.steps)]
    reach = _FARTHEST * grid.steps * grid.values.shape
    allowed = (np.abs(shifts[0]) <= reach[0])[:, None] & (np.abs(shifts[1]) <= reach[1])
    allowed &= overlap >= max(_FEWEST, 0.25 * min(known.sum(), present.sum()))
    if not allowed.any():
        return None
    i, j = map(int, np.unravel_index(np.argmax(np.where(allowed, correlation, -2)), correlation.shape))
    peaks = _vertex(correlation[:, j], i), _vertex(correlation[i], j)
    x, y = (float(shift[k] + step * peak) for shift, k, step, peak in zip(shifts, (i, j), grid.steps, peaks))
    each = mean_spacing(measured.places) ** 2 * measured.values.size  # area of an independent place
    each /= independent_places(measured.values, measured.places)
    return (x, y), max(1.0, 4 * reach.prod() / each)


def _binned(measured: Samples, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the measured places' mean normal scores on a grid of the prediction's steps, and a mask of known ones."""
    cell = np.rint((measured.places - measured.places.min(axis=0)) / steps).astype(int)
    count = np.zeros(cell.max(axis=0) + 1)
    total = np.zeros(count.shape)
    np.add.at(count, tuple(cell.T), 1)
    np.add.at(total, tuple(cell.T), normal_scores(measured.values))
    return total / np.maximum(count, 1), count > 0


def _correlations(first, first_known, second, second_known) -> tuple[np.ndarray, np.ndarray]:
    """Return, at every shift of the second map, the correlation over pixels known in both, and their number."""
    from scipy.signal import correlate

    def cross_correlate(a, b):
        return correlate(np.asarray(a, float), np.asarray(b, float), method="fft")

    a = first * first_known
    b = second * second_known
    m = first_known
    n = second_known
    count = np.maximum(np.rint(cross_correlate(m, n)), 0)
    some = np.maximum(count, 1)
    sums = cross_correlate(a, n), cross_correlate(m, b)
    covariance = cross_correlate(a, b) - sums[0] * sums[1] / some
    variances = cross_correlate(a**2, n) - sums[0] ** 2 / some, cross_correlate(m, b**2) - sums[1] ** 2 / some
    scale = np.sqrt(np.maximum(variances[0], 0) * np.maximum(variances[1], 0))
    return np.divide(covariance, scale, out=np.zeros_like(scale), where=scale > 1e-6 * some), count


def _vertex(line: np.ndarray, k: int) -> float:
    """Return the vertex of the parabola through a peak and its neighbours, in steps from the peak."""
    if not 0 < k < line.size - 1:
        return 0.0
    before, peak, after = line[k - 1 : k + 2]
    bend = before - 2 * peak + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0
