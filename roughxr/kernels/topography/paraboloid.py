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

from ..arrays import line, table
from ..jit import kernel

#: The pixels do not determine a term if less than this part of it is independent of the other terms.
_RANK_TOLERANCE = 1e-10


class Paraboloid(NamedTuple):
    """One paraboloid, about the peak's pixel."""

    z0: float  # height at the pixel, above that of the scan, nm
    gx: float  # slope at the pixel, 1
    gy: float
    A: float  # coefficients of x², y², x y, nm⁻¹
    B: float
    C: float


class Design(NamedTuple):
    """What all whole patches share."""

    half: int  # pixels from the patch's middle to its side
    terms: np.ndarray  # (k², 6): the value of c's terms at each pixel
    inverses: np.ndarray  # (2, 6, k²): pseudo-inverse, vertex free and vertex fixed


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
    edge: np.ndarray  # patch cut by the scan's edge or by NaN, fitted on the pixels there are
    vertex_fixed: np.ndarray  # vertex held at the peak's pixel


@kernel
def principal(A, B, C):
    """Return curvature_min, curvature_max (nm⁻¹) and the orientation (rad) of the flattest direction.

    Along direction t the curvature is A + B + (A − B) cos 2t + C sin 2t, least at 2t = arctan2(−C, B − A).
    """
    spread = np.hypot(A - B, C)
    flattest = 0.5 * np.arctan2(-C, B - A)
    if flattest >= 0.5 * np.pi:
        flattest -= np.pi
    return A + B - spread, A + B + spread, flattest


@kernel
def _is_summit(f):
    """Whether both curvatures are positive; asked twice, since rounding may tell the two forms apart."""
    return principal(f.A, f.B, f.C)[0] > 0 and 4 * f.A * f.B > f.C**2


@kernel
def _vertex(f):
    """Return where the paraboloid is level, x and y (nm) from the pixel, and its height there (nm)."""
    determinant = 4 * f.A * f.B - f.C**2
    x = (2 * f.B * f.gx - f.C * f.gy) / determinant
    y = (2 * f.A * f.gy - f.C * f.gx) / determinant
    return x, y, f.z0 + 0.5 * (f.gx * x + f.gy * y)


@kernel
def _is_summit_near(f, dx, dy):
    """Whether the paraboloid has its summit within one pixel of the peak's."""
    if not _is_summit(f):
        return False
    x, y, _ = _vertex(f)
    return abs(x) <= dx and abs(y) <= dy


@kernel
def _gather(z, i, j, half, heights, known):
    """Copy the patch around pixel (i, j), as heights above that pixel; what is not known counts as 0."""
    p = 0
    for u in range(i - half, i + half + 1):
        for v in range(j - half, j + half + 1):
            inside = 0 <= u < z.shape[0] and 0 <= v < z.shape[1]
            height = z[u, v] - z[i, j] if inside else np.nan
            known[p] = np.isfinite(height)
            heights[p] = height if known[p] else 0.0
            p += 1


@kernel(reorder=True)
def _solve_whole(inverse, heights, c):
    for m in range(c.size):
        total = 0.0
        for p in range(heights.size):
            total += inverse[m, p] * heights[p]
        c[m] = total


@kernel
def _dot(a, i, b, j):
    """Return the scalar product of column i of ``a`` and column j of ``b``."""
    total = 0.0
    for p in range(a.shape[0]):
        total += a[p, i] * b[p, j]
    return total


@kernel
def _known_rows(terms, heights, known, first):
    """Return the terms from ``first`` on, and the heights as one more column; rows that are not known are 0."""
    pixels, last = terms.shape
    columns = table(pixels, last + 1, 0.0)
    for p in range(pixels):
        if known[p]:
            for k in range(first, last):
                columns[p, k] = terms[p, k]
            columns[p, last] = heights[p]
    return columns


@kernel
def _solve_clipped(terms, heights, known, first, c):
    """Solve for the coefficients from ``first`` on, the others being 0; all NaN if the pixels are too few.

    Least squares by modified Gram–Schmidt, with the heights as one more column (Björck 1967): as accurate as by
    orthogonal matrices. In plain loops, which compile in a tenth of the time of ``np.linalg.lstsq``.
    """
    pixels, last = terms.shape[0], terms.shape[1]
    columns, upper = _known_rows(terms, heights, known, first), table(last, last + 1, 0.0)
    for k in range(last):
        c[k] = np.nan
    for k in range(first, last):
        length2 = _dot(columns, k, columns, k)
        if length2 <= _RANK_TOLERANCE**2 * _dot(terms, k, terms, k):
            return
        for m in range(k + 1, last + 1):
            upper[k, m] = _dot(columns, k, columns, m) / length2
            for p in range(pixels):
                columns[p, m] -= upper[k, m] * columns[p, k]
    for k in range(last - 1, -1, -1):
        c[k] = upper[k, last]
        for m in range(k + 1, last):
            c[k] -= upper[k, m] * c[m]


