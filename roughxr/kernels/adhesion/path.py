"""Path of a body under a law of adhesion: one loading, any number of turning points, a retraction from each.

Each state is searched from the last one. So the path follows a branch of solutions to its end and then jumps to another
branch, as a body on a stiff device does. The displacement moves in steps, between which two events are located:

preload       on loading, the force reaches a preload: regula falsi (`_Loading`).
branch end    on retraction, the tension may be largest where a branch ends or the last contact detaches, between two
              steps (`_Retraction`). Retraction first takes whole steps to the end. The last stiffness gives an upper
              bound of the tension within each step. Where this bound exceeds the largest tension, the step is bisected,
              accepting only states of the same branch; the path then continues until it is the known one again.

The largest tension at last is that of the vertex of the parabola through the largest state and its neighbours.

A step at fixed displacement dissipates the work ½ (F₀ + F₁) Δδ less the increase of the energy.

Unit cells and unit modulus.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .states import Solver

#: Outcomes of a path.
CONVERGED, NOT_FINITE, CELL_LIMIT = range(3)

#: A state's values; of yielding, the shares of pushing force and touching cells at the hardness or above, and area and
#: volume of what has given way, in cells.
STATE = np.dtype(
    [
        *((name, float) for name in ("delta", "force", "contact_area", "energy", "dissipated", "contact_patches")),
        *((name, float) for name in ("resolution", "residual", "yielded_fraction", "yielded_area_fraction")),
        *((name, float) for name in ("yielded_area", "plastic_work")),
        ("iterations", int),
        ("converged", bool),
        ("prescribed", bool),
    ]
)

#: A step has jumped if it dissipates more than this part of |ΔF Δδ|, and has passed a sharp edge if it seems to gain
#: more than the second part: a smooth curved branch stays well below both. Without the second the pull-off of a place
#: of the twin with steps of 0.4 nm is 14 % lower.
_JUMP_DISSIPATION, _EDGE_GAIN = 0.15, 0.05

#: Largest part of the largest tension that may be missed between two states.
_PULL_ERROR = 0.005

#: Part of the step below which steps are not divided.
_SHORTEST_STEP = 1.0 / 64

#: Retraction's steps over those of loading. Longer ones pass from one branch to another that shorter ones do not meet:
#: places of the twin then pull off by up to 17 % less with steps of 0.4 nm, on four cells to a pixel.
_RETRACTION_STEP = 0.5

#: Accuracy of a preload, as a part of it, or of the largest tension if that is more.
_PRELOAD_TOLERANCE = 1e-3

#: Displacements closer than this part of a step count as equal.
_EQUAL_DELTA = 1e-9


class Path(NamedTuple):
    """All states of one cycle in order, and how it ended."""

    states: np.ndarray  # (state,) of STATE
    turn: int  # first state of the retraction
    status: int
    pressures: np.ndarray  # (prescribed or 0, nx, ny) p dx/E*, nm, in the order of the path
    left: np.ndarray  # (prescribed or 1, nx, ny) nm ≤ 0, residual height after loading to the prescribed displacements


def follow_path(
    separation,
    deltas,
    step,
    law,
    *,
    preloads=(),
    max_cells=10**7,
    fields=False,
    cap=np.inf,
    limit=np.inf,
    left=None,
    from_contact=False,
    capture=0.0,
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
        Forces, nm (F/(E* dx)), ascending: the body turns back where the force first reaches them on loading, once it
        touches; at 0 it has settled under its own adhesion. All share one loading path. Without any it turns back at
        the last of ``deltas``.
    max_cells : int
        Largest number of cells within range.
    fields : bool
        Whether to return pressures.
    cap : float
        Largest pressure that the body bears, nm (H dx/E*); inf where it never yields.
    limit : float
        Pressure, nm, above which the shares of force and area are reported.
    left : (nx, ny) array, optional
        Residual height of earlier cycles, nm ≤ 0.
    from_contact : bool
        The law stands for one without range: it attracts in contacts and within the opening of their edges, and across
        the gap to other cells only where that gap is smaller than ``capture``.
    capture : float
        Gap (nm) at which a surface with the pair's range snaps in; 0 without any range.

    Returns
    -------
    list of Path
        One for each turning point. A preload that was not reached turns back at the last of ``deltas``.
    """
    separation = np.ascontiguousarray(np.where(np.isfinite(separation), separation, np.inf))
    deltas, preloads = np.asarray(deltas, dtype=float), np.sort(np.asarray(preloads, dtype=float))
    goals = preloads if preloads.size else [np.inf]
    if np.count_nonzero(separation < deltas[-1] + law.range) > max_cells:
        no_fields = np.zeros((0, *separation.shape))
        return [Path(np.zeros(0, STATE), 0, CELL_LIMIT, no_fields, no_fields) for _ in goals]
    solver = Solver(separation, law, cap, limit, from_contact, capture)
    left = np.zeros(separation.shape) if left is None else left
    loading = _Loading(solver, step, deltas, left, fields=fields)
    return [_path(loading, loading.load(goal)) for goal in goals]


