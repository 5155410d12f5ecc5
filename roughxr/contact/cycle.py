"""Cycles of approach and retraction at one contact centre: the choice of solver and of mesh.

All laws are followed by Newton's method (``kernels.adhesion.smooth_path``), for which the traction must not fall off
more steeply than a mesh can bear. Laws with an edge, the Griffith limit (all pull at contact) and Dugdale's, are given
the steepest edge that it bears, and one half as steep; what both find is extrapolated to the edge itself
(`_EXTRAPOLATION`). The cells are halved until two meshes in a row agree on the pull-off.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..bodies.liquid import Menisci
from ..kernels.adhesion import path as path
from ..kernels.adhesion import traction_laws as smooth_laws
from ..kernels.halfspace import displacement_control
from ..kernels.halfspace.products import coefficients_for
from .problem import Place, Problem, Surface, surface_at

#: Laws with an edge, which are extrapolated.
EDGED = ("griffith", "dugdale")

#: Largest fall of the traction with the gap at an edge, over E*/dx; the second edge has half of it.
_EDGE_SLOPE = 0.25

#: Width of the edge of condensed liquid, at least, in its height; the law's work is kept. By it the wetted area is off
#: by some 1e-3.
_LIQUID_EDGE = 0.25

#: What the two edges differ by, times this, is added to what the steeper one gives: a constant, and a part over the
#: radius, in cells, of the smallest contact at pull-off. With it smooth spheres meet JKR's pull-off, on the mean of
#: sixteen places on the pixels, within 0.6 % from 2.5 to 40 cells in radius (``tests/benchmarks/without_range.py``).
_EXTRAPOLATION = {"griffith": (1.15, 6.4), "dugdale": (0.5, 0.0)}

#: Where `_EXTRAPOLATION` takes off more than this part of the steeper edge's pull-off, more than from any sphere, both
#: edges differ by more than their width explains (a summit that only one holds): then this part, or the constant alone.
_LARGEST_CORRECTION = 0.15

#: The refinements that refine="auto" may choose.
REFINEMENTS = (1, 2, 4, 8, 16)

#: The largest cell on which a law with a range can be solved. The cell must resist more than the traction falls off:
#: w/ρ² < E*/dx times this. On larger cells the edge of a contact jumps from cell to cell, which overestimates the
#: pull-off (on the glass twin by 4 to 7 times at w dx/(E* ρ²) = 3.7, some per cent at 0.9 and 0.5). Laws without range
#: start with cells of 5 nm or less, of soft bodies of a twentieth of JKR's radius a_c.
_SOFTENING, FIRST_CELL = 1.0, 5.0

#: Contacts of fewer cells in radius than this at pull-off are not taken as resolved. JKR's sphere is off by 6 % in the
#: mean square where it has two and a half cells, 1.4 % at five, 0.3 % at ten and 0.2 % at twenty
#: (``tests/benchmarks/without_range.py``).
LEAST_RADIUS = 2.0

#: Over the square of the radius, in cells, of the smallest contact at pull-off: the least error that two meshes state,
#: about what they are off by on spheres of that radius, on which they may agree by chance.
_LEAST_MESH_ERROR = 0.5

#: Largest number of cells within the range of adhesion.
MOST_CELLS = 10**6

#: Largest number of meshes on which a place is solved.
_MOST_MESHES = 4

#: Where pull-offs differ by more than this part, both edges found different contacts, and the steeper is taken as it
#: is: a summit more or less is touched.
_LARGEST_DIFFERENCE = 0.3

#: Without range the steeper edge is also taken as it is where it pulls more than the wider one, as a contact does whose
#: rim cannot move. What both differ by, times this, is its stated error: flat punches are off by 1.5 to 1.7 times it
#: at ten and twenty cells in radius, asperities pressed flat by less than half of it.
_RIM_ERROR = 2.0

#: A single mesh states as error what is taken off the steeper edge's pull-off, and this over the radius of the smallest
#: contact in cells. Of rough places on meshes that are two to eight times as coarse as the finest, nine in ten are off
#: by less; smooth spheres by less than half of it (``tests/benchmarks/without_range.py``).
_SINGLE_MESH_ERROR = 0.7

#: Work of separation that stands for none, nm².
_NO_WORK = 1e-12

#: Events that are not extrapolated.
_MESH_ONLY = ("pull_off_resolution",)

#: A preload counts as reached within this part of it, or of the largest pull.
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
    liquid: Menisci | None = None  # what condenses between the bodies; ``work`` is then that of the solids beside it
    first_cell: float = FIRST_CELL  # nm, of the coarsest mesh that "auto" takes without range
    capture: float = 0.0  # nm, gap at which the pair's attraction snaps surfaces together; of "griffith" only

    @property
    def whole(self) -> float:
        """The whole work to part the bodies, that of liquid included, J/m²."""
        return self.work + (self.liquid.work if self.liquid else 0.0)

    @property
    def span(self) -> float:
        """The range over which most of it pulls, nm: that of liquid where there is any."""
        return self.liquid.height if self.liquid else self.length

    @property
    def peak(self) -> float:
        """The largest pull of a law with a range, GPa."""
        return self.work / self.length + (self.liquid.pull if self.liquid else 0.0)


def law_on(adhesion: Adhesion, problem: Problem, steepness: float = 1.0) -> smooth_laws.SmoothLaw:
    """Return the law on unit cells of unit modulus; an edge has this part of the steepness that the mesh bears."""
    per_unit = problem.dx / problem.contact_modulus
    w, length = adhesion.work * per_unit, adhesion.length
    if adhesion.liquid is not None:
        return _law_with_liquid(w, length, adhesion.liquid, per_unit)
    if w == 0:
        return smooth_laws.law_of(exponential=(_NO_WORK, 1.0))
    if adhesion.law == "exponential":
        return smooth_laws.law_of(exponential=(w, length))
    if adhesion.law == "lennard_jones":
        return smooth_laws.law_of(waals=(w, length))
    if adhesion.law == "griffith":
        return smooth_laws.without_range(w, _EDGE_SLOPE * steepness)
    return smooth_laws.dugdale(w, length, _EDGE_SLOPE * steepness)


def _law_with_liquid(w: float, length: float, liquid: Menisci, per_unit: float) -> smooth_laws.SmoothLaw:
    """Return the sum of the solids' pull and the liquid's, with an edge as steep as the mesh bears, or as need be."""
    pull, height = liquid.pull * per_unit, liquid.height
    wide = np.clip(2.0 * pull / _EDGE_SLOPE, _LIQUID_EDGE * height, 3.0 * height)
    solids = {"exponential": (w, length)} if w > 0 else {}
    return smooth_laws.law_of(step=smooth_laws.edged(pull, height, wide), **solids)


def reach_of_law(adhesion: Adhesion, problem: Problem) -> float:
    """Return the gap (nm) beyond which nothing pulls."""
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
        found = _cycles(place, problem, adhesion, adhesion.refine, fields=fields)
        settling = _settling_error(place, problem, adhesion, found)
        error = np.hypot(_error_of_one_mesh(found), settling)
        return found, {"refinement": adhesion.refine, "settling_error": settling, "pull_off_error": error}
    return _refined_until_accurate(place, problem, adhesion)


def _refined_until_accurate(place: Place, problem: Problem, adhesion: Adhesion) -> tuple[Cycles, dict]:
    """Halve the cells until the largest pull changes by less than the accuracy, or there are too many of them.

    The change from one mesh to the next is taken as the error of the finer one: an upper bound where the meshes
    converge at first order or better. The error of the step is the change between the step and twice the step on the
    coarsest mesh; where it is large, finer meshes take half the step. The error of what lies between the pixels is the
    change from a band-limited surface to splines on the first mesh that divides them.
    """
    pixels = overlapping_cells(surface_at(place, problem._replace(refine=1)), problem._replace(refine=1), adhesion)
    finest = max((n for n in REFINEMENTS if pixels * n**2 <= MOST_CELLS), default=1)
    first = min(_first_refinement(problem, adhesion), finest)
    meshes = [n for n in REFINEMENTS if first <= n <= finest][:_MOST_MESHES]
    before = _cycles(place, problem, adhesion, meshes[0])
    if np.isnan(adhesion.accuracy):
        return before, {"refinement": meshes[0]}
    of_step = _change(_cycles(place, problem, adhesion._replace(step=2 * adhesion.step), meshes[0]), before)
    between = _between_pixels(place, problem, adhesion, before)
    settling = _settling_error(place, problem, adhesion, before)
    if (of_step > 0.5 * adhesion.accuracy).any():  # longer steps pass over states that shorter ones find
        adhesion = adhesion._replace(step=0.5 * adhesion.step)
    found, n, of_mesh = before, meshes[0], np.full_like(of_step, np.nan)
    for finer in meshes[1:]:
        found = _cycles(place, problem, adhesion, finer)
        of_mesh, n = np.fmax(np.fmax(_change(before, found), _apart(found)), _unseen(found)), finer
        between = _between_pixels(place, problem, adhesion, found) if between is None else between
        if (of_mesh < adhesion.accuracy)[np.isfinite(of_mesh)].all():
            break
        before = found
    between = 0.0 * of_mesh if between is None else between
    errors = {"mesh_error": of_mesh, "step_error": of_step, "interpolation_error": between}
    errors |= {"settling_error": settling}
    errors["pull_off_error"] = np.sqrt(sum(error**2 for error in errors.values()))
    return found, {"refinement": n, **errors}


def _between_pixels(place: Place, problem: Problem, adhesion: Adhesion, found: Cycles) -> np.ndarray | None:
    """Return what splines between the pixels change; None on cells of a pixel, which have nothing between them."""
    refine = found.problem.refine
    if refine == 1:
        return None
    return _change(_cycles(place, problem._replace(splined=True), adhesion, refine), found)


def _settling_error(place: Place, problem: Problem, adhesion: Adhesion, found: Cycles) -> np.ndarray:
    """Return the relative change of each pull-off if the indenter is pressed on by the pull-off itself, or more.

    A law without range closes gaps up to one distance only (`snap_in_gap`); a preload closes what that may have missed.
    """
    pulls = np.array([largest_pull(found, k) for k in range(len(found.paths))])
    change, load = np.zeros(pulls.size), np.nanmax(pulls, initial=0.0)
    light = np.resize(adhesion.preloads, pulls.size) < load if adhesion.preloads.size else np.zeros(pulls.size, bool)
    if adhesion.law != "griffith" or np.isnan(adhesion.accuracy) or not light.any():
        return change
    pressed = adhesion._replace(preloads=np.array([load]), cycles=1)
    pull = largest_pull(_cycles(place, problem, pressed, found.problem.refine), 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(light & (pulls > 0), np.abs(pull - pulls) / pulls, change)


def _unseen(found: Cycles) -> np.ndarray:
    """Return the error of small contacts at pull-off, on which two meshes may agree by chance."""
    radii = [events(found, k).get("pull_off_resolution", np.nan) for k in range(len(found.paths))]
    return _LEAST_MESH_ERROR / np.array(radii) ** 2


def _error_of_one_mesh(found: Cycles) -> np.ndarray:
    """Return the stated errors of pull-offs by a law with an edge, NaN for one without."""
    told = [(events(found, k), _events(followed)) for k, followed in enumerate(found.paths)]
    if not found.wider:
        return np.full(len(told), np.nan)
    pulls, steeper, radii = (
        np.array([one[of].get(name, np.nan) for one in told])
        for of, name in ((0, "pull_off_force"), (1, "pull_off_force"), (1, "pull_off_resolution"))
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.fmax(np.abs(pulls - steeper) / pulls, _apart(found)) + _SINGLE_MESH_ERROR / radii


def _apart(found: Cycles) -> np.ndarray:
    return np.array([apart(found, k) for k in range(len(found.paths))])


def _first_refinement(problem: Problem, adhesion: Adhesion) -> int:
    cell = bearing_cell(adhesion, problem.contact_modulus)
    return next((n for n in REFINEMENTS if problem.pixel / n <= cell), REFINEMENTS[-2])


def bearing_cell(adhesion: Adhesion, modulus: float) -> float:
    """Return the largest cells (nm) on which adhesion holds between bodies of a modulus (GPa)."""
    cell, liquid = largest_cell(adhesion.law, adhesion.length, modulus, adhesion.work), adhesion.liquid
    cell = adhesion.first_cell if adhesion.law == "griffith" else cell
    if liquid is None:
        return cell
    return min(cell, 0.5 * _EDGE_SLOPE * modulus * liquid.height / liquid.pull)  # its edge is no wider than its height


def largest_cell(law: str, length: float, modulus: float, work: float) -> float:
    """Return the largest cells (nm) on which a law of this length (nm) holds; modulus in GPa, work in J/m²."""
    if law == "griffith" or work == 0:
        return FIRST_CELL
    bears = modulus * length**2 / work
    if law == "dugdale":  # so that the wider edge, too, leaves some of the step
        return 0.75 * _EDGE_SLOPE * bears
    return bears * (_SOFTENING if law == "exponential" else _SOFTENING / smooth_laws.WALL)


def overlapping_cells(surface: Surface, problem: Problem, adhesion: Adhesion) -> int:
    """Return the number of cells within reach of the law at the largest displacement."""
    within = deltas_of(surface, problem, adhesion)[-1] + reach_of_law(adhesion, problem)
    return int(np.count_nonzero(surface.separation < within))


def _change(one: Cycles, other: Cycles) -> np.ndarray:
    """Return the relative difference of the pull-offs of two meshes; NaN where neither pulls."""
    a, b = (np.array([largest_pull(found, k) for k in range(len(found.paths))]) for found in (one, other))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(b > 0, np.abs(a - b) / b, np.nan)


def deltas_of(surface: Surface, problem: Problem, adhesion: Adhesion) -> np.ndarray:
    """Return the prescribed displacements, nm below the datum; those up to a preload count from first contact."""
    return problem.steps + (surface.separation.min() if adhesion.preloads.size else surface.zero)


def deepest_of(followed: path.Path, found: Cycles) -> float:
    """Return the largest displacement of a cycle, nm below the datum."""
    return found.surface.zero + (followed.states["delta"][followed.turn - 1] if followed.turn else -np.inf)


def reached(followed: path.Path, adhesion: Adhesion, k: int) -> bool:
    """Return whether a cycle turned back at its preload, and not because loading was followed no deeper."""
    if adhesion.preloads.size == 0:
        return True
    if not followed.turn:
        return False
    turn, largest = followed.states[followed.turn - 1], -followed.states["force"].min()
    goal = adhesion.preloads[k % adhesion.preloads.size]
    return turn["contact_area"] > 0 and turn["force"] >= goal - _PRELOAD_TOLERANCE * max(goal, largest)


def largest_pull(found: Cycles, k: int) -> float:
    """Return the pull-off force of a cycle, nN; NaN for one that broke off."""
    return events(found, k).get("pull_off_force", np.nan)


def _cycles(place: Place, problem: Problem, adhesion: Adhesion, refine: int, *, fields: bool = False) -> Cycles:
    problem = problem._replace(refine=refine)
    return cycles_on(surface_at(place, problem), problem, adhesion, fields=fields)


def cycles_on(surface: Surface, problem: Problem, adhesion: Adhesion, *, fields: bool = False) -> Cycles:
    """Return the cycles on one surface, on the mesh that it is given on."""
    edges = (1.0, 0.5) if adhesion.law in EDGED and adhesion.work > 0 else (1.0,)
    laws = [law_on(adhesion, problem, steepness) for steepness in edges]
    paths, *wider = (_follow(surface, problem, adhesion, law, fields and law is laws[0]) for law in laws)
    return Cycles(surface, problem, paths, wider[0] if wider else [], adhesion.law)


def _follow(surface: Surface, problem: Problem, adhesion: Adhesion, law, fields: bool) -> list[path.Path]:
    """Return the paths of all cycles and preloads, in units."""
    found = before = _cycle(surface, problem, adhesion, law, fields, adhesion.preloads, None)
    for _ in range(1, adhesion.cycles):
        loads = [adhesion.preloads[k : k + 1] for k in range(len(before))]
        before = [
            _cycle(surface, problem, adhesion, law, fields, load, followed.left[-1])[0] if followed.turn else followed
            for load, followed in zip(loads, before)
        ]
        found = found + before
    return [_in_units(followed, surface, problem) for followed in found]


def _cycle(surface, problem, adhesion, law, fields, preloads, left) -> list[path.Path]:
    """Return the paths up to each preload (nN) and back, on a surface whose residual height is ``left`` (nm)."""
    cap, limit = _bounds(problem)
    return path.follow_smooth(
        surface.separation,
        deltas_of(surface, problem, adhesion),
        adhesion.step,
        coefficients_for(surface.separation.shape),
        law,
        preloads=preloads / (problem.contact_modulus * problem.dx),
        max_cells=MOST_CELLS,
        fields=fields,
        cap=cap,
        limit=limit,
        left=left,
        from_contact=adhesion.law == "griffith" and adhesion.work > 0,
        capture=adhesion.capture,
    )


def _bounds(problem: Problem) -> tuple[float, float]:
    """Return the largest pressure on unit cells of unit modulus, and the one that is told of."""
    per_unit = problem.dx / problem.contact_modulus
    return displacement_control.Hardness(problem.hardness, problem.yielding).scaled(per_unit)


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


def yield_told(followed: path.Path, problem: Problem) -> dict[str, np.ndarray]:
    """Return what the states of a path have yielded, as far as a hardness is known."""
    if not np.isfinite(problem.hardness):
        return {}
    names = ("yielded_fraction", "yielded_area_fraction", *(("yielded_area", "plastic_work") * problem.yielding))
    return {name: followed.states[name] for name in names}


def gain(found: Cycles, k: int) -> float:
    """Return how much of what two edges differ by is added to the steeper one's; 0 where that is taken as it is."""
    if apart(found, k) > 0.0:
        return 0.0
    radius = _events(found.paths[k]).get("pull_off_resolution", np.nan)
    return gain_at(found.law, radius, abs(_difference(found, k)))


