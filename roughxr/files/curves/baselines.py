"""The baseline of a retraction: offset, tilt, drift and interference where nothing touches.

A straight line fits the longest stretch from the far end that is straight within the noise. Interference bends it: then
the samples after the jump tell the force that the free cantilever has there, extrapolated to the lowest force by a
polynomial of degree 0 to 2 through the nearest ones. Degree and number of samples are those that predict best all other
places of the free part, and how well they do is the error. Fits use the means of about 100 bins.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

#: Number of bins of a stretch.
_BINS = 100

#: Smallest number of bins in a baseline.
_LEAST_BINS = 8

#: Smallest number of bins through which a line is formed.
_LEAST_COUNT = 4

#: Other parts of the longest stretch, whose lines give the error by its choice.
_PARTS = (0.3, 0.5, 0.8, 1.0)

#: Numbers of bins that are also tried for stretches shorter than the first of them.
_BEYOND = (20, 30)

#: Error of a parabola's third coefficient, in errors of its first, over equidistant values.
_BEND = np.sqrt(5) / 2

#: Numbers of bins, and degrees of polynomials through them, that predict the force at the next bins.
_WINDOWS = (4, 6, 8, 12, 16, 24, 32, 48)
_DEGREES = (0, 1, 2)

#: A step of the force between the means of this many bins counts if it is this many standard deviations high.
_STEP_BINS = 4
_STEP_SIGNIFICANCE = 5.0


class Baseline(NamedTuple):
    """A straight line over the piezo's travel, and its standard errors."""

    centre: float  # travel at which errors of level and tilt are independent, nm
    level: float  # force there, nN
    tilt: float  # nN/nm
    level_error: float
    tilt_error: float
    end: float  # travel at which the used part ends, nm
    longest: float = np.nan  # travel at which the longest straight stretch ends, nm
    noise: float = np.nan  # standard deviation of the samples, nN
    spread: float = 0.0  # half of the difference between two readings of the level, which is their mean, nN

    def force(self, z: Any) -> Any:
        """Return the force of the baseline, nN."""
        return self.level + self.tilt * (z - self.centre)

    def error(self, z: float) -> float:
        """Return the standard error of the baseline, nN."""
        return np.hypot(self.level_error, self.tilt_error * (z - self.centre))


def white_noise(values: np.ndarray) -> float:
    """Return the standard deviation of white noise, from second differences, which a slow bend does not affect."""
    second = values[2:] - 2 * values[1:-1] + values[:-2]
    return median(np.abs(second)) / 0.6745 / np.sqrt(6)


def median(values: np.ndarray) -> float:
    """Return the median, the larger of two middle values; faster than numpy's, which prepares for NaN."""
    middle = values.size // 2
    return float(np.partition(values, middle)[middle])


