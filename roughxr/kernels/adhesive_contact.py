"""Adhesive contact of a rigid profile with a half space, followed through loading and retraction.

On cells with undeformed separation S (nm), at a displacement δ, the state is a local minimum of the energy

    Π = ½ Σ p (δ − S + u) − Σ W(u),    p ≥ −t(0) where u = 0,   p = −t(u) where u > 0,   u ≥ 0,

u the gap and W the work still needed to open it (``kernels.cohesion``). Displacement moves in small steps, and
from each state the next is found downhill: so the path follows a branch to its end and then jumps, as a body held by
a stiff device does. A step frees energy at fixed displacement; as far as that is more than the half ΔF Δδ by which a
smooth branch curves away from its tangent, it is dissipated. Where the law is the Griffith limit's, the
front's neighbours join when their gap closes to the law's (mesh-sized) range, any other cell only when it touches.

Inside a step the cells of the set C (``kernels.glued``) are balanced one after the other, each on its own, which
only ever lowers Π, and together by Newton's method on the cells that are open, as long as their stiffness is positive
definite: where it is not, the state is past the end of its branch.

Unit cells and unit modulus, as in ``kernels.glued``.
"""

from typing import NamedTuple

import numpy as np

from .cohesion import balance, effective_part, remaining_work, toughness, traction
from .glued import (
    ABSENT,
    approach,
    displacement_at,
    elastic_energy,
    glue,
    nothing_glued,
    open_cell,
    unglue,
    with_room,
)
from .jit import kernel, reducing_kernel

#: How a path ended.
CONVERGED, ITERATION_LIMIT, CELL_LIMIT = 0, 1, 2

#: Reasons, by status.
REASONS = {
    CONVERGED: "converged",
    ITERATION_LIMIT: "iteration limit reached before the tolerance",
    CELL_LIMIT: "more cells within reach than max_cells",
}

#: What is kept of a state.
DELTA, FORCE, AREA, ENERGY, DISSIPATED, CONTACTS, RESOLUTION, ITERATIONS, OK, ASKED = range(10)

#: A retraction step that frees more than this many cells' w is halved, down to 1/32 of the step asked for.
_JUMP, _HALVINGS = 1.0, 32.0

#: A cell leaves the set once its gap is this many times the law's range.
_FORGET = 1.2

#: Contacts with a smaller part of the whole tension than this do not count for the resolution.
_SHARE = 0.1

_NEWTON_CELLS = 1200
_ROUNDS = 60


class Path(NamedTuple):
    """All states of a path in order, and how it ended."""

    states: np.ndarray  # (state, DELTA … ASKED)
    turn: int  # first state of the retraction
    status: int
    pressures: (
        np.ndarray
    )  # (2 deltas or 0, nx, ny) p dx/E*, nm, at the states asked for in order; NaN where not reached


class _Problem(NamedTuple):
    """What does not change along a path, and where its pressures are written."""

    separation: np.ndarray
    coefficients: np.ndarray
    law: NamedTuple
    w: float
    tolerance: float
    max_iterations: int
    inset: bool  # whether w is lowered for the mesh's inset
    pressures: np.ndarray  # as of ``Path``, on the padded window


class _Work(NamedTuple):
    """Room for one step."""

    open: np.ndarray
    matrix: np.ndarray
    step: np.ndarray


