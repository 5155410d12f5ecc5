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

from .asperity_contact import Scales, asperity_contact, pick
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
    out = np.zeros((6, deltas.size))
    for i in range(offset.size):
        if deltas[-1] - offset[i] >= field.scales.end[i] * field.scales.delta[i]:
            _add(deltas, field, i, offset[i], patch_radius, branch, out)
    return out


@kernel
def _add(deltas, field, i, offset, patch_radius, branch, out):
    """Add one asperity's contact at every displacement that reaches it."""
    scales = pick(field.scales, i)
    first = np.searchsorted(deltas, offset + scales.end * scales.delta)
    for k in range(first, deltas.size):
        contact = asperity_contact(deltas[k] - offset, scales, branch)
        if contact.a > 0.0:
            out[FORCE, k] += contact.P
            out[AREA, k] += np.pi * contact.a * contact.b
            out[CONTACTS, k] += 1.0
            out[BEYOND_PATCH, k] += contact.a > patch_radius
            out[OVERLAPPING, k] += contact.a > field.spacing[i]
            out[TRUNCATED, k] += field.at_edge[i]
