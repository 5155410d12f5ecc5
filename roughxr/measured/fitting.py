"""Fits of one number of the pair, so that predicted pull-offs agree with the measured ones."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..asperity import expectation
from ..asperity.maps import pull_off_map
from ..bodies.pair import range_of
from ..contact.adhesion import adhesive
from ..contact.rigid.bodies import rigid
from ..statistics.sampling import by_share
from ..vocabulary import schema
from ..vocabulary.units import Places, fraction
from .likelihood import CHANGE, Fitted, Predicted, matching, positive_forces, predicted_forces, trade

#: Methods that predict pull-offs, and at how many places where none are given.
VERBS: dict[str, Callable[..., xr.Dataset]] = {"adhesive": adhesive, "superposed": pull_off_map, "rigid": rigid}
PLACES = {"adhesive": (4, 4), "superposed": (8, 8), "rigid": (8, 8)}

#: Whether the roughness that the scan does not show is part of a fit or verdict.
_WITHOUT = "roughness finer than the scans is not included (extrapolation=)"
_WITH = "roughness finer than the scans is included"

#: Forces determine a quantity only if they depend on it with a larger exponent than this.
_LEAST_EXPONENT = 0.05

#: Below this exponent the fit hardly depends on an assumed quantity.
_WEAK_EXPONENT = 0.1

#: Range of measured over predicted spread that the surface explains.
_EXPLAINED_SPREAD = 0.7, 1.4

#: Standard deviation of ln(superposed / simulated pull-off) from surface to surface: 90 % lie between `expectation`'s.
_SUPERPOSITION_ERROR = float(np.log(expectation.HIGH / expectation.LOW)) / (2 * 1.645)


class _Quantity(NamedTuple):
    """A quantity that can be fitted at fixed values of the others."""

    words: str
    ends: str  # prefix of the names of the interval's ends
    traded: str  # the fixed quantity whose error the fit absorbs
    proportional: bool  # whether pull-offs are roughly proportional to it, so that the next value can be guessed
    reach: float  # trial values lie within this factor of the assigned one, up and down
    methods: tuple[str, ...]  # the first one by default


QUANTITIES = {
    "work_of_adhesion": _Quantity(
        "work of adhesion", "fitted_work", "contact_modulus", True, 1e3, ("adhesive", "superposed")
    ),
    "adhesion_range": _Quantity(
        "range of adhesion", "fitted_range", "work_of_adhesion", False, 6.0, ("adhesive", "rigid")
    ),
    "hardness": _Quantity("hardness", "fitted_hardness", "work_of_adhesion", False, 6.0, ("adhesive",)),
    "sphere_radius": _Quantity(
        "sphere's radius", "fitted_sphere_radius", "work_of_adhesion", True, 1e2, ("adhesive", "superposed")
    ),
}

#: Name of the exponent of the fitted value's dependence on a fixed quantity.
_TRADES = {"contact_modulus": "modulus_trade", "work_of_adhesion": "work_trade"}


def fit_pair(
    ds: xr.Dataset,
    measured: xr.Dataset,
    *,
    quantity: str = "work_of_adhesion",
    method: str | None = None,
    subregions: Places = None,
    confidence: float = 0.95,
    force_error: float = 0.0,
    extrapolation: xr.Dataset | None = None,
    **options: Any,
) -> xr.Dataset:
    """Fit the work of adhesion (or range, hardness, radius) so that prediction and measurement agree.

    Parameters
    ----------
    ds : Dataset
        A scan of the measured surface, with an assigned pair. The other quantities are fixed. The search begins at the
        assigned value (for the range at 0.3 nm if none is assigned).
    measured : Dataset
        With ``pull_off_force``, from `open_pull_off`; all positive.
    quantity : {"work_of_adhesion", "adhesion_range", "hardness", "sphere_radius"}
        What is fitted.
    method : {"adhesive", "superposed", "rigid"}, optional
        How pull-offs are predicted: "adhesive", the default, by the direct simulation, at some seconds for each place
        and each of about six values; "superposed", by `pull_off_map`, in seconds (work of adhesion and radius);
        "rigid", between bodies too stiff to deform (the range).
    subregions : (int, int), (array, array) or Dataset, optional
        Places of the predictions, see `regions.centres`; by default 4 × 4, for the quick methods 8 × 8. They may differ
        from the measured places.
    confidence : float
        Of the interval, between 0 and 1.
    force_error : float
        Relative standard error that all measured forces share, such as that of a spring constant: 0.1 for 10 %.
    extrapolation : Dataset, optional
        Result of `extrapolated` at the same places, with the assigned numbers. It scales the predicted forces: at the
        assigned value their mean is that with the roughness that the scan does not show. Its uncertainty is included in
        the fit's. Without it the fit is for the surface as scanned.
    **options
        Passed to the method, such as the ``preload`` of the measurement.

    Returns
    -------
    Dataset
        ``fitted_work_of_adhesion`` (J/m²), ``fitted_adhesion_range`` (nm), ``fitted_hardness`` (GPa) or
        ``fitted_sphere_radius`` (nm), with the ends of its interval (``fitted_work_low``, ``fitted_range_low``,
        ``fitted_hardness_low``, ``fitted_sphere_radius_low`` and ``…_high``); NaN beyond the solved values. These are
        along ``trial_…`` with ``quantile_distance``, 0 where all quantiles from 5 to 95 % agree. Quality of the fit:
        ``spread_ratio``, 1 where the surface explains the measured spread; ``force_exponent``, d ln force / d ln value;
        d ln value / d ln of the fixed work of adhesion (``work_trade``) or, for the work, of the fixed contact modulus
        (``modulus_trade``). The attribute ``not_identifiable`` states the limits of the fit in words.

    Raises
    ------
    ValueError
        If measured forces are not all positive, no pair is assigned, for the hardness none, the method does not suit
        the quantity, or nothing can be predicted with the assigned value.

    Notes
    -----
    At the fitted value, predicted and measured forces have the same mean logarithm. The likelihood interval with
    Student's t includes three errors: the scatter over the independent places of both, ``force_error``, and the mean
    ``pull_off_error`` of the simulation. Only mesh="auto", or one mesh for laws with an edge, states the last one.
    Superposed forces are divided by 0.7, their median ratio to the simulation. The interval includes the spread of this
    ratio, 0.3 to 1.4 on nine surfaces of ten.

    Without ``extrapolation`` the fitted value absorbs the effect of roughness missing in the scan. It also absorbs a
    mesh error that the simulation does not state. Measured and predicted places are taken as independent. The adhesion
    of a rigid smooth sphere is 2πwR for any range (Derjaguin): only roughness makes the range identifiable.

    Trials (``tests/benchmarks/fitted_work.py``): 200 synthetic sets of measurements on 20 surfaces, without wavelengths
    that the scan does not resolve. Intervals of 95 % contained the true work of adhesion in 91 ± 5 % of the trials; the
    mean of ln(fit/truth) was −0.05 ± 0.04. For scans two roll-off wavelengths wide it was 84 %, for a scan of another
    surface of the same kind 92 ± 5 %. With wavelengths down to a pixel ("hidden") and without ``extrapolation`` it was
    92 %, with a mean of −0.10 ± 0.05.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, work_of_adhesion=0.1)
    >>> measured = scan.assign_coords(work_of_adhesion=0.5).contact.pull_off_map(subregions=(5, 5))
    >>> found = fit_pair(scan, measured, method="superposed")
    >>> bool(found.fitted_work_low < 0.5 < found.fitted_work_high)
    True
    """
    ds, measured, extrapolation = schema.entered(ds), schema.entered(measured), schema.entered(extrapolation)
    fitted = QUANTITIES[schema.one_of(quantity, tuple(QUANTITIES), "quantity")]
    method = schema.one_of(method or fitted.methods[0], fitted.methods, "method")
    fraction(confidence, "confidence")
    if not 0 <= force_error < 1:
        raise ValueError(f"force_error: expected a relative error from 0 to below 1, found {force_error!r}")
    schema.pair(ds, "contact_modulus", "work_of_adhesion")
    forces = positive_forces(measured)
    law = {"law": "exponential"} if quantity == "adhesion_range" else {}
    options = {"subregions": PLACES[method] if subregions is None else subregions, **law, **options}
    start = _start(ds, quantity)
    predict = _Prediction(ds, quantity, method, options, extrapolation)
    given = {"confidence": confidence, "error": force_error}
    fit = matching(forces, predict, start, proportional=fitted.proportional, reach=fitted.reach, **given)
    out = _labelled(fit, quantity, fitted)
    determined = np.isfinite(fit.value) and (fitted.proportional or abs(fit.exponent) > _LEAST_EXPONENT)
    out[_TRADES[fitted.traded]] = trade(fit, predict(fit.value, CHANGE).forces) if determined else np.nan
    law = {"law": predict.held["law"]} if method == "adhesive" else {}
    out.attrs = {"method": method, **law, "confidence": confidence, "force_error": force_error}
    out.attrs |= {"measured_from": str(measured.attrs.get("source_file", ""))}
    out.attrs |= {"missing": f"NaN where the {fitted.words} is beyond the values solved, or forces do not determine it"}
    out.attrs["not_identifiable"] = (
        f"{_words(quantity, fitted, fit, out, ds)}; {_WITHOUT if extrapolation is None else _WITH}"
    )
    given = {"confidence": confidence, "force_error": force_error}
    return schema.record(schema.label(out), "fit_pair", ds, quantity=quantity, method=method, **given, **options)


def _predicted(ds: xr.Dataset, method: str, options: dict[str, Any]) -> xr.Dataset:
    """Return the pull-offs by a method; scale superposed ones to the median of the simulation."""
    pull = VERBS[method](schema.label(ds), **options)
    if method != "superposed":
        return pull
    return pull.assign(pull_off_force=pull["pull_off_force"] / expectation.RATIO)


def _method_error(pull: xr.Dataset, method: str) -> float:
    """Return the relative standard error that a method's forces share; NaN where it states none."""
    if method == "superposed":
        return _SUPERPOSITION_ERROR
    stated = pull["pull_off_error"].values if "pull_off_error" in pull else np.full(1, np.nan)
    return float(np.nanmean(stated)) if np.isfinite(stated).any() else np.nan


