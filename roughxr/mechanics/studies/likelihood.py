"""Fit one quantity so that predicted and measured forces have equal mean logarithms.

Logarithms of forces are taken as normal. The likelihood's interval contains the values of the quantity for which the
two means differ by no more than

    t √(s²/n + σ²/m + ε²)

with the spreads s and σ over n measured and m predicted independent places, ε the error common to all places, and
Student's t for Welch's number of degrees of freedom. The fit and both ends of its interval are roots on the logarithm
of the quantity, each solved until a solved value is near it. Differences in the shape of the distributions are
reported, not fitted.

Measured forces that are known by their limits are censored: the mean of the logarithms and its error are then those of
a likelihood with a log-normal law. With fewer than three known forces, only the upper end of the interval is fitted, as
if each force were at its limit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..statistics.censoring import limited_median
from ..statistics.places import independent_places
from ..statistics.sampling import Samples, without_weights
from ..vocabulary.refusal import Refusal

#: Quantiles whose distance and spread are reported, without tails of few places.
_LEVELS = np.linspace(0.05, 0.95, 19)

#: Factor on a fixed quantity, to determine its effect on the fitted value.
CHANGE = 1.2

#: Largest number of solved values.
_MOST_VALUES = 14

#: Longest step beyond the solved values (ln).
_LONGEST_STEP = np.log(4.0)

#: Largest distance of a root from a solved value (ln).
_CLOSE_ENOUGH = 0.05

#: Range of the values that are tried, over the first value (ln).
_FARTHEST = -np.log(1e3), np.log(1e3)


class Predicted(NamedTuple):
    """Forces at all places for one value of the quantity, and their common relative error."""

    forces: Samples
    error: float = 0.0


class Measured(NamedTuple):
    """Logarithms of measured forces: mean, its variance by scatter, number of independent ones, and quantiles."""

    mean: float
    variance: float
    independent: float
    quantiles: np.ndarray  # NaN if some forces are limits
    is_upper_bound: bool = False  # the forces are at most as large


class Fitted(NamedTuple):
    """The fitted value and its interval; NaN beyond the values that could be solved."""

    value: float
    low: float
    high: float
    exponent: float  # d ln force / d ln value at the fit
    spread_ratio: float  # measured over predicted
    mean: float  # of the logarithms of the forces at the fit
    values: np.ndarray  # solved
    distance: np.ndarray  # of the distributions at each of them
    left_out: tuple[float, ...]  # values that could not be solved


def fit_mean(
    forces: Samples, predict: Callable[[float], Predicted], start: float, *, confidence: float, error: float
) -> Fitted:
    """Return the value whose predicted forces agree in the mean, with its interval."""
    search = _Search(_log_forces(without_weights(forces, "fit_pair")), predict, confidence, error)
    search.solve(np.log(start), required=True)
    gap = -float(search.difference[0])
    search.solve(np.log(start) + float(np.clip(gap if abs(gap) > _CLOSE_ENOUGH else np.log(1.5), *_FARTHEST)))
    if search.measured.is_upper_bound:
        return search.fitted(np.nan, -np.inf, search.root(-1.0))
    best = search.root(0.0)
    low, high = (search.root(sign) if np.isfinite(best) else np.nan for sign in (1.0, -1.0))
    return search.fitted(best, low, high)


def _log_forces(forces: Samples) -> Measured:
    """Return what is fitted of the measured forces."""
    independent = _independent(forces)
    if forces.bounds is None or forces.censored is None:
        ln_force = np.log(forces.values)
        return Measured(ln_force.mean(), ln_force.var(ddof=1) / independent, independent, _ln_quantiles(ln_force))
    unknown = np.full(_LEVELS.size, np.nan)
    if np.isinf(forces.bounds).any():
        raise Refusal("measured", "forces or upper limits", "lower limits", "increase the detector's range")
    median, error = limited_median(forces.censored, independent)
    if np.isnan(median):
        ln_limit = np.log(forces.bounds[1])
        return Measured(ln_limit.mean(), ln_limit.var(ddof=1) / independent, independent, unknown, True)
    return Measured(np.log(median), error**2, independent, unknown)


class _Search:
    """The solved values of the quantity, as logarithms, and the comparison of their forces."""

    def __init__(self, measured: Measured, predict, confidence: float, error: float):
        self.measured = measured
        self.predict = predict
        self.confidence = confidence
        self.error = error
        self.known: dict[float, Predicted] = {}
        self.failed: list[float] = []

    def solve(self, x: float, required: bool = False) -> None:
        """Predict the forces at a value, and keep the values in ascending order."""
        try:
            self.known = dict(sorted({**self.known, x: self.predict(float(np.exp(x)))}.items()))
        except Refusal:  # such as a contact beyond the scan's edge: other values can be fitted
            if required:
                raise
            self.failed.append(x)

    @property
    def x(self) -> np.ndarray:
        """The solved values."""
        return np.array(list(self.known))

    @property
    def predicted(self) -> np.ndarray:
        """Logarithms of the predicted forces, (values, places)."""
        return np.log([known.forces.values for known in self.known.values()])

    @property
    def difference(self) -> np.ndarray:
        """Predicted less measured mean logarithm."""
        return self.predicted.mean(axis=-1) - self.measured.mean

    def half_width(self) -> np.ndarray:
        """Return the half width of the interval of the difference, at each value."""
        from scipy.stats import t

        places = _independent(next(iter(self.known.values())).forces)
        own = self.measured.variance
        theirs = self.predicted.var(axis=-1, ddof=1) / places
        shared = np.nan_to_num([known.error for known in self.known.values()])
        whole = own + theirs + self.error**2 + shared**2
        freedom = whole**2 / np.maximum(own**2 / (self.measured.independent - 1) + theirs**2 / (places - 1), 1e-30)
        return t.ppf(0.5 + self.confidence / 2, np.minimum(freedom, 1e6)) * np.sqrt(whole)

    def root(self, sign: float) -> float:
        """Return the value at which the difference plus ``sign`` times its half width is 0, NaN if unreached."""
        first = next(iter(self.known))
        while True:
            x = self._guess(self.difference + sign * self.half_width())
            near = float(self.x[np.argmin(np.abs(self.x - x))])
            blocked = [value for value in self.failed if min(near, x) <= value <= max(near, x)]
            if blocked:  # stay clear of values that could not be solved
                x = 0.5 * (near + min(blocked, key=lambda value: abs(value - near)))
            if abs(x - near) <= _CLOSE_ENOUGH:
                return np.nan if blocked else x
            if len(self.known) + len(self.failed) >= _MOST_VALUES or not _FARTHEST[0] <= x - first <= _FARTHEST[1]:
                return np.nan
            self.solve(x)

    def _guess(self, y: np.ndarray) -> float:
        """Return the root of a function of the solved values, interpolated or extrapolated linearly."""
        x = self.x
        k = int(np.argmin(np.abs(y)))
        crossings = np.flatnonzero(np.diff(np.sign(y)) != 0)
        if crossings.size:
            k = int(crossings[np.argmin(np.abs(y[crossings]))])
            return float(x[k] - y[k] * (x[k + 1] - x[k]) / (y[k + 1] - y[k]))
        slope = max(np.polyfit(x, y, 1)[0], 0.1) if x.size > 1 else 1.0
        return float(x[k] - np.clip(y[k] / slope, -_LONGEST_STEP, _LONGEST_STEP))

    def fitted(self, best: float, low: float, high: float) -> Fitted:
        """Return the fit with its interval, and the distance of the distributions."""
        k = int(np.argmin(np.abs(self.x - best))) if np.isfinite(best) else int(np.argmin(np.abs(self.difference)))
        measured = self.measured.quantiles
        predicted = _ln_quantiles(self.predicted)
        slopes = np.gradient(self.difference, self.x) if len(self.known) > 1 else [np.nan]
        return Fitted(
            value=float(np.exp(best)),
            low=float(np.exp(low)),
            high=float(np.exp(high)),
            exponent=float(slopes[k]),
            spread_ratio=float(measured.std() / predicted[k].std()) if predicted[k].std() > 1e-12 else np.nan,
            mean=float(self.measured.mean),
            values=np.exp(self.x),
            distance=np.sqrt(np.mean((predicted - measured) ** 2, axis=-1)),
            left_out=tuple(np.exp(sorted(self.failed))),
        )


def _ln_quantiles(ln_values: np.ndarray) -> np.ndarray:
    """Return the quantiles that are compared, along the last axis."""
    return np.log(np.moveaxis(np.quantile(np.exp(ln_values), _LEVELS, axis=-1), 0, -1))


def _independent(forces: Samples) -> float:
    """Return the number of independent places; few places all count."""
    # least number of places whose correlation is estimated; fewer count as independent
    if forces.places is None or forces.values.size < 16 or np.ptp(forces.values) == 0:
        return float(forces.values.size)
    return float(np.clip(independent_places(forces.values, forces.places), 2, forces.values.size))
