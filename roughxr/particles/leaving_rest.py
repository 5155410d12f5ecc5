"""`leaving`: what drives a particle out of its place of rest and over the lowest pass, instead of only rocking it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..asperity.catalogue import asperities
from ..asperity.moments import rolling
from ..vocabulary import schema
from ..vocabulary.units import Quantity
from ..vocabulary.verbs import verb
from .force_balance import body_of, critical_load, first_strength, held_of, load_of, recorded
from .loads import Flow, Load, weight

#: Directions of rolling, that nearest to the pass among them.
_DIRECTIONS = 24


@verb
def leaving(
    ds: xr.Dataset,
    places: xr.Dataset,
    load: str | Load = "wall_shear",
    *,
    particle_density: Quantity | None = None,
    flow: str | Flow = "air",
) -> xr.Dataset:
    """Return the smallest strength of a load at which particles leave their basins over the lowest pass.

    Parameters
    ----------
    ds : Dataset
        A scan or an asperity catalogue with an assigned pair; asperities carry the particle as in `rolling`.
    places : Dataset
        Result of `resting` by gravity, or some of its places.
    load, particle_density, flow
        As for `critical_load`; the load pushes towards the pass.

    Returns
    -------
    Dataset
        Along subregion: ``leaving_friction_velocity`` (m/s), ``leaving_acceleration`` (m/s²) or ``leaving_angle``
        (rad), at which both moments towards the pass are overcome; beside it that of `critical_load` towards the
        weakest direction, at which the particle first rocks; ``barrier`` (nm), ``pass_direction`` (rad),
        ``rest_moment`` and ``pass_moment`` (nN nm), what is resisted towards the pass at rest and on the pass. NaN
        where there is no pass, or no strength suffices.

    Raises
    ------
    ValueError
        If ``places`` have no passes, or as for `critical_load`.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> found = leaving(scan, roughxr.resting(scan).isel(subregion=[500, 600]))
    >>> bool((found.leaving_friction_velocity >= 0.99 * found.critical_friction_velocity).all())
    True
    """
    if "pass_x" not in places or "barrier" not in places:
        raise ValueError("places: expected a result of resting(settle='gravity'), found no passes (pass_x)")
    catalogue = ds if "asperity" in ds.dims else asperities(ds)
    known = np.isfinite(places["pass_x"].values)
    if not known.any():
        raise ValueError("places: expected at least one place that a particle can leave over a pass, found none")
    kind, body = load_of(load), body_of(catalogue, particle_density, flow)
    down = 0.0 if np.isnan(body.density) else float(weight(body.radius, body.density, gravity=body.gravity))
    passes = tuple(np.where(known, places[f"pass_{axis}"], places[f"subregion_{axis}"]) for axis in "xy")
    rest, over = (rolling(catalogue, directions=_DIRECTIONS, load=down, subregions=at) for at in (places, passes))
    off = [there - places[f"subregion_{axis}"].values for there, axis in zip(passes, "xy")]
    towards = np.arctan2(off[1], off[0])
    angles = rest["direction"].values  # the one nearest to the pass counts alone
    share = np.eye(angles.size)[np.cos(angles - towards[:, None]).argmax(axis=1)]
    strengths = [
        first_strength(kind, body, held_of(one, 0.0, None, None)._replace(share=share))[0] for one in (rest, over)
    ]
    moments = [np.where(share > 0, one["resisting_moment"].values, 0.0).sum(axis=1) for one in (rest, over)]
    out = critical_load(rest, load, direction="weakest", particle_density=particle_density, flow=flow)
    name = kind.critical.replace("critical", "leaving")
    columns = {name: np.maximum(*strengths), "rest_moment": moments[0], "pass_moment": moments[1]}
    columns |= {"pass_direction": towards, "barrier": places["barrier"].values}
    out = out.assign({key: ("subregion", np.where(known, values, np.nan)) for key, values in columns.items()})
    return schema.record(
        schema.label(out), "leaving", ds, load=out.attrs["load"], particle_density=particle_density, **recorded(body)
    )
