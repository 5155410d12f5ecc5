"""Samples that are limits: the bounds of their statistics, and likelihoods with censoring.

A limit states that a value lies between two ends, such as 0 and the largest pull-off force that a curve allows. Mean
and quantiles grow with every value, so that their bounds are those of all lower and of all upper ends; the standard
deviation is least with the values nearest to their mean, and largest with each at one of its ends.

The likelihood takes the samples as drawn from one law with a shape and a scale. Its intervals are the extremes of a
statistic where the likelihood is high enough, by any of the laws that explain the samples nearly as well as the best
(Meeker & Escobar, Statistical Methods for Reliability Data, 1998, chapter 8), of as many samples as are independent.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .laws import LAWS, Law, fitted_parameters, log_likelihood

#: Statistic that is the standard deviation over the mean.
RELATIVE_STD = "relative_std"

#: Grid of the likelihood: points along each parameter, and its half width over that of a parameter's error.
_POINTS = 41
_GRID_ERRORS = 7.0


class CensoredEstimates(NamedTuple):
    """Statistics by the law of highest likelihood, and the ends of their intervals; NaN without a law."""

    law: str
    values: np.ndarray  # (3, statistics): estimate, low, high


def finite_ends(bounds: np.ndarray) -> np.ndarray:
    """Return bounds with 1e100 for infinity, whose share in sums and roots exceeds 1e60, see `with_infinity`."""
    return np.where(np.isinf(bounds), 1e100, bounds)


def with_infinity(ends: np.ndarray) -> np.ndarray:
    """Return results of `finite_ends` with infinity where they depend on it."""
    return np.where(np.abs(ends) > 1e60, np.inf, ends)


def least_spread_values(bounds: np.ndarray) -> np.ndarray:
    """Return the values within bounds that have the least standard deviation."""
    low, high = bounds
    smallest = float(low.min())
    largest = float(high.max())
    for _ in range(60):
        middle = (smallest + largest) / 2
        is_low = np.clip(middle, low, high).mean() < middle
        smallest, largest = (smallest, middle) if is_low else (middle, largest)
    return np.clip((smallest + largest) / 2, low, high)


def most_spread_values(bounds: np.ndarray) -> np.ndarray:
    """Return the values within bounds that have the largest standard deviation: ends farthest from their mean."""
    low, high = bounds
    middles = np.unique(low + high) / 2
    middles = middles[:: max(middles.size // _POINTS, 1)]
    candidates = [np.where(low + high < 2 * middle, low, high) for middle in (-np.inf, *middles, np.inf)]
    return max(candidates, key=np.std)


def likelihood_estimates(
    bounds: np.ndarray, labels: list[str], independent: float, confidence: float
) -> CensoredEstimates:
    """Return statistics by a likelihood with censoring, of the positive law that explains the samples best."""
    missing = CensoredEstimates("", np.full((3, len(labels)), np.nan))
    if not _determine_a_law(bounds):
        return missing
    fits = {name: fitted_parameters(law, bounds) for name, law in LAWS.items() if law.positive}
    likelihoods = {name: float(log_likelihood(LAWS[name], fit, bounds)) for name, fit in fits.items()}
    best = max(likelihoods, key=lambda name: likelihoods[name])
    drop = _largest_drop(bounds, independent, confidence)
    possible = [name for name in fits if likelihoods[name] > likelihoods[best] - drop]
    if not possible:
        return missing
    shape, _, scale = fits[best]
    estimates = [_law_statistic(LAWS[best], shape, scale, label) for label in labels]
    ends = np.array([_profile_ends(LAWS[name], fits[name], bounds, labels, independent, drop) for name in possible])
    law_names = LAWS[best].words + "".join(f" (or {LAWS[name].words})" for name in possible if name != best)
    return CensoredEstimates(law_names, np.array([estimates, ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)]))


def limited_median(bounds: np.ndarray, independent: float) -> tuple[float, float]:
    """Return the median of a log-normal law by its likelihood, and its logarithm's standard error; NaN if unknown."""
    if not _determine_a_law(bounds):
        return np.nan, np.nan
    law = LAWS["log_normal"]
    fit = fitted_parameters(law, bounds)
    drop = 0.5 * bounds.shape[1] / independent  # one standard error
    low, high = _profile_ends(law, fit, bounds, ["q50"], independent, drop)[:, 0]
    return float(fit[2]), float(np.log(high / low)) / 2


def _known_values(bounds: np.ndarray) -> np.ndarray:
    """Return the samples that are no limits."""
    return bounds[0][bounds[0] == bounds[1]]


def _determine_a_law(bounds: np.ndarray) -> bool:
    """Return whether enough samples are known, and positive, for a positive law."""
    exact_values = _known_values(bounds)
    # smallest number of different known values that determine a law
    return np.unique(exact_values).size >= 3 and bool(exact_values.min() > 0)


def _largest_drop(bounds: np.ndarray, independent: float, confidence: float) -> float:
    """Return the drop of the logarithm of the likelihood at the ends of an interval."""
    from scipy.stats import t

    return t.ppf(0.5 + confidence / 2, max(independent - 1, 1)) ** 2 / 2 * bounds.shape[1] / independent


def _law_statistic(law: Law, shape: Any, scale: Any, label: str) -> Any:
    """Return a statistic of a law, proportional to its scale but for the relative standard deviation."""
    frozen = law.scipy(shape)
    if label == RELATIVE_STD:
        return frozen.std() / frozen.mean() * np.ones_like(scale)
    if label in ("mean", "std"):
        return scale * getattr(frozen, label)()
    return scale * frozen.ppf(float(label.removeprefix("q")) / 100)


def _profile_ends(
    law: Law, fit: tuple[float, ...], bounds: np.ndarray, labels: list[str], independent: float, drop: float
) -> np.ndarray:
    """Return the ends (2, statistics) of statistics where the likelihood is high enough.

    The grid's axes are the logarithms of the shape and of the quantile that the known samples show, which the samples
    determine well for any shape.
    """
    shape, _, scale = fit
    exact_values = _known_values(bounds)
    below = (bounds[1] < np.median(exact_values)).mean()
    level = float(np.clip(below, 0.05, 0.95))
    reach = _GRID_ERRORS / np.sqrt(exact_values.size * independent / bounds.shape[1])
    shapes = shape * np.exp(np.linspace(-reach, reach, _POINTS))
    quantile = scale * law.scipy.ppf(level, shape)
    # smallest spread of a logarithm for the width of the grid
    width = reach * max(float(np.log(exact_values).std()), 0.2)
    quantiles = quantile * np.exp(np.linspace(-width, width, _POINTS))
    ends = []
    with np.errstate(over="ignore", invalid="ignore"):
        scales = quantiles[:, None] / law.scipy.ppf(level, shapes)
        likelihood = np.array([log_likelihood(law, (shapes, 0.0 * shapes, row), bounds) for row in scales])
        is_allowed = likelihood > likelihood.max() - drop
        for label in labels:
            allowed = _law_statistic(law, shapes, scales, label)[is_allowed]
            allowed = np.where(np.isnan(allowed), np.inf, allowed)  # of a law so wide that its moments overflow
            ends.append((allowed.min(), allowed.max()))
    return np.array(ends).T
