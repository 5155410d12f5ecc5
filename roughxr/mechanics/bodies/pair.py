"""Assignment of a pair of bodies to a scan: elastic constants, adhesion, hardness, and the indenter.

They are scalar coordinates, which every result and archive keeps.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.refusal import Refusal, shown
from ..vocabulary.text import Argument, Phrase, RoughxrWarning, warn
from ..vocabulary.units import Quantities, Quantity, carries_units, in_units, plain, positive, single
from . import liquid as liquids
from . import substances
from .layer import Layer, read_layer
from .liquid import HumidAir
from .pair_record import DEFAULT_RANGE, closest_approach


class ImplausiblePair(RoughxrWarning):
    """A pair of bodies has an improbable value, which is used but should be checked.

    Examples
    --------
    >>> import warnings
    >>> import roughxr
    >>> warnings.simplefilter("error", roughxr.ImplausiblePair)  # stop instead of warning
    """


#: Closest approaches, nm, between which a Hamaker constant and a work of adhesion are consistent.
_CUT_OFFS = 0.08, 0.6


class _Range(NamedTuple):
    """The range of a quantity: an error outside ``least`` … ``greatest``, a warning outside ``low`` … ``high``."""

    units: str
    least: float
    low: float
    high: float
    greatest: float
    known: str


_MODULUS = _Range("GPa", 1e-9, 1e-7, 1.5e3, 1e5, "gels have 1e-6 GPa, glass 75, diamond 1100")

_RANGES = {
    "sphere_radius": _Range("nm", 0.2, 5.0, 1e6, 1e10, "an atom has 0.1 nm, an AFM's tip 10, a colloidal probe 3000"),
    "young_modulus": _MODULUS,
    "contact_modulus": _MODULUS,
    "layer_thickness": _Range("nm", 0.01, 0.3, 1e6, 1e9, "native oxides have 1 nm, coatings some 1000"),
    "hardness": _Range("GPa", 1e-6, 1e-3, 100.0, 1e3, "PTFE has 0.05 GPa, gold 1, glass 6, diamond 100"),
    "adhesion_range": _Range("nm", 0.01, 0.1, 50.0, 1e4, "dry solids have 0.2 to 0.4 nm, capillary bridges some nm"),
    "retardation": _Range("nm", 1.0, 10.0, 1e3, 1e5, "bodies absorb light of some 100 nm"),
    "hamaker_constant": _Range(
        "nN nm", 1e-4, 1e-3, 1.0, 5.0, "solids have 0.03 to 0.5 nN nm, which are 30 to 500 zJ, as '6.5e-20 J'"
    ),
    "work_of_adhesion": _Range("J/m^2", 0.0, 1e-6, 6.0, 30.0, "dry glass has 0.06 J/m², cleaved diamond 11"),
}

#: Pixels in a sphere's radius below which it is an error.
_FEWEST_PIXELS = 1.0

#: Pixels in a sphere's radius below which a warning is given.
_FEW_PIXELS = 5.0


def contact_modulus(young_modulus: Quantities, poisson_ratio: Quantities) -> float:
    """Return the contact modulus E* of two elastic bodies, 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂.

    Parameters
    ----------
    young_modulus : number, quantity or pair of them
        GPa; one value for two equal bodies, ``inf`` for a rigid one.
    poisson_ratio : number or pair of them

    Returns
    -------
    float
        GPa.

    References
    ----------
    Johnson, Contact Mechanics, eq. 4.22; Cheng, Dunn & Brach below eq. 5.

    Examples
    --------
    >>> import roughxr
    >>> round(roughxr.reference.contact_modulus(75, 0.22), 3)
    39.407
    """
    moduli = [_young_modulus(value) for value in _values_of_both(young_modulus, "GPa", "young_modulus")]
    ratios = [_ratio(value) for value in _values_of_both(poisson_ratio, "1", "poisson_ratio")]
    compliance = sum((1 - ratio**2) / modulus for modulus, ratio in zip(moduli, ratios))
    if compliance == 0:
        raise Refusal("young_modulus", "at least one elastic body", "two rigid ones")
    return 1 / compliance


@schema.recorded
def assign_pair(
    ds: xr.Dataset,
    *,
    sphere_radius: Quantity | None = None,
    indenter: xr.DataArray | xr.Dataset | None = None,
    materials: str | tuple[str, str] | None = None,
    young_modulus: Quantities | None = None,
    poisson_ratio: Quantities | None = None,
    contact_modulus: Quantity | None = None,
    surface_energy: Quantity | None = None,
    work_of_adhesion: Quantities | None = None,
    adhesion_range: Quantity | None = None,
    hamaker_constant: Quantity | None = None,
    retardation: Quantity | None = None,
    hardness: Quantity | None = None,
    humidity: Quantity | HumidAir | None = None,
    layer: Layer | str | None = None,
    medium: Quantity | None = None,
) -> xr.Dataset:
    """Return the scan or catalogue with the pair of bodies on it.

    Parameters
    ----------
    ds : Dataset
        A scan or an asperity catalogue.
    sphere_radius : number or quantity
        nm; either this or ``indenter``.
    indenter : Dataset or DataArray
        A scan of the indenter's face, such as of a colloidal probe: it is turned over about the x axis to face the
        surface, its highest point at the contact centre. Or its heights (x, y), pointing out of it, with x, y counted
        from the contact centre along the surface's axes. It must be larger than any contact with it.
    materials : str or pair of str
        Names, such as "glass/silicon" or "glass" for two bodies of it: glass, silica, alumina, polystyrene, ptfe,
        silicon, steel or gold. Moduli are from handbooks and, unless it is given, the work of adhesion of clean bodies
        by van der Waals forces alone. Glass and oxidized silicon have the Hamaker constant of silica, 65 zJ, which
        polystyrene's equals; that of steel is its oxide's.
    young_modulus, poisson_ratio : number or pair
        Of both bodies alike, or of each; GPa, and a number up to 0.5. Either these two, ``materials`` or
        ``contact_modulus``.
    contact_modulus : number or quantity
        E*, GPa.
    surface_energy : number or quantity, optional
        γ of two equal bodies, J/m²; the work of adhesion is 2γ.
    work_of_adhesion : number, quantity or pair, optional
        w, J/m²; with a humidity also a pair, without and under the liquid.
    adhesion_range : number or quantity, optional
        ρ, nm, the work of adhesion over the largest adhesive traction; 0.2 to 0.4 nm for dry solids, more where
        liquids or charges attract. By default 0.3 nm.
    hamaker_constant : number or quantity, optional
        A of the bodies across the medium between them, nN nm (1e-18 J), as "6.5e-20 J" or by
        `reference.hamaker_constant`. With a work of adhesion it sets the closest approach, z₀ = √(A/(12πw)); without
        one w = A/(12π z₀²) with z₀ = 0.165 nm. Named materials have their own, unless a work of adhesion is given.
    retardation : number or quantity, optional
        Wavelength, nm, of retarded van der Waals forces (`rigid` by Hamaker's law), about 100 nm; by default none,
        which overestimates the contribution of gaps of more than some 10 nm.
    hardness : number or quantity, optional
        H of the softer body, GPa: the largest pressure that it bears, see `direct`. Without it the bodies stay elastic,
        and results with named materials report the share above the hardness estimated for these.
    humidity : number, str or HumidAir, optional
        Relative humidity, as 0.6 or "60 %", or `HumidAir`, where the liquid is not water that wets both bodies. It
        condenses in gaps below r_K (cos θ₁ + cos θ₂), with Kelvin's radius r_K at 25 °C, pulls with γ/r_K and
        weakens the solids' own attraction, which must be known: by named materials, a work of adhesion (0: they attract
        by liquid alone) or a Hamaker constant. Water counts in full above 19 % relative humidity, less below, and not
        at all below 3 %, where menisci are thinner than a molecule. Without a humidity the pair is dry.
    layer : Layer or str, optional
        A layer bonded to the scan's body, as "50 nm silica" or `Layer`. The pair is then the indenter and the body
        below the layer, in this order: ``materials="glass/silicon"`` or ``young_modulus=(75, 130)``, ``inf`` for a
        rigid one. ``contact_modulus`` of the result is that of indenter and layer; adhesion and hardness of named
        materials are theirs, too.
    medium : str, number or quantity, optional
        What is between named bodies already when they meet, such as "water" or its Hamaker constant: they adhere
        across it, see `reference.hamaker_constant`. By default air or vacuum.

    Returns
    -------
    Dataset
        With what is given, or follows from named materials, as scalar coordinates, and the
        indenter's map. Of a humid pair ``share_under_liquid`` is the share of the work of adhesion left to the solids
        under the liquid: by Hamaker constants across it, of the named materials or of two equal bodies with this work.

    Raises
    ------
    ValueError
        If a value is missing, stated twice, or none that a body has; the message names the argument.

    Warns
    -----
    ImplausiblePair
        If a quantity is improbable, such as a sphere with a radius of fewer than five pixels.
    UserWarning
        If nothing condenses at the given humidity.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> pair = scan.contact.assign_pair(sphere_radius="3 um", materials="glass")
    >>> float(pair.sphere_radius), round(float(pair.contact_modulus), 3), round(float(pair.work_of_adhesion), 4)
    (3000.0, 39.407, 0.0633)
    >>> measured = scan.contact.assign_pair(sphere_radius="3 um", materials="glass", work_of_adhesion="90 mJ/m^2")
    >>> float(measured.work_of_adhesion)
    0.09
    """
    ds = schema.entered_dataset(ds)
    ds = schema.validate(ds, "scan") if schema.kind_of(ds) == "scan" else ds
    _exactly_one(sphere_radius=sphere_radius, indenter=indenter)
    is_humid = humidity is not None
    bodies, moduli = _elastic_bodies(materials, young_modulus, poisson_ratio, contact_modulus, layer)
    is_known = bodies is not None and surface_energy is work_of_adhesion is hamaker_constant is None
    between = _medium_constant(medium, is_known, is_humid=is_humid)
    adhesion, under_liquid = _dry_and_under_liquid(surface_energy, work_of_adhesion, is_humid=is_humid)
    values = (
        moduli
        | under_liquid
        | _without_missing(
            sphere_radius=_radius(sphere_radius, ds),
            **_attraction(bodies, adhesion, hamaker_constant, between),
            adhesion_range=_plausibly(adhesion_range, "adhesion_range"),
            retardation=_plausibly(retardation, "retardation"),
        )
    )
    values |= _hardness(bodies, hardness, values)
    if is_humid:
        attracting = bodies if adhesion is hamaker_constant is None else None  # whose own constants set the attraction
        values |= liquids.liquid_coordinates(values, humidity, bodies=attracting)
    out = _with_names(ds, materials, medium).assign_coords(values)
    if indenter is not None:
        out = out.assign(indenter_height=_indenter(indenter))
    return schema.label(out)


def _dry_and_under_liquid(
    surface_energy: Quantity | None, work: Quantities | None, *, is_humid: bool
) -> tuple[float | None, dict[str, float]]:
    """Return the work of adhesion without liquid, and its share under the liquid where both works are stated."""
    if not is_humid or not _is_several(work):
        return _work_of_adhesion(surface_energy, work), {}
    both = _values_of_both(work, "J/m^2", "work_of_adhesion")
    adhesion, under = (_work_of_adhesion(surface_energy, value) for value in both)
    return adhesion, {"share_under_liquid": under / adhesion if under is not None and adhesion else 1.0}


def _with_names(ds: xr.Dataset, materials: Any, medium: Any) -> xr.Dataset:
    """Return a Dataset without a pair assigned before, with the names of materials and medium as attributes."""
    out = ds.drop_vars([*schema.TRAVELLING, "indenter_height", "indenter_x", "indenter_y"], errors="ignore")
    names = {"materials": "/".join(materials) if isinstance(materials, tuple) else materials, "medium": medium}
    out.attrs = {name: value for name, value in ds.attrs.items() if name not in names}
    out.attrs |= {name: str(value) for name, value in names.items() if value is not None}
    return out


def hamaker_constant(first: Quantity, second: Quantity | None = None, *, medium: Quantity = "vacuum") -> float:
    """Return the Hamaker constant of two bodies across a medium, by combining rules.

    Parameters
    ----------
    first, second : str, number or quantity
        Names of materials, or the Hamaker constant of each across vacuum, nN nm (1e-18 J). One value is used for
        both.
    medium : str, number or quantity
        The medium between them: "vacuum", "air", "water", "ethanol", "hexadecane", or its Hamaker constant.

    Returns
    -------
    float
        nN nm; negative where the bodies repel.

    Notes
    -----
    A₁₂ = √(A₁A₂) and A₁₃₂ = (√A₁ − √A₃)(√A₂ − √A₃). For media such as water, whose static response differs from all the
    others', the rules are rough, and the zero-frequency part of A should be computed by Lifshitz's theory.

    References
    ----------
    Israelachvili, Intermolecular and Surface Forces, 3rd ed., §13.9.

    Examples
    --------
    >>> import roughxr
    >>> round(roughxr.reference.hamaker_constant("silica", "alumina"), 4)
    0.0994
    >>> round(roughxr.reference.hamaker_constant("silica", medium="water"), 5)
    0.00392
    """
    first_constant, second_constant = (
        _own_constant(body, substances.materials()) for body in (first, first if second is None else second)
    )
    return substances.combined(first_constant, second_constant, _own_constant(medium, substances.MEDIA))


def _own_constant(body: Any, constants: dict[str, Any], name: str = "hamaker_constant") -> float:
    """Return the Hamaker constant (nN nm) of a name or a quantity."""
    if isinstance(body, str) and not carries_units(body):
        material = constants[schema.one_of(body.strip().lower(), constants, name)]
        return material if isinstance(material, float) else material.hamaker_constant
    return single(body, "nN nm", name, "one number >= 0 in nN nm", lambda value: value >= 0)


def _medium_constant(medium: Any, is_known: bool, *, is_humid: bool) -> float:
    """Return the Hamaker constant of a medium; raise unless the attraction across it is known, in a dry pair."""
    between = 0.0 if medium is None else _own_constant(medium, substances.MEDIA, "medium")
    if between > 0 and not is_known:
        raise Refusal(
            "medium",
            "named materials alone, whose attraction across it is known",
            advice=Phrase("give ", liquids.ATTRACTION, " under the medium instead, without medium"),
        )
    if between > 0 and is_humid:
        raise Refusal("medium", "a dry pair across a medium, or humid air", "both", "leave medium or humidity out")
    return between


def _attraction(bodies: tuple | None, adhesion: float | None, stated_constant: Any, medium: float) -> dict[str, float]:
    """Return work of adhesion and Hamaker constant, as far as they are given or follow from named materials."""
    constant = _plausibly(stated_constant, "hamaker_constant")
    if bodies is not None and adhesion is None and constant is None:
        first, second = (body.hamaker_constant for body in bodies)
        constant = substances.combined(first, second, medium)
        if constant <= 0:
            raise Refusal(
                "medium",
                "bodies that attract across it",
                f"a Hamaker constant of {constant:.2g} nN nm: they do not adhere",
                "choose another medium or other materials",
            )
    if constant is not None:
        adhesion = substances.van_der_waals_work(constant) if adhesion is None else adhesion
        distance = closest_approach(constant, adhesion)
        if not _CUT_OFFS[0] <= distance <= _CUT_OFFS[1]:
            warn(
                f"{constant:.3g} nN nm and a work of adhesion of {adhesion:.3g} J/m² mean a closest approach of "
                f"{distance:.2g} nm: is this intended? (van der Waals solids have 0.1 to 0.5 nm)",
                ImplausiblePair,
                what="hamaker_constant",
            )
    return _without_missing(work_of_adhesion=adhesion, hamaker_constant=constant)


def indenter_map(ds: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return x, y and height (nm) of the assigned indenter's map, or None where a sphere is assigned."""
    if "indenter_height" not in ds:
        return None
    x, y, height = (ds[name].values.astype(float) for name in ("indenter_x", "indenter_y", "indenter_height"))
    return x, y, height


