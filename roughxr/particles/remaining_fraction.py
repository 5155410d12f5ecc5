"""`resuspension`: how many particles remain after some time in a flow, from the computed adhesion of each place."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..statistics import bootstrap
from ..statistics.sampling import by_share
from ..vocabulary import schema
from ..vocabulary.units import Quantities, Quantity
from .force_balance import (
    Body,
    Held,
    body_of,
    drive_ratios,
    for_each,
    held_of,
    recorded,
    scope_of,
    varied_dimension,
)
from .kinetics import survival
from .loads import LOADS, Flow

MODELS = ("rock_n_roll", "static")

#: Confidence level of the band over places, and the resamples that make it.
_CONFIDENCE, _RESAMPLES = 0.95, 399


def resuspension(
    ds: xr.Dataset,
    *,
    friction_velocity: Quantities,
    time: Quantities = 1.0,
    model: str = "rock_n_roll",
    direction: Quantity = 0.0,
    particle_density: Quantity | None = None,
    flow: str | Flow = "air",
    friction_coefficient: Quantity | None = None,
    shear_strength: Quantity | None = None,
) -> xr.Dataset:
    """Return the fraction of particles that remain on the surface over friction velocity and time.

    Each place holds one particle, or of places from `resting` its share of them. Its largest ratio of drive to
    resistance, as in `critical_load`, is taken as F/f_a of Rock'n'Roll; no law of adhesion is assumed.

    Parameters
    ----------
    ds : Dataset
        Result of `rolling`, or of `vary` over it; for the sizes of a powder, weight ``remaining`` by their shares.
    friction_velocity : array_like or quantity
        m/s, ascending, not negative.
    time : array_like or quantity
        s, ascending.
    model : {"rock_n_roll", "static"}
        "rock_n_roll": the quasi-static model of Reeks & Hall, in which the force has normal fluctuations with an rms of
        0.366 of its mean; "static": a particle leaves at once where the mean force exceeds the resistance.
    direction, particle_density, flow, friction_coefficient, shear_strength
        As for `critical_load`.

    Returns
    -------
    Dataset
        ``remaining`` along (friction_velocity, time) and whatever `vary` varied, with ``remaining_low`` and
        ``remaining_high``, the 95 % band of a block bootstrap over places, if there are at least two;
        ``remaining_here`` along (subregion, friction_velocity, time), the probability at each place; ``in_range`` along
        friction_velocity, whether drag, torque and lift are valid, see `critical_load`. Places without contact are NaN
        and left out of the mean; the attribute ``places`` is the number of the others.

    Raises
    ------
    ValueError
        As for `critical_load`; or if speeds or times are negative or not ascending, or no place is in contact.

    References
    ----------
    Reeks & Hall, J. Aerosol Sci. 32 (2001) 1.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> held = roughxr.rolling(scan, directions=8, subregions=(2, 2))
    >>> left = resuspension(held, friction_velocity=[0.1, 100.0])
    >>> left.remaining.isel(time=0).values.tolist()
    [1.0, 0.0]
    """
    ds = schema.entered(ds)
    schema.one_of(model, MODELS, "model")
    if (name := varied_dimension(ds)) is not None:
        given = {"time": time, "model": model, "direction": direction, "particle_density": particle_density}
        given |= {"flow": flow, "friction_coefficient": friction_coefficient, "shear_strength": shear_strength}
        return for_each(name, ds, resuspension, friction_velocity=friction_velocity, **given)
    speed = _not_negative(friction_velocity, "m/s", "friction_velocity")
    seconds = _not_negative(time, "s", "time")
    body = body_of(ds, particle_density, flow)
    limit = held_of(ds, direction, friction_coefficient, shear_strength)
    if not limit.known.any():
        raise ValueError(f"expected at least one place in contact, found none of {limit.known.size}")
    out = _labelled(_remaining_at(speed, seconds, body, limit, model), ds, speed, seconds)
    out["in_range"] = ("friction_velocity", LOADS["wall_shear"].push(speed, body).in_range)
    out = _with_band(out, int(limit.known.sum()))
    out.attrs = {"model": model, "confidence": _CONFIDENCE, "places": int(limit.known.sum())}
    out.attrs |= {"missing": "NaN where nothing is in contact", "comment": scope_of(ds)}
    given = {"friction_velocity": speed, "time": seconds, "model": model, "direction": direction}
    given |= {"particle_density": particle_density, **recorded(body)}
    given |= {"friction_coefficient": friction_coefficient, "shear_strength": shear_strength}
    return schema.record(schema.label(out), "resuspension", ds, **given)


def _not_negative(values: Any, units: str, name: str) -> np.ndarray:
    """Return ascending values that are not negative."""
    array = schema.ascending(values, units, name)
    if array[0] < 0:
        raise ValueError(f"{name}: expected values that are not negative, found {array[0]:g} {units}")
    return array


def _remaining_at(speed: np.ndarray, seconds: np.ndarray, body: Body, limit: Held, model: str) -> np.ndarray:
    """Return the probability (place, speed, time) that the particle at each place remains."""
    push = LOADS["wall_shear"].push
    ratio = np.array([drive_ratios(push(np.array([u]), body), body, limit).max(axis=0) for u in speed])
    left = survival(np.maximum(ratio, 0.0), speed, seconds, model, body.flow)
    return np.where(limit.known[:, None, None], left.transpose(1, 0, 2), np.nan)


def _labelled(shares: np.ndarray, ds: xr.Dataset, speed: np.ndarray, seconds: np.ndarray) -> xr.Dataset:
    place = {name: ds[name] for name in ds.coords if "direction" not in ds[name].dims}
    dims = ("subregion", "friction_velocity", "time")
    return xr.Dataset({"remaining_here": (dims, shares)}, coords={**place, "friction_velocity": speed, "time": seconds})


def _with_band(out: xr.Dataset, places: int) -> xr.Dataset:
    """Return the mean over places, with the ends of its interval if there are at least two."""
    out["remaining"] = by_share(out["remaining_here"]).mean("subregion")
    if places < 2:
        return out
    known = out[["remaining_here"]].dropna("subregion")
    band = bootstrap(known, "remaining_here", statistics=["mean"], confidence=_CONFIDENCE, resamples=_RESAMPLES)
    ends = band.sel(resampling="block", statistic="mean", drop=True).transpose("friction_velocity", "time")
    for end in ("low", "high"):
        out[f"remaining_{end}"] = (("friction_velocity", "time"), np.clip(ends[end].values, 0.0, 1.0))
    return out
