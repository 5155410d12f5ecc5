"""Kalker's active set on a given list of cells: which of them touch, and how hard.

On ``count`` cells of unit side and unit modulus, overlapping the undeformed half space by h, find pressures p with

    p ≥ 0,     g = A p − h ≥ 0,     p g = 0

where A holds Love's coefficients (Kalker 1990; Cheng, Dunn & Brach below eq. 42). A set C of cells is taken to be in
contact; there g = 0 is solved by conjugate gradients; cells that pull (p < 0) leave C and cells that interpenetrate
(g < 0) join, until none does. A is symmetric and positive definite, so the solution exists and is one; exchanging all
violating cells at once converges in a few rounds, and where rounds stop making progress the cells are exchanged one
at a time by least index, which is finite (Júdice & Pires 1994).

A is near to an inverse of |q| in Fourier space. Its own inverse is so short-ranged that 3 × 3 of its terms, within
the contact, precondition well: half the iterations, at the cost of a few additions per cell.

Vectors are compact, see ``products``; their last entry stays zero: the neighbour that is not there.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import line, table
from ..jit import kernel
from .products import Operator, divide, largest, multiply

#: How a solve ended.
CONVERGED, ITERATION_LIMIT = 0, 1

#: Inverse of Love's coefficients at offsets (0,0), (0,1), (1,1), from 1/Â on a periodic grid of 128² cells.
STENCIL = (1.1628, -0.1831, -0.0478)

#: A round of conjugate gradients ends when the largest gap has fallen to this part of the largest violation.
_ROUND = 0.15

#: Rounds without fewer violations than ever before, until cells are exchanged one at a time.
PATIENCE = 10


class Outcome(NamedTuple):
    """How a solve ended."""

    status: int
    iterations: int  #: products A p
    violation: float  #: largest |g| in contact or penetration outside
    shift: float  #: what was added to the depths to carry the load; 0 where none is prescribed


class Cells(NamedTuple):
    """The cells of a problem: how far they overlap, their neighbours, and A."""

    depth: np.ndarray  # h, (count,)
    neighbours: np.ndarray  # (count, 8): four by side, four by corner; `count` where there is none
    operator: Operator


@kernel(inner=True)
def gather_cells(operator, count):
    """Return the ``count`` `Cells` of an operator, their depths to be filled in."""
    return Cells(line(count, 0.0), _neighbours(operator.rows, operator.columns), operator)


@kernel(inner=True)
def solve(cells, pressure, gap, contact, goal, max_iterations, load, patience):
    """Solve from the given pressures, their gaps and a contact, each (count + 1,), which become the solution's.

    Every condition is met to ``goal`` (the unit of the depths) unless ``max_iterations`` products are not enough;
    pressures are never negative. Where ``load`` > 0 the pressures keep adding up to it, and all depths are shifted by
    what that takes: the search directions are projected onto loads of zero sum, at no further product. Returns the
    `Outcome`.
    """
    size = pressure.size
    direction, image, preconditioned, other = line(size, 0.0), line(size, 0.0), line(size, 0.0), line(size, 0.0)
    iterations, slope, shift, fewest, left = 0, 0.0, 0.0, np.inf, patience
    while True:
        if load > 0.0 and slope == 0.0:
            shift += _carry(pressure, gap, contact, cells.depth, shift, load)
            _precondition_unit(cells, contact, image, other)
        worst, inside = _violation(gap, contact)
        target = max(_ROUND * worst, 0.5 * goal) if left > 0 else 0.5 * goal
        closed = inside <= target
        while not closed and iterations < max_iterations:
            _residual(gap, contact, image)
            _precondition(cells, image, preconditioned)
            if load > 0.0:
                shift += _project(gap, contact, preconditioned, other)
                _residual(gap, contact, image)
            slope = _search(image, contact, preconditioned, direction, slope)
            multiply(cells.operator, direction, image)
            iterations += 1
            closed = _advance(pressure, gap, contact, direction, image, slope, target)
        violating, worst = _count(pressure, gap, contact, goal)
        if violating == 0 and worst <= goal:
            return Outcome(CONVERGED, iterations, worst, shift)
        if violating > 0:
            slope = 0.0  # another contact: the old directions are no longer conjugate
            fewest, left = (violating, patience) if violating < fewest else (fewest, left - 1)
            if _exchange(pressure, gap, contact, other, goal, left <= 0):
                multiply(cells.operator, other, image)
                iterations += 1
                for k in range(size):
                    gap[k] += image[k]
        if iterations >= max_iterations:
            return Outcome(ITERATION_LIMIT, iterations, _give_up(pressure, gap, contact), shift)


@kernel(inner=True)
def _neighbours(rows, columns):
    """Return for each cell the compact index of the four cells beside it and the four at its corners."""
    count = rows.size
    number = table(largest(rows) + 3, largest(columns) + 3, np.int32(count))
    for k in range(count):
        number[rows[k] + 1, columns[k] + 1] = k
    neighbours = table(count, 8, np.int32(count))
    for k in range(count):
        i, j = rows[k] + 1, columns[k] + 1
        neighbours[k, 0], neighbours[k, 1] = number[i - 1, j], number[i + 1, j]
        neighbours[k, 2], neighbours[k, 3] = number[i, j - 1], number[i, j + 1]
        neighbours[k, 4], neighbours[k, 5] = number[i - 1, j - 1], number[i - 1, j + 1]
        neighbours[k, 6], neighbours[k, 7] = number[i + 1, j - 1], number[i + 1, j + 1]
    return neighbours


@kernel(inner=True)
def _violation(gap, contact):
    """Return the largest |g| in contact or penetration outside, and the largest |g| in contact."""
    inside, outside = 0.0, 0.0
    for k in range(gap.size - 1):
        if contact[k]:
            inside = max(inside, abs(gap[k]))
        else:
            outside = max(outside, -gap[k])
    return max(inside, outside), inside


@kernel(inner=True)
def _carry(pressure, gap, contact, depth, shift, load):
    """Scale the pressures to the load, and shift the depths so that the gaps in contact balance; return the shift."""
    count, total = 0, 0.0
    for k in range(depth.size):
        count += contact[k]
        total += pressure[k]
    if total > 0.0:
        for k in range(depth.size):
            pressure[k] *= load / total
            gap[k] = (gap[k] + depth[k] + shift) * (load / total) - depth[k] - shift
    mean = 0.0
    for k in range(depth.size):
        mean += gap[k] / count if contact[k] else 0.0
    for k in range(depth.size):
        gap[k] -= mean
    return mean


@kernel(inline=True)
def _precondition_unit(cells, contact, unit, preconditioned):
    """Write what the preconditioner makes of a unit residual all over the contact, and zero outside."""
    for k in range(unit.size - 1):
        unit[k] = 1.0 if contact[k] else 0.0
    _precondition(cells, unit, preconditioned)
    for k in range(unit.size - 1):
        preconditioned[k] *= unit[k]


@kernel(inner=True)
def _project(gap, contact, preconditioned, unit):
    """Take the load out of the preconditioned residual, and the shift that it stands for out of the gaps."""
    total, whole = 0.0, 0.0
    for k in range(gap.size - 1):
        if contact[k]:
            total += preconditioned[k]
            whole += unit[k]
    excess = total / whole
    for k in range(gap.size - 1):
        gap[k] += excess
        preconditioned[k] -= excess * unit[k]
    return -excess


@kernel(inner=True)
def _residual(gap, contact, residual):
    """Write the gaps that are to be closed: free of branches, as the loops below are, for half of their time."""
    for k in range(gap.size):
        residual[k] = -gap[k] if contact[k] else 0.0


@kernel(inner=True, reorder=True)
def _search(residual, contact, preconditioned, direction, slope):
    """Set the next conjugate direction on the contact; return the residual's preconditioned square.

    ``slope`` is the last one's, or 0 to start anew.
    """
    new = 0.0
    for k in range(residual.size):
        new += residual[k] * preconditioned[k]
    ratio = new / slope if slope > 0.0 else 0.0
    for k in range(residual.size):
        direction[k] = preconditioned[k] + ratio * direction[k] if contact[k] else 0.0
    return new


@kernel(inline=True)
def _precondition(cells, residual, preconditioned):
    """Write nearly the pressures that would close the residual, which is zero outside the contact."""
    if cells.operator.inverse.box.size:
        divide(cells.operator, residual, preconditioned)
    else:
        _precondition_by_neighbours(cells.neighbours, residual, preconditioned)


@kernel(inner=True)
def _precondition_by_neighbours(neighbours, r, preconditioned):
    for k in range(neighbours.shape[0]):
        n = neighbours[k]
        beside = r[n[0]] + r[n[1]] + r[n[2]] + r[n[3]]
        corner = r[n[4]] + r[n[5]] + r[n[6]] + r[n[7]]
        preconditioned[k] = STENCIL[0] * r[k] + STENCIL[1] * beside + STENCIL[2] * corner


@kernel(inner=True, reorder=True)
def _advance(pressure, gap, contact, direction, image, slope, target):
    """Go to the least energy along the direction; say whether all gaps in contact are within the target."""
    curvature = 0.0
    for k in range(gap.size):
        curvature += direction[k] * image[k]
    step, beyond = slope / curvature, False
    for k in range(gap.size):
        pressure[k] += step * direction[k]
        gap[k] += step * image[k]
        beyond |= contact[k] & (abs(gap[k]) > target)
    return not beyond


@kernel(inner=True)
def _count(pressure, gap, contact, goal):
    """Return how many cells pull or penetrate, and the largest violation."""
    violating, worst = 0, 0.0
    for k in range(gap.size - 1):
        if contact[k]:
            violating += pressure[k] < 0.0
            worst = max(worst, abs(gap[k]))
        else:
            violating += gap[k] < -goal
            worst = max(worst, -gap[k])
    return violating, worst


@kernel(inner=True)
def _exchange(pressure, gap, contact, removed, goal, single):
    """Free the pulling cells and take in the penetrating ones, all or the first; say whether any was freed."""
    freed = False
    for k in range(gap.size - 1):
        removed[k] = 0.0
    for k in range(gap.size - 1):
        if contact[k] and pressure[k] < 0.0:
            contact[k] = False
            removed[k] = -pressure[k]
            pressure[k] = 0.0
            freed = True
        elif not contact[k] and gap[k] < -goal:
            contact[k] = True
        else:
            continue
        if single:
            break
    return freed


@kernel(inner=True)
def _give_up(pressure, gap, contact):
    """Cut off what still pulls; return the largest violation."""
    for k in range(gap.size - 1):
        pressure[k] = max(pressure[k], 0.0)
    return _violation(gap, contact)[0]
