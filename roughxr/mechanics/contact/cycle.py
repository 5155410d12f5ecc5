"""Cycles of approach and retraction on one mesh: their paths, and the events and pull-offs that follow from them.

All laws are followed by Newton's method (``kernels.adhesion.path``), which needs a traction whose slope the mesh
resolves. Laws with an edge, JKR's limit (all tension at contact) and Dugdale's, are solved with the steepest
edge that the mesh resolves, and with half that slope; both results are extrapolated (`edge_extrapolation`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..asperity.moments import edge_opening, footprint, touching_cells
from ..kernels.adhesion import path as path
from ..kernels.halfspace import displacement_control
from ..vocabulary.adhesion_laws import ADHESION_LAWS, DUGDALE, JKR
from .adhesion_on_cells import Adhesion, interaction_range, law_on_cells
from .problem import Problem, Surface

#: Extrapolation factor, result = steep + factor × (steep − wide): a constant, plus a number over the radius, in cells,
#: of the smallest contact at pull-off. Smooth spheres then have JKR's pull-off, on the mean of sixteen positions on the
#: pixels, within 0.6 % from 2.5 to 40 cells in radius (``tests/benchmarks/without_range.py``).
_EXTRAPOLATION = {JKR: (1.15, 6.4), DUGDALE: (0.5, 0.0)}

#: Largest relative correction of the steeper edge's pull-off, more than that of any sphere. Beyond it the second number
#: is dropped: edges then differ by more than their width explains, as at a summit that touches with one of them.
LARGEST_CORRECTION = 0.15

#: Pull-offs that differ by more than this part belong to different contacts: the steeper edge's result is taken.
LARGEST_DIFFERENCE = 0.3

#: Stated error, over the difference of both edges, if the steeper edge has the larger pull-off. Flat punches are off by
#: 1.5 to 1.7 times the difference at ten and twenty cells in radius, flattened asperities by less than half of it.
_RIM_ERROR = 2.0

#: Least radius (cells) of a resolved contact at pull-off.
LEAST_RADIUS = 2.0

#: Largest number of cells within the range of adhesion.
MOST_CELLS = 10**6

#: Approach and retraction are on one branch where their energies differ by less, over the work of separation.
_SAME_ENERGY = 0.005

#: Tolerance of a reached preload, as a part of the preload or of the largest tension.
_PRELOAD_TOLERANCE = 0.02


class Extrapolation(NamedTuple):
    """Extrapolation from two widths of an edge to width 0: result = steep + factor × (steep − wide)."""

    factor: float  # 0: the steeper edge's result is taken
    error: float  # relative error of a pull-off that is not extrapolated; else 0

    def apply(self, steep: Any, wide: Any) -> Any:
        """Return a quantity extrapolated from its values with the steeper and with the wider edge."""
        return steep + self.factor * (steep - wide) if self.factor else steep


class Cycles(NamedTuple):
    """The paths of one surface, one for each cycle and preload, in nm and nN, with the surface and its mesh."""

    surface: Surface
    problem: Problem
    law: str
    paths: list[path.Path]
    wider: list[path.Path]  # of a law with an edge, with the wider edge; else empty
    edges: list[Extrapolation]  # from both edges, of each cycle
    events: list[dict[str, float]]  # snap-in, pull-off, work of separation etc.; empty if broken or without contact
    steep_pulls: np.ndarray  # nN, of the steeper edge
    wide_pulls: np.ndarray  # nN, of the wider edge; empty without
    pressed_pulls: np.ndarray  # nN, once the indenter was pressed as hard as it holds; NaN if not asked for

    @property
    def pull_offs(self) -> np.ndarray:
        """The pull-off forces of all cycles, nN; NaN for a broken path."""
        return _pull_offs(self.events)


def overlapping_cells(surface: Surface, problem: Problem, adhesion: Adhesion) -> int:
    """Return the number of cells within the law's range at the largest displacement."""
    within = prescribed_deltas(surface, problem, adhesion)[-1] + interaction_range(adhesion, problem)
    return int(np.count_nonzero(surface.separation < within))


