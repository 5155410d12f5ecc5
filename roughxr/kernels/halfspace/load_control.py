"""The contact under a prescribed load: the active set finds the displacement along with the contact.

On cells with undeformed separation S, under a load P, find pressures p and the displacement δ with

    p ≥ 0,     g = S + A p − δ ≥ 0,     p g = 0,     Σ p = P             (as ``displacement_control``, with P for δ)

by ``active_set``; for a material that yields also p ≤ H. Source: own; conjugate gradients under a prescribed load
follow Polonsky & Keer (1999). The cells to work on are chosen by a guess of δ, from the load before or from cells twice
as large; where δ turns out to be larger, or far smaller, they are chosen again. The guess does not affect the result.

Inside, unit cells and unit modulus: loads are in units of E* dx, hence in nm as pressures and all lengths.
"""

import numpy as np

from .active_set import CONVERGED, ITERATION_LIMIT
from .displacement_control import ELASTIC, STATUS, ahead_of, describe, in_units, records
from .working_set import (
    COARSE_ITERATIONS,
    COARSE_TOLERANCE,
    Contact,
    Guess,
    box_below,
    half_deep,
    halved,
    refined,
    solve_in_box,
)

#: Cells that overlap at up to this many times the guessed depth are chosen.
_DEPTH_FACTOR = 1.1

#: d ln depth / d ln F of a sphere.
_DEPTH_EXPONENT = 2 / 3

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
    separation = np.where(np.isnan(separation), np.inf, separation)
    cap, limit = hardness.scaled(dx / contact_modulus)
    deltas, arrays = np.full(len(loads), np.nan), records(len(loads), separation.shape, keep)
    states, pressures, displacements = arrays
    states[:, STATUS] = ITERATION_LIMIT  # where there is nothing to press on, no load is carried
    windows, touch = [separation], separation.min(initial=np.inf)
    while min(windows[-1].shape) >= _SMALLEST_HALVED:
        windows.append(halved(windows[-1]))
    scaled, contact = np.asarray(loads) / (contact_modulus * dx), None
    for k, load in enumerate(scaled if np.isfinite(touch) else ()):
        if contact is None:
            delta, guess = _coarse_guess(windows, load, cap)
        else:
            delta = touch + (deltas[k - 1] - touch) * (load / scaled[k - 1]) ** _DEPTH_EXPONENT
            guess = _onward(separation, delta, deltas[k - 1], contact, cap)
        deltas[k], contact = _solve(separation, load, delta, guess, tolerance, max_iterations, cap)
        describe(states[k], contact, deltas[k] - separation, cap, limit)
        field = k - len(loads) + keep
        if field >= 0:
            pressures[field], displacements[field] = contact.pressure, contact.displacement
    return deltas, *in_units(*arrays, dx, contact_modulus, hardness)


def _coarse_guess(windows, load, cap):
    """Return displacement and `Guess` of a load on the first of some windows, the others of cells twice as large each.

    The guess is None where there is but one window.
    """
    last = len(windows) - 1
    delta, guess = windows[last].min() + _depth_estimate(windows[last], load / 2**last), None
    for n in range(last, 0, -1):  # when the side of cells doubles, E* dx doubles and E*/dx halves
        limits = COARSE_TOLERANCE, COARSE_ITERATIONS, cap * 2**n
        coarse_delta, coarse = _solve(windows[n], load / 2**n, delta, guess, *limits)
        finer = windows[n - 1]
        delta = max(coarse_delta, finer.min() + 0.1 * (coarse_delta - windows[n].min()))
        guess = refined(coarse, delta - finer, cap * 2 ** (n - 1))
    return delta, guess


def _onward(separation, delta, before, contact, cap):
    """Return a guess at a displacement from the contact at another, or from one on too few cells."""
    trail = [(before, contact.pressure, contact.displacement)]
    return ahead_of(trail, delta, (slice(None), slice(None)), delta - separation, cap)


def _solve(separation, load, delta, guess, tolerance, max_iterations, cap):
    """Return displacement and `Contact` on a window, from a displacement and a guess of the contact, if any, there."""
    touch, products = separation.min(), 0
    for _ in range(_MOST_CHOICES):
        reach = touch + _DEPTH_FACTOR * (delta - touch)
        box, _ = box_below(separation, reach)
        depth, slack = delta - separation[box], reach - delta
        begin = half_deep(depth) if guess is None else Guess(*(field[box] for field in guess))
        solved = solve_in_box(depth, begin, 0.5 * tolerance, max_iterations - products, cap, load=load, slack=slack)
        products += solved.outcome.iterations
        reached = delta + solved.outcome.shift
        shallow = reached - touch < 0.5 * (delta - touch)  # then the goal, a part of the guessed depth, was too loose
        pressure, displacement = np.zeros(separation.shape), np.full(separation.shape, np.nan)
        pressure[box], displacement[box] = solved.pressure, solved.displacement
        contact = Contact(pressure, displacement, solved.outcome._replace(iterations=products))
        if solved.outcome.status != CONVERGED or (reached <= reach and not shallow):
            return reached, contact
        delta, guess = reached, _onward(separation, reached, delta, contact, cap)
    return delta, contact._replace(outcome=contact.outcome._replace(status=ITERATION_LIMIT))


def _depth_estimate(separation, load):
    """Return the depth at which F = (4/3) E* depth √(overlap area/2π), as for a paraboloid, reaches the load."""
    depths = np.sort(separation[np.isfinite(separation)]) - separation.min()
    estimates = 0.75 * load / np.sqrt(np.arange(1, depths.size + 1) / (2.0 * np.pi))
    reached = estimates[:-1] <= depths[1:]  # before the next cell overlaps
    return estimates[np.argmax(reached) if reached.any() else -1]
