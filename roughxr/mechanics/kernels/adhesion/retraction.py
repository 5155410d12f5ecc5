"""The retraction of a path: from a turning point until contact is lost, with the largest tension.

It takes whole steps first. It is then repeated from the state beyond which the largest tension may lie, and only states
near the last one are accepted. If there is none, a branch has ended or the last contact of a stiff body is lost;
shorter steps locate this end. Once the path coincides with the known path again, it continues on that. Ends that cannot
change the largest tension are not located, which saves a third of the work.

The state of the largest tension is refined until neither a parabola through it and its neighbours nor the work of the
steps between them leaves room for a larger one. Stiff bodies pull most at first touch, within a fraction of a step.
"""

import numpy as np

from .states import INTERMEDIATE_TOLERANCE
from .steps import EQUAL_DELTA, SHORTEST_STEP, STATE, Stepper, Visit

#: Retraction ends where nothing touches and the tension is below this part of the largest.
_LEAST_TENSION = 1e-3

#: Largest error of the largest tension by states missed between two steps.
_TENSION_ERROR = 0.005

#: The same error on a smooth curve that may have turned: there the tangent is an upper bound.
_TENSION_ERROR_ON_CURVE = 0.05

#: Largest number of states that refine the largest tension, and their least distance from the ends of a step, as a part
#: of the step.
_MOST_TRIALS = 8
_LEAST_PART = 0.125

#: An end is located once a state before it is nearer than this number of shortest steps. No binary fraction, unlike
#: steps, so that rounding does not decide.
_AT_END = 2.3

#: Steps below this number of shortest steps are not halved. No binary fraction, either.
_SHORT = 1.3

#: Steps of retraction over those of loading. Longer steps jump to branches that shorter ones do not meet: pull-off
#: forces on the twin are then up to 17 % lower, with steps of 0.4 nm and 4 × 4 cells a pixel.
_RETRACTION_STEP = 0.5


class _EndSearch:
    """The steps of a search for the end of a branch, and a displacement before which the branch has ended."""

    def __init__(self, longest, shortest):
        self.longest = longest
        self.shortest = shortest
        self.step = longest
        self.beyond = None

    def next_step(self, delta):
        """Return the next step from a displacement: the shortest where the end is located."""
        return self.shortest if self._is_at_end(delta) else self.step

    def may_shorten(self, delta, moved):
        """Return whether a step from a displacement can be shortened, so that only a state near the last will do."""
        return not self._is_at_end(delta) and moved > _SHORT * self.shortest

    def shorten(self, delta, beyond):
        """Halve a step from ``delta`` to ``beyond``, before which the branch has ended."""
        self.step = max(0.5 * (delta - beyond), self.shortest)
        self.beyond = beyond

    def go_on(self, delta, reached, *, near):
        """Choose the next step after one from ``delta`` to ``reached``."""
        if near and self.beyond is not None and self.beyond < reached:
            self.step = 0.5 * (reached - self.beyond)
        else:
            self.step = min(self.longest, max(self.step, 2.0 * (delta - reached)))
            self.beyond = None

    def leap(self):
        """Step from one prescribed displacement to the next."""
        self.step = np.inf
        self.beyond = None

    def _is_at_end(self, delta):
        return self.beyond is not None and delta - self.beyond < _AT_END * self.shortest


