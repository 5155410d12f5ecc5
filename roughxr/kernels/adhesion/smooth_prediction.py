"""Where two states of a path point to."""

from ..jit import kernel
from .smooth_laws import traction


@kernel
def ahead(state, before, ratio, law):
    """Move ``state`` on by ``ratio`` of what it has changed by since ``before``.

    Pressures follow where cells touch in both, gaps where they do not; a gap that would close attracts as where it is
    closed.
    """
    most = traction(0.0, law)[0]
    for i in range(state.gap.shape[0]):
        for j in range(state.gap.shape[1]):
            gap, other = state.gap[i, j], before.gap[i, j]
            if not (gap < law.range and other < law.range):
                continue
            if not state.touching[i, j]:
                state.gap[i, j] = max(gap + ratio * (gap - other), 0.0)
                state.pressure[i, j] = -traction(state.gap[i, j], law)[0]
            elif before.touching[i, j]:
                moved = state.pressure[i, j] + ratio * (state.pressure[i, j] - before.pressure[i, j])
                state.pressure[i, j] = max(moved, -most)
