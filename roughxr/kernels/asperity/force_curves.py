"""An asperity's own branch: what the laws of ``asperity_contact`` say of one asperity at many displacements.

The laws of free shape are read from splines over (B/A, displacement). One asperity keeps its B/A, so that its splines
can be summed across once and read along a line afterwards: 4 products in place of 16, and the slope beside the load.

δ*      displacement in the asperity's own units (``asperity_contact.Scales``), counted from the end of its stable
        branch where it is called ``above_end``
q       √above_end, in which a branch is smooth where it begins
"""

from math import sqrt

from ..jit import kernel
from . import jkr
from .elliptic_table import _CELLS_ALONG, spline_weights

#: Coefficients along a branch.
LENGTH = _CELLS_ALONG + 3

#: Columns of a table: P*, a*, b*/λ, each divided by its growth under load.
P, A, B = range(3)


@kernel
def collapse(table, row, column, out):
    """Sum one column of a law's table across at the place ``row``: ``out`` has shape (LENGTH,)."""
    i = min(int(row), table.shape[0] - 4)
    w0, w1, w2, w3 = spline_weights(row - i)
    for j in range(out.size):
        out[j] = (
            w0 * table[i, j, column]
            + w1 * table[i + 1, j, column]
            + w2 * table[i + 2, j, column]
            + w3 * table[i + 3, j, column]
        )


@kernel
def line_force(line, above_end):
    """Return P* and dP*/dδ* at ``above_end`` > 0 on a collapsed branch: P* = f(z) (1 + q)³, z = (1 + q)^−½."""
    q = sqrt(above_end)
    size = 1.0 + q
    along = _CELLS_ALONG / sqrt(size)
    j = min(int(along), _CELLS_ALONG - 1)
    t = along - j
    u = 1.0 - t
    c0, c1, c2, c3 = line[j], line[j + 1], line[j + 2], line[j + 3]
    w0, w1, w2, w3 = spline_weights(t)
    f = w0 * c0 + w1 * c1 + w2 * c2 + w3 * c3
    df = 0.5 * (u * u * (c1 - c0) + t * t * (c3 - c2)) + (0.5 + t * u) * (c2 - c1)
    return f * size * size * size, (3.0 * f - 0.5 * along * df) * size * size / (2.0 * q)


@kernel
def closed_force(delta):
    """Return P* and dP*/dδ* of the closed form at δ* above the end of its branch."""
    a = jkr.stable_semi_axis(delta)
    root = a * sqrt(a)
    return root * (root - 2.0), 1.5 * a * (root - 1.0) / (root - 1.0 / 3.0)


@kernel(inner=True)
def line_contact(lines, above_end):
    """Return P*, a* and b*/λ at ``above_end`` ≥ 0 on collapsed branches: (LENGTH, 3), columns ``P``, ``A``, ``B``."""
    size = 1.0 + sqrt(above_end)
    along = _CELLS_ALONG / sqrt(size)
    j = min(int(along), _CELLS_ALONG - 1)
    w0, w1, w2, w3 = spline_weights(along - j)
    p = w0 * lines[j, P] + w1 * lines[j + 1, P] + w2 * lines[j + 2, P] + w3 * lines[j + 3, P]
    a = w0 * lines[j, A] + w1 * lines[j + 1, A] + w2 * lines[j + 2, A] + w3 * lines[j + 3, A]
    b = w0 * lines[j, B] + w1 * lines[j + 1, B] + w2 * lines[j + 2, B] + w3 * lines[j + 3, B]
    return p * size * size * size, a * size, b * size


@kernel(inner=True)
def closed_contact(delta, adheres):
    """Return P*, a* and b*/λ of the closed forms at δ* on the branch: JKR's, or Hertz's where nothing adheres."""
    if not adheres:
        a = sqrt(delta)
        return delta * a, a, a
    a = jkr.stable_semi_axis(delta)
    return jkr.load(a), a, a
