"""Fit one quantity so that predicted and measured forces have the same mean logarithm.

The pull-off of each place is known at a few values of the number, added where they are needed, and interpolated between
them on logarithms (`Emulator`). Logarithms of forces are taken as normal. The likelihood's interval then contains the
values for which the two means differ by no more than

    t √(s²/n + σ²/m + ε²)

with the spreads s and σ over n measured and m predicted independent places, ε the error common to all places, and
Student's t for Welch's number of degrees of freedom. Differences in the shape of the distributions are reported, not
fitted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..statistics.places import independent_places
from ..statistics.sampling import Samples, counted_equally

#: Quantiles whose distance and spread are reported: tails with few places are left out.
_LEVELS = np.linspace(0.05, 0.95, 19)

#: Factor on a fixed quantity, to find how the fitted value depends on it.
CHANGE = 1.2

#: Most values solved; longest step between two values, and largest distance of a solved value from the fit (both ln).
_MOST_VALUES, _LONGEST_STEP, _CLOSE_ENOUGH = 12, np.log(4.0), 0.05

#: The values that are tried: up to so many times the first one, and down to that part of it.
_FARTHEST = 1e3

#: Below this number all places count as independent.
_FEW_PLACES = 16

#: Points at which the interval is evaluated.
_INTERVAL_POINTS = 2001


class Predicted(NamedTuple):
    """Forces at all places for one value of the number, and the relative error that all of them share."""

    forces: Samples
    error: float = 0.0


class Emulator(NamedTuple):
    """Logarithm of each place's force as a function of the logarithm of the fitted quantity."""

    ln_value: np.ndarray  # (values), ascending
    ln_force: np.ndarray  # (values, places)
    error: np.ndarray  # (values), common to all places

    def at(self, x: np.ndarray | float) -> np.ndarray:
        """Return the logarithms of the forces, (…, places)."""
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.ln_value, self.ln_force, axis=0)(x)


class Compared(NamedTuple):
    """What is compared with predictions: logarithms of measured forces, and how many places on both sides count."""

    ln_force: np.ndarray
    error: float  # relative, common to all
    independent: float
    predicted: float  # independent places of the prediction
    confidence: float


class Fitted(NamedTuple):
    """The fitted value and its interval; NaN beyond the solved values."""

    value: float
    low: float
    high: float
    exponent: float  # d ln force / d ln value at the fit
    spread_ratio: float  # measured over predicted
    mean: float  # of the logarithms of the forces at the fit
    values: np.ndarray  # solved
    distance: np.ndarray  # of the distributions at each of them
    left_out: tuple[float, ...]  # values that could not be solved


class _Test(NamedTuple):
    """Difference of the means, and the largest that the interval allows, at many values of the number."""

    x: np.ndarray
    difference: np.ndarray  # predicted less measured, of the mean logarithms
    allowed: np.ndarray
    best: float  # where the means agree, or nearly so
    inside: bool  # whether they agree

    @property
    def accepted(self) -> np.ndarray:
        """Which values lie in the interval."""
        return np.abs(self.difference) <= self.allowed


def ln_quantiles(ln_values: np.ndarray) -> np.ndarray:
    """Return the quantiles that are compared, along the last axis."""
    return np.log(np.moveaxis(np.quantile(np.exp(ln_values), _LEVELS, axis=-1), 0, -1))


def matching(
    forces: Samples, predict: Callable[[float], Predicted], start: float, *, confidence: float, error: float
) -> Fitted:
    """Return the value whose predicted forces, roughly proportional to it, agree in the mean, and its interval."""
    ln_force, first = np.log(counted_equally(forces, "fit_pair").values), predict(start)
    compared = Compared(ln_force, error, _independent(forces), _independent(first.forces), confidence)
    known, failed = {float(np.log(start)): first}, list[float]()
    ends = np.log(start) - np.log(_FARTHEST), np.log(start) + np.log(_FARTHEST)
    gap = float(ln_force.mean() - np.log(first.forces.values).mean())
    guess = gap if abs(gap) > _CLOSE_ENOUGH else np.log(1.5)
    x: float | None = float(np.clip(np.log(start) + guess, *ends))
    while x is not None and len(known) + len(failed) < _MOST_VALUES:
        try:
            known[x] = predict(float(np.exp(x)))
        except ValueError:  # such as a contact beyond the scan's edge: the others can be fitted
            failed.append(x)
        x = _next(known, failed, ends, compared)
    return _fitted(_emulator(known), compared, failed)


def _independent(forces: Samples) -> float:
    """Return the number of independent places; few places show no correlation, and all count."""
    if forces.places is None or forces.values.size < _FEW_PLACES or np.ptp(forces.values) == 0:
        return float(forces.values.size)
    return float(np.clip(independent_places(forces.values, forces.places), 2, forces.values.size))


