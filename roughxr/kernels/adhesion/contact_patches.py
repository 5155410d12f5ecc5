"""Contact patches: which cells form which connected contact, and the curvature of its outline.

A cell counts by its closed fraction. Cells at least a fifth closed that share a side form one patch; the more open ones
around them go to the patch that reaches them first. The outline of a patch is taken as the ellipse with the moments of
its cells, which is smooth although the cells are not.

For an outline of length L around an area A, the line tension depends on how much it shortens as the contact shrinks,
dL/dA: 1/r for a circle. An ellipse of constant shape has L/2A; adhesive ellipses become rounder as they shrink and have
more, (L/L₀)^{5/3}/r to within 2 % along JKR's branches (``elliptic_jkr``, energy), with L₀ and r of the circle of the
same area.

Lengths in cells, areas in cells². Source: own; the power is fitted to JKR's ellipses, which ``python
tests/benchmarks/line_tension.py`` repeats.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .constrained_cells import ABSENT
from .tuning import CORE, LENGTHENING_POWER

#: Variance of a coordinate within one cell.
_CELL = 1.0 / 12.0


class Patches(NamedTuple):
    """The contact patches of a set of cells: first those with a core, then connected cells without one."""

    of: np.ndarray  # (cell,) patch of each cell
    area: np.ndarray  # (patch,) sum of the closed fractions, cells
    radius: np.ndarray  # (patch,) 1 over dL/dA, cells; at least that of one whole cell
    cores: int  # number of patches with a core


@kernel
def contact_patches(closed, cells):
    """Return the `Patches` of a set of cells; ``closed`` (cell,) in [0, 1]."""
    of, number, cores = _separate(closed, cells)
    moments = np.zeros((number, 6))
    for k in range(closed.size):
        x, y, part = float(cells.row[k]), float(cells.column[k]), closed[k]
        m = moments[of[k]]
        m[0] += part
        m[1] += part * x
        m[2] += part * y
        m[3] += part * x * x
        m[4] += part * y * y
        m[5] += part * x * y
    area, radius = np.empty(number), np.empty(number)
    for c in range(number):
        area[c] = moments[c, 0]
        radius[c] = np.sqrt(max(area[c], 1.0) / np.pi) / lengthening(_axis_ratio(moments[c])) ** LENGTHENING_POWER
    return Patches(of, area, radius, cores)


@kernel
def _separate(closed, cells):
    """Return the patch of each cell, the number of patches, and the number of those with a core."""
    count = closed.size
    of, queue = np.full(count, -1), np.empty(count, np.int64)
    reached, number, cores = np.int64(0), 0, 0
    for least in (CORE, -1.0):  # cores first, then cells without one
        for seed in range(count):
            if of[seed] < 0 and closed[seed] >= least:
                of[seed], queue[reached] = number, seed
                reached, number = _spread(of, queue, reached, reached + 1, closed, least, cells), number + 1
        reached = _spread(of, queue, np.int64(0), reached, closed, -1.0, cells)
        cores = number if least == CORE else cores
    return of, number, cores


@kernel
def _spread(of, queue, head, tail, closed, least, cells):
    """Assign the patch of the cells in the queue to their neighbours, and so on outwards; return the queue's end."""
    while head < tail:
        k = queue[head]
        head += 1
        for side in range(4):
            i = cells.row[k] + (side == 0) - (side == 1)
            j = cells.column[k] + (side == 2) - (side == 3)
            m = cells.place[i, j]
            if m != ABSENT and of[m] < 0 and closed[m] >= least:
                of[m], queue[tail], tail = of[k], m, tail + 1
    return tail


@kernel
def _axis_ratio(moments):
    """Return the axis ratio b/a of the ellipse with the moments of a patch."""
    total = moments[0]
    if total <= 0.0:
        return 1.0
    x, y = moments[1] / total, moments[2] / total
    xx, yy = moments[3] / total - x * x + _CELL, moments[4] / total - y * y + _CELL
    xy = moments[5] / total - x * y
    mean, spread = 0.5 * (xx + yy), np.sqrt(0.25 * (xx - yy) ** 2 + xy * xy)
    return np.sqrt(max(mean - spread, _CELL) / (mean + spread))


@kernel
def lengthening(ratio):
    """Return the perimeter of an ellipse with b/a = ``ratio`` over that of a circle of equal area (Ramanujan)."""
    h = ((1.0 - ratio) / (1.0 + ratio)) ** 2
    return 0.5 * (1.0 + ratio) / np.sqrt(ratio) * (1.0 + 3.0 * h / (10.0 + np.sqrt(4.0 - 3.0 * h)))
