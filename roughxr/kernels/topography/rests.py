"""Where a sphere lies still on a scan, from which places it gets there, and over which pass it leaves.

A sphere rests where its height Z (``dilation``) is least. Z is the largest of the heights Z_k on the patches that it
may touch; the slope of each points from the sphere's axis away from where it touches,

    ∇Z_k = −(x − u_k) / √(R² − |x − u_k|²)

so that the sphere rests where its axis lies within the polygon of what it touches, and a pass between two summits is
where it lies on the line that joins them, at equal heights.

1. Every pixel drains to the lowest, by distance, of its neighbours; pixels that drain to one are its basin.
2. A trough that runs obliquely to the pixels has false minima on them. From each minimum the sphere therefore rolls on
   between pixels: the steps d minimise max over k of Z_k + ∇Z_k·d within a square, which is halved where a step does
   not lower the sphere. It ends at rest, or in another basin, of which its own then is a part.
3. The pass between two basins is the lowest pixel of their common border, then the point on the line that joins two
   touched summits, where there are two.

Letters: x, y, u nm; Z nm; R radius (nm); d step (nm).
"""

from typing import NamedTuple

import numpy as np

from ..arrays import line, table
from ..jit import kernel
from .dilation import SIDE, touch

#: Label of pixels from which the sphere rolls off the scan.
OFF = 0

#: Half-width of a step, in pixels: at first, and at the end; and the largest number of steps.
_STEP, _LAST, _MOST_STEPS = 0.5, 0.004, 4000

#: Least distance (pixels) of patches on different summits.
_APART = 2.0

_OFFSETS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))


@kernel
def _on_border(shape, i, j):
    return i == 0 or j == 0 or i == shape[0] - 1 or j == shape[1] - 1


@kernel
def _lowest_neighbour(z, i, j, pixel):
    """Return the neighbour, flat, to which the steepest way down leads; −1 where none is lower."""
    nx, ny = z.shape
    steepest, to = 0.0, -1
    for di, dj in _OFFSETS:
        p, q = i + di, j + dj
        if 0 <= p < nx and 0 <= q < ny and z[p, q] < z[i, j]:
            slope = (z[i, j] - z[p, q]) / np.sqrt((di * pixel[0]) ** 2 + (dj * pixel[1]) ** 2)
            if slope > steepest:
                steepest, to = slope, p * ny + q
    return to


