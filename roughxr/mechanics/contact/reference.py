"""Closed forms for comparison: single smooth contacts, and the usual formulas for rough surfaces.

Lengths in nm, moduli in GPa, works of adhesion in J/m², Hamaker constants in nN nm (1e-18 J), or quantities such as
"3 um" and "6.5e-20 J"; forces are returned in nN. For two spheres ``radius`` is the composite radius, 1/R = 1/R₁ +
1/R₂. Single values are returned as floats, curves as labelled Datasets. Values must be positive.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
import xarray as xr

from ..asperity.asperity_sum import DEFAULT, FORMULATIONS
from ..bodies import liquid
from ..bodies.pair import contact_modulus, hamaker_constant
from ..kernels.adhesion import potentials
from ..kernels.asperity import asperity_laws, ellipse, elliptic_jkr, maugis
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import LENNARD_JONES, read_law
from ..vocabulary.calls import checked_call
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Quantities, Quantity, positive
from .estimates import tabor

__all__ = [
    "contact_modulus",
    "gaussian_work",
    "gilman_surface_energy",
    "hamaker_constant",
    "hertz",
    "jkr_paraboloid",
    "jkr_pull_off",
    "jkr_sphere",
    "meniscus_sphere",
    "rabinovich",
    "rumpf",
    "tabor",
    "tabor_parameter",
]

#: Rabinovich's caps: height over the rms height.
_CAP_HEIGHT = 1.82

#: Rabinovich's caps: λ² over radius and rms height.
_CAP_RADIUS = 58.0

#: Rabinovich's hemispheres: radius over the rms height.
_HEMISPHERE = 1.48

#: Units of options that are numbers or quantities.
_UNITS = {"contact_modulus": "GPa", "young_modulus": "GPa", "curvature_min": "1/nm", "curvature_max": "1/nm"}
_UNITS |= {"work_of_adhesion": "J/m^2", "surface_tension": "J/m^2", "hamaker_constant": "nN nm"}
_UNITS |= dict.fromkeys(("radius", "asperity_radius", "kelvin_radius", "atomic_radius", "plane_distance"), "nm")
_UNITS |= dict.fromkeys(("rms", "wavelength", "long_rms", "long_wavelength"), "nm")
_UNITS |= dict.fromkeys(("length", "adhesion_range", "closest_approach"), "nm")

_Formula = TypeVar("_Formula", bound=Callable[..., Any])


def _takes_quantities(function: _Formula) -> _Formula:
    """Return a formula whose options of `_UNITS` become positive numbers in these units."""

    @functools.wraps(function)
    def formula(*arguments: Any, **options: Any) -> Any:
        units = {name: _UNITS[name] for name, value in options.items() if name in _UNITS and value is not None}
        return function(*arguments, **options | {name: positive(options[name], units[name], name) for name in units})

    return checked_call(cast(_Formula, formula))


@_takes_quantities
def hertz(
    delta: Quantities,
    *,
    contact_modulus: Quantity,
    radius: Quantity | None = None,
    curvature_min: Quantity | None = None,
    curvature_max: Quantity | None = None,
) -> xr.Dataset:
    """Return Hertz's contact of a sphere (radius) or paraboloid (both curvatures) with a half space.

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

    References
    ----------
    Johnson, Contact Mechanics (1985), §4.2.

    Examples
    --------
    >>> import roughxr
    >>> round(float(roughxr.reference.hertz([5.08], radius="3 um", contact_modulus=39.407).force[0]), 0)
    32951.0
    """
    delta = schema.ascending(delta, "nm", "delta")
    A, B = _paraboloid(radius, curvature_min, curvature_max)
    states = [ellipse.hertz(d, A, B, contact_modulus) for d in delta]
    names = {"P": "force", "a": "semi_axis_a", "b": "semi_axis_b", "area": "contact_area", "p0": "pressure"}
    return _curves("delta", delta, {name: [getattr(state, key) for state in states] for key, name in names.items()})


def jkr_sphere(
    delta: Quantities, *, radius: Quantity, contact_modulus: Quantity, work_of_adhesion: Quantity
) -> xr.Dataset:
    """Return JKR's sphere on its stable branch under displacement control, that of retraction.

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
        at −3^{−1/3} δ_c, which the attribute ``branch_end`` states in nm.

    References
    ----------
    Johnson, Kendall & Roberts, Proc. R. Soc. A 324 (1971) 301, doi:10.1098/rspa.1971.0141.

    Examples
    --------
    >>> import roughxr
    >>> found = roughxr.reference.jkr_sphere([0.0], radius=3000, contact_modulus=39.407, work_of_adhesion=1.2842)
    >>> round(float(found.force[0] / roughxr.reference.jkr_pull_off(radius=3000, work_of_adhesion=1.2842)), 4)
    -0.8889
    """
    sphere = {"radius": radius, "contact_modulus": contact_modulus, "work_of_adhesion": work_of_adhesion}
    contact = jkr_paraboloid(delta, **sphere).sel(branch="stable", drop=True)
    return contact[["force", "semi_axis_a", "contact_area"]]


@_takes_quantities
def jkr_paraboloid(
    delta: Quantities,
    *,
    contact_modulus: Quantity,
    work_of_adhesion: Quantity,
    radius: Quantity | None = None,
    curvature_min: Quantity | None = None,
    curvature_max: Quantity | None = None,
    formulation: str = DEFAULT,
) -> xr.Dataset:
    """Return the generalized JKR contact of a sphere (radius) or paraboloid (both curvatures) with a half space.

    Parameters
    ----------
    delta : array_like or quantity
        Displacements, nm, ascending.
    contact_modulus, work_of_adhesion : number or quantity
        E*, GPa; w = 2γ, J/m².
    radius : number or quantity, optional
        Of a sphere, nm. Give either this or both curvatures.
    curvature_min, curvature_max : number or quantity, optional
        Principal curvatures 2A ≤ 2B of the paraboloid, nm⁻¹; up to a ratio of 1000. Add the curvature of the other
        body, if it has one.
    formulation : {"energy", "self_similar", "published"}
        How adhesion acts on an ellipse, see `superpose`.

    Returns
    -------
    Dataset
        ``force`` (nN), ``semi_axis_a`` and ``semi_axis_b`` (nm) and ``contact_area`` (nm²) along (branch, delta), with
        branch "stable" or "unstable" at a prescribed displacement. NaN beyond the ends of a branch: both begin at the
        attribute ``branch_end`` (nm); the unstable one ends at delta = 0, without contact. The units a_c, δ_c and P_c
        (``unit_semi_axis``, ``unit_delta``, ``unit_force``) and λ = b/a of Hertz's ellipse (``axis_ratio``) are
        variables.

    Notes
    -----
    With P* = P/P_c, a* = a/a_c and δ* = δ/δ_c, "self_similar" and "published" follow P* = a*³ − 2a*^{3/2} and
    δ* = a*² − (4/3)√a*, to δ* = −3^{−1/3}. Their units are a_c³ = 9γλK/(2β²E*), δ_c = βa_c² and P_c = 3πγλ/β with
    β = A + λ²B; "published" has λ² for λ. "energy" has the units of "self_similar", but other curves.

    The branch is that of retraction. Bodies without range jump into contact at delta = 0, not where the branch begins.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 1–24; Giudici, Vella & Griffiths, arXiv 2407.00378.

    Examples
    --------
    >>> import roughxr
    >>> shape = {"curvature_min": 0.001, "curvature_max": 0.002}
    >>> contact = roughxr.reference.jkr_paraboloid([-0.5, 0.0, 2.0], **shape, contact_modulus=40, work_of_adhesion=1.35)
    >>> contact.force.sel(branch="stable").values.round(0).tolist()
    [-4429.0, -3981.0, 629.0]
    >>> round(float(contact.axis_ratio), 4)
    0.6306
    """
    schema.one_of(formulation, FORMULATIONS, "formulation")
    delta = schema.ascending(delta, "nm", "delta")
    A, B = _paraboloid(radius, curvature_min, curvature_max)
    scales = asperity_laws.asperity_scales(A, B, contact_modulus, work_of_adhesion, asperity_laws.law(formulation))
    delta_star = delta / scales.delta
    end = asperity_laws.branch_end(formulation, B / A)
    is_adhering = delta_star >= end
    on_branch = {"stable": is_adhering, "unstable": is_adhering & (delta_star <= 0)}
    states = [
        asperity_laws.branch_states(formulation, delta_star, B / A, stable=name == "stable") for name in on_branch
    ]
    P, a, b = (np.where(list(on_branch.values()), values, np.nan) for values in zip(*[state[:3] for state in states]))
    a = scales.a * a
    b = scales.a * b
    curves = {"force": scales.P * P, "semi_axis_a": a, "semi_axis_b": b, "contact_area": np.pi * a * b}
    data = {name: (("branch", "delta"), values) for name, values in curves.items()}
    units = {"unit_semi_axis": scales.a, "unit_delta": scales.delta, "unit_force": scales.P}
    out = xr.Dataset(data | units | {"axis_ratio": scales.axis_ratio}, {"branch": list(on_branch), "delta": delta})
    out.attrs = {"formulation": formulation, "branch_end": end * scales.delta}
    return schema.label(out)


@_takes_quantities
def jkr_pull_off(
    *,
    work_of_adhesion: Quantity,
    radius: Quantity | None = None,
    curvature_min: Quantity | None = None,
    curvature_max: Quantity | None = None,
    formulation: str = DEFAULT,
) -> float:
    """Return JKR's pull-off force of a sphere, 3/2 π w R (radius), or of a paraboloid (both curvatures).

    Parameters
    ----------
    work_of_adhesion : number or quantity
        J/m².
    radius : number or quantity, optional
        nm. Give either this or both curvatures.
    curvature_min, curvature_max : number or quantity, optional
        nm⁻¹, the smaller first; up to a ratio of 1000.
    formulation : {"energy", "self_similar", "published"}
        How adhesion acts on an ellipse, see `superpose`.

    Returns
    -------
    float
        nN, positive.

    References
    ----------
    Giudici, Vella & Griffiths, arXiv 2407.00378.

    Examples
    --------
    >>> import roughxr
    >>> round(roughxr.reference.jkr_pull_off(radius=100, work_of_adhesion=0.1), 3)
    47.124
    >>> elliptic = roughxr.reference.jkr_pull_off(curvature_min=0.01, curvature_max=0.05, work_of_adhesion=0.1)
    >>> round(elliptic / 47.124 * 5**0.5, 4)
    0.9813
    """
    schema.one_of(formulation, FORMULATIONS, "formulation")
    A, B = _paraboloid(radius, curvature_min, curvature_max)
    unit = float(asperity_laws.asperity_scales(A, B, 1.0, work_of_adhesion, asperity_laws.law(formulation)).P)
    if formulation != "energy" or B == A:
        return unit
    state = elliptic_jkr.contact_at(B / A, elliptic_jkr.largest_tension(B / A))
    return float(-state.P * unit)


@_takes_quantities
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
    Tabor, J. Colloid Interface Sci. 58 (1977) 2, doi:10.1016/0021-9797(77)90366-6.

    Examples
    --------
    >>> import roughxr
    >>> round(roughxr.reference.tabor_parameter(radius=3000, contact_modulus=39.407, work_of_adhesion=1.35), 1)
    5.1
    """
    return float(maugis.tabor(0.5 / radius, 0.5 / radius, contact_modulus, work_of_adhesion, adhesion_range))


