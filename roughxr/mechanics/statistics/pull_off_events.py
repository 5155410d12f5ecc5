"""The pull-off force at each place, by any method, and its ratio to that of a smooth sphere."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..bodies.pair_record import read_pair
from ..jobs.records import converged
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS, AUTO
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import IncompleteResult, warn

#: Variables by which solvers state the error of their pull-off.
_ERRORS = ("pull_off_resolution", "pull_off_error", "pressed_pull_off_force", "mesh", "cell_error")


@schema.verb("result")
def pull_off(ds: xr.Dataset) -> xr.Dataset:
    """Return the pull-off of each subregion: the largest adhesion force and its displacement.

    Parameters
    ----------
    ds : Dataset
        A solution. Other dimensions than ``delta`` are kept. `superpose` and `adhesive` find the pull-off at any
        displacement. For other solutions it is the largest adhesion force among the displacements of ``force``: too
        small if the sweep is coarse or too short.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN, a positive magnitude) and ``pull_off_delta`` (nm); NaN without adhesion. ``bracketed``
        is False if the largest adhesion force is at an end of the sweep, which was then too short. For a cycle it is
        False if the adhesion force is largest at the largest displacement, or the cycle is incomplete. A solver's own
        errors, such as ``pull_off_error`` and ``cell_error``, are kept, as is ``pressed_pull_off_force``.

    Raises
    ------
    ValueError
        If the sweep has no adhesion: that of `direct`, or with law="hertz".

    See Also
    --------
    pull_off_map : the exact pull-off of superposed asperities, without a sweep.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> sweep = xr.Dataset(
    ...     {"force": (("subregion", "delta"), [[0.0, -3.0, 1.0]])},
    ...     coords={"subregion": [0], "delta": [-1.0, 0.0, 1.0]},
    ... )
    >>> float(sweep.contact.pull_off().pull_off_force[0]), float(sweep.contact.pull_off().pull_off_delta[0])
    (3.0, 0.0)
    """
    if "pull_off_force" in ds and {"complete", "force", "roughness_factor"} & set(ds):
        out = _solver_pull_off(ds)
        method = "cycle" if "force" not in ds or "complete" in ds else "exact search"
    else:
        force = _adhesive_force(ds)
        method = "sweep"
        out = _largest_in_sweep(force, converged(ds))
    out.attrs = dict(ds.attrs)
    unsolved = ", or the largest adhesion force has not converged" if method == "sweep" else ""
    out.attrs["missing"] = f"NaN where nothing adheres at any displacement of the {method}{unsolved}"
    if method == "sweep" and not force.chunks:
        _warn_of_short_sweep(out, ds["delta"].values)
    return schema.label(out)


def _warn_of_short_sweep(out: xr.Dataset, delta: np.ndarray) -> None:
    """Warn of places at which the sweep ends before the pull-off."""
    pulls = out["pull_off_force"].notnull()
    short = int((pulls & ~out["bracketed"]).sum())
    never = int((~pulls).sum())
    if short or never:
        warn(
            f"the sweep from {delta[0]:g} to {delta[-1]:g} nm is too short for {short + never} of {pulls.size} places: "
            f"at {short} the adhesion force is largest at its end, at {never} there is none; take a longer sweep, or "
            "leave delta out",
            IncompleteResult,
        )


def _adhesive_force(ds: xr.Dataset) -> xr.DataArray:
    """Return the force of a sweep with adhesion; raise for other solutions."""
    if "force" not in ds or "delta" not in ds["force"].dims:
        advice = "run superpose, adhesive or rigid first"
        names = ", ".join(map(str, ds.data_vars))
        if "pull_off_force" in ds:
            advice = "it contains pull-off forces already"
        raise Refusal("", "a solution with 'force' along 'delta'", f"variables: {names}", advice)
    force = ds["force"]
    if force.sizes["delta"] < 2:
        raise Refusal("delta", "a sweep of at least two displacements to find the pull-off in", "one")
    elastic = ds.attrs.get("method") == "direct" or not ADHESION_LAWS[ds.attrs.get("law", AUTO)].adheres
    if elastic and (force.chunks is not None or not (force < 0).any()):
        raise Refusal(
            "", "a sweep with adhesion", "one without", "solve with adhesion: superpose(…, law='jkr') or adhesive(…)"
        )
    return force


def _largest_in_sweep(force: xr.DataArray, solved: xr.DataArray | bool) -> xr.Dataset:
    """Return the largest adhesion force among the displacements of a sweep; NaN if it has not converged."""
    least = force.min("delta")
    pulls = (least < 0) & ~((force == least) & ~(solved | force.isnull())).any("delta")
    filled = force.fillna(np.inf)
    where = filled.argmin("delta")
    at = filled.idxmin("delta")
    return xr.Dataset(
        {
            "pull_off_force": (-least).where(pulls),
            "pull_off_delta": at.where(pulls),
            "bracketed": pulls & (where > 0) & (where < force.sizes["delta"] - 1),
        }
    )


def _solver_pull_off(ds: xr.Dataset) -> xr.Dataset:
    """Return the solver's own pull-off, at any displacement."""
    bracketed = pulls = ds["pull_off_force"] > 0
    names = ["pull_off_force", *(name for name in ("pull_off_delta", *_ERRORS) if name in ds)]
    if "complete" in ds:
        bracketed = pulls & ds["complete"]
        if "delta" in ds.dims:
            bracketed = bracketed & (ds["pull_off_delta"] < ds["delta"].max())
    return ds[names].where(pulls).assign(bracketed=bracketed)


