"""Predicted and measured pull-offs: distributions, quantiles against quantiles, and the fitted work of adhesion."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ...mechanics.statistics.means import estimated_mean
from ...mechanics.statistics.sampling import sample_bounds
from ...mechanics.studies.comparison import compare
from ...mechanics.vocabulary.numbers import format_percent
from .distributions import FEWEST_SAMPLES, distribution, draw_mean
from .style import BLACK, BLUE, DASHED, GREY, PAGE, Axes, Panels, axes, label_axis, legend, log_ticks, panels, styled


@styled
def predicted_and_measured(
    predicted: xr.Dataset, measured: xr.Dataset, *, comparison: xr.Dataset | None = None, ax: Panels | None = None
):
    """Draw the pull-off forces of both as distributions, and their quantiles against each other.

    ``comparison`` is the result of `compare` for them, if it is known already.

    Examples
    --------
    >>> import numpy as np
    >>> import roughxr
    >>> import xarray as xr
    >>> forces = np.random.default_rng(0).lognormal(3.0, 0.4, (2, 30))
    >>> predicted, measured = (xr.Dataset({"pull_off_force": ("subregion", row, {"units": "nN"})}) for row in forces)
    >>> roughxr.figures.predicted_and_measured(predicted, measured)[1].get_ylabel()
    'measured pull-off force [nN]'
    """
    distributions, right = made = panels(ax, 1, 2, aspect=0.4, width=PAGE)
    forces = {"predicted": predicted, "measured": measured}
    counts = [np.isfinite(sample_bounds(ds, "pull_off_force")[0]).sum() for ds in forces.values()]
    bins = "auto" if min(counts) >= FEWEST_SAMPLES else None
    for order, (label, ds) in enumerate(forces.items()):
        distribution(ds, "pull_off_force", ax=distributions, label=label, order=order, bins=bins)
    compared = compare(predicted, measured) if comparison is None else comparison
    best = estimated_mean(compared)
    if best is not None:
        label = "best estimate of the real mean, all known errors"
        draw_mean(distributions, *best, row=len(forces), color=BLACK, label=label)
        # the interval may lie beyond all samples
        distributions.autoscale(axis="x")
        legend(distributions, rows=len(forces) + 1)
    quantiles(compared, ax=right)
    return made


@styled
def quantiles(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw measured against predicted quantiles, from `compare`, with the line on which both are equal.

    Quantiles of 1 to 99 %, those of 5, 50 and 95 % filled; the ratio of the means, where it is known, is a dashed line,
    on which distributions of one shape lie. With a best estimate of the mean the line of equal forces is that of the
    real surface, and a band shows its interval.
    Bars are the bounds of quantiles of forces that are known by limits.
    """
    ax = axes(ax)
    predicted = ds["predicted_quantile"].values
    measured = ds["measured_quantile"].values
    low, high = (ds.get(f"measured_quantile_{end}", ds["measured_quantile"]).values for end in ("low", "high"))
    both = np.concatenate([predicted, low, high[np.isfinite(high)]])
    ends = np.array([np.nanmin(both), np.nanmax(both)])
    _line_of_equal_forces(ax, ds, ends)
    if "mean" in ds["statistic"]:
        ratio = float(ds["ratio"].sel(statistic="mean"))
        span = np.array([predicted.min(), predicted.max()])
        ax.plot(span, ratio * span, color=BLACK, linewidth=0.8, linestyle=DASHED, label=_means_label(ds, ratio))
    ax.plot(predicted, measured, color=BLUE, marker="o", markersize=2.2, linewidth=0, markerfacecolor="none")
    ax.vlines(predicted, low, np.minimum(high, ends[1]), color=BLUE, linewidth=0.6, alpha=0.4)
    marked = ds.sel(probability=[0.05, 0.5, 0.95], method="nearest")
    at = marked["predicted_quantile"].values, marked["measured_quantile"].values
    ax.plot(*at, color=BLUE, marker="o", markersize=4.0, linewidth=0, label="5, 50, 95 % quantiles")
    label_axis(ax.xaxis, "predicted_quantile")
    label_axis(ax.yaxis, "measured_quantile")
    return legend(ax)


def _line_of_equal_forces(ax: Axes, ds: xr.Dataset, ends: np.ndarray) -> None:
    """Draw the line on which measured forces equal those predicted, or the best estimate with its interval."""
    predicted = ds["predicted_quantile"].values
    best = estimated_mean(ds) if "mean" in ds["statistic"] else None
    if best is None:
        ax.plot(ends, ends, color=GREY, linewidth=0.9, label="equal")
    else:
        span = np.array([predicted.min(), predicted.max()])
        estimate, least, most = np.array(best) / float(ds["predicted"].sel(statistic="mean"))
        ax.plot(span, estimate * span, color=GREY, linewidth=0.9, label="equal to the best estimate")
        ax.fill_between(span, least * span, most * span, color=GREY, alpha=0.2, linewidth=0, label="its 95 % interval")
        ax.set_ylim(0, 1.7 * max(ends[1], estimate * span[1]))  # the band may go far beyond the forces


def _means_label(ds: xr.Dataset, ratio: float) -> str:
    """Return the ratio of the means, and how far the distributions differ beside it."""
    distance = float(ds.get("scaled_distance", np.nan))
    label = f"means: × {ratio:.2g}"
    if np.isfinite(distance):
        label += f", then at most {format_percent(distance)} apart"
    return label


@styled
def fitted_work(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the distance of predicted from measured quantiles over the work of adhesion, from `fit_pair`, with its fit.

    Where the distance is 0 all quantiles agree; the band is the interval of the fit.
    """
    ax = axes(ax)
    name = "trial_work_of_adhesion"
    ax.plot(ds[name], ds["quantile_distance"], color=BLUE, marker="o", markersize=4.0, linewidth=0.9, label="tried")
    low, high = (float(ds[f"fitted_work_{end}"]) for end in ("low", "high"))
    if np.isfinite([low, high]).all():
        ax.axvspan(
            low, high, color=BLUE, alpha=0.15, linewidth=0, label=f"{format_percent(ds.attrs['confidence'])} interval"
        )
    if np.isfinite(ds["fitted_work_of_adhesion"]):
        ax.axvline(float(ds["fitted_work_of_adhesion"]), color=BLACK, linewidth=0.8, linestyle=DASHED, label="fit")
    ax.set_xscale("log")
    log_ticks(ax.xaxis)
    label_axis(ax.xaxis, name)
    label_axis(ax.yaxis, "quantile_distance")
    ax.set_ylim(bottom=0)
    return legend(ax)
