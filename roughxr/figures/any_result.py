"""The function `plot`, which draws any result in the figure for its kind."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.numbers import number
from .contact_fields import field_map
from .distributions import asperity_statistics, distribution, label_density
from .maps import scan_map, subregion_map
from .measured_figure import quantiles
from .particle_figures import fraction_remaining, moment_rose
from .style import STROKES, Axes, Panels, axes, label_axis, legend, stroke, styled
from .sweeps import sweep
from .uncertainty_bars import cut_off, error_budget


def plot(
    ds: xr.Dataset | xr.DataArray, name: str | None = None, *, ax: Axes | Panels | None = None, **options: Any
) -> Any:
    """Draw any result, or one of its variables, as the figure that shows it best.

    xarray's own ``ds.height.plot()`` draws a map with its first dimension, x, upright; this function draws x to the
    right.

    Parameters
    ----------
    ds : Dataset or DataArray
        Densities, up to five, are drawn as steps between the edges of their bins; another DataArray as xarray does,
        maps with x to the right.
    name : str, optional
        A variable of the Dataset: a map along x and y, or samples along ``subregion`` or ``asperity``. By default: the
        heights of a scan, the statistics of asperities, the forces of a solution over displacement, the pull-off
        forces, the bars of an error budget, the pull-off over the shortest wavelength, the rose of resisting moments,
        the fraction remaining, or the quantiles of `compare`.
    ax : Axes or sequence of them, optional
        A new figure by default.
    **options
        Options of the figure that is drawn: `figures.scan_map`, `sweep`, `distribution`, `field_map`, or xarray's
        ``.plot()``. For a variable along subregions ``on="map"`` draws `subregion_map`.

    Returns
    -------
    Axes, or an array of several

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> roughxr.figures.plot(roughxr.open_sample("glass"), ax=Figure().subplots()).get_xlabel()
    'x [µm]'
    """
    if isinstance(ds, xr.DataArray):
        return _array(ds, ax=ax, **options)
    if name is None:
        parts = set(map(str, [*ds.data_vars, *ds.dims]))
        if (draw := next((draw for needs, draw in _OWN_FIGURES if needs <= parts), None)) is not None:
            return draw(ds, ax=ax, **options)
        swept = "force" in ds and "delta" in ds["force"].dims  # it may contain the pull-off as well
        names = ("pressure", "force", "height") if swept else ("pull_off_force", "pressure", "force", "height")
        name = next((main for main in [*names, *map(str, ds.data_vars)] if main in ds.data_vars), "")
    if name not in ds:
        raise ValueError(f"expected one of the variables {', '.join(map(str, ds.data_vars))}, found {name!r}")
    return _variable(ds, name, ax, options)


#: Figures of particular results, each with the variables and dimensions that identify the result.
_OWN_FIGURES: tuple[tuple[set[str], Any], ...] = (
    ({"curvature_min", "orientation", "asperity"}, asperity_statistics),
    ({"relative_error", "standard_error", "entry"}, error_budget),
    ({"predicted_quantile", "measured_quantile"}, quantiles),
    ({"remaining", "friction_velocity", "time"}, fraction_remaining),
    ({"resisting_moment", "subregion", "direction"}, moment_rose),
    ({"pull_off_force", "shortest_kept", "seed"}, cut_off),
)


def _variable(ds: xr.Dataset, name: str, ax: Any, options: dict[str, Any]) -> Any:
    """Draw a variable by its dimensions."""
    dims = set(ds[name].dims)
    if not dims:
        raise ValueError(f"{name}: a single number cannot be drawn; expected a variable with at least one dimension")
    if name == "height" and dims == {"x", "y"}:
        return scan_map(ds, ax=ax, **options)
    if {"subregion", "x", "y"} <= dims:
        return field_map(ds, name, ax=ax, **options)
    if name == "force" and "delta" in dims and "subregion" in ds.coords:
        return sweep(ds if "subregion" in dims else ds.expand_dims("subregion"), ax=ax, **options)
    if dims in ({"subregion"}, {"asperity"}):
        way = schema.one_of(options.pop("on", "distribution"), ("distribution", "map"), "on")
        draw = subregion_map if way == "map" or name == "mode" else distribution
        return draw(ds, name, ax=ax, **options)
    return _array(ds[name], ax=ax, **options)


@styled
def _array(array: xr.DataArray, *, ax: Axes | None = None, **options: Any) -> Any:
    """Draw a density as steps between its bins' edges, a map with x to the right, and anything else as xarray does."""
    ax = axes(ax)
    if array.name in ("pdf", "cdf") and array.size <= len(STROKES) * array.shape[-1]:
        return _densities(array, ax, **options)
    if set(array.dims) == {"x", "y"}:
        options = {"x": "x", "y": "y", **options}
    array.plot(ax=ax, **options)
    ax.set_title("")  # xarray's lists the pair of bodies
    return ax


def _entry(coordinate: xr.DataArray) -> str:
    """Return an entry of a dimension in words."""
    value = coordinate.item()
    return value if isinstance(value, str) else number(value, coordinate.attrs.get("units", ""))


def _densities(array: xr.DataArray, ax: Any, **options: Any):
    """Draw a density or a cumulative probability as steps; along another dimension, those of each entry."""
    *others, name = map(str, array.dims)
    cases = array.stack(case=others, create_index=False) if others else array.expand_dims(case=1)
    for order in range(cases.sizes["case"]):
        case = cases.isel(case=order)
        label = ", ".join(_entry(case[other]) for other in others) or None
        look = {"label": label, **stroke(order), **options}
        if "bin_edges" in array.attrs:
            ax.stairs(case.values, np.asarray(array.attrs["bin_edges"]), **look)
        else:
            ax.step(case[name], case.values, where="post", **look)
    label_density(ax, name)
    legend(ax)
    if array.name == "cdf":
        label_axis(ax.xaxis, name)
        ax.yaxis.set_major_formatter("{x:g}")
        ax.set_ylabel("cumulative probability")
    return ax
