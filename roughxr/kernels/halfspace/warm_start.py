"""Warm starts: a first guess of a contact, which affects the time of a solve, but not its result.

Given solutions at smaller displacements, or none, sought are pressures p, the cells to start from as touching, and the
cells that may touch at all. In a sweep they are extrapolated from the two solutions before; otherwise the same problem
is first solved on cells twice as large, which are started likewise (nested iteration). Source: own.

Unit cells and unit modulus: pressures are in units of E*/dx, hence in nm as all lengths.
"""

import numpy as np

from ..arrays import table, unset
from ..jit import kernel
from .products import DENSE_LIMIT
from .working_set import WarmStart, overlap_of

#: In a sweep, cells that penetrate by this part of the step when extrapolated are taken as touching.
_JOINING_PART = 0.1

#: After a coarse solve, cells whose predicted gap exceeds this part of the deepest overlap are left out.
_MARGIN = 0.05

#: Tolerance and iterations of the solve on cells twice as large, which is only a guess.
COARSE_TOLERANCE, COARSE_ITERATIONS = 1e-3, np.int64(1000)


@kernel
def extrapolated(depth, step, pressure, displacement, ahead, cap, row, column):
    """Extrapolate the contact in a box along the line through two solutions, or from one (``ahead`` is NaN then).

    Pressure and displacement are (1 or 2, …), the later solution last, on a window in which the box begins at ``row``
    and ``column``; ``step`` is the change of displacement from it, and ``ahead`` this change over that between the two.

    With increasing δ the contact grows, and displacements outside it grow faster than linearly (the inverse of A has
    positive entries on its diagonal only). Linear extrapolation therefore overestimates the contact: a cell that will
    touch penetrates, a slight penetration seldom leads to contact. From a single solution, possible contact assumes a
    constant displacement, and contact a growth by half the step. A cell of unknown displacement may touch.
    """
    (rows, columns), last = depth.shape, pressure.shape[0] - 1
    out, touching, possible = table(rows, columns, 0.0), table(rows, columns, False), table(rows, columns, False)
    for i in range(rows):
        for j in range(columns):
            k, m = row + i, column + j
            p, u = pressure[last, k, m], displacement[last, k, m]
            growth = ahead * (u - displacement[0, k, m])
            out[i, j] = p if np.isnan(ahead) else min(max(p + ahead * (p - pressure[0, k, m]), 0.0), cap)
            doubt = 0.0
            if np.isnan(growth):
                growth, doubt = 0.0, 0.5 * step
            gap = u + growth - depth[i, j]
            touching[i, j] = (p > 0.0 or gap + doubt < -_JOINING_PART * step) and out[i, j] < cap
            possible[i, j] = touching[i, j] or not gap >= 0.0
    return WarmStart(out, touching, possible, 0, 0)


@kernel
def half_deep(depth, slack):
    """Return a guess for few cells: those that overlap by more than half the deepest, as under a paraboloid, touch."""
    _, largest = overlap_of(depth, 0.0)
    rows, columns = depth.shape
    touching, possible = table(rows, columns, False), table(rows, columns, False)
    for i in range(rows):
        for j in range(columns):
            touching[i, j], possible[i, j] = depth[i, j] > 0.5 * largest, depth[i, j] > -slack
    return WarmStart(table(rows, columns, 0.0), touching, possible, 0, 0)


@kernel
def coarser(depth):
    """Return the depths on cells twice as large, on cells twice as large as those, and so on, while they are many."""
    levels = [depth]
    while overlap_of(levels[-1], 0.0)[0] > DENSE_LIMIT and min(levels[-1].shape[0], levels[-1].shape[1]) >= 4:
        levels.append(halved(levels[-1]))
    return levels


@kernel
def refined(pressure, displacement, depth, cap):
    """Return the guess in a box of depths from a solution on cells twice as large, its pressures below the cap."""
    (rows, columns), margin = depth.shape, _MARGIN * overlap_of(depth, 0.0)[1]
    out, touching, possible = table(rows, columns, 0.0), table(rows, columns, False), table(rows, columns, False)
    for i in range(rows):
        for j in range(columns):
            out[i, j] = min(0.5 * pressure[i // 2, j // 2], cap)  # E*/dx is twice as large
            gap = _between(displacement, i, j) - depth[i, j]
            touching[i, j] = (gap < 0.0 or (out[i, j] > 0.0 and out[i, j] > gap)) and out[i, j] < cap
            possible[i, j] = touching[i, j] or not gap >= margin
    return WarmStart(out, touching, possible, 0, 0)


@kernel
def _between(field, i, j):
    """Return a coarse field at the centre of a cell half as large, interpolated linearly between centres."""
    k, m = i // 2, j // 2
    k_next = min(max(k + 2 * (i % 2) - 1, 0), field.shape[0] - 1)
    m_next = min(max(m + 2 * (j % 2) - 1, 0), field.shape[1] - 1)
    near = 0.75 * field[k, m] + 0.25 * field[k, m_next]
    return 0.75 * near + 0.25 * (0.75 * field[k_next, m] + 0.25 * field[k_next, m_next])


@kernel
def halved(depth):
    """Return the means of 2 × 2 cells; odd rims are repeated."""
    rows, columns = depth.shape
    out = unset(((rows + 1) // 2, (columns + 1) // 2), 0.0)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            k, m = min(2 * i + 1, rows - 1), min(2 * j + 1, columns - 1)
            out[i, j] = 0.25 * (depth[2 * i, 2 * j] + depth[2 * i, m] + depth[k, 2 * j] + depth[k, m])
    return out
