"""Densities and cumulative probabilities of a variable over its subregions or asperities."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import carries_units, plain
from .sampling import Samples, density_units, limit_attributes, other_dimensions, samples


def pdf(
    ds: xr.Dataset,
    name: str = "pull_off_force",
    *,
    bins: int | str | ArrayLike = "auto",
) -> xr.DataArray:
    """Return the probability density of a variable over its subregions or asperities.

    Parameters
    ----------
    ds : Dataset
    name : str
        A variable along ``subregion`` or ``asperity``, or a map; other dimensions, such as the displacements of a
        sweep, are kept. Samples are weighted by their ``landing_share`` if there is one.
    bins : int, str or array
        As for `numpy.histogram_bin_edges`, of all samples together; edges in the variable's units or with their own.

    Returns
    -------
    DataArray
        ``pdf`` (1/unit of the variable, integrating to 1) along the variable's own name, and along the other dimensions
        with the same bins, with the coordinate ``cdf``; the attributes contain ``bin_rule``, ``bin_edges`` and the
        numbers of all ``samples`` and of ``missing`` ones. A pull-off force that is known to lie below a limit counts
        with equal density from 0 to the limit. One that is known to lie above a limit is in no bin: the density then
        integrates to the share of the others. The attributes ``limits_below`` and
        ``limits_above`` count both, ``largest_limit`` and ``least_limit`` (nN) are their ends.
        ``.to_dataset()`` makes ``pdf`` and ``cdf`` variables of one Dataset.

    Raises
    ------
    ValueError
        If the variable has no samples along places, asperities or a map, or ``bins`` is no rule, number or edges.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> ds = xr.Dataset({"height": ("asperity", [1.0, 2.0, 2.0, 3.0], {"units": "nm"})})
    >>> density = ds.contact.pdf("height", bins=2)
    >>> density.values.tolist(), density.units, float(density.cdf[-1])
    ([0.25, 0.75], '1/nm', 1.0)
    >>> forces = [[0.0, 0.0], [0.0, 2.0], [1.0, 3.0], [1.0, 3.0]]
    >>> sweep = xr.Dataset({"force": (("subregion", "delta"), forces, {"units": "nN"})}, {"delta": [5.0, 15.0]})
    >>> sweep.contact.pdf("force", bins=3).sel(delta=15).values.tolist()
    [0.25, 0.0, 0.75]
    """
    ds = schema.entered_dataset(ds, "result")
    others = other_dimensions(ds, name)
    if others:
        return _pdf_along(ds, name, others[0], bins)
    sample = samples(ds, name)
    units = ds[name].attrs.get("units", "1")
    ends = sample.values if sample.bounds is None else sample.bounds[np.isfinite(sample.bounds)]
    edges = _bin_edges(ends, bins, units)
    values = binned_density(sample, edges)
    points, cumulative = (edges[:-1] + edges[1:]) / 2, np.cumsum(values * np.diff(edges))
    axis = (name, points, dict(ds[name].attrs))
    out = xr.DataArray(values, dims=name, coords={name: axis, "cdf": (name, cumulative)}, name="pdf")
    out["cdf"].attrs.update(schema.attributes("cdf"))
    out.attrs = {"units": density_units(units), "long_name": "probability density", "method": "histogram"}
    out.attrs |= {"bin_rule": bins if isinstance(bins, str) else "given", "bin_edges": edges}
    out.attrs |= {"samples": sample.values.size, "missing": sample.missing}
    return out.assign_attrs(limit_attributes(sample.bounds))


def binned_density(sample: Samples, edges: np.ndarray) -> np.ndarray:
    """Return the density of samples in each bin; samples without an upper limit count, but in no bin."""
    shares, above = bin_shares(sample, edges)
    return shares / ((shares.sum() + above) * np.diff(edges))


def bin_shares(sample: Samples, edges: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the weight of the samples in each bin, and that of samples without an upper limit, which are in none.

    Samples with two limits are spread evenly between them.
    """
    weights = np.ones(sample.values.size) if sample.weights is None else sample.weights
    if sample.bounds is None:
        return np.histogram(sample.values, bins=edges, weights=weights)[0], 0.0
    low, high = sample.bounds
    is_open = np.isinf(high)
    is_exact = low == high
    shares = np.histogram(sample.values[is_exact], bins=edges, weights=weights[is_exact])[0]
    is_spread = ~is_exact & ~is_open
    low, high = sample.bounds[:, is_spread]
    below = np.clip((edges[:, None] - low) / (high - low), 0, 1) @ weights[is_spread]
    return shares + np.diff(below), float(weights[is_open].sum())


