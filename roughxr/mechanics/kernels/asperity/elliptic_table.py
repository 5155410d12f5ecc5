"""Table of the branch of ``elliptic_jkr``, which has no closed form.

Its two coordinates cover all shapes up to a limit, and all loads up to infinity:

    across   ln(B/A) from 0 (circle) to ln 10⁴, in even rows; a flatter asperity is read as B/A = 10⁴,
    along    z = (1 + q)^{−1/2},  q = √(δ* − δ*_end):  z = 1 is the turning point, about which contact varies
             as q, and z = 0 infinite load, about which JKR is a series in δ*^{−1/4} ~ z.

Tabulated are P*/(1+q)³, a*/(1+q) and b*/(λ(1+q)), in self-similar units: smooth everywhere, and 1 at z = 0
(Hertz). They are interpolated by cubic B-splines, with continuous second derivatives, fitted by least squares at
twice as many points. Errors against the direct solution, of the marks as well, are below 10⁻⁶, relative to P_c and
a_c, or to P and a where these are larger. Source: own.

P*, a*, b*, δ*   load, semi-axes and displacement in the units of ``jkr``;  λ = b/a of Hertz's ellipse (``ellipse``)

``python -m tests.asperity_tables`` computes the file, in about half a minute.
"""

from functools import cache
from math import log, sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np

from roughxr.mechanics.kernels.jit import kernel

#: Largest B/A of the table; flatter asperities are read at this ratio.
LARGEST_RATIO = 1e4
FILE = Path(__file__).with_name("elliptic_table.npz")

#: Number of spline cells along the first coordinate.
CELLS_ACROSS = 20

#: Number of spline cells along the second coordinate.
CELLS_ALONG = 48

#: Columns of splines and marks: NumPy's integers, since Numba compiles a function again for every literal number.
P, A, B = np.arange(3)
END, LEAST = np.arange(2)
_PER_LOG = CELLS_ACROSS / log(LARGEST_RATIO)
_SIXTH = 1.0 / 6.0  # a product is quicker than a quotient


class Table(NamedTuple):
    """Spline coefficients of one law."""

    spline: np.ndarray  # (across, along, 3): P*/(1+q)³, a*/(1+q), b*/(λ(1+q))
    marks: np.ndarray  # (across, 5): δ*_end; P*, a*, b*/λ, δ* at the largest tension


EMPTY = Table(np.empty((0, 0, 3)), np.empty((0, 5)))


@kernel
def spline_weights(t):
    """Return the four cubic B-splines over a cell, at 0 ≤ t ≤ 1 within it."""
    u = 1.0 - t
    return (
        u * u * u * _SIXTH,
        2.0 / 3.0 - t * t * (1.0 - 0.5 * t),
        2.0 / 3.0 - u * u * (1.0 - 0.5 * u),
        t * t * t * _SIXTH,
    )


@kernel
def spline_value(w, coefficients, j):
    """Return the spline in the ``j``-th cell, for the weights ``w`` there."""
    return w[0] * coefficients[j] + w[1] * coefficients[j + 1] + w[2] * coefficients[j + 2] + w[3] * coefficients[j + 3]


@kernel
def table_row(ratio):
    """Return the position across the table, in cells, of a paraboloid of B/A = ``ratio``."""
    return min(_PER_LOG * log(ratio), float(CELLS_ACROSS))


@kernel
def mark_at_row(marks, row, column):
    """Return a column of ``marks``, interpolated at the position ``row``."""
    i = min(int(row), marks.shape[0] - 4)
    return spline_value(spline_weights(row - i), marks[:, column], i)


@kernel
def coefficient_at_row(spline, row, j, column):
    """Return a coefficient along the branch, for the asperity at the position ``row``."""
    i = min(int(row), spline.shape[0] - 4)
    return spline_value(spline_weights(row - i), spline[:, j, column], i)


@kernel
def lookup(spline, row, above_end):
    """Return (P*, a*, b*/λ) at the displacement δ* − δ*_end = ``above_end`` ≥ 0 of the stable branch."""
    size = 1.0 + sqrt(above_end)
    along = CELLS_ALONG / sqrt(size)
    j = min(int(along), CELLS_ALONG - 1)
    w = spline_weights(along - j)
    p = _branch_value(spline, row, j, P, w)
    a = _branch_value(spline, row, j, A, w)
    b = _branch_value(spline, row, j, B, w)
    return p * size * size * size, a * size, b * size


@kernel
def _branch_value(spline, row, j, column, w):
    total = 0.0
    for n in range(4):
        total += w[n] * coefficient_at_row(spline, row, j + n, column)
    return total


@cache
def table():
    """Return the table, read on first use."""
    with np.load(FILE) as file:
        return Table(file["branch"], file["marks"])
