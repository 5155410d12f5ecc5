"""Path of a body under a smooth law of adhesion: one loading, any number of turning points, a retraction from each.

Each state is searched from an extrapolation of the last two: of gaps where cells attract, of pressures where they
touch. So the path follows a branch to its end and then descends to another one, as a body held by a stiff device does.
The displacement moves in steps, and the pull-off must not depend on what lies between two of them:

- retraction goes back in whole steps first. Then, from the state beyond which the largest pull may lie, it is
  repeated, and only states near the extrapolation are accepted. Where there is none, a branch has ended or the last
  contact of a stiff body is lost; this end is located by shorter steps, and passed by a leap. Once the path is again
  the one known, it leads on from there. That ends are looked for only where they may matter saves a third of the
  work (``tests/benchmarks/adhesive_cost.py pressed``).
- at the largest pull, states are solved at the vertices of parabolas through three.
- a preload is located by regula falsi.

The energy that a step releases at fixed displacement is dissipated: the work ½(F₀ + F₁)Δδ less the increase of the
energy.

Unit cells and unit modulus.
"""

from typing import NamedTuple

import numpy as np

from .states import Solver

#: Outcomes of a path.
CONVERGED, NOT_FINITE, CELL_LIMIT = range(3)

#: What is told of a state: of yielding, the shares of pushing force and touching cells at the hardness or above, and
#: area and volume of what has given way, in cells.
STATE = np.dtype(
    [
        *((name, float) for name in ("delta", "force", "contact_area", "energy", "dissipated", "contact_patches")),
        *((name, float) for name in ("resolution", "residual", "yielded_fraction", "yielded_area_fraction")),
        *((name, float) for name in ("yielded_area", "plastic_work")),
        ("iterations", int),
        ("converged", bool),
        ("asked", bool),
    ]
)

#: Retraction ends where nothing touches and the pull is below this part of the largest.
_LEAST_PULL = 1e-3

#: A step has jumped if it dissipated more than this part of |ΔF Δδ|, and has passed a sharp edge if it seems to have
#: gained more than the second part: a smooth curved branch stays well below both.
_JUMP_DISSIPATION, _EDGE_GAIN = 0.15, 0.05

#: Avoids 0/0 in ratios.
_TINY = 1e-300

#: Where a branch has ended, the next one is searched some distance beyond: close to the end, convergence is slow, as
#: one over the root of the distance. The leap is at most so many longest steps, and such that at most this part of the
#: largest pull may be missed. It saves a quarter of the work, and its pull-offs are closer to those of short steps.
_LONGEST_LEAP, _LEAP_ERROR = 1.0 / 16, 0.005

#: Largest part of the largest pull that may be missed between two states; part of the longest step below which steps
#: are not halved.
_PULL_ERROR, _SHORTEST_STEP = 0.005, 1.0 / 64

#: The same where a smooth curve may have turned: the tangent is an upper bound, and the vertex is solved afterwards.
_PULL_ERROR_ON_CURVE = 0.05

#: Steps back over those of loading. Longer ones pass from one branch to another that shorter ones do not meet: places
#: of the twin then pull off by up to 17 % less with steps of 0.4 nm, on four cells to a pixel.
_RETRACTION_STEP = 0.5

#: Part of a step within which the last contact is seen to let go: a longer step may let go of what still holds.
_LAST_CONTACT_STEP = 1.0 / 16

#: Part of a step by which the stiffness of a branch is measured.
_STIFFNESS_STEP = 1.0 / 16

#: Largest number of states that are added to locate the largest pull.
_MOST_VERTICES = 4

#: Accuracy of a preload, as a part of it, or of the largest pull if that is more.
_PRELOAD_TOLERANCE = 1e-3

#: Displacements closer than this part of a step count as equal.
_EQUAL_DELTA = 1e-9


class Path(NamedTuple):
    """All states of one cycle in order, and how it ended."""

    states: np.ndarray  # (state,) of STATE; asked: at a prescribed displacement
    turn: int  # first state of the retraction
    status: int
    pressures: np.ndarray  # (asked or 0, nx, ny) p dx/E*, nm, at the prescribed displacements, in the order of the path
    left: np.ndarray  # (asked or 1, nx, ny) nm ≤ 0, residual height after loading to the prescribed displacements