@_takes_quantities
def gilman_surface_energy(
    *,
    young_modulus: Quantity,
    poisson_ratio: float = 0.0,
    plane_distance: Quantity = 0.2,
    atomic_radius: Quantity = 0.13,
) -> float:
    """Return Gilman's estimate of the surface energy from Young's modulus, γ = (E/y₀)(a₀/π)².

    Parameters
    ----------
    young_modulus : number or quantity
        E, GPa.
    poisson_ratio : float
        With it E/(1 − ν²) takes the place of E. Cheng, Dunn & Brach print E, but their pull-off of the smooth sphere,
        19.1 µN, has E/(1 − ν²).
    plane_distance, atomic_radius : number or quantity
        y₀, distance of the planes of cleavage, and a₀, radius of their atoms; nm.

    Returns
    -------
    float
        γ, J/m²; the work of adhesion of two equal bodies is 2γ.

    References
    ----------
    Gilman, in Fracture (1959); Cheng, Dunn & Brach, eq. 43.

    Examples
    --------
    >>> import roughxr
    >>> round(roughxr.reference.gilman_surface_energy(young_modulus=75), 4)
    0.6421
    >>> round(roughxr.reference.gilman_surface_energy(young_modulus="75 GPa", poisson_ratio=0.22), 4)
    0.6748
    """
    return young_modulus / (1 - poisson_ratio**2) / plane_distance * (atomic_radius / np.pi) ** 2


