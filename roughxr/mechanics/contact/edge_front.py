"""A soft contact as one region, by the front that bounds it (``kernels.adhesion.front``), in place of cells.

A place is solved on points along radii and angles about the middle of its contact. Their spacing follows the scan's
pixels. The pull-off is solved again with half the points, with twice the step and on heights that splines interpolate;
the changes are its errors. "auto" follows the front where cells would take longer than `_AFFORDABLE`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..kernels.adhesion import front
from ..kernels.topography.interpolation import heights_on_circles
from ..vocabulary.adhesion_laws import ADHESION_LAWS, JKR
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import Argument, Phrase
from .adhesion_on_cells import Adhesion
from .mesh import FRONT
from .pressing import LARGEST_SETTLING
from .problem import Place, Problem, Surface, cell_axes, surface_at
from .refinement import first_refinement, with_settling

#: Cells along a side of a pixel between which splines interpolate; without shorter wavelengths than two pixels.
_CELLS = 2

#: Points along a radius, and along the edge of JKR's contact, to a pixel.
_RADII = 2.0
_ANGLES = 1.0

#: Fewest and most angles, and most radii.
_FEWEST_ANGLES = 64
_MOST_ANGLES = 512
_MOST_RADII = 500

#: Step of the displacement, as a part of the length (π²w²R/E*²)^{1/3} of a sphere's retraction.
_STEP = 0.02

#: Largest radius of the points, over that of JKR's contact under the largest load.
_WINDOW = 1.7

#: Largest distance of the points' middle from that of the contact, over its radius, and most attempts.
_CENTRED = 0.1
_MOST_CENTRINGS = 4

#: Largest standard deviation of an edge's radius over its mean, and largest second order over w, of a valid edge.
_LARGEST_SPREAD = 0.3
_LARGEST_SECOND_ORDER = 0.15

#: Stated error over the second order, and least stated error, relative.
_SECOND_ORDER_ERROR = 1.0
_LEAST_ERROR = 0.006


#: Processor time (s) of a soft place on cells, over the root of the number of cells within reach on the second mesh:
#: 9 to 190 s on 9,000 to 200,000 cells, within a factor of 3 where one region touches a weak roughness. It was 4 s for
#: 40 s where single summits touch, and 345 s for 13 s on roughness whose flattening takes 0.45 w.
_SECONDS_ON_CELLS = 0.1

#: Processor time (s) of a place on cells, from which on "auto" follows the front, and from which on it leaves out
#: places whose front is not valid.
_AFFORDABLE = 5.0
_BEARABLE = 15.0

#: Relative change of the pull-off by finer cells, at places whose front is not valid, where none is stated.
_ACCURACY = 0.05


def seconds_on_cells(problem: Problem, adhesion: Adhesion) -> float:
    """Return about the processor time (s) of a soft place on cells."""
    side = 0.5 * problem.pixel / first_refinement(problem, adhesion)
    area = min(2 * np.pi * problem.indenter.radius * float(problem.steps[-1]), problem.shown)
    return _SECONDS_ON_CELLS * np.sqrt(area) / side


def with_front(problem: Problem, adhesion: Adhesion, *, fields: bool) -> Adhesion:
    """Return the solution by the front where "auto" takes it; raise if it is requested for what it does not solve."""
    obstacle = _obstacle(problem, adhesion, fields)
    if adhesion.by_front and obstacle:
        raise Refusal(
            Phrase(Argument("mesh", FRONT)),
            Phrase("a sphere on half spaces, ", Argument("law", JKR), " and a preload"),
            obstacle,
            Phrase("take ", Argument("mesh", "auto")),
        )
    is_automatic = np.isfinite(adhesion.tabor) and not (adhesion.refine or adhesion.by_front)
    if not is_automatic or obstacle or (seconds := seconds_on_cells(problem, adhesion)) < _AFFORDABLE:
        return adhesion
    accuracy = float(np.nan_to_num(adhesion.accuracy, nan=_ACCURACY))  # of the places on cells
    return adhesion._replace(by_front=True, on_cells=seconds < _BEARABLE, accuracy=accuracy)


def _obstacle(problem: Problem, adhesion: Adhesion, fields: bool) -> str:
    """Return what the front does not solve; empty if there is nothing."""
    obstacles = {
        f"law={adhesion.law!r}": ADHESION_LAWS[adhesion.law].has_range or not adhesion.work > 0,
        "displacements": not adhesion.preloads.size,
        "fields": fields,
        "an indenter's map": problem.indenter.map is not None,
        "a layer": problem.layer is not None,
        "a body that yields": problem.yielding,
        f"{adhesion.cycles} cycles": adhesion.cycles > 1,
        "moments of rolling": bool(adhesion.directions.size),
    }
    return next((name for name, is_present in obstacles.items() if is_present), "")


class Points(NamedTuple):
    """The points of a solution and the step of its displacement."""

    middle: tuple[float, float]  # of the contact, nm from the contact centre
    radius: float  # nm, largest
    spacing: float  # nm
    angles: int
    step: float  # nm

    @property
    def halved(self) -> Points:
        """Half as many points along radii and angles, and twice the step."""
        return self._replace(spacing=2 * self.spacing, angles=self.angles // 2, step=2 * self.step)


class Circles(NamedTuple):
    """The undeformed bodies at the points."""

    radii: np.ndarray  # nm
    separation: np.ndarray  # (radius, angle), nm
    slope: np.ndarray  # its derivative by the radius

    @property
    def halved(self) -> Circles:
        """The bodies at half as many points along radii and angles."""
        return Circles(self.radii[::2], self.separation[::2, ::2], self.slope[::2, ::2])


def circles_at(place: Place, problem: Problem, points: Points) -> Circles:
    """Return the bodies at the points about one place, by splines between the cells of a problem."""
    separation = surface_at(place, problem).separation
    separation = np.where(np.isfinite(separation), separation, separation[np.isfinite(separation)].max())
    radii = np.arange(0.0, points.radius, points.spacing)
    angles = 2 * np.pi * np.arange(points.angles) / points.angles
    return Circles(radii, *heights_on_circles(cell_axes(place, problem), separation, points.middle, radii, angles))


class Unfollowed(Exception):
    """The contact of a place is not followed as one region: it finds no rest, or reaches the ends of the points."""


class Cycle(NamedTuple):
    """The states of one cycle."""

    loading: list[front.State]
    retraction: list[front.State]

    @property
    def turn(self) -> front.State:
        """The state in which the sphere turns back."""
        return self.loading[-1]

    @property
    def until_pull_off(self) -> list[front.State]:
        """The states up to that of the largest tension."""
        forces = [state.force for state in (self.turn, *self.retraction)]
        return self.loading + self.retraction[: int(np.argmin(forces))]

    @property
    def pull_off(self) -> front.State:
        """The state of the largest tension."""
        return self.until_pull_off[-1]


class FrontCycles(NamedTuple):
    """The cycles of one place, one for each preload, in nm below the datum and nN."""

    surface: Surface
    points: Points
    cycles: list[Cycle]
    pressed: np.ndarray  # pull-offs after the sphere was pressed as hard as it holds, nN
    errors: dict[str, np.ndarray]  # of the pull-offs by points and step, and by interpolation; relative

    @property
    def pull_offs(self) -> np.ndarray:
        """The pull-off forces of all cycles, nN."""
        return _pull_offs(self.cycles)

    @property
    def pull_off_errors(self) -> np.ndarray:
        """The stated errors of the pull-offs without their changes by pressing, relative."""
        second_order = np.array([cycle.pull_off.second_order for cycle in self.cycles])
        squares = _LEAST_ERROR**2 + (_SECOND_ORDER_ERROR * second_order) ** 2
        return np.sqrt(squares + sum(error**2 for error in self.errors.values()))

    @property
    def is_valid(self) -> bool:
        """Whether edges are so near to circles, in all states up to the pull-offs, that the perturbation holds.

        An edge that once was farther from a circle may have jumped to another state than the perturbation's.
        """
        states = [state for cycle in self.cycles for state in cycle.until_pull_off]
        spread = max(float(state.radius.std() / state.radius.mean()) for state in states)
        return spread <= _LARGEST_SPREAD and max(state.second_order for state in states) <= _LARGEST_SECOND_ORDER


def valid_cycles(place: Place, problem: Problem, adhesion: Adhesion) -> FrontCycles | None:
    """Return the cycles of one place by its front; None where it is not to be followed, or they are not valid."""
    if not adhesion.by_front:
        return None
    try:
        cycles = front_cycles(place, problem, adhesion)
    except Unfollowed:
        return None
    return cycles if cycles.is_valid else None


def front_results(cycles: FrontCycles, problem: Problem, adhesion: Adhesion) -> list[dict[str, Any]]:
    """Return the results of each cycle by their names."""
    errors = with_settling(cycles.pull_off_errors, cycles.pull_offs, cycles.pressed, adhesion)
    results = []
    for k, cycle in enumerate(cycles.cycles):
        retraction = [cycle.turn, *cycle.retraction]
        delta, force = (np.array([getattr(state, name) for state in retraction]) for name in ("delta", "force"))
        approach = [np.array([getattr(state, name) for state in cycle.loading]) for name in ("delta", "force")]
        tension = np.minimum(force, 0.0)
        zero = cycles.surface.zero
        turn = cycle.turn
        results.append(
            {
                "snap_in_force": max(-cycle.loading[0].force, 0.0),
                "snap_in_delta": cycle.loading[0].delta - zero,
                "pull_off_force": max(cycles.pull_offs[k], 0.0),
                "pull_off_delta": cycle.pull_off.delta - zero,
                "detachment_delta": delta[-1] - zero,
                "work_of_separation": np.trapezoid(tension, delta),
                "hysteresis": max(np.trapezoid(force, delta) + np.trapezoid(approach[1], approach[0]), 0.0),
                "pull_off_resolution": cycle.pull_off.radius.mean() / problem.pixel,
                "pressed_pull_off_force": cycles.pressed[k],
                "pull_off_error": errors[k],
                **{name: error[k] for name, error in cycles.errors.items()},
                "preload_delta": turn.delta - zero,
                "contact_area": np.pi * np.mean(turn.radius**2),
                "residual": front.TOLERANCE,
                "converged": True,
                "complete": True,
                "truncated": cycles.surface.unknown_from < turn.delta,
            }
        )
    return results


def front_cycles(place: Place, problem: Problem, adhesion: Adhesion) -> FrontCycles:
    """Return the cycles of one place to each preload and the errors of their pull-offs; raises `Unfollowed`."""
    on_pixels = problem._replace(refine=1)
    axes = cell_axes(place, on_pixels)
    points = _usual_points(problem, adhesion, axes)
    on_cells = problem._replace(refine=_CELLS if points.spacing < problem.pixel else 1)

    def edge_on(circles: Circles) -> front.Front:
        return front.Front(front.landscape(*circles), problem.contact_modulus, adhesion.work)

    for attempt in range(_MOST_CENTRINGS):
        # fewest points along a radius of the coarser solution
        if points.radius < 8 * points.halved.spacing:
            raise Unfollowed
        circles = circles_at(place, on_cells, points)
        coarse = edge_on(circles.halved)
        coarse_cycles = _cycles(coarse, points.halved.step, adhesion.preloads)
        shift, radius = _middle(coarse_cycles[-1].pull_off.radius)
        if np.hypot(*shift) < _CENTRED * radius or attempt == _MOST_CENTRINGS - 1:
            break
        middle = points.middle[0] + shift[0], points.middle[1] + shift[1]
        points = _within(points._replace(middle=middle), axes)
    coarse_pulls = _pull_offs(coarse_cycles)
    pressed = _pressed_pull_offs(coarse, points.halved.step, coarse_cycles, adhesion.preloads) / coarse_pulls
    cycles = _cycles(edge_on(circles), points.step, adhesion.preloads)
    pulls = _pull_offs(cycles)
    splined_pulls = coarse_pulls
    if on_cells.refine > 1:  # else points are wider than pixels, between which the same splines interpolate
        splined = edge_on(circles_at(place, on_pixels, points.halved))
        splined_pulls = _pull_offs(_cycles(splined, points.halved.step, adhesion.preloads))
    errors = {
        "mesh_error": np.abs(coarse_pulls / pulls - 1),
        "interpolation_error": np.abs(splined_pulls / coarse_pulls - 1),
    }
    return FrontCycles(surface_at(place, on_pixels), points, cycles, pressed * pulls, errors)


def _pull_offs(cycles: list[Cycle]) -> np.ndarray:
    """Return the pull-off forces of cycles, nN."""
    return np.array([-cycle.pull_off.force for cycle in cycles])


def _usual_points(problem: Problem, adhesion: Adhesion, axes: tuple[np.ndarray, np.ndarray]) -> Points:
    """Return the usual points about the contact centre."""
    radius = problem.indenter.radius
    modulus = problem.contact_modulus
    work = adhesion.work
    contact = _jkr_radius(max(adhesion.preloads[-1], 0.0), radius, modulus, work)
    spacing = max(problem.pixel / _RADII, contact / _MOST_RADII)
    angles = 4 * int(np.clip(2 * np.pi * contact * _ANGLES / problem.pixel, _FEWEST_ANGLES, _MOST_ANGLES) / 4)
    step = _STEP * float(np.cbrt(np.pi**2 * work**2 * radius / modulus**2))
    return _within(Points((0.0, 0.0), _WINDOW * contact, spacing, angles, step), axes)


def _within(points: Points, axes: tuple[np.ndarray, np.ndarray]) -> Points:
    """Return points that lie within the cells."""
    nearest = min(min(at - cells[0], cells[-1] - at) for at, cells in zip(points.middle, axes))
    return points._replace(radius=min(points.radius, float(nearest)))


def _jkr_radius(load: float, radius: float, modulus: float, work: float) -> float:
    """Return the radius (nm) of JKR's contact under a load (nN)."""
    adhesion = 3 * np.pi * work * radius
    return float(np.cbrt(0.75 * radius / modulus * (load + adhesion + np.sqrt(adhesion * (2 * load + adhesion)))))


