"""Contact modulus and work of adhesion of a sphere on a flat, fitted to force-distance curves.

A law gives force and indentation along its stable branch; the piezo travels by the indentation and the bending of the
cantilever, F/k. The retraction is used from its largest force to the detachment, and the approach where it is
repulsive, which excludes the snap-in. Besides modulus and work of adhesion the fit has a contact point for each branch,
and corrections with normal distributions: of the baselines, the spring constant, the sensitivity, and the work of
adhesion on approach, which may be smaller than on retraction.

Soft matter that flows follows no such law on both branches. If one law misses them by more than the noise, and the
approach shows no adhesion, Hertz's law on the approach gives the modulus, and the pull-off force the work of adhesion.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy import optimize, special

from ...mechanics.jobs.spread import finish, task_results
from ...mechanics.kernels.asperity import jkr, maugis
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.adhesion_laws import (
    AUTO,
    DMT,
    DUGDALE,
    HERTZ,
    JKR,
    LONG_RANGE,
    SHORT_RANGE,
    law_by_tabor,
    read_law,
)
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.text import RoughxrWarning, warn
from ...mechanics.vocabulary.units import Quantity, fraction, positive, single
from .baselines import Baseline, least_error_line, straight_baseline, with_choice_error
from .force_curves import at_places, evaluated_retraction, recorded_curves, retraction_pull

#: Points of a branch.
_POINTS = 1500

#: Largest number of bins of a contact.
_BINS = 150

#: Smallest number of samples of a contact.
_LEAST_CONTACT = 10

_SHORT_CONTACT = f"fewer than {_LEAST_CONTACT} samples in contact"

#: Share of the largest tension below which the sphere has detached.
_DETACHED = 0.25

#: Significant force in standard deviations.
_SIGNIFICANCE = 5.0

#: Range of ln of the contact modulus in GPa.
_LOG_MODULUS = (-16.0, 9.0)

#: Standard deviation of ln of the ratio of both works of adhesion.
_APPROACH_ADHESION = 1.0

#: Factor on the variance, for the error of the noise and its correlation, which a short baseline gives: without it,
#: intervals of 95 % contained 91 to 97 % of synthetic values.
_NOISE_UNCERTAINTY = 1.3

#: Rms of the residuals, over the noise and interference of the baseline, above which a law does not describe a curve.
_MISFIT = 3.0

#: Points of Hertz's law.
_HERTZ_POINTS = 300

#: Its fewest samples on an approach.
_LEAST_HERTZ = 20

#: Its largest error of the modulus' logarithm.
_LARGEST_HERTZ = 1.5

#: Standard error of a logarithm from which on its interval follows from the likelihood, not from the curvature.
_LARGE_ERROR = 0.15

#: Change of a logarithm up to which the end of its interval is sought.
_LARGEST_CHANGE = 9.0

_RESULT = np.dtype(
    [(f"fitted_{name}", float) for name in ("contact_modulus", "modulus_low", "modulus_high")]
    + [(f"fitted_{name}", float) for name in ("work_of_adhesion", "work_low", "work_high", "contact_point")]
    + [(name, float) for name in ("tabor_parameter", "force_rms", "force_noise", "misfit", "joint_contact_modulus")]
    + [("law", "U12"), ("reason", "U80"), ("note", "U90")]
)

#: What limits a fit, in its ``note``.
_NO_UPPER_LIMIT = "the bending of the cantilever hides the indentation: the modulus has no upper limit"
_NO_ONE_LAW = "approach and retraction follow no one law"
_UPPER_LIMIT_ONLY = "no pull exceeds the noise: w has an upper limit only"


class MisfittingCurves(RoughxrWarning):
    """A law does not describe force-distance curves within their noise.

    Examples
    --------
    >>> import warnings
    >>> import roughxr
    >>> warnings.simplefilter("error", roughxr.MisfittingCurves)  # stop instead of warning
    """


@schema.recorded
def fit_curve(
    ds: xr.Dataset,
    *,
    sphere_radius: Quantity,
    law: str = AUTO,
    adhesion_range: Quantity = 0.3,
    spring_constant: Quantity | None = None,
    spring_constant_std: float = 0.1,
    sensitivity_std: float = 0.03,
    confidence: float = 0.95,
) -> xr.Dataset:
    """Fit contact modulus and work of adhesion to force-distance curves of a sphere on a flat.

    Parameters
    ----------
    ds : Dataset
        Curves, from `measured.open_curves`, or in the form that `measured.curves_pull_off` describes. The retraction
        gives the work of adhesion; the branch "loading", if there is one, adds to the modulus, or gives it alone.
    sphere_radius : number or quantity
        nm.
    law : {"auto", "jkr", "dugdale", "dmt"}
        The law of contact. "auto" uses JKR's if Tabor's parameter is above 5, DMT's if it is below 0.1, both for all
        moduli in the interval, else Maugis's transition with Dugdale's attraction.
    adhesion_range : number or quantity
        z₀ of Tabor's parameter (R w²/(E*² z₀³))^{1/3}, nm.
    spring_constant : number or quantity, optional
        N/m, if ``ds`` does not state it.
    spring_constant_std, sensitivity_std : float
        Relative standard deviations of the spring constant and of the deflection sensitivity.
    confidence : float
        Of the intervals, between 0 and 1.

    Returns
    -------
    Dataset
        Along ``subregion``: ``fitted_contact_modulus`` (GPa) and ``fitted_work_of_adhesion`` (J/m²) with the ends of
        their intervals ``fitted_modulus_low``, ``fitted_modulus_high``, ``fitted_work_low`` and ``fitted_work_high``;
        an end is 0 or infinite if the curve does not limit the value, and a modulus without upper limit is NaN.
        ``fitted_contact_point`` (nm), the piezo's travel on retraction at which the undeformed bodies touch;
        ``tabor_parameter``; ``law``, the one used; ``force_rms`` (nN) of the residuals of single samples, equal to
        ``force_noise`` where the law fits; ``misfit``, the same over the noise and interference of the baseline, of one
        law through both branches, and ``joint_contact_modulus`` (GPa), what that law gives; ``reason``, why a curve has
        no fit, whose values are then NaN; ``note``, what limits a fit. The law "hertz+jkr" stands for Hertz's on the
        approach, whose contact point is then given, and the pull-off force of the other law; "hertz" for an approach
        whose retraction shows no pull.

    Raises
    ------
    ValueError
        If the spring constant is not known, or units are missing.

    Warns
    -----
    MisfittingCurves
        If the rms of the residuals is more than three times the noise and interference of the baseline.

    Notes
    -----
    The intervals contain noise and interference with their correlation in time, the baseline with the choice of its
    stretch, and the given errors of the calibration. They are wider by the rms of the residuals over the noise where
    the law fits worse than that. The radius, roughness and viscosity are not included, nor is interference in contact:
    with fringes of 5 % of the pull the intervals contain the modulus in about 90 % of soft and 85 % of stiff contacts,
    the work in 95 % (``tests/benchmarks/fitted_curves.py``). A soft cantilever on a stiff contact gives no upper limit
    of the modulus; the work of adhesion then lies between those of both laws.

    References
    ----------
    Johnson, Kendall & Roberts, Proc. R. Soc. A 324 (1971) 301, doi:10.1098/rspa.1971.0141; Derjaguin, Muller & Toporov,
    J. Colloid Interface Sci. 53 (1975) 314, doi:10.1016/0021-9797(75)90018-1; Maugis, J. Colloid Interface Sci. 150
    (1992) 243, doi:10.1016/0021-9797(92)90285-T.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import roughxr
    >>> from roughxr import reference
    >>> delta = np.linspace(6000.0, -4000.0, 1500)
    >>> contact = reference.jkr_sphere(delta[::-1], radius=2000, contact_modulus=0.0001, work_of_adhesion=0.05)
    >>> force = contact.force.fillna(0.0).values[::-1] + np.random.default_rng(0).normal(0, 2.0, 1500)
    >>> made = {"piezo": ("sample", delta + force / 10.0, {"units": "nm"}), "force": ("sample", force, {"units": "nN"})}
    >>> fit = roughxr.fit_curve(xr.Dataset(made), sphere_radius="2 um", spring_constant="10 N/m")
    >>> bool(fit.fitted_modulus_low[0] < 0.0001 < fit.fitted_modulus_high[0]), fit.law.item()
    (True, 'jkr')
    """
    ds = schema.entered_dataset(ds, "force_curve")
    radius = positive(sphere_radius, "nm", "sphere_radius")
    reach = positive(adhesion_range, "nm", "adhesion_range")
    named_law = read_law(law, "fit_curve")
    confidence = fraction(confidence, "confidence")
    stated = {"spring_constant_std": spring_constant_std, "sensitivity_std": sensitivity_std}
    expected = "a relative error from 0 to below 1"
    errors = {name: single(error, "1", name, expected, lambda value: 0 <= value < 1) for name, error in stated.items()}
    recorded, stiffness = recorded_curves(ds, spring_constant)
    if np.isinf(stiffness):
        raise Refusal("spring_constant", "it in N/m to subtract the bending of the cantilever", "none")
    branches = [name for name in ("retraction", "loading") if "branch" in recorded.dims and name in recorded["branch"]]
    parts = [recorded.sel(branch=name) for name in branches] or [recorded]
    samples = np.stack([[part["piezo"].values, part["force"].values] for part in parts], axis=2)  # (z or F, …, branch)
    fits = task_results(
        _fit,
        list(zip(*samples)),
        _RESULT,
        radius,
        None if named_law == AUTO else named_law,  # None: by Tabor's parameter
        reach,
        stiffness,
        tuple(errors.values()),
        float(special.chdtri(1, 1 - confidence)),  # quantile of chi²
        name="fit_curve",
    )
    out = at_places({name: fits[name] for name in _RESULT.names or ()}, ds)
    out.attrs = {
        "sphere_radius": radius,
        "adhesion_range": reach,
        "spring_constant": stiffness,
        **errors,
        "confidence": confidence,
        "missing": "NaN where reason says why",
    }
    _warn_of_misfit(fits["misfit"])
    return finish(schema.label(out))


def _warn_of_misfit(ratios: np.ndarray) -> None:
    """Warn of residuals of a law on both branches above noise and interference, by their ratio."""
    misfitting = ratios[ratios > _MISFIT]
    if misfitting.size:
        warn(
            f"{misfitting.size} of {ratios.size} curves: no one law describes both branches within the noise; the rms "
            f"of the residuals is {np.median(misfitting):.2g} times that of the baseline (median); see misfit and note",
            MisfittingCurves,
        )


class _CurvePart(NamedTuple):
    """The means of a branch's samples in contact, without baseline."""

    z: np.ndarray  # piezo from the detachment, nm
    force: np.ndarray  # nN
    error: np.ndarray  # standard errors, nN
    line: np.ndarray  # changes by one standard error of the baseline's offset and tilt, nN
    width: int  # samples in a mean
    noise: float  # of the samples, nN
    baseline_rms: float  # of the free samples about the baseline, with interference, nN

    def rms(self, misfit: np.ndarray) -> float:
        """Return the rms of the residuals of single samples, from those of the means in standard errors."""
        return np.sqrt(((misfit * self.error) ** 2).mean() + self.noise**2 * (1 - 1 / self.width))


