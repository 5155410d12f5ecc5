"""Resisting moments of the simulation's contacts."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..asperity.moments import MISSING, States, moments_of_states, states_layout, touching_cells
from ..bodies.pair import attraction_range
from ..contact.adhesive_options import LONG_STEP, preload_problem, usual_step, window_half_width
from ..contact.cycle import Adhesion, cycles_on, events
from ..contact.mesh import Mesh
from ..contact.problem import Place, Problem, cell_axes, surface_at
from ..contact.problem import places as placed_at
from ..contact.solving import state_fields
from ..jobs import spread
from ..jobs.records import Layout, labelled
from ..specimen import Specimen
from ..statistics.sampling import SHARE
from ..vocabulary import schema

#: Number of states of the retraction whose moments are compared, and largest number of cells along a side of a pixel;
#: more of them where heights that differ by fractions of a nanometre decide which supports touch.
_STATES, _MOST_CELLS, _SUPPORT_CELLS = 12, 2, 4

#: Range of displacements at places without a simulated pull-off, in ranges of adhesion.
_WITHOUT_PULL_OFF = -10 / 3, 1 / 3


def simulated_moments(specimen: Specimen, solved: xr.Dataset, *, directions: int = 24) -> xr.Dataset:
    """Return the resisting moments of the simulation's contacts, in the form of `rolling`.

    Each place of ``solved``, a result of `adhesive` by preload, is retracted again from the depth of its preload, for
    the levers of its contacts. A law without range takes the steeper edge's results.
    """
    finest = _SUPPORT_CELLS if SHARE in solved.coords or schema.is_wet(specimen.bodies) else _MOST_CELLS
    law, length = solved.attrs["law"], attraction_range(specimen.bodies)
    mesh = Mesh(int(solved["refinement"].max()), step=LONG_STEP * usual_step(specimen))
    problem, adhesion = preload_problem(specimen, law=law, mesh=mesh)
    adhesion = adhesion._replace(preloads=np.zeros(0))
    arguments = []
    for k in range(solved.sizes["subregion"]):
        place = solved.isel(subregion=[k])
        low, high = (float(np.ravel(place[f"{name}_delta"].values)[0]) for name in ("detachment", "preload"))
        low, high = (low, high) if low < high else (_WITHOUT_PULL_OFF[0] * length, _WITHOUT_PULL_OFF[1] * length)
        cells = int(place["refinement"].max())
        refine = cells if law == "lennard_jones" else min(cells, finest)
        own = problem._replace(steps=np.linspace(low, high, _STATES), refine=refine)
        (placed,), _ = placed_at(specimen, place, window_half_width(specimen, own, adhesion))
        arguments.append((*placed, own, adhesion))
    layout = states_layout(2 * np.pi * np.arange(directions) / directions)
    records = spread.task_results(_moments_at, arguments, layout.dtype, layout, name="moments")
    positions = xr.Dataset(coords={name: solved[name] for name in ("subregion_x", "subregion_y")})
    out = labelled(records, layout, specimen.bodies, positions)
    out.attrs = {"method": "adhesive", "load": 0.0, "missing": MISSING["adhesive"]}
    return _recorded(out, specimen, solved, "simulated_moments", directions)


def _moments_at(height, datum, window, ends, problem: Problem, adhesion: Adhesion, layout: Layout) -> np.ndarray:
    """Return the record of one place, as a task."""
    place, record = Place(height, datum, window, ends), layout.blank()
    surface = surface_at(place, problem)
    cycles = cycles_on(surface, problem, adhesion, fields=True, steepest_only=True)
    followed, known = cycles.paths[0], events(cycles, 0)
    if not known:
        return record
    retraction = followed.states["prescribed"] & (np.arange(followed.states.size) >= followed.turn)
    states = followed.states[retraction][::-1]
    pressure = followed.pressures[: -states.size - 1 : -1]
    yielded = surface._replace(separation=surface.separation - followed.residual_heights[-1])
    gap = state_fields(pressure, yielded, states["delta"] + surface.zero, problem)["gap"]
    contact = States(
        *cell_axes(place, problem),
        pressure=pressure,
        touching=touching_cells(gap, pressure, problem.dx),
        force=states["force"],
        area=states["contact_area"],
        refine=problem.refine,
    )
    pull_off = {name: known[name] for name in ("pull_off_force", "pull_off_delta")}
    return moments_of_states(contact, layout, 0.0, converged=states["converged"].all(), **pull_off)


def _recorded(out: xr.Dataset, specimen: Specimen, positions: xr.Dataset, verb: str, directions: int) -> xr.Dataset:
    """Return moments with the places' own coordinates, and their history."""
    shared = {name: positions[name] for name in ("subregion", "landing_share") if name in positions.coords}
    return schema.record(schema.label(out.assign_coords(shared)), verb, specimen.bodies, directions=directions)
