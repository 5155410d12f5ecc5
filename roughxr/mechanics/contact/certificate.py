"""Check the conditions of a contact solution: each violation, with its limit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from ..jobs.records import FIELDS
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal

#: Largest relative error of a pull-off by mesh and step, unless the solution states another accuracy.
_ACCURACY = 0.05

#: Largest relative amount by which a pull-off may leave what the states of its retraction allow.
_PULL_OFF_TOLERANCE = 0.05

#: Share of the work between two states that a jump may dissipate where the pull-off is bounded by that work.
_JUMP = 0.05

#: Methods whose solutions can be checked.
SOLVED = ("direct", "adhesive", "rigid")


@schema.recorded
def certificate(ds: xr.Dataset) -> xr.Dataset:
    """Return the largest violation of each contact condition that a solution states, with its limit.

    Parameters
    ----------
    ds : Dataset
        Solution of `direct`, `adhesive` or `rigid` at places.

    Returns
    -------
    Dataset
        Along ``check``: ``violation``, the largest over all places and states, its ``limit`` and whether it is
        ``met``. An unknown violation is NaN and counts as not met. "unconverged" and "truncated" are shares of the
        solves, "residual" the largest of the solver's, "load" the relative difference from the prescribed
        load, "mesh" the stated error of the pull-off, "pull_off" by how much the pull-off force leaves what the states
        of a retraction allow, beyond its stated error: at least their largest pull, at most what the work between the
        two states around it allows.

    Raises
    ------
    ValueError
        If ``ds`` is no solution of these methods along places.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, young_modulus=75, poisson_ratio=0.2)
    >>> roughxr.certificate(scan.contact.direct(load=[1000.0])).met.to_series().to_dict()
    {'unconverged': True, 'residual': True, 'load': True, 'truncated': True}
    """
    ds = schema.entered_dataset(ds, "result")
    ds = schema.in_memory(ds.drop_vars(FIELDS, errors="ignore"))  # which may be larger than memory
    method = ds.attrs.get("method")
    if method not in SOLVED or ("converged" not in ds and method != "rigid"):
        raise Refusal("", f"a solution of {', '.join(SOLVED)} along subregion", f"method={method!r}")
    conditions = list(_solver_conditions(ds))
    violations = np.array([float(value.max(skipna=False)) for _, value, _ in conditions])
    limits = np.array([limit for _, _, limit in conditions], float)
    rows = {"violation": violations, "limit": limits, "met": violations <= limits}
    out = xr.Dataset(
        {name: ("check", values) for name, values in rows.items()}, {"check": [name for name, _, _ in conditions]}
    )
    return schema.label(out.assign_attrs(method=method))


def _solver_conditions(ds: xr.Dataset) -> Iterator[tuple[str, xr.DataArray, float]]:
    """Yield name, values and limit of the sums that the solver reports."""
    tolerance = ds.attrs.get("tolerance", np.nan)
    if "converged" in ds:  # rigid bodies need no iterations
        yield "unconverged", 1 - ds["converged"].astype(bool).mean(), 0.0
    if "residual" in ds:
        yield "residual", ds["residual"], tolerance
    if "load" in ds.dims:
        yield "load", abs(ds["force"] / ds["load"] - 1), tolerance
    yield "truncated", ds["truncated"].astype(bool).mean(), 0.0
    for name in {"pull_off_error", "cell_error"} & set(ds):
        yield "mesh", abs(ds[name]), ds.attrs.get("accuracy", _ACCURACY)
    if "pull_off_delta" in ds and "branch" in ds.dims:
        yield "pull_off", _pull_off_violation(ds), _PULL_OFF_TOLERANCE


def _pull_off_violation(ds: xr.Dataset) -> xr.DataArray:
    """Return by how much a pull-off leaves what its states allow, beyond its stated error."""
    least, most = _pulls_of_states(ds)
    pull_off = ds["pull_off_force"]
    below, above = least / pull_off - 1, pull_off / most - 1
    outside = xr.where(below > above, below, above) - ds["pull_off_error"].fillna(0.0)
    return outside.clip(min=0).where(least > 0, 0.0)


def _pulls_of_states(ds: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the smallest and the largest pull-off force (nN) that the states of a retraction allow.

    From the state before the pull-off to the pull-off a contact only shrinks, so that its stiffness falls and the pull
    is concave; from there to the next state the pull falls. With the work between the two states both bound the
    largest pull. Without such states, or if a jump lies between them, the upper bound is infinite.
    """
    states = ds[["force", "energy", "dissipated"]].sel(branch="retraction")
    least = (-states["force"]).max("delta")
    before = states["delta"].where(states["delta"] > ds["pull_off_delta"]).min("delta")
    after = states["delta"].where(states["delta"] <= ds["pull_off_delta"]).max("delta")
    known = before.notnull() & after.notnull()
    first = states.sel(delta=before.fillna(states["delta"][0]))
    second = states.sel(delta=after.fillna(states["delta"][0]))
    jump = second["dissipated"] - first["dissipated"]
    work = second["energy"] - first["energy"] + jump
    falling = -second["force"] * (ds["pull_off_delta"] - after)
    most = 2 * (work - falling) / (before - ds["pull_off_delta"]) + first["force"]
    return least, most.where(known & (jump < _JUMP * work), np.inf)
