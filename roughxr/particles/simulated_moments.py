"""Resisting moments of the simulation's contacts, on meshes that resolve the edges of the contacts."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..asperity.moments import (
    MISSING,
    States,
    edge_opening,
    lever_change,
    moments_of_states,
    states_layout,
    touching_cells,
)
from ..contact.adhesion_on_cells import Adhesion, interaction_range
from ..contact.adhesive_options import preload_problem, usual_step, window_half_width
from ..contact.cycle import cycles_on, overlapping_cells, prescribed_deltas
from ..contact.mesh import Mesh
from ..contact.problem import Place, Problem, Surface, cell_axes, surface_at
from ..contact.problem import places as placed_at
from ..contact.refinement import REFINEMENTS
from ..jobs import spread
from ..jobs.records import Layout, labelled
from ..kernels.adhesion.steps import ON_RETRACTION
from ..specimen import Specimen
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS

#: Change of the lever from cells twice as large, over the mean of all directions, above which cells are halved again.
_ACCURACY = 0.1

#: Largest number of cells within range: of meshes finer than that of the pull-off, and of all.
_MOST_FINER_CELLS, _LARGEST_MESH = 5_000, 1_000_000

#: Cells around those within range.
_MARGIN = 8

#: Error over the last change by the mesh, without range: edges converge with the root of the cell, so that all further
#: changes together exceed the last. Set on the soft surfaces 54 and 55 of ``tests/benchmarks/levers.py``.
_SLOW_CHANGE = 2.0

#: Least error of the position of a contact's edge, in cells.
_EDGE_ERROR = 0.2

#: Steps beyond the depth of the preload on the pull-off's mesh that other meshes may need.
_FARTHER_STEPS = 8


def simulated_moments(
    specimen: Specimen, solved: xr.Dataset, *, preload: float = 0.0, directions: int = 24
) -> xr.Dataset:
    """Return the resisting moments of the simulation's contacts, in the form of `rolling`, with errors of the levers.

    Each place of ``solved``, a result of `adhesive` by this preload, is solved again for the states of its retraction,
    on the cells of its pull-off and on cells twice as large. Cells are halved further while the lever changes and the
    place is small. A law without range takes the steeper edge's results.
    """
    step = usual_step(specimen)
    mesh = Mesh(int(solved["mesh"].max()), step=step)
    problem, adhesion = preload_problem(specimen, preload=preload, law=solved.attrs["law"], mesh=mesh)
    arguments = []
    for k in range(solved.sizes["subregion"]):
        place = solved.isel(subregion=[k])
        deepest = float(np.ravel(place["preload_delta"].values)[0]) + _FARTHER_STEPS * step
        steps = np.array([deepest]) if np.isfinite(deepest) else problem.steps
        place_problem = problem._replace(steps=steps, refine=int(place["mesh"].max()))
        (placed,), _ = placed_at(specimen, place, window_half_width(specimen, place_problem, adhesion))
        arguments.append((placed, place_problem, adhesion))
    layout = states_layout(2 * np.pi * np.arange(directions) / directions)
    records = spread.task_results(_moments_at, arguments, layout.dtype, layout, name="moments")
    positions = xr.Dataset(coords={name: solved[name] for name in ("subregion_x", "subregion_y")})
    out = labelled(records, layout, specimen.bodies, positions)
    out.attrs = {"method": "adhesive", "normal_force": 0.0, "missing": MISSING["adhesive"]}
    coordinates = {name: solved[name] for name in ("subregion", "landing_share") if name in solved.coords}
    out = schema.label(out.assign_coords(coordinates))
    return schema.record(out, "simulated_moments", specimen.bodies, directions=directions)


def _moments_at(place: Place, problem: Problem, adhesion: Adhesion, layout: Layout) -> np.ndarray:
    """Return the record of one place, as a task: of the finest mesh, with the errors of its levers."""
    solved_on = problem.refine
    coarser = record = layout.blank()
    pixels = problem._replace(refine=1)
    for refine in _refinements(overlapping_cells(surface_at(place, pixels), pixels, adhesion), solved_on):
        coarser, (record, every_second) = record, _moments_on(place, problem._replace(refine=refine), adhesion, layout)
        change = lever_change(coarser, record)
        mesh_error = change * (1.0 if ADHESION_LAWS[adhesion.law].has_range else _SLOW_CHANGE)
        edge = _EDGE_ERROR * problem.pixel / refine / np.abs(record["lever"]).mean()
        record["lever_error"] = np.sqrt(max(mesh_error, edge) ** 2 + lever_change(every_second, record) ** 2)
        if refine >= solved_on and change < _ACCURACY:
            break
    return record


def _refinements(pixels: int, solved_on: int) -> list[int]:
    """Return the refinements to solve at: half and all of that of the pull-off, and finer ones at small places."""
    least = max(solved_on // 2, 1)
    finest = 2 * least
    meshes = [n for n in REFINEMENTS if least <= n <= finest or (n > finest and pixels * n**2 <= _MOST_FINER_CELLS)]
    return [n for n in meshes if n == least or pixels * n**2 <= _LARGEST_MESH]


def _moments_on(place: Place, problem: Problem, adhesion: Adhesion, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the record of one place on one mesh, from all states and from every second."""
    surface, (x, y) = _within_range(surface_at(place, problem), cell_axes(place, problem), problem, adhesion)
    cycles = cycles_on(surface, problem, adhesion, fields=ON_RETRACTION, steepest_only=True)
    followed = cycles.paths[0]
    events = cycles.events[0]
    if not events:
        return layout.blank(), layout.blank()
    states = followed.states[followed.turn :][::-1]
    pressure = followed.pressures[::-1]
    opening = edge_opening(adhesion.law, adhesion.work, problem.contact_modulus, problem.dx)
    touching = touching_cells(followed.gaps[::-1], pressure, problem.dx, opening)
    force = states["force"]
    area = states["contact_area"]
    pull_off = {name: events[name] for name in ("pull_off_force", "pull_off_delta")}
    converged = bool(states["converged"].all())
    all_states, every_second = (
        moments_of_states(
            States(x, y, pressure[::n], touching[::n], force[::n], area[::n], problem.refine),
            layout,
            0.0,
            converged=converged,
            **pull_off,
        )
        for n in (1, 2)
    )
    return all_states, every_second


def _within_range(surface: Surface, axes: tuple, problem: Problem, adhesion: Adhesion) -> tuple[Surface, list]:
    """Return the part of a surface within range of the largest displacement, and its axes; all of it under a layer."""
    deepest = prescribed_deltas(surface, problem, adhesion)[-1]
    within = surface.separation < deepest + interaction_range(adhesion, problem)
    if problem.layer or not within.any():
        return surface, list(axes)
    parts = []
    for axis in (0, 1):
        cells = np.flatnonzero(within.any(axis=1 - axis))
        parts.append(slice(max(cells[0] - _MARGIN, 0), cells[-1] + 1 + _MARGIN))
    return surface._replace(separation=surface.separation[tuple(parts)]), [x[part] for x, part in zip(axes, parts)]
