"""Constrained cells that yield: on loading, cells pressed harder than the hardness give way until they are not.

Given pressures p = δ q₁ − q_S + M u of a set of cells (``constrained_cells``), find the depth d by which the surface of
each has given way, S = S₀ + d, such that

    p ≤ H,     d ≥ d₀,     (H − p)(d − d₀) = 0

with d₀ the depth before this step. As the cells at H give way, the pressures of all others rise, since M has positive
entries on its diagonal only. So each round takes all cells that press too hard, or gave way too much while the contact
was still smaller, and solves for them together (Cholesky), or one after the other where they are too many. The depth at
the end of a step is permanent (``halfspace.yielding``). Source: own. Unit cells and unit modulus.
"""

import numpy as np

from ..jit import kernel
from .cholesky import solve_in_place
from .constrained_cells import ABSENT, dent, displacement_at, open_cell

#: Parts by which a pressure may exceed the hardness: in a state, and within `give_way`.
OVER, _EXACT = 1e-3, 1e-9

#: Largest number of rounds in which more cells give way.
_MOST_ROUNDS = 200


@kernel
def begin_to_yield(problem):
    """Make the present depths permanent."""
    for i in range(problem.dent.shape[0]):
        for j in range(problem.dent.shape[1]):
            problem.stays[i, j] = problem.dent[i, j]


@kernel
def give_way(problem, delta, cells):
    """Let all cells that press too hard give way, at their present gaps."""
    _close_up(problem, delta, cells)
    hard = np.zeros(cells.count[0], np.bool_)
    for _ in range(_MOST_ROUNDS):
        if bears(_EXACT, problem, cells):
            break
        size = np.int64(0)
        for k in range(hard.size):
            hard[k] = cells.pressure[k] > problem.cap or _gives(cells.row[k], cells.column[k], problem)
            size += hard[k]
        if size > problem.open.size or not _together(hard, problem, cells):
            _one_by_one(hard, problem, cells)


@kernel
def bears(part, problem, cells):
    """Return whether each cell is at the hardness, to this part of it, or below it without giving way in this step."""
    for k in range(cells.count[0]):
        over = cells.pressure[k] / problem.cap - 1.0
        if over > part or (over < -part and _gives(cells.row[k], cells.column[k], problem)):
            return False
    return True


@kernel
def _gives(i, j, problem):
    return problem.dent[i, j] > problem.stays[i, j]


@kernel
def left_open(problem, cells):
    """Return whether a cell that gave way in this step has left the set since, and so gave way too far."""
    for i in range(problem.dent.shape[0]):
        for j in range(problem.dent.shape[1]):
            if _gives(i, j, problem) and cells.place[i, j] == ABSENT:
                return True
    return False


@kernel
def _close_up(problem, delta, cells):
    """Undo the depth that open cells gained in this step, until they touch, which changes no pressure."""
    for i in range(problem.dent.shape[0]):
        for j in range(problem.dent.shape[1]):
            if not _gives(i, j, problem):
                continue
            k = cells.place[i, j]
            if k == ABSENT:
                gap = problem.separation[i, j] - delta + displacement_at(i, j, cells, problem.coefficients)
            else:
                gap = cells.gap[k]
            back = min(max(gap, 0.0), problem.dent[i, j] - problem.stays[i, j])
            problem.dent[i, j] -= back
            problem.separation[i, j] -= back
            if k != ABSENT:
                open_cell(k, -back, cells)
                dent(k, -back, cells)


@kernel
def _together(hard, problem, cells):
    """Bring all marked cells to the hardness together; return False if their matrix is not positive definite."""
    size = np.int64(0)
    for k in range(hard.size):
        if hard[k]:
            problem.open[size] = k
            size += 1
    for a in range(size):
        k = problem.open[a]
        problem.step[a] = cells.pressure[k] - problem.cap
        for b in range(a + 1):
            problem.matrix[a, b] = cells.inverse[k, problem.open[b]]
    if not solve_in_place(problem.matrix, problem.step, size):
        return False
    for a in range(size):
        _give(problem.open[a], problem.step[a], problem, cells)
    return True


@kernel
def _one_by_one(hard, problem, cells):
    for k in range(hard.size):
        if hard[k]:
            _give(k, (cells.pressure[k] - problem.cap) / cells.inverse[k, k], problem, cells)


@kernel
def _give(k, depth, problem, cells):
    """Change the depth of a cell, but not to less than is permanent."""
    i, j = cells.row[k], cells.column[k]
    before = problem.dent[i, j]
    problem.dent[i, j] = max(before + depth, problem.stays[i, j])
    problem.separation[i, j] += problem.dent[i, j] - before
    dent(k, problem.dent[i, j] - before, cells)
