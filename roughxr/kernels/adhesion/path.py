"""Adhesive contact of a rigid profile with a half space, followed through loading and retraction.

Given the undeformed separation S (nm) of cells and displacements δ (nm), sought are gaps u (nm) and pressures p. At
each δ the state is a local minimum of the energy

    Π = ½ Σ p (δ − S + u) − Σ W(u),    p ≥ −t(0) where u = 0,   p = −t(u) where u > 0,   u ≥ 0,

with W the work left to open a cell and t its traction (``cohesive_laws``). The displacement moves in small steps, and
each state is reached from the one before by descent (``equilibrium``): so the path follows a branch of equilibria to
its end and then jumps, as a body held by a stiff device does. A step releases energy at fixed displacement; what
exceeds the ½ ΔF Δδ by which a smooth branch deviates from its tangent is dissipated. In the Griffith limit the
neighbours of constrained cells join when their gap is within the law's (mesh-sized) range, any other cell only when it
touches.

On retraction a step is halved where it went past the end of a branch, so that each jump begins where it should, and
where a larger pull may lie between two states. The bound on that pull: in a step back the pull grows no faster than
with all gaps held, nor, on a branch whose cells open one after the other, faster than in the step before.

A body that yields gives way on loading, under the attraction of each state (``capped_cells``); retraction is elastic on
the surface that is left.

Source: own; the criterion of Griffith (1921) on a mesh as in Pohrt & Popov (2015). Unit cells and unit modulus, as in
``constrained_cells``: forces and pressures in nm, energies in nm².
"""

from typing import NamedTuple

import numpy as np

from ..halfspace.products import coefficients_for
from ..jit import kernel
from . import tuning
from .capped_cells import OVER, bears, begin_to_yield, give_way, left_open
from .cohesive_laws import line_energy, remaining_work, toughness
from .constrained_cells import approach, elastic_energy, force, no_cells, restore, save
from .contact_patches import contact_patches
from .equilibrium import Descent, Problem, descend, release_open, root_of, settle

#: Outcomes of a path.
CONVERGED, NOT_FINITE, CELL_LIMIT = range(3)

#: Columns of a state.
DELTA, FORCE, AREA, ENERGY, DISSIPATED, CONTACTS, RESOLUTION, ITERATIONS, OK, ASKED = range(10)

#: Columns of the yield of a state: force and area of the cells at the hardness or above, over those of all cells that
#: push or touch; the area that has given way, in cells, and its volume.
HARD_FORCE, HARD_AREA, DENT_AREA, DENT = range(4)

#: Number of columns of a state, without those of its yield.
_STATE = ASKED + 1

#: Largest number of times that a state gives way and settles again.
_MOST_DENTS = 30


class Path(NamedTuple):
    """All states of a path in order, and how it ended."""

    states: np.ndarray  # (state, DELTA … ASKED)
    turn: int  # first state of the retraction
    status: int
    pressures: np.ndarray  # (2 deltas or 0, nx, ny) p dx/E*, nm, at the prescribed displacements; NaN where not reached
    hard: np.ndarray  # (state, HARD_FORCE … DENT)
    left: np.ndarray  # (deltas or 1, nx, ny) nm ≤ 0, residual height after loading; NaN where not reached


