"""Equilibrium of an adhesive contact at a fixed displacement: a local minimum of its energy, found downhill.

The cells of the set C (``glued``) are balanced one after the other, each on its own, which only ever lowers Π
(``adhesive_contact``), and together by Newton's method on the cells that are open, as long as their stiffness is
positive definite: where it is not, the state is past the end of its branch. Newton's whole step is taken where the
energy falls with it, as many cells change their regime in it: to halt at each took half as long again. Then others
are taken in that touch.

Unit cells and unit modulus, as in ``glued``.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel, reducing_kernel
from .cohesive_laws import balance, remaining_work, toughness, traction
from .constrained_cells import ABSENT, displacement_at, elastic_energy, glue, open_cell, unglue, with_room

#: A cell leaves the set once its gap is this many times the law's range.
_FORGET = 1.2

#: Times that a state takes in others before it is given up.
_ROUNDS = 60

#: What became of Newton's step.
_DONE, _PAST_END, _NO_ROOM = range(3)


class Problem(NamedTuple):
    """What is given, how tough the fronts have been found, and room to work in."""

    separation: np.ndarray  # (nx, ny) S, nm, with an empty margin
    coefficients: np.ndarray
    law: NamedTuple
    w: float
    tolerance: float
    max_iterations: int
    max_cells: int
    roots: np.ndarray  # (nx, ny) root of the factor on w of each cell (``cohesion.toughness``)
    open: np.ndarray  # (size,) room for Newton's step
    matrix: np.ndarray  # (size, size)
    step: np.ndarray  # (size,)


@kernel
def root_of(k, problem, glued):
    """Return the root of the factor on w of the k-th cell."""
    return problem.roots[glued.row[k], glued.column[k]]


@kernel
def settle(problem, delta, glued, count):
    """Balance the cells and take others in until none beside the contacts wants to join; return what that freed."""
    freed, rounds = 0.0, 0
    for attempt in range(_ROUNDS):
        fallen, done, fine, _ = descend(problem, delta, glued, count, np.inf)
        freed, rounds = freed + fallen, rounds + done
        before = count
        everywhere = problem.law.anywhere or attempt == 0
        glued, count, gained = _join(problem, delta, glued, count, everywhere)
        freed += gained
        if count == before:
            return glued, count, freed, rounds, fine
        if count >= problem.max_cells:
            break
    return glued, count, freed, rounds, False


@kernel
def descend(problem, delta, glued, count, patience):
    """Go downhill to a local minimum of Π.

    Parameters
    ----------
    patience : float
        Energy, nm²: once more has been freed past the end of a branch, what is left of the way is not gone.

    Returns
    -------
    freed, rounds, arrived, stable
        Energy, nm²; whether the minimum was reached; and whether the stiffness was positive definite all the way.
    """
    before = _energy(problem, delta, glued, count)
    goal = problem.tolerance * max(np.abs(glued.pressure[:count]).max() if count > 0 else 0.0, problem.law.strength)
    rounds, fine, stable = 0, False, True
    while rounds < problem.max_iterations:
        rounds += 1
        if _sweep(problem, glued, count) <= goal:
            fine = True
            break
        outcome = _newton(problem, delta, glued, count)
        if outcome != _DONE:
            stable = stable and outcome == _NO_ROOM
            for _ in range(10):
                _sweep(problem, glued, count)
            if before - _energy(problem, delta, glued, count) > patience:
                break
    return before - _energy(problem, delta, glued, count), rounds, fine, stable


@kernel
def forget(problem, glued, count):
    """Let go of the cells that are open beyond the law's range; return how many are left."""
    k = 0
    while k < count:
        if glued.gap[k] > _FORGET * problem.law.range * root_of(k, problem, glued):
            unglue(k, glued, count)
            count -= 1
        else:
            k += 1
    return count


@kernel
def _energy(problem, delta, glued, count):
    """Return Π, nm²."""
    total = elastic_energy(problem.separation, delta, glued, count)
    for k in range(count):
        total -= remaining_work(glued.gap[k], problem.law, root_of(k, problem, glued))
    return total


@kernel
def _join(problem, delta, glued, count, everywhere):
    """Glue the cells that interpenetrate, and those within the law's range that it acts on."""
    separation, place, law = problem.separation, glued.place, problem.law
    reach = law.range if law.anywhere else 0.0
    highest = _uplift(separation, delta, glued, count) + reach
    nx, ny = separation.shape
    cells, gaps, found = np.empty((nx * ny, 2), np.int64), np.empty(nx * ny), 0
    for i in range(1, nx - 1):
        for j in range(1, ny - 1):
            if place[i, j] != ABSENT or not separation[i, j] < np.inf:
                continue
            beside = place[i - 1, j] != ABSENT or place[i + 1, j] != ABSENT
            beside = beside or place[i, j - 1] != ABSENT or place[i, j + 1] != ABSENT
            if not beside and not (everywhere and separation[i, j] - delta < highest):
                continue
            gap = separation[i, j] - delta + displacement_at(i, j, glued, count, problem.coefficients)
            if gap < (law.range if beside else reach):
                cells[found], gaps[found], found = (i, j), gap, found + 1
    gained = 0.0
    for k in range(found):
        if count < problem.max_cells:
            i, j = cells[k]
            glued = with_room(glued, count)
            problem.roots[i, j] = _root_beside(i, j, problem, glued)
            glue(i, j, gaps[k], separation[i, j], glued, count, problem.coefficients)
            gained += remaining_work(max(gaps[k], 0.0), law, problem.roots[i, j])
            count += 1
    return glued, count, gained


