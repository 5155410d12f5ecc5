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

import csv
import math
import os
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

from ..vocabulary.refusal import Refusal
from ..vocabulary.text import Argument, Phrase, did_you_mean
from ..vocabulary.units import positive, single

#: Cut-off of van der Waals forces at contact, nm.
CUT_OFF = 0.165


class Material(NamedTuple):
    """An isotropic solid; the Hamaker constant is that across vacuum, of the oxide where one covers it."""

    young_modulus: float  # GPa
    poisson_ratio: float
    elastic_source: str
    hardness: float  # GPa, an estimate; infinite where none is known
    hardness_source: str
    hamaker_constant: float  # nN nm = 1e-18 J
    hamaker_source: str


#: Units of the columns of numbers in a table of materials.
_COLUMNS = {"young_modulus": "GPa", "poisson_ratio": "1", "hamaker_constant": "nN nm", "hardness": "GPa"}

#: Environment variable with the path of a table of a user's own materials.
OWN_TABLE = "ROUGHXR_MATERIALS"


def read_materials(lines: Iterable[str], table: object) -> dict[str, Material]:
    """Return the materials of a table of text, by name; ``table`` is its name in errors.

    A material without hardness does not yield. Sources are those of the table.
    """
    materials = {}
    for row in csv.DictReader(lines):
        name = (row.get("name") or "").strip().lower()
        if not name or "/" in name:
            raise Refusal(table, "a column 'name' without '/'", f"{name!r} in {', '.join(map(str, row))}")
        numbers: dict[str, Any] = {}
        for column, units in _COLUMNS.items():
            text = (row.get(column) or "").strip()
            if not text and column != "hardness":
                raise Refusal(table, f"{column} of {name} ({units})", "none")
            numbers[column] = math.inf if not text else _number(text, units, f"{table}: {column} of {name}")
        sources: dict[str, Any] = {
            column: row.get(column) or f"{table}" for column in Material._fields if column not in numbers
        }
        materials[name] = Material(**numbers, **sources)
    return materials


def _number(text: str, units: str, name: str) -> float:
    """Return text as a positive number, units convert it; one without units may be Poisson's ratio."""
    try:
        value: float | str = float(text)
    except ValueError:
        value = text
    if units == "1":
        return single(value, units, name, "a number in (-1, 0.5]", lambda ratio: -1 < ratio <= 0.5)
    return positive(value, units, name)


#: By name. Glass is the paper's. Silicon's constants are those along <100>: a crystal that is pressed on
#: answers with its other directions too, 169 GPa and 0.06 along <110>, and is somewhat stiffer.
#:
#: A of silica, alumina, calcite, mica, silicon nitride, polymers but PDMS, steel and the media follows to 5 % from the
#: index of refraction and absorption frequency by Tabor and Winterton's formula (Israelachvili, eq. 13.16), as tests
#: compute it; gold's lies between what the formula gives metals, 0.26 and 0.44 (eq. 13.18). In air 1 to 2 nm of oxide
#: cover silicon. Not looked up again: the moduli of alumina, silica and gold, the ratios of polystyrene and PTFE, the
#: hardness of glass, silica and silicon, the yield strengths of steel, polystyrene and PTFE, and A of calcite, mica,
#: silicon nitride and titania in Bergström's table.
MATERIALS = read_materials(
    files(__package__).joinpath("substances.csv").read_text(encoding="utf-8").splitlines(), "substances.csv"
)


def materials() -> dict[str, Material]:
    """Return all named materials with those of the user's own table, which come first."""
    path = os.environ.get(OWN_TABLE)
    if not path:
        return MATERIALS
    if not Path(path).is_file():
        raise Refusal(OWN_TABLE, "the name of a table of materials", repr(path))
    lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    return MATERIALS | read_materials(lines, path)


#: Hamaker constants (nN nm) of media, across vacuum.
MEDIA = {"vacuum": 0.0, "air": 0.0, "water": 0.037, "ethanol": 0.042, "hexadecane": 0.052}


#: Names that people give to listed materials.
_OTHER_NAMES = {"limestone": "calcite", "chalk": "calcite", "marble": "calcite", "teflon": "ptfe", "quartz": "silica"}
_OTHER_NAMES |= {"sapphire": "alumina", "al2o3": "alumina", "sio2": "silica", "si": "silicon", "tio2": "titania"}
_OTHER_NAMES |= {"plexiglass": "pmma", "ps": "polystyrene", "si3n4": "silicon_nitride", "oxide": "silica"}


def named_pair(names: str | tuple[str, str]) -> tuple[Material, Material]:
    """Return the two materials named in "glass/silicon" or ("glass", "silicon"); a single name is used for both."""
    both = names.split("/") if isinstance(names, str) else list(names)
    both = [str(name).strip().lower() for name in both]
    listed = materials()
    unknown = [name for name in both if name not in listed]
    if len(both) not in (1, 2) or unknown:
        # other names of the same first letter: mica is no misspelt silica
        similar = [name for name in listed if name not in both and unknown and name[0] == unknown[0][:1]]
        question = did_you_mean(unknown[0], similar) if unknown else ""
        if unknown and unknown[0] in _OTHER_NAMES:
            question = f" (did you mean {_OTHER_NAMES[unknown[0]]}?)"
        raise Refusal(
            "materials",
            f"one or two of {', '.join(listed)}, as in 'glass/silicon'",
            f"{names!r}{question}",
            Phrase(
                "for another material give ",
                Argument("young_modulus"),
                ", ",
                Argument("poisson_ratio"),
                ", and ",
                Argument("work_of_adhesion"),
                " or ",
                Argument("hamaker_constant"),
                f"; or list it in a table that the environment variable {OWN_TABLE} names",
            ),
        )
    return listed[both[0]], listed[both[-1]]


def combined(first: float, second: float, medium: float = 0.0) -> float:
    """Return Hamaker's A₁₃₂ = (√A₁ − √A₃)(√A₂ − √A₃): √(A₁A₂) across vacuum, negative where they repel."""
    return (math.sqrt(first) - math.sqrt(medium)) * (math.sqrt(second) - math.sqrt(medium))


def van_der_waals_work(hamaker: float) -> float:
    """Return the work of adhesion A/(12π D₀²), J/m², of a Hamaker constant (nN nm)."""
    return hamaker / (12 * math.pi * CUT_OFF**2)
