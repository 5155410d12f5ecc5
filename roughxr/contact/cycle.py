"""Cycles of approach and retraction at one contact centre: the choice of the mesh, and the errors of the pull-off.

All laws are followed by Newton's method (``kernels.adhesion.path``), which needs a traction whose slope the mesh
resolves. Laws with an edge, JKR's limit (all tension at contact) and Dugdale's, are solved with the steepest
edge that the mesh resolves, and with half that slope; both results are extrapolated (`edge_extrapolation`). The cells
are halved until two successive meshes agree on the pull-off.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..bodies.liquid import Menisci
from ..kernels.adhesion import path as path
from ..kernels.adhesion import traction_laws
from ..kernels.halfspace import displacement_control
from ..vocabulary.adhesion_laws import ADHESION_LAWS, DUGDALE, EXPONENTIAL, JKR
from .problem import Place, Problem, Surface, surface_at

#: Largest slope |dt/du| of the traction at an edge, over E*/dx; the wider edge has half of it.
_EDGE_SLOPE = 0.25

#: Least width of the edge of condensed liquid, over its height, at the same work. Changes the wetted area by 0.1 %.
_LIQUID_EDGE = 0.25

#: Extrapolation factor, result = steep + factor × (steep − wide): a constant, plus a number over the radius, in cells,
#: of the smallest contact at pull-off. Smooth spheres then have JKR's pull-off, on the mean of sixteen positions on the
#: pixels, within 0.6 % from 2.5 to 40 cells in radius (``tests/benchmarks/without_range.py``).
_EXTRAPOLATION = {JKR: (1.15, 6.4), DUGDALE: (0.5, 0.0)}

#: Largest relative correction of the steeper edge's pull-off, more than that of any sphere. Beyond it the second number
#: is dropped: edges then differ by more than their width explains, as at a summit that touches with one of them.
_LARGEST_CORRECTION = 0.15

#: Pull-offs that differ by more than this part belong to different contacts: the steeper edge's result is taken.
_LARGEST_DIFFERENCE = 0.3

#: Stated error, over the difference of both edges, if the steeper edge has the larger pull-off. Flat punches are off by
#: 1.5 to 1.7 times the difference at ten and twenty cells in radius, flattened asperities by less than half of it.
_RIM_ERROR = 2.0

#: Largest part of the error of a pull-off without range that remains on cells of half the side. At edges that cannot
#: move, the error falls as the root of the side, to 0.71. The sum of all further changes is then up to 3 times the last
#: change, and stated as the error. ``tests/benchmarks/stated_error.py`` counts the places that this covers.
_LEFT = 0.75

#: Change of a pull-off by pressing, over the pull-off, beyond which both are the ends of a range: no error by itself.
LARGEST_SETTLING = 0.5

#: Least stated error without range: the mean error of smooth spheres.
_LEAST_ERROR = 0.006

#: The refinements that refine="auto" may choose, and the largest number of meshes at a place: a fifth would cost four
#: times as much as the others together.
REFINEMENTS, _MOST_MESHES = (1, 2, 4, 8, 16), 4

#: Sides of cells (nm) among which the largest is chosen on a layer.
_CELLS = np.geomspace(1e-3, 1e4, 701)

#: Least radius (cells) of a resolved contact at pull-off.
LEAST_RADIUS = 2.0

#: Root mean square of the relative error of a mesh without range, times the square of the radius (cells) of the
#: smallest contact at pull-off: spheres of 1.5 to 14 cells (``tests/benchmarks/without_range.py``). A single mesh
#: states three times as much. Two meshes state it as well, since they may agree by chance.
_MESH_ERROR, _DEVIATIONS = 0.5, 3.0

#: Relative error without range on a film that changes the contact, times the film's thickness in cells: the width of
#: the cohesive zone must be small beside the thickness. Smooth spheres on films of 2 to 20 cells are off by 0.1 of it
#: over the thickness if compressible, by 0.2 if not (``tests/benchmarks/without_range.py``).
_FILM_ERROR = 0.2

#: Largest number of cells within the range of adhesion.
MOST_CELLS = 10**6

#: Work of separation in place of zero, nm².
_NO_WORK = 1e-12

#: Tolerance of a reached preload, as a part of the preload or of the largest tension.
_PRELOAD_TOLERANCE = 0.02


class Adhesion(NamedTuple):
    """Law of adhesion, loading, and accuracy of the pull-off."""

    work: float  # J/m²
    law: str
    length: float  # nm, see `ADHESION_LAWS`; NaN without range
    preloads: np.ndarray  # nN, ascending; empty where the indenter turns back at the last displacement
    refine: int  # 0: refine until ``accuracy`` is met
    accuracy: float  # NaN: take the first mesh, without an estimate of its error
    step: float  # nm
    cycles: int = 1  # at each place, each on the shape left by the cycle before
    liquid: Menisci | None = None  # condensed between the bodies; ``work`` is then that of the solids outside it
    first_cell: float = np.inf  # nm, of the coarsest mesh of "auto" with an accuracy, or without range
    capture: float = 0.0  # nm, gap at which the pair's attraction snaps surfaces together; without range only

    @property
    def whole_work(self) -> float:
        """The whole work to separate the bodies, that of liquid included, J/m²."""
        return self.work + (self.liquid.work if self.liquid else 0.0)

    @property
    def main_range(self) -> float:
        """The range of most of the attraction, nm: that of the liquid if there is any."""
        return self.liquid.height if self.liquid else self.length

    @property
    def largest_tension(self) -> float:
        """The largest tension of a law with a range, GPa."""
        return self.work / self.length + (self.liquid.capillary_pressure if self.liquid else 0.0)


def law_on_cells(adhesion: Adhesion, problem: Problem, steepness: float = 1.0) -> traction_laws.SmoothLaw:
    """Return the law on unit cells of unit modulus; ``steepness`` is the slope of an edge over the mesh's largest."""
    per_unit = problem.dx / problem.contact_modulus
    slope = _EDGE_SLOPE * (problem.film.stiffness if problem.film else 1.0)
    w = adhesion.work * per_unit
    if adhesion.liquid is not None:
        return _law_with_liquid(w, adhesion.length, adhesion.liquid, per_unit, slope)
    if w == 0:
        return traction_laws.smooth_law(exponential=(_NO_WORK, 1.0))
    return traction_laws.LAWS[adhesion.law](w, adhesion.length, slope * steepness)


