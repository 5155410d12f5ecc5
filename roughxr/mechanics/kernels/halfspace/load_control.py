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
from .displacement_control import ELASTIC, MOST_PRODUCTS, STATUS, TOLERANCE, describe, extrapolated, in_units, records
from .products import DENSE_LIMIT
from .working_set import (
    COARSE_ITERATIONS,
    COARSE_TOLERANCE,
    Guess,
    SolvedContact,
    box_below,
    half_deep,
    halved,
    refined,
    slack_of,
    solve_in_box,
)


def loaded_arrays(
    separation,
    loads,
    dx,
    contact_modulus,
    film=None,
    *,
    tolerance=TOLERANCE,
    max_iterations=MOST_PRODUCTS,
    hardness=ELASTIC,
    keep=0,
):
    """Solve the contact at each of ascending loads (nN > 0), each started from the one before.

    Returns displacements (load,), then the results of `displacement_control.sweep_arrays`, which explains the options.
    Where there is nothing to press on, the displacement is NaN and the solution has not converged.
    """
    separation = np.where(np.isnan(separation), np.inf, separation)
    cap, limit = hardness.scaled(dx / contact_modulus)
    deltas = np.full(len(loads), np.nan)
    arrays = records(len(loads), separation.shape, keep)
    states, pressures, displacements = arrays
    states[:, STATUS] = ITERATION_LIMIT  # stays so where there is nothing to press on
    touch = separation.min(initial=np.inf)
    scaled = np.asarray(loads) / (contact_modulus * dx)
    contact = None
    for k, load in enumerate(scaled if np.isfinite(touch) else ()):
        if contact is None:
            delta, start = _first_guess(separation, load, cap, film)
        else:
            # d ln depth / d ln F of Hertz's sphere
            delta = touch + (deltas[k - 1] - touch) * (load / scaled[k - 1]) ** (2 / 3)
            start = _start_from_state(deltas[k - 1], contact, cap)
        deltas[k], contact = _solve(separation, load, delta, start, tolerance, max_iterations, cap, film)
        describe(states[k], contact, deltas[k] - separation, cap, limit)
        field = k - len(loads) + keep
        if field >= 0:
            pressures[field] = contact.pressure
            displacements[field] = contact.displacement
    return deltas, *in_units(*arrays, dx, contact_modulus, hardness)


def _first_guess(separation, load, cap, film):
    """Return a displacement and a start: by an estimate for few cells, else from a solution on cells twice as large."""
    # windows narrower than this are not halved to find a displacement
    halves = min(separation.shape) >= 24
    depth = _depth_estimate(separation, load, DENSE_LIMIT if halves else separation.size)
    touch = separation.min()
    if np.isfinite(depth):
        return touch + depth, lambda delta, box, depth: half_deep(depth)
    coarser = halved(separation)  # E* dx doubles and E*/dx halves
    limits = (COARSE_TOLERANCE, COARSE_ITERATIONS, 2.0 * cap)
    thinner = film and film.on_cells(2)
    start = _first_guess(coarser, 0.5 * load, 2.0 * cap, thinner)
    reached, coarse = _solve(coarser, 0.5 * load, *start, *limits, thinner)
    delta = max(reached, touch + 0.1 * (reached - coarser.min()))
    guess = refined(coarse, delta - separation, cap)
    return delta, lambda delta, box, depth: Guess(*(np.ascontiguousarray(field[box]) for field in guess))


def _start_from_state(before, contact, cap):
    """Return a start from the contact at another displacement."""
    last = before, contact.pressure, contact.displacement
    older = -np.inf, contact.pressure, np.full(contact.pressure.shape, np.nan)
    return lambda delta, box, depth: extrapolated(older, last, delta, box, depth, cap)


def _solve(separation, load, delta, start, tolerance, max_iterations, cap, film):
    """Solve at one load; return displacement and `Contact`. ``start(delta, box, depth)`` returns a `Guess` in a box."""
    lowest = (separation.min(1), separation.min(0))
    products = 0
    beyond = slack_of(film)
    touch = lowest[0].min()
    # largest number of choices of cells
    for _ in range(30):
        # cells that overlap at up to this many times the guessed depth are chosen
        reach = touch + 1.1 * (delta - touch)
        box = box_below(lowest, reach + beyond)
        depth = delta - separation[box]
        slack = reach - delta + beyond
        guess = start(delta, box, depth)
        products_left = max_iterations - products
        solved = solve_in_box(depth, guess, 0.5 * tolerance, products_left, cap, film, load=load, slack=slack)
        products += solved.outcome.iterations
        reached = delta + solved.outcome.shift
        shallow = reached - touch < 0.5 * (delta - touch)  # then the tolerance, a part of the guessed depth, was loose
        pressure = np.zeros(separation.shape)
        displacement = np.full(separation.shape, np.nan)
        pressure[box] = solved.pressure
        displacement[box] = solved.displacement
        contact = SolvedContact(pressure, displacement, solved.outcome._replace(iterations=products))
        if solved.outcome.status != CONVERGED or (reached <= reach and not shallow):
            return reached, contact
        start = _start_from_state(delta, contact, cap)
        delta = reached
    return delta, contact._replace(outcome=contact.outcome._replace(status=ITERATION_LIMIT))


def _depth_estimate(separation, load, most_cells):
    """Return the depth at which F = (4/3) E* depth √(overlap area/2π), as for a paraboloid, reaches the load.

    NaN where more than ``most`` cells overlap there.
    """
    values = separation[np.isfinite(separation)]
    depths = (
        np.sort(np.partition(values, most_cells)[: most_cells + 1] if most_cells < values.size else values)
        - separation.min()
    )
    estimates = 0.75 * load / np.sqrt(np.arange(1, depths.size + 1) / (2.0 * np.pi))
    reached = np.flatnonzero(estimates[:-1] <= depths[1:])  # before the next cell overlaps
    return estimates[reached[0]] if reached.size else estimates[-1] if depths.size == values.size else np.nan
