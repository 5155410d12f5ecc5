"""Figures of values: one for each name as dots, over a parameter as lines, and the spectrum of a scan."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics import statistics
from ...mechanics.kernels.topography.random_surface import k_correlation
from ...mechanics.statistics.laws import fitted_law
from ...mechanics.statistics.sampling import SAMPLES
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.numbers import format_number
from ...mechanics.vocabulary.refusal import Refusal
from ..wording import names_in_words
from .distributions import label_density, law_curves
from .style import (
    BLACK,
    BLUE,
    DASHED,
    GREY,
    STROKES,
    VERMILION,
    Axes,
    axes,
    label_axes,
    label_axis,
    legend,
    log_ticks,
    stroke,
    styled,
)

#: Resamples of the interval of a mean.
_RESAMPLES = 399

#: Cumulative probabilities between which fitted laws are drawn.
_LAW_RANGE = 0.001, 0.999

#: Parts of matplotlib's box of a summary, and their meaning.
_BOX_PARTS = {
    "boxes": "middle half",
    "medians": "median",
    "means": "mean",
    "whiskers": "5 to 95 %",
    "fliers": "extremes",
}

#: Formulas and the names that readers know them by.
FORMULAS = names_in_words("formula")


@styled
def named_values(ds: xr.Dataset, name: str, *, ax: Axes | None = None):
    """Draw a variable along a dimension of names as dots, one row for each name, an estimate with its interval."""
    (dim,) = ds[name].dims
    rows = ds.isel({dim: ds[name].notnull().values})
    values = rows[name].values
    low, high = (rows[end].values for end in ("low", "high")) if name == "estimate" else (values, values)
    confidence = float(ds.attrs.get("confidence", 0.95))
    names = [FORMULAS[entry] for entry in rows[dim].values] if dim == "formula" else rows[dim].values
    return _rows(names, (values, low, high), str(ds.attrs.get("variable", name)), ax, confidence)


def _rows(names: Any, columns: tuple[Any, Any, Any], label: str, ax: Axes | None, confidence: float = 0.95):
    """Draw values with the ends of their intervals, one row for each name."""
    values, low, high = (np.asarray(column, dtype=float) for column in columns)
    ax, order = _row_axes(names, ax)
    ax.hlines(order, low, high, color=BLUE, linewidth=1.2)
    ax.plot(values, order, "o", color=BLUE)
    with_interval = bool((high > low).any())
    if _is_wide(np.concatenate([values, low, high])):
        ax.set_xscale("log")
        log_ticks(ax.xaxis)
    elif min(values.min(), np.nanmin(low, initial=0.0)) >= 0:
        ax.set_xlim(left=0)
    label_axis(ax.xaxis, label)
    if with_interval:
        ax.set_xlabel(f"{100 * confidence:g} % interval of the {ax.get_xlabel()}")
    return ax


def _row_axes(names: Any, ax: Axes | None) -> tuple[Axes, np.ndarray]:
    """Return Axes with one row for each name from the top, and the positions of the rows."""
    ax = axes(ax, aspect=0.25 + 0.06 * len(names))
    order = np.arange(len(names))
    # width of a name, in characters
    ax.set_yticks(order, [textwrap.fill(str(name).replace("_", " "), 34) for name in names])
    ax.set_ylim(order.size - 0.5, -0.5)
    return ax, order


def _is_wide(values: np.ndarray) -> bool:
    """Return whether positive values span so much that a logarithmic axis shows them better."""
    finite = values[np.isfinite(values)]
    # ratio of largest to smallest value from which an axis is logarithmic
    return finite.size > 0 and finite.min() > 0 and finite.max() > 20.0 * finite.min()


@styled
def over_parameter(ds: xr.Dataset, name: str, *, ax: Axes | None = None):
    """Draw a variable over a parameter such as load, preload or radius: every place, and the mean with its interval.

    Of two parameters the longer one is the axis, and the mean for each value of the other is a line.
    """
    sample = next((dim for dim in SAMPLES if dim in ds[name].dims), None)
    along, *others = _parameters(ds, name, sample)
    ax = axes(ax)
    cases = [ds.isel({others[0]: order}) for order in range(ds.sizes[others[0]])] if others else [ds]
    for order, case in enumerate(cases):
        look = {"marker": "o", "markersize": 3.0, **stroke(order)}
        x = _positions(case[along])
        label = entry_in_words(case[others[0]]) if others else None
        if sample is None or case.sizes[sample] == 1:
            ax.plot(x, case[name].squeeze().values, label=label, **look)
            continue
        places = case[name].transpose(along, sample).values
        if not others:
            ax.plot(x, places, color=GREY, linewidth=0.35, alpha=0.6)
            ax.plot([], [], color=GREY, linewidth=0.6, label=f"{case.sizes[sample]} places")
        mean = statistics.bootstrap(case, name, statistics=["mean"], resamples=_RESAMPLES).isel(statistic=0)
        meaning = "95 % interval" if bool(np.isfinite(mean["low"]).any()) else "too few independent for an interval"
        _draw_estimates(ax, x, mean, label or f"mean, {meaning}", look)
    return legend(_labelled(ax, ds[along], name), title=_title(others))


@styled
def estimates_over_parameter(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the statistics of `bootstrap` over a parameter such as the radius, with their intervals."""
    ax = axes(ax)
    statistics_of = ds if "statistic" in ds.dims else ds.expand_dims("statistic")
    (along,) = (str(dim) for dim in statistics_of["estimate"].dims if dim != "statistic")
    x = _positions(ds[along])
    for order, label in enumerate(statistics_of["statistic"].values):
        look = {"marker": "o", "markersize": 3.0, **stroke(order)}
        _draw_estimates(ax, x, statistics_of.isel(statistic=order), str(label), look)
    title = f"with {100 * ds.attrs.get('confidence', 0.95):g} % intervals"
    return legend(_labelled(ax, ds[along], str(ds.attrs["variable"])), title=title)


