"""The heights at which a sphere touches a scan (the scan's dilation by the sphere), and the patches that it touches.

    Z(x, y) = max over u, v of  h(u, v) − S(x − u, y − v),   S(r) = R − √(R² − r²)

Z is the height of the sphere's lowest point, (u, v) the contact point. Between pixels h is the paraboloid through a
pixel and its eight neighbours, within half a pixel of that pixel. So Z has no dimples between pixels, and a summit
narrower than a few pixels keeps its height.

The cost is linear in the number of pixels for two reasons. A pixel that lies below the sphere's curve through two
opposite neighbours is never touched. Of the remaining ones, nearly all stay below the highest over a box of positions;
boxes are halved until few are left, as in `envelope`. The result is exact.

Letters: x, y pixel centres (nm); h, Z heights (nm); R radius (nm); u, v position from a pixel's centre (nm).
"""

from typing import NamedTuple

import numpy as np

from ..halfspace.separation import sphere_height
from ..jit import kernel

#: Side of a box that is not divided further, pixels.
SIDE = 4

#: Columns of a patch: position, height, slopes, second derivatives (nm⁻¹), and its largest rise over its pixel (nm).
X, Y, H, GX, GY, HXX, HYY, HXY, RISE = range(9)


class Ball(NamedTuple):
    """The sphere, and half a pixel along each axis (nm)."""

    radius: float
    half_x: float
    half_y: float


@kernel
def _is_summit(z, i, j, pixel, bend):
    """Return whether no two neighbours on opposite sides hide a pixel; ``bend`` is the sphere's largest curvature."""
    nx, ny = z.shape
    for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
        if 0 <= i - di and i + di < nx and 0 <= j - abs(dj) and j + abs(dj) < ny:
            second = z[i + di, j + dj] + z[i - di, j - dj] - 2 * z[i, j]
            if second > ((di * pixel[0]) ** 2 + (dj * pixel[1]) ** 2) * bend:
                return False
    return True


@kernel
def put_patch(out, z, i, j, pixel, radius):
    """Write the paraboloid through a pixel and its neighbours; at the border a level plane."""
    nx, ny = z.shape
    centre = z[i, j]
    out[H] = centre
    out[GX:] = 0.0
    if not (0 < i < nx - 1 and 0 < j < ny - 1):
        return
    dx, dy = pixel
    before_x = z[i - 1, j]
    beyond_x = z[i + 1, j]
    before_y = z[i, j - 1]
    beyond_y = z[i, j + 1]
    out[GX] = (beyond_x - before_x) / (2 * dx)
    out[GY] = (beyond_y - before_y) / (2 * dy)
    out[HXX] = (beyond_x + before_x - 2 * centre) / dx**2
    out[HYY] = (beyond_y + before_y - 2 * centre) / dy**2
    out[HXY] = (z[i + 1, j + 1] + z[i - 1, j - 1] - (z[i + 1, j - 1] + z[i - 1, j + 1])) / (4 * dx * dy)
    out[RISE] = (
        0.125 * (abs(out[HXX]) * dx**2 + abs(out[HYY]) * dy**2)
        + 0.25 * abs(out[HXY]) * dx * dy
        + 0.25 * (dx**2 + dy**2) / radius
    )


@kernel
def patches(z, x, y, pixel, radius, reach):
    """Return the patches (rows) of the pixels that a sphere may touch."""
    nx, ny = z.shape
    bend = np.inf if reach > 0.99 * radius else 1 / radius * (1 - (reach / radius) ** 2) ** -1.5
    is_chosen = np.zeros(z.shape, np.bool_)
    for i in range(nx):
        for j in range(ny):
            is_chosen[i, j] = _is_summit(z, i, j, pixel, bend)
    rows, columns = np.nonzero(is_chosen)
    out = np.zeros((rows.size, RISE + 1))
    for k in range(rows.size):
        put_patch(out[k], z, rows[k], columns[k], pixel, radius)
        out[k, X] = x[rows[k]]
        out[k, Y] = y[columns[k]]
    return out


