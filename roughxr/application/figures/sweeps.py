"""Force over displacement: all places, and mean forces of several solutions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics import statistics
from ...mechanics.statistics.sampling import weighted_by_landing_share
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal
from .style import BLACK, BLUE, GREY, VERMILION, Axes, axes, label_axes, label_axis, legend, stroke, styled


@styled
def sweep(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw force over displacement: every subregion, their median, and bands that contain half and 90 % of them.

    Of a solution with loading and retraction: the mean of both, and the work lost between them as an area. Where the
    tension would be invisible, larger forces are on a logarithmic scale.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> solution = scan.contact.direct(delta=[4.0, 8.0, 12.0], subregions=(3, 3))
    >>> roughxr.figures.sweep(solution).get_xlabel()
    'displacement [nm]'
    """
    if "force" in ds and set(ds["force"].dims) == {"subregion", "branch", "delta"}:
        return _loop(ds, axes(ax))
    ds = _along_delta(ds)
    ax = axes(ax)
    force = ds["force"].transpose("delta", "subregion")
    label = f"place {ds['subregion'].values[0]}"
    if ds.sizes["subregion"] > 1:
        label = "median"
        _places_and_bands(ax, force)
    ax.plot(ds["delta"], force.median("subregion"), color=BLACK, linewidth=1.4, label=label)
    tension = float(-force.min("delta").median())  # of the median place
    if {"pull_off_force", "pull_off_delta"} <= set(ds) and bool(ds["pull_off_force"].notnull().any()):
        style: dict[str, Any] = {"color": VERMILION, "marker": "v", "markersize": 2.6, "linewidth": 0, "zorder": 3}
        ax.plot(ds["pull_off_delta"], -ds["pull_off_force"], label="pull-off", **style)
        tension = float(ds["pull_off_force"].median())  # a sweep may step over it
    # smallest tension, over the largest force, that is visible on a linear axis
    is_logarithmic = 0 < tension < 0.05 * float(force.max())
    if is_logarithmic:
        ax.set_yscale("symlog", linthresh=tension, linscale=1.0)
        ax.set_yticks([tick for tick in ax.get_yticks() if not 0 < abs(tick) < tension])  # nearer to 0 they overlap
    _zero_line(ax, force)
    label_axes(ax, "delta", "force")
    if is_logarithmic:
        label_axis(ax.yaxis, "force", largest=tension)
    return legend(ax)


def _places_and_bands(ax, force: xr.DataArray) -> None:
    """Draw the force at every place, and bands that contain half and 90 % of them."""
    delta = force["delta"].values
    ax.plot(delta, force.values, color=GREY, linewidth=0.35, alpha=0.6)
    ax.plot([], [], color=GREY, linewidth=0.6, label=f"{force.sizes['subregion']} places")
    for low, alpha in ((0.05, 0.22), (0.25, 0.4)):
        band = force.quantile([low, 1 - low], "subregion").values
        share = f"{100 * (1 - 2 * low):.0f} % of them"
        ax.fill_between(delta, *band, color=BLUE, alpha=alpha, linewidth=0, label=share)


def _loop(ds: xr.Dataset, ax):
    """Draw the mean force on loading and on retraction, with the area between them shaded."""
    mean, delta = ds["force"].mean("subregion"), ds["delta"].values
    loading, retraction = (mean.sel(branch=branch).values for branch in ("loading", "retraction"))
    # smallest difference of the forces, over the largest force, that is visible
    visible = 0.01 * np.nanmax(abs(mean.values))
    label = "work lost" if np.nanmax(abs(loading - retraction)) > visible else None
    ax.fill_between(delta, retraction, loading, color=GREY, alpha=0.3, linewidth=0, label=label)
    ax.plot(delta, loading, color=BLACK, label="loading")
    ax.plot(delta, retraction, color=VERMILION, linestyle=(0, (4, 1.5)), label="retraction")
    _zero_line(ax, mean)
    return legend(label_axes(ax, "delta", "force"))