@kernel
def _all(known):
    everywhere = True
    for one in known:
        everywhere &= one
    return everywhere


@kernel
def _solve(design, heights, known, fixed, c):
    if _all(known):
        _solve_whole(design.inverses[int(fixed)], heights, c)
    else:
        _solve_clipped(design.terms, heights, known, 3 if fixed else 0, c)


@kernel
def _residual_rms(terms, heights, known, c):
    """Root mean square (nm) of heights minus paraboloid over the known pixels."""
    total, count = 0.0, 0
    for p in range(heights.size):
        if known[p]:
            residual = heights[p]
            for m in range(c.size):
                residual -= terms[p, m] * c[m]
            total += residual * residual
            count += 1
    return np.sqrt(total / count) if count else np.nan


@kernel
def _in_nanometres(c, dx, dy):
    return Paraboloid(c[0], c[1] / dx, c[2] / dy, -c[3] / dx**2, -c[4] / dy**2, -c[5] / (dx * dy))


@kernel
def _fit_patch(design, heights, known, fixed, dx, dy, c):
    """Fit one patch, its vertex at the pixel if asked or if it would leave the peak; return whether it was, too."""
    _solve(design, heights, known, fixed, c)
    f = _in_nanometres(c, dx, dy)
    if fixed or _is_summit_near(f, dx, dy):
        return f, fixed
    _solve(design, heights, known, True, c)
    return _in_nanometres(c, dx, dy), True


@kernel
def _record(fit, n, f, fixed, level):
    """Write paraboloid ``f`` as peak ``n``; ``level`` is the height (nm) of its pixel."""
    x, y, height = (0.0, 0.0, f.z0) if fixed else _vertex(f)
    fit.vertex_x[n], fit.vertex_y[n], fit.height[n] = x, y, level + height
    fit.curvature_min[n], fit.curvature_max[n], fit.orientation[n] = principal(f.A, f.B, f.C)
    fit.saddle[n] = fit.curvature_min[n] <= 0
    fit.vertex_fixed[n] = fixed


@kernel
def _fit_each(z, ix, iy, dx, dy, design, fixed, fit):
    heights = line(design.terms.shape[0], 0.0)
    known = line(heights.size, False)
    c = line(design.terms.shape[1], 0.0)
    for n in range(ix.size):
        _gather(z, ix[n], iy[n], design.half, heights, known)
        f, held = _fit_patch(design, heights, known, fixed, dx, dy, c)
        _record(fit, n, f, held, z[ix[n], iy[n]])
        fit.fit_rms[n] = _residual_rms(design.terms, heights, known, c)
        fit.edge[n] = not _all(known)


def _design(k):
    """Return the :class:`Design` of patches of k by k pixels."""
    half = k // 2
    u, v = (offset.ravel() for offset in np.mgrid[-half : half + 1, -half : half + 1].astype(float))
    terms = np.stack([np.ones(k * k), u, v, u * u, v * v, u * v], axis=1)
    vertex_fixed = np.vstack([np.zeros((3, k * k)), np.linalg.pinv(terms[:, 3:])])
    return Design(half, terms, np.stack([np.linalg.pinv(terms), vertex_fixed]))


def fit_paraboloids(z, ix, iy, dx, dy, *, size=5, vertex="fitted"):
    """Return the :class:`Fit` of the peaks at pixels ``ix``, ``iy`` of ``z``, on ``size`` by ``size`` pixels.

    With ``vertex="fitted"`` a peak falls back to ``"pixel"``, and says so in ``vertex_fixed``, where the free
    fit is no summit or puts it farther than one pixel away, as on quantised or noisy tops.
    """
    numbers = [np.empty(ix.size) for _ in range(7)]
    flags = [np.empty(ix.size, np.bool_) for _ in range(3)]
    fit = Fit(*numbers, *flags)
    _fit_each(z, ix, iy, float(dx), float(dy), _design(size), vertex == "pixel", fit)
    return fit
