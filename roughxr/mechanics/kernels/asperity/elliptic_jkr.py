"""Adhesive contact on an ellipse of free shape: JKR of stationary energy, which has no closed form.

On the paraboloid z = A x² + B y² the pressure over an ellipse of semi-axes a ≥ b is taken as

    p = (c₀ + c₁ x²/a² + c₂ y²/b²) / √(1 − x²/a² − y²/b²),

whose surface displacement is quadratic (potentials of the ellipse: Johnson, *Contact Mechanics*, 1985, §3.5).
Fitting it to A and B gives c₁ and c₂. At the edge, at eccentric angle φ, the intensity of the tension is
c(φ) = c₀ + c₁cos²φ + c₂sin²φ = m + d cos 2φ < 0, and opening the contact by unit area frees the elastic
energy G = πc²/(2E*g), g = √(cos²φ/a² + sin²φ/b²). G = w cannot hold on the whole edge. The energy is stationary
in a and in b where ∮c²cos²φ/g dφ = ∮c²sin²φ/g dφ = 2E*w (close to Giudici, Vella & Griffiths, arXiv 2407.00378).

The shape k = b/a alone determines m/d, and their size then a: the branch, stable and unstable, is explicit
in k. It runs from Hertz's ellipse k = λ (infinite load) to the circle k = 1 (no contact), with the parameter

    s in (0, 1),   k = λ^{1−s}.

A, B    half the principal curvatures, nm⁻¹; only B/A = ``ratio`` enters here
w, E*   work of adhesion J/m², contact modulus GPa
δ, P    displacement nm, load nN;  a, b nm

Results are in the units a_c, P_c, δ_c of the self-similar ellipse (``jkr``). This module is plain NumPy,
for tables, figures and tests; loops over asperities read its results from ``elliptic_table``.
"""

from typing import NamedTuple

import numpy as np

from roughxr.mechanics.kernels.asperity.ellipse import axis_ratio
from roughxr.mechanics.kernels.asperity.jkr import self_similar_units


class EllipseState(NamedTuple):
    """P*, a*, b* and δ* of one or many contacts, in self-similar units (b in units of a_c)."""

    P: np.ndarray
    a: np.ndarray
    b: np.ndarray
    delta: np.ndarray


class EdgeFit(NamedTuple):
    """The ansatz on the ellipse a = 1, b = k, fitted to A = 1, B = ratio, with E* = 1."""

    d: np.ndarray  # (c₁ − c₂)/2, so that c(φ) = m + d cos 2φ
    mean: np.ndarray  # (c₁ + c₂)/2 = m − c₀
    delta_c0: np.ndarray  # δ of c₀ = 1 alone
    delta_fit: np.ndarray  # δ of c₁ and c₂


def _quarter_turn(k):
    """Return cos²ψ, sin²ψ and the weight of the midpoint rule, nodes along a new last axis.

    The integrands are analytic and periodic in ψ, with poles at tan ψ = i√k: the error falls as exp(−4N√k).
    """
    n = int(32 + 10 / np.sqrt(np.min(k)))
    psi = (np.arange(n) + 0.5) * np.pi / (2 * n)
    return np.cos(psi) ** 2, np.sin(psi) ** 2, np.pi / (2 * n)


def edge_moments(k):
    """Return ∮ cosⁿ2φ dφ/g around the ellipse a = 1, b = k for n = 0 … 3, by tan φ = √k tan ψ."""
    cos2, sin2, weight = _quarter_turn(k)
    k = np.asarray(k)[..., None]
    stretch = cos2 + k * sin2
    cos_2phi = (cos2 - k * sin2) / stretch
    dphi_by_g = 4 * weight * k / np.sqrt(stretch * (k * cos2 + sin2))
    return [np.sum(dphi_by_g * cos_2phi**n, axis=-1) for n in range(4)]


def potentials(k):
    """Return I_jl = ∫₀^∞ dt / ((1+t)^{j+½} (k²+t)^{l+½} √t) for jl = 00, 10, 01, 20, 11, 02, by t = k tan²ψ."""
    cos2, sin2, weight = _quarter_turn(k)
    k = np.asarray(k)[..., None]
    # 1/(1+t), 1/(k²+t)
    in_a = cos2 / (cos2 + k * sin2)
    in_b = cos2 / (k * (k * cos2 + sin2))
    base = 2 * weight * np.sqrt(k * in_a * in_b) / cos2
    orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    return [np.sum(base * in_a**j * in_b**l, axis=-1) for j, l in orders]


