"""The attraction between a rigid body and a rough half space: tractions summed over the local gaps.

With S the undeformed separation (``halfspace.separation``) and δ the displacement,

    F = a Σ t(g),   g = max(S − δ, g₀)

over pixels of area a, g₀ the smallest gap of hard bodies (flattened summits are at g₀). Beyond the window
the surface is its mean plane, and the attraction to the rest of the sphere, its back included, is an integral over S
(`force_outside`).

The edge g = b of condensed liquid (`potentials`) crosses pixels. The wetted part of a pixel is computed for a plane gap
with the slopes at the pixel's middle and the pixel's mean gap (own; without the difference between mean and middle,
a²∇²g/24, the area of a disk of n pixels in radius is off by 1/(6n²)).

S, δ, g  nm;  a nm²;  t GPa;  F nN
"""

import functools
from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .potentials import partly_wetted_traction, tractions


class Cells(NamedTuple):
    """Heights and slopes of cells, from which their wetted parts follow; empty arrays for a dry law."""

    mean: np.ndarray  # mean gap or height of the cell, nm
    x: np.ndarray  # change of gap or height across the cell, nm
    y: np.ndarray
    most: float  # largest difference within a cell from the value at its middle, nm


def cells(height, law):
    """Return the means and slopes of the cells of a map of heights or gaps (nm), from each cell's neighbours.

    At the rim a cell is its own neighbour. None for a dry law.
    """
    if law.filled == -np.inf:
        return Cells(*(np.empty((0, 0)),) * 3, 0.0)
    padded = np.pad(np.asarray(height, dtype=float), 1, mode="edge")
    centre = padded[1:-1, 1:-1]
    before = padded[:-2, 1:-1]
    after = padded[2:, 1:-1]
    left = padded[1:-1, :-2]
    right = padded[1:-1, 2:]
    with np.errstate(invalid="ignore"):  # inf beyond a map
        fields = 0.5 * (after - before), 0.5 * (right - left), (after + before + left + right - 4.0 * centre) / 24.0
    x, y, bend = (np.where(np.isfinite(field), field, 0.0) for field in fields)
    most = np.max(np.abs(bend) + 0.5 * (np.abs(x) + np.abs(y)), initial=0.0)
    return Cells(centre + bend, x, y, float(most))


@kernel
def attractions(separation, cells, deltas, law, closest, area):
    """Return the attractive force (nN) over a window of separations at each displacement (nm)."""
    forces = np.zeros(deltas.size)
    humid = cells.mean.size > 0
    for k in range(deltas.size):
        for i in range(separation.shape[0]):
            for j in range(separation.shape[1]):
                s = separation[i, j]
                if s < np.inf:
                    part = 0.0
                    if humid and s - deltas[k] < law.filled + cells.most:
                        part = wetted(law.filled + deltas[k] - cells.mean[i, j], cells.x[i, j], cells.y[i, j])
                    forces[k] += partly_wetted_traction(max(s - deltas[k], closest), law, part)
    return area * forces


@kernel
def wetted(depth, x, y):
    """Return the part of a cell where a plane gap lies below a level ``depth`` over its mean; x, y are its changes."""
    a = max(abs(x), abs(y))
    b = min(abs(x), abs(y))
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
def wetted_area(cells, level):
    """Return the area wetted below a level (nm), and the length of its edge, in cells and their sides."""
    area = 0.0
    edge = 0.0
    means = cells.mean.ravel()
    x = cells.x.ravel()
    y = cells.y.ravel()
    for n in range(means.size):
        depth = level - means[n]
        if depth <= -cells.most:
            continue
        a = abs(x[n])
        b = abs(y[n])
        area += wetted(depth, a, b)
        if abs(depth) < 0.5 * (a + b):
            width = 1e-3 * (a + b)
            edge += np.hypot(a, b) * (wetted(depth + width, a, b) - wetted(depth - width, a, b)) / (2.0 * width)
    return area, edge


def smallest_gap(law):
    """Return the smallest gap (nm) to evaluate: the closest approach, or a part of the law's length without one."""
    # smallest gap, as a part of the law's length, of laws that repel by themselves
    return 0.25 * law.length if law.closest is None else max(law.closest, 1e-12)


def force_outside(gaps, law, radius, rectangle):
    """Return the attraction (nN) of a sphere to the mean plane outside a rectangle around its axis, less its back's.

    Parameters
    ----------
    gaps : ndarray
        Distance of the sphere's lowest point from the mean plane, nm.
    law : Potential
    radius : float
        nm.
    rectangle : (float, float, float, float)
        Distances from the axis to the sides: below and above along x, then along y, nm, all positive.
    """
    below_x, above_x, below_y, above_y = rectangle
    corners = [np.hypot(a, b) for a in (below_x, above_x) for b in (below_y, above_y)]
    marks = np.clip([*rectangle, *corners], 0.0, radius)
    heights = marks**2 / (radius + np.sqrt(radius**2 - marks**2))
    edges = np.unique(np.append(heights, 2 * radius))
    forces = np.zeros(gaps.size)
    for k, gap in enumerate(np.maximum(gaps, smallest_gap(law) - edges[0])):
        crosses = edges[0] < law.filled - gap < edges[-1]
        S, weight = _nodes(np.sort(np.append(edges, law.filled - gap)) if crosses else edges, gap)
        r = np.sqrt(np.maximum(S * (2 * radius - S), 0))
        rings = radius - S
        share = np.where(rings > 0, 1 - _fraction_inside(r, rectangle), 1.0)
        forces[k] = 2 * np.pi * np.sum(weight * rings * share * tractions(gap + S, law))
    return forces


#: Gauss's nodes and weights, cached: halves the time of a place.
_gauss = functools.cache(np.polynomial.legendre.leggauss)


def _nodes(edges, gap):
    """Return Gauss's nodes and weights along S, uniform in the logarithm of gap + S between the edges.

    The nodes are denser at the ends of each interval, as x²(3 − 2x): there the fraction of a circle inside a rectangle
    has square-root singularities.
    """
    # pieces of an interval
    pieces = 8
    # nodes of a piece
    x, w = _gauss(12)
    ends = np.log(gap + edges)
    u = (np.arange(pieces)[:, None] + 0.5 * (1 + x)).ravel() / pieces
    weight = np.tile(0.5 * w, pieces) / pieces * 6 * u * (1 - u)
    length = np.diff(ends)[:, None]
    along = np.exp(ends[:-1, None] + length * u * u * (3 - 2 * u))
    return (along - gap).ravel(), (length * weight * along).ravel()


def _fraction_inside(r, rectangle):
    """Return the fraction of a circle of radius r that lies inside the rectangle."""
    angle = np.zeros(r.size)
    with np.errstate(divide="ignore"):
        for a in rectangle[:2]:
            for b in rectangle[2:]:
                least = np.arccos(np.minimum(a / r, 1.0))
                most = np.arcsin(np.minimum(b / r, 1.0))
                angle += np.maximum(most - least, 0.0) / (2 * np.pi)
    return angle
