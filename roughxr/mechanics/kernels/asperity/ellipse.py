"""The ellipse in which two smooth bodies touch: elliptic integrals and Hertz's contact.

A paraboloid z = A x² + B y², A ≤ B, pressed by δ against a half space touches it in an ellipse whose shape
depends on B/A alone (Johnson, *Contact Mechanics*, 1985, §4.2; Cheng, Dunn & Brach, eqs. 1-7):

    B/A = (E − λ²K) / (λ² (K − E)),   δ = A a² + B b² = p₀ b K/E*,   P = ⅔ π a b p₀.

A, B    half the principal curvatures, 1/(2R′) and 1/(2R″), nm⁻¹
E*      ``E_star``, combined (contact) modulus, GPa
δ       ``delta``, displacement, > 0 brings the bodies together, nm
a, b    semi-axes of the contact ellipse, a ≥ b, nm;  λ = ``lam`` = b/a
e       eccentricity of the ellipse, e² = 1 − λ²: the modulus of the elliptic integrals (SciPy's parameter m is e²)
K, E    complete elliptic integrals of the first and second kind
B̂, D    associate integrals, B̂ = (E − λ²K)/e² = ∫cos²φ/Δ dφ and D = (K − E)/e² = ∫sin²φ/Δ dφ over a quarter
        turn, Δ² = 1 − e² sin²φ. From them K = B̂ + D,  E = B̂ + λ²D and B/A = B̂/(λ²D) follow without loss of
        digits near the circle.
β       ``beta`` = A + λ²B, so that δ = β a², nm⁻¹
P, p₀   ``P``, ``p0``, load, nN, and greatest pressure, GPa
"""

from math import exp, log, pi, sqrt
from typing import NamedTuple

import numpy as np

from roughxr.mechanics.kernels.jit import kernel

#: Relative accuracy of the integrals and of λ, and largest number of steps for λ.
_ROUNDING = 1e-15
_MOST_STEPS = 30


class HertzContact(NamedTuple):
    """Load nN, semi-axes nm, area nm² and greatest pressure GPa of a contact without adhesion."""

    P: float
    a: float
    b: float
    area: float
    p0: float


@kernel
def associate_integrals(lam):
    """Return (B̂, D) for 0 < λ ≤ 1, by the arithmetic-geometric mean.

    Gauss: K = π/(2 agm(1, λ)) and K − E = K Σ 2ⁿ⁻¹cₙ², n ≥ 0, with c₀² = e² and cₙ₊₁ = cₙ²/(4 meanₙ₊₁). Divided
    by e², all terms of the sum are positive, and the first stays ½ as λ → 1.
    """
    mean = 0.5 * (1.0 + lam)
    geometric = sqrt(lam)
    c = 0.5 * (1.0 - lam)
    term = 0.25 * (1.0 - lam) / (1.0 + lam)
    power = 1.0
    share = 0.5 + term
    while c > _ROUNDING * mean:
        mean, geometric = 0.5 * (mean + geometric), sqrt(mean * geometric)
        ratio = 0.25 * c / mean
        c = c * ratio
        term = term * ratio * ratio
        power = 2.0 * power
        share += power * term
    K = 0.5 * pi / mean
    return K * (1.0 - share), K * share


@kernel
def elliptic_integrals(lam):
    """Return (K, E) for an ellipse of axis ratio λ."""
    B_hat, D = associate_integrals(lam)
    return B_hat + D, B_hat + lam * lam * D


@kernel
def curvature_ratio(lam):
    """Return B/A of the paraboloid whose Hertzian contact has the axis ratio λ (eq. 7)."""
    B_hat, D = associate_integrals(lam)
    return B_hat / (lam * lam * D)


@kernel
def axis_ratio(ratio):
    """Return λ = b/a of Hertz's ellipse on a paraboloid of B/A = ``ratio`` ≥ 1 (the inverse of eq. 7); else NaN.

    Secant steps for ln λ against ln B/A, a nearly straight line that leaves the circle with slope −2/3.
    """
    if not 1.0 <= ratio < np.inf:
        return np.nan
    target = log(ratio)
    x_old = 0.0
    f_old = -target
    x = -2.0 / 3.0 * target
    for _ in range(_MOST_STEPS):
        f = log(curvature_ratio(exp(x))) - target
        if f == f_old or abs(x - x_old) <= _ROUNDING:
            break
        x_old, f_old, x = x, f, x - f * (x - x_old) / (f - f_old)
    return exp(x)


@kernel
def shape(A, B):
    """Return λ of Hertz's ellipse on the paraboloid A x² + B y², NaN unless 0 < A ≤ B."""
    return axis_ratio(B / A) if A > 0.0 else np.nan


@kernel
def axis_ratios(A, B):
    """Return λ of Hertz's ellipse on each of many paraboloids."""
    lam = np.empty(A.size)
    for n in range(lam.size):
        lam[n] = shape(A[n], B[n])
    return lam


@kernel
def stiffness(A, B, lam, E_star):
    """Return (β, H) of a = √(δ/β) and P = H δ^{3/2}, in nm⁻¹ and nN nm^{−3/2}: H = 2πE*/(3K√β)."""
    K, _ = elliptic_integrals(lam)
    beta = A + lam * lam * B
    return beta, 2.0 * pi * E_star / (3.0 * K * sqrt(beta))


@kernel
def hertz(delta, A, B, E_star):
    """Return Hertz's contact of the paraboloid A x² + B y² at displacement ``delta``; no contact at δ ≤ 0."""
    lam = shape(A, B)
    beta, H = stiffness(A, B, lam, E_star)
    depth = max(delta, 0.0)
    P = H * depth * sqrt(depth)
    a = sqrt(depth / beta)
    area = pi * lam * a * a
    return HertzContact(P, a, lam * a, area, 1.5 * P / area if area > 0.0 else area)