def follow(separation, deltas, step, coefficients, law, w, *, tolerance, max_iterations, max_cells, fields=False):
    """Follow the contact up to the last of ascending ``deltas`` (nm), back through them and on until it is lost.

    Parameters
    ----------
    separation : (nx, ny) array
        S, nm; NaN or inf where there is nothing to touch.
    deltas : array
        Displacements at which states are asked for, nm, ascending.
    step : float
        Longest step between two states, nm.
    coefficients : (≥ nx, ≥ ny) array
        Love's.
    law : cohesion.Law
    w : float
        Work of adhesion, nm² (w dx/E*).
    tolerance, max_iterations, max_cells : float, int, int
        Residual traction over the largest; rounds per state; cells of the set.
    fields : bool
        Whether to keep pressures.

    Returns
    -------
    Path
    """
    padded = np.pad(np.where(np.isfinite(separation), separation, np.inf), 1, constant_values=np.inf)
    pressures = np.full((2 * len(deltas) if fields else 0, *padded.shape), np.nan)
    problem = _Problem(padded, coefficients, law, w, tolerance, max_iterations, not law.anywhere, pressures)
    room = min(max_cells, _NEWTON_CELLS)
    work = _Work(np.zeros(room, np.int64), np.zeros((room, room)), np.zeros(room))
    states, count, turn, status = _follow(problem, deltas, step, max_cells, work)
    return Path(states[:count], turn, status, pressures[:, 1:-1, 1:-1])


@kernel
def _follow(problem, deltas, step, max_cells, work):
    """Return (states, their number, the first of the retraction, status)."""
    states = np.zeros((1024, 10))
    glued, count, kept = nothing_glued(problem.separation.shape), 0, 0
    roots = np.ones(problem.separation.shape)
    delta = min(deltas[0], problem.separation.min() - problem.law.range)
    dissipated, status = 0.0, CONVERGED
    for target in deltas:
        if target <= delta and kept == 0 and count == 0:
            states, kept = _keep(states, kept, target, 0.0, problem, glued, count, roots, 0, True, True)
            continue
        while delta < target and status == CONVERGED:
            change = min(step, target - delta)
            if count == 0:
                change = min(target - delta, max(change, problem.separation.min() - problem.law.range - delta))
            delta = target if target - delta - change < 1e-9 * step else delta + change
            approach(change, glued, count)
            frozen = _sum(glued.pressure, count)
            glued, count, freed, rounds, fine = _settle(problem, delta, glued, count, roots, work, max_cells)
            dissipated += freed - 0.5 * (frozen - _sum(glued.pressure, count)) * change
            count = _forget(problem, glued, count, roots)
            _toughen(problem, glued, count, roots)
            states, kept = _keep(
                states, kept, delta, dissipated, problem, glued, count, roots, rounds, fine, delta == target
            )
            status = CELL_LIMIT if count >= max_cells else CONVERGED
    turn = kept
    states, kept = _keep(states, kept, delta, dissipated, problem, glued, count, roots, 0, True, True)
    if status == CONVERGED:
        states, kept, status = _retract(
            problem, deltas, step, max_cells, work, glued, count, roots, dissipated, states, kept
        )
    return states, kept, turn, status


@kernel
def _retract(problem, deltas, step, max_cells, work, glued, count, roots, dissipated, states, kept):
    """Go back through the displacements asked for, then on until nothing holds; halve steps that jump."""
    delta, k, change = deltas[-1], deltas.size - 2, step
    size = problem.separation.size
    gap, pressure = np.empty(size), np.empty(size)
    while k >= 0 or count > 0:
        target = deltas[k] if k >= 0 else -np.inf
        if count == 0:
            states, kept = _keep(states, kept, target, dissipated, problem, glued, count, roots, 0, True, True)
            delta, k = target, k - 1
            continue
        gap[:count], pressure[:count] = glued.gap[:count], glued.pressure[:count]
        change = min(change, delta - target)
        approach(-change, glued, count)
        frozen = _sum(glued.pressure, count)
        freed, rounds, fine = _balance_all(problem, delta - change, glued, count, roots, work)
        if freed > _JUMP * problem.w and change > step / _HALVINGS:
            glued.gap[:count], glued.pressure[:count] = gap[:count], pressure[:count]
            change *= 0.5
            continue
        delta = target if delta - change - target < 1e-9 * step else delta - change
        glued, count, more, others, good = _settle(problem, delta, glued, count, roots, work, max_cells)
        dissipated += freed + more + 0.5 * (frozen - _sum(glued.pressure, count)) * change
        count = _forget(problem, glued, count, roots)
        _toughen(problem, glued, count, roots)
        asked = delta == target
        states, kept = _keep(
            states, kept, delta, dissipated, problem, glued, count, roots, rounds + others, fine and good, asked
        )
        k, change = k - asked, min(step, 2.0 * change)
        if count >= max_cells:
            return states, kept, CELL_LIMIT
    return states, kept, CONVERGED


