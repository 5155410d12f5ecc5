"""Solve one problem at every contact centre, a task for each place, and write fields on their windows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ..jobs import spread
from ..jobs.records import Layout, labelled
from ..kernels.halfspace.products import surface_displacement
from ..scans import regions
from ..specimen import Specimen
from .problem import Problem, Surface, places


def solve(
    solver: Any,
    specimen: Specimen,
    problem: Problem,
    layout: Layout,
    *options: Any,
    name: str,
    positions: xr.Dataset,
    reach: float,
    fields: bool = False,
) -> xr.Dataset:
    """Solve a problem at every contact centre, and label the results; lazy if the scan is.

    ``solver(place, problem, layout, *options)``, a module's function, returns a filled `Layout.blank` record.
    ``fields`` are stored within ``reach`` nm of the centres.
    """
    placed, shape = places(specimen, positions, reach)
    cells = problem.refine * shape[0], problem.refine * shape[1]
    if fields:
        layout = layout._replace(window=cells)
    records = spread.task_results(
        solver,
        [(place,) for place in placed],
        layout.dtype,
        problem,
        layout,
        *options,
        name=name,
        lazy=specimen.lazy,
    )
    out = labelled(records, layout, specimen.bodies, positions)
    return out.assign_coords(window_axes([place.window for place in placed], problem, cells)) if fields else out


def state_fields(pressure: np.ndarray, surface: Surface, deltas: np.ndarray, problem: Problem) -> dict[str, np.ndarray]:
    """Return pressure (GPa), displacement and gap (nm) of the states at ``deltas`` (nm below the datum)."""
    displacement = surface_displacement(pressure, problem.dx, problem.contact_modulus, problem.film)
    gap = displacement + surface.separation - deltas[..., None, None]
    return {
        "pressure": pressure,
        "displacement": displacement,
        "gap": np.where(np.isfinite(surface.separation), gap, np.nan),
    }


def put_fields(record: np.ndarray, surface: Surface, fields: Mapping[str, np.ndarray]) -> None:
    """Write the fields of the solved cells into a record's full windows; cells beyond the scan stay NaN."""
    (i, j) = surface.corner
    (rows, columns) = surface.separation.shape
    for name, values in fields.items():
        record[name][..., i : i + rows, j : j + columns] = values


def window_axes(windows: list[regions.Window], problem: Problem, cells: tuple[int, int]) -> dict:
    """Return x, y from the contact centre, and each centre's offset within its pixel if offsets differ."""
    half = 0.5 * (problem.pixel - problem.dx)  # from a pixel's centre to its first cell's
    origins = np.array([window.origin for window in windows]) - half
    alike = np.ptp(origins, axis=0).max() < 1e-6 * problem.dx
    common = origins[0] if alike else np.round(origins[0] / problem.pixel) * problem.pixel - half
    axes = {axis: common[k] + problem.dx * np.arange(cells[k]) for k, axis in enumerate("xy")}
    if alike:
        return axes
    shifts = origins - common
    return axes | {f"subpixel_{axis}": ("subregion", shifts[:, k]) for k, axis in enumerate("xy")}
