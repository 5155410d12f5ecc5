"""Distributions over subregions or asperities."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from .. import statistics
from ..statistics.sampling import per
from ..vocabulary import schema
from .style import (
    BLACK,
    SMALL,
    Axes,
    Panels,
    Unit,
    axes,
    fold_labels,
    in_words,
    label_axis,
    legend,
    panels,
    round_ticks,
    stroke,
    styled,
    superscripts,
)

#: With fewer samples than this each is drawn, and no density.
_FEWEST = 10

#: Largest number of bins: rules for their width fail where most samples are similar and a few are far off.
_MOST_BINS = 48


@styled
def distribution(
    ds: xr.Dataset,
    name: str,
    *,
    ax: Axes | None = None,
    label: str | None = None,
    bins: int | str | ArrayLike = "auto",
    kde: bool = True,
    rug: bool = True,
    order: int = 0,
    interval: float | None = 0.95,
):
    """Draw the probability density of a variable: histogram, kernel estimate and ticks; below ten samples, points.

    Parameters
    ----------
    ds : Dataset
    name : str
        A variable along ``subregion`` or ``asperity`` alone: select one displacement first.
    ax : Axes, optional
    label : str, optional
        Label in the legend.
    bins : int, str or array
        As for `statistics.pdf`; at most 48 by a rule.
    kde : bool
        Draw a Gaussian kernel estimate within the range of the samples.
    rug : bool
        Draw a tick for each sample, which shows the few that are far off.
    order : int
        Index of the line style, where several distributions share the Axes.
    interval : float, optional
        Confidence level of the mean's interval, by block bootstrap, drawn at the top; None for no interval.

    Returns
    -------
    Axes

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ds = xr.Dataset({"force": ("subregion", [1e3, 2e3, 3e3] * 4, {"units": "nN"})})
    >>> ax = distribution(ds, "force", ax=Figure().subplots())
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('contact force [µN]', 'probability density [1/µN]')
    """
    ax = axes(ax)
    look = stroke(order)
    values = np.asarray(ds[name].values, dtype=float)
    values = values[np.isfinite(values)]
    if values.size < _FEWEST:
        return legend(_points(ax, ds, name, values, order=order, label=label, interval=interval))
    density = statistics.pdf(ds, name, bins=bin_edges(values, bins))
    smooth = kde and np.ptp(values) > 0
    ax.stairs(density.values, density.attrs["bin_edges"], fill=True, color=look["color"], alpha=0.18)
    outline = {"linewidth": 0.6, "alpha": 0.7} if smooth else {"label": label}
    ax.stairs(density.values, density.attrs["bin_edges"], color=look["color"], **outline)
    if smooth:
        estimate = statistics.pdf(ds, name, method="kde")
        estimate = estimate.sel({name: slice(values.min(), values.max())})
        ax.plot(estimate[name], estimate.values, label=label, **look)
    if rug:
        _rug(ax, values, look["color"], order)
    if interval is not None:
        mean_interval(ax, ds, name, look["color"], order=order, confidence=interval)
    return legend(label_density(ax, name))


def _points(
    ax, ds: xr.Dataset, name: str, values: np.ndarray, *, order: int, label: str | None, interval: float | None
):
    """Draw each sample, at a height that means nothing."""
    if not ax.has_data():
        ax.set(yticks=[], ylabel=f"{values.size} samples")
    height = np.full(values.size, 0.3 + 0.2 * order)
    style = {"color": stroke(order)["color"], "linestyle": "none", "marker": "o", "label": label}
    ax.plot(values, height, transform=ax.get_xaxis_transform(), **style)
    if interval is not None and values.size > 1:
        mean_interval(ax, ds, name, style["color"], order=order, confidence=interval)
    label_axis(ax.xaxis, name)
    return ax


def mean_interval(ax, ds: xr.Dataset, name: str, color: str, *, order: int = 0, confidence: float = 0.95):
    """Draw the mean and its interval by block bootstrap along the upper edge, one row for each distribution."""
    interval = statistics.bootstrap(ds, name, statistics=["mean"], confidence=confidence)
    low, high = (float(interval[end].sel(resampling="block")[0]) for end in ("low", "high"))
    mean, row = float(interval["estimate"][0]), 1.03 + 0.05 * order
    style = {"color": color, "transform": ax.get_xaxis_transform(), "clip_on": False}
    ax.plot([low, high], [row, row], linewidth=1.6, solid_capstyle="butt", **style)
    ax.plot([low, mean, high], [row] * 3, linestyle="none", marker="|", markersize=4, **style)
    ax.plot([mean], [row], marker="o", markersize=3, **style)
    if order == 0:
        words = f" mean, {100 * confidence:g} % interval"
        right = high < np.mean(ax.get_xlim())
        where = {"x": high if right else low, "ha": "left" if right else "right", "va": "center"}
        ax.text(where.pop("x"), row, words if right else words.strip() + " ", **where, fontsize=SMALL - 0.7, **style)


@styled
def asperity_statistics(catalogue: xr.Dataset, *, ax: Panels | None = None) -> np.ndarray:
    """Draw the statistics of a surface's asperities: heights, ln(B/A), axis ratio and orientation.

    Parameters
    ----------
    catalogue : Dataset
        The asperities of a scan. Saddles have no contact ellipse and are included in the heights only.
    ax : sequence of four Axes, optional

    Returns
    -------
    array of four Axes
        Heights on a logarithmic density, so that a few debris particles are visible beside thousands of peaks. B/A
        (the ratio of the principal curvatures) and b/a have unit 1.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> catalogue = xr.Dataset({
    ...     "height": ("asperity", [14.0, 15.0, 16.0]),
    ...     "curvature_min": ("asperity", [0.001, 0.002, 0.004]),
    ...     "curvature_max": ("asperity", [0.002, 0.006, 0.009]),
    ...     "orientation": ("asperity", [-1.0, 0.2, 1.0]),
    ...     "axis_ratio": ("asperity", [0.6, 0.5, 0.6]),
    ... })
    >>> made = asperity_statistics(catalogue, ax=Figure().subplots(2, 2))
    >>> [one.get_xlabel() for one in made][2]
    'axis ratio b/a'
    """
    catalogue = schema.validate(catalogue, "asperities")
    made = panels(ax, 2, 2, aspect=0.95)
    distribution(catalogue, "height", ax=made[0], kde=False, interval=None)
    made[0].set_yscale("log" if catalogue.sizes["asperity"] >= _FEWEST else "linear")
    peaks = catalogue.isel(asperity=(catalogue["curvature_min"] > 0).values)
    _anisotropy(made[1], peaks)
    _axis_ratio(made[2], peaks)
    _orientation(made[3], peaks)
    for one in made:
        fold_labels(one, 24, 22)
    return made


def _anisotropy(ax, peaks: xr.Dataset):
    name = "ln_ratio"
    ratio = xr.DataArray(np.log(peaks["curvature_max"] / peaks["curvature_min"]))
    most = float(ratio.quantile(0.99)) or 1.0
    ds = xr.Dataset({name: ratio.assign_attrs(units="1")})
    _plain_density(ax, ds, name, "ln(B/A) of the curvatures", bins=np.linspace(0, most, 41))
    ax.set_xlim(0, most)


def _axis_ratio(ax, peaks: xr.Dataset):
    _plain_density(ax, peaks, "axis_ratio", "axis ratio b/a")
    mean = float(peaks["axis_ratio"].mean())
    ax.axvline(mean, color=BLACK, linewidth=0.8, linestyle=(0, (1, 1.2)))
    ax.set_xlim(0, 1)
    ax.set_ylim(0, 1.2 * ax.get_ylim()[1])
    ax.text(mean + 0.03, 0.98 * ax.get_ylim()[1], f"mean {mean:.2f}", va="top", fontsize=SMALL)


def _orientation(ax, peaks: xr.Dataset):
    edges = np.linspace(-np.pi / 2, np.pi / 2, 19)
    distribution(peaks, "orientation", ax=ax, kde=False, rug=False, interval=None, bins=edges)
    ax.axhline(1 / np.pi, color=BLACK, linewidth=0.8, linestyle=(0, (4, 2)), label="uniform")
    ax.set_xticks(np.pi * np.array([-0.5, 0, 0.5]), ["−π/2", "0", "π/2"])
    ax.set_ylim(0, 1.35 * ax.get_ylim()[1])
    legend(ax, loc="upper right")


def _plain_density(ax, ds: xr.Dataset, name: str, words: str, bins: Any = "auto"):
    """Draw the density of a dimensionless variable, with a given label."""
    values = ds[name].values
    density = statistics.pdf(ds, name, bins=bin_edges(values[np.isfinite(values)], bins))
    look = stroke(0)
    ax.stairs(density.values, density.attrs["bin_edges"], fill=True, color=look["color"], alpha=0.18)
    ax.stairs(density.values, density.attrs["bin_edges"], color=look["color"])
    ax.set(xlabel=words, ylabel=in_words("pdf"))
    round_ticks(ax.yaxis)
    ax.set_ylim(bottom=0)


def bin_edges(values: np.ndarray, bins: Any) -> Any:
    """Return the edges that a rule finds, limited to what a figure can show; edges that are given are unchanged."""
    if not isinstance(bins, str):
        return bins
    edges = np.histogram_bin_edges(values, bins=bins)
    count = min(edges.size - 1, _MOST_BINS)
    step = _step(values)
    if step is None:
        return edges if count == edges.size - 1 else np.linspace(edges[0], edges[-1], count + 1)
    width = step * max(np.ceil((values.max() - values.min() + step) / step / count), 1.0)
    low = values.min() - step / 2
    return low + width * np.arange(np.ceil((values.max() - low) / width - 1e-9) + 1)


def _step(values: np.ndarray) -> float | None:
    """Return the step of quantised values, None for values that are not quantised.

    Bins that contain sometimes two levels and sometimes three turn a smooth distribution into a comb.
    """
    levels = np.unique(values)
    if levels.size < 3 or levels.size > values.size / 2:
        return None
    steps = np.diff(levels) / np.diff(levels).min()
    return float(np.diff(levels).min()) if np.allclose(steps, np.round(steps), atol=0.05) else None


def _rug(ax, values: np.ndarray, color: str, order: int):
    """Draw the samples as ticks between the densities and the axis, one row for each distribution."""
    from matplotlib.transforms import ScaledTranslation

    row = (3.5 + 5 * order) / 72
    below = ax.get_xaxis_transform() + ScaledTranslation(0, -row, ax.figure.dpi_scale_trans)
    style = {"color": color, "markersize": 4, "markeredgewidth": 0.5, "clip_on": False, "linestyle": "none"}
    ax.plot(np.unique(values), np.zeros(np.unique(values).size), marker="|", transform=below, **style)
    ax.spines["bottom"].set_position(("outward", 72 * row + 3.5))


def label_density(ax, name: str):
    """Label the variable on the horizontal axis, and the density, in its inverse, on the vertical one."""
    unit = label_axis(ax.xaxis, name)
    inverse = Unit(per(unit.text), 1 / unit.size)
    ax.yaxis.set_major_formatter(inverse.formatter())
    words = in_words("pdf") if inverse.text == "1" else f"{schema.VARIABLES['pdf'].long_name} [{inverse.text}]"
    ax.set_ylabel(superscripts(words))
    return ax