def entry_in_words(coordinate: xr.DataArray) -> str:
    """Return an entry of a dimension in words."""
    value = coordinate.item()
    return value if isinstance(value, str) else format_number(value, coordinate.attrs.get("units", ""))


def _draw_estimates(ax: Axes, x: np.ndarray, statistic: xr.Dataset, label: str, look: dict[str, Any]) -> None:
    """Draw a statistic of `bootstrap` over a parameter, and its intervals."""
    ax.plot(x, statistic["estimate"], label=label, **look)
    ax.vlines(x, statistic["low"].values, statistic["high"].values, color=look["color"], linewidth=0.9)


def _parameters(ds: xr.Dataset, name: str, sample: str | None) -> list[str]:
    """Return the dimensions of a variable other than its samples, the longest first; raise for too many."""
    if "statistic" in ds[name].dims:  # lines would join a count, a mean and a deviation
        raise Refusal(
            name,
            "a summary along statistic alone, or statistics with intervals",
            ", ".join(map(str, ds[name].dims)),
            "draw result.contact.bootstrap(statistics=['mean', 'q50']), or select one entry by isel",
        )
    parameters = sorted((str(dim) for dim in ds[name].dims if dim != sample), key=lambda dim: -ds.sizes[dim])
    if len(parameters) > 2 or (len(parameters) == 2 and ds.sizes[parameters[1]] > len(STROKES)):
        raise Refusal(
            name,
            f"places and at most two parameters, the second with at most {len(STROKES)} values",
            ", ".join(map(str, ds[name].dims)),
            f"select first, for example ds.isel({parameters[-1]}=0)",
        )
    return parameters


def _title(others: list[str]) -> str | None:
    """Return the title of a legend: the long name of its parameter."""
    return schema.VARIABLES[others[0]].long_name if others and others[0] in schema.VARIABLES else None


def _positions(parameter: xr.DataArray) -> np.ndarray:
    """Return the positions of a parameter's values on the axis; words are one apart."""
    values = parameter.values
    return values.astype(float) if values.dtype.kind in "fiu" else np.arange(values.size)


def _labelled(ax, parameter: xr.DataArray, name: str):
    """Return the Axes with scales that suit the values, and with their labels."""
    positions = _positions(parameter)
    if parameter.dtype.kind not in "fiu":
        ax.set_xticks(positions, map(str, parameter.values))
        label_axis(ax.yaxis, name)
        return ax
    if _is_wide(positions):
        ax.set_xscale("log")
        log_ticks(ax.xaxis)
    if _is_wide(ax.dataLim.intervaly):
        ax.set_yscale("log")
        log_ticks(ax.yaxis)
    return label_axes(ax, str(parameter.name), name)


@styled
def fitted_laws(fits: xr.Dataset, *, ax: Axes | None = None):
    """Draw the densities of fitted laws in the order of their AIC, over the histogram of the samples."""
    ax = axes(ax)
    if "bin_edges" in fits.attrs:
        label = f"{fits.attrs['samples']} samples"
        ax.stairs(fits.attrs["density"], fits.attrs["bin_edges"], fill=True, alpha=0.18, color=BLUE, label=label)
    fits = fits.dropna("law", subset=["aic"])
    ends = [fitted_law(fits, str(law)).ppf(_LAW_RANGE) for law in fits["law"].values]
    law_curves(ax, fits, np.linspace(np.min(ends), np.max(ends), 400))
    ax.set_ylim(bottom=0)
    return legend(label_density(ax, str(fits.attrs["variable"])))