def gain_at(law: str, radius: float, off: float) -> float:
    """Return the same at a radius in cells of the smallest contact, where both pull-offs differ by a part ``off``."""
    constant, over_radius = _EXTRAPOLATION[law]
    whole = constant + over_radius / max(radius, LEAST_RADIUS) if radius > 0 else constant
    return max(constant, _LARGEST_CORRECTION / off) if whole * off > _LARGEST_CORRECTION else whole


def sharper(value: Any, wide: Any, gain: float) -> Any:
    """Return a quantity extrapolated from its values with the steeper and with the wider edge."""
    return value + gain * (value - wide) if gain else value


def apart(found: Cycles, k: int) -> float:
    """Return the error of the steeper edge's pull-off where it is taken as it is; 0 where both are extrapolated."""
    if not found.wider:
        return 0.0
    change = _difference(found, k)
    if change > 0 and found.law == "griffith":
        return _RIM_ERROR * change
    return abs(change) if abs(change) > _LARGEST_DIFFERENCE else 0.0


def _difference(found: Cycles, k: int) -> float:
    """Return by what part of itself the steeper edge's pull-off exceeds the wider one's."""
    pull, wide = (_events(one[k]).get("pull_off_force", np.nan) for one in (found.paths, found.wider))
    return (pull - wide) / max(pull, 1e-300)


