"""Named materials: elastic constants, hardness, and the adhesion due to van der Waals forces alone, with sources.

For named materials the work of adhesion is that of clean, dry, smooth bodies without bonds or water between them,
w = A/(12π D₀²) with Hamaker's constant A and the cut-off D₀ = 0.165 nm, √(A₁A₂) for two materials, (√A₁ − √A₃)(√A₂ −
√A₃) across a third (Israelachvili, Intermolecular and Surface Forces, 3rd ed., eqs. 13.15, 13.29 and 13.31; media from
its table 13.2). Adhesion is stronger with films of water, after long contact, and between cleaved crystals: give a
measured value as ``work_of_adhesion``.

Hardness is an estimate to one digit: it depends on treatment, purity, rate and size, and the small indents that
asperities make are harder than large ones, in metals several times. It shows where elasticity is doubtful; give a
measured value as ``hardness``, at which the body then yields.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..vocabulary.refusal import Refusal
from ..vocabulary.text import did_you_mean

#: Cut-off of van der Waals forces at contact, nm.
CUT_OFF = 0.165

_HANDBOOK = "Callister & Rethwisch, Materials Science and Engineering, appendix B"
_BERGSTROM = "Bergström, Adv. Colloid Interface Sci. 70 (1997) 125"
_ISRAELACHVILI = "Israelachvili, Intermolecular and Surface Forces, 3rd ed., table 13.2"
_PAPER = "Cheng, Dunn & Brach (2003)"
_HOPCROFT = "Hopcroft, Nix & Kenny, J. MEMS 19 (2010) 229, <100>"
_OLIVER = "estimate: Oliver & Pharr, J. Mater. Res. 7 (1992) 1564"
_THIRD = "estimate: three times the handbook's yield strength, Tabor, The Hardness of Metals (1951)"
_LESS_THAN_SAPPHIRE = f"{_OLIVER}, less than sapphire's; 25 to 30 of dense fine grain"
_OF_A_FILM = "estimate: a film of 504 nm has 1.3, Zhou et al. (2007); annealed bulk 0.3"
_OF_ITS_OXIDE = f"{_BERGSTROM}, of silica, its native oxide; bare silicon 0.18 to 0.26"
_OF_IRON_OXIDE = f"{_ISRAELACHVILI}, of iron oxide"
_OF_NOBLE_METALS = f"{_ISRAELACHVILI}, 0.25 to 0.40 of noble metals; computed ones are at its upper end"


class Material(NamedTuple):
    """An isotropic solid; ``hamaker`` across vacuum, of the oxide where one covers it."""

    young_modulus: float  # GPa
    poisson_ratio: float
    elastic_source: str
    hardness: float  # GPa, an estimate
    hardness_source: str
    hamaker: float  # nN nm = 1e-18 J
    hamaker_source: str


#: By name. Glass is the paper's. Silicon's constants are those along <100>: a crystal that is pressed on
#: answers with its other directions too, 169 GPa and 0.06 along <110>, and is somewhat stiffer.
#:
#: Every A but glass's (silica's), silicon's and gold's, and those of the media below, follows to 5 % from index of
#: refraction and absorption frequency by Tabor and Winterton's formula (Israelachvili, eq. 13.16), as the tests compute
#: it; gold's lies between what the formula gives metals, 0.26 and 0.44 (eq. 13.18). Bare silicon would have 0.18 to
#: 0.26; in air 1 to 2 nm of oxide cover it. Not looked up again: the moduli of alumina, silica and gold, the ratios of
#: polystyrene and PTFE, the hardness of glass, silica and silicon, and the yield strengths of steel and the polymers.
MATERIALS = {
    "glass": Material(75.0, 0.22, _PAPER, 6.0, f"{_OLIVER}, of soda-lime glass", 0.065, f"{_BERGSTROM}, of silica"),
    "silica": Material(73.0, 0.17, _HANDBOOK, 9.0, f"{_OLIVER}; 7.3 of large indents", 0.065, _BERGSTROM),
    "alumina": Material(380.0, 0.22, _HANDBOOK, 20.0, _LESS_THAN_SAPPHIRE, 0.152, _BERGSTROM),
    "polystyrene": Material(2.8, 0.33, _HANDBOOK, 0.2, _THIRD, 0.065, _ISRAELACHVILI),
    "ptfe": Material(0.5, 0.46, _HANDBOOK, 0.05, _THIRD, 0.038, _ISRAELACHVILI),
    "silicon": Material(130.0, 0.28, _HOPCROFT, 12.0, f"{_OLIVER} and others", 0.065, _OF_ITS_OXIDE),
    "steel": Material(207.0, 0.30, _HANDBOOK, 2.0, f"{_THIRD}, annealed; 8 if hardened", 0.21, _OF_IRON_OXIDE),
    "gold": Material(77.0, 0.42, _HANDBOOK, 1.0, _OF_A_FILM, 0.40, _OF_NOBLE_METALS),
}

#: Hamaker constants (nN nm) of media, across vacuum.
MEDIA = {"vacuum": 0.0, "air": 0.0, "water": 0.037, "ethanol": 0.042, "hexadecane": 0.052}


def named_pair(names: str | tuple[str, str]) -> tuple[Material, Material]:
    """Return the two materials named in "glass/silicon" or ("glass", "silicon"); a single name is used for both."""
    both = names.split("/") if isinstance(names, str) else list(names)
    both = [str(name).strip().lower() for name in both]
    unknown = [name for name in both if name not in MATERIALS]
    if len(both) not in (1, 2) or unknown:
        # other names of the same first letter: mica is no misspelt silica
        similar = [name for name in MATERIALS if name not in both and unknown and name[0] == unknown[0][:1]]
        raise Refusal(
            "materials",
            f"one or two of {', '.join(MATERIALS)}, as in 'glass/silicon'",
            f"{names!r}{(did_you_mean(unknown[0], similar) if unknown else '')}",
            "for other materials give young_modulus and poisson_ratio, and work_of_adhesion or hamaker_constant",
        )
    return MATERIALS[both[0]], MATERIALS[both[-1]]


def combined(first: float, second: float, medium: float = 0.0) -> float:
    """Return Hamaker's A₁₃₂ = (√A₁ − √A₃)(√A₂ − √A₃): √(A₁A₂) across vacuum, negative where they repel."""
    return (math.sqrt(first) - math.sqrt(medium)) * (math.sqrt(second) - math.sqrt(medium))


def van_der_waals_work(hamaker: float) -> float:
    """Return the work of adhesion A/(12π D₀²), J/m², of a Hamaker constant (nN nm)."""
    return hamaker / (12 * math.pi * CUT_OFF**2)
