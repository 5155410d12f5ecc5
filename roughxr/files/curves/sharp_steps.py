"""The sharpest step of a retraction, a sudden loss of tension; and the smallest pull that would be detected.

The mean force before each sample is compared with the force that a polynomial through the samples after it predicts
there. On the far part of the retraction, where nothing detaches, the same prediction fails by noise, interference and
drift: a step counts if it is so many times as high, beyond any other step of the curve. For near the surface, and in
contact, forces ripple and slip more than far out. Predictions are tried over many widths, as detachments differ.

The smallest detected pull is found on the curve itself: pulls that grow as the curve's own contact does, and end in a
jump, are added at several places of the free part, and their size is bisected.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from .baselines import bin_means, median, prediction_weights

#: Bins before a step whose mean is its foot, and between the foot and the samples that predict it.
_FOOT = 4
_GAP = 1

#: Numbers of bins that predict the foot, and degrees of polynomials through them.
_PREDICTORS = ((6, 0), (12, 1), (24, 2))

#: Height of a step beyond that of any other step of the curve, over the standard deviation of the far part's.
_SIGNIFICANCE = 5.0

#: Largest of many deviations of white noise, in standard deviations: a wave's kinks are larger.
_EXTREME = 3.5

#: Share of its height that a step has within the gap.
_SUDDEN = 0.5

#: Bins of a step, within which there is no other.
_LENGTH = _FOOT + _GAP + _FOOT

#: Share of the samples, farthest from the surface, that tells the height of steps where nothing detaches.
_FAR = 0.4

#: Smallest length of the far part, in lengths of a step with its predictors: shorter ones show too little of a drift.
_LEAST_LENGTHS = 5

#: Places of added pulls, as shares of the free part; ratio of sizes at which a bisection ends.
_PLACES = np.linspace(0.02, 0.3, 6)
_RESOLUTION = 1.1


class Step(NamedTuple):
    """A sudden loss of tension."""

    first: int  # sample after it
    height: float  # nN
    error: float  # standard deviation of such heights where nothing detaches, nN
    level: float  # of the force after it, extrapolated to it, nN
    rival: float  # height of the next highest step of the curve, nN

    @property
    def significance(self) -> float:
        """The height beyond that of any other step, over its standard deviation."""
        return (self.height - self.rival) / self.error

    @property
    def threshold(self) -> float:
        """The smallest height that other steps and noise do not explain, nN."""
        return self.rival + _SIGNIFICANCE * self.error


class _Heights(NamedTuple):
    """The heights of steps between bins, far first, by the predictor whose error is least."""

    values: np.ndarray  # nN
    error: float
    means: np.ndarray  # of the bins, far first, nN
    window: int  # bins of the predictor
    degree: int  # of its polynomial


def sharpest_step(force: np.ndarray, noise: float) -> Step | None:
    """Return the most significant step of a retraction, None if none is significant."""
    steps = []
    width = 1  # samples of a bin
    while (heights := _heights_of_width(force, noise, width)) is not None:
        if heights.values.max() > _SIGNIFICANCE * heights.error:
            steps.append(_highest_step(heights, force.size, width))
        width *= 2
    significant = (step for step in steps if step.height > step.threshold)
    return max(significant, key=lambda step: step.significance, default=None)


def contact_end(force: np.ndarray) -> int:
    """Return the first sample from which the force is no larger than on the far part."""
    width = 8  # samples of a mean
    means = bin_means(force, width)
    above = np.flatnonzero(means > means[int((1 - _FAR) * means.size) :].max())
    return int(above[-1] + 1) * width if above.size else 0


def _heights_of_width(force: np.ndarray, noise: float, width: int) -> _Heights | None:
    """Return the heights of steps between bins of so many samples, None if the far part is too short."""
    means = bin_means(force[force.size % width :], width)[::-1].copy()
    feet = np.correlate(means, np.full(_FOOT, 1 / _FOOT))
    best = None
    for window, degree in _PREDICTORS:
        span = window + _GAP + _FOOT
        if _FAR * means.size < _LEAST_LENGTHS * span:
            continue
        weights = prediction_weights(window, degree, _GAP + (_FOOT + 1) / 2)
        heights = np.correlate(means[: -_GAP - _FOOT], weights) - feet[window + _GAP :]
        far = heights[: int(_FAR * heights.size)]
        white = noise * np.sqrt((float(weights @ weights) + 1 / _FOOT) / width)
        error = max(1.4826 * median(np.abs(far)), -float(far.min()) / _EXTREME, white)
        if best is None or error < best.error:
            best = _Heights(heights, error, means, window, degree)
    return best


def _highest_step(heights: _Heights, size: int, width: int) -> Step:
    """Return the highest of the steps between bins of ``width`` samples, of ``size`` samples."""
    window = heights.window
    levels = np.correlate(heights.means[: -_GAP - _FOOT], prediction_weights(window, heights.degree, (_GAP + 1) / 2))
    rises = np.where(_is_step(heights, levels), heights.values, -np.inf)
    highest = int(np.argmax(rises))
    height = float(rises[highest])
    rises[max(highest - _LENGTH, 0) : highest + _LENGTH + 1] = 0.0
    end = size - (window + highest) * width
    return Step(end, height, heights.error, float(levels[highest]), float(rises.max()))


def _is_step(heights: _Heights, levels: np.ndarray) -> np.ndarray:
    """Return where the force has the shape of a step: sudden, upwards, and as smooth after it as the far part."""
    values, _, means, window, degree = heights
    feet = np.correlate(means, np.full(_FOOT, 1 / _FOOT))
    # not so at the end of a contact, which curves, too
    is_lower = feet[window + _GAP :] < feet[window - _FOOT : -_GAP - _FOOT]
    # in the middle of the gap
    before = np.correlate(means, prediction_weights(_FOOT, 1, (_GAP + 1) / 2)[::-1])
    sudden = levels - before[window + _GAP :]
    misfits = _misfits(means[: -_GAP - _FOOT], window, degree)
    return is_lower & (sudden > _SUDDEN * values) & (misfits <= misfits[: int(_FAR * values.size)].max())


def _misfits(values: np.ndarray, window: int, degree: int) -> np.ndarray:
    """Return the sums of squares of all so many successive values about their polynomials of least squares."""
    values = values - values[0]  # for the precision of their squares
    misfits = np.correlate(values**2, np.ones(window))
    for polynomial in _orthonormal_polynomials(window, degree):
        misfits -= np.correlate(values, polynomial) ** 2
    return misfits


@lru_cache(maxsize=64)
def _orthonormal_polynomials(window: int, degree: int) -> np.ndarray:
    """Return polynomials of degrees 0, 1 … over equidistant values, as rows."""
    powers = np.linspace(-1, 1, window)[:, None] ** np.arange(degree + 1)
    return np.ascontiguousarray(np.linalg.qr(powers)[0].T)


def smallest_detected_pull(
    force: np.ndarray, contact: int, noise: float, pull_in: Callable[[np.ndarray], Any]
) -> float:
    """Return the size (nN) of the smallest pulls that are detected at all places where they are added to a curve.

    The free part begins at sample ``contact``. ``pull_in`` returns the pull of a curve.
    """
    level = force[contact : contact + 10].mean()  # just after the contact

    def contact_samples(size: float) -> int:
        """Return the number of samples in which the force in contact falls from twice a size to the size."""
        twice, once = (np.flatnonzero(force[:contact] > level + times * size) for times in (2, 1))
        return max(int(once[-1] - twice[-1]), 1) if twice.size else max(contact, 1)

    def is_detected(foot: int, size: float) -> bool:
        """Return whether a pull of a size that ends before sample ``foot`` is detected there."""
        visible = max(size, 5 * noise)  # in the noise
        length = max(round(contact_samples(visible) * size / visible), 1)
        growth = (np.arange(length) + 0.5) / length  # the jump lies between two samples
        pulled = force.copy()
        pulled[max(foot - length, 0) : foot] -= size * growth[-foot:]
        pull = pull_in(pulled)
        return pull.is_measured and abs(foot - pull.lowest) <= max(length, force.size // 100)

    limit = noise
    for foot in contact + (_PLACES * (force.size - contact)).astype(int):
        if is_detected(foot, limit):
            continue
        low = limit
        limit = float(np.ptp(force))
        while limit > _RESOLUTION * low:
            middle = np.sqrt(low * limit)
            low, limit = (low, middle) if is_detected(foot, middle) else (middle, limit)
    return limit
