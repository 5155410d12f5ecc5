"""Liquid that condenses from vapour between two bodies: Kelvin radius, wetted gap and capillary pressure.

Kelvin      r_K = γV/(R_g T |ln p|), the radius at which liquid and vapour of relative pressure p (the humidity) are in
            equilibrium; water at 25 °C: 0.5243 nm/|ln p|
wetted      gaps below h = r_K (cos θ₁ + cos θ₂) + 2f, each body covered by a film of thickness f
attraction  the capillary pressure γ/r_K on the wetted area: Dugdale's law with the range h, for gaps that vary slowly
            along the surface

Butt & Kappl, Adv. Colloid Interface Sci. 146 (2009) 48; de Boer & de Boer, J. Colloid Interface Sci. 311 (2007) 171;
as Dugdale's law: Fogden & White, J. Colloid Interface Sci. 138 (1990) 414; between rough bodies: Persson, J. Phys.:
Condens. Matter 20 (2008) 315007. The film widens the gap that fills as it does a pore (Cohan 1938); it is not counted
by default. Kelvin's equation was found to hold down to radii of 4 nm (Fisher & Israelachvili, J. Colloid Interface
Sci. 80 (1981) 528), and in slits down to a single layer of water (Yang et al., Nature 588 (2020) 250). A meniscus
thinner than a molecule carries nothing. So the liquid's surface, of diameter 2 r_K, counts in part,

    c = 2 r_K/d − 1 within 0 … 1,    d = (V/N_A)^⅓    (a molecule: 0.31 nm for water)

in the capillary pressure c γ/r_K and in what the solids lose under the liquid (own interpolation between one and two
molecules). For water c is 0 below 3 % and 1 above 19 % relative humidity.

γ J/m²;  V cm³/mol;  T K;  r_K, h, f, d nm;  θ rad
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import xarray as xr

from ..vocabulary import schema
from ..vocabulary.calls import checked_class
from ..vocabulary.refusal import Refusal, shown
from ..vocabulary.text import Argument, Phrase, warn
from ..vocabulary.units import Quantity, magnitude, positive, single
from .substances import CUT_OFF, MEDIA, combined

#: Avogadro's number, 1/mol (CODATA 2018).
_AVOGADRO = 6.02214076e23

#: The arguments that state the attraction of the solids, as an advice names them.
ATTRACTION = Phrase(Argument("work_of_adhesion"), " or ", Argument("hamaker_constant"))

#: Names of the contact angles on the scan's body and on the other.
ANGLES = ("contact_angle_1", "contact_angle_2")


class Liquid(NamedTuple):
    """A liquid at 25 °C; its Hamaker constant is that of `substances.MEDIA`."""

    tension: float  # γ, J/m²
    volume: float  # V, cm³/mol
    source: str


#: By name. Water's 0.07197 is that of IAPWS R1-76(2014), rounded; V at 25 °C is 18.07, at 4 °C 18.02.
LIQUIDS = {
    "water": Liquid(0.072, 18.05, "IAPWS R1-76(2014)"),
    "ethanol": Liquid(0.02197, 58.7, "CRC Handbook of Chemistry and Physics, surface tension; density 0.785"),
}


class Menisci(NamedTuple):
    """The condensed liquid between the bodies."""

    kelvin_radius: float  # nm
    surface_tension: float  # J/m²
    angles: tuple[float, float]  # rad
    film: float  # nm, on each body
    share: float  # work of adhesion of the solids under the liquid, over that without it
    part: float = 1.0  # c, of the capillary pressure of bulk liquid

    @property
    def height(self) -> float:
        """The largest wetted gap, nm."""
        return self.kelvin_radius * sum(map(math.cos, self.angles)) + 2 * self.film

    @property
    def capillary_pressure(self) -> float:
        """The tension on the wetted area, c γ/r_K, GPa."""
        return self.part * self.surface_tension / self.kelvin_radius

    @property
    def work(self) -> float:
        """The work to separate the wetted area, J/m²."""
        return self.capillary_pressure * self.height

    @property
    def range(self) -> float:
        """The range z₀ (nm) of a Lennard-Jones law of the same Maugis parameter."""
        from ..kernels.asperity.maugis import PER_TABOR  # not at the top: it needs Numba

        return PER_TABOR * (2 * math.pi / 9) ** (1 / 3) * self.height

    @property
    def edge(self) -> float:
        """The energy of a meniscus per length of its edge, nN: the arc's, less that of the law's sharp edge."""
        open_angle = math.pi - sum(self.angles) + 0.5 * sum(math.sin(2 * angle) for angle in self.angles)
        return 0.5 * self.part * self.surface_tension * self.kelvin_radius * open_angle


def menisci_of(ds: xr.Dataset) -> Menisci | None:
    """Return the menisci of a pair of bodies, None for a dry pair and below a molecule."""
    if not schema.is_humid(ds):
        return None
    names = ("kelvin_radius", "surface_tension", "liquid_molecule")
    schema.need_assigned(ds, *names)
    radius, tension, molecule = (float(ds[name]) for name in names)
    first, second = (float(ds[name]) for name in ANGLES)
    film, share = (float(ds.coords.get(name, usual)) for name, usual in (("liquid_film", 0), ("share_under_liquid", 1)))
    part = min(2 * radius / molecule - 1, 1.0)
    return Menisci(radius, tension, (first, second), film, 1 - part * (1 - share), part)


def angles(contact_angle: Any) -> tuple[float, float]:
    """Return the contact angles on both bodies in rad, from degrees; raise if the liquid does not wet the bodies."""
    both = tuple(contact_angle) if isinstance(contact_angle, (tuple, list)) else (contact_angle, contact_angle)
    if len(both) != 2:
        raise Refusal("contact_angle", "one angle or a pair of them", f"{contact_angle!r}")
    expected = "degrees from 0 to 90"
    degrees = [
        single(angle_given, "deg", "contact_angle", expected, lambda angle: 0 <= angle < 180) for angle_given in both
    ]
    if sum(degrees) >= 180 or max(degrees) > 90:
        raise Refusal(
            "contact_angle",
            "angles of at most 90 degrees",
            f"{contact_angle!r}: such a liquid does not wet and forms no bridge by condensation",
            "assign a dry pair",
        )
    first, second = degrees
    return math.radians(first), math.radians(second)


def kelvin_radius(humidity: Quantity, *, liquid: str | tuple = "water") -> float:
    """Return a liquid's Kelvin radius (nm) in its vapour: Butt & Kappl, Adv. Colloid Interface Sci. 146 (2009) 48."""
    tension, volume = _liquid(liquid)
    # R_g T, J/mol, at 25 °C (CODATA 2018)
    return 1e3 * tension * volume / ((8.314462618 * 298.15) * abs(math.log(_pressure(humidity))))  # 1e-6 m = 1e3 nm


