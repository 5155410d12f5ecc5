"""Path of a body under a smooth law of adhesion: one loading, any number of turning points, a retraction from each.

Each state is solved from the last one. So the path follows a branch of solutions to its end and then descends to
another branch, as a body under displacement control does. The displacement changes in steps, and the pull-off must not
depend on them:

- retraction takes whole steps first. It is then repeated from the state beyond which the largest tension may lie, and
  only states near the last one are accepted. If there is none, a branch has ended or the last contact of a stiff body
  is lost; shorter steps locate this end. Once the path coincides with the known path again, it continues on that. Ends
  that cannot change the largest tension are not located, which saves a third of the work.
- the state of the largest tension is refined until neither a parabola through it and its neighbours nor the work of
  the steps between them leaves room for a larger one. Stiff bodies pull most at first touch, within a fraction of
  a step.
- a preload is located by regula falsi.

The energy released at fixed displacement is dissipated: the work ½(F₀ + F₁)Δδ of a step less the increase of energy.

Unit cells and unit modulus.
"""

from typing import NamedTuple

import numpy as np

from .states import Solver

#: Outcomes of a path.
CONVERGED, NOT_FINITE, CELL_LIMIT = range(3)

#: States whose fields are returned.
AT_DISPLACEMENTS = "at displacements"  # the prescribed ones, on both branches
ON_RETRACTION = "on retraction"  # all

#: Values of a state. Yielding: the shares of compressive force and touching cells at the hardness or above, and area
#: and volume of the dents, in cells.
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

#: Retraction ends where nothing touches and the tension is below this part of the largest.
_LEAST_TENSION = 1e-3

#: A step has jumped if it dissipates more than the first part of |ΔF Δδ|, and has passed a sharp edge if it gains more
#: than the second part. A smooth branch stays well below both.
_JUMP_DISSIPATION, _EDGE_GAIN = 0.15, 0.05

#: Avoids 0/0 in ratios.
_TINY = 1e-300

#: Largest error of the largest tension by states missed between two steps; and the shortest step over the longest.
_TENSION_ERROR, _SHORTEST_STEP = 0.005, 1.0 / 64

#: The same error on a smooth curve that may have turned: there the tangent is an upper bound.
_TENSION_ERROR_ON_CURVE = 0.05

#: Largest number of states that refine the largest tension, and their least distance from the ends of a step, as a part
#: of the step.
_MOST_TRIALS = 8
_LEAST_PART = 0.125

#: An end is located once a state before it is nearer than the first number, in shortest steps; steps below the second
#: number are not halved. Not binary fractions, unlike steps, so that rounding does not decide.
_AT_END, _SHORT = 2.3, 1.3

#: Steps of retraction over those of loading. Longer steps jump to branches that shorter ones do not meet: pull-off
#: forces on the twin are then up to 17 % lower, with steps of 0.4 nm and 4 × 4 cells a pixel.
_RETRACTION_STEP = 0.5

#: Tolerance of a preload, as a part of the preload or of the largest tension, whichever is larger.
_PRELOAD_TOLERANCE = 1e-3

#: Displacements closer than this part of a step count as equal.
_EQUAL_DELTA = 1e-9


#: Contacts and their resolution at states that nobody reads: counting takes a tenth of a solve.
_NOT_COUNTED = -1, np.nan


class Path(NamedTuple):
    """The states of one cycle in order, and its outcome."""

    states: np.ndarray  # (state,) of STATE; prescribed: at a prescribed displacement
    turn: int  # first state of the retraction
    status: int
    pressures: np.ndarray  # (state or 0, nx, ny) p dx/E*, nm, of the states that were asked for, in the path's order
    gaps: np.ndarray  # (state or 0, nx, ny) nm, of all states on retraction: 0 in contact, inf beyond the range
    residual_heights: np.ndarray  # (prescribed or 1, nx, ny) nm ≤ 0, after loading to the prescribed displacements


