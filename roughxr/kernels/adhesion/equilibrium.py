"""Equilibrium of an adhesive contact at a fixed displacement: a local minimum of its energy, reached by descent.

Unknowns are the gaps u of the constrained cells (``constrained_cells``), with M = A⁻¹ on them; sought is a minimum of

    Π(u) = ½ Σ p (δ − S + u) − Σ W(u),    p = δ q₁ − q_S + M u,    u ≥ 0        (``path``)

by two methods in turn. Nonlinear Gauss-Seidel balances one cell after the other, each on its own, which never raises Π.
Newton's method balances all open cells (u > 0) at once, with the matrix M + dt/du, as long as this is positive
definite. Where it is not, the state is past the end of its branch: if many cells are open, they move together along a
direction of negative curvature (``conjugate_gradients``), which saves half the time where contacts jump. A full step is
taken where it lowers the energy, although cells may change their regime within it (closed, plateau, falling, beyond the
range): to stop at the first that does takes half as long again. Then cells that interpenetrate, or that adhesion
reaches, join the set.

Source: own. Unit cells and unit modulus, as in ``constrained_cells``: δ, S, u, p and tractions in nm, Π in nm².
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from . import tuning
from .cholesky import solve_in_place
from .cohesive_laws import CohesiveLaw, balance, remaining_work, toughness, traction
from .conjugate_gradients import solve_nearly
from .constrained_cells import (
    ABSENT,
    constrain,
    displacement_at,
    elastic_energy,
    open_cell,
    release,
    restore,
    save,
    with_room,
)

#: Outcomes of Newton's step.
_DONE, _PAST_END, _NO_ROOM = range(3)


class Problem(NamedTuple):
    """The input of a solve, the factor on w at each cell, and work space."""

    separation: np.ndarray  # (nx, ny) S, nm, with an empty margin
    coefficients: np.ndarray
    law: CohesiveLaw
    w: float
    tolerance: float
    max_iterations: int
    max_cells: int
    roots: np.ndarray  # (nx, ny) root of the factor on w at each cell (``cohesive_laws.toughness``)
    open: np.ndarray  # (size,) work space of Newton's step
    matrix: np.ndarray  # (size, size)
    step: np.ndarray  # (size,)
    cap: float  # largest pressure that the body bears on loading, nm (``capped_cells``)
    limit: float  # pressure above which the shares of force and area are reported, nm
    dent: np.ndarray  # (nx, ny) depth by which the surface has given way, nm, included in the separation
    stays: np.ndarray  # the same before this step


@kernel
def root_of(k, problem, cells):
    """Return the root of the factor on w at the k-th cell."""
    return problem.roots[cells.row[k], cells.column[k]]


class Descent(NamedTuple):
    """The outcome of a descent."""

    freed: float  # energy released, nm²
    rounds: int
    arrived: bool  # whether it reached a minimum
    stable: bool  # whether the stiffness was positive definite all the way


@kernel
def settle(problem, delta, cells):
    """Balance the cells and let others join, until none beside the contacts would.

    Returns
    -------
    ConstrainedCells, Descent
        The set, whose arrays may have been replaced by larger ones, and the outcome; ``stable`` is of the last descent.
    """
    freed, rounds, attempts, joining = 0.0, 0, 0, True
    arrived = stable = False
    while joining and attempts < tuning.MOST_JOININGS:
        way = descend(problem, delta, cells, np.inf)
        freed, rounds, stable = freed + way.freed, rounds + way.rounds, way.stable
        before = cells.count[0]
        cells, gained = _join(problem, delta, cells, problem.law.anywhere or attempts == 0)
        freed, attempts = freed + gained, attempts + 1
        joining = cells.count[0] > before
        arrived = way.arrived and not joining
        if cells.count[0] >= problem.max_cells:
            break
    return cells, Descent(freed, rounds, arrived, stable)


@kernel
def descend(problem, delta, cells, patience):
    """Descend to a local minimum of Π; return the `Descent`.

    ``patience`` is an energy, nm²: once more than this is released past the end of a branch, the descent stops.
    """
    before = _energy(problem, delta, cells)
    largest = problem.law.strength
    for k in range(cells.count[0]):
        largest = max(largest, abs(cells.pressure[k]))
    rounds, arrived, stable = 0, False, True
    while rounds < problem.max_iterations:
        rounds += 1
        if _sweep(problem, cells) <= problem.tolerance * largest:
            arrived = True
            break
        outcome = _newton(problem, delta, cells)
        if outcome != _DONE:
            stable = stable and outcome == _NO_ROOM
            for _ in range(tuning.SWEEPS_PAST_END):
                _sweep(problem, cells)
            if before - _energy(problem, delta, cells) > patience:
                break
    return Descent(before - _energy(problem, delta, cells), rounds, arrived, stable)


@kernel
def release_open(problem, cells):
    """Release the cells whose gap is beyond the law's range."""
    gone, number = np.empty(cells.count[0], np.int64), 0
    for k in range(cells.count[0]):
        if cells.gap[k] > tuning.RELEASE * problem.law.range * root_of(k, problem, cells):
            gone[number], number = k, number + 1
    if number > 0:
        release(gone[:number], cells)


