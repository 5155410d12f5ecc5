"""States of one body under a law of adhesion, each at its displacement, computed from the state before it.

At each displacement only the bounding box of the cells within the law's range is solved.

A body that yields bears p ≤ H (``halfspace.yielding``). Where a state on loading exceeds this, the surface gives way
until it does not, at the attraction of that state, and the state is solved again on the dented surface. Dents stay,
and retraction is elastic.

Unit cells and unit modulus.
"""

import itertools
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from ..halfspace import displacement_control, yielding
from ..halfspace.products import displaced, inverse_in, product_in
from .equilibrium import BoxProblem, ContactState, closed_parts, energy, settle
from .patches import contacts_and_resolution
from .traction_laws import traction

#: The sides of boxes are multiples of this many cells, so that few transforms of the coefficients are needed.
_BOX_MULTIPLE = 16

#: Boxes reach so many cells beyond what was within range or pulled: few states then need a larger box. Saves 40 % of
#: the work of cycles without range.
_BOX_MARGIN = 3

#: Residual, over the largest traction, that a state must meet, and one in between, which is neither at a prescribed
#: displacement nor at the largest tension. It saves a quarter of the work; pull-offs change by 0.2 %.
TOLERANCE, ON_THE_WAY = 1e-5, 1e-3

#: On loading a state may exceed the hardness by this part. Else it gives way, at most so many times, each time by an
#: amount computed to this part of the deepest overlap.
_EXCESS, _MOST_DENTS, _DENT_TOLERANCE = 1e-3, 6, 1e-6

#: How far the edge of a contact opens within a law without range, in cells times the steepness of the law: π E* b²/16w
#: by Griffith's edge. Overlaps of more than the second part of the range are contacts. Distances go from cell to cell.
_EDGE_OPENING, _CONTACT_OVERLAP = 1.2, 1e-3
_FOUR_NEIGHBOURS = ndimage.generate_binary_structure(2, 1)

#: Mark of cells that have touched; cells around them are marked 1.
_TOUCHED = 2

#: Part of the largest traction above which a cell's tension counts for the size of a box.
_LEAST_PULL = 2e-3


class SolvedState(NamedTuple):
    """One state: on the box of the cells within range, at (rows, columns) of the window."""

    delta: float
    force: float
    energy: float
    rows: slice
    columns: slice
    state: ContactState
    rounds: int
    fine: bool
    residual: float  # over the largest traction
    left: np.ndarray  # (nx, ny) of the window: residual height
    near: np.ndarray | None = None  # (nx, ny) of the window: where a law without range has touched, and may pull
    opens: bool = False  # it may pull where it was not yet allowed to


