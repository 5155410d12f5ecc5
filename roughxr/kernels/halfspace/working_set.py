"""The contact in a box by a working set: the cells that may touch, and the check that no other cell does.

Given depths δ − S (nm) in a box, sought are pressures p ≥ 0 and displacements A p that meet the conditions of contact
(``active_set``) on every cell of it. The active set solves on the chosen cells alone, its search directions in single
precision. The product over the whole box, in double precision, then shows which other cells violate a condition; they
join the working set, and the active set continues. The first choice comes from the same problem on cells twice as
large, solved likewise (nested iteration); it affects the time of a solve, but not its result. Source: own.

Unit cells and unit modulus, as in ``active_set``; depths are negative for cells that do not overlap.
"""

from typing import NamedTuple

import numpy as np

from .active_set import CONVERGED, PATIENCE, Outcome, solve
from .products import DENSE_LIMIT, displaced, multiply, operator

#: After a coarse solve, cells whose predicted gap exceeds this part of the deepest overlap are left out.
_MARGIN = 0.05

#: Tolerance and iterations of the solve on cells twice as large, which is only a guess.
COARSE_TOLERANCE, COARSE_ITERATIONS = 1e-3, 1000


class Guess(NamedTuple):
    """A guess of a contact in a box."""

    pressure: np.ndarray
    touching: np.ndarray  # cells to start from
    possible: np.ndarray  # cells that may touch; the others are left out until they are found to penetrate


class Contact(NamedTuple):
    """The contact in a box; displacements are NaN where they are not known."""

    pressure: np.ndarray
    displacement: np.ndarray
    outcome: Outcome


def box_below(separation, delta):
    """Return the rows and columns of the bounding box of the cells with S < δ, and their number."""
    within = separation < delta
    rows, columns = (np.flatnonzero(within.any(axis)) for axis in (1, 0))
    if rows.size == 0:
        return (slice(0, 0), slice(0, 0)), 0
    return (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)), np.count_nonzero(within)


def contact_in(depth, tolerance, max_iterations, cap, guess=None):
    """Return the `Contact` in a box, from a guess or by nested iteration."""
    if guess is not None:
        return solve_in_box(depth, guess, 0.5 * tolerance, max_iterations, cap)
    levels = [depth]
    while np.count_nonzero(levels[-1] > 0.0) > DENSE_LIMIT and min(levels[-1].shape) >= 4:
        levels.append(halved(levels[-1]))
    guess = half_deep(levels[-1])
    for n in range(len(levels) - 1, 0, -1):
        coarse_cap = cap * 2**n  # with the cells' side E*/dx halves
        coarse = solve_in_box(levels[n], guess, 0.5 * COARSE_TOLERANCE, COARSE_ITERATIONS, coarse_cap)
        guess = refined(coarse, levels[n - 1], 0.5 * coarse_cap)
    return solve_in_box(depth, guess, 0.5 * tolerance, max_iterations, cap)


def half_deep(depth):
    """Return a guess for few cells: those that overlap by more than half the deepest, as under a paraboloid, touch."""
    return Guess(np.zeros(depth.shape), depth > 0.5 * depth.max(), np.ones(depth.shape, bool))


def halved(depth):
    """Return the means of 2 × 2 cells; odd rims are repeated."""
    odd = [(0, size % 2) for size in depth.shape]
    even = np.pad(depth, odd, mode="edge") if any(depth.shape[axis] % 2 for axis in (0, 1)) else depth
    rows = even[::2] + even[1::2]
    return 0.25 * (rows[:, ::2] + rows[:, 1::2])


