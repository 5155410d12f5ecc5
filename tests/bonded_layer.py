"""Independent solutions for a layer bonded to a half space: boundary values in Fourier space, and dual integrals."""

from functools import lru_cache

import numpy as np
from scipy.optimize import minimize_scalar


def compliance(s, mismatch, ratio, base_ratio):
    """Return F(s): displacement under a harmonic pressure over that of the layer's half space, by boundary values.

    Love's strain function Φ = (A + Bz) e⁻ᶻ + (C + Dz) eᶻ at wavevector 1 in a layer of thickness s and of shear modulus
    1; below it (A + Bz) e⁻ᶻ, or nothing moves (mismatch 0).
    """

    def columns(z, modulus, nu, terms):
        """Return displacements 2w, 2u and stresses σ, τ of each term of Φ (Johnson's or Love's formulas)."""
        out = []
        for power, sign, at in terms:
            decay = np.exp(sign * (z - at))
            f = [
                (z**power * sign**k + (k * sign ** (k - 1) if power else 0.0)) * decay if k else z**power * decay
                for k in range(4)
            ]
            out.append(
                [
                    ((1 - 2 * nu) * f[2] - 2 * (1 - nu) * f[0]) / modulus,
                    f[1] / modulus,
                    (1 - nu) * f[3] - (2 - nu) * f[1],
                    nu * f[2] + (1 - nu) * f[0],
                ]
            )
        return np.array(out).T

    layer = [(0, -1, 0.0), (1, -1, 0.0), (0, 1, s), (1, 1, s)]
    base = [(0, -1, s), (1, -1, s)] if mismatch else []
    top = columns(0.0, 1.0, ratio, layer)
    bottom = columns(s, 1.0, ratio, layer)
    size = 4 + len(base)
    matrix = np.zeros((size, size))
    right = np.zeros(size)
    matrix[:2, :4] = top[2:]
    right[0] = -1.0
    if mismatch:
        matrix[2:, :4] = bottom
        matrix[2:, 4:] = -columns(s, 1.0 / mismatch, base_ratio, base)
    else:
        matrix[2:, :4] = bottom[:2]
    return abs(top[0] @ np.linalg.solve(matrix, right)[:4]) / (2 * (1 - ratio))


@lru_cache
def remainder(mismatch, ratio, base_ratio, count=600, last=16.0):
    """Return nodes s, weights of an integral over s, and F(s) − 1 there."""
    s, weight = np.polynomial.legendre.leggauss(count)
    s = 0.5 * last * (s + 1)
    weight = 0.5 * last * weight
    return s, weight, np.array([compliance(wavenumber, mismatch, ratio, base_ratio) for wavenumber in s]) - 1


def response(radius, layer, count=160, edge=0.0, *, flat=False):
    """Return force/(E* R²) and displacement/R of a paraboloid in contact up to a radius a/R = 1, by dual integrals.

    ``layer`` is (thickness over a, mismatch, ratio, base ratio), R = 1. p̂(q) = ∫ φ(t) cos(qt) dt on t < a, with

        φ(t) + (1/π) ∫ φ(s) [K(t − s) + K(t + s)] ds = (δ − t²/R)/π,     K(x) = ∫ (F(qh) − 1) cos(qx) dq,

    and φ(a) = ``edge``: 0 without adhesion, −√(2aw/(πE*)) with (Griffith). F = 2π ∫ φ dt, E* = 1 (Lebedev & Ufliand).
    A ``flat`` punch has δ = 1 and no condition at its edge.
    """
    thickness = layer[0] * radius
    t, weight = np.polynomial.legendre.leggauss(count)
    t = 0.5 * radius * (t + 1)
    weight = 0.5 * radius * weight
    q, weights, rest_of_compliance = remainder(*layer[1:])
    part = weights * rest_of_compliance / thickness
    points = np.append(t, radius)
    cosines = np.cos(np.outer(points, q / thickness))
    # K(t − s) + K(t + s) is twice the product of cosines
    kernel = 2 * (cosines * part) @ cosines[:-1].T / np.pi * weight
    matrix = np.zeros((count + 2, count + 2))
    matrix[:-1, :count] = kernel
    matrix[:-1, :-1] += np.eye(count + 1)
    matrix[:-1, -1] = -1 / np.pi
    matrix[-1, count] = 1.0
    if flat:
        return 2 * np.pi * weight @ np.linalg.solve(matrix[:count, :count], np.full(count, 1 / np.pi)), 1.0
    solved = np.linalg.solve(matrix, np.append(-(points**2) / np.pi, edge))
    return 2 * np.pi * weight @ solved[:count], solved[-1]


def pull_off(work, thickness, *layer):
    """Return the pull-off force/(π w R) of a paraboloid without range, and a/R there; w/(E* R) and h/R are given."""
    radius_of_jkr = (9 * np.pi * work / 8) ** (1 / 3)  # on a half space

    def force(radius):
        return response(radius, (thickness / radius, *layer), edge=-np.sqrt(2 * radius * work / np.pi))[0]

    least = minimize_scalar(lambda part: force(part * radius_of_jkr), bounds=(0.3, 3.0), options={"xatol": 1e-3})
    return -least.fun / (np.pi * work), least.x * radius_of_jkr


def punch(layer):
    """Return the force of a flat punch over that on the layer's half space, 2 E* a δ, by the same equations."""
    return 0.5 * response(1.0, layer, flat=True)[0]
