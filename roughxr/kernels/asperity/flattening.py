"""An asperity that yields: its curvature and height after it was pressed, in closed form as far as there is one.

Up to δ_Y, where Hertz's largest pressure is the hardness H, it is elastic. Beyond, the pressure is capped at H (rigid
sphere on a half space with 0 ≤ p ≤ H, ``halfspace.yielding``): by scaling, force and area over those of first yield are
functions of x = δ/δ_Y alone,

    P = P_Y · 3x u(x),     A = A_Y · 2x v(x),     u, v from 1/3, 1/2 at x = 1 to 1, 1 as P → H A and A → 2πRδ

tabulated here over s = 1/√x from the half space solver at sixty cells in radius, which ``tests/test_flattening.py``
repeats. An ellipse keeps Hertz's shape and takes the same functions.

On unloading it is elastic with a flattened curvature (Johnson, Contact Mechanics, §6.4; Mesarovic & Johnson, J. Mech.
Phys. Solids 48 (2000) 2009): κ times the composite one, and its vertex δ₀ deeper, such that Hertz's law gives the
force and the area at which it turned back,

    κ = 3x u/(2x v)^{3/2},     δ₀ = δ (1 − 2v κ),

hence also the stiffness of a punch of that area. This holds for unloading without adhesion. With adhesion the
contact lets go in its middle, where a shape that recovers from a capped pressure is flatter than near its rim: there
the curvature is κ_m = g(s) s and the vertex δ (1 − e(s)) deeper, from the curvature and the depth of the elastic
displacement, with g and e tabulated like u and v, from 1 to 0.450 (of a uniform pressure: radius E* a/H) and from 1 to
0. Adhesive asperities are unloaded with these; near the turning point their force is then up to a fifth too large.
The load that adhesion adds on loading is left out.
"""

import numpy as np

#: s = √(δ_Y/δ), and u and v at these s.
_S = (0.0, 0.0577, 0.1, 0.1291, 0.1826, 0.2582, 0.3162, 0.378, 0.4472, 0.5, 0.5774, 0.6325, 0.7071, 0.8165, 0.8944)
_S = np.array([*_S, 0.9535, 1.0])
_U = (1.0, 0.936, 0.892, 0.863, 0.811, 0.7445, 0.6975, 0.6505, 0.6022, 0.568, 0.5218, 0.4914, 0.4534, 0.4034, 0.3716)
_U = np.array([*_U, 0.3495, 1 / 3])
_V = (1.0, 0.9365, 0.8925, 0.8635, 0.8125, 0.746, 0.6995, 0.6535, 0.608, 0.5806, 0.55, 0.5335, 0.517, 0.505, 0.5015)
_V = np.array([*_V, 0.5003, 0.5])

#: g and e, for the middle, at these s.
_G = (0.4502, 0.4655, 0.4765, 0.4835, 0.4996, 0.5219, 0.5391, 0.5581, 0.5801, 0.5974, 0.6236, 0.6432, 0.6719, 0.7228)
_G = np.array([*_G, 0.7739, 0.8368, 1.0])
_E = (0.0, 0.1005, 0.1701, 0.2155, 0.2962, 0.401, 0.4755, 0.5489, 0.6249, 0.6785, 0.7508, 0.7979, 0.8559, 0.928, 0.9684)
_E = np.array([*_E, 0.9907, 1.0])


def flattened(delta, stiffness, contact, hardness, *, middle=False):
    """Return κ and δ₀ (nm) of asperities that were pressed to a displacement, with ``middle`` those of their middle.

    Of each ``delta``, nm, for an untouched one any number up to 0 or -inf; Hertz's force (nN, ``stiffness``) and area
    (nm², ``contact``) at a displacement of 1 nm; hardness in GPa.
    """
    delta, first = np.maximum(delta, 0.0), (hardness * contact / (1.5 * stiffness)) ** 2  # -inf beside the sphere
    s = np.sqrt(first / np.maximum(delta, first))
    if middle:
        return np.interp(s, _S, _G) * s, np.where(s < 1.0, delta * (1 - np.interp(s, _S, _E)), 0.0)
    u, v = np.interp(s, _S, _U), np.interp(s, _S, _V)
    curvature = np.minimum(3 * u * s / (2 * v) ** 1.5, 1.0)  # the tables' last digits may exceed it
    return curvature, np.where(s < 1.0, delta * (1 - 2 * v * curvature), 0.0)
