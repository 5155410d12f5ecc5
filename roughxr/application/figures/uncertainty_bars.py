"""The uncertainty of the pull-off: the error budget as bars, and the pull-off over the shortest wavelength."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
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
    table = _entries(ds)
    ax = axes(ax, aspect=0.16 + 0.058 * len(table))
    rows = np.arange(len(table))
    value = table["relative_std"]
    error = table["standard_error"].fillna(0)
    colors = [BLUE] * (len(table) - 1) + [BLACK]
    ends: dict[str, Any] = {"xerr": [np.minimum(value, error), error], "ecolor": GREY, "error_kw": {"elinewidth": 1.2}}
    bars = ax.barh(rows, value.fillna(0), height=0.62, color=colors, **ends)
    ax.bar_label(bars, [_words(*entry) for entry in table.values], padding=3, fontsize=SMALL - 0.5)
    is_remedied = (table["remaining_std"] < value).values
    if is_remedied.any():
        mark: dict[str, Any] = {
            "linestyle": "none",
            "markersize": 7,
            "markeredgewidth": 1.4,
            "label": "after its remedy",
        }
        ax.plot(table["remaining_std"][is_remedied], rows[is_remedied], "|", color=ORANGE, **mark)
    legend(ax)
    ax.set_yticks(rows, table.index)
    label = "standard deviation of the mean pull-off force [%]"
    longest = float((value.fillna(0) + error).max())
    ax.set(ylim=(len(table) - 0.5, -0.5), xlim=(0, 1.4 * longest or 1.0), xlabel=label)
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    return ax


def _entries(ds: xr.Dataset) -> pd.DataFrame:
    """Return error, its error, change and remaining error (%) of each entry and of all, and whether it is a bias."""
    names = ["relative_std", "standard_error", "pull_off_change", "remaining_std"]
    table = 100 * ds[[name for name in names if name in ds]].to_dataframe().reindex(columns=names).astype(float)
    table["known_bias"] = ds["known_bias"].values if "known_bias" in ds else False
    total = float(ds["total_std"]) if "total_std" in ds else total_std(ds["relative_std"])
    standard_error = float(ds["total_standard_error"]) if "total_standard_error" in ds else np.nan
    table.loc["all of these"] = [100 * total, 100 * standard_error, np.nan, np.nan, False]
    return table


def _words(value: float, error: float, change: float, _: float, is_bias: bool) -> str:
    """Return the label of an entry (%): its error with the sign of the change, standard error, and subtracted bias."""
    if not np.isfinite(value):
        return "not computed"
    sign = "" if is_bias or not round(value, 2) > 0 or not abs(change) > 0 else "−" if change < 0 else "+"
    value = round(value, 2)
    error = round(error, 2)
    text = " ± ".join(with_error(value, error)) if error > 0 else format_number(value, digits=2)
    bias = f", {change:+.2g} subtracted".replace("-", "−") if is_bias else ""
    return f"{sign}{text}{bias}"