class _Curve(NamedTuple):
    """A curve as it is fitted."""

    parts: list[_CurvePart]  # retraction, and approach if it is there
    gap: float  # standard error of the position of the detachment, nm
    pull: float  # measured pull-off force, nN
    radius: float
    reach: float
    stiffness: float
    errors: tuple[float, float]

    def branch(self, law: str, modulus: float, w: float) -> tuple[np.ndarray, np.ndarray]:
        """Return force and indentation along the stable branch of a law."""
        return _branch(law, modulus, w, self.radius, self.reach)

    def residuals(self, x: np.ndarray, law: str) -> np.ndarray:
        """Return residuals in standard errors: of the samples, the detachment, and the corrections."""
        stiffer, larger, drier, *lines = x[2 + len(self.parts) :]
        stiffness = self.stiffness * np.exp(self.errors[0] * stiffer)
        shown = np.exp(-self.errors[0] * stiffer - self.errors[1] * larger)
        modulus, out = _modulus_within_range(x[0]), [x[2 + len(self.parts) :]]
        for k, part in enumerate(self.parts):
            force, travel = self.branch(law, modulus, np.exp(x[1] + (k > 0) * _APPROACH_ADHESION * drier))
            travel = travel + force / stiffness
            end = int(np.argmin(travel))
            if k == 0:
                out.append(np.array([(x[2] + travel[end]) / self.gap]))
            model = np.interp(part.z - x[2 + k], travel[end:], force[end:]) * shown
            out.append((model - part.force + part.line @ lines[2 * k : 2 * k + 2]) / part.error)
        return np.concatenate(out)

    def start(self, law: str, log_modulus: float) -> np.ndarray:
        """Return parameters near the best at a modulus, with the measured pull-off force and detachment."""
        w = self.pull / (1.5 * np.pi * self.radius)
        for _ in range(3):
            force, travel = self.branch(law, np.exp(log_modulus), w)
            w *= self.pull / -force.min()
        travel = travel + force / self.stiffness
        end = int(np.argmin(travel))
        points = [np.median(part.z - np.interp(part.force, force[end:], travel[end:])) for part in self.parts[1:]]
        return np.r_[log_modulus, np.log(w), -travel[end], points, np.zeros(3 + 2 * len(self.parts))]

    def best_start(self, law: str) -> np.ndarray:
        """Return the best of starts over all moduli."""
        starts = [self.start(law, log_modulus) for log_modulus in np.arange(-13.0, 8.0, 0.5)]
        return min(starts, key=lambda x: (self.residuals(x, law) ** 2).sum())


