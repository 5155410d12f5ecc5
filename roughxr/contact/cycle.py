"""Cycles of approach and retraction at one contact centre: the choice of solver and of mesh.

Smooth laws of finite range are followed by Newton's method (``kernels.adhesion.smooth_path``), the Griffith limit and
Dugdale's law cell by cell (``kernels.adhesion.path``). The cells are halved until two meshes in a row agree on the
pull-off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.adhesion import cohesive_laws, path, smooth_laws, smooth_path
from ..kernels.halfspace import displacement_control
from ..kernels.halfspace.products import coefficients_for
from .problem import Place, Problem, Surface, surface_at

#: Laws that are followed by Newton's method, and their names in the kernels.
SMOOTH = ("exponential", "lennard_jones")
_KERNEL_NAMES = {"exponential": "exponential", "lennard_jones": "van_der_waals"}

#: The refinements that refine="auto" may choose.
REFINEMENTS = (1, 2, 4, 8, 16)

#: The largest cell on which a law with a range can be solved. The cell must resist more than the traction falls off:
#: w/ρ² < E*/dx times this. On larger cells the edge of a contact jumps from cell to cell, which overestimates the
#: pull-off (on the glass twin by 4 to 7 times at w dx/(E* ρ²) = 3.7, some per cent at 0.9 and 0.5). Laws without range
#: start with cells of 5 nm or less.
_SOFTENING, _FIRST_CELL = 1.0, 5.0

#: Largest number of meshes on which a place is solved.
_MESHES = 4

#: A preload counts as reached within this part of it, or of the largest pull.
_MET = 0.02

#: A preload between two states is bracketed down to this part of a step.
_CLOSEST = 1 / 64

#: Factor from one displacement tried for a preload to the next, and the largest number of them.
_DEEPER, _TRIES = 1.6, 24


class Adhesion(NamedTuple):
    """How the bodies adhere, how they are moved, and how accurately the pull-off is computed."""

    work: float  # J/m²
    law: str
    length: float  # nm: ρ of "exponential", z₀ of "lennard_jones", w over the strength of "dugdale"; NaN for "griffith"
    preloads: np.ndarray  # nN, ascending; empty where the indenter turns back at the last displacement
    refine: int  # 0: refine until ``accuracy`` is met
    accuracy: float  # NaN: take the first mesh, without an estimate of its error
    step: float  # nm
    tolerance: float
    max_iterations: int
    max_cells: int
    cycles: int = 1  # at each place, each on the shape that the one before has left


def reach_of_law(adhesion: Adhesion, problem: Problem) -> float:
    """Return the gap (nm) beyond which nothing pulls."""
    if adhesion.law == "griffith" or adhesion.work == 0:
        return 0.0
    if adhesion.law in SMOOTH:
        return smooth_laws.smooth_law(_KERNEL_NAMES[adhesion.law], adhesion.work, adhesion.length).range
    return law_by_cells(adhesion, problem).range


class Cycles(NamedTuple):
    """The paths of one surface, one for each cycle and preload, in nm and nN, and the surface and mesh they are on."""

    surface: Surface
    problem: Problem
    paths: list[path.Path]


def cycles_at(place: Place, problem: Problem, adhesion: Adhesion, *, fields: bool) -> tuple[Cycles, dict]:
    """Return the cycles at one place, on a mesh that meets the accuracy, and the errors of their pull-offs."""
    if adhesion.refine:
        return _cycles(place, problem, adhesion, adhesion.refine, fields=fields), {"refinement": adhesion.refine}
    return _refined_until_accurate(place, problem, adhesion)


def _refined_until_accurate(place: Place, problem: Problem, adhesion: Adhesion) -> tuple[Cycles, dict]:
    """Halve the cells until the largest pull changes by less than the accuracy, or there are too many of them.

    The change from one mesh to the next is taken as the error of the finer one: an upper bound where the meshes
    converge at first order or better. The error of the step is the change between the step and twice the step on the
    coarsest mesh; where it is large, finer meshes take half the step.
    """
    meshes = [n for n in REFINEMENTS if n >= _first_refinement(problem, adhesion)][:_MESHES]
    before = _cycles(place, problem, adhesion, meshes[0])
    if np.isnan(adhesion.accuracy):
        return before, {"refinement": meshes[0]}
    of_step = _change(_cycles(place, problem, adhesion._replace(step=2 * adhesion.step), meshes[0]), before)
    if (of_step > 0.5 * adhesion.accuracy).any():  # longer steps pass over states that shorter ones find
        adhesion = adhesion._replace(step=0.5 * adhesion.step)
    found, n, of_mesh = before, meshes[0], np.full_like(of_step, np.nan)
    for finer in meshes[1:]:
        if _overlapping(before.surface, problem, adhesion) * (finer / n) ** 2 > adhesion.max_cells:
            break
        found = _cycles(place, problem, adhesion, finer)
        of_mesh, n = _change(before, found), finer
        if (of_mesh < adhesion.accuracy)[np.isfinite(of_mesh)].all():
            break
        before = found
    errors = {"mesh_error": of_mesh, "step_error": of_step, "pull_off_error": np.hypot(of_mesh, of_step)}
    return found, {"refinement": n, **errors}


def _first_refinement(problem: Problem, adhesion: Adhesion) -> int:
    cell = largest_cell(adhesion.law, adhesion.length, problem.contact_modulus, adhesion.work)
    return next((n for n in REFINEMENTS if problem.pixel / n <= cell), REFINEMENTS[-2])


def largest_cell(law: str, length: float, modulus: float, work: float) -> float:
    """Return the largest cells (nm) on which a law of this length (nm) holds; modulus in GPa, work in J/m²."""
    return _SOFTENING * modulus * length**2 / work if law in SMOOTH and work > 0 else _FIRST_CELL


def _overlapping(surface: Surface, problem: Problem, adhesion: Adhesion) -> int:
    return int(np.count_nonzero(surface.separation < deltas_of(surface, problem, adhesion)[-1]))


def _change(one: Cycles, other: Cycles) -> np.ndarray:
    """Return the relative difference of the pull-offs of two meshes; NaN where neither pulls."""
    a, b = (np.array([largest_pull(followed) for followed in found.paths]) for found in (one, other))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(b > 0, np.abs(a - b) / b, np.nan)


def deltas_of(surface: Surface, problem: Problem, adhesion: Adhesion) -> np.ndarray:
    """Return the prescribed displacements, nm below the datum; those up to a preload count from first contact."""
    return problem.steps + (surface.separation.min() if adhesion.preloads.size else surface.zero)


def deepest_of(followed: path.Path, found: Cycles) -> float:
    """Return the largest displacement of a cycle, nm below the datum."""
    return found.surface.zero + (followed.states[followed.turn - 1, path.DELTA] if followed.turn else -np.inf)


def reached(followed: path.Path, adhesion: Adhesion, k: int) -> bool:
    """Return whether a cycle turned back at its preload, and not because loading was followed no deeper."""
    if adhesion.preloads.size == 0:
        return True
    if not followed.turn:
        return False
    turn, largest = followed.states[followed.turn - 1], -followed.states[:, path.FORCE].min()
    goal = adhesion.preloads[k % adhesion.preloads.size]
    return turn[path.AREA] > 0 and turn[path.FORCE] >= goal - _MET * max(goal, largest)


def largest_pull(followed: path.Path) -> float:
    """Return the pull-off force of a cycle, nN; NaN for one that broke off."""
    back = followed.states[followed.turn :, path.FORCE]
    return -float(back.min()) if followed.status == path.CONVERGED and back.size else np.nan


def _cycles(place: Place, problem: Problem, adhesion: Adhesion, refine: int, *, fields: bool = False) -> Cycles:
    problem = problem._replace(refine=refine)
    surface = surface_at(place, problem)
    follow = _follow_smooth if adhesion.law in SMOOTH and adhesion.work > 0 else _follow_by_cells
    paths = [_in_units(found, surface, problem) for found in follow(surface, problem, adhesion, fields)]
    return Cycles(surface, problem, paths)


def _follow_smooth(surface: Surface, problem: Problem, adhesion: Adhesion, fields: bool) -> list[path.Path]:
    found = _cycle_smooth(surface, problem, adhesion, fields, adhesion.preloads, None)
    before = found
    for _ in range(1, adhesion.cycles):
        loads = [adhesion.preloads[k : k + 1] for k in range(len(before))]
        before = [
            _cycle_smooth(surface, problem, adhesion, fields, load, followed.left[-1])[0] if followed.turn else followed
            for load, followed in zip(loads, before)
        ]
        found = found + before
    return found


def _cycle_smooth(surface, problem, adhesion, fields, preloads, left) -> list[path.Path]:
    """Return the paths up to each preload (nN) and back, on a surface whose residual height is ``left`` (nm)."""
    per_unit = problem.dx / problem.contact_modulus
    cap, limit = _bounds(problem)
    return smooth_path.follow_smooth(
        surface.separation,
        deltas_of(surface, problem, adhesion),
        adhesion.step,
        coefficients_for(surface.separation.shape),
        smooth_laws.smooth_law(_KERNEL_NAMES[adhesion.law], adhesion.work * per_unit, adhesion.length),
        preloads=preloads / (problem.contact_modulus * problem.dx),
        tolerance=adhesion.tolerance,
        max_rounds=adhesion.max_iterations,
        max_cells=adhesion.max_cells,
        fields=fields,
        cap=cap,
        limit=limit,
        left=left,
    )


def _follow_by_cells(surface: Surface, problem: Problem, adhesion: Adhesion, fields: bool) -> list[path.Path]:
    if adhesion.preloads.size == 0:
        return [_by_cells(surface, deltas_of(surface, problem, adhesion), problem, adhesion, fields)]
    found = before = [_up_to(load, surface, problem, adhesion) for load in adhesion.preloads]
    for _ in range(1, adhesion.cycles):
        before = [_again(load, last, surface, problem, adhesion) for load, last in zip(adhesion.preloads, before)]
        found = found + before
    return found


def _again(load: float, before: path.Path, surface: Surface, problem: Problem, adhesion: Adhesion) -> path.Path:
    """Return the next cycle up to the same load, on the shape that the one before left; the same if elastic."""
    if not problem.yielding or before.status != path.CONVERGED:
        return before
    return _up_to(load, surface, problem, adhesion, before.left[-1])


def _up_to(
    load: float, surface: Surface, problem: Problem, adhesion: Adhesion, left: np.ndarray | None = None
) -> path.Path:
    """Return the cycle that turns back where the force first reaches a load (nN), once anything touches."""
    stiffness, depth, touch = problem.contact_modulus * problem.dx, 4 * adhesion.step, surface.separation.min()
    for _ in range(_TRIES):
        depth = min(depth, float(problem.steps[-1]))
        found = _by_cells(surface, np.array([depth + touch]), problem, adhesion, False, left)
        up = found.states[: found.turn]
        met = (up[:, path.FORCE] * stiffness >= load) & (up[:, path.AREA] > 0)
        if met.any() or found.status != path.CONVERGED or depth == problem.steps[-1]:
            break
        depth *= _DEEPER
    if not met.any():
        return found
    k = int(np.argmax(met))
    bracket = up[max(k - 1, 0)], up[k]
    return _closed_in(load, bracket, surface, problem, adhesion, left)


def _closed_in(load, bracket, surface, problem, adhesion, left) -> path.Path:
    """Return the cycle that turns back at a load (nN), which two given states bracket."""
    below, above = bracket
    goal, least = load / (problem.contact_modulus * problem.dx), adhesion.step * _CLOSEST
    turn = float(above[path.DELTA]) if above[path.DELTA] <= below[path.DELTA] else _between(below, above, goal)
    for _ in range(_TRIES):
        found = _by_cells(surface, np.array([turn]), problem, adhesion, False, left)
        if found.status != path.CONVERGED:
            return found
        last = found.states[found.turn - 1]
        over, largest = last[path.FORCE] - goal, -found.states[:, path.FORCE].min()
        low = over < 0 or last[path.AREA] == 0
        near = not low and over <= 0.5 * _MET * max(goal, largest)
        if near or above[path.DELTA] - below[path.DELTA] <= least:
            break
        below, above = (last, above) if low else (below, last)
        turn = _between(below, above, goal)
    return found if not low else _by_cells(surface, above[[path.DELTA]], problem, adhesion, False, left)


def _between(below: np.ndarray, above: np.ndarray, force: float) -> float:
    """Return the displacement at which the line between two states has a force; the middle if one does not touch."""
    part = 0.5
    if below[path.AREA] > 0 and above[path.FORCE] > below[path.FORCE]:
        # a little deeper than the line says: slightly above the preload is close enough, slightly below is not
        part = (force - below[path.FORCE]) / (above[path.FORCE] - below[path.FORCE]) + _CLOSEST
    return float(below[path.DELTA] + min(max(part, 0.05), 0.95) * (above[path.DELTA] - below[path.DELTA]))


def _by_cells(surface, deltas, problem, adhesion, fields, left=None) -> path.Path:
    cap, limit = _bounds(problem)
    return path.follow(
        surface.separation,
        deltas,
        adhesion.step,
        law_by_cells(adhesion, problem),
        adhesion.work * problem.dx / problem.contact_modulus,
        tolerance=adhesion.tolerance,
        max_iterations=adhesion.max_iterations,
        max_cells=adhesion.max_cells,
        fields=fields,
        cap=cap,
        limit=limit,
        left=left,
    )


def _bounds(problem: Problem) -> tuple[float, float]:
    """Return the largest pressure on unit cells of unit modulus, and the one that is told of."""
    per_unit = problem.dx / problem.contact_modulus
    return displacement_control.Hardness(problem.hardness, problem.yielding).scaled(per_unit)


def law_by_cells(adhesion: Adhesion, problem: Problem) -> cohesive_laws.CohesiveLaw:
    """Return the law on unit cells of unit modulus."""
    per_unit = problem.dx / problem.contact_modulus
    w = adhesion.work * per_unit
    if adhesion.law == "griffith" or w == 0:
        return cohesive_laws.griffith(w)
    return cohesive_laws.finite_range(adhesion.law, w, w / adhesion.length)


def _in_units(followed: path.Path, surface: Surface, problem: Problem) -> path.Path:
    """Return a path in nm, nN and GPa, its displacements counted from the datum of the result."""
    states, stiffness = followed.states.copy(), problem.contact_modulus * problem.dx
    states[:, [path.FORCE, path.ENERGY, path.DISSIPATED]] *= stiffness
    states[:, path.AREA] *= problem.dx * problem.dx
    states[:, path.DELTA] -= surface.zero
    volume = problem.dx**2
    hard = followed.hard * [1.0, 1.0, volume, volume * (problem.hardness if problem.yielding else 0.0)]
    pressures = followed.pressures * problem.contact_modulus / problem.dx
    return followed._replace(states=states, pressures=pressures, hard=hard)


def yield_told(followed: path.Path, problem: Problem) -> dict[str, np.ndarray]:
    """Return what the states of a path have yielded, as far as a hardness is known."""
    if not np.isfinite(problem.hardness):
        return {}
    told = {"yielded_fraction": smooth_path.HARD_FORCE, "yielded_area_fraction": smooth_path.HARD_AREA}
    if problem.yielding:
        told |= {"yielded_area": smooth_path.DENT_AREA, "plastic_work": smooth_path.DENT}
    return {name: followed.hard[:, column] for name, column in told.items()}


def events(followed: path.Path) -> dict[str, float]:
    """Return snap-in, pull-off, work of separation and so on; empty for a path that broke off or never touched."""
    states, back = followed.states, followed.states[followed.turn :]
    touching = states[:, path.AREA] > 0
    if followed.status != path.CONVERGED or not touching.any():
        return {}
    first, lowest = states[np.argmax(touching)], back[np.argmin(back[:, path.FORCE])]
    delta, force = states[:, path.DELTA], states[:, path.FORCE]
    return {
        "snap_in_force": max(-first[path.FORCE], 0.0),
        "snap_in_delta": first[path.DELTA],
        "pull_off_force": max(-lowest[path.FORCE], 0.0),
        "pull_off_delta": lowest[path.DELTA],
        "detachment_delta": delta[touching].min() if touching[followed.turn :].any() else np.nan,
        "work_of_separation": _work(np.minimum(back[:, path.FORCE], 0.0), back[:, path.DELTA]),
        "hysteresis": _work(force, delta),
        "pull_off_resolution": lowest[path.RESOLUTION],
    }


def _work(force: np.ndarray, delta: np.ndarray) -> float:
    """Return the work of a force along a path, nN nm."""
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(delta)))