def _path(loading, fine):
    """Return the `Path` that turns back where the loading has arrived."""
    retraction = _Retraction(loading)
    whole = fine and retraction.retract()
    visited, shape = loading.visited + (retraction.visited if fine else []), (0, *loading.solver.separation.shape)
    states = np.array([visit.row for visit in visited], STATE)
    states["dissipated"] = np.cumsum(states["dissipated"])
    pressures = [visit.pressure for visit in visited if visit.pressure is not None]
    left = [visit.left for visit in loading.visited if visit.left is not None] or [loading.last.left]
    status = CONVERGED if whole else NOT_FINITE
    pressures = np.array(pressures) if pressures else np.zeros(shape)
    return Path(states, len(loading.visited), status, pressures, np.array(left))


@dataclass
class _Visit:
    """A visited state: its values, and what is needed to continue from it."""

    row: np.void
    solved: object  # the `SolvedState`, None where no larger tension can lie beyond
    stiffness: float
    pressure: np.ndarray | None = None
    left: np.ndarray | None = None
    bound: float = -np.inf  # of the tension up to the next state


class _Stepper:
    """The present state of a path, and the states that it has visited."""

    def __init__(self, solver, step, deltas, fields):
        self.solver, self.step, self.deltas, self.fields = solver, step, deltas, fields
        self.visited, self.largest, self.stiffness, self.last = [], 0.0, np.inf, None
        self.shortest, self.start = _SHORTEST_STEP * step, float(solver.separation.min()) - solver.law.onset

    def accept(self, solved, prescribed):
        """Append a state, which becomes the present one."""
        freed, moved = self._freed(solved), self.last.delta - solved.delta
        if moved != 0.0 and self._is_smooth(solved):  # across a jump two states do not give the stiffness
            self.stiffness = (self.last.force - solved.force) / moved
        self.last, self.largest = solved, max(self.largest, -solved.force)
        pressure = left = None
        if prescribed and self.fields:
            pressure, left = np.zeros(self.solver.separation.shape), solved.left
            pressure[solved.rows, solved.columns] = solved.state.pressure
        self.visited.append(_Visit(self._row(solved, prescribed, freed), solved, self.stiffness, pressure, left))

    def _row(self, solved, prescribed, freed):
        """Return the values of a state; ``dissipated`` is that of the step to it."""
        row, state = np.zeros(1, STATE)[0], solved.state
        row["delta"], row["force"], row["energy"], row["dissipated"] = solved.delta, solved.force, solved.energy, freed
        row["contact_patches"], row["resolution"] = self.solver.contacts(state)
        row["contact_area"], row["residual"], row["iterations"] = state.touching.sum(), solved.residual, solved.rounds
        row["converged"], row["prescribed"] = solved.fine, prescribed
        for name, value in self.solver.yielded(solved).items():
            row[name] = value
        return row

    def _is_smooth(self, solved):
        """Return whether a step follows a branch, judged by what it dissipates."""
        work = abs((self.last.force - solved.force) * (self.last.delta - solved.delta))
        return -_EDGE_GAIN * work <= self._freed(solved) <= _JUMP_DISSIPATION * work

    def _freed(self, solved):
        """Return the energy that the step to a state dissipates, nm²."""
        last = self.last
        return 0.5 * (solved.force + last.force) * (solved.delta - last.delta) - (solved.energy - last.energy)


