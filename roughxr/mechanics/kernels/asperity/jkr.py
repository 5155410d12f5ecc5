"""JKR in its own units: one curve in closed form for the sphere and for every ellipse of Hertz's shape.

    δ* = a*² − (4/3)√a*,   P* = a*³ − 2 a*^{3/2}        (Cheng, Dunn & Brach, eqs. 23-24)

with the units (eqs. 20-22; printed with λ² for λ, and the last as 3P_c = 2πγλ²/β)

    a_c³ = 9γλK/(2β²E*),   δ_c = β a_c²,   P_c = 3πγλ/β.

a*, δ*, P*   semi-axis, displacement and load in these units; from δ* = 0 down to −3^{−1/3}, where the branch
             turns, a* has two values, of which the larger is stable when the displacement is prescribed
w = 2γ       work of adhesion, J/m²
λ, K, β, E*  as in ``ellipse``
"""

from math import pi
from typing import NamedTuple

import numpy as np

from roughxr.mechanics.kernels.asperity.ellipse import elliptic_integrals, shape
from roughxr.mechanics.kernels.jit import kernel

#: a* and δ* at the end of the stable branch under prescribed displacement.
END_A = 3.0 ** (-2 / 3)
END_DELTA = -(3.0 ** (-1 / 3))

#: First guess of τ on the unstable branch, a parabola that is exact at both of its ends, Q = 0 and −√3.
_SLOPE = 6.0**-0.5
_BEND = (1.0 - 0.5**0.5) / 3.0

_SQRT_3_2 = 1.5**0.5


class Units(NamedTuple):
    """a_c nm, P_c nN, δ_c nm."""

    a: float
    P: float
    delta: float


@kernel
def self_similar_units(A, B, E_star, w):
    """Return the units of the paraboloid A x² + B y²; with λw for w, the published units."""
    return ellipse_units(A, B, shape(A, B), E_star, w)


@kernel
def ellipse_units(A, B, lam, E_star, w):
    """Return the self-similar units for a known λ."""
    K, _ = elliptic_integrals(lam)
    beta = A + lam * lam * B
    a = np.cbrt(2.25 * w * lam * K / (beta * beta * E_star))
    return Units(a, 1.5 * pi * w * lam / beta, beta * a * a)


@kernel
def load(a):
    """Return P* at semi-axis a* ≥ 0."""
    root = a * np.sqrt(a)
    return root * (root - 2.0)


@kernel
def displacement(a):
    """Return δ* at semi-axis a* ≥ 0."""
    return a * a - 4.0 / 3.0 * np.sqrt(a)


@kernel
def _semi_axis(Q, tau):
    """Return a* by Newton steps from ``tau``."""
    for _ in range(3):
        root = np.sqrt(6.0 + tau * (4.0 + tau))
        tau -= (tau * root - Q) * root / (6.0 + tau * (6.0 + 2.0 * tau))
    return END_A * (1.0 + tau) ** 2


@kernel
def stable_semi_axis(delta):
    """Return the larger a* at displacement δ* ≥ −3^{−1/3}, to rounding.

    With √a* = 3^{−1/3}(1 + τ) the curve reads τ √(τ² + 4τ + 6) = Q = √(3^{4/3} (δ* + 3^{−1/3})). Its left
    side stays regular where the two branches meet, so three Newton steps are enough everywhere.
    """
    Q = np.sqrt(delta - END_DELTA) / END_A
    return _semi_axis(Q, Q / (np.sqrt(Q + 1.5) + _SQRT_3_2))


@kernel
def unstable_semi_axis(delta):
    """Return the smaller a* at displacement −3^{−1/3} ≤ δ* ≤ 0, to rounding: the same curve at −Q."""
    Q = -np.sqrt(delta - END_DELTA) / END_A
    return _semi_axis(Q, Q * (_SLOPE - _BEND * Q))