def smooth_pull_off(ds: xr.Dataset) -> float:
    """Return the pull-off force (nN) of the same sphere on a smooth flat: 3/2 π w R, or 2 π w R for a stiff pair.

    Stiff are `rigid`, sums over asperities with a range, and humid pairs, whose menisci act over distances larger than
    the deformation. For a humid pair, w is the work of the liquid and of the solids under it.

    Parameters
    ----------
    ds : Dataset
        Any Dataset with an assigned pair.

    Returns
    -------
    float

    References
    ----------
    Johnson, Kendall & Roberts (1971); Bradley (1932) for rigid bodies.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> pair = xr.Dataset(coords={"sphere_radius": 3000.0, "work_of_adhesion": 1.349})
    >>> round(roughxr.statistics.smooth_pull_off(pair))
    19071
    """
    summed_with_range = ds.attrs.get("method") == "superpose" and ADHESION_LAWS[ds.attrs["law"]].has_range
    pair = read_pair(ds, "sphere_radius", "work_of_adhesion")
    stiff = pair.menisci is not None or ds.attrs.get("method") == "rigid" or summed_with_range
    return pair.smooth_pull_off(stiff=stiff)


@schema.verb("forces")
def reduction(ds: xr.Dataset) -> xr.Dataset:
    """Return a pull-off with its ratio to that of the smooth sphere.

    Parameters
    ----------
    ds : Dataset
        A pull-off with its pair, along any dimensions.

    Returns
    -------
    Dataset
        With ``pull_off_ratio``, pull-off force over that of the same sphere on a smooth flat, unit 1.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import roughxr
    >>> forces = {"pull_off_force": ("subregion", [9.0, 18.0]), "pull_off_delta": ("subregion", [0.0, 0.0])}
    >>> pair = {"sphere_radius": 12 / np.pi, "work_of_adhesion": 2.0}
    >>> roughxr.statistics.reduction(xr.Dataset(forces, coords=pair)).pull_off_ratio.values.round(12).tolist()
    [0.25, 0.5]
    """
    smooth = smooth_pull_off(ds)
    if smooth <= 0:
        raise Refusal("", "a pair with work_of_adhesion > 0", "0", "assign one with assign_pair")
    return schema.label(ds.assign(pull_off_ratio=ds["pull_off_force"] / smooth))
