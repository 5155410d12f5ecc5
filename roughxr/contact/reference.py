"""Closed forms to compare results with: single smooth contacts, and the usual formulas for rough ones.

Lengths in nm, moduli in GPa, works of adhesion in J/m², Hamaker constants in nN nm (1e-18 J), or quantities such as
"3 um" and "6.5e-20 J"; forces are returned in nN. For two spheres ``radius`` is the composite one, 1/R = 1/R₁ + 1/R₂.
A function of one state returns a float, a function of a curve a labelled Dataset. What is not positive is refused.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..bodies import liquid
from ..bodies.pair import contact_modulus, gilman_surface_energy, hamaker_constant
from ..kernels.adhesion import potentials
from ..kernels.asperity import ellipse, elliptic_jkr, jkr, maugis
from ..vocabulary import schema
from ..vocabulary.units import Quantities, Quantity, positive
from .estimates import elastic_pull_off, tabor

__all__ = [
    "contact_modulus",
    "dmt_pull_off",
    "elastic_pull_off",
    "flattened_pull_off",
    "gaussian_work",
    "gilman_surface_energy",
    "hamaker_constant",
    "hertz",
    "jkr_curve",
    "jkr_pull_off",
    "jkr_sphere",
    "maugis_pull_off",
    "meniscus_sphere",
    "punch_pull_off",
    "rabinovich",
    "rigid_sphere",
    "rumpf",
    "tabor",
    "tabor_parameter",
]

#: Formulations of an adhesive ellipse.
FORMULATIONS = ("energy", "self_similar")

#: Rabinovich's geometry: caps of height 1.82 rms and radius λ²/(58 rms); hemispheres of radius 1.48 rms.
_CAP_HEIGHT, _CAP_RADIUS, _HEMISPHERE = 1.82, 58.0, 1.48

_UNITS = {
    "radius": "nm",
    "contact_modulus": "GPa",
    "work_of_adhesion": "J/m^2",
    "hardness": "GPa",
    "adhesion_range": "nm",
    "curvature_min": "1/nm",
    "curvature_max": "1/nm",
    "length": "nm",
    "retardation": "nm",
    "kelvin_radius": "nm",
    "surface_tension": "J/m^2",
    "hamaker_constant": "nN nm",
    "closest_approach": "nm",
    "asperity_radius": "nm",
    "rms": "nm",
    "wavelength": "nm",
    "long_rms": "nm",
    "long_wavelength": "nm",
}


def _positive(names: str, *given: Any) -> list[Any]:
    """Return options of these names as positive numbers in their units, None where they are not given."""
    each = zip(names.split(), given)
    return [None if value is None else positive(value, _UNITS[name], name) for name, value in each]


def hertz(
    delta: Quantities,
    *,
    contact_modulus: Quantity,
    radius: Quantity | None = None,
    curvature_min: Quantity | None = None,
    curvature_max: Quantity | None = None,
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
    radius, contact_modulus, curvature_min, curvature_max = _positive(
        "radius contact_modulus curvature_min curvature_max", radius, contact_modulus, curvature_min, curvature_max
    )
    delta = schema.ascending(delta, "nm", "delta")
    A, B = _paraboloid(radius, curvature_min, curvature_max)
    states = [ellipse.hertz(d, A, B, contact_modulus) for d in delta]
    names = {"P": "force", "a": "semi_axis_a", "b": "semi_axis_b", "area": "contact_area", "p0": "pressure"}
    return _along("delta", delta, {name: [getattr(state, key) for state in states] for key, name in names.items()})


def jkr_sphere(
    delta: Quantities, *, radius: Quantity, contact_modulus: Quantity, work_of_adhesion: Quantity
) -> xr.Dataset:
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
    radius, contact_modulus, work_of_adhesion = _positive(
        "radius contact_modulus work_of_adhesion", radius, contact_modulus, work_of_adhesion
    )
    delta = schema.ascending(delta, "nm", "delta")
    units = _jkr_units(radius, contact_modulus, work_of_adhesion)
    reduced = delta / units.delta
    a = np.array([jkr.stable_semi_axis(d) if d >= jkr.END_DELTA else np.nan for d in reduced])
    force = units.P * a**1.5 * (a**1.5 - 2)
    radius_of = units.a * a
    out = _along("delta", delta, {"force": force, "semi_axis_a": radius_of, "contact_area": np.pi * radius_of**2})
    return out.assign_attrs(end_of_branch=jkr.END_DELTA * units.delta)


def jkr_curve(
    *, radius: Quantity, contact_modulus: Quantity, work_of_adhesion: Quantity, largest: float = 2.0, points: int = 201
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
    radius, contact_modulus, work_of_adhesion = _positive(
        "radius contact_modulus work_of_adhesion", radius, contact_modulus, work_of_adhesion
    )
    units = _jkr_units(radius, contact_modulus, work_of_adhesion)
    a = np.linspace(0.0, largest, points)
    curve = {"delta": units.delta * (a**2 - 4 / 3 * np.sqrt(a)), "force": units.P * (a**3 - 2 * a**1.5)}
    return _along("semi_axis_a", units.a * a, curve)


def jkr_pull_off(
    *,
    work_of_adhesion: Quantity,
    radius: Quantity | None = None,
    curvature_min: Quantity | None = None,
    curvature_max: Quantity | None = None,
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
    formulation : {"energy", "self_similar"}
        How adhesion acts on an ellipse, see `superpose`.

    Returns
    -------
    float
        nN, positive.

    Raises
    ------
    ValueError
        If a number is not positive, the paraboloid is given twice or not at all, or the formulation is unknown.

    References
    ----------
    Giudici, Vella & Griffiths, arXiv 2407.00378.

    Examples
    --------
    >>> round(jkr_pull_off(radius=100, work_of_adhesion=0.1), 3)
    47.124
    >>> round(jkr_pull_off(curvature_min=0.01, curvature_max=0.05, work_of_adhesion=0.1) / 47.124 * 5**0.5, 4)
    0.9813
    """
    work_of_adhesion, radius, curvature_min, curvature_max = _positive(
        "work_of_adhesion radius curvature_min curvature_max", work_of_adhesion, radius, curvature_min, curvature_max
    )
    schema.one_of(formulation, FORMULATIONS, "formulation")
    A, B = _paraboloid(radius, curvature_min, curvature_max)
    if B == A:
        return 0.75 * np.pi * work_of_adhesion / A
    self_similar = float(jkr.self_similar_units(A, B, 1.0, work_of_adhesion).P)
    if formulation == "self_similar":
        return self_similar
    state = elliptic_jkr.contact_at(B / A, elliptic_jkr.largest_tension(B / A))
    return float(-state.P * self_similar)