def _fine_roughness(pull: xr.Dataset, extrapolation: xr.Dataset | None) -> tuple[float, float]:
    """Return the factor on predicted forces by roughness that the scan does not show, and its relative error."""
    if extrapolation is None:
        return 1.0, 0.0
    mean, upper = (
        float(extrapolation[name]) if name in extrapolation else np.nan for name in ("pull_off_mean", "pull_off_upper")
    )
    own, given = (float(ds.get("work_of_adhesion", np.nan)) for ds in (pull, extrapolation))
    if not (np.isfinite([mean, upper]).all() and np.isclose(own, given)):
        raise ValueError(
            f"extrapolation: expected a result of `extrapolated` at a work of adhesion of {own:.3g} J/m², found a mean "
            f"of {mean:.3g} nN at {given:.3g} J/m²"
        )
    return mean / float(by_share(pull["pull_off_force"]).mean()), float(np.log(upper / mean)) / 1.96


class _Prediction:
    """Predicted forces as a function of the fitted quantity; the traction law is chosen once, at the first value."""

    def __init__(self, ds: xr.Dataset, quantity: str, method: str, options: dict[str, Any], extrapolation: Any = None):
        self.ds, self.quantity, self.method, self.held = ds, quantity, method, dict(options)
        self.extrapolation = extrapolation
        self.fine: tuple[float, float] | None = None

    def __call__(self, value: float, traded: float = 1.0) -> Predicted:
        fitted = QUANTITIES[self.quantity]
        changed = {fitted.traded: float(self.ds[fitted.traded]) * traded, self.quantity: value}
        words = f"{fitted.words} {value:.3g}; choose other subregions, or begin nearer with another {self.quantity}"
        pull = _predicted(self.ds.assign_coords(changed), self.method, self.held)
        if self.method == "adhesive":
            self.held["law"] = pull.attrs["law"]
        self.fine = self.fine or _fine_roughness(pull, self.extrapolation)
        pull = pull.assign(pull_off_force=self.fine[0] * pull["pull_off_force"])
        error = np.hypot(np.nan_to_num(_method_error(pull, self.method)), self.fine[1])
        return Predicted(predicted_forces(pull, words), error)