def _emulator(known: dict[float, Predicted]) -> Emulator:
    x = sorted(known)
    ln_force = np.log([known[value].forces.values for value in x])
    return Emulator(np.array(x), ln_force, np.nan_to_num([known[value].error for value in x]))


def _tested(emulator: Emulator, compared: Compared) -> _Test:
    """Return the difference of the means over the values covered, and the largest that the interval allows."""
    from scipy.stats import t

    x = np.unique(np.r_[np.linspace(emulator.ln_value[0], emulator.ln_value[-1], _INTERVAL_POINTS), emulator.ln_value])
    predicted = emulator.at(x)
    own = compared.ln_force.var(ddof=1) / compared.independent, compared.independent - 1
    theirs = predicted.var(axis=-1, ddof=1) / compared.predicted, compared.predicted - 1
    whole = own[0] + theirs[0] + compared.error**2 + np.interp(x, emulator.ln_value, emulator.error) ** 2
    freedom = whole**2 / np.maximum(own[0] ** 2 / own[1] + theirs[0] ** 2 / theirs[1], 1e-30)
    allowed = t.ppf(0.5 + compared.confidence / 2, np.minimum(freedom, 1e6)) * np.sqrt(whole)
    difference = predicted.mean(axis=-1) - compared.ln_force.mean()
    cross = np.flatnonzero(np.diff(np.sign(difference)) != 0)
    if not cross.size:
        k = int(np.argmin(np.abs(difference)))
        return _Test(x, difference, allowed, float(x[k]), 0 < k < x.size - 1)
    a, b = difference[cross], difference[cross + 1]
    roots = x[cross] + (x[cross + 1] - x[cross]) * a / (a - b)
    nearest = np.argmin(_distances(emulator.at(roots), compared))  # if there are several
    return _Test(x, difference, allowed, float(roots[nearest]), True)


def _next(
    known: dict[float, Predicted], failed: list[float], ends: tuple[float, float], compared: Compared
) -> float | None:
    """Return the logarithm of the value to solve next; None where the fit and both ends are known, or cannot be."""
    if len(known) < 2:
        return 0.5 * (min(known) + failed[-1])
    emulator = _emulator(known)
    tested = _tested(emulator, compared)
    if tested.inside and np.abs(emulator.ln_value - tested.best).min() > _CLOSE_ENOUGH:
        return tested.best
    slope = np.polyfit(emulator.ln_value, emulator.ln_force.mean(axis=1), 1)[0]
    for side, index in ((-1, 0), (1, -1)):
        at_fit = not tested.inside and tested.best == tested.x[index]
        if not (at_fit or (tested.inside and tested.accepted[index])):
            continue
        difference = abs(tested.difference[index])
        missing = difference if at_fit else tested.allowed[index] - difference
        edge, far = tested.x[index], np.clip(1.3 * missing / max(abs(slope), 1e-3), 4 * _CLOSE_ENOUGH, _LONGEST_STEP)
        beyond = [abs(value - edge) for value in failed if (value - edge) * side > 0]
        if beyond and far >= min(beyond):  # short of what could not be solved
            far = 0.5 * min(beyond)
        x = float(np.clip(edge + side * far, *ends))
        if (x - edge) * side > _CLOSE_ENOUGH:
            return x
    return None


def _distances(ln_force: np.ndarray, compared: Compared) -> np.ndarray:
    """Return the rms difference between predicted and measured logarithms of quantiles, at each value."""
    return np.sqrt(np.mean((ln_quantiles(ln_force) - ln_quantiles(compared.ln_force)) ** 2, axis=-1))


def _fitted(emulator: Emulator, compared: Compared, failed: list[float]) -> Fitted:
    tested = _tested(emulator, compared)
    best, accepted = tested.best, tested.accepted
    low, high = np.exp(tested.x[accepted][[0, -1]] if accepted.any() else [best, best])
    predicted = emulator.at(best)
    target, own = ln_quantiles(compared.ln_force), ln_quantiles(predicted)
    near = np.clip(best + np.array([-0.05, 0.05]), emulator.ln_value[0], emulator.ln_value[-1])
    return Fitted(
        value=float(np.exp(best)) if tested.inside else np.nan,
        low=np.nan if accepted[0] or not tested.inside else float(low),
        high=np.nan if accepted[-1] or not tested.inside else float(high),
        exponent=float(np.diff(emulator.at(near).mean(axis=-1))[0] / np.diff(near)[0]),
        spread_ratio=float(target.std() / own.std()) if own.std() > 1e-12 else np.nan,
        mean=float(predicted.mean()),
        values=np.exp(emulator.ln_value),
        distance=_distances(emulator.ln_force, compared),
        left_out=tuple(np.exp(sorted(failed))),
    )
