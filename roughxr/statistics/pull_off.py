"""Pull-off: the largest pull of each subregion's sweep, and what roughness leaves of the smooth sphere's."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .. import schema


def pull_off(ds: xr.Dataset) -> xr.Dataset:
    """Return the largest pull of each subregion's sweep, and where it was.

    Parameters
    ----------
    ds : Dataset
        A solution with ``force`` along ``delta``. Other dimensions are kept.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN, a positive magnitude) and ``pull_off_delta`` (nm); NaN where nothing pulls.
        ``bracketed`` is False where the largest pull stands at an end of the sweep, which then was too short.

    Raises
    ------
    ValueError
        If ``ds`` is no solution, or its sweep has fewer than two displacements.

    Examples
    --------
    >>> sweep = xr.Dataset(
    ...     {"force": (("subregion", "delta"), [[0.0, -3.0, 1.0]])},
    ...     coords={"subregion": [0], "delta": [-1.0, 0.0, 1.0]},
    ... )
    >>> float(pull_off(sweep).pull_off_force[0]), float(pull_off(sweep).pull_off_delta[0])
    (3.0, 0.0)
    """
    force = _sweep(ds)
    least = force.min("delta")
    pulls = least < 0
    where = force.fillna(np.inf).argmin("delta")
    at = xr.apply_ufunc(
        lambda k, delta: delta[k],
        where,
        kwargs={"delta": ds["delta"].values},
        dask="parallelized",
        output_dtypes=[float],
    )
    out = xr.Dataset(
        {
            "pull_off_force": (-least).where(pulls),
            "pull_off_delta": at.where(pulls),
            "bracketed": pulls & (where > 0) & (where < ds.sizes["delta"] - 1),
        }
    )
    out.attrs = {key: value for key, value in ds.attrs.items() if key != "history"}
    out.attrs["missing"] = "NaN where no displacement of the sweep pulls"
    return schema.record(schema.label(out), "pull_off", ds)


def _sweep(ds: xr.Dataset) -> xr.DataArray:
    if "force" not in ds or "delta" not in ds["force"].dims:
        raise ValueError(
            f"expected a solution with 'force' along 'delta', found variables: {', '.join(map(str, ds.data_vars))}"
        )
    if ds.sizes["delta"] < 2:
        raise ValueError("delta: expected a sweep of at least two displacements to find the pull-off in, found one")
    return ds["force"]


def smooth_pull_off(ds: xr.Dataset) -> float:
    """Return the pull-off force (nN) of the same sphere from a smooth flat, 3/2 π w R.

    Parameters
    ----------
    ds : Dataset
        With an assigned pair.

    Returns
    -------
    float

    References
    ----------
    Johnson, Kendall & Roberts (1971); all formulations agree on a sphere.

    Examples
    --------
    >>> pair = xr.Dataset(coords={"sphere_radius": 3000.0, "work_of_adhesion": 1.349})
    >>> round(smooth_pull_off(pair))
    19071
    """
    radius, work = schema.pair(ds, "sphere_radius", "work_of_adhesion")
    return 1.5 * np.pi * work * radius


def reduction(ds: xr.Dataset) -> xr.Dataset:
    """Return a pull-off with its part of the smooth sphere's beside it.

    Parameters
    ----------
    ds : Dataset
        A pull-off with its pair.

    Returns
    -------
    Dataset
        With ``pull_off_ratio``, pull-off force over that of the same sphere from a smooth flat, unit 1.

    Raises
    ------
    ValueError
        If ``ds`` is no pull-off, or has no pair with adhesion.

    Examples
    --------
    >>> forces = {"pull_off_force": ("subregion", [9.0, 18.0]), "pull_off_delta": ("subregion", [0.0, 0.0])}
    >>> pair = {"sphere_radius": 12 / np.pi, "work_of_adhesion": 2.0}
    >>> reduction(xr.Dataset(forces, coords=pair)).pull_off_ratio.values.round(12).tolist()
    [0.25, 0.5]
    """
    ds = schema.validate(ds, "pull_off")
    smooth = smooth_pull_off(ds)
    if smooth <= 0:
        raise ValueError("expected a pair with work_of_adhesion > 0, found 0; assign one with assign_pair")
    out = schema.label(ds.assign(pull_off_ratio=ds["pull_off_force"] / smooth))
    return schema.record(out, "reduction", ds)
