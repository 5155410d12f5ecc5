"""The pull of a rigid body on a rough half space: tractions summed over the local gaps, at one place or at all.

At one place, with S the undeformed separation (``halfspace.separation``) and δ the displacement,

    F = a Σ t(g),   g = max(S − δ, g₀)

over pixels of area a, g₀ the smallest gap of hard bodies (flattened summits are at g₀). Beyond the window
the ground is its mean plane, and the pull of the rest of the sphere, its back included, an integral over S (`outside`).

At all places at once, the sum over the pixels around each is split at a gap d. Beyond d the traction is a sum of
exponentials (own; fitted to 10⁻⁶ of itself),

    t(g) = Σ_j c_j exp(−s_j g),   Σ_k t(z + S_k − h_k) = Σ_j c_j exp(−s_j z) [exp(s_j h) ⋆ exp(−s_j S)]

one correlation by FFT for each term, valid for every height z of the indenter. At gaps below d the difference between
t and the sum is added pixel by pixel; only few pixels are so near. The rounding error of a correlation is that of its
largest value, exp(s_j·range of heights) over the smallest: d is chosen so that this stays below 10⁻⁸.

With condensed liquid (`potentials`) its edge g = b runs through pixels. The part of a pixel that is wetted is that of
a plane gap with the slopes at the pixel's middle and the mean gap of the pixel (own; without the difference between
mean and middle, a²∇²g/24, the area of a disk of n pixels in radius is off by 1/(6n²)).

S, z, g, h, d   nm: z the height of the indenter's lowest point, h those of the surface;  a nm²;  t GPa;  F nN
"""

import functools
from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .potentials import partly, tractions

#: Number of exponentials, the largest of their rates in 1/d, and the least d in ranges of heights: with these t is
#: fitted to 5e-7 of itself, and the rounding error of the correlations is below 1e-8 of theirs.
_TERMS, _FASTEST, _PER_RANGE = 16, 12.0, 12.0 / 18.0

#: The shortest d, nm, and the number of entries in the table of the sum of exponentials below it.
_LEAST_NEAR, _TABLE = 2.0, 4096

#: Where nothing keeps the bodies apart, gaps below this part of the law's length count as equal to it.
_CRUSHED = 0.25


class Split(NamedTuple):
    """A traction as a sum of exponentials beyond a gap, and a table of the sum below it."""

    near: float  # the gap d, nm
    rates: np.ndarray  # s_j, nm⁻¹
    weights: np.ndarray  # c_j, GPa
    table: np.ndarray  # Σ_j c_j exp(−s_j g) at _TABLE + 1 even gaps from 0 to d


class Cells(NamedTuple):
    """What the wetted part of each cell depends on; arrays without cells where nothing is wetted."""

    mean: np.ndarray  # gap or height, its mean over the cell, nm
    x: np.ndarray  # change of it across the cell, nm
    y: np.ndarray
    most: float  # how far above its middle's gap a cell may reach the level, nm


def cells(height, law):
    """Return the means and slopes of the cells of a map of heights or gaps (nm); none for a dry law."""
    if law.wet == -np.inf:
        return Cells(*(np.empty((0, 0)),) * 3, 0.0)
    height = np.ascontiguousarray(height, dtype=float)
    found = np.empty((3, *height.shape))
    return Cells(*found, _planes(height, *found))


@kernel
def _planes(height, mean, x, y):
    """Fill means and changes across each cell from its neighbours, itself at the rim; return ``Cells.most``."""
    n, m = height.shape
    most = 0.0
    for i in range(n):
        before, after = height[max(i - 1, 0)], height[min(i + 1, n - 1)]
        for j in range(m):
            here, left, right = height[i, j], height[i, max(j - 1, 0)], height[i, min(j + 1, m - 1)]
            a, b = 0.5 * (after[j] - before[j]), 0.5 * (right - left)
            bend = (after[j] + before[j] + left + right - 4.0 * here) / 24.0
            x[i, j], y[i, j] = a if np.isfinite(a) else 0.0, b if np.isfinite(b) else 0.0
            bend = bend if np.isfinite(bend) else 0.0
            mean[i, j] = here + bend
            most = max(most, abs(bend) + 0.5 * (abs(x[i, j]) + abs(y[i, j])))
    return most


@kernel
def pulls(separation, around, deltas, law, closest, area):
    """Return the pull (nN) at each displacement (nm) of a window of separations."""
    found, wet = np.zeros(deltas.size), around.mean.size > 0
    for k in range(deltas.size):
        for i in range(separation.shape[0]):
            for j in range(separation.shape[1]):
                s = separation[i, j]
                if s < np.inf:
                    part = 0.0
                    if wet and s - deltas[k] < law.wet + around.most:
                        part = wetted(law.wet + deltas[k] - around.mean[i, j], around.x[i, j], around.y[i, j])
                    found[k] += partly(max(s - deltas[k], closest), law, part)
    return area * found


