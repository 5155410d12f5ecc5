"""Kalker's active set on a given list of cells: which of them touch, and their pressures.

On ``count`` cells of unit side and unit modulus, overlapping the undeformed half space by h, find pressures p with

    p ≥ 0,     g = A p − h ≥ 0,     p g = 0

where A holds Love's coefficients (Kalker 1990; Cheng, Dunn & Brach below eq. 42). A set C of cells is taken to be in
contact; there g = 0 is solved by conjugate gradients; cells that pull (p < 0) leave C and cells that interpenetrate
(g < 0) join, until none does. Where pressures are capped, p ≤ H (Almqvist et al. 2007), cells that press harder leave C
as well, with p = H, and rejoin it if their gap opens: for them −g ≥ 0 is the depth by which they have given way. The
pressure of a cell outside C tells whether it is open or yields. A is symmetric and positive definite, so the solution
exists and is unique: it minimises ½ p A p − h p within the bounds. Exchanging all violating cells at once converges in
a few rounds; where rounds stop making progress the cells are exchanged one at a time by least index, which is finite
(Júdice & Pires 1994).

A is nearly the inverse of |q| in Fourier space. Its own inverse is so short-ranged that 3 × 3 of its terms, within the
contact, are a good preconditioner: half the iterations, at the cost of a few additions per cell.

Pressures (p dx/E*), gaps and overlaps are in nm. Vectors are compact, see ``products``; their last entry stays zero and
stands for a missing neighbour.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import line, table
from ..jit import kernel
from .products import Operator, divide, largest, multiply

#: Outcomes of a solve.
CONVERGED, ITERATION_LIMIT = 0, 1

#: Inverse of Love's coefficients at offsets (0,0), (0,1), (1,1), from 1/Â on a periodic grid of 128² cells.
STENCIL = (1.1628, -0.1831, -0.0478)

#: A round of conjugate gradients ends when the largest gap has fallen to this part of the largest violation.
_ROUND = 0.15

#: Part of the load that is rounding.
_ROUNDING = 1e-13

#: Number of rounds without a new minimum of violations after which cells are exchanged one at a time.
PATIENCE = 10


class Outcome(NamedTuple):
    """The outcome of a solve."""

    status: int
    iterations: int  #: products A p
    violation: float  #: largest |g| in contact or penetration outside
    shift: float  #: what was added to the depths to carry the load; 0 where none is prescribed


class Cells(NamedTuple):
    """The cells of a problem: their overlaps and neighbours, and A."""

    depth: np.ndarray  # h, (count,)
    neighbours: np.ndarray  # (count, 8): four by side, four by corner; `count` for a missing one
    operator: Operator
    cap: float  # H dx/E*, the largest pressure; inf where nothing yields


class Work(NamedTuple):
    """Vectors of the conjugate gradients."""

    direction: np.ndarray
    image: np.ndarray  # A times the direction; before that the residual
    preconditioned: np.ndarray
    flat: np.ndarray  # nearly the pressures of a flat punch on the contact


@kernel
def gather_cells(operator, count, cap):
    """Return the ``count`` `Cells` of an operator, with their depths still to be filled in."""
    return Cells(line(count, 0.0), _neighbours(operator.rows, operator.columns), operator, cap)


@kernel
def solve(cells, pressure, gap, contact, goal, max_iterations, load, patience):
    """Solve from the given pressures, their gaps and a contact, each (count + 1,), which become the solution's.

    Every condition is met to ``goal`` (the unit of the depths) unless ``max_iterations`` products are not enough;
    pressures are never negative or above the cap. With a ``load`` > 0 the pressures keep adding up to it, and all
    depths are shifted by what that takes: the search directions are projected onto loads of zero sum, at no further
    product. Without one it is None, by which numba leaves out what a load needs: an eighth of the first call. Returns
    the `Outcome`.
    """
    size, cap = pressure.size, cells.cap
    work = Work(line(size, 0.0), line(size, 0.0), line(size, 0.0), line(size, 0.0))
    change = line(size, 0.0)
    iterations, slope, shift, fewest, left = 0, 0.0, 0.0, np.inf, patience
    changed, yields = False, _is_capped(pressure, cap)
    while True:
        if load is not None and slope == 0.0:
            changed, shift = _carry(cells, pressure, gap, contact, work, change, changed, load, shift, yields)
        elif changed:
            _displace(cells, gap, change, work.image)
        iterations += changed
        worst, inside = _violation(pressure, gap, contact, cap)
        target = max(_ROUND * worst, 0.5 * goal) if left > 0 else 0.5 * goal
        if inside > target:
            most = max_iterations - iterations
            products, slope, shift = _close(cells, pressure, gap, contact, work, slope, shift, target, load, most)
            iterations += products
        violating, worst = _count(pressure, gap, contact, cap, goal)
        if violating == 0 and worst <= goal:
            return Outcome(CONVERGED, iterations, worst, shift)
        changed = False
        if violating > 0:
            slope = 0.0  # another contact: the old directions are no longer conjugate
            fewest, left = (violating, patience) if violating < fewest else (fewest, left - 1)
            changed = _exchange(pressure, gap, contact, cap, change, goal, left <= 0)
            yields = yields or _is_capped(pressure, cap)
        if iterations >= max_iterations:
            return Outcome(ITERATION_LIMIT, iterations, _give_up(pressure, gap, contact, cap), shift)


@kernel
def _close(cells, pressure, gap, contact, work, slope, shift, target, load, most):
    """Close the gaps in contact to a target by conjugate gradients; return products, slope and the depths' shift."""
    products, closed = 0, False
    while not closed and products < most:
        _residual(gap, contact, work.image)
        _precondition(cells, work.image, work.preconditioned)
        if load is not None:
            shift += _project(gap, contact, work.preconditioned, work.flat)
            _residual(gap, contact, work.image)
        slope = _search(work.image, contact, work.preconditioned, work.direction, slope)
        multiply(cells.operator, work.direction, work.image)
        products += 1
        closed = _advance(pressure, gap, contact, work.direction, work.image, slope, target)
    return products, slope, shift


