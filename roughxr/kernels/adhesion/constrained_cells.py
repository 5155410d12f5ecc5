"""Cells held at a prescribed gap, and the pressures that hold them, updated as cells join and leave one at a time.

On a set C of cells the surface takes the shape δ − S + u, where u is the gap of each cell, so that

    A p = δ − S + u   on C,        p = 0 elsewhere;        p = δ q₁ − q_S + M u,     M = A⁻¹, q₁ = M 1, q_S = M S,

with Love's coefficients A (``love``). M is kept in full: a cell that joins adds a row to A, a cell that leaves removes
one, and either changes M by a matrix of rank one (Schur complement; Sherman & Morrison 1950). So a contact's edge that
sweeps over n cells costs as much as one inversion, and every energy is exact.

δ displacement, S separation, u gap, all in nm. Cells have unit side and the half space unit modulus: pressures are in
nm, p dx/E*. Source: own, from Schur's complement; tests compare it with the dense solution. The arrays are longer than
the set, so that cells can join without a copy; the number of cells is therefore kept separately.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel

#: Initial length of the arrays.
_ROOM = 256

#: Value of ``place`` for cells that are not in the set.
ABSENT = -1


class ConstrainedCells(NamedTuple):
    """The set C and its pressures. All functions but `with_room` change it in place."""

    count: np.ndarray  # (1,) cells in the set: the entries in use of the arrays below
    row: np.ndarray  # (room,) position in the window
    column: np.ndarray
    place: np.ndarray  # (nx, ny) index into the set, or ABSENT
    inverse: np.ndarray  # (room, room) M
    pressure_rate: np.ndarray  # (room,) q₁: pressure per unit displacement
    shape_pressure: np.ndarray  # (room,) q_S, nm
    gap: np.ndarray  # (room,) u, nm
    pressure: np.ndarray  # (room,) p dx/E*, nm


@kernel
def no_cells(shape):
    """Return the empty set on a window."""
    return _empty(_ROOM, np.full(shape, ABSENT, np.int64))


@kernel
def _empty(room, place):
    row, column = np.zeros(room, np.int64), np.zeros(room, np.int64)
    vectors = np.zeros((4, room))
    count, inverse = np.zeros(1, np.int64), np.zeros((room, room))
    return ConstrainedCells(count, row, column, place, inverse, vectors[0], vectors[1], vectors[2], vectors[3])


@kernel
def with_room(cells):
    """Return the set with room for one more cell: itself, or a copy with half as much room again."""
    room = cells.row.size
    if cells.count[0] < room:
        return cells
    larger = _empty(room + room // 2, cells.place)
    larger.count[0] = room
    for k in range(room):
        larger.row[k], larger.column[k] = cells.row[k], cells.column[k]
        larger.pressure_rate[k], larger.shape_pressure[k] = cells.pressure_rate[k], cells.shape_pressure[k]
        larger.gap[k], larger.pressure[k] = cells.gap[k], cells.pressure[k]
        for m in range(room):
            larger.inverse[k, m] = cells.inverse[k, m]
    return larger


@kernel(reorder=True)
def displacement_at(i, j, cells, coefficients):
    """Return the displacement of the surface at a cell of the window, nm."""
    sunk = 0.0
    for k in range(cells.count[0]):
        sunk += coefficients[abs(cells.row[k] - i), abs(cells.column[k] - j)] * cells.pressure[k]
    return sunk


@kernel(reorder=True)
def constrain(i, j, gap, separation, cells, coefficients):
    """Add the cell (i, j) to the set at its present gap, so that nothing else changes; needs room (`with_room`)."""
    count = cells.count[0]
    inverse, q1, qs = cells.inverse, cells.pressure_rate, cells.shape_pressure
    by_new, image = np.empty(count), np.empty(count)
    for k in range(count):
        by_new[k] = coefficients[abs(cells.row[k] - i), abs(cells.column[k] - j)]
    compliance, rate, shape = coefficients[0, 0], 1.0, separation
    for k in range(count):
        row, total = inverse[k], 0.0
        for m in range(count):
            total += row[m] * by_new[m]
        image[k] = total
        compliance -= by_new[k] * total
        rate -= by_new[k] * q1[k]
        shape -= by_new[k] * qs[k]
    rate, shape = rate / compliance, shape / compliance
    for k in range(count):
        row, factor = inverse[k], image[k] / compliance
        for m in range(count):
            row[m] += factor * image[m]
        inverse[k, count] = inverse[count, k] = -factor
        q1[k] -= image[k] * rate
        qs[k] -= image[k] * shape
    inverse[count, count] = 1.0 / compliance
    q1[count], qs[count], cells.gap[count], cells.pressure[count] = rate, shape, gap, 0.0
    cells.row[count], cells.column[count], cells.place[i, j] = i, j, count
    cells.count[0] = count + 1


@kernel(reorder=True)
def release(k, cells):
    """Remove the k-th cell; the last one takes its place in the arrays."""
    last = cells.count[0] - 1
    _swap(k, last, cells)
    inverse, q1, qs, p = cells.inverse, cells.pressure_rate, cells.shape_pressure, cells.pressure
    cells.place[cells.row[last], cells.column[last]] = ABSENT
    cells.count[0] = last
    gone = inverse[last]
    for m in range(last):
        row, factor = inverse[m], gone[m] / gone[last]
        for n in range(last):
            row[n] -= factor * gone[n]
        q1[m] -= factor * q1[last]
        qs[m] -= factor * qs[last]
        p[m] -= factor * p[last]


@kernel
def _swap(k, last, cells):
    if k == last:
        return
    count, inverse = cells.count[0], cells.inverse
    for m in range(count):
        inverse[k, m], inverse[last, m] = inverse[last, m], inverse[k, m]
    for m in range(count):
        inverse[m, k], inverse[m, last] = inverse[m, last], inverse[m, k]
    for values in (cells.pressure_rate, cells.shape_pressure, cells.gap, cells.pressure):
        values[k], values[last] = values[last], values[k]
    for values in (cells.row, cells.column):
        values[k], values[last] = values[last], values[k]
    cells.place[cells.row[k], cells.column[k]] = k
    cells.place[cells.row[last], cells.column[last]] = last


@kernel(reorder=True)
def open_cell(k, change, cells):
    """Increase the gap of the k-th cell by ``change`` (nm)."""
    row, pressure = cells.inverse[k], cells.pressure
    cells.gap[k] += change
    for m in range(cells.count[0]):
        pressure[m] += change * row[m]


@kernel(reorder=True)
def dent(k, depth, cells):
    """Let the surface of the k-th cell give way by ``depth`` (nm), its separation with it, at unchanged gaps."""
    row = cells.inverse[k]
    for m in range(cells.count[0]):
        cells.pressure[m] -= depth * row[m]
        cells.shape_pressure[m] += depth * row[m]


@kernel(reorder=True)
def approach(change, cells):
    """Increase the displacement by ``change`` (nm) at unchanged gaps."""
    for k in range(cells.count[0]):
        cells.pressure[k] += change * cells.pressure_rate[k]


@kernel(reorder=True)
def elastic_energy(separation, delta, cells):
    """Return ½ Σ p (δ − S + u), nm²."""
    total = 0.0
    for k in range(cells.count[0]):
        total += cells.pressure[k] * (delta - separation[cells.row[k], cells.column[k]] + cells.gap[k])
    return 0.5 * total


@kernel
def force(cells):
    """Return the force, nm, positive where it pushes."""
    total = 0.0
    for k in range(cells.count[0]):
        total += cells.pressure[k]
    return total


@kernel
def save(cells):
    """Return a copy of gaps and pressures, (2, count), the state of a set whose cells do not change."""
    saved = np.empty((2, cells.count[0]))
    for k in range(cells.count[0]):
        saved[0, k], saved[1, k] = cells.gap[k], cells.pressure[k]
    return saved


@kernel
def restore(saved, cells):
    """Restore the gaps and pressures that `save` has copied."""
    for k in range(cells.count[0]):
        cells.gap[k], cells.pressure[k] = saved[0, k], saved[1, k]
