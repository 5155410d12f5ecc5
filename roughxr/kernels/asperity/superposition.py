"""Many asperities under one sphere: the sum of their own contacts, as if none knew of the others.

With the sphere's lowest point at δ below the datum, an asperity at distance r from the axis, its vertex at height Z,
is displaced by

    δᵢ = δ − (Z_max − Z + S₀(r))                                   (Cheng, Dunn & Brach, eq. 35, sign corrected)

and pushes or pulls by its own law. At a fixed sphere each asperity is under displacement control: its branch goes on
to its end, beyond the largest pull.

δ       ``deltas``, displacements of the sphere, ascending, nm;  Z_max ``datum``, nm
S₀      height of the sphere's profile over its lowest point, nm (``kernels.halfspace.separation``)
"""

from math import pi
from typing import NamedTuple

import numpy as np

from ..halfspace.separation import profile_height
from ..jit import kernel
from .force_curves import LENGTH, A, B, P, closed_contact, collapse, line_contact
from .laws import Scales, pick


class Field(NamedTuple):
    """The asperities of a scan, ready to be summed: each array has shape (asperity,)."""

    x: np.ndarray  # vertex, nm
    y: np.ndarray
    depth: np.ndarray  # Z_max − Z, nm
    spacing: np.ndarray  # distance to the next asperity, nm
    at_edge: np.ndarray  # the fitted patch is clipped by the scan's edge
    scales: Scales


#: What is summed per displacement.
FORCE, AREA, CONTACTS, BEYOND_PATCH, OVERLAPPING, TRUNCATED = range(6)


@kernel
def offsets(field, x, y, radius, profile):
    """Return how far (nm) the sphere at (x, y) must come down to reach each vertex."""
    out = np.empty(field.x.size)
    for i in range(out.size):
        u, v = field.x[i] - x, field.y[i] - y
        out[i] = field.depth[i] + profile_height(u * u + v * v, radius, profile)
    return out


@kernel
def superpose(deltas, field, offset, patch_radius, branch):
    """Return (6, delta): force nN, area nm², and the counts of ``CONTACTS`` … ``TRUNCATED``."""
    out, lines = np.zeros((6, deltas.size)), np.empty((LENGTH, 3))
    for i in range(offset.size):
        if deltas[-1] - offset[i] >= field.scales.end[i] * field.scales.delta[i]:
            _add(deltas, field, i, offset[i], patch_radius, branch, lines, out)
    for row in range(CONTACTS, TRUNCATED + 1):  # what began somewhere goes on from there
        for k in range(1, deltas.size):
            out[row, k] += out[row, k - 1]
    return out


@kernel(inner=True)
def _add(deltas, field, i, offset, patch_radius, branch, lines, out):
    """Add one asperity's contact at every displacement that reaches it; ``lines`` is room for its branch.

    Since it grows with the displacement, its flags are counted at the first displacement that raises them. The loop
    takes scalars from laws of closed form: an array handed to a function costs Numba as much as the law itself.
    """
    scales, force, area, n = pick(field.scales, i), out[FORCE], out[AREA], deltas.size
    adheres = scales.end < 0.0
    first = np.searchsorted(deltas, offset + scales.end * scales.delta)
    while not adheres and first < n and deltas[first] <= offset:  # a touch without area is none
        first += 1
    tabulated = adheres and branch.size > 0
    if tabulated:
        for column in (P, A, B):
            collapse(branch, scales.row, column, lines[:, column])
    beyond = overlapping = n
    per_nm, ellipse = 1.0 / scales.delta, pi * scales.axis_ratio * scales.a * scales.a
    for k in range(first, n):
        delta = max((deltas[k] - offset) * per_nm, scales.end)
        p, a, b = line_contact(lines, delta - scales.end) if tabulated else closed_contact(delta, adheres)
        force[k] += scales.P * p
        area[k] += ellipse * a * b
        if beyond == n and scales.a * a > patch_radius:
            beyond = k
        if overlapping == n and scales.a * a > field.spacing[i]:
            overlapping = k
    for row, begins, what in (
        (CONTACTS, first, 1.0),
        (TRUNCATED, first, field.at_edge[i]),
        (BEYOND_PATCH, beyond, 1.0),
        (OVERLAPPING, overlapping, 1.0),
    ):
        if begins < n:
            out[row, begins] += what