def _elastic_bodies(
    materials: Any, young_modulus: Any, poisson_ratio: Any, stated_modulus: Any, layer: Layer | str | None
) -> tuple[tuple | None, dict[str, float]]:
    """Return the named bodies that face each other, None for others, and the moduli as coordinates."""
    _exactly_one(materials=materials, contact_modulus=stated_modulus, young_modulus=young_modulus)
    if poisson_ratio is not None and young_modulus is None:
        expected = Phrase("none without ", Argument("young_modulus"))
        raise Refusal("poisson_ratio", expected, poisson_ratio, "leave it out")
    bodies = None if materials is None else substances.named_pair(materials)
    if bodies is not None:
        for body in bodies:
            _plausible(body.hamaker_constant, "hamaker_constant", body.hamaker_constant)
        young_modulus, poisson_ratio = zip(*((body.young_modulus, body.poisson_ratio) for body in bodies))
    if layer is None:
        return bodies, {"contact_modulus": _contact_modulus(stated_modulus, young_modulus, poisson_ratio)}
    layer = read_layer(layer)
    moduli, ratios, coating = _coated(layer, stated_modulus, young_modulus, poisson_ratio)
    facing = None
    if bodies is not None and layer.material is not None:
        facing = (bodies[0], substances.named_pair(layer.material)[0])
    return facing, {"contact_modulus": contact_modulus(moduli, ratios)} | coating


