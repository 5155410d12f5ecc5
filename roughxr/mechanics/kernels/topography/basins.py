"""Resting positions of a sphere on a scan, and their drainage basins.

A sphere rests at a local minimum of its height Z (``dilation``). Z is the largest of the heights Z_k on the patches
that it may touch, with the slopes

    ∇Z_k = −(x − u_k) / √(R² − |x − u_k|²)

where u_k is the contact. So the sphere's axis lies within the polygon of its contacts at rest.

1. Every pixel drains along the steepest descent to a neighbour; pixels that drain to one minimum are its basin.
2. A trough oblique to the pixels has false minima on them. From each minimum the sphere therefore rolls on between
   pixels: the steps d minimise max over k of Z_k + ∇Z_k·d within a square, which is halved where a step does not lower
   the sphere. Basins from which it rolls to the same resting position are merged.

Letters: x, y, u nm; Z nm; R radius (nm); d step (nm).
"""

from typing import Any, NamedTuple

import numpy as np

from ..jit import kernel
from .dilation import SIDE, touch

#: First half-width of a step, pixels: such steps never end midway between pixels.
_FIRST_STEP = 0.47

#: Last half-width of a step, pixels.
_LAST_STEP = 0.004

#: Largest number of steps.
_MOST_STEPS = 4000

#: Largest number of tangent planes along an axis, in the search for the best step.
_MOST_CUTS = 50

#: In `_best_step`, heights that differ by less than this part of a step count as equal.
_ROUNDING = 1e-10

#: Contacts lie below the centre by at least this part of the radius, so that slopes stay finite.
_LEAST_SLANT = 1e-9

_OFFSETS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))


@kernel
def _downhill_label(z, i, j, pixel, labels, lowest):
    """Return the label of the steepest lower neighbour; of equally steep ones, that of the lowest minimum."""
    steepest = 0.0
    label = 0
    for di, dj in _OFFSETS:
        p = i + di
        q = j + dj
        if 0 <= p < z.shape[0] and 0 <= q < z.shape[1] and z[p, q] < z[i, j]:
            slope = (z[i, j] - z[p, q]) / np.sqrt((di * pixel[0]) ** 2 + (dj * pixel[1]) ** 2)
            # slopes that differ by less than this part count as equal
            equal = abs(slope - steepest) <= 1e-9 * steepest
            if (slope > steepest and not equal) or (equal and lowest[labels[p, q]] < lowest[label]):
                label = labels[p, q]
            steepest = max(steepest, slope)
    return label


@kernel
def _drain(z, pixel, labels, lowest):
    """Label all pixels but the minima, whose labels are known."""
    for start in np.argsort(z.ravel()):
        i = start // z.shape[1]
        j = start % z.shape[1]
        if labels[i, j] == 0:
            labels[i, j] = _downhill_label(z, i, j, pixel, labels, lowest)


@kernel
def _outlets(z, is_minimum, labels, count):
    """Return for each minimum the label of an equally high pixel beside it that drains, else its own."""
    outlets = np.arange(count + 1)
    for i, j in np.argwhere(is_minimum):
        for di, dj in _OFFSETS:
            p = i + di
            q = j + dj
            if 0 <= p < z.shape[0] and 0 <= q < z.shape[1] and z[p, q] == z[i, j] and not is_minimum[p, q]:
                outlets[labels[i, j]] = labels[p, q]
    return outlets


def drainage_basins(z, pixel):
    """Return the minima, in pixels, (n, 2), the lowest first, and the share of the pixels that drain to each.

    Other pixels drain off the scan. Pixels of equal height are one minimum, if none of them has a lower neighbour. One
    at the border is none.
    """
    from scipy.ndimage import center_of_mass, label, minimum_filter

    is_minimum = z == minimum_filter(z, 3)
    labels, count = label(is_minimum, np.ones((3, 3)))
    border = np.ones(z.shape, np.bool_)
    border[1:-1, 1:-1] = False
    is_off = np.isin(np.arange(count + 1), np.append(0, labels[border]))
    height = np.zeros(count + 1)
    height[labels] = z
    _drain(z, pixel, labels, np.where(is_off, -np.inf, height))
    outlets = _outlets(z, is_minimum, labels, count)
    lowest_first = np.argsort(height, kind="stable")
    for k in lowest_first:
        outlets[k] = outlets[outlets[k]]
    inner = lowest_first[((outlets == np.arange(count + 1)) & ~is_off)[lowest_first]]
    minima = np.reshape(center_of_mass(is_minimum, labels, inner), (-1, 2))
    return minima, np.bincount(outlets[labels.ravel()], minlength=count + 1)[inner] / z.size


