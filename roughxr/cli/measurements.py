"""`measured` and `compare`: measured pull-off forces, alone and beside those of a run."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from .. import archive, figures, statistics
from .. import tables as exports
from ..measured import compare, curves_pull_off, open_curves, open_pull_off
from ..vocabulary.numbers import number
from ..vocabulary.schema import one_of
from . import words
from .file_commands import drawn, image, tell_attributes


def measurement(files: list[str], options: Namespace) -> xr.Dataset:
    """Return the measured pull-offs in files, read with the given options."""
    constant = options.spring_constant and words.number(options.spring_constant)
    known = {"sensitivity": options.sensitivity, "spring_constant": constant}
    if options.baseline is None:
        stated = {"units": options.units, "place_units": options.place_units, "pulls": options.pulls}
        return open_pull_off(files, **image(options), **stated, **known)
    if len(files) > 1:
        raise ValueError(f"--baseline: expected one file of curves, found {len(files)}")
    return curves_pull_off(open_curves(files[0], **known), baseline=options.baseline)


def describe(options: Namespace) -> None:
    """Print what files of measured pull-offs hold, and their mean and quantiles with intervals."""
    ds = measurement(options.file, options)
    tell_attributes(ds)
    print(f"places: {'known' if 'subregion_x' in ds.coords else 'not known'}")
    if "reason" in ds:
        left = ds["reason"].where(ds["reason"] != "", "used").to_series().value_counts()
        print("curves: " + ", ".join(f"{count} {reason}" for reason, count in left.items()))
    force = ds["pull_off_force"].dropna("subregion")
    if force.size == 1:
        error = f" ± {number(ds['pull_off_uncertainty'].max(), digits=2)}" if "pull_off_uncertainty" in ds else ""
        print(f"\npull-off force: {number(force[0], digits=4)}{error} nN")
    else:
        print("\npull-off force, nN:")
        intervals = statistics.bootstrap(ds, "pull_off_force")
        print(intervals[["estimate", "low", "high"]].to_dataframe().to_string(float_format=number))
    if options.output:
        print(f"written to {exports.to_table(ds, options.output)}")


def compare_with_run(options: Namespace) -> None:
    """Print measured over predicted pull-off forces, and whether both could be of one distribution."""
    groups = archive.load(archive.of_run(Path(options.run)))
    methods = [name.partition("/")[2] for name, ds in groups.items() if name.startswith("statistics/") and _pulls(ds)]
    predicted = groups[f"statistics/{one_of(options.method, methods, 'method')}"].load()
    own = measurement(options.file, options)
    compared = compare(predicted, own)
    print(f"measured over predicted ({options.method}) pull-off forces, nN:")
    columns = [f"{name}{end}" for name in ("predicted", "measured", "ratio") for end in ("", "_low", "_high")]
    print(compared[columns].to_dataframe().to_string(float_format=number))
    distance, p_value = float(compared.distribution_distance), float(compared.distribution_p_value)
    print(
        f"\nlargest difference of the cumulative distributions: {number(distance)}; samples of one distribution differ "
        f"so much, or more, with probability {number(p_value, digits=2)}"
    )
    predicted_places, measured_places = float(compared.predicted_places), float(compared.measured_places)
    print(f"equivalent to {predicted_places:.0f} independent predicted places, {measured_places:.0f} measured ones")
    print(f"places: {compared.attrs['places']}{_shift(compared)}")
    if options.picture:
        axes = Figure(figsize=(6.9, 2.9), layout="constrained").subplots(1, 2)
        figures.predicted_and_measured(predicted, own, comparison=compared, ax=axes)
        drawn(axes[0].figure, options.picture)


def _pulls(ds: xr.Dataset) -> bool:
    return "pull_off_force" in ds and ds["pull_off_force"].dims == ("subregion",)


def _shift(compared: xr.Dataset) -> str:
    if "measured_force" not in compared:
        return ""
    words = f"by {number(compared.shift_x)} and {number(compared.shift_y)} nm along x and y"
    return f", {words}; correlation {number(compared.place_correlation)}, p = {number(compared.place_p_value)}"
