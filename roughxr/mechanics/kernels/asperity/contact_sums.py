"""Many asperities under one sphere: the sum of their contacts, each independent of the others.

With the sphere's lowest point at δ below the datum, an asperity at distance r from the axis, its vertex at height Z,
is displaced by

    δᵢ = δ − (Z_max − Z + S₀(r))                                   (Cheng, Dunn & Brach, eq. 35, sign corrected)

and its force follows its own law. At a fixed sphere each asperity is under displacement control: its branch continues
to its end, beyond the largest tension. So the sum is that of retraction; on approach an asperity without range jumps
into contact at δᵢ = 0.

Two contacts overlap if the radii of their ellipses along the line between their centres add up to more than its
length: then the sum counts some area twice. Ellipses that overlap only away from that line are not counted, so that
the count is a lower bound.

δ       ``deltas``, displacements of the sphere, ascending, nm;  Z_max ``datum``, nm
S₀      height of the sphere's profile over its lowest point, nm (``kernels.halfspace.separation``)
"""

from math import pi
from typing import NamedTuple

import numpy as np

from ..halfspace.separation import sphere_height
from ..jit import kernel
from .asperity_laws import Scales, asperity_contact, scales_of
from .branches import LENGTH, A, B, P, closed_contact, collapse, line_contact


class Field(NamedTuple):
    """The asperities of a scan, ready to be summed: each array has shape (asperity,)."""

    x: np.ndarray  # vertex, nm
    y: np.ndarray
    depth: np.ndarray  # Z_max − Z, nm
    orientation: np.ndarray  # of the longer semi-axis, from x towards y, rad
    at_edge: np.ndarray  # the fitted patch is clipped by the scan's edge
    neighbour: np.ndarray  # (asperity, NEIGHBOURS) the nearest others; −1 where there are no more
    scales: Scales


#: Number of nearest asperities compared for overlap: farther asperities lie behind these.
NEIGHBOURS = 8

#: Rows of the sums for each displacement.
FORCE, AREA, CONTACTS, BEYOND_PATCH, OVERLAPPING, TRUNCATED = range(6)


@kernel
def offsets(field, x, y, radius):
    """Return the displacement (nm) at which the sphere at (x, y) reaches each vertex."""
    out = np.empty(field.x.size)
    for i in range(out.size):
        u = field.x[i] - x
        v = field.y[i] - y
        out[i] = field.depth[i] + sphere_height(u * u + v * v, radius)
    return out


@kernel
def superpose(deltas, field, offset, patch_radius, branch):
    """Return (6, delta): force nN, area nm², and the counts of ``CONTACTS`` … ``TRUNCATED``."""
    out = np.zeros((6, deltas.size))
    lines = np.empty((3, LENGTH))
    for i in range(offset.size):
        if deltas[-1] - offset[i] >= field.scales.end[i] * field.scales.delta[i]:
            _add(deltas, field, i, offset[i], patch_radius, branch, lines, out)
            begins = _first_overlap(deltas, field, i, offset, branch)
            if begins < deltas.size:
                out[OVERLAPPING, begins] += 1.0
    for row in range(CONTACTS, TRUNCATED + 1):  # contacts persist at larger displacements
        for k in range(1, deltas.size):
            out[row, k] += out[row, k - 1]
    return out


@kernel
def _add(deltas, field, i, offset, patch_radius, branch, lines, out):
    """Add an asperity's contact at every displacement that reaches it; ``lines`` is work space for its branch.

    Flags are counted at their first displacement, since contacts grow. Laws of closed form take scalars: passing an
    array to a function costs as much as the law itself.
    """
    scales = scales_of(field.scales, i)
    force = out[FORCE]
    area = out[AREA]
    n = deltas.size
    first = 0
    adheres = scales.end < 0.0
    begins = offset + scales.end * scales.delta
    while first < n and (deltas[first] < begins or (not adheres and deltas[first] == offset)):
        first += 1  # contacts without area do not count
    tabulated = adheres and branch.size > 0
    if tabulated:
        for column in (P, A, B):
            collapse(branch, scales.row, column, lines[column])
    beyond = n
    per_nm = 1.0 / scales.delta
    ellipse = pi * scales.axis_ratio * scales.a * scales.a
    for k in range(first, n):
        delta = max((deltas[k] - offset) * per_nm, scales.end)
        p, a, b = line_contact(lines, delta - scales.end) if tabulated else closed_contact(delta, scales.end)
        force[k] += scales.P * p
        area[k] += ellipse * a * b
        if beyond == n and scales.a * a > patch_radius:
            beyond = k
    for row, begins, what in (
        (CONTACTS, first, 1.0),
        (TRUNCATED, first, field.at_edge[i]),
        (BEYOND_PATCH, beyond, 1.0),
    ):
        if begins < n:
            out[row, begins] += what


@kernel
def _contact_radius(delta, field, i, x, y, branch):
    """Return the radius (nm) of the contact of asperity i at ``delta`` along the unit vector (x, y)."""
    contact = asperity_contact(delta, scales_of(field.scales, i), branch)
    if not contact.b > 0.0:
        return 0.0
    c = np.cos(field.orientation[i])
    s = np.sin(field.orientation[i])
    along = c * x + s * y
    across = c * y - s * x
    return contact.a * contact.b / np.hypot(contact.b * along, contact.a * across)


@kernel
def _overlaps(delta, field, i, j, offset, branch):
    """Return whether the contacts of two asperities overlap with the sphere at ``delta``."""
    x = field.x[j] - field.x[i]
    y = field.y[j] - field.y[i]
    distance = np.hypot(x, y)
    x = x / distance
    y = y / distance
    mine = _contact_radius(delta - offset[i], field, i, x, y, branch)
    other = _contact_radius(delta - offset[j], field, j, x, y, branch)
    return mine > 0.0 and other > 0.0 and mine + other > distance


@kernel
def _first_overlap(deltas, field, i, offset, branch):
    """Return the index of the first displacement at which asperity i overlaps a neighbour."""
    first = deltas.size
    for j in field.neighbour[i]:
        if j < 0 or not _overlaps(deltas[first - 1], field, i, j, offset, branch):
            continue
        low = -1
        first = first - 1
        while first - low > 1:
            middle = (low + first) // 2
            if _overlaps(deltas[middle], field, i, j, offset, branch):
                first = middle
            else:
                low = middle
        if first == 0:
            break
    return first