class Retraction(Stepper):
    """The retraction from the present state of loading until contact is lost; it finds the largest tension."""

    def __init__(self, loading, observe, *, known=()):
        super().__init__(loading.solver, loading.step, loading.deltas, loading.fields)
        self.last = loading.last
        self.stiffness = loading.stiffness
        self.first = float(self.solver.separation.min()) - self.solver.law.onset
        self.observe = observe
        self.known = known  # the states of a retraction from a smaller displacement
        if loading.visited:  # it begins with the present state
            turn = loading.visited[-1]
            row = turn.row.copy()
            row["dissipated"] = 0.0
            self.visited.append(Visit(row, self.last, self.stiffness, turn.pressure))
            self._observe(self.visited[-1])

    def accept(self, solved, prescribed):
        """Append a state, which becomes the present state."""
        super().accept(solved, prescribed)
        self._observe(self.visited[-1])

    def _observe(self, visit):
        if self.observe is not None:
            visit.observed = self.observe(visit.solved)

    @property
    def tension(self):
        """The largest tension, nm; 0 without any."""
        return max((-visit.row["force"] for visit in self.visited if visit.row["force"] < 0.0), default=0.0)

    def retract(self):
        """Retract through the prescribed displacements until contact is lost; return whether all states are finite.

        It ends where it meets a known retraction, and continues on that.
        """
        same = EQUAL_DELTA * self.step
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
            known = self._known_within(step)
            delta = self._delta_after(step, targets[0] if targets else -np.inf)
            if known:
                delta = max(delta, float(known[0].row["delta"]))
            at_target = bool(targets) and delta == targets[0]
            solved = self.solver.solve(delta, self.last, exact=at_target)
            if not np.isfinite(solved.force):
                return False
            if self.visited and self._may_miss_tension(solved):
                self.visited[-1].most = self.stiffness * (self.last.delta - delta) - self.last.force
            self.accept(solved, at_target)
            self._forget()
            targets = targets[1:] if at_target else targets
            if known and delta == known[0].row["delta"] and self._coincides(known[0]):
                self._join(known[0], known[1:])
                break
        return True

    def _known_within(self, step):
        """Return the states of the known retraction from the last one within a step; none if they begin farther."""
        below = [visit.row["delta"] for visit in self.known if visit.row["delta"] < self.last.delta]
        within = sum(delta >= self.last.delta - step for delta in below)
        return self.known[len(self.known) - len(below) + within - 1 :] if within else []

    def _delta_after(self, step, target):
        """Return the displacement after a step of retraction, or the target if that is nearer."""
        delta = self.last.delta - min(step, self.last.delta - target)
        return float(target) if delta - target < EQUAL_DELTA * self.step else float(delta)

    def _forget(self):
        """Free the memory of states beyond which no larger tension can lie, except the last two, and the largest."""
        for visit, following in zip(self.visited[:-2], self.visited[1:]):
            if visit.solved is None or visit.most > (1.0 + _TENSION_ERROR) * self.largest:
                continue
            if -min(visit.row["force"], following.row["force"]) < self.largest:
                visit.solved = None

    def _doubtful_state(self):
        """Return the index of the state beyond which the largest tension may lie; None if that tension is known."""
        self.largest = self.tension
        stored = [(visit.most, k) for k, visit in enumerate(self.visited) if visit.solved is not None]
        most, index = max(stored, default=(0.0, 0))
        return index if most > (1.0 + _TENSION_ERROR) * self.largest else None

    def _locate_ends(self, index):
        """Retract again from a state, and locate the ends of branches, until the path joins the known path."""
        following = self.visited[index + 1 :]
        self.visited = self.visited[: index + 1]
        start = self.visited[-1]
        self.last = start.solved
        self.stiffness = start.stiffness
        start.most = -np.inf
        search = _EndSearch(_RETRACTION_STEP * self.step, SHORTEST_STEP * self.step)
        if following and following[0].solved is not None:
            search.shorten(self.last.delta, following[0].solved.delta)
        while following or not self.is_lost():
            if self.is_lost():  # nothing happens between the prescribed displacements
                following = [visit for visit in following if visit.row["prescribed"]]
                if not following:
                    break
                search.leap()
            target = following[0].row["delta"] if following else -np.inf
            delta = self._delta_after(search.next_step(self.last.delta), target)
            at_target = delta == target
            prescribed = at_target and bool(following[0].row["prescribed"])
            solved = self._solved_before_end(search, delta, exact=prescribed)
            if solved is None:
                continue
            if not np.isfinite(solved.force):
                return False
            self.accept(solved, prescribed)
            self._forget()
            if at_target and self._is_same(following[0]) and (following[1:] or self.is_lost()):
                self._join(following[0], following[1:])
                break
            following = following[1:] if at_target else following
        return True

    def _solved_before_end(self, search, delta, *, exact):
        """Return the state at a displacement; None, with shorter steps to come, if its branch ends before."""
        moved = self.last.delta - delta
        near = search.may_shorten(self.last.delta, moved) and not self.is_lost() and self._may_reach_largest(moved)
        solved = self.solver.solve(delta, self.last, near=near, exact=exact)
        if near and (not solved.converged or self._may_miss_tension(solved)):
            search.shorten(self.last.delta, delta)
            return None
        if np.isfinite(solved.force):
            search.go_on(self.last.delta, delta, near=near)
        return solved

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

    def _coincides(self, other):
        """Return whether the present state equals another one but for the tolerance of a solve."""
        row = self.visited[-1].row
        same_force = abs(row["force"] - other.row["force"]) <= INTERMEDIATE_TOLERANCE * self.largest
        return same_force and row["contact_area"] == other.row["contact_area"]

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
            self.visited.insert(following, Visit(self._row(solved, False, 0.0), solved, np.nan))
            self._observe(self.visited[following])
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
        if last.delta <= self.first or -last.force >= _LEAST_TENSION * self.largest:
            return last.delta <= self.first
        largest_at = min(self.visited, key=lambda visit: visit.row["force"]).row["delta"] if self.visited else np.inf
        return last.delta < largest_at  # the force also vanishes before it turns to a tension

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