def maugis_pull_off(
    *, radius: Quantity, contact_modulus: Quantity, work_of_adhesion: Quantity, adhesion_range: Quantity = 0.3
) -> float:
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
    radius, work_of_adhesion = _positive("radius work_of_adhesion", radius, work_of_adhesion)
    pair = {"contact_modulus": contact_modulus, "work_of_adhesion": work_of_adhesion, "adhesion_range": adhesion_range}
    parameter = maugis.parameter(tabor_parameter(radius=radius, **pair))
    return float(np.pi * work_of_adhesion * radius * maugis.pull_off(parameter))


def tabor_parameter(
    *, radius: Quantity, contact_modulus: Quantity, work_of_adhesion: Quantity, adhesion_range: Quantity = 0.3
) -> float:
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
    radius, contact_modulus, work_of_adhesion, adhesion_range = _positive(
        "radius contact_modulus work_of_adhesion adhesion_range",
        radius,
        contact_modulus,
        work_of_adhesion,
        adhesion_range,
    )
    return float(maugis.tabor(0.5 / radius, 0.5 / radius, contact_modulus, work_of_adhesion, adhesion_range))


def punch_pull_off(
    *, radius: Quantity, contact_modulus: Quantity, work_of_adhesion: Quantity, adhesion_range: Quantity | None = None
) -> float:
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
    Range matters to a punch that is small beside the cohesive zone, π E* w/(4σ₀²). An asperity flattened at
    a hardness above the pull of adhesion recovers on unloading, and is no flat punch: see `flattened_pull_off`.

    References
    ----------
    Kendall, J. Phys. D 4 (1971) 1186. The zone is that of Maugis, J. Colloid Interface Sci. 150 (1992) 243, for a flat.

    Examples
    --------
    >>> flat = {"radius": 10, "contact_modulus": 39.4, "work_of_adhesion": 0.1}
    >>> round(punch_pull_off(**flat), 1), round(punch_pull_off(adhesion_range=0.3, **flat), 1)
    (314.7, 104.7)
    """
    radius, contact_modulus, work_of_adhesion, adhesion_range = _positive(
        "radius contact_modulus work_of_adhesion adhesion_range",
        radius,
        contact_modulus,
        work_of_adhesion,
        adhesion_range,
    )
    from scipy.optimize import brentq

    if adhesion_range is None:
        return float(np.sqrt(8 * np.pi * work_of_adhesion * contact_modulus * radius**3))
    pull = work_of_adhesion / adhesion_range

    def opens_too_far(inner: float) -> float:
        m = radius / inner
        gap = 4 * pull * inner / (np.pi * contact_modulus) * (np.sqrt(m * m - 1) * np.arccos(1 / m) + 1 - m)
        return gap - adhesion_range

    least, most = 1e-9 * radius, radius * (1 - 1e-12)
    if opens_too_far(least) < 0:
        return float(np.pi * radius**2 * pull)
    inner = brentq(opens_too_far, least, most)
    return float(2 * pull * (inner * np.sqrt(radius**2 - inner**2) + radius**2 * np.arccos(inner / radius)))


def flattened_pull_off(
    *, radius: Quantity, contact_modulus: Quantity, work_of_adhesion: Quantity, hardness: Quantity
) -> float:
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
    peels from the rim. It acts as a flat punch, `punch_pull_off`, where H is small compared with √(w E*/a) (2 % less at
    0.03 times this, half at 1.2 times), and as JKR's sphere of radius E* a/H where H is large (3 % less at ten times).

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
    radius, contact_modulus, work_of_adhesion, hardness = _positive(
        "radius contact_modulus work_of_adhesion hardness", radius, contact_modulus, work_of_adhesion, hardness
    )
    from scipy.optimize import brentq

    punch = punch_pull_off(radius=radius, contact_modulus=contact_modulus, work_of_adhesion=work_of_adhesion)
    load = hardness * radius**2
    part = 3 * punch / (8 * load)  # where the pull is largest, s^{3/2}/√(1 − s²)
    s = brentq(lambda s: (s / part) ** 2 * s + s * s - 1, 0.0, 1.0, xtol=1e-15)
    return float(punch * s**1.5 - 2 * load * (np.arcsin(s) - s * s**1.5 / part))


def dmt_pull_off(*, radius: Quantity, work_of_adhesion: Quantity) -> float:
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
    radius, work_of_adhesion = _positive("radius work_of_adhesion", radius, work_of_adhesion)
    return 2 * np.pi * work_of_adhesion * radius


def rigid_sphere(
    distance: Quantities,
    *,
    radius: Quantity,
    work_of_adhesion: Quantity,
    length: Quantity,
    law: str = "hamaker",
    retardation: Quantity | None = None,
) -> xr.Dataset:
    """Return the force between a rigid sphere and a flat half space across a gap, integrated over the true sphere.

    By law="hamaker" it is Hamaker's 2A R³/(3D²(D + 2R)²), with A = 12π z₀² w.

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
    >>> curve = rigid_sphere([0.3], radius=1000, work_of_adhesion=0.1 / (12 * np.pi * 0.3**2), length=0.3)
    >>> round(float(curve.force[0]), 4)
    -185.1296
    """
    radius, work_of_adhesion, length, retardation = _positive(
        "radius work_of_adhesion length retardation", radius, work_of_adhesion, length, retardation
    )
    z = schema.ascending(distance, "nm", "distance")
    if z[0] <= 0:
        raise ValueError(f"distance: expected positive distances, found {z[0]:g} nm")
    attraction = _potential(law, work_of_adhesion, length, retardation)
    return _along("distance", z, {"force": -potentials.sphere_pull(z, radius, attraction)})


def meniscus_sphere(
    distance: Quantities,
    *,
    radius: Quantity,
    kelvin_radius: Quantity,
    surface_tension: Quantity = 0.072,
    contact_angle: Quantities = 0.0,
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
    Along the meridian, inclined by φ, Young's and Laplace's equation has the integral C = 2r sin φ + r²/r_K, the pull
    being πγC. It starts from the plane at φ = π − θ₂ and ends on the sphere at φ = β + θ₁, β from its axis.

    References
    ----------
    Orr, Scriven & Rivas, J. Fluid Mech. 67 (1975) 723; Dörmann & Schmid, Langmuir 30 (2014) 1055.

    Examples
    --------
    >>> found = meniscus_sphere([0.0], radius=100, kelvin_radius=4.9758)
    >>> round(float(found.force[0]), 2), round(float(found.thin_force[0]), 2)
    (-82.53, -90.48)
    """
    radius, kelvin_radius, surface_tension = _positive(
        "radius kelvin_radius surface_tension", radius, kelvin_radius, surface_tension
    )
    D = schema.ascending(distance, "nm", "distance")
    if D[0] < 0:
        raise ValueError(f"distance: expected distances of at least 0 nm, found {D[0]:g} nm")
    angles = liquid.angles(contact_angle)
    constants = np.array([_meniscus(gap_value, radius, kelvin_radius, *angles) for gap_value in D])
    thin = 2 * radius * np.maximum(sum(np.cos(angles)) - D / kelvin_radius, 0.0)
    forces = {"force": constants, "thin_force": thin}
    return _along("distance", D, {name: 0 - np.pi * surface_tension * each for name, each in forces.items()})


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


