"""Displacement of a half space under a uniformly loaded square: Love's coefficients.

A unit pressure on a square cell of unit side sinks the surface of a half space of unit modulus, at offset
(x, y) from the cell's centre, by

    u = [ f(x₊, y₊) − f(x₊, y₋) − f(x₋, y₊) + f(x₋, y₋) ] / π,     x± = x ± ½,  y± = y ± ½,
    f(s, t) = s asinh(t/|s|) + t asinh(s/|t|)                 (the integral of 1/r over the cell)

(Love 1929; Johnson, Contact Mechanics, eq. 3.25; Cheng, Dunn & Brach eqs. 40–42, whose "0.3" reads 0.5 and
whose compliances add). Cells of side dx on a half space of modulus E* sink by u dx/E* per unit pressure.
"""

from functools import lru_cache

import numpy as np


@lru_cache(maxsize=8)
def love_coefficients(rows, columns):
    """Return the displacements at offsets (i, j), i < rows, j < columns, of a unit pressure (read only).

    Examples
    --------
    The centre of the loaded square itself sinks by 4 asinh(1)/π:

    >>> round(float(love_coefficients(1, 1)[0, 0]), 6)
    1.1222
    """
    table = cell_integrals(rows, columns, 0.0) / np.pi
    table.setflags(write=False)
    return table


def cell_integrals(rows, columns, depth):
    """Return the integral of 1/√(r² + d²) over the cell at each offset, for a depth or several (…, 1, 1)."""
    # neighbouring cells share their corners; none passes through a centre, so s, t ≠ 0
    s = np.arange(rows + 1)[:, None] - 0.5
    t = np.arange(columns + 1) - 0.5
    corners = s * np.arcsinh(t / np.hypot(s, depth)) + t * np.arcsinh(s / np.hypot(t, depth))
    with np.errstate(divide="ignore"):  # at no depth the last term is 0
        corners = corners - depth * np.arctan(s * t / (depth * np.sqrt(s**2 + t**2 + depth**2)))
    return corners[..., 1:, 1:] - corners[..., 1:, :-1] - corners[..., :-1, 1:] + corners[..., :-1, :-1]
