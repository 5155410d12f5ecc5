"""The paraboloid of each peak: a least-squares fit to the k by k pixels around it.

    z = z0 + g·r − (A x² + B y² + C x y)           r = (x, y) from the peak's pixel

(Cheng, Dunn & Brach, eqs. 25–30, which print the height *below* the peak, and whose factor dz/dx² holds for
heights counted in steps dz; with heights in nm it is 1/dx² alone.) Two ways to place the vertex:

"fitted"  all six coefficients are free: a peak between pixels is recovered exactly.
"pixel"   the paper's: the vertex is the peak's pixel, and only A, B, C are free.

In its principal axes the depth is Â x̂² + B̂ ŷ² with Â ≤ B̂ (eqs. 31–33). Their direction is printed with
arctan (eq. 34), which loses the quadrant and fails at A = B; arctan2 keeps it.

Letters: z heights (nm) as z[ix, iy]; dx, dy pixel spacings (nm); k pixels along a patch's side, odd;
g slope at the peak's pixel (1); A, B, C second-order coefficients (nm⁻¹), half the curvatures.
Coefficients are solved in pixels, c = [z0, g_x, g_y, −A, −B, −C] (nm), which keeps every system well scaled.
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view


class Fit(NamedTuple):
    """The fits of all peaks; NaN where too few pixels are known."""

    vertex_x: np.ndarray  # vertex from the peak's pixel, nm
    vertex_y: np.ndarray
    height: np.ndarray  # of the vertex, nm
    curvature_min: np.ndarray  # principal curvatures 2Â ≤ 2B̂, nm⁻¹, positive for a peak
    curvature_max: np.ndarray
    orientation: np.ndarray  # of the flattest direction, from x towards y, in [−π/2, π/2), rad
    fit_rms: np.ndarray  # root mean square of the patch's residuals, nm
    saddle: np.ndarray  # curvature_min <= 0: the paraboloid is no summit
    edge: np.ndarray  # patch cut by the scan's edge or by NaN, fitted on the remaining pixels
    vertex_fixed: np.ndarray  # vertex held at the peak's pixel


def principal(A, B, C):
    """Return curvature_min, curvature_max (nm⁻¹) and the orientation (rad) of the flattest direction.

    Along direction t the curvature is A + B + (A − B) cos 2t + C sin 2t, least at 2t = arctan2(−C, B − A).
    """
    spread = np.hypot(A - B, C)
    flattest = 0.5 * np.arctan2(-C, B - A)
    return A + B - spread, A + B + spread, flattest - np.pi * (flattest >= 0.5 * np.pi)


def fit_paraboloids(z, ix, iy, dx, dy, *, size=5, vertex="fitted"):
    """Return the :class:`Fit` of the peaks at pixels ``ix``, ``iy`` of ``z``, on ``size`` by ``size`` pixels.

    With ``vertex="fitted"`` a peak falls back to ``"pixel"``, and reports it in ``vertex_fixed``, where the free
    fit is no summit or puts it farther than one pixel away, as on quantised or noisy tops.
    """
    patches = sliding_window_view(np.pad(z, size // 2, constant_values=np.nan), (size, size))
    # number of heights fitted in one block
    block = max((2**21) // size**2, 1)
    starts = range(0, max(ix.size, 1), block)
    parts = []
    for start in starts:
        i = ix[start : start + block]
        j = iy[start : start + block]
        heights = patches[i, j].reshape(i.size, size**2) - z[i, j][:, None]
        parts.append(_fit_block(heights, z[i, j], float(dx), float(dy), vertex == "pixel"))
    return Fit(*map(np.concatenate, zip(*parts)))


def _fit_block(heights, level, dx, dy, fixed):
    """Fit patches (peaks, pixels) of heights over their peak's pixel, whose height is the level (nm)."""
    size = round(heights.shape[1] ** 0.5)
    u, v = (offset.ravel() for offset in np.mgrid[:size, :size] - size // 2.0)
    terms = np.stack([np.ones(u.size), u, v, u * u, v * v, u * v], axis=1)
    is_known = np.isfinite(heights)
    c = _coefficients(terms, heights, is_known, 3)
    rejected = np.ones(level.size, np.bool_)
    if not fixed:
        free = _coefficients(terms, heights, is_known, 0)
        rejected = ~_have_near_summits(free, dx, dy)
        c = np.where(rejected[:, None], c, free)
    x, y, height = _vertex(c, dx, dy)
    low, high, orientation = principal(*_second_order(c, dx, dy))
    residual = np.where(is_known, heights - c @ terms.T, 0.0)
    rms = np.sqrt((residual**2).sum(axis=1) / np.maximum(is_known.sum(axis=1), 1))
    rms[~is_known.any(axis=1)] = np.nan
    x = np.where(rejected, 0.0, x)
    y = np.where(rejected, 0.0, y)
    height = level + np.where(rejected, c[:, 0], height)
    return Fit(x, y, height, low, high, orientation, rms, low <= 0, ~is_known.all(axis=1), rejected)


def _have_near_summits(c, dx, dy):
    """Return which paraboloids have a summit within a pixel of their peak."""
    x, y, _ = _vertex(c, dx, dy)
    A, B, C = _second_order(c, dx, dy)
    low, _, _ = principal(A, B, C)
    return (low > 0) & (4 * A * B > C**2) & (np.abs(x) <= dx) & (np.abs(y) <= dy)


def _coefficients(terms, heights, is_known, first):
    """Return c (peaks, 6) by least squares, 0 before ``first``; NaN where the known pixels are too few."""
    c = np.zeros((len(heights), terms.shape[1]))
    whole = is_known.all(axis=1)
    c[whole, first:] = heights[whole] @ np.linalg.pinv(terms[:, first:]).T
    for n in np.flatnonzero(~whole):
        # a term is undetermined if less than this part of it is independent of the other terms
        solved, _, rank, _ = np.linalg.lstsq(terms[is_known[n], first:], heights[n, is_known[n]], rcond=1e-10)
        c[n, first:] = solved if rank == terms.shape[1] - first else np.nan
    c[np.isnan(c).any(axis=1)] = np.nan
    return c


def _second_order(c, dx, dy):
    """Return A, B and C (nm⁻¹)."""
    return -c[:, 3] / dx**2, -c[:, 4] / dy**2, -c[:, 5] / (dx * dy)


def _vertex(c, dx, dy):
    """Return the vertices of the paraboloids: x, y from the pixel and height (nm)."""
    (A, B, C) = _second_order(c, dx, dy)
    gx = c[:, 1] / dx
    gy = c[:, 2] / dy
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = 4 * A * B - C**2
        x = (2 * B * gx - C * gy) / determinant
        y = (2 * A * gy - C * gx) / determinant
        return x, y, c[:, 0] + 0.5 * (gx * x + gy * y)
