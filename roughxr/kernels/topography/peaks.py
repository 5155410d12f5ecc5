"""Summits of a surface: local maxima among eight neighbours, flat tops counted once.

Cheng, Dunn & Brach take as asperity every point that is higher than its neighbours. A digitised scan has
equal heights side by side, so the rule is applied to plateaus: a plateau is a set of pixels of one height,
connected by sides or corners; it is a peak when every pixel around it is strictly lower. One pixel alone is
the smallest plateau.

What lies outside the scan, or under a missing (NaN) pixel, is unknown: a plateau that holds a pixel of the
outermost ring, or that has a NaN neighbour, is not known to be a maximum and is not a peak.

Letters: z heights (nm) as z[ix, iy]; i, j a pixel; n a plateau's number of pixels.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import line
from ..jit import kernel


class Peaks(NamedTuple):
    """Peaks in the order in which a walk along the rows z[0], z[1], … first meets them."""

    ix: np.ndarray  # first index of the plateau's pixel nearest its centroid
    iy: np.ndarray  # second index
    size: np.ndarray  # number of pixels of the plateau


@kernel
def _mark_unsurpassed(west, row, east, unsurpassed):
    """Mark the inner pixels of ``row`` that no neighbour exceeds; comparing with NaN marks nothing.

    Free of branches, so that it runs on vector registers at the speed of memory. The shifted views spare
    the test for negative indices, which would forbid that.
    """
    middle, south, north = row[1:-1], row[:-2], row[2:]
    west_south, west_middle, west_north = west[:-2], west[1:-1], west[2:]
    east_south, east_middle, east_north = east[:-2], east[1:-1], east[2:]
    for j in range(middle.size):
        z = middle[j]
        unsurpassed[j] = (
            (z >= south[j])
            & (z >= north[j])
            & (z >= west_south[j])
            & (z >= west_middle[j])
            & (z >= west_north[j])
            & (z >= east_south[j])
            & (z >= east_middle[j])
            & (z >= east_north[j])
        )


@kernel
def on_border(shape, i, j):
    return i == 0 or j == 0 or i == shape[0] - 1 or j == shape[1] - 1


@kernel
def _flood(z, i, j, seen, plateau):
    """Fill the plateau around an inner pixel; return its size, and whether all around it is lower.

    The fill goes on after the plateau has failed: every pixel is then seen once, and the cost stays O(N).
    It does not walk along the border, where a pixel has no eight neighbours.
    """
    top = z[i, j]
    seen[i, j] = True
    plateau[0, 0], plateau[0, 1] = i, j
    done, n, is_peak = 0, 1, True
    while done < n:
        i, j = plateau[done, 0], plateau[done, 1]
        done += 1
        for p in range(i - 1, i + 2):
            for q in range(j - 1, j + 2):
                if z[p, q] < top:
                    continue
                if z[p, q] != top or on_border(z.shape, p, q):  # higher, NaN, or open to the outside
                    is_peak = False
                elif not seen[p, q]:
                    seen[p, q] = True
                    plateau[n, 0], plateau[n, 1] = p, q
                    n += 1
    return n, is_peak


@kernel
def _nearest_centroid(pixels):
    """Return the plateau's pixel nearest its centroid; of equals the first in the scan."""
    n, sum_i, sum_j = len(pixels), 0, 0
    for i, j in pixels:
        sum_i, sum_j = sum_i + i, sum_j + j
    best_i, best_j, best = pixels[0, 0], pixels[0, 1], np.inf
    for i, j in pixels:
        distance = float(n * i - sum_i) ** 2 + float(n * j - sum_j) ** 2  # whole numbers, so that equal ones tie
        if (distance, i, j) < (best, best_i, best_j):
            best_i, best_j, best = i, j, distance
    return best_i, best_j


@kernel
def search(z):
    """Return the :class:`Peaks` of the heights ``z[ix, iy]``."""
    nx, ny = z.shape
    most = (max(nx - 1, 0) // 2) * (max(ny - 1, 0) // 2)  # peaks do not touch: one in two by two pixels
    peaks = np.empty((3, most), np.int32)  # the system lends these pages, and the next, only as they are touched
    plateau = np.empty((z.size, 2), np.int32)
    unsurpassed = line(max(ny - 2, 0), False)
    seen = np.zeros(z.shape, np.bool_)
    count = 0
    for i in range(1, nx - 1):
        _mark_unsurpassed(z[i - 1], z[i], z[i + 1], unsurpassed)
        for j in range(1, ny - 1):
            if not unsurpassed[j - 1] or seen[i, j]:
                continue
            n, is_peak = _flood(z, i, j, seen, plateau)
            if is_peak:
                peaks[0, count], peaks[1, count] = _nearest_centroid(plateau[:n])
                peaks[2, count] = n
                count += 1
    columns = peaks[:, :count].astype(np.int64)
    return Peaks(columns[0], columns[1], columns[2])
