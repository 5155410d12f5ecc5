"""Cycles of approach and retraction at one contact centre: the choice of the mesh, and the errors of the pull-off.

All laws are followed by Newton's method (``kernels.adhesion.path``), for which the traction must not fall off more
steeply than a mesh can bear. Laws with an edge, the Griffith limit (all tension at contact) and Dugdale's, are solved
with the steepest edge that it bears, and with half that steepness; both results are extrapolated (`extrapolation_of`).
The cells are halved until two meshes in a row agree on the pull-off.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..bodies.liquid import Menisci
from ..kernels.adhesion import path as path
from ..kernels.adhesion import traction_laws
from ..kernels.halfspace import displacement_control
from .problem import Place, Problem, Surface, surface_at

#: Laws with an edge, which are extrapolated.
EDGED = ("griffith", "dugdale")

#: Largest fall of the traction with the gap at an edge, over E*/dx; the second edge has half of it.
_EDGE_SLOPE = 0.25

#: Width of the edge of condensed liquid, at least, in its height; the work stays the same. Changes the wetted area by
#: 0.1 %.
_LIQUID_EDGE = 0.25

#: Factor of the extrapolation: a constant, and a part over the radius, in cells, of the smallest contact at pull-off.
#: Smooth spheres then meet JKR's pull-off, on the mean of sixteen places on the pixels, within 0.6 % from 2.5 to 40
#: cells in radius (``tests/benchmarks/without_range.py``).
_EXTRAPOLATION = {"griffith": (1.15, 6.4), "dugdale": (0.5, 0.0)}

#: Largest correction of the steeper edge's pull-off, more than that of any sphere. Beyond it the part over the radius
#: is left out: edges then differ by more than their width explains, as at a summit that touches with one of them.
_LARGEST_CORRECTION = 0.15

#: Where pull-offs differ by more than this part, both edges lead to different contacts: the steeper one's is taken.
_LARGEST_DIFFERENCE = 0.3

#: Stated error, over the difference of both edges, where the steeper one pulls more: flat punches are off by 1.5 to 1.7
#: times the difference at ten and twenty cells in radius, asperities pressed flat by less than half of it.
_RIM_ERROR = 2.0

#: The refinements that refine="auto" may choose, and the largest number of meshes on which a place is solved: a fifth
#: would cost four times as much as the others together.
REFINEMENTS, _MOST_MESHES = (1, 2, 4, 8, 16), 4

#: The largest cell on which a law with a range can be solved. The cell must resist more than the traction falls off:
#: w/ρ² < E*/dx times this. On larger cells the edge of a contact jumps from cell to cell, which overestimates the
#: pull-off (on the glass twin by 4 to 7 times at w dx/(E* ρ²) = 3.7, some per cent at 0.9 and 0.5).
_SOFTENING = 1.0

#: Contacts of fewer cells in radius than this at pull-off are not taken as resolved.
LEAST_RADIUS = 2.0

#: Root mean square of the error of a mesh without range, times the square of the radius (cells) of the smallest contact
#: at pull-off: spheres of 1.5 to 14 cells (``tests/benchmarks/without_range.py``). A single mesh states three times as
#: much. Two meshes state it, too, since they may agree by chance.
_MESH_ERROR, _DEVIATIONS = 0.5, 3.0

#: Largest number of cells within the range of adhesion.
MOST_CELLS = 10**6

#: Work of separation that stands for none, nm².
_NO_WORK = 1e-12

#: A preload counts as reached within this part of it, or of the largest tension.
_PRELOAD_TOLERANCE = 0.02


class Adhesion(NamedTuple):
    """How the bodies adhere, how they are moved, and how accurately the pull-off is computed."""

    work: float  # J/m²
    law: str
    length: float  # nm: ρ of "exponential", z₀ of "lennard_jones", w over the strength of "dugdale"; NaN for "griffith"
    preloads: np.ndarray  # nN, ascending; empty where the indenter turns back at the last displacement
    refine: int  # 0: refine until ``accuracy`` is met
    accuracy: float  # NaN: take the first mesh, without an estimate of its error
    step: float  # nm
    cycles: int = 1  # at each place, each on the shape that the one before has left
    liquid: Menisci | None = None  # condensed between the bodies; ``work`` is then that of the solids outside it
    first_cell: float = np.inf  # nm, of the coarsest mesh that "auto" takes without range
    capture: float = 0.0  # nm, gap at which the pair's attraction snaps surfaces together; of "griffith" only

    @property
    def whole(self) -> float:
        """The whole work to part the bodies, that of liquid included, J/m²."""
        return self.work + (self.liquid.work if self.liquid else 0.0)

    @property
    def span(self) -> float:
        """The range of most of the attraction, nm: that of liquid where there is any."""
        return self.liquid.height if self.liquid else self.length

    @property
    def peak(self) -> float:
        """The largest tension of a law with a range, GPa."""
        return self.work / self.length + (self.liquid.pull if self.liquid else 0.0)


def law_on(adhesion: Adhesion, problem: Problem, steepness: float = 1.0) -> traction_laws.SmoothLaw:
    """Return the law on unit cells of unit modulus; an edge has this part of the steepness that the mesh bears."""
    per_unit = problem.dx / problem.contact_modulus
    w, length = adhesion.work * per_unit, adhesion.length
    if adhesion.liquid is not None:
        return _law_with_liquid(w, length, adhesion.liquid, per_unit)
    if w == 0:
        return traction_laws.smooth_law(exponential=(_NO_WORK, 1.0))
    if adhesion.law == "exponential":
        return traction_laws.smooth_law(exponential=(w, length))
    if adhesion.law == "lennard_jones":
        return traction_laws.smooth_law(waals=(w, length))
    if adhesion.law == "griffith":
        return traction_laws.without_range(w, _EDGE_SLOPE * steepness)
    return traction_laws.dugdale(w, length, _EDGE_SLOPE * steepness)


def _law_with_liquid(w: float, length: float, liquid: Menisci, per_unit: float) -> traction_laws.SmoothLaw:
    """Return the sum of the solids' and the liquid's traction, the latter's edge as steep as the mesh bears."""
    pull, height = liquid.pull * per_unit, liquid.height
    wide = np.clip(2.0 * pull / _EDGE_SLOPE, _LIQUID_EDGE * height, 3.0 * height)
    solids = {"exponential": (w, length)} if w > 0 else {}
    return traction_laws.smooth_law(step=traction_laws.widened_step(pull, height, wide), **solids)


