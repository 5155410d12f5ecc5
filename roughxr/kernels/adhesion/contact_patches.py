"""Which cells belong to which contact, and how curved its outline is.

A cell counts by the part of it that is closed. Cells at least a fifth closed that share a side are one contact; the
more open ones around go to the contact that reaches them first. The outline of a contact is drawn as the ellipse with
its cells' moments: smooth where the cells are not, and what a rough outline is seen as from the width of its front.

What matters of an outline of length L around an area A is by how much it shortens as the contact shrinks, dL/dA: 1/r on
a circle. An ellipse of lasting shape would lose L/2A; adhesive ellipses grow rounder as they shrink and lose more, by
JKR's branches (``elliptic_jkr``, energy) to within 2 % (L/L₀)^{5/3}/r, L₀ and r of the circle of the same area.
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .constrained_cells import ABSENT

#: Part of a cell that must be closed for it to belong to the core of a contact.
_CORE = 0.2

#: Power of the lengthening with which an adhesive ellipse's dL/dA grows.
_ROUNDING = 5.0 / 3.0

#: Variance of a coordinate over one cell.
_CELL = 1.0 / 12.0


class Contacts(NamedTuple):
    """The contacts of a set of cells: first those with a core, then what hangs together without one."""

    of: np.ndarray  # (cell,) contact of each cell
    cells: np.ndarray  # (contact,) sum of the closed parts
    radius: np.ndarray  # (contact,) 1 over dL/dA, cells; of one whole cell at least
    cores: int  # contacts with a core


@kernel
def contacts(closed, glued, count):
    """Tell contacts apart; ``closed`` (cell,) in [0, 1]."""
    of, found, cores = _separate(closed, glued, count)
    moments = np.zeros((found, 6))
    for k in range(count):
        x, y, part = float(glued.row[k]), float(glued.column[k]), closed[k]
        m = moments[of[k]]
        m[0] += part
        m[1] += part * x
        m[2] += part * y
        m[3] += part * x * x
        m[4] += part * y * y
        m[5] += part * x * y
    cells, radius = np.empty(found), np.empty(found)
    for c in range(found):
        cells[c] = moments[c, 0]
        radius[c] = np.sqrt(max(cells[c], 1.0) / np.pi) / lengthening(_axis_ratio(moments[c])) ** _ROUNDING
    return Contacts(of, cells, radius, cores)


@kernel
def _separate(closed, glued, count):
    """Return the contact of each cell, the number of contacts, and that of those with a core."""
    of, queue = np.full(count, -1), np.empty(count, np.int64)
    reached, found, cores = 0, 0, 0
    for least in (_CORE, -1.0):  # cores first, then what has none
        for seed in range(count):
            if of[seed] < 0 and closed[seed] >= least:
                of[seed], queue[reached] = found, seed
                reached, found = _spread(of, queue, reached, reached + 1, closed, least, glued), found + 1
        reached = _spread(of, queue, 0, reached, closed, -1.0, glued)
        cores = found if least == _CORE else cores
    return of, found, cores


@kernel
def _spread(of, queue, head, tail, closed, least, glued):
    """Let the cells of the queue take in their neighbours, these theirs, and so on; return the queue's end."""
    while head < tail:
        k = queue[head]
        head += 1
        for side in range(4):
            i = glued.row[k] + (side == 0) - (side == 1)
            j = glued.column[k] + (side == 2) - (side == 3)
            m = glued.place[i, j]
            if m != ABSENT and of[m] < 0 and closed[m] >= least:
                of[m], queue[tail], tail = of[k], m, tail + 1
    return tail


@kernel
def _axis_ratio(moments):
    """Return b/a of the ellipse with the moments of a contact."""
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
