"""Path of a body under a smooth law of adhesion: one loading, any number of turning points, a retraction from each.

Each state is solved from the last one. So the path follows a branch of solutions to its end and then descends to
another branch, as a body under displacement control does. The displacement changes in steps, and the pull-off must not
depend on them (`retraction`). A preload is located by regula falsi.

The energy released at fixed displacement is dissipated: the work ½(F₀ + F₁)Δδ of a step less the increase of energy.

Unit cells and unit modulus.
"""

from typing import NamedTuple

import numpy as np

from .retraction import Retraction
from .states import Solver
from .steps import EQUAL_DELTA, SHORTEST_STEP, STATE, Stepper

#: Outcomes of a path.
CONVERGED, NOT_FINITE, CELL_LIMIT = range(3)

#: Tolerance of a preload, as a part of the preload or of the largest tension, whichever is larger.
_PRELOAD_TOLERANCE = 1e-3


#: A body that holds less than this times the force that pressed it is not pressed again.
_AS_HARD = 1.5

#: Energy of a jump on loading that changes what the body holds, over the largest tension times the step.
_LEAST_JUMP = 0.02


class Path(NamedTuple):
    """The states of one cycle in order, and its outcome."""

    states: np.ndarray  # (state,) of STATE; prescribed: at a prescribed displacement
    first_retraction: int  # number of the state
    status: int
    pressures: np.ndarray  # (prescribed or 0, nx, ny) p dx/E*, nm, in the path's order
    observed: list  # what ``observe`` returned of each state on retraction
    residual_heights: np.ndarray  # (prescribed or 1, nx, ny) nm ≤ 0, after loading to the prescribed displacements
    pressed: float = np.nan  # largest tension, nm, once the body was pressed as hard as it holds, if asked for

    @property
    def tension(self):
        """The largest tension on retraction, nm; 0 without any."""
        return max(0.0, -self.states["force"][self.first_retraction :].min(initial=0.0))


def follow_path(
    separation,
    deltas,
    step,
    law,
    *,
    preloads=(),
    max_cells=10**7,
    fields=False,
    observe=None,
    cap=np.inf,
    limit=np.inf,
    residual_height=None,
    capture=None,
    film=None,
    press=False,
):
    """Follow the contact up to the largest of ``deltas``, or to each of ``preloads``, and back until it is lost.

    Parameters
    ----------
    separation : (nx, ny) array
        S, nm; NaN or inf where there is nothing to touch.
    deltas : array
        Prescribed displacements, nm, ascending. Loading ends at the last.
    step : float
        Longest step between two states, nm.
    law : traction_laws.SmoothLaw
    preloads : array, optional
        Forces, nm (F/(E* dx)), ascending: the body turns back where the force first reaches them on loading, in
        contact; at 0 it has settled under its own adhesion. All share one loading path. Without preloads it turns back
        at the last of ``deltas``.
    max_cells : int
        Largest number of cells within range.
    fields : bool
        Return the pressures at the prescribed displacements.
    observe : callable, optional
        ``observe(SolvedState)`` is called for each state on retraction; its results are returned.
    cap : float
        Hardness of the body, nm (H dx/E*); inf for an elastic body.
    limit : float
        Pressure, nm, above which the shares of force and area are reported.
    residual_height : (nx, ny) array, optional
        From earlier cycles, nm ≤ 0.
    capture : float, optional
        The law represents one without range: it attracts cells in contact and within the opening of the edges, and
        other cells only across gaps smaller than this (nm), at which a surface with the pair's range snaps in.
    film : layered.Film, optional
        Film on the half space, its thickness in cells.
    press : bool
        Continue loading beyond the preloads to find ``pressed``.

    Returns
    -------
    list of Path
        One for each turning point. A preload that was not reached turns back at the last of ``deltas``.
    """
    separation = np.ascontiguousarray(np.where(np.isfinite(separation), separation, np.inf))
    deltas = np.asarray(deltas, dtype=float)
    preloads = np.sort(np.asarray(preloads, dtype=float))
    goals = preloads if preloads.size else [np.inf]
    if np.count_nonzero(separation < deltas[-1] + law.range) > max_cells:
        no_fields = np.zeros((0, *separation.shape))
        return [Path(np.zeros(0, STATE), 0, CELL_LIMIT, no_fields, [], no_fields) for _ in goals]
    solver = Solver(separation, law, cap, limit, capture, film)
    residual_height = np.zeros(separation.shape) if residual_height is None else residual_height
    loading = _Loading(solver, step, deltas, residual_height, fields=fields)
    paths = []
    for goal in goals:
        loaded = loading.load(goal)
        retraction = Retraction(loading, observe)
        paths.append(_path(loading, retraction, loaded))
    if not press:
        return paths
    pressed = np.nan
    if paths[-1].status == CONVERGED:
        pressed = _pressed_tension(loading, retraction, preloads[-1])
    return [path._replace(pressed=pressed if goal < pressed else path.tension) for path, goal in zip(paths, goals)]


