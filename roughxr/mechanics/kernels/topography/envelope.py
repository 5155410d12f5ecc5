"""The surface rebuilt from its asperities: the upper envelope of their paraboloids.

    height(x, y) = max over i of  z_i − (Â_i x̂² + B̂_i ŷ²)

(Cheng, Dunn & Brach, eq. 31, "by hiding the overlapping parts".) A paraboloid extends without end, and that of a
nearly cylindrical asperity stays high over the whole scan, so none may be cut off by distance; yet nearly
all of them are hidden nearly everywhere. The envelope is therefore computed by branch and bound. Over a box of
pixels it is nowhere below the highest of the paraboloids' lowest points; a paraboloid below that level all over the
box is hidden there, and is dropped. The box is halved with the rest, until a few pixels or a single paraboloid remain.
The result is exact.

Letters: x, y pixel centres (nm); z height (nm); u, v position from an asperity's vertex (nm). With the axis
t of the flattest direction, the depth of a paraboloid below its vertex is

    depth(u, v) = (p·r)² + (q·r)²,   r = (u, v),   p = √Â (cos t, sin t),   q = √B̂ (−sin t, cos t)

(p, q in nm^-½), a sum of squares, which unlike a u² + b v² + c u v loses no digits far along a ridge.
"""

import numpy as np

from ..jit import kernel


def upper_envelope(x, y, rows):
    """Return the heights (nm) at ascending pixel centres of the :func:`asperity_rows`."""
    out = np.full((x.size, y.size), -np.inf)
    boxes = [(0, x.size, 0, y.size, rows)] if out.size else []
    while boxes:
        i0, i1, j0, j1, candidates = boxes.pop()
        visible = candidates[_are_visible(candidates, x[i0], x[i1 - 1], y[j0], y[j1 - 1])]
        # boxes of no more pixels than this are drawn without further division
        if len(visible) <= 1 or (i1 - i0) * (j1 - j0) <= 256:
            _draw(visible, x, y, i0, i1, j0, j1, out)
        elif i1 - i0 >= j1 - j0:
            middle = (i0 + i1) // 2
            boxes += [(i0, middle, j0, j1, visible), (middle, i1, j0, j1, visible)]
        else:
            middle = (j0 + j1) // 2
            boxes += [(i0, i1, j0, middle, visible), (i0, i1, middle, j1, visible)]
    return np.where(out > -np.inf, out, np.nan)


def asperity_rows(x, y, height, curvature_min, curvature_max, orientation):
    """Return one row (x, y, z, p, q) of seven numbers for each asperity with a summit.

    Vertices ``x``, ``y`` and ``height`` in nm, curvatures in nm⁻¹, the ``orientation`` of the flattest direction in
    rad. Saddles (curvature_min <= 0) and failed fits (NaN) are left out: their paraboloids have no summit.
    """
    along = np.cos(orientation)
    across = np.sin(orientation)
    with np.errstate(invalid="ignore"):
        p = np.sqrt(0.5 * curvature_min)
        q = np.sqrt(0.5 * curvature_max)
    columns = [x, y, height, p * along, p * across, -q * across, q * along]
    rows = np.stack(np.broadcast_arrays(*columns), axis=-1)
    return rows[(curvature_min > 0) & ~np.isnan(rows).any(axis=-1)]


@kernel
def _depth(row, u, v):
    return (row[3] * u + row[4] * v) ** 2 + (row[5] * u + row[6] * v) ** 2


@kernel
def _draw(rows, x, y, i0, i1, j0, j1, out):
    """Raise the pixels of a box to the asperities."""
    for n in range(len(rows)):
        row = rows[n]
        for i in range(i0, i1):
            for j in range(j0, j1):
                out[i, j] = max(out[i, j], row[2] - _depth(row, x[i] - row[0], y[j] - row[1]))


@kernel
def _are_visible(rows, x0, x1, y0, y1):
    """Return which of the asperities may show over a rectangle.

    The least depth lies on a side that faces the vertex. The line through the rectangle's point nearest in u contains
    one such side, that nearest in v the other; along each, the least point is known and clipped to the rectangle. The
    greatest depth is at a corner.
    """
    highest = np.empty(len(rows))
    floor = -np.inf
    for n in range(len(rows)):
        row = rows[n]
        u0 = x0 - row[0]
        u1 = x1 - row[0]
        v0 = y0 - row[1]
        v1 = y1 - row[1]
        u = min(max(0.0, u0), u1)
        v = min(max(0.0, v0), v1)
        coupling = row[3] * row[4] + row[5] * row[6]
        lowest_u = min(max(-v * coupling / (row[3] ** 2 + row[5] ** 2), u0), u1)
        lowest_v = min(max(-u * coupling / (row[4] ** 2 + row[6] ** 2), v0), v1)
        least = min(_depth(row, u, lowest_v), _depth(row, lowest_u, v))
        greatest = max(_depth(row, u0, v0), _depth(row, u0, v1), _depth(row, u1, v0), _depth(row, u1, v1))
        low = row[2] - greatest
        highest[n] = max(low, row[2] - least)  # rounding may not drop the asperity that sets the floor
        floor = max(floor, low)
    return highest >= floor