class DilatedSurface(NamedTuple):
    """The pixels of a scan, and the patches that a sphere may touch at each."""

    shape: tuple  # pixels along x and y
    first: tuple  # x and y of the first pixel, nm
    pixel: tuple
    patches: np.ndarray  # rows of `dilation.patches`
    bounds: np.ndarray  # first and last entry in ``lists`` of each box of pixels
    lists: np.ndarray  # the patches that it may touch
    ball: Any  # of `dilation.Ball`


@kernel
def _pixel_at(surface, x, y):
    """Return the pixel nearest to a point."""
    i = int(np.floor((x - surface.first[0]) / surface.pixel[0] + 0.5))
    j = int(np.floor((y - surface.first[1]) / surface.pixel[1] + 0.5))
    return i, j


@kernel
def _is_off(surface, x, y):
    """Return whether a point lies on the scan's outermost pixels, their inner edge included, or beyond."""
    nx, ny = surface.shape
    along_x = (x - surface.first[0]) / surface.pixel[0]
    along_y = (y - surface.first[1]) / surface.pixel[1]
    # half the width of a pixel, in pixels, with a margin for rounding
    return min(along_x, along_y, nx - 1 - along_x, ny - 1 - along_y) <= 0.5 + 1e-9


@kernel
def _patches_near(surface, i, j):
    """Return the patches (rows) that a sphere may touch with its axis within a pixel of pixel i, j."""
    nx, ny = surface.shape
    start, stop = surface.bounds[min(max(i, 0), nx - 1) // SIDE, min(max(j, 0), ny - 1) // SIDE]
    return surface.patches[surface.lists[start:stop]]


@kernel
def _plane(row, x, y, ball):
    """Return the sphere's height on a patch, its slopes, and the contact point."""
    height, u, v = touch(row, x, y, ball)
    c = np.sqrt(max(ball.radius**2 - (x - u) ** 2 - (y - v) ** 2, (_LEAST_SLANT * ball.radius) ** 2))
    return height, (u - x) / c, (v - y) / c, u, v


@kernel
def _planes(rows, x, y, ball, reach):
    """Return height, slopes, contact point and index of the patches that may be touched within a step."""
    out = np.zeros((len(rows), 6))
    for n in range(len(rows)):
        out[n, :5] = _plane(rows[n], x, y, ball)
        out[n, 5] = n
    top = out[out[:, 0].argmax()]
    rise = (np.abs(out[:, 1] - top[1]) + np.abs(out[:, 2] - top[2])) * reach
    return out[out[:, 0] + 1.1 * rise >= top[0]]


@kernel
def _touching_height(rows, x, y, ball):
    """Return the sphere's height, the greatest on some patches."""
    highest = -np.inf
    for n in range(len(rows)):
        highest = max(highest, touch(rows[n], x, y, ball)[0])
    return highest


@kernel
def _highest_plane(planes, dx, dy):
    """Return the greatest height of planes at a step, and the index of that plane."""
    highest = -np.inf
    at = 0
    for n in range(len(planes)):
        height = planes[n, 0] + planes[n, 1] * dx + planes[n, 2] * dy
        if height > highest:
            highest = height
            at = n
    return highest, at


@kernel
def _best_across(planes, dx, step):
    """Return the least height over dy, its slope along x, and dy: there a falling plane crosses a rising one."""
    height, fall = _highest_plane(planes, dx, -step)
    if planes[fall, 2] >= 0:
        return height, planes[fall, 1], -step
    height, rise = _highest_plane(planes, dx, step)
    if planes[rise, 2] <= 0:
        return height, planes[rise, 1], step
    slope = 0.0
    dy = 0.0
    for _ in range(_MOST_CUTS):
        a = planes[fall]
        b = planes[rise]
        dy = (a[0] - b[0] + (a[1] - b[1]) * dx) / (b[2] - a[2])
        slope = (b[2] * a[1] - a[2] * b[1]) / (b[2] - a[2])
        height, higher = _highest_plane(planes, dx, dy)
        if higher in (fall, rise):
            break
        if planes[higher, 2] < 0:
            fall = higher
        else:
            rise = higher
    return height, slope, dy


@kernel
def _best_step(planes, step):
    """Return the step within a square that lowers the highest of planes most.

    The least height over dy is a convex function of dx: the next dx is where its tangents on both sides cross.
    """
    low = -step
    high = step
    at_low, fall, dy = _best_across(planes, low, step)
    if fall >= 0:
        return low, dy
    at_high, rise, dy = _best_across(planes, high, step)
    if rise <= 0:
        return high, dy
    dx = 0.0
    for _ in range(_MOST_CUTS):
        dx = (at_low - at_high + rise * high - fall * low) / (rise - fall)
        height, slope, dy = _best_across(planes, dx, step)
        if height <= at_low + fall * (dx - low) + _ROUNDING * step:
            break
        if slope < 0:
            low = dx
            at_low = height
            fall = slope
        else:
            high = dx
            at_high = height
            rise = slope
    return dx, dy


@kernel
def _step_down(rows, x, y, ball, step, last):
    """Return a lower point within a step, its height, and the step; if there is none, the point and a step < last."""
    height = _touching_height(rows, x, y, ball)
    while step >= last:
        planes = _planes(rows, x, y, ball, step)
        rows = rows[planes[:, 5].astype(np.int64)]
        dx, dy = _best_step(planes, step)
        lower = _touching_height(rows, x + dx, y + dy, ball)
        if lower < height - 1e-12 * ball.radius:
            return x + dx, y + dy, lower, step
        step *= 0.5
    return x, y, height, step


@kernel
def _roll(surface, x, y):
    """Roll from x, y to a resting position; return its x, y and height, NaN off the scan or all patches."""
    largest = max(surface.pixel[0], surface.pixel[1])
    height = np.inf
    step = _FIRST_STEP * largest
    for _ in range(_MOST_STEPS):
        i, j = _pixel_at(surface, x, y)
        near = _patches_near(surface, i, j)
        if len(near) == 0 or _is_off(surface, x, y):
            return np.nan, np.nan, np.nan
        x, y, height, step = _step_down(near, x, y, surface.ball, step, _LAST_STEP * largest)
        if step < _LAST_STEP * largest:
            break
    return x, y, height


@kernel
def settle(surface, places):
    """Roll a sphere from each place to rest; return its x, y, height (nm), (places, 3), NaN if it leaves the scan."""
    out = np.zeros((len(places), 3))
    for n in range(len(places)):
        out[n] = _roll(surface, places[n, 0], places[n, 1])
    return out


@kernel
def _planes_at(surface, x, y, reach):
    """Return `_planes` of the patches near a point."""
    i, j = _pixel_at(surface, x, y)
    return _planes(_patches_near(surface, i, j), x, y, surface.ball, reach)


def _contacts(planes, reach):
    """Return the planes that are the highest somewhere within a step, from the highest on: at rest several are."""
    height = planes[:, 0]
    rise = np.abs(planes[:, None, 1:3] - planes[:, 1:3]).sum(axis=2) * reach
    contacts = planes[(height[:, None] + 1.1 * rise >= height).all(axis=1)]
    return contacts[np.argsort(-contacts[:, 0], kind="stable")]


def supports(places, surface, slack):
    """Return for each place the number of summits that support a sphere, within ``slack`` pixels, and their x, y."""
    from scipy.sparse import block_diag
    from scipy.sparse.csgraph import connected_components

    most_supports = 8
    number = np.zeros(len(places), np.int64)
    at = np.full((len(places), most_supports, 2), np.nan)
    reach = slack * max(surface.pixel)
    contacts = [_contacts(_planes_at(surface, x, y, reach), reach)[:, 3:5] for x, y, _ in places]
    distances = [(np.abs(contact[:, None] - contact) / surface.pixel).max(axis=2) for contact in contacts]
    # contacts nearer than this (pixels) are on one summit; not a multiple of half a pixel: many distances are
    near = block_diag([[[True]], *(distance < 1.9 for distance in distances)])  # one graph: each takes a millisecond
    near.eliminate_zeros()
    summits = np.split(connected_components(near)[1], np.cumsum([1, *map(len, contacts)]))
    for n, (contact, summit) in enumerate(zip(contacts, summits[1:])):
        highest = np.sort(np.unique(summit, return_index=True)[1])[:most_supports]
        number[n] = highest.size
        at[n, : highest.size] = contact[highest]
    return number, at
