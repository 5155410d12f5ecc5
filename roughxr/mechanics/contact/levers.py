"""Resisting moments of a place's contacts, from the states of its pull-off, with the errors of their levers.

The states of the retraction are those of the pull-off itself. The mesh's error follows from cells twice as large; at
small places, cells are halved further while the lever changes. That of the heights between the pixels follows from an
interpolation by splines, as the pull-off's. All these are followed roughly: steps at the ends of branches change the
lever by less than its error.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..asperity.moments import KEPT, States, lever_change, moments_of_states, states_layout
from ..jobs.records import Layout
from ..vocabulary.adhesion_laws import ADHESION_LAWS
from .adhesion_on_cells import Adhesion, interaction_range
from .cycle import LEAST_RADIUS, Cycles, cycles_on, largest_displacement
from .mesh import MOST_REFINED
from .problem import Place, cell_axes, surface_at

#: Change of the lever from cells twice as large, over the mean of all directions, above which cells are halved again.
_ACCURACY = 0.1

#: Largest number of cells within range of meshes finer than that of the pull-off.
_MOST_FINER_CELLS = 5_000

#: Largest number of cells within range of all meshes.
_LARGEST_MESH = 1_000_000

#: Error over the last change by the mesh, without range: edges converge with the root of the cell, so that all further
#: changes together exceed the last. Set on the soft surfaces 54 and 55 of ``tests/benchmarks/levers.py``.
_SLOW_CHANGE = 2.0

#: Least error of the position of a contact's edge, in cells.
_EDGE_ERROR = 0.2


def lever_results(place: Place, cycles: Cycles, adhesion: Adhesion) -> dict[str, Any]:
    """Return the moments at one place, by their names in a record of `adhesive`; they are scaled to its pull-off."""
    layout = states_layout(adhesion.directions)
    problem = cycles.problem
    solved_on = problem.refine
    coarser = record = layout.blank()
    deepest = largest_displacement(cycles.paths[0], cycles)
    within = cycles.surface.separation < deepest + interaction_range(adhesion, problem)
    pixels = np.count_nonzero(within) / solved_on**2
    radius = cycles.events[0].get("pull_off_resolution", np.nan)
    meshes = _refinements(pixels, solved_on, radius)
    for refine in meshes:
        on_mesh = cycles
        if refine != solved_on:
            other = problem._replace(refine=refine)
            on_mesh = cycles_on(surface_at(place, other), other, adhesion, roughly=True)
        coarser, (record, every_second) = record, _moments_on(place, on_mesh, layout)
        change = lever_change(coarser, record)
        mesh_error = change * (1.0 if ADHESION_LAWS[adhesion.law].has_range else _SLOW_CHANGE)
        edge = _EDGE_ERROR * problem.pixel / refine / np.abs(record["lever"]).mean()
        record["lever_error"] = np.sqrt(max(mesh_error, edge) ** 2 + lever_change(every_second, record) ** 2)
        if refine > meshes[0] and change < _ACCURACY:
            break
    if refine > 1:
        on_larger = refine == solved_on > 2  # large places, on cells that are no pixels: nothing lies between these
        other = problem._replace(refine=refine // (1 + on_larger), splined=True)
        splined, _ = _moments_on(place, cycles_on(surface_at(place, other), other, adhesion, roughly=True), layout)
        between = lever_change(splined, coarser if on_larger else record)
        record["lever_error"] = np.hypot(record["lever_error"], between)
    scale = cycles.pull_offs[0] / record["pull_off_force"]
    for name in ("resisting_moment", "tipping_force"):
        record[name] *= scale
    return {own_name: record[name] for own_name, name in KEPT.items()}


def _refinements(pixels: float, solved_on: int, radius: float) -> list[int]:
    """Return the refinements to compare: half and all of that of the pull-off, and finer ones at small places.

    The larger cells are left out where they do not resolve a contact of this radius (cells of the pull-off).
    """
    meshes = [solved_on // 2, solved_on] if solved_on > 1 else [1, 2]
    while 2 * meshes[-1] <= MOST_REFINED and pixels * (2 * meshes[-1]) ** 2 <= _MOST_FINER_CELLS:
        meshes.append(2 * meshes[-1])
    if solved_on == 1:
        return meshes if 4 * pixels <= _LARGEST_MESH else [1]
    return meshes[1:] if len(meshes) > 2 and radius < LEAST_RADIUS else meshes


def _moments_on(place: Place, cycles: Cycles, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the record of one place on one mesh, from all states and from every second."""
    followed = cycles.paths[0]
    events = cycles.events[0]
    if not events:
        return layout.blank(), layout.blank()
    angles = layout.axes["direction"]
    problem = cycles.problem
    x, y = cell_axes(place, problem)
    states = followed.states[followed.turn :][::-1]
    footprints = [seen.moved(x[0], y[0], angles) for seen in followed.observed[::-1]]
    known = {
        "pull_off_force": cycles.steep_pulls[0],
        "pull_off_delta": events["pull_off_delta"],
        "converged": bool(states["converged"].all()),
    }
    parts = [States(footprints[::n], states["force"][::n], states["contact_area"][::n], problem.refine) for n in (1, 2)]
    all_states, every_second = (moments_of_states(part, layout, 0.0, **known) for part in parts)
    return all_states, every_second