def _pressed_tension(loading, retraction, load):
    """Return the largest tension once the body was pressed as hard as it holds, after a retraction from ``load``.

    Loading without a jump is reversible: the body then holds as much as before, and need not retract once more.
    """
    enough = load
    while retraction.tension > enough:
        tension = retraction.tension
        loading.has_jumped = False
        if not loading.load(tension, only_after_jump=True):
            return np.nan
        if not loading.has_jumped:
            break
        enough = _AS_HARD * tension
        retraction = Retraction(loading, None, known=retraction.visited)
        if not retraction.retract():
            return np.nan
    return retraction.tension


def _path(loading, retraction, loaded):
    """Return the `Path` that turns back at the present state of loading."""
    whole = loaded and retraction.retract()
    visited = loading.visited + (retraction.visited if loaded else [])
    shape = (0, *loading.solver.separation.shape)
    states = np.array([visit.row for visit in visited], STATE)
    states["dissipated"] = np.cumsum(states["dissipated"])
    pressures = [visit.pressure for visit in visited if visit.pressure is not None]
    heights = [visit.residual_height for visit in loading.visited if visit.residual_height is not None]
    heights = heights or [loading.last.residual_height]
    status = CONVERGED if whole else NOT_FINITE
    pressures = np.array(pressures) if pressures else np.zeros(shape)
    observed = [visit.observed for visit in retraction.visited] if loaded else []
    return Path(states, len(loading.visited), status, pressures, observed, np.array(heights))


class _Loading(Stepper):
    """The approach, through the prescribed displacements and up to preloads."""

    def __init__(self, solver, step, deltas, residual_height, *, fields):
        super().__init__(solver, step, deltas, fields)
        self.solve = solver.solve_yielding if solver.cap < np.inf else solver.solve
        first = float(solver.separation.min()) - solver.law.onset
        steps = np.ceil(max(deltas[0] - first, 0.0) / step)  # whole, so that retraction visits the same displacements
        self.last = solver.without_traction(deltas[0] - step * steps, residual_height)
        self.next = 0
        self.has_jumped = False

    def accept(self, solved, prescribed):
        """Append a state, which becomes the present state."""
        self.has_jumped |= self._jumps(solved)
        super().accept(solved, prescribed)

    def _jumps(self, solved, part=1.0):
        """Return whether a part of the step to a state, or the whole step, may change what the body holds."""
        freed = self._freed_energy(solved)
        return freed > _LEAST_JUMP * self.largest * self.step and self.has_dissipated(solved, part)

    def load(self, goal, *, only_after_jump=False):
        """Continue to the force ``goal`` or to the last displacement; return whether all states are finite.

        With ``only_after_jump`` the goal is not located unless a step has jumped, and the last step may exceed it.
        """
        over = None  # a state beyond the goal
        while self.next < self.deltas.size:
            target = self.deltas[self.next]
            last = self.last
            if over is not None and over.delta - last.delta <= SHORTEST_STEP * self.step:
                solved = over  # the force jumps past the goal
            else:
                delta = self._next_delta(goal, over, target)
                solved = self.solve(delta, last, exact=delta == target)
            if not np.isfinite(solved.force):
                return False
            reached = solved.force >= goal and solved.state.touching.any()
            met = solved.force - goal <= _PRELOAD_TOLERANCE * max(abs(goal), self.largest)
            if reached and not met and solved.delta - last.delta > SHORTEST_STEP * self.step:
                part = (goal - last.force) / (solved.force - last.force)
                if only_after_jump and not (self.has_jumped or self._jumps(solved, part)):
                    break
                over = solved
                continue
            self.accept(solved, solved.delta == target)
            self.visited[-1].solved = None
            self.next += solved.delta == target
            if reached:
                break
        return True

    def _next_delta(self, goal, over, target):
        """Return the next displacement on loading: a step ahead, or towards a goal that the state ``over`` exceeds."""
        last = self.last
        delta = last.delta + self.step
        if over is not None:
            part = (goal - last.force) / (over.force - last.force)
            delta = last.delta + min(max(part, 0.05), 0.95) * (over.delta - last.delta)
        return float(target) if target - delta < EQUAL_DELTA * self.step else float(delta)
