"""Fit one quantity so that predicted and measured forces have the same mean logarithm.

The pull-off of each place is solved at a few values of the quantity, added where needed, and interpolated between them
on logarithms (`Emulator`). Logarithms of forces are taken as normal. The likelihood interval then contains the values
for which the two means differ by no more than

    t √(s²/n + σ²/m + ε²)

with the spreads s and σ over n measured and m predicted independent places, ε the error common to all places, and
Student's t for Welch's number of degrees of freedom. Differences in the shape of the distributions are reported, not
fitted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..statistics.places import independent_places
from ..statistics.sampling import Samples, counted_equally, samples

#: Quantiles whose distance and spread are reported: tails with few places are left out.
_LEVELS = np.linspace(0.05, 0.95, 19)

#: Factor on a fixed quantity, to find how the fitted value depends on it.
CHANGE = 1.2

#: Most values solved; longest step between two values, and largest distance of a solved value from the fit (both ln).
_MOST_VALUES, _LONGEST_STEP, _CLOSE_ENOUGH = 12, np.log(4.0), 0.05

#: First step (ln) to both sides of the start, if forces are not proportional to the quantity.
_FIRST_STEP = np.log(3.0)

#: Below this number all places count as independent.
_FEW_PLACES = 16

#: Points at which the interval is evaluated.
_INTERVAL_POINTS = 2001


class Predicted(NamedTuple):
    """Forces at all places for one value of the quantity, and their common relative error (NaN: unknown)."""

    forces: Samples
    error: float = np.nan


class Emulator(NamedTuple):
    """Logarithm of each place's force as a function of the logarithm of the fitted quantity."""

    ln_value: np.ndarray  # (values), ascending
    ln_force: np.ndarray  # (values, places)
    error: np.ndarray  # (values), common to all places

    def at(self, x: np.ndarray | float) -> np.ndarray:
        """Return the logarithms of the forces, (…, places)."""
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.ln_value, self.ln_force, axis=0)(x)


class Measured(NamedTuple):
    """Logarithms of the measured forces, number of independent ones, and their common relative error."""

    ln_force: np.ndarray
    independent: float
    error: float


class Fitted(NamedTuple):
    """The fitted value and its interval; NaN beyond the solved values."""

    value: float
    low: float
    high: float
    stretches: int  # number of separate parts of the interval
    exponent: float  # d ln force / d ln value at the fit
    spread_ratio: float  # measured over predicted
    mean: float  # of the logarithms of the forces at the fit
    values: np.ndarray  # solved
    distance: np.ndarray  # of the distributions at each of them
    left_out: tuple[float, ...]  # values that could not be solved


class _Test(NamedTuple):
    """Difference of the mean logarithms, and the largest within the likelihood interval, at many values."""

    x: np.ndarray
    difference: np.ndarray  # predicted less measured, of the mean logarithms
    allowed: np.ndarray


def positive_forces(measured: xr.Dataset) -> Samples:
    """Return measured forces; raise where they are not all positive."""
    forces = samples(measured, "pull_off_force", quiet=True)
    low = int((forces.values <= 0).sum())
    if low:
        raise ValueError(
            f"measured: expected positive pull-off forces, found {low} of {forces.values.size} at zero or below; leave "
            "them out with measured.where(measured.pull_off_force > 0), which biases the mean upwards"
        )
    return forces


def predicted_forces(pull: xr.Dataset, words: str) -> Samples:
    """Return predicted forces; raise if a place has none."""
    forces = pull["pull_off_force"].to_dataset()
    without = int((~(forces["pull_off_force"] > 0)).sum())
    if without:  # leaving them out would compare with different places at each value
        total = forces["pull_off_force"].size
        raise ValueError(f"expected a pull-off at every place, found none at {without} of {total} for {words}")
    return samples(forces, "pull_off_force", quiet=True)


def ln_quantiles(values: np.ndarray) -> np.ndarray:
    """Return the logarithms of the quantiles that are compared, along the last axis."""
    return np.log(np.moveaxis(np.quantile(values, _LEVELS, axis=-1), 0, -1))