@kernel
def _sum(values, count):
    total = 0.0
    for k in range(count):
        total += values[k]
    return total


@kernel
def _keep(states, kept, delta, dissipated, problem, glued, count, roots, rounds, fine, asked):
    """Write one state down."""
    if kept == states.shape[0]:
        longer = np.zeros((2 * kept, states.shape[1]))
        longer[:kept] = states
        states = longer
    state = states[kept]
    state[DELTA], state[DISSIPATED], state[ITERATIONS] = delta, dissipated, rounds
    state[OK], state[ASKED] = fine, asked
    for k in range(count):
        state[FORCE] += glued.pressure[k]
        root = roots[glued.row[k], glued.column[k]]
        state[AREA] += effective_part(root) * _closed(glued.gap[k], problem, root)
    state[ENERGY] = elastic_energy(problem.separation, delta, glued, count)
    for k in range(count):  # w was lowered by what a cell's leaving takes; the whole contact lacks twice that
        root = roots[glued.row[k], glued.column[k]]
        state[ENERGY] -= (2.0 - 1.0 / root**2) * remaining_work(glued.gap[k], problem.law, root)
    _, state[CONTACTS], state[RESOLUTION] = _contacts(glued, count)
    if asked and problem.pressures.shape[0] > 0:
        _keep_pressure(problem.pressures[int(states[:kept, ASKED].sum())], glued, count)
    return states, kept + 1


@kernel
def _keep_pressure(pressure, glued, count):
    pressure[:] = 0.0
    for k in range(count):
        pressure[glued.row[k], glued.column[k]] = glued.pressure[k]


@kernel
def _closed(gap, problem, root):
    """Return the part of a cell that is in contact; in the Griffith limit the front runs through cells."""
    if gap <= 0.0:
        return 1.0
    reach = root * problem.law.range
    return 1.0 - gap / reach if problem.inset and gap < reach else 0.0


@kernel
def _energy(problem, delta, glued, count, roots):
    """Return Π, nm²."""
    total = elastic_energy(problem.separation, delta, glued, count)
    for k in range(count):
        total -= remaining_work(glued.gap[k], problem.law, roots[glued.row[k], glued.column[k]])
    return total


@kernel
def _settle(problem, delta, glued, count, roots, work, max_cells):
    """Balance the cells and take others in until none wants to join; return what that freed."""
    freed, rounds, fine = 0.0, 0, True
    for attempt in range(_ROUNDS):
        fallen, done, fine = _balance_all(problem, delta, glued, count, roots, work)
        freed, rounds = freed + fallen, rounds + done
        before = count
        everywhere = problem.law.anywhere or attempt == 0
        glued, count, gained = _join(problem, delta, glued, count, roots, everywhere, max_cells)
        freed += gained
        if count == before or count >= max_cells:
            break
    return glued, count, freed, rounds, fine


@kernel
def _join(problem, delta, glued, count, roots, everywhere, max_cells):
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
        if count < max_cells:
            i, j = cells[k]
            glued = with_room(glued, count)
            glue(i, j, gaps[k], separation[i, j], glued, count, problem.coefficients)
            gained += remaining_work(max(gaps[k], 0.0), law, roots[i, j])
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
def _forget(problem, glued, count, roots):
    """Let go of the cells that are open beyond the law's range."""
    k = 0
    while k < count:
        if glued.gap[k] > _FORGET * problem.law.range * roots[glued.row[k], glued.column[k]]:
            unglue(k, glued, count)
            count -= 1
        else:
            k += 1
    return count


