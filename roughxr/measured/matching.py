"""Fit of one number of a prediction, so that the predicted quantiles come closest to the measured ones.

The logarithms of the quantiles are compared. The shape of the distribution follows from the surface; whether it agrees
with the measured one is reported, not fitted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..statistics.sampling import Samples, known_samples
from ..statistics.uncertainty import interval_of

#: Quantiles that are matched: tails with few places are left out.
_LEVELS = np.linspace(0.05, 0.95, 19)

#: Factor by which a fixed number is changed to see how the fit follows.
CHANGE = 1.2


class Curves(NamedTuple):
    """Logarithms of predicted quantiles as functions of the logarithm of the fitted number."""

    ln_value: np.ndarray
    ln_force: np.ndarray  # (values, levels)


class Fitted(NamedTuple):
    """The fitted number and its interval; NaN for an end beyond the values tried."""

    value: float
    low: float
    high: float
    distance: np.ndarray  # of the distributions, at each value tried
    spread_ratio: float  # measured over predicted
    exponent: float  # d ln force / d ln value at the fit
    own: np.ndarray  # logarithms of the quantiles predicted with the fitted number


def positive_forces(measured: xr.Dataset) -> Samples:
    """Return measured forces; raise where they are not all positive."""
    found = known_samples(measured, "pull_off_force")
    low = int((found.values <= 0).sum())
    if low:
        raise ValueError(
            f"measured: expected positive pull-off forces, found {low} of {found.values.size} at zero or below; leave "
            "them out, measured.where(measured.pull_off_force > 0), and know that the rest is no longer the whole"
        )
    return found


def predicted_forces(found: xr.Dataset, words: str) -> Samples:
    """Return predicted forces, one at every place; raise where there is none at some."""
    forces = found["pull_off_force"].to_dataset()
    without = int((~(forces["pull_off_force"] > 0)).sum())
    if without:  # leaving them out would compare with different places at each value
        total = forces["pull_off_force"].size
        raise ValueError(f"expected a pull-off at every place, found none at {without} of {total} for {words}")
    return known_samples(forces, "pull_off_force")


def ln_quantiles(values: np.ndarray, axis: int = -1) -> np.ndarray:
    """Return the logarithms of the quantiles that are matched, along the last axis."""
    return np.log(np.moveaxis(np.quantile(values, _LEVELS, axis=axis), 0, -1))


def matching(
    found: Samples, predict: Callable[[float], Samples], values: np.ndarray, *, seed: int, **given: float
) -> Fitted:
    """Return the value whose predicted forces come closest to the distribution of the measured ones."""
    target = ln_quantiles(found.values)
    curves = Curves(np.log(values), np.array([ln_quantiles(predict(one).values) for one in values]))
    best = float(np.exp(_best(curves, target)))
    there = predict(best)
    own = ln_quantiles(there.values)
    of_measured = interval_of(found, _fit_to_measured(curves), seed=seed, **given)
    of_predicted = interval_of(there, _fit_of_predicted(curves, target, own), seed=seed + 1, **given)
    low, high = _both(best, of_measured, of_predicted, curves)
    spread = float(target.std() / own.std()) if own.std() > 0 else np.nan
    return Fitted(best, low, high, _distances(curves.ln_force, target), spread, _exponent(curves, best), own)


def trade(fit: Fitted, other: Samples) -> float:
    """Return d ln value / d ln of what was changed by the factor `CHANGE`, at equal forces."""
    return (
        float(-(ln_quantiles(other.values) - fit.own).mean() / np.log(CHANGE) / fit.exponent)
        if fit.exponent
        else np.nan
    )


def _exponent(curves: Curves, value: float) -> float:
    growth = np.gradient(curves.ln_force.mean(axis=1), curves.ln_value)
    return float(np.interp(np.log(value), curves.ln_value, growth))


def _distances(ln_force: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return the rms difference between predicted and measured logarithms of quantiles, at each value."""
    return np.sqrt(np.mean((ln_force - target[..., None, :]) ** 2, axis=-1))


def _best(curves: Curves, target: np.ndarray) -> np.ndarray:
    """Return the logarithm of the best value, by a spline through the squared distances, within the values tried."""
    from scipy.interpolate import CubicSpline

    fine = np.linspace(curves.ln_value[0], curves.ln_value[-1], 401)
    squares = CubicSpline(curves.ln_value, _distances(curves.ln_force, target) ** 2, axis=-1)(fine)
    return fine[np.argmin(squares, axis=-1)]


def _fit_to_measured(curves: Curves) -> Callable[..., np.ndarray]:
    """Return the fit as a function of measured forces, for their bootstrap."""
    return lambda values, axis=-1: np.exp(_best(curves, ln_quantiles(values, axis)))


def _fit_of_predicted(curves: Curves, target: np.ndarray, own: np.ndarray) -> Callable[..., np.ndarray]:
    """Return the fit as a function of the forces predicted there, for their bootstrap: to first order one shift."""
    return lambda values, axis=-1: np.exp(_best(curves, target - (ln_quantiles(values, axis) - own)))


def _both(value: float, first: tuple, second: tuple, curves: Curves) -> tuple[float, float]:
    """Return the interval for two independent errors, added in squares on the logarithms; NaN beyond values tried."""
    low, high = (
        float(np.exp(np.log(value) + sign * np.hypot(np.log(a / value), np.log(b / value))))
        for sign, a, b in zip((-1, 1), first, second)
    )
    ends = np.exp(curves.ln_value[[1, -2]])
    return (low if low > ends[0] else np.nan), (high if high < ends[1] else np.nan)
