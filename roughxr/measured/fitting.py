"""The work of adhesion at which a surface's predicted pull-offs are distributed as the measured ones are.

One number is fitted: that which brings the logarithms of the predicted quantiles nearest to the measured ones. The
shape of the distribution stays what the surface makes it; whether it is the measured one is told, not fitted.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import schema
from ..contact.adhesion import adhesive
from ..contact.maps import pull_off_map
from ..statistics.sampling import Samples, samples
from ..statistics.uncertainty import interval_of
from ..units import fraction

METHODS = ("superposed", "adhesive")

#: Quantiles that are matched: a tail of few places is chance.
_LEVELS = np.linspace(0.05, 0.95, 19)

#: Works of adhesion tried, and over how many times the first guess on either side.
_TRIALS = {"superposed": (9, 4.0), "adhesive": (5, 2.0)}

#: By how much the modulus is changed to see what the fit makes of it.
_CHANGE = 1.2


class _Curves(NamedTuple):
    """Logarithms of predicted quantiles against that of the work of adhesion."""

    ln_work: np.ndarray
    ln_force: np.ndarray  # (works, levels)


def fit_work_of_adhesion(
    ds: xr.Dataset,
    measured: xr.Dataset,
    *,
    method: str = "superposed",
    subregions: Any = (8, 8),
    confidence: float = 0.95,
    resamples: int = 399,
    seed: int = 0,
    progress: bool = False,
    **options: Any,
) -> xr.Dataset:
    """Fit the work of adhesion at which a scan's predicted pull-offs are distributed as the measured ones.

    Parameters
    ----------
    ds : Dataset
        A scan of the measured surface, with an assigned pair; its work of adhesion is where the search begins.
    measured : Dataset
        With ``pull_off_force``, from `open_pull_off`; all positive.
    method : {"superposed", "adhesive"}
        How pull-offs are predicted: by `pull_off_map`, superposed asperities, in seconds; or by `adhesive`, the direct
        simulation, at some seconds for each place and each of seven works of adhesion.
    subregions : (int, int), (array, array) or Dataset
        Where the prediction's sphere lands, see `regions.centres`. Places need not be the measured ones.
    confidence : float
        Of the interval.
    resamples : int
        Of each bootstrap.
    seed : int
    progress : bool
        Tell on standard error how far it is.
    **options
        For `pull_off_map` or `adhesive`.

    Returns
    -------
    Dataset
        ``fitted_work_of_adhesion`` (J/m²) with ``fitted_work_low`` and ``fitted_work_high``, of the chance of both the
        measured and the predicted places, an end being NaN beyond the works tried. Along ``trial_work_of_adhesion`` the
        profile: ``quantile_distance``, which is 0 where all quantiles from 5 to 95 % agree. What the fit leaves open:
        ``spread_ratio``, of 1 where the surface explains the measured spread, and ``modulus_trade``, by how much ln w
        follows the logarithm of the contact modulus that was assumed. The attribute ``not_identifiable`` says it in
        words.

    Raises
    ------
    ValueError
        If measured forces are not all positive, no pair is assigned, or no work of adhesion predicts such forces.

    Notes
    -----
    The interval is of chance alone. What is wrong alike at all places, as a spring constant, the scan's missing waves
    or the method, goes into w unseen: `error_budget` and `scale_dependence` tell of it. Measured and predicted places
    are taken for independent; where both lie on one scan they share its peaks, and the interval is wider than it need
    be.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, work_of_adhesion=0.1)
    >>> measured = scan.assign_coords(work_of_adhesion=0.5).contact.pull_off_map(subregions=(5, 5))
    >>> found = fit_work_of_adhesion(scan, measured)
    >>> bool(found.fitted_work_low < 0.5 < found.fitted_work_high)
    True
    """
    schema.one_of(method, METHODS, "method")
    fraction(confidence, "confidence")
    schema.pair(ds, "contact_modulus", "work_of_adhesion")
    found = _positive(measured)
    predict = _prediction(ds, method, {"subregions": subregions, "progress": progress, **options})
    target = _ln_quantiles(found.values)
    curves = _tried(predict, target, float(ds["work_of_adhesion"]), *_TRIALS[method])
    work = float(np.exp(_best(curves, target)))
    there = predict(work, 1.0)
    own = _ln_quantiles(there.values)
    given = {"confidence": confidence, "resamples": resamples}
    of_measured = interval_of(found, _fit_to_measured(curves), seed=seed, **given)
    of_predicted = interval_of(there, _fit_of_predicted(curves, target, own), seed=seed + 1, **given)
    low, high = _both(work, of_measured, of_predicted, curves)
    stiffer = _ln_quantiles(predict(work, _CHANGE).values)
    out = xr.Dataset(
        {
            "fitted_work_of_adhesion": work,
            "fitted_work_low": low,
            "fitted_work_high": high,
            "quantile_distance": ("trial_work_of_adhesion", _distances(curves.ln_force, target)),
            "spread_ratio": float(target.std() / own.std()) if own.std() > 0 else np.nan,
            "modulus_trade": _trade(curves, own, stiffer, work),
        },
        coords={"trial_work_of_adhesion": np.exp(curves.ln_work)},
    )
    out.attrs = {
        "method": method,
        "confidence": confidence,
        "measured_from": str(measured.attrs.get("source_file", "")),
    }
    out.attrs["missing"] = "NaN where the interval ends beyond the works of adhesion tried"
    out.attrs["not_identifiable"] = _words(out, ds)
    return schema.record(schema.label(out), "fit_work_of_adhesion", ds, method=method, confidence=confidence, **options)


def _positive(measured: xr.Dataset) -> Samples:
    """Return measured forces, all positive, or say what is wrong with them."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*the others are missing")
        found = samples(measured, "pull_off_force")
    low = int((found.values <= 0).sum())
    if low:
        raise ValueError(
            f"measured: expected positive pull-off forces, found {low} of {found.values.size} at zero or below; leave "
            "them out, measured.where(measured.pull_off_force > 0), and know that the rest is no longer the whole"
        )
    return found