@kernel
def _energy(problem, delta, cells):
    """Return Π, nm²."""
    total = elastic_energy(problem.separation, delta, cells)
    for k in range(cells.count[0]):
        total -= remaining_work(cells.gap[k], problem.law, root_of(k, problem, cells))
    return total


@kernel
def _join(problem, delta, cells, everywhere):
    """Let cells join that interpenetrate, or on which the law acts within its range.

    Returns the set and the energy, nm², that this releases.
    """
    rows, columns, gaps = _joining(problem, delta, cells, everywhere)
    number, gained = min(gaps.size, problem.max_cells - cells.count[0]), 0.0
    if number <= 0:
        return cells, gained
    rows, columns, gaps, separation = rows[:number], columns[:number], gaps[:number], np.empty(number)
    for c in range(number):
        i, j = rows[c], columns[c]
        root, separation[c] = _root_beside(i, j, problem, cells), problem.separation[i, j]
        problem.roots[i, j], cells.place[i, j] = root, cells.count[0] + c
        gained += remaining_work(max(gaps[c], 0.0), problem.law, root)
    cells = with_room(cells, number)
    constrain(rows, columns, gaps, separation, cells, problem.coefficients)
    return cells, gained


@kernel
def _joining(problem, delta, cells, everywhere):
    """Return rows and columns of the cells that should join the set, and their gaps."""
    separation, place, law = problem.separation, cells.place, problem.law
    reach = law.range if law.anywhere else 0.0
    highest = _uplift(separation, delta, cells) + reach
    nx, ny = separation.shape
    rows, columns, gaps, number = np.empty(nx * ny, np.int64), np.empty(nx * ny, np.int64), np.empty(nx * ny), 0
    for i in range(1, nx - 1):
        for j in range(1, ny - 1):
            if place[i, j] != ABSENT or not separation[i, j] < np.inf:
                continue
            beside = place[i - 1, j] != ABSENT or place[i + 1, j] != ABSENT
            beside = beside or place[i, j - 1] != ABSENT or place[i, j + 1] != ABSENT
            if not beside and not (everywhere and separation[i, j] - delta < highest):
                continue
            gap = separation[i, j] - delta + displacement_at(i, j, cells, problem.coefficients)
            if gap < (law.range if beside else reach):
                rows[number], columns[number], gaps[number] = i, j, gap
                number += 1
    return rows[:number], columns[:number], gaps[:number]


