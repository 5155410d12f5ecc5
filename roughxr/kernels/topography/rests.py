"""Where a sphere lies still on a scan, from which places it gets there, and over which pass it leaves.

A sphere rests where its height Z (``dilation``) is least. Z is the largest of the heights Z_k on the patches that it may
touch; the slope of each points from the sphere's axis away from where it touches,

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

import numpy as np

from ..arrays import line
from ..jit import kernel
from .dilation import touch

#: Label of pixels from which the sphere rolls off the scan.
OFF = 0

#: Half-width, in pixels, of the square of pixels whose patches a sphere in its middle may touch.
_AROUND = 2

#: Half-width of a step, in pixels: at first, and at the end; and the largest number of steps.
_STEP, _LAST, _MOST_STEPS = 1.0, 0.005, 2000

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
    """Drain a level plateau: to a lower pixel beside it, off the scan, or to its middle; return its minimum, −1 if none.

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


@kernel
def _patches_around(touched, i, j, out):
    """Write the patches that the sphere touches at the pixels around one, each once; return their number."""
    count = 0
    for p in range(max(i - _AROUND, 0), min(i + _AROUND + 1, touched.shape[0])):
        for q in range(max(j - _AROUND, 0), min(j + _AROUND + 1, touched.shape[1])):
            new = True
            for n in range(count):
                new &= out[n] != touched[p, q]
            if new:
                out[count] = touched[p, q]
                count += 1
    return count


@kernel
def _planes(rows, which, count, x, y, ball, out):
    """Write height, slopes and place of contact for each patch; return the greatest height."""
    highest = -np.inf
    for n in range(count):
        height, u, v = touch(rows[which[n]], x, y, ball)
        c = np.sqrt(max(ball.radius**2 - (x - u) ** 2 - (y - v) ** 2, 1e-12))
        out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = height, (u - x) / c, (v - y) / c, u, v
        highest = max(highest, height)
    return highest


@kernel
def _highest_plane(planes, count, dx, dy):
    highest = -np.inf
    for n in range(count):
        highest = max(highest, planes[n, 0] + planes[n, 1] * dx + planes[n, 2] * dy)
    return highest


@kernel
def _best_across(planes, count, dx, step):
    """Return the least height over dy, and dy: the function is convex."""
    low, high = -step, step
    for _ in range(18):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        if _highest_plane(planes, count, dx, a) < _highest_plane(planes, count, dx, b):
            high = b
        else:
            low = a
    dy = 0.5 * (low + high)
    return _highest_plane(planes, count, dx, dy), dy


@kernel
def _best_step(planes, count, step):
    """Return the step within a square that lowers the highest of the planes most."""
    low, high = -step, step
    for _ in range(18):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        if _best_across(planes, count, a, step)[0] < _best_across(planes, count, b, step)[0]:
            high = b
        else:
            low = a
    dx = 0.5 * (low + high)
    return dx, _best_across(planes, count, dx, step)[1]


@kernel
def _near_highest(planes, count, highest, reach):
    """Keep in front those planes that may be the highest within a step; return their number."""
    steepest = 0.0
    for n in range(count):
        if planes[n, 0] > -np.inf:
            steepest = max(steepest, abs(planes[n, 1]) + abs(planes[n, 2]))
    kept = 0
    for n in range(count):
        if planes[n, 0] >= highest - 2 * steepest * reach:
            for column in range(5):
                planes[kept, column] = planes[n, column]
            kept += 1
    return kept


@kernel
def _roll(rows, touched, labels, start, own, axes, pixel, ball, which, planes):
    """Roll from x, y down to rest; return x, y, height, and the label of another basin that it comes into, else own."""
    x, y = start
    first_x, first_y = axes
    step = _STEP * max(pixel[0], pixel[1])
    last = _LAST * max(pixel[0], pixel[1])
    highest, label = np.inf, own
    for _ in range(_MOST_STEPS):
        i, j = int(np.floor((x - first_x) / pixel[0] + 0.5)), int(np.floor((y - first_y) / pixel[1] + 0.5))
        if i <= 0 or j <= 0 or i >= touched.shape[0] - 1 or j >= touched.shape[1] - 1:
            return x, y, highest, np.int32(OFF)
        label = labels[i, j]
        if label != own:
            return x, y, highest, label
        count = _patches_around(touched, i, j, which)
        highest = _planes(rows, which, count, x, y, ball, planes)
        lower = False
        while not lower and step >= last:
            kept = _near_highest(planes, count, highest, step)
            dx, dy = _best_step(planes, kept, step)
            height = -np.inf
            for n in range(count):
                height = max(height, touch(rows[which[n]], x + dx, y + dy, ball)[0])
            lower = height < highest - 1e-12 * ball.radius
            if lower:
                x, y = x + dx, y + dy
            else:
                step *= 0.5
                highest = _planes(rows, which, count, x, y, ball, planes)
        if not lower:
            break
    return x, y, highest, own


