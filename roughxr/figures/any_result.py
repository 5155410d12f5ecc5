"""One verb for any result: the figure that shows it best."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.verbs import verb
from .budget_figure import cut_off, error_budget
from .contact_fields import field_map
from .detachment_figure import fraction_remaining, mode_map, moment_rose
from .distributions import asperity_statistics, distribution, label_density
from .forces import force_fan
from .maps import scan_map, subregion_map
from .measured_figure import quantile_quantile
from .style import Axes, Panels, axes, label_axis, stroke, styled
from .yielding_figure import force_loop


@verb
def plot(ds: xr.Dataset, name: str | None = None, *, ax: Axes | Panels | None = None, **options: Any) -> Any:
    """Draw a scan, an asperity catalogue, a solution, a pull-off or one of their variables.

    xarray's own ``ds.height.plot()`` sets a map's first dimension, x, upright; here x runs to the right.

    Parameters
    ----------
    ds : Dataset
    name : str, optional
        A variable: a map along x and y, or samples along ``subregion`` or ``asperity``. By default: the heights of a
        scan, the statistics of asperities, the forces of a solution over displacement, the pull-off forces, the bars
        of an error budget, the pull-off over the shortest wave, the rose of resisting moments, the
        fraction remaining, or the quantiles of `compare`.
    ax : Axes or sequence of them, optional
        A new figure by default.
    **options
        Options of the figure that is drawn: `figures.scan_map`, `asperity_statistics`, `force_fan`, `distribution`,
        `field_map`. For a variable along subregions ``on="map"`` draws `subregion_map`.

    Returns
    -------
    Axes or array of Axes

    Raises
    ------
    ValueError
        If there is no such variable, or no figure of it.

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> plot(roughxr.open_sample("glass"), ax=Figure().subplots()).get_xlabel()
    'x [µm]'
    """
    if name is None and schema.kind_of(ds) == "asperities":
        return asperity_statistics(ds, ax=ax, **options)
    if name is None and (drawn := _by_kind(ds)) is not None:
        return drawn(ds, ax=ax, **options)
    name = name or _main(ds)
    if name not in ds:
        raise ValueError(f"expected one of the variables {', '.join(map(str, ds.data_vars))}, found {name!r}")
    drawn, shown = _of_variable(ds, name)
    return drawn(shown, ax=ax, **options)


def _of_variable(ds: xr.Dataset, name: str) -> tuple[Any, Any]:
    """Return the figure of a variable, and its argument."""
    dims = set(ds[name].dims)
    if name == "height" and dims == {"x", "y"}:
        return scan_map, ds
    if {"subregion", "x", "y"} <= dims:
        return partial(field_map, name=name), ds
    if name == "force" and (figure := _of_force(ds, dims)) is not None:
        return figure
    if name == "mode" and dims == {"subregion"}:
        return mode_map, ds
    if dims in ({"subregion"}, {"asperity"}):
        return partial(_samples, name=name), ds
    if not dims:
        raise ValueError(f"{name}: a single number cannot be drawn; expected a variable with at least one dimension")
    return plot_array, ds[name]


def _of_force(ds: xr.Dataset, dims: set) -> tuple[Any, Any] | None:
    """Return the figure of forces over displacement; None for other forces."""
    if dims == {"subregion", "delta"}:
        return force_fan, ds
    if dims == {"delta"} and "subregion" in ds.coords:
        return partial(force_fan, interval=None), ds.expand_dims("subregion")
    return (force_loop, ds) if dims == {"subregion", "branch", "delta"} else None


def _by_kind(ds: xr.Dataset) -> Any:
    """Return the figure of a result that is no map, sweep or sample, such as an error budget; None for others."""
    if "relative_error" in ds and "entry" in ds.dims:
        return error_budget
    if {"predicted_quantile", "measured_quantile"} <= set(ds.data_vars):
        return quantile_quantile
    if "remaining" in ds and {"friction_velocity", "time"} <= set(ds.dims):
        return fraction_remaining
    if "resisting_moment" in ds and {"subregion", "direction"} <= set(ds.dims):
        return moment_rose
    return cut_off if {"shortest_kept", "seed"} <= set(ds.dims) and "pull_off_force" in ds else None


def _main(ds: xr.Dataset) -> str:
    """Return the main variable of a Dataset."""
    first = next(iter(map(str, ds.data_vars)), "")
    swept = "force" in ds and "delta" in ds["force"].dims  # it may hold its pull-off as well
    names = ("pressure", "force", "height") if swept else ("pull_off_force", "pressure", "force", "height")
    return next((name for name in names if name in ds.data_vars), first)


def _samples(ds: xr.Dataset, *, name: str, ax: Any, on: str = "distribution", **options: Any):
    schema.one_of(on, ("distribution", "map"), "on")
    drawn = subregion_map if on == "map" else distribution
    return drawn(ds, name, ax=ax, **options)


@styled
def plot_array(array: xr.DataArray, *, ax: Axes | None = None, **options: Any) -> Any:
    """Draw a density as steps between its bins' edges, a map with x to the right, and anything else as xarray does.

    Parameters
    ----------
    array : DataArray
    ax : Axes, optional
    **options
        For matplotlib's `stairs` or `plot`, or xarray's ``.plot()``.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset({"force": ("subregion", [1.0, 2.0, 2.0, 3.0], {"units": "nN"})})
    >>> ax = plot_array(roughxr.pdf(ds, "force", bins=2), ax=Figure().subplots())
    >>> ax.get_xlabel(), len(ax.patches)
    ('contact force [nN]', 1)
    """
    ax = axes(ax)
    if array.name in ("pdf", "cdf") and array.ndim == 1:
        return _density(array, ax, **options)
    if set(array.dims) == {"x", "y"}:
        options = {"x": "x", "y": "y", **options}
    array.plot(ax=ax, **options)
    ax.set_title("")  # xarray's lists the pair of bodies
    return ax


def _density(array: xr.DataArray, ax: Any, **options: Any):
    """Draw a density or a cumulative probability: as steps where it has bins or samples, else as a line."""
    (name,) = map(str, array.dims)
    look = {**stroke(0), **options}
    if "bin_edges" in array.attrs:
        ax.stairs(array.values, np.asarray(array.attrs["bin_edges"]), **look)
    elif array.name == "cdf":
        ax.step(array[name], array.values, where="post", **look)
    else:
        ax.plot(array[name], array.values, **look)
    if name not in schema.VARIABLES:
        ax.set(xlabel=name, ylabel=array.attrs.get("long_name", array.name))
        return ax
    if array.name == "cdf":
        label_axis(ax.xaxis, name)
        ax.set_ylabel("cumulative probability")
        return ax
    return label_density(ax, name)