def rumpf(
    *,
    radius: Quantity,
    asperity_radius: Quantity | None = None,
    rms: Quantity | None = None,
    hamaker_constant: Quantity,
    closest_approach: Quantity = 0.165,
) -> float:
    """Return Rumpf's pull of a sphere on a plane with one hemispherical asperity.

    Parameters
    ----------
    radius : number or quantity
        Of the sphere, nm.
    asperity_radius, rms : number or quantity
        Radius of the asperity, whose centre lies in the plane, or the roughness that hemispheres of radius 1.48 rms
        give a surface; nm, one of them.
    hamaker_constant, closest_approach : number or quantity
        A, nN nm, and z₀ between sphere and asperity, nm.

    Returns
    -------
    float
        nN, positive: (A/6z₀²) [rR/(r + R) + R/(1 + r/z₀)²].

    Raises
    ------
    ValueError
        If a number is not positive, or both or none are given of radius and roughness.

    References
    ----------
    Rumpf, Particle Technology (1990); Rabinovich, Adler, Ata, Singh & Moudgil, J. Colloid Interface Sci. 232 (2000) 10.

    Examples
    --------
    >>> sphere = {"radius": 1000, "hamaker_constant": "1e-19 J", "closest_approach": 0.3}
    >>> round(rumpf(asperity_radius=10, **sphere), 3), rumpf(rms=2, **sphere) == rumpf(asperity_radius=2.96, **sphere)
    (1.991, True)
    """
    radius, asperity_radius, rms, hamaker_constant, closest_approach = _positive(
        "radius asperity_radius rms hamaker_constant closest_approach",
        radius,
        asperity_radius,
        rms,
        hamaker_constant,
        closest_approach,
    )
    if (asperity_radius is None) == (rms is None):
        raise ValueError(f"expected asperity_radius or rms, found {'none of them' if rms is None else 'both'}")
    R, z, r = radius, closest_approach, _HEMISPHERE * rms if asperity_radius is None else asperity_radius
    return hamaker_constant / (6 * z**2) * (r * R / (r + R) + R / (1 + r / z) ** 2)