def displacement(c0, c1, c2, k):
    """Return (u₀, u_x, u_y) of the ansatz's displacement u₀ − u_x x² − u_y y² on a = 1, b = k, with E* = 1."""
    I00, I10, I01, I20, I11, I02 = potentials(k)
    both = c0 * I00 + (c1 + c2) * I00 / 2 - (c1 * I10 + c2 * k**2 * I01) / 2
    u_x = (c1 * (I10 - 3 * I20) + c2 * (I10 - k**2 * I11)) / 2
    u_y = (c1 * (I01 - I11) + c2 * (I01 - 3 * k**2 * I02)) / 2
    return k * both, k * u_x, k * u_y


def fit(k, ratio):
    """Fit c₁ and c₂ to the paraboloid's shape: u_x = A = 1, u_y = B = ``ratio``."""
    u0_1, x_1, y_1 = displacement(0, 1, 0, k)
    u0_2, x_2, y_2 = displacement(0, 0, 1, k)
    det = x_1 * y_2 - x_2 * y_1
    c1 = (y_2 - x_2 * ratio) / det
    c2 = (x_1 * ratio - y_1) / det
    return EdgeFit((c1 - c2) / 2, (c1 + c2) / 2, displacement(1, 0, 0, k)[0], c1 * u0_1 + c2 * u0_2)


def _energy(k, d):
    """Return (m, a³), E* = w = 1, of an energy stationary in both axes: the root with tension all around the edge."""
    J0, J1, J2, J3 = edge_moments(k)
    m = -d * (J2 + np.sqrt(J2**2 - J1 * J3)) / J1  # ∮c² cos 2φ/g dφ = 0
    return m, 4 / (m**2 * J0 + 2 * m * d * J1 + d**2 * J2)


def contact_at(ratio, s):
    """Return the contacts at the points ``s`` in (0, 1) of the branch, for one B/A = ``ratio`` > 1."""
    k = axis_ratio(ratio) ** (1 - np.asarray(s))
    on_unit = fit(k, ratio)
    m, a_cubed = _energy(k, on_unit.d)
    a = np.cbrt(a_cubed)
    P = 2 * np.pi * k * (m - on_unit.mean / 3) * a_cubed
    delta = ((m - on_unit.mean) * on_unit.delta_c0 + on_unit.delta_fit) * a**2
    unit = self_similar_units(1.0, ratio, 1.0, 1.0)
    return EllipseState(P / unit.P, a / unit.a, k * a / unit.a, delta / unit.delta)


def _least(ratio, quantity):
    """Return the point s at which ``quantity`` ("P" or "delta") is least."""
    coarse = np.linspace(0.02, 0.98, 97)
    i = np.argmin(getattr(contact_at(ratio, coarse), quantity))
    from scipy.optimize import minimize_scalar  # not at the top: a quarter of the import time

    least = minimize_scalar(
        lambda s: getattr(contact_at(ratio, s), quantity),
        bounds=(coarse[i - 1], coarse[i + 1]),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return least.x


def branch_end(ratio):
    """Return the point s of least displacement, where the stable branch under prescribed displacement ends."""
    return _least(ratio, "delta")


def largest_tension(ratio):
    """Return the point s of pull-off under prescribed load."""
    return _least(ratio, "P")


def states_at_displacement(ratio, delta, *, stable):
    """Return the contacts at displacements ``delta`` between the ends of one branch, by bisection of log s to 1e-13."""
    end = branch_end(ratio)
    # ends of the interval of s that is searched for a displacement
    span = (1e-12, end) if stable else (end, 1 - 1e-9)
    low, high = (np.full(np.shape(delta), np.log(s)) for s in span)
    for _ in range(48):
        middle = (low + high) / 2
        # δ falls with s along the stable branch, and rises along the unstable one
        is_before = (contact_at(ratio, np.exp(middle)).delta > delta) == stable
        low = np.where(is_before, middle, low)
        high = np.where(is_before, high, middle)
    return contact_at(ratio, np.exp((low + high) / 2))
