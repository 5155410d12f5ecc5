"""The critical strength of a load: rolling, sliding and lifting, each as drive over resistance.

    roll    max over n of the smaller of [T (e·n) + (N + L) h] / M for two states with edge n: that of the largest
            moment, and that of the largest M/h, the tipping force; T = along · r + torque, the moment about the
            contact
    slide   along / (μ (F_c − N)), or along / (τ A)
    lift    N / F_c

where M is the resisting moment about the contact's edge in direction n, h the distance of that edge (`rolling`, under a
load L; the contact resists as long as any of its states does), e the direction of the load, N the force away from the
wall, F_c the pull-off force, A the contact area. The mode whose ratio reaches 1 at the smallest strength comes first.
All directions n count: a sphere pushed along e may tip about any edge of its contact.

An elastic adhesive contact rolls by closing in front as it opens behind, against its hysteresis alone. M about the edge
of a single contact, P_c times about its radius, is therefore an upper bound; several contacts have to detach.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
import xarray as xr

from ..asperity.moments import weakest
from ..vocabulary import schema
from ..vocabulary.numbers import format_percent
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import Argument, IncompleteResult, Phrase, warn
from ..vocabulary.units import Quantity, magnitude, positive
from .loads import LOADS, Body, Flow, Load, Push, read_flow

Verb = TypeVar("Verb", bound=Callable[..., xr.Dataset])

MODES = ("roll", "slide", "lift")

#: Values of ``mode`` at places without a mode.
NEITHER, NO_CONTACT, NO_REST = "none", "no contact", "no rest"

_MISSING = "NaN where no load moves the sphere, nothing is in contact or the sphere does not rest; see mode"

#: Number of strengths that bracket the critical strength.
_STRENGTHS = 240

#: Number of bisections after that.
_HALVINGS = 60


class Resistance(NamedTuple):
    """The resistance at each place."""

    moment: np.ndarray  # (state, place, direction), nN nm
    hinge: np.ndarray  # (state, place, direction), nm
    share: np.ndarray  # (place, direction): e·n, of the load's moment about each edge
    pull_off: np.ndarray  # (place,), nN, 0 without adhesion
    area: np.ndarray  # (place,), nm²
    load: float  # nN, on the sphere's axis, already counted in the moment
    friction: float | None
    strength: float | None  # shear strength, GPa
    known: np.ndarray  # (place,): whether there is contact
    moment_error: np.ndarray  # (place, direction), nN nm; NaN if unknown


def for_each_condition(function: Verb) -> Verb:
    """Return a function of resisting moments that also maps over the entries of `vary`."""

    @functools.wraps(function)
    def each(ds: xr.Dataset, *arguments: Any, **options: Any) -> Any:
        schema.need_dataset(ds, "moments")
        dims = ds["resisting_moment"].dims if "resisting_moment" in ds else ()
        name = next((str(dim) for dim in dims if dim not in ("subregion", "direction")), None)
        if name is None:
            return function(ds, *arguments, **options)
        parts = [each(ds.isel({name: k}), *arguments, **options) for k in range(ds.sizes[name])]
        out = xr.concat(parts, name, combine_attrs="drop_conflicts", coords="different", compat="equals")
        if name == "scan" and "places" in parts[0].attrs:
            out.attrs["places"] = sum(part.attrs["places"] for part in parts)
        return out

    return cast(Verb, each)


@for_each_condition
@schema.verb("moments")
def critical_load(
    ds: xr.Dataset,
    cause: str = "wall_shear",
    *,
    direction: Quantity = 0.0,
    particle_density: Quantity | None = None,
    flow: str | Flow = "air",
    friction_coefficient: Quantity | None = None,
    shear_strength: Quantity | None = None,
) -> xr.Dataset:
    """Return the strength of a flow, tilt, rotation or vibration that detaches the sphere, and the mode, at each place.

    Parameters
    ----------
    ds : Dataset
        Result of `rolling`, or of `vary` over it, for example for spheres of several radii.
    cause : {"wall_shear", "tilt", "centrifuge", "vibration"}
        "centrifuge" pulls away from the wall, "vibration" shakes along it.
    direction : number, quantity or "weakest"
        Direction in which it acts, rad from x towards y; "weakest": the direction of the least resisting moment at each
        place, the first of several equal ones.
    particle_density : number or quantity, optional
        kg/m³, for its weight; without it the sphere is weightless in a flow, and other causes are refused.
    flow : {"air", "water"} or Flow
        The fluid, at 20 °C, or a `Flow` of your own.
    friction_coefficient, shear_strength : number or quantity, optional
        One of them: the sphere slides at a force of μ times the sum of pull-off force and weight less lift, or of τ
        (GPa) times the contact area at rest. By default it does not slide.

    Returns
    -------
    Dataset
        ``critical_friction_velocity`` (m/s), ``critical_acceleration`` (m/s²) or ``critical_angle`` (rad); ``mode``,
        the first to occur: roll, slide or lift. NaN if no strength suffices (``mode`` "none"), without contact ("no
        contact"), or if the sphere rolls off by itself ("no rest"). ``in_range``: whether all formulas of drag and lift
        are valid at this strength, in wall shear up to r⁺ = 1. ``critical_load_error``: the relative error by those
        stated of levers and pull-off forces; NaN without any, as from asperities. ``shared_load_error``: by those of
        the pull-off forces alone, which all places share.

    Raises
    ------
    ValueError
        If ``ds`` has no resisting moments, a density is missing, or both ways to slide are stated.

    Notes
    -----
    On a single contact, where the lever is about its radius, the sphere may roll earlier: the moment about its edge is
    an upper bound. An elastic adhesive contact closes in front as it opens behind, and resists by its hysteresis alone.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> moments = roughxr.rolling(scan, directions=8, subregions=(2, 2))
    >>> found = moments.contact.critical_load("wall_shear", particle_density=2500)
    >>> found.critical_friction_velocity.units, set(found["mode"].values.tolist())
    ('m/s', {'roll'})
    """
    kind = LOADS[schema.one_of(cause, LOADS, "cause")]
    body = read_body(ds, particle_density, flow)
    if kind.critical != "critical_friction_velocity" and np.isnan(body.density):
        raise Refusal("particle_density", "a density in kg/m³ for this cause", "none")
    limit = read_resistance(ds, direction, friction_coefficient, shear_strength)
    strength, mode = critical_strength(kind, body, limit)
    push = kind.push(np.where(np.isfinite(strength), strength, 0.0), body)
    place = {name: ds[name] for name in ds.coords if "direction" not in ds[name].dims}
    if restless := int((mode == NO_REST).sum()):
        warn(
            f"{restless} of {mode.size} places are no resting positions: the sphere rolls off by itself, and "
            f"{kind.critical} is NaN; take places of `resting`",
            IncompleteResult,
        )
    values = {kind.critical: strength, "mode": mode, "in_range": push.in_range & np.isfinite(strength)}
    values["critical_load_error"] = _strength_error(kind, body, limit, strength)
    by_pull_off = limit._replace(moment_error=pull_off_part(ds) * np.abs(limit.moment[0]))
    values["shared_load_error"] = _strength_error(kind, body, by_pull_off, strength)
    out = xr.Dataset({name: ("subregion", array) for name, array in values.items()}, coords=place)
    out.attrs = {"cause": cause, "missing": _MISSING, **dict(zip(_FLUID_ARGUMENTS, body.flow))}
    return schema.label(out)


def fluid_of(critical: xr.Dataset) -> Flow:
    """Return the fluid of a result of `critical_load`."""
    if missing := set(_FLUID_ARGUMENTS) - set(critical.attrs):
        raise Refusal("", "a result of critical_load, which states its fluid", f"none of {', '.join(sorted(missing))}")
    return Flow(*(critical.attrs[name] for name in _FLUID_ARGUMENTS))


def strength_of_places(critical: xr.Dataset) -> xr.DataArray:
    """Return the critical strengths of a result of `critical_load`, 0 where the sphere rolls off without a load.

    NaN without contact, and where no strength of the load moves the sphere. Every door takes its quantiles of these.
    """
    name = str(next(iter(critical.data_vars)))
    return critical[name].where(critical["mode"] != NO_REST, 0.0).assign_attrs(critical[name].attrs)


@schema.recorded
def with_pull_off(ds: xr.Dataset, pull_off: xr.Dataset) -> xr.Dataset:
    """Return resisting moments with the pull-off forces of another method at the same places, at unchanged levers.

    The adhesive part of the moment is scaled by the ratio of the pull-off forces at each place. Those of `extrapolated`
    have the error of their mean.
    """
    before = ds["pull_off_force"].variable
    force = before.copy(data=pull_off["pull_off_force"].values)
    load = float(ds.attrs.get("normal_force", 0.0))
    columns: dict[str, Any] = {"resisting_moment": load * ds["hinge_distance"].variable, "tipping_force": load}
    changed = {name: (ds[name].variable - part) * (force / before) + part for name, part in columns.items()}
    changed["pull_off_force"] = force
    error = pull_off.get("pull_off_error")
    if "pull_off_high" in pull_off:
        error = pull_off["pull_off_high"] / pull_off["pull_off_mean"] - 1
    if error is not None:
        changed["pull_off_error"] = before.copy(data=np.full(before.shape, error.values))
    out = ds.drop_vars(["pull_off_delta", "pull_off_error"], errors="ignore").assign(changed)
    out.attrs["levers"] = str(ds.attrs.get("method", "rolling"))
    return schema.label(out)


def read_body(ds: xr.Dataset, density: Any, flow: str | Flow) -> Body:
    """Return the particle of a result, and the fluid around it; raise for menisci in a liquid."""
    fluid = read_flow(flow)
    if schema.is_humid(ds) and fluid.density > DENSEST_GAS:
        raise Refusal(
            "flow",
            "a dry pair in a liquid",
            f"one at {format_percent(ds['humidity'])} relative humidity",
            "leave out the humidity, and give the medium, or the work of adhesion under it",
        )
    return Body(schema.sphere_radius(ds), _physical(density, "kg/m^3", "particle_density") or np.nan, fluid)


#: Names of the fluid's properties as attributes, in the order of `Flow`.
_FLUID_ARGUMENTS = ("medium_density", "viscosity", "lift", "gravity")

#: Density (kg/m³) above which a fluid is a liquid, in which no menisci condense.
DENSEST_GAS = 200.0


def read_resistance(ds: xr.Dataset, direction: Any, friction_coefficient: Any, shear_strength: Any) -> Resistance:
    """Return the resistance at each place of a result of `rolling`; raise if an option is missing or impossible."""
    if friction_coefficient is not None and shear_strength is not None:
        expected = Phrase("either ", Argument("friction_coefficient"), " or ", Argument("shear_strength"))
        raise Refusal("", expected, "both")
    names = ("resisting_moment", "hinge_distance", "tipping_force", "tipping_hinge_distance")
    moment, hinge, force, tipping_hinge = (ds[name].transpose("subregion", "direction").values for name in names)
    angles = ds["direction"].values
    if isinstance(direction, str) and direction == "weakest":
        towards = angles[weakest(np.nan_to_num(moment))[0]]  # places with missing moments are unknown anyway
    else:
        towards = np.full(len(moment), float(magnitude(direction, "rad", "direction")))
    tips = np.isfinite(force) & np.isfinite(tipping_hinge)  # else only the state of the largest moment is used
    return Resistance(
        moment=np.array([moment, np.where(tips, force * tipping_hinge, moment)]),
        hinge=np.array([hinge, np.where(tips, tipping_hinge, hinge)]),
        share=np.cos(angles[None, :] - towards[:, None]),
        pull_off=np.nan_to_num(ds["pull_off_force"].values),
        area=ds["contact_area"].values,
        load=float(ds.attrs.get("normal_force", 0.0)),
        friction=_physical(friction_coefficient, "1", "friction_coefficient"),
        strength=_physical(shear_strength, "GPa", "shear_strength"),
        known=np.isfinite(moment).all(axis=1),
        moment_error=_moment_error(ds, moment),
    )


def _moment_error(ds: xr.Dataset, moment: np.ndarray) -> np.ndarray:
    """Return the error (nN nm) of moments (place, direction), by those of levers and pull-offs."""
    if "lever_error" not in ds:
        return np.full_like(moment, np.nan)
    size = np.abs(moment)
    lever = ds["lever_error"].values[:, None] * size.mean(axis=1, keepdims=True)
    return np.hypot(lever, pull_off_part(ds) * size)


def pull_off_part(ds: xr.Dataset) -> np.ndarray:
    """Return the relative error of moments (place, 1) by that of the pull-offs; 0 where none is stated."""
    error = ds["pull_off_error"] if "pull_off_error" in ds else xr.zeros_like(ds["pull_off_force"])
    return np.nan_to_num(error.values)[:, None]


#: Least and largest physical values, and examples for messages.
_POSSIBLE = {
    "particle_density": (50.0, 25_000.0, "foams have 100 kg/m³, polystyrene 1050, glass 2500, gold 19300"),
    "friction_coefficient": (1e-4, 10.0, "PTFE has 0.05, glass 0.5, gold on gold 1"),
    "shear_strength": (1e-6, 10.0, "polymers have 0.01 GPa, which are 10 MPa, mica and metals 0.02 to 1"),
}


def _physical(quantity: Any, units: str, name: str) -> float | None:
    """Return the given value, or None; raise outside the physical limits."""
    low, high, examples = _POSSIBLE[name]
    value = None if quantity is None else positive(quantity, units, name)
    if value is not None and not low <= value <= high:
        stated = f"{value:.4g} {units}; state the units" if units != "1" else f"{value:.4g}"
        raise Refusal(name, f"a physical value ({examples})", stated)
    return value


def drive_ratios(push: Push, body: Body, limit: Resistance) -> np.ndarray:
    """Return drive over resistance, (mode, …, place), for a push of strengths (…, place) or (…, 1)."""
    along, turn, away = push[:3]
    forward, raising = (part[..., None, :, None] for part in (along * body.radius + turn, away + limit.load))
    about = forward * limit.share + raising * limit.hinge
    with np.errstate(divide="ignore", invalid="ignore"):
        roll = np.where(limit.moment > 0, about / limit.moment, np.where(about >= limit.moment, np.inf, 0.0))
        roll = roll.min(axis=-3).max(axis=-1)
        slide = np.zeros_like(roll)
        holds = limit.pull_off - away
        if limit.friction is not None or limit.strength is not None:
            strongest = limit.strength * limit.area if limit.strength is not None else limit.friction * holds
            slide = np.where(strongest > 0, along / strongest, np.where(along > 0, np.inf, 0.0))
        raised = np.where(holds > 0, np.maximum(away, 0) / limit.pull_off, np.inf)
    raised = np.where((limit.pull_off > 0) | (away >= 0), raised, 0.0)
    return np.where(limit.known, np.array([roll, slide, raised]), np.nan)


def rolls_off(kind: Load, body: Body, limit: Resistance) -> np.ndarray:
    """Return the places at which the sphere does not rest: it detaches without a load."""
    return np.asarray((drive_ratios(kind.push(np.zeros(1), body), body, limit) >= 1).any(axis=0))


def critical_strength(kind: Load, body: Body, limit: Resistance) -> tuple[np.ndarray, np.ndarray]:
    """Return the critical strength of each place, and its mode."""
    low, high = kind.span
    tried = np.geomspace(low, high, _STRENGTHS) if low > 0 else np.linspace(low, high, _STRENGTHS)
    tried = np.r_[0.0, tried[tried > 0]]
    parts = np.array_split(tried[:, None], 16)  # so many that each needs little memory
    moves = np.concatenate([(drive_ratios(kind.push(part, body), body, limit) >= 1).any(axis=0) for part in parts])
    first = moves.argmax(axis=0)
    any_at_all = moves.any(axis=0)
    above = tried[first]
    below = tried[np.maximum(first - 1, 0)]
    for _ in range(_HALVINGS):
        middle = 0.5 * (below + above)
        moved = (drive_ratios(kind.push(middle, body), body, limit) >= 1).any(axis=0)
        above = np.where(moved, middle, above)
        below = np.where(moved, below, middle)
    rests = ~rolls_off(kind, body, limit)
    strength = np.where(any_at_all & rests, above, np.nan)
    ratios = drive_ratios(kind.push(np.nan_to_num(strength), body), body, limit)
    mode = np.where(any_at_all, np.array(MODES)[np.nan_to_num(ratios).argmax(axis=0)], NEITHER)
    return strength, np.where(limit.known, np.where(rests, mode, NO_REST), NO_CONTACT)


def _strength_error(kind: Load, body: Body, limit: Resistance, strength: np.ndarray) -> np.ndarray:
    """Return the relative change of the critical strengths by the error of the moments, the larger of both signs."""
    error = np.nan_to_num(limit.moment_error)
    changes = [np.zeros(strength.shape)]
    for sign in (-1, 1) if error.any() else ():
        moment = limit.moment + sign * error
        changed = np.nan_to_num(critical_strength(kind, body, limit._replace(moment=moment))[0])  # 0: it rolls off
        changes.append(np.abs(changed / strength - 1))
    has_error = np.isfinite(limit.moment_error).all(axis=1) & (strength > 0)
    return np.where(has_error, np.max(changes, axis=0), np.nan)