@checked_class
@dataclass(frozen=True)
class HumidAir:
    """Air whose vapour condenses between bodies, for ``assign_pair`` where the relative humidity alone is not enough.

    Attributes
    ----------
    humidity : number or str
        Relative humidity, as 0.6 or "60 %".
    contact_angle : number, quantity or pair
        θ on both bodies or on each, degrees up to 90.
    liquid : {"water", "ethanol"} or pair
        What condenses, at 25 °C; or its surface tension, J/m², and molar volume, cm³/mol. At T multiply the molar
        volume by 298 K/T.
    film : number or quantity, optional
        Thickness, nm, of an adsorbed film on each body, which widens the gap that fills.

    Examples
    --------
    >>> import roughxr
    >>> roughxr.HumidAir("60 %", contact_angle=30).liquid
    'water'
    """

    humidity: Any
    contact_angle: Any = 0.0
    liquid: Any = "water"
    film: Any = None


def liquid_coordinates(pair: dict[str, float], humidity: Any, *, bodies: tuple | None) -> dict[str, float]:
    """Return the coordinates that describe the condensed liquid of a pair, see `assign_pair`.

    ``pair`` contains the other coordinates, ``bodies`` the named materials if their Hamaker constants set the adhesion.
    """
    if "work_of_adhesion" not in pair:
        raise Refusal(
            "humidity",
            "the dry adhesion of the bodies as well",
            "none",
            Phrase("give ", ATTRACTION, ", or ", Argument("work_of_adhesion", 0), " if they attract by liquid alone"),
        )
    air = humidity if isinstance(humidity, HumidAir) else HumidAir(humidity)
    liquid = air.liquid
    pressure = _pressure(air.humidity)
    tension, volume = _liquid(liquid)
    radius = kelvin_radius(pressure, liquid=liquid)
    wetting = angles(air.contact_angle)
    coords = {"humidity": pressure, "kelvin_radius": radius, "surface_tension": tension, **dict(zip(ANGLES, wetting))}
    coords["liquid_molecule"] = (1e21 * volume / _AVOGADRO) ** (1 / 3)  # 1 cm³ = 1e21 nm³
    if film := single(
        air.film or 0.0, "nm", "film", "a thickness of at least 0 nm on each body", lambda film: film >= 0
    ):
        coords["liquid_film"] = film
    medium = MEDIA.get(liquid.strip().lower()) if isinstance(liquid, str) else None
    if "share_under_liquid" not in pair:
        is_named = bodies is not None and medium is not None
        coords["share_under_liquid"] = _named_materials_share(bodies, medium) if is_named else _share(pair, medium)  # type: ignore[arg-type]
    _refuse_thick(pair, radius, pressure)
    if 2 * radius <= coords["liquid_molecule"]:
        warn(
            f"at {pressure:.3g} relative humidity menisci, of {2 * radius:.2g} nm, would be thinner than a molecule "
            f"({coords['liquid_molecule']:.2g} nm): nothing condenses, and the pair counts as dry",
            what="humidity",
        )
    return coords