def _law_with_liquid(w: float, length: float, liquid: Menisci, per_unit: float, slope) -> traction_laws.SmoothLaw:
    """Return the sum of the solids' and the liquid's tractions, the liquid's edge as steep as the mesh resolves."""
    tension, height = liquid.capillary_pressure * per_unit, liquid.height
    width = np.clip(2.0 * tension / slope, _LIQUID_EDGE * height, 3.0 * height)
    solids = {EXPONENTIAL: (w, length)} if w > 0 else {}
    return traction_laws.smooth_law(step=traction_laws.widened_step(tension, height, width), **solids)


def interaction_range(adhesion: Adhesion, problem: Problem) -> float:
    """Return the gap (nm) beyond which the traction is 0."""
    return law_on_cells(adhesion, problem, 0.5).range


class Cycles(NamedTuple):
    """The paths of one surface, one for each cycle and preload, in nm and nN, with the surface and its mesh."""

    surface: Surface
    problem: Problem
    paths: list[path.Path]
    wider: list[path.Path]  # of a law with an edge, with the wider edge; else empty
    law: str


def cycles_at(place: Place, problem: Problem, adhesion: Adhesion, *, fields: bool) -> tuple[Cycles, dict]:
    """Return the cycles at one place, on a mesh that meets the accuracy, and the errors of their pull-offs."""
    if adhesion.refine:
        pressures = path.AT_DISPLACEMENTS if fields else None
        cycles = _solved(place, problem, adhesion, adhesion.refine, fields=pressures)
        pressed = _pressed_pull_offs(place, problem, adhesion, cycles)
        error = _with_settling(_single_mesh_error(cycles), cycles, pressed, adhesion)
        return cycles, {"refinement": adhesion.refine, "pressed_pull_off_force": pressed, "pull_off_error": error}
    return _refined_until_accurate(place, problem, adhesion)


