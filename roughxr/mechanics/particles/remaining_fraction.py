"""`resuspension`: the fraction of particles that remain in a flow, from the computed adhesion of each place."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from ..statistics import bootstrap
from ..statistics.sampling import weighted_by_landing_share
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Quantities, Quantity
from .force_balance import (
    Resistance,
    drive_ratios,
    for_each_condition,
    pull_off_part,
    read_body,
    read_resistance,
    rolls_off,
)
from .kinetics import not_negative, survival
from .loads import LOADS, Body, Flow

#: Confidence level of the band.
_CONFIDENCE = 0.95

#: Number of resamples of the band.
_RESAMPLES = 399


@for_each_condition
@schema.verb("moments")
def resuspension(
    ds: xr.Dataset,
    *,
    friction_velocity: Quantities,
    time: Quantities = 1.0,
    direction: Quantity = 0.0,
    particle_density: Quantity | None = None,
    flow: str | Flow = "air",
    friction_coefficient: Quantity | None = None,
    shear_strength: Quantity | None = None,
) -> xr.Dataset:
    """Return the fraction of particles that remain on the surface in turbulence, over friction velocity and time.

    Each place has one particle, or its share of particles from `resting`. F/f_a of Rock'n'Roll is the largest ratio of
    drive to resistance, as in `critical_load`. No adhesion distribution is assumed.

    Parameters
    ----------
    ds : Dataset
        Result of `rolling`, or of `vary` over it; for the sizes of a powder, weight ``remaining`` by their shares.
    friction_velocity : array_like or quantity
        m/s, ascending, not negative.
    time : array_like or quantity
        s, ascending.
    direction, particle_density, flow, friction_coefficient, shear_strength
        As in `critical_load`.

    Returns
    -------
    Dataset
        ``remaining`` along (friction_velocity, time), with its 95 % band by places and by known errors of pull-offs,
        ``remaining_low`` and ``remaining_high``; ``remaining_at_place``, the probability at each place, NaN without
        contact or if the sphere does not rest; ``in_range``, as in `critical_load`.

    Raises
    ------
    ValueError
        If ``ds`` has no resisting moments, or the sphere rests at no place.

    References
    ----------
    Reeks & Hall, J. Aerosol Sci. 32 (2001) 1, doi:10.1016/S0021-8502(00)00063-X.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> moments = roughxr.rolling(scan, directions=8, subregions=(2, 2))
    >>> left = moments.contact.resuspension(friction_velocity=[0.001, 100.0])
    >>> left.remaining.isel(time=0).values.tolist()
    [1.0, 0.0]
    """
    speed = not_negative(friction_velocity, "m/s", "friction_velocity")
    seconds = not_negative(time, "s", "time")
    body = read_body(ds, particle_density, flow)
    limit = _at_rest(body, read_resistance(ds, direction, friction_coefficient, shear_strength))
    place = {name: ds[name] for name in ds.coords if "direction" not in ds[name].dims}
    out = xr.Dataset(coords=place | {"friction_velocity": speed, "time": seconds})
    remains = partial(_remaining, body=body, speed=speed, seconds=seconds)
    at_place = xr.DataArray(remains(limit), dims=("subregion", "friction_velocity", "time"), coords=out.coords)
    out["remaining_at_place"] = at_place
    out["in_range"] = ("friction_velocity", LOADS["wall_shear"].push(speed, body).in_range)
    growth = 1 + pull_off_part(ds)
    if_pull_offs_err = [at_place, at_place]
    if (growth > 1).any():
        if_pull_offs_err = [at_place.copy(data=remains(_scaled(limit, factor))) for factor in (1 / growth, growth)]
    out = _with_band(out, if_pull_offs_err, int(limit.known.sum()))
    out.attrs = {"confidence": _CONFIDENCE, "places": int(limit.known.sum())}
    out.attrs["missing"] = "NaN where nothing is in contact or the sphere does not rest"
    return schema.label(out)


def _at_rest(body: Any, limit: Any) -> Any:
    """Return the resistance of the places where the sphere rests; raise if there are none."""
    rests = limit.known & ~rolls_off(LOADS["wall_shear"], body, limit)
    if not rests.any():
        raise Refusal(
            "",
            "at least one place where the sphere rests",
            f"none of {rests.size} ({int(limit.known.sum())} in contact)",
            "take places of `resting`",
        )
    return limit._replace(known=rests)


def _remaining(limit: Resistance, *, body: Body, speed: np.ndarray, seconds: np.ndarray) -> np.ndarray:
    """Return the fraction remaining (place, speed, time) against a resistance; NaN where the sphere does not rest."""
    push = LOADS["wall_shear"].push
    ratio = np.array([drive_ratios(push(np.array([u]), body), body, limit).max(axis=0) for u in speed])
    remaining = survival(np.maximum(ratio, 0.0), speed, seconds, body.flow).transpose(1, 0, 2)
    return np.where(limit.known[:, None, None], remaining, np.nan)


def _scaled(limit: Resistance, factor: np.ndarray) -> Resistance:
    """Return the resistance with all pull-offs times a factor (place, 1)."""
    weight = limit.load * limit.hinge
    return limit._replace(moment=weight + (limit.moment - weight) * factor, pull_off=limit.pull_off * factor[:, 0])


def _with_band(out: xr.Dataset, if_pull_offs_err: list[xr.DataArray], places: int) -> xr.Dataset:
    """Return the mean over places, with the ends of its interval if there are at least two.

    Places share the errors of their pull-offs: the ends by all of them too small, and too large, are given.
    """
    mean = weighted_by_landing_share(out["remaining_at_place"]).mean("subregion")
    out["remaining"] = mean
    if places < 2:
        return out
    solved = out[["remaining_at_place"]].dropna("subregion")
    band = bootstrap(solved, "remaining_at_place", statistics=["mean"], confidence=_CONFIDENCE, resamples=_RESAMPLES)
    ends = band.sel(statistic="mean", drop=True).transpose("friction_velocity", "time")
    for end, sign, shifted in zip(("low", "high"), (-1, 1), if_pull_offs_err):
        width = np.hypot(ends[end].values - mean, weighted_by_landing_share(shifted).mean("subregion") - mean)
        out[f"remaining_{end}"] = (mean + sign * width).clip(0.0, 1.0)
    return out
