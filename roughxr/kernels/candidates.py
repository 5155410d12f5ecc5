"""The contact in a box by way of the cells that may touch, and the proof that no other does.

The active set works on the chosen cells, its search directions in single precision; the product over the whole box, in
double, is what decides. Whatever violates a condition there is taken in, and the active set goes on.

Unit cells and unit modulus, as in ``kernels.active_set``; depths are δ − S, whatever does not overlap is below zero.
"""

from typing import NamedTuple

import numpy as np

from .active_set import CONVERGED, PATIENCE, Outcome, gather_cells, solve
from .halfspace import DENSE_LIMIT, displace, multiply, operator, whole_box
from .jit import kernel


class Prediction(NamedTuple):
    """What a contact may look like, on a window or a box."""

    pressure: np.ndarray
    touching: np.ndarray  # cells to start from
    possible: np.ndarray  # cells that may touch, the others are left out until they prove to penetrate


class Overlap(NamedTuple):
    """The cells with S < δ: their bounding box, how many they are, and how deep the deepest (nm)."""

    rows: slice
    columns: slice
    count: int
    largest: float


@kernel
def overlapping(separation, delta):
    """Return the `Overlap` of a window."""
    rows, columns = separation.shape
    first_row, last_row, first_column, last_column, count, least = rows, -1, columns, -1, 0, np.inf
    for i in range(rows):
        for j in range(columns):
            if separation[i, j] < delta:
                first_row, last_row = min(first_row, i), i
                first_column, last_column = min(first_column, j), max(last_column, j)
                least = min(least, separation[i, j])
                count += 1
    box = slice(first_row, last_row + 1), slice(first_column, last_column + 1)
    return Overlap(box[0], box[1], count, delta - least)


@kernel
def solve_in_box(depth, count, start, goal, max_iterations, load, slack, coefficients, known):
    """Return pressures, displacements and `Outcome` in a box of which ``count`` cells overlap.

    With a ``load`` the depths shift, and cells within ``slack`` of overlapping are taken along.
    """
    inside = depth > -slack
    touching = start.touching & inside
    pressure = np.where(touching, start.pressure, 0.0)
    if load > 0.0 and not pressure.any():
        _spread(load, depth, pressure, touching)
    chosen = inside.copy() if count <= DENSE_LIMIT else (start.possible | touching) & inside
    displacement, whole = np.zeros_like(depth), whole_box(depth.shape, coefficients, known)
    fresh = not pressure.any()  # whether the displacement is that of the pressure
    iterations, shift = 0, 0.0
    while True:
        rows, columns = np.nonzero(chosen)
        dense = rows.size <= DENSE_LIMIT
        if not (fresh or dense):
            displace(pressure, whole, displacement)
        cells = gather_cells(operator(rows, columns, coefficients, known, dense), _at(rows, columns, depth) + shift)
        compact, contact = _compact(rows, columns, pressure, touching)
        gap = _gap(rows, columns, cells, compact, displacement, fresh or not dense)
        outcome = solve(cells, compact, gap, contact, goal, max_iterations - iterations, load, PATIENCE)
        pressure[:] = 0.0
        for k in range(rows.size):
            pressure[rows[k], columns[k]] = compact[k]
        displace(pressure, whole, displacement)
        iterations, shift, fresh = iterations + outcome.iterations + 2 - fresh, shift + outcome.shift, True
        worst = _violation(pressure, displacement, depth, shift, goal, touching)
        if outcome.status != CONVERGED or worst <= goal:
            return pressure, displacement, Outcome(outcome.status, iterations, worst, shift)
        chosen |= touching


@kernel
def _at(rows, columns, field):
    """Return the field's values at the cells."""
    values = np.empty(rows.size)
    for k in range(rows.size):
        values[k] = field[rows[k], columns[k]]
    return values


@kernel
def _spread(load, depth, pressure, touching):
    """Let the cells that may touch, at least the deepest, carry a load in equal parts."""
    deepest = np.argmax(np.where(depth == depth, depth, -np.inf))
    touching[deepest // depth.shape[1], deepest % depth.shape[1]] = True
    share = load / touching.sum()
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            pressure[i, j] = share if touching[i, j] else 0.0


@kernel
def _compact(rows, columns, pressure, touching):
    """Return pressures and contact of the cells as compact vectors."""
    compact, contact = np.zeros(rows.size + 1), np.zeros(rows.size + 1, np.bool_)
    for k in range(rows.size):
        compact[k], contact[k] = pressure[rows[k], columns[k]], touching[rows[k], columns[k]]
    return compact, contact


@kernel
def _gap(rows, columns, cells, compact, displacement, known):
    """Return the gaps under the pressures ``compact``, from the displacement where it is known."""
    gap = np.zeros(compact.size)
    if not known:
        multiply(cells.operator, compact, gap)
    for k in range(rows.size):
        gap[k] += (displacement[rows[k], columns[k]] if known else 0.0) - cells.depth[k]
    return gap


@kernel
def _violation(pressure, displacement, depth, shift, goal, touching):
    """Mark the cells that touch or penetrate; return the largest |g| in contact or penetration outside."""
    worst = 0.0
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            overlap = depth[i, j] + shift
            gap = displacement[i, j] - overlap
            loaded = pressure[i, j] > 0.0
            touching[i, j] = loaded or (overlap > 0.0 and gap < -goal)
            if loaded or overlap > 0.0:
                worst = max(worst, abs(gap) if loaded else -gap)
    return worst