def _refined_until_accurate(place: Place, problem: Problem, adhesion: Adhesion) -> tuple[Cycles, dict]:
    """Halve the cells until the pull-off changes by less than the accuracy, or there are too many cells.

    The change from one mesh to the next is the error of the finer mesh: an upper bound if the meshes converge at first
    order or better. Without range more is stated, `_slow_error`. The error of the step is the change between the step
    and twice the step on the coarsest mesh; if it is large, finer meshes take half the step.
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
    n, mesh_error, slow = meshes[0], _single_mesh_error(cycles), _slow_error(cycles)
    if not meshes[1:] and n > 1:  # cells too large for the law give an upper bound
        mesh_error = _change(_solved(place, problem, adhesion, n // 2), cycles)
        slow = _slow_error(cycles, mesh_error)
    for n in meshes[1:]:
        before, cycles = cycles, _solved(place, problem, adhesion, n)
        # two edges may agree by chance: half the error of the coarser mesh is a lower bound
        edge_errors = np.fmax(_edge_errors(cycles), _edge_errors(before) / _RIM_ERROR)
        change = _change(before, cycles)
        lost = np.isnan(change) & (pull_off_forces(cycles) > 0)  # the mesh before gave no pull-off
        radius_errors = np.fmax(_radius_errors(cycles), _film_errors(cycles))
        mesh_error = np.where(lost, np.nan, np.fmax.reduce([change, edge_errors, radius_errors]))
        slow = np.fmax(_slow_error(cycles, change), _LEFT * slow)
        spline_change = _change_by_splines(place, problem, adhesion, cycles) if spline_change is None else spline_change
        if (mesh_error < adhesion.accuracy)[np.isfinite(mesh_error)].all() and not lost.any():
            break
    errors = {"mesh_error": mesh_error, "step_error": step_error}
    errors["interpolation_error"] = 0.0 * mesh_error if spline_change is None else spline_change
    pressed = _pressed_pull_offs(place, problem, adhesion, cycles)
    stated = errors | {"mesh_error": np.maximum(mesh_error, slow)}
    numerical = np.sqrt(sum(error**2 for error in stated.values()))
    errors["pull_off_error"] = _with_settling(numerical, cycles, pressed, adhesion)
    return cycles, {"refinement": n, "pressed_pull_off_force": pressed, **errors}


def _slow_error(cycles: Cycles, change: Any = 0.0) -> Any:
    """Return the error without range by a change from larger cells, or from the wider edge, that goes on slowly.

    Changes beyond `_LARGEST_DIFFERENCE` belong to different contacts and are left out.
    """
    if not cycles.wider or cycles.law != JKR:
        return 0.0
    steep, wide = (pull_off_forces(cycles._replace(paths=paths, wider=[])) for paths in (cycles.paths, cycles.wider))
    rises = 1 - wide / np.where(steep > 0, steep, np.nan)
    return np.maximum(np.maximum(_further_changes(rises), _further_changes(change)), _LEAST_ERROR)


def coarser_mesh_error(change: np.ndarray, law: str | None) -> np.ndarray:
    """Return the error of the coarser of two meshes by the relative change: without range the changes go on slowly."""
    if law != JKR:
        return change
    return np.maximum(change + _further_changes(change), _LEAST_ERROR)


def _further_changes(change: Any) -> Any:
    """Return the sum of all changes that follow one of a slow series; 0 after one that is not part of it."""
    return np.where((change > 0) & (change <= _LARGEST_DIFFERENCE), change, 0.0) * _LEFT / (1 - _LEFT)


def _change_by_splines(place: Place, problem: Problem, adhesion: Adhesion, cycles: Cycles) -> np.ndarray | None:
    """Return the change of the pull-off if heights are interpolated by splines; None if cells are pixels."""
    refine = cycles.problem.refine
    if refine == 1:
        return None
    return _change(_solved(place, problem._replace(splined=True), adhesion, refine), cycles)


def _pressed_pull_offs(place: Place, problem: Problem, adhesion: Adhesion, cycles: Cycles) -> np.ndarray:
    """Return each pull-off (nN) after the sphere was pressed as hard as it holds; NaN where that is not solved.

    A law without range closes gaps up to `snap_in_gap` only, a preload the others. The sphere may then hold more than
    the preload, and is pressed again.
    """
    pulls = pull_off_forces(cycles)
    if not _is_pressed(adhesion):
        return np.full(pulls.size, np.nan)
    wide = pull_off_forces(cycles._replace(paths=cycles.wider, wider=[]))  # may settle on more summits
    load, pressed = 0.0, np.nanmax(np.append(pulls, wide), initial=0.0)
    light = np.resize(adhesion.preloads, pulls.size) < pressed
    while light.any() and pressed > (1 + LARGEST_SETTLING) * load:
        load = pressed
        harder = adhesion._replace(preloads=np.array([load]), cycles=1)
        pressed = pull_off_force(_solved(place, problem, harder, cycles.problem.refine), 0)
    return np.where(light, pressed, pulls)


def _is_pressed(adhesion: Adhesion) -> bool:
    """Return whether places are solved once more after the sphere was pressed."""
    return adhesion.law == JKR and not np.isnan(adhesion.accuracy) and adhesion.preloads.size > 0


def _with_settling(errors: np.ndarray, cycles: Cycles, pressed: np.ndarray, adhesion: Adhesion) -> np.ndarray:
    """Return the errors of pull-offs with their changes by pressing, except for ranges; NaN if these are not known.

    Larger errors of a range belong to other contacts, which the range includes.
    """
    if not _is_pressed(adhesion):
        return errors
    changes = settling_changes(pull_off_forces(cycles), pressed)
    return np.where(changes > LARGEST_SETTLING, np.minimum(errors, LARGEST_SETTLING), np.hypot(errors, changes))


def settling_changes(pulls: Any, pressed: Any) -> Any:
    """Return the relative changes of pull-offs by pressing; 0 where nothing adheres."""
    return np.abs(pressed - pulls) / np.where(pulls > 0, pulls, np.inf)


def _contact_radii(cycles: Cycles) -> np.ndarray:
    """Return the radii (cells) of the smallest contacts at pull-off."""
    return np.array([events(cycles, k).get("pull_off_resolution", np.nan) for k in range(len(cycles.paths))])


def _radius_errors(cycles: Cycles) -> np.ndarray:
    """Return the usual error of the mesh for the radii of the contacts at pull-off."""
    return _MESH_ERROR / _contact_radii(cycles) ** 2


def _film_errors(cycles: Cycles) -> np.ndarray:
    """Return the error of a law with an edge on a film of few cells, as far as the film changes the contact."""
    film, radii = cycles.problem.film, _contact_radii(cycles)
    if film is None or not cycles.wider:
        return 0.0 * radii
    softening = film.softening(radii)
    return _FILM_ERROR / film.thickness * np.abs(1.0 - softening) / np.maximum(1.0, softening)


def _edge_errors(cycles: Cycles) -> np.ndarray:
    return np.array([extrapolation(cycles, k).error for k in range(len(cycles.paths))])


def _single_mesh_error(cycles: Cycles) -> np.ndarray:
    """Return the stated errors of pull-offs by a law with an edge, NaN for a law without."""
    if not cycles.wider:
        return np.full(len(cycles.paths), np.nan)
    pulls, steep = pull_off_forces(cycles), pull_off_forces(cycles._replace(wider=[]))
    radius_errors = np.fmax(_DEVIATIONS * _radius_errors(cycles), _film_errors(cycles))
    errors = np.fmax(np.fmax(_edge_errors(cycles), _slow_error(cycles)), radius_errors)
    with np.errstate(invalid="ignore", divide="ignore"):
        limited = np.abs(pulls - steep) > 0.99 * _LARGEST_CORRECTION * steep  # edges differ by more than their width
        return errors + np.where(limited | (cycles.law == DUGDALE), np.abs(pulls - steep) / pulls, 0.0)


def _first_refinement(problem: Problem, adhesion: Adhesion) -> int:
    cell = resolving_cell(adhesion, problem)
    if np.isfinite(adhesion.accuracy):  # on pixels wider than the contacts, two meshes would agree by chance
        cell = min(cell, adhesion.first_cell)
    return next((n for n in REFINEMENTS if problem.pixel / n <= cell), REFINEMENTS[-2])


def resolving_cell(adhesion: Adhesion, problem: Problem) -> float:
    """Return the largest cells (nm) on which adhesion can be solved."""
    cell, liquid = largest_cell(adhesion, problem), adhesion.liquid
    cell = min(cell, adhesion.first_cell) if np.isinf(cell) else cell
    if liquid is None:
        return cell
    # an edge as wide as the liquid is high
    return min(cell, 0.5 * _EDGE_SLOPE * problem.softest * liquid.height / liquid.capillary_pressure)


def largest_cell(adhesion: Adhesion, problem: Problem) -> float:
    """Return the largest cells (nm) that are stiffer than the slope of the traction; inf without range."""
    law = ADHESION_LAWS[adhesion.law]
    if not law.has_range or adhesion.work == 0:
        return np.inf
    largest = law.largest_cell * problem.contact_modulus * adhesion.length**2 / adhesion.work
    if problem.layer is None:
        return largest
    softening = problem.layer.softening(0.5 * _CELLS)  # of cells as contacts of half their side
    stiff = np.flatnonzero(_CELLS * softening <= largest)
    return largest / softening[stiff[-1] if stiff.size else 0]


def overlapping_cells(surface: Surface, problem: Problem, adhesion: Adhesion) -> int:
    """Return the number of cells within the law's range at the largest displacement."""
    within = prescribed_deltas(surface, problem, adhesion)[-1] + interaction_range(adhesion, problem)
    return int(np.count_nonzero(surface.separation < within))