def _contact_modulus(stated_modulus: Any, young_modulus: Any, poisson_ratio: Any) -> float:
    if stated_modulus is not None:
        return _plausibly(stated_modulus, "contact_modulus")
    if poisson_ratio is None:
        raise Refusal("poisson_ratio", Phrase("one with ", Argument("young_modulus")), "none")
    return contact_modulus(young_modulus, poisson_ratio)


def _coated(layer: Layer, stated_modulus: Any, young_modulus: Any, poisson_ratio: Any):
    """Return Young's moduli and Poisson's ratios of indenter and layer, and the coordinates of layer and base."""
    if stated_modulus is not None or poisson_ratio is None:
        stated = "no poisson_ratio" if stated_modulus is None else "their contact_modulus"
        raise Refusal(
            "layer",
            "the moduli of the indenter and of the scan's body",
            stated,
            Phrase(
                "give ",
                Argument("young_modulus", (75, 130)),
                " and ",
                Argument("poisson_ratio", (0.22, 0.28)),
                ", or ",
                Argument("materials", "glass/silicon"),
            ),
        )
    _exactly_one(material=layer.material, young_modulus=layer.young_modulus)
    _exactly_one(material=layer.material, poisson_ratio=layer.poisson_ratio)
    material = layer if layer.material is None else _layer_material(layer.material)
    indenter, base = _values_of_both(young_modulus, "GPa", "young_modulus")
    ratios = _values_of_both(poisson_ratio, "1", "poisson_ratio")
    values = {
        "layer_thickness": _plausibly(layer.thickness, "layer_thickness"),
        "layer_modulus": _plausibly(material.young_modulus, "young_modulus"),
        "layer_poisson_ratio": _ratio(material.poisson_ratio),
        "base_modulus": _young_modulus(base),
        "base_poisson_ratio": _ratio(ratios[1]),
    }
    # A layer may be at most so many times as stiff as its base
    stiffest_layer = 1000.0
    if values["layer_modulus"] > stiffest_layer * values["base_modulus"]:
        raise Refusal(
            "layer",
            f"at most {stiffest_layer:g} times the modulus of its base, {values['base_modulus']:g} GPa",
            f"{values['layer_modulus']:g} GPa",
        )
    return (indenter, values["layer_modulus"]), (ratios[0], material.poisson_ratio), values


