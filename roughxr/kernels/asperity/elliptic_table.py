"""The branches of ``elliptic_jkr``, which have no closed form, as a table small enough to ship.

One plane holds each formulation whole, and extends to infinite load:

    across   ln(B/A) from 0 (circle) to ln 10⁴, in even rows; a flatter asperity is read as B/A = 10⁴,
    along    z = (1 + q)^{−1/2},  q = √(δ* − δ*_end):  z = 1 is the turning point, about which contact varies
             as q, and z = 0 infinite load, about which JKR is a series in δ*^{−1/4} ~ z.

Tabulated are P*/(1+q)³, a*/(1+q) and b*/(λ(1+q)), in self-similar units: smooth on the plane, and 1 at z = 0
(Hertz). Cubic B-splines, with continuous second derivatives, join them, fitted by least squares at twice as
many points. Against the direct solution these values and the marks are off by less than 10⁻⁶ (``energy``) and
5·10⁻⁶ (``johnson_greenwood``), relative to P_c and a_c, or to P and a where these are larger. Source: own.

P*, a*, b*, δ*   load, semi-axes and displacement in the units of ``jkr``;  λ = b/a of Hertz's ellipse (``ellipse``)

``python -m roughxr.kernels.asperity.elliptic_table`` computes the file again, in about half a minute.
"""

from functools import cache
from math import log, sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np

from roughxr.kernels.asperity import jkr
from roughxr.kernels.asperity.ellipse import axis_ratio
from roughxr.kernels.asperity.elliptic_jkr import (
    FORMULATIONS,
    contact_at,
    end_of_branch,
    largest_tension,
    stable_state,
)
from roughxr.kernels.jit import kernel

LARGEST_RATIO = 1e4
FILE = Path(__file__).with_name("elliptic_table.npz")
_CELLS_ACROSS, CELLS_ALONG = 20, 48
_PER_LOG = _CELLS_ACROSS / log(LARGEST_RATIO)
_SIXTH = 1.0 / 6.0  # a product is quicker than a quotient


class Table(NamedTuple):
    """Spline coefficients of one formulation."""

    spline: np.ndarray  # (across, along, 3): P*/(1+q)³, a*/(1+q), b*/(λ(1+q))
    marks: np.ndarray  # (across, 5): δ*_end; P*, a*, b*/λ, δ* at the largest tension


EMPTY = Table(np.empty((0, 0, 3)), np.empty((0, 5)))


@kernel
def spline_weights(t):
    """The four cubic B-splines over a cell, at 0 ≤ t ≤ 1 within it."""
    u = 1.0 - t
    return (
        u * u * u * _SIXTH,
        2.0 / 3.0 - t * t * (1.0 - 0.5 * t),
        2.0 / 3.0 - u * u * (1.0 - 0.5 * u),
        t * t * t * _SIXTH,
    )


@kernel
def spline_value(w, c0, c1, c2, c3):
    """The spline with coefficients c0 … c3 around a cell, at the place of the weights ``w``."""
    return w[0] * c0 + w[1] * c1 + w[2] * c2 + w[3] * c3


@kernel
def row_of(ratio):
    """The place across the table of a paraboloid of B/A = ``ratio``, in cells."""
    return min(_PER_LOG * log(ratio), float(_CELLS_ACROSS))


@kernel
def mark(marks, row, column):
    """One column of ``marks`` at the place ``row``."""
    i = min(int(row), marks.shape[0] - 4)
    w = spline_weights(row - i)
    return spline_value(w, marks[i, column], marks[i + 1, column], marks[i + 2, column], marks[i + 3, column])


@kernel
def across(spline, row, j, column):
    """One coefficient along the branch, for the asperity at the place ``row``."""
    i = min(int(row), spline.shape[0] - 4)
    w = spline_weights(row - i)
    return spline_value(
        w, spline[i, j, column], spline[i + 1, j, column], spline[i + 2, j, column], spline[i + 3, j, column]
    )