class _Loading(_Stepper):
    """The approach, through the prescribed displacements and up to preloads."""

    def __init__(self, solver, step, deltas, left, *, fields):
        super().__init__(solver, step, deltas, fields)
        self.seek = solver.press if solver.cap < np.inf else solver.seek
        steps = np.ceil(max(deltas[0] - self.start, 0.0) / step)  # whole steps: both ways visit the same displacements
        self.last, self.next = solver.nothing(deltas[0] - step * steps, left), 0

    def load(self, goal):
        """Step until the force reaches ``goal`` or the last displacement; return whether all states are finite."""
        while self.next < self.deltas.size:
            target, delta = float(self.deltas[self.next]), float(self.last.delta + self.step)
            delta = target if target - delta < _EQUAL_DELTA * self.step else delta
            solved = self.seek(delta, self.last, exact=delta == target)
            reached = solved.force >= goal and solved.state.touching.any()
            solved = self._meet(goal, solved) if reached else solved
            if not np.isfinite(solved.force):
                return False
            self._accept(solved)
            self.next += solved.delta == target
            if reached:
                break
        return True

    def _accept(self, solved):
        self.accept(solved, solved.delta == self.deltas[self.next])
        self.visited[-1].solved = None

    def _meet(self, goal, above):
        """Return the state that meets a preload, between the last state and one above it."""
        while (
            above.force - goal > _PRELOAD_TOLERANCE * max(abs(goal), self.largest)
            and above.delta - self.last.delta > self.shortest
        ):
            part = (goal - self.last.force) / (above.force - self.last.force)
            delta = self.last.delta + min(max(part, 0.05), 0.95) * (above.delta - self.last.delta)
            solved = self.seek(float(delta), self.last, exact=False)
            if not np.isfinite(solved.force) or (solved.force >= goal and solved.state.touching.any()):
                above = solved
            else:
                self._accept(solved)
        return above


