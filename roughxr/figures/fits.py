"""A distribution with the laws fitted to it, and the interval of each bar."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from .. import statistics
from ..statistics.laws import law_density
from ..statistics.uncertainty import density_intervals
from .distributions import bin_edges, label_density, mean_interval
from .style import BLACK, GREY, Axes, axes, legend, stroke, styled


@styled
def fitted_distribution(
    ds: xr.Dataset,
    name: str = "pull_off_force",
    *,
    laws: Sequence[str] | xr.Dataset = ("normal", "log_normal", "weibull", "gumbel"),
    bins: int | str | ArrayLike = "auto",
    confidence: float = 0.95,
    ax: Axes | None = None,
):
    """Draw a histogram with the interval of each bar, the mean with its own, and fitted laws, the best first.

    Parameters
    ----------
    ds : Dataset
    name : str
        A variable along ``subregion`` or ``asperity`` alone.
    laws : sequence of str or Dataset
        Laws to fit, or a result of `statistics.fit`.
    bins : int, str or array
        As for `statistics.pdf`.
    confidence : float
        Confidence level of the intervals, by block bootstrap.
    ax : Axes, optional

    Returns
    -------
    Axes

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset({"pull_off_force": ("subregion", [1e3, 2e3, 2e3, 3e3], {"units": "nN"})})
    >>> ax = fitted_distribution(ds, laws=["normal"], ax=Figure().subplots())
    >>> ax.get_xlabel(), [text.get_text() for text in ax.get_legend().get_texts()][0]
    ('pull-off force [µN]', 'normal')
    """
    ax = axes(ax)
    values = ds[name].values[np.isfinite(ds[name].values)]
    density = statistics.pdf(ds, name, bins=bin_edges(values, bins))
    edges = density.attrs["bin_edges"]
    ax.stairs(density.values, edges, fill=True, color=GREY, alpha=0.3)
    low, high = density_intervals(ds, name, bins=edges, confidence=confidence)
    ax.vlines(density[name], low, high, color=GREY, linewidth=0.8)
    fits = laws if isinstance(laws, xr.Dataset) else statistics.fit(ds, name, laws=laws, simulations=0)
    least = edges[0] - 0.3 * np.ptp(edges)
    highest = float(max(high.max(), density.max()))
    _curves(ax, fits, np.linspace(max(least, 0.0) if values.min() >= 0 else least, edges[-1], 400), highest)
    ax.set_ylim(0, 1.25 * highest)
    mean_interval(ax, ds, name, BLACK, confidence=confidence)
    return legend(label_density(ax, name), loc="upper right")


def _curves(ax, fits: xr.Dataset, points: np.ndarray, highest: float):
    """Draw the laws in the order of their AIC; the legend gives the difference of each from the best."""
    ranked = fits.dropna("law", subset=["aic"]).sortby("aic")
    for order, law in enumerate(ranked["law"].values):
        worse = float(ranked["aic_difference"].sel(law=law))
        words = statistics.LAWS[str(law)].words.partition(",")[0]
        words += f" (ΔAIC {worse:.1f})" if order else ""
        at = points[1:] if not statistics.LAWS[str(law)].positive else points[points > 0]
        curve = law_density(ranked, str(law), at)
        shown = np.where(curve > 1.5 * highest, np.nan, curve)  # a Weibull law of shape < 1 diverges at zero
        ax.plot(at, shown, label=words, **stroke(order))