def _middle(radius: np.ndarray) -> tuple[tuple[float, float], float]:
    """Return the centroid of a region by its radius along the edge, and its mean radius."""
    angle = 2 * np.pi * np.arange(radius.size) / radius.size
    area = np.mean(radius**2)
    x, y = (float(np.mean(radius**3 * wave(angle)) / (1.5 * area)) for wave in (np.cos, np.sin))
    return (x, y), float(radius.mean())


def _cycles(edge: front.Front, step: float, preloads: np.ndarray) -> list[Cycle]:
    """Return the cycles to each preload, nN, which share their loading."""
    delta = float(edge.shape.edge_delta[0].mean())
    loading: list[front.State] = []
    cycles = []
    for preload in preloads:
        cycles.append(_cycle(edge, loading, delta, step, preload))
        loading = cycles[-1].loading
        delta = loading[-1].delta
    return cycles


def _pressed_pull_offs(edge: front.Front, step: float, cycles: list[Cycle], preloads: np.ndarray) -> np.ndarray:
    """Return the pull-offs (nN) of cycles once the sphere was pressed as hard as it holds, beyond the last cycle."""
    pulls = _pull_offs(cycles)
    load = float(preloads[-1])
    pressed = float(pulls.max())
    is_light = preloads < pressed
    loading = cycles[-1].loading
    while pressed > (1 + LARGEST_SETTLING) * load:
        load = pressed
        harder = _cycle(edge, loading, loading[-1].delta, step, load)
        loading = harder.loading
        pressed = -harder.pull_off.force
    return np.where(is_light, pressed, pulls)


def _cycle(edge: front.Front, loading: list[front.State], delta: float, step: float, preload: float) -> Cycle:
    """Return the cycle to a preload (nN) that continues a loading; the edge stays where it turns back."""
    states, result = front.approach(edge, delta, step, preload)
    if result != front.AT_REST:
        raise Unfollowed
    retraction, result = front.retraction(edge, states[-1].delta, step)
    if result != front.LOST:
        raise Unfollowed
    edge.radius = states[-1].radius
    return Cycle(loading + states, retraction)
