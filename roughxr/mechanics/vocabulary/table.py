"""Units, sign and meaning of every variable of a roughxr Dataset, read from `variables.csv`.

Signs: heights point out of the material; ``delta`` > 0 brings the bodies together; ``force`` and ``pressure`` are > 0
in compression, < 0 in tension; ``gap`` >= 0; a pull-off force is a positive magnitude.
"""

from __future__ import annotations

import csv
from importlib.resources import files
from typing import NamedTuple


class Variable(NamedTuple):
    """The meaning of one name: its units (UDUNITS; empty where they are another variable's), label, and sign.

    Examples
    --------
    >>> import roughxr
    >>> roughxr.schema.VARIABLES["pull_off_force"].units
    'nN'
    """

    units: str
    long_name: str
    comment: str = ""


def _read() -> dict[str, Variable]:
    """Return the table of names."""
    lines = files(__package__).joinpath("variables.csv").read_text(encoding="utf-8").splitlines()
    rows = csv.reader(line for line in lines[1:] if not line.startswith("#"))
    return {name: Variable(*meaning) for name, *meaning in rows}


_TABLE = _read()

#: Every variable and coordinate name that roughxr writes.
VARIABLES = {name: row for name, row in _TABLE.items() if "." not in name}

#: The scalars of an answer and of a run's summary, where a name has its own meaning.
SCALARS = {name.removeprefix("summary."): row for name, row in _TABLE.items() if "." in name}

#: Required variables of each kind of Dataset, and their dimensions.
KINDS: dict[str, dict[str, tuple[str, ...]]] = {
    "scan": {"height": ("x", "y")},
    "asperities": {
        "height": ("asperity",),
        "curvature_min": ("asperity",),
        "curvature_max": ("asperity",),
        "orientation": ("asperity",),
    },
    "solution": {"force": ("subregion", "delta")},
    "pull_off": {"pull_off_force": ("subregion",)},
    "line": {"height": ("x",)},
    "moments": {"resisting_moment": ("subregion", "direction")},
    "forces": {"pull_off_force": ()},
    "places": {"subregion_x": (), "subregion_y": ()},
    "critical_load": {"shared_load_error": ("subregion",)},
}

#: Scalar coordinates of a scan with an assigned pair, which every result and archive keeps.
PAIR = ("sphere_radius", "contact_modulus", "work_of_adhesion")

#: The same, with the optional coordinates of a pair.
TRAVELLING = (
    *(*PAIR, "adhesion_range", "hamaker_constant", "retardation", "hardness", "hardness_estimate"),
    *("humidity", "kelvin_radius", "surface_tension", "contact_angle_1", "contact_angle_2"),
    *("liquid_film", "liquid_molecule", "share_under_liquid"),
    *("layer_thickness", "layer_modulus", "layer_poisson_ratio", "base_modulus", "base_poisson_ratio"),
)


def attributes(name: str) -> dict[str, str]:
    """Return the attributes of a variable of this name: long name, and units and comment where there are any."""
    row = VARIABLES[name]
    attrs = {"long_name": row.long_name, **({"units": row.units} if row.units else {})}
    return {**attrs, "comment": row.comment} if row.comment else attrs


def axis_label(name: str) -> str:
    """Return the label of an axis: long name and units."""
    row = VARIABLES[name]
    return row.long_name if row.units in ("1", "") else f"{row.long_name} [{row.units}]"