@kernel
def _drain_flat(z, i, j, to, found):
    """Drain a level plateau: to a lower pixel beside it, off the scan, or to its middle; return that, −1 if none.

    ``found`` takes the plateau's pixels, those with a way out first.
    """
    nx, ny = z.shape
    here = i * ny + j
    found[0], count, done = here, 1, 0
    to[here] = -3
    off = False
    while done < count:
        p, q = found[done] // ny, found[done] % ny
        done += 1
        off |= _on_border(z.shape, p, q)
        for di, dj in _OFFSETS:
            r, s = p + di, q + dj
            if 0 <= r < nx and 0 <= s < ny and z[r, s] == z[p, q] and to[r * ny + s] == -1:
                to[r * ny + s] = -3
                found[count] = r * ny + s
                count += 1
    middle = found[count // 2]
    outlet = -1
    for n in range(count):
        p, q = found[n] // ny, found[n] % ny
        for di, dj in _OFFSETS:
            r, s = p + di, q + dj
            if outlet < 0 and 0 <= r < nx and 0 <= s < ny and z[r, s] == z[p, q] and to[r * ny + s] >= 0:
                outlet = r * ny + s
    end = outlet if outlet >= 0 else (-2 if off else middle)
    for n in range(count):
        to[found[n]] = end
    if end == middle:
        to[middle] = middle
        return middle
    return -1


@kernel
def basins(z, pixel):
    """Return the label of each pixel's basin (``OFF``, 1, 2, …), and the minimum (flat) of each label from 1 on."""
    nx, ny = z.shape
    to, found = line(z.size, np.int32(-1)), line(z.size, np.int32(0))
    for i in range(nx):
        for j in range(ny):
            to[i * ny + j] = _lowest_neighbour(z, i, j, pixel)
    minima, count = line(z.size // 4 + 1, np.int32(0)), 0
    for k in range(z.size):
        if to[k] == -1:
            lowest = _drain_flat(z, k // ny, k % ny, to, found)
            if lowest >= 0:
                minima[count] = lowest
                count += 1
    labels = found.reshape(nx, ny)
    labels[:] = -1
    flat = labels.ravel()
    for n in range(count):
        flat[minima[n]] = n + 1
    for k in range(z.size):
        end = k
        while end >= 0 and flat[end] < 0:
            end = to[end]
        label = flat[end] if end >= 0 else np.int32(OFF)
        end = k
        while end >= 0 and flat[end] < 0:
            flat[end] = label
            end = to[end]
    return labels, minima[:count].copy()


class Ground(NamedTuple):
    """What a sphere may touch, anywhere on a scan, and the scan's pixels."""

    patches: np.ndarray
    bounds: np.ndarray  # first and last entry in ``lists`` of each box of pixels
    lists: np.ndarray
    first: tuple  # x and y of the first pixel, nm
    pixel: tuple
    shape: tuple
    ball: tuple


@kernel
def _pixel_at(ground, x, y):
    """Return the pixel nearest to a place."""
    i = int(np.floor((x - ground.first[0]) / ground.pixel[0] + 0.5))
    j = int(np.floor((y - ground.first[1]) / ground.pixel[1] + 0.5))
    return i, j


@kernel
def _near(ground, i, j):
    """Return the patches that a sphere may touch whose axis is within a pixel of a pixel."""
    start, stop = ground.bounds[i // SIDE, j // SIDE]
    return ground.lists[start:stop]


@kernel
def _planes(ground, which, x, y, reach):
    """Return height, slopes, place of contact and number of the patches that may be touched within a step."""
    out, steepest, highest, ball = table(which.size, 6, 0.0), 0.0, -np.inf, ground.ball
    for n in range(which.size):
        height, u, v = touch(ground.patches[which[n]], x, y, ball)
        c = np.sqrt(max(ball.radius**2 - (x - u) ** 2 - (y - v) ** 2, 1e-12))
        out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = height, (u - x) / c, (v - y) / c, u, v
        out[n, 5] = which[n]
        if height > -np.inf:
            steepest = max(steepest, abs(out[n, 1]) + abs(out[n, 2]))
        highest = max(highest, height)
    kept = 0
    for n in range(which.size):
        if out[n, 0] >= highest - 2 * steepest * reach:
            for column in range(6):
                out[kept, column] = out[n, column]
            kept += 1
    return out[:kept]


@kernel
def _height(ground, which, x, y):
    """Return the greatest height on some patches."""
    highest = -np.inf
    for k in which:
        highest = max(highest, touch(ground.patches[k], x, y, ground.ball)[0])
    return highest


@kernel
def _highest_plane(planes, dx, dy):
    highest = -np.inf
    for n in range(len(planes)):
        highest = max(highest, planes[n, 0] + planes[n, 1] * dx + planes[n, 2] * dy)
    return highest


@kernel
def _best_across(planes, dx, step):
    """Return the least height over dy, and dy: the function is convex."""
    low, high = -step, step
    for _ in range(10):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        if _highest_plane(planes, dx, a) < _highest_plane(planes, dx, b):
            high = b
        else:
            low = a
    dy = 0.5 * (low + high)
    return _highest_plane(planes, dx, dy), dy


@kernel
def _best_step(planes, step):
    """Return the step within a square that lowers the highest of the planes most."""
    low, high = -step, step
    for _ in range(10):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        if _best_across(planes, a, step)[0] < _best_across(planes, b, step)[0]:
            high = b
        else:
            low = a
    dx = 0.5 * (low + high)
    return dx, _best_across(planes, dx, step)[1]


@kernel
def _roll(ground, labels, x, y, own):
    """Roll from x, y down to rest; return x, y, height, and the label of another basin that it comes into, else own."""
    largest = max(ground.pixel[0], ground.pixel[1])
    step, height = _STEP * largest, np.inf
    for _ in range(_MOST_STEPS):
        i, j = _pixel_at(ground, x, y)
        if i <= 0 or j <= 0 or i >= ground.shape[0] - 1 or j >= ground.shape[1] - 1:
            return x, y, height, np.int32(OFF)
        if labels[i, j] != own:
            return x, y, height, labels[i, j]
        which = _near(ground, i, j)
        height, lower = _height(ground, which, x, y), False
        while not lower and step >= _LAST * largest:
            dx, dy = _best_step(_planes(ground, which, x, y, step), step)
            lower = _height(ground, which, x + dx, y + dy) < height - 1e-12 * ground.ball.radius
            if lower:
                x, y = x + dx, y + dy
            else:
                step *= 0.5
        if not lower:
            break
    return x, y, height, own


@kernel
def settle(ground, labels, minima):
    """Roll a sphere from each minimum; return x, y, height (nm) and label, (minima, 4)."""
    out = table(minima.size, 4, 0.0)
    for n in range(minima.size):
        i, j = minima[n] // ground.shape[1], minima[n] % ground.shape[1]
        x, y = ground.first[0] + i * ground.pixel[0], ground.first[1] + j * ground.pixel[1]
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = _roll(ground, labels, x, y, np.int32(n + 1))
    return out


@kernel
def _within_reach(ground, x, y, farthest):
    """Return those of all patches that a sphere may touch within a distance (nm) of a place."""
    which, heights, slopes = (
        line(len(ground.patches), 0),
        line(len(ground.patches), 0.0),
        line(len(ground.patches), 0.0),
    )
    highest, steepest, count = -np.inf, 0.0, 0
    for k in range(len(ground.patches)):
        heights[k], u, v = touch(ground.patches[k], x, y, ground.ball)
        r2 = (x - u) ** 2 + (y - v) ** 2
        slopes[k] = np.sqrt(r2 / max(ground.ball.radius**2 - r2, 1e-12))
        if heights[k] > highest:
            highest, steepest = heights[k], slopes[k]
    for k in range(len(ground.patches)):
        if heights[k] + 1.1 * (slopes[k] + steepest) * farthest >= highest:
            which[count] = k
            count += 1
    return which[:count]


@kernel
def settle_near(ground, places, farthest):
    """Roll a sphere from each place down on all patches, no farther than a distance (nm); return x, y, height."""
    out, last = table(len(places), 3, 0.0), _LAST * max(ground.pixel[0], ground.pixel[1])
    for n in range(len(places)):
        x, y = places[n, 0], places[n, 1]
        which, step = _within_reach(ground, x, y, farthest), _STEP * max(ground.pixel[0], ground.pixel[1])
        height = _height(ground, which, x, y)
        while step >= last and max(abs(x - places[n, 0]), abs(y - places[n, 1])) < 0.7 * farthest:
            dx, dy = _best_step(_planes(ground, which, x, y, step), step)
            lower = _height(ground, which, x + dx, y + dy)
            if lower < height - 1e-12 * ground.ball.radius:
                x, y, height = x + dx, y + dy, lower
            else:
                step *= 0.5
        out[n, 0], out[n, 1], out[n, 2] = x, y, height
    return out


@kernel
def borders(z, labels, start, stop):
    """Return (first label, second label, pixel) for neighbouring pixels of different basins, and the heights there.

    The first pixel lies in rows from ``start`` to ``stop``.
    """
    nx, ny = z.shape
    count = 0
    for fill in range(2):
        if fill:
            pairs, heights = np.zeros((count, 3), np.int32), line(count, 0.0)
            count = 0
        for i in range(start, min(stop, nx)):
            for j in range(ny):
                for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
                    p, q = i + di, j + dj
                    if p < nx and 0 <= q < ny and labels[p, q] != labels[i, j]:
                        if fill:
                            here = z[i, j] >= z[p, q]
                            pairs[count, 0] = min(labels[i, j], labels[p, q])
                            pairs[count, 1] = max(labels[i, j], labels[p, q])
                            pairs[count, 2] = i * ny + j if here else p * ny + q
                            heights[count] = z[i, j] if here else z[p, q]
                        count += 1
    return pairs, heights


@kernel
def _between(a, b, ball, place):
    """Return where on the line that joins two patches the sphere touches both at once, and its height; NaN if nowhere.

    Where it touches them hardly moves with the sphere: the line is drawn anew a few times.
    """
    x, y, height = place[0], place[1], np.nan
    for _ in range(3):
        _, ua, va = touch(a, x, y, ball)
        _, ub, vb = touch(b, x, y, ball)
        low, high = 0.0, 1.0
        f_low = touch(a, ua, va, ball)[0] - touch(b, ua, va, ball)[0]
        f_high = touch(a, ub, vb, ball)[0] - touch(b, ub, vb, ball)[0]
        if not (f_low > 0 > f_high):
            return x, y, np.nan
        for _ in range(4):  # false position: the difference is nearly a straight line
            t = (low * f_high - high * f_low) / (f_high - f_low)
            x, y = ua + t * (ub - ua), va + t * (vb - va)
            height = touch(a, x, y, ball)[0]
            f = height - touch(b, x, y, ball)[0]
            if f > 0:
                low, f_low = t, f
            else:
                high, f_high = t, f
    return x, y, height


@kernel
def _off_line(a, b, x, y):
    """Return the squared distance of a place from the line between two patches, as far as it lies between them."""
    dx, dy = b[3] - a[3], b[4] - a[4]
    along = ((x - a[3]) * dx + (y - a[4]) * dy) / (dx * dx + dy * dy)
    along = min(max(along, 0.0), 1.0)
    return (x - a[3] - along * dx) ** 2 + (y - a[4] - along * dy) ** 2


@kernel
def _apart(a, b, pixel):
    """Return whether two contacts lie on different summits."""
    return max(abs(a[3] - b[3]) / pixel[0], abs(a[4] - b[4]) / pixel[1]) >= _APART


@kernel
def passes(z, pixels, ground):
    """Return x, y and height (nm) of the pass at each of some pixels of a border, (passes, 3)."""
    out, ball = table(pixels.size, 3, 0.0), ground.ball
    largest = max(ground.pixel[0], ground.pixel[1])
    for n in range(pixels.size):
        i, j = pixels[n] // z.shape[1], pixels[n] % z.shape[1]
        x, y = ground.first[0] + i * ground.pixel[0], ground.first[1] + j * ground.pixel[1]
        out[n, 0], out[n, 1], out[n, 2] = x, y, z[i, j]
        which, nearest = _near(ground, i, j), (2.0 * largest) ** 2
        planes = _planes(ground, which, x, y, largest)
        for p in range(len(planes)):
            for q in range(p):
                a, b = planes[p], planes[q]
                if not _apart(a, b, ground.pixel) or _off_line(a, b, x, y) > nearest:
                    continue
                px, py, height = _between(ground.patches[int(a[5])], ground.patches[int(b[5])], ball, (x, y))
                distance = (px - x) ** 2 + (py - y) ** 2
                if not (height < np.inf and distance < nearest):
                    continue
                if _height(ground, which, px, py) <= height + 1e-9 * ball.radius:
                    nearest = distance
                    out[n, 0], out[n, 1], out[n, 2] = px, py, height
    return out


@kernel
def carriers(places, ground, slack):
    """Return for each place the number of summits that carry a sphere, and where it touches them, (places, most, 2).

    Patches within ``slack`` (pixels) of motion of the sphere from being touched count; those side by side are one.
    """
    most = 8
    number, at = line(len(places), 0), np.full((len(places), most, 2), np.nan)
    kept = table(most, 5, 0.0)
    for n in range(len(places)):
        i, j = _pixel_at(ground, places[n, 0], places[n, 1])
        i, j = min(max(i, 0), ground.shape[0] - 1), min(max(j, 0), ground.shape[1] - 1)
        reach = slack * max(ground.pixel[0], ground.pixel[1])
        planes = _planes(ground, _near(ground, i, j), places[n, 0], places[n, 1], reach)
        for k in np.argsort(-planes[:, 0]):
            new = number[n] < most
            for m in range(number[n]):
                new &= _apart(planes[k], kept[m], ground.pixel)
            if new:
                kept[number[n]] = planes[k, :5]
                at[n, number[n], 0], at[n, number[n], 1] = planes[k, 3], planes[k, 4]
                number[n] += 1
    return number, at


@kernel
def heights(places, ground):
    """Return the heights (nm) of the sphere at places."""
    out = line(len(places), 0.0)
    for n in range(len(places)):
        i, j = _pixel_at(ground, places[n, 0], places[n, 1])
        i, j = min(max(i, 0), ground.shape[0] - 1), min(max(j, 0), ground.shape[1] - 1)
        out[n] = _height(ground, _near(ground, i, j), places[n, 0], places[n, 1])
    return out


@kernel
def way_down(z, i, j, pixel):
    """Return the pixels (steps, 2) of the steepest way down from one, itself the first."""
    here, count = i * z.shape[1] + j, 0
    for fill in range(2):
        if fill:
            out = np.zeros((count, 2), np.int64)
        at, count = here, 0
        while at >= 0:
            p, q = at // z.shape[1], at % z.shape[1]
            if fill:
                out[count, 0], out[count, 1] = p, q
            count += 1
            at = _lowest_neighbour(z, p, q, pixel)
    return out
