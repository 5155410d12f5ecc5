"""Pull-off forces by all methods, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from .style import BLACK, BLUE, GREY, SMALL, VERMILION, axes, label_axis, legend, styled


@styled
def verdict(ds: xr.Dataset, *, marks: Mapping[str, float] | None = None, ax: Any = None):
    """Draw the pull-off forces by method: every place, the median, and the mean with its interval."""
    ax = axes(ax, aspect=0.26 + 0.075 * ds.sizes["method"])
    force = ds["pull_off_force"].transpose("method", "subregion")
    for row, values in enumerate(force.values):
        _places(ax, row, values[values > 0])
    _means(ax, ds, force)
    for (words, value), dashes in zip((marks or {}).items(), ((0, (4, 2)), (0, (1, 1.2)), "-")):
        ax.axvline(value, color=VERMILION, linewidth=0.9, linestyle=dashes, label=words, zorder=0)
    ax.set_xscale("log")
    ax.set_yticks(np.arange(force.sizes["method"]), [str(name) for name in force["method"].values])
    ax.set_ylim(force.sizes["method"] - 0.5, -0.5)
    label_axis(ax.xaxis, "pull_off_force")
    ax.tick_params(axis="y", length=0, labelsize=SMALL)
    return legend(ax, loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=3, columnspacing=1.2)


def _places(ax, row: int, values: np.ndarray):
    """Draw every place slightly off its row, and the median as a bar."""
    off = 0.26 * np.sin(2.4 * np.arange(values.size))  # in steps of a constant angle: evenly spread, and reproducible
    ax.plot(values, row + off, ".", color=BLUE, markersize=2.2, alpha=0.45, label="place" if row == 0 else None)
    if values.size:
        median = np.median(values)
        label = "median" if row == 0 else None
        ax.plot([median] * 2, [row - 0.34, row + 0.34], color=GREY, linewidth=1.4, label=label)


def _means(ax, ds: xr.Dataset, force: xr.DataArray):
    mean, rows = force.mean("subregion").values, np.arange(force.sizes["method"])
    if {"low", "high"} <= set(ds.data_vars):
        ends = np.abs(np.stack([ds["low"].values, ds["high"].values]) - mean)
        words = "mean, 95 %"
        ax.errorbar(mean, rows, xerr=ends, fmt="o", color=BLACK, markersize=3.2, capsize=2, label=words)
    else:
        ax.plot(mean, rows, "o", color=BLACK, markersize=3.2, label="mean")
