"""Loads on a sphere of radius r that rests on a wall: one function for each, collected in `LOADS`.

In wall shear of friction velocity u*, the flow at the wall is y u*²/ν. Its scale is the friction Reynolds number
r⁺ = r u*/ν; the shear Reynolds number of the sphere is r⁺².

    drag      1.7009 · 6π ρ u*² r²  = 32.06 ρ u*² r²        creeping flow, r⁺ ≤ 1       (O'Neill 1968)
    torque    0.94399 · 4π ρ u*² r³ = 11.86 ρ u*² r³        about the centre, the same   (Goldman, Cox & Brenner 1967)
    lift      9.22 ρ ν² r⁺⁴                                 r⁺ ≤ 1                       (Leighton & Acrivos 1985)
              20.9 ρ ν² r⁺^2.31                             1.8 ≤ r⁺ ≤ 70                (Hall 1988)

Drag and torque about the contact are 43.92 ρ u*² r³ together. Outside these ranges the formulas still return numbers,
and a flag says so. Lengths nm, forces nN; velocities m/s, densities kg/m³, kinematic viscosities m²/s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..vocabulary import schema
from ..vocabulary.units import Quantities, Quantity, factor, magnitude, positive

#: Air at 20 °C, as Reeks & Hall (2001) took it: kg/m³ and m²/s.
AIR_DENSITY, AIR_VISCOSITY = 1.181, 1.539e-5

#: m/s².
GRAVITY = 9.80665

_DRAG = 1.7009 * 6 * np.pi
_TORQUE = 0.94399 * 4 * np.pi

#: r⁺ up to which the flow around the sphere counts as creeping.
CREEPING = 1.0

#: r⁺ at which both formulas of lift are equal: 9.22 r⁺⁴ = 20.9 r⁺^2.31.
_EQUAL_LIFT = (20.9 / 9.22) ** (1 / 1.69)

LIFTS = ("by_range", "leighton_acrivos", "hall", "none")


class Flow(NamedTuple):
    """The fluid that streams over the wall, how it lifts a particle, and gravity.

    Density in kg/m³, kinematic viscosity in m²/s, gravity in m/s²; lift by "by_range", "leighton_acrivos", "hall" or
    "none", see `lift`.
    """

    density: Any = AIR_DENSITY
    viscosity: Any = AIR_VISCOSITY
    lift: str = "by_range"
    gravity: Any = GRAVITY


#: Fluids at 20 °C.
FLOWS = {"air": Flow(), "water": Flow(998.2, 1.004e-6)}


class Body(NamedTuple):
    """The particle, and the fluid around it."""

    radius: float  # nm
    density: float  # kg/m³, of the particle; NaN if its weight is left out
    flow: Flow = FLOWS["air"]


class Push(NamedTuple):
    """The force and torque of a load on the sphere, arrays of the strength's shape."""

    along: Any  # nN, at the sphere's centre, along the wall
    torque: Any  # nN nm, about the centre, in the direction of rolling
    away: Any  # nN, away from the wall, weight included
    in_range: Any  # whether the formulas are valid there


class Load(NamedTuple):
    """A kind of load: the meaning of its strength, and the push that it exerts."""

    words: str
    critical: str  # name of the variable for its critical strength
    push: Callable[[Any, Body], Push]
    span: tuple[float, float]  # strengths between which the critical one is searched, in the variable's units


def friction_reynolds(friction_velocity: Quantities, radius: Quantities, *, flow: Flow = FLOWS["air"]) -> Any:
    """Return r⁺ = r u*/ν.

    Parameters
    ----------
    friction_velocity : number, array or quantity
        m/s, not negative.
    radius : number, array or quantity
        nm.
    flow : Flow
        The fluid; by default air.

    Returns
    -------
    float or array

    Raises
    ------
    ValueError
        If a speed is negative.

    Examples
    --------
    >>> round(friction_reynolds(1.0, "5 um"), 4)
    0.3249
    """
    return _speed(friction_velocity) * _radius(radius) * factor("nm", "m") / _viscosity(flow)


def drag(friction_velocity: Quantities, radius: Quantities, *, flow: Flow = FLOWS["air"]) -> Any:
    """Return the drag on a sphere that touches a wall in shear, nN: 32.06 ρ u*² r², for r⁺ ≤ 1.

    Options, results and errors as for `friction_reynolds`.

    References
    ----------
    O'Neill, Chem. Eng. Sci. 23 (1968) 1293.

    Examples
    --------
    >>> round(drag(1.0, "5 um"), 4)
    0.9466
    """
    return _DRAG * _pressure(friction_velocity, flow) * _radius(radius) ** 2


def torque(friction_velocity: Quantities, radius: Quantities, *, flow: Flow = FLOWS["air"]) -> Any:
    """Return the torque about its centre of a sphere that touches a wall in shear, nN nm: 11.86 ρ u*² r³, for r⁺ ≤ 1.

    Options, results and errors as for `friction_reynolds`.

    References
    ----------
    Goldman, Cox & Brenner, Chem. Eng. Sci. 22 (1967) 653.

    Examples
    --------
    >>> r = 5000.0
    >>> about_the_contact = drag(1.0, r) * r + torque(1.0, r)
    >>> round(about_the_contact / (1.181e-9 * r**3), 2)
    43.92
    """
    return _TORQUE * _pressure(friction_velocity, flow) * _radius(radius) ** 3