@kernel
def settle(z, touched, labels, minima, rows, axes, pixel, ball):
    """Roll a sphere from each minimum; return x, y, height (nm) and label, (minima, 4)."""
    which, planes = line(25, np.int64(0)), np.zeros((25, 5))
    out = np.zeros((minima.size, 4))
    for n in range(minima.size):
        i, j = minima[n] // z.shape[1], minima[n] % z.shape[1]
        start = axes[0] + i * pixel[0], axes[1] + j * pixel[1]
        x, y, height, label = _roll(rows, touched, labels, start, np.int32(n + 1), axes, pixel, ball, which, planes)
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = x, y, height, label
    return out


@kernel
def borders(z, labels):
    """Return (first label, second label, pixel) for neighbouring pixels of different basins, and the heights there."""
    nx, ny = z.shape
    count = 0
    for fill in range(2):
        if fill:
            pairs, heights = np.zeros((count, 3), np.int32), line(count, 0.0)
            count = 0
        for i in range(nx):
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
def _between(row_a, row_b, ball, x, y):
    """Return where on the line that joins two patches the sphere touches both at once, and its height; NaN if nowhere."""
    _, ua, va = touch(row_a, x, y, ball)
    _, ub, vb = touch(row_b, x, y, ball)
    t = 0.5
    for _ in range(6):
        low, high = 0.0, 1.0
        for _ in range(40):
            t = 0.5 * (low + high)
            a = touch(row_a, ua + t * (ub - ua), va + t * (vb - va), ball)[0]
            b = touch(row_b, ua + t * (ub - ua), va + t * (vb - va), ball)[0]
            if a > b:
                low = t
            else:
                high = t
        if t < 1e-6 or t > 1 - 1e-6:
            return np.nan, np.nan, np.nan
        x, y = ua + t * (ub - ua), va + t * (vb - va)
        a, ua, va = touch(row_a, x, y, ball)
        b, ub, vb = touch(row_b, x, y, ball)
    return x, y, max(a, b)


@kernel
def passes(z, touched, pixels, rows, axes, pixel, ball):
    """Return x, y and height (nm) of the pass at each of some pixels of a border, (passes, 3)."""
    which, out = line(25, np.int64(0)), np.zeros((pixels.size, 3))
    largest = max(pixel[0], pixel[1])
    for n in range(pixels.size):
        i, j = pixels[n] // z.shape[1], pixels[n] % z.shape[1]
        x, y = axes[0] + i * pixel[0], axes[1] + j * pixel[1]
        out[n, 0], out[n, 1], out[n, 2] = x, y, z[i, j]
        count = _patches_around(touched, i, j, which)
        nearest = (2.5 * largest) ** 2
        for a in range(count):
            for b in range(a):
                one, other = rows[which[a]], rows[which[b]]
                if max(abs(one[0] - other[0]) / pixel[0], abs(one[1] - other[1]) / pixel[1]) < _APART:
                    continue
                px, py, height = _between(one, other, ball, x, y)
                distance = (px - x) ** 2 + (py - y) ** 2
                if not distance < nearest:
                    continue
                over = height
                for c in range(count):
                    over = max(over, touch(rows[which[c]], px, py, ball)[0])
                if over <= height + 1e-9 * ball.radius:
                    nearest = distance
                    out[n, 0], out[n, 1], out[n, 2] = px, py, height
    return out


@kernel
def carriers(touched, places, rows, axes, pixel, ball, slack):
    """Return for each place the number of summits that carry a sphere, and where it touches them, (places, most, 2).

    Patches within ``slack`` (pixels) of motion of the sphere from being touched count; those side by side are one.
    """
    which, planes = line(25, np.int64(0)), np.zeros((25, 5))
    most = 8
    number, at = line(len(places), 0), np.full((len(places), most, 2), np.nan)
    for n in range(len(places)):
        x, y = places[n, 0], places[n, 1]
        i, j = int(np.floor((x - axes[0]) / pixel[0] + 0.5)), int(np.floor((y - axes[1]) / pixel[1] + 0.5))
        i, j = min(max(i, 0), touched.shape[0] - 1), min(max(j, 0), touched.shape[1] - 1)
        count = _patches_around(touched, i, j, which)
        highest = _planes(rows, which, count, x, y, ball, planes)
        count = _near_highest(planes, count, highest, slack * max(pixel[0], pixel[1]))
        order = np.argsort(-planes[:count, 0])
        for k in order:
            new = number[n] < most
            for m in range(number[n]):
                off_x, off_y = (planes[k, 3] - at[n, m, 0]) / pixel[0], (planes[k, 4] - at[n, m, 1]) / pixel[1]
                new &= max(abs(off_x), abs(off_y)) >= _APART
            if new:
                at[n, number[n], 0], at[n, number[n], 1] = planes[k, 3], planes[k, 4]
                number[n] += 1
    return number, at


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
