"""`measured`, `compare` and `fit`: measured pull-off forces, and their comparison with those of a run."""

from __future__ import annotations

import warnings
from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from ...files.curves.curve_fit import fit_curve
from ...files.curves.curves import open_curves
from ...files.curves.doubts import most_doubtful
from ...files.curves.opening import open_pull_off
from ...files.images.channel import UnreadableScan
from ...mechanics import statistics
from ...mechanics.contact.mesh import FRONT, Mesh, UnresolvedContact
from ...mechanics.scans import regions
from ...mechanics.statistics.censoring import RELATIVE_STD
from ...mechanics.statistics.means import estimated_mean
from ...mechanics.statistics.sampling import CONDITION, SHARE, sample_bounds
from ...mechanics.studies.comparison import compare
from ...mechanics.studies.fitting import fit_pair
from ...mechanics.vocabulary.numbers import format_number
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.schema import one_of
from .. import archive, figures
from .. import tables as exports
from ..figures.curve_panels import MOST_CURVES, doubtful_curves
from ..headline import best_estimate
from ..report.summary import PLACES, with_few_digits
from ..sentences import comparison_sentence, fit_sentence
from ..wording import names_in_words, render_sentence
from ..wording.intervals import bounds_in_words, with_error, with_interval
from . import words
from .file_commands import image_options, print_attributes, save_picture


def measurement(files: list[str], options: Namespace) -> xr.Dataset:
    """Return the measured pull-offs in files, read with the given options."""
    constant = options.spring_constant and words.number(options.spring_constant)
    known = {"units": options.units, "sensitivity": options.sensitivity, "spring_constant": constant}
    known |= {"place_units": options.place_units, "pulls": options.pulls}
    return open_pull_off(files, **image_options(options), **known, baseline=_baseline(options))


def _baseline(options: Namespace) -> float | tuple[float, float] | None:
    """Return the share of the travel that may contain the baseline, or its two ends."""
    if options.baseline is None:
        return None
    if len(options.baseline) == 1:
        return options.baseline[0]
    if len(options.baseline) > 2:
        raise Refusal("--baseline", "a part of the travel, or its two ends", f"{len(options.baseline)} numbers")
    nearest, farthest = options.baseline
    return nearest, farthest


def describe(options: Namespace) -> None:
    """Print the attributes of measured pull-offs, and their mean and quantiles with intervals."""
    if options.sphere_radius:
        _describe_fits(options)
        return
    ds = measurement(options.file, options)
    print_attributes(ds)
    print(f"places: {'known' if 'subregion_x' in ds.coords else 'not known'}")
    print(f"values: {int(ds['pull_off_force'].count())} of {ds['pull_off_force'].size} rows, curves or pixels")
    if "reason" in ds:
        _print_curves(ds, "used")
    _print_sample(ds)
    if options.output:
        print(f"written to {exports.to_table(with_few_digits(ds), options.output)}")
    if options.picture:
        _draw_doubtful(ds, options)


def _print_sample(ds: xr.Dataset) -> None:
    """Print the statistics of pull-off forces, at each condition where there are several, or the only force."""
    bounds = sample_bounds(ds, "pull_off_force")
    low, high = bounds[:, np.isfinite(bounds[0])]
    if low.size == 1 and low[0] < high[0]:
        print(f"\npull-off force: {bounds_in_words(low[0], high[0])}")
    elif low.size == 1:
        error = float(ds["pull_off_standard_error"].max()) if "pull_off_standard_error" in ds else 0.0
        parts = with_error(float(low[0]), error)[: 2 if error > 0 else 1]
        print(f"\npull-off force: {' ± '.join(parts)} nN")
    elif low.size and CONDITION in ds.coords:
        for value, part in ds.groupby(CONDITION):
            print(f"\n{ds.attrs[CONDITION]}: {value:g}")
            if part.sizes["subregion"] == 1:
                print(f"pull-off force: {float(part['pull_off_force'][0]):.4g} nN")
                continue
            _print_statistics(statistics.bootstrap(part, "pull_off_force"))
    elif low.size:
        _print_statistics(statistics.bootstrap(ds, "pull_off_force"))


def _draw_doubtful(ds: xr.Dataset, options: Namespace) -> None:
    """Draw the most doubtful curves of the files."""
    if "reason" not in ds:
        raise Refusal("--picture", "force-distance curves", ds.attrs["measured"], "leave --picture out")
    constant = options.spring_constant and words.number(options.spring_constant)
    numbers = most_doubtful(ds, MOST_CURVES)
    curves = {}
    first = 0
    for file in options.file:
        opened = open_curves(file, units=options.units, sensitivity=options.sensitivity, spring_constant=constant)
        count = opened.sizes.get("subregion", 1)
        for place in numbers[(numbers >= first) & (numbers < first + count)]:
            curves[place] = opened.isel(subregion=place - first) if "subregion" in opened.dims else opened
        first += count
    figure = doubtful_curves([curves[place] for place in numbers], ds.isel(subregion=numbers))
    save_picture(figure, options.picture)


