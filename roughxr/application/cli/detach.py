"""`detach`: what detaches the spheres of a finished run, and input for particle codes."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from ...files.storage import atomic_write
from ...mechanics import particles
from ...mechanics.particles.adhesion_parameters import adhesion_by_place
from ...mechanics.particles.force_balance import (
    DENSEST_GAS,
    NEITHER,
    NO_REST,
    fluid_of,
    strength_of_places,
)
from ...mechanics.particles.loads import read_flow
from ...mechanics.statistics.sampling import SHARE, first_surface_of_each_place, quantile_of_places
from ...mechanics.vocabulary.numbers import format_number
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.schema import is_humid
from ...mechanics.vocabulary.text import without_warnings
from .. import archive, figures, report
from .. import tables as exports
from ..dem import places_in_words, to_dem
from ..figures.maps import critical_map
from ..figures.particle_figures import removed_share
from ..figures.style import SMALL
from ..report.detachment import turbulent_speed
from ..report.run_numbers import METHOD_WORDS, critical_strength
from ..report.summary import best_method, critical_flow, fluid_in_words, place_table, scan_label, with_few_digits
from ..wording import render_sentence, render_sentences
from ..wording.intervals import value_and_interval, with_interval
from . import words
from .file_commands import save_picture

_FILE = "detach.toml"

#: The sentences on the critical strength, and on the strength that removes a share.
_CRITICAL = ("heading", "detached", "median", "modes", "single", "no_rest", "neither", "valid", "work")
_REMOVAL = ("removal", "stress", "burst", "jet")

#: What an input of LAMMPS has to state before it includes a file of `to_dem`.
_BEFORE_LAMMPS = "; before its include: units si, atoms of its types, and variable damping equal … (kg/s)"

#: Speed of a round jet over the largest friction velocity on a wall at 8 diameters of its nozzle, as in the how-to.
_JET_OVER_FRICTION = 20.0

#: Largest speed (m/s) of a jet of gas whose density hardly changes: 0.3 times that of sound in air.
_INCOMPRESSIBLE = 100.0

#: What the interval of a median holds: the scatter of the places, and the errors that they share.
_INTERVAL = "95 % interval, all known errors"


@archive.checked_names
def detach(options: Namespace) -> None:
    """Print the critical strength for a run, or a row for each run in a folder, and write the files."""
    runs = _runs(Path(options.run))
    tables = {}
    media = set[str]()
    criticals = {}
    titles = {}
    files = [f"--{name}" for name in ("parameters", "dem") if getattr(options, name)]
    if files and len(runs) > 1:
        raise Refusal(", ".join(files), "one run", f"several in {options.run}", "name one of them")
    for name, path in runs.items():
        groups = _load(path)
        critical, moments, title = _critical_load(options, groups)
        label = scan_label(groups)
        media.add(groups["scan"].attrs.get("medium") or "air")
        table = adhesion_by_place(moments).merge(critical, compat="override", combine_attrs="override")
        tables[name] = place_table(table, label)
        criticals[name] = critical
        titles[name] = title
        if len(runs) == 1:
            values = {**_strength_values(critical), **_mode_values(critical, moments), "title": title}
            values |= _removal_values(critical, moments, options)
            for sentence in render_sentences(_FILE, (*_CRITICAL, *_REMOVAL), values):
                print(sentence)
            _write_files(options, critical, moments, title)
    if len(runs) > 1:
        _print_runs(criticals, titles, options)
    if options.fluid:
        values = {"media": " or ".join(sorted(media)), "other_fluid_name": options.fluid}
        print(render_sentence(_FILE, "other_fluid", values))
    if options.output:
        table = next(iter(tables.values()))
        if len(runs) > 1:
            table = xr.concat(tables.values(), "scan", data_vars="all", coords="minimal", compat="override")
        print(f"written to {exports.to_table(table, options.output)}")


def _print_runs(criticals: Mapping[str, xr.Dataset], titles: Mapping[str, str], options: Namespace) -> None:
    """Print a row for each run, with its load and method where they differ, and draw the share that is removed."""
    rows = {name: _row(critical, options.remove) for name, critical in criticals.items()}
    table = pd.DataFrame.from_dict(rows, orient="index")
    title, *others = set(titles.values())
    if others:
        title = "load and method of each run"
        table[title] = pd.Series(titles)
    long_name = _strength(next(iter(criticals.values()))).attrs["long_name"]
    print(f"{long_name} ({title}):")
    print(table.to_string())
    if options.picture:
        axes = removed_share(criticals, ax=Figure(figsize=(4.2, 3.2), layout="constrained").subplots())
        axes.figure.suptitle(title, fontsize=SMALL)
        save_picture(axes.figure, options.picture)


def _runs(path: Path) -> dict[str, Path]:
    """Return the run at a path, or those in the folders of several scans."""
    if path.is_dir() and not [*path.glob("*.nc")]:
        return {file.parent.name: file.parent for file in sorted(path.glob("*/run.nc"))} or {path.name: path}
    return {path.name: path}


def _critical_load(options: Namespace, groups: Mapping[str, xr.Dataset]) -> tuple[xr.Dataset, xr.Dataset, str]:
    """Return the critical load of one run, its resisting moments, and both in words."""
    method = options.method or best_method(groups)
    if report.CRITICAL[method] not in groups:
        raise Refusal(
            "method", "a run with pull-off forces of this method", f"none of {method}", "take --method adhesive"
        )
    moments = report.run_moments(groups, method)
    flow = options.fluid or fluid_of(critical_flow(groups))
    critical = without_warnings(particles.critical_load, moments, options.cause, flow=flow, **_resistance(options))
    fluid = fluid_in_words(read_flow(flow)) if options.cause == "wall_shear" else ""
    values = {"fluid": fluid, "cause": options.cause, "method": METHOD_WORDS[method]}
    return critical, moments, render_sentence(_FILE, "load_and_method", values)


def _resistance(options: Namespace) -> dict[str, Any]:
    """Return the weight of the sphere, and how it slides, as `critical_load` takes them."""
    numbers = {name: words.numbers(getattr(options, name)) for name in ("particle_density", "shear_strength")}
    return {"friction_coefficient": options.friction_coefficient, **numbers}


def _write_files(options: Namespace, critical: xr.Dataset, moments: xr.Dataset, title: str) -> None:
    """Write parameters, input of particle codes and the picture of one run, as requested."""
    if options.parameters:
        print(f"written to {exports.to_table(with_few_digits(particles.parameters(moments)), options.parameters)}")
    for code, file in options.dem:
        with atomic_write(file) as temporary:
            temporary.write_text(to_dem(moments, code=code), encoding="utf-8")
        print(f"written to {file}" + _BEFORE_LAMMPS * (code == "lammps"))
    if options.picture:
        _draw(critical, moments, options.picture, title)


def _load(run: Path) -> Mapping[str, xr.Dataset]:
    groups = archive.load(archive.run_archive(run))
    if not set(report.DETACHMENT) <= set(groups):
        advice = "they are in what roughxr run makes, not roughxr paper, with adhesion and a sphere, no indenter"
        raise Refusal(run, "a run with resisting moments", "none", advice)
    return groups


def _strength(critical: xr.Dataset) -> xr.DataArray:
    """Return the variable of the critical strength."""
    return critical[next(iter(critical.data_vars))]


def _units(critical: xr.Dataset) -> str:
    return _strength(critical).attrs["units"].replace("^2", "²")


def _row(critical: xr.Dataset, share: float | None) -> dict[str, str]:
    """Return the critical strength of a run in a row: median, or that for a share, with interval, and first mode."""
    label = "median" if share is None else f"removes {100 * share:g} %"
    strength, interval = value_and_interval(*critical_strength(critical, share), _units(critical))
    modes, counts = np.unique(critical["mode"].values.astype(str), return_counts=True)
    most = f"{modes[np.argmax(counts)]}, at {counts.max()} of {counts.sum()} places"
    return {label: strength, _INTERVAL: interval, "first mode of most": most}


def _strength_values(critical: xr.Dataset) -> dict[str, Any]:
    """Return the critical strength at the median and at the ends of the range of places or particles."""
    strength = _strength(critical)
    units = _units(critical)
    strengths = strength_of_places(critical)
    values: dict[str, Any] = {"strength_name": strength.attrs["long_name"], "strength_units": units}
    if not bool((strengths > 0).any()):
        return values
    # over particles, where places hold shares of them, else over places
    quantiles = quantile_of_places(strengths, [0.05, 0.95])
    least, largest = (format_number(float(f"{value:.3g}"), units) for value in quantiles)
    detaching = int(strengths.notnull().sum())
    if strength.name == "critical_friction_velocity":
        values["valid_share"] = critical["in_range"].where(strengths > 0).mean()
    return {
        **values,
        "some_stay": detaching < strengths.size,
        "detaching": detaching,
        "number_of_places": strengths.size,
        "median_strength": with_interval(*critical_strength(critical), units, name=_INTERVAL),
        "rolls_off": not quantiles[0] > 0,
        "least_strength": least,
        "largest_strength": largest,
    }


def _mode_values(critical: xr.Dataset, moments: xr.Dataset) -> dict[str, Any]:
    """Return the modes of detachment of places or particles, and the adhesion that they are computed with."""
    modes, counts = np.unique(critical["mode"].values.astype(str), return_counts=True)
    has_particles = SHARE in critical.coords
    return {
        "unit": "particles" if has_particles else "places",
        "has_particles": has_particles,
        "places": places_in_words(critical),
        "first_modes": ", ".join(f"{mode} at {count}" for mode, count in zip(modes, counts)),
        "single_contacts": int((moments["contacts"] == 1).sum()),
        "is_restless": NO_REST in modes,
        "stays": NEITHER in modes,
        "work_of_adhesion": moments["work_of_adhesion"],
        "humidity": moments["humidity"] if is_humid(moments) else None,
    }


def _removal_values(critical: xr.Dataset, moments: xr.Dataset, options: Namespace) -> dict[str, Any]:
    """Return the strength that removes the requested share, also in turbulence, and a jet beyond its formula."""
    is_flow = _strength(critical).name == "critical_friction_velocity"
    per_cent = None if options.remove is None else 100 * options.remove
    speed, slowest, fastest = critical_strength(critical, options.remove)
    if not np.isfinite(speed):
        return {"removed_per_cent": per_cent}
    units = _units(critical)
    values = {
        "removed_per_cent": per_cent,
        "is_flow": is_flow,
        "strength": with_interval(speed, slowest, fastest, units, name=_INTERVAL),
    }
    if not is_flow:
        return values
    density = fluid_of(critical).density
    if options.remove is not None and speed > 0:
        stresses = (density * speed**2, density * slowest**2, density * fastest**2)
        values["wall_shear_stress"] = with_interval(*stresses, "Pa", name=_INTERVAL)
        burst = turbulent_speed(moments, critical, options.remove, **_resistance(options))
        values["turbulent_speed"] = with_interval(*burst, units, name=_INTERVAL)
    jet = _JET_OVER_FRICTION * speed
    if density < DENSEST_GAS and jet > _INCOMPRESSIBLE:
        values |= {"jet_speed": jet, "incompressible": _INCOMPRESSIBLE}
    return values


def _draw(critical: xr.Dataset, moments: xr.Dataset, path: str, title: str) -> None:
    """Draw the map of the mode of detachment or the critical load, and the rose of resisting moments."""
    figure = Figure(figsize=(6.9, 3.4), layout="constrained")
    critical = first_surface_of_each_place(critical)
    moments = first_surface_of_each_place(moments)
    critical_map(critical, ax=figure.add_subplot(1, 2, 1))
    figures.moment_rose(moments, ax=figure.add_subplot(1, 2, 2, projection="polar"))
    figure.suptitle(title)
    save_picture(figure, path)
