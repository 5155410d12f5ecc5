"""Cells held at a prescribed gap, and the pressures that hold them, updated as cells join and leave.

On a set C of cells the surface takes the shape δ − S + u, where u is the gap of each cell, so that

    A p = δ − S + u   on C,        p = 0 elsewhere;        p = δ q₁ − q_S + M u,     M = A⁻¹, q₁ = M 1, q_S = M S,

with Love's coefficients A (``love``). M is kept in full: cells that join add rows to A, cells that leave remove some,
and either changes M by a matrix whose rank is their number (Schur complement; Sherman & Morrison 1950). So a contact's
edge that sweeps over n cells costs as much as one inversion, and every energy is exact. M is read and written once for
all the cells that come or go together: it outgrows the processor's cache, and one by one takes four times as long.

δ displacement, S separation, u gap, all in nm. Cells have unit side and the half space unit modulus: pressures are in
nm, p dx/E*. Source: own, from Schur's complement; tests compare it with the dense solution. The arrays are longer than
the set, so that cells can join without a copy; the number of cells is therefore kept separately.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .cholesky import invert

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
def with_room(cells, more):
    """Return the set with room for some more cells: itself, or a copy with half as much room again, or all it needs."""
    room, count = cells.row.size, cells.count[0]
    if count + more <= room:
        return cells
    larger = _empty(max(room + room // 2, count + more), cells.place)
    larger.count[0] = count
    for k in range(count):
        larger.row[k], larger.column[k] = cells.row[k], cells.column[k]
        larger.pressure_rate[k], larger.shape_pressure[k] = cells.pressure_rate[k], cells.shape_pressure[k]
        larger.gap[k], larger.pressure[k] = cells.gap[k], cells.pressure[k]
        for m in range(count):
            larger.inverse[k, m] = cells.inverse[k, m]
    return larger


@kernel(reorder=True)
def displacement_at(i, j, cells, coefficients):
    """Return the displacement of the surface at a cell of the window, nm."""
    sunk = 0.0
    for k in range(cells.count[0]):
        sunk += coefficients[abs(cells.row[k] - i), abs(cells.column[k] - j)] * cells.pressure[k]
    return sunk


@kernel
def constrain(rows, columns, gaps, separation, cells, coefficients):
    """Add cells to the set at their present gaps, so that nothing else changes; needs room for them (`with_room`).

    With B the coefficients between old cells (columns) and new ones (rows), and G = B M, their Schur complement is
    A' − G Bᵀ, and what M gains is Gᵀ (A' − G Bᵀ)⁻¹ G.
    """
    count, new = cells.count[0], rows.size
    between, images, beside = np.empty((new, count)), np.empty((new, count)), np.empty((new, new))
    for c in range(new):
        for k in range(count):
            between[c, k] = coefficients[abs(cells.row[k] - rows[c]), abs(cells.column[k] - columns[c])]
        for d in range(new):
            beside[c, d] = coefficients[abs(rows[c] - rows[d]), abs(columns[c] - columns[d])]
    _multiply(cells.inverse, between, images)
    _take_products(images, between, beside)
    invert(beside)
    loads = np.zeros((new, count))
    _add_products(beside, images, loads, 1.0)
    _add_products(np.ascontiguousarray(images.T), loads, cells.inverse, 1.0)
    for c in range(new):
        for k in range(count):
            cells.inverse[count + c, k] = cells.inverse[k, count + c] = -loads[c, k]
        for d in range(new):
            cells.inverse[count + c, count + d] = beside[c, d]
    _take_on(cells.pressure_rate, np.ones(new), between, beside, images)
    _take_on(cells.shape_pressure, separation, between, beside, images)
    for c in range(new):
        k = count + c
        cells.gap[k], cells.pressure[k] = gaps[c], 0.0
        cells.row[k], cells.column[k], cells.place[rows[c], columns[c]] = rows[c], columns[c], k
    cells.count[0] = count + new


@kernel(reorder=True)
def _take_on(pressures, right, between, complement, images):
    """Append to M r of the old cells that of the new ones, on which r is ``right``, and change it for them."""
    new, count = between.shape
    left = np.empty(new)
    for c in range(new):
        total, row = right[c], between[c]
        for k in range(count):
            total -= row[k] * pressures[k]
        left[c] = total
    for c in range(new):
        total, row = 0.0, images[c]
        for d in range(new):
            total += complement[c, d] * left[d]
        pressures[count + c] = total
        for k in range(count):
            pressures[k] -= total * row[k]


@kernel
def release(gone, cells):
    """Remove cells by their indices, in ascending order; the last ones take their places in the arrays.

    With D the rows of M for them and C their part of these, what M loses is Dᵀ C⁻¹ D.
    """
    left, number = cells.count[0] - gone.size, gone.size
    for c in range(number - 1, -1, -1):
        _swap(gone[c], left + c, cells)
        cells.place[cells.row[left + c], cells.column[left + c]] = ABSENT
    cells.count[0] = left
    rows, within = cells.inverse[left : left + number, :left].copy(), np.empty((number, number))
    for c in range(number):
        for d in range(number):
            within[c, d] = cells.inverse[left + c, left + d]
    invert(within)
    loads = np.zeros((number, left))
    _add_products(within, rows, loads, 1.0)
    _add_products(np.ascontiguousarray(rows.T), loads, cells.inverse, -1.0)
    for values in (cells.pressure_rate, cells.shape_pressure, cells.pressure):
        for c in range(number):
            for k in range(left):
                values[k] -= loads[c, k] * values[left + c]


@kernel(reorder=True)
def _multiply(matrix, vectors, out):
    """Write M times each of some vectors, which are rows, into the rows of ``out``; four at a time, for speed."""
    number, size = vectors.shape
    fours = number - number % 4
    for k in range(size):
        row = matrix[k]
        for c in range(0, fours, 4):
            v0, v1, v2, v3 = vectors[c], vectors[c + 1], vectors[c + 2], vectors[c + 3]
            t0 = t1 = t2 = t3 = 0.0
            for m in range(v0.size):
                t0 += row[m] * v0[m]
                t1 += row[m] * v1[m]
                t2 += row[m] * v2[m]
                t3 += row[m] * v3[m]
            out[c, k], out[c + 1, k], out[c + 2, k], out[c + 3, k] = t0, t1, t2, t3
        for c in range(fours, number):
            vector, total = vectors[c], 0.0
            for m in range(vector.size):
                total += row[m] * vector[m]
            out[c, k] = total


@kernel(reorder=True)
def _take_products(rows, others, out):
    """Take the products of some rows with others from a matrix."""
    for c in range(rows.shape[0]):
        for d in range(others.shape[0]):
            row, other, total = rows[c], others[d], 0.0
            for m in range(row.size):
                total += row[m] * other[m]
            out[c, d] -= total


@kernel(reorder=True)
def _add_products(factors, rows, out, sign):
    """Add to each row of a matrix the sum of some rows times its own factors; four at a time, for speed."""
    number, size = rows.shape
    fours = number - number % 4
    for k in range(factors.shape[0]):
        to = out[k]
        for c in range(0, fours, 4):
            r0, r1, r2, r3 = rows[c], rows[c + 1], rows[c + 2], rows[c + 3]
            f0, f1, f2, f3 = factors[k, c], factors[k, c + 1], factors[k, c + 2], factors[k, c + 3]
            for m in range(size):
                to[m] += sign * (f0 * r0[m] + f1 * r1[m] + f2 * r2[m] + f3 * r3[m])
        for c in range(fours, number):
            row, factor = rows[c], sign * factors[k, c]
            for m in range(size):
                to[m] += factor * row[m]


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
