"""The baseline of a force-distance curve: offset, tilt, drift and interference far from the surface.

The baseline is the longest stretch, from the far end, that a straight line fits within the noise. A line with one
interference fringe replaces it if its stretch is at least half as long again. Fits use the means of about 100 bins.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

#: Number of bins of a curve, and smallest number of them in a baseline.
_BINS, _LEAST_BINS = 100, 8

#: Largest deviation of the last bins of a stretch from its line, and of its curvature from 0, in standard deviations.
_THRESHOLD = 4.5

#: Used part of the longest stretch, whose end may contain an undetected weak tension; parts whose lines show the effect
#: of the choice of the stretch; for stretches shorter than the first of these numbers of bins, also these numbers.
_USED, _PARTS, _BEYOND = 0.8, (0.4, 0.6, 1.0), (20, 30)

#: Factor on the largest of these changes, since they are few.
_FEW = 1.5

#: Limits of a fringe: periods in the stretch, bins in a period, and its stretch over that of a line. Below the last
#: number of periods a fringe and a bend cannot be distinguished.
_PERIODS, _PERIOD_BINS, _LONGER, _SURE_PERIODS = 1.5, 6.0, 1.5, 2.5


class Baseline(NamedTuple):
    """A straight line, or one with a fringe, over the piezo's travel, fitted to the part farthest from the surface."""

    end: float  # travel at which this part ends, nm
    centre: float  # mean travel of its bins, nm
    wave: float  # wavenumber of the fringe, rad/nm; 0 without one
    coefficients: np.ndarray  # nN at the centre, nN/nm; amplitudes of the fringe and 0 for its wavenumber
    covariance: np.ndarray
    noise: float = np.nan  # standard deviation of the samples, nN
    others: tuple[Baseline, ...] = ()  # of other stretches

    def columns(self, z: Any) -> np.ndarray:
        """Return the derivatives of the force by the coefficients, and by the wavenumber."""
        x = np.asarray(z, dtype=float)[..., None] - self.centre
        if not self.wave:
            return np.concatenate((np.ones_like(x), x), axis=-1)
        sine, cosine = np.sin(self.wave * x), np.cos(self.wave * x)
        by_wave = x * (self.coefficients[2] * cosine - self.coefficients[3] * sine)
        return np.concatenate((np.ones_like(x), x, sine, cosine, by_wave), axis=-1)

    def at(self, z: Any) -> Any:
        """Return the force of the baseline, nN."""
        return self.columns(z) @ self.coefficients

    def error(self, z: float) -> float:
        """Return the standard error of the baseline by noise, nN."""
        row = self.columns(z)
        return float(np.sqrt(row @ self.covariance @ row))

    def choice(self, z: float) -> float:
        """Return the change of the baseline by other stretches beyond their noise, nN."""
        own = self.error(z) ** 2
        excess = [(self.at(z) - other.at(z)) ** 2 - max(other.error(z) ** 2 - own, 0.0) for other in self.others]
        return _FEW * float(np.sqrt(max(0.0, *excess)))

    def work_error(self, z: np.ndarray) -> float:
        """Return the standard error of the work along a travel, nN nm, due to the line and to the noise."""
        row = np.trapezoid(self.columns(z), z, axis=0)
        return float(np.sqrt(row @ self.covariance @ row + self.noise**2 * (np.diff(z) ** 2).sum()))