@styled
def spectrum(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw a power spectrum, the self-affine fit, or both on logarithmic axes."""
    from matplotlib.ticker import LogFormatterMathtext

    ax = axes(ax)
    if "psd" in ds:
        whole_rings = ds["wavevector"].values <= ds.attrs.get("nyquist_wavevector", np.inf)
        measured = ds.isel(wavevector=whole_rings).isel(wavevector=slice(1, None))  # the first is the mean height
        ax.plot(measured["wavevector"], measured["psd"], color=GREY, label="scan")
    if "psd_plateau" in ds:
        rolloff, shortest = (2 * np.pi / float(ds[f"{name}_wavelength"]) for name in ("rolloff", "shortest"))
        # wavevectors below the roll-off, and beyond the shortest wavelength shown, to which a fitted spectrum is drawn
        wavevector = np.geomspace(min(rolloff / 5.0, shortest), shortest * 4.0, 200)
        plateau, hurst = (float(ds[name]) for name in ("psd_plateau", "hurst_exponent"))
        density = k_correlation(wavevector, plateau, float(ds["rolloff_wavelength"]), hurst)
        ax.plot(wavevector, density, color=BLUE, label=f"self-affine fit, H = {hurst:.2g}")
        ax.axvline(shortest, color=VERMILION, linewidth=0.9, linestyle=DASHED, label="shown by the scan", zorder=0)
    ax.set(xscale="log", yscale="log")
    label_axes(ax, "wavevector", "psd")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(LogFormatterMathtext())
    return legend(ax)


@styled
def answer_rows(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the mean pull-off as scanned, of the real surface, and after the next step, with their 95 % intervals."""
    parts = {
        "as scanned": ("pull_off_force", "low", "high"),
        "real surface": ("best_estimate", "best_low", "best_high"),
        "real surface,\nafter the next step": ("best_estimate", "narrowed_low", "narrowed_high"),
    }
    available = {row: names for row, names in parts.items() if set(names) <= set(ds) and np.isfinite(ds[names[0]])}
    values, low, high = ([float(ds[names[column]]) for names in available.values()] for column in range(3))
    return _rows(list(available), (values, low, high), "pull_off_force", ax)


@styled
def violations(ds: xr.Dataset, *, ax: Axes | None = None):
    """Draw the violations of a certificate over their limits; those of zero at the left edge."""
    limit = ds["limit"].where(ds["limit"] > 0, 1.0)
    # least violation, over its limit, on the axis
    least_violation = 1e-6
    ratio = (ds["violation"] / limit).fillna(np.inf).clip(least_violation, 1 / least_violation).values
    ax, order = _row_axes(ds["check"].values, ax)
    met = ds["met"].values.astype(bool)
    for chosen, colour, label in ((met, BLUE, "met"), (~met, VERMILION, "not met, or unknown")):
        if chosen.any():
            ax.plot(ratio[chosen], order[chosen], "o", color=colour, label=label, clip_on=False)
    ax.axvline(1.0, color=BLACK, linewidth=0.8, linestyle=DASHED, label="limit")
    ax.set_xscale("log")
    ax.set_xlim(least_violation, max(10.0, 2 * ratio.max()))
    ax.set_xlabel("largest violation / limit")
    return legend(ax)


@styled
def quantile_box(ds: xr.Dataset, name: str, *, ax: Axes | None = None):
    """Draw the summary of a variable as a box: quartiles, 5 and 95 %, extremes and mean."""
    value = ds[name].to_series()
    if not {"q5", "q25", "q50", "q75", "q95"} <= set(value.index):
        raise Refusal("", "the quantiles of 5, 25, 50, 75 and 95 %", advice="draw the samples: figures.distribution")
    ax = axes(ax)
    box = {"q1": value["q25"], "med": value["q50"], "q3": value["q75"], "whislo": value["q5"], "whishi": value["q95"]}
    drawn = ax.bxp([box | {"mean": value["mean"], "fliers": [value["min"], value["max"]]}], showmeans=True)
    for part, words in _BOX_PARTS.items():
        drawn[part][0].set_label(words)
    ax.set_xticks([])
    label_axis(ax.yaxis, name)
    return legend(ax, title=f"{value['count']:g} samples")
