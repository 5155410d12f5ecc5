"""The sharpest step of a retraction, a sudden loss of tension; and the smallest pull that would be detected.

The mean force before each sample is compared with the force that a polynomial through the samples after it predicts
there. On the far part of the retraction, where nothing detaches, the same prediction fails by noise, interference and
drift: a step counts if it is so many times as high, beyond any other step of the curve. For near the surface, and in
contact, forces ripple and slip more than far out. Predictions are tried over many widths, as detachments differ.

The smallest detected pull is found on the curve itself: pulls that grow as the curve's own contact does, and end in a
jump, are added at several places of the free part, and their size is bisected.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

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

    heights: np.ndarray  # nN
    error: float
    is_step: np.ndarray  # whether the shape is that of a step
    levels: np.ndarray  # of the force after the steps, extrapolated to them, nN
    ends: np.ndarray  # first samples after the steps


def sharpest_step(force: np.ndarray, noise: float) -> Step | None:
    """Return the most significant step of a retraction, None if none is significant."""
    steps = []
    for heights, error, is_step, levels, ends in _heights_of_all_widths(force, noise):
        rises = np.where(is_step, heights, -np.inf)
        highest = int(np.argmax(rises))
        height = float(rises[highest])
        rises[max(highest - _LENGTH, 0) : highest + _LENGTH + 1] = 0.0
        step = Step(int(ends[highest]), height, error, float(levels[highest]), float(rises.max()))
        if step.height > step.threshold:
            steps.append(step)
    return max(steps, key=lambda step: step.significance, default=None)


def contact_end(force: np.ndarray) -> int:
    """Return the first sample from which the force is no larger than on the far part."""
    width = 8  # samples of a mean
    means = bin_means(force, width)
    above = np.flatnonzero(means > means[int((1 - _FAR) * means.size) :].max())
    return int(above[-1] + 1) * width if above.size else 0


def _heights_of_all_widths(force: np.ndarray, noise: float) -> Iterator[_Heights]:
    """Yield the heights of steps between bins of 1, 2, 4 … samples."""
    width = 1
    while (heights := _heights_of_width(force, noise, width)) is not None:
        yield heights
        width *= 2


def _heights_of_width(force: np.ndarray, noise: float, width: int) -> _Heights | None:
    """Return the heights of steps between bins of so many samples, None if the far part is too short."""
    means = bin_means(force[force.size % width :], width)[::-1]  # far first
    best = None
    for window, degree in _PREDICTORS:
        span = window + _GAP + _FOOT
        if _FAR * means.size < _LEAST_LENGTHS * span:
            continue
        after = sliding_window_view(means, window)[: means.size - span + 1]
        foot = sliding_window_view(means, _FOOT)[window + _GAP :]
        weights = prediction_weights(window, degree, _GAP + (_FOOT + 1) / 2)
        heights = after @ weights - foot.mean(axis=1)
        far = slice(int(_FAR * heights.size))
        white = noise * np.sqrt((float(weights @ weights) + 1 / _FOOT) / width)
        error = max(1.4826 * median(np.abs(heights[far])), -float(heights[far].min()) / _EXTREME, white)
        if best is None or error < best.error:
            levels = after @ prediction_weights(window, degree, (_GAP + 1) / 2)
            is_step = _is_step(after, foot, levels, heights, degree, far)
            ends = force.size - (window + np.arange(heights.size)) * width
            best = _Heights(heights, error, is_step, levels, ends)
    return best


def _is_step(
    after: np.ndarray, foot: np.ndarray, levels: np.ndarray, heights: np.ndarray, degree: int, far: slice
) -> np.ndarray:
    """Return where the force has the shape of a step: sudden, upwards, and as smooth after it as the far part."""
    sudden = levels - foot[:, ::-1] @ prediction_weights(_FOOT, 1, (_GAP + 1) / 2)  # in the middle of the gap
    misfit = ((after @ _residuals(after.shape[1], degree)) ** 2).sum(axis=1)
    is_lower = foot.mean(axis=1) < after[:, -_FOOT:].mean(axis=1)  # not so at the end of a contact, which curves, too
    return is_lower & (sudden > _SUDDEN * heights) & (misfit <= misfit[far].max())


@lru_cache(maxsize=64)
def _residuals(window: int, degree: int) -> np.ndarray:
    """Return the matrix that takes a polynomial of least squares off equidistant values."""
    powers = np.linspace(-1, 1, window)[:, None] ** np.arange(degree + 1)
    return np.eye(window) - powers @ np.linalg.pinv(powers)


def smallest_detected_pull(
    force: np.ndarray, contact: int, noise: float, detected_at: Callable[[np.ndarray], int | None]
) -> float:
    """Return the size (nN) of the smallest pulls that are detected at all places where they are added to a curve.

    The free part begins at sample ``contact``. ``detected_at`` returns the sample at which a pull is detected.
    """
    largest = float(np.ptp(force))
    limit = noise
    for foot in contact + (_PLACES * (force.size - contact)).astype(int):
        if _is_detected(force, contact, noise, foot, limit, detected_at):
            continue
        low = limit
        limit = largest
        while limit > _RESOLUTION * low:
            middle = np.sqrt(low * limit)
            detected = _is_detected(force, contact, noise, foot, middle, detected_at)
            low, limit = (low, middle) if detected else (middle, limit)
    return limit


def _is_detected(
    force: np.ndarray,
    contact: int,
    noise: float,
    foot: int,
    size: float,
    detected_at: Callable[[np.ndarray], int | None],
) -> bool:
    """Return whether a pull of a size that ends before sample ``foot`` is detected there."""
    visible = max(size, 5 * noise)  # in the noise
    length = max(round(_contact_samples(force, contact, visible) * size / visible), 1)
    growth = (np.arange(length) + 0.5) / length  # the jump lies between two samples
    pulled = force.copy()
    pulled[max(foot - length, 0) : foot] -= size * growth[-foot:]
    at = detected_at(pulled)
    return at is not None and abs(foot - at) <= max(length, force.size // 100)


def _contact_samples(force: np.ndarray, contact: int, size: float) -> int:
    """Return the number of samples in which the force in contact falls from twice a size to the size."""
    level = force[contact : contact + 10].mean()  # just after the contact
    twice, once = (np.flatnonzero(force[:contact] > level + times * size) for times in (2, 1))
    return max(int(once[-1] - twice[-1]), 1) if twice.size else max(contact, 1)