def refined(coarse, depth, cap):
    """Return the guess in a box of depths from a solution on cells twice as large, its pressures below the cap."""
    rows, columns = (np.arange(size) // 2 for size in depth.shape)
    pressure = np.minimum(0.5 * coarse.pressure[rows[:, None], columns], cap)  # E*/dx is twice as large
    displacement = _between(_between(coarse.displacement).T).T[: depth.shape[0], : depth.shape[1]]
    gap, margin = displacement - depth, _MARGIN * depth.max()
    with np.errstate(invalid="ignore"):
        touching = ((gap < 0.0) | ((pressure > 0.0) & (pressure > gap))) & (pressure < cap)
        return Guess(pressure, touching, touching | ~(gap >= margin))


def _between(field):
    """Return a coarse field at the centres of cells half as long along the first axis, linear between centres."""
    out = np.repeat(0.75 * field, 2, axis=0)
    out[2::2] += 0.25 * field[:-1]
    out[1:-1:2] += 0.25 * field[1:]
    out[0] += 0.25 * field[0]
    out[-1] += 0.25 * field[-1]
    return out


def solve_in_box(depth, guess, part, max_iterations, cap, *, load=0.0, slack=0.0):
    """Return the `Contact` in a box, all conditions met to ``part`` of the deepest overlap.

    With a ``load`` the depths shift, and cells within ``slack`` of overlapping are included. No pressure exceeds the
    ``cap``.
    """
    inside, deepest = depth > -slack, depth.max()
    few, goal = np.count_nonzero(inside) <= DENSE_LIMIT, part * deepest
    touching = inside & guess.touching
    loaded = touching | (inside & (guess.pressure >= cap)) if cap < np.inf else touching
    pressure = np.where(loaded, guess.pressure, 0.0)
    chosen = inside if few else (inside & guess.possible) | loaded  # of few cells all are chosen
    if load > 0.0 and not pressure.any():
        touching = touching if touching.any() else depth == deepest
        pressure[touching] = load / np.count_nonzero(touching)
        chosen = chosen | touching
    if not chosen.any():
        chosen = depth == deepest
    displacement, products, shift = np.full(depth.shape, np.nan), 0, 0.0
    if np.count_nonzero(chosen) > DENSE_LIMIT:
        displacement, products = displaced(pressure), 1
    while True:
        left = max_iterations - products
        outcome = _solve_cells(chosen, depth, pressure, touching, displacement, goal, left, load, cap)
        products, shift, depth = products + outcome.iterations, shift + outcome.shift, depth + outcome.shift
        if few:
            return Contact(pressure, displacement, Outcome(outcome.status, products, outcome.violation, shift))
        displacement = displaced(pressure)
        products += 1
        worst, touching, chosen = _violation(pressure, displacement, depth, cap, goal, chosen)
        if outcome.status != CONVERGED or not worst > goal:  # of numbers that are none too
            return Contact(pressure, displacement, Outcome(outcome.status, products, worst, shift))


def _solve_cells(chosen, depth, pressure, touching, displacement, goal, max_iterations, load, cap):
    """Solve on the chosen cells in the box, from a displacement that belongs to the pressure, or is NaN."""
    rows, columns = np.nonzero(chosen)
    count, products = rows.size, 0
    cells = operator(rows, columns, dense=count <= DENSE_LIMIT)
    compact, gap, contact = np.zeros(count + 1), np.zeros(count + 1), np.zeros(count + 1, bool)
    deep = depth[chosen]
    compact[:-1], gap[:-1], contact[:-1] = pressure[chosen], displacement[chosen], touching[chosen]
    if np.isnan(gap[0]):
        multiply(cells, compact, gap)
        products = 1
    gap[:-1] -= deep
    status, iterations, violation, shift = solve(
        cells, deep, compact, gap, contact, goal, max_iterations - products, load, cap, PATIENCE
    )
    pressure[chosen], displacement[chosen] = compact[:-1], gap[:-1] + (deep + shift)
    return Outcome(status, iterations + products, violation, shift)


def _violation(pressure, displacement, depth, cap, goal, chosen):
    """Return the largest |g| in contact or of the wrong sign outside, what touches, and the cells to choose."""
    gap, yielding = displacement - depth, pressure >= cap
    loaded = (pressure > 0.0) & ~yielding
    wrong = np.where(yielding, gap, np.where(loaded, np.abs(gap), -gap))
    deep = depth > 0.0
    touching = loaded | (deep & (wrong > goal))
    return wrong[loaded | deep].max(initial=0.0), touching, chosen | touching | yielding