@_takes_quantities
def meniscus_sphere(
    distance: Quantities,
    *,
    radius: Quantity,
    kelvin_radius: Quantity,
    surface_tension: Quantity = 0.072,
    contact_angle: Quantities = 0.0,
) -> xr.Dataset:
    """Return the capillary force of condensed liquid between a rigid sphere and a plane, by the exact meniscus.

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
        ``force`` (nN, < 0 attracts) along ``distance``, 0 where no liquid bridge exists; ``thin_force``, the force of
        thin menisci, 2πRγ(cos θ₁ + cos θ₂ − D/r_K).

    Notes
    -----
    The Young-Laplace equation has the integral C = 2r sin φ + r²/r_K along the meridian of inclination φ. The capillary
    force is πγC. The meridian starts on the plane at φ = π − θ₂ and ends on the sphere at φ = β + θ₁, β from its axis.

    References
    ----------
    Orr, Scriven & Rivas, J. Fluid Mech. 67 (1975) 723, doi:10.1017/S0022112075000572; Dörmann & Schmid, Langmuir 30
    (2014) 1055.

    Examples
    --------
    >>> import roughxr
    >>> found = roughxr.reference.meniscus_sphere([0.0], radius=100, kelvin_radius=4.9758)
    >>> round(float(found.force[0]), 2), round(float(found.thin_force[0]), 2)
    (-82.53, -90.48)
    """
    D = schema.ascending(distance, "nm", "distance")
    if D[0] < 0:
        raise Refusal("distance", "distances of at least 0 nm", f"{D[0]:g} nm")
    angles = liquid.angles(contact_angle)
    constants = np.array([_meniscus(gap_value, radius, kelvin_radius, *angles) for gap_value in D])
    thin = 2 * radius * np.maximum(sum(np.cos(angles)) - D / kelvin_radius, 0.0)
    forces = {"force": constants, "thin_force": thin}
    return _curves("distance", D, {name: 0 - np.pi * surface_tension * factor for name, factor in forces.items()})