def _change(cycles: Cycles, reference: Cycles) -> np.ndarray:
    """Return the relative difference of the pull-offs of two meshes; NaN where the reference does not adhere."""
    pulls, expected = pull_off_forces(cycles), pull_off_forces(reference)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(expected > 0, np.abs(pulls - expected) / expected, np.nan)


def prescribed_deltas(surface: Surface, problem: Problem, adhesion: Adhesion) -> np.ndarray:
    """Return the prescribed displacements, nm below the datum; with a preload they count from first contact."""
    return problem.steps + (surface.separation.min() if adhesion.preloads.size else surface.zero)


def largest_displacement(followed: path.Path, cycles: Cycles) -> float:
    """Return the largest displacement of a cycle, nm below the datum."""
    return cycles.surface.zero + (followed.states["delta"][followed.turn - 1] if followed.turn else -np.inf)


def reached(followed: path.Path, adhesion: Adhesion, k: int) -> bool:
    """Return whether a cycle turned back at its preload, and not at the largest depth."""
    if adhesion.preloads.size == 0:
        return True
    if not followed.turn:
        return False
    turn, largest = followed.states[followed.turn - 1], -followed.states["force"].min()
    goal = adhesion.preloads[k % adhesion.preloads.size]
    return turn["contact_area"] > 0 and turn["force"] >= goal - _PRELOAD_TOLERANCE * max(goal, largest)