@kernel
def wetted(depth, x, y):
    """Return the part of a cell where a plane gap lies below a level, ``depth`` above its mean and x, y its changes."""
    a, b = max(abs(x), abs(y)), min(abs(x), abs(y))
    u = depth + 0.5 * (a + b)
    if u <= 0.0:
        return 0.0
    if u >= a + b:
        return 1.0
    if b <= 1e-6 * a:
        return min(max((u - 0.5 * b) / a, 0.0), 1.0)
    area = u * u - max(u - a, 0.0) ** 2 - max(u - b, 0.0) ** 2
    return min(area / (2.0 * a * b), 1.0)


@kernel
def wet_area(around, level):
    """Return the area wetted below a level (nm), and the length of its edge, in cells and their sides."""
    area, edge = 0.0, 0.0
    means, x, y = around.mean.ravel(), around.x.ravel(), around.y.ravel()
    for n in range(means.size):
        depth = level - means[n]
        if depth <= -around.most:
            continue
        a, b = abs(x[n]), abs(y[n])
        area += wetted(depth, a, b)
        if abs(depth) < 0.5 * (a + b):
            width = 1e-3 * (a + b)
            edge += np.hypot(a, b) * (wetted(depth + width, a, b) - wetted(depth - width, a, b)) / (2.0 * width)
    return area, edge


def floor(law):
    """Return the smallest gap (nm) to evaluate: the closest approach, or a part of the law's length without one."""
    return _CRUSHED * law.length if law.closest is None else max(law.closest, 1e-12)


def outside(gaps, law, radius, parabola, rectangle):
    """Return the pull (nN) of a sphere on the mean plane beyond a rectangle around its axis, less that of its back.

    Parameters
    ----------
    gaps : ndarray
        Distance of its lowest point from the mean plane, nm.
    law : Potential
    radius : float
        nm.
    parabola : bool
        Hertz's paraboloid in place of the sphere: it has no back.
    rectangle : (float, float, float, float)
        Sides of the window from the axis: below and above along x, then along y, nm, all positive.
    """
    below_x, above_x, below_y, above_y = rectangle
    corners = [np.hypot(a, b) for a in (below_x, above_x) for b in (below_y, above_y)]
    marks = np.clip([*rectangle, *corners], 0.0, radius)
    heights = marks**2 / (2 * radius) if parabola else marks**2 / (radius + np.sqrt(radius**2 - marks**2))
    edges = np.unique(np.append(heights, 2 * radius))
    found = np.zeros(gaps.size)
    for k, gap in enumerate(np.maximum(gaps, floor(law) - edges[0])):
        wet = edges[0] < law.wet - gap < edges[-1]
        S, weight = _nodes(np.sort(np.append(edges, law.wet - gap)) if wet else edges, gap)
        r = np.sqrt(2 * radius * S if parabola else np.maximum(S * (2 * radius - S), 0))
        rings = np.full(S.size, radius) if parabola else radius - S
        share = np.where(rings > 0, 1 - _inside(r, rectangle), 1.0)
        found[k] = 2 * np.pi * np.sum(weight * rings * share * tractions(gap + S, law))
    return found


#: Gauss's nodes and weights, found once: half of the time of a place went into finding them again.
_gauss = functools.cache(np.polynomial.legendre.leggauss)


def _nodes(edges, gap, pieces=8, each=12):
    """Return Gauss's nodes and weights along S, even in the logarithm of gap + S between the edges.

    The nodes are denser at the ends of each interval, as x²(3 − 2x), where the part of a circle inside a rectangle has
    square-root singularities.
    """
    x, w = _gauss(each)
    ends = np.log(gap + edges)
    u = (np.arange(pieces)[:, None] + 0.5 * (1 + x)).ravel() / pieces
    weight = np.tile(0.5 * w, pieces) / pieces * 6 * u * (1 - u)
    length = np.diff(ends)[:, None]
    along = np.exp(ends[:-1, None] + length * u * u * (3 - 2 * u))
    return (along - gap).ravel(), (length * weight * along).ravel()


def _inside(r, rectangle):
    """Return the fraction of a circle of radius r that lies inside the rectangle."""
    found = np.zeros(r.size)
    with np.errstate(divide="ignore"):
        for a in rectangle[:2]:
            for b in rectangle[2:]:
                least = np.arccos(np.minimum(a / r, 1.0))
                most = np.arcsin(np.minimum(b / r, 1.0))
                found += np.maximum(most - least, 0.0) / (2 * np.pi)
    return found