@kernel
def _clip(value, half):
    return min(max(value, -half), half)


@kernel
def _highest_point(sx, sy, a, b, e, ball):
    """Return u, v of the highest point in a pixel by slopes and second derivatives (a, b, e mixed) in its middle."""
    det = a * b - e * e
    if det <= 0 or a >= 0:
        u = _clip(-sx / a, ball.half_x) if a < 0 else 0.0
        v = _clip(-sy / b, ball.half_y) if b < 0 else 0.0
        return u, v
    u = (e * sy - b * sx) / det
    v = (e * sx - a * sy) / det
    if abs(u) > ball.half_x:
        u = _clip(u, ball.half_x)
        v = -(sy + e * u) / b
    if abs(v) > ball.half_y:
        v = _clip(v, ball.half_y)
        u = _clip(-(sx + e * v) / a, ball.half_x)
    return u, v


@kernel
def touch(row, x, y, ball):
    """Return the height (nm) of the sphere's lowest point on one patch, its axis at x, y; and the contact point."""
    rx = x - row[X]
    ry = y - row[Y]
    r2 = rx * rx + ry * ry
    c2 = ball.radius**2 - r2
    if c2 <= 0.0:
        return -np.inf, row[X], row[Y]
    c = np.sqrt(c2)
    largest_height = row[H] + row[RISE] - r2 / (ball.radius + c)
    bend = 1 / c
    sx = row[GX] + rx * bend
    sy = row[GY] + ry * bend
    bend3 = bend * bend * bend
    a = row[HXX] - bend - rx * rx * bend3
    b = row[HYY] - bend - ry * ry * bend3
    e = row[HXY] - rx * ry * bend3
    u, v = _highest_point(sx, sy, a, b, e, ball)
    height = row[H] + row[GX] * u + row[GY] * v + 0.5 * (row[HXX] * u * u + row[HYY] * v * v) + row[HXY] * u * v
    rx = rx - u
    ry = ry - v
    return min(height - sphere_height(rx * rx + ry * ry, ball.radius), largest_height), row[X] + u, row[Y] + v


@kernel
def _visible(rows, candidates, x0, x1, y0, y1, radius):
    """Return the candidates that the sphere may touch with its axis in a box."""
    highest = np.zeros(candidates.size)
    floor = -np.inf
    for n in range(candidates.size):
        row = rows[candidates[n]]
        near_x = max(x0 - row[X], row[X] - x1, 0.0)
        near_y = max(y0 - row[Y], row[Y] - y1, 0.0)
        far_x = max(row[X] - x0, x1 - row[X])
        far_y = max(row[Y] - y0, y1 - row[Y])
        highest[n] = row[H] + row[RISE] - sphere_height(near_x * near_x + near_y * near_y, radius)
        floor = max(floor, row[H] - sphere_height(far_x * far_x + far_y * far_y, radius))
    return candidates[(highest >= floor) & (highest > -np.inf)]


@kernel
def _sphere_heights(part, x, y, radius, heights):
    """Fill in the sphere's heights on pixels' centres (rows of ``part``: x, y, height), its axis at x, y."""
    for n in range(heights.size):
        r2 = (x - part[0, n]) ** 2 + (y - part[1, n]) ** 2
        fall = r2 / (radius + np.sqrt(max(radius * radius - r2, 0.0)))
        heights[n] = part[2, n] - (fall if r2 < radius * radius else np.inf)


@kernel
def _raise_bounds(part, first, wide, margin, heights, best, over):
    """Raise ``over`` to the largest height of each patch over the best one, within the margin around a position."""
    for n in range(heights.size):
        distance = np.sqrt((part[0, first] - part[0, n]) ** 2 + (part[1, first] - part[1, n]) ** 2) + wide
        over[n] = max(over[n], heights[n] + part[3, n] + margin * distance - best)


