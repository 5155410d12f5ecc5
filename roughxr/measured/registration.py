"""Offset between measured and predicted places: the shift of best correlation.

Zero-normalised cross-correlation of normal scores over the pixels that both have, at all shifts at once (Padfield, IEEE
Trans. Image Process. 21 (2012) 2706). The p-value accounts for the number of independent shifts.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..statistics.places import correlogram, independent_places, mean_spacing, normal_scores
from ..statistics.sampling import Samples

#: Largest offset along each axis, as a share of the prediction's extent.
_FARTHEST = 0.25


class Grid(NamedTuple):
    """A prediction on a grid of places."""

    x: np.ndarray  # nm, ascending, uniform
    y: np.ndarray
    values: np.ndarray  # (x, y), NaN where nothing is known


class Match(NamedTuple):
    """A shift, nm, to be added to measured places, and the correlation there."""

    x: float
    y: float
    predicted: np.ndarray  # at each measured place, NaN beyond the prediction
    correlation: float  # of the normal scores of both
    p_value: float  # of such a correlation arising by chance at any of the shifts


def grid_of(predicted: Samples) -> Grid | None:
    """Return samples on a uniform grid as a map, else None."""
    if predicted.places is None:
        return None
    axes = [np.unique(np.round(axis, 6)) for axis in predicted.places.T]
    if any(axis.size < 2 or not np.allclose(np.diff(axis), axis[1] - axis[0], rtol=1e-4) for axis in axes):
        return None
    values = np.full([axis.size for axis in axes], np.nan)
    at = [np.rint((place - axis[0]) / (axis[1] - axis[0])).astype(int) for place, axis in zip(predicted.places.T, axes)]
    values[tuple(at)] = predicted.values
    x, y = axes
    return Grid(x, y, values)


def matched(predicted: Samples, measured: Samples, *, shift: tuple[float, float] | None) -> Match:
    """Return the prediction at the measured places after the given or the best shift."""
    grid = grid_of(predicted)
    if grid is None:
        return _at_the_same(predicted, measured)
    tried = 1.0
    if shift is None:
        shift, tried = _best_shift(grid, measured)
    at_measured = _interpolated(grid, measured.places + np.asarray(shift))
    both = np.isfinite(at_measured)
    if both.sum() < 9:
        raise ValueError(
            f"expected at least 9 measured places within the predicted ones, found {both.sum()}; check their x and y"
        )
    scores = normal_scores(at_measured[both]), normal_scores(measured.values[both])
    correlation = (
        float(np.corrcoef(*scores)[0, 1]) if np.ptp(at_measured[both]) and np.ptp(measured.values[both]) else 0.0
    )
    independent = _independent_pairs(*scores, measured.places[both])
    along_x, along_y = map(float, shift)
    return Match(along_x, along_y, at_measured, correlation, _by_chance(correlation, independent, tried))


def _at_the_same(predicted: Samples, measured: Samples) -> Match:
    same = predicted.places.shape == measured.places.shape and np.allclose(predicted.places, measured.places)
    if not same:
        raise ValueError("expected a prediction on a grid of places, or at the measured ones (subregions=measured)")
    scores = normal_scores(predicted.values), normal_scores(measured.values)
    correlation = float(np.corrcoef(*scores)[0, 1])
    independent = _independent_pairs(*scores, measured.places)
    return Match(0.0, 0.0, predicted.values, correlation, _by_chance(correlation, independent, 1.0))


def _independent_pairs(first: np.ndarray, second: np.ndarray, places: np.ndarray) -> float:
    """Return the effective number of pairs of two correlated fields, n² / Σᵢⱼ ρ₁(dᵢⱼ) ρ₂(dᵢⱼ).

    Bartlett, J. R. Stat. Soc. 98 (1935) 536; Clifford, Richardson & Hémon, Biometrics 45 (1989) 123.
    """
    if first.size < 9:
        return float(first.size)
    first_scales, other = correlogram(first, places), correlogram(second, places)
    alike = np.cumprod((first_scales.correlation > 0) & (other.correlation > 0)).astype(bool)
    common = (first_scales.pairs * first_scales.correlation * other.correlation)[alike].sum()
    return float(np.clip(first.size**2 / (first.size + 2 * common), 1.0, first.size))


def _by_chance(correlation: float, independent: float, tried: float) -> float:
    """Return the p-value of the best correlation among independent shifts, by Fisher's transform."""
    from scipy.stats import norm

    if independent <= 3:
        return 1.0
    single = norm.sf(np.arctanh(min(correlation, 1 - 1e-12)) * np.sqrt(independent - 3))
    return float(min(1.0, tried * single))


