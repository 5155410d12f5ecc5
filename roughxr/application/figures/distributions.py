"""Distributions over subregions or asperities."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ...mechanics import statistics
from ...mechanics.statistics.laws import LAWS, fitted_law
from ...mechanics.statistics.sampling import (
    counted_equally,
    density_units,
    limit_attributes,
    map_samples,
    sample_bounds,
    sample_dimension,
)
from ...mechanics.statistics.uncertainty import density_intervals
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.units import fraction
from ..wording import render_sentence
from .style import (
    BLACK,
    DASHED,
    GREY,
    ROW,
    Axes,
    Panels,
    axes,
    label_axis,
    legend,
    panels,
    printed_label,
    stroke,
    styled,
    ticks_in_unit,
)

#: Smallest number of samples for a density: fewer are drawn one by one.
FEWEST_SAMPLES = 10

#: Largest number of bins: rules for their width fail where most samples are similar and a few are far off.
_MOST_BINS = 48


@styled
def distribution(
    ds: xr.Dataset,
    name: str = "pull_off_force",
    *,
    laws: Sequence[str] | xr.Dataset = (),
    bins: int | str | ArrayLike | None = "auto",
    interval: float | None = 0.95,
    label: str | None = None,
    order: int = 0,
    ax: Axes | None = None,
):
    """Draw a histogram of a variable as a probability density, the mean above it; of few samples the steps of each.

    Parameters
    ----------
    ds, name
        A Dataset, and a variable along ``subregion`` or ``asperity`` alone: select one displacement first.
    laws : sequence of str or Dataset
        Names of laws to fit, such as ``statistics.LAWS``, or a result of `statistics.fit`: they are drawn in the order
        of their AIC, with the interval of each bar. All places count equally then, as in the fit.
    bins : int, str or array, optional
        As for `statistics.pdf`; at most 48 by a rule. None, and by default for fewer than ten samples, for the share of
        samples below each value.
    interval : float, optional
        Confidence level of the intervals of mean and bars, by bootstrap; None for no interval.
    label, order
        Label in the legend, and index of the line style where several distributions share the Axes.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=500, materials="glass")
    >>> pull_offs = scan.contact.pull_off_map(subregions=(8, 8))
    >>> roughxr.figures.distribution(pull_offs, laws=["normal", "weibull"]).get_xlabel()
    'pull-off force [nN]'
    """
    sample_dimension(map_samples(ds, name), name)
    ax = axes(ax)
    if len(laws):
        ds = counted_equally(ds)
    bounds = sample_bounds(ds, name)
    bounds = bounds[:, np.isfinite(bounds[0])]
    values = bounds[np.isfinite(bounds)]
    count = bounds.shape[1]
    limits = render_sentence("answer.toml", "limits", {"places": count, **limit_attributes(bounds)})
    legend_text = "; ".join(filter(None, [label and f"{label} ({count})", limits])) or None
    look = {"label": legend_text, **stroke(order)}
    if isinstance(bins, str):
        bins = None if bins == "auto" and count < FEWEST_SAMPLES else _edges_by_rule(values, bins)
    if bins is None:
        _steps(ax, bounds, look)
        label_axis(ax.xaxis, name)
    else:
        edges = _bars(ax, ds, name, bins, look)
        if len(laws):
            _laws(ax, ds, name, values, edges, laws, interval)
        label_density(ax, name)
        ax.set_ylim(0, 1.05 * ax.dataLim.y1)  # of all distributions on these Axes
    if interval is None or values.size < 2:
        return legend(ax)
    confidence = fraction(interval, "interval")
    _mean_with_interval(ax, ds, name, confidence, counted="mean" if label else f"mean of {count}", order=order)
    return legend(ax, rows=order + 1)


def _steps(ax, bounds: np.ndarray, look: dict[str, Any]) -> None:
    """Draw the share of samples below a value; of samples known by limits it lies between two curves."""
    import seaborn

    seaborn.ecdfplot(x=bounds[1], ax=ax, marker="o", **look)
    if (bounds[0] < bounds[1]).any():
        seaborn.ecdfplot(x=bounds[0], ax=ax, **{**look, "label": None, "linewidth": 0.8})
    ax.set(ylim=(0, 1.03), ylabel="share of samples below")


def _bars(ax, ds: xr.Dataset, name: str, bins: ArrayLike, look: dict[str, Any]) -> np.ndarray:
    """Draw the probability density of a variable as a histogram, and return the edges of its bins."""
    import seaborn

    density = statistics.pdf(ds, name, bins=bins)
    edges = density.attrs["bin_edges"]
    bars = {"stat": "count", "element": "step", "alpha": 0.18, "linewidth": 0.8}  # not scaled: limits are in no bin
    seaborn.histplot(x=density[name].values, weights=density.values, bins=edges.tolist(), ax=ax, **bars, **look)
    return edges


def _mean_with_interval(ax, ds: xr.Dataset, name: str, interval: float, *, counted: str, order: int) -> None:
    """Draw the mean of a variable with its interval above the Axes; the first distribution has them in the legend."""
    mean = statistics.bootstrap(ds, name, statistics=["mean"], confidence=interval)
    ends = [float(mean[part].item()) for part in ("estimate", "low", "high")]
    accuracy = f"{100 * interval:g} % interval" if np.isfinite(ends[1]) else "too few independent"
    draw_mean(ax, *ends, row=order, color=stroke(order)["color"], label=None if order else f"{counted}, {accuracy}")


def _edges_by_rule(values: np.ndarray, rule: str) -> np.ndarray:
    """Return the edges of bins by a rule, of at most 48 bins."""
    edges = np.histogram_bin_edges(values, bins=rule)
    if edges.size <= _MOST_BINS + 1:
        return edges
    return np.linspace(edges[0], edges[-1], _MOST_BINS + 1)


def draw_mean(ax, mean: float, low: float, high: float, *, row: int, color: str, label: str | None = None):
    """Draw a mean and its interval above the Axes, one row for each distribution."""
    high = np.nan if np.isinf(high) else high
    style = {"color": color, "transform": ax.get_xaxis_transform(), "clip_on": False, "capsize": 2}
    error = [[mean - low], [high - mean]]
    ax.errorbar([mean], [1 + ROW * (row + 0.6)], xerr=error, fmt="o", markersize=3, label=label, **style)


def _laws(ax, ds: xr.Dataset, name: str, values, edges, laws: Sequence[str] | xr.Dataset, interval: float | None):
    """Draw the bars' intervals, and laws in the order of their AIC, each with its difference from the best."""
    density = statistics.pdf(ds, name, bins=edges)
    highest = float(density.max())
    if interval is not None:
        low, high = density_intervals(ds, name, bins=edges, confidence=interval)
        ax.vlines(density[name], low, high, color=GREY, linewidth=0.8)
        highest = max(highest, float(high.max()))
    fits = laws if isinstance(laws, xr.Dataset) else statistics.fit(ds, name, laws=laws, simulations=0)
    least = edges[0] - 0.3 * np.ptp(edges)
    points = np.linspace(max(least, 0.0) if values.min() >= 0 else least, edges[-1], 400)[1:]
    law_curves(ax, fits, points, 1.2 * highest)


