"""Adhesionless contact of a rigid profile with a half space, at a displacement or through a sweep of them.

On cells with undeformed separation S (nm), at a displacement δ (nm), find pressures p (GPa) with

    p ≥ 0,     g = S + A p − δ ≥ 0,     p g = 0                       (Kalker 1990; Cheng, Dunn & Brach, eqs. 36–39)

or, of a material that yields at the hardness H (GPa), p ≤ H as well, with g ≤ 0 where p = H: there the surface yields
by −g (``yielding``). The active set (``active_set``) finds the touching cells. Few cells and a good start save time and
do not change the solution:

- Only cells with S < δ can carry load, since A p ≥ 0; all others are left out.
- Of these, cells with a wide gap in the guess are left out as well, until one product over the whole overlap shows
  whether they touch (``working_set``).
- Pressures scale with E*/dx, so cells of unit side on a half space of unit modulus are solved.
"""

from typing import NamedTuple

import numpy as np

from .active_set import CONVERGED as CONVERGED
from .active_set import ITERATION_LIMIT
from .working_set import Guess, box_below, slack_of, solve_contact

#: Columns for each solve of a sweep: force nN, area nm², status, products A p, the largest |g| in contact or of the
#: wrong sign outside over the deepest overlap; force nN and area nm² of cells at the hardness or above, and their
#: plastically displaced volume, nm³.
FORCE, AREA, STATUS, ITERATIONS, RESIDUAL, HARD_FORCE, HARD_AREA, DENT = range(8)


class Hardness(NamedTuple):
    """The pressure (GPa) at which a material yields or, with ``yielding`` False, above which it is only reported."""

    pressure: float = np.inf
    yielding: bool = True

    def scaled(self, per_unit):
        """Return the largest pressure on unit cells of unit modulus, and the one above which cells are reported."""
        limit = self.pressure * per_unit
        return (limit if self.yielding else np.inf), limit


#: Relative error of the force.
TOLERANCE = 1e-6

#: Largest number of products A p of a solve.
MOST_PRODUCTS = 5000

#: For a material that never yields.
ELASTIC = Hardness()


def sweep_arrays(
    separation,
    deltas,
    dx,
    contact_modulus,
    film=None,
    *,
    tolerance=TOLERANCE,
    max_iterations=MOST_PRODUCTS,
    hardness=ELASTIC,
    keep=0,
):
    """Solve the contact at each of ascending displacements, nm, each started from those before.

    The separation is in nm, NaN or inf where there is nothing to touch; the gap left in contact, and the penetration
    outside, stay below half of ``tolerance`` times the deepest overlap, the force's relative error (it grows about like
    depth^1.5, or as depth at first touch). ``max_iterations`` is the largest number of products A p. Returns (delta, 8)
    of ``FORCE`` … ``DENT``, and pressures (GPa) and displacements (nm, on the overlap's bounding box, NaN elsewhere) of
    the last ``keep``.
    """
    separation = np.where(np.isnan(separation), np.inf, separation)
    lowest = separation.min(1), separation.min(0)
    touch = lowest[0].min(initial=np.inf)
    cap, limit = hardness.scaled(dx / contact_modulus)
    states, *fields = records(len(deltas), separation.shape, max(keep, 2))
    last = (-np.inf, *(field[0] for field in fields))
    older = last
    slack = slack_of(film)
    for k, delta in enumerate(map(float, deltas), -len(deltas)):
        if not touch < delta:
            continue
        box = box_below(lowest, delta + slack)
        depth = delta - separation[box]
        guess = extrapolated(older, last, delta, box, depth, cap) if last[0] > -np.inf else None
        contact = solve_contact(depth, tolerance, max_iterations, cap, guess, film)
        describe(states[k], contact, depth, cap, limit)
        pressure, displacement = (field[k % len(field)] for field in fields)  # boxes grow: older ones are overwritten
        pressure[box] = contact.pressure
        displacement[box] = contact.displacement
        older = last
        last = (delta, pressure, displacement)
    return in_units(states, *(field[len(field) - keep :] for field in fields), dx, contact_modulus, hardness)


def records(count, shape, keep):
    """Return empty arrays for the columns of each solve, and for pressures and displacements of the last ``keep``."""
    fields = (keep, *shape)
    return np.zeros((count, 8)), np.zeros(fields), np.full(fields, np.nan)


def in_units(states, pressures, displacements, dx, contact_modulus, hardness):
    """Convert the results on unit cells of unit modulus to nm, nN and GPa, in place."""
    states[:, [FORCE, HARD_FORCE]] *= contact_modulus * dx
    states[:, [AREA, HARD_AREA, DENT]] *= dx * dx
    pressures *= contact_modulus / dx
    if hardness.yielding:
        np.minimum(pressures, hardness.pressure, out=pressures)  # corrects rounding
    return states, pressures, displacements


def extrapolated(older, last, delta, box, depth, cap):
    """Return a guess in a box from two states (δ, pressure, displacement), linear in δ; an unknown state has δ = -inf.

    With increasing δ the contact grows, and displacements outside it grow faster than linearly (the inverse of A has
    positive entries on its diagonal only). Linear extrapolation therefore overestimates the contact: a cell that will
    touch penetrates, but a slight penetration seldom leads to contact. Where the older displacement is unknown, the
    last one is used to choose cells that may touch, and the last one plus half of the step to choose cells in contact.
    """
    pressure, displacement = (field[box] for field in last[1:])
    older_pressure, older_displacement = (field[box] for field in older[1:])
    step = delta - last[0]
    ahead = step / (last[0] - older[0])
    growth = ahead * (displacement - older_displacement)
    is_unknown = np.isnan(growth)
    gap = displacement + np.where(is_unknown, 0.0, growth) - depth
    guess = np.clip(pressure + ahead * (pressure - older_pressure), 0.0, cap)
    # in a sweep, cells whose extrapolated penetration exceeds this part of the step are taken as touching
    penetrates = gap + np.where(is_unknown, 0.5 * step, 0.0) < -0.1 * step
    touching = ((pressure > 0.0) | penetrates) & (guess < cap)
    return Guess(guess, touching, touching | ~(gap >= 0.0))


def describe(row, contact, depth, cap, limit):
    """Write the columns of a solve."""
    pressure, displacement, outcome = contact
    row[FORCE] = pressure.sum()
    row[AREA] = np.count_nonzero(pressure)
    if limit < np.inf:
        hard = pressure >= limit
        row[HARD_FORCE] = pressure[hard].sum()
        row[HARD_AREA] = np.count_nonzero(hard)
    if cap < np.inf:
        row[DENT] = np.maximum(depth - displacement, 0.0)[pressure >= cap].sum()
    row[STATUS] = outcome.status
    row[ITERATIONS] = outcome.iterations
    row[RESIDUAL] = outcome.violation / depth.max()
    if not np.isfinite(row[FORCE]):  # comparisons with NaN hide it from the conditions
        row[STATUS] = ITERATION_LIMIT
        row[RESIDUAL] = np.nan