@kernel
def _uplift(separation, delta, glued, count):
    """Return the highest that the surface is drawn up, nm: nowhere higher than within the set."""
    highest = 0.0
    for k in range(count):
        highest = max(highest, separation[glued.row[k], glued.column[k]] - delta - glued.gap[k])
    return highest


@kernel
def _root_beside(i, j, problem, glued):
    """Return the root that a cell takes over from its neighbours, or that of a contact of one cell."""
    if problem.law.anywhere:
        return 1.0
    root = 0.0
    for a, b in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
        if glued.place[a, b] != ABSENT:
            root = max(root, problem.roots[a, b])
    return root if root > 0.0 else np.sqrt(toughness(np.sqrt(1.0 / np.pi)))


@kernel
def _sweep(problem, glued, count):
    """Balance every cell on its own in turn; return the largest traction that was out of balance, nm."""
    worst = 0.0
    for k in range(count):
        u, p, root = glued.gap[k], glued.pressure[k], root_of(k, problem, glued)
        if u != 0.0 or p < -root * problem.law.strength:
            stiffness = glued.inverse[k, k]
            change = balance(p, u, stiffness, problem.law, root) - u
            if change != 0.0:
                worst = max(worst, abs(change) * stiffness)
                open_cell(k, change, glued, count)
    return worst


@kernel
def _newton(problem, delta, glued, count):
    """Balance all open cells together, if there is room for them and the state is not past its branch's end.

    The whole step where the energy falls with it, else up to the first cell that changes its regime, where it must.
    """
    size = 0
    for k in range(count):
        if glued.gap[k] > 0.0:
            if size == problem.open.size:
                return _NO_ROOM
            problem.open[size] = k
            size += 1
    for a in range(size):
        k = problem.open[a]
        t, slope = traction(glued.gap[k], problem.law, root_of(k, problem, glued))
        problem.step[a] = -(glued.pressure[k] + t)
        for b in range(a + 1):
            problem.matrix[a, b] = glued.inverse[k, problem.open[b]]
        problem.matrix[a, a] += slope
    if not _solve(problem.matrix, problem.step, size):
        return _PAST_END
    part = _admissible(problem, glued, size)
    if part < 1.0:
        gap, pressure = glued.gap[:count].copy(), glued.pressure[:count].copy()
        before = _energy(problem, delta, glued, count)
        _open_all(1.0, size, problem, glued, count)
        if _energy(problem, delta, glued, count) < before:
            return _DONE
        glued.gap[:count], glued.pressure[:count] = gap, pressure
    _open_all(part, size, problem, glued, count)
    return _DONE


@kernel
def _open_all(part, size, problem, glued, count):
    """Go a part of Newton's step; what would close beyond touching touches."""
    for a in range(size):
        k = problem.open[a]
        change = part * problem.step[a]
        open_cell(k, -glued.gap[k] if glued.gap[k] + change < 1e-14 else change, glued, count)


@kernel
def _admissible(problem, glued, size):
    """Return the part of Newton's step up to the first cell that closes or crosses the law's range."""
    part = 1.0
    for a in range(size):
        k, change = problem.open[a], problem.step[a]
        u, root = glued.gap[k], root_of(k, problem, glued)
        if u + change < 0.0:
            part = min(part, -u / change)
        for corner in (problem.law.range * root, problem.law.length * root):
            if (u < corner) != (u + change < corner) and corner > 0.0:
                part = min(part, (corner - u) / change * (1.0 + 1e-9))
    return part


@reducing_kernel
def _solve(matrix, right, size):
    """Solve in place by Cholesky's factors of the lower triangle; False if it is not positive definite."""
    for a in range(size):
        row = matrix[a]
        for b in range(a + 1):
            other, total = matrix[b], row[b]
            for m in range(b):
                total -= row[m] * other[m]
            if b < a:
                row[b] = total / other[b]
            elif total <= 1e-6:
                return False
            else:
                row[a] = np.sqrt(total)
    for a in range(size):
        total = right[a]
        for m in range(a):
            total -= matrix[a, m] * right[m]
        right[a] = total / matrix[a, a]
    for a in range(size - 1, -1, -1):
        total = right[a]
        for m in range(a + 1, size):
            total -= matrix[m, a] * right[m]
        right[a] = total / matrix[a, a]
    return True