def prescribed_deltas(surface: Surface, problem: Problem, adhesion: Adhesion) -> np.ndarray:
    """Return the prescribed displacements, nm below the datum; with a preload they count from first contact."""
    return problem.steps + (surface.separation.min() if adhesion.preloads.size else surface.zero)


def largest_displacement(cycle_path: path.Path, cycles: Cycles) -> float:
    """Return the largest displacement of a cycle, nm below the datum."""
    if not cycle_path.first_retraction:
        return -np.inf
    return cycles.surface.zero + cycle_path.states["delta"][cycle_path.first_retraction - 1]


def reached(cycle_path: path.Path, adhesion: Adhesion, k: int) -> bool:
    """Return whether a cycle turned back at its preload, and not at the largest depth."""
    if adhesion.preloads.size == 0:
        return True
    if not cycle_path.first_retraction:
        return False
    last_loaded = cycle_path.states[cycle_path.first_retraction - 1]
    largest_pull = -cycle_path.states["force"].min()
    goal = adhesion.preloads[k % adhesion.preloads.size]
    least = goal - _PRELOAD_TOLERANCE * max(goal, largest_pull)
    return last_loaded["contact_area"] > 0 and last_loaded["force"] >= least


def cycles_on(
    surface: Surface,
    problem: Problem,
    adhesion: Adhesion,
    *,
    fields: bool = False,
    single_edge: bool = False,
    press: bool = False,
) -> Cycles:
    """Return the cycles on a surface and its mesh, of a law with an edge with both edges or the steepest only.

    The footprints of the states on retraction are observed if directions of rolling are stated.
    """
    has_edge = ADHESION_LAWS[adhesion.law].has_edge and adhesion.work > 0
    observe = _footprints_of(problem, adhesion) if adhesion.directions.size else None
    options = {"fields": fields, "press": press, "observe": observe}
    paths = _follow(surface, problem, adhesion, law_on_cells(adhesion, problem), options)
    steep = [_events(cycle_path, has_edge) for cycle_path in paths]
    pulls = _pull_offs(steep)
    pressed = np.array([cycle_path.pressed for cycle_path in paths])
    if not has_edge or single_edge:
        edges = [Extrapolation(0.0, 0.0)] * len(paths)
        return Cycles(surface, problem, adhesion.law, paths, [], edges, steep, pulls, np.zeros(0), pressed)
    wider = _follow(surface, problem, adhesion, law_on_cells(adhesion, problem, 0.5), {})
    wide = [_events(cycle_path, has_edge) for cycle_path in wider]
    edges = [_extrapolation(adhesion.law, *both) for both in zip(steep, wide)]
    events = [_extrapolated_events(*each) for each in zip(steep, wide, edges)]
    with np.errstate(invalid="ignore", divide="ignore"):
        pressed = _pull_offs(events) * pressed / pulls  # as the narrower edge's
    return Cycles(surface, problem, adhesion.law, paths, wider, edges, events, pulls, _pull_offs(wide), pressed)


def _footprints_of(problem: Problem, adhesion: Adhesion) -> Callable:
    """Return a function from a solved state to its `Footprint`, nm from the first cell of the window."""
    side = problem.dx
    force_of_cell = problem.contact_modulus * side
    opening = edge_opening(adhesion.law, adhesion.work, problem.contact_modulus, side)

    def observe(solved: Any) -> Any:
        pressure, gap, touching = solved.state
        touching = touching | touching_cells(gap, pressure, side, opening)
        x, y = (side * np.arange(cells.start, cells.stop) for cells in (solved.rows, solved.columns))
        return footprint(force_of_cell * pressure, touching, x, y, side, adhesion.directions)

    return observe


def _pull_offs(events: list[dict[str, float]]) -> np.ndarray:
    """Return the pull-off forces (nN) among the events of cycles."""
    return np.array([event.get("pull_off_force", np.nan) for event in events])


