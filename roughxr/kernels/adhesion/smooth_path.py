"""Path of a body under a smooth law of adhesion: one loading, any number of turning points, a retraction from each.

Each state is searched from an extrapolation of the last two: of gaps where cells attract, of pressures where they
touch. So the path follows a branch to its end and then descends to another one, as a body held by a stiff device does.
The displacement moves in steps, and the result must not depend on what lies between two of them:

- while the pull may still exceed the largest, only states near the extrapolation are accepted. Where there is none, a
  branch has ended or the last contact of a stiff body is lost; this end is located by shorter steps, and passed by a
  leap.
- where the force passed a minimum, one more state is solved at the vertex of the parabola through three.
- a preload is located by regula falsi.

At each displacement only the bounding box of the cells within the law's range is solved. The energy that a step
releases at fixed displacement is dissipated: the work ½(F₀ + F₁)Δδ less the increase of the energy.

A body that yields bears p ≤ H (``halfspace.yielding``). Where a state on loading exceeds this, the surface gives way
until it does not, with the attraction of that state held, and the state is solved again on the dented surface. What
has given way stays, and retraction is elastic.

Unit cells and unit modulus.
"""

import itertools
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from ..halfspace import displacement_control, yielding
from ..halfspace.products import surface_displacement
from ..halfspace.transforms import convolution, even_length, transfer_of
from .smooth_equilibrium import Body, State, closed_parts, energy, settle
from .smooth_laws import traction
from .smooth_patches import contacts_and_resolution
from .smooth_prediction import ahead

#: Outcomes of a path.
CONVERGED, NOT_FINITE, CELL_LIMIT = range(3)

#: Columns of a state.
DELTA, FORCE, AREA, ENERGY, DISSIPATED, CONTACTS, RESOLUTION, ITERATIONS, OK, ASKED, RESIDUAL = range(11)

#: Retraction ends where nothing touches and the pull is below this part of the largest.
_LOST = 1e-3

#: A step has jumped if it dissipated more than this part of |ΔF Δδ|, and has passed a sharp edge if it seems to have
#: gained more than the second part: a smooth curved branch stays well below both.
_JUMP, _EDGE = 0.15, 0.05

#: Avoids 0/0 in ratios.
_TINY = 1e-300

#: Where a branch has ended, the next one is searched some distance beyond: close to the end, convergence is slow, as
#: one over the root of the distance. The leap is at most so many longest steps, and such that at most this part of the
#: largest pull may be missed. It saves a quarter of the work, and its pull-offs are closer to those of short steps.
_LEAP, _PASSED = 1.0 / 16, 0.005

#: Largest part of the largest pull that may be missed between two states; part of the longest step below which steps
#: are not halved.
_MISSED, _LEAST_STEP = 0.002, 1.0 / 64

#: The same where a smooth curve may have turned: the tangent is an upper bound, and the vertex is solved afterwards.
_MISSED_IN_A_CURVE = 0.05

#: Largest number of states that are added to locate the largest pull.
_VERTICES = 4

#: Accuracy of a preload, as a part of it, or of the largest pull if that is more.
_MET = 1e-3

#: The sides of boxes are multiples of this many cells, so that few transforms of the coefficients are needed.
_ALIKE = 16

#: Boxes reach so many cells beyond what was within range or pulled: few states then need a larger box.
_BESIDE = 3

#: Residual, over the largest traction, that a state must meet, and one in between, which is neither at a prescribed
#: displacement nor at the largest pull. It saves a quarter of the work; pull-offs change by 0.2 %.
TOLERANCE, ON_THE_WAY = 1e-5, 1e-3

#: Displacements closer than this part of a step count as equal.
_SAME = 1e-9


#: Yield of a state: force and area of the cells at the hardness or above, over those of all cells that push or touch;
#: the area that has given way, in cells, and its volume.
HARD_FORCE, HARD_AREA, DENT_AREA, DENT = range(4)

#: On loading a state may exceed the hardness by this part. Else it gives way, at most so many times, each time by an
#: amount found to this part of the deepest overlap.
_OVER, _DENTS, _DENT_TOLERANCE = 1e-3, 6, 1e-5

#: How far the edge of a contact opens within a law without range, in cells times the steepness of the law: π E* b²/16w
#: by Griffith's edge. Overlaps of more than the second part of the range are contacts. Distances are taken as round.
_OPENS, _CLOSES = 1.2, 1e-3
_ROUND = ndimage.generate_binary_structure(2, 1)

