"""Adhesionless contact of a rigid profile with a half space: Kalker's active set.

On cells with undeformed separation S (nm), at a displacement δ (nm), find pressures p with

    p ≥ 0,     g = S + A p − δ ≥ 0,     p g = 0                       (Kalker 1990; Cheng et al. eqs. 36–39)

where A holds Love's coefficients (nm/GPa). A set C of cells is taken to be in contact; there g = 0 is
solved by conjugate gradients; cells that pull (p < 0) leave C and cells that interpenetrate (g < 0) join,
until none does. A is symmetric and positive definite, so the solution exists and is one; exchanging all
violating cells at once converges in a few rounds, and where rounds stop making progress the cells are
exchanged one at a time by least index, which is finite (Júdice & Pires 1994).

Three facts make it fast, all exact: only cells with S < δ can carry load, since A p ≥ 0, so everything
else is cut away; pressures scale with E*/dx, so cells of unit side and unit modulus are solved; and A is
near to an inverse of |q| in Fourier space, which a 3 × 3 stencil approximates well enough as a
preconditioner to halve the iterations at the cost of a few additions per cell.

Compact vectors hold the overlapping cells and one more entry that stays zero: the neighbour that is not there.
"""

from typing import NamedTuple

import numpy as np

from .halfspace import product
from .jit import kernel

#: How a solve ended.
CONVERGED, ITERATION_LIMIT = 0, 1

#: Reasons, by status.
REASONS = {CONVERGED: "converged", ITERATION_LIMIT: "iteration limit reached before the tolerance"}

#: Inverse of Love's coefficients at offsets (0,0), (0,1), (1,1), from 1/Â on a periodic grid of 128² cells.
_STENCIL = (1.1628, -0.1831, -0.0478)

#: A round of conjugate gradients ends when the largest gap has fallen to this part of the largest violation.
_ROUND = 0.1

#: d ln F / d ln depth of a sphere.
_LOAD_EXPONENT = 1.5

#: Solves at most to find the displacement of one load.
_MAX_SOLVES = 30

#: Rounds without fewer violations than ever before, until cells are exchanged one at a time.
_PATIENCE = 10


class Solution(NamedTuple):
    """One contact: pressures on the window (dx × dx cells), integrals and how the solve ended."""

    pressure: np.ndarray  #: GPa, >= 0
    force: float  #: nN
    area: float  #: nm²
    status: int
    iterations: int  #: products A p
    residual: float  #: largest |g| in contact or penetration outside, over the deepest overlap

    @property
    def converged(self):
        """Whether the tolerance was met."""
        return self.status == CONVERGED


class _Overlap(NamedTuple):
    """The cells that can carry load: their place in the window, their depth and their neighbours."""

    cells: np.ndarray  # index into the flattened window
    depth: np.ndarray  # δ − S > 0 (nm)
    neighbours: np.ndarray  # (count, 8): four by side, four by corner; `count` where there is none
    product: object
    largest: float  # largest depth (nm)


def solve(separation, delta, dx, contact_modulus, *, tolerance=1e-6, start=None, max_iterations=5000):
    """Solve the contact at one displacement.

    Parameters
    ----------
    separation : (nx, ny) array
        Undeformed separation S, nm; NaN or inf where there is nothing to touch.
    delta : float
        Displacement, nm.
    dx : float
        Side of the cells, nm.
    contact_modulus : float
        E*, GPa.
    tolerance : float
        Relative error of the force: the gap left in contact, and the penetration outside, stay below half
        of it times the deepest overlap (force grows about like depth^1.5, or as depth^1 at first touch).
    start : (nx, ny) array, optional
        Pressures near the solution's, GPa.
    max_iterations : int
        Products A p at most.

    Returns
    -------
    Solution
    """
    overlap = _overlapping(separation, delta)
    if overlap is None:
        return _untouched(separation.shape)
    scale = contact_modulus / dx
    count = overlap.cells.size
    pressure = np.zeros(count + 1)
    gap = np.empty(count + 1)
    contact = np.zeros(count + 1, dtype=np.bool_)
    if start is None:
        contact[:count] = overlap.depth > 0.5 * overlap.largest
    else:
        pressure[:count] = start.ravel()[overlap.cells] / scale
        contact[:count] = pressure[:count] > 0
    goal = 0.5 * tolerance * overlap.largest
    status, iterations, worst = _active_set(overlap, pressure, gap, contact, goal, max_iterations)
    field = np.zeros(separation.shape)
    field.ravel()[overlap.cells] = pressure[:-1] * scale
    area = np.count_nonzero(pressure) * dx * dx
    return Solution(field, float(field.sum()) * dx * dx, area, status, iterations, worst)


