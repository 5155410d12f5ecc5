"""Many asperities under one sphere: the sum of their own contacts, as if none knew of the others.

With the sphere's lowest point at δ below the datum, an asperity at distance r from the axis, its vertex at height Z,
is displaced by

    δᵢ = δ − (Z_max − Z + S₀(r))                                   (Cheng, Dunn & Brach, eq. 35, sign corrected)

and pushes or pulls by its own law. At a fixed sphere each asperity is under displacement control: its branch goes on
to its end, beyond the largest pull.

δ       ``deltas``, displacements of the sphere, ascending, nm;  Z_max ``datum``, nm
S₀      height of the sphere's profile over its lowest point, nm (``kernels.indenter``)
"""

from typing import NamedTuple

import numpy as np

from .asperity_contact import Contact, Scales, asperity_contact, pick
from .branches import LENGTH, A, B, P, collapse, line_contact
from .indenter import profile_height
from .jit import kernel


class Field(NamedTuple):
    """The asperities of a scan, ready to be summed: each array has shape (asperity,)."""

    x: np.ndarray  # vertex, nm
    y: np.ndarray
    depth: np.ndarray  # Z_max − Z, nm
    spacing: np.ndarray  # distance to the next asperity, nm
    at_edge: np.ndarray  # the fitted patch is clipped by the scan's edge
    scales: Scales


#: Displacements from which on it is quicker to sum an asperity's splines across once than at each.
_WORTH_COLLAPSING = 12

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
    out, lines = np.zeros((6, deltas.size)), np.empty((3, LENGTH))
    for i in range(offset.size):
        if deltas[-1] - offset[i] >= field.scales.end[i] * field.scales.delta[i]:
            _add(deltas, field, i, offset[i], patch_radius, branch, lines, out)
    return out


@kernel
def _add(deltas, field, i, offset, patch_radius, branch, lines, out):
    """Add one asperity's contact at every displacement that reaches it; ``lines`` is room for its branch."""
    scales = pick(field.scales, i)
    first = np.searchsorted(deltas, offset + scales.end * scales.delta)
    collapsed = branch.size > 0 and scales.end < 0.0 and deltas.size - first >= _WORTH_COLLAPSING
    if collapsed:
        for column in (P, A, B):
            collapse(branch, scales.row, column, lines[column])
    for k in range(first, deltas.size):
        delta = deltas[k] - offset
        contact = _read(delta, scales, lines) if collapsed else asperity_contact(delta, scales, branch)
        if contact.a != 0.0:  # where contact shrinks to a point a table may fall short of zero
            out[FORCE, k] += contact.P
            out[AREA, k] += np.pi * contact.a * contact.b
            out[CONTACTS, k] += 1.0
            out[BEYOND_PATCH, k] += contact.a > patch_radius
            out[OVERLAPPING, k] += contact.a > field.spacing[i]
            out[TRUNCATED, k] += field.at_edge[i]


@kernel
def _read(delta, scales, lines):
    """Return one asperity's contact on its own branch."""
    above_end = delta / scales.delta - scales.end
    if above_end < 0.0:
        return Contact(0.0, 0.0, 0.0)
    p, a, b = line_contact(lines, above_end)
    return Contact(scales.P * p, scales.a * a, scales.a * scales.axis_ratio * b)