def _follow(surface: Surface, problem: Problem, adhesion: Adhesion, law, options: dict) -> list[path.Path]:
    """Return the paths of all cycles and preloads, in nm, nN and GPa."""
    paths = before = _cycle(surface, problem, adhesion, law, options, adhesion.preloads, None)
    for _ in range(1, adhesion.cycles):
        loads = [adhesion.preloads[k : k + 1] for k in range(len(before))]
        before = [
            _cycle(surface, problem, adhesion, law, options, load, last.residual_heights[-1])[0]
            if last.first_retraction
            else last
            for load, last in zip(loads, before)
        ]
        paths = paths + before
    return [_in_units(cycle_path, surface, problem) for cycle_path in paths]


def _cycle(surface, problem, adhesion, law, options, preloads, residual_height) -> list[path.Path]:
    """Return the paths up to each preload (nN) and back, on a surface with residual heights (nm) of earlier cycles."""
    hardness = displacement_control.Hardness(problem.hardness, problem.yielding)
    cap, limit = hardness.scaled(problem.dx / problem.contact_modulus)
    return path.follow_path(
        surface.separation,
        prescribed_deltas(surface, problem, adhesion),
        adhesion.step,
        law,
        preloads=preloads / (problem.contact_modulus * problem.dx),
        max_cells=MOST_CELLS,
        cap=cap,
        limit=limit,
        residual_height=residual_height,
        capture=adhesion.capture,
        film=problem.film,
        **options,
    )


def _in_units(cycle_path: path.Path, surface: Surface, problem: Problem) -> path.Path:
    """Return a path in nm, nN and GPa, its displacements counted from the datum of the result."""
    states, stiffness = cycle_path.states.copy(), problem.contact_modulus * problem.dx
    for name in ("force", "energy", "dissipated"):
        states[name] *= stiffness
    for name in ("contact_area", "yielded_area", "plastic_work"):
        states[name] *= problem.dx**2
    states["plastic_work"] *= problem.hardness if problem.yielding else 0.0
    states["delta"] -= surface.zero
    pressures = cycle_path.pressures * problem.contact_modulus / problem.dx
    return cycle_path._replace(states=states, pressures=pressures, pressed=cycle_path.pressed * stiffness)


def yielded_shares(cycle_path: path.Path, problem: Problem) -> dict[str, np.ndarray]:
    """Return the yielded shares of the states of a path, if a hardness is known."""
    if not np.isfinite(problem.hardness):
        return {}
    names = ("yielded_fraction", "yielded_area_fraction", *(("yielded_area", "plastic_work") * problem.yielding))
    return {name: cycle_path.states[name] for name in names}


def _extrapolation(law: str, steep: dict[str, float], wide: dict[str, float]) -> Extrapolation:
    """Return the `Extrapolation` of a cycle by its events with both edges."""
    pull = steep.get("pull_off_force", np.nan)
    change = (pull - wide.get("pull_off_force", np.nan)) / max(pull, 1e-300)
    return edge_extrapolation(law, steep.get("pull_off_resolution", np.nan), change)


def edge_extrapolation(law: str, radius: float, change: float) -> Extrapolation:
    """Return the `Extrapolation` for a relative excess ``change`` of the steeper edge's pull-off over the wider edge's.

    Richardson's extrapolation of an error c bⁿ in the width b of the edge. Without range half the slope widens the edge
    by √2, hence a factor of 1/(2^{n/2} − 1). Dugdale's edge widens by 2, hence 1/(2ⁿ − 1). Spheres of many cells give
    n = 1.8 and 1.6. Without range, few cells add a number over the radius, which is fitted (``_EXTRAPOLATION``).
    """
    if change > 0 and not ADHESION_LAWS[law].has_range:  # as at a rim that cannot move
        return Extrapolation(0.0, _RIM_ERROR * change)
    if abs(change) > LARGEST_DIFFERENCE:
        return Extrapolation(0.0, abs(change))
    constant, over_radius = _EXTRAPOLATION[law]
    factor = constant + over_radius / max(radius, LEAST_RADIUS) if radius > 0 else constant
    if factor * abs(change) > LARGEST_CORRECTION:
        factor = max(constant, LARGEST_CORRECTION / abs(change))
    return Extrapolation(factor, 0.0)


