"""The uncertainty of the pull-off: the error budget as bars, and the pull-off over the shortest wavelength."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ...mechanics.vocabulary.error_sources import total_std
from ...mechanics.vocabulary.numbers import format_number, with_error
from .style import BLACK, BLUE, GREY, ORANGE, SMALL, Axes, axes, legend, styled


@styled
def error_budget(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the entries of an error budget as bars with their own errors, in per cent of the mean pull-off.

    Each entry has its standard error and the sign of the change, a known bias what was subtracted from the mean. Of a
    result of `extrapolated` the entries of its interval, with a mark at what remains of each after its remedy.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> budget = scan.contact.error_budget(settings={"work of adhesion": [0.9, 1.1]}, places=1, law="jkr")
    >>> ax = roughxr.figures.error_budget(budget)
    >>> ax.get_yticklabels()[-1].get_text()
    'all of these'
    """
    bars = _budget_bars(ds)
    ax = axes(ax, aspect=0.16 + 0.058 * len(bars))
    longest = 0.0
    for row, (value, error, change, remaining, subtracted, color) in enumerate(bars.values()):
        end = np.nan_to_num(value) + np.nan_to_num(error)
        longest = max(longest, end)
        if np.isfinite(value):
            ax.barh(row, value, height=0.62, color=color, edgecolor="none")
        if error > 0:
            ax.plot([max(value - error, 0.0), end], [row, row], color=GREY, linewidth=1.2)
        if remaining < value:
            ax.plot([remaining], [row], "|", color=ORANGE, markersize=7, markeredgewidth=1.4, zorder=3)
        label_text = _words(value, error, change, subtracted)
        ax.annotate(label_text, (end, row), (3, 0), textcoords="offset points", va="center", fontsize=SMALL - 0.5)
    if any(remaining < value for value, _, _, remaining, *_ in bars.values()):
        ax.plot([], [], "|", color=ORANGE, markersize=7, markeredgewidth=1.4, label="after its remedy")
        legend(ax, loc="lower right", bbox_to_anchor=(1, 1), borderpad=0)
    ax.set_yticks(range(len(bars)), list(bars))
    label = "standard deviation of the mean pull-off force [%]"
    ax.set(ylim=(len(bars) - 0.5, -0.5), xlim=(0, 1.4 * longest or 1.0), xlabel=label)
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    return ax


def _budget_bars(ds: xr.Dataset) -> dict[str, tuple]:
    """Return error, its error, change and remaining error (%), if a bias, and colour of each entry, and of all."""
    entry = ds["entry"].values
    columns = [
        100 * ds[name].values if name in ds else np.full(entry.size, np.nan)
        for name in ("relative_std", "standard_error", "pull_off_change", "remaining_std")
    ]
    is_bias = ds["known_bias"].values if "known_bias" in ds else np.zeros(entry.size, bool)
    bars: dict[str, tuple] = {str(name): (*row, BLUE) for name, *row in zip(entry, *columns, is_bias)}
    total = float(ds["total_std"]) if "total_std" in ds else total_std(ds["relative_std"])
    standard_error = float(ds["total_standard_error"]) if "total_standard_error" in ds else np.nan
    bars["all of these"] = (100 * total, 100 * standard_error, np.nan, np.nan, False, BLACK)
    return bars


def _words(value: float, error: float, change: float, is_bias: bool) -> str:
    """Return the label of an entry (%): its error with the sign of the change, standard error, and subtracted bias."""
    if not np.isfinite(value):
        return "not computed"
    sign = "" if is_bias or not round(value, 2) > 0 or not abs(change) > 0 else "−" if change < 0 else "+"
    value = round(value, 2)
    error = round(error, 2)
    text = " ± ".join(with_error(value, error)) if error > 0 else format_number(value, digits=2)
    bias = f", {change:+.2g} subtracted".replace("-", "−") if is_bias else ""
    return f"{sign}{text}{bias}"