@kernel
def lookup(spline, row, above_end):
    """(P*, a*, b*/λ) at the displacement δ* − δ*_end = ``above_end`` ≥ 0 of the stable branch."""
    size = 1.0 + sqrt(above_end)
    along = CELLS_ALONG / sqrt(size)
    j = min(int(along), CELLS_ALONG - 1)
    w = spline_weights(along - j)
    P, a, b = _along(spline, row, j, 0, w), _along(spline, row, j, 1, w), _along(spline, row, j, 2, w)
    return P * size * size * size, a * size, b * size


@kernel
def _along(spline, row, j, column, w):
    return spline_value(
        w,
        across(spline, row, j, column),
        across(spline, row, j + 1, column),
        across(spline, row, j + 2, column),
        across(spline, row, j + 3, column),
    )


@cache
def table(formulation):
    """The shipped table of a formulation, read on first use."""
    with np.load(FILE) as file:
        return Table(file[f"{formulation}_branch"], file[f"{formulation}_marks"])


def _sites(cells):
    """Where to sample, in cells: at every node and half way between."""
    return np.arange(2 * cells + 1) / 2


def _fit(samples, cells):
    """B-spline coefficients along the first axis from ``samples`` at ``_sites(cells)``."""
    knots = np.arange(-3.0, cells + 4.0)
    from scipy.interpolate import BSpline  # needed to make the table, not to read it

    design = BSpline.design_matrix(_sites(cells), knots, 3).toarray()
    return np.tensordot(np.linalg.pinv(design), samples, axes=1)


def _sphere_row(z):
    """The row B/A = 1, from the closed form."""
    q = 1 / z**2 - 1
    a = jkr.stable_semi_axis(jkr.END_DELTA + q**2)
    row = np.stack([jkr.load(a) / (1 + q) ** 3, a / (1 + q), a / (1 + q)], axis=-1)
    return row, [jkr.END_DELTA, -1.0, 1.0, 1.0, -1 / 3]


def _elliptic_row(formulation, ratio, z):
    """One row of samples of the branch, and its marks, by direct solution."""
    lam, s_end = axis_ratio(ratio), end_of_branch(formulation, ratio)
    end, pull_off = (contact_at(formulation, ratio, s) for s in (s_end, largest_tension(formulation, ratio)))
    row = []
    for q in 1 / z**2 - 1:
        state = stable_state(formulation, ratio, end.delta + q**2, s_end) if q > 0 else end
        row.append([state.P / (1 + q) ** 3, state.a / (1 + q), state.b / (lam * (1 + q))])
    return row, [end.delta, pull_off.P, pull_off.a, pull_off.b / lam, pull_off.delta]


def compute(formulation):
    """The table of a formulation, from direct solutions."""
    z = _sites(CELLS_ALONG)[1:] / CELLS_ALONG
    ratios = np.exp(_sites(_CELLS_ACROSS)[1:] / _PER_LOG)
    rows, marks = zip(_sphere_row(z), *(_elliptic_row(formulation, ratio, z) for ratio in ratios))
    samples = np.concatenate([np.ones((len(rows), 1, 3)), np.array(rows)], axis=1)  # Hertz at z = 0
    across = _fit(samples, _CELLS_ACROSS)
    both = _fit(across.swapaxes(0, 1), CELLS_ALONG).swapaxes(0, 1)
    return Table(np.ascontiguousarray(both), _fit(np.array(marks), _CELLS_ACROSS))


def write(file=FILE):
    """Compute all tables and store them."""
    tables = {name: compute(name) for name in FORMULATIONS}
    arrays = {f"{name}_branch": t.spline for name, t in tables.items()}
    arrays |= {f"{name}_marks": t.marks for name, t in tables.items()}
    np.savez_compressed(file, **arrays)


if __name__ == "__main__":
    write()
