"""`detach`: the load that detaches the spheres of a finished run, and input for particle codes."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from .. import archive, figures, particles, report
from .. import tables as exports
from ..figures.maps import critical_map
from ..particles.adhesion_parameters import adhesion_by_place
from ..particles.force_balance import NO_REST, places_in_words, strength_of_places
from ..report.run_tables import METHOD_WORDS
from ..report.summary import best_method, critical_median, place_table, scan_label
from ..statistics.sampling import by_share, one_of_each_place
from ..vocabulary import schema
from ..vocabulary.numbers import number, percent, with_interval
from ..vocabulary.text import without_warnings
from . import words
from .file_commands import save_picture

_NO_REST_OF_PLACES = "the sphere rolls off without any load; roughxr run --particle analyses resting positions"
_NO_REST_OF_PARTICLES = (
    "the summits on which rigid bodies rest are not those of the simulated contact, from which it rolls"
)


@archive.checked_names
def detach(options: Namespace) -> None:
    """Print the critical strength of a load for a run, or for each run in a folder, and write the requested files."""
    runs = _runs(Path(options.run))
    tables = {}
    files = [f"--{name}" for name in ("parameters", "dem", "picture") if getattr(options, name)]
    if files and len(runs) > 1:
        raise ValueError(f"{', '.join(files)}: expected one run, found several in {options.run}; name one of them")
    for name, path in runs.items():
        if len(runs) > 1:
            print(f"{name}:")
        tables[name] = _detach_run(options, path)
    if options.output:
        table = next(iter(tables.values()))
        if len(runs) > 1:
            table = xr.concat(tables.values(), "scan", data_vars="all", coords="minimal", compat="override")
        print(f"written to {exports.to_table(table, options.output)}")


def _runs(path: Path) -> dict[str, Path]:
    """Return the run at a path, or those in the folders of several scans."""
    if path.is_dir() and not [*path.glob("*.nc")]:
        return {file.parent.name: file.parent for file in sorted(path.glob("*/run.nc"))} or {path.name: path}
    return {path.name: path}


def _detach_run(options: Namespace, path: Path) -> xr.Dataset:
    """Print the critical load of one run, write the requested files, and return the table of places."""
    groups = _load(path)
    method = options.method or best_method(groups)
    if report.CRITICAL[method] not in groups:
        raise ValueError(f"--method {method}: the run has no such pull-off forces; expected --method adhesive")
    moments = report.run_moments(groups, method)
    humid = schema.is_humid(moments)
    if options.fluid == "water" and humid:
        raise ValueError(
            f"--fluid water: expected a dry run, found one at {percent(moments['humidity'])} relative humidity; "
            "run again without --humidity, with the --work-of-adhesion under water"
        )
    numbers = {name: words.numbers(getattr(options, name)) for name in ("particle_density", "shear_strength")}
    slides = {"friction_coefficient": options.friction_coefficient, **numbers}
    critical = without_warnings(particles.critical_load, moments, options.load, flow=options.fluid, **slides)
    load = f"flow of {options.fluid}" if options.load == "wall_shear" else options.load
    forces = f"pull-off forces: {METHOD_WORDS[method]}"
    _print_critical(critical, load)
    print(f"{forces}, with the run's work of adhesion, {number(moments['work_of_adhesion'], 'J/m²')}")
    if options.parameters:
        print(f"written to {exports.to_table(particles.parameters(moments), options.parameters)}")
    for code, file in options.dem:
        Path(file).write_text(particles.to_dem(moments, code=code), encoding="utf-8")
        print(f"written to {file}")
    if options.picture:
        _draw(critical, moments, options.picture, f"{load}, {forces}")
    table = adhesion_by_place(moments).merge(critical, compat="override", combine_attrs="override")
    return place_table(table, scan_label(groups))


def _load(run: Path) -> Mapping[str, xr.Dataset]:
    groups = archive.load(archive.run_archive(run))
    if not set(report.DETACHMENT) <= set(groups):
        raise ValueError(
            f"{run}: expected a run with resisting moments, found none; it needs adhesion and a sphere, no indenter"
        )
    return groups


def _print_critical(critical: xr.Dataset, load: str) -> None:
    """Print the critical strength of a load and the modes of detachment."""
    name = str(next(iter(critical.data_vars)))
    units = critical[name].attrs["units"].replace("^2", "²")
    of = "particles" if "landing_share" in critical.coords else "places"
    values = strength_of_places(critical)
    print(f"{critical[name].attrs['long_name']} ({load}):")
    if bool(values.notnull().any()):  # over particles, where places hold shares of them, else over places
        quantiles = by_share(values).quantile([0.05, 0.95]).values
        least, largest = (number(float(f"{value:.3g}"), units) for value in quantiles)
        median = with_interval(*critical_median(critical), units)
        print(f"  median {median}; 5 % of {of} below {least}, 95 % below {largest}")
    modes, counts = np.unique(critical["mode"].values.astype(str), return_counts=True)
    first = ", ".join(f"{mode} at {count}" for mode, count in zip(modes, counts))
    print(f"first mode of detachment, of {places_in_words(critical)}: {first}")
    if NO_REST in modes:
        print(f"{NO_REST}: {_NO_REST_OF_PARTICLES if of == 'particles' else _NO_REST_OF_PLACES}")
    if "none" in modes:
        print("none: the sphere stays at any strength of this load")
    if name == "critical_friction_velocity":
        valid = percent(critical["in_range"].mean())
        print(f"drag formulas valid at {valid} of them")


def _draw(critical: xr.Dataset, moments: xr.Dataset, path: str, title: str) -> None:
    """Draw the map of the mode of detachment or the critical load, and the rose of resisting moments."""
    figure = Figure(figsize=(6.9, 3.4), layout="constrained")
    critical = one_of_each_place(critical)
    moments = one_of_each_place(moments)
    critical_map(critical, ax=figure.add_subplot(1, 2, 1))
    figures.moment_rose(moments, ax=figure.add_subplot(1, 2, 2, projection="polar"))
    figure.suptitle(title)
    save_picture(figure, path)
