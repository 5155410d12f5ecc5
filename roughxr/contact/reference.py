"""Closed forms to compare results with: single smooth contacts, and the usual formulas for rough ones.

Lengths in nm, moduli in GPa, works of adhesion in J/m², Hamaker constants in nN nm (1e-18 J), or quantities such as
"3 um" and "6.5e-20 J"; forces are returned in nN. For two spheres ``radius`` is the composite one, 1/R = 1/R₁ + 1/R₂.
A function of one state returns a float, a function of a curve a labelled Dataset.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..bodies import liquid
from ..bodies.materials import contact_modulus, gilman_surface_energy, hamaker_constant
from ..kernels.adhesion import potentials
from ..kernels.asperity import ellipse, elliptic_jkr, jkr, maugis
from ..vocabulary import schema
from ..vocabulary.units import positive
from .estimates import tabor

__all__ = [
    "contact_modulus",
    "dmt_pull_off",
    "flattened_pull_off",
    "gaussian_work",
    "gilman_surface_energy",
    "hamaker_constant",
    "hamaker_sphere",
    "hertz",
    "jkr_curve",
    "jkr_pull_off",
    "jkr_sphere",
    "maugis_pull_off",
    "maugis_sphere",
    "meniscus_sphere",
    "punch_pull_off",
    "rabinovich",
    "rigid_sphere",
    "rumpf",
    "rumpf_rms",
    "tabor",
    "tabor_parameter",
    "work_from_hamaker",
    "yield_load",
]

#: Formulations of an adhesive ellipse.
FORMULATIONS = ("energy", "self_similar", "johnson_greenwood")

#: Rabinovich's geometry: caps of height 1.82 rms and radius λ²/(58 rms); hemispheres of radius 1.48 rms.
_CAP_HEIGHT, _CAP_RADIUS, _HEMISPHERE = 1.82, 58.0, 1.48


def hertz(
    delta: Any, *, contact_modulus: Any, radius: Any = None, curvature_min: Any = None, curvature_max: Any = None
) -> xr.Dataset:
    """Return Hertz's contact of a paraboloid with a half space.

    Parameters
    ----------
    delta : array_like or quantity
        Displacements, nm, ascending; nothing touches at 0 and below.
    contact_modulus : number or quantity
        E*, GPa.
    radius : number or quantity, optional
        Of a sphere, nm. Give either this or both curvatures.
    curvature_min, curvature_max : number or quantity, optional
        Principal curvatures of the paraboloid, nm⁻¹, the smaller first.

    Returns
    -------
    Dataset
        ``force`` (nN), ``contact_area`` (nm²), ``semi_axis_a`` and ``semi_axis_b`` (nm), ``pressure`` (GPa, the
        largest) along ``delta``.

    Raises
    ------
    ValueError
        If a number is not positive, or the paraboloid is given twice or not at all.

    References
    ----------
    Johnson, Contact Mechanics (1985), §4.2.

    Examples
    --------
    >>> round(float(hertz([5.08], radius="3 um", contact_modulus=39.407).force[0]), 0)
    32951.0
    """
    delta = schema.ascending(delta, "nm", "delta")
    A, B = _paraboloid(radius, curvature_min, curvature_max)
    modulus = positive(contact_modulus, "GPa", "contact_modulus")
    found = [ellipse.hertz(d, A, B, modulus) for d in delta]
    names = {"P": "force", "a": "semi_axis_a", "b": "semi_axis_b", "area": "contact_area", "p0": "pressure"}
    return _along("delta", delta, {name: [getattr(state, key) for state in found] for key, name in names.items()})


def jkr_sphere(delta: Any, *, radius: Any, contact_modulus: Any, work_of_adhesion: Any) -> xr.Dataset:
    """Return JKR's sphere on its stable branch under displacement control.

    Parameters
    ----------
    delta : array_like or quantity
        Displacements, nm, ascending.
    radius, contact_modulus, work_of_adhesion : number or quantity
        nm, GPa, J/m².

    Returns
    -------
    Dataset
        ``force`` (nN), ``semi_axis_a`` (nm), ``contact_area`` (nm²) along ``delta``; NaN below the end of the branch,
        at −3^{−1/3} δ_c, which the attribute ``end_of_branch`` holds in nm.

    References
    ----------
    Johnson, Kendall & Roberts, Proc. R. Soc. A 324 (1971) 301.

    Examples
    --------
    >>> found = jkr_sphere([0.0], radius=3000, contact_modulus=39.407, work_of_adhesion=1.2842)
    >>> round(float(found.force[0] / jkr_pull_off(radius=3000, work_of_adhesion=1.2842)), 4)
    -0.8889
    """
    delta = schema.ascending(delta, "nm", "delta")
    units = _jkr_units(radius, contact_modulus, work_of_adhesion)
    reduced = delta / units.delta
    a = np.array([jkr.stable_semi_axis(d) if d >= jkr.END_DELTA else np.nan for d in reduced])
    force = units.P * a**1.5 * (a**1.5 - 2)
    radius_of = units.a * a
    out = _along("delta", delta, {"force": force, "semi_axis_a": radius_of, "contact_area": np.pi * radius_of**2})
    return out.assign_attrs(end_of_branch=jkr.END_DELTA * units.delta)


def jkr_curve(
    *, radius: Any, contact_modulus: Any, work_of_adhesion: Any, largest: float = 2.0, points: int = 201
) -> xr.Dataset:
    """Return the whole curve of JKR's sphere, unstable branch included, along its contact radius.

    Parameters
    ----------
    radius, contact_modulus, work_of_adhesion : number or quantity
        nm, GPa, J/m².
    largest : float
        Contact radius at the end of the curve, over that at pull-off under load control.
    points : int

    Returns
    -------
    Dataset
        ``delta`` (nm) and ``force`` (nN) along ``semi_axis_a`` (nm).

    Examples
    --------
    >>> curve = jkr_curve(radius=3000, contact_modulus=39.407, work_of_adhesion=1.2842)
    >>> bool(curve.force.min() < 0 < curve.force[-1])
    True
    """
    units = _jkr_units(radius, contact_modulus, work_of_adhesion)
    a = np.linspace(0.0, largest, points)
    found = {"delta": units.delta * (a**2 - 4 / 3 * np.sqrt(a)), "force": units.P * (a**3 - 2 * a**1.5)}
    return _along("semi_axis_a", units.a * a, found)


def jkr_pull_off(
    *,
    work_of_adhesion: Any,
    radius: Any = None,
    curvature_min: Any = None,
    curvature_max: Any = None,
    formulation: str = "energy",
) -> float:
    """Return the pull-off force of JKR's sphere, 3/2 π w R, or of an adhesive ellipse.

    Parameters
    ----------
    work_of_adhesion : number or quantity
        J/m².
    radius : number or quantity, optional
        nm. Give either this or both curvatures.
    curvature_min, curvature_max : number or quantity, optional
        nm⁻¹, the smaller first; up to a ratio of 1000.
    formulation : {"energy", "self_similar", "johnson_greenwood"}
        How adhesion acts on an ellipse, see `superpose`.

    Returns
    -------
    float
        nN, positive.

    References
    ----------
    Johnson & Greenwood, J. Phys. D 38 (2005) 1042; Giudici, Vella & Griffiths, arXiv 2407.00378.

    Examples
    --------
    >>> round(jkr_pull_off(radius=100, work_of_adhesion=0.1), 3)
    47.124
    >>> round(jkr_pull_off(curvature_min=0.01, curvature_max=0.05, work_of_adhesion=0.1) / 47.124 * 5**0.5, 4)
    0.9813
    """
    schema.one_of(formulation, FORMULATIONS, "formulation")
    A, B = _paraboloid(radius, curvature_min, curvature_max)
    w = positive(work_of_adhesion, "J m-2", "work_of_adhesion")
    sphere = 0.75 * np.pi * w / np.sqrt(A * B)
    if B == A:
        return float(sphere)
    if formulation == "self_similar":
        return float(jkr.self_similar_units(A, B, 1.0, w).P)
    state = elliptic_jkr.contact_at(formulation, B / A, elliptic_jkr.largest_tension(formulation, B / A))
    return float(-state.P * jkr.self_similar_units(A, B, 1.0, w).P)


def dmt_pull_off(*, radius: Any, work_of_adhesion: Any) -> float:
    """Return the pull-off force 2πwR of a sphere that is rigid (any law), or whose adhesion has a long range.

    Parameters
    ----------
    radius, work_of_adhesion : number or quantity
        nm, J/m².

    Returns
    -------
    float
        nN, positive.

    References
    ----------
    Bradley, Phil. Mag. 13 (1932) 853; Derjaguin, Muller & Toporov, J. Colloid Interface Sci. 53 (1975) 314.

    Examples
    --------
    >>> round(dmt_pull_off(radius=100, work_of_adhesion=0.1), 3)
    62.832
    """
    return 2 * np.pi * positive(work_of_adhesion, "J m-2", "work_of_adhesion") * positive(radius, "nm", "radius")


def maugis_pull_off(*, radius: Any, contact_modulus: Any, work_of_adhesion: Any, adhesion_range: Any = 0.3) -> float:
    """Return the pull-off force of Maugis's sphere with Dugdale's law, between JKR's and DMT's.

    Parameters
    ----------
    radius, contact_modulus, work_of_adhesion : number or quantity
        nm, GPa, J/m².
    adhesion_range : number or quantity
        z₀ of the interatomic potential, nm.

    Returns
    -------
    float
        nN, positive.

    References
    ----------
    Maugis, J. Colloid Interface Sci. 150 (1992) 243.

    Examples
    --------
    >>> pull = maugis_pull_off(radius=100, contact_modulus=39.4, work_of_adhesion=1.35)
    >>> round(pull / (3.14159 * 1.35 * 100), 2)
    1.54
    """
    radius, w = positive(radius, "nm", "radius"), positive(work_of_adhesion, "J m-2", "work_of_adhesion")
    parameter = _maugis_parameter(radius, contact_modulus, w, adhesion_range)
    return float(np.pi * w * radius * maugis.pull_off(parameter))


def maugis_sphere(
    *, radius: Any, contact_modulus: Any, work_of_adhesion: Any, adhesion_range: Any = 0.3, points: int = 801
) -> xr.Dataset:
    """Return the curve of Maugis's sphere with Dugdale's law, along its contact radius.

    Parameters
    ----------
    radius, contact_modulus, work_of_adhesion, adhesion_range : number or quantity
        nm, GPa, J/m², nm.
    points : int

    Returns
    -------
    Dataset
        ``delta`` (nm) and ``force`` (nN) along ``semi_axis_a`` (nm), ascending.

    Examples
    --------
    >>> curve = maugis_sphere(radius=100, contact_modulus=39.4, work_of_adhesion=1.35)
    >>> bool(curve.force.min() < 0 < curve.force[-1])
    True
    """
    units = _jkr_units(radius, contact_modulus, work_of_adhesion)
    parameter = _maugis_parameter(radius, contact_modulus, work_of_adhesion, adhesion_range)
    P, a, delta = maugis.contact_at(parameter, 1 + np.geomspace(1e-5, 1e7, points))
    order = np.argsort(a)
    return _along("semi_axis_a", units.a * a[order], {"delta": units.delta * delta[order], "force": units.P * P[order]})


def tabor_parameter(*, radius: Any, contact_modulus: Any, work_of_adhesion: Any, adhesion_range: Any = 0.3) -> float:
    """Return Tabor's parameter (R w²/(E*² z₀³))^{1/3} of a sphere: large for JKR, small for DMT.

    Parameters
    ----------
    radius, contact_modulus, work_of_adhesion, adhesion_range : number or quantity
        nm, GPa, J/m², nm.

    Returns
    -------
    float

    References
    ----------
    Tabor, J. Colloid Interface Sci. 58 (1977) 2.

    Examples
    --------
    >>> round(tabor_parameter(radius=3000, contact_modulus=39.407, work_of_adhesion=1.35), 1)
    5.1
    """
    return _tabor(radius, contact_modulus, work_of_adhesion, adhesion_range)


def rigid_sphere(
    distance: Any,
    *,
    radius: Any,
    work_of_adhesion: Any,
    length: Any,
    law: str = "hamaker",
    retardation: Any = None,
) -> xr.Dataset:
    """Return the force between a rigid sphere and a flat half space across a gap, integrated over the true sphere.

    Parameters
    ----------
    distance : array_like or quantity
        Distance of the sphere's lowest point from the plane, nm, positive and ascending.
    radius : number or quantity
        nm.
    work_of_adhesion : number or quantity
        w, J/m²; with law="hamaker" the work of separation from the distance ``length``.
    length : number or quantity
        nm: the cut-off z₀ of law="hamaker", ε of "lennard_jones", ρ of "exponential", the range h of "dugdale".
    law : {"hamaker", "lennard_jones", "exponential", "dugdale"}
    retardation : number or quantity, optional
        Wavelength λ, nm, of retarded van der Waals forces (law="hamaker"); about 100 nm. By default none.

    Returns
    -------
    Dataset
        ``force`` (nN, negative pulls) along ``distance`` (nm).

    Raises
    ------
    ValueError
        If a number is not positive, or the law is unknown.

    References
    ----------
    Hamaker, Physica 4 (1937) 1058; Bhattacharjee & Elimelech, J. Colloid Interface Sci. 193 (1997) 273; Gregory,
    J. Colloid Interface Sci. 83 (1981) 138, for retardation.

    Examples
    --------
    >>> w = work_from_hamaker(hamaker_constant="1e-19 J", closest_approach=0.3)
    >>> found = rigid_sphere([0.3], radius=1000, work_of_adhesion=w, length=0.3)
    >>> round(float(found.force[0]), 4)
    -185.1296
    """
    z = schema.ascending(distance, "nm", "distance")
    if z[0] <= 0:
        raise ValueError(f"distance: expected positive distances, found {z[0]:g} nm")
    found = _potential(law, work_of_adhesion, length, retardation)
    pull = potentials.sphere_pull(z, positive(radius, "nm", "radius"), found)
    return _along("distance", z, {"force": -pull})


def meniscus_sphere(
    distance: Any, *, radius: Any, kelvin_radius: Any, surface_tension: Any = 0.072, contact_angle: Any = 0.0
) -> xr.Dataset:
    """Return the pull of liquid that has condensed between a rigid sphere and a plane, by its exact surface.

    Parameters
    ----------
    distance : array_like or quantity
        Distance of the sphere's lowest point from the plane, nm, ascending, at least 0.
    radius, kelvin_radius : number or quantity
        R and r_K, nm; see `kelvin_radius` in `bodies.liquid`.
    surface_tension : number or quantity
        γ, J/m²; by default water's.
    contact_angle : number or pair
        θ₁ on the sphere and θ₂ on the plane, degrees.

    Returns
    -------
    Dataset
        ``force`` (nN, negative pulls) along ``distance``, 0 where no bridge can stand; ``thin_force``, that of the law
        of thin menisci, 2πRγ(cos θ₁ + cos θ₂ − D/r_K).

    Raises
    ------
    ValueError
        If a number is not positive, distances are negative, or an angle exceeds 90 degrees.

    Notes
    -----
    Along the meridian, inclined by φ, Young's and Laplace's equation has the integral C = 2r sin φ + r²/r_K, so that
    r and z are known of φ, and the pull is πγC. It starts from the plane at φ = π − θ₂ and ends on the sphere, at the
    angle β from its axis, at β + θ₁, which sets β.

    References
    ----------
    Orr, Scriven & Rivas, J. Fluid Mech. 67 (1975) 723; Dörmann & Schmid, Langmuir 30 (2014) 1055.

    Examples
    --------
    >>> found = meniscus_sphere([0.0], radius=100, kelvin_radius=4.9758)
    >>> round(float(found.force[0]), 2), round(float(found.thin_force[0]), 2)
    (-82.53, -90.48)
    """
    D = schema.ascending(distance, "nm", "distance")
    if D[0] < 0:
        raise ValueError(f"distance: expected distances of at least 0 nm, found {D[0]:g} nm")
    R, r_K = positive(radius, "nm", "radius"), positive(kelvin_radius, "nm", "kelvin_radius")
    tension, angles = positive(surface_tension, "J m-2", "surface_tension"), liquid.angles(contact_angle)
    constants = np.array([_meniscus(one, R, r_K, *angles) for one in D])
    thin = np.maximum(sum(np.cos(angles)) - D / r_K, 0.0)
    return _along(
        "distance", D, {"force": 0 - np.pi * tension * constants, "thin_force": 0 - 2 * np.pi * R * tension * thin}
    )


def _meniscus(distance: float, R: float, r_K: float, sphere: float, plane: float) -> float:
    """Return C (nm) of the exact surface of liquid between a sphere and a plane; 0 where none can stand."""
    from scipy.optimize import brentq

    nodes, weights = np.polynomial.legendre.leggauss(200)

    def constant(beta):
        return R * np.sin(beta) * (2 * np.sin(beta + sphere) + R * np.sin(beta) / r_K)

    def excess(beta):
        half = 0.5 * (np.pi - plane - sphere - beta)
        sine = np.sin(beta + sphere + half * (1 + nodes))
        height = r_K * half * float(weights @ (sine * (1 - sine / np.sqrt(sine**2 + constant(beta) / r_K))))
        return height - distance - R * (1 - np.cos(beta))

    tried = np.geomspace(1e-6, 0.5 * np.pi, 400)
    tried = tried[tried < np.pi - plane - sphere]
    above = np.flatnonzero([excess(beta) > 0 for beta in tried])
    if above.size == 0 or above[-1] + 1 == tried.size:
        return 0.0
    return float(constant(brentq(excess, tried[above[-1]], tried[above[-1] + 1], xtol=1e-14)))


def hamaker_sphere(distance: Any, *, radius: Any, hamaker_constant: Any) -> float:
    """Return Hamaker's pull of a sphere on a half space, 2A R³/(3D²(D + 2R)²).

    Parameters
    ----------
    distance, radius : number or quantity
        nm.
    hamaker_constant : number or quantity
        nN nm, that is 1e-18 J.

    Returns
    -------
    float
        nN, positive; Derjaguin's approximation is A R/(6D²).

    Examples
    --------
    >>> round(hamaker_sphere(0.3, radius=1000, hamaker_constant="1e-19 J"), 4)
    185.1296
    """
    D, R = positive(distance, "nm", "distance"), positive(radius, "nm", "radius")
    return 2 * _hamaker(hamaker_constant) * R**3 / (3 * D**2 * (D + 2 * R) ** 2)


def work_from_hamaker(*, hamaker_constant: Any, closest_approach: Any = 0.165) -> float:
    """Return the work of adhesion A/(12π z₀²) (J/m²) of a Hamaker constant and a cut-off z₀.

    Parameters
    ----------
    hamaker_constant : number or quantity
        nN nm, that is 1e-18 J.
    closest_approach : number or quantity
        z₀, nm.

    Returns
    -------
    float

    References
    ----------
    Israelachvili, Intermolecular and Surface Forces, 3rd ed., eq. 13.15 and §13.13 for 0.165 nm.

    Examples
    --------
    >>> round(work_from_hamaker(hamaker_constant="6.5e-20 J"), 4)
    0.0633
    """
    return _hamaker(hamaker_constant) / (12 * np.pi * positive(closest_approach, "nm", "closest_approach") ** 2)


def rumpf(*, radius: Any, asperity_radius: Any, hamaker_constant: Any, closest_approach: Any = 0.165) -> float:
    """Return Rumpf's pull of a sphere on a plane with one hemispherical asperity.

    Parameters
    ----------
    radius : number or quantity
        Of the sphere, nm.
    asperity_radius : number or quantity
        nm; its centre lies in the plane.
    hamaker_constant : number or quantity
        nN nm.
    closest_approach : number or quantity
        z₀ between sphere and asperity, nm.

    Returns
    -------
    float
        nN, positive: (A/6z₀²) [rR/(r + R) + R/(1 + r/z₀)²].

    References
    ----------
    Rumpf, Particle Technology (1990).

    Examples
    --------
    >>> round(rumpf(radius=1000, asperity_radius=10, hamaker_constant="1e-19 J", closest_approach=0.3), 3)
    1.991
    """
    R, r = positive(radius, "nm", "radius"), positive(asperity_radius, "nm", "asperity_radius")
    z = positive(closest_approach, "nm", "closest_approach")
    return _hamaker(hamaker_constant) / (6 * z**2) * (r * R / (r + R) + R / (1 + r / z) ** 2)


def rumpf_rms(*, radius: Any, rms: Any, hamaker_constant: Any, closest_approach: Any = 0.165) -> float:
    """Return Rumpf's pull, with hemispheres whose radius 1.48 rms gives a surface its roughness.

    Parameters
    ----------
    radius, rms : number or quantity
        nm.
    hamaker_constant : number or quantity
        nN nm.
    closest_approach : number or quantity
        nm.

    Returns
    -------
    float
        nN, positive: (AR/6z₀²) [1/(1 + R/(1.48 rms)) + 1/(1 + 1.48 rms/z₀)²].

    References
    ----------
    Rabinovich, Adler, Ata, Singh & Moudgil, J. Colloid Interface Sci. 232 (2000) 10.

    Examples
    --------
    >>> arguments = {"radius": 1000, "hamaker_constant": "1e-19 J", "closest_approach": 0.3}
    >>> rumpf_rms(rms=2, **arguments) == rumpf(asperity_radius=2.96, **arguments)
    True
    """
    return rumpf(
        radius=radius,
        asperity_radius=_HEMISPHERE * positive(rms, "nm", "rms"),
        hamaker_constant=hamaker_constant,
        closest_approach=closest_approach,
    )


def rabinovich(
    *,
    radius: Any,
    rms: Any,
    wavelength: Any,
    hamaker_constant: Any,
    closest_approach: Any = 0.165,
    long_rms: Any = None,
    long_wavelength: Any = None,
) -> float:
    """Return Rabinovich's pull of a sphere on a surface of spherical caps, of one or two scales.

    Parameters
    ----------
    radius : number or quantity
        Of the sphere, nm.
    rms, wavelength : number or quantity
        Root mean square roughness and peak-to-peak distance, nm, of the only scale or the shorter of two.
    hamaker_constant : number or quantity
        nN nm.
    closest_approach : number or quantity
        z₀, nm.
    long_rms, long_wavelength : number or quantity, optional
        Roughness and distance of the longer scale, nm; both or none.

    Returns
    -------
    float
        nN, positive. Caps have the radius λ²/(58 rms) and the height 1.82 rms. For one scale
        (AR/6z₀²) [1/(1 + 58 R rms/λ²) + 1/(1 + 1.82 rms/z₀)²]; for two the sphere touches small caps on large ones:
        (AR/6z₀²) [1/(1 + 58 R rms₂/λ₂²) + 1/((1 + 58 R rms₁/λ₁²)(1 + 1.82 rms₂/z₀)²)]. Without the longer scale
        this is the former; what lies beneath both scales is left out.

    Raises
    ------
    ValueError
        If a number is not positive, or only one of the two for the longer scale is given.

    References
    ----------
    Rabinovich, Adler, Ata, Singh & Moudgil, J. Colloid Interface Sci. 232 (2000) 10 and 17.

    Examples
    --------
    >>> arguments = {"radius": 1000, "rms": 1, "wavelength": 50, "hamaker_constant": "1e-19 J", "closest_approach": 0.3}
    >>> round(rabinovich(**arguments), 2)
    11.36
    >>> round(rabinovich(**arguments, long_rms=10, long_wavelength=1000), 2)
    10.0
    """
    R, z = positive(radius, "nm", "radius"), positive(closest_approach, "nm", "closest_approach")
    rms, wavelength = positive(rms, "nm", "rms"), positive(wavelength, "nm", "wavelength")
    flat = _hamaker(hamaker_constant) * R / (6 * z**2)
    cap = 1 / (1 + _CAP_RADIUS * R * rms / wavelength**2)
    if (long_rms is None) != (long_wavelength is None):
        raise ValueError("long_rms, long_wavelength: expected both or neither, found one")
    if long_rms is None:
        return flat * (cap + 1 / (1 + _CAP_HEIGHT * rms / z) ** 2)
    long_rms = positive(long_rms, "nm", "long_rms")
    long_cap = 1 / (1 + _CAP_RADIUS * R * long_rms / positive(long_wavelength, "nm", "long_wavelength") ** 2)
    return flat * (cap + long_cap / (1 + _CAP_HEIGHT * rms / z) ** 2)


def gaussian_work(
    *, rms: Any, length: Any, work_of_adhesion: Any = 1.0, law: str = "lennard_jones", cut: float = 4.0
) -> float:
    """Return the work of adhesion between Gaussian heights and a rigid flat: the largest mean of the potential.

    Parameters
    ----------
    rms : number or quantity
        Standard deviation of the heights, nm.
    length : number or quantity
        Length of the law, nm, see `rigid_sphere`.
    work_of_adhesion : number or quantity
        Work of adhesion of smooth surfaces, J/m².
    law : {"hamaker", "lennard_jones", "exponential", "dugdale"}
        For laws without repulsion, the highest summit comes no closer than on a smooth surface.
    cut : float
        Heights are cut off at this many standard deviations.

    Returns
    -------
    float
        J/m²; a large rigid sphere pulls with 2πR times it.

    Examples
    --------
    >>> round(gaussian_work(rms=0.3, length=0.3), 4)
    0.0795
    """
    return potentials.gaussian_mean(_potential(law, work_of_adhesion, length, None), positive(rms, "nm", "rms"), cut)


def yield_load(*, radius: Any, contact_modulus: Any, hardness: Any) -> float:
    """Return the load at which a sphere first yields, π³R²H³/(6E*²): there Hertz's largest pressure is H.

    Parameters
    ----------
    radius, contact_modulus, hardness : number or quantity
        nm, GPa, GPa.

    Returns
    -------
    float
        nN.

    Examples
    --------
    >>> round(yield_load(radius=100, contact_modulus=39.4, hardness=6.0), 0)
    7191.0
    """
    R, modulus = positive(radius, "nm", "radius"), positive(contact_modulus, "GPa", "contact_modulus")
    return np.pi**3 * R**2 * positive(hardness, "GPa", "hardness") ** 3 / (6 * modulus**2)


def punch_pull_off(*, radius: Any, contact_modulus: Any, work_of_adhesion: Any, adhesion_range: Any = None) -> float:
    """Return the pull-off force of a flat punch whose edge is sharp.

    Parameters
    ----------
    radius : number or quantity
        Of the punch, nm.
    contact_modulus, work_of_adhesion : number or quantity
        E*, GPa, and w, J/m².
    adhesion_range : number or quantity, optional
        nm: the adhesion pulls with σ₀ = w over this range up to a gap of the range (Dugdale's law). By default none.

    Returns
    -------
    float
        nN: √(8π w E* a³) without range. With a range, a cohesive zone from c to the edge a carries part of the pull:
        with m = a/c it is 2σ₀ [c √(a² − c²) + a² arccos(1/m)], where c is such that the gap at the edge, (4σ₀c/πE*)
        [√(m² − 1) arccos(1/m) + 1 − m], is w/σ₀. Where the gap stays below this with the whole punch pulling, π a² σ₀.

    Notes
    -----
    With a range of 0.3 nm, w = 0.1 J/m² and E* = 39.4 GPa a punch of 10 nm holds a third of what it would without
    range, because the cohesive zone, π E* w/(4σ₀²), is 28 nm. An asperity flattened at a hardness above the pull of
    adhesion is no such punch: it recovers, see `flattened_pull_off`.

    References
    ----------
    Kendall, J. Phys. D 4 (1971) 1186. The zone is that of Maugis, J. Colloid Interface Sci. 150 (1992) 243, for a flat.

    Examples
    --------
    >>> flat = {"radius": 10, "contact_modulus": 39.4, "work_of_adhesion": 0.1}
    >>> round(punch_pull_off(**flat), 1), round(punch_pull_off(adhesion_range=0.3, **flat), 1)
    (314.7, 104.7)
    """
    from scipy.optimize import brentq

    edge, modulus = positive(radius, "nm", "radius"), positive(contact_modulus, "GPa", "contact_modulus")
    work = positive(work_of_adhesion, "J m-2", "work_of_adhesion")
    if adhesion_range is None:
        return float(np.sqrt(8 * np.pi * work * modulus * edge**3))
    pull = work / positive(adhesion_range, "nm", "adhesion_range")

    def opens_too_far(inner: float) -> float:
        m = edge / inner
        gap = 4 * pull * inner / (np.pi * modulus) * (np.sqrt(m * m - 1) * np.arccos(1 / m) + 1 - m)
        return gap - work / pull

    least, most = 1e-9 * edge, edge * (1 - 1e-12)
    if opens_too_far(least) < 0:
        return float(np.pi * edge**2 * pull)
    inner = brentq(opens_too_far, least, most)
    return float(2 * pull * (inner * np.sqrt(edge**2 - inner**2) + edge**2 * np.arccos(inner / edge)))


def flattened_pull_off(*, radius: Any, contact_modulus: Any, work_of_adhesion: Any, hardness: Any) -> float:
    """Return the pull-off force of an asperity that was pressed flat, its whole contact at the hardness.

    Parameters
    ----------
    radius : number or quantity
        Radius of the contact under the largest load, nm.
    contact_modulus, work_of_adhesion, hardness : number or quantity
        E*, GPa, w, J/m², and H, GPa.

    Returns
    -------
    float
        nN: the largest of √(8π w E* a³) s^{3/2} − 2Ha² [arcsin s − s √(1 − s²)] over s ≤ 1, where s a is the contact's
        radius on unloading. Adhesion has no range.

    Notes
    -----
    A contact that bore H everywhere recovers to a convex shape, 0.73 H a/E* higher in its middle than at its rim, and
    peels from the rim. It acts as a flat punch, `punch_pull_off`, only where H is small compared with √(w E*/a): its
    pull-off is 2 % less at 0.03 times this, half at 1.2 times. Where H is large it acts as JKR's sphere of radius
    E* a/H, with 3/2 π w E* a/H, and 3 % less than this at ten times √(w E*/a). A body that its own adhesion does not
    tear, w/ρ < H, has H/√(w E*/a) above √(w a/(E* ρ²)): the shorter the range, the farther it is from a flat punch.

    References
    ----------
    Own, from the pressures of Sneddon, Int. J. Eng. Sci. 3 (1965) 47, on the shape that a uniform pressure leaves, and
    Johnson, Kendall & Roberts (1971).

    Examples
    --------
    >>> flat = {"radius": 10, "contact_modulus": 39.4, "work_of_adhesion": 0.1}
    >>> [round(flattened_pull_off(hardness=H, **flat), 1) for H in (0.001, 0.6, 6.0)]
    [314.4, 181.4, 29.9]
    """
    from scipy.optimize import brentq

    edge, pressed = positive(radius, "nm", "radius"), positive(hardness, "GPa", "hardness")
    punch = punch_pull_off(radius=edge, contact_modulus=contact_modulus, work_of_adhesion=work_of_adhesion)
    load = pressed * edge**2
    part = 3 * punch / (8 * load)  # where the pull is largest, s^{3/2}/√(1 − s²)
    s = brentq(lambda s: (s / part) ** 2 * s + s * s - 1, 0.0, 1.0, xtol=1e-15)
    return float(punch * s**1.5 - 2 * load * (np.arcsin(s) - s * s**1.5 / part))


def _potential(law: str, work: Any, length: Any, retardation: Any) -> potentials.Potential:
    schema.one_of(law, tuple(potentials.POTENTIALS), "law")
    wavelength = np.inf if retardation is None else positive(retardation, "nm", "retardation")
    if law != "hamaker" and np.isfinite(wavelength):
        raise ValueError(f"retardation: used by law='hamaker' only, found law={law!r}; leave it out")
    w = positive(work, "J m-2", "work_of_adhesion")
    length = positive(length, "nm", "length")
    found = potentials.potential(law, w, length, wavelength)
    if found.code == potentials.RETARDED:  # w is the work from z₀ on, retarded or not
        return found._replace(work=w * w / float(potentials.energy(length, found)))
    return found


def _hamaker(value: Any) -> float:
    return positive(value, "nN nm", "hamaker_constant")


def _tabor(radius: Any, contact_modulus: Any, work: Any, distance: Any) -> float:
    A = 0.5 / positive(radius, "nm", "radius")
    modulus = positive(contact_modulus, "GPa", "contact_modulus")
    w, z0 = positive(work, "J m-2", "work_of_adhesion"), positive(distance, "nm", "adhesion_range")
    return float(maugis.tabor(A, A, modulus, w, z0))


def _maugis_parameter(radius: Any, contact_modulus: Any, work: Any, distance: Any) -> float:
    return maugis.parameter(_tabor(radius, contact_modulus, work, distance))


def _paraboloid(radius: Any, curvature_min: Any, curvature_max: Any) -> tuple[float, float]:
    """Return half the principal curvatures, nm⁻¹."""
    if (radius is None) == (curvature_min is None) or (curvature_min is None) != (curvature_max is None):
        raise ValueError("expected either radius, or curvature_min and curvature_max")
    if radius is not None:
        return (0.5 / positive(radius, "nm", "radius"),) * 2
    flat, sharp = positive(curvature_min, "nm-1", "curvature_min"), positive(curvature_max, "nm-1", "curvature_max")
    if flat > sharp:
        raise ValueError(f"curvature_min: expected at most curvature_max = {sharp:g}, found {flat:g}")
    return 0.5 * flat, 0.5 * sharp


def _jkr_units(radius: Any, contact_modulus: Any, work_of_adhesion: Any) -> jkr.Units:
    A = 0.5 / positive(radius, "nm", "radius")
    modulus = positive(contact_modulus, "GPa", "contact_modulus")
    return jkr.self_similar_units(A, A, modulus, positive(work_of_adhesion, "J m-2", "work_of_adhesion"))


def _along(axis: str, values: np.ndarray, found: dict[str, Any]) -> xr.Dataset:
    """Return a labelled curve along an axis with these values."""
    data = {name: (axis, np.asarray(numbers, dtype=float)) for name, numbers in found.items()}
    return schema.label(xr.Dataset(data, {axis: values}))
