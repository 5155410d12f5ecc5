"""Fits of one number of the pair, so that predicted pull-offs have the distribution of the measured ones.

One distribution determines one number, and for a smooth sphere not even the range: the results say what a fit leaves
open.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..asperity.maps import pull_off_map
from ..bodies.materials import range_of
from ..contact.adhesion import adhesive
from ..contact.rigid_bodies import rigid
from ..statistics.sampling import Samples
from ..vocabulary import schema
from ..vocabulary.units import fraction
from ..vocabulary.verbs import verb
from .matching import CHANGE, Fitted, ln_quantiles, matching, positive_forces, predicted_forces, trade

#: Methods that predict pull-offs.
VERBS = {"superposed": pull_off_map, "adhesive": adhesive, "rigid": rigid}

#: A number is not determined by forces that depend on it with a smaller exponent than this.
_LEAST_EXPONENT = 0.05

#: Distances between distributions (of logarithms) that differ by less than this count as equal.
_EQUAL_DISTANCE = 0.02

#: A measured spread this many times the predicted is not explained by the surface.
_EXPLAINED = 0.7, 1.4


class _Quantity(NamedTuple):
    """A number that can be fitted while the others are held."""

    words: str
    ends: str  # prefix of the names of the interval's ends
    traded: str  # the held number whose error the fit absorbs
    proportional: bool  # whether pull-offs are roughly proportional to it, so that one nearby can be guessed
    trials: dict[str, tuple[int, float]]  # by method: how many values are tried, and their factor to either end


QUANTITIES = {
    "work_of_adhesion": _Quantity(
        "work of adhesion", "fitted_work", "contact_modulus", True, {"superposed": (9, 4.0), "adhesive": (5, 2.0)}
    ),
    "adhesion_range": _Quantity(
        "range of adhesion", "fitted_range", "work_of_adhesion", False, {"adhesive": (5, 3.0), "rigid": (9, 4.0)}
    ),
    "hardness": _Quantity("hardness", "fitted_hardness", "work_of_adhesion", False, {"adhesive": (5, 3.0)}),
    "sphere_radius": _Quantity(
        "sphere's radius",
        "fitted_sphere_radius",
        "work_of_adhesion",
        True,
        {"superposed": (9, 4.0), "adhesive": (5, 2.0)},
    ),
}

#: How the result names the exponent with which the fit follows a held number.
_TRADES = {"contact_modulus": "modulus_trade", "work_of_adhesion": "work_trade"}


@verb
def fit_pair(
    ds: xr.Dataset,
    measured: xr.Dataset,
    *,
    quantity: str = "work_of_adhesion",
    method: str | None = None,
    subregions: Any = (8, 8),
    confidence: float = 0.95,
    resamples: int = 399,
    seed: int = 0,
    **options: Any,
) -> xr.Dataset:
    """Fit one number of the pair, with which a scan's predicted pull-offs have the distribution of the measured ones.

    Parameters
    ----------
    ds : Dataset
        A scan of the measured surface, with an assigned pair: the other numbers are held as they are, and the search
        begins at the assigned value (for the range 0.3 nm where none is assigned).
    measured : Dataset
        With ``pull_off_force``, from `open_pull_off`; all positive.
    quantity : {"work_of_adhesion", "adhesion_range", "hardness", "sphere_radius"}
        What is fitted.
    method : {"superposed", "adhesive", "rigid"}, optional
        How pull-offs are predicted: "superposed", by `pull_off_map`, in seconds (work of adhesion and radius, their
        default); "adhesive", by the direct simulation, at some seconds for each place and each of seven values (the
        default of the others, for the range with law="exponential"); "rigid", between bodies too stiff to deform (the
        range).
    subregions : (int, int), (array, array) or Dataset
        Where the prediction's sphere lands, see `regions.centres`. Places need not be the measured ones.
    confidence, resamples, seed : float, int, int
        Confidence level of the interval, and of its bootstraps the number of resamples and the seed.
    **options
        Passed to the method, such as the ``preload`` of the measurement.

    Returns
    -------
    Dataset
        ``fitted_work_of_adhesion`` (J/m²), ``fitted_adhesion_range`` (nm), ``fitted_hardness`` (GPa) or
        ``fitted_sphere_radius`` (nm), with the ends of an interval due to the scatter of both measured and predicted
        places (``fitted_work_low``, ``fitted_range_low``, ``fitted_hardness_low``, ``fitted_sphere_radius_low`` and
        ``…_high``); NaN beyond the values tried. Along ``trial_…`` the profile ``quantile_distance``, 0 where all
        quantiles from 5 to 95 % agree. What the fit leaves open: ``spread_ratio``, 1 where the surface explains the
        measured spread; ``force_exponent``, d ln force / d ln value, near 0 where the forces do not determine it; and
        the derivative of its logarithm with respect to that of the held work of adhesion (``work_trade``) or, for the
        work of adhesion, of the held contact modulus (``modulus_trade``). The attribute ``not_identifiable`` says the
        same in words.

    Raises
    ------
    ValueError
        If measured forces are not all positive, no pair is assigned, for the hardness none, the method does not suit
        the quantity, or no work of adhesion predicts such forces.

    Notes
    -----
    The interval covers random scatter only. An error common to all places, such as that of a spring constant, of the
    method, or of waves missing in the scan, is absorbed by the fit: see `error_budget` and `scale_dependence`. Measured
    and predicted places are taken as independent; where both lie on one scan they share its peaks, and the interval is
    wider than necessary.

    A smooth sphere pulls with 2πwR whatever the range (Derjaguin), so that only roughness reveals it.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, work_of_adhesion=0.1)
    >>> measured = scan.assign_coords(work_of_adhesion=0.5).contact.pull_off_map(subregions=(5, 5))
    >>> found = fit_pair(scan, measured)
    >>> bool(found.fitted_work_low < 0.5 < found.fitted_work_high)
    True
    """
    fitted = QUANTITIES[schema.one_of(quantity, tuple(QUANTITIES), "quantity")]
    method = schema.one_of(method or next(iter(fitted.trials)), tuple(fitted.trials), "method")
    fraction(confidence, "confidence")
    schema.pair(ds, "contact_modulus", "work_of_adhesion")
    forces = positive_forces(measured)
    options = {"subregions": subregions, **({"law": "exponential"} if quantity == "adhesion_range" else {}), **options}

    def predict(value: float, traded: float = 1.0) -> Samples:
        changed = {fitted.traded: float(ds[fitted.traded]) * traded, quantity: value}
        words = f"{fitted.words} {value:.3g}; choose other subregions, or begin nearer with another {quantity}"
        return predicted_forces(VERBS[method](schema.label(ds.assign_coords(changed)), **options), words)

    values = _trials(ds, quantity, predict, forces, *fitted.trials[method])
    given = {"confidence": confidence, "resamples": resamples, "seed": seed}
    fit = matching(forces, predict, values, **given)
    out = _labelled(fit, values, quantity, fitted)
    told = fitted.proportional or abs(fit.exponent) > _LEAST_EXPONENT
    out[_TRADES[fitted.traded]] = trade(fit, predict(fit.value, CHANGE)) if told else np.nan
    out.attrs = {"method": method, "confidence": confidence}
    out.attrs |= {"measured_from": str(measured.attrs.get("source_file", ""))}
    out.attrs |= {"missing": f"NaN where the {fitted.words} lies beyond those tried, or forces do not tell it"}
    out.attrs["not_identifiable"] = _words(quantity, fitted, fit, out, ds)
    return schema.record(schema.label(out), "fit_pair", ds, quantity=quantity, method=method, **given, **options)


def _trials(ds: xr.Dataset, quantity: str, predict, forces: Samples, count: int, times: float) -> np.ndarray:
    """Return the values to try, around the assigned one or around the one with about the measured forces."""
    if QUANTITIES[quantity].proportional:
        return _guessed(predict, forces, quantity, float(ds[quantity])) * np.geomspace(1 / times, times, count)
    if quantity == "adhesion_range":
        start, least = range_of(ds), 0.0
    elif "hardness" in ds.coords:
        start, least = float(ds["hardness"]), 1.05 * float(ds["work_of_adhesion"]) / range_of(ds)
    else:
        raise ValueError("hardness: expected an assigned one to begin with, found none; assign_pair(hardness=…)")
    return np.geomspace(max(start / times, least), start * times, count)


def _guessed(predict, forces: Samples, quantity: str, value: float) -> float:
    """Return a value that predicts about the measured quantiles, pull-offs being roughly proportional to it."""
    value, target = value if value > 0 else 0.1, ln_quantiles(forces.values)
    for _ in range(2):
        value *= float(np.exp(np.mean(target - ln_quantiles(predict(value).values))))
    if not np.isfinite(value) or not 1e-7 < value < 1e10:
        raise ValueError(f"expected a {quantity} that predicts the measured forces, found none ({value:g})")
    return value


def _labelled(fit: Fitted, values: np.ndarray, quantity: str, fitted: _Quantity) -> xr.Dataset:
    inside = fitted.proportional or values[0] * 1.01 < fit.value < values[-1] / 1.01
    numbers = (fit.value, fit.low, fit.high) if inside else (np.nan,) * 3
    names = f"fitted_{quantity}", f"{fitted.ends}_low", f"{fitted.ends}_high"
    out = xr.Dataset(dict(zip(names, numbers)), {f"trial_{quantity}": values})
    out["quantile_distance"] = (f"trial_{quantity}", fit.distance)
    return out.assign(spread_ratio=fit.spread_ratio, force_exponent=fit.exponent)


def _words(quantity: str, fitted: _Quantity, fit: Fitted, out: xr.Dataset, ds: xr.Dataset) -> str:
    """Return a sentence on what the fit cannot tell."""
    if quantity == "work_of_adhesion":
        power = float(out["modulus_trade"])
        said = [
            f"w goes with the assumed contact modulus {float(ds['contact_modulus']):g} GPa to the power {power:.2g}"
        ]
        said += ["the range of adhesion is the assumed one"]
    elif abs(fit.exponent) <= _LEAST_EXPONENT:
        said = [f"the work of adhesion is held at {float(ds['work_of_adhesion']):.3g} J/m²"]
        said += [f"forces go with the {fitted.words} to the power {fit.exponent:.2g} only: they do not tell it"]
    else:
        said = [f"the work of adhesion is held at {float(ds['work_of_adhesion']):.3g} J/m²"]
        said += [f"the {fitted.words} goes with it to the power {float(out['work_trade']):.2g}"]
    if np.isnan(out[f"fitted_{quantity}"]):
        said += ["the nearest lies at the end of those tried: assign one nearer to it, or doubt what is held"]
    elif (others := _minima(out["quantile_distance"])) > 1:
        said += [f"the profile has {others} valleys of like depth: more than one {fitted.words} predicts these forces"]
    elif np.isnan(fit.low) or np.isnan(fit.high):
        said += [f"the interval reaches beyond those tried: these forces do not tell the {fitted.words}"]
    if np.isfinite(fit.spread_ratio) and not _EXPLAINED[0] < fit.spread_ratio < _EXPLAINED[1]:
        said += [f"the measured spread is {fit.spread_ratio:.2g} times the predicted, which no {fitted.words} explains"]
    return "; ".join(said)


def _minima(profile: xr.DataArray) -> int:
    """Return the number of minima of the profile that are about as deep as the deepest."""
    distance = np.concatenate(([np.inf], profile.values, [np.inf]))
    valleys = (distance[1:-1] < distance[:-2]) & (distance[1:-1] <= distance[2:])
    return int((profile.values[valleys] < 1.5 * profile.values.min() + _EQUAL_DISTANCE).sum())
