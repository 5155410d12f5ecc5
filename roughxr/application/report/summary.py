"""The summary of a run and its table of places, which the reports, tables and the command line show."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from ...mechanics.contact.refinement import coarser_mesh_error
from ...mechanics.particles.force_balance import fluid_of
from ...mechanics.particles.loads import FLOWS, Flow
from ...mechanics.particles.removal import strength_quantile
from ...mechanics.scans.plausibility import is_noise
from ...mechanics.scans.regions import sides
from ...mechanics.statistics.means import mean_pull_off, with_units
from ...mechanics.statistics.sampling import place_numbers, place_order, quantile_of_places
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.error_sources import HALF_WIDTH
from ...mechanics.vocabulary.text import printable
from ..headline import answer_lines, best_estimate, with_best_estimate
from ..sentences import estimate_notes
from ..wording import render_sentence, table_of_words

Run = Mapping[str, xr.Dataset]

#: Groups of the error budget, the summary, the table of places, and where particles rest.
BUDGET, SUMMARY, PLACES, RESTS = (f"statistics/{name}" for name in ("error_budget", "summary", "places", "rests"))

#: The answer of a scan that shows no surface.
_NOISE = (
    "No pull-off force is stated: neighbouring heights of this scan are uncorrelated, as in noise. Next: measure the "
    "scan again, or check its file."
)

_POSITION = ("subregion_x", "subregion_y")

#: Significant digits of values in tables for readers.
_DIGITS = 4

#: Significant digits of their errors.
_ERROR_DIGITS = 2

#: Groups of the critical flow, by the method of the pull-off force.
CRITICAL = {"extrapolated": "statistics/detachment_extrapolated", "adhesive": "statistics/detachment"}

#: The groups of detachment.
DETACHMENT = ("solutions/rolling", "statistics/adhesive", "statistics/detachment")


def headline(run: Run) -> str:
    """Return the mean pull-off with its errors, the best estimate, the largest error, and what to do next, as text.

    Empty where the groups of the run contain no simulation with adhesion.

    Examples
    --------
    >>> import roughxr
    >>> import xarray as xr
    >>> forces = xr.Dataset({"pull_off_force": ("subregion", [388.0, 575.0, 817.0], {"units": "nN"})})
    >>> roughxr.report.headline({"statistics/adhesive": forces}).partition(" (")[0]
    'Mean pull-off 590 nN'
    """
    return " ".join(headline_lines(run))


def headline_lines(run: Run) -> list[str]:
    """Return the sentences of the headline."""
    return answer_lines(run_summary({name: schema.in_package_units(ds) for name, ds in run.items()}))


def run_summary(run: Run) -> xr.Dataset:
    """Return the answer of a run as scalars with units, see ``SCALARS``; empty without a simulation with adhesion."""
    if SUMMARY in run:
        return run[SUMMARY]
    if "statistics/adhesive" not in run:
        return xr.Dataset()
    pull_off = run["statistics/adhesive"]
    if not bool((pull_off["pull_off_force"] > 0).any()):
        return xr.Dataset(attrs={"missing": "The sphere adheres at no place."})
    if "scan" in run and is_noise(run["scan"]):
        return xr.Dataset(attrs={"missing": _NOISE})
    out = mean_pull_off(pull_off).load()
    if BUDGET in run:
        errors = run[BUDGET]["relative_std"].to_series().fillna(0.0)
        total = HALF_WIDTH * float(run[BUDGET]["total_std"])
        out = out.assign(total_error=total, largest_error=HALF_WIDTH * errors.max())
        out.attrs["known_bias"] = 1 - float(run[BUDGET]["pull_off_corrected"] / run[BUDGET]["pull_off_mean"])
        out.attrs["largest_source"] = errors.idxmax()
    if best_estimate(run) is not None:
        out = with_best_estimate(out, run["statistics/extrapolated"])
    elif "statistics/extrapolated" in run:
        (out.attrs["not_extrapolated"],) = estimate_notes(run["statistics/extrapolated"])
    if fluid := run_fluid(run):
        out.attrs["fluid"] = fluid
    if advice := render_sentence("answer.toml", "better_scan", _scan_values(run, out)):
        out.attrs["advice"] = advice
    return with_units(out.assign(_flow(run)))


def best_estimate_notes(run: Run) -> list[str]:
    """Return the basis of the best estimate as sentences; empty without an estimate."""
    if best_estimate(run) is None:
        return []
    return estimate_notes(run["statistics/extrapolated"])


def best_method(run: Run) -> str:
    """Return the method of a run's best estimate: the roughness extrapolated below the scan, or as scanned."""
    return "extrapolated" if best_estimate(run) else "adhesive"


def critical_flow(run: Run) -> xr.Dataset:
    """Return the critical flow of a run by its best estimate; empty without one."""
    return run.get(CRITICAL[best_method(run)], run.get(CRITICAL["adhesive"], xr.Dataset()))


def run_fluid(run: Run) -> str:
    """Return the fluid of a run's critical flow in words; empty without one."""
    critical = critical_flow(run)
    return fluid_in_words(fluid_of(critical)) if critical else ""


def fluid_in_words(flow: Flow) -> str:
    """Return the name of a fluid, or its density."""
    names = [name for name, fluid in FLOWS.items() if fluid[:2] == flow[:2]]
    return names[0] if names else f"a fluid of {flow.density:.4g} kg/m³"