def rabinovich(
    *,
    radius: Quantity,
    rms: Quantity,
    wavelength: Quantity,
    hamaker_constant: Quantity,
    closest_approach: Quantity = 0.165,
    long_rms: Quantity | None = None,
    long_wavelength: Quantity | None = None,
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
    radius, rms, wavelength, hamaker_constant, closest_approach, long_rms, long_wavelength = _positive(
        "radius rms wavelength hamaker_constant closest_approach long_rms long_wavelength",
        radius,
        rms,
        wavelength,
        hamaker_constant,
        closest_approach,
        long_rms,
        long_wavelength,
    )
    flat = hamaker_constant * radius / (6 * closest_approach**2)
    near = 1 / (1 + _CAP_HEIGHT * rms / closest_approach) ** 2
    cap = 1 / (1 + _CAP_RADIUS * radius * rms / wavelength**2)
    if (long_rms is None) != (long_wavelength is None):
        raise ValueError("long_rms, long_wavelength: expected both or neither, found one")
    if long_rms is None:
        return flat * (cap + near)
    return flat * (cap + near / (1 + _CAP_RADIUS * radius * long_rms / long_wavelength**2))


def gaussian_work(
    *, rms: Quantity, length: Quantity, work_of_adhesion: Quantity = 1.0, law: str = "lennard_jones", cut: float = 4.0
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

    Raises
    ------
    ValueError
        If a number is not positive, or the law is unknown.

    Examples
    --------
    >>> round(gaussian_work(rms=0.3, length=0.3), 4)
    0.0795
    """
    rms, length, work_of_adhesion = _positive("rms length work_of_adhesion", rms, length, work_of_adhesion)
    return potentials.gaussian_mean(_potential(law, work_of_adhesion, length), rms, cut)


def _potential(law: str, work: float, length: float, retardation: float | None = None) -> potentials.Potential:
    """Return a law of attraction whose work from ``length`` on is ``work``, retarded or not."""
    schema.one_of(law, tuple(potentials.POTENTIALS), "law")
    if law != "hamaker" and retardation is not None:
        raise ValueError(f"retardation: used by law='hamaker' only, found law={law!r}; leave it out")
    built = potentials.potential(law, work, length, np.inf if retardation is None else retardation)
    if built.code == potentials.RETARDED:
        return built._replace(work=work**2 / float(potentials.energy(length, built)))
    return built


def _paraboloid(radius: float | None, flat: float | None, sharp: float | None) -> tuple[float, float]:
    """Return half the principal curvatures, nm⁻¹."""
    if (radius is None) == (flat is None) or (flat is None) != (sharp is None):
        raise ValueError("expected either radius, or curvature_min and curvature_max")
    if radius is not None:
        return 0.5 / radius, 0.5 / radius
    if flat > sharp:
        raise ValueError(f"curvature_min: expected at most curvature_max = {sharp:g}, found {flat:g}")
    return 0.5 * flat, 0.5 * sharp


def _jkr_units(radius: float, contact_modulus: float, work_of_adhesion: float) -> jkr.Units:
    return jkr.self_similar_units(0.5 / radius, 0.5 / radius, contact_modulus, work_of_adhesion)


def _along(axis: str, values: np.ndarray, curves: dict[str, Any]) -> xr.Dataset:
    """Return labelled curves along an axis with these values."""
    data = {name: (axis, np.asarray(numbers, dtype=float)) for name, numbers in curves.items()}
    return schema.label(xr.Dataset(data, {axis: values}))
