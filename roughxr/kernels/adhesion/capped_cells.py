"""Constrained cells that yield: on loading what presses harder than the hardness gives way until it does not.

Given pressures p = δ q₁ − q_S + M u of a set of cells (``constrained_cells``), find by which d the surface of each has
given way, S = S₀ + d, such that

    p ≤ H,     d ≥ d₀,     (H − p)(d − d₀) = 0

with d₀ what it had given way before this step. The cells at H push all others harder as they give way, since M has
positive entries on its diagonal only; so each round takes all that press too hard, or gave way too much while the
contact was still smaller, and solves for them at once (Cholesky), or for one after the other where they are too many.
What has given way stays when the step is over (``halfspace.yielding``). Source: own. Unit cells and unit modulus.
"""

import numpy as np

from ..jit import kernel
from .constrained_cells import ABSENT, dent, displacement_at, open_cell
from .equilibrium import solve_in_place

#: A pressure may exceed the hardness by this part, of a state and within `give_way`.
OVER, _EXACT = 1e-3, 1e-9

#: Rounds at most in which more cells give way.
_MOST_ROUNDS = 200


@kernel
def begin_to_yield(problem):
    """Take what has given way so far as that which stays."""
    for i in range(problem.dent.shape[0]):
        for j in range(problem.dent.shape[1]):
            problem.stays[i, j] = problem.dent[i, j]


@kernel
def give_way(problem, delta, cells):
    """Let all cells that press too hard give way, at the gaps that they have."""
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


@kernel(inner=True)
def bears(part, problem, cells):
    """Say whether all cells are at the hardness to this part of it, or below it and give no way in this step."""
    for k in range(cells.count[0]):
        over = cells.pressure[k] / problem.cap - 1.0
        if over > part or (over < -part and _gives(cells.row[k], cells.column[k], problem)):
            return False
    return True


@kernel(inner=True)
def _gives(i, j, problem):
    return problem.dent[i, j] > problem.stays[i, j]


@kernel(inner=True)
def left_open(problem, cells):
    """Say whether a cell that gave way in this step has left the set since: it gave way too far."""
    for i in range(problem.dent.shape[0]):
        for j in range(problem.dent.shape[1]):
            if _gives(i, j, problem) and cells.place[i, j] == ABSENT:
                return True
    return False


@kernel(inner=True)
def _close_up(problem, delta, cells):
    """Take back what open cells gave way in this step, until they touch: no pressure changes by it."""
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


@kernel(inner=True)
def _together(hard, problem, cells):
    """Bring all marked cells to the hardness at once, if their matrix lets it."""
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


@kernel(inner=True)
def _one_by_one(hard, problem, cells):
    for k in range(hard.size):
        if hard[k]:
            _give(k, (cells.pressure[k] - problem.cap) / cells.inverse[k, k], problem, cells)


@kernel(inner=True)
def _give(k, depth, problem, cells):
    """Let a cell give way by so much, or take back so much, but for what stays."""
    i, j = cells.row[k], cells.column[k]
    before = problem.dent[i, j]
    problem.dent[i, j] = max(before + depth, problem.stays[i, j])
    problem.separation[i, j] += problem.dent[i, j] - before
    dent(k, problem.dent[i, j] - before, cells)