@styled
def mean_force(solutions: Mapping[str, xr.Dataset], *, ax: Axes | None = None):
    """Draw the mean force over subregions of several solutions, by their labels in the legend.

    Of several subregions the mean, its 95 % interval by bootstrap, and the band that contains 68 % of them; of
    one (``ds.sel(subregion=[3])``) its force, the pull-off marked.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> places = {"delta": [4.0, 8.0, 12.0], "subregions": (3, 3)}
    >>> summed = scan.contact.superpose(law="hertz", **places)
    >>> roughxr.figures.mean_force({"direct": scan.contact.direct(**places), "superposed": summed}).get_xlabel()
    'displacement [nm]'
    """
    ax = axes(ax)
    band_label: str | None = "68 % of places"
    intervals = []
    for order, (name, ds) in enumerate(solutions.items()):
        ds = _along_delta(ds)
        look = stroke(order)
        delta = ds["delta"].values
        force = weighted_by_landing_share(ds["force"])
        mean = force.mean("subregion")
        marker = "os^D"[order % 4] if delta.size <= 40 else None
        ax.plot(delta, mean, label=name, marker=marker, markersize=2.6, **look)
        _zero_line(ax, mean)
        if ds.sizes["subregion"] > 1:
            band = force.quantile([0.16, 0.84], dim="subregion").values
            ax.fill_between(delta, *band, color=look["color"], alpha=0.18, linewidth=0, label=band_label)
            intervals.append((ds, look["color"]))
            band_label = None
        elif float(mean.min()) < 0:
            lowest = int(mean.argmin("delta"))
            ax.plot(delta[lowest], mean[lowest], "v", color=look["color"], markersize=4.5, markeredgecolor="white")
    ax.set_ylim(ax.get_ylim())  # where few places touch, an interval can exceed all forces
    interval_label: str | None = "95 % interval of the mean"
    for ds, color in intervals:
        if _interval_bars(ax, ds, color, interval_label):
            interval_label = None
    return legend(label_axes(ax, "delta", "force"))


def _interval_bars(ax, ds: xr.Dataset, color: str, label: str | None) -> bool:
    """Draw 95 % intervals of the mean force at some displacements; return whether one is longer than a marker."""
    shown = ds.isel(delta=(ds["force"].notnull().sum("subregion") > 1).values)
    if not shown.sizes["delta"]:
        return False
    # largest number of displacements with an interval: more would hide the line
    shown = shown.isel(delta=slice(None, None, -(-shown.sizes["delta"] // 20)))
    mean = statistics.bootstrap(shown, "force", statistics=["mean"], resamples=399).isel(statistic=0)
    # smallest visible length of an interval, over the height of the Axes: a marker of 2.6 points
    visible = 2.6 / 72 * ax.figure.dpi / ax.bbox.height
    low, high = (mean[end].clip(*ax.get_ylim()) for end in ("low", "high"))
    is_visible = bool((high - low > visible * np.ptp(ax.get_ylim())).any())
    look = {"color": color, "linewidth": 0.8, "label": label if is_visible else None}
    ax.vlines(shown["delta"].values, mean["low"].values, mean["high"].values, **look)
    return is_visible


def _along_delta(ds: xr.Dataset) -> xr.Dataset:
    """Return a solution whose forces lie along subregions and displacements alone; raise for others, with advice."""
    if isinstance(ds, xr.Dataset) and "force" not in ds and "pull_off_force" in ds:
        raise Refusal(
            "",
            "forces along delta",
            "only pull-offs",
            "solve with adhesive(…, delta=[…]) for force curves, or draw the pull-off: "
            "ds.contact.plot('pull_off_force')",
        )
    ds = schema.validate(ds, "solution")
    others = [str(dim) for dim in ds["force"].dims if dim not in ("subregion", "delta")]
    if others:
        ways = [f"{dim}={ds[dim].values.tolist()[-1]!r}" if dim in ds.coords else f"{dim}=…" for dim in others]
        raise Refusal(
            "force",
            "one along ('subregion', 'delta')",
            f"also {', '.join(others)}",
            f"select one first, for example ds.sel({', '.join(ways)})",
        )
    return ds


def _zero_line(ax, force: xr.DataArray):
    """Draw the line of zero force if there is any tension."""
    if float(force.min()) < 0:
        ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)