def pull_off_force(cycles: Cycles, k: int) -> float:
    """Return the pull-off force of a cycle, nN; NaN for a broken path."""
    return events(cycles, k).get("pull_off_force", np.nan)


def pull_off_forces(cycles: Cycles) -> np.ndarray:
    """Return the pull-off forces of all cycles, nN."""
    return np.array([pull_off_force(cycles, k) for k in range(len(cycles.paths))])


def _solved(place: Place, problem: Problem, adhesion: Adhesion, refine: int, *, fields: str | None = None) -> Cycles:
    """Return the cycles at one place on one mesh."""
    problem = problem._replace(refine=refine)
    return cycles_on(surface_at(place, problem), problem, adhesion, fields=fields)


def cycles_on(
    surface: Surface, problem: Problem, adhesion: Adhesion, *, fields: str | None = None, steepest_only: bool = False
) -> Cycles:
    """Return the cycles on a surface and its mesh; with both edges, or the steepest only."""
    edges = (1.0, 0.5) if ADHESION_LAWS[adhesion.law].has_edge and adhesion.work > 0 and not steepest_only else (1.0,)
    laws = [law_on_cells(adhesion, problem, steepness) for steepness in edges]
    paths, *wider = (_follow(surface, problem, adhesion, law, fields if law is laws[0] else None) for law in laws)
    return Cycles(surface, problem, paths, wider[0] if wider else [], adhesion.law)


