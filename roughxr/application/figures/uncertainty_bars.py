"""The uncertainty of the pull-off: the error budget as bars, and the pull-off over the shortest wavelength."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.vocabulary.error_sources import KnownError, read_errors, total_error
from ...mechanics.vocabulary.numbers import format_number
from ..wording.intervals import with_error
from .style import BLACK, BLUE, GREY, ORANGE, SMALL, Axes, axes, legend, styled


@styled
def error_budget(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the entries of an error budget as bars with their own errors, in per cent of the mean pull-off.

    Each entry has its standard error and the sign of the change, a known bias what was subtracted from the mean. Of a
    result of `extrapolated` the entries of its interval, with a mark at what remains of each after its remedy.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((48, 48), 10, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.1)
    >>> budget = scan.contact.error_budget(settings={"work of adhesion": [0.9, 1.1]}, places=1, law="jkr")
    >>> ax = roughxr.figures.error_budget(budget)
    >>> ax.get_yticklabels()[-1].get_text()
    'all of these'
    """
    errors = read_errors(ds)
    entries = errors | {"all of these": total_error(errors.values())}
    ax = axes(ax, aspect=0.16 + 0.058 * len(entries))
    rows = np.arange(len(entries))
    std = 100 * np.nan_to_num([entry.std for entry in entries.values()])
    error = 100 * np.nan_to_num([entry.standard_error for entry in entries.values()])
    colors = [BLUE] * len(errors) + [BLACK]
    ends: dict[str, Any] = {"xerr": [np.minimum(std, error), error], "ecolor": GREY, "error_kw": {"elinewidth": 1.2}}
    bars = ax.barh(rows, std, height=0.62, color=colors, **ends)
    ax.bar_label(bars, [_words(entry) for entry in entries.values()], padding=3, fontsize=SMALL - 0.5)
    remaining = 100 * ds["remaining_std"].values if "remaining_std" in ds else std[:-1]
    is_remedied = remaining < std[:-1]
    if is_remedied.any():
        mark: dict[str, Any] = {
            "linestyle": "none",
            "markersize": 7,
            "markeredgewidth": 1.4,
            "label": "after its remedy",
        }
        ax.plot(remaining[is_remedied], rows[:-1][is_remedied], "|", color=ORANGE, **mark)
    legend(ax)
    ax.set_yticks(rows, list(entries))
    label = "standard deviation of ln(mean pull-off) [%]"
    longest = float((std + error).max())
    ax.set(ylim=(len(entries) - 0.5, -0.5), xlim=(0, 1.4 * longest or 1.0), xlabel=label)
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    return ax


def error_in_percent(error: KnownError) -> str:
    """Return an error with its standard error in per cent."""
    std = round(100 * error.std, 2)
    standard_error = round(100 * error.standard_error, 2)
    return " ± ".join(with_error(std, standard_error)) if standard_error > 0 else format_number(std, digits=2)


def _words(error: KnownError) -> str:
    """Return the label of an error in per cent: with the sign of the change, standard error, and subtracted bias."""
    if not np.isfinite(error.std):
        return "not computed"
    text = error_in_percent(error)
    change = error.pull_off_change
    if error.known_bias:
        return f"{text}, {100 * change:+.2g} subtracted".replace("-", "−")
    sign = "−" if change < 0 else "+"
    return f"{sign}{text}" if round(error.std, 4) > 0 and abs(change) > 0 else text
