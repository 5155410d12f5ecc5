"""The surface rebuilt from its asperities: the upper envelope of their paraboloids.

    height(x, y) = max over i of  z_i − (Â_i x̂² + B̂_i ŷ²)

(Cheng, Dunn & Brach, eq. 31, "by hiding the overlapping parts".) A paraboloid has no end, and that of a
nearly cylindrical asperity stays high over the whole scan, so none may be cut off by distance; yet nearly
all of them are hidden nearly everywhere. The envelope is therefore computed by branch and bound: over a box of
pixels, the envelope is nowhere below the highest of the paraboloids' lowest points; whichever paraboloid
stays below that all over the box is hidden there, and is dropped. What is left goes on to the two halves of
the box, until a few pixels or a single paraboloid remain. The result is exact.

Letters: x, y pixel centres (nm); z height (nm); u, v position from an asperity's vertex (nm). With the axis
t of the flattest direction, the depth of a paraboloid below its vertex is

    depth(u, v) = (p·r)² + (q·r)²,   r = (u, v),   p = √Â (cos t, sin t),   q = √B̂ (−sin t, cos t)

(p, q in nm^-½), a sum of squares, which unlike a u² + b v² + c u v loses no digits far along a ridge.
"""

import numpy as np

#: Boxes of no more pixels than this are drawn without further division.
_PIXELS_PER_BOX = 512

#: Paraboloids that are drawn at a time.
_ROWS_AT_A_TIME = 1024


def upper_envelope(x, y, rows):
    """Return the heights (nm) at ascending pixel centres of the :func:`asperity_rows`, NaN where none reaches."""
    out = np.full((x.size, y.size), -np.inf)
    boxes = [(slice(0, x.size), slice(0, y.size), rows)] if out.size else []
    while boxes:
        i, j, candidates = boxes.pop()
        visible = _visible(candidates, (x[i][0], x[i][-1]), (y[j][0], y[j][-1]))
        nx, ny = x[i].size, y[j].size
        if len(visible) <= 1 or nx * ny <= _PIXELS_PER_BOX:
            for first in range(0, len(visible), _ROWS_AT_A_TIME):
                heights = _heights(visible[first : first + _ROWS_AT_A_TIME], x[i], y[j])
                np.maximum(out[i, j], heights.max(axis=0), out=out[i, j])
        elif nx >= ny:
            middle = (i.start + i.stop) // 2
            boxes += [(slice(i.start, middle), j, visible), (slice(middle, i.stop), j, visible)]
        else:
            middle = (j.start + j.stop) // 2
            boxes += [(i, slice(j.start, middle), visible), (i, slice(middle, j.stop), visible)]
    return np.where(out > -np.inf, out, np.nan)


def asperity_rows(x, y, height, curvature_min, curvature_max, orientation, *, reach=np.inf):
    """Return one row (x, y, z, p, q, reach²) of eight numbers for each asperity with a summit.

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


def _heights(rows, x, y):
    """Return the heights (asperity, x, y), nm, −inf beyond reach."""
    vertex_x, vertex_y, z, px, py, qx, qy, reach2 = rows.T[:, :, None, None]
    u, v = x[:, None] - vertex_x, y - vertex_y
    heights = z - ((px * u + py * v) ** 2 + (qx * u + qy * v) ** 2)
    return heights if np.isinf(reach2).all() else np.where(u**2 + v**2 <= reach2, heights, -np.inf)


def _visible(rows, x, y):
    """Return those of the asperities that may show over a rectangle, x and y from end to end.

    The least depth lies on a side that faces the vertex. The line through the rectangle's point nearest in u holds the
    one such side, that nearest in v the other; along each, the least point is known and clipped to the rectangle. The
    greatest depth is at a corner.
    """
    vertex_x, vertex_y, z, px, py, qx, qy, reach2 = rows.T
    (u0, u1), (v0, v1) = (x[0] - vertex_x, x[1] - vertex_x), (y[0] - vertex_y, y[1] - vertex_y)

    def depth(u, v):
        return (px * u + py * v) ** 2 + (qx * u + qy * v) ** 2

    u, v, coupling = np.clip(0.0, u0, u1), np.clip(0.0, v0, v1), px * py + qx * qy
    lowest_u = np.clip(-v * coupling / (px**2 + qx**2), u0, u1)
    lowest_v = np.clip(-u * coupling / (py**2 + qy**2), v0, v1)
    least = np.minimum(depth(u, lowest_v), depth(lowest_u, v))
    greatest = np.max([depth(corner_u, corner_v) for corner_u in (u0, u1) for corner_v in (v0, v1)], axis=0)
    farthest2 = np.maximum(-u0, u1) ** 2 + np.maximum(-v0, v1) ** 2
    low = np.where(farthest2 <= reach2, z - greatest, -np.inf)
    high = np.where(u**2 + v**2 <= reach2, z - least, -np.inf)
    high = np.maximum(low, high)  # rounding may not drop the asperity that sets the floor
    return rows[(high >= np.max(low, initial=-np.inf)) & (high > -np.inf)]
