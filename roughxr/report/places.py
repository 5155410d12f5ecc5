"""One row for each place of a run: where it is, how hard it sticks by either method, and in which flow it comes off."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ..statistics.sampling import at_first_preload
from ..vocabulary import schema
from .summary import mesh_change

PLACES = "statistics/places"

#: What is known of some places only, as a group.
_PARTIAL_GROUP = "some"

#: Group, variable and name in the table; of a variable with directions the mean over these.
_COLUMNS = (
    ("statistics/rests", "landing_share", "landing_share"),
    ("statistics/rests", "carriers", "carriers"),
    ("statistics/rests", "barrier", "barrier"),
    ("statistics/adhesive", "pull_off_force", "pull_off_force"),
    (_PARTIAL_GROUP, "pull_off_error", "pull_off_error"),
    (_PARTIAL_GROUP, "pull_off_force_extrapolated", "pull_off_force_extrapolated"),
    ("statistics/energy", "pull_off_force", "pull_off_force_superposed"),
    ("statistics/rigid", "pull_off_force", "pull_off_force_rigid"),
    ("solutions/rolling", "lever", "lever"),
    ("statistics/detachment", "critical_friction_velocity", "critical_friction_velocity"),
    ("statistics/detachment", "mode", "gives_way_first"),
)


def by_place(run: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Return what a run says of each of its places, as far as it holds it."""
    if PLACES in run:
        return run[PLACES]
    run, columns = {**run, _PARTIAL_GROUP: _of_some(run)}, {}
    for group, variable, name in _COLUMNS:
        if group not in run or variable not in run[group]:
            continue
        one = at_first_preload(run[group][variable])
        one = one.mean("direction", keep_attrs=True) if "direction" in one.dims else one
        if one.dims == ("subregion",):
            one = one.drop_vars([axis for axis in one.coords if axis not in ("subregion", *_PLACE)])
            # the numbers of rests are those of all rests of the scan
            columns[name] = one.assign_coords(subregion=np.arange(one.size)) if "subregion" in one.coords else one
    return xr.Dataset(columns)


_PLACE = ("subregion_x", "subregion_y")


def with_mesh_error(run: Mapping[str, xr.Dataset]) -> dict[str, xr.Dataset]:
    """Return a run whose pull-offs state their error by mesh and step, where only a finer solution shows it."""
    solved = run["solutions/adhesive"]
    if "pull_off_error" in solved and bool(solved["pull_off_error"].notnull().any()):
        return dict(run)
    error = _among(solved, abs(mesh_change(run)))
    names = ("solutions/adhesive", "statistics/adhesive")
    return {**run, **{name: schema.label(run[name].assign(pull_off_error=error.variable)) for name in names}}


def _of_some(run: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Return what was computed at some places only, NaN at the others."""
    places, columns = run.get("solutions/adhesive", xr.Dataset()), {}
    if "pull_off_error" in places and bool(places["pull_off_error"].notnull().any()):
        columns["pull_off_error"] = places["pull_off_error"]
    if "solutions/extrapolated" in run:
        extrapolated = run["solutions/extrapolated"]["pull_off_force"].mean("seed", keep_attrs=True)
        columns["pull_off_force_extrapolated"] = _among(places, extrapolated)
    return xr.Dataset(columns)


def _among(places: xr.Dataset, some: xr.DataArray) -> xr.DataArray:
    """Return the values of some places at all of them."""
    some = at_first_preload(some)
    known = dict(zip(zip(*(some[axis].values for axis in _PLACE)), some.values))
    values = [known.get(place, np.nan) for place in zip(*(places[axis].values for axis in _PLACE))]
    return xr.DataArray(values, {axis: places[axis] for axis in _PLACE}, ["subregion"], attrs=some.attrs)