def _follow(surface: Surface, problem: Problem, adhesion: Adhesion, law, fields: str | None) -> list[path.Path]:
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
        prescribed_deltas(surface, problem, adhesion),
        adhesion.step,
        law,
        preloads=preloads / (problem.contact_modulus * problem.dx),
        max_cells=MOST_CELLS,
        fields=fields,
        cap=cap,
        limit=limit,
        residual_height=residual_height,
        from_contact=adhesion.law == JKR and adhesion.work > 0,
        capture=adhesion.capture,
        film=problem.film,
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


def yielded_shares(followed: path.Path, problem: Problem) -> dict[str, np.ndarray]:
    """Return the yielded shares of the states of a path, if a hardness is known."""
    if not np.isfinite(problem.hardness):
        return {}
    names = ("yielded_fraction", "yielded_area_fraction", *(("yielded_area", "plastic_work") * problem.yielding))
    return {name: followed.states[name] for name in names}


class Extrapolation(NamedTuple):
    """Extrapolation from two widths of an edge to width 0: result = steep + factor × (steep − wide)."""

    factor: float  # 0: the steeper edge's result is taken
    error: float  # relative error of a pull-off that is not extrapolated; else 0

    def apply(self, steep: Any, wide: Any) -> Any:
        """Return a quantity extrapolated from its values with the steeper and with the wider edge."""
        return steep + self.factor * (steep - wide) if self.factor else steep


def extrapolation(cycles: Cycles, k: int) -> Extrapolation:
    """Return the `Extrapolation` of a cycle by the pull-offs with both edges."""
    if not cycles.wider:
        return Extrapolation(0.0, 0.0)
    steep, wide = (_events(paths[k]) for paths in (cycles.paths, cycles.wider))
    pull = steep.get("pull_off_force", np.nan)
    change = (pull - wide.get("pull_off_force", np.nan)) / max(pull, 1e-300)
    return edge_extrapolation(cycles.law, steep.get("pull_off_resolution", np.nan), change)


def edge_extrapolation(law: str, radius: float, change: float) -> Extrapolation:
    """Return the `Extrapolation` for a relative excess ``change`` of the steeper edge's pull-off over the wider edge's.

    Richardson's extrapolation of an error c bⁿ in the width b of the edge. Without range half the slope widens the edge
    by √2, hence a factor of 1/(2^{n/2} − 1). Dugdale's edge widens by 2, hence 1/(2ⁿ − 1). Spheres of many cells give
    n = 1.8 and 1.6. Without range, few cells add a number over the radius, which is fitted (``_EXTRAPOLATION``).
    """
    if change > 0 and law == JKR:  # as at a rim that cannot move
        return Extrapolation(0.0, _RIM_ERROR * change)
    if abs(change) > _LARGEST_DIFFERENCE:
        return Extrapolation(0.0, abs(change))
    constant, over_radius = _EXTRAPOLATION[law]
    factor = constant + over_radius / max(radius, LEAST_RADIUS) if radius > 0 else constant
    if factor * abs(change) > _LARGEST_CORRECTION:
        factor = max(constant, _LARGEST_CORRECTION / abs(change))
    return Extrapolation(factor, 0.0)


def events(cycles: Cycles, k: int) -> dict[str, float]:
    """Return snap-in, pull-off, work of separation etc. of a cycle; empty for a broken path or without contact."""
    steep = _events(cycles.paths[k])
    if not cycles.wider or not steep:
        return steep
    wide = _events(cycles.wider[k])
    if not wide:
        return {}
    extrapolated = extrapolation(cycles, k)
    out = {name: extrapolated.apply(value, wide[name]) for name, value in steep.items()}
    out |= {name: max(out[name], 0.0) for name in ("snap_in_force", "pull_off_force")}
    return out | {"pull_off_resolution": steep["pull_off_resolution"]}


def _events(followed: path.Path) -> dict[str, float]:
    """Return the events of one path; NaN if a state that they depend on has not converged."""
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
