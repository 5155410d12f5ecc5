"""Kalker's active set on a given list of cells: the cells that touch, and their pressures.

On ``count`` cells of unit side and unit modulus, overlapping the undeformed half space by h, find pressures p with

    p ≥ 0,     g = A p − h ≥ 0,     p g = 0

where A holds Love's coefficients (Kalker 1990; Cheng, Dunn & Brach below eq. 42). A set C of cells is taken to be in
contact, and g = 0 is solved there by conjugate gradients; cells in tension (p < 0) leave C and cells that penetrate
(g < 0) join it, until none does. If pressures are capped, p ≤ H (Almqvist et al. 2007), cells above the cap leave C as
well, with p = H, and rejoin it if their gap opens: for them −g ≥ 0 is the depth by which they have yielded. A cell
outside C yields if p = H and is open if p = 0. A is symmetric and positive definite, so the solution exists and is
unique: it minimises ½ p A p − h p within the bounds. Exchanging all violating cells at once converges in a few rounds;
when rounds stop making progress the cells are exchanged one at a time by least index, which ends (Júdice & Pires 1994).

A is nearly the inverse of |q| in Fourier space. Its own inverse is so short-ranged that 3 × 3 of its terms, within the
contact, are a good preconditioner: half the iterations, at the cost of a few additions per cell.

Pressures (p dx/E*), gaps and depths are in nm. Vectors are compact, see ``products``; their last entry stays zero and
represents a missing neighbour.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .products import multiply

#: Outcomes of a solve.
CONVERGED, ITERATION_LIMIT = 0, 1

#: Inverse of Love's coefficients at offsets (0,0), (0,1), (1,1), from 1/Â on a periodic grid of 128² cells.
STENCIL = (1.1628, -0.1831, -0.0478)

#: Offsets of a cell's neighbours, by side and by corner.
_OFFSETS = ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1))

#: Number of rounds without a new minimum of violations after which cells are exchanged one at a time.
PATIENCE = 10


class Outcome(NamedTuple):
    """The outcome of a solve."""

    status: int
    iterations: int  #: products A p
    violation: float  #: largest |g| in contact or penetration outside
    shift: float  #: added to all depths so that the load is met; 0 if no load is prescribed


class GradientVectors(NamedTuple):
    """Vectors of the conjugate gradients."""

    direction: np.ndarray
    image: np.ndarray  # A times the direction; before that the residual
    preconditioned: np.ndarray
    flat: np.ndarray  # approximate pressures of a flat punch on the contact
    change: np.ndarray  # of the pressures by an exchange of cells
    neighbours: np.ndarray  # (count, 8): four by side, four by corner; `count` for a missing one


@kernel
def solve(operator, depth, pressure, gap, contact, goal, max_iterations, load, cap, patience):
    """Solve from given pressures, their gaps and a contact, each (count + 1,), in place; return the `Outcome`.

    Gaps may be NaN: then they are computed first, by one product.
    Every condition is met to ``goal`` (nm) unless ``max_iterations`` products are not enough; pressures are never
    negative or above the ``cap``. With a ``load`` > 0 the pressures keep adding up to it, and all depths shift as
    needed: the search directions are projected onto zero total load, without a further product.
    """
    z = np.zeros((5, pressure.size))
    work = GradientVectors(z[0], z[1], z[2], z[3], z[4], _neighbours(operator.rows, operator.columns))
    iterations = 0
    slope = 0.0
    shift = 0.0
    fewest = np.inf
    rounds_left = patience
    changed = _count_as_change(depth, pressure, gap, work.change)
    while True:
        if load > 0.0 and slope == 0.0:
            changed, shift = _restore_load(operator, depth, pressure, gap, contact, work, changed, load, shift, cap)
        elif changed:
            _displace(operator, gap, work)
        iterations += changed
        violating, inside, worst = _violations(pressure, gap, contact, cap, goal)
        # a round of conjugate gradients ends when the largest gap is below this part of the largest violation
        target = max(0.15 * worst, 0.5 * goal) if rounds_left > 0 else 0.5 * goal
        if inside > target:
            products_left = max_iterations - iterations
            products, slope, shift = _close(
                operator, pressure, gap, contact, work, slope, shift, target, load, products_left
            )
            iterations += products
            violating, inside, worst = _violations(pressure, gap, contact, cap, goal)
        if violating == 0 and worst <= goal:
            return Outcome(CONVERGED, iterations, worst, shift)
        changed = False
        if violating > 0:
            slope = 0.0  # another contact: the old directions are no longer conjugate
            fewest, rounds_left = (violating, patience) if violating < fewest else (fewest, rounds_left - 1)
            changed = _exchange(pressure, gap, contact, cap, work.change, goal, rounds_left <= 0)
        if iterations >= max_iterations:
            for k in range(pressure.size):
                pressure[k] = min(max(pressure[k], 0.0), cap)
            worst = _violations(pressure, gap, contact, cap, goal)[2]
            return Outcome(ITERATION_LIMIT, iterations, worst, shift)


@kernel
def _count_as_change(depth, pressure, gap, change):
    """If gaps are unknown, set them as without pressures and count all pressures as a change; return whether so."""
    unknown = np.isnan(gap[0])
    if unknown:
        for k in range(depth.size):
            gap[k] = -depth[k]
            change[k] = pressure[k]
    return unknown


@kernel
def _neighbours(rows, columns):
    """Return for each cell the compact index of its four neighbours by side and four by corner."""
    count = rows.size
    last_column = 0
    for k in range(count):
        last_column = max(last_column, columns[k])
    number = np.full((rows[-1] + 3, last_column + 3), count, np.int32)
    for k in range(count):
        number[rows[k] + 1, columns[k] + 1] = k
    neighbours = np.empty((count, 8), np.int32)
    for k in range(count):
        for n, (di, dj) in enumerate(_OFFSETS):
            neighbours[k, n] = number[rows[k] + 1 + di, columns[k] + 1 + dj]
    return neighbours


@kernel
def _close(operator, pressure, gap, contact, work, slope, shift, target, load, most_products):
    """Close the gaps in contact to a target by conjugate gradients; return products, slope and the depths' shift."""
    products = 0
    closed = False
    while not closed and products < most_products:
        for k in range(gap.size):  # without branches, as below: half of the time
            work.image[k] = -gap[k] if contact[k] else 0.0
        _precondition(work.neighbours, work.image, work.preconditioned)
        if load > 0.0:
            shift += _project(gap, contact, work)
        slope = _search(work.image, contact, work.preconditioned, work.direction, slope)
        multiply(operator, work.direction, work.image)
        products += 1
        closed = _advance(pressure, gap, contact, work.direction, work.image, slope, target)
    return products, slope, shift