def _start(ds: xr.Dataset, quantity: str) -> float:
    """Return the first trial value."""
    if quantity == "adhesion_range":
        return range_of(ds)
    if quantity == "hardness" and "hardness" not in ds.coords:
        raise ValueError("hardness: expected a value to start from, found none; assign_pair(hardness=…) first")
    value = float(ds[quantity])
    return value if value > 0 else 0.1


def _labelled(fit: Fitted, quantity: str, fitted: _Quantity) -> xr.Dataset:
    names = f"fitted_{quantity}", f"{fitted.ends}_low", f"{fitted.ends}_high"
    out = xr.Dataset(dict(zip(names, (fit.value, fit.low, fit.high))), {f"trial_{quantity}": fit.values})
    out["quantile_distance"] = (f"trial_{quantity}", fit.distance)
    return out.assign(spread_ratio=fit.spread_ratio, force_exponent=fit.exponent)


def _words(quantity: str, fitted: _Quantity, fit: Fitted, out: xr.Dataset, ds: xr.Dataset) -> str:
    """Return a sentence on what the fit does not determine."""
    power = float(out[_TRADES[fitted.traded]])
    if quantity == "work_of_adhesion":
        modulus = f"contact modulus {float(ds['contact_modulus']):g} GPa"
        separable = "only weakly" if abs(power) < _WEAK_EXPONENT else "so that the fit cannot separate the two"
        notes = [f"w depends on the assumed {modulus} to the power {power:.2f}, {separable}"]
        notes += ["the range of adhesion is the assumed one"]
    elif abs(fit.exponent) <= _LEAST_EXPONENT:
        notes = [f"the work of adhesion is fixed at {float(ds['work_of_adhesion']):.3g} J/m²"]
        notes += [f"forces depend on the {fitted.words} to the power {fit.exponent:.2f} only: they do not determine it"]
    else:
        notes = [f"the work of adhesion is fixed at {float(ds['work_of_adhesion']):.3g} J/m²"]
        notes += [f"the {fitted.words} depends on it to the power {power:.2f}, so that the fit cannot separate the two"]
    covered = f"{fit.values[0]:.3g} to {fit.values[-1]:.3g}"
    if np.isnan(fit.value):
        notes += [
            f"the best value is at the end of the range tried, {covered}: start nearer to it, or check the fixed values"
        ]
    elif np.isnan(fit.low) or np.isnan(fit.high):
        notes += [f"the interval reaches beyond the values that could be solved, {covered}"]
    if fit.stretches > 1:
        notes += [f"the interval falls into {fit.stretches} parts: more than one {fitted.words} predicts these forces"]
    if fit.left_out:
        notes += [f"left out, since it could not be solved: {', '.join(f'{value:.3g}' for value in fit.left_out)}"]
    if np.isfinite(fit.spread_ratio) and not _EXPLAINED_SPREAD[0] < fit.spread_ratio < _EXPLAINED_SPREAD[1]:
        notes += [
            f"the measured spread is {fit.spread_ratio:.2g} times the predicted, which no {fitted.words} explains"
        ]
    return "; ".join(notes)
