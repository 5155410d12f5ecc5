"""Extrapolation of a path from its last two states."""

from ..jit import kernel
from .traction_laws import traction


@kernel
def ahead(state, before, ratio, law):
    """Change ``state`` by ``ratio`` times its change since ``before``.

    Pressures are extrapolated where cells touch in both states, gaps where they do not; where a gap would close, the
    attraction is that in contact.
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
