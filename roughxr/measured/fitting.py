"""The work of adhesion for which a surface's predicted pull-offs have the distribution of the measured ones."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from ..asperity.maps import pull_off_map
from ..contact.adhesion import adhesive
from ..statistics.sampling import Samples
from ..vocabulary import schema
from ..vocabulary.units import fraction
from ..vocabulary.verbs import verb
from .matching import CHANGE, ln_quantiles, matching, positive_forces, predicted_forces, trade

#: Methods that predict pull-offs.
VERBS = {"superposed": pull_off_map, "adhesive": adhesive}

#: Number of works of adhesion tried, and the factor from the first guess to either end of them.
_TRIALS = {"superposed": (9, 4.0), "adhesive": (5, 2.0)}


@verb
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
    """Fit the work of adhesion for which a scan's predicted pull-offs have the distribution of the measured ones.

    Parameters
    ----------
    ds : Dataset
        A scan of the measured surface, with an assigned pair; its work of adhesion is where the search begins.
    measured : Dataset
        With ``pull_off_force``, from `open_pull_off`; all positive.
    method : {"superposed", "adhesive"}
        How pull-offs are predicted: "superposed", by `pull_off_map`, in seconds; "adhesive", by the direct simulation
        `adhesive`, at some seconds for each place and each of seven works of adhesion.
    subregions : (int, int), (array, array) or Dataset
        Where the prediction's sphere lands, see `regions.centres`. Places need not be the measured ones.
    confidence : float
        Confidence level of the interval.
    resamples : int
        Number of resamples of each bootstrap.
    seed : int
    progress : bool
        Show progress on standard error.
    **options
        Passed to `pull_off_map` or `adhesive`.

    Returns
    -------
    Dataset
        ``fitted_work_of_adhesion`` (J/m²) with ``fitted_work_low`` and ``fitted_work_high``, an interval due to the
        scatter of both measured and predicted places; an end is NaN beyond the works tried. Along
        ``trial_work_of_adhesion`` the profile ``quantile_distance``, which is 0 where all quantiles from 5 to 95 %
        agree. What the fit leaves open: ``spread_ratio``, 1 where the surface explains the measured spread, and
        ``modulus_trade``, the derivative of ln w with respect to the logarithm of the assumed contact modulus. The
        attribute ``not_identifiable`` says the same in words.

    Raises
    ------
    ValueError
        If measured forces are not all positive, no pair is assigned, or no work of adhesion predicts such forces.

    Notes
    -----
    The interval covers random scatter only. An error common to all places, such as that of a spring constant, of the
    method, or of waves missing in the scan, is absorbed by w: see `error_budget` and `scale_dependence`. Measured and
    predicted places are taken as independent; where both lie on one scan they share its peaks, and the interval is
    wider than necessary.

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
    schema.one_of(method, tuple(VERBS), "method")
    fraction(confidence, "confidence")
    schema.pair(ds, "contact_modulus", "work_of_adhesion")
    found = positive_forces(measured)
    predict = _prediction(ds, method, {"subregions": subregions, "progress": progress, **options})
    works = _works(predict, found, float(ds["work_of_adhesion"]), *_TRIALS[method])
    given = {"confidence": confidence, "resamples": resamples, "seed": seed}
    fit = matching(found, lambda work: predict(work, 1.0), works, **given)
    out = xr.Dataset(
        {
            "fitted_work_of_adhesion": fit.value,
            "fitted_work_low": fit.low,
            "fitted_work_high": fit.high,
            "quantile_distance": ("trial_work_of_adhesion", fit.distance),
            "spread_ratio": fit.spread_ratio,
            "modulus_trade": trade(fit, predict(fit.value, CHANGE)),
        },
        coords={"trial_work_of_adhesion": works},
    )
    out.attrs = {
        "method": method,
        "confidence": confidence,
        "measured_from": str(measured.attrs.get("source_file", "")),
    }
    out.attrs["missing"] = "NaN where the interval ends beyond the works of adhesion tried"
    out.attrs["not_identifiable"] = _words(out, ds)
    return schema.record(schema.label(out), "fit_work_of_adhesion", ds, method=method, confidence=confidence, **options)


def _prediction(ds: xr.Dataset, method: str, options: dict[str, Any]) -> Callable[[float, float], Samples]:
    """Return the function that predicts pull-offs from a work of adhesion and a factor of the modulus."""
    verb = VERBS[method]

    def predict(work: float, stiffer: float) -> Samples:
        modulus = float(ds["contact_modulus"]) * stiffer
        pair = schema.label(ds.assign_coords(work_of_adhesion=work, contact_modulus=modulus))
        words = f"w = {work:.3g} J/m²; choose other subregions, or start nearer with another work_of_adhesion"
        return predicted_forces(verb(pair, **options), words)

    return predict


def _works(predict, found: Samples, work: float, count: int, times: float) -> np.ndarray:
    """Return works of adhesion around the one whose predicted median force is the measured one."""
    work, target = work if work > 0 else 0.1, ln_quantiles(found.values)
    for _ in range(2):  # pull-offs are roughly proportional to the work of adhesion
        ratio = float(np.exp(np.mean(target - ln_quantiles(predict(work, 1.0).values))))
        work *= ratio
    if not np.isfinite(work) or not 1e-7 < work < 1e4:
        raise ValueError(
            f"expected a work of adhesion that predicts the measured forces, found none (w = {work:g} J/m²)"
        )
    return work * np.geomspace(1 / times, times, count)


def _words(out: xr.Dataset, ds: xr.Dataset) -> str:
    """Return a sentence on what the fit cannot tell."""
    trade, spread = float(out["modulus_trade"]), float(out["spread_ratio"])
    said = [f"w goes with the assumed contact modulus {float(ds['contact_modulus']):g} GPa to the power {trade:.2g}"]
    said += ["the range of adhesion is the assumed one"]
    if np.isnan(out["fitted_work_low"]) or np.isnan(out["fitted_work_high"]):
        said += ["the interval reaches beyond the works of adhesion tried: these forces do not tell w"]
    if not 0.7 < spread < 1.4:
        said += [f"the measured spread is {spread:.2g} times the predicted, which no work of adhesion explains"]
    return "; ".join(said)
