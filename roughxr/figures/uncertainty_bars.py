"""The uncertainty of the pull-off: the error budget as bars, and the pull-off over the shortest wavelength."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..studies.roughness_scale import mean_over_wavelengths
from ..vocabulary.numbers import number, with_error
from .style import (
    BLACK,
    BLUE,
    DASHED,
    GREY,
    SMALL,
    VERMILION,
    Axes,
    axes,
    label_axis,
    legend,
    log_ticks,
    styled,
)


@styled
def error_budget(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the entries of an error budget as bars with their own errors, in per cent of the mean pull-off.

    Each entry has its standard error and the sign of the change, a known bias what was subtracted from the mean.
    """
    numbers = (100 * ds[name].values for name in ("relative_error", "standard_error", "pull_off_change"))
    bars = {str(name): (*row, BLUE) for name, *row in zip(ds["entry"].values, *numbers, ds["known_bias"].values)}
    bars["all of these"] = (
        100 * float(ds["total_error"]),
        100 * float(ds["total_standard_error"]),
        np.nan,
        False,
        BLACK,
    )
    ax = axes(ax, aspect=0.16 + 0.058 * len(bars))
    longest = 0.0
    for row, (value, error, change, is_bias, color) in enumerate(bars.values()):
        end = np.nan_to_num(value) + np.nan_to_num(error)
        longest = max(longest, end)
        if np.isfinite(value):
            ax.barh(row, value, height=0.62, color=color, edgecolor="none")
        if error > 0:
            ax.plot([max(value - error, 0.0), end], [row, row], color=GREY, linewidth=1.2)
        words = _words(value, error, change, is_bias)
        ax.annotate(words, (end, row), (3, 0), textcoords="offset points", va="center", fontsize=SMALL - 0.5)
    ax.set_yticks(range(len(bars)), list(bars))
    ax.set(ylim=(len(bars) - 0.5, -0.5), xlim=(0, 1.4 * longest or 1.0), xlabel="error of the mean pull-off force [%]")
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    return ax


def _words(value: float, error: float, change: float, is_bias: bool) -> str:
    """Return the label of an entry (%): its error with the sign of the change, standard error, and subtracted bias."""
    if not np.isfinite(value):
        return "not computed"
    sign = "" if is_bias or not round(value, 2) > 0 or not abs(change) > 0 else "−" if change < 0 else "+"
    value = round(value, 2)
    error = round(error, 2)
    words = " ± ".join(with_error(value, error)) if error > 0 else number(value, digits=2)
    bias = f", {change:+.2g} subtracted".replace("-", "−") if is_bias else ""
    return f"{sign}{words}{bias}"


@styled
def cut_off(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the pull-off of `scale_dependence` over the shortest wavelength: every place, and the mean with its scatter.

    Bars are the standard deviation of the mean over seeds. The dashed line is the shortest wavelength that the scan
    shows: roughness was added left of it, and cut off right of it.
    """
    ax = axes(ax)
    force = ds["pull_off_force"].transpose("subregion", "shortest_kept", "seed")
    wavelengths = ds["shortest_kept"].values
    means = mean_over_wavelengths(ds)
    for place, values in enumerate(force.mean("seed").values):
        ax.plot(wavelengths, np.where(values > 0, values, np.nan), color=GREY, linewidth=0.6, alpha=0.6)
        if place == 0:
            ax.lines[-1].set_label("each place")
    look: dict[str, Any] = {"fmt": "o-", "color": BLUE, "capsize": 2, "markersize": 3.5, "label": "mean, its scatter"}
    ax.errorbar(wavelengths, means.mean("seed"), yerr=means.std("seed"), **look)
    shown = ds.attrs.get("shortest_wavelength", np.nan)
    if np.isfinite(shown):
        ax.axvline(shown, color=VERMILION, linewidth=0.9, linestyle=DASHED, label="shown by the scan", zorder=0)
    ax.set_xscale("log")
    ax.set_xticks(wavelengths, [f"{length:.3g}" for length in wavelengths])  # there may be no decade tick
    ax.set_xticks([], minor=True)
    if (means > 0).any():
        ax.set(yscale="log")
        log_ticks(ax.yaxis)
    else:  # a logarithmic axis without a value cannot be drawn
        ax.set_title("not computed: no place has a pull-off")
    label_axis(ax.yaxis, "pull_off_force")
    ax.set_xlabel("shortest wavelength of the surface [nm]")
    return legend(ax, loc="best")