def reach_of_law(adhesion: Adhesion, problem: Problem) -> float:
    """Return the gap (nm) beyond which nothing attracts."""
    return law_on(adhesion, problem, 0.5).range


class Cycles(NamedTuple):
    """The paths of one surface, one for each cycle and preload, in nm and nN, and the surface and mesh they are on."""

    surface: Surface
    problem: Problem
    paths: list[path.Path]
    wider: list[path.Path]  # of a law with an edge, with the wider edge; else empty
    law: str


def cycles_at(place: Place, problem: Problem, adhesion: Adhesion, *, fields: bool) -> tuple[Cycles, dict]:
    """Return the cycles at one place, on a mesh that meets the accuracy, and the errors of their pull-offs."""
    if adhesion.refine:
        cycles = _solved(place, problem, adhesion, adhesion.refine, fields=fields)
        settling = _settling_error(place, problem, adhesion, cycles)
        error = np.hypot(_single_mesh_error(cycles), settling)
        return cycles, {"refinement": adhesion.refine, "settling_error": settling, "pull_off_error": error}
    return _refined_until_accurate(place, problem, adhesion)


def _refined_until_accurate(place: Place, problem: Problem, adhesion: Adhesion) -> tuple[Cycles, dict]:
    """Halve the cells until the pull-off changes by less than the accuracy, or there are too many of them.

    The change from one mesh to the next is taken as the error of the finer one: an upper bound where the meshes
    converge at first order or better. The error of the step is the change between the step and twice the step on the
    coarsest mesh; where it is large, finer meshes take half the step.
    """
    pixels = overlapping_cells(surface_at(place, problem._replace(refine=1)), problem._replace(refine=1), adhesion)
    finest = max((n for n in REFINEMENTS if pixels * n**2 <= MOST_CELLS), default=1)
    first = min(_first_refinement(problem, adhesion), finest)
    meshes = [n for n in REFINEMENTS if first <= n <= finest][:_MOST_MESHES]
    cycles = _solved(place, problem, adhesion, meshes[0])
    if np.isnan(adhesion.accuracy):
        return cycles, {"refinement": meshes[0]}
    step_error = _change(_solved(place, problem, adhesion._replace(step=2 * adhesion.step), meshes[0]), cycles)
    spline_change = _change_by_splines(place, problem, adhesion, cycles)
    if (step_error > 0.5 * adhesion.accuracy).any():  # longer steps pass over states
        adhesion = adhesion._replace(step=0.5 * adhesion.step)
    n, mesh_error = meshes[0], np.full_like(step_error, np.nan)
    for n in meshes[1:]:
        before, cycles = cycles, _solved(place, problem, adhesion, n)
        # two edges may agree by chance: half the coarser mesh's error, the difference of its edges, counts too
        edge_errors = np.fmax(_edge_errors(cycles), _edge_errors(before) / _RIM_ERROR)
        mesh_error = np.fmax.reduce([_change(before, cycles), edge_errors, _radius_errors(cycles)])
        spline_change = _change_by_splines(place, problem, adhesion, cycles) if spline_change is None else spline_change
        if (mesh_error < adhesion.accuracy)[np.isfinite(mesh_error)].all():
            break
    errors = {"mesh_error": mesh_error, "step_error": step_error}
    errors["settling_error"] = _settling_error(place, problem, adhesion, cycles)
    errors["interpolation_error"] = 0.0 * mesh_error if spline_change is None else spline_change
    errors["pull_off_error"] = np.sqrt(sum(error**2 for error in errors.values()))
    return cycles, {"refinement": n, **errors}


