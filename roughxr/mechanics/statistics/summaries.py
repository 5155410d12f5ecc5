"""A table of mean, standard deviation, extremes and quantiles."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from .sampling import (
    SAMPLES,
    map_samples,
    sample_bounds,
    standard_deviation,
    warn_of_missing,
    weighted_by_landing_share,
)


@schema.verb("result")
def summary(ds: xr.Dataset, *, quantiles: Sequence[float] = (0.05, 0.25, 0.5, 0.75, 0.95)) -> xr.Dataset:
    """Return mean, standard deviation, extremes and quantiles over subregions or asperities.

    Parameters
    ----------
    ds : Dataset
        Every numeric variable along ``subregion`` or ``asperity`` is summarised; other dimensions are kept. If
        all lie along ``x`` and ``y``, as in a map, every pixel is a sample.
    quantiles : sequence of float
        Between 0 and 1.

    Returns
    -------
    Dataset
        The same variables along ``statistic``: count (finite samples), mean, std, min, max and ``q…`` for each
        quantile, in per cent. Samples are weighted by their ``landing_share`` if there is one, as in `bootstrap`. If
        pull-off forces are known by limits, ``pull_off_force_low`` and ``pull_off_force_high`` have all of them at
        their lower and upper ends, in place of ``pull_off_force``.

    Raises
    ------
    ValueError
        If ``ds`` has neither places nor asperities.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> ds = xr.Dataset({"height": ("asperity", [1.0, 2.0, 3.0], {"units": "nm"})})
    >>> table = ds.contact.summary()
    >>> float(table.height.sel(statistic="mean")), float(table.height.sel(statistic="q50"))
    (2.0, 2.0)
    """
    ds = map_samples(ds)
    dim = next((dim for dim in SAMPLES if dim in ds.dims), None)
    if dim is None:
        raise Refusal("", f"a dimension {' or '.join(SAMPLES)}", tuple(ds.dims))
    ds = _with_bounds(ds)
    wanted = {name: array for name, array in ds.data_vars.items() if dim in array.dims and array.dtype.kind in "fiu"}
    names_by_reason: dict[tuple, list[str]] = {}
    for name, array in wanted.items():
        if not array.chunks:  # do not compute lazy values
            missing = int(array.isnull().any([other for other in array.dims if other != dim]).sum())
            reason = array.attrs.get("missing", ds.attrs.get("missing"))
            names_by_reason.setdefault((missing, array.sizes[dim], reason), []).append(str(name))
    for counts_and_reason, names in names_by_reason.items():
        warn_of_missing(", ".join(names), *counts_and_reason)
    rows = {name: _summarised(array, dim, list(quantiles)).assign_attrs(array.attrs) for name, array in wanted.items()}
    return xr.Dataset(rows, attrs=ds.attrs)


def _with_bounds(ds: xr.Dataset) -> xr.Dataset:
    """Return a Dataset with the lower and upper ends of pull-off forces in their place if some are limits."""
    name = "pull_off_force"
    if name not in ds or ds[name].chunks:
        return ds
    low, high = sample_bounds(ds, name)
    if np.array_equal(low, high, equal_nan=True):
        return ds
    force = ds[name]
    return ds.drop_vars(name).assign({f"{name}_low": force.copy(data=low), f"{name}_high": force.copy(data=high)})


def _summarised(array: xr.DataArray, dim: str, quantiles: list[float]) -> xr.DataArray:
    array = array.astype(float).chunk({dim: -1}) if array.chunks else array.astype(float)
    counted = weighted_by_landing_share(array)
    parts = {
        "count": array.notnull().sum(dim).astype(float),
        "mean": counted.mean(dim),
        "std": standard_deviation(array, dim),
        "min": array.min(dim),
        "max": array.max(dim),
    }
    with warnings.catch_warnings():  # the count is 0 there
        warnings.filterwarnings("ignore", "All-NaN slice encountered", RuntimeWarning)
        parts |= {f"q{100 * q:g}": counted.quantile(q, dim=dim).drop_vars("quantile") for q in quantiles}
    names = xr.DataArray(list(parts), dims="statistic", name="statistic")
    return xr.concat(list(parts.values()), dim=names, coords="minimal", compat="override")