def _layer_material(name: str) -> substances.Material:
    material = substances.materials().get(name.strip().lower())
    if material is None:
        raise Refusal(
            "layer",
            f"a layer of {', '.join(substances.materials())}",
            f"{name!r}",
            Phrase(
                "of another material give its moduli, as roughxr.Layer('5 nm', young_modulus=70, poisson_ratio=0.2), "
                "and the pair's ",
                Argument("work_of_adhesion"),
            ),
        )
    return material


def _work_of_adhesion(surface_energy: Any, work_of_adhesion: Any) -> float | None:
    if surface_energy is not None and work_of_adhesion is not None:
        energy = Argument("surface_energy")
        expected = Phrase(energy, " or ", Argument("work_of_adhesion"), " (= 2 ", energy, ")")
        raise Refusal("", expected, "both", "leave one out")
    name = "surface_energy"
    stated = surface_energy
    times = 2.0
    if surface_energy is None:
        name = "work_of_adhesion"
        stated = work_of_adhesion
        times = 1.0
    if stated is None:
        return None
    value = single(stated, "J/m^2", name, "one number >= 0 in J/m²", lambda value: value >= 0)
    if value > 0:
        _plausible(times * value, "work_of_adhesion", stated, name)
    return times * value


def elastic(ds: xr.Dataset) -> xr.Dataset:
    """Return a pair that does not yield; results still report the share of the contact above its hardness."""
    if "hardness" not in ds.coords:
        return ds
    return schema.label(ds.assign_coords(hardness_estimate=float(ds["hardness"])).drop_vars("hardness"))