def line_through(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Return tilt and value at 0 of the straight line of least squares."""
    centre = x.sum() / x.size
    level = y.sum() / y.size
    off = x - centre
    tilt = float(off @ y / (off @ off))
    return tilt, float(level - tilt * centre)


def sample_noise(force: np.ndarray) -> float:
    """Return the standard deviation of white noise; at least that of rounding."""
    return max(white_noise(force), rounding_noise(force))


def rounding_noise(force: np.ndarray) -> float:
    """Return the standard deviation of rounding to the smallest step."""
    steps = np.abs(np.diff(force))
    steps = steps[steps > 1e-9 * np.ptp(force)]
    return float(steps.min()) / np.sqrt(12) if steps.size else 0.0


def straight_baseline(z: np.ndarray, force: np.ndarray, size: int) -> tuple[Baseline, list[Baseline]]:
    """Return the line through the far part of samples, and lines through other stretches of it.

    ``size`` is the number of samples of the whole curve, of which a bin is one part in a hundred.
    """
    order = np.argsort(z, kind="stable")
    z, force = z[order], force[order]
    width = max(1, min(size // _BINS, z.size // (2 * _LEAST_BINS)))
    mean_z, mean_force = (bin_means(values, width) for values in (z, force))
    x = mean_z - z[0]
    variance = _variance_of_means(force, mean_force, width)
    all_lines = _lines_through(x, mean_force, np.arange(_LEAST_COUNT, x.size + 1))
    count = _straight(x, mean_force, variance, all_lines)
    # used part of the longest stretch, whose end may contain an undetected weak tension
    parts = [int(part * count) for part in (0.65, *_PARTS)] + [n for n in _BEYOND if count < _BEYOND[0] <= x.size]
    counts = np.clip(parts, _LEAST_COUNT, x.size)
    lines = _Lines(*(column[counts - _LEAST_COUNT] for column in all_lines))
    level_errors = np.sqrt(np.maximum(variance, lines.misfit) / counts)
    tilt_errors = level_errors / np.sqrt(lines.variance)
    line, *others = map(
        Baseline, z[0] + lines.centre, lines.level, lines.tilt, level_errors, tilt_errors, mean_z[counts - 1]
    )
    far = z <= line.end
    off = force[far] - line.force(z[far])
    noise = np.sqrt((off**2).sum() / max(off.size - 2, 1))
    return line._replace(longest=float(mean_z[count - 1]), noise=noise), others


def with_choice_error(line: Baseline, others: list[Baseline], at: float) -> Baseline:
    """Return a line with errors that contain its change at a travel by other stretches, beyond their noise."""
    variance = line.error(at) ** 2
    excess = [(line.force(at) - other.force(at)) ** 2 - max(other.error(at) ** 2 - variance, 0.0) for other in others]
    # twice the largest of the changes by other stretches, since there are few
    wider = np.sqrt(1 + 4.0 * max(0.0, *excess) / variance)
    return line._replace(level_error=line.level_error * wider, tilt_error=line.tilt_error * wider)


def _variance_of_means(force: np.ndarray, means: np.ndarray, width: int) -> float:
    """Return the variance of bin means, by their own noise and by that of the samples."""
    noise_of_means = white_noise(means[: 3 * _LEAST_BINS])
    noise_of_samples = white_noise(force[: 3 * _LEAST_BINS * width])
    rounding = 1e-12 * np.ptp(force) ** 2
    return float(max(noise_of_means**2, noise_of_samples**2 / width, rounding, 1e-300))


def _straight(x: np.ndarray, force: np.ndarray, variance: float, lines: _Lines) -> int:
    """Return the number of bins from the far end that a straight line fits, without a bend."""
    counts = np.arange(_LEAST_COUNT, x.size + 1)
    deviation = force[counts - 1] - lines.level - lines.tilt * (x[counts - 1] - lines.centre)
    # largest deviation of the last bin of a stretch from its line, and of its bend from 0, in standard deviations
    largest = 4.5 * np.sqrt(variance)
    off = (np.abs(deviation) > largest) | (np.abs(_bends(x, force, counts, lines)) > largest)
    off &= counts >= _LEAST_BINS
    return int(counts[np.argmax(off)] - 1) if off.any() else x.size


def _bends(x: np.ndarray, y: np.ndarray, counts: np.ndarray, lines: _Lines) -> np.ndarray:
    """Return the last coefficient of parabolas through the first values of each count, over its error by that of y."""
    squares = _lines_through(x, x**2, counts)
    covariance = np.cumsum(x**2 * y)[counts - 1] / counts - squares.level * lines.level
    covariance -= squares.tilt * lines.tilt * lines.variance
    return counts * covariance / np.sqrt(np.maximum((counts - 2) * squares.misfit, 1e-300))


def least_error_line(z: np.ndarray, force: np.ndarray, noise: float, at: float, *, shortest: float = 0.15) -> Baseline:
    """Return the line through a stretch from the far end that predicts the force at a travel ``at`` best.

    ``shortest`` is the smallest length of the stretch over that of the samples. Interference about the line counts as
    if its phase there were unknown.
    """
    width = max(1, z.size // _BINS)
    x, y = bin_means(z, width)[::-1], bin_means(force, width)[::-1]
    x = x - x[0]
    # 24 stretches, of which the one with the least error is taken
    counts = np.unique(np.geomspace(max(shortest * x.size, min(_LEAST_BINS, x.size)), x.size, 24).astype(int))
    lines = _lines_through(x, y, counts)
    white = noise**2 / width
    distance = at - bin_means(z, width)[-1] - lines.centre
    interference = np.maximum(lines.misfit - white * (1 + np.sqrt(8 / counts)), 0.0)  # beyond the scatter of noise
    level_variance = white / counts + interference
    variance = level_variance * (1 + distance**2 / lines.variance)
    best = int(np.argmin(variance))
    length = x[counts[best] - 1]
    bend = _BEND * max(3 * (2 * distance[best] / length) ** 2 - 1, 0.0) * np.sqrt(lines.misfit[best] / counts[best])
    level = float(lines.level[best] + lines.tilt[best] * distance[best])
    end = float(length + bin_means(z, width)[-1])
    return Baseline(at, level, float(lines.tilt[best]), np.sqrt(variance[best] + bend**2), 0.0, end, noise=noise)


class _Lines(NamedTuple):
    """Straight lines of least squares through the first values, by their counts."""

    centre: np.ndarray  # mean x
    level: np.ndarray  # mean y
    tilt: np.ndarray
    variance: np.ndarray  # of x
    misfit: np.ndarray  # variance of y about the line


def _lines_through(x: np.ndarray, y: np.ndarray, counts: np.ndarray) -> _Lines:
    """Return the lines through the first values of each count."""
    first = y[0]
    y = y - first  # for the precision of its squares
    sums = np.cumsum([x, x**2, y, x * y, y**2], axis=1)[:, counts - 1] / counts
    variance_x, variance_y = sums[1] - sums[0] ** 2, sums[4] - sums[2] ** 2
    positive = np.maximum(variance_x, 1e-300)
    tilt = (sums[3] - sums[0] * sums[2]) / positive
    misfit = np.maximum(variance_y - tilt**2 * variance_x, 0.0) * counts / np.maximum(counts - 2, 1)
    return _Lines(sums[0], first + sums[2], tilt, positive, misfit)


def extrapolated_level(force: np.ndarray, gap: int, noise: float) -> tuple[float, float]:
    """Return the baseline ``gap`` samples before the first of the free samples, and its standard error; NaN if too few.

    The error is that with which the same polynomial predicts all other places of the free part, ``noise`` taken off.
    """
    width = max(1, force.size // _BINS)
    means = bin_means(force, width)[::-1].copy()  # far first
    variance = noise**2 / width
    distance = (gap + (width - 1) / 2) / width
    ahead = max(1, int(np.ceil(distance)))
    best = (np.nan, np.inf)
    for window in (size for size in _WINDOWS if 2 * size <= means.size and size + ahead < means.size):
        for degree in (degree for degree in _DEGREES if window >= 2 * (degree + 1)):
            weights = _weights_of_misses(window, degree, ahead)
            misses = np.correlate(means, weights)
            error = max(float(misses @ misses) / misses.size - variance, variance * (float(weights @ weights) - 1))
            error *= 1 + window / (means.size - ahead)  # few of the predictions are independent
            if error < best[1]:
                best = float(means[-window:] @ prediction_weights(window, degree, distance)), error
    return best[0], np.sqrt(best[1])


def bin_means(values: np.ndarray, width: int) -> np.ndarray:
    """Return the means of successive bins of so many values; what is left at the end is left out."""
    bins = values.size // width
    return np.add.reduceat(values[: bins * width], np.arange(0, bins * width, width)) / width if bins else values[:0]


@lru_cache(maxsize=4096)
def prediction_weights(window: int, degree: int, ahead: float) -> np.ndarray:
    """Return the weights of equidistant values in a polynomial's value ``ahead`` of the last of them."""
    powers = np.arange(degree + 1)
    x = (np.arange(window)[:, None] - (window - 1)) / window
    return (ahead / window) ** powers @ np.linalg.pinv(x**powers)


@lru_cache(maxsize=4096)
def _weights_of_misses(window: int, degree: int, ahead: int) -> np.ndarray:
    """Return the weights of equidistant values in a polynomial's value ``ahead`` of them, less the value there."""
    return np.r_[prediction_weights(window, degree, ahead), np.zeros(ahead - 1), -1.0]


def last_step(force: np.ndarray, noise: float) -> tuple[int, float]:
    """Return the number of free samples before the last sudden loss of tension, and its height; 0 without."""
    width, m = max(1, force.size // _BINS), _STEP_BINS
    bins = force.size // width
    if bins < 4 * m + _LEAST_BINS:
        return 0, 0.0
    sums = np.cumsum(np.append(0.0, bin_means(force, width)[::-1]))  # far first
    means = (sums[m:] - sums[:-m]) / m
    at = np.arange(2 * m, bins - 2 * m + 1)
    rise = means[at - m] - means[at] - (means[at - 2 * m] - means[at + m]) / 3  # beyond the slope of both sides
    spread = 1.4826 * median(np.abs(rise - median(rise)))
    limit = _STEP_SIGNIFICANCE * max(noise * np.sqrt(20 / (9 * m * width)), spread)
    steps = np.flatnonzero(rise > limit)
    if not steps.size:
        return 0, 0.0
    first = steps[steps < steps[0] + 2 * m]
    highest = first[np.argmax(rise[first])]
    return int(bins - at[highest] + 1) * width, float(1.5 * rise[highest])