def sweep(separation, deltas, dx, contact_modulus, *, tolerance=1e-6, max_iterations=5000):
    """Yield the contact at each of ascending displacements, each started from those before.

    The start is the straight line in δ through the two solutions before, pulling cells cut off: pressures
    grow smoothly with δ, so it is right to a few per cent.
    """
    before, last = None, None
    for delta in deltas:
        start = _extrapolated(before, last, delta)
        solution = solve(
            separation, delta, dx, contact_modulus, tolerance=tolerance, start=start, max_iterations=max_iterations
        )
        if solution.force > 0:
            before, last = last, (delta, solution.pressure)
        yield solution


def loaded(separation, loads, dx, contact_modulus, *, tolerance=1e-6, max_iterations=5000):
    """Yield (delta, contact) for each of ascending loads (nN > 0), each started from the one before.

    ln F grows smoothly and almost straight with ln(δ − δ₁), δ₁ the first touch, so the secant rule finds δ in
    a few solves, each started from the last, and loose as long as the load is far off.
    """
    touch = float(np.nanmin(separation))
    depths = np.sort(separation[np.isfinite(separation)] - touch, axis=None)
    solution = None
    for load in loads:
        depth = _depth_estimate(depths, load, dx, contact_modulus)
        if solution is not None:
            depth = last_depth * (load / solution.force) ** (1 / _LOAD_EXPONENT)
        points, error, solves, products = [], 1.0, 0, 0
        while abs(error) > tolerance and solves < _MAX_SOLVES:
            solution = solve(
                separation,
                touch + depth,
                dx,
                contact_modulus,
                tolerance=max(0.1 * tolerance, min(1e-3, 1e-2 * abs(error))),
                start=None if solution is None else solution.pressure,
                max_iterations=max_iterations,
            )
            solves, products = solves + 1, products + solution.iterations
            last_depth, error = depth, solution.force / load - 1
            points = [*points[-1:], (np.log(depth), np.log(solution.force))]
            depth = float(np.exp(points[-1][0] + (np.log(load) - points[-1][1]) / _exponent(points)))
        status = solution.status if abs(error) <= tolerance else ITERATION_LIMIT
        yield touch + last_depth, solution._replace(status=status, iterations=products)


def _exponent(points):
    """Return d ln F / d ln depth through the last two points; a sphere's where there is one only."""
    if len(points) < 2 or points[0][0] == points[1][0]:
        return _LOAD_EXPONENT
    return float(np.clip(np.diff(points, axis=0)[0] @ (0, 1) / np.diff(points, axis=0)[0, 0], 1.0, 4.0))


def _depth_estimate(depths, load, dx, contact_modulus):
    """Return the depth at which F = (4/3) E* depth √(overlap area/2π), as for a paraboloid, reaches the load."""
    area = np.arange(1, depths.size) * dx * dx
    force = 4 / 3 * contact_modulus * depths[1:] * np.sqrt(area / (2 * np.pi))
    k = min(int(np.searchsorted(force, load)), force.size - 1)
    reached = depths[k + 1] if force[k] > 0 else dx
    return float(reached * (load / force[k]) ** (1 / _LOAD_EXPONENT)) if force[k] > 0 else float(reached)


def _extrapolated(before, last, delta):
    if last is None:
        return None
    if before is None or last[0] == before[0]:
        return last[1]
    ahead = (delta - last[0]) / (last[0] - before[0])
    return np.maximum(last[1] + ahead * (last[1] - before[1]), 0.0)


def _overlapping(separation, delta):
    """Return the cells with S < δ, or None."""
    depth = delta - separation
    inside = depth > 0
    cells = np.flatnonzero(inside)
    if cells.size == 0:
        return None
    rows, columns = np.divmod(cells, separation.shape[1])
    engine = product(rows - rows.min(), columns - columns.min())
    depth = depth.ravel()[cells]
    return _Overlap(cells, depth, _neighbours(inside, cells), engine, float(depth.max()))


def _untouched(shape):
    return Solution(np.zeros(shape), 0.0, 0.0, CONVERGED, 0, 0.0)