def _meniscus(distance: float, R: float, r_K: float, sphere: float, plane: float) -> float:
    """Return C (nm) of the exact meniscus between a sphere and a plane; 0 where no liquid bridge exists."""
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


@_takes_quantities
def rumpf(
    *,
    radius: Quantity,
    asperity_radius: Quantity | None = None,
    rms: Quantity | None = None,
    hamaker_constant: Quantity,
    closest_approach: Quantity = 0.165,
) -> float:
    """Return Rumpf's pull-off force of a sphere on a plane with a hemisphere (asperity_radius, or rms of the plane).

    Parameters
    ----------
    radius, hamaker_constant, closest_approach : number or quantity
        Of the sphere, nm; A, nN nm; z₀ between sphere and asperity, nm.
    asperity_radius, rms : number or quantity
        Radius of the asperity, whose centre lies in the plane, or rms height of hemispheres, of radius 1.48 rms; nm,
        one of them.

    Returns
    -------
    float
        nN, positive: (A/6z₀²) [rR/(r + R) + R/(1 + r/z₀)²].

    References
    ----------
    Rumpf, Particle Technology (1990); Rabinovich, Adler, Ata, Singh & Moudgil, J. Colloid Interface Sci. 232 (2000) 10,
    doi:10.1006/jcis.2000.7167.

    Examples
    --------
    >>> import roughxr
    >>> sphere = {"radius": 1000, "hamaker_constant": "1e-19 J", "closest_approach": 0.3}
    >>> round(roughxr.reference.rumpf(asperity_radius=10, **sphere), 3)
    1.991
    >>> roughxr.reference.rumpf(rms=2, **sphere) == roughxr.reference.rumpf(asperity_radius=2.96, **sphere)
    True
    """
    if (asperity_radius is None) == (rms is None):
        raise Refusal("", "asperity_radius or rms", "none of them" if rms is None else "both")
    R = radius
    z = closest_approach
    r = _HEMISPHERE * rms if asperity_radius is None else asperity_radius
    return hamaker_constant / (6 * z**2) * (r * R / (r + R) + R / (1 + r / z) ** 2)


