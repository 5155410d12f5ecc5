"""Densities and cumulative probabilities of a variable over its subregions or asperities."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ..vocabulary import schema
from ..vocabulary.units import carries_units, plain
from .sampling import Samples, per, samples

#: Variables that cannot be negative: a kernel estimate must not extend below zero.
NOT_NEGATIVE = (
    "pull_off_force",
    "pull_off_ratio",
    "contact_area",
    "axis_ratio",
    "curvature_max",
    "fit_rms",
    "gap",
    "contacts",
    "critical_friction_velocity",
    "critical_acceleration",
    "critical_angle",
)

#: Variables that cannot exceed one: a kernel estimate must not extend above it.
AT_MOST_ONE = ("axis_ratio",)


def pdf(
    ds: xr.Dataset,
    name: str = "pull_off_force",
    *,
    method: str = "histogram",
    bins: int | str | ArrayLike | None = None,
    weights: str | None = None,
) -> xr.DataArray:
    """Return the probability density of a variable over its subregions or asperities.

    Parameters
    ----------
    ds : Dataset
    name : str
        A variable along ``subregion`` or ``asperity`` and no other dimension: select one displacement first.
    method : {"histogram", "kde"}
        Densities of bins, or a Gaussian kernel estimate with Scott's bandwidth. The estimate is reflected at 0 for
        variables that cannot be negative, such as ``pull_off_force``, and at 1 for an axis ratio. Reflection keeps the
        integral, not the mean: take means from `summary`.
    bins : int, str or array, optional
        Of a histogram, as for `numpy.histogram_bin_edges`, by default "auto"; edges in the variable's units or with
        their own. A rule ignores the weights.
    weights : str, optional
        Variable of ``ds`` that holds the weight of each sample; by default ``landing_share`` where there is one.

    Returns
    -------
    DataArray
        ``pdf`` (1/unit of the variable, integrating to 1) along the variable's own name, with ``cdf`` beside it; the
        attributes hold ``bin_rule`` and ``bin_edges``, or ``bandwidth`` and ``boundary``, and the numbers of
        ``samples`` and ``missing`` ones. ``.to_dataset()`` makes ``pdf`` and ``cdf`` variables of one Dataset.

    References
    ----------
    Scott, Multivariate Density Estimation (1992); Silverman, Density Estimation (1986), section 2.10, for the
    reflection.

    Examples
    --------
    >>> ds = xr.Dataset({"height": ("asperity", [1.0, 2.0, 2.0, 3.0], {"units": "nm"})})
    >>> density = pdf(ds, "height", bins=2)
    >>> density.values.tolist(), density.units, float(density.cdf[-1])
    ([0.25, 0.75], '1/nm', 1.0)
    """
    ds = schema.entered(ds)
    schema.one_of(method, ("histogram", "kde"), "method")
    some = samples(ds, name, weights=weights)
    units = ds[name].attrs.get("units", "1")
    bins = plain(bins, units, name) if carries_units(bins) else bins
    if method == "histogram":
        bins = "auto" if bins is None else bins
        edges = np.histogram_bin_edges(some.values, bins=bins)
        values = np.histogram(some.values, bins=edges, density=True, weights=some.weights)[0]
        points, cumulative = (edges[:-1] + edges[1:]) / 2, np.cumsum(values * np.diff(edges))
        extra = {"bin_rule": bins if isinstance(bins, str) else "given", "bin_edges": edges}
    else:
        schema.refuse_unused("method='kde'", bins=bins)
        lower = 0.0 if name in NOT_NEGATIVE and some.values.min() >= 0 else -np.inf
        points, values, cumulative, extra = _kernel_density(some, lower, 1.0 if name in AT_MOST_ONE else np.inf)
    axis = (name, points, dict(ds[name].attrs))
    out = xr.DataArray(values, dims=name, coords={name: axis, "cdf": (name, cumulative)}, name="pdf")
    out["cdf"].attrs.update(schema.attributes("cdf"))
    out.attrs = {"units": per(units), "long_name": "probability density", "method": method}
    out.attrs |= {"samples": some.values.size, "missing": some.missing, **extra}
    return out


def cdf(ds: xr.Dataset, name: str = "pull_off_force", *, weights: str | None = None) -> xr.DataArray:
    """Return the empirical cumulative probability of a variable over its subregions or asperities.

    Parameters
    ----------
    ds : Dataset
    name, weights
        As in `pdf`.

    Returns
    -------
    DataArray
        ``cdf``, the share of the samples up to and including each value, along the variable's own name: one entry
        for each distinct sample, ascending, and 1 at the last.

    Examples
    --------
    >>> ds = xr.Dataset({"height": ("asperity", [3.0, 1.0, 2.0, 2.0], {"units": "nm"})})
    >>> steps = cdf(ds, "height")
    >>> steps.height.values.tolist(), steps.values.tolist()
    ([1.0, 2.0, 3.0], [0.25, 0.75, 1.0])
    """
    ds = schema.entered(ds)
    some = samples(ds, name, weights=weights)
    points, group = np.unique(some.values, return_inverse=True)
    share = np.cumsum(np.bincount(group, some.weights))
    axis = (name, points, dict(ds[name].attrs))
    out = xr.DataArray(share / share[-1], dims=name, coords={name: axis}, name="cdf")
    out.attrs = {**schema.attributes("cdf"), "method": "empirical"}
    return out.assign_attrs(samples=some.values.size, missing=some.missing)


def _kernel_density(some: Samples, boundary: float, end: float, points: int = 512) -> tuple:
    """Return the Gaussian estimate on a grid that holds all but 1e-9 of it, reflected at ``boundary`` and ``end``."""
    from scipy.special import ndtr
    from scipy.stats import gaussian_kde

    values = some.values
    if np.ptp(values) == 0:
        raise ValueError(
            "expected samples that differ, found all equal, which have no kernel estimate; use method='histogram'"
        )
    estimate = gaussian_kde(values, weights=some.weights)
    width = float(np.sqrt(estimate.covariance[0, 0]))
    grid = np.linspace(max(values.min() - 6 * width, boundary), min(values.max() + 6 * width, end), points)
    below = lambda at: ndtr((at[:, None] - values) / width) @ estimate.weights  # noqa: E731
    density, cumulative = estimate(grid), below(grid)
    extra = {"bandwidth": width}
    if np.isfinite(boundary):
        mirrored = 2 * boundary - grid
        density, cumulative = density + estimate(mirrored), cumulative - below(mirrored)
        extra["boundary"] = boundary
    if np.isfinite(end):
        mirrored = 2 * end - grid
        density, cumulative = density + estimate(mirrored), cumulative + 1 - below(mirrored)
    return grid, density, cumulative, extra
