"""The baseline of a force-distance curve: offset, tilt and drift far from the surface.

The baseline is the longest stretch from the far end that a straight line fits within the noise. Fits use the means of
about 100 bins.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

#: Number of bins of a curve, and smallest number of them in a baseline.
_BINS, _LEAST_BINS = 100, 8

#: Largest deviation of the last bins of a stretch from its line, and of its curvature from 0, in standard deviations.
_THRESHOLD = 4.5

#: Used part of the longest stretch, whose end may contain an undetected weak tension; other parts, whose lines give the
#: error by the choice of the stretch; and numbers of bins that are also tried for stretches shorter than the first.
_USED, _PARTS, _BEYOND = 0.65, (0.3, 0.5, 0.8, 1.0), (20, 30)

#: Factor on the largest of the changes by other stretches, since there are few.
_FEW = 2.0


class Baseline(NamedTuple):
    """A straight line over the piezo's travel, fitted to the part farthest from the surface."""

    end: float  # travel at which this part ends, nm
    centre: float  # mean travel of its bins, nm
    coefficients: np.ndarray  # nN at the centre, nN/nm
    covariance: np.ndarray
    noise: float = np.nan  # standard deviation of the samples, nN
    others: tuple[Baseline, ...] = ()  # of other stretches

    def columns(self, z: Any) -> np.ndarray:
        """Return the derivatives of the force by the coefficients."""
        x = np.asarray(z, dtype=float)[..., None] - self.centre
        return np.concatenate((np.ones_like(x), x), axis=-1)

    def force(self, z: Any) -> Any:
        """Return the force of the baseline, nN."""
        return self.columns(z) @ self.coefficients

    def error(self, z: float) -> float:
        """Return the standard error of the baseline by noise, nN."""
        row = self.columns(z)
        return float(np.sqrt(row @ self.covariance @ row))

    def choice_error(self, z: float) -> float:
        """Return the change of the baseline by other stretches beyond their noise, nN."""
        own = self.error(z) ** 2
        excess = [(self.force(z) - other.force(z)) ** 2 - max(other.error(z) ** 2 - own, 0.0) for other in self.others]
        return _FEW * float(np.sqrt(max(0.0, *excess)))

    def work_error(self, z: np.ndarray) -> float:
        """Return the standard error of the work along a travel, nN nm, due to the line and to the noise."""
        row = np.trapezoid(self.columns(z), z, axis=0)
        return float(np.sqrt(row @ self.covariance @ row + self.noise**2 * (np.diff(z) ** 2).sum()))


def fitted_baseline(z: np.ndarray, force: np.ndarray, share: float = 1.0) -> Baseline:
    """Return the baseline of a curve, within a share of its travel."""
    order = np.argsort(z, kind="stable")
    z, force = z[order], force[order]
    some = int(np.searchsorted(z, z[0] + share * (z[-1] - z[0]), side="right"))
    width = max(1, z.size // _BINS)
    bins = max(some // width, 4)
    mean_z, mean_force = (values[: bins * width].reshape(bins, width).mean(axis=1) for values in (z, force))
    variance = _variance_of_means(force, mean_force, width)
    count = _straight(mean_z, mean_force, variance)
    parts = [int(part * count) for part in (_USED, *_PARTS)] + [n for n in _BEYOND if count < _BEYOND[0] <= bins]
    line, *others = (_fitted_line(mean_z, mean_force, variance, min(max(part, 4), bins)) for part in parts)
    far = z <= line.end
    off = force[far] - line.force(z[far])
    noise = float(np.sqrt((off**2).sum() / max(off.size - 2, 1)))
    return line._replace(noise=noise, others=tuple(others))


def _variance_of_means(force: np.ndarray, means: np.ndarray, width: int) -> float:
    """Return the variance of bin means from second differences, which a slow bend does not affect."""
    bend = np.abs(np.diff(means[: 3 * _LEAST_BINS], 2))
    samples = np.abs(np.diff(force[: 3 * _LEAST_BINS * width], 2))
    robust = [np.median(each) / 0.6745 / np.sqrt(6) for each in (bend, samples)]
    rounding = 1e-12 * float(np.ptp(force)) ** 2
    return float(max(robust[0] ** 2, robust[1] ** 2 / width, rounding, 1e-300))


def _straight(z: np.ndarray, force: np.ndarray, variance: float) -> int:
    """Return the number of bins from the far end that a straight line fits, without a bend."""
    if z.size < _LEAST_BINS:
        return z.size
    counts = np.arange(_LEAST_BINS, z.size + 1)
    x = (z - z[0]) / np.ptp(z)
    powers = x[:, None] ** np.arange(5)
    sums, products = (np.cumsum(each, axis=0) for each in (powers, powers[:, :3] * force[:, None]))
    moments = sums[counts[:, None, None] - 1, np.add.outer(np.arange(3), np.arange(3))]
    right = products[counts - 1][..., None]
    bend = np.linalg.solve(moments, right)[:, 2, 0]
    off = np.abs(bend) > _THRESHOLD * np.sqrt(variance * np.linalg.inv(moments)[:, 2, 2])
    line = np.linalg.solve(moments[:, :2, :2], right[:, :2])[..., 0]
    for last in (np.ones_like(counts), np.full_like(counts, 2), counts // 8 + 1, counts // 4):
        since = counts - last - 1
        mean_x, mean_force = (
            (each[counts - 1] - np.where(since < 0, 0.0, each[since])) / last for each in (sums[:, 1], products[:, 0])
        )
        off |= np.abs(mean_force - line[:, 0] - line[:, 1] * mean_x) > _THRESHOLD * np.sqrt(variance / last)
    return int(counts[np.argmax(off)] - 1) if off.any() else z.size


def _fitted_line(z: np.ndarray, force: np.ndarray, variance: float, count: int) -> Baseline:
    """Return the straight line through the first bins, with the covariance of its coefficients."""
    z, force, centre = z[:count], force[:count], float(z[:count].mean())
    design = np.c_[np.ones(count), z - centre]
    coefficients = np.linalg.lstsq(design, force, rcond=None)[0]
    scatter = max(variance, float(((force - design @ coefficients) ** 2).sum() / max(count - 2, 1)))
    return Baseline(float(z[-1]), centre, coefficients, scatter * np.diag(1 / (design**2).sum(axis=0)))
