"""Attraction of two half spaces across a gap g: traction t, remaining work U, and the force on a sphere.

hamaker         t = A/(6πg³), U = A/(12πg²), no closer than z₀: w = U(z₀), A = 12π z₀² w (Hamaker 1937; Israelachvili,
                Intermolecular and Surface Forces, 3rd ed., eq. 13.15 and table 13.1)
retarded        U = A/(12πg²) [1 − x ln(1 + 1/x)], x = 5.32 g/λ (Gregory, J. Colloid Interface Sci. 83 (1981) 138)
lennard_jones   t = (8w/3ε) [(ε/g)³ − (ε/g)⁹], U(ε) = w: its attraction is Hamaker's with A = 16π ε² w
exponential     t = (w/ρ) exp(−g/ρ)
dugdale         t = w/h up to g = h

Between bodies with condensed liquid gaps below b are wetted: there t is γ/r_K and a share s of the solids' own,

    t = γ/r_K + s t₀,   U(g) = γ/r_K (b − g) + s (U₀(g) − U₀(b)) + U₀(b)   for g < b, and t₀ and U₀ beyond

where b is the height of a meniscus counted from contact, that is from the closest approach or Lennard-Jones's ε.

The attraction between a rigid body and a half space is the sum of t over the body's front less its back (surface
element integration, Bhattacharjee & Elimelech, J. Colloid Interface Sci. 193 (1997) 273). Over a plane, a sphere's
rings of equal height S over its lowest point have the area 2π(R − S) dS, negative on its back, so that with V = ∫U dg

    F(z) = 2π ∫₀^2R (R − S) t(z + S) dS = 2π [R U(z) + R U(z + 2R) − V(z) + V(z + 2R)]

which is Hamaker's sphere, 2A R³/(3z²(z + 2R)²), for his t, and 2πR U(z) (Derjaguin, Bradley) if its back is far away.

g, z, S, R, z₀, ε, ρ, h, b, λ   nm;   t GPa;   U, w J/m²;   V nN/nm;   A nN nm;   F nN
"""

from typing import NamedTuple

import numpy as np

from ..jit import kernel

HAMAKER, RETARDED, LENNARD_JONES, EXPONENTIAL, DUGDALE = range(5)

#: Laws by name; Hamaker's is retarded where a wavelength is given.
POTENTIALS = {"hamaker": HAMAKER, "lennard_jones": LENNARD_JONES, "exponential": EXPONENTIAL, "dugdale": DUGDALE}

#: Gap of Lennard-Jones's largest traction, in ε.
LARGEST_AT = 3.0 ** (1 / 6)

#: Gregory's factor of g/λ in x.
_GREGORY = 5.32


class Potential(NamedTuple):
    """A law of attraction; for Hamaker's, ``work`` is U at the closest approach ``length``."""

    code: int
    work: float  # J/m²
    length: float  # z₀, ε, ρ or h, nm
    wavelength: float  # of retardation, nm; inf without
    filled: float = -np.inf  # b, the gap below which liquid fills it, nm
    tension: float = 0.0  # of the liquid, γ/r_K, GPa
    share: float = 1.0  # s, of the solids' own traction under the liquid

    @property
    def closest(self):
        """The smallest gap, nm, that the law allows; None if the law repels by itself."""
        return {LENNARD_JONES: None, EXPONENTIAL: 0.0, DUGDALE: 0.0}.get(self.code, self.length)

    @property
    def range(self):
        """The gap (nm) beyond which the attraction is negligible; inf if it never is."""
        return {EXPONENTIAL: 25.0 * self.length, DUGDALE: self.length}.get(self.code, np.inf)


def potential(name, work, length, wavelength=np.inf):
    """Return the law with this name."""
    code = POTENTIALS[name]
    return Potential(RETARDED if code == HAMAKER and np.isfinite(wavelength) else code, work, length, wavelength)


def with_liquid(law, height, tension, share):
    """Return a law with liquid in gaps up to a height (nm) above contact, and the liquid's tension (GPa)."""
    contact = law.length if law.code == LENNARD_JONES else law.closest
    return law._replace(filled=contact + height, tension=tension, share=share)


@kernel
def traction(g, law):
    """Return t(g), GPa, at g > 0; positive for attraction."""
    return partly_wetted_traction(g, law, 1.0 if g < law.filled else 0.0)


@kernel
def partly_wetted_traction(g, law, wetted):
    """Return t(g) where liquid covers a part of the area."""
    t = _solids(g, law)
    return t + wetted * (law.tension - (1.0 - law.share) * t) if wetted > 0.0 else t


@kernel
def _solids(g, law):
    """Return the traction t₀ of the solids alone."""
    if law.code == EXPONENTIAL:
        return law.work / law.length * np.exp(-g / law.length)
    if law.code == DUGDALE:
        return law.work / law.length if g < law.length else 0.0
    x = law.length / g
    cube = x * x * x
    if law.code == LENNARD_JONES:
        return 8.0 / 3.0 * law.work / law.length * cube * (1.0 - cube * cube)
    t = 2.0 * law.work / law.length * cube
    return t if law.code == HAMAKER else t * _retardation(_GREGORY * g / law.wavelength)


@kernel
def _retardation(x):
    """Return f − x f′/2 of f = 1 − x ln(1 + 1/x), the factor by which retardation lowers a traction."""
    return 1.0 - 0.5 * x * np.log1p(1.0 / x) - 0.5 * x / (x + 1.0)


@kernel
def tractions(g, law):
    """Return t(g) at an array of gaps."""
    values = np.empty(g.size)
    for k in range(g.size):
        values[k] = traction(g[k], law)
    return values


def energy(g, law):
    """Return U(g), J/m²: the work left to separate two half spaces from the gap g."""
    g = np.asarray(g, dtype=float)
    if law.filled == -np.inf:
        return _energy(g, law)
    values = np.array(_energy(g, law))
    at_edge = _energy(law.filled, law)
    under = g < law.filled
    values[under] = law.share * (values[under] - at_edge) + law.tension * (law.filled - g[under]) + at_edge
    return values


def _energy(g, law):
    """Return U₀, the work of the solids alone."""
    x = law.length / np.maximum(g, 1e-300)
    if law.code == EXPONENTIAL:
        return law.work * np.exp(-g / law.length)
    if law.code == DUGDALE:
        return law.work * np.clip(1.0 - g / law.length, 0.0, None)
    if law.code == LENNARD_JONES:
        return law.work * (4.0 * x**2 - x**8) / 3.0
    if law.code == HAMAKER:
        return law.work * x**2
    y = _GREGORY * g / law.wavelength
    return law.work * x**2 * (1.0 - y * np.log1p(1.0 / y))


def gaussian_mean(law, sigma, cut=4.0):
    """Return the largest mean of U (J/m²) over Gaussian heights of a standard deviation (nm), cut at ``cut`` of it."""
    from scipy.optimize import minimize_scalar
    from scipy.special import erf

    nodes, weights = np.polynomial.legendre.leggauss(400)
    u = cut * nodes
    density = cut * weights * np.exp(-0.5 * u**2) / (np.sqrt(2 * np.pi) * erf(cut / np.sqrt(2)))

    def mean(nearest):
        return float(density @ energy(nearest + sigma * (cut - u), law))

    if law.closest is not None:
        return mean(law.closest)
    nearest = np.geomspace(0.1, 2.0, 120) * law.length
    best = nearest[np.argmax([mean(g) for g in nearest])]
    bounds = 0.97 * best, 1.03 * best
    return float(-minimize_scalar(lambda g: -mean(g), bounds=bounds, method="bounded", options={"xatol": 1e-9}).fun)
