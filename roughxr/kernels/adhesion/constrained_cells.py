"""Cells held at a prescribed gap: the pressures that do it, as cells come and go one at a time.

On a set C of cells the surface takes the shape δ − S + u, u the gap that each cell is left with, so

    A p = δ − S + u   on C,        p = 0 elsewhere;        p = δ q₁ − q_S + M u,     M = A⁻¹, q₁ = M 1, q_S = M S,

with Love's coefficients A (``love``). M is kept whole: a cell that joins borders A by one row, a cell that
leaves takes one away, and either changes M by a matrix of rank one (Schur complement; Sherman & Morrison 1950).
So a front that sweeps over n cells costs what one inversion does, and every energy is exact.

Cells have unit side and the half space unit modulus: pressures are in nm, p dx/E*. Arrays have room to spare;
only the first ``count`` entries count.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel, reducing_kernel

#: Cells that a new set has room for.
_ROOM = 256

#: What stands in ``place`` where a cell does not belong to the set.
ABSENT = -1


class Glued(NamedTuple):
    """The set C: where its cells are and what holds them."""

    row: np.ndarray  # (room,) place in the window
    column: np.ndarray
    place: np.ndarray  # (nx, ny) index into the set, or ABSENT
    inverse: np.ndarray  # (room, room) M
    pressure_rate: np.ndarray  # (room,) q₁: pressure per unit displacement
    shape_pressure: np.ndarray  # (room,) q_S, nm
    gap: np.ndarray  # (room,) u, nm
    pressure: np.ndarray  # (room,) p dx/E*, nm


@kernel
def nothing_glued(shape):
    """Return the empty set on a window."""
    room = _ROOM
    row, column = np.zeros(room, np.int64), np.zeros(room, np.int64)
    place = np.full(shape, ABSENT, np.int64)
    inverse = np.zeros((room, room))
    return Glued(row, column, place, inverse, np.zeros(room), np.zeros(room), np.zeros(room), np.zeros(room))


@kernel
def with_room(glued, count):
    """Return the set with room for one more cell."""
    room = glued.row.size
    if count < room:
        return glued
    more = room + room // 2
    inverse = np.zeros((more, more))
    inverse[:room, :room] = glued.inverse
    row, column = np.zeros(more, np.int64), np.zeros(more, np.int64)
    row[:room], column[:room] = glued.row, glued.column
    rate, shape, gap, pressure = np.zeros(more), np.zeros(more), np.zeros(more), np.zeros(more)
    rate[:room], shape[:room] = glued.pressure_rate, glued.shape_pressure
    gap[:room], pressure[:room] = glued.gap, glued.pressure
    return Glued(row, column, glued.place, inverse, rate, shape, gap, pressure)


@reducing_kernel
def displacement_at(i, j, glued, count, coefficients):
    """Return how far the surface sinks at a cell of the window, nm."""
    sunk = 0.0
    for k in range(count):
        sunk += coefficients[abs(glued.row[k] - i), abs(glued.column[k] - j)] * glued.pressure[k]
    return sunk


@reducing_kernel
def glue(i, j, gap, separation, glued, count, coefficients):
    """Take in the cell (i, j) at the gap it has: nothing else changes. Room is there already."""
    inverse, q1, qs = glued.inverse, glued.pressure_rate, glued.shape_pressure
    by_new, image = np.empty(count), np.empty(count)
    for k in range(count):
        by_new[k] = coefficients[abs(glued.row[k] - i), abs(glued.column[k] - j)]
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
    q1[count], qs[count], glued.gap[count], glued.pressure[count] = rate, shape, gap, 0.0
    glued.row[count], glued.column[count], glued.place[i, j] = i, j, count


@reducing_kernel
def unglue(k, glued, count):
    """Let the k-th cell go; the last one takes its place."""
    last = count - 1
    _swap(k, last, glued, count)
    inverse, q1, qs, p = glued.inverse, glued.pressure_rate, glued.shape_pressure, glued.pressure
    glued.place[glued.row[last], glued.column[last]] = ABSENT
    gone = inverse[last]
    for m in range(last):
        row, factor = inverse[m], gone[m] / gone[last]
        for n in range(last):
            row[n] -= factor * gone[n]
        q1[m] -= factor * q1[last]
        qs[m] -= factor * qs[last]
        p[m] -= factor * p[last]


@kernel
def _swap(k, last, glued, count):
    if k == last:
        return
    inverse = glued.inverse
    for m in range(count):
        inverse[k, m], inverse[last, m] = inverse[last, m], inverse[k, m]
    for m in range(count):
        inverse[m, k], inverse[m, last] = inverse[m, last], inverse[m, k]
    for values in (glued.pressure_rate, glued.shape_pressure, glued.gap, glued.pressure):
        values[k], values[last] = values[last], values[k]
    for values in (glued.row, glued.column):
        values[k], values[last] = values[last], values[k]
    glued.place[glued.row[k], glued.column[k]] = k
    glued.place[glued.row[last], glued.column[last]] = last


@reducing_kernel
def open_cell(k, change, glued, count):
    """Let the gap of the k-th cell grow by ``change`` (nm)."""
    row, pressure = glued.inverse[k], glued.pressure
    glued.gap[k] += change
    for m in range(count):
        pressure[m] += change * row[m]


@reducing_kernel
def approach(change, glued, count):
    """Bring the bodies together by ``change`` (nm) at unchanged gaps."""
    for k in range(count):
        glued.pressure[k] += change * glued.pressure_rate[k]


@reducing_kernel
def elastic_energy(separation, delta, glued, count):
    """Return ½ Σ p (δ − S + u), nm²."""
    total = 0.0
    for k in range(count):
        total += glued.pressure[k] * (delta - separation[glued.row[k], glued.column[k]] + glued.gap[k])
    return 0.5 * total
