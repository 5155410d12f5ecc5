"""The function `plot`, which draws any result in the figure for its kind."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.jobs.records import FIELDS
from ...mechanics.scans.regions import extent
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.text import did_you_mean
from .contact_fields import field_map
from .distributions import asperity_statistics, distribution, label_density
from .images import COLOURS, image
from .maps import scan_map, subregion_map
from .measured_figure import fitted_work, quantiles
from .particle_figures import fraction_remaining, moment_rose
from .style import STROKES, Axes, Panels, axes, label_axes, label_axis, legend, stroke, styled
from .sweeps import sweep
from .uncertainty_bars import error_budget
from .values import (
    answer_rows,
    entry_in_words,
    estimates_over_parameter,
    fitted_laws,
    named_values,
    over_parameter,
    quantile_box,
    spectrum,
    violations,
)


def plot(
    ds: xr.Dataset | xr.DataArray, name: str | None = None, *, ax: Axes | Panels | None = None, **options: Any
) -> Any:
    """Draw any result, or one of its variables, as the figure that shows it best.

    Save a picture by ``ax.figure.savefig("picture.png")``, of several Axes by ``ax[0].figure``. xarray's own
    ``ds.height.plot()`` draws a map with its first dimension, x, upright; this function draws x to the right.

    Parameters
    ----------
    ds : Dataset or DataArray
        Densities, up to five, are drawn as steps between the edges of their bins; another DataArray as xarray does,
        maps with x to the right.
    name : str, optional
        A variable of the Dataset: a map along x and y, samples along ``subregion`` or ``asperity``, lines over a
        parameter such as load, preload or radius, or dots for named entries. By default the figure that suits the
        result: heights of a scan, statistics of asperities, forces of a solution over displacement, pull-off forces,
        bars of an error budget, intervals of an answer, a spectrum, and so on.
    ax : Axes or sequence of them, optional
        A new figure by default.
    **options
        Options of the figure that is drawn: `figures.scan_map`, `sweep`, `distribution`, `field_map`, or xarray's
        ``.plot()``. For a variable along subregions ``on="map"`` draws `subregion_map`.

    Returns
    -------
    Axes, or an array of several

    Raises
    ------
    ValueError
        If a result has nothing to draw; the message names what to draw instead.

    Examples
    --------
    >>> import roughxr
    >>> from matplotlib.figure import Figure
    >>> roughxr.figures.plot(roughxr.open_sample("glass"), ax=Figure().subplots()).get_xlabel()
    'x [µm]'
    """
    if not isinstance(ds, (xr.DataArray, xr.Dataset)):
        advice = "a run's are in roughxr.archive.load(RUN)"
        raise Refusal("", "a Dataset or DataArray, to be drawn", type(ds).__name__, advice)
    if isinstance(ds, xr.Dataset) and not ds.data_vars:
        raise Refusal("", "a Dataset with variables, to be drawn", "none")
    if isinstance(ds, xr.DataArray):
        return _array(ds, ax=ax, **options)
    if name is None and "pull_off_force" in ds and "contacts" in ds and ds["contacts"].dims == ("subregion",):
        return subregion_map(ds, ax=ax, **options)  # of `pull_off_map`
    if name is None:
        parts = set(map(str, [*ds.data_vars, *ds.dims]))
        if (draw := next((draw for needs, draw in _OWN_FIGURES if needs <= parts), None)) is not None:
            return draw(ds, ax=ax, **options)
        name = _main_variable(ds)
    if name not in ds:
        names = ", ".join(map(str, ds.data_vars))
        how = "fields=True of direct and adhesive computes it" if name in FIELDS else ""
        raise Refusal("", f"one of the variables {names}", f"{name!r}{did_you_mean(name, ds.data_vars)}", how)
    return _variable(ds, name, ax, options)


#: Figures of particular results, each with the variables and dimensions that identify the result.
_OWN_FIGURES: tuple[tuple[set[str], Any], ...] = (
    ({"curvature_min", "orientation", "asperity"}, asperity_statistics),
    ({"relative_std", "entry"}, error_budget),
    ({"predicted_quantile", "measured_quantile"}, quantiles),
    ({"fitted_work_of_adhesion", "quantile_distance"}, fitted_work),
    ({"remaining", "friction_velocity", "time"}, fraction_remaining),
    ({"resisting_moment", "subregion", "direction"}, moment_rose),
    ({"psd", "wavevector"}, spectrum),
    ({"psd_plateau", "hurst_exponent"}, spectrum),
    ({"aic", "law"}, fitted_laws),
    ({"violation", "check"}, violations),
    ({"solved_places", "low", "high"}, answer_rows),
)


def _main_variable(ds: xr.Dataset) -> str:
    """Return the variable that shows a result best."""
    # a sweep may contain the pull-off as well; rigid bodies have no force where they would overlap
    # share of known forces from which a sweep is drawn rather than its pull-off
    swept = "force" in ds and "delta" in ds["force"].dims and bool(ds["force"].notnull().mean() > 0.9)
    names = ["pressure", "force", "height"] if swept else ["pull_off_force", "pressure", "force", "height"]
    if "load" in ds.dims:
        names.insert(names.index("force"), "contact_area")  # the force is the load
    return next((main for main in [*names, *map(str, ds.data_vars)] if main in ds.data_vars), "")


def _variable(ds: xr.Dataset, name: str, ax: Any, options: dict[str, Any]) -> Any:
    """Draw a variable by its dimensions."""
    dims = set(map(str, ds[name].dims))
    if not dims:
        raise Refusal(
            name,
            "a variable along a dimension, to be drawn",
            "a single number",
            "draw what it was computed from: scan.contact.plot() for the heights, "
            "scan.contact.formulas().contact.plot() for forces of several models",
        )
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
    if dims == {"statistic"} and "estimate" not in ds:
        return quantile_box(ds, name, ax=ax)
    if name == "estimate" and "variable" in ds.attrs and len(dims - {"statistic"}) == 1:
        return estimates_over_parameter(ds, ax=ax)
    if len(dims) == 1 and ds[min(dims)].dtype.kind in "OU":
        return named_values(ds, name, ax=ax)
    if {"x", "y"}.isdisjoint(dims):
        return over_parameter(ds, name, ax=ax, **options)
    return _array(ds[name], ax=ax, **options)


@styled
def _array(array: xr.DataArray, *, ax: Axes | None = None, **options: Any) -> Any:
    """Draw a density as steps between its bins' edges, a map with x to the right, and anything else as xarray does."""
    ax = axes(ax)
    if array.name in ("pdf", "cdf") and array.size <= len(STROKES) * array.shape[-1]:
        return _densities(array, ax, **options)
    if set(array.dims) == {"x", "y"} and array.name in schema.VARIABLES and not options:
        centred = array.transpose("x", "y")
        image(
            ax, centred.values, extent(centred.to_dataset()), str(array.name), COLOURS.get(str(array.name), "rocket_r")
        )
        return label_axes(ax, "x", "y")
    if set(array.dims) == {"x", "y"}:
        options = {"x": "x", "y": "y", **options}
    array.plot(ax=ax, **options)
    ax.set_title("")  # xarray's lists the pair of bodies
    return ax


def _densities(array: xr.DataArray, ax: Any, **options: Any):
    """Draw a density or a cumulative probability as steps; along another dimension, those of each entry."""
    *others, name = map(str, array.dims)
    cases = array.stack(case=others, create_index=False) if others else array.expand_dims(case=1)
    sampling = f"{array.attrs['samples']} samples" if "samples" in array.attrs else None
    if sampling and array.attrs.get("method") == "histogram":
        sampling += f", {array.sizes[name]} bins"
    for order in range(cases.sizes["case"]):
        case = cases.isel(case=order)
        label = ", ".join(entry_in_words(case[other]) for other in others) or sampling
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