@kernel
def _uplift(separation, delta, cells):
    """Return the largest uplift of the surface, nm, which is within the set."""
    highest = 0.0
    for k in range(cells.count[0]):
        highest = max(highest, separation[cells.row[k], cells.column[k]] - delta - cells.gap[k])
    return highest


@kernel
def _root_beside(i, j, problem, cells):
    """Return the root of the factor on w that a cell takes from its neighbours, or that of a single cell."""
    if problem.law.anywhere:
        return 1.0
    root = 0.0
    for a, b in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
        if cells.place[a, b] != ABSENT:
            root = max(root, problem.roots[a, b])
    return root if root > 0.0 else np.sqrt(toughness(np.sqrt(1.0 / np.pi), problem.law))


@kernel
def _sweep(problem, cells):
    """Balance every cell in turn, each on its own; return the largest unbalanced traction, nm."""
    worst = 0.0
    for k in range(cells.count[0]):
        u, p, root = cells.gap[k], cells.pressure[k], root_of(k, problem, cells)
        if u != 0.0 or p < -root * problem.law.strength:
            stiffness = cells.inverse[k, k]
            change = balance(p, u, stiffness, problem.law, root) - u
            if change != 0.0:
                worst = max(worst, abs(change) * stiffness)
                open_cell(k, change, cells)
    return worst


@kernel
def _newton(problem, delta, cells):
    """Balance all open cells together, if the work space holds them and the state is not past the end of its branch.

    The full step is taken where it lowers the energy, else the step up to the first cell that changes its regime.
    """
    size = np.int64(0)
    for k in range(cells.count[0]):
        if cells.gap[k] > 0.0:
            if size == problem.open.size:
                return _NO_ROOM
            problem.open[size] = k
            size += 1
    for a in range(size):
        k = problem.open[a]
        t, slope = traction(cells.gap[k], problem.law, root_of(k, problem, cells))
        problem.step[a] = -(cells.pressure[k] + t)
        for b in range(a + 1):
            problem.matrix[a, b] = cells.inverse[k, problem.open[b]]
        problem.matrix[a, a] += slope
    outcome = _solve(problem, size)
    if outcome == _PAST_END and size < tuning.FEW_OPEN:
        return outcome
    part = _admissible(problem, cells, size)
    if part < 1.0:
        saved = save(cells)
        before = _energy(problem, delta, cells)
        _open_all(1.0, size, problem, cells)
        if _energy(problem, delta, cells) < before:
            return outcome
        restore(saved, cells)
    _open_all(part, size, problem, cells)
    return outcome


@kernel
def _solve(problem, size):
    """Solve for Newton's step; past the end of a branch with many open cells, find one along which the energy falls."""
    if size < tuning.FEW_OPEN:
        return _DONE if solve_in_place(problem.matrix, problem.step, size) else _PAST_END
    if solve_nearly(problem.matrix, problem.step, size, tuning.OPEN_PART):
        return _DONE
    longest = 0.0
    for a in range(size):
        longest = max(longest, abs(problem.step[a]))
    for a in range(size):
        problem.step[a] *= problem.law.range / longest
    return _PAST_END


@kernel
def _open_all(part, size, problem, cells):
    """Take a part of Newton's step; cells whose gap would become negative close."""
    for a in range(size):
        k = problem.open[a]
        change = part * problem.step[a]
        open_cell(k, -cells.gap[k] if cells.gap[k] + change < 1e-14 else change, cells)


@kernel
def _admissible(problem, cells, size):
    """Return the part of Newton's step up to the first cell that closes or crosses the law's range."""
    part = 1.0
    for a in range(size):
        k, change = problem.open[a], problem.step[a]
        u, root = cells.gap[k], root_of(k, problem, cells)
        if u + change < 0.0:
            part = min(part, -u / change)
        for corner in (problem.law.range * root, problem.law.length * root):
            if (u < corner) != (u + change < corner) and corner > 0.0:
                part = min(part, (corner - u) / change * (1.0 + 1e-9))
    return part
