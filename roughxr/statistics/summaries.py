"""A table of mean, standard deviation, extremes and quantiles."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import xarray as xr

from .. import schema
from .sampling import SAMPLES, of_a_map, speak_for_some


def summary(
    ds: xr.Dataset, *, quantiles: Sequence[float] = (0.05, 0.25, 0.5, 0.75, 0.95), weights: Any = None
) -> xr.Dataset:
    """Return mean, standard deviation, extremes and quantiles over subregions or asperities.

    Parameters
    ----------
    ds : Dataset
        Every numeric variable along ``subregion`` or ``asperity`` is summarised; other dimensions are kept. Where
        all lie along ``x`` and ``y``, as in a map, every pixel is a sample.
    quantiles : sequence of float
        Between 0 and 1.
    weights : str or DataArray, optional
        What each sample counts for: a variable of ``ds``, or an array along its samples.

    Returns
    -------
    Dataset
        The same variables along ``statistic``: count (finite samples), mean, std (with n − 1; with weights the
        root of the weighted mean square), min, max and one ``q…`` for each quantile, in per cent.

    Raises
    ------
    ValueError
        If nothing lies along ``subregion`` or ``asperity``.

    Examples
    --------
    >>> ds = xr.Dataset({"height": ("asperity", [1.0, 2.0, 3.0], {"units": "nm"})})
    >>> table = summary(ds)
    >>> float(table.height.sel(statistic="mean")), float(table.height.sel(statistic="q50"))
    (2.0, 2.0)
    """
    ds = of_a_map(ds)
    along = [dim for dim in SAMPLES if dim in ds.dims]
    if not along:
        raise ValueError(f"expected a dimension {' or '.join(SAMPLES)}, found {tuple(ds.dims)}")
    dim = along[0]
    weight = ds[weights] if isinstance(weights, str) else weights
    names = [name for name in ds.data_vars if dim in ds[name].dims and ds[name].dtype.kind in "fiu"]
    names = [name for name in names if name != weights] if isinstance(weights, str) else names
    for name in names:
        if not ds[name].chunks:
            missing = int(ds[name].isnull().any([d for d in ds[name].dims if d != dim]).sum())
            speak_for_some(str(name), missing, ds.sizes[dim], ds.attrs.get("missing"))
    out = xr.Dataset({name: _summarised(ds[name], dim, list(quantiles), weight) for name in names})
    for name in names:
        out[name].attrs.update(ds[name].attrs)
    out.attrs = dict(ds.attrs)
    return schema.record(out, "summary", quantiles=list(quantiles))


def _summarised(array: xr.DataArray, dim: str, quantiles: list[float], weights: xr.DataArray | None) -> xr.DataArray:
    array = array.astype(float).chunk({dim: -1}) if array.chunks else array.astype(float)
    counted = array if weights is None else array.weighted(weights)
    spread = array.std(dim, ddof=1) if weights is None else counted.std(dim)
    parts = {
        "count": array.notnull().sum(dim).astype(float),
        "mean": counted.mean(dim),
        "std": spread,
        "min": array.min(dim),
        "max": array.max(dim),
    }
    with warnings.catch_warnings():  # where nothing is known, the table says so by its count
        warnings.filterwarnings("ignore", "All-NaN slice encountered", RuntimeWarning)
        parts |= {f"q{100 * q:g}": counted.quantile(q, dim=dim).drop_vars("quantile") for q in quantiles}
    names = xr.DataArray(list(parts), dims="statistic", name="statistic")
    return xr.concat(list(parts.values()), dim=names, coords="minimal", compat="override")