def follow(
    separation,
    deltas,
    step,
    law,
    w,
    *,
    tolerance,
    max_iterations,
    max_cells,
    fields=False,
    cap=np.inf,
    limit=np.inf,
    left=None,
):
    """Follow the contact up to the last of ascending ``deltas`` (nm), back through them and on until it is lost.

    Parameters
    ----------
    separation : (nx, ny) array
        S, nm; NaN or inf where there is nothing to touch.
    deltas : array
        Prescribed displacements, nm, ascending.
    step : float
        Longest step between two states, nm.
    law : CohesiveLaw
    w : float
        Work of adhesion, nm² (w dx/E*).
    tolerance, max_iterations, max_cells : float, int, int
        Residual traction over the largest; iterations per state; largest number of cells in the set.
    fields : bool
        Whether to return pressures.
    cap : float
        Largest pressure that the body bears, nm (H dx/E*); inf where it never yields.
    limit : float
        Pressure, nm, above which the shares of force and area are reported.
    left : (nx, ny) array, optional
        Residual height of earlier cycles, nm ≤ 0.

    Returns
    -------
    Path
    """
    padded = np.pad(np.where(np.isfinite(separation), separation, np.inf), 1, constant_values=np.inf)
    dent = np.zeros(padded.shape) if left is None else np.pad(-left, 1)
    pressures = np.full((2 * len(deltas) if fields else 0, *padded.shape), np.nan)
    dents = np.full((len(deltas) if fields else 1, *padded.shape), np.nan)
    room = min(max_cells, tuning.NEWTON_CELLS)
    problem = Problem(
        separation=padded + dent,
        coefficients=coefficients_for(padded.shape),
        law=law,
        w=w,
        tolerance=tolerance,
        max_iterations=max_iterations,
        max_cells=max_cells,
        roots=np.ones(padded.shape),
        open=np.zeros(room, np.int64),
        matrix=np.zeros((room, room)),
        step=np.zeros(room),
        cap=float(cap),
        limit=float(limit) * (1.0 - 2.0 * OVER if cap < np.inf else 1.0),
        dent=dent,
        stays=dent.copy(),
    )
    deltas = np.ascontiguousarray(deltas, dtype=float)
    there, back = pressures[: len(pressures) // 2], pressures[len(pressures) // 2 :]
    loading, retraction, status = _there_and_back(problem, deltas, float(step), there, back, dents)
    states, inside = np.vstack([loading, retraction]), (slice(None), slice(1, -1), slice(1, -1))
    return Path(states[:, :_STATE], len(loading), status, pressures[inside], states[:, _STATE:], -dents[inside])


class _State(NamedTuple):
    """One state, in the order of the columns."""

    delta: float
    force: float
    area: float
    energy: float
    dissipated: float
    contacts: int
    resolution: float
    iterations: int
    ok: bool
    asked: bool
    hard_force: float
    hard_area: float
    dent_area: float
    dent: float


class _Trial(NamedTuple):
    """A step back that was tried, and its outcome."""

    accepted: bool
    way: Descent
    before: float  # force before the step, nm
    held: float  # force after it with all gaps held
    after: float  # force after it


@kernel
def _table(states):
    """Return states as rows."""
    table = np.empty((len(states), _STATE + DENT + 1))
    for k in range(len(states)):
        s, row = states[k], table[k]
        row[DELTA], row[FORCE], row[AREA], row[ENERGY], row[DISSIPATED] = (
            s.delta,
            s.force,
            s.area,
            s.energy,
            s.dissipated,
        )
        row[CONTACTS], row[RESOLUTION], row[ITERATIONS] = s.contacts, s.resolution, s.iterations
        row[OK], row[ASKED] = s.ok, s.asked
        told = row[_STATE:]
        told[HARD_FORCE], told[HARD_AREA], told[DENT_AREA], told[DENT] = s.hard_force, s.hard_area, s.dent_area, s.dent
    return table


@kernel
def _no_states():
    """Return an empty list of states, typed for numba."""
    zero, no = np.int64(0), np.bool_(False)
    states = [_State(0.0, 0.0, 0.0, 0.0, 0.0, zero, 0.0, zero, no, no, 0.0, 0.0, 0.0, 0.0)]
    states.pop()
    return states


@kernel
def _unmoved():
    """Return the descent of a state in which nothing has moved."""
    return Descent(0.0, np.int64(0), np.bool_(True), np.bool_(True))


@kernel
def _there_and_back(problem, deltas, step, there, back, dents):
    """Return the states of loading and of retraction, and how it ended: one entry, compiled sooner than two."""
    loading, cells = _load(problem, deltas, step, there, dents)
    retraction, status = _retract(problem, deltas, step, cells, loading[-1, DISSIPATED], back)
    return loading, retraction, status


@kernel
def _load(problem, deltas, step, pressures, dents):
    """Go through ascending displacements, from the first at which anything can pull; return (states, cells)."""
    cells, states = no_cells(problem.separation.shape), _no_states()
    first = problem.separation.min() - problem.law.range
    delta = min(deltas[0], first)
    for n in range(deltas.size):
        target = deltas[n]
        if delta == target:
            _keep(states, delta, 0.0, problem, cells, _unmoved(), np.bool_(True), pressures)
        while delta < target and cells.count[0] < problem.max_cells:
            change = min(max(step, first - delta) if cells.count[0] == 0 else step, target - delta)
            delta = target if target - delta - change < 1e-9 * step else delta + change
            approach(change, cells)
            held = force(cells)
            cells, way = _bear(problem, delta, cells)
            dissipated = way.freed - 0.5 * (held - force(cells)) * change
            _keep(states, delta, dissipated, problem, cells, way, delta == target, pressures)
        if delta == target and n - deltas.size + dents.shape[0] >= 0:
            _copy(problem.dent, dents[n - deltas.size + dents.shape[0]])
    return _table(states), cells


@kernel
def _bear(problem, delta, cells):
    """Settle, and again while the surface gives way where it is pressed too hard."""
    begin_to_yield(problem)
    freed, rounds = 0.0, 0
    for _ in range(_MOST_DENTS):
        cells, way = _rest(problem, delta, cells)
        freed, rounds = freed + way.freed, rounds + way.rounds
        if cells.count[0] >= problem.max_cells or (bears(OVER, problem, cells) and not left_open(problem, cells)):
            break
        freed += _whole_energy(problem, delta, cells)
        give_way(problem, delta, cells)
        freed -= _whole_energy(problem, delta, cells)
    return cells, Descent(freed, rounds, way.arrived, way.stable)


@kernel
def _copy(values, room):
    """Copy an array into another: NumPy's own assignment takes longer to compile."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            room[i, j] = values[i, j]


@kernel
def _retract(problem, deltas, step, cells, dissipated, pressures):
    """Go back through the prescribed displacements, then on until contact is lost; return states and outcome."""
    delta, k, length, largest, slope, states = deltas[-1], deltas.size - 2, step, 0.0, np.inf, _no_states()
    if cells.count[0] < problem.max_cells:
        _keep(states, delta, dissipated, problem, cells, _unmoved(), np.bool_(True), pressures)
    while (k >= 0 or cells.count[0] > 0) and cells.count[0] < problem.max_cells:
        target = deltas[k] if k >= 0 else -np.inf
        if cells.count[0] == 0:
            delta, k = target, k - 1
            _keep(states, delta, 0.0, problem, cells, _unmoved(), np.bool_(True), pressures)
            continue
        if not np.isfinite(force(cells)):
            return _table(states), NOT_FINITE
        back = min(length, delta - target)
        largest = max(largest, -force(cells))
        trial = _step_back(problem, delta, back, back > tuning.LEAST_STEP * step, largest, slope, cells)
        if not trial.accepted:
            length = 0.5 * back
            continue
        if back == length or not trial.way.stable:  # a step cut short by its target says little
            slope = (trial.before - trial.after) / back if trial.way.stable else np.inf
        delta = target if delta - back - target < 1e-9 * step else delta - back
        cells, rest = _rest(problem, delta, cells)
        way = Descent(
            trial.way.freed + rest.freed,
            trial.way.rounds + rest.rounds,
            trial.way.arrived and rest.arrived,
            trial.way.stable,
        )
        asked = delta == target
        dissipated = way.freed + 0.5 * (trial.held - force(cells)) * back
        _keep(states, delta, dissipated, problem, cells, way, asked, pressures)
        k, length = k - asked, min(step, 2.0 * back) if back == length else length
    return _table(states), CONVERGED if cells.count[0] < problem.max_cells else CELL_LIMIT


@kernel
def _step_back(problem, delta, back, long_enough, largest, slope, cells):
    """Try a step back and descend; where it went too far, undo it and report that.

    It went too far if it jumped from beyond the end of a branch, or if a pull larger than the ``largest`` so far may
    lie within it; ``slope`` is that of the force in the step before.
    """
    saved, before = save(cells), force(cells)
    approach(-back, cells)
    held = force(cells)
    may_halve = long_enough and before - held > tuning.LEAST_GROWTH * max(largest, abs(before))
    patience = tuning.JUMP * problem.w if may_halve else np.inf
    way = descend(problem, delta - back, cells, patience)
    jumped = way.freed > patience and not way.stable
    after = force(cells)
    bound = min((before - held) / back, slope) * back - before  # the largest pull that the step may pass over
    missed = bound > (1.0 + tuning.MISSED) * max(largest, -after)
    accepted = not (jumped or (missed and may_halve))
    if not accepted:
        restore(saved, cells)
    return _Trial(accepted, way, before, held, after)


@kernel
def _rest(problem, delta, cells):
    """Settle, and again while this changes the toughness of the outlines; return the same as ``settle``.

    Where two patches are about to merge, the toughness of one outline may lead to two patches and that of two to one:
    after ``UNDAMPED_UPDATES`` only a decreasing part of the change is applied, so that it ends in between.
    """
    before = 0.0 if problem.law.anywhere else _whole_energy(problem, delta, cells)
    cells, way = settle(problem, delta, cells)
    release_open(problem, cells)
    freed, rounds, updates = way.freed, way.rounds, 0
    while updates < tuning.MOST_UPDATES and cells.count[0] < problem.max_cells:
        part = 1.0 / max(updates - tuning.UNDAMPED_UPDATES, 1)
        if _toughen(problem, cells, part) < tuning.SAME_ROOT:
            break
        cells, way = settle(problem, delta, cells)
        release_open(problem, cells)
        updates, rounds = updates + 1, rounds + way.rounds
        freed = before - _whole_energy(problem, delta, cells)  # outlines whose toughness grew in between released more
    return cells, Descent(freed, rounds, way.arrived, way.stable)


@kernel
def _toughen(problem, cells, part):
    """Move each cell's factor on w by a part of the way to that for the curvature of its patch's outline.

    Return the largest change of its root. Laws of finite range need no such factor.
    """
    most = 0.0
    if not problem.law.anywhere and cells.count[0] > 0:
        patches = contact_patches(_closed(problem, cells), cells)
        for k in range(cells.count[0]):
            radius = patches.radius[patches.of[k]]
            change = part * (np.sqrt(toughness(radius, problem.law)) - root_of(k, problem, cells))
            most = max(most, abs(change))
            problem.roots[cells.row[k], cells.column[k]] += change
    return most


@kernel
def _closed(problem, cells):
    """Return the closed fraction of each cell: the work left to open it, over the whole work of opening."""
    closed = np.ones(cells.count[0])
    for k in range(cells.count[0]):
        if cells.gap[k] > 0.0:
            root = root_of(k, problem, cells)
            left = remaining_work(cells.gap[k], problem.law, root) if problem.w > 0.0 else 0.0
            closed[k] = left / (problem.w * root**2) if left > 0.0 else 0.0
    return closed


@kernel
def _keep(states, delta, dissipated, problem, cells, way, asked, pressures):
    """Store one state; ``dissipated`` is the sum up to the step that led to it."""
    closed = _closed(problem, cells)
    patches = contact_patches(closed, cells)
    before = states[-1].dissipated if len(states) > 0 else 0.0
    energy = elastic_energy(problem.separation, delta, cells) + _adhesion(problem, closed, patches)
    hard_force, hard_area = _hard_shares(problem, cells)
    dent_area, volume = _dented(problem.dent)
    state = _State(
        delta,
        force(cells),
        _area(problem, cells, closed),
        energy,
        before + dissipated,
        patches.cores,
        _resolution(patches, cells),
        way.rounds,
        way.arrived,
        asked,
        hard_force,
        hard_area,
        dent_area,
        volume,
    )
    if asked and pressures.shape[0] > 0:
        _keep_pressure(pressures[_number_asked(states)], cells)
    states.append(state)


@kernel
def _hard_shares(problem, cells):
    """Return force and area of the cells at the hardness or above, over those that push or touch."""
    pushes, hard_force, touching, hard = 0.0, 0.0, 0, 0
    for k in range(cells.count[0]):
        p = cells.pressure[k]
        touching += cells.gap[k] <= 0.0
        pushes += max(p, 0.0)
        if p >= problem.limit:
            hard_force += p
            hard += 1
    return hard_force / max(pushes, 1e-300), hard / max(touching, 1)


@kernel
def _dented(dent):
    """Return the number of cells that have given way, and their volume."""
    count, volume = 0, 0.0
    for depth in dent.flat:
        count += depth > 0.0
        volume += depth
    return float(count), volume


@kernel
def _number_asked(states):
    number = 0
    for k in range(len(states)):
        number += 1 if states[k].asked else 0
    return number


@kernel
def _area(problem, cells, closed):
    """Return the area in contact, cells; in the Griffith limit the outline runs through cells."""
    area = 0.0
    for k in range(closed.size):
        if cells.gap[k] <= 0.0 or not problem.law.anywhere:
            area += closed[k]
    return area


@kernel
def _whole_energy(problem, delta, cells):
    """Return the energy, nm²: elastic and of adhesion."""
    closed = _closed(problem, cells)
    adhesion = _adhesion(problem, closed, contact_patches(closed, cells))
    return elastic_energy(problem.separation, delta, cells) + adhesion


@kernel
def _adhesion(problem, closed, patches):
    """Return the energy of adhesion, nm²: of all cells, less that of the line tension around them."""
    energy = -problem.w * np.sum(closed)
    if not problem.law.anywhere:
        for c in range(patches.area.size):
            energy += problem.w * line_energy(patches.area[c], patches.radius[c], problem.law)
    return energy


@kernel
def _resolution(patches, cells):
    """Return the radius, in cells, of the smallest contact that bears a relevant part of the tension."""
    pulls = np.zeros(patches.area.size)
    for k in range(cells.count[0]):
        pulls[patches.of[k]] += max(-cells.pressure[k], 0.0)
    smallest, whole = np.inf, pulls.sum()
    for c in range(pulls.size):
        if pulls[c] >= tuning.BEARING_SHARE * whole:
            smallest = min(smallest, np.sqrt(patches.area[c] / np.pi))
    return smallest if pulls.size > 0 else np.nan


@kernel
def _keep_pressure(pressure, cells):
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            pressure[i, j] = 0.0
    for k in range(cells.count[0]):
        pressure[cells.row[k], cells.column[k]] = cells.pressure[k]