@kernel
def _contacts(glued, count):
    """Return each cell's contact, their number, and the radius in cells of the smallest that matters."""
    contact = np.full(count, -1)
    waiting = np.empty(count, np.int64)
    sizes, pulls, found = np.zeros(count), np.zeros(count), 0
    for seed in range(count):
        if contact[seed] >= 0:
            continue
        contact[seed], waiting[0], left = found, seed, 1
        while left > 0:
            left -= 1
            k = waiting[left]
            sizes[found] += 1.0
            pulls[found] += max(-glued.pressure[k], 0.0)
            for side in range(4):
                i = glued.row[k] + (side == 0) - (side == 1)
                j = glued.column[k] + (side == 2) - (side == 3)
                m = glued.place[i, j]
                if m != ABSENT and contact[m] < 0:
                    contact[m], waiting[left], left = found, m, left + 1
        found += 1
    smallest, all_pulls = np.inf, pulls[:found].sum()
    for c in range(found):
        if pulls[c] >= _SHARE * all_pulls:
            smallest = min(smallest, np.sqrt(sizes[c] / np.pi))
    for k in range(count):
        waiting[k] = int(sizes[contact[k]])
    return waiting, found, smallest if found > 0 else np.nan


@kernel
def _toughen(problem, glued, count, roots):
    """Set each cell's factor on w for the inset of its contact's outline."""
    if problem.inset:
        sizes, _, _ = _contacts(glued, count)
        for k in range(count):
            roots[glued.row[k], glued.column[k]] = np.sqrt(toughness(float(sizes[k])))


@kernel
def _balance_all(problem, delta, glued, count, roots, work):
    """Go downhill to a local minimum of Π; return what that freed, rounds, and whether it arrived."""
    before = _energy(problem, delta, glued, count, roots)
    goal = problem.tolerance * max(np.abs(glued.pressure[:count]).max() if count > 0 else 0.0, problem.law.strength)
    rounds, fine = 0, False
    while rounds < problem.max_iterations:
        rounds += 1
        if _sweep(problem, glued, count, roots) <= goal:
            fine = True
            break
        if not _newton(problem, glued, count, roots, work):
            for _ in range(10):
                _sweep(problem, glued, count, roots)
    return before - _energy(problem, delta, glued, count, roots), rounds, fine


@kernel
def _sweep(problem, glued, count, roots):
    """Balance every cell on its own in turn; return the largest traction that was out of balance, nm."""
    worst = 0.0
    for k in range(count):
        u, p, root = glued.gap[k], glued.pressure[k], roots[glued.row[k], glued.column[k]]
        if u != 0.0 or p < -root * problem.law.strength:
            stiffness = glued.inverse[k, k]
            change = balance(p, u, stiffness, problem.law, root) - u
            if change != 0.0:
                worst = max(worst, abs(change) * stiffness)
                open_cell(k, change, glued, count)
    return worst


@kernel
def _newton(problem, glued, count, roots, work):
    """Balance all open cells together, up to the first that changes its regime; False past a branch's end."""
    size = 0
    for k in range(count):
        if glued.gap[k] > 0.0:
            if size == work.open.size:
                return False
            work.open[size] = k
            size += 1
    for a in range(size):
        k = work.open[a]
        t, slope = traction(glued.gap[k], problem.law, roots[glued.row[k], glued.column[k]])
        work.step[a] = -(glued.pressure[k] + t)
        for b in range(a + 1):
            work.matrix[a, b] = glued.inverse[k, work.open[b]]
        work.matrix[a, a] += slope
    if not _solve(work.matrix, work.step, size):
        return False
    part = _admissible(problem, glued, roots, work, size)
    for a in range(size):
        k = work.open[a]
        change = part * work.step[a]
        open_cell(k, -glued.gap[k] if glued.gap[k] + change < 1e-14 else change, glued, count)
    return True


@kernel
def _admissible(problem, glued, roots, work, size):
    """Return the part of Newton's step up to the first cell that closes or crosses the law's range."""
    part = 1.0
    for a in range(size):
        k, change = work.open[a], work.step[a]
        u, end = glued.gap[k], problem.law.range * roots[glued.row[k], glued.column[k]]
        if u + change < 0.0:
            part = min(part, -u / change)
        for corner in (end, problem.law.length * roots[glued.row[k], glued.column[k]]):
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
