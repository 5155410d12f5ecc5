"""States of one body under a law of adhesion, each at its displacement, computed from the state before it.

At each displacement only the bounding box of the cells within the law's range is solved.

A body that yields has p ≤ H (``halfspace.yielding``). If a state on loading exceeds H, the surface is dented at fixed
attraction until no pressure does, and the state is solved again on the dented surface. Dents remain, and retraction is
elastic.

Unit cells and unit modulus.
"""

import itertools
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from ..halfspace import displacement_control, yielding
from ..halfspace.products import displaced, surface_convolution
from .equilibrium import BoxProblem, ContactState, closed_parts, energy, settle
from .newton_system import BOX_MULTIPLE
from .patches import contacts_and_resolution
from .traction_laws import traction

#: Width (cells) of the margin of a box around the cells within range or under traction: few states then need a larger
#: box. Saves 40 % of the work of cycles without range.
_BOX_MARGIN = 3

#: Largest residual over the largest traction of states at prescribed displacements and at the largest tension.
TOLERANCE = 1e-5

#: Largest residual of states in between: saves a quarter of the work; pull-offs change by 0.2 %.
INTERMEDIATE_TOLERANCE = 1e-3

#: Part by which a state may exceed the hardness on loading.
_EXCESS = 1e-3

#: Largest number of dents otherwise.
_MOST_DENTS = 6

#: Accuracy of each dent, as a part of the deepest overlap.
_DENT_TOLERANCE = 1e-6

#: Width of the opening at the edge of a contact under a law without range, in cells times the steepness of the law:
#: π E* b²/16w by Griffith's edge.
_EDGE_OPENING = 1.2

#: Overlaps of more than this part of the range are contacts.
_CONTACT_OVERLAP = 1e-3
_FOUR_NEIGHBOURS = ndimage.generate_binary_structure(2, 1)

#: Mark of cells that have touched; cells within the opening of their edge are marked 1.
_TOUCHED = 2


class SolvedState(NamedTuple):
    """One state: on the box of the cells within range, at (rows, columns) of the window."""

    delta: float
    force: float
    energy: float
    rows: slice
    columns: slice
    state: ContactState
    rounds: int
    converged: bool
    residual: float  # over the largest traction
    residual_height: np.ndarray  # (nx, ny) of the window
    attracting: np.ndarray | None = None  # (nx, ny) of the window: marks of cells that a law without range may attract
    grows: bool = False  # more cells may attract than in the solve