def _extrapolated_events(steep: dict, wide: dict, extrapolation: Extrapolation) -> dict[str, float]:
    """Return the events of a cycle, extrapolated from those with both edges; empty if there are none of one."""
    if not (steep and wide):
        return {}
    out = {name: extrapolation.apply(value, wide[name]) for name, value in steep.items()}
    out |= {name: max(out[name], 0.0) for name in ("snap_in_force", "pull_off_force", "hysteresis")}
    return out | {"pull_off_resolution": steep["pull_off_resolution"]}


def _events(cycle_path: path.Path, has_edge: bool) -> dict[str, float]:
    """Return the events of one path; NaN if a state that they depend on has not converged.

    Of a law with an edge, both paths are extrapolated, so that neither takes states of its retraction for the approach.
    """
    states, retraction = cycle_path.states, cycle_path.states[cycle_path.first_retraction :]
    touching = states["contact_area"] > 0
    if cycle_path.status != path.CONVERGED or not touching.any():
        return {}
    lowest = cycle_path.first_retraction + int(np.argmin(retraction["force"]))
    last = len(touching) - 1 - int(np.argmax(touching[::-1]))
    whole = (
        states
        if has_edge
        else np.concatenate([_approach(states[: cycle_path.first_retraction], retraction[::-1]), retraction])
    )
    first = whole[np.argmax(whole["contact_area"] > 0)]
    delta, force, fine = states["delta"], states["force"], states["converged"]
    values = {
        "snap_in_force": (max(-first["force"], 0.0), first["converged"]),
        "snap_in_delta": (first["delta"], first["converged"]),
        "pull_off_force": (max(-force[lowest], 0.0), fine[lowest]),
        "pull_off_delta": (delta[lowest], fine[lowest]),
        "detachment_delta": (delta[touching].min() if last >= cycle_path.first_retraction else np.nan, fine[last]),
        "work_of_separation": (_work(np.minimum(retraction["force"], 0.0), retraction["delta"]), fine.all()),
        "hysteresis": (max(_work(whole["force"], whole["delta"]), 0.0), fine.all()),
        "pull_off_resolution": (states["resolution"][lowest], True),
    }
    return {name: value if known else np.nan for name, (value, known) in values.items()}


def _approach(loading: np.ndarray, retraction: np.ndarray) -> np.ndarray:
    """Return the states of the approach, in steps where it runs along the retraction of which the latter's states too.

    A stiff body pulls most within a fraction of a step, which only the retraction resolves. Both take states in order
    of their displacements. They are on one branch where their energies agree, of which forces are the slopes.
    """
    from scipy.interpolate import CubicHermiteSpline

    distinct = np.flatnonzero(np.diff(retraction["delta"], prepend=-np.inf) > 0)
    if distinct.size < 2:
        return loading
    delta, energy, force, area = (retraction[name][distinct] for name in ("delta", "energy", "force", "contact_area"))
    energy_there = CubicHermiteSpline(delta, energy, force)(loading["delta"])
    tolerance = _SAME_ENERGY * _work(np.minimum(force, 0.0)[::-1], delta[::-1])
    after = np.clip(np.searchsorted(delta, loading["delta"]), 1, delta.size - 1)
    areas = np.sort([area[after - 1], area[after]], axis=0) * np.array([[0.99], [1.01]])
    together = (areas[0] <= loading["contact_area"]) & (loading["contact_area"] <= areas[1])
    together &= (loading["delta"] >= delta[0]) & (np.abs(loading["energy"] - energy_there) <= tolerance)
    step = np.searchsorted(loading["delta"], retraction["delta"])
    inside = (step > 0) & (step < len(loading))
    inside[inside] = together[step[inside] - 1] & together[step[inside]]
    return np.sort(np.concatenate([loading, retraction[inside]]), order="delta", kind="stable")


def _work(force: np.ndarray, delta: np.ndarray) -> float:
    """Return the work of a force along a path, nN nm."""
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(delta)))
