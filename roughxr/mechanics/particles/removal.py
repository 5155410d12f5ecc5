"""`removing_load`: the strength of a load that removes a share of the particles, with all known errors."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..statistics import bootstrap
from ..statistics.sampling import first_surface_of_each_place, mean_of_places, quantile_of_places
from ..vocabulary import schema
from ..vocabulary.error_sources import HALF_WIDTH, error_of_interval, symmetric_error, total_error
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Quantity, fraction
from .force_balance import NEITHER, NO_CONTACT, strength_of_places

#: Name of the load, and endings of the ends of its interval.
_NAME = "removing_load"
_ENDS = ("", "_low", "_high")


@schema.verb("critical_load")
def removing_load(ds: xr.Dataset, share: Quantity = 0.5) -> xr.Dataset:
    """Return the strength of a steady load that removes a share of the particles.

    Parameters
    ----------
    ds : Dataset
        Result of `critical_load`, without other conditions.
    share : number or quantity
        Share of the places in contact, or of the particles of `resting`, between 0 and 1 or as "90 %".

    Returns
    -------
    Dataset
        ``removing_load`` in the units of the critical load, with the 95 % interval ``removing_load_low`` …
        ``removing_load_high`` by places and by errors of the pull-off forces, which all places share; NaN for too few
        places. All are infinite if more particles than the others stay under any strength.

    Raises
    ------
    ValueError
        If ``ds`` has no critical load, or the share is not between 0 and 1.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> critical = roughxr.rolling(scan, directions=8, subregions=(4, 4)).contact.critical_load()
    >>> half, most = (roughxr.particles.removing_load(critical, share) for share in ("50 %", "90 %"))
    >>> bool(half.removing_load < most.removing_load), most.removing_load.units
    (True, 'm/s')
    """
    removed = fraction(share, "share")
    if "mode" not in ds:
        names = ", ".join(map(str, ds.data_vars))
        raise Refusal("critical_load", "a variable 'mode'", names, "pass the result of .contact.critical_load() whole")
    strength = strength_of_places(ds)
    moves = (ds["mode"] != NEITHER).where(ds["mode"] != NO_CONTACT)
    moving = mean_of_places(moves.astype(float))
    ends = (np.inf, np.inf, np.inf)
    if removed <= moving:
        ends = strength_quantile(ds, removed / moving)
    out = xr.Dataset({_NAME + end: value for end, value in zip(_ENDS, ends)})
    out = schema.label(out)
    for name in out.data_vars:
        out[name].attrs["units"] = strength.attrs["units"]
    out.attrs |= {"cause": ds.attrs.get("cause", ""), "share": removed, "confidence": 0.95}
    return out


def strength_quantile(critical: xr.Dataset, share: float = 0.5) -> tuple[float, float, float]:
    """Return a quantile of a critical load where it moves the sphere, with the ends of its 95 % interval.

    Places share the errors of their pull-offs; those of levers are part of the scatter of the places. Too few places
    have NaN for an interval.
    """
    name = str(next(iter(critical.data_vars)))
    detaching = strength_of_places(critical).dropna("subregion").to_dataset(name=name)
    if not detaching.sizes["subregion"]:
        return (np.nan, np.nan, np.nan)
    first_surfaces = first_surface_of_each_place(detaching)  # surfaces of a place are alike
    if first_surfaces.sizes["subregion"] < 2:
        return (float(detaching[name].quantile(share)), np.nan, np.nan)
    label = f"q{100 * share:.10g}"
    quantile = bootstrap(detaching, name, statistics=[label], within=first_surfaces).isel(statistic=0)
    value, low, high = (float(quantile[part]) for part in ("estimate", "low", "high"))
    errors = critical["shared_load_error"].dropna("subregion")
    shared = float(np.log1p(quantile_of_places(errors, 0.5))) if errors.size else 0.0
    if value == 0.0:  # so many spheres roll off by themselves
        return (value, low, high * float(np.exp(shared)))
    if np.isnan(low):
        return (value, low, high)
    with np.errstate(divide="ignore"):
        error = total_error([error_of_interval(value, low, high), symmetric_error(shared / HALF_WIDTH)])
    return (value, *error.interval(value))