def baseline_of(z: np.ndarray, force: np.ndarray, share: float = 1.0) -> Baseline:
    """Return the baseline of a curve, within a share of its travel."""
    order = np.argsort(z, kind="stable")
    z, force = z[order], force[order]
    some = int(np.searchsorted(z, z[0] + share * (z[-1] - z[0]), side="right"))
    width = max(1, z.size // _BINS)
    bins = max(some // width, 4)
    mean_z, mean_force = (values[: bins * width].reshape(bins, width).mean(axis=1) for values in (z, force))
    variance = _variance_of_means(force, mean_force, width)
    count = _straight(mean_z, mean_force, variance)
    wave, longer = _fringe(mean_z, mean_force, variance, count)
    if wave:
        line, *others = (
            _fitted_fringe(mean_z, mean_force, variance, part, wave) for part in (longer, int(0.8 * longer))
        )
        if wave * (line.end - z[0]) < 2 * np.pi * _SURE_PERIODS:
            others.append(_fitted_line(mean_z, mean_force, variance, min(max(count, 4), bins)))
    else:
        parts = [int(part * count) for part in (_USED, *_PARTS)] + [n for n in _BEYOND if count < _BEYOND[0] <= bins]
        line, *others = (_fitted_line(mean_z, mean_force, variance, min(max(part, 4), bins)) for part in parts)
    far = z <= line.end
    off = force[far] - line.at(z[far])
    noise = float(np.sqrt((off**2).sum() / max(off.size - len(line.coefficients), 1)))
    return line._replace(noise=noise, others=tuple(others))


def _variance_of_means(force: np.ndarray, means: np.ndarray, width: int) -> float:
    """Return the variance of bin means, from second differences, which a slow bend does not raise."""
    bend = np.abs(np.diff(means[: 3 * _LEAST_BINS], 2))
    samples = np.abs(np.diff(force[: 3 * _LEAST_BINS * width], 2))
    robust = [np.median(each) / 0.6745 / np.sqrt(6) for each in (bend, samples)]
    rounding = 1e-12 * float(np.ptp(force)) ** 2
    return float(max(robust[0] ** 2, robust[1] ** 2 / width, rounding, 1e-300))


def _straight(z: np.ndarray, force: np.ndarray, variance: float) -> int:
    """Return the number of bins, from the far end, that a straight line fits without a bend and to their end."""
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


def _fringe(z: np.ndarray, force: np.ndarray, variance: float, straight: int) -> tuple[float, int]:
    """Return the wavenumber of a fringe and its number of bins; 0 where a line fits nearly as many."""
    step, shortest = np.ptp(z) / (z.size - 1), int(max(2 * _LEAST_BINS, _LONGER * straight))
    if shortest > z.size:
        return 0.0, straight
    for count in np.unique(np.geomspace(shortest, z.size, 8).astype(int))[::-1].tolist():
        length = count * step
        wavenumbers = np.arange(2 * np.pi * _PERIODS / length, 2 * np.pi / (_PERIOD_BINS * step), 0.5 / length)
        phase = wavenumbers[:, None] * (z[:count] - z[:count].mean())
        design = np.stack((np.ones_like(phase), phase, np.sin(phase), np.cos(phase)), -1)
        turned = design.transpose(0, 2, 1)
        fitted = np.linalg.solve(turned @ design, turned @ force[:count, None])
        squares = ((force[:count] - (design @ fitted)[..., 0]) ** 2).sum(axis=1)
        if not squares.min() < 30 * variance * count:
            continue
        line = _fitted_fringe(z, force, variance, count, float(wavenumbers[np.argmin(squares)]))
        off = force[:count] - line.at(z[:count])
        ends = all(
            abs(off[-n:].mean()) < _THRESHOLD * np.sqrt(variance / n) for n in (1, 2, count // 8 + 1, count // 4)
        )
        if ends and (off**2).sum() < variance * (count - 5) * (1 + 5 * np.sqrt(2 / (count - 5))):
            return line.wave, count
    return 0.0, straight


def _fitted_line(z: np.ndarray, force: np.ndarray, variance: float, count: int) -> Baseline:
    """Return the straight line through the first bins."""
    centre = float(z[:count].mean())
    line = Baseline(float(z[count - 1]), centre, 0.0, np.zeros(2), np.zeros((2, 2)))
    return _solved(line, z[:count], force[:count], variance)


def _fitted_fringe(z: np.ndarray, force: np.ndarray, variance: float, count: int, wave: float) -> Baseline:
    """Return the line with a fringe through the first bins, its wavenumber refined by a few Newton steps."""
    z, force = z[:count], force[:count]
    for _ in range(6):
        line = Baseline(float(z[-1]), float(z.mean()), wave, np.zeros(5), np.zeros((5, 5)))
        linear = line.columns(z)[:, :4]
        own = np.linalg.lstsq(linear, force, rcond=None)[0]
        line = line._replace(coefficients=np.append(own, 0.0))
        change = np.linalg.lstsq(line.columns(z), force, rcond=None)[0][4]
        wave += float(np.clip(change, -0.2 / np.ptp(z), 0.2 / np.ptp(z)))
    return _solved(line, z, force, variance)


def _solved(line: Baseline, z: np.ndarray, force: np.ndarray, variance: float) -> Baseline:
    """Return the baseline with its coefficients and their covariance."""
    design = line.columns(z)
    coefficients = line.coefficients
    if not line.wave:
        coefficients = np.linalg.lstsq(design, force, rcond=None)[0]
    off = force - design @ coefficients
    scatter = max(variance, float((off**2).sum() / max(off.size - len(coefficients), 1)))
    scale = np.abs(design).max(axis=0)
    inverse = np.linalg.inv((design / scale).T @ (design / scale)) / np.outer(scale, scale)
    return line._replace(coefficients=coefficients, covariance=scatter * inverse)


def recorded_curves(recorded: xr.Dataset, contact_points: np.ndarray, share: float) -> xr.Dataset:
    """Return all curves on one axis of distances."""
    branches = recorded["branch"].values.tolist() if "branch" in recorded.dims else ["retraction"]
    shape = (recorded.sizes["subregion"], len(branches), recorded.sizes["sample"])
    distance = contact_points[:, None, None] - recorded["piezo"].values.reshape(shape)
    force = recorded["force"].values.reshape(shape)
    axis = _distances(distance)
    values = [[_baseline_on(axis, *both, share) for both in zip(*curve)] for curve in zip(distance, force)]
    coords = {"branch": branches, "piezo_distance": axis}
    made = np.array(values).reshape(*shape[:2], axis.size)
    return xr.Dataset({"force": (("subregion", "branch", "piezo_distance"), made)}, coords)


def _distances(distance: np.ndarray) -> np.ndarray:
    """Return distances from the most pressed to the farthest, in the step of the samples."""
    known = distance[np.isfinite(distance)]
    if known.size == 0:
        return np.empty(0)
    steps = np.abs(np.diff(distance, axis=-1))
    step = float(np.median(steps[np.isfinite(steps) & (steps > 0)]))
    return step * np.arange(np.ceil(known.min() / step), np.floor(known.max() / step) + 1)


def _baseline_on(axis: np.ndarray, distance: np.ndarray, force: np.ndarray, share: float) -> np.ndarray:
    """Return one branch less its own baseline, interpolated between its samples; NaN beyond them."""
    good = np.isfinite(distance) & np.isfinite(force)
    if good.sum() < 10:
        return np.full(axis.size, np.nan)
    order = np.argsort(distance[good], kind="stable")
    distance, force = distance[good][order], force[good][order]
    flat = force - baseline_of(-distance, force, share).at(-distance)
    return np.interp(axis, distance, flat, left=np.nan, right=np.nan)
