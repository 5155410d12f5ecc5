"""The contact in a box by a working set: the cells that may touch, and the check that no other cell does.

Given depths δ − S (nm) in a box, sought are pressures p ≥ 0 and displacements A p that meet the conditions of contact
(``active_set``) on every cell of it. The active set solves on the chosen cells alone, its search directions in single
precision. The product over the whole box, in double precision, then shows which other cells violate a condition; they
join the working set, and the active set continues. Source: own.

Unit cells and unit modulus, as in ``active_set``; depths are δ − S, negative for cells that do not overlap.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import line, table, unset
from ..jit import kernel
from .active_set import CONVERGED, PATIENCE, Outcome, gather_cells, solve
from .products import DENSE_LIMIT, displace, multiply, operator, whole_box


class WarmStart(NamedTuple):
    """A guess of a contact, on a window or a box."""

    pressure: np.ndarray
    touching: np.ndarray  # cells to start from
    possible: np.ndarray  # cells that may touch; the others are left out until they are found to penetrate
    row: int = 0  # position of the box's first cell in these arrays
    column: int = 0


class Overlap(NamedTuple):
    """The cells with S < δ: their bounding box, their number, and the depth of the deepest (nm)."""

    row: int  # the box's first
    column: int
    rows: int
    columns: int
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
    high, wide = last_row - first_row + 1, last_column - first_column + 1
    return Overlap(first_row, first_column, high, wide, count, delta - least)


@kernel
def depth_in(separation, delta, box):
    """Return δ − S in the box of an `Overlap`."""
    depth = unset((box.rows, box.columns), 0.0)
    for i in range(box.rows):
        for j in range(box.columns):
            depth[i, j] = delta - separation[box.row + i, box.column + j]
    return depth


@kernel
def put(part, windows, k, box):
    """Copy a field in a box into the k-th window."""
    for i in range(part.shape[0]):
        for j in range(part.shape[1]):
            windows[k, box.row + i, box.column + j] = part[i, j]


@kernel
def overlap_of(depth, slack):
    """Return how many cells of a box overlap, or miss it by less than ``slack``, and the depth of the deepest."""
    count, largest = 0, -np.inf
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            if depth[i, j] > -slack:
                count, largest = count + 1, max(largest, depth[i, j])
    return count, largest


@kernel
def solve_in_box(depth, start, part, max_iterations, load, slack, cap, coefficients, known):
    """Return pressures, displacements (NaN where not known) and `Outcome` in a box.

    All conditions are met to ``part`` of the deepest overlap. With a ``load`` (else None) the depths shift, and cells
    within ``slack`` of overlapping are included. No pressure exceeds the ``cap``.
    """
    count, largest = overlap_of(depth, slack)
    few, goal = count <= DENSE_LIMIT, part * largest  # few cells are all chosen, and none is left to check
    pressure, touching, chosen = _begin(depth, start, slack, load, cap, few)
    rows, columns = depth.shape
    displacement, whole = table(rows, columns, np.nan), whole_box((0, 0) if few else depth.shape, coefficients, known)
    products, shift = 0, 0.0
    while True:
        if products == 0 and _count(chosen) > DENSE_LIMIT:
            displace(pressure, whole, displacement)
            products = 1
        left = max_iterations - products
        outcome = _solve_cells(
            chosen, depth, pressure, touching, displacement, goal, left, load, cap, coefficients, known
        )
        products, shift = products + outcome.iterations, shift + outcome.shift
        if few:
            return pressure, displacement, Outcome(outcome.status, products, outcome.violation, shift)
        displace(pressure, whole, displacement)
        products += 1
        worst = _violation(pressure, displacement, depth, cap, goal, touching, chosen)
        if outcome.status != CONVERGED or worst <= goal:
            return pressure, displacement, Outcome(outcome.status, products, worst, shift)


@kernel
def _begin(depth, start, slack, load, cap, all_chosen):
    """Return the initial pressures, the cells in contact, and the cells to work on."""
    rows, columns = depth.shape
    pressure, touching, chosen = table(rows, columns, 0.0), table(rows, columns, False), table(rows, columns, False)
    carrying, loaded = 0, False
    for i in range(rows):
        for j in range(columns):
            inside, k, m = depth[i, j] > -slack, start.row + i, start.column + j
            touching[i, j] = inside and start.touching[k, m]
            yielding = inside and not touching[i, j] and start.pressure[k, m] >= cap
            chosen[i, j] = inside and (all_chosen or start.possible[k, m] or touching[i, j] or yielding)
            pressure[i, j] = start.pressure[k, m] if touching[i, j] or yielding else 0.0
            carrying, loaded = carrying + touching[i, j], loaded or pressure[i, j] > 0.0
    if load is not None and not loaded:
        _spread(load / max(carrying, 1), carrying == 0, depth, pressure, touching, chosen)
    return pressure, touching, chosen


@kernel
def _spread(share, on_deepest, depth, pressure, touching, chosen):
    """Distribute a load evenly over the touching cells, or else over the deepest."""
    _, largest = overlap_of(depth, np.inf)
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            if touching[i, j] or (on_deepest and depth[i, j] == largest):
                pressure[i, j], touching[i, j], chosen[i, j] = share, True, True


@kernel
def _count(chosen):
    count = 0
    for i in range(chosen.shape[0]):
        for j in range(chosen.shape[1]):
            count += chosen[i, j]
    return count


@kernel
def _solve_cells(chosen, depth, pressure, touching, displacement, goal, max_iterations, load, cap, coefficients, known):
    """Solve on the chosen cells in the box, from a displacement that belongs to the pressure, or is NaN."""
    rows, columns = _places(chosen)
    count, products = rows.size, 0
    cells = gather_cells(operator(rows, columns, coefficients, known, count <= DENSE_LIMIT), count, cap)
    compact, gap, contact = line(count + 1, 0.0), line(count + 1, 0.0), line(count + 1, False)
    for k in range(count):
        i, j = rows[k], columns[k]
        cells.depth[k], contact[k] = depth[i, j], touching[i, j]
        compact[k], gap[k] = pressure[i, j], displacement[i, j]
    if np.isnan(gap[0]):
        multiply(cells.operator, compact, gap)
        products = 1
    for k in range(count):
        gap[k] -= cells.depth[k]
    outcome = solve(cells, compact, gap, contact, goal, max_iterations - products, load, np.int64(PATIENCE))
    _shift(depth, outcome.shift)
    for k in range(count):
        i, j = rows[k], columns[k]
        pressure[i, j], displacement[i, j] = compact[k], gap[k] + depth[i, j]
    return Outcome(outcome.status, outcome.iterations + products, outcome.violation, outcome.shift)


@kernel
def _shift(depth, shift):
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            depth[i, j] += shift


@kernel
def _places(chosen):
    """Return the rows and columns of the chosen cells."""
    count = _count(chosen)
    rows, columns, k = unset((count,), 0), unset((count,), 0), 0
    for i in range(chosen.shape[0]):
        for j in range(chosen.shape[1]):
            if chosen[i, j]:
                rows[k], columns[k], k = i, j, k + 1
    return rows, columns


@kernel
def _violation(pressure, displacement, depth, cap, goal, touching, chosen):
    """Choose the cells that penetrate; return the largest |g| in contact or of the wrong sign outside."""
    worst = 0.0
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            gap, yielding = displacement[i, j] - depth[i, j], pressure[i, j] >= cap
            loaded = pressure[i, j] > 0.0 and not yielding
            wrong = gap if yielding else abs(gap) if loaded else -gap
            touching[i, j] = loaded or (depth[i, j] > 0.0 and wrong > goal)
            chosen[i, j] |= touching[i, j] or yielding
            if loaded or depth[i, j] > 0.0:
                worst = max(worst, wrong)
    return worst