def law_curves(ax, fits: xr.Dataset, points: np.ndarray, highest: float = np.inf) -> None:
    """Draw the densities of fitted laws in the order of their AIC, where they are below ``highest``."""
    ranked = fits.dropna("law", subset=["aic"]).sortby("aic")
    for order, law in enumerate(map(str, ranked["law"].values)):
        worse = float(ranked["aic_difference"].sel(law=law))
        label = LAWS[law].words.partition(",")[0] + (f" (ΔAIC {worse:.1f})" if order else "")
        inside = points[points > 0] if LAWS[law].positive else points
        curve = fitted_law(ranked, law).pdf(inside)
        shown = np.where(curve > highest, np.nan, curve)  # a Weibull law of shape < 1 diverges at zero
        ax.plot(inside, shown, label=label, **stroke(order))


@styled
def asperity_statistics(catalogue: xr.Dataset, *, ax: Panels | None = None) -> np.ndarray:
    """Draw the statistics of a catalogue of asperities on four Axes: heights, ln(B/A), axis ratio and orientation.

    Saddles have no contact ellipse and are included in the heights only, whose density is logarithmic to show few
    debris particles among thousands of peaks. Orientations are compared with the uniform density, with a band of two
    standard deviations of a random sample.

    Examples
    --------
    >>> import roughxr
    >>> catalogue = roughxr.open_sample("glass").contact.asperities()
    >>> panels = roughxr.figures.asperity_statistics(catalogue)
    >>> [panel.get_xlabel() for panel in panels[:2]]
    ['height [nm]', 'ln(B/A) of the\\ncurvatures']
    """
    catalogue = schema.validate(catalogue, "asperities")
    heights, anisotropy, ratio, orientation = made = panels(ax, 2, 2, aspect=0.95)
    distribution(catalogue, "height", ax=heights, interval=None)
    if catalogue.sizes["asperity"] >= FEWEST_SAMPLES:
        heights.set_yscale("log")
        heights.autoscale(axis="y")
        label_density(heights, "height")
    peaks = catalogue.isel(asperity=(catalogue["curvature_min"] > 0).values)
    peaks = peaks.assign(ln_ratio=np.log(peaks["curvature_max"] / peaks["curvature_min"]))
    largest_ratio = float(peaks["ln_ratio"].quantile(0.99)) or 1.0
    distribution(peaks, "ln_ratio", ax=anisotropy, interval=None, bins=np.linspace(0, largest_ratio, 41))
    anisotropy.set(xlim=(0, largest_ratio), xlabel="ln(B/A) of the curvatures")
    distribution(peaks, "axis_ratio", ax=ratio, interval=None)
    mean = float(peaks["axis_ratio"].mean())
    ratio.axvline(mean, color=BLACK, linewidth=0.8, linestyle=":", label=f"mean {mean:.2f}")
    ratio.set(xlim=(0, 1), xlabel="axis ratio b/a")
    legend(ratio)
    _orientations(orientation, peaks)
    for axis in (axis for panel in made for axis in (panel.xaxis, panel.yaxis)):
        axis.set_label_text("\n".join(textwrap.wrap(axis.get_label_text(), 21)))
    return made


def _orientations(ax, peaks: xr.Dataset):
    """Draw the orientations, with the uniform density and two standard deviations of a random sample."""
    bins = 18
    distribution(peaks, "orientation", ax=ax, interval=None, bins=np.linspace(-np.pi / 2, np.pi / 2, bins + 1))
    spread = 2 * np.sqrt(bins / max(peaks.sizes["asperity"], 1))
    ax.axhspan(max(1 - spread, 0) / np.pi, (1 + spread) / np.pi, color=BLACK, alpha=0.15, linewidth=0)
    ax.axhline(1 / np.pi, color=BLACK, linewidth=0.8, linestyle=DASHED, label="uniform")
    ax.set_xticks(np.pi * np.array([-0.5, 0, 0.5]), ["−π/2", "0", "π/2"])
    legend(ax)


def label_density(ax, name: str):
    """Label the horizontal axis by the variable, and the vertical one by the density in its inverse units."""
    unit, size = label_axis(ax.xaxis, name)
    ticks_in_unit(ax.yaxis, 1 / size)
    ax.set_ylabel(printed_label("pdf", density_units(unit)))
    return ax