def follow_smooth(
    separation,
    deltas,
    step,
    coefficients,
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
    coefficients : array
        Love's, for all boxes within the window (``halfspace.coefficients_for``).
    law : laws.SmoothLaw
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
        The law stands for one without range: it pulls around contacts only, as far as their edges open within it, and
        not across the gap to what has not touched, unless that gap is smaller than ``capture``.
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
    solver = Solver(separation, coefficients, law, cap, limit, from_contact, capture)
    left = np.zeros(separation.shape) if left is None else left
    loading = _Loading(solver, step, deltas, left, fields=fields)
    return [_path(loading, loading.load(goal)) for goal in goals]


def _path(loading, fine):
    """Return the `Path` that turns back where the loading has arrived."""
    back = _Retraction(loading)
    whole = fine and back.retract()
    visited, shape = loading.visited + (back.visited if fine else []), (0, *loading.solver.separation.shape)
    states = np.array([one.row for one in visited], STATE)
    states["dissipated"] = np.cumsum(states["dissipated"])
    pressures = [one.pressure for one in visited if one.pressure is not None]
    left = [one.left for one in loading.visited if one.left is not None] or [loading.last.left]
    status = CONVERGED if whole else NOT_FINITE
    pressures = np.array(pressures) if pressures else np.zeros(shape)
    return Path(states, len(loading.visited), status, pressures, np.array(left))


class _Visited:
    """A state of the path: what is told of it and, while a larger pull may lie beyond, the state itself."""

    __slots__ = ("before", "known", "left", "most", "pressure", "row", "stiffness")

    def __init__(self, row, known, before, stiffness, pressure=None, left=None):
        self.row, self.known, self.before, self.stiffness = row, known, before, stiffness
        self.pressure, self.left, self.most = pressure, left, -np.inf

    def forget(self):
        """Let go of the state, which is not asked any more."""
        self.known = self.before = None


class _Stepper:
    """Where a path stands, and the states that it has visited."""

    def __init__(self, solver, step, deltas, fields):
        self.solver, self.step, self.deltas, self.fields = solver, step, deltas, fields
        self.visited, self.largest, self.stiffness = [], 0.0, np.inf
        self.before, self.last = None, None

    def accept(self, found, asked):
        """Append a state, which becomes the present one."""
        freed = self._freed(found)
        moved = self.last.delta - found.delta
        if moved != 0.0 and self._is_smooth(found):  # across a jump two states do not give the stiffness
            self.stiffness = (self.last.force - found.force) / moved
        self.before, self.last = self.last, found
        self.largest = max(self.largest, -found.force)
        pressure = left = None
        if asked and self.fields:
            pressure, left = np.zeros(self.solver.separation.shape), found.left
            pressure[found.rows, found.columns] = found.state.pressure
        row = self.row(found, asked, freed)
        self.visited.append(_Visited(row, found, self.before, self.stiffness, pressure, left))

    def row(self, found, asked, freed):
        """Return what is told of a state, with the energy that the step to it has freed in place of their sum."""
        row, state = np.zeros(1, STATE)[0], found.state
        row["delta"], row["force"], row["energy"], row["dissipated"] = found.delta, found.force, found.energy, freed
        row["contact_patches"], row["resolution"] = self.solver.contacts(state)
        row["contact_area"], row["residual"], row["iterations"] = state.touching.sum(), found.residual, found.rounds
        row["converged"], row["asked"] = found.fine, asked
        for name, value in self.solver.yielded(found).items():
            row[name] = value
        return row

    def _is_smooth(self, found):
        """Return whether a step follows a branch, judged by what it dissipates."""
        last = self.last
        apart = abs((last.force - found.force) * (last.delta - found.delta)) + _TINY
        return -_EDGE_GAIN <= self._freed(found) / apart <= _JUMP_DISSIPATION

    def _freed(self, found):
        """Return the energy that the step to a state dissipates, nm²."""
        last = self.last
        return 0.5 * (found.force + last.force) * (found.delta - last.delta) - (found.energy - last.energy)


class _Loading(_Stepper):
    """The way in, through the prescribed displacements and up to preloads."""

    def __init__(self, solver, step, deltas, left, *, fields):
        super().__init__(solver, step, deltas, fields)
        self.seek = solver.press if solver.cap < np.inf else solver.seek
        first = float(solver.separation.min()) - solver.law.onset
        ahead = max(deltas[0] - first, 0.0)  # then whole steps: both ways visit the same displacements
        self.last, self.next = solver.nothing(deltas[0] - step * np.ceil(ahead / step), left), 0

    def load(self, goal):
        """Continue until the force reaches ``goal`` or the last displacement; return whether it converged."""
        over = None  # a state beyond the goal
        while self.next < self.deltas.size:
            target, last = self.deltas[self.next], self.last
            if over is not None and over.delta - last.delta <= _SHORTEST_STEP * self.step:
                found = over  # the force jumps past the goal
            else:
                delta = self._towards(goal, over, target)
                found = self.seek(delta, self.before, last, well=delta == target)
            if not np.isfinite(found.force):
                return False
            reached = found.force >= goal and found.state.touching.any()
            met = found.force - goal <= _PRELOAD_TOLERANCE * max(abs(goal), self.largest)
            if reached and not met and found.delta - last.delta > _SHORTEST_STEP * self.step:
                over = found
                continue
            self.accept(found, found.delta == target)
            self.visited[-1].forget()
            self.next += found.delta == target
            if reached:
                break
        return True

    def _towards(self, goal, over, target):
        """Return the next displacement on loading: a step ahead, or towards a goal that the state ``over`` exceeds."""
        last = self.last
        delta = last.delta + self.step
        if over is not None:
            part = (goal - last.force) / (over.force - last.force)
            delta = last.delta + min(max(part, 0.05), 0.95) * (over.delta - last.delta)
        return float(target) if target - delta < _EQUAL_DELTA * self.step else float(delta)


class _EndSearch:
    """How far to go back where the end of a branch is looked for: by shorter steps up to it, then a leap past it."""

    def __init__(self, path, step):
        self.path, self.step, self.beyond, self.least = path, step, None, _SHORTEST_STEP * path.step

    def ahead(self, target):
        """Return the next displacement, up to a target, and whether only a state near the extrapolation will do."""
        path, last = self.path, self.path.last
        leaps = self.beyond is not None and last.delta - self.beyond < 2.0 * self.least
        back = min(self._leap() if leaps else self.step, last.delta - target)
        delta = float(target) if last.delta - back - target < _EQUAL_DELTA * path.step else last.delta - back
        near = not leaps and back > self.least and not path.is_lost() and path.leads_to_more(back)
        return delta, near

    def fails(self, found):
        """Note that a branch ends before this state, or a larger pull was passed."""
        self.step, self.beyond = self._shorter(found), found.delta

    def passes(self, found, near):
        """Note that the path goes on to this state, from the present one."""
        back = self.path.last.delta - found.delta
        if near and self.beyond is not None and self.beyond < found.delta:
            self.step = 0.5 * (found.delta - self.beyond)
        else:
            self.step, self.beyond = min(_RETRACTION_STEP * self.path.step, max(self.step, 2.0 * back)), None

    def _leap(self):
        """Return how far to leap beyond the end of a branch."""
        far = _LEAP_ERROR * self.path.largest / max(self.path.stiffness, _TINY)
        return min(max(far, self.least), _LONGEST_LEAP * self.path.step)

    def _shorter(self, found):
        """Return a step to where the extrapolation has the pull that was found, or half as far as that state.

        A stiff body lets go within a small part of a step, which is so found in three tries instead of ten.
        """
        last = self.path.last
        half, leads = 0.5 * (last.delta - found.delta), (last.force - found.force) / (self.path.stiffness or np.inf)
        return max(min(half, leads) if leads > 0.0 and found.fine else half, self.least)


class _Retraction(_Stepper):
    """The way back from where the loading stands, until contact is lost; it finds the largest pull."""

    def __init__(self, loading):
        super().__init__(loading.solver, loading.step, loading.deltas, loading.fields)
        self.before, self.last, self.stiffness = loading.before, loading.last, loading.stiffness
        self.first = float(self.solver.separation.min()) - self.solver.law.onset
        if loading.visited:  # it begins with the present state
            turn = loading.visited[-1]
            row = turn.row.copy()
            row["dissipated"] = 0.0
            self.visited.append(_Visited(row, self.last, self.before, self.stiffness, turn.pressure))

    def retract(self):
        """Go back through the prescribed displacements, then on until contact is lost; return whether it converged."""
        same = _EQUAL_DELTA * self.step
        asked = [float(delta) for delta in self.deltas[::-1] if delta < self.last.delta - same]
        fine = self._walk([(delta, True) for delta in asked])
        while fine and (place := self._doubtful()) is not None:
            fine = self._repeat(place)
        if fine:
            self._largest_pull()
        return fine

    def _walk(self, ahead):
        """Go back in whole steps through the displacements ahead, and on by shorter ones until contact is lost."""
        whole = change = _RETRACTION_STEP * self.step
        while ahead or not self.is_lost():
            last, (target, asked) = self.last, ahead[0] if ahead else (-np.inf, False)
            back = last.delta - target if self.is_lost() else min(change, last.delta - target)
            delta = target if last.delta - back - target < _EQUAL_DELTA * self.step else last.delta - back
            found = self.solver.seek(delta, self.before, last, well=asked and delta == target)
            if not np.isfinite(found.force):
                return False
            if self._lets_go(found):
                change = 0.5 * back
                continue
            self._judge(found)
            jumped = not self._is_smooth(found)
            self.accept(found, asked and delta == target)
            if jumped:
                self._measure_stiffness()
            self._forget()
            ahead, change = ahead[1:] if delta == target else ahead, min(whole, max(change, 2.0 * back))
        return True

    def _measure_stiffness(self):
        """Take the stiffness of the present branch, which a jump has led to, from a short step."""
        last = self.last
        found = self.solver.seek(last.delta - _STIFFNESS_STEP * self.step, None, last, near=True, well=False)
        if found.fine and self._is_smooth(found):
            self.stiffness = self.visited[-1].stiffness = (last.force - found.force) / (last.delta - found.delta)

    def _judge(self, found):
        """Note what pull may have been passed on the way to a state."""
        if self.visited and self._passed_more(found):
            last = self.last
            self.visited[-1].most = self.stiffness * (last.delta - found.delta) - last.force

    def _forget(self):
        """Let go of states beyond which no larger pull can lie, but for the largest pull's own and the one after it."""
        before = None
        for one in self.visited[:-2]:
            pulls_most = any(-each.row["force"] >= self.largest for each in (one, before or one))
            if one.most <= (1.0 + _PULL_ERROR) * self.largest and not pulls_most:
                one.forget()
            before = one

    def _doubtful(self):
        """Return the place of the state beyond which the largest pull may lie; None where it is known already."""
        self.largest = max((-one.row["force"] for one in self.visited), default=0.0)
        asked = [(one.most, k) for k, one in enumerate(self.visited) if one.known is not None]
        most, place = max(asked, default=(0.0, 0))
        return place if most > (1.0 + _PULL_ERROR) * self.largest else None

    def _repeat(self, place):
        """Go back from a state once more, and find where branches end, until the path is the known one again."""
        known, self.visited = self.visited[place + 1 :], self.visited[: place + 1]
        start, search = self.visited[-1], _EndSearch(self, _RETRACTION_STEP * self.step)
        self.before, self.last, self.stiffness, start.most = start.before, start.known, start.stiffness, -np.inf
        if known and known[0].known is not None:  # the whole step is known to pass the largest pull
            search.fails(known[0].known)
        while known or not self.is_lost():
            if self.is_lost():  # nothing happens on the way
                known, search = [one for one in known if one.row["asked"]], _EndSearch(self, np.inf)
                if not known:
                    break
            target, asked = (known[0].row["delta"], bool(known[0].row["asked"])) if known else (-np.inf, False)
            delta, near = search.ahead(target)
            there = delta == target
            found = self.solver.seek(delta, self.before, self.last, near=near, well=there and asked)
            if self._is_beyond_an_end(found, near):
                search.fails(found)
                continue
            if not np.isfinite(found.force):
                return False
            search.passes(found, near)
            self.accept(found, there and asked)
            self._forget()
            if there and self._is_same(known[0]) and (known[1:] or self.is_lost()):
                self._join(known[0], known[1:])
                break
            known = known[1:] if there else known
        return True

    def _is_beyond_an_end(self, found, near):
        """Return whether a branch ends, or a larger pull lies, between the present state and this one."""
        if not np.isfinite(found.force):
            return near
        return self._lets_go(found) or (near and (not found.fine or self._passed_more(found)))

    def _join(self, same, beyond):
        """Go on by the known path, of which a larger pull is expected only if the present stiffness says so, too."""
        here, last = self.visited[-1], self.last
        if beyond:
            row = beyond[0].row
            here.most = min(same.most, self.stiffness * (last.delta - row["delta"]) - last.force)
            work = 0.5 * (row["force"] + last.force) * (row["delta"] - last.delta)
            row["dissipated"] = work - (row["energy"] - last.energy)
        self.visited += beyond

    def _lets_go(self, found):
        """Return whether a step loses the last contact, and is too long to tell where."""
        lost = self.last.state.touching.any() and not found.state.touching.any()
        return bool(lost and self.last.delta - found.delta > _LAST_CONTACT_STEP * self.step)

    def _is_same(self, other):
        """Return whether the present state is another one at the same displacement."""
        here, there = self.visited[-1].row, other.row
        cells = abs(here["contact_area"] - there["contact_area"])
        pulls_alike = abs(here["force"] - there["force"]) <= _PULL_ERROR * self.largest
        return pulls_alike and cells <= max(0.01 * there["contact_area"], 1.0)

    def leads_to_more(self, back):
        """Return whether the branch, with its last stiffness, leads to a larger pull than any before within a step."""
        return self.stiffness * back - self.last.force > (1.0 + _PULL_ERROR) * self.largest

    def is_lost(self):
        """Return whether nothing touches, and almost nothing pulls."""
        last = self.last
        if last.state.touching.any():
            return False
        return last.delta <= self.first or (
            -last.force < _LEAST_PULL * self.largest and last.delta < self._largest_at()
        )

    def _largest_at(self):
        """Return the displacement of the largest pull so far: a force of zero before it is one that turns to a pull."""
        return min(self.visited, key=lambda one: one.row["force"]).row["delta"] if self.visited else np.inf

    def _passed_more(self, found):
        """Return whether a step may have passed over a larger pull.

        It may if, by its energy, it jumped or a stiff contact let go, or if the pull fell although it was growing.
        """
        last, smooth = self.last, self._is_smooth(found)
        if smooth and found.force <= last.force:
            return False
        missed = _PULL_ERROR_ON_CURVE if smooth else _PULL_ERROR
        most = self.stiffness * (last.delta - found.delta) - last.force
        return most > (1.0 + missed) * max(self.largest, -found.force)

    def _largest_pull(self):
        """Solve the state of the largest pull as well as is asked, and those at vertices of parabolas through three."""
        best = int(np.argmin([one.row["force"] for one in self.visited])) if self.visited else 0
        if not 0 < best < len(self.visited) - 1:
            return
        if self.visited[best].known is None:  # what pulled more was replaced by another branch
            return
        state, beyond = self._mended(best), self.visited[best + 1].known
        for _ in range(_MOST_VERTICES):
            around = np.array([one.row for one in self.visited[best - 1 : best + 2]], STATE)
            (x0, x1, x2), (f0, f1, f2) = around["delta"], around["force"]
            if not (x0 > x1 > x2 and f1 < f0 and f1 < f2):
                return
            first, second = (f1 - f0) / (x1 - x0), (f2 - f1) / (x2 - x1)
            curvature = (second - first) / (x2 - x0)
            delta = 0.5 * (x0 + x1) - 0.5 * first / curvature
            if f1 - curvature * (delta - x1) ** 2 > (1.0 + _PULL_ERROR) * f1:
                return
            found = self.solver.seek(float(delta), beyond, state)
            if not found.fine or found.force >= f1:
                return
            best += delta < x1
            self.visited.insert(best, _Visited(self.row(found, False, 0.0), None, None, np.nan))

    def _mended(self, place):
        """Return the state at a place, solved as well as is asked if it was on the way only.

        Where that is another state, the branch ended just before, and the first stays: the end of the branch is as
        close to it as its residual is small.
        """
        one = self.visited[place]
        if one.row["asked"]:
            return one.known
        found = self.solver.seek(one.known.delta, None, one.known)
        if found.fine and abs(found.force - one.row["force"]) < _PULL_ERROR * self.largest:
            one.row, one.known = self.row(found, False, one.row["dissipated"]), found
        return one.known
