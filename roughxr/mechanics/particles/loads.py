"""Loads on a sphere of radius r that rests on a wall, collected in `LOADS`.

In wall shear of friction velocity u*, the flow at the wall is y u*²/ν. Its scale is the friction Reynolds number
r⁺ = r u*/ν; the shear Reynolds number of the sphere is r⁺².

    drag      1.7009 · 6π ρ u*² r²  = 32.06 ρ u*² r²    creeping flow, r⁺ ≤ 1     O'Neill, Chem. Eng. Sci. 23 (1968)
    torque    0.94399 · 4π ρ u*² r³ = 11.86 ρ u*² r³    about the centre          Goldman, Cox & Brenner, 22, 653
    lift      9.22 ρ ν² r⁺⁴          r⁺ ≤ 1             Leighton & Acrivos, Z. angew. Math. Phys. 36 (1985) 174
              20.9 ρ ν² r⁺^2.31      1.8 ≤ r⁺ ≤ 70      Hall, J. Fluid Mech. 187 (1988) 451

Drag and torque about the contact are 43.92 ρ u*² r³ together. Outside these ranges the formulas still return numbers,
and a flag marks them. Lengths nm, forces nN; velocities m/s, densities kg/m³, kinematic viscosities m²/s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..vocabulary import schema
from ..vocabulary.calls import checked_class
from ..vocabulary.units import factor, magnitude, positive

#: Density (kg/m³) of air at 20 °C, as in Reeks & Hall (2001).
AIR_DENSITY = 1.181

#: Kinematic viscosity (m²/s) of air at 20 °C, as in Reeks & Hall (2001).
AIR_VISCOSITY = 1.539e-5

#: Standard gravity, m/s².
GRAVITY = 9.80665

#: Drag over ρ u*² r², and torque over ρ u*² r³.
_DRAG = 1.7009 * 6 * np.pi
_TORQUE = 0.94399 * 4 * np.pi

#: Largest r⁺ of creeping flow around the sphere.
CREEPING = 1.0

#: r⁺ at which both formulas of lift agree: 9.22 r⁺⁴ = 20.9 r⁺^2.31.
_EQUAL_LIFT = (20.9 / 9.22) ** (1 / 1.69)

LIFTS = ("by_range", "leighton_acrivos", "hall", "none")


@checked_class
class Flow(NamedTuple):
    """The fluid over the wall, its formula of lift, and gravity.

    Density in kg/m³, kinematic viscosity in m²/s, gravity in m/s²; lift by "leighton_acrivos", "hall", "by_range" (the
    first up to r⁺ = 1.62, where both agree, then the second) or "none".

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> moments = scan.contact.rolling(directions=8, subregions=(2, 2))
    >>> helium = roughxr.particles.Flow(density=0.166, viscosity=1.18e-4)
    >>> critical = moments.contact.critical_load(flow=helium)
    >>> bool((critical.critical_friction_velocity > 0).all())
    True
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
    density: float  # kg/m³, of the particle; NaN to neglect its weight
    flow: Flow = FLOWS["air"]


class Push(NamedTuple):
    """The force and torque of a load on the sphere, arrays of the strength's shape."""

    along: Any  # nN, at the sphere's centre, along the wall
    torque: Any  # nN nm, about the centre, in the direction of rolling
    away: Any  # nN, away from the wall, weight included
    in_range: Any  # whether the formulas are valid


class Load(NamedTuple):
    """A kind of load: the name of its critical strength, and its force and torque."""

    critical: str  # name of the variable for its critical strength
    push: Callable[[Any, Body], Push]
    span: tuple[float, float]  # range of strengths that is searched, in the variable's units


def read_flow(flow: str | Flow) -> Flow:
    """Return a fluid, given by name or as a `Flow`, in plain numbers; raise for anything else."""
    flow = flow if isinstance(flow, Flow) else FLOWS[schema.one_of(flow, FLOWS, "flow")]
    return Flow(
        density=positive(flow.density, "kg/m^3", "flow.density"),
        viscosity=positive(flow.viscosity, "m^2/s", "flow.viscosity"),
        lift=schema.one_of(flow.lift, LIFTS, "flow.lift"),
        gravity=float(magnitude(flow.gravity, "m/s^2", "flow.gravity")),
    )


