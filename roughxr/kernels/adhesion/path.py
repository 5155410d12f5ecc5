"""Adhesive contact of a rigid profile with a half space, followed through loading and retraction.

On cells with undeformed separation S (nm), at a displacement δ, the state is a local minimum of the energy

    Π = ½ Σ p (δ − S + u) − Σ W(u),    p ≥ −t(0) where u = 0,   p = −t(u) where u > 0,   u ≥ 0,

u the gap and W the work still needed to open it (``cohesion``). Displacement moves in small steps, and from each state
the next is found downhill (``equilibrium``): so the path follows a branch to its end and then jumps, as a body held by
a stiff device does. A step frees energy at fixed displacement; as far as that is more than the half ΔF Δδ by which a
smooth branch curves away from its tangent, it is dissipated. Where the law is the Griffith limit's, the
front's neighbours join when their gap closes to the law's (mesh-sized) range, any other cell only when it touches.

What a path passes between two states must not matter. On retraction a step is halved where it ran past the end of a
branch, so that each jump begins where it is due, and where it may have passed a larger pull than it shows: the pull
grows no faster than with all gaps held, nor, on a branch whose cells open one after the other, than in the step before.

Unit cells and unit modulus, as in ``glued``.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .cohesive_laws import line_energy, remaining_work, toughness
from .constrained_cells import approach, elastic_energy, nothing_glued
from .contact_patches import contacts
from .equilibrium import Problem, descend, forget, root_of, settle

#: How a path ended.
CONVERGED, NOT_FINITE, CELL_LIMIT = range(3)

#: What is kept of a state.
DELTA, FORCE, AREA, ENERGY, DISSIPATED, CONTACTS, RESOLUTION, ITERATIONS, OK, ASKED = range(10)

#: A step past the end of a branch that frees more than this many cells' w is halved.
_JUMP = 0.02

#: How much of the largest pull may be missed between two states, and by how much of it the pull may at most grow in the
#: shortest step.
_MISSED, _SHORTEST = 0.003, 0.002

#: No step is halved that is shorter than this part of the longest.
_LEAST_STEP = 1e-4

#: A state is found again while the root of a cell's factor on w changes by more than this, at most so often.
_ALIKE, _TURNS, _FREE = 1e-3, 60, 20

#: Contacts with a smaller part of the whole tension than this do not count for the resolution.
_SHARE = 0.1

#: Cells that Newton's method balances together at most: their matrix takes 46 MB. More are balanced one by one.
_NEWTON_CELLS = 2400


class Path(NamedTuple):
    """All states of a path in order, and how it ended."""

    states: np.ndarray  # (state, DELTA … ASKED)
    turn: int  # first state of the retraction
    status: int
    pressures: (
        np.ndarray
    )  # (2 deltas or 0, nx, ny) p dx/E*, nm, at the states asked for in order; NaN where not reached


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
    room = min(max_cells, _NEWTON_CELLS)
    problem = Problem(
        separation=padded,
        coefficients=coefficients,
        law=law,
        w=w,
        tolerance=tolerance,
        max_iterations=max_iterations,
        max_cells=max_cells,
        roots=np.ones(padded.shape),
        open=np.zeros(room, np.int64),
        matrix=np.zeros((room, room)),
        step=np.zeros(room),
    )
    states, turn, status = _follow(problem, deltas, step, pressures)
    return Path(states, turn, status, pressures[:, 1:-1, 1:-1])


@kernel
def _follow(problem, deltas, step, pressures):
    """Return (states, the first of the retraction, status)."""
    states, kept = np.zeros((1024, 10)), 0
    glued, count, dissipated = nothing_glued(problem.separation.shape), 0, 0.0
    first = problem.separation.min() - problem.law.range
    delta = min(deltas[0], first)
    for target in deltas:
        if delta == target:
            states, kept = _keep(states, kept, delta, dissipated, problem, glued, count, 0, True, True, pressures)
        while delta < target and count < problem.max_cells:
            change = min(max(step, first - delta) if count == 0 else step, target - delta)
            delta = target if target - delta - change < 1e-9 * step else delta + change
            approach(change, glued, count)
            held = _force(glued, count)
            glued, count, freed, rounds, fine = _rest(problem, delta, glued, count)
            dissipated += freed - 0.5 * (held - _force(glued, count)) * change
            states, kept = _keep(
                states, kept, delta, dissipated, problem, glued, count, rounds, fine, delta == target, pressures
            )
    turn = kept
    if count >= problem.max_cells:
        return states[:kept], turn, CELL_LIMIT
    states, kept = _keep(states, kept, delta, dissipated, problem, glued, count, 0, True, True, pressures)
    states, kept, status = _retract(problem, deltas, step, glued, count, dissipated, states, kept, pressures)
    return states[:kept], turn, status


@kernel
def _retract(problem, deltas, step, glued, count, dissipated, states, kept, pressures):
    """Go back through the displacements asked for, then on until nothing holds."""
    delta, k, change, largest, slope = deltas[-1], deltas.size - 2, step, 0.0, np.inf
    while k >= 0 or count > 0:
        target = deltas[k] if k >= 0 else -np.inf
        if count == 0:
            delta, k = target, k - 1
            states, kept = _keep(states, kept, delta, dissipated, problem, glued, count, 0, True, True, pressures)
            continue
        gap, pressure = glued.gap[:count].copy(), glued.pressure[:count].copy()
        before = _force(glued, count)
        if not np.isfinite(before):
            return states, kept, NOT_FINITE
        largest = max(largest, -before)
        back = min(change, delta - target)
        approach(-back, glued, count)
        held = _force(glued, count)
        may_halve = back > _LEAST_STEP * step and before - held > _SHORTEST * max(largest, abs(before))
        patience = _JUMP * problem.w if may_halve else np.inf
        freed, rounds, fine, stable = descend(problem, delta - back, glued, count, patience)
        jumped = freed > patience and not stable
        bound = min((before - held) / back, slope) * back - before  # the largest pull that the step may pass
        missed = bound > (1.0 + _MISSED) * max(largest, -_force(glued, count))
        if jumped or (missed and may_halve):
            glued.gap[:count], glued.pressure[:count] = gap, pressure
            change = 0.5 * back
            continue
        if back == change or not stable:  # a step cut short by its target says little
            slope = (before - _force(glued, count)) / back if stable else np.inf
        delta = target if delta - back - target < 1e-9 * step else delta - back
        glued, count, more, others, good = _rest(problem, delta, glued, count)
        dissipated += freed + more + 0.5 * (held - _force(glued, count)) * back
        asked = delta == target
        states, kept = _keep(
            states, kept, delta, dissipated, problem, glued, count, rounds + others, fine and good, asked, pressures
        )
        k, change = k - asked, min(step, 2.0 * back) if back == change else change
        if count >= problem.max_cells:
            return states, kept, CELL_LIMIT
    return states, kept, CONVERGED


@kernel
def _rest(problem, delta, glued, count):
    """Come to rest, and again while that changes how tough the fronts are; return as ``settle`` does.

    Where contacts are about to merge, tough as one and tough as two may each lead to the other: after ``_FREE`` turns
    toughness changes by less and less of what it should, and ends in between.
    """
    before = 0.0 if problem.law.anywhere else _whole_energy(problem, delta, glued, count)
    glued, count, freed, rounds, fine = settle(problem, delta, glued, count)
    count = forget(problem, glued, count)
    for turn in range(_TURNS):
        part = 1.0 / max(turn - _FREE, 1)
        if count >= problem.max_cells or _toughen(problem, glued, count, part) < _ALIKE:
            return glued, count, freed, rounds, fine
        glued, count, _, done, fine = settle(problem, delta, glued, count)
        count, rounds = forget(problem, glued, count), rounds + done
        freed = before - _whole_energy(problem, delta, glued, count)  # fronts that grew tougher on the way freed more
    return glued, count, freed, rounds, fine


@kernel
def _force(glued, count):
    """Return the force, nm, positive where it presses."""
    total = 0.0
    for k in range(count):
        total += glued.pressure[k]
    return total


@kernel
def _toughen(problem, glued, count, part):
    """Bring each cell's factor on w a part of the way to what the curvature of its contact's outline makes it.

    Return by how much its root changed at most. Only fronts of the mesh's own making need it.
    """
    most = 0.0
    if not problem.law.anywhere and count > 0:
        found = contacts(_closed(problem, glued, count), glued, count)
        for k in range(count):
            change = part * (np.sqrt(toughness(found.radius[found.of[k]])) - root_of(k, problem, glued))
            most = max(most, abs(change))
            problem.roots[glued.row[k], glued.column[k]] += change
    return most


@kernel
def _closed(problem, glued, count):
    """Return the part of each cell that is closed: of the work of opening it, what is still needed."""
    closed = np.ones(count)
    for k in range(count):
        if glued.gap[k] > 0.0:
            root = root_of(k, problem, glued)
            left = remaining_work(glued.gap[k], problem.law, root) if problem.w > 0.0 else 0.0
            closed[k] = left / (problem.w * root**2) if left > 0.0 else 0.0
    return closed


@kernel
def _keep(states, kept, delta, dissipated, problem, glued, count, rounds, fine, asked, pressures):
    """Write one state down."""
    if kept == states.shape[0]:
        longer = np.zeros((2 * kept, states.shape[1]))
        longer[:kept] = states
        states = longer
    closed = _closed(problem, glued, count)
    found = contacts(closed, glued, count)
    state = states[kept]
    state[DELTA], state[DISSIPATED], state[ITERATIONS] = delta, dissipated, rounds
    state[OK], state[ASKED] = fine, asked
    state[FORCE] = _force(glued, count)
    state[AREA] = _area(problem, glued, closed)
    state[ENERGY] = elastic_energy(problem.separation, delta, glued, count) + _adhesion(problem, closed, found)
    state[CONTACTS], state[RESOLUTION] = found.cores, _resolution(found, glued, count)
    if asked and pressures.shape[0] > 0:
        _keep_pressure(pressures[int(states[:kept, ASKED].sum())], glued, count)
    return states, kept + 1


@kernel
def _area(problem, glued, closed):
    """Return the cells in contact; in the Griffith limit the front runs through cells."""
    area = 0.0
    for k in range(closed.size):
        if glued.gap[k] <= 0.0 or not problem.law.anywhere:
            area += closed[k]
    return area


@kernel
def _whole_energy(problem, delta, glued, count):
    """Return the energy, nm²: elastic and of adhesion."""
    closed = _closed(problem, glued, count)
    adhesion = _adhesion(problem, closed, contacts(closed, glued, count))
    return elastic_energy(problem.separation, delta, glued, count) + adhesion


@kernel
def _adhesion(problem, closed, found):
    """Return the energy of adhesion, nm²: of all cells, less what the lines around them take."""
    energy = -problem.w * np.sum(closed)
    if not problem.law.anywhere:
        for c in range(found.cells.size):
            energy += problem.w * line_energy(found.cells[c], found.radius[c])
    return energy


@kernel
def _resolution(found, glued, count):
    """Return the radius in cells of the smallest contact that bears enough of the tension to matter."""
    pulls = np.zeros(found.cells.size)
    for k in range(count):
        pulls[found.of[k]] += max(-glued.pressure[k], 0.0)
    smallest = np.inf
    for c in range(pulls.size):
        if pulls[c] >= _SHARE * pulls.sum():
            smallest = min(smallest, np.sqrt(found.cells[c] / np.pi))
    return smallest if pulls.size > 0 else np.nan


@kernel
def _keep_pressure(pressure, glued, count):
    pressure[:] = 0.0
    for k in range(count):
        pressure[glued.row[k], glued.column[k]] = glued.pressure[k]