class Solver:
    """Solves the states of one body."""

    def __init__(self, separation, law, cap, limit, capture=None, film=None):
        self.separation = separation
        self.law = law
        self.film = film
        self.operators = {}
        self.bulges = film is not None and film.bulges
        self.cap = cap
        self.limit = limit
        self.lowest = [separation.min(axis=axis) for axis in (1, 0)]  # of whole rows and columns: windows are wide
        self.edge_width = 0 if capture is None else int(np.ceil(_EDGE_OPENING / law.steepest)) + 2
        self.closes_at = capture or -_CONTACT_OVERLAP * law.range

    def without_traction(self, delta, left):
        """Return the state without any traction."""
        rows, columns = self._box(delta)
        separation = self.separation[rows, columns] - left[rows, columns]
        state = ContactState(np.zeros(separation.shape), separation - delta, np.zeros(separation.shape, bool))
        attracting = np.zeros(self.separation.shape, np.int8) if self.edge_width else None
        return SolvedState(delta, 0.0, 0.0, rows, columns, state, 0, True, 0.0, left, attracting)

    def solve_yielding(self, delta, last, *, exact=True):
        """Return the state at a displacement on loading, the surface dented until no pressure exceeds the hardness."""
        solved = self.solve(delta, last, exact=exact)
        for _ in range(_MOST_DENTS):
            if not solved.state.pressure.max() > (1.0 + _EXCESS) * self.cap:
                break
            dented = solved._replace(residual_height=self._indented(solved))
            rounds = solved.rounds
            solved = self.solve(delta, dented, exact=exact)
            solved = solved._replace(rounds=solved.rounds + rounds)
        else:
            within_cap = not solved.state.pressure.max() > (1.0 + _EXCESS) * self.cap
            solved = solved._replace(converged=solved.converged and within_cap)
        return solved

    def _indented(self, solved):
        """Return the residual height of the surface, dented at fixed attraction where pressures exceed the hardness."""
        at = (solved.rows, solved.columns)
        state = solved.state
        most = traction(0.0, self.law)[0]
        attraction = np.where(state.touching, most, np.maximum(-state.pressure, 0.0))
        separation = self.separation[at] - solved.residual_height[at] - displaced(attraction, self.film)
        hardness = displacement_control.Hardness(self.cap + most)
        deltas = np.array([solved.delta])
        limits = {"tolerance": _DENT_TOLERANCE, "hardness": hardness, "keep": 1}
        _, pressure, displacement = displacement_control.sweep_arrays(separation, deltas, 1.0, 1.0, self.film, **limits)
        left = solved.residual_height.copy()
        left[at] += yielding.residual_heights(pressure, displacement, separation, deltas, hardness.pressure)[0]
        return left

    def solve(self, delta, last, *, near=False, exact=True):
        """Return the state at a displacement, starting from the last state, on that state's residual heights.

        With ``near`` the solve does not converge where there is no state close to the last. Unless ``exact`` its
        tolerance is ``INTERMEDIATE_TOLERANCE``.
        """
        for margin in itertools.count(_BOX_MARGIN, BOX_MULTIPLE):
            rows, columns = self._box(delta, last, margin)
            solved = self._solve_in_box(rows, columns, delta, last, near, exact)
            while solved.grows and np.isfinite(solved.force):
                last = solved
                solved = self._solve_in_box(rows, columns, delta, last, near, exact)
            if not self._tension_at_edge(solved):
                return solved

    def _attracting_cells(self, rows, columns, delta, displacement, state, last):
        """Return the marks of cells in and near contacts, and whether any of them may newly attract.

        Contacts that grow within the marked cells need no second solve, which halves the work.
        """
        marks = last.attracting[rows, columns]
        gap = self.separation[rows, columns] - last.residual_height[rows, columns] + displacement - delta
        touches = (marks < _TOUCHED) & (state.touching | ((gap < self.closes_at) & (marks == 0)))
        if not touches.any():
            return last.attracting, False
        width = self.edge_width
        grown = last.attracting.copy()
        grown[rows, columns][touches] = _TOUCHED
        wider = tuple(slice(max(part.start - width, 0), part.stop + width) for part in (rows, columns))
        at_edge = ndimage.binary_dilation(grown[wider] == _TOUCHED, _FOUR_NEIGHBOURS, width)
        np.maximum(grown[wider], at_edge, out=grown[wider])
        return grown, bool(((grown[rows, columns] > 0) & (marks == 0) & (gap < self.law.range)).any())

    def _solve_in_box(self, rows, columns, delta, last, near, exact):
        state = self._moved_state(last, rows, columns)
        left = last.residual_height
        separation = np.ascontiguousarray(self.separation[rows, columns] - left[rows, columns])
        if self.edge_width:
            separation[last.attracting[rows, columns] == 0] = np.inf
        body = self._body(separation, TOLERANCE if exact else INTERMEDIATE_TOLERANCE)
        out = settle(body, delta, state, near)
        force = float(state.pressure.sum())
        stored = energy(separation, self.law, delta, state)
        cells = None, False
        if self.edge_width:
            displacement = body.displacement if out.converged else displaced(state.pressure, self.film)
            cells = self._attracting_cells(rows, columns, delta, displacement, state, last)
        converged = out.converged and bool(np.isfinite(force))  # comparisons with NaN hide it from the residual
        return SolvedState(
            delta, force, stored, rows, columns, state, out.rounds, converged, out.residual, left, *cells
        )

    def contacts(self, state):
        """Return the number of contacts, and their resolution by the mesh."""
        return contacts_and_resolution(state, closed_parts(state, self.law), self.law)

    def yielded(self, solved):
        """Return the shares of force and area at the hardness, and area and volume of the dents; none without one."""
        if min(self.cap, self.limit) == np.inf:
            return {}
        pressure = solved.state.pressure
        least = self.limit * (1.0 - 2.0 * _EXCESS if self.cap < np.inf else 1.0)
        hard = pressure >= least
        pushes = max(pressure.clip(min=0.0).sum(), 1e-300)
        touching = solved.state.touching
        left = solved.residual_height[: None if self.cap < np.inf else 0]  # of the whole window: costs time
        return {
            "yielded_fraction": pressure[hard].sum() / pushes,
            "yielded_area_fraction": np.count_nonzero(hard) / max(np.count_nonzero(touching), 1),
            "yielded_area": np.count_nonzero(left),
            "plastic_work": np.abs(left).sum(),
        }

    def _box(self, delta, last=None, margin=0):
        """Return rows and columns of the box of all cells within range or a film's bulges, and last under traction."""
        beyond = max(delta - self.lowest[0].min(), 0.0) if self.bulges else 0.0
        within = [lowest < delta + beyond + self.law.range for lowest in self.lowest]
        if last is not None:
            loaded = last.state.pressure != 0.0
            within[0][last.rows] |= loaded.any(axis=1)
            within[1][last.columns] |= loaded.any(axis=0)
        return tuple(_rounded_slice(np.flatnonzero(axis), axis.size, margin) for axis in within)

    def _tension_at_edge(self, solved):
        """Return whether cells are loaded at a side of the box that is not the window's."""
        loaded = solved.state.pressure != 0.0
        for side, part, size in zip((loaded, loaded.T), (solved.rows, solved.columns), self.separation.shape):
            if (part.start > 0 and side[:1].any()) or (part.stop < size and side[-1:].any()):
                return True
        return False

    def _moved_state(self, known, rows, columns):
        """Return a state on another box; cells outside the old box have no traction."""
        shape = rows.stop - rows.start, columns.stop - columns.start
        state = ContactState(np.zeros(shape), np.full(shape, np.inf), np.zeros(shape, bool))
        (a, b) = _overlap(known.rows, rows)
        (c, d) = _overlap(known.columns, columns)
        for old, new in zip(known.state, state):
            new[b, d] = old[a, c]
        return state

    def _body(self, separation, tolerance):
        product = surface_convolution(*separation.shape, self.film)
        displacement = np.empty(separation.shape)
        return BoxProblem(separation, self.law, tolerance, product, displacement, self.film, self.operators)


def _rounded_slice(places, size, margin):
    """Return a slice around some cells, its length a multiple of `BOX_MULTIPLE`."""
    if places.size == 0:
        return slice(0, min(BOX_MULTIPLE, size))
    first = places[0] - margin
    end = places[-1] + 1 + margin
    length = min(BOX_MULTIPLE * -(-(end - first) // BOX_MULTIPLE), size)
    first = min(max(first, 0), size - length)
    return slice(first, first + length)


def _overlap(old, new):
    """Return the intersection of two slices, relative to each of them."""
    first = max(old.start, new.start)
    end = max(min(old.stop, new.stop), max(old.start, new.start))
    return slice(first - old.start, end - old.start), slice(first - new.start, end - new.start)