def matching(
    forces: Samples,
    predict: Callable[[float], Predicted],
    start: float,
    *,
    proportional: bool,
    reach: float,
    confidence: float,
    error: float,
) -> Fitted:
    """Return the value within ``reach`` times the start whose predicted forces agree in the mean, and its interval."""
    ln_force = np.log(counted_equally(forces, "fit_pair").values)
    measured = Measured(ln_force, _independent(forces), error)
    first = predict(start)
    places = _independent(first.forces)
    known = {float(np.log(start)): first}
    ends = np.log(start) - np.log(reach), np.log(start) + np.log(reach)
    failed: list[float] = []
    gap = float(ln_force.mean() - np.log(first.forces.values).mean())
    guess = gap if abs(gap) > _CLOSE_ENOUGH else np.log(1.5)
    steps = [guess] if proportional else [-_FIRST_STEP, _FIRST_STEP]  # forces may rise or fall: try both sides
    planned = [float(np.clip(np.log(start) + step, *ends)) for step in steps]
    x: float | None = planned.pop()
    while x is not None and len(known) + len(failed) < _MOST_VALUES:
        try:
            known[x] = predict(float(np.exp(x)))
        except ValueError:  # such as a hardness below the adhesive tension: report the other values
            failed.append(x)
        x = planned.pop() if planned else _next(known, failed, ends, measured, places, confidence)
    return _fitted(_emulator(known), measured, places, confidence, failed)


def trade(fit: Fitted, other: Samples) -> float:
    """Return d ln value / d ln of the quantity that was changed by the factor `CHANGE`, at equal forces."""
    moved = np.log(other.values).mean() - fit.mean
    return float(-moved / np.log(CHANGE) / fit.exponent) if fit.exponent else np.nan


def _independent(forces: Samples) -> float:
    """Return the number of independent places; few places show no correlation, and all count."""
    if forces.places is None or forces.values.size < _FEW_PLACES or np.ptp(forces.values) == 0:
        return float(forces.values.size)
    return float(np.clip(independent_places(forces.values, forces.places), 2, forces.values.size))


def _emulator(known: dict[float, Predicted]) -> Emulator:
    x = np.array(sorted(known))
    return Emulator(
        x,
        np.array([np.log(known[value].forces.values) for value in x]),
        np.array([np.nan_to_num(known[value].error) for value in x]),
    )


def _tested(emulator: Emulator, measured: Measured, places: float, confidence: float) -> _Test:
    """Return the difference of the means over the solved range, and its largest value within the interval."""
    from scipy.stats import t

    x = np.unique(np.r_[np.linspace(emulator.ln_value[0], emulator.ln_value[-1], _INTERVAL_POINTS), emulator.ln_value])
    predicted = emulator.at(x)
    own = measured.ln_force.var(ddof=1) / measured.independent, measured.independent - 1
    theirs = predicted.var(axis=-1, ddof=1) / places, places - 1
    common = measured.error**2 + np.interp(x, emulator.ln_value, emulator.error) ** 2
    whole = own[0] + theirs[0] + common
    freedom = whole**2 / np.maximum(own[0] ** 2 / own[1] + theirs[0] ** 2 / theirs[1], 1e-30)
    allowed = t.ppf(0.5 + confidence / 2, np.minimum(freedom, 1e6)) * np.sqrt(whole)
    return _Test(x, predicted.mean(axis=-1) - measured.ln_force.mean(), allowed)