def friction_reynolds(speed: Any, radius: Any, flow: Flow = FLOWS["air"]) -> Any:
    """Return r⁺ = r u*/ν, for a friction velocity (m/s) and a radius (nm)."""
    return speed * radius * factor("nm", "m") / flow.viscosity


def drag(speed: Any, radius: Any, flow: Flow = FLOWS["air"]) -> Any:
    """Return the drag, nN, along the wall."""
    return _DRAG * _pressure(speed, flow) * radius**2


def torque(speed: Any, radius: Any, flow: Flow = FLOWS["air"]) -> Any:
    """Return the torque about the sphere's centre, nN nm."""
    return _TORQUE * _pressure(speed, flow) * radius**3


def lift(speed: Any, radius: Any, flow: Flow = FLOWS["air"]) -> Any:
    """Return the lift, nN, by the formula of the flow; see `Flow`."""
    plus = friction_reynolds(speed, radius, flow)
    slow = 9.22 * plus**4
    fast = 20.9 * plus**2.31
    formulas = {"by_range": np.where(plus < _EQUAL_LIFT, slow, fast), "leighton_acrivos": slow, "hall": fast}
    return formulas.get(flow.lift, 0.0 * plus) * flow.density * flow.viscosity**2 * factor("N", "nN")


def weight(radius: Any, density: float, flow: Flow = FLOWS["air"]) -> Any:
    """Return the weight less the buoyancy, nN, for a particle's density in kg/m³."""
    return _mass(radius, density - flow.density) * flow.gravity


def _in_range(plus: Any, formula: str) -> Any:
    """Return whether drag, torque and this formula of lift are valid at r⁺."""
    if formula == "hall":  # Hall's lift and creeping flow have no common range
        return np.zeros(np.shape(plus), bool)
    return np.asarray(plus) <= CREEPING


def _wall_shear(strength: Any, body: Body) -> Push:
    at_wall = strength, body.radius, body.flow
    away = lift(*at_wall) - _weight_of(body)
    plus = friction_reynolds(*at_wall)
    return Push(drag(*at_wall), torque(*at_wall), away, _in_range(plus, body.flow.lift))


def _tilt(strength: Any, body: Body) -> Push:
    down = _weight_of(body)
    angle = np.asarray(strength)
    return Push(down * np.sin(angle), 0.0 * angle, -down * np.cos(angle), np.ones(angle.shape, bool))


def _centrifuge(strength: Any, body: Body) -> Push:
    force = _mass(body.radius, body.density - body.flow.density) * np.asarray(strength)
    return Push(0.0 * force, 0.0 * force, force - _weight_of(body), np.ones(force.shape, bool))


def _vibration(strength: Any, body: Body) -> Push:
    force = _mass(body.radius, body.density) * np.asarray(strength)
    return Push(force, 0.0 * force, np.full(force.shape, -_weight_of(body)), np.ones(force.shape, bool))


#: All loads, by name.
LOADS: dict[str, Load] = {
    "wall_shear": Load("critical_friction_velocity", _wall_shear, (1e-5, 1e4)),
    "tilt": Load("critical_angle", _tilt, (0.0, np.pi)),
    "centrifuge": Load("critical_acceleration", _centrifuge, (1e-3, 1e14)),
    "vibration": Load("critical_acceleration", _vibration, (1e-3, 1e14)),
}


def _weight_of(body: Body) -> float:
    """Return the weight, nN; 0 without a density."""
    return 0.0 if np.isnan(body.density) else float(weight(body.radius, body.density, body.flow))


def _mass(radius: Any, density: float) -> Any:
    """Return the mass in nN/(m/s²)."""
    return 4 / 3 * np.pi * radius**3 * density * factor("kg/m^3 nm^3 m/s^2", "nN")


def _pressure(speed: Any, flow: Flow) -> Any:
    """Return ρ u*², GPa."""
    return flow.density * speed**2 * factor("Pa", "GPa")