@kernel
def _precondition(neighbours, r, preconditioned):
    """Write approximate pressures that would close the residual, which is zero outside the contact."""
    for k in range(neighbours.shape[0]):
        n = neighbours[k]
        side_sum = r[n[0]] + r[n[1]] + r[n[2]] + r[n[3]]
        corner = r[n[4]] + r[n[5]] + r[n[6]] + r[n[7]]
        preconditioned[k] = STENCIL[0] * r[k] + STENCIL[1] * side_sum + STENCIL[2] * corner


@kernel
def _project(gap, contact, work):
    """Remove the net load from the preconditioned residual, and the corresponding shift from the gaps."""
    load = 0.0
    flat = 0.0
    for k in range(gap.size):
        load += work.preconditioned[k] if contact[k] else 0.0
        flat += work.flat[k]
    excess = load / flat
    for k in range(gap.size - 1):
        gap[k] += excess
        work.preconditioned[k] -= excess * work.flat[k]
        work.image[k] = -gap[k] if contact[k] else 0.0
    return -excess


@kernel(reorder=True)
def _search(residual, contact, preconditioned, direction, slope):
    """Set the next conjugate direction (the first if ``slope`` is 0); return the residual's preconditioned square."""
    new = 0.0
    for k in range(residual.size):
        new += residual[k] * preconditioned[k]
    ratio = new / slope if slope > 0.0 else 0.0
    for k in range(residual.size):
        direction[k] = preconditioned[k] + ratio * direction[k] if contact[k] else 0.0
    return new


@kernel(reorder=True)
def _advance(pressure, gap, contact, direction, image, slope, target):
    """Minimise the energy along the direction; return whether all gaps in contact are within the target."""
    curvature = 0.0
    for k in range(gap.size):
        curvature += direction[k] * image[k]
    step = slope / curvature
    beyond = False
    for k in range(gap.size):
        pressure[k] += step * direction[k]
        gap[k] += step * image[k]
        beyond |= contact[k] & (abs(gap[k]) > target)
    return not beyond


