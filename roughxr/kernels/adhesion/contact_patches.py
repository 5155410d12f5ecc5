"""Contact patches: which cells form which connected contact, and how curved its outline is.

A cell counts by the part of it that is closed. Cells at least a fifth closed that share a side are one patch; the
more open ones around go to the patch that reaches them first. The outline of a patch is taken as the ellipse with
the moments of its cells: smooth where the cells are not.

What matters of an outline of length L around an area A is by how much it shortens as the contact shrinks, dL/dA: 1/r on
a circle. An ellipse of lasting shape would lose L/2A; adhesive ellipses grow rounder as they shrink and lose more, by
JKR's branches (``elliptic_jkr``, energy) to within 2 % (L/L₀)^{5/3}/r, L₀ and r of the circle of the same area.

Lengths in cells, areas in cells². Source: own; the power is found from JKR's ellipses, and shown again by
``python tests/benchmarks/line_tension.py``.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .constrained_cells import ABSENT
from .tuning import CORE, LENGTHENING_POWER

#: Variance of a coordinate over one cell.
_CELL = 1.0 / 12.0


class Patches(NamedTuple):
    """The contact patches of a set of cells: first those with a core, then connected cells without one."""

    of: np.ndarray  # (cell,) patch of each cell
    area: np.ndarray  # (patch,) sum of the closed parts, cells
    radius: np.ndarray  # (patch,) 1 over dL/dA, cells; of one whole cell at least
    cores: int  # patches with a core


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


@kernel(inner=True)
def _separate(closed, cells):
    """Return the patch of each cell, the number of patches, and that of those with a core."""
    count = closed.size
    of, queue = np.full(count, -1), np.empty(count, np.int64)
    reached, number, cores = np.int64(0), 0, 0
    for least in (CORE, -1.0):  # cores first, then what has none
        for seed in range(count):
            if of[seed] < 0 and closed[seed] >= least:
                of[seed], queue[reached] = number, seed
                reached, number = _spread(of, queue, reached, reached + 1, closed, least, cells), number + 1
        reached = _spread(of, queue, np.int64(0), reached, closed, -1.0, cells)
        cores = number if least == CORE else cores
    return of, number, cores


@kernel(inner=True)
def _spread(of, queue, head, tail, closed, least, cells):
    """Let the cells of the queue take in their neighbours, these theirs, and so on; return the queue's end."""
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


@kernel(inner=True)
def _axis_ratio(moments):
    """Return b/a of the ellipse with the moments of a patch."""
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
    """Return the length of an ellipse of b/a = ``ratio`` over a circle's of the same area, by Ramanujan's formula."""
    h = ((1.0 - ratio) / (1.0 + ratio)) ** 2
    return 0.5 * (1.0 + ratio) / np.sqrt(ratio) * (1.0 + 3.0 * h / (10.0 + np.sqrt(4.0 - 3.0 * h)))
