"""Adhesionless contact of a rigid profile with a half space, at a displacement or through a sweep of them.

On cells with undeformed separation S (nm), at a displacement δ (nm), find pressures p (GPa) with

    p ≥ 0,     g = S + A p − δ ≥ 0,     p g = 0                       (Kalker 1990; Cheng, Dunn & Brach, eqs. 36–39)

or, of a material that yields at the hardness H (GPa), p ≤ H as well, with g ≤ 0 where p = H: there the surface gives
way by −g (``yielding``). The active set (``active_set``) finds which cells touch. Here it is given as few cells as
possible, and a good start, none of which changes the solution:

- Only cells with S < δ can carry load, since A p ≥ 0; everything else is cut away.
- Of these, the cells whose gap is well open in the warm start (``warm_start``) are left out too, until one product
  over the whole overlap shows whether they touch (``working_set``).
- Pressures scale with E*/dx, so cells of unit side on a half space of unit modulus are solved.

A whole sweep is one compiled call that holds no lock: threads do not wait for each other.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .active_set import CONVERGED as CONVERGED
from .active_set import ITERATION_LIMIT
from .products import coefficients_for, no_transfers
from .warm_start import COARSE_ITERATIONS, COARSE_TOLERANCE, coarser, extrapolated, half_deep, refined
from .working_set import WarmStart, depth_in, overlapping, put, solve_in_box

#: Columns for each solve of a sweep: force nN, area nm², status, products A p, the largest |g| in contact or of the
#: wrong sign outside over the deepest overlap; force nN and area nm² of cells at the hardness or above, and the volume
#: nm³ by which they gave way.
FORCE, AREA, STATUS, ITERATIONS, RESIDUAL, HARD_FORCE, HARD_AREA, DENT = range(8)


class Hardness(NamedTuple):
    """The pressure (GPa) at which a material yields or, with ``yielding`` False, above which it is only reported."""

    pressure: float = np.inf
    yielding: bool = True

    def scaled(self, per_unit):
        """Return the largest pressure on unit cells of unit modulus, and the one above which cells are reported."""
        limit = self.pressure * per_unit
        return (limit if self.yielding else np.inf), limit


#: For a material that never yields.
ELASTIC = Hardness()


def sweep_arrays(
    separation,
    deltas,
    dx,
    contact_modulus,
    *,
    tolerance=1e-6,
    start=None,
    max_iterations=5000,
    hardness=ELASTIC,
    keep=0,
):
    """Solve the contact at each of ascending displacements, nm, each started from those before.

    The separation is in nm, NaN or inf where there is nothing to touch; the gap left in contact, and the penetration
    outside, stay below half of ``tolerance`` times the deepest overlap, the force's relative error (it grows about like
    depth^1.5, or as depth at first touch). ``start`` is a guess of the first contact, its pressure in GPa, and
    ``max_iterations`` the largest number of products A p. Returns (delta, 8) of ``FORCE`` … ``DENT``, and pressures
    (GPa) and displacements (nm, on the overlap's bounding box, NaN elsewhere) of the last ``keep``.
    """
    separation, guided = np.ascontiguousarray(separation, dtype=float), start is not None
    start = start._replace(pressure=start.pressure * (dx / contact_modulus)) if guided else _no_start()
    coefficients, deltas = coefficients_for(separation.shape), np.asarray(deltas, dtype=float)
    states, pressures, displacements = records(deltas.size, separation.shape, keep)
    trail = _Trail(np.full(2, np.nan), np.zeros((2, *separation.shape)), np.full((2, *separation.shape), np.nan))
    bounds = hardness.scaled(dx / contact_modulus)
    given = separation, deltas, tolerance, max_iterations, *bounds, start, guided, coefficients
    _sweep(*given, trail, states, pressures, displacements)
    return in_units(states, pressures, displacements, dx, contact_modulus, hardness)


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


def _no_start():
    return WarmStart(np.zeros((0, 0)), np.zeros((0, 0), np.bool_), np.zeros((0, 0), np.bool_), 0, 0)


class _Trail(NamedTuple):
    """The last two solutions of a sweep, the later one second: NaN where nothing is known."""

    delta: np.ndarray  # (2,), nm
    pressure: np.ndarray  # (2, nx, ny), scaled
    displacement: np.ndarray  # nm


@kernel
def _sweep(
    separation,
    deltas,
    tolerance,
    max_iterations,
    cap,
    limit,
    start,
    guided,
    coefficients,
    trail,
    states,
    pressures,
    displacements,
):
    """Write the columns of each solve, and the scaled fields of as many of the last ones as there is room for."""
    known = no_transfers()
    for k in range(deltas.size):
        box = overlapping(separation, deltas[k])
        if box.count == 0:
            continue
        depth = depth_in(separation, deltas[k], box)
        cold = not guided and np.isnan(trail.delta[1])
        levels = coarser(depth) if cold else [depth]
        begin = half_deep(levels[-1], 0.0) if cold else _begin(depth, deltas[k], box, trail, cap, start)
        for n in range(len(levels) - 1, -1, -1):
            part = 0.5 * (tolerance if n == 0 else COARSE_TOLERANCE)
            most = max_iterations if n == 0 else COARSE_ITERATIONS
            coarse_cap = cap * (1 << n)  # with the cells' side E*/dx halves
            pressure, displacement, outcome = solve_in_box(
                levels[n], begin, part, most, None, 0.0, coarse_cap, coefficients, known
            )
            begin = refined(pressure, displacement, levels[n - 1], 0.5 * coarse_cap) if n > 0 else begin
        describe(states[k], pressure, displacement, depth, outcome, box.largest, cap, limit)
        field = k - deltas.size + pressures.shape[0]
        if field >= 0:
            put(pressure, pressures, field, box)
            put(displacement, displacements, field, box)
        if states[k, FORCE] > 0.0:
            _remember(trail, deltas[k], box, pressure, displacement)


@kernel
def describe(row, pressure, displacement, depth, outcome, largest, cap, limit):
    """Write the columns of a solve whose deepest overlap is ``largest``."""
    total, touching, hard_force, hard, dent = 0.0, 0, 0.0, 0, 0.0
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            total += pressure[i, j]
            touching += pressure[i, j] != 0.0
            if pressure[i, j] >= limit:
                hard_force += pressure[i, j]
                hard += 1
            if pressure[i, j] >= cap:
                dent += max(depth[i, j] - displacement[i, j], 0.0)
    row[FORCE], row[AREA], row[HARD_FORCE], row[HARD_AREA], row[DENT] = total, touching, hard_force, hard, dent
    row[STATUS], row[ITERATIONS], row[RESIDUAL] = outcome.status, outcome.iterations, outcome.violation / largest
    if not np.isfinite(total):  # comparisons with NaN hide it from the conditions
        row[STATUS], row[RESIDUAL] = ITERATION_LIMIT, np.nan


@kernel
def _begin(depth, delta, box, trail, cap, start):
    """Return a guess of the contact in a box: from the solutions before or, for the first, the given one."""
    if np.isnan(trail.delta[1]):
        return WarmStart(start.pressure, start.touching, start.possible, box.row, box.column)
    step = delta - trail.delta[1]
    ahead = step / (trail.delta[1] - trail.delta[0])
    return extrapolated(depth, step, trail.pressure, trail.displacement, ahead, cap, box.row, box.column)


@kernel
def _remember(trail, delta, box, pressure, displacement):
    """Store a solution as the last one."""
    trail.delta[0], trail.delta[1] = trail.delta[1], delta
    _, rows, columns = trail.pressure.shape
    for i in range(rows):
        for j in range(columns):
            trail.pressure[0, i, j], trail.displacement[0, i, j] = trail.pressure[1, i, j], trail.displacement[1, i, j]
            trail.pressure[1, i, j], trail.displacement[1, i, j] = 0.0, np.nan
    put(pressure, trail.pressure, 1, box)
    put(displacement, trail.displacement, 1, box)