def _flow(run: Run) -> dict[str, float]:
    """Return the critical flow at the median place, with its interval, and the number of supporting contacts."""
    if not {"statistics/detachment", "solutions/rolling"} <= set(run):
        return {}
    name = "critical_friction_velocity"
    critical = critical_flow(run)
    flow = dict(zip((name, f"{name}_low", f"{name}_high"), strength_quantile(critical)))
    density = fluid_of(critical).density
    stress = {key.replace(name, "wall_shear_stress"): density * value**2 for key, value in flow.items()}
    contacts = run["solutions/rolling"]["contacts"]
    return flow | stress | {"supports": float(quantile_of_places(contacts, 0.5))}


def _scan_values(run: Run, out: xr.Dataset) -> dict[str, float]:
    """Return in what a scan is smaller than the region of contact, or too coarse for the contacts, nm."""
    if "scan" not in run or "sphere_radius" not in run["scan"].coords:
        return {}
    scan = run["scan"]
    side = min(sides(scan))
    radius = float(scan["sphere_radius"])
    touched = 2 * np.sqrt(2 * radius * 2 * float(np.nanstd(scan["height"].values)))
    if side < 2 * touched:
        return {"touched_width": touched, "scanned_width": side}
    shortest = run.get("solutions/adhesive", run["statistics/adhesive"]).coords.get("shortest_wavelength")
    # shortest wavelength (nm) above which a scan is too coarse: contacts at pull-off are smaller
    if shortest is not None and float(shortest) > 50.0 and "best_estimate" not in out:
        return {"unresolved": float(shortest)}
    return {}


def with_mesh_error(run: Run) -> dict[str, xr.Dataset]:
    """Return a run with the error of its pull-offs by mesh and step, estimated from the finer solution."""
    solved = run["solutions/adhesive"]
    if "pull_off_error" in solved and bool(solved["pull_off_error"].notnull().any()):
        return dict(run)
    force = run["statistics/adhesive"]["pull_off_force"]
    solved_finer = run["solutions/finer"]["pull_off_force"]
    order = place_order(force, solved_finer)
    finer = [np.nan if index is None else float(solved_finer[index]) for index in order]
    error = ("subregion", coarser_mesh_error(abs(force / finer - 1).values, solved.attrs.get("law")))
    names = ("solutions/adhesive", "statistics/adhesive")
    return {**run, **{name: schema.label(run[name].assign(pull_off_error=error)) for name in names}}


def by_place(run: Run) -> xr.Dataset:
    """Return the results of a run by place: one row each, directions averaged, without empty columns."""
    if PLACES in run:
        return run[PLACES]
    columns = {}
    groups = {**run, "detachment": critical_flow(run)}
    for group, variable, name, method in table_of_words("places.csv"):
        if variable not in groups.get(group, ()):
            continue
        column = groups[group][variable]
        column = column.mean("direction", keep_attrs=True) if "direction" in column.dims else column
        if column.dims == ("subregion",) and bool(column.notnull().any()):
            long_name = f"{column.attrs.get('long_name', name)}{method}"
            columns[name] = column.drop_vars(set(column.coords) - set(_POSITION)).assign_attrs(long_name=long_name)
    return xr.Dataset(columns)


def summary_groups(run: Run, command: str, **options) -> dict[str, xr.Dataset]:
    """Return the groups of the summary and of the table of places, with the options of the run in their history."""
    made = schema.record(run_summary(run), "run", run["scan"], **options)
    return {PLACES: by_place(run), SUMMARY: made.assign_attrs(command=printable(command))}


def scan_label(run: Run) -> str:
    """Return the name of a run's scan in tables."""
    return Path(run["scan"].attrs.get("source_file", "scan")).name


def place_table(places: xr.Dataset, label: str) -> xr.Dataset:
    """Return a table of places as it is published: the scan's name first, few digits, errors as forces."""
    alike = [name for name, column in places.variables.items() if not column.ndim or bool(column.isnull().all())]
    table = places.drop_vars(["subregion", *alike], errors="ignore").reset_coords()
    if "pull_off_error" in table:
        error = table["pull_off_force"] * table["pull_off_error"]
        meaning = {"units": "nN", "long_name": "error of the pull-off force by mesh and step"}
        table = table.assign(pull_off_error=error.assign_attrs(meaning)).rename(pull_off_error="pull_off_force_error")
    table = with_few_digits(table)
    count = table.sizes["subregion"]
    position = {name: table[name] for name in _POSITION if name in table}
    place = place_numbers(places)
    first = xr.Dataset({"place": ("subregion", place), **position})
    if place.max() + 1 < count:
        first["surface"] = ("subregion", pd.Series(place).groupby(place).cumcount())
    table = first.merge(table.drop_vars(list(position))).rename_dims(subregion="scan")
    return table.assign_coords(scan=[label] * count)


def with_few_digits(table: xr.Dataset) -> xr.Dataset:
    """Return the numbers of a table rounded to the digits of a published one."""
    return table.map(
        lambda c: c.copy(data=few_digits(c.values, c.name)) if c.dtype.kind == "f" and c.ndim < 2 else c,
        keep_attrs=True,
    )


def few_digits(values: ArrayLike, name: str) -> np.ndarray:
    """Return a number, or those of a column, rounded to the digits of a published table."""
    digits = _ERROR_DIGITS if str(name).endswith(("_error", "independent_places")) else _DIGITS
    return np.vectorize(lambda value: float(f"{value:.{digits}g}"), otypes=[float])(values)