def _interpolated(grid: Grid, places: np.ndarray) -> np.ndarray:
    """Return the map interpolated at places, NaN beyond it and beside missing values."""
    from scipy.interpolate import RegularGridInterpolator

    steps = np.array([grid.x[1] - grid.x[0], grid.y[1] - grid.y[0]])
    ends = np.array([[grid.x[0], grid.y[0]], [grid.x[-1], grid.y[-1]]])
    inside = np.clip(places, *ends)  # guards against rounding only
    near = (np.abs(inside - places) < 1e-6 * steps).all(axis=1)
    known = RegularGridInterpolator((grid.x, grid.y), grid.values)
    out = np.full(len(places), np.nan)
    out[near] = known(inside[near])
    return out


def _best_shift(grid: Grid, measured: Samples) -> tuple[tuple[float, float], float]:
    """Return the shift, nm, of the largest correlation, and the number of independent shifts that were tried."""
    steps = np.array([grid.x[1] - grid.x[0], grid.y[1] - grid.y[0]])
    coarse = _binned(measured, steps)
    known = np.isfinite(grid.values)
    scores = np.zeros(grid.values.shape)
    scores[known] = normal_scores(grid.values[known])
    correlation, overlap = _correlations(scores, known, *coarse.values)
    start = (coarse.origin - [grid.x[0], grid.y[0]]) / steps  # of the measured map, in steps of the grid
    lags = [np.arange(n) - (m - 1) for n, m in zip(correlation.shape, coarse.values[0].shape)]
    shifts = [(lag - first) * step for lag, first, step in zip(lags, start, steps)]
    reach = _FARTHEST * steps * grid.values.shape
    allowed = (np.abs(shifts[0]) <= reach[0])[:, None] & (np.abs(shifts[1]) <= reach[1])
    allowed &= overlap >= max(9, 0.25 * min(known.sum(), coarse.values[1].sum()))
    if not allowed.any():
        raise ValueError("expected measured places that overlap the predicted ones, found none; check their x and y")
    at = np.unravel_index(np.argmax(np.where(allowed, correlation, -2)), correlation.shape)
    best = [
        shift[k] + step * _vertex(line, k) for shift, step, line, k in zip(shifts, steps, _lines(correlation, at), at)
    ]
    each = (
        measured.values.size * mean_spacing(measured.places) ** 2 / independent_places(measured.values, measured.places)
    )
    return (float(best[0]), float(best[1])), max(1.0, 4 * reach.prod() / each)


class _Binned(NamedTuple):
    origin: np.ndarray  # nm
    values: tuple[np.ndarray, np.ndarray]  # mean scores, and a mask of where there are any


def _binned(measured: Samples, steps: np.ndarray) -> _Binned:
    """Return the mean of the measured places' normal scores on a grid of the prediction's steps."""
    origin = measured.places.min(axis=0)
    cell = np.rint((measured.places - origin) / steps).astype(int)
    shape = tuple(cell.max(axis=0) + 1)
    flat = np.ravel_multi_index(tuple(cell.T), shape)
    count = np.bincount(flat, minlength=np.prod(shape)).reshape(shape)
    total = np.bincount(flat, normal_scores(measured.values), minlength=np.prod(shape)).reshape(shape)
    return _Binned(origin, (total / np.maximum(count, 1), count > 0))


def _correlations(first, first_known, second, second_known) -> tuple[np.ndarray, np.ndarray]:
    """Return, at every shift of the second map, the correlation over pixels known in both, and their number."""
    from scipy.signal import correlate

    def across(a, b):
        return correlate(np.asarray(a, float), np.asarray(b, float), method="fft")

    a, b, m, n = first * first_known, second * second_known, first_known, second_known
    count = np.maximum(np.rint(across(m, n)), 0)
    some = np.maximum(count, 1)
    sums = across(a, n), across(m, b)
    covariance = across(a, b) - sums[0] * sums[1] / some
    variances = across(a**2, n) - sums[0] ** 2 / some, across(m, b**2) - sums[1] ** 2 / some
    scale = np.sqrt(np.maximum(variances[0], 0) * np.maximum(variances[1], 0))
    return np.divide(covariance, scale, out=np.zeros_like(scale), where=scale > 1e-6 * some), count


def _lines(values: np.ndarray, at: tuple) -> tuple[np.ndarray, np.ndarray]:
    return values[:, at[1]], values[at[0], :]


def _vertex(line: np.ndarray, k: Any) -> float:
    """Return the vertex of the parabola through a peak and its neighbours, in steps from the peak."""
    if not 0 < k < line.size - 1:
        return 0.0
    before, peak, after = line[k - 1 : k + 2]
    bend = before - 2 * peak + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0
