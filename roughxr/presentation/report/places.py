"""One row for each place of a run: where it is, how hard it sticks by either method, and in which flow it comes off."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ...vocabulary.verbs import verb

#: Group, variable and name in the table; of a variable with directions the weakest counts.
_COLUMNS = (
    ("statistics/rests", "landing_share", "landing_share"),
    ("statistics/rests", "carriers", "carriers"),
    ("statistics/rests", "barrier", "barrier"),
    ("statistics/adhesive", "pull_off_force", "pull_off_force"),
    ("solutions/adhesive", "pull_off_error", "pull_off_error"),
    ("statistics/energy", "pull_off_force", "pull_off_force_superposed"),
    ("statistics/menisci", "pull_off_force", "pull_off_force_superposed"),
    ("statistics/rigid", "pull_off_force", "pull_off_force_rigid"),
    ("solutions/rolling", "lever", "lever"),
    ("statistics/detachment", "critical_friction_velocity", "critical_friction_velocity"),
    ("statistics/detachment", "mode", "gives_way_first"),
    ("statistics/leaving", "leaving_friction_velocity", "leaving_friction_velocity"),
)


@verb
def by_place(run: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Return what a run says of each of its places, as far as it holds it.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run.

    Returns
    -------
    Dataset
        Along ``subregion``, with ``subregion_x``, ``subregion_y`` (nm): ``pull_off_force`` (nN) by the simulation with
        adhesion at its first preload, with ``pull_off_error`` where it was estimated, ``pull_off_force_superposed`` and
        ``pull_off_force_rigid``, the least ``lever`` (nm) over the directions, ``critical_friction_velocity`` (m/s) of
        air along x and what ``gives_way_first``. Of particles also ``landing_share``, ``carriers``, ``barrier`` (nm),
        see `resting`; ``leaving_friction_velocity`` (m/s), see `leaving`. `to_table` writes it.

    Examples
    --------
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [1.0, 2.0], {"units": "nN"})})
    >>> list(by_place({"statistics/adhesive": pull, "statistics/energy": 3 * pull}))
    ['pull_off_force', 'pull_off_force_superposed']
    """
    found = {}
    for group, variable, name in _COLUMNS:
        if group not in run or variable not in run[group]:
            continue
        one = run[group][variable]
        one = one.isel(preload=0, drop=True) if "preload" in one.dims else one
        one = one.min("direction", keep_attrs=True) if "direction" in one.dims else one
        if one.dims == ("subregion",):
            one = one.drop_vars([axis for axis in one.coords if axis not in ("subregion", *_PLACE)])
            # the numbers of rests are those of all rests of the scan
            found[name] = one.assign_coords(subregion=np.arange(one.size)) if "subregion" in one.coords else one
    return xr.Dataset(found)


_PLACE = ("subregion_x", "subregion_y")
