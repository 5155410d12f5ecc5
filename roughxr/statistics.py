"""From many places to distributions: pull-off of each subregion, densities, and their summary.

The samples lie along ``subregion`` or ``asperity``; NaN stands for a place where there was nothing to
measure, is left out, and counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from . import schema

#: Dimensions along which samples lie.
SAMPLES = ("subregion", "asperity")


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
        raise ValueError(
            "delta: expected a sweep of at least two displacements to find the pull-off in, found one"
        )
    return ds["force"]


def pdf(
    ds: xr.Dataset, name: str, *, method: str = "histogram", bins: Any = "auto", bandwidth: Any = None
) -> xr.DataArray:
    """Return the probability density of a variable over its subregions or asperities.

    Parameters
    ----------
    ds : Dataset
    name : str
        A variable along ``subregion`` or ``asperity`` and no other dimension: select one displacement first.
    method : {"histogram", "kde"}
        Densities of bins, or a Gaussian kernel estimate.
    bins : int, str or array
        As `numpy.histogram_bin_edges` takes them (histogram).
    bandwidth : str, float, optional
        As `scipy.stats.gaussian_kde` takes them (kde); Scott's rule by default.

    Returns
    -------
    DataArray
        ``pdf`` (1/unit of the variable, integrating to 1) along the variable's own name, with ``cdf`` beside it;
        ``bin_edges`` or ``bandwidth`` are kept, ``samples`` and ``missing`` counted. ``.to_dataset()`` makes
        ``pdf`` and ``cdf`` variables of one Dataset.

    Raises
    ------
    ValueError
        If there is no such variable, it has other dimensions, or fewer than two finite samples.

    Examples
    --------
    >>> ds = xr.Dataset({"height": ("asperity", [1.0, 2.0, 2.0, 3.0], {"units": "nm"})})
    >>> density = pdf(ds, "height", bins=2)
    >>> density.values.tolist(), density.units, float(density.cdf[-1])
    ([0.25, 0.75], 'nm-1', 1.0)
    """
    schema.one_of(method, ("histogram", "kde"), "method")
    samples, missing = _samples(ds, name)
    density = _histogram(samples, bins) if method == "histogram" else _kernel_density(samples, bandwidth)
    points, values, cumulative, extra = density
    units = ds[name].attrs.get("units", "1")
    axis = (name, points, dict(ds[name].attrs))
    out = xr.DataArray(values, dims=name, coords={name: axis, "cdf": (name, cumulative)}, name="pdf")
    out["cdf"].attrs.update(schema.attributes("cdf"))
    out.attrs = {"units": _per(units), "long_name": "probability density", "method": method}
    out.attrs |= {"samples": samples.size, "missing": missing, **extra}
    return out


def _samples(ds: xr.Dataset, name: str) -> tuple[np.ndarray, int]:
    if name not in ds:
        raise ValueError(f"{name}: expected one of {', '.join(map(str, ds.data_vars))}")
    if len(ds[name].dims) != 1 or ds[name].dims[0] not in SAMPLES:
        raise ValueError(
            f"{name}: expected one dimension, {' or '.join(SAMPLES)}, found {tuple(ds[name].dims)}; "
            "select first, for example ds.sel(delta=10, method='nearest')"
        )
    values = np.asarray(ds[name].values, dtype=float)
    samples = values[np.isfinite(values)]
    if samples.size < 2:
        raise ValueError(
            f"{name}: expected at least two finite samples, found {samples.size} of {values.size}"
        )
    return samples, int(values.size - samples.size)


def _histogram(samples: np.ndarray, bins: Any) -> tuple:
    density, edges = np.histogram(samples, bins=bins, density=True)
    cumulative = np.cumsum(density * np.diff(edges))
    return (edges[:-1] + edges[1:]) / 2, density, cumulative, {"bin_edges": edges}


def _kernel_density(samples: np.ndarray, bandwidth: Any, points: int = 512) -> tuple:
    """Return the Gaussian estimate on a grid that holds all but 1e-9 of it."""
    from scipy.special import ndtr
    from scipy.stats import gaussian_kde

    if np.ptp(samples) == 0:
        raise ValueError(
            "expected samples that differ for a kernel estimate, found equal ones; use method='histogram'"
        )
    estimate = gaussian_kde(samples, bw_method=bandwidth)
    width = float(np.sqrt(estimate.covariance[0, 0]))
    grid = np.linspace(samples.min() - 6 * width, samples.max() + 6 * width, points)
    cumulative = ndtr((grid[:, None] - samples) / width).mean(axis=1)
    return grid, estimate(grid), cumulative, {"bandwidth": width}


def _per(units: str) -> str:
    """Return the units of a density over ``units``."""
    return {"1": "1", "nm-1": "nm", "nm2": "nm-2", "J m-2": "m2 J-1"}.get(units, f"{units}-1")


def summary(ds: xr.Dataset, *, quantiles: Sequence[float] = (0.05, 0.25, 0.5, 0.75, 0.95)) -> xr.Dataset:
    """Return mean, standard deviation, extremes and quantiles over subregions or asperities.

    Parameters
    ----------
    ds : Dataset
        Every numeric variable along ``subregion`` or ``asperity`` is summarised; other dimensions are kept.
    quantiles : sequence of float
        Between 0 and 1.

    Returns
    -------
    Dataset
        The same variables along ``statistic``: count (finite samples), mean, std (with n − 1), min, max and
        one ``q…`` for each quantile, in per cent.

    Examples
    --------
    >>> ds = xr.Dataset({"height": ("asperity", [1.0, 2.0, 3.0], {"units": "nm"})})
    >>> table = summary(ds)
    >>> float(table.height.sel(statistic="mean")), float(table.height.sel(statistic="q50"))
    (2.0, 2.0)
    """
    along = [dim for dim in SAMPLES if dim in ds.dims]
    if not along:
        raise ValueError(f"expected a dimension {' or '.join(SAMPLES)}, found {tuple(ds.dims)}")
    dim = along[0]
    numeric = [name for name in ds.data_vars if dim in ds[name].dims and ds[name].dtype.kind in "fiu"]
    out = xr.Dataset({name: _summarised(ds[name], dim, list(quantiles)) for name in numeric})
    for name in numeric:
        out[name].attrs.update(ds[name].attrs)
    out.attrs = dict(ds.attrs)
    return schema.record(out, "summary", quantiles=list(quantiles))


def _summarised(array: xr.DataArray, dim: str, quantiles: list[float]) -> xr.DataArray:
    array = array.astype(float).chunk({dim: -1}) if array.chunks else array.astype(float)
    parts = {
        "count": array.notnull().sum(dim).astype(float),
        "mean": array.mean(dim),
        "std": array.std(dim, ddof=1),
        "min": array.min(dim),
        "max": array.max(dim),
    }
    parts |= {f"q{100 * q:g}": array.quantile(q, dim).drop_vars("quantile") for q in quantiles}
    names = xr.DataArray(list(parts), dims="statistic", name="statistic")
    return xr.concat(list(parts.values()), dim=names, coords="minimal", compat="override")
