"""Force-distance curves with their baselines, limits, pull-offs and doubts."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ...files.curves.doubts import curve_doubts
from ...files.curves.force_curves import recorded_curves
from .style import BLACK, BLUE, DASHED, GREY, label_axes, styled, tidy

#: Largest number of curves in a figure.
MOST_CURVES = 12

#: Number of panels in a row.
_COLUMNS = 3

#: Number of letters in a line above a panel.
_LETTERS = 48

#: The doubts about a curve, each with its number.
_DOUBTS = {
    "contact_point": "no contact point: the force is nowhere above the baseline",
    "standard_error": "the standard error is {:.0%} of the pull-off",
    "limit": "the limit is {:.0f} times the noise: drift or interference",
    "ruptures": "{:.0f} ruptures: the detachment has several steps",
}


@styled
def doubtful_curves(curves: Sequence[xr.Dataset], measured: xr.Dataset) -> Figure:
    """Draw retractions with baseline, limit or pull-off, and the doubts about each.

    Parameters
    ----------
    curves : sequence of Dataset
        Single curves, as `curves_pull_off` takes them.
    measured : Dataset
        Their results, along ``subregion``.

    Returns
    -------
    Figure

    Examples
    --------
    >>> import numpy as np
    >>> import roughxr
    >>> import xarray as xr
    >>> from roughxr.application.figures.curve_panels import doubtful_curves
    >>> piezo = np.linspace(20.0, -80.0, 400)
    >>> force = np.where(piezo > -10.0, 2.0 * piezo, 0.0) + np.random.default_rng(0).normal(0.0, 0.1, 400)
    >>> curve = xr.Dataset({"piezo": ("sample", piezo, {"units": "nm"}), "force": ("sample", force, {"units": "nN"})})
    >>> figure = doubtful_curves([curve], roughxr.measured.curves_pull_off(curve))
    >>> figure.axes[0].get_title(loc="left")
    'curve 0: no doubt'
    """
    rows = -(-len(curves) // _COLUMNS)
    figure = Figure(figsize=(10.0, 2.6 * rows), layout="constrained")
    for number, (curve, doubts) in enumerate(zip(curves, curve_doubts(measured))):
        ax = tidy(figure.add_subplot(rows, _COLUMNS, number + 1))
        result = measured.isel(subregion=number)
        _draw_curve(ax, curve, result)
        name = int(result["subregion"]) if "subregion" in result.coords else number
        entries = [_DOUBTS[key].format(value) for key, value in doubts.items()]
        title = f"curve {name}: {'; '.join(filter(None, [result['reason'].item(), *entries])) or 'no doubt'}"
        ax.set_title(textwrap.fill(title, _LETTERS), loc="left", fontsize=7)
    return figure


def _draw_curve(ax, curve: xr.Dataset, result: xr.Dataset) -> None:
    """Draw one retraction, its baseline, and its pull-off with error, or its limit."""
    recorded, _ = recorded_curves(curve, None)
    recorded = recorded.isel(subregion=0)
    retraction = recorded.sel(branch="retraction") if "branch" in recorded.dims else recorded
    z = retraction["piezo"].values
    force = retraction["force"].values
    ax.plot(z, force, color=GREY, linewidth=0.6)
    contact = float(result["contact_point"])
    if np.isfinite(contact):
        line = float(result["baseline_offset"]) + float(result["baseline_tilt"]) * (z - contact)
        ax.plot(z, line, color=BLACK, linewidth=0.8, label="baseline")
        limit = float(result["pull_off_at_most"])
        depth = limit
        if np.isfinite(limit):
            ax.plot(z, line - limit, color=BLUE, linewidth=0.8, linestyle=DASHED, label=f"limit {limit:.2g} nN")
        pull = float(result["pull_off_force"])
        if np.isfinite(pull):
            depth = max(pull, 1e-12)
            error = 2 * float(result["pull_off_standard_error"])
            lowest = int(np.nanargmin(np.where(z < contact, force - line, np.nan)))
            style = {"color": BLUE, "fmt": "o", "markersize": 3.0, "capsize": 2.0}
            label = f"pull-off {pull:.3g} ± {error:.2g} nN"
            ax.errorbar(z[lowest], line[lowest] - pull, error, label=label, **style)
        if np.isfinite(depth):  # the contact is cut off where it would hide the pull
            low = np.nanmin(force)
            ax.set_ylim(low - 0.5 * depth, max(np.nanmedian(force), np.nanmax(line)) + 2.0 * depth)
        ax.legend(fontsize=6, loc="best")
    label_axes(ax, "piezo", "force")