@_takes_quantities
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
    """Return Rabinovich's pull-off force of a sphere on a surface of spherical caps, of one or two scales.

    Parameters
    ----------
    radius, hamaker_constant, closest_approach : number or quantity
        Of the sphere, nm; A, nN nm; z₀, nm.
    rms, wavelength : number or quantity
        Root mean square roughness and peak-to-peak distance, nm, of the only scale or the shorter of two.
    long_rms, long_wavelength : number or quantity, optional
        Roughness and distance of the longer scale, nm; both or none.

    Returns
    -------
    float
        nN, positive. Caps have the radius λ²/(58 rms) and the height 1.82 rms. For one scale
        (AR/6z₀²) [1/(1 + 58 R rms/λ²) + 1/(1 + 1.82 rms/z₀)²]; for two the sphere touches small caps on large ones:
        (AR/6z₀²) [1/(1 + 58 R rms₂/λ₂²) + 1/((1 + 58 R rms₁/λ₁²)(1 + 1.82 rms₂/z₀)²)]. Without the longer scale
        this is the former. The plane beneath both scales is left out.

    References
    ----------
    Rabinovich, Adler, Ata, Singh & Moudgil, J. Colloid Interface Sci. 232 (2000) 10 and 17, doi:10.1006/jcis.2000.7167
    and .7168.

    Examples
    --------
    >>> import roughxr
    >>> arguments = {"radius": 1000, "rms": 1, "wavelength": 50, "hamaker_constant": "1e-19 J", "closest_approach": 0.3}
    >>> round(roughxr.reference.rabinovich(**arguments), 2)
    11.36
    >>> round(roughxr.reference.rabinovich(**arguments, long_rms=10, long_wavelength=1000), 2)
    10.0
    """
    flat = hamaker_constant * radius / (6 * closest_approach**2)
    near = 1 / (1 + _CAP_HEIGHT * rms / closest_approach) ** 2
    cap = 1 / (1 + _CAP_RADIUS * radius * rms / wavelength**2)
    if (long_rms is None) != (long_wavelength is None):
        raise Refusal("long_rms, long_wavelength", "both or neither", "one")
    if long_rms is None:
        return flat * (cap + near)
    return flat * (cap + near / (1 + _CAP_RADIUS * radius * long_rms / long_wavelength**2))


@_takes_quantities
def gaussian_work(
    *, rms: Quantity, length: Quantity, work_of_adhesion: Quantity = 1.0, law: str = LENNARD_JONES, cut: float = 4.0
) -> float:
    """Return the work of adhesion between Gaussian heights and a rigid flat: the largest mean of the potential.

    Parameters
    ----------
    rms : number or quantity
        Standard deviation of the heights, nm.
    length : number or quantity
        Length of the law, nm: the cut-off z₀ of "hamaker", ε of "lennard_jones", ρ of "exponential", the range of
        "dugdale".
    work_of_adhesion : number or quantity
        Work of adhesion of smooth surfaces, J/m².
    law : {"hamaker", "lennard_jones", "exponential", "dugdale"}
        For laws without repulsion, the highest summit comes no closer than on a smooth surface.
    cut : float
        Heights are cut off at this many standard deviations.

    Returns
    -------
    float
        J/m²; the pull-off force of a large rigid sphere is 2πR times this work.

    Examples
    --------
    >>> import roughxr
    >>> round(roughxr.reference.gaussian_work(rms=0.3, length=0.3), 4)
    0.0795
    """
    potential = potentials.potential(read_law(law, "rigid"), work_of_adhesion, length)
    return potentials.gaussian_mean(potential, rms, cut)


def _paraboloid(radius: float | None, flat: float | None, sharp: float | None) -> tuple[float, float]:
    """Return half the principal curvatures, nm⁻¹."""
    if (radius is None) == (flat is None) or (flat is None) != (sharp is None):
        raise Refusal("", "either radius, or curvature_min and curvature_max")
    if radius is not None:
        return 0.5 / radius, 0.5 / radius
    if flat > sharp:
        raise Refusal("curvature_min", f"at most curvature_max = {sharp:g}", f"{flat:g}")
    return 0.5 * flat, 0.5 * sharp


def _curves(axis: str, values: np.ndarray, curves: dict[str, Any]) -> xr.Dataset:
    """Return labelled curves along an axis with these values."""
    data = {name: (axis, np.asarray(numbers, dtype=float)) for name, numbers in curves.items()}
    return schema.label(xr.Dataset(data, {axis: values}))
