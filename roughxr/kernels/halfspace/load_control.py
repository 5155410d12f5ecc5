"""The contact under a prescribed load: the active set finds the displacement along with the contact.

On cells with undeformed separation S, under a load P, find pressures p and the displacement δ with

    p ≥ 0,     g = S + A p − δ ≥ 0,     p g = 0,     Σ p = P             (as ``displacement_control``, with P for δ)

by ``active_set``; for a material that yields also p ≤ H. Source: own; conjugate gradients under a prescribed load
follow Polonsky & Keer (1999). The cells to work on are chosen by a guess of δ, from the load before or from cells twice
as large; where δ turns out to be larger, or far smaller, they are chosen again. The guess does not affect the result.

Inside, unit cells and unit modulus: loads are in units of E* dx, hence in nm as pressures and all lengths.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .active_set import CONVERGED, ITERATION_LIMIT, Outcome
from .displacement_control import ELASTIC, FORCE, HARD_FORCE, STATUS, describe, in_units, records
from .products import coefficients_for, no_transfers
from .warm_start import COARSE_ITERATIONS, COARSE_TOLERANCE, extrapolated, half_deep, halved, refined
from .working_set import Overlap, WarmStart, depth_in, overlapping, put, solve_in_box

#: Cells that overlap at up to this many times the guessed depth are chosen.
_DEPTH_FACTOR = 1.1

#: d ln F / d ln depth of a sphere, and of one all of whose contact yields.
_SPHERE_EXPONENT, _YIELDING_EXPONENT = 1.5, 1.0

#: Windows narrower than this are not halved to find a displacement.
_SMALLEST_HALVED = 24

#: Largest number of choices of cells.
_MOST_CHOICES = 30


def loaded_arrays(
    separation, loads, dx, contact_modulus, *, tolerance=1e-6, max_iterations=5000, hardness=ELASTIC, keep=0
):
    """Solve the contact at each of ascending loads (nN > 0), each started from the one before.

    Returns displacements (load,), then as `displacement_control.sweep_arrays`, whose options these are. Where there is
    nothing to press on, the displacement is NaN and the solution has not converged.
    """
    separation = np.ascontiguousarray(separation, dtype=float)
    scaled = np.asarray(loads, dtype=float) / (contact_modulus * dx)
    deltas, arrays = np.full(scaled.size, np.nan), records(scaled.size, separation.shape, keep)
    given = separation, scaled, tolerance, max_iterations, *hardness.scaled(dx / contact_modulus)
    _loaded(*given, coefficients_for(separation.shape), deltas, *arrays)
    return deltas, *in_units(*arrays, dx, contact_modulus, hardness)


class _State(NamedTuple):
    """A solved load on a window; the displacement is NaN outside the chosen cells."""

    delta: float
    pressure: np.ndarray  # (1, nx, ny)
    displacement: np.ndarray
    outcome: Outcome


class _Guess(NamedTuple):
    """A displacement near that of a load, and the contact there if known (else with no cells)."""

    delta: float
    contact: WarmStart


@kernel
def _loaded(
    separation, loads, tolerance, max_iterations, cap, limit, coefficients, deltas, states, pressures, displacements
):
    """Write displacements, the columns of each solve, and the fields that there is room for."""
    known, touch = no_transfers(), _lowest(separation)
    for k in range(loads.size):
        states[k, STATUS] = ITERATION_LIMIT  # where there is nothing to press on, no load is carried
    if not np.isfinite(touch) or loads.size == 0:
        return
    guess = _coarse_guess(separation, loads[0], cap, coefficients, known)
    window = Overlap(0, 0, separation.shape[0], separation.shape[1], 0, 0.0)
    for k in range(loads.size):
        state = _solve(separation, loads[k], guess, tolerance, max_iterations, cap, coefficients, known)
        deltas[k] = state.delta
        pressure, displacement, depth = state.pressure[0], state.displacement[0], state.delta - separation
        describe(states[k], pressure, displacement, depth, state.outcome, state.delta - touch, cap, limit)
        field = k - loads.size + pressures.shape[0]
        if field >= 0:
            put(pressure, pressures, field, window)  # a tenth of what NumPy's own assignment takes to compile
            put(displacement, displacements, field, window)
        if k + 1 < loads.size and states[k, FORCE] > 0.0:
            hard = states[k, HARD_FORCE] / states[k, FORCE] if cap < np.inf else 0.0
            exponent = _SPHERE_EXPONENT + hard * (_YIELDING_EXPONENT - _SPHERE_EXPONENT)
            deeper = (loads[k + 1] / states[k, FORCE]) ** (1.0 / exponent)
            guess = _onward(separation, touch + (state.delta - touch) * deeper, state, cap)


@kernel
def _solve(separation, load, guess, tolerance, max_iterations, cap, coefficients, known):
    """Solve one load, starting from a guess."""
    touch, products = _lowest(separation), 0
    for _ in range(_MOST_CHOICES):
        delta = guess.delta
        reach = touch + _DEPTH_FACTOR * (delta - touch)
        box, slack = overlapping(separation, reach), reach - delta
        depth, left = depth_in(separation, delta, box), max_iterations - products
        begin = _cut(guess.contact, box) if guess.contact.pressure.size else half_deep(depth, slack)
        pressure, displacement, outcome = solve_in_box(
            depth, begin, 0.5 * tolerance, left, load, slack, cap, coefficients, known
        )
        products += outcome.iterations
        reached = delta + outcome.shift
        ending = Outcome(outcome.status, products, outcome.violation, outcome.shift)
        shape = (1, *separation.shape)
        state = _State(reached, np.zeros(shape), np.full(shape, np.nan), ending)
        put(pressure, state.pressure, 0, box)
        put(displacement, state.displacement, 0, box)
        shallow = reached - touch < 0.5 * (delta - touch)  # then the goal, a part of the guessed depth, was too loose
        if outcome.status != CONVERGED or (reached <= reach and not shallow):
            return state
        guess = _onward(separation, reached, state, cap)
    stagnant = Outcome(ITERATION_LIMIT, products, state.outcome.violation, state.outcome.shift)
    return _State(state.delta, state.pressure, state.displacement, stagnant)


@kernel
def _cut(start, box):
    return WarmStart(start.pressure, start.touching, start.possible, box.row, box.column)


@kernel
def _onward(separation, delta, state, cap):
    """Return a guess from one solution: that of the load before, or of the same load on too few cells."""
    depth, step = delta - separation, delta - state.delta
    return _Guess(delta, extrapolated(depth, step, state.pressure, state.displacement, np.nan, cap, 0, 0))


@kernel
def _coarse_guess(separation, load, cap, coefficients, known):
    """Return a guess from the same load on cells twice as large, solved likewise; with few cells from a paraboloid."""
    levels = [separation]
    while min(levels[-1].shape[0], levels[-1].shape[1]) >= _SMALLEST_HALVED:
        levels.append(halved(levels[-1]))
    last = len(levels) - 1
    nothing = WarmStart(np.zeros((0, 0)), np.zeros((0, 0), np.bool_), np.zeros((0, 0), np.bool_), 0, 0)
    guess = _Guess(_lowest(levels[last]) + _depth_estimate(levels[last], load / 2.0**last), nothing)
    for k in range(last, 0, -1):  # when the side of cells doubles, E* dx doubles and E*/dx halves
        coarse_cap = cap * 2.0**k
        state = _solve(
            levels[k], load / 2.0**k, guess, COARSE_TOLERANCE, COARSE_ITERATIONS, coarse_cap, coefficients, known
        )
        finer = levels[k - 1]
        touch = _lowest(finer)
        delta = max(state.delta, touch + 0.1 * (state.delta - _lowest(levels[k])))
        guess = _Guess(delta, refined(state.pressure[0], state.displacement[0], delta - finer, 0.5 * coarse_cap))
    return guess


@kernel
def _depth_estimate(separation, load):
    """Return the depth at which F = (4/3) E* depth √(overlap area/2π), as for a paraboloid, reaches the load."""
    heights = separation.ravel()
    depths = np.sort(heights[np.isfinite(heights)]) - _lowest(separation)
    for k in range(depths.size):
        depth = 0.75 * load / np.sqrt((k + 1) / (2.0 * np.pi))
        if k + 1 == depths.size or depth <= depths[k + 1]:  # reached before the next cell overlaps
            return depth
    return np.nan


@kernel
def _lowest(separation):
    lowest = np.inf
    for value in separation.flat:
        lowest = min(lowest, value) if value == value else lowest
    return lowest