def _print_statistics(table: xr.Dataset) -> None:
    """Print mean, standard deviation and quantiles of pull-off forces with their intervals."""
    limits = render_sentence("answer.toml", "limits", {"places": table.attrs["samples"], **table.attrs})
    if not limits:
        print("\npull-off force, nN, with its 95 % interval:")
        print(_with_intervals(table, {"estimate": ""}))
        return
    intervals = table.attrs.get("no_interval", "95 % intervals hold wherever these forces lie")
    print(f"\nknown by limits: {limits}; {intervals}")
    law = table.attrs.get("law", "none: fewer than three forces are measured")
    print(f"law of the likelihood with censoring: {law}")
    by_law = table.assign(low=table["likelihood_low"], high=table["likelihood_high"])
    shown = {"pull-off force": table, "by a likelihood with censoring": by_law}
    rows = {}
    for name in table["statistic"].values.tolist():
        ends = [_with_ends(part.sel(statistic=name), "estimate") for part in shown.values()]
        rows[_STATISTICS.get(name, name)] = [bounds_in_words(*ends[0][1:]), with_interval(*ends[1], name="")]
    print(pd.DataFrame.from_dict(rows, orient="index", columns=list(shown)).to_string(justify="left"))


def _print_curves(ds: xr.Dataset, accepted: str) -> None:
    """Print the numbers of curves that were accepted, and of the others by reason."""
    reasons = ds["reason"].to_series().value_counts()
    print("curves: " + ", ".join(f"{count} {reason or accepted}" for reason, count in reasons.items()))


def _describe_fits(options: Namespace) -> None:
    """Print the moduli and works of adhesion fitted to a file's curves: of one, or the medians of many."""
    constant = options.spring_constant and words.number(options.spring_constant)
    radius = words.number(options.sphere_radius)
    fits = []
    for file in options.file:
        try:  # a table of forces does not need the spring constant, the fit does
            curves = open_curves(file, sensitivity=options.sensitivity)
            needed = constant
        except UnreadableScan:
            curves = open_curves(file, sensitivity=options.sensitivity, spring_constant=constant)
            needed = None
        fits.append(fit_curve(curves, sphere_radius=radius, spring_constant=needed))
    fit = xr.concat(fits, "subregion", combine_attrs="override") if len(fits) > 1 else fits[0]
    print_attributes(fit)
    _print_curves(fit, "fitted")
    laws = fit["law"].where(fit["reason"] == "", drop=True)
    print("law: " + ", ".join(f"{law} ({n})" for law, n in laws.to_series().value_counts().items()))
    if not laws.size:
        return
    of = "" if laws.size == 1 else ", medians of the curves"
    middle = fit.drop_vars(["law", "reason"]).median("subregion")
    for value, ends, units in (("contact_modulus", "modulus", "GPa"), ("work_of_adhesion", "work", "J/m²")):
        best, low, high = (float(middle[f"fitted_{name}"]) for name in (value, f"{ends}_low", f"{ends}_high"))
        print(f"{value.replace('_', ' ')}: {with_interval(best, low, high, units)}{of}")
    if options.output:
        print(f"written to {exports.to_table(with_few_digits(fit), options.output)}")


@archive.checked_names
def compare_with_run(options: Namespace) -> None:
    """Print the ratios of measured to predicted pull-off forces, and the test of a common distribution."""
    groups = archive.load(_archive_of(options))
    predicted = _predicted(options, groups)
    own = measurement(options.file, options)
    extrapolation = groups.get("statistics/extrapolated") if options.method == "adhesive" else None
    compared = compare(predicted, own, extrapolation=extrapolation, force_std=options.force_std)
    print(f"pull-off forces, nN, predicted ({options.method}) and measured, with 95 % intervals:")
    columns = {"predicted": "predicted", "measured": "measured", "ratio": "measured / predicted"}
    print(_with_intervals(_with_scatter(compared), columns))
    print()
    if estimated_mean(compared) is None:
        print(render_sentence("comparison.toml", "as_scanned", {}))
    print(comparison_sentence(compared))
    print(render_sentence("comparison.toml", "counted", _counts(compared, predicted, own)))
    if options.picture:
        axes = Figure(figsize=(6.9, 2.9), layout="constrained").subplots(1, 2)
        figures.predicted_and_measured(predicted, own, comparison=compared, ax=axes)
        save_picture(axes[0].figure, options.picture)