def _bin_edges(values: np.ndarray, bins: Any, units: str) -> np.ndarray:
    """Return the edges of a histogram's bins; raise for bins that are none."""
    try:
        return np.histogram_bin_edges(values, bins=plain(bins, units, "bins") if carries_units(bins) else bins)
    except (TypeError, ValueError):
        expected = f"a number of bins, NumPy's name of a rule such as 'auto', or ascending edges in {units}"
        raise Refusal("bins", expected, f"{bins!r}", "for bins of one width give their edges") from None


def _pdf_along(ds: xr.Dataset, name: str, along: str, bins: Any) -> xr.DataArray:
    """Return `pdf` at each entry of a second dimension, with the bins of all samples together."""
    pooled = np.asarray(ds[name].values, dtype=float)
    edges = _bin_edges(pooled[np.isfinite(pooled)], bins, ds[name].attrs.get("units", "1"))
    parts = [pdf(ds.isel({along: k}), name, bins=edges) for k in range(ds.sizes[along])]
    out = xr.concat(parts, dim=ds[along], coords=["cdf"], compat="override", combine_attrs="drop_conflicts")
    counts = {count: sum(part.attrs[count] for part in parts) for count in ("samples", "missing")}
    return out.assign_attrs(counts, bin_rule=bins if isinstance(bins, str) else "given")


def cdf(ds: xr.Dataset, name: str = "pull_off_force") -> xr.DataArray:
    """Return the empirical cumulative probability of a variable over its subregions or asperities.

    Parameters
    ----------
    ds : Dataset
    name : str
        A variable along ``subregion`` or ``asperity`` and no other dimension: select one displacement first.

    Returns
    -------
    DataArray
        ``cdf``, the share of the samples up to and including each value, along the variable's own name: one entry
        for each distinct sample, ascending, and 1 at the last. If some pull-off forces are known by limits, it is the
        least share that they allow; the coordinate ``cdf_high`` is the largest.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> ds = xr.Dataset({"height": ("asperity", [3.0, 1.0, 2.0, 2.0], {"units": "nm"})})
    >>> steps = roughxr.statistics.cdf(ds, "height")
    >>> steps.height.values.tolist(), steps.values.tolist()
    ([1.0, 2.0, 3.0], [0.25, 0.75, 1.0])
    """
    ds = schema.entered_dataset(ds, "result")
    sample = samples(ds, name)
    low, high = (sample.values, sample.values) if sample.bounds is None else sample.bounds
    points = np.unique(np.concatenate([low, high]))
    axis = (name, points[np.isfinite(points)], dict(ds[name].attrs))
    out = xr.DataArray(shares_up_to(high, axis[1], sample.weights), dims=name, coords={name: axis}, name="cdf")
    if sample.bounds is not None:
        out.coords["cdf_high"] = (name, shares_up_to(low, axis[1], sample.weights), schema.attributes("cdf_high"))
    out.attrs = {**schema.attributes("cdf"), "method": "empirical"}
    out.attrs |= limit_attributes(sample.bounds)
    return out.assign_attrs(samples=sample.values.size, missing=sample.missing)


def shares_up_to(values: np.ndarray, points: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """Return the share of values up to and including each point."""
    order = np.argsort(values)
    counted = np.ones(values.size) if weights is None else weights[order]
    total = np.concatenate([[0.0], np.cumsum(counted)])
    return total[np.searchsorted(values[order], points, side="right")] / total[-1]
