"""The contact in a box by a working set: the cells that may touch, and the check that no other cell does.

Given depths δ − S (nm) in a box, find pressures p ≥ 0 and displacements A p that meet the conditions of contact
(``active_set``) on every cell. The active set solves on the chosen cells alone, with search directions in single
precision. The product over the whole box, in double precision, then shows the other cells that violate a condition;
they join the working set, and the active set continues. The first choice comes from the same problem on cells twice as
large, solved in the same way (nested iteration); it affects the time of a solve, but not its result. Source: own.

Unit cells and unit modulus, as in ``active_set``; depths are negative for cells that do not overlap. Where a film
bulges beside the load these may touch, too, within ``slack``.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .active_set import CONVERGED, PATIENCE, Outcome, solve
from .products import DENSE_LIMIT, displaced, operator

#: Tolerance of the solve on cells twice as large, which only serves as a guess.
COARSE_TOLERANCE = 1e-3

#: Iterations of that solve.
COARSE_ITERATIONS = 1000


class Guess(NamedTuple):
    """A guess of a contact in a box."""

    pressure: np.ndarray
    touching: np.ndarray  # cells to start from
    possible: np.ndarray  # cells that may touch; others are left out until they penetrate


class SolvedContact(NamedTuple):
    """The contact in a box; displacements are NaN where they are not known."""

    pressure: np.ndarray
    displacement: np.ndarray
    outcome: Outcome


def slack_of(film):
    """Return by how much cells that may touch lie outside the overlap: not at all, unless the film bulges."""
    return np.inf if film is not None and film.bulges else 0.0


def box_below(lowest, delta):
    """Return the bounding box of the cells with S < δ, given the least S of each row and of each column."""
    rows, columns = (np.flatnonzero(least < delta) for least in lowest)
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def solve_contact(depth, tolerance, max_iterations, cap, guess=None, film=None):
    """Return the `Contact` in a box, from a guess or by nested iteration."""
    guess = _nested_guess(depth, cap, film) if guess is None else guess
    return solve_in_box(depth, guess, 0.5 * tolerance, max_iterations, cap, film, slack=slack_of(film))


def _nested_guess(depth, cap, film):
    """Return a guess from the solution on cells twice as large, themselves solved from such a guess."""
    if np.count_nonzero(depth > 0.0) <= DENSE_LIMIT or min(depth.shape) < 4:
        return half_deep(depth)
    coarser = halved(depth)
    thinner = film and film.on_cells(2)
    guess = _nested_guess(coarser, 2.0 * cap, thinner)  # with the cells' side E*/dx halves
    limits = (0.5 * COARSE_TOLERANCE, COARSE_ITERATIONS, 2.0 * cap)
    coarse = solve_in_box(coarser, guess, *limits, thinner, slack=slack_of(film))
    return refined(coarse, depth, cap)


def half_deep(depth):
    """Return a guess for few cells: as under a paraboloid, cells of more than half the deepest overlap touch."""
    return Guess(np.zeros(depth.shape), depth > 0.5 * depth.max(), np.ones(depth.shape, bool))


def halved(depth):
    """Return the means of 2 × 2 cells; an odd last row or column is repeated."""
    odd = [(0, size % 2) for size in depth.shape]
    even = np.pad(depth, odd, mode="edge") if any(depth.shape[axis] % 2 for axis in (0, 1)) else depth
    rows = even[::2] + even[1::2]
    return 0.25 * (rows[:, ::2] + rows[:, 1::2])


def refined(coarse, depth, cap):
    """Return the guess in a box of depths from a solution on cells twice as large, its pressures below the cap."""
    rows, columns = (np.arange(size) // 2 for size in depth.shape)
    pressure = np.minimum(0.5 * coarse.pressure[rows[:, None], columns], cap)  # E*/dx is twice as large
    displacement = _refine_rows(_refine_rows(coarse.displacement).T).T[: depth.shape[0], : depth.shape[1]]
    gap = displacement - depth
    # cells whose gap, predicted by a coarse solve, exceeds this part of the deepest overlap are left out at first
    margin = 0.05 * depth.max()
    with np.errstate(invalid="ignore"):
        touching = ((gap < 0.0) | ((pressure > 0.0) & (pressure > gap))) & (pressure < cap)
        return Guess(pressure, touching, touching | ~(gap >= margin))


def _refine_rows(field):
    """Interpolate a coarse field linearly to the centres of cells half as long along the first axis."""
    out = np.repeat(0.75 * field, 2, axis=0)
    out[2::2] += 0.25 * field[:-1]
    out[1:-1:2] += 0.25 * field[1:]
    out[0] += 0.25 * field[0]
    out[-1] += 0.25 * field[-1]
    return out


def solve_in_box(depth, guess, part, max_iterations, cap, film=None, *, load=0.0, slack=0.0):
    """Return the `Contact` in a box, all conditions met to ``part`` of the deepest overlap.

    With a ``load`` the depths shift, and cells that lack up to ``slack`` (nm) to overlap are included. No pressure
    exceeds the ``cap``.
    """
    inside = depth > -slack
    are_few = np.count_nonzero(inside) <= DENSE_LIMIT  # then all are chosen
    pressure, touching, chosen = _begin(depth, inside, are_few, guess, cap, load)
    products = 0
    displacement = np.full(depth.shape, np.nan)
    if np.count_nonzero(chosen) > DENSE_LIMIT:
        displacement = displaced(pressure, film)
        products = 1
    shift = 0.0
    goal = part * depth.max()
    while True:
        products_left = max_iterations - products
        outcome = _solve_cells(chosen, depth, pressure, touching, displacement, goal, products_left, load, cap, film)
        products = products + outcome.iterations
        shift = shift + outcome.shift
        depth = depth + outcome.shift
        if are_few:
            return SolvedContact(pressure, displacement, Outcome(outcome.status, products, outcome.violation, shift))
        displacement = displaced(pressure, film)
        products += 1
        worst = _violation(pressure, displacement, depth, cap, goal, touching, chosen)
        if outcome.status != CONVERGED or not worst > goal:  # true for NaN as well
            return SolvedContact(pressure, displacement, Outcome(outcome.status, products, worst, shift))


def _begin(depth, inside, are_few, guess, cap, load):
    """Return start pressures, cells in contact, and cells to solve on, from a guess."""
    contact = inside & guess.touching
    loaded = contact | (inside & (guess.pressure >= cap))
    start = np.where(loaded, guess.pressure, 0.0)
    chosen = loaded | (inside & (guess.possible | are_few))
    if not chosen.any() or (load > 0.0 and not start.any()):
        first = contact if contact.any() else depth == depth.max()
        start[first] = load / max(np.count_nonzero(contact), 1)
        chosen |= first
        contact = first & (load > 0.0)
    return start, contact, chosen


def _solve_cells(chosen, depth, pressure, touching, displacement, goal, max_iterations, load, cap, film):
    """Solve on the chosen cells of the box, from a displacement consistent with the pressure, or NaN."""
    at = rows, columns = np.nonzero(chosen)
    deep = depth[at]
    compact = np.append(pressure[at], 0.0)
    gap = np.append(displacement[at] - deep, 0.0)
    contact = np.append(touching[at], False)
    cells = operator(rows, columns, film, dense=rows.size <= DENSE_LIMIT)
    outcome = solve(cells, deep, compact, gap, contact, goal, max_iterations, load, cap, PATIENCE)
    pressure[at] = compact[:-1]
    displacement[at] = gap[:-1] + (deep + outcome.shift)
    return outcome


@kernel
def _violation(pressure, displacement, depth, cap, goal, touching, chosen):
    """Choose the cells that violate a condition as well; return the largest |g| in contact or of wrong sign outside."""
    worst = 0.0
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            gap = displacement[i, j] - depth[i, j]
            yielding = pressure[i, j] >= cap
            loaded = pressure[i, j] > 0.0 and not yielding
            wrong = gap if yielding else abs(gap) if loaded else -gap
            touching[i, j] = loaded or wrong > goal
            chosen[i, j] |= touching[i, j] or yielding
            worst = max(worst, wrong)
    return worst