#: Ratios m along Maugis's branch, from its end to large loads; forces and indentations of other laws in JKR's units.
_RATIOS = 1 + np.geomspace(1e6, 3e-7, _POINTS)
_A = np.geomspace(jkr.END_A, 300.0, _POINTS)
_REDUCED = {
    JKR: (_A**3 - 2 * _A**1.5, _A**2 - 4 / 3 * np.sqrt(_A)),
    DMT: (np.r_[0.0, _A**3] - 4 / 3, np.r_[0.0, _A**2]),
}


@lru_cache(maxsize=64)  # most derivatives of the residuals are by parameters that do not change it
def _branch(law: str, modulus: float, w: float, R: float, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Return force and indentation along the stable branch of a law."""
    units = jkr.ellipse_units(0.5 / R, 0.5 / R, 1.0, modulus, w)
    if law in _REDUCED:
        return units.P * _REDUCED[law][0], units.delta * _REDUCED[law][1]
    tabor = maugis.tabor(0.5 / R, 0.5 / R, modulus, w, reach)
    P, _, delta = maugis.contact_at(min(max(maugis.parameter(tabor), 1e-3), maugis.LARGEST), _RATIOS)
    return units.P * P, units.delta * delta


def _modulus_within_range(log_modulus: float) -> float:
    lowest, highest = _LOG_MODULUS
    return np.exp(min(max(log_modulus, lowest), highest))


def _fitted(x: np.ndarray, residuals: Callable[[np.ndarray], np.ndarray]) -> optimize.OptimizeResult:
    """Return the fit of parameters from a start."""
    most_evaluations = 40 * (x.size + 1)
    return optimize.least_squares(residuals, x, method="lm", ftol=1e-6, xtol=1e-8, max_nfev=most_evaluations)


def _fit(
    z: np.ndarray,
    force: np.ndarray,
    radius: float,
    law: str | None,
    reach: float,
    stiffness: float,
    errors: tuple[float, float],
    level: float,
) -> np.ndarray:
    """Return the results of one curve, whose branches are the retraction and, if there is one, the approach."""
    finite = [np.isfinite(travel) & np.isfinite(recorded) for travel, recorded in zip(z, force)]
    branches = [(travel[valid], recorded[valid]) for travel, recorded, valid in zip(z, force, finite)]
    pull = evaluated_retraction(*branches[0], stiffness, 1.0)
    end, gap, retraction = (0.0, 0.0, None) if pull.reason else _in_contact(*branches[0])
    approaches = [both for both in branches[1:] if both[0].size >= 5 * _LEAST_CONTACT and both[0][0] < both[0][-1]]
    hertz = next((_hertz(*both, radius, stiffness, errors, level) for both in approaches), None)
    if retraction is None:
        return _hertz_alone(hertz, pull, radius)
    parts = [retraction, *filter(None, (_approach(*both, end) for both in approaches))]
    curve = _Curve(parts, gap, pull.pull_off_force, radius, reach, stiffness, errors)
    out = _fit_both(curve, law, level)
    out["fitted_contact_point"] += end
    if hertz is None or out["misfit"] < _MISFIT:
        return out
    relative = np.linalg.norm([pull.pull_off_standard_error / pull.pull_off_force, *errors]) * np.sqrt(level)
    return _separate(out, hertz, curve, law, float(relative))


def _fit_both(curve: _Curve, law: str | None, level: float) -> np.ndarray:
    """Return the fit of one law to all parts of a curve."""
    radius, reach, retraction = curve.radius, curve.reach, curve.parts[0]
    used = law or DUGDALE
    best = _fitted(curve.best_start(used), partial(curve.residuals, law=used))
    ends = _intervals(curve, used, best, level)
    extremes = [maugis.tabor(0.5 / radius, 0.5 / radius, np.exp(end), np.exp(best.x[1]), reach) for end in ends[0]]
    if law is None and (extremes[1] > SHORT_RANGE or extremes[0] < LONG_RANGE):
        used = JKR if extremes[1] > SHORT_RANGE else DMT
        best = _fitted(best.x, partial(curve.residuals, law=used))
        ends = _intervals(curve, used, best, level)
    is_limited = np.isfinite(ends[0][1])
    modulus = np.exp(best.x[0]) if is_limited else np.nan
    work = np.exp(best.x[1])
    rms = retraction.rms(best.fun[4 + 2 * len(curve.parts) :][: retraction.z.size])
    tabor = maugis.tabor(0.5 / radius, 0.5 / radius, modulus, work, reach)
    values = modulus, *np.exp(ends[0]), work, *np.exp(ends[1]), best.x[2], tabor, rms, retraction.noise
    note = "" if is_limited else _NO_UPPER_LIMIT
    return np.array((*values, rms / retraction.baseline_rms, modulus, used, "", note), _RESULT)


class _Hertz(NamedTuple):
    """Hertz's law on an approach."""

    log_modulus: float
    half_width: float  # of its interval
    contact_point: float  # nm
    rms: float  # nN
    noise: float  # nN

    @property
    def moduli(self) -> np.ndarray:
        """The contact modulus and the ends of its interval, GPa."""
        return np.exp(self.log_modulus + self.half_width * np.array([0, -1, 1]))


class _HertzContact(NamedTuple):
    """A pressed part as Hertz's law is fitted to it; ``x`` are ln of the modulus, contact point, and baseline."""

    part: _CurvePart
    radius: float
    stiffness: float

    @property
    def start(self) -> np.ndarray:
        """Parameters from which fits begin."""
        log_modulus = np.log(0.75 * self.part.force[-1] / np.sqrt(self.radius) / self.part.z[-1] ** 1.5)
        return np.r_[log_modulus, 0.0, 0.0, 0.0]

    def residuals(self, x: np.ndarray, error: np.ndarray, stiffer: float, larger: float) -> np.ndarray:
        """Return residuals in errors, with changed logarithms of spring constant and sensitivity."""
        indentation = np.linspace(0.0, 1.0, _HERTZ_POINTS) ** 2 * max(float(self.part.z[-1]) - x[1], 1e-9)
        pressing = 4 / 3 * _modulus_within_range(x[0]) * np.sqrt(self.radius) * indentation**1.5
        travel = indentation + pressing / (self.stiffness * np.exp(stiffer))
        shown = np.interp(self.part.z - x[1], travel, pressing, left=0.0) * np.exp(-stiffer - larger)
        return np.r_[x[2:], (shown - self.part.force + self.part.line @ x[2:]) / error]

    def fitted(
        self, x: np.ndarray, error: np.ndarray, stiffer: float = 0.0, larger: float = 0.0
    ) -> optimize.OptimizeResult:
        """Return the fit from a start."""
        return _fitted(x, partial(self.residuals, error=error, stiffer=stiffer, larger=larger))


def _pressed_part(z: np.ndarray, force: np.ndarray, line: Baseline, begin: int) -> _CurvePart | None:
    """Return an approach from as far before its first pressed sample as after it; None if it shows adhesion."""
    pressed = z.size - begin
    if begin == 0 or pressed < _LEAST_HERTZ:
        return None
    part = _part(z, force, line, slice(max(begin - pressed, 0), z.size), z[begin])
    if part is None or part.force.min() < -_SIGNIFICANCE * max(part.error[0], part.baseline_rms):
        return None
    return part


def _hertz(
    z: np.ndarray, force: np.ndarray, radius: float, stiffness: float, errors: tuple[float, float], level: float
) -> _Hertz | None:
    """Return Hertz's law with a free contact point, fitted to an approach; None if it shows adhesion or no contact."""
    line = _approach_baseline(z, force)
    begin = _first_pressed(z, force, line)
    part = _pressed_part(z, force, line, begin)
    if part is None:
        return None
    contact = _HertzContact(part, radius, stiffness)
    first = contact.fitted(contact.start, part.error)
    misfit = np.sqrt(max(2 * first.cost / part.z.size, 1.0))  # so large that no correction of the baseline takes it up
    best = contact.fitted(first.x, part.error * misfit)
    changes = ((errors[0], 0.0), (0.0, errors[1]))
    calibrated = [contact.fitted(best.x, part.error * misfit, *change).x[0] for change in changes]
    by_calibration = np.sqrt(level) * (np.array(calibrated) - best.x[0])
    half_width = np.linalg.norm([_half_width(best.jac, 0, level * _NOISE_UNCERTAINTY), *by_calibration])
    rms = part.rms(misfit * best.fun[2:])
    if half_width > _LARGEST_HERTZ:  # the indentation does not show
        return None
    return _Hertz(float(best.x[0]), float(half_width), float(z[begin] + best.x[1]), rms, part.noise)


def _hertz_alone(hertz: _Hertz | None, pull: Any, radius: float) -> np.ndarray:
    """Return Hertz's law of an approach without a pull on retraction, else the reason of no fit."""
    out = np.full((), np.nan, _RESULT)
    out["law"], out["reason"], out["note"] = "", pull.reason or _SHORT_CONTACT, ""
    if hertz is None or np.isnan(pull.pull_off_at_most):
        return out
    work = pull.pull_off_at_most / (1.5 * np.pi * radius)
    values = *hertz.moduli, np.nan, 0.0, work, hertz.contact_point, np.nan
    out[()] = (*values, hertz.rms, hertz.noise, np.nan, np.nan, HERTZ, "", _UPPER_LIMIT_ONLY)
    return out


def _separate(joint: np.ndarray, hertz: _Hertz, curve: _Curve, law: str | None, relative: float) -> np.ndarray:
    """Return Hertz's modulus of the approach with the work of the pull-off force, and how the branches disagree."""
    works = np.exp([curve.start(law or DUGDALE, np.log(modulus))[1] for modulus in hertz.moduli])
    tabor = float(maugis.tabor(0.5 / curve.radius, 0.5 / curve.radius, hertz.moduli[0], works[0], curve.reach))
    name = law or law_by_tabor(tabor)
    work_ends = works[0], works.min() * np.exp(-relative), works.max() * np.exp(relative)
    values = *hertz.moduli, *work_ends, hertz.contact_point, tabor, hertz.rms, hertz.noise
    both = joint["misfit"], joint["joint_contact_modulus"]
    return np.array((*values, *both, f"{HERTZ}+{name}", "", _NO_ONE_LAW), _RESULT)


def _in_contact(z: np.ndarray, force: np.ndarray) -> tuple[float, float, _CurvePart | None]:
    """Return position and standard error of the detachment, and the part of a retraction in contact."""
    pull = retraction_pull(z, force, 1.0)
    at, line = pull.lowest, pull.line
    flat = force - line.force(z)
    gone = flat[at:] > _DETACHED * flat[at]
    end = at + max(int(np.argmax(gone[:-1] & gone[1:])), 1)
    position = float(z[end - 1] + z[end]) / 2
    gap = max(float(z[end - 1] - z[end]) / np.sqrt(12), 1e-3)
    return position, gap, _part(z, force, line, slice(0, end - 1), position)


def _approach(z: np.ndarray, force: np.ndarray, position: float) -> _CurvePart | None:
    """Return the repulsive part of an approach."""
    line = _approach_baseline(z, force)
    return _part(z, force, line, slice(_first_pressed(z, force, line), z.size), position)


def _approach_baseline(z: np.ndarray, force: np.ndarray) -> Baseline:
    """Return the baseline of an approach at its contact."""
    far = force[: z.size // 4]
    contact = int(np.flatnonzero(force < np.median(far) + 3 * far.std())[-1])
    line, others = straight_baseline(z, force, z.size)
    # A straight stretch is the baseline of an approach if it is this share of the travel before the contact
    if line.longest - z[0] > 0.3 * (z[contact] - z[0]) or contact < 5 * _LEAST_CONTACT:
        return with_choice_error(line, others, z[contact])
    nearest_first = slice(contact, None, -1)
    return least_error_line(z[nearest_first], force[nearest_first], line.noise, z[contact])


def _first_pressed(z: np.ndarray, force: np.ndarray, line: Baseline) -> int:
    """Return the sample of an approach from which on it is repulsive."""
    weak = np.flatnonzero(force - line.force(z) <= _SIGNIFICANCE * np.hypot(line.noise, line.error(line.centre)))
    return int(weak[-1]) + 1 if weak.size else 0


def _part(z: np.ndarray, force: np.ndarray, line: Baseline, used: slice, position: float) -> _CurvePart | None:
    """Return means of the used samples, travel from a position; the errors contain the correlation of the noise."""
    count = z[used].size
    if count < _LEAST_CONTACT:
        return None
    far = force[z <= line.end] - line.force(z[z <= line.end])
    far = far - far.mean()
    baseline_rms = max(np.sqrt((far**2).mean()), line.noise)
    correlated, length = 1.0, 2
    while far.size >= 8 * length:
        means = far[: far.size // length * length].reshape(-1, length).mean(axis=1)
        correlated = max(correlated, length * float((means**2).mean()) / max(line.noise, 1e-300) ** 2)
        length *= 2
    width = -(-count // _BINS)
    whole_bins = slice(used.start, used.start + count // width * width)
    mean_z, mean_force = (values[whole_bins].reshape(-1, width).mean(axis=1) for values in (z, force - line.force(z)))
    changes = np.c_[np.full(mean_z.size, line.level_error), line.tilt_error * (mean_z - line.centre)]
    noise = max(line.noise, 1e-9 * np.ptp(force))
    error = np.full(mean_z.size, noise * np.sqrt(correlated / width))
    return _CurvePart(mean_z - position, mean_force, error, changes, width, noise, baseline_rms)


def _intervals(curve: _Curve, law: str, best: optimize.OptimizeResult, level: float) -> list[tuple[float, float]]:
    """Return the ends at which the least sum of squares has risen by ``level`` times the misfit, of both logarithms."""
    count = sum(part.z.size for part in curve.parts) - 2 - len(curve.parts)
    level *= _NOISE_UNCERTAINTY * max(1.0, 2 * best.cost / max(count, 1))
    half = _half_width(best.jac, 0, level)
    works = [float(best.x[1])]
    if half < _LARGE_ERROR * np.sqrt(level):
        modulus = best.x[0] - half, best.x[0] + half
        half = _half_width(best.jac, 1, level)
    else:
        sides = [_modulus_end(curve, law, best, level, side * min(half, 1.0)) for side in (-1, 1)]
        modulus = sides[0][0], sides[1][0]
        works += [work for _, work in sides]
        if law not in _REDUCED and np.isinf(modulus[1]):  # then so is the transition between DMT's and JKR's pull-off
            works += np.log(curve.pull / np.pi / curve.radius / np.array([2.0, 1.5])).tolist()
        half = _half_width(np.delete(best.jac, 0, axis=1), 0, level)
    return [modulus, (min(works) - half, max(works) + half)]


def _half_width(jacobian: np.ndarray, index: int, level: float) -> float:
    """Return half the interval of a parameter by the curvature at the best fit."""
    column, rest = jacobian[:, index], np.delete(jacobian, index, axis=1)
    unexplained = float(((column - rest @ np.linalg.lstsq(rest, column, rcond=None)[0]) ** 2).sum())
    return np.sqrt(level / max(unexplained, 1e-4))


def _modulus_end(
    curve: _Curve, law: str, best: optimize.OptimizeResult, level: float, step: float
) -> tuple[float, float]:
    """Return one end of the modulus' interval, infinite without a limit, and the work of adhesion there."""

    @cache
    def fit_at(value: float) -> optimize.OptimizeResult:
        return _fitted(best.x[1:], lambda rest: curve.residuals(np.append(value, rest), law))

    def excess(value: float) -> float:
        """Return the change of the fit, in ends of the interval, beyond one."""
        return np.sqrt(max(2 * (fit_at(value).cost - best.cost), 0.0) / level) - 1

    best_value = float(best.x[0])
    reach = step
    while excess(best_value + reach) < 0:
        if abs(1.6 * reach) > _LARGEST_CHANGE:
            return np.copysign(np.inf, step), float(fit_at(best_value + reach).x[0])
        reach *= 1.6
    end = optimize.brentq(excess, best_value, best_value + reach, xtol=0.05)
    return end, float(fit_at(end).x[0])
