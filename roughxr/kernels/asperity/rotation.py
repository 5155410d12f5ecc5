"""A sphere that is rolled off its asperities: the moment they hold while they let go one after the other.

The sphere turns as a rigid body about the foremost edge of its contact, a line square to the direction e of rolling:

    h = max sᵢ + rᵢ,    sᵢ = (xᵢ, yᵢ)·e,    rᵢ = √(a²(e·a)² + b²(e·b)²)    (support of the contact ellipse)

over all contacts that are still held. A turn by dθ lifts asperity i by (h − sᵢ) dθ, and the moment about the edge is

    M(θ) = Σ −Pᵢ(δᵢ) (h − sᵢ) + L h,

L being the load on the sphere's axis. An asperity whose branch has ended is gone for good; the edge draws back with
the contacts that make it. The largest M on the way is what the place resists. One JKR asperity gives max |P| a =
1.087872 P_c a_c; two, far apart beside their contacts, the textbook's P_c times their distance.

The force at the edge is the reaction that closes the balance of forces; it acts at the foremost point of the contact,
the longest lever that the contact allows. Asperities ahead of the edge that the sphere comes down on are left out.

A pull F at the sphere's axis takes F h from what is held: max over θ of M(θ) − F h(θ) is left. That is convex in F and
lies above two of its tangents: the one at F = 0, M and h at the largest moment, and the one where nothing is left,
F = max M/h, the pull at the axis that tips the sphere by itself. One JKR asperity gives P_c there.

x, y    vertices from the sphere's axis, nm;  ``delta`` their displacements at rest, nm
P, L    nN;  M  nN nm;  h, s, r  nm;  e = (cos φ, sin φ)
Source: own.
"""

import numpy as np

from ..jit import kernel
from .laws import asperity_contact, pick

#: Parts of its own way to the end of its branch by which an asperity moves in one step, at most.
_STEPS = 100

#: Steps at most; some 500 bring contacts a hundred times as far from the edge as wide to their end.
_MOST = 100_000

#: What is found in each direction: the largest moment, nN nm, and the edge's distance from the axis there, nm; the
#: largest M/h, nN, inf where the edge is never ahead of the axis, and the edge's distance there, nm.
MOMENT, HINGE, PULL, PULL_HINGE = range(4)


@kernel
def resisting_moments(directions, x, y, orientation, delta, scales, load, spline):
    """Return (direction, 4), ``MOMENT`` … ``PULL_HINGE``, for each direction φ (rad); NaN without contact."""
    out = np.empty((directions.size, 4))
    for k in range(directions.size):
        c, s = np.cos(directions[k]), np.sin(directions[k])
        along = x * c + y * s
        turned = orientation - directions[k]
        _turn(along, turned, delta.copy(), scales, load, spline, out[k])
    return out


@kernel
def _turn(along, turned, delta, scales, load, spline, out):
    """Turn the sphere until all have let go, and keep the largest moment and the largest M/h on the way."""
    n = along.size
    force, reach, way = np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        way[i] = delta[i] - scales.end[i] * scales.delta[i]
    out[MOMENT], out[HINGE], out[PULL], out[PULL_HINGE] = -np.inf, np.nan, -np.inf, np.nan
    for _ in range(_MOST):
        h = _edge(along, turned, delta, scales, spline, force, reach)
        if h == -np.inf:
            break
        moment, step = load * h, np.inf
        for i in range(n):
            if reach[i] >= 0.0:
                moment -= force[i] * (h - along[i])
                if h > along[i]:
                    step = min(step, way[i] / (_STEPS * (h - along[i])))
        if moment > out[MOMENT]:
            out[MOMENT], out[HINGE] = moment, h
        if h > 0.0 and moment / h > out[PULL]:
            out[PULL], out[PULL_HINGE] = moment / h, h
        if step == np.inf:
            break
        for i in range(n):
            delta[i] -= step * (h - along[i])
    if out[MOMENT] == -np.inf:
        out[:] = np.nan
    elif out[PULL] == -np.inf:
        out[PULL] = np.inf


@kernel
def _edge(along, turned, delta, scales, spline, force, reach):
    """Fill in each asperity's load and how far it reaches ahead, −1 if it has let go; return the foremost edge."""
    h = -np.inf
    for i in range(along.size):
        reach[i] = -1.0
        if delta[i] < scales.end[i] * scales.delta[i] or np.isnan(delta[i]):
            continue
        contact = asperity_contact(delta[i], pick(scales, i), spline)
        force[i] = contact.P
        reach[i] = np.hypot(contact.a * np.cos(turned[i]), contact.b * np.sin(turned[i]))
        h = max(h, along[i] + reach[i])
    return h


@kernel
def total_force(delta, offset, scales, spline):
    """Return the force (nN) and contact area (nm²) of all asperities with the sphere at ``delta`` (nm)."""
    force = area = 0.0
    for i in range(offset.size):
        contact = asperity_contact(delta - offset[i], pick(scales, i), spline)
        force += contact.P
        area += np.pi * contact.a * contact.b
    return force, area


@kernel
def rest(offset, scales, load, start, spline):
    """Return the displacement (nm) at which the sphere rests under ``load`` as it comes back from being pressed.

    NaN where no asperity can be touched. From a displacement that carries more than the load it is raised by steps,
    up to the first at which it carries less, and the crossing is halved.
    """
    if offset.size == 0:
        return np.nan
    unit = max(np.median(scales.delta), 1e-3)
    high = max(start, offset.min()) + unit
    for _ in range(200):
        if total_force(high, offset, scales, spline)[0] > load:
            break
        high += unit
        unit *= 1.3
    step = (high - start) / 400 if high > start else unit
    low = high - step
    while total_force(low, offset, scales, spline)[0] > load:
        high, low = low, low - step
        if high < offset.min() - 1e6:
            return np.nan
    for _ in range(80):
        middle = 0.5 * (low + high)
        if total_force(middle, offset, scales, spline)[0] > load:
            high = middle
        else:
            low = middle
    return high