def events(found: Cycles, k: int) -> dict[str, float]:
    """Return snap-in, pull-off, work of separation and so on; empty for a path that broke off or never touched."""
    told = _events(found.paths[k])
    if not found.wider or not told:
        return told
    wide = _events(found.wider[k])
    if not wide:
        return {}
    least, added = {"snap_in_force": 0.0, "pull_off_force": 0.0}, gain(found, k)
    return {
        name: max(sharper(value, wide[name], added), least.get(name, -np.inf)) if name not in _MESH_ONLY else value
        for name, value in told.items()
    }


def _events(followed: path.Path) -> dict[str, float]:
    """Return the events of one path: missing where a state that they rest on has not converged."""
    states, back = followed.states, followed.states[followed.turn :]
    touching = states["contact_area"] > 0
    if followed.status != path.CONVERGED or not touching.any():
        return {}
    lowest = followed.turn + int(np.argmin(back["force"]))
    first, last = int(np.argmax(touching)), len(touching) - 1 - int(np.argmax(touching[::-1]))
    delta, force, fine = states["delta"], states["force"], states["converged"]
    told = {
        "snap_in_force": (max(-force[first], 0.0), fine[first]),
        "snap_in_delta": (delta[first], fine[first]),
        "pull_off_force": (max(-force[lowest], 0.0), fine[lowest]),
        "pull_off_delta": (delta[lowest], fine[lowest]),
        "detachment_delta": (delta[touching].min() if last >= followed.turn else np.nan, fine[last]),
        "work_of_separation": (_work(np.minimum(back["force"], 0.0), back["delta"]), fine.all()),
        "hysteresis": (_work(force, delta), fine.all()),
        "pull_off_resolution": (states["resolution"][lowest], True),
    }
    return {name: value if rests else np.nan for name, (value, rests) in told.items()}


def _work(force: np.ndarray, delta: np.ndarray) -> float:
    """Return the work of a force along a path, nN nm."""
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(delta)))