#: Marks what has touched, beside 1 for what is around it.
_TOUCHED = 2

#: Part of the largest traction above which the pull of a cell matters in deciding how large a box must be.
_PULLS = 2e-3

#: Margin, in cells, of the linear systems' part of the box around the cells that belong to them now.
_MARGIN = 6


class Path(NamedTuple):
    """All states of one cycle in order, and how it ended."""

    states: np.ndarray  # (state, DELTA … ASKED)
    turn: int  # first state of the retraction
    status: int
    pressures: np.ndarray  # (asked or 0, nx, ny) p dx/E*, nm, at the prescribed displacements, in the order of the path
    hard: np.ndarray  # (state, HARD_FORCE … DENT)
    left: np.ndarray  # (asked or 1, nx, ny) nm ≤ 0, residual height after loading to the prescribed displacements


class Known(NamedTuple):
    """One state: on the box of the cells within range, at (rows, columns) of the window."""

    delta: float
    force: float
    energy: float
    rows: slice
    columns: slice
    state: State
    rounds: int
    fine: bool
    residual: float  # over the largest traction
    left: np.ndarray  # (nx, ny) of the window: residual height
    near: np.ndarray | None = None  # (nx, ny) of the window: where a law without range has touched, and may pull
    opens: bool = False  # it may pull where it was not yet allowed to


