"""Fits of the range of adhesion or the hardness to measured pull-offs, the work of adhesion held fixed.

One distribution determines one number, and for a smooth sphere not even the range: the results say what a fit leaves
open.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..bodies.materials import DEFAULT_RANGE
from ..contact.adhesion import adhesive
from ..contact.rigid_bodies import rigid
from ..statistics.sampling import Samples
from ..vocabulary import schema
from ..vocabulary.units import fraction
from .matching import CHANGE, Fitted, matching, positive_forces, predicted_forces, trade

#: A number is not determined by forces that depend on it with a smaller exponent than this.
_TELLS = 0.05

#: Distances between distributions (of logarithms) that differ by less than this count as equal.
_ALIKE = 0.02

#: Number of values tried, and the factor from the assigned one to either end of them.
_TRIALS = {"rigid": (9, 4.0), "adhesive": (5, 3.0)}


class _Held(NamedTuple):
    """The number that is fitted while the work of adhesion is held fixed."""

    name: str
    words: str
    ends: str  # prefix of the names of the interval's ends
    start: float
    least: float  # smallest value to try


def fit_adhesion_range(
    ds: xr.Dataset,
    measured: xr.Dataset,
    *,
    method: str = "adhesive",
    subregions: Any = (8, 8),
    confidence: float = 0.95,
    resamples: int = 399,
    seed: int = 0,
    **options: Any,
) -> xr.Dataset:
    """Fit the range of adhesion for which a scan's predicted pull-offs have the distribution of the measured ones.

    Parameters
    ----------
    ds : Dataset
        A scan of the measured surface, with an assigned pair: its work of adhesion is held fixed, and ranges around its
        range of adhesion (0.3 nm where none is assigned) are tried.
    measured : Dataset
        With ``pull_off_force``, from `open_pull_off`; all positive.
    method : {"adhesive", "rigid"}
        How pull-offs are predicted: "adhesive", by the direct simulation (law="exponential"), run seven times at each
        place; "rigid", between bodies too stiff to deform.
    subregions : (int, int), (array, array) or Dataset
        Where the prediction's sphere lands.
    confidence, resamples, seed : float, int, int
        Confidence level of the interval, and of its bootstrap the number of resamples and the seed.
    **options
        Passed to `adhesive` or `rigid`.

    Returns
    -------
    Dataset
        ``fitted_adhesion_range`` (nm) with ``fitted_range_low`` and ``fitted_range_high``, and the profile
        ``quantile_distance`` along ``trial_adhesion_range``; NaN where the best value is no better than an end of those
        tried. ``force_exponent``, d ln force / d ln range: where it is near 0 the forces do not determine the range.
        ``work_trade``, the derivative of the range's logarithm with respect to that of the work of adhesion.
        ``spread_ratio`` and ``not_identifiable`` as for `fit_work_of_adhesion`.

    Raises
    ------
    ValueError
        As for `fit_work_of_adhesion`.

    Notes
    -----
    A smooth sphere pulls with 2πwR whatever the range (Derjaguin), so that only roughness reveals it.

    Examples
    --------
    >>> import roughxr
    >>> from roughxr.scans.synthetic import self_affine
    >>> scan = self_affine((48, 48), 2, rms=1, hurst=0.9, rolloff=50, seed=1).contact.assign_pair(
    ...     sphere_radius=200, contact_modulus=40, work_of_adhesion=0.1, adhesion_range=1.0)
    >>> options = {"subregions": (2, 2), "law": "exponential", "delta": [0.0]}
    >>> measured = scan.assign_coords(adhesion_range=2.0).contact.rigid(**options)
    >>> found = fit_adhesion_range(scan, measured, method="rigid", resamples=50, **options)
    >>> round(float(found.fitted_adhesion_range), 1)
    2.0
    """
    schema.one_of(method, tuple(_TRIALS), "method")
    start = float(ds.coords.get("adhesion_range", DEFAULT_RANGE))
    held = _Held("adhesion_range", "range of adhesion", "fitted_range", start, 0.0)
    verb = adhesive if method == "adhesive" else rigid
    given = {"confidence": confidence, "resamples": resamples, "seed": seed}
    return _fitted(ds, measured, held, verb, given, {"subregions": subregions, "law": "exponential", **options})


def fit_hardness(
    ds: xr.Dataset,
    measured: xr.Dataset,
    *,
    subregions: Any = (8, 8),
    confidence: float = 0.95,
    resamples: int = 399,
    seed: int = 0,
    **options: Any,
) -> xr.Dataset:
    """Fit the hardness for which a scan's predicted pull-offs have the distribution of the measured ones.

    Parameters
    ----------
    ds : Dataset
        A scan of the measured surface, with an assigned pair and hardness, around which others are tried; the work of
        adhesion is held fixed.
    measured : Dataset
        With ``pull_off_force``, from `open_pull_off`; all positive.
    subregions : (int, int), (array, array) or Dataset
        Where the prediction's sphere lands.
    confidence, resamples, seed : float, int, int
        Confidence level of the interval, and of its bootstrap the number of resamples and the seed.
    **options
        Passed to `adhesive`, such as the ``preload`` of the measurement.

    Returns
    -------
    Dataset
        ``fitted_hardness`` (GPa) with ``fitted_hardness_low`` and ``fitted_hardness_high``, the profile along
        ``trial_hardness``, and the further variables of `fit_adhesion_range`.

    Raises
    ------
    ValueError
        As for `fit_work_of_adhesion`, or if no hardness is assigned.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, contact_modulus=40)
    >>> forces = xr.Dataset({"pull_off_force": ("subregion", [1.0, 2.0])})
    >>> fit_hardness(scan, forces)
    Traceback (most recent call last):
        ...
    ValueError: hardness: expected an assigned one to begin with, found none; assign_pair(hardness=…)
    """
    if "hardness" not in ds.coords:
        raise ValueError("hardness: expected an assigned one to begin with, found none; assign_pair(hardness=…)")
    work, length = float(ds.coords.get("work_of_adhesion", 0.0)), float(ds.coords.get("adhesion_range", DEFAULT_RANGE))
    held = _Held("hardness", "hardness", "fitted_hardness", float(ds["hardness"]), 1.05 * work / length)
    given = {"confidence": confidence, "resamples": resamples, "seed": seed}
    return _fitted(ds, measured, held, adhesive, given, {"subregions": subregions, **options})


def _fitted(
    ds: xr.Dataset, measured: xr.Dataset, held: _Held, verb: Callable, given: dict[str, Any], options: dict[str, Any]
) -> xr.Dataset:
    """Return the fit of one number of the pair, the others held fixed."""
    fraction(given["confidence"], "confidence")
    schema.pair(ds, "contact_modulus", "work_of_adhesion")
    found = positive_forces(measured)
    count, times = _TRIALS[verb.__name__]
    values = np.geomspace(max(held.start / times, held.least), held.start * times, count)

    def predict(value: float, stickier: float = 1.0) -> Samples:
        work = float(ds["work_of_adhesion"]) * stickier
        pair = schema.label(ds.assign_coords({held.name: value, "work_of_adhesion": work}))
        return predicted_forces(verb(pair, **options), f"{held.words} {value:.3g}; choose other subregions")

    fit = matching(found, predict, values, **given)
    inside = values[0] * 1.01 < fit.value < values[-1] / 1.01
    numbers = (fit.value, fit.low, fit.high) if inside else (np.nan,) * 3
    names = (f"fitted_{held.name}", f"{held.ends}_low", f"{held.ends}_high")
    trial = f"trial_{held.name}"
    out = xr.Dataset(dict(zip(names, numbers)), {trial: values})
    out["quantile_distance"] = (trial, fit.distance)
    out["spread_ratio"], out["force_exponent"] = fit.spread_ratio, fit.exponent
    out["work_trade"] = trade(fit, predict(fit.value, CHANGE)) if abs(fit.exponent) > _TELLS else np.nan
    out.attrs = {"method": verb.__name__, "confidence": given["confidence"]}
    out.attrs |= {"measured_from": str(measured.attrs.get("source_file", ""))}
    out.attrs |= {"missing": f"NaN where the {held.words} lies beyond those tried, or forces do not tell it"}
    out.attrs["not_identifiable"] = _words(held, fit, out, ds, inside)
    return schema.record(schema.label(out), f"fit_{held.name}", ds, **given, **options)


def _words(held: _Held, fit: Fitted, out: xr.Dataset, ds: xr.Dataset, inside: bool) -> str:
    """Return a sentence on what the fit cannot tell."""
    said = [f"the work of adhesion is held at {float(ds['work_of_adhesion']):.3g} J/m²"]
    if abs(fit.exponent) <= _TELLS:
        said += [f"forces go with the {held.words} to the power {fit.exponent:.2g} only: they do not tell it"]
    else:
        said += [f"the {held.words} goes with it to the power {float(out['work_trade']):.2g}"]
    if not inside:
        said += ["the nearest lies at the end of those tried: assign one nearer to it, or doubt what is held"]
    elif (others := _minima(out["quantile_distance"])) > 1:
        said += [f"the profile has {others} valleys of like depth: more than one {held.words} predicts these forces"]
    elif np.isnan(fit.low) or np.isnan(fit.high):
        said += ["the interval reaches beyond those tried"]
    if np.isfinite(fit.spread_ratio) and not 0.7 < fit.spread_ratio < 1.4:
        said += [f"the measured spread is {fit.spread_ratio:.2g} times the predicted, which it does not explain"]
    return "; ".join(said)


def _minima(profile: xr.DataArray) -> int:
    """Return the number of minima of the profile that are about as deep as the deepest."""
    distance = np.concatenate(([np.inf], profile.values, [np.inf]))
    valleys = (distance[1:-1] < distance[:-2]) & (distance[1:-1] <= distance[2:])
    return int((profile.values[valleys] < 1.5 * profile.values.min() + _ALIKE).sum())
