"""A sphere that rolls off its asperities: the moment that resists while they detach one after the other.

The sphere turns as a rigid body about the foremost edge of its contact, a line square to the direction e of rolling:

    h = max sᵢ + rᵢ,    sᵢ = (xᵢ, yᵢ)·e,    rᵢ = √(a²(e·a)² + b²(e·b)²)    (support of the contact ellipse)

over all contacts that have not detached. A turn by dθ lifts asperity i by (h − sᵢ) dθ, and the moment about the edge is

    M(θ) = Σ −Pᵢ(δᵢ) (h − sᵢ) + L h,

where L is the load on the sphere's axis. A detached asperity does not touch again; the edge recedes with the contacts
that define it. The largest M along the way is the resisting moment. One JKR asperity gives max |P| a =
1.087872 P_c a_c; two, far apart compared with their contacts, the textbook's P_c times their distance.

The force at the edge is the reaction that closes the balance of forces; it acts at the foremost point of the contact,
the longest lever possible. Asperities ahead of the edge, onto which the sphere would roll, are left out.

A normal force F away from the surface, at the sphere's axis, reduces the resistance to the maximum over θ of
M(θ) − F h(θ). It is convex in F and lies above two of its tangents: at F = 0, with M and h at the largest moment, and
at F = max M/h, where it vanishes: this force alone tips the sphere. One JKR asperity gives P_c there.

x, y    vertices from the sphere's axis, nm;  ``delta`` their displacements at rest, nm
P, L    nN;  M  nN nm;  h, s, r  nm;  e = (cos φ, sin φ)
Source: own.
"""

import numpy as np

from ..jit import kernel
from .asperity_laws import asperity_contact, scales_of

#: Results in each direction: the largest moment, nN nm, and the edge's distance from the axis there, nm; the
#: largest M/h, nN (inf if the edge is never ahead of the axis), and the edge's distance there, nm.
MOMENT, HINGE, TIPPING_FORCE, TIPPING_HINGE = range(4)


@kernel
def resisting_moments(directions, x, y, orientation, delta, scales, load, spline):
    """Return (direction, 4), ``MOMENT`` … ``TIPPING_HINGE``, for each direction φ (rad); NaN without contact."""
    out = np.empty((directions.size, 4))
    for k in range(directions.size):
        c = np.cos(directions[k])
        s = np.sin(directions[k])
        along = x * c + y * s
        turned = orientation - directions[k]
        _turn(along, turned, delta.copy(), scales, load, spline, out[k])
    return out


@kernel
def _turn(along, turned, delta, scales, load, spline, out):  # noqa: C901
    """Turn the sphere until all asperities have detached; store the largest moment and the largest M/h on the way."""
    n = along.size
    way = delta - scales.end * scales.delta
    force = np.zeros(n)
    reach = np.zeros(n)
    out[MOMENT] = -np.inf
    out[HINGE] = np.nan
    out[TIPPING_FORCE] = -np.inf
    out[TIPPING_HINGE] = np.nan
    # largest number of steps; some 500 detach contacts a hundred times farther from the edge than they are wide
    for _ in range(100_000):
        h = _edge(along, turned, delta, scales, spline, force, reach)
        if h == -np.inf:
            break
        moment = load * h
        step = np.inf
        for i in range(n):  # a function of its own would take a twentieth longer
            if reach[i] >= 0.0:
                moment -= force[i] * (h - along[i])
                if h > along[i]:
                    # in a step an asperity moves by at most a hundredth of its way to the end of its branch
                    step = min(step, way[i] / (100 * (h - along[i])))
        if moment > out[MOMENT]:
            out[MOMENT] = moment
            out[HINGE] = h
        if h > 0.0 and moment / h > out[TIPPING_FORCE]:
            out[TIPPING_FORCE] = moment / h
            out[TIPPING_HINGE] = h
        if step == np.inf:
            break
        for i in range(n):
            delta[i] -= step * (h - along[i])
    if out[MOMENT] == -np.inf:
        out[:] = np.nan
    elif out[TIPPING_FORCE] == -np.inf:
        out[TIPPING_FORCE] = np.inf


@kernel
def _edge(along, turned, delta, scales, spline, force, reach):
    """Write each asperity's load and contact support r (−1 if detached); return the position of the edge."""
    h = -np.inf
    for i in range(along.size):
        reach[i] = -1.0
        end = scales.end[i] * scales.delta[i]
        # an asperity still adheres at the end of its branch. It counts as detached beyond this rounding error, in units
        # of its own scale, and has up to as far within the end the contact there: at the end itself rounding would
        # decide.
        rounding = 1e-9 * scales.delta[i]
        if delta[i] < end - rounding or np.isnan(delta[i]):
            continue
        contact = asperity_contact(max(delta[i], end + rounding), scales_of(scales, i), spline)
        force[i] = contact.P
        reach[i] = np.hypot(contact.a * np.cos(turned[i]), contact.b * np.sin(turned[i]))
        h = max(h, along[i] + reach[i])
    return h


@kernel
def total_force(delta, offset, scales, spline):
    """Return the force (nN) and contact area (nm²) of all asperities with the sphere at ``delta`` (nm)."""
    force = area = 0.0
    for i in range(offset.size):
        contact = asperity_contact(delta - offset[i], scales_of(scales, i), spline)
        force += contact.P
        area += np.pi * contact.a * contact.b
    return force, area


def resting_displacement(offset, scales, load, start, spline):
    """Return the displacement (nm) at which the sphere rests under ``load`` on unloading; NaN without contact."""
    if offset.size == 0:
        return np.nan
    unit = max(np.median(scales.delta), 1e-3)
    first = offset.min()
    high = max(start, first) + unit
    for _ in range(200):
        if total_force(high, offset, scales, spline)[0] > load:
            break
        high += unit
        unit *= 1.3
    step = (high - start) / 400 if high > start else unit
    low = high - step
    while total_force(low, offset, scales, spline)[0] > load:
        high = low
        low = low - step
        if high < first - 1e6:
            return np.nan
    for _ in range(80):
        middle = 0.5 * (low + high)
        if total_force(middle, offset, scales, spline)[0] > load:
            high = middle
        else:
            low = middle
    return high