def humidity_coordinates(ds: xr.Dataset, humidity: float) -> dict[str, float]:
    """Return the humidity and Kelvin radius of a humid pair at another humidity of the same liquid."""
    if "humidity" not in ds.coords:
        raise Refusal("humidity", "a humid pair", "a dry one", "assign_pair(humidity=…) first")
    assigned = float(ds["humidity"])
    pressure = _pressure(humidity)
    changed = {
        "humidity": pressure,
        "kelvin_radius": float(ds["kelvin_radius"]) * math.log(assigned) / math.log(pressure),
    }
    _refuse_thick(dict(ds.coords), changed["kelvin_radius"], pressure)
    return changed


def updated_liquid_share(ds: xr.Dataset, work: float) -> dict[str, float]:
    """Return the share under the liquid of a humid pair at another work of adhesion (J/m²); empty for a dry pair.

    Empty also where the share was stated, or follows from named materials, and does not depend on this work.
    """
    if "share_under_liquid" not in ds.coords:
        return {}
    pair = {name: float(ds[name]) for name in ("hamaker_constant", "work_of_adhesion") if name in ds.coords}
    share = float(ds["share_under_liquid"])
    for medium in MEDIA.values():
        dry = _hamaker_constant(pair)
        if dry and math.isclose(combined(dry, dry, medium) / dry, share, rel_tol=1e-9):
            return {"share_under_liquid": _share(pair | {"work_of_adhesion": work}, medium)}
    return {}


def _pressure(humidity: Any) -> float:
    """Return a relative vapour pressure; raise unless it is between 0 and saturation."""
    number = magnitude(humidity, "1", "humidity")
    if not isinstance(number, float) or not 0 < number < 1:
        meant = ""
        if isinstance(number, float) and 1 < number < 100 and str(humidity).strip()[-1].isdecimal():
            meant = f": {number:g} % is {0.01 * number:g}"
        raise Refusal("humidity", "relative humidity between 0 and 1, as 0.6 or '60 %'", f"{shown(humidity)}{meant}")
    # relative vapour pressure above which this law would fill every gap
    saturation = 0.99
    if number >= saturation:
        raise Refusal(
            "humidity",
            f"less than {saturation}",
            f"{humidity!r}: near saturation the amount of water is not determined by the humidity",
            "give a lower one",
        )
    return number


def _liquid(liquid: Any) -> tuple[float, float]:
    """Return surface tension (J/m²) and molar volume (cm³/mol) of a name or of a pair of numbers."""
    if isinstance(liquid, str):
        named = LIQUIDS[schema.one_of(liquid.strip().lower(), LIQUIDS, "liquid")]
        return named.tension, named.volume
    if not isinstance(liquid, (tuple, list)) or len(liquid) != 2:
        raise Refusal(
            "liquid",
            f"one of {', '.join(LIQUIDS)}, or surface tension (J/m²) and molar volume (cm³/mol)",
            f"{liquid!r}",
        )
    return positive(liquid[0], "J/m^2", "liquid"), positive(liquid[1], "cm^3/mol", "liquid")


def _hamaker_constant(pair: dict[str, float]) -> float:
    """Return the assigned Hamaker constant (nN nm), or that of the work of adhesion."""
    return pair.get("hamaker_constant") or 12 * math.pi * CUT_OFF**2 * pair.get("work_of_adhesion", 0.0)


def _share(pair: dict[str, float], medium: float | None) -> float:
    """Return the share of the work of adhesion that remains under a liquid, for two bodies of one material.

    (1 − √(A₃/A))² with the liquid's Hamaker constant A₃ and the bodies' A, or that of their work of adhesion; 1 where
    the liquid's constant is not known or nothing attracts. Raise where it is above 1: A₃ is more than four times A.
    """
    dry = _hamaker_constant(pair)
    share = combined(dry, dry, medium) / dry if dry and medium is not None else 1.0
    if share > 1:
        raise Refusal(
            "work_of_adhesion",
            "solids that attract no less in air than under the liquid",
            f"a Hamaker constant of {dry:.3g} nN nm, the liquid's {medium:.3g} nN nm",
            Phrase("give ", Argument("work_of_adhesion", ...), " (dry, under the liquid) if both are known"),
        )
    return share


def _named_materials_share(bodies: tuple, medium: float) -> float:
    """Return this share for two named materials; 0 where they repel each other under the liquid."""
    first, second = (body.hamaker_constant for body in bodies)
    return max(combined(first, second, medium) / combined(first, second), 0.0)


def _refuse_thick(pair: Any, radius: float, pressure: float) -> None:
    """Raise where the Kelvin radius (nm) is not small against the sphere's radius."""
    sphere = float(pair.get("sphere_radius", math.inf))
    # largest Kelvin radius of thin menisci, over the indenter's radius
    if radius > 0.1 * sphere:
        raise Refusal(
            "humidity",
            f"menisci that are small compared with the sphere's radius ({sphere:.3g} nm)",
            f"a Kelvin radius of {radius:.3g} nm at {pressure:.3g}",
            "give a lower humidity",
        )
