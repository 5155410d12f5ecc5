"""Summits of a surface: local maxima among eight neighbours, flat tops counted once.

Cheng, Dunn & Brach take as asperity every point that is higher than its neighbours. A digitised scan has
adjacent pixels of equal height, so the rule is applied to plateaus: a plateau is a set of pixels of one height,
connected by sides or corners; it is a peak when every pixel around it is strictly lower. A single pixel is the
smallest plateau.

Heights outside the scan and at missing (NaN) pixels are unknown: a plateau with a pixel of the outermost ring, or with
a NaN neighbour, may not be a maximum and is not a peak.

A ridge that runs across the pixels' rows has several highest pixels, where its crest passes near pixel centres. They
are one summit if the interpolated surface rises from all of them to one point (`ascend`).

Letters: z heights (nm) as z[ix, iy]; n a plateau's number of pixels.
"""

from typing import NamedTuple

import numpy as np

_NEIGHBOURHOOD = np.ones((3, 3))

#: Longest step of an ascent, pixels.
_LONGEST_STEP = 0.5

#: Largest number of steps.
_MOST_STEPS = 200

#: The step that ends an ascent, pixels.
_LAST_STEP = 1e-4


class Peaks(NamedTuple):
    """Peaks in the order in which a walk along the rows z[0], z[1], … first meets them."""

    ix: np.ndarray  # first index of the plateau's pixel nearest its centroid; of equally near ones the first
    iy: np.ndarray  # second index
    size: np.ndarray  # number of pixels of the plateau


def search(z: np.ndarray) -> Peaks:
    """Return the :class:`Peaks` of the heights ``z[ix, iy]``."""
    from scipy.ndimage import label, maximum_filter

    if min(z.shape) < 3:
        return Peaks(*np.zeros((3, 0), np.int64))
    z = np.where(np.isnan(z), np.inf, z)
    top = (z == maximum_filter(z, 3)) & (z < np.inf)
    top[[0, -1], :] = top[:, [0, -1]] = False
    lower = np.where(top, -np.inf, z)
    # next to a pixel of equal height that is not a top: its plateau is not a peak
    shelf = top & (maximum_filter(lower, 3) == z)
    plateaus, count = label(top, _NEIGHBOURHOOD)
    is_peak = np.ones(count + 1, np.bool_)
    is_peak[plateaus[shelf]] = False
    ix, iy = np.nonzero(top & is_peak[plateaus])
    number = plateaus[ix, iy]  # in the order in which the rows meet them
    n, sum_x, sum_y = (np.bincount(number, weights) for weights in (None, ix, iy))
    off_centroid = (n[number] * ix - sum_x[number]) ** 2 + (n[number] * iy - sum_y[number]) ** 2  # n² times the square
    order = np.lexsort((off_centroid, number))  # stable: of equally near pixels the first comes first
    nearest = order[np.unique(number[order], return_index=True)[1]]
    return Peaks(ix[nearest], iy[nearest], n[number[nearest]])


def ascend(surface, points):
    """Return the summits, (n, 2), to which an interpolated surface rises from points (n, 2), in pixels.

    ``surface(x, y, dx=…, dy=…)`` returns heights or their derivatives. Steps are Newton's, uphill also where the
    surface is not convex.
    """
    points = np.array(points, dtype=float)
    rising = np.arange(len(points))
    for _ in range(_MOST_STEPS):
        x, y = points[rising].T
        slope = np.stack([surface(x, y, dx=1), surface(x, y, dy=1)], axis=-1)
        mixed = surface(x, y, dx=1, dy=1)
        bend = np.array([[surface(x, y, dx=2), mixed], [mixed, surface(x, y, dy=2)]])
        curvature, axes = np.linalg.eigh(np.moveaxis(bend, -1, 0))
        curvature = np.abs(curvature)
        # least curvature that scales a step, over the larger one: along a level crest rounding would decide
        floor = 1e-6 * curvature.max(axis=1, keepdims=True) + 1e-300
        along = np.einsum("nij,ni->nj", axes, slope) / np.maximum(curvature, floor)
        step = np.einsum("nij,nj->ni", axes, along)
        length = np.hypot(*step.T)
        points[rising] += step * np.minimum(1.0, _LONGEST_STEP / np.maximum(length, 1e-300))[:, None]
        rising = rising[length > _LAST_STEP]
        if not rising.size:
            break
    return points