def _prediction(ds: xr.Dataset, method: str, options: dict[str, Any]) -> Callable[[float, float], Samples]:
    """Return the function of (work of adhesion, factor of the modulus) that predicts pull-offs."""
    verb = pull_off_map if method == "superposed" else adhesive

    def predict(work: float, stiffer: float) -> Samples:
        modulus = float(ds["contact_modulus"]) * stiffer
        pair = schema.label(ds.assign_coords(work_of_adhesion=work, contact_modulus=modulus))
        forces = verb(pair, **options)["pull_off_force"].to_dataset()
        without = int((~(forces["pull_off_force"] > 0)).sum())
        if without:  # to leave them out would set other places beside the measured ones at each w
            raise ValueError(
                f"expected a pull-off at every place, found none at {without} of {forces['pull_off_force'].size} for "
                f"w = {work:.3g} J/m²; choose other subregions, or start nearer with another work_of_adhesion"
            )
        return samples(forces, "pull_off_force")

    return predict


def _ln_quantiles(values: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.log(np.moveaxis(np.quantile(values, _LEVELS, axis=axis), 0, -1))


def _tried(predict, target: np.ndarray, work: float, count: int, times: float) -> _Curves:
    """Return predicted quantiles around the work of adhesion at which the median is the measured one."""
    work = work if work > 0 else 0.1
    for _ in range(2):  # pull-offs grow about as the work of adhesion does
        ratio = float(np.exp(np.mean(target - _ln_quantiles(predict(work, 1.0).values))))
        work *= ratio
    if not np.isfinite(work) or not 1e-7 < work < 1e4:
        raise ValueError(
            f"expected a work of adhesion that predicts the measured forces, found none (w = {work:g} J/m²)"
        )
    works = work * np.geomspace(1 / times, times, count)
    return _Curves(np.log(works), np.array([_ln_quantiles(predict(one, 1.0).values) for one in works]))


def _distances(ln_force: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return the rms distance of predicted from measured logarithms of quantiles, at each work of adhesion."""
    return np.sqrt(np.mean((ln_force - target[..., None, :]) ** 2, axis=-1))


def _best(curves: _Curves, target: np.ndarray) -> np.ndarray:
    """Return ln w of the least distance, by a spline through the squares, within the works tried."""
    from scipy.interpolate import CubicSpline

    fine = np.linspace(curves.ln_work[0], curves.ln_work[-1], 401)
    squares = CubicSpline(curves.ln_work, _distances(curves.ln_force, target) ** 2, axis=-1)(fine)
    return fine[np.argmin(squares, axis=-1)]


def _fit_to_measured(curves: _Curves) -> Callable[..., np.ndarray]:
    """Return w as a statistic of measured forces."""
    return lambda values, axis=-1: np.exp(_best(curves, _ln_quantiles(values, axis)))


def _fit_of_predicted(curves: _Curves, target: np.ndarray, own: np.ndarray) -> Callable[..., np.ndarray]:
    """Return w as a statistic of forces predicted at the fit: to first order, all works' quantiles shift as theirs."""
    return lambda values, axis=-1: np.exp(_best(curves, target - (_ln_quantiles(values, axis) - own)))


def _both(work: float, first: tuple, second: tuple, curves: _Curves) -> tuple[float, float]:
    """Return the interval of independent errors, added in squares on the logarithms; NaN beyond what was tried."""
    low, high = (
        float(np.exp(np.log(work) + sign * np.hypot(np.log(a / work), np.log(b / work))))
        for sign, a, b in zip((-1, 1), first, second)
    )
    ends = np.exp(curves.ln_work[[1, -2]])
    return (low if low > ends[0] else np.nan), (high if high < ends[1] else np.nan)


def _trade(curves: _Curves, own: np.ndarray, stiffer: np.ndarray, work: float) -> float:
    """Return d ln w / d ln E* at equal forces."""
    growth = np.gradient(curves.ln_force.mean(axis=1), curves.ln_work)
    by_work = float(np.interp(np.log(work), curves.ln_work, growth))
    return float(-(stiffer - own).mean() / np.log(_CHANGE) / by_work) if by_work else np.nan


def _words(out: xr.Dataset, ds: xr.Dataset) -> str:
    """Return what the fit cannot tell."""
    trade, spread = float(out["modulus_trade"]), float(out["spread_ratio"])
    said = [f"w goes with the assumed contact modulus {float(ds['contact_modulus']):g} GPa to the power {trade:.2g}"]
    said += ["the range of adhesion is the assumed one"]
    if np.isnan(out["fitted_work_low"]) or np.isnan(out["fitted_work_high"]):
        said += ["the interval reaches beyond the works of adhesion tried: these forces do not tell w"]
    if not 0.7 < spread < 1.4:
        said += [f"the measured spread is {spread:.2g} times the predicted, which no work of adhesion explains"]
    return "; ".join(said)