def split(law, height_range, farthest, least=0.0):
    """Return the split of a law for heights of a range (nm), from ``least`` at least to the farthest gap (nm)."""
    if np.isfinite(law.range):
        return Split(max(law.range, least), np.zeros(0), np.zeros(0), np.zeros(_TABLE + 1))
    near = max(_PER_RANGE * height_range, _LEAST_NEAR, 4.0 * law.length, least)
    farthest = max(farthest, 10.0 * near)
    g = np.geomspace(near, farthest, 2000)
    rates = np.geomspace(1.0 / farthest, _FASTEST / near, _TERMS)
    matrix = np.exp(-np.outer(g, rates)) / tractions(g, law._replace(wet=-np.inf))[:, None]
    scale = matrix.max(axis=0)
    weights = np.linalg.lstsq(matrix / scale, np.ones(g.size), rcond=1e-15)[0] / scale
    table = np.exp(-np.outer(np.linspace(0, near, _TABLE + 1), rates)) @ weights
    return Split(near, rates, weights, table)


@kernel
def first_touches(height, rise, rows, out):
    """Fill ``out`` with the height z (nm) of the indenter's lowest point at first touch, at the places of some rows.

    ``height`` is padded by the indenter's half-width on every side; ``rise`` is the indenter's height S over its
    lowest point, inf outside it.
    """
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            highest = -np.inf
            for k in range(rise.shape[0]):
                touch = _highest(height[rows + i + k, j : j + rise.shape[1]], rise[k])
                highest = max(highest, touch)
            out[i, j] = highest


@kernel(reorder=True)
def _highest(height, rise):
    highest = -np.inf
    for k in range(height.size):
        z = height[k] - rise[k]
        highest = z if z > highest else highest
    return highest


@kernel
def near_pulls(height, rise, ground, indenter, top, rows, z, law, split, closest):
    """Return Σ (t − Σ_j c_j exp(−s_j g)) over the cells nearer than d, in GPa, at heights z (rows, columns, heights).

    NaN where z is; ``ground`` and ``indenter`` are the `cells` of heights and rises. Only rows and columns of the
    indenter that can be so near are visited: ``top`` is the highest point (nm) around each place.
    """
    found, wet = np.zeros(z.shape), ground.mean.size > 0
    middle, per_nm = rise.shape[0] // 2, (split.table.size - 1) / split.near
    for i in range(z.shape[0]):
        for j in range(z.shape[1]):
            for n in range(z.shape[2]):
                lowest = z[i, j, n]
                if np.isnan(lowest):
                    found[i, j, n] = np.nan
                    continue
                half = _half_width(rise, middle, split.near + top[rows + i, j] - lowest)
                total = 0.0
                for k in range(middle - half, middle + half + 1):
                    for m in range(middle - half, middle + half + 1):
                        g = lowest + rise[k, m] - height[rows + i + k, j + m]
                        if g < split.near:
                            part = 0.0
                            if wet:
                                at = rows + i + k, j + m
                                part = wetted(
                                    law.wet - (lowest + indenter.mean[k, m] - ground.mean[at]),
                                    indenter.x[k, m] - ground.x[at],
                                    indenter.y[k, m] - ground.y[at],
                                )
                            total += _beyond_exponentials(max(g, closest), law, part, split.table, per_nm)
                found[i, j, n] = total
    return found


@kernel
def _half_width(rise, middle, depth):
    """Return the distance in pixels from the axis within which the indenter rises by less than a depth."""
    half = 0
    while half < middle and rise[middle + half + 1, middle] < depth:
        half += 1
    return half


@kernel
def _beyond_exponentials(g, law, part, table, per_nm):
    x = g * per_nm
    k = min(int(x), table.size - 2)
    return partly(g, law, part) - (table[k] + (x - k) * (table[k + 1] - table[k]))


def far_fields(height, rise, split, shape):
    """Return exp(s_j (h − top)) ⋆ exp(−s_j S) for each term, (terms, rows, columns); top is the highest h."""
    from scipy.fft import irfft2, next_fast_len, rfft2

    padded = [next_fast_len(n, real=True) for n in height.shape]
    top = height.max()
    found = np.empty((split.rates.size, *shape))
    for rate, field in zip(split.rates, found):
        surface = rfft2(np.exp(rate * (height - top)), padded)
        surface *= np.conj(rfft2(np.exp(-rate * rise), padded))
        field[:] = irfft2(surface, padded)[: shape[0], : shape[1]]
    return found


def far_pulls(fields, top, z, split):
    """Return Σ Σ_j c_j exp(−s_j g) over all cells, in GPa, at heights z (rows, columns, heights); NaN where z is."""
    found = np.where(np.isnan(z), np.nan, 0.0)
    for rate, weight, field in zip(split.rates, split.weights, fields):
        found += weight * np.exp(rate * (top - z)) * field[..., None]
    return found