@kernel
def _violations(pressure, gap, contact, cap, goal):
    """Return the number of violating cells, the largest |g| in contact, and the largest violation of all gaps.

    Cells violate a condition in tension, above the cap, or with a gap of the wrong sign outside (`_gap_violation`).
    """
    violating = 0
    inside = 0.0
    worst = 0.0
    for k in range(gap.size - 1):
        if contact[k]:
            violating += (pressure[k] < 0.0) | (pressure[k] > cap)
            inside = max(inside, abs(gap[k]))
        else:
            wrong = _gap_violation(pressure[k], gap[k], cap)
            violating += wrong > goal
            worst = max(worst, wrong)
    return violating, inside, max(inside, worst)


@kernel
def _gap_violation(pressure, gap, cap):
    """Return the violation by the gap of a cell out of contact, open or yielding: positive if its sign is wrong."""
    return gap if pressure >= cap else -gap


@kernel
def _exchange(pressure, gap, contact, cap, change, goal, single):
    """Free cells beyond the bounds and add cells with a wrong gap, all or the first; return whether any was freed."""
    freed = False
    change[:] = 0.0
    for k in range(gap.size - 1):
        if contact[k] and (pressure[k] < 0.0 or pressure[k] > cap):
            bound = 0.0 if pressure[k] < 0.0 else cap
            contact[k] = False
            change[k] = bound - pressure[k]
            pressure[k] = bound
            freed = True
        elif not contact[k] and _gap_violation(pressure[k], gap[k], cap) > goal:
            contact[k] = True
        else:
            continue
        if single:
            break
    return freed


@kernel
def _displace(operator, gap, work):
    """Add the displacement under the change of pressures to the gaps."""
    multiply(operator, work.change, work.image)
    for k in range(gap.size):
        gap[k] += work.image[k]


@kernel
def _restore_load(operator, depth, pressure, gap, contact, work, changed, load, shift, cap):
    """Adapt the pressures of a changed contact to the load; return whether they have changed, and the depths' shift.

    If nothing yields the pressures are scaled; else the missing load is added as under a flat punch.
    """
    total, yields, touching = _load(pressure, contact, cap)
    if touching == 0:
        contact[_next_in_contact(pressure, gap, cap, load - total)] = True
        touching = 1
    flat = _flat_punch(contact, work)
    # relative rounding error of the load
    if yields and abs(load - total) > 1e-13 * load:
        for k in range(pressure.size):
            added = (load - total) / flat * work.flat[k]
            pressure[k] += added
            work.change[k] += added
        changed = True
    if changed:
        _displace(operator, gap, work)
    part = load / total if total != 0.0 and not yields else 1.0
    mean = 0.0
    for k in range(depth.size):
        pressure[k] *= part
        gap[k] = (gap[k] + depth[k] + shift) * part - depth[k] - shift
        mean += gap[k] / touching if contact[k] else 0.0
    for k in range(depth.size):
        gap[k] -= mean
    return changed, shift + mean


@kernel
def _load(pressure, contact, cap):
    """Return the load, whether any cell yields, and the number of cells in contact."""
    total = 0.0
    yields = False
    touching = 0
    for k in range(pressure.size):
        total += pressure[k]
        yields |= pressure[k] >= cap
        touching += contact[k]
    return total, yields, touching


@kernel
def _flat_punch(contact, work):
    """Write approximate pressures of a flat punch on the contact into ``work.flat``; return their sum."""
    for k in range(contact.size):
        work.image[k] = 1.0 if contact[k] else 0.0
    _precondition(work.neighbours, work.image, work.flat)
    total = 0.0
    for k in range(contact.size):
        work.flat[k] = work.flat[k] if contact[k] else 0.0
        total += work.flat[k]
    return total


@kernel
def _next_in_contact(pressure, gap, cap, missing):
    """Return the open cell of the least gap if load is missing, else the yielding cell of the least depth."""
    best = 0
    least = np.inf
    for k in range(pressure.size - 1):
        yielding = pressure[k] >= cap
        if yielding == (missing < 0.0) and abs(gap[k]) < least:
            best = k
            least = abs(gap[k])
    return best
