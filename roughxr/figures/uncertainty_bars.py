"""The uncertainty of the pull-off: the error budget as bars, and the pull-off over the shortest wavelength."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..studies.roughness_scale import mean_over_wavelengths
from .style import BLACK, BLUE, GREY, SMALL, VERMILION, Axes, axes, label_axis, legend, log_ticks, styled


@styled
def error_budget(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the entries of an error budget as bars with their own errors, in per cent of the mean pull-off.

    Parameters
    ----------
    ds : Dataset
        From `error_budget`.
    ax : Axes, optional

    Returns
    -------
    Axes
        In the order of the budget from the top, each with its standard error and the sign of the change, a known bias
        with what was subtracted from the mean; then the total. An entry that was not computed has no bar.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> values = {"relative_error": [0.03, np.nan], "standard_error": [0.01, np.nan], "known_bias": [False, False]}
    >>> values |= {"pull_off_change": [-0.03, np.nan]}
    >>> entries = {name: ("entry", one) for name, one in values.items()}
    >>> totals = {"total_error": 0.03, "total_standard_error": 0.01}
    >>> ax = error_budget(xr.Dataset(entries | totals, {"entry": ["modulus", "tip"]}), ax=Figure().subplots())
    >>> [float(round(bar.get_width(), 6)) for bar in ax.patches], [text.get_text() for text in ax.texts]
    ([3.0, 3.0], ['−3 ± 1', 'not computed', '3 ± 1'])
    """
    numbers = [100 * ds[name].values for name in ("relative_error", "standard_error", "pull_off_change")]
    bars = {str(name): _Bar(*values) for name, *values in zip(ds["entry"].values, *numbers, ds["known_bias"].values)}
    rows = [(name, bar, BLUE) for name, bar in bars.items()]
    rows.append(("all of these", _Bar(100 * float(ds["total_error"]), 100 * float(ds["total_standard_error"])), BLACK))
    ax = axes(ax, aspect=0.16 + 0.058 * len(rows))
    for row, (_, bar, color) in enumerate(rows):
        bar.draw(ax, row, color)
    ax.set_yticks(range(len(rows)), [name for name, *_ in rows])
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.set_xlim(0, 1.4 * max([bar.end for _, bar, _ in rows if np.isfinite(bar.value)], default=1.0) or 1.0)
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    ax.set_xlabel("error of the mean pull-off force [%]")
    return ax


class _Bar(NamedTuple):
    """One entry, in per cent of the mean."""

    value: float
    error: float
    change: float = np.nan
    is_bias: bool = False

    @property
    def end(self) -> float:
        return self.value + np.nan_to_num(self.error)

    def draw(self, ax, row: int, color: str) -> None:
        """Draw the bar with its own error, or write that there is none."""
        known = np.isfinite(self.value)
        if known:
            ax.barh(row, self.value, height=0.62, color=color, edgecolor="none")
        if known and self.error > 0:
            ax.plot([max(self.value - self.error, 0.0), self.end], [row, row], color=GREY, linewidth=1.2)
        style = {"fontsize": SMALL - 0.5, "va": "center", "textcoords": "offset points"}
        at = self.end if known else 0.0
        ax.annotate(self._words(), (at, row), (3, 0), color=BLACK if known else GREY, **style)

    def _words(self) -> str:
        if not np.isfinite(self.value):
            return "not computed"
        sign = "" if self.is_bias or not abs(self.change) > 0 else "−" if self.change < 0 else "+"
        own = f" ± {_number(self.error)}" if np.isfinite(self.error) else ""
        bias = f", {self.change:+.2g} subtracted".replace("-", "−") if self.is_bias else ""
        return f"{sign}{_number(self.value)}{own}{bias}"


def _number(value: float) -> str:
    return f"{value:.2g}" if value < 100 else f"{value:.0f}"


@styled
def cut_off(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the pull-off over the shortest wavelength of the surface: every place, and the mean with its scatter.

    Parameters
    ----------
    ds : Dataset
        From `scale_dependence`.
    ax : Axes, optional

    Returns
    -------
    Axes
        Both axes logarithmic. Bars are the standard deviation of the mean over seeds; the dashed line is the shortest
        wavelength that the scan shows: roughness was added left of it, and cut off right of it.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset({"pull_off_force": (("subregion", "shortest_kept", "seed"), [[[1.0], [3.0]]])})
    >>> ds = ds.assign_coords(shortest_kept=[10.0, 20.0]).assign_attrs(shortest_wavelength=20.0)
    >>> cut_off(ds, ax=Figure().subplots()).get_xscale()
    'log'
    """
    from matplotlib.ticker import NullLocator

    ax = axes(ax)
    force = ds["pull_off_force"].transpose("subregion", "shortest_kept", "seed")
    wavelengths, means = ds["shortest_kept"].values, mean_over_wavelengths(ds)
    for place, values in enumerate(force.mean("seed").values):
        ax.plot(wavelengths, np.where(values > 0, values, np.nan), color=GREY, linewidth=0.6, alpha=0.6)
        if place == 0:
            ax.lines[-1].set_label("each place")
    look: dict[str, Any] = {"fmt": "o-", "color": BLUE, "capsize": 2, "markersize": 3.5, "label": "mean, its scatter"}
    ax.errorbar(wavelengths, means.mean("seed"), yerr=means.std("seed"), **look)
    shown = ds.attrs.get("shortest_wavelength", np.nan)
    if np.isfinite(shown):
        ax.axvline(shown, color=VERMILION, linewidth=0.9, linestyle=(0, (4, 2)), label="shown by the scan", zorder=0)
    ax.set(xscale="log")
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticks(
        wavelengths, [f"{length:.3g}" for length in wavelengths]
    )  # a factor of four has hardly a tick of its own
    if (means > 0).any():
        ax.set(yscale="log")
        log_ticks(ax.yaxis)
    else:  # a logarithmic axis without a value cannot be drawn
        ax.set_title("not computed: no place has a pull-off")
    label_axis(ax.yaxis, "pull_off_force")
    ax.set_xlabel("shortest wavelength of the surface [nm]")
    return legend(ax, loc="best")