def _without_missing(**values: float | None) -> dict[str, float]:
    """Return the values that are known."""
    return {name: value for name, value in values.items() if value is not None}


def _young_modulus(stated: Any) -> float:
    """Return a modulus (GPa), inf of a rigid body; raise or warn where it is implausible."""
    return np.inf if isinstance(stated, float) and stated == np.inf else _plausibly(stated, "young_modulus")


def _plausibly(stated: Any, name: str) -> Any:
    """Return a positive number, or None where it is not given; raise or warn where it is implausible."""
    return None if stated is None else _plausible(positive(stated, _RANGES[name].units, name), name, stated)


def _hardness(bodies: tuple | None, stated: Any, pair: dict[str, float]) -> dict[str, float]:
    """Return the hardness (GPa), else named materials' estimate; raise or warn if adhesion alone exceeds it."""
    if stated is None:
        return {} if bodies is None else {"hardness_estimate": min(body.hardness for body in bodies)}
    value = _plausibly(stated, "hardness")
    length = pair.get("adhesion_range")
    strength = pair.get("work_of_adhesion", 0.0) / (length or DEFAULT_RANGE)
    traction = f"the adhesive traction w/rho = {strength:.3g} GPa (rho = {length or DEFAULT_RANGE:g} nm)"
    if value <= strength and length is not None:
        softness = f"{value:.3g} GPa: such a body would yield by adhesion alone"
        advice = Phrase("state a larger hardness, a larger ", Argument("adhesion_range"), " or less work of adhesion")
        raise Refusal("hardness", f"more than {traction}", softness, advice)
    if value <= strength:
        question = (
            f"{value:.3g} GPa does not exceed {traction}: such a body would yield by adhesion alone; is this "
            "intended? (else assign the "
        )
        warn(
            Phrase(question, Argument("adhesion_range"), " that belongs to this work of adhesion)"),
            ImplausiblePair,
            what="hardness",
        )
    return {"hardness": value}