def _next(known, failed, ends, measured: Measured, places: float, confidence: float) -> float | None:
    """Return the logarithm of the next value to solve; None if the fit and both ends are known or out of range."""
    if len(known) < 2:
        return _nearer(min(known), failed[-1]) if failed else None
    emulator = _emulator(known)
    tested = _tested(emulator, measured, places, confidence)
    best, inside = _best(tested, emulator, measured)
    if inside and np.abs(emulator.ln_value - best).min() > _CLOSE_ENOUGH:
        return best
    accepted = np.abs(tested.difference) <= tested.allowed
    slope = np.polyfit(emulator.ln_value, emulator.ln_force.mean(axis=1), 1)[0]
    for side, index in ((-1, 0), (1, -1)):
        at_fit = not inside and best == tested.x[index]
        if not (at_fit or (inside and accepted[index])):
            continue
        missing = abs(tested.difference[index]) if at_fit else tested.allowed[index] - abs(tested.difference[index])
        far = np.clip(1.3 * missing / max(abs(slope), 1e-3), 4 * _CLOSE_ENOUGH, _LONGEST_STEP)
        x = _open(tested.x[index] + side * far, tested.x[index], side, failed, ends)
        if x is not None:
            return x
    return None


def _open(x: float, edge: float, side: int, failed: list[float], ends: tuple[float, float]) -> float | None:
    """Return a next value beyond an edge, short of those that failed; None if none is left."""
    beyond = [value for value in failed if (value - edge) * side > 0]
    limit = min(beyond, key=lambda value: abs(value - edge)) if beyond else None
    if limit is not None and (x - limit) * side >= 0:
        x = _nearer(edge, limit)
    x = float(np.clip(x, *ends))
    return x if (x - edge) * side > _CLOSE_ENOUGH else None


def _nearer(known: float, failed: float) -> float:
    return 0.5 * (known + failed)


def _best(tested: _Test, emulator: Emulator, measured: Measured) -> tuple[float, bool]:
    """Return the value at which the means agree best, and whether it lies inside the solved range.

    Of several such values, take the one with the nearest distribution.
    """
    cross = np.flatnonzero(np.diff(np.sign(tested.difference)) != 0)
    if not cross.size:
        k = int(np.argmin(np.abs(tested.difference)))
        return float(tested.x[k]), 0 < k < tested.x.size - 1
    a, b = tested.difference[cross], tested.difference[cross + 1]
    x = tested.x[cross] + (tested.x[cross + 1] - tested.x[cross]) * a / (a - b)
    return float(x[np.argmin(_distances(emulator.at(x), measured))]), True


def _distances(ln_force: np.ndarray, measured: Measured) -> np.ndarray:
    """Return the rms difference between predicted and measured logarithms of quantiles, at each value."""
    off = ln_quantiles(np.exp(ln_force)) - ln_quantiles(np.exp(measured.ln_force))
    return np.sqrt(np.mean(off**2, axis=-1))


def _fitted(emulator: Emulator, measured: Measured, places: float, confidence: float, failed: list[float]) -> Fitted:
    tested = _tested(emulator, measured, places, confidence)
    best, inside = _best(tested, emulator, measured)
    accepted = np.abs(tested.difference) <= tested.allowed
    stretches = int((np.diff(np.r_[False, accepted]) & accepted).sum())
    low, high = (np.exp(tested.x[accepted][k]) if accepted.any() else np.exp(best) for k in (0, -1))
    low = np.nan if accepted[0] or not inside else low
    high = np.nan if accepted[-1] or not inside else high
    predicted = np.exp(emulator.at(best))
    target, own = ln_quantiles(np.exp(measured.ln_force)), ln_quantiles(predicted)
    near = np.clip(best + np.array([-0.05, 0.05]), emulator.ln_value[0], emulator.ln_value[-1])
    growth = float(np.diff(emulator.at(near).mean(axis=-1))[0] / np.diff(near)[0])
    return Fitted(
        value=float(np.exp(best)) if inside else np.nan,
        low=float(low),
        high=float(high),
        stretches=stretches,
        exponent=growth,
        spread_ratio=float(target.std() / own.std()) if own.std() > 1e-12 else np.nan,
        mean=float(np.log(predicted).mean()),
        values=np.exp(emulator.ln_value),
        distance=_distances(emulator.ln_force, measured),
        left_out=tuple(np.exp(sorted(failed))),
    )