def lift(friction_velocity: Quantities, radius: Quantities, *, flow: Flow = FLOWS["air"]) -> Any:
    """Return the lift on a sphere that touches a wall in shear, nN, by the flow's formula.

    "leighton_acrivos": 9.22 ρν² r⁺⁴, valid for r⁺ ≤ 1; "hall": 20.9 ρν² r⁺^2.31, measured for 1.8 ≤ r⁺ ≤ 70;
    "by_range", the default: the first up to where both are equal (r⁺ = 1.62), then the second. Options, results and
    errors as for `friction_reynolds`.

    References
    ----------
    Leighton & Acrivos, Z. angew. Math. Phys. 36 (1985) 174; Hall, J. Fluid Mech. 187 (1988) 451.

    Examples
    --------
    >>> round(lift(1.0, "5 um", flow=Flow(lift="hall")), 4)
    0.4355
    """
    schema.one_of(flow.lift, LIFTS, "flow.lift")
    plus = friction_reynolds(friction_velocity, radius, flow=flow)
    slow, fast = 9.22 * plus**4, 20.9 * plus**2.31
    formulas = {"by_range": np.where(plus < _EQUAL_LIFT, slow, fast), "leighton_acrivos": slow, "hall": fast}
    return formulas.get(flow.lift, 0.0 * plus) * _density(flow) * _viscosity(flow) ** 2 * factor("N", "nN")


def weight(radius: Quantities, density: Quantity, *, flow: Flow = FLOWS["air"]) -> Any:
    """Return a sphere's weight less its buoyancy, nN.

    Parameters
    ----------
    radius : number, array or quantity
        nm.
    density : number or quantity
        Of the particle, kg/m³.
    flow : Flow
        The fluid and gravity; by default air.

    Returns
    -------
    float or array

    Raises
    ------
    ValueError
        If a number is not positive.

    Examples
    --------
    >>> round(weight("5 um", 4000.0), 5)
    0.02053
    """
    difference = positive(density, "kg/m^3", "density") - _density(flow)
    return _mass(radius, difference) * float(magnitude(flow.gravity, "m/s^2", "flow.gravity"))


def in_range(plus: Any, formula: str) -> Any:
    """Return whether drag, torque and this formula of lift are valid at r⁺."""
    if formula == "hall":  # no r⁺ is in the range of both Hall's lift and creeping flow
        return np.zeros(np.shape(plus), bool)
    return np.asarray(plus) <= CREEPING


def _wall_shear(strength: Any, body: Body) -> Push:
    radius, flow = body.radius, body.flow
    away = lift(strength, radius, flow=flow) - _weight_of(body)
    plus = friction_reynolds(strength, radius, flow=flow)
    return Push(drag(strength, radius, flow=flow), torque(strength, radius, flow=flow), away, in_range(plus, flow.lift))


def _tilt(strength: Any, body: Body) -> Push:
    down, angle = _weight_of(body), np.asarray(strength)
    return Push(down * np.sin(angle), 0.0 * angle, -down * np.cos(angle), np.ones(angle.shape, bool))


def _centrifuge(strength: Any, body: Body) -> Push:
    force = _mass(body.radius, body.density - body.flow.density) * np.asarray(strength)
    return Push(0.0 * force, 0.0 * force, force - _weight_of(body), np.ones(force.shape, bool))


def _vibration(strength: Any, body: Body) -> Push:
    force = _mass(body.radius, body.density) * np.asarray(strength)
    return Push(force, 0.0 * force, np.full(force.shape, -_weight_of(body)), np.ones(force.shape, bool))


#: All loads, by name.
LOADS: dict[str, Load] = {
    "wall_shear": Load("shear flow along the wall", "critical_friction_velocity", _wall_shear, (1e-5, 1e4)),
    "tilt": Load("weight on a tilted wall", "critical_angle", _tilt, (0.0, np.pi)),
    "centrifuge": Load("acceleration away from the wall", "critical_acceleration", _centrifuge, (1e-3, 1e14)),
    "vibration": Load("acceleration along the wall", "critical_acceleration", _vibration, (1e-3, 1e14)),
}


def _weight_of(body: Body) -> float:
    """Return the weight, nN; 0 where no density is given."""
    return 0.0 if np.isnan(body.density) else float(weight(body.radius, body.density, flow=body.flow))


def _mass(radius: Any, density: float) -> Any:
    """Return the mass in units in which an acceleration in m/s² gives a force in nN."""
    return 4 / 3 * np.pi * _radius(radius) ** 3 * density * factor("kg/m^3 nm^3 m/s^2", "nN")


def _pressure(friction_velocity: Any, flow: Flow) -> Any:
    """Return ρ u*², GPa."""
    return _density(flow) * _speed(friction_velocity) ** 2 * factor("Pa", "GPa")


def _density(flow: Flow) -> float:
    return positive(flow.density, "kg/m^3", "flow.density")


def _viscosity(flow: Flow) -> float:
    return positive(flow.viscosity, "m^2/s", "flow.viscosity")


def _radius(value: Any) -> Any:
    return _at_least(magnitude(value, "nm", "radius"), "radius", "nm", above=True)


def _speed(value: Any) -> Any:
    return _at_least(magnitude(value, "m/s", "friction_velocity"), "friction_velocity", "m/s")


def _at_least(number: Any, name: str, units: str, *, above: bool = False) -> Any:
    """Raise for numbers below 0, with ``above`` also for 0."""
    least = np.min(number, initial=np.inf)
    if least < 0 or (above and least == 0):
        words = "positive numbers" if above else "numbers that are not negative"
        raise ValueError(f"{name}: expected {words} in {units}, found {least:g}")
    return number
