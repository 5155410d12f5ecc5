"""Resisting moments of a place's contacts, from the states of its pull-off, with the errors of their levers.

The states of the retraction are those of the pull-off itself, or at small places those on finer cells. The error
follows from one other solution, on cells twice as large with heights between the pixels by splines: mesh and
interpolation change together. Other solutions than the pull-off's have the steepest edge of the law alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..asperity.moments import KEPT, States, lever_change, moments_of_states, states_layout
from ..jobs.records import Layout
from ..vocabulary.adhesion_laws import ADHESION_LAWS
from .adhesion_on_cells import Adhesion, interaction_range
from .cycle import Cycles, cycles_on, largest_displacement
from .mesh import MOST_REFINED
from .problem import Place, cell_axes, surface_at

#: Cells along a side of a pixel below which levers take finer cells than the pull-off: by laws with a range, contacts
#: of few cells have levers up to three times too large.
_FINE = 8

#: Largest number of these finer cells within range.
_MOST_FINER_CELLS = 2_600

#: Largest number of cells within range of a second mesh to pixels.
_LARGEST_MESH = 1_000_000

#: Error over the change by the mesh, without range: edges converge with the root of the cell, so that all further
#: changes together exceed the last. Set on the soft surfaces 54 and 55 of ``tests/benchmarks/levers.py``.
_SLOW_CHANGE = 2.0

#: Least error of the position of a contact's edge, in cells.
_EDGE_ERROR = 0.2


def lever_results(place: Place, cycles: Cycles, adhesion: Adhesion) -> dict[str, Any]:
    """Return the moments at one place, by their names in a record of `adhesive`; they are scaled to its pull-off."""
    layout = states_layout(adhesion.directions)
    problem = cycles.problem

    def moments(refine: int, *, splined: bool = False) -> tuple[np.ndarray, np.ndarray]:
        on_mesh = cycles
        if splined or refine != problem.refine:
            other = problem._replace(refine=refine, splined=splined)
            on_mesh = cycles_on(surface_at(place, other), other, adhesion, single_edge=True)
        return _moments_on(place, on_mesh, layout)

    refine = _lever_refinement(cycles, adhesion)
    record, every_second = moments(refine)
    coarser = layout.blank()
    if refine > 1:
        coarser, _ = moments(refine // 2, splined=refine > 2)  # nothing lies between cells that are pixels
    change = lever_change(coarser, record) * (1.0 if ADHESION_LAWS[adhesion.law].has_range else _SLOW_CHANGE)
    edge = _EDGE_ERROR * problem.pixel / refine / np.abs(record["lever"]).mean()
    record["lever_error"] = np.hypot(max(change, edge), lever_change(every_second, record))
    scale = cycles.pull_offs[0] / record["pull_off_force"]
    for name in ("resisting_moment", "tipping_force"):
        record[name] *= scale
    return {own_name: record[name] for own_name, name in KEPT.items()}


def _lever_refinement(cycles: Cycles, adhesion: Adhesion) -> int:
    """Return the refinement for the lever: that of the pull-off, finer at small places, and 2 instead of 1."""
    problem = cycles.problem
    refine = problem.refine
    deepest = largest_displacement(cycles.paths[0], cycles)
    within = np.count_nonzero(cycles.surface.separation < deepest + interaction_range(adhesion, problem))
    pixels = within / refine**2
    if problem.refine < _FINE and ADHESION_LAWS[adhesion.law].has_range:
        while 2 * refine <= MOST_REFINED and pixels * (2 * refine) ** 2 <= _MOST_FINER_CELLS:
            refine *= 2
    return 2 if refine == 1 and 4 * pixels <= _LARGEST_MESH else refine


def _moments_on(place: Place, cycles: Cycles, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the record of one place on one mesh, from all states and from every second."""
    cycle_path = cycles.paths[0]
    events = cycles.events[0]
    if not events:
        return layout.blank(), layout.blank()
    angles = layout.axes["direction"]
    problem = cycles.problem
    x, y = cell_axes(place, problem)
    states = cycle_path.states[cycle_path.first_retraction :][::-1]
    footprints = [seen.moved(x[0], y[0], angles) for seen in cycle_path.observed[::-1]]
    known = {
        "pull_off_force": cycles.steep_pulls[0],
        "pull_off_delta": events["pull_off_delta"],
        "converged": bool(states["converged"].all()),
    }
    parts = [States(footprints[::n], states["force"][::n], states["contact_area"][::n], problem.refine) for n in (1, 2)]
    all_states, every_second = (moments_of_states(part, layout, 0.0, **known) for part in parts)
    return all_states, every_second
