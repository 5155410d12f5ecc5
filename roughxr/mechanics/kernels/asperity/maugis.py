"""Maugis's sphere with Dugdale's law of adhesion, between JKR and DMT, as a table of an asperity's contact.

With m = c/a, the annulus a < r < c under the tension σ₀ (Maugis, J. Colloid Interface Sci. 150, 243, 1992),

    ½ λA² [s + (m² − 2) t] + (4/3) λ²A [s t − m + 1] = 1,        s = √(m² − 1),  t = arctan s,
    P̄ = A³ − λA² (s + m² t),        δ̄ = A² − (4/3) λA s,        λ = 2σ₀ (R/(πwK²))^{1/3},  K = 4E*/3,

A, P̄, δ̄ in units (πwR²/K)^{1/3}, πwR, (π²w²R/K²)^{1/3}; here given in JKR's a_c, P_c, δ_c (``jkr``). λ → ∞ is
JKR, λ → 0 DMT; λ = 1.157 μ with Tabor's μ. A branch is followed from large loads down to its smallest δ, where it
turns (λ ≳ 0.94), or until the contact shrinks to a point; attraction across the gap beyond is neglected. The whole
branch is convex: dP̄/dδ̄ grows with δ̄.

The table has the form of ``elliptic_table`` and is read by the same ``lookup``, ln λ in place of ln B/A. Its error
against the closed form is 10⁻³ P_c near the end of the branch for 0.5 < λ < 1.5, where the end changes from a fold to a
point, and below 10⁻⁴ P_c elsewhere; 10⁻⁷ for the largest tension, 2·10⁻⁵ δ_c for the end.
``python -m tests.asperity_tables`` computes it, in a few seconds.
"""

from functools import cache
from math import log
from pathlib import Path

import numpy as np

from ..jit import kernel
from .elliptic_table import Table

#: Smallest λ in the table; below it the end is read, nearly DMT.
SMALLEST = 0.02

#: Largest λ in the table; above it the end is read, nearly JKR.
LARGEST = 50.0
FILE = Path(__file__).with_name("maugis_table.npz")

#: Number of spline cells across.
ACROSS = 80
_PER_LOG = ACROSS / log(LARGEST / SMALLEST)

#: Maugis's λ over Tabor's μ, with Dugdale's σ₀ the largest traction of Lennard-Jones, 16w/(9√3 z0).
PER_TABOR = 1.157

#: JKR's units in Maugis's.
_A, _P, _DELTA = 1.5 ** (1 / 3), 1.5, 1.5 ** (2 / 3)


@kernel
def tabor(A, B, E_star, w, z0):
    """Return Tabor's μ = (R w²/(E*² z0³))^{1/3} of the paraboloid A x² + B y², R = 1/(2√(AB)); lengths in nm."""
    return np.cbrt(w * w / (2.0 * np.sqrt(A * B) * E_star * E_star * z0**3))


@kernel
def parameter(tabor):
    """Return Maugis's λ of Tabor's μ."""
    return PER_TABOR * tabor


@kernel
def table_row(parameter):
    """Return the position of λ across the table, in cells; beyond its ends JKR's and DMT's."""
    return _PER_LOG * log(min(max(parameter, SMALLEST), LARGEST) / SMALLEST)


def contact_at(parameter, m):
    """Return (P*, a*, δ*) in JKR's units at ratios m > 1 of the outer to the inner radius."""
    lam = parameter
    s = np.sqrt((m - 1) * (m + 1))
    t = np.arctan(s)
    half = 4 / 3 * lam**2 * (s * t - m + 1)
    quadratic = lam * (s + (m * m - 2) * t)
    A = 2 / (half + np.sqrt(half**2 + 2 * quadratic))
    P = A**3 - lam * A**2 * (s + m * m * t)
    return P / _P, A / _A, (A**2 - 4 / 3 * lam * A * s) / _DELTA


def pull_off(parameter):
    """Return the pull-off force P_c/(πwR).

    Examples
    --------
    >>> round(float(pull_off(1.0)), 4)
    1.6007
    """
    return -_P * contact_at(parameter, ratios())[0].min()


@cache
def table():
    """Return the table, read on first use."""
    with np.load(FILE) as file:
        return Table(file["branch"], file["marks"])


def ratios():
    """Return the ratios m along a whole branch."""
    return 1 + np.geomspace(1e-9, 1e7, 200_001)