def _radius(stated: Any, ds: xr.Dataset) -> float | None:
    """Return the sphere's radius (nm), None without one; raise or warn where the scan's pixels do not resolve it."""
    radius = _plausibly(stated, "sphere_radius")
    if radius is None or "height" not in ds or not {"x", "y"} <= set(ds["height"].dims) & set(ds.indexes):
        return radius
    pixel = max(schema.spacing(ds[axis]) for axis in ("x", "y"))
    size = f"{radius / pixel:.2g} pixels of {pixel:g} nm"
    advice = "plain numbers are in nm, other units are written as in '3 um'"
    if radius < _FEWEST_PIXELS * pixel:
        raise Refusal("sphere_radius", "more than one pixel", f"{radius:g} nm, {size}", advice)
    if radius < _FEW_PIXELS * pixel:
        sentence = f"{radius:g} nm is {size}, too few to resolve its contact; {advice}"
        warn(sentence, ImplausiblePair, what="sphere_radius")
    return radius


def _plausible(value: float, quantity: str, stated: Any, name: str = "") -> float:
    """Return a value; raise if no body can have it, warn if it is improbable."""
    possible = _RANGES[quantity]
    sentence = f"{shown(stated)} is {value:.4g} {possible.units}"
    sentence += f" of {quantity}" if name not in ("", quantity) else ""
    advice = (
        f"{possible.known}; plain numbers are in {possible.units}, other units are written as in '3 um' or '70e9 Pa'"
    )
    if not possible.least <= value <= possible.greatest:
        raise Refusal(
            name or quantity,
            f"{possible.least:g} to {possible.greatest:g} {possible.units}, as bodies have",
            f"{value:.4g} {possible.units} by {shown(stated)}",
            advice,
        )
    if not possible.low <= value <= possible.high:
        warn(f"{sentence}: is this intended? ({advice})", ImplausiblePair, what=name or quantity)
    return value