def _predicted(options: Namespace, groups: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Return the pull-offs of a run by the requested method; raise if it has none."""
    names = [name.partition("/") for name, ds in groups.items() if name != PLACES and _has_pull_off(ds)]
    methods = [method for kind, _, method in names if kind == "statistics"]
    if not methods:
        raise Refusal(options.run, "a run with pull-off forces", "none", "make it with roughxr run")
    return groups[f"statistics/{one_of(options.method, methods, '--method')}"].load()


def _counts(compared: xr.Dataset, predicted: xr.Dataset, measured: xr.Dataset) -> dict[str, Any]:
    """Return the numbers of forces that a comparison counts, and of measured ones that are lost or limits."""
    low, high = sample_bounds(measured, "pull_off_force")
    known = int(np.isfinite(low).sum())
    rows = measured["pull_off_force"].size
    return {
        "predicted_count": int(predicted["pull_off_force"].count()),
        "predicted_places": float(compared.predicted_places),
        "measured_count": known,
        "measured_places": float(compared.measured_places),
        "rows": rows,
        "lost": rows - known,
        "limited": int((low < high).sum()),
    }


@archive.checked_names
def fit_to_run(options: Namespace) -> None:
    """Print the work of adhesion at which a run's prediction and measured forces agree."""
    groups = archive.load(_archive_of(options))
    solved = groups.get("solutions/adhesive")
    if solved is None or SHARE in solved.coords:
        raise Refusal(options.run, "a run of a probe with adhesion", "none", "make it with roughxr run")
    how: dict[str, Any] = {"method": options.method, "subregions": regions.sample(solved, _FITTED_PLACES)}
    if options.method == "adhesive":
        how |= {"mesh": Mesh(int(solved["mesh"].max()) or FRONT), "law": solved.attrs["law"]}
        how["preload"] = solved.attrs.get("preload", 0.0)
    estimate = groups["statistics/extrapolated"] if best_estimate(groups) else None
    measured = measurement(options.file, options)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnresolvedContact)  # the mesh is the run's, which stated its error
        fit = fit_pair(groups["scan"], measured, extrapolation=estimate, force_std=options.force_std, **how)
    print(fit_sentence(fit))
    if options.picture:
        save_picture(figures.plot(fit).figure, options.picture)
    if np.isfinite(fit["fitted_work_of_adhesion"]):
        print(f"run again with --work-of-adhesion {format_number(fit['fitted_work_of_adhesion'])}")


def _archive_of(options: Namespace) -> Path:
    """Return the archive of the run; raise where the measured forces come first."""
    path = Path(options.run)
    if path.is_file() and path.suffix != ".nc":
        raise Refusal(path, "a run first, then the measured forces", "another file")
    return archive.run_archive(path)


#: Number of a run's places at which a fit predicts.
_FITTED_PLACES = 16

#: Statistics in words.
_STATISTICS = names_in_words("statistic")


def _with_scatter(compared: xr.Dataset) -> xr.Dataset:
    """Return a comparison with a row of the relative standard deviations after that of the means."""
    row = {}
    for name in ("predicted", "measured"):
        for end in ("", "_low", "_high"):
            row[name + end] = compared[f"{name}_{RELATIVE_STD}{end}"]
    for end in ("", "_low", "_high"):
        row[f"ratio{end}"] = compared[f"{RELATIVE_STD}_ratio{end}"]
    scatter = xr.Dataset(row).expand_dims(statistic=[RELATIVE_STD])
    along_statistic = compared[list(row)]
    return xr.concat(
        [along_statistic[{"statistic": [0]}], scatter, along_statistic[{"statistic": slice(1, None)}]], "statistic"
    )


def _with_intervals(ds: xr.Dataset, columns: Mapping[str, str]) -> str:
    """Return estimates with their 95 % intervals as a table of text."""
    rows = {}
    for name in ds["statistic"].values.tolist():
        known = [_with_ends(ds.sel(statistic=name), column) for column in columns]
        rows[_STATISTICS.get(name, name)] = [with_interval(*ends, "", name="") for ends in known]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=list(columns.values()))
    return table.to_string(header=any(columns.values()), justify="left")


def _with_ends(row: xr.Dataset, name: str) -> tuple[float, float, float]:
    low, high = ("low", "high") if name == "estimate" else (f"{name}_low", f"{name}_high")
    return float(row[name]), float(row[low]), float(row[high])


def _has_pull_off(ds: xr.Dataset) -> bool:
    return "pull_off_force" in ds and ds["pull_off_force"].dims == ("subregion",)
