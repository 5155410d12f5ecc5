"""Force curves: the load and contact of one asperity at many displacements, by the laws of ``asperity_laws``.

The laws of free shape are read from splines over (B/A, displacement). B/A of an asperity is fixed, so that its splines
can be summed across once and read along a line afterwards: 4 products in place of 16, and the slope with the load.

δ*         displacement in the asperity's own units (``asperity_laws.Scales``)
above_end  δ* counted from the end of the stable branch
q          √above_end, in which a branch is smooth at its end

Loads, semi-axes and displacements are in the asperity's own units. Source: own, from the splines of ``elliptic_table``.
"""

from math import sqrt

from ..jit import kernel
from . import jkr
from .elliptic_table import CELLS_ALONG, A, B, P, coefficient_at_row, spline_value, spline_weights

#: Number of coefficients along a branch.
LENGTH = CELLS_ALONG + 3


@kernel
def collapse(table, row, column, out):
    """Sum a column of a law's table across at the position ``row``: ``out`` has shape (LENGTH,)."""
    for j in range(out.size):
        out[j] = coefficient_at_row(table, row, j, column)


@kernel
def line_force(line, above_end):
    """Return P* and dP*/dδ* at ``above_end`` > 0 on a collapsed branch: P* = f(z) (1 + q)³, z = (1 + q)^−½."""
    q = sqrt(above_end)
    size = 1.0 + q
    along = CELLS_ALONG / sqrt(size)
    j = min(int(along), CELLS_ALONG - 1)
    t = along - j
    u = 1.0 - t
    f = spline_value(spline_weights(t), line, j)
    rises = line[j + 1] - line[j], line[j + 2] - line[j + 1], line[j + 3] - line[j + 2]
    df = 0.5 * (u * u * rises[0] + t * t * rises[2]) + (0.5 + t * u) * rises[1]
    return f * size * size * size, (3.0 * f - 0.5 * along * df) * size * size / (2.0 * q)


@kernel
def closed_force(delta):
    """Return P* and dP*/dδ* of the closed form (JKR) at δ* above the end of its branch."""
    a = jkr.stable_semi_axis(delta)
    root = a * sqrt(a)
    return root * (root - 2.0), 1.5 * a * (root - 1.0) / (root - 1.0 / 3.0)


@kernel
def line_contact(lines, above_end):
    """Return P*, a* and b*/λ at ``above_end`` ≥ 0 on collapsed branches: (3, LENGTH), rows ``P``, ``A``, ``B``."""
    size = 1.0 + sqrt(above_end)
    along = CELLS_ALONG / sqrt(size)
    j = min(int(along), CELLS_ALONG - 1)
    w = spline_weights(along - j)
    p = spline_value(w, lines[P], j)
    a = spline_value(w, lines[A], j)
    b = spline_value(w, lines[B], j)
    return p * size * size * size, a * size, b * size


@kernel
def closed_contact(delta, end):
    """Return P*, a* and b*/λ of the closed forms at δ* ≥ ``end``: Hertz's where ``end`` is 0, else JKR's."""
    if end == 0.0:
        a = sqrt(delta)
        return delta * a, a, a
    a = jkr.stable_semi_axis(delta)
    return jkr.load(a), a, a