def check_plausible(name: str, value: float, ds: xr.Dataset) -> None:
    """Raise or warn for one of the pair's values (nm, GPa, J/m²) on a scan, as `assign_pair` does."""
    if name == "sphere_radius":
        _radius(value, ds)
    elif name == "work_of_adhesion":
        _work_of_adhesion(None, value)
    else:
        _plausibly(value, name)


def _indenter(indenter: xr.DataArray | xr.Dataset) -> xr.DataArray:
    """Return the indenter's map on its own dimensions, in nm, the contact centre at x = y = 0."""
    if isinstance(indenter, xr.Dataset):
        heights: xr.DataArray = schema.validate(indenter, "scan")["height"].reset_coords(drop=True)
        return _facing(heights.copy(data=schema.finite(heights.values)))
    if not isinstance(indenter, xr.DataArray) or set(indenter.dims) != {"x", "y"}:
        expected = "a scan, or a DataArray of heights with dimensions ('x', 'y')"
        raise Refusal("indenter", expected, type(indenter).__name__, "open a file by roughxr.open_scan")
    heights = schema.in_package_units(indenter)
    heights = heights.copy(data=in_units(heights.variable, "nm", "indenter").data).assign_attrs(units="nm")
    for axis in ("x", "y"):
        schema.spacing(heights[axis])
        first = float(heights[axis][0])
        last = float(heights[axis][-1])
        if abs(first + last) / 2 > (last - first) / 4:
            raise Refusal(
                "indenter",
                "x and y counted from the contact centre",
                f"{axis} from {first:g} to {last:g} nm",
                "give the whole scan instead of its height, and its highest point becomes the centre, or shift "
                f"the axes with .assign_coords({axis}=…)",
            )
    schema.finite(heights.values)
    return heights.transpose("x", "y").rename(x="indenter_x", y="indenter_y").reset_coords(drop=True)


def _facing(height: xr.DataArray) -> xr.DataArray:
    """Return a scan of the indenter's face turned over to face the surface, its highest point at the centre."""
    top = height.isel(height.argmax(["x", "y"]))
    turned = height.assign_coords(x=height["x"] - top["x"], y=top["y"] - height["y"]).isel(y=slice(None, None, -1))
    axes = {f"indenter_{axis}": turned[axis].values for axis in "xy"}
    return xr.DataArray(turned.values, axes, list(axes), attrs={"units": "nm"})


def _exactly_one(**alternatives: Any) -> None:
    """Raise unless exactly one of several alternatives is given."""
    stated = [name for name, value in alternatives.items() if value is not None]
    if len(stated) != 1:
        first, *others = map(Argument, alternatives)
        expected = Phrase("one of ", first, *(part for other in others for part in (", ", other)))
        raise Refusal("", expected, " and ".join(stated) or "none of them")


def _is_several(value: Any) -> bool:
    return isinstance(value, (tuple, list)) or np.ndim(getattr(value, "magnitude", value)) == 1


def _values_of_both(value: Any, units: str, name: str) -> tuple[Any, Any]:
    """Return the values for both bodies; text is returned unchanged, for messages."""
    if not _is_several(value):
        return value, value
    values = tuple(value if isinstance(value, (tuple, list)) else plain(value, units, name))
    if len(values) != 2:
        raise Refusal(name, "one value or a pair", len(values))
    return values


def _ratio(value: Any) -> float:
    return single(value, "1", "poisson_ratio", "a number in (-1, 0.5]", lambda ratio: -1 < ratio <= 0.5)
