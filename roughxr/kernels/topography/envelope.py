"""The surface rebuilt from its asperities: the upper envelope of their paraboloids.

    height(x, y) = max over i of  z_i − (Â_i x̂² + B̂_i ŷ²)

(Cheng, Dunn & Brach, eq. 31, "by hiding the overlapping parts".) A paraboloid has no end, and that of a
nearly cylindrical asperity stays high over the whole scan, so none may be cut off by distance; yet nearly
all of them are hidden nearly everywhere. The envelope is therefore found by branch and bound: over a box of
pixels, the envelope is nowhere below the highest of the paraboloids' lowest points; whichever paraboloid
stays below that all over the box is hidden there, and is dropped. What is left goes on to the two halves of
the box, until a few pixels or a single paraboloid remain. The result is exact.

Letters: x, y pixel centres (nm); z height (nm); u, v position from an asperity's vertex (nm). With the axis
t of the flattest direction, a paraboloid is kept as

    depth(u, v) = (p·r)² + (q·r)²,   r = (u, v),   p = √Â (cos t, sin t),   q = √B̂ (−sin t, cos t)

(p, q in nm^-½), a sum of squares, which unlike a u² + b v² + c u v loses no digits far along a ridge.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import table
from ..jit import kernel

#: Boxes of no more pixels than this are drawn without further division.
_PIXELS_PER_BOX = 128


class Asperity(NamedTuple):
    """One paraboloid, as the eight numbers of a row: one line of cache."""

    x: float  # vertex, nm
    y: float
    z: float
    px: float  # nm^-½
    py: float
    qx: float
    qy: float
    reach2: float  # square of the largest distance from the vertex at which it is drawn, nm²


class Box(NamedTuple):
    """The pixels x[i0:i1], y[j0:j1]."""

    i0: int
    i1: int
    j0: int
    j1: int


@kernel
def _asperity(row):
    return Asperity(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7])


@kernel
def _depth(a, u, v):
    """Return the depth (nm) of the paraboloid below its vertex."""
    return (a.px * u + a.py * v) ** 2 + (a.qx * u + a.qy * v) ** 2


@kernel
def _clip(value, low, high):
    return min(max(value, low), high)


@kernel
def _least_depth(a, u0, u1, v0, v1):
    """Least depth (nm) over a rectangle: exact, hence never too great for a ridge that passes it obliquely.

    It lies on a side that faces the vertex. The line through the rectangle's point nearest in u holds the one
    such side, that nearest in v the other; along each, the least point is known and clipped to the rectangle.
    """
    coupling = a.px * a.py + a.qx * a.qy
    u, v = _clip(0.0, u0, u1), _clip(0.0, v0, v1)
    lowest_u = _clip(-v * coupling / (a.px**2 + a.qx**2), u0, u1)
    lowest_v = _clip(-u * coupling / (a.py**2 + a.qy**2), v0, v1)
    return min(_depth(a, u, lowest_v), _depth(a, lowest_u, v))


@kernel
def _greatest_depth(a, u0, u1, v0, v1):
    """Greatest depth (nm) over a rectangle: a convex function is greatest at a corner."""
    return max(max(_depth(a, u0, v0), _depth(a, u0, v1)), max(_depth(a, u1, v0), _depth(a, u1, v1)))


@kernel
def _bounds(a, x0, x1, y0, y1):
    """Return the lowest and highest height (nm) that the asperity lends the rectangle; −inf: out of reach."""
    u0, u1, v0, v1 = x0 - a.x, x1 - a.x, y0 - a.y, y1 - a.y
    nearest = _clip(0.0, u0, u1) ** 2 + _clip(0.0, v0, v1) ** 2
    farthest = max(-u0, u1) ** 2 + max(-v0, v1) ** 2
    lowest = a.z - _greatest_depth(a, u0, u1, v0, v1) if farthest <= a.reach2 else -np.inf
    highest = a.z - _least_depth(a, u0, u1, v0, v1) if nearest <= a.reach2 else -np.inf
    return lowest, max(lowest, highest)  # rounding may not drop the one that sets the floor


@kernel
def _visible(rows, candidates, x, y, box):
    """Return those of the candidates that may show within the box."""
    x0, x1, y0, y1 = x[box.i0], x[box.i1 - 1], y[box.j0], y[box.j1 - 1]
    highest = np.empty(candidates.size)
    floor = -np.inf
    for n in range(candidates.size):
        lowest, highest[n] = _bounds(_asperity(rows[candidates[n]]), x0, x1, y0, y1)
        floor = max(floor, lowest)
    return candidates[(highest >= floor) & (highest > -np.inf)]


@kernel
def _draw(a, x, y, box, out):
    """Raise ``out`` to the asperity, pixel by pixel."""
    y_box = y[box.j0 : box.j1]
    for i in range(box.i0, box.i1):
        u = x[i] - a.x
        row = out[i, box.j0 : box.j1]
        for j in range(row.size):
            v = y_box[j] - a.y
            height = a.z - _depth(a, u, v) if u**2 + v**2 <= a.reach2 else -np.inf
            row[j] = height if height > row[j] else row[j]


@kernel
def _halves(box):
    """Cut the box across its longer side."""
    i0, i1, j0, j1 = box
    if i1 - i0 >= j1 - j0:
        middle = (i0 + i1) // 2
        return Box(i0, middle, j0, j1), Box(middle, i1, j0, j1)
    middle = (j0 + j1) // 2
    return Box(i0, i1, j0, middle), Box(i0, i1, middle, j1)


@kernel
def _is_small(box):
    return (box.i1 - box.i0) * (box.j1 - box.j0) <= _PIXELS_PER_BOX


@kernel
def _fill(rows, x, y, out):
    """Draw box after box (a list, since numba compiles recursion anew in every process), or by halves of it."""
    todo = [(Box(0, x.size, 0, y.size), np.arange(len(rows)))]
    while len(todo) > 0:
        box, candidates = todo.pop()
        visible = _visible(rows, candidates, x, y, box)
        if visible.size <= 1 or _is_small(box):
            for n in visible:
                _draw(_asperity(rows[n]), x, y, box, out)
        else:
            for half in _halves(box):
                todo.append((half, visible))


@kernel
def upper_envelope(x, y, rows):
    """Return the heights (nm) at ascending pixel centres of the :func:`asperity_rows`, NaN where none reaches."""
    out = table(x.size, y.size, -np.inf)
    if out.size:
        _fill(rows, x, y, out)
    for i in range(x.size):  # NumPy's own ``where`` takes 2 s to compile
        for j in range(y.size):
            if not out[i, j] > -np.inf:
                out[i, j] = np.nan
    return out


def asperity_rows(x, y, height, curvature_min, curvature_max, orientation, *, reach=np.inf):
    """Return one row of :class:`Asperity` numbers for each asperity with a summit.

    Vertices ``x``, ``y``, ``height`` and ``reach`` (one, or one for each) in nm, curvatures in nm⁻¹, the
    ``orientation`` of the flattest direction in rad. Saddles (curvature_min <= 0) and failed fits (NaN) are
    left out: their paraboloids bound nothing.
    """
    along, across = np.cos(orientation), np.sin(orientation)
    with np.errstate(invalid="ignore"):
        p, q = np.sqrt(0.5 * curvature_min), np.sqrt(0.5 * curvature_max)
    columns = [x, y, height, p * along, p * across, -q * across, q * along, np.square(reach)]
    rows = np.stack(np.broadcast_arrays(*columns), axis=-1)
    return rows[(curvature_min > 0) & ~np.isnan(rows).any(axis=-1)]