class Solver:
    """Computes the states of one body."""

    def __init__(self, separation, law, cap, limit, from_contact, capture=0.0):
        self.separation, self.law = separation, law
        self.cap, self.limit = cap, limit
        self.lowest = [separation.min(axis=axis) for axis in (1, 0)]  # of whole rows and columns: windows are wide
        self.around = int(np.ceil(_EDGE_OPENING / law.steepest)) + 2 if from_contact and law.work > 0 else 0
        self.closes_at = capture if capture > 0.0 else -_CONTACT_OVERLAP * law.range

    def nothing(self, delta, left):
        """Return the state without any traction."""
        rows, columns = self._box(delta)
        separation = self.separation[rows, columns] - left[rows, columns]
        state = ContactState(np.zeros(separation.shape), separation - delta, np.zeros(separation.shape, bool))
        near = np.zeros(self.separation.shape, np.int8) if self.around else None
        return SolvedState(delta, 0.0, 0.0, rows, columns, state, 0, True, 0.0, left, near)

    def press(self, delta, last, *, exact=True):
        """Return the state at a displacement on loading: the surface gives way until it bears the pressure."""
        solved = self.seek(delta, last, exact=exact)
        for _ in range(_MOST_DENTS):
            if not solved.state.pressure.max() > (1.0 + _EXCESS) * self.cap:
                break
            dented = solved._replace(left=self._dented(solved))
            rounds, solved = solved.rounds, self.seek(delta, dented, exact=exact)
            solved = solved._replace(rounds=solved.rounds + rounds)
        else:
            bears = not solved.state.pressure.max() > (1.0 + _EXCESS) * self.cap
            solved = solved._replace(fine=solved.fine and bears)
        return solved

    def _dented(self, solved):
        """Return the residual height once the surface has given way under too large pressures, at fixed attraction."""
        at, state, most = (solved.rows, solved.columns), solved.state, traction(0.0, self.law)[0]
        attraction = np.where(state.touching, most, np.maximum(-state.pressure, 0.0))
        separation = self.separation[at] - solved.left[at] - displaced(attraction)
        hardness, deltas = displacement_control.Hardness(self.cap + most), np.array([solved.delta])
        limits = {"tolerance": _DENT_TOLERANCE, "hardness": hardness, "keep": 1}
        _, pressure, displacement = displacement_control.sweep_arrays(separation, deltas, 1.0, 1.0, **limits)
        left = solved.left.copy()
        left[at] += yielding.residual_heights(pressure, displacement, separation, deltas, hardness.pressure)[0]
        return left

    def seek(self, delta, last, *, near=False, exact=True):
        """Return the state at a displacement, starting from the last state, on the surface that it left.

        With ``near`` the solve fails (not ``fine``) where there is no state close to the last. Unless ``exact`` its
        tolerance is ``ON_THE_WAY``.
        """
        for margin in itertools.count(_BOX_MARGIN, _BOX_MULTIPLE):
            rows, columns = self._box(delta, last, margin)
            solved = self._seek_in(rows, columns, delta, last, near, exact)
            while solved.opens and np.isfinite(solved.force):
                last = solved
                solved = self._seek_in(rows, columns, delta, last, near, exact)
            if not self._pulls_at_edge(solved):
                return solved

    def _where_it_pulls(self, rows, columns, delta, sinks, state, last):
        """Return the cells of contacts and those around them, and whether new cells among them may attract.

        Contacts that grow within the cells around them need no second solve, which halves the work.
        """
        near = last.near[rows, columns]
        gap = self.separation[rows, columns] - last.left[rows, columns] + sinks - delta
        touches = (near < _TOUCHED) & (state.touching | ((gap < self.closes_at) & (near == 0)))
        if not touches.any():
            return last.near, False
        grown = last.near.copy()
        grown[rows, columns][touches] = _TOUCHED
        wider = tuple(slice(max(part.start - self.around, 0), part.stop + self.around) for part in (rows, columns))
        nearby = ndimage.binary_dilation(grown[wider] == _TOUCHED, _FOUR_NEIGHBOURS, self.around)
        np.maximum(grown[wider], nearby, out=grown[wider])
        return grown, bool(((grown[rows, columns] > 0) & (near == 0) & (gap < self.law.range)).any())

    def _seek_in(self, rows, columns, delta, last, near, exact):
        """Return the state of the cells of a box."""
        state, left = self._moved(last, rows, columns), last.left
        separation = np.ascontiguousarray(self.separation[rows, columns] - left[rows, columns])
        if self.around:
            separation[last.near[rows, columns] == 0] = np.inf
        body = self._body(separation, TOLERANCE if exact else ON_THE_WAY)
        out = settle(body, delta, state, near)
        force = float(state.pressure.sum())
        stored = energy(separation, self.law, delta, state)
        nearby = None, False
        if self.around:
            sinks = body.sinks if out.fine else displaced(state.pressure)
            nearby = self._where_it_pulls(rows, columns, delta, sinks, state, last)
        fine = out.fine and bool(np.isfinite(force))  # comparisons with NaN hide it from the residual
        return SolvedState(delta, force, stored, rows, columns, state, out.rounds, fine, out.residual, left, *nearby)

    def contacts(self, state):
        """Return the number of contacts, and how well the mesh resolves them."""
        return contacts_and_resolution(state, closed_parts(state, self.law), self.law)

    def yielded(self, solved):
        """Return the shares of a state at the hardness, and area and volume of its dents."""
        pressure, least = solved.state.pressure, self.limit * (1.0 - 2.0 * _EXCESS if self.cap < np.inf else 1.0)
        hard, pushes, touching = pressure >= least, max(pressure.clip(min=0.0).sum(), 1e-300), solved.state.touching
        left = solved.left if self.cap < np.inf else solved.left[:0]  # of the whole window: not where nothing yields
        return {
            "yielded_fraction": pressure[hard].sum() / pushes,
            "yielded_area_fraction": np.count_nonzero(hard) / max(np.count_nonzero(touching), 1),
            "yielded_area": np.count_nonzero(left),
            "plastic_work": np.abs(left).sum(),
        }

    def _box(self, delta, last=None, margin=0):
        """Return the rows and columns of the box that holds all cells within range, and those that pulled before."""
        within = [lowest < delta + self.law.range for lowest in self.lowest]
        if last is not None:
            pulls = np.abs(last.state.pressure) > _LEAST_PULL * self.law.strength
            within[0][last.rows] |= pulls.any(axis=1)
            within[1][last.columns] |= pulls.any(axis=0)
        return tuple(_rounded(np.flatnonzero(axis), axis.size, margin) for axis in within)

    def _pulls_at_edge(self, solved):
        """Return whether adhesion draws the surface up as far as a side of the box beyond which there is more of it."""
        pulls = np.abs(solved.state.pressure) > _LEAST_PULL * self.law.strength
        for side, part, size in zip((pulls, pulls.T), (solved.rows, solved.columns), self.separation.shape):
            if (part.start > 0 and side[:1].any()) or (part.stop < size and side[-1:].any()):
                return True
        return False

    def _moved(self, known, rows, columns):
        """Return a state on another box; cells outside the old one have no traction."""
        shape = rows.stop - rows.start, columns.stop - columns.start
        state = ContactState(np.zeros(shape), np.full(shape, np.inf), np.zeros(shape, bool))
        (a, b), (c, d) = _shared(known.rows, rows), _shared(known.columns, columns)
        for old, new in zip(known.state, state):
            new[b, d] = old[a, c]
        return state

    def _body(self, separation, tolerance):
        product, inverse = product_in(*separation.shape), inverse_in(*separation.shape)
        return BoxProblem(separation, self.law, tolerance, product, inverse, np.empty(separation.shape))


def _rounded(places, size, margin):
    """Return a slice around some cells, with one of few lengths."""
    if places.size == 0:
        return slice(0, min(_BOX_MULTIPLE, size))
    first, end = places[0] - margin, places[-1] + 1 + margin
    length = min(_BOX_MULTIPLE * -(-(end - first) // _BOX_MULTIPLE), size)
    first = min(max(first, 0), size - length)
    return slice(first, first + length)


def _shared(old, new):
    """Return the intersection of two slices, as a slice within each of them."""
    first, end = max(old.start, new.start), max(min(old.stop, new.stop), max(old.start, new.start))
    return slice(first - old.start, end - old.start), slice(first - new.start, end - new.start)