def _change_by_splines(place: Place, problem: Problem, adhesion: Adhesion, cycles: Cycles) -> np.ndarray | None:
    """Return the change by splines between the pixels; None on cells of a pixel, which have nothing between them."""
    refine = cycles.problem.refine
    if refine == 1:
        return None
    return _change(_solved(place, problem._replace(splined=True), adhesion, refine), cycles)


def _settling_error(place: Place, problem: Problem, adhesion: Adhesion, cycles: Cycles) -> np.ndarray:
    """Return the relative change of each pull-off if the indenter is pressed on by the pull-off itself, or more.

    A law without range closes gaps up to one distance only (`snap_in_gap`); a preload closes the others.
    """
    pulls = pull_offs_of(cycles)
    change, load = np.zeros(pulls.size), np.nanmax(pulls, initial=0.0)
    light = np.resize(adhesion.preloads, pulls.size) < load if adhesion.preloads.size else np.zeros(pulls.size, bool)
    if adhesion.law != "griffith" or np.isnan(adhesion.accuracy) or not light.any():
        return change
    pressed = adhesion._replace(preloads=np.array([load]), cycles=1)
    pull = largest_pull(_solved(place, problem, pressed, cycles.problem.refine), 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(light & (pulls > 0), np.abs(pull - pulls) / pulls, change)


def _radius_errors(cycles: Cycles) -> np.ndarray:
    """Return the usual error of contacts of so many cells at pull-off."""
    radii = [events(cycles, k).get("pull_off_resolution", np.nan) for k in range(len(cycles.paths))]
    return _MESH_ERROR / np.array(radii) ** 2


def _edge_errors(cycles: Cycles) -> np.ndarray:
    return np.array([extrapolation(cycles, k).error for k in range(len(cycles.paths))])


def _single_mesh_error(cycles: Cycles) -> np.ndarray:
    """Return the stated errors of pull-offs by a law with an edge, NaN for one without."""
    if not cycles.wider:
        return np.full(len(cycles.paths), np.nan)
    errors = np.fmax(_edge_errors(cycles), _DEVIATIONS * _radius_errors(cycles))
    pulls, steep = pull_offs_of(cycles), pull_offs_of(cycles._replace(wider=[]))
    with np.errstate(invalid="ignore", divide="ignore"):
        limited = np.abs(pulls - steep) > 0.99 * _LARGEST_CORRECTION * steep  # edges differ by more than their width
        return errors + np.where(limited | (cycles.law == "dugdale"), np.abs(pulls - steep) / pulls, 0.0)


def _first_refinement(problem: Problem, adhesion: Adhesion) -> int:
    cell = bearing_cell(adhesion, problem.contact_modulus)
    return next((n for n in REFINEMENTS if problem.pixel / n <= cell), REFINEMENTS[-2])


def bearing_cell(adhesion: Adhesion, modulus: float) -> float:
    """Return the largest cells (nm) on which adhesion can be solved between bodies of a modulus (GPa)."""
    cell, liquid = largest_cell(adhesion.law, adhesion.length, modulus, adhesion.work), adhesion.liquid
    cell = min(cell, adhesion.first_cell) if np.isinf(cell) else cell
    if liquid is None:
        return cell
    return min(cell, 0.5 * _EDGE_SLOPE * modulus * liquid.height / liquid.pull)  # its edge is no wider than its height


def largest_cell(law: str, length: float, modulus: float, work: float) -> float:
    """Return the largest cells (nm) on which a law of this length (nm) can be solved; modulus in GPa, work in J/m²."""
    if law == "griffith" or work == 0:
        return np.inf
    bears = modulus * length**2 / work
    if law == "dugdale":  # so that the wider edge, too, leaves some of the step
        return 0.75 * _EDGE_SLOPE * bears
    return bears * (_SOFTENING if law == "exponential" else _SOFTENING / traction_laws.WALL)


def overlapping_cells(surface: Surface, problem: Problem, adhesion: Adhesion) -> int:
    """Return the number of cells within reach of the law at the largest displacement."""
    within = deltas_of(surface, problem, adhesion)[-1] + reach_of_law(adhesion, problem)
    return int(np.count_nonzero(surface.separation < within))


def _change(cycles: Cycles, reference: Cycles) -> np.ndarray:
    """Return the relative difference of the pull-offs of two meshes; NaN where the reference does not adhere."""
    pulls, expected = pull_offs_of(cycles), pull_offs_of(reference)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(expected > 0, np.abs(pulls - expected) / expected, np.nan)


def deltas_of(surface: Surface, problem: Problem, adhesion: Adhesion) -> np.ndarray:
    """Return the prescribed displacements, nm below the datum; those up to a preload count from first contact."""
    return problem.steps + (surface.separation.min() if adhesion.preloads.size else surface.zero)


def deepest_of(followed: path.Path, cycles: Cycles) -> float:
    """Return the largest displacement of a cycle, nm below the datum."""
    return cycles.surface.zero + (followed.states["delta"][followed.turn - 1] if followed.turn else -np.inf)


def reached(followed: path.Path, adhesion: Adhesion, k: int) -> bool:
    """Return whether a cycle turned back at its preload, and not because loading was followed no deeper."""
    if adhesion.preloads.size == 0:
        return True
    if not followed.turn:
        return False
    turn, largest = followed.states[followed.turn - 1], -followed.states["force"].min()
    goal = adhesion.preloads[k % adhesion.preloads.size]
    return turn["contact_area"] > 0 and turn["force"] >= goal - _PRELOAD_TOLERANCE * max(goal, largest)


def largest_pull(cycles: Cycles, k: int) -> float:
    """Return the pull-off force of a cycle, nN; NaN for one that broke off."""
    return events(cycles, k).get("pull_off_force", np.nan)


def pull_offs_of(cycles: Cycles) -> np.ndarray:
    """Return the pull-off forces of all cycles, nN."""
    return np.array([largest_pull(cycles, k) for k in range(len(cycles.paths))])


def _solved(place: Place, problem: Problem, adhesion: Adhesion, refine: int, *, fields: bool = False) -> Cycles:
    """Return the cycles at one place on one mesh."""
    problem = problem._replace(refine=refine)
    return cycles_on(surface_at(place, problem), problem, adhesion, fields=fields)


def cycles_on(
    surface: Surface, problem: Problem, adhesion: Adhesion, *, fields: bool = False, steepest_only: bool = False
) -> Cycles:
    """Return the cycles on one surface, on the mesh that it is given on; with the steepest edge only, or both."""
    edges = (1.0, 0.5) if adhesion.law in EDGED and adhesion.work > 0 and not steepest_only else (1.0,)
    laws = [law_on(adhesion, problem, steepness) for steepness in edges]
    paths, *wider = (_follow(surface, problem, adhesion, law, fields and law is laws[0]) for law in laws)
    return Cycles(surface, problem, paths, wider[0] if wider else [], adhesion.law)


def _follow(surface: Surface, problem: Problem, adhesion: Adhesion, law, fields: bool) -> list[path.Path]:
    """Return the paths of all cycles and preloads, in nm, nN and GPa."""
    paths = before = _cycle(surface, problem, adhesion, law, fields, adhesion.preloads, None)
    for _ in range(1, adhesion.cycles):
        loads = [adhesion.preloads[k : k + 1] for k in range(len(before))]
        before = [
            _cycle(surface, problem, adhesion, law, fields, load, last.residual_heights[-1])[0] if last.turn else last
            for load, last in zip(loads, before)
        ]
        paths = paths + before
    return [_in_units(followed, surface, problem) for followed in paths]


def _cycle(surface, problem, adhesion, law, fields, preloads, residual_height) -> list[path.Path]:
    """Return the paths up to each preload (nN) and back, on a surface with residual heights (nm) of earlier cycles."""
    hardness = displacement_control.Hardness(problem.hardness, problem.yielding)
    cap, limit = hardness.scaled(problem.dx / problem.contact_modulus)
    return path.follow_path(
        surface.separation,
        deltas_of(surface, problem, adhesion),
        adhesion.step,
        law,
        preloads=preloads / (problem.contact_modulus * problem.dx),
        max_cells=MOST_CELLS,
        fields=fields,
        cap=cap,
        limit=limit,
        residual_height=residual_height,
        from_contact=adhesion.law == "griffith" and adhesion.work > 0,
        capture=adhesion.capture,
    )


def _in_units(followed: path.Path, surface: Surface, problem: Problem) -> path.Path:
    """Return a path in nm, nN and GPa, its displacements counted from the datum of the result."""
    states, stiffness = followed.states.copy(), problem.contact_modulus * problem.dx
    for name in ("force", "energy", "dissipated"):
        states[name] *= stiffness
    for name in ("contact_area", "yielded_area", "plastic_work"):
        states[name] *= problem.dx**2
    states["plastic_work"] *= problem.hardness if problem.yielding else 0.0
    states["delta"] -= surface.zero
    pressures = followed.pressures * problem.contact_modulus / problem.dx
    return followed._replace(states=states, pressures=pressures)


def yielding_of(followed: path.Path, problem: Problem) -> dict[str, np.ndarray]:
    """Return the yielded shares of the states of a path, as far as a hardness is known."""
    if not np.isfinite(problem.hardness):
        return {}
    names = ("yielded_fraction", "yielded_area_fraction", *(("yielded_area", "plastic_work") * problem.yielding))
    return {name: followed.states[name] for name in names}


class Extrapolation(NamedTuple):
    """The way from two widths of an edge to an edge without width."""

    factor: float  # result = steep + factor × (steep − wide); 0 where the steeper edge's result is taken
    error: float  # relative error of the pull-off where it is not extrapolated; else 0

    def of(self, steep: Any, wide: Any) -> Any:
        """Return a quantity extrapolated from its values with the steeper and with the wider edge."""
        return steep + self.factor * (steep - wide) if self.factor else steep


def extrapolation(cycles: Cycles, k: int) -> Extrapolation:
    """Return the `Extrapolation` of a cycle by the pull-offs with both edges."""
    if not cycles.wider:
        return Extrapolation(0.0, 0.0)
    steep, wide = (_events(paths[k]) for paths in (cycles.paths, cycles.wider))
    pull = steep.get("pull_off_force", np.nan)
    change = (pull - wide.get("pull_off_force", np.nan)) / max(pull, 1e-300)
    return extrapolation_of(cycles.law, steep.get("pull_off_resolution", np.nan), change)


def extrapolation_of(law: str, radius: float, change: float) -> Extrapolation:
    """Return the `Extrapolation` where the steeper edge's pull-off exceeds the wider one's by a part ``change``.

    Richardson's extrapolation of an error c bⁿ in the width b of the edge. Without range half the steepness widens the
    edge by √2, hence a factor of 1/(2^{n/2} − 1). Dugdale's edge widens by 2, hence 1/(2ⁿ − 1). Spheres of many cells
    give n = 1.8 and 1.6. Without range few cells add a part over the radius, which is fitted (``_EXTRAPOLATION``).
    """
    if change > 0 and law == "griffith":  # as at a rim that cannot move
        return Extrapolation(0.0, _RIM_ERROR * change)
    if abs(change) > _LARGEST_DIFFERENCE:
        return Extrapolation(0.0, abs(change))
    constant, over_radius = _EXTRAPOLATION[law]
    factor = constant + over_radius / max(radius, LEAST_RADIUS) if radius > 0 else constant
    if factor * abs(change) > _LARGEST_CORRECTION:
        factor = max(constant, _LARGEST_CORRECTION / abs(change))
    return Extrapolation(factor, 0.0)


def events(cycles: Cycles, k: int) -> dict[str, float]:
    """Return snap-in, pull-off, work of separation and so on; empty for a path that broke off or never touched."""
    steep = _events(cycles.paths[k])
    if not cycles.wider or not steep:
        return steep
    wide = _events(cycles.wider[k])
    if not wide:
        return {}
    to_edge = extrapolation(cycles, k)
    out = {name: to_edge.of(value, wide[name]) for name, value in steep.items()}
    out |= {name: max(out[name], 0.0) for name in ("snap_in_force", "pull_off_force")}
    return out | {"pull_off_resolution": steep["pull_off_resolution"]}


def _events(followed: path.Path) -> dict[str, float]:
    """Return the events of one path: missing where a state that they depend on has not converged."""
    states, retraction = followed.states, followed.states[followed.turn :]
    touching = states["contact_area"] > 0
    if followed.status != path.CONVERGED or not touching.any():
        return {}
    lowest = followed.turn + int(np.argmin(retraction["force"]))
    first, last = int(np.argmax(touching)), len(touching) - 1 - int(np.argmax(touching[::-1]))
    delta, force, fine = states["delta"], states["force"], states["converged"]
    values = {
        "snap_in_force": (max(-force[first], 0.0), fine[first]),
        "snap_in_delta": (delta[first], fine[first]),
        "pull_off_force": (max(-force[lowest], 0.0), fine[lowest]),
        "pull_off_delta": (delta[lowest], fine[lowest]),
        "detachment_delta": (delta[touching].min() if last >= followed.turn else np.nan, fine[last]),
        "work_of_separation": (_work(np.minimum(retraction["force"], 0.0), retraction["delta"]), fine.all()),
        "hysteresis": (_work(force, delta), fine.all()),
        "pull_off_resolution": (states["resolution"][lowest], True),
    }
    return {name: value if known else np.nan for name, (value, known) in values.items()}


def _work(force: np.ndarray, delta: np.ndarray) -> float:
    """Return the work of a force along a path, nN nm."""
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(delta)))