def _active_set(overlap, pressure, gap, contact, goal, max_iterations):
    """Exchange cells and solve until every condition holds to ``goal`` (nm); return status, products, violation."""
    direction, image = np.zeros_like(pressure), np.zeros_like(pressure)
    preconditioned, removed = np.zeros_like(pressure), np.zeros_like(pressure)
    overlap.product(pressure, gap)
    _open(gap, overlap.depth)
    _join(gap, contact, goal)
    iterations, fewest, patience = 1, np.inf, _PATIENCE
    while True:
        target = max(_ROUND * _violation(gap, contact)[0], 0.5 * goal) if patience > 0 else 0.5 * goal
        slope = 0.0
        while _violation(gap, contact)[1] > target and iterations < max_iterations:
            slope = _search(gap, contact, overlap.neighbours, preconditioned, direction, slope)
            overlap.product(direction, image)
            iterations += 1
            _advance(pressure, gap, direction, image, slope)
        pulling, count = _count(pressure, gap, contact, goal)
        worst = _violation(gap, contact)[0]
        if pulling == 0 and worst <= goal:
            return CONVERGED, iterations, worst / overlap.largest
        fewest, patience = (count, _PATIENCE) if count < fewest else (fewest, patience - 1)
        if _exchange(pressure, gap, contact, removed, goal, patience <= 0):
            overlap.product(removed, image)
            iterations += 1
            gap += image
        if iterations >= max_iterations:
            return ITERATION_LIMIT, iterations, _violation(gap, contact)[0] / overlap.largest


@kernel
def _neighbours(inside, cells):
    """Return for each cell the compact index of the four cells beside it and the four at its corners."""
    rows, columns = inside.shape
    count = cells.size
    number = np.full((rows + 2, columns + 2), count, dtype=np.int32)
    for k in range(count):
        number[cells[k] // columns + 1, cells[k] % columns + 1] = k
    neighbours = np.empty((count, 8), dtype=np.int32)
    for k in range(count):
        i, j = cells[k] // columns + 1, cells[k] % columns + 1
        neighbours[k, 0], neighbours[k, 1] = number[i - 1, j], number[i + 1, j]
        neighbours[k, 2], neighbours[k, 3] = number[i, j - 1], number[i, j + 1]
        neighbours[k, 4], neighbours[k, 5] = number[i - 1, j - 1], number[i - 1, j + 1]
        neighbours[k, 6], neighbours[k, 7] = number[i + 1, j - 1], number[i + 1, j + 1]
    return neighbours


@kernel
def _open(gap, depth):
    """Turn the displacement into the gap g = A p − (δ − S)."""
    for k in range(depth.size):
        gap[k] -= depth[k]
    gap[-1] = 0.0


@kernel
def _join(gap, contact, goal):
    for k in range(gap.size - 1):
        if gap[k] < -goal:
            contact[k] = True


@kernel
def _violation(gap, contact):
    """Return the largest |gap| in contact or penetration outside, and the largest |gap| in contact."""
    inside, outside = 0.0, 0.0
    for k in range(gap.size - 1):
        if contact[k]:
            inside = max(inside, abs(gap[k]))
        else:
            outside = max(outside, -gap[k])
    return max(inside, outside), inside


@kernel
def _search(gap, contact, neighbours, preconditioned, direction, slope):
    """Set the next conjugate direction on the contact cells; return the residual's preconditioned square."""
    count = gap.size - 1
    new = 0.0
    for k in range(count):
        if contact[k]:
            beside, corner = 0.0, 0.0
            for n in range(4):
                m = neighbours[k, n]
                if contact[m]:
                    beside -= gap[m]
                m = neighbours[k, n + 4]
                if contact[m]:
                    corner -= gap[m]
            preconditioned[k] = -_STENCIL[0] * gap[k] + _STENCIL[1] * beside + _STENCIL[2] * corner
            new -= gap[k] * preconditioned[k]
    ratio = new / slope if slope > 0.0 else 0.0
    for k in range(count):
        direction[k] = preconditioned[k] + ratio * direction[k] if contact[k] else 0.0
    return new


@kernel
def _advance(pressure, gap, direction, image, slope):
    """Go to the minimum of the energy along the direction."""
    count = gap.size - 1
    curvature = 0.0
    for k in range(count):
        curvature += direction[k] * image[k]
    step = slope / curvature
    for k in range(count):
        pressure[k] += step * direction[k]
        gap[k] += step * image[k]


@kernel
def _count(pressure, gap, contact, goal):
    """Return the number of cells that pull, and of all that violate a condition."""
    pulling, penetrating = 0, 0
    for k in range(gap.size - 1):
        if contact[k]:
            pulling += pressure[k] < 0.0
        else:
            penetrating += gap[k] < -goal
    return pulling, pulling + penetrating


@kernel
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
