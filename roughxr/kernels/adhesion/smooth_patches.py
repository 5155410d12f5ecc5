"""Which cells belong to which contact, and how well the mesh shows it."""

import numpy as np

from ..jit import kernel
from .smooth_laws import remaining_work

#: Cells that attract with more than this part of the largest traction belong to the contact that reaches them first.
_ATTRACTS = 0.02

#: Contacts with a smaller part of the whole tension than this do not count for the resolution.
_SHARE = 0.1


@kernel
def contacts_and_resolution(state, law):
    """Return how many contacts there are, and the radius in cells of the smallest that bears enough of the tension.

    Cells that touch and share a side are one contact. A contact's size counts each cell by the part of the work of
    separation that is left to do there. NaN where nothing attracts.
    """
    nx, ny = state.gap.shape
    of, queue, tail, found, cores = np.full((nx, ny), -1), np.empty((nx * ny, 2), np.int64), 0, 0, 0
    for core in (True, False):
        head = tail
        for i in range(nx):
            for j in range(ny):
                if of[i, j] < 0 and _belongs(i, j, core, state, law):
                    of[i, j], queue[tail] = found, (i, j)
                    head, tail = _spread(of, queue, tail, tail + 1, core, state, law)
                    found += 1
        if core:
            cores = found
            head, tail = _spread(of, queue, 0, tail, False, state, law)
    return cores, _smallest(of, queue[:tail], found, state, law)


@kernel
def _belongs(i, j, core, state, law):
    return state.touching[i, j] if core else state.touching[i, j] or state.pressure[i, j] < -_ATTRACTS * law.strength


@kernel
def _spread(of, queue, head, tail, core, state, law):
    """Let the cells of the queue take in their neighbours, these theirs, and so on; return the queue's ends."""
    while head < tail:
        a, b = queue[head]
        head += 1
        for side in range(4):
            i, j = a + (side == 0) - (side == 1), b + (side == 2) - (side == 3)
            if 0 <= i < of.shape[0] and 0 <= j < of.shape[1] and of[i, j] < 0 and _belongs(i, j, core, state, law):
                of[i, j], queue[tail], tail = of[a, b], (i, j), tail + 1
    return head, tail


@kernel
def _smallest(of, cells, found, state, law):
    size, tension, total = np.zeros(found), np.zeros(found), 0.0
    for i, j in cells:
        pull = max(-state.pressure[i, j], 0.0)
        tension[of[i, j]] += pull
        size[of[i, j]] += remaining_work(max(state.gap[i, j], 0.0), law) / (law.work - law.cut)
        total += pull
    least = np.inf
    for k in range(found):
        if tension[k] >= _SHARE * total:
            least = min(least, np.sqrt(size[k] / np.pi))
    return least if found > 0 else np.nan