class _Retraction(_Stepper):
    """The retraction from the present state of the loading, until contact is lost; it locates the largest tension."""

    def __init__(self, loading):
        super().__init__(loading.solver, loading.step, loading.deltas, loading.fields)
        self.last, self.stiffness = loading.last, loading.stiffness
        if loading.visited:  # it begins with the present state
            turn = loading.visited[-1]
            row = turn.row.copy()
            row["dissipated"] = 0.0
            self.visited.append(_Visit(row, self.last, self.stiffness, turn.pressure))

    def retract(self):
        """Retract until contact is lost, locate the ends of branches; return whether all states are finite."""
        same = _EQUAL_DELTA * self.step
        finite = self._walk([(float(d), True, None) for d in self.deltas[::-1] if d < self.last.delta - same])
        while finite and (k := self._most_doubtful()) is not None:
            known, self.visited = self.visited[k + 1 :], self.visited[: k + 1]
            begin = self.visited[-1]
            self.last, self.stiffness, begin.bound = begin.solved, begin.stiffness, -np.inf
            targets = [(float(visit.row["delta"]), bool(visit.row["prescribed"]), visit) for visit in known]
            finite = self._walk(targets, locate=True)
        if finite:
            self._solve_vertex()
        return finite

    def _walk(self, targets, *, locate=False):
        """Retract in whole steps through targets (δ, prescribed, `_Visit` or None), until lost or on the known path."""
        whole = stride = _RETRACTION_STEP * self.step
        while targets or not self.is_lost():
            lost = self.is_lost()
            if lost:  # nothing happens between the prescribed displacements
                targets = [target for target in targets if target[1]]
                if not targets:
                    break
            target, prescribed, known = targets[0] if targets else (-np.inf, False, None)
            delta = self.last.delta - min(np.inf if lost else stride, self.last.delta - target)
            delta = target if delta - target < _EQUAL_DELTA * self.step else float(delta)
            solved, exact = None, prescribed and delta == target
            if locate and not lost:
                delta, solved = self._branch_end(delta, exact)
            arrives = delta == target
            solved = solved or self.solver.seek(delta, self.last, exact=arrives and prescribed)
            if not np.isfinite(solved.force):
                return False
            if self.visited and not locate and self._may_hide_more(solved):
                self.visited[-1].bound = self._bound(delta)
            stride = min(2.0 * (self.last.delta - delta), whole) if locate else whole  # a new branch may be short
            self.accept(solved, arrives and prescribed)
            self._forget()
            targets = targets[1:] if arrives else targets
            if arrives and known and (targets or self.is_lost()) and self._is_same(known):
                self._join(known, [visit for *_, visit in targets])
                break
        return True

    def _branch_end(self, end, exact):
        """Follow the branch to a displacement; return it and its state, or the nearest one beyond its end and None."""
        delta = end
        while self.last.delta - end > self.shortest and self._bound(end) > (1.0 + _PULL_ERROR) * self.largest:
            solved = self.solver.seek(delta, self.last, near=True, exact=exact and delta == end)
            if not solved.fine or self._may_hide_more(solved):
                end = delta
            elif delta == end:
                return end, solved
            else:
                self.accept(solved, False)
                self._forget()
            delta = float(0.5 * (self.last.delta + end))
        return end, None

    def _bound(self, delta):
        """Return the tension at a displacement by the last stiffness."""
        return self.stiffness * (self.last.delta - delta) - self.last.force

    def _may_hide_more(self, solved):
        """Return whether a larger tension may lie within a step: it jumped, or the tension fell although it grew."""
        if self._is_smooth(solved) and solved.force <= self.last.force:
            return False
        return self._bound(solved.delta) > (1.0 + _PULL_ERROR) * max(self.largest, -solved.force)

    def _forget(self):
        """Free states beyond which no larger tension can lie, but for the last two and that of the largest."""
        for visit in self.visited[:-2]:
            if visit.bound <= (1.0 + _PULL_ERROR) * self.largest and -visit.row["force"] < self.largest:
                visit.solved = None

    def _most_doubtful(self):
        """Return the position of the state after which the largest tension may lie; None where it is known already."""
        self.largest = max((-visit.row["force"] for visit in self.visited), default=0.0)
        stored = [(visit.bound, k) for k, visit in enumerate(self.visited) if visit.solved is not None]
        bound, k = max(stored, default=(0.0, 0))
        return k if bound > (1.0 + _PULL_ERROR) * self.largest else None

    def _is_same(self, known):
        """Return whether the present state is a known one at the same displacement."""
        row, cells = self.visited[-1].row, known.row["contact_area"]
        same_force = abs(row["force"] - known.row["force"]) <= _PULL_ERROR * self.largest
        return same_force and abs(row["contact_area"] - cells) <= max(0.01 * cells, 1.0)

    def _join(self, same, following):
        """Continue by the known path."""
        if following:
            row, last = following[0].row, self.last
            self.visited[-1].bound = min(same.bound, self._bound(row["delta"]))
            work = 0.5 * (row["force"] + last.force) * (row["delta"] - last.delta)
            row["dissipated"] = work - (row["energy"] - last.energy)
        self.visited += following

    def _solve_vertex(self):
        """Solve the state at the vertex of the parabola through the state of the largest tension and its neighbours."""
        best = int(np.argmin([visit.row["force"] for visit in self.visited])) if self.visited else 0
        if not 0 < best < len(self.visited) - 1 or self.visited[best].solved is None:
            return
        rows = np.array([visit.row for visit in self.visited[best - 1 : best + 2]], STATE)
        (x0, x1, x2), (f0, f1, f2) = rows["delta"], rows["force"]
        if not (x0 > x1 > x2 and f1 < min(f0, f2)):
            return
        first, second = (f1 - f0) / (x1 - x0), (f2 - f1) / (x2 - x1)
        delta = float(0.5 * (x0 + x1) - 0.5 * first * (x2 - x0) / (second - first))
        solved = self.solver.seek(delta, self.visited[best].solved)
        if solved.fine and solved.force < f1:
            self.visited.insert(best + (delta < x1), _Visit(self._row(solved, False, 0.0), None, np.nan))

    def is_lost(self):
        """Return whether nothing touches, at a displacement where nothing attracts either."""
        return self.last.delta <= self.start and not self.last.state.touching.any()
