"""The tables of branches that the package ships, computed from the direct solutions.

    python -m tests.asperity_tables

writes both files again, in about half a minute. Tests compare what is shipped with the solutions here.
"""

import numpy as np
from scipy.interpolate import BSpline, PchipInterpolator
from scipy.optimize import brentq

from roughxr.mechanics.kernels.asperity import elliptic_table, jkr, maugis
from roughxr.mechanics.kernels.asperity.ellipse import axis_ratio
from roughxr.mechanics.kernels.asperity.elliptic_jkr import EllipseState, branch_end, contact_at, largest_tension
from roughxr.mechanics.kernels.asperity.elliptic_table import CELLS_ACROSS, CELLS_ALONG, LARGEST_RATIO, Table


def sites(cells):
    """Where to sample, in cells: at every node and half way between."""
    return np.arange(2 * cells + 1) / 2


def fitted(samples, cells):
    """B-spline coefficients along the first axis from ``samples`` at ``sites(cells)``."""
    design = BSpline.design_matrix(sites(cells), np.arange(-3.0, cells + 4.0), 3).toarray()
    return np.tensordot(np.linalg.pinv(design), samples, axes=1)


def tabulate(rows, marks, cells):
    """The table of samples (P*/(1+q)³, a*/(1+q), b*/(λ(1+q))) along rows, and of their marks."""
    samples = np.concatenate([np.ones((len(rows), 1, 3)), np.array(rows)], axis=1)  # Hertz at z = 0
    coefficients = fitted(fitted(samples, cells).swapaxes(0, 1), CELLS_ALONG).swapaxes(0, 1)
    return Table(np.ascontiguousarray(coefficients), fitted(np.array(marks), cells))


# ---------------------------------------------------------------- ellipses of free shape


def stable_state(ratio, delta, s_end=None):
    """The stable contact at displacement δ*; NaN beyond the end of the branch (``s_end``, if known)."""
    s_end = branch_end(ratio) if s_end is None else s_end
    if delta < contact_at(ratio, s_end).delta:
        return EllipseState(np.nan, np.nan, np.nan, delta)

    def excess(log_s):
        return contact_at(ratio, np.exp(log_s)).delta - delta

    return contact_at(ratio, np.exp(brentq(excess, np.log(1e-12), np.log(s_end), xtol=1e-13)))


def sphere_row(z):
    """The row B/A = 1, from the closed form."""
    q = 1 / z**2 - 1
    a = jkr.stable_semi_axis(jkr.END_DELTA + q**2)
    row = np.stack([jkr.load(a) / (1 + q) ** 3, a / (1 + q), a / (1 + q)], axis=-1)
    return row, [jkr.END_DELTA, -1.0, 1.0, 1.0, -1 / 3]


def elliptic_row(ratio, z):
    """One row of samples of the branch, and its marks, by direct solution."""
    lam = axis_ratio(ratio)
    s_end = branch_end(ratio)
    end, pull_off = (contact_at(ratio, s) for s in (s_end, largest_tension(ratio)))
    row = []
    for q in 1 / z**2 - 1:
        state = stable_state(ratio, end.delta + q**2, s_end) if q > 0 else end
        row.append([state.P / (1 + q) ** 3, state.a / (1 + q), state.b / (lam * (1 + q))])
    return row, [end.delta, pull_off.P, pull_off.a, pull_off.b / lam, pull_off.delta]


def elliptic():
    """The table of ellipses of least energy."""
    z = sites(CELLS_ALONG)[1:] / CELLS_ALONG
    ratios = LARGEST_RATIO ** (sites(CELLS_ACROSS)[1:] / CELLS_ACROSS)
    rows, marks = zip(sphere_row(z), *(elliptic_row(ratio, z) for ratio in ratios))
    return tabulate(rows, marks, CELLS_ACROSS)


# ---------------------------------------------------------------- Maugis's sphere


def maugis_row(parameter, z):
    """Samples (P*/(1+q)³, a*/(1+q), twice) along one row, and its marks."""
    P, a, delta = maugis.contact_at(parameter, maugis.ratios())
    end = int(np.argmin(delta))
    weakest = int(np.argmin(P))
    q = np.sqrt(np.maximum(delta[: end + 1] - delta[end], 0.0))[::-1]
    keep = np.append(True, np.diff(np.maximum.accumulate(q)) > 0)
    wanted = 1 / z**2 - 1
    load, radius = (PchipInterpolator(q[keep], values[: end + 1][::-1][keep])(wanted) for values in (P, a))
    radius = radius / (1 + wanted)
    marks = [delta[end], P[weakest], a[weakest], a[weakest], delta[weakest]]
    return np.stack([load / (1 + wanted) ** 3, radius, radius], -1), marks


def maugis_table(cells=maugis.ACROSS):
    """The table of Maugis's sphere, of so many cells across."""
    z = sites(CELLS_ALONG)[1:] / CELLS_ALONG
    parameters = maugis.SMALLEST * (maugis.LARGEST / maugis.SMALLEST) ** (sites(cells) / cells)
    return tabulate(*zip(*(maugis_row(parameter, z) for parameter in parameters)), cells)


def main():
    """Write both files."""
    for file, table in ((elliptic_table.FILE, elliptic()), (maugis.FILE, maugis_table())):
        np.savez_compressed(file, branch=table.spline, marks=table.marks)


if __name__ == "__main__":
    main()