@kernel
def _carry(cells, pressure, gap, contact, work, change, changed, load, shift, yields):
    """Let another contact carry the load; return whether pressures have changed, and the shift of the depths."""
    missing = _missing(pressure, gap, contact, cells.cap, load) if yields else 0.0
    _ones_in(contact, work.image)
    _precondition(cells, work.image, work.flat)
    _keep_in(contact, work.flat)
    if abs(missing) > _ROUNDING * load:
        _top_up(pressure, work.flat, change, missing)
        changed = True
    if changed:
        _displace(cells, gap, change, work.image)
    if not yields:
        _scale(pressure, gap, cells.depth, shift, load)
    return changed, shift + _level(gap, contact)


@kernel
def _displace(cells, gap, change, image):
    """Add the displacement by a change of the pressures to the gaps."""
    multiply(cells.operator, change, image)
    for k in range(gap.size):
        gap[k] += image[k]


@kernel
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


@kernel
def _wrong_by(pressure, gap, cap):
    """Return by how much the gap of a cell out of contact has the wrong sign, be it open or yielding."""
    return gap if pressure >= cap else -gap


@kernel
def _violation(pressure, gap, contact, cap):
    """Return the largest |g| in contact or of the wrong sign outside, and the largest |g| in contact."""
    inside, outside = 0.0, 0.0
    for k in range(gap.size - 1):
        if contact[k]:
            inside = max(inside, abs(gap[k]))
        else:
            outside = max(outside, _wrong_by(pressure[k], gap[k], cap))
    return max(inside, outside), inside


@kernel
def _scale(pressure, gap, depth, shift, load):
    """Scale the pressures to the load, their gaps along with them."""
    total = 0.0
    for k in range(depth.size):
        total += pressure[k]
    if total > 0.0:
        for k in range(depth.size):
            pressure[k] *= load / total
            gap[k] = (gap[k] + depth[k] + shift) * (load / total) - depth[k] - shift


@kernel
def _is_capped(pressure, cap):
    """Return whether there is a cap, and a pressure at it."""
    if cap == np.inf:
        return False
    reaches = False
    for p in pressure:  # a tenth of what NumPy's own ``max`` takes to compile
        reaches |= p >= cap
    return reaches


@kernel
def _missing(pressure, gap, contact, cap, load):
    """Return what the pressures leave of the load for the contact to carry; where none is free, one more cell joins."""
    missing, carrying = load, False
    for k in range(pressure.size - 1):
        missing -= pressure[k]
        carrying |= contact[k]
    if not carrying:
        contact[_next_to_carry(pressure, gap, cap, missing)] = True
    return missing


@kernel
def _top_up(pressure, flat, change, missing):
    """Spread what is missing of the load as by a flat punch, and add it to the ``change``."""
    whole = 0.0
    for k in range(flat.size):
        whole += flat[k]
    share = missing / whole
    for k in range(pressure.size - 1):
        pressure[k] += share * flat[k]
        change[k] += share * flat[k]