def follow_smooth(
    separation,
    deltas,
    step,
    coefficients,
    law,
    *,
    preloads=(),
    tolerance=TOLERANCE,
    max_rounds=200,
    max_cells=10**7,
    fields=False,
    cap=np.inf,
    limit=np.inf,
    left=None,
    from_contact=False,
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
    tolerance : float
        Residual traction over the largest, at ``deltas`` and at the largest pull.
    max_rounds : int
        Largest number of linear systems per state.
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
        not across the gap to what has not touched.

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
        return [Path(np.zeros((0, 11)), 0, CELL_LIMIT, no_fields, np.zeros((0, 4)), no_fields) for _ in goals]
    solver = _Solver(separation, coefficients, law, tolerance, max_rounds, cap, limit, from_contact)
    left = np.zeros(separation.shape) if left is None else left
    loading = _Branch(solver, step, deltas, fields, left, yields=cap < np.inf)
    return [_path(loading, loading.load(goal), fields) for goal in goals]


def _path(loading, fine, fields):
    """Return the `Path` that turns back where the loading has arrived."""
    back = loading.turned()
    fine = fine and back.retract()
    pressures = (
        np.array(loading.pressures + back.pressures) if fields else np.zeros((0, *loading.solver.separation.shape))
    )
    rows = np.array(loading.rows + back.rows).reshape(-1, 15)
    left = np.array(loading.left if fields and loading.left else [loading.last.left])
    status = CONVERGED if fine else NOT_FINITE
    return Path(rows[:, :11], len(loading.rows), status, pressures, rows[:, 11:], left)


class _Solver:
    """Finds the states of one body."""

    def __init__(self, separation, coefficients, law, tolerance, max_rounds, cap, limit, from_contact):
        self.separation, self.coefficients, self.law = separation, coefficients, law
        self.cap, self.limit = cap, limit
        self.tolerance, self.max_rounds = float(tolerance), int(max_rounds)
        self.transfers = {}
        self.around = int(np.ceil(_OPENS / law.steepest)) + 2 if from_contact and law.work > 0 else 0

    def nothing(self, delta, left):
        """Return the state without any traction."""
        rows, columns = self._box(delta)
        separation = self.separation[rows, columns] - left[rows, columns]
        state = State(np.zeros(separation.shape), separation - delta, np.zeros(separation.shape, bool))
        near = np.zeros(self.separation.shape, np.int8) if self.around else None
        return Known(delta, 0.0, 0.0, rows, columns, state, 0, True, 0.0, left, near)

    def press(self, delta, before, last, *, well=True):
        """Return the state at a displacement on loading: the surface gives way until it bears the pressure."""
        found = self.seek(delta, before, last, well=well)
        for _ in range(_DENTS):
            if not found.state.pressure.max() > (1.0 + _OVER) * self.cap:
                break
            dented = found._replace(left=self._dented(found))
            rounds, found = found.rounds, self.seek(delta, None, dented, well=well)
            found = found._replace(rounds=found.rounds + rounds)
        else:
            found = found._replace(fine=found.fine and not found.state.pressure.max() > (1.0 + _OVER) * self.cap)
        return found

    def _dented(self, found):
        """Return the residual height once the surface has given way under too large pressures, at fixed attraction."""
        at, state, most = (found.rows, found.columns), found.state, traction(0.0, self.law)[0]
        held = np.where(state.touching, most, np.maximum(-state.pressure, 0.0))
        separation = self.separation[at] - found.left[at] - surface_displacement(held, 1.0, 1.0)
        bears = np.where(state.touching, np.clip(state.pressure + held, 0.0, self.cap + most), 0.0)
        touching = (bears > 0.0) & (bears < self.cap + most)
        hardness, deltas = displacement_control.Hardness(self.cap + most), np.array([found.delta])
        _, pressure, displacement = displacement_control.sweep_arrays(
            separation,
            deltas,
            1.0,
            1.0,
            tolerance=_DENT_TOLERANCE,
            start=displacement_control.WarmStart(bears, touching, bears > 0.0),
            hardness=hardness,
            keep=1,
        )
        left = found.left.copy()
        left[at] += yielding.residual_heights(pressure, displacement, separation, deltas, hardness.pressure)[0]
        return left

    def seek(self, delta, before, last, *, near=False, well=True):
        """Return the state at a displacement, extrapolated from two others, on the surface left by the last one.

        With ``near`` it is given up, and not ``fine``, where there is no state close to the extrapolation. Unless
        ``well`` it is a state in between, which need not be solved closer than ``ON_THE_WAY``.
        """
        for margin in itertools.count(_BESIDE, _ALIKE):
            rows, columns = self._box(delta, last, margin)
            found = self._seek_in(rows, columns, delta, before, last, near=near, well=well)
            while found.opens and np.isfinite(found.force):
                before, last = None, found._replace(near=found.near)
                found = self._seek_in(rows, columns, delta, before, last, near=near, well=well)
            if not self._pulls_at_edge(found):
                return found

    def _where_it_pulls(self, rows, columns, delta, sinks, state, last):
        """Return where contacts are or would be and what is around them, and whether anything new there may pull.

        Contacts that grow by less than what is around them ask for no second solve, which halves the work.
        """
        near = last.near[rows, columns]
        gap = self.separation[rows, columns] - last.left[rows, columns] + sinks - delta
        touches = (near < _TOUCHED) & (state.touching | ((gap < -_CLOSES * self.law.range) & (near == 0)))
        if not touches.any():
            return last.near, False
        grown = last.near.copy()
        grown[rows, columns][touches] = _TOUCHED
        wider = tuple(slice(max(part.start - self.around, 0), part.stop + self.around) for part in (rows, columns))
        around = ndimage.binary_dilation(grown[wider] == _TOUCHED, _ROUND, self.around)
        np.maximum(grown[wider], around, out=grown[wider])
        return grown, bool(((grown[rows, columns] > 0) & (near == 0) & (gap < self.law.range)).any())

    def _seek_in(self, rows, columns, delta, before, last, *, near, well):
        """Return the state of the cells of a box."""
        start = self._moved(last, rows, columns)
        trial = State(*(values.copy() for values in start))
        if before is not None and before.delta != last.delta:
            ratio = max((delta - last.delta) / (last.delta - before.delta), -2.0)
            ahead(trial, self._moved(before, rows, columns), min(ratio, 2.0), self.law)
        shape, left = trial.gap.shape, last.left
        separation = np.ascontiguousarray(self.separation[rows, columns] - left[rows, columns])
        if self.around:
            separation[last.near[rows, columns] == 0] = np.inf
        for part in (self._part(trial), (slice(0, shape[0]), slice(0, shape[1]))):
            body = self._body(separation, part, self.tolerance if well else max(self.tolerance, ON_THE_WAY))
            state = State(*(values.copy() for values in trial))
            out = settle(body, delta, start, state, near)
            if out.residual < np.inf:
                break
        force = float(state.pressure.sum())
        held = energy(separation, self.law, delta, state)
        around = None, False
        if self.around:
            sinks = body.exact.box[:, : shape[1]] if out.fine else surface_displacement(state.pressure, 1.0, 1.0)
            around = self._where_it_pulls(rows, columns, delta, sinks, state, last)
        fine = out.fine and bool(np.isfinite(force))  # comparisons with NaN hide it from the residual
        return Known(delta, force, held, rows, columns, state, out.rounds, fine, out.residual, left, *around)

    def contacts(self, state):
        """Return the number of contacts, and how well the mesh resolves them."""
        return contacts_and_resolution(state, closed_parts(state, self.law), self.law)

    def yielded(self, found):
        """Return ``HARD_FORCE`` … ``DENT`` of a state."""
        pressure, least = found.state.pressure, self.limit * (1.0 - 2.0 * _OVER if self.cap < np.inf else 1.0)
        hard, pushes, touching = pressure >= least, max(pressure.clip(min=0.0).sum(), 1e-300), found.state.touching
        shares = pressure[hard].sum() / pushes, np.count_nonzero(hard) / max(np.count_nonzero(touching), 1)
        return *shares, np.count_nonzero(found.left), np.abs(found.left).sum()

    def _box(self, delta, last=None, margin=0):
        """Return the rows and columns of the box that holds all cells within range, and those that pulled before."""
        within = self.separation < delta + self.law.range
        if last is not None:
            within[last.rows, last.columns] |= np.abs(last.state.pressure) > _PULLS * self.law.strength
        return tuple(_rounded(np.flatnonzero(within.any(axis)), within.shape[1 - axis], margin) for axis in (1, 0))

    def _pulls_at_edge(self, found):
        """Return whether adhesion draws the surface up as far as a side of the box beyond which there is more of it."""
        pulls = np.abs(found.state.pressure) > _PULLS * self.law.strength
        for side, part, size in zip((pulls, pulls.T), (found.rows, found.columns), self.separation.shape):
            if (part.start > 0 and side[:1].any()) or (part.stop < size and side[-1:].any()):
                return True
        return False

    def _moved(self, known, rows, columns):
        """Return a state on another box; cells outside the old one have no traction."""
        shape = rows.stop - rows.start, columns.stop - columns.start
        state = State(np.zeros(shape), np.full(shape, np.inf), np.zeros(shape, bool))
        (a, b), (c, d) = _shared(known.rows, rows), _shared(known.columns, columns)
        for old, new in zip(known.state, state):
            new[b, d] = old[a, c]
        return state

    def _part(self, state):
        """Return the rows and columns of a box that contains all cells of the linear systems, with a margin."""
        gap = np.maximum(state.gap, 0.0)
        near = state.touching | (gap < self.law.onset)
        return tuple(_rounded(np.flatnonzero(near.any(axis)), near.shape[1 - axis], _MARGIN) for axis in (1, 0))

    def _body(self, separation, part, tolerance):
        whole, near = separation.shape, tuple(p.stop - p.start for p in part)
        high, wide = even_length(2 * whole[0] - 1), even_length(2 * whole[1] - 1)
        transfer = self._transfer(high, wide)
        exact = convolution(whole[0], wide, transfer.double, np.complex128(0))
        quick = convolution(whole[0], wide, transfer.single, np.complex64(0))
        high, wide = even_length(near[0]), even_length(near[1])
        product = convolution(near[0], 2 * wide, self._transfer(2 * high, 2 * wide).single, np.complex64(0))
        inverse = convolution(near[0], wide, self._inverse(high, wide), np.complex64(0))
        first = part[0].start, part[1].start
        return Body(
            separation,
            self.coefficients,
            self.law,
            tolerance,
            self.max_rounds,
            exact,
            quick,
            first,
            product,
            inverse,
        )

    def _transfer(self, rows, columns):
        if (rows, columns) not in self.transfers:
            self.transfers[rows, columns] = transfer_of(rows, columns, self.coefficients)
        return self.transfers[rows, columns]

    def _inverse(self, rows, columns):
        """Return the inverse of transformed coefficients, like these divided by the number of cells."""
        key = "inverse", rows, columns
        if key not in self.transfers:
            self.transfers[key] = (1.0 / ((rows * columns) ** 2 * self._transfer(rows, columns).double)).astype(
                np.float32
            )
        return self.transfers[key]


def _rounded(places, size, margin):
    """Return a slice around some cells, with one of few lengths."""
    if places.size == 0:
        return slice(0, min(_ALIKE, size))
    first, end = places[0] - margin, places[-1] + 1 + margin
    length = min(_ALIKE * -(-(end - first) // _ALIKE), size)
    first = min(max(first, 0), size - length)
    return slice(first, first + length)


def _shared(old, new):
    """Return the intersection of two slices, as a slice within each of them."""
    first, end = max(old.start, new.start), max(min(old.stop, new.stop), max(old.start, new.start))
    return slice(first - old.start, end - old.start), slice(first - new.start, end - new.start)


class _Branch:
    """The states along one branch of the path, and the present one."""

    def __init__(self, solver, step, deltas, fields, left, yields=False):
        self.solver, self.step, self.deltas, self.fields = solver, step, deltas, fields
        self.seek = solver.press if yields else solver.seek
        self.rows, self.pressures, self.left, self.largest, self.dissipated = [], [], [], 0.0, 0.0
        self.before, self.next, self.stiffness = None, 0, np.inf
        self.first = float(solver.separation.min()) - solver.law.onset
        ahead = max(deltas[0] - self.first, 0.0)  # then whole steps: both branches visit the same displacements
        self.last = solver.nothing(deltas[0] - step * np.ceil(ahead / step), left)

    def turned(self):
        """Return the branch that leads back from here; it begins with the present state."""
        back = _Branch(self.solver, self.step, self.deltas, self.fields, self.last.left)
        back.before, back.last, back.next, back.stiffness = self.before, self.last, self.next, self.stiffness
        back.dissipated = self.dissipated
        if self.rows:
            back.rows.append(self.rows[-1].copy())
            back.pressures += self.pressures[-1:] if self.rows[-1][ASKED] else []
        return back

    def load(self, goal):
        """Continue until the force reaches ``goal`` or the last displacement; return whether it converged."""
        over = None  # a state beyond the goal
        while self.next < self.deltas.size:
            target, last = self.deltas[self.next], self.last
            if over is not None and over.delta - last.delta <= _LEAST_STEP * self.step:
                found = over  # the force jumps past the goal
            else:
                delta = self._towards(goal, over, target)
                found = self.seek(delta, self.before, last, well=delta == target)
            if not np.isfinite(found.force):
                return False
            reached = found.force >= goal and found.state.touching.any()
            met = found.force - goal <= _MET * max(abs(goal), self.largest)
            if reached and not met and found.delta - last.delta > _LEAST_STEP * self.step:
                over = found
                continue
            self._accept(found, found.delta == target)
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
        return float(target) if target - delta < _SAME * self.step else float(delta)

    def retract(self):
        """Go back through the prescribed displacements, then on until contact is lost.

        While a larger pull may lie ahead, the next state is searched near the extrapolation of the last two. Where
        there is none, the branch has ended on the way: its end is located by shorter steps, and passed by a leap.
        """
        change, beyond, least = self.step, None, _LEAST_STEP * self.step
        while self.next > 0 and self.deltas[self.next - 1] >= self.last.delta - _SAME * self.step:
            self.next -= 1
        while not (self._is_lost() and self.next == 0):
            last, target = self.last, self.deltas[self.next - 1] if self.next > 0 else -np.inf
            if self._is_lost():
                change, beyond = last.delta - target, None  # nothing happens on the way
            leaps = beyond is not None and last.delta - beyond < 2.0 * least
            back = min(self._leap() if leaps else change, last.delta - target)
            delta = float(target) if last.delta - back - target < _SAME * self.step else last.delta - back
            near = not leaps and back > least and self._leads_to_more(back)
            found = self.solver.seek(delta, self.before, last, near=near, well=delta == target)
            if not np.isfinite(found.force):
                return False
            if near and (not found.fine or self._passed_more(found)):
                beyond, change = delta, self._shorter(found)
                continue
            self._accept(found, delta == target)
            self.next -= delta == target
            if near and beyond is not None and beyond < delta:
                change = 0.5 * (delta - beyond)
            else:
                change, beyond = min(self.step, max(change, 2.0 * back)), None
            self._vertex()
        return True

    def _leap(self):
        """Return how far to leap beyond the end of a branch."""
        far = _PASSED * self.largest / max(self.stiffness, _TINY)
        return min(max(far, _LEAST_STEP * self.step), _LEAP * self.step)

    def _leads_to_more(self, back):
        """Return whether the branch, with its last stiffness, leads to a larger pull than any before within a step."""
        return self.stiffness * back - self.last.force > (1.0 + _MISSED) * self.largest

    def _is_lost(self):
        """Return whether nothing touches, and almost nothing pulls."""
        last = self.last
        return not last.state.touching.any() and (last.delta <= self.first or -last.force < _LOST * self.largest)

    def _passed_more(self, found):
        """Return whether a step may have passed over a larger pull.

        It may if, by its energy, it jumped or a stiff contact let go, or if the pull fell although it was growing.
        """
        last, smooth = self.last, self._is_smooth(found)
        if smooth and found.force <= last.force:
            return False
        missed = _MISSED_IN_A_CURVE if smooth else _MISSED
        most = self.stiffness * (last.delta - found.delta) - last.force
        return most > (1.0 + missed) * max(self.largest, -found.force)

    def _is_smooth(self, found):
        """Return whether a step follows a branch, judged by what it dissipates."""
        last = self.last
        apart = abs((last.force - found.force) * (last.delta - found.delta)) + _TINY
        return -_EDGE <= self._freed(found) / apart <= _JUMP

    def _shorter(self, found):
        """Return a step to where the extrapolation has the pull that was found, or half as far as that state.

        A stiff body lets go within a small part of a step, which is so found in three tries instead of ten.
        """
        last = self.last
        half, leads = 0.5 * (last.delta - found.delta), (last.force - found.force) / (self.stiffness or np.inf)
        return max(min(half, leads) if leads > 0.0 and found.fine else half, _LEAST_STEP * self.step)

    def _freed(self, found):
        """Return the energy that the step to a state dissipates, nm²."""
        last = self.last
        return 0.5 * (found.force + last.force) * (found.delta - last.delta) - (found.energy - last.energy)

    def _accept(self, found, asked):
        """Append a state, which becomes the present one."""
        self.dissipated += self._freed(found)
        moved = self.last.delta - found.delta
        if moved != 0.0 and self._is_smooth(found):  # across a jump two states do not give the stiffness
            self.stiffness = (self.last.force - found.force) / moved
        self.before, self.last = self.last, found
        self.largest = max(self.largest, -found.force)
        self.rows.append(self._row(found, asked))
        if asked and self.fields:
            pressure = np.zeros(self.solver.separation.shape)
            pressure[found.rows, found.columns] = found.state.pressure
            self.pressures.append(pressure)
            self.left.append(found.left)

    def _row(self, found, asked):
        row = np.zeros(15)
        row[DELTA], row[FORCE], row[ENERGY], row[DISSIPATED] = found.delta, found.force, found.energy, self.dissipated
        row[AREA], row[ITERATIONS], row[OK], row[ASKED] = found.state.touching.sum(), found.rounds, found.fine, asked
        row[CONTACTS], row[RESOLUTION] = self.solver.contacts(found.state)
        row[RESIDUAL], row[11:] = found.residual, self.solver.yielded(found)
        return row

    def _mend(self, place):
        """Find the last state but one as well as is asked, if it stands at ``place`` and was on the way only.

        Where that is another state, the branch ended just before, and the first stays: the end of the branch is as
        close to it as its residual is small.
        """
        row = self.rows[place]
        if row[ASKED]:
            return
        found = self.solver.seek(self.before.delta, None, self.before)
        if found.fine and abs(found.force - row[FORCE]) < _MISSED * self.largest:
            self.rows[place] = self._row(found, False)
            self.rows[place][DISSIPATED] = row[DISSIPATED]
            self.before, self.largest = found, -found.force

    def _vertex(self):
        """Add states at vertices of parabolas through the largest pull and its neighbours, while they may pull more."""
        if len(self.rows) < 3 or -self.rows[-2][FORCE] < self.largest:
            return
        best = len(self.rows) - 2
        self._mend(best)
        for _ in range(_VERTICES):
            (x0, x1, x2), (f0, f1, f2) = (np.array(self.rows[best - 1 : best + 2])[:, k] for k in (DELTA, FORCE))
            if best < 1 or not (x0 > x1 > x2 and f1 < f0 and f1 < f2):
                return
            first, second = (f1 - f0) / (x1 - x0), (f2 - f1) / (x2 - x1)
            curvature = (second - first) / (x2 - x0)
            delta = 0.5 * (x0 + x1) - 0.5 * first / curvature
            if f1 - curvature * (delta - x1) ** 2 > (1.0 + _MISSED) * f1:
                return
            found = self.solver.seek(float(delta), self.last, self.before)
            row = self._row(found, False)
            row[DISSIPATED] = self.rows[best][DISSIPATED]
            if not found.fine or found.force >= f1:
                return
            best += delta < x1
            self.rows.insert(best, row)
            self.largest = max(self.largest, -found.force)
