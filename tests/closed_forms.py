"""Closed forms that results are compared with: rigid spheres, flat punches, Maugis's sphere; nm, GPa, J/m², nN."""

import numpy as np
from scipy.optimize import brentq
from scipy.special import spence

from roughxr.mechanics.kernels.adhesion import potentials
from roughxr.mechanics.kernels.asperity import maugis


def potential(law, work, length, retardation=np.inf):
    """Return a law of attraction whose work from the gap ``length`` to infinity is ``work``, retarded or not."""
    built = potentials.potential(law, work, length, retardation)
    if built.code == potentials.RETARDED:
        return built._replace(work=work**2 / float(potentials.energy(length, built)))
    return built


def energy_beyond(g, law):
    """Return V(g), the integral of U from g to infinity, nN/nm."""
    g = np.asarray(g, dtype=float)
    if law.filled == -np.inf:
        return _solids_beyond(g, law)
    depth = np.maximum(law.filled - g, 0.0)
    under = (
        _solids_beyond(law.filled - depth, law)
        - _solids_beyond(law.filled, law)
        - potentials._energy(law.filled, law) * depth
    )
    under = law.share * under + potentials._energy(law.filled, law) * depth + 0.5 * law.tension * depth**2
    return under + _solids_beyond(np.maximum(g, law.filled), law)


def _solids_beyond(g, law):
    """Return V₀(g), the same integral for the solids alone."""
    x = law.length / np.maximum(g, 1e-300)
    if law.code == potentials.EXPONENTIAL:
        return law.work * law.length * np.exp(-g / law.length)
    if law.code == potentials.DUGDALE:
        return 0.5 * law.work / law.length * np.clip(law.length - g, 0.0, None) ** 2
    if law.code == potentials.LENNARD_JONES:
        return law.work * law.length * (4.0 * x - x**7 / 7.0) / 3.0
    if law.code == potentials.HAMAKER:
        return law.work * law.length * x
    y = law.wavelength / (potentials._GREGORY * g)
    return law.work * law.length**2 * potentials._GREGORY / law.wavelength * (y + spence(1.0 + y))


def sphere_attraction(z, radius, law):
    """Return the attraction (nN) of a rigid sphere whose lowest point is z above a plane."""
    far = z + 2.0 * radius
    beyond = energy_beyond(z, law) - energy_beyond(far, law)
    return 2.0 * np.pi * (radius * (potentials.energy(z, law) + potentials.energy(far, law)) - beyond)


def rigid_sphere(distance, *, radius, work_of_adhesion, length, law="hamaker"):
    """Return the force between a rigid sphere and a flat half space, integrated over the true sphere (Hamaker 1937)."""
    return -sphere_attraction(np.asarray(distance, float), radius, potential(law, work_of_adhesion, length))


def maugis_pull_off(*, radius, contact_modulus, work_of_adhesion, adhesion_range):
    """Return the pull-off of Maugis's sphere with Dugdale's law, J. Colloid Interface Sci. 150 (1992) 243."""
    tabor = maugis.tabor(0.5 / radius, 0.5 / radius, contact_modulus, work_of_adhesion, adhesion_range)
    return float(np.pi * work_of_adhesion * radius * maugis.pull_off(maugis.parameter(tabor)))


def punch_pull_off(*, radius, contact_modulus, work_of_adhesion, adhesion_range=None):
    """Return the pull-off of a flat punch, √(8π w E* a³) without range (Kendall 1971).

    With a range (Dugdale's law, σ₀ = w over it) a cohesive zone from c to the edge a carries part of the pull: with
    m = a/c it is 2σ₀ [c √(a² − c²) + a² arccos(1/m)], where c is such that the gap at the edge, (4σ₀c/πE*)
    [√(m² − 1) arccos(1/m) + 1 − m], is w/σ₀ (Maugis 1992, for a flat). Where the gap stays below this with the whole
    punch pulling, π a² σ₀.
    """
    if adhesion_range is None:
        return float(np.sqrt(8 * np.pi * work_of_adhesion * contact_modulus * radius**3))
    pull = work_of_adhesion / adhesion_range

    def opens_too_far(inner):
        m = radius / inner
        gap = 4 * pull * inner / (np.pi * contact_modulus) * (np.sqrt(m * m - 1) * np.arccos(1 / m) + 1 - m)
        return gap - adhesion_range

    smallest = 1e-9 * radius
    largest = radius * (1 - 1e-12)
    if opens_too_far(smallest) < 0:
        return float(np.pi * radius**2 * pull)
    inner = brentq(opens_too_far, smallest, largest)
    return float(2 * pull * (inner * np.sqrt(radius**2 - inner**2) + radius**2 * np.arccos(inner / radius)))


def flattened_pull_off(*, radius, contact_modulus, work_of_adhesion, hardness):
    """Return the pull-off of an asperity pressed flat: the hardness H on the whole contact, of radius a.

    The largest of √(8π w E* a³) s^{3/2} − 2Ha² [arcsin s − s √(1 − s²)] over s ≤ 1, where s a is the contact's radius
    on unloading. The contact recovers to a convex shape, 0.73 H a/E* higher in its middle than at its rim, and peels
    from the rim. Own, from the pressures of Sneddon, Int. J. Eng. Sci. 3 (1965) 47.
    """
    punch = punch_pull_off(radius=radius, contact_modulus=contact_modulus, work_of_adhesion=work_of_adhesion)
    load = hardness * radius**2
    part = 3 * punch / (8 * load)  # where the pull is largest, s^{3/2}/√(1 − s²)
    s = brentq(lambda s: (s / part) ** 2 * s + s * s - 1, 0.0, 1.0, xtol=1e-15)
    return float(punch * s**1.5 - 2 * load * (np.arcsin(s) - s * s**1.5 / part))


def wide_contact_pull_off(radius, modulus, work):
    """Return JKR's pull-off (nN) of a sphere whose contact is not small beside its radius.

    Sneddon's load of the exact sphere less that of a flat punch at Griffith's balance (Maugis, Langmuir 11 (1995) 679).
    """
    a = np.linspace(0.01, 0.95, 10_000) * radius
    logarithm = np.log((radius + a) / (radius - a))
    hertz = modulus * (0.5 * (a**2 + radius**2) * logarithm - a * radius)
    return -np.min(hertz - np.sqrt(8 * np.pi * modulus * work * a**3))