@kernel
def _next_to_carry(pressure, gap, cap, missing):
    """Return the open cell of the least gap if load is missing, else the yielding one that has given way least."""
    best, least = 0, np.inf
    for k in range(pressure.size - 1):
        yielding = pressure[k] >= cap
        if yielding == (missing < 0.0) and abs(gap[k]) < least:
            best, least = k, abs(gap[k])
    return best


@kernel
def _level(gap, contact):
    """Shift the gaps so that those in contact have zero mean; return the shift of the depths."""
    count, mean = 0, 0.0
    for k in range(gap.size - 1):
        count += contact[k]
        mean += gap[k] if contact[k] else 0.0
    mean /= count
    for k in range(gap.size - 1):
        gap[k] -= mean
    return mean


@kernel
def _ones_in(contact, values):
    """Write ones in contact, and zeros outside."""
    for k in range(values.size - 1):
        values[k] = 1.0 if contact[k] else 0.0


@kernel
def _keep_in(contact, values):
    """Write zeros outside the contact."""
    for k in range(values.size - 1):
        if not contact[k]:
            values[k] = 0.0


@kernel
def _project(gap, contact, preconditioned, unit):
    """Remove the load from the preconditioned residual, and the shift that it stands for from the gaps."""
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


@kernel
def _residual(gap, contact, residual):
    """Write the gaps to be closed; without branches, like the loops below, in half of their time."""
    for k in range(gap.size):
        residual[k] = -gap[k] if contact[k] else 0.0


@kernel(reorder=True)
def _search(residual, contact, preconditioned, direction, slope):
    """Set the next conjugate direction, ``slope`` 0 to start anew; return the residual's preconditioned square."""
    new = 0.0
    for k in range(residual.size):
        new += residual[k] * preconditioned[k]
    ratio = new / slope if slope > 0.0 else 0.0
    for k in range(residual.size):
        direction[k] = preconditioned[k] + ratio * direction[k] if contact[k] else 0.0
    return new


@kernel
def _precondition(cells, residual, preconditioned):
    """Write nearly the pressures that would close the residual, which is zero outside the contact."""
    if len(cells.operator.convolutions) > 1:
        divide(cells.operator, residual, preconditioned)
    else:
        _precondition_by_neighbours(cells.neighbours, residual, preconditioned)


@kernel
def _precondition_by_neighbours(neighbours, r, preconditioned):
    for k in range(neighbours.shape[0]):
        n = neighbours[k]
        side_sum = r[n[0]] + r[n[1]] + r[n[2]] + r[n[3]]
        corner = r[n[4]] + r[n[5]] + r[n[6]] + r[n[7]]
        preconditioned[k] = STENCIL[0] * r[k] + STENCIL[1] * side_sum + STENCIL[2] * corner


@kernel(reorder=True)
def _advance(pressure, gap, contact, direction, image, slope, target):
    """Minimise the energy along the direction; return whether all gaps in contact are within the target."""
    curvature = 0.0
    for k in range(gap.size):
        curvature += direction[k] * image[k]
    step, beyond = slope / curvature, False
    for k in range(gap.size):
        pressure[k] += step * direction[k]
        gap[k] += step * image[k]
        beyond |= contact[k] & (abs(gap[k]) > target)
    return not beyond


@kernel
def _count(pressure, gap, contact, cap, goal):
    """Return how many cells pull, press above the cap or have the wrong gap outside, and the largest violation."""
    violating, worst = 0, 0.0
    for k in range(gap.size - 1):
        if contact[k]:
            violating += (pressure[k] < 0.0) | (pressure[k] > cap)
            worst = max(worst, abs(gap[k]))
        else:
            wrong = _wrong_by(pressure[k], gap[k], cap)
            violating += wrong > goal
            worst = max(worst, wrong)
    return violating, worst


@kernel
def _exchange(pressure, gap, contact, cap, change, goal, single):
    """Free cells beyond the bounds and add those with the wrong gap, all or the first; return whether any was freed."""
    freed = False
    for k in range(gap.size - 1):
        change[k] = 0.0
    for k in range(gap.size - 1):
        if contact[k] and (pressure[k] < 0.0 or pressure[k] > cap):
            bound = 0.0 if pressure[k] < 0.0 else cap
            contact[k] = False
            change[k] = bound - pressure[k]
            pressure[k] = bound
            freed = True
        elif not contact[k] and _wrong_by(pressure[k], gap[k], cap) > goal:
            contact[k] = True
        else:
            continue
        if single:
            break
    return freed


@kernel
def _give_up(pressure, gap, contact, cap):
    """Cut off pressures below zero or above the cap; return the largest violation."""
    for k in range(gap.size - 1):
        pressure[k] = min(max(pressure[k], 0.0), cap)
    return _violation(pressure, gap, contact, cap)[0]