def follow_path(
    separation,
    deltas,
    step,
    law,
    *,
    preloads=(),
    max_cells=10**7,
    fields=None,
    cap=np.inf,
    limit=np.inf,
    residual_height=None,
    from_contact=False,
    capture=0.0,
    film=None,
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
    fields : {AT_DISPLACEMENTS, ON_RETRACTION}, optional
        States whose pressures are returned; by default of none. ON_RETRACTION: with their gaps.
    cap : float
        Hardness of the body, nm (H dx/E*); inf for an elastic body.
    limit : float
        Pressure, nm, above which the shares of force and area are reported.
    residual_height : (nx, ny) array, optional
        From earlier cycles, nm ≤ 0.
    from_contact : bool
        The law represents one without range: it attracts cells in contact and within the opening of the edges, and
        other cells only across gaps smaller than ``capture``.
    capture : float
        Gap (nm) at which a surface with the pair's range snaps in; 0 without any range.
    film : layered.Film, optional
        Film on the half space, its thickness in cells.

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
        return [Path(np.zeros(0, STATE), 0, CELL_LIMIT, no_fields, no_fields, no_fields) for _ in goals]
    solver = Solver(separation, law, cap, limit, from_contact, capture, film)
    residual_height = np.zeros(separation.shape) if residual_height is None else residual_height
    loading = _Loading(solver, step, deltas, residual_height, fields=fields)
    return [_path(loading, loading.load(goal)) for goal in goals]


def _path(loading, loaded):
    """Return the `Path` that turns back at the present state of loading."""
    retraction = _Retraction(loading)
    whole = loaded and retraction.retract()
    visited = loading.visited + (retraction.visited if loaded else [])
    shape = (0, *loading.solver.separation.shape)
    states = np.array([visit.row for visit in visited], STATE)
    states["dissipated"] = np.cumsum(states["dissipated"])
    pressures = [visit.pressure for visit in visited if visit.pressure is not None]
    gaps = [visit.gap for visit in visited if visit.gap is not None]
    heights = [visit.residual_height for visit in loading.visited if visit.residual_height is not None]
    heights = heights or [loading.last.residual_height]
    status = CONVERGED if whole else NOT_FINITE
    pressures, gaps = (np.array(fields) if fields else np.zeros(shape) for fields in (pressures, gaps))
    return Path(states, len(loading.visited), status, pressures, gaps, np.array(heights))


class _Visit:
    """A state of the path: its row and, while a larger tension may lie beyond, the state itself."""

    __slots__ = ("gap", "most", "pressure", "residual_height", "row", "solved", "stiffness")

    def __init__(self, row, solved, stiffness, pressure=None, residual_height=None):
        self.row = row
        self.solved = solved
        self.stiffness = stiffness
        self.pressure = pressure
        self.gap = None
        self.residual_height = residual_height
        self.most = -np.inf  # the largest tension that may lie between this state and the next


class _Stepper:
    """The present state of a path, and the states visited so far."""

    def __init__(self, solver, step, deltas, fields):
        self.solver = solver
        self.step = step
        self.deltas = deltas
        self.fields = fields
        self.visited = []
        self.largest = 0.0
        self.stiffness = np.inf
        self.last = None

    def accept(self, solved, prescribed):
        """Append a state, which becomes the present state."""
        freed = self._freed_energy(solved)
        moved = self.last.delta - solved.delta
        if moved != 0.0 and self._is_smooth(solved):  # across a jump two states do not give the stiffness
            self.stiffness = (self.last.force - solved.force) / moved
        self.last = solved
        self.largest = max(self.largest, -solved.force)
        pressure = residual_height = None
        if prescribed and self.fields == AT_DISPLACEMENTS:
            pressure = self._on_window(solved, solved.state.pressure, 0.0)
            residual_height = solved.residual_height
        row = self._row(solved, prescribed, freed)
        self.visited.append(_Visit(row, solved, self.stiffness, pressure, residual_height))

    def _on_window(self, solved, field, beyond):
        """Return a field of a state's box on all cells, with its value beyond the box."""
        on_window = np.full(self.solver.separation.shape, beyond)
        on_window[solved.rows, solved.columns] = field
        return on_window

    def _row(self, solved, prescribed, freed):
        """Return the values of a state, with the energy freed by the last step in place of the whole dissipation."""
        row = np.zeros(1, STATE)[0]
        state = solved.state
        row["delta"] = solved.delta
        row["force"] = solved.force
        row["energy"] = solved.energy
        row["dissipated"] = freed
        row["contact_patches"], row["resolution"] = self.solver.contacts(state) if prescribed else _NOT_COUNTED
        row["contact_area"] = state.touching.sum()
        row["residual"] = solved.residual
        row["iterations"] = solved.rounds
        row["converged"] = solved.converged
        row["prescribed"] = prescribed
        for name, value in self.solver.yielded(solved).items():
            row[name] = value
        return row

    def _is_smooth(self, solved):
        """Return whether a step follows a branch, judged by its dissipation."""
        work = abs((self.last.force - solved.force) * (self.last.delta - solved.delta)) + _TINY
        return -_EDGE_GAIN <= self._freed_energy(solved) / work <= _JUMP_DISSIPATION

    def _freed_energy(self, solved):
        """Return the energy dissipated by the step to a state, nm²."""
        last = self.last
        return 0.5 * (solved.force + last.force) * (solved.delta - last.delta) - (solved.energy - last.energy)


class _Loading(_Stepper):
    """The approach, through the prescribed displacements and up to preloads."""

    def __init__(self, solver, step, deltas, residual_height, *, fields):
        super().__init__(solver, step, deltas, fields)
        self.solve = solver.solve_yielding if solver.cap < np.inf else solver.solve
        first = float(solver.separation.min()) - solver.law.onset
        steps = np.ceil(max(deltas[0] - first, 0.0) / step)  # whole, so that retraction visits the same displacements
        self.last = solver.without_traction(deltas[0] - step * steps, residual_height)
        self.next = 0

    def load(self, goal):
        """Continue to the force ``goal`` or to the last displacement; return whether all states are finite."""
        over = None  # a state beyond the goal
        while self.next < self.deltas.size:
            target = self.deltas[self.next]
            last = self.last
            if over is not None and over.delta - last.delta <= _SHORTEST_STEP * self.step:
                solved = over  # the force jumps past the goal
            else:
                delta = self._next_delta(goal, over, target)
                solved = self.solve(delta, last, exact=delta == target)
            if not np.isfinite(solved.force):
                return False
            reached = solved.force >= goal and solved.state.touching.any()
            met = solved.force - goal <= _PRELOAD_TOLERANCE * max(abs(goal), self.largest)
            if reached and not met and solved.delta - last.delta > _SHORTEST_STEP * self.step:
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
        return float(target) if target - delta < _EQUAL_DELTA * self.step else float(delta)


class _Retraction(_Stepper):
    """The retraction from the present state of loading until contact is lost; it finds the largest tension."""

    def __init__(self, loading):
        super().__init__(loading.solver, loading.step, loading.deltas, loading.fields)
        self.last = loading.last
        self.stiffness = loading.stiffness
        self.first = float(self.solver.separation.min()) - self.solver.law.onset
        if loading.visited:  # it begins with the present state
            turn = loading.visited[-1]
            row = turn.row.copy()
            row["dissipated"] = 0.0
            self.visited.append(_Visit(row, self.last, self.stiffness, turn.pressure))
            self._keep_fields(self.visited[-1])

    def accept(self, solved, prescribed):
        """Append a state, which becomes the present state."""
        super().accept(solved, prescribed)
        self._keep_fields(self.visited[-1])

    def _keep_fields(self, visit):
        """Store pressure and gap of a state if those of all are asked for."""
        if self.fields == ON_RETRACTION:
            state = visit.solved.state
            visit.pressure = self._on_window(visit.solved, state.pressure, 0.0)
            visit.gap = self._on_window(visit.solved, np.where(state.touching, 0.0, state.gap), np.inf)

    def retract(self):
        """Retract through the prescribed displacements until contact is lost; return whether all states are finite."""
        same = _EQUAL_DELTA * self.step
        targets = [float(delta) for delta in self.deltas[::-1] if delta < self.last.delta - same]
        finite = self._retract_in_steps(targets)
        while finite and (index := self._doubtful_state()) is not None:
            finite = self._locate_ends(index)
        if finite:
            self._refine_largest()
            self._count_contacts_at_largest()
        return finite

    def _count_contacts_at_largest(self):
        """Count the contacts of the state of the largest tension."""
        visit = min(self.visited, key=lambda visit: visit.row["force"], default=None)
        if visit is not None and visit.solved is not None:
            visit.row["contact_patches"], visit.row["resolution"] = self.solver.contacts(visit.solved.state)

    def _retract_in_steps(self, targets):
        """Retract in whole steps through the targets until contact is lost; return whether all states are finite."""
        while targets or not self.is_lost():
            step = np.inf if self.is_lost() else _RETRACTION_STEP * self.step
            delta = self._delta_after(step, targets[0] if targets else -np.inf)
            at_target = bool(targets) and delta == targets[0]
            solved = self.solver.solve(delta, self.last, exact=at_target)
            if not np.isfinite(solved.force):
                return False
            if self.visited and self._may_miss_tension(solved):
                self.visited[-1].most = self.stiffness * (self.last.delta - delta) - self.last.force
            self.accept(solved, at_target)
            self._forget()
            targets = targets[1:] if at_target else targets
        return True

    def _delta_after(self, step, target):
        """Return the displacement after a step of retraction, or the target if that is nearer."""
        delta = self.last.delta - min(step, self.last.delta - target)
        return float(target) if delta - target < _EQUAL_DELTA * self.step else float(delta)

    def _forget(self):
        """Free the memory of states beyond which no larger tension can lie, except the last two, and the largest."""
        for visit, following in zip(self.visited[:-2], self.visited[1:]):
            is_largest = -min(visit.row["force"], following.row["force"]) >= self.largest
            if visit.most <= (1.0 + _TENSION_ERROR) * self.largest and not is_largest:
                visit.solved = None

    def _doubtful_state(self):
        """Return the index of the state beyond which the largest tension may lie; None if that tension is known."""
        self.largest = max((-visit.row["force"] for visit in self.visited), default=0.0)
        stored = [(visit.most, k) for k, visit in enumerate(self.visited) if visit.solved is not None]
        most, index = max(stored, default=(0.0, 0))
        return index if most > (1.0 + _TENSION_ERROR) * self.largest else None

    def _locate_ends(self, index):
        """Retract again from a state, and locate the ends of branches, until the path joins the known path."""
        known = self.visited[index + 1 :]
        self.visited = self.visited[: index + 1]
        start = self.visited[-1]
        least = _SHORTEST_STEP * self.step
        self.last = start.solved
        self.stiffness = start.stiffness
        start.most = -np.inf
        whole = step = _RETRACTION_STEP * self.step
        beyond = None  # a displacement before which the branch has ended
        if known and known[0].solved is not None:
            beyond = known[0].solved.delta
            step = max(0.5 * (self.last.delta - beyond), least)
        while known or not self.is_lost():
            if self.is_lost():  # nothing happens between the prescribed displacements
                known = [visit for visit in known if visit.row["prescribed"]]
                step = np.inf
                beyond = None
                if not known:
                    break
            target = -np.inf
            prescribed = False
            if known:
                target = known[0].row["delta"]
                prescribed = bool(known[0].row["prescribed"])
            at_end = beyond is not None and self.last.delta - beyond < _AT_END * least
            delta = self._delta_after(least if at_end else step, target)
            moved = self.last.delta - delta
            at_target = delta == target
            near = not at_end and moved > _SHORT * least and not self.is_lost() and self._may_reach_largest(moved)
            solved = self.solver.solve(delta, self.last, near=near, exact=at_target and prescribed)
            if near and (not solved.converged or self._may_miss_tension(solved)):
                step = max(0.5 * moved, least)
                beyond = delta
                continue
            if not np.isfinite(solved.force):
                return False
            if near and beyond is not None and beyond < delta:
                step = 0.5 * (delta - beyond)
            else:
                step = min(whole, max(step, 2.0 * moved))
                beyond = None
            self.accept(solved, at_target and prescribed)
            self._forget()
            if at_target and self._is_same(known[0]) and (known[1:] or self.is_lost()):
                self._join(known[0], known[1:])
                break
            known = known[1:] if at_target else known
        return True

    def _join(self, same, following):
        """Continue on the known path; expect a larger tension there only if the present stiffness does."""
        if following:
            moved = self.last.delta - following[0].row["delta"]
            self.visited[-1].most = min(same.most, self.stiffness * moved - self.last.force)
            self.visited += following
            self._count_dissipation(-len(following))

    def _is_same(self, other):
        """Return whether the present state equals another state at its displacement."""
        row = self.visited[-1].row
        cells = other.row["contact_area"]
        same_force = abs(row["force"] - other.row["force"]) <= _TENSION_ERROR * self.largest
        return same_force and abs(row["contact_area"] - cells) <= max(0.01 * cells, 1.0)

    def _may_reach_largest(self, moved):
        """Return whether the branch, extended by its last stiffness, exceeds the largest tension so far."""
        return self.stiffness * moved - self.last.force > (1.0 + _TENSION_ERROR) * self.largest

    def _refine_largest(self):
        """Solve between the state of the largest tension and its neighbours until that tension is known."""
        for trial in range(_MOST_TRIALS):
            best = int(np.argmin([visit.row["force"] for visit in self.visited])) if self.visited else 0
            if not 0 < best < len(self.visited) - 1:
                return
            index, delta, is_known = self._larger_tension_near(best)
            start = self.visited[index].solved
            if (is_known and trial > 0) or start is None or delta == start.delta:
                return
            solved = self.solver.solve(delta, start)
            if not solved.converged:
                return
            following = next(k for k, visit in enumerate(self.visited) if visit.row["delta"] < delta)
            self.visited.insert(following, _Visit(self._row(solved, False, 0.0), solved, np.nan))
            self._keep_fields(self.visited[following])
            self._count_dissipation(following)
            self._count_dissipation(following + 1)

    def _larger_tension_near(self, best):
        """Return a state, the displacement to solve from it, and whether no relevant tension is expected there.

        The energies of the largest tension's state and of its neighbours give the work of both steps. If a parabola
        through the forces does the same work, the displacement is that of its vertex. Else the force turns within
        a step, as at the first touch of stiff bodies: the displacement is that where the secants beyond both ends of
        the step meet.
        """
        rows = np.array([visit.row for visit in self.visited[best - 1 : best + 2]], STATE)
        vertex, at_vertex, missing = _parabola_through(rows)
        index = best - 1 + int(np.argmax(missing))
        crossing, at_crossing = self._crossing_of_secants(index)
        tolerance = -_TENSION_ERROR * rows["force"][1]
        if min(2.0 * missing.max(), at_crossing + rows["force"][1]) > tolerance:
            return index, crossing, False
        return best, vertex, at_vertex + rows["force"][1] <= tolerance

    def _crossing_of_secants(self, index):
        """Return a displacement in the step after a state, and the tension, where the secants beyond its ends meet."""
        rows = np.array([visit.row for visit in self.visited[max(index - 1, 0) : index + 3]], STATE)
        slopes = np.diff(rows["force"]) / np.diff(rows["delta"])
        slope_before = slopes[0] if index > 0 else np.inf
        slope_after = slopes[-1] if index + 2 < len(self.visited) else 0.0
        start = self.visited[index].row
        end = self.visited[index + 1].row
        width = start["delta"] - end["delta"]
        part = (start["force"] - end["force"] - slope_after * width) / ((slope_before - slope_after) * width)
        inside = min(max(part, _LEAST_PART), 1.0 - _LEAST_PART)
        return float(start["delta"] - inside * width), slope_after * (part - 1.0) * width - end["force"]

    def _count_dissipation(self, index):
        """Set the energy dissipated by the step to a state."""
        before = self.visited[index - 1].row
        after = self.visited[index].row
        work = 0.5 * (after["force"] + before["force"]) * (after["delta"] - before["delta"])
        after["dissipated"] = work - (after["energy"] - before["energy"])

    def is_lost(self):
        """Return whether nothing touches, and almost nothing attracts."""
        last = self.last
        if last.state.touching.any():
            return False
        largest_at = min(self.visited, key=lambda visit: visit.row["force"]).row["delta"] if self.visited else np.inf
        past = last.delta < largest_at  # the force also vanishes before it turns to a tension
        return last.delta <= self.first or (-last.force < _LEAST_TENSION * self.largest and past)

    def _may_miss_tension(self, solved):
        """Return whether a step may have passed over a larger tension.

        It may if by its energy it jumped or a stiff contact detached, or if the tension fell after it had increased.
        """
        last = self.last
        smooth = self._is_smooth(solved)
        if smooth and solved.force <= last.force:
            return False
        missed = _TENSION_ERROR_ON_CURVE if smooth else _TENSION_ERROR
        most = self.stiffness * (last.delta - solved.delta) - last.force
        return most > (1.0 + missed) * max(self.largest, -solved.force)


def _parabola_through(rows):
    """Return the vertex of the parabola through three states, its tension, and that which each step's work adds."""
    offset = rows["delta"] - rows["delta"][1]
    parabola = np.polynomial.Polynomial(np.linalg.solve(np.vander(offset, increasing=True), rows["force"]))
    _, slope, curvature = parabola.coef
    work = np.diff(parabola.integ()(offset))
    vertex = -0.5 * slope / curvature
    missing = (work - np.diff(rows["energy"])) / np.diff(offset)
    return float(rows["delta"][1] + vertex), -float(parabola(vertex)), missing