@kernel
def _fill_box(rows, visible, x, y, box, ball, z):
    """Fill a box with the sphere's heights; return the patches that are touched within the margin."""
    heights = np.zeros(visible.size)
    over = np.full(visible.size, -np.inf)
    farthest = 0.0
    part = np.zeros((4, visible.size))
    for n in range(visible.size):
        row = rows[visible[n]]
        part[0, n] = row[X]
        part[1, n] = row[Y]
        part[2, n] = row[H]
        part[3, n] = row[RISE]
        farthest = max(farthest, (x[box[0]] - row[X]) ** 2 + (y[box[2]] - row[Y]) ** 2)
    steeper = 1.1 / np.sqrt(max(1.0 - farthest / ball.radius**2, 0.01)) / ball.radius
    wide = np.hypot(x[1] - x[0], y[1] - y[0])
    margin = wide * steeper
    for i in range(box[0], box[1]):
        for j in range(box[2], box[3]):
            _sphere_heights(part, x[i], y[j], ball.radius, heights)
            first = heights.argmax()
            best = touch(rows[visible[first]], x[i], y[j], ball)[0]
            for n in range(visible.size):
                if n != first and heights[n] + part[3, n] > best:
                    best = max(best, touch(rows[visible[n]], x[i], y[j], ball)[0])
            z[i, j] = best
            _raise_bounds(part, first, wide, margin, heights, best, over)
    return visible[over >= 0]


@kernel
def _middle(low, high):
    """Return the middle of a range of pixels, rounded to a whole number of boxes."""
    return low + max((high - low) // (2 * SIDE), 1) * SIDE


@kernel
def _halves(box):
    """Return both halves of a box of pixels, across its longer side."""
    i0, i1, j0, j1 = box
    if i1 - i0 >= j1 - j0:
        middle = _middle(i0, i1)
        return (i0, middle, j0, j1), (middle, i1, j0, j1)
    middle = _middle(j0, j1)
    return (i0, i1, j0, middle), (i0, i1, middle, j1)


@kernel
def _longer_lists(lists, size, visible):
    """Return lists that contain ``visible`` from the index ``size`` on, twice as long if they were full."""
    while size + visible.size > lists.size:
        longer = np.zeros(2 * lists.size, np.int32)
        longer[:size] = lists[:size]
        lists = longer
    lists[size : size + visible.size] = visible
    return lists


@kernel
def dilation(rows, x, y, ball):
    """Return the height of the sphere's lowest point (nm) at pixel centres, and lists of the patches it may touch.

    Each box of `SIDE` × `SIDE` pixels has a list, valid up to a pixel beyond it: its first and last entry (boxes along
    x, boxes along y, 2) in a vector of patches.
    """
    z = np.full((x.size, y.size), -np.inf)
    bounds = np.zeros((-(-x.size // SIDE), -(-y.size // SIDE), 2), np.int64)
    lists = np.zeros(1024, np.int32)
    size = 0
    # lists hold in a margin of one pixel
    wide_x = x[1] - x[0]
    wide_y = y[1] - y[0]
    todo = [((0, x.size, 0, y.size), np.arange(len(rows)))]
    while len(todo) > 0:
        box, candidates = todo.pop()
        i0, i1, j0, j1 = box
        edges = x[i0] - wide_x, x[i1 - 1] + wide_x, y[j0] - wide_y, y[j1 - 1] + wide_y
        visible = _visible(rows, candidates, edges[0], edges[1], edges[2], edges[3], ball.radius)
        if i1 - i0 > SIDE or j1 - j0 > SIDE:
            for half in _halves(box):
                todo.append((half, visible))
            continue
        if visible.size > 0:
            visible = _fill_box(rows, visible, x, y, box, ball, z)
        lists = _longer_lists(lists, size, visible)
        bounds[i0 // SIDE, j0 // SIDE, 0] = size
        size += visible.size
        bounds[i0 // SIDE, j0 // SIDE, 1] = size
    return z, bounds, lists[:size].copy()
