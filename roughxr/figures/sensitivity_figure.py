"""A tornado plot: the change of a result under each assumption."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .style import BLACK, BLUE, GREY, ORANGE, SMALL, Axes, axes, styled


@styled
def tornado(ds: xr.Dataset, name: str = "pull_off_mean", *, ax: Axes | None = None):
    """Draw how far each factor changes a result from its base, the strongest on top.

    Parameters
    ----------
    ds : Dataset
        From `sensitivity`.
    name : str
        The result.
    ax : Axes, optional

    Returns
    -------
    Axes
        Change in per cent of the base value. The grey band is the base value's own interval, where known: smaller
        changes cannot be told from the scatter of places. Cases that were not computed are left out.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset(
    ...     {"pull_off_mean": ("case", [2.0, 1.0, 4.0])},
    ...     coords={"factor": ("case", ["base", "energy", "energy"]), "setting": ("case", ["", "half", "double"])},
    ... )
    >>> ax = tornado(ds, ax=Figure().subplots())
    >>> [float(bar.get_width()) for bar in ax.patches]
    [-50.0, 100.0]
    """
    ax = axes(ax)
    base = ds.isel(case=int(np.flatnonzero(ds["factor"].values == "base")[0]))
    change = 100 * _change(ds, base, name)
    factors = [factor for factor in dict.fromkeys(ds["factor"].values.tolist()) if factor != "base"]
    swings = {factor: change[ds["factor"].values == factor] for factor in factors}
    factors = [factor for factor in factors if np.isfinite(swings[factor]).any()]
    factors.sort(key=lambda factor: float(np.nanmax(np.abs(swings[factor]))))
    _own_interval(ax, base, name)
    for row, factor in enumerate(factors):
        _bars(ax, row, swings[factor])
    ax.axvline(0, color=BLACK, linewidth=0.8)
    ax.set_yticks(range(len(factors)), factors)
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    ax.margins(x=0.2)
    words = str(ds[name].attrs.get("long_name", name.replace("_", " ")))
    ax.set_xlabel(f"change of {words} [%]")
    return ax


def _change(ds: xr.Dataset, base: xr.Dataset, name: str) -> xr.DataArray:
    """Return the relative change of each case from the base; for the simulation, that on cells of the same size."""
    if name == "pull_off_mean" and "pull_off_change" in ds:
        return ds["pull_off_change"]
    return ds[name] / float(base[name]) - 1


def _own_interval(ax, base: xr.Dataset, name: str):
    if f"{name}_low" in base:
        ends = (100 * (float(base[f"{name}_{end}"]) / float(base[name]) - 1) for end in ("low", "high"))
        ax.axvspan(*ends, color=GREY, alpha=0.2, linewidth=0, label="95 % interval over places, unchanged")
        ax.legend(loc="best")


def _bars(ax, row: int, change: xr.DataArray):
    """Draw the settings with the largest changes down and up, each with its label at the end of its bar."""
    falls, rises = change.where(change < 0, drop=True), change.where(change > 0, drop=True)
    for some, color in ((falls, ORANGE), (rises, BLUE)):
        if some.size:
            one = some.isel(case=int(np.abs(some.values).argmax()))
            _bar(ax, row, float(one), str(one["setting"].values), color)
    if not falls.size and not rises.size:
        ax.annotate("no change", (0, row), (3, 0), textcoords="offset points", va="center", fontsize=SMALL - 0.5)


def _bar(ax, row: int, width: float, words: str, color: str):
    ax.barh(row, width, height=0.62, color=color, edgecolor="none")
    side, offset = ("right", (-2, 0)) if width < 0 else ("left", (2, 0))
    style = {"fontsize": SMALL - 0.5, "ha": side, "va": "center", "textcoords": "offset points"}
    ax.annotate(words, (width, row), offset, **style)
