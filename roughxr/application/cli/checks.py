"""What the words of a command line alone decide, checked before slow imports and before a file is read.

The functions of the package check their arguments at their own doors; here they check what needs no scan and no run.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.bodies.liquid import HumidAir
from ...mechanics.bodies.pair import assign_pair
from ...mechanics.bodies.substances import MATERIALS
from ...mechanics.contact.mesh import Mesh, read_mesh
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.schema import one_of
from ...mechanics.vocabulary.text import without_warnings
from ...mechanics.vocabulary.units import positive
from ..runs.run_options import check_output, read_adhesion
from ..tables import table_writer
from .options import AIR, BODIES, PARTICLE_CODES
from .words import FILES, number, numbers

#: Units of the options that are positive quantities.
_UNITS = {
    "sphere_radius": "nm",
    "size": "nm",
    "spring_constant": "nN/nm",
    "particle_density": "kg/m^3",
    "shear_strength": "GPa",
}

#: Endings of a picture, and of a converted scan.
_PICTURES = (".png", ".pdf", ".svg", ".jpg")
_SCANS = (".nc", ".gsf")

#: Options of commands that name a table to write.
_TABLES = {"detach:detach": ("output", "parameters"), "measurements:describe": ("output",)}


def check(options: Namespace) -> None:
    """Raise where a command's words are wrong by themselves."""
    given = {name: value for name, value in vars(options).items() if value is not None}
    for name in FILES:
        files = _listed(given.get(name, []))
        if len(files) == 1:  # of several the others are read
            Path(files[0]).stat()
    for name in ("output", "parameters", "picture"):
        if given.get(name) == "":
            raise Refusal(name, "the name of a file or folder", "an empty one")
    _check_output_names(options.command, given)
    if options.command == "running:run":
        _check_run(options)
    for name in given.keys() & _UNITS.keys():
        for value in _listed(given[name]):
            positive(number(value), _UNITS[name], name)


def _check_output_names(command: str, given: Mapping[str, Any]) -> None:
    """Raise where a table, a picture, a converted scan or input of a particle code has no known format."""
    for name in _TABLES.get(command, ()):
        if name in given:
            table_writer(Path(given[name]))
    if "picture" in given:
        one_of(Path(given["picture"]).suffix, _PICTURES, f"{given['picture']}'s ending")
    if command == "file_commands:convert":
        one_of(Path(given["output"]).suffix, _SCANS, "--output")
    for code, _ in given.get("dem", []):
        one_of(code, PARTICLE_CODES, "code")


def _check_run(options: Namespace) -> None:
    """Raise where output, bodies, or the options of the simulation with adhesion are wrong by themselves."""
    output = Path(options.output)
    if len(options.scan) > 1 and output.is_file():
        raise Refusal("output", "a folder for several scans", f"a file, {output}")
    check_output(output)
    both_counts(options.subregions)
    any_sphere = {"sphere_radius": 1000.0}  # in place of an indenter, which is not read yet
    check_adhesion(without_warnings(assign_pair, xr.Dataset(), **any_sphere | stated_pair(options)))
    read_adhesion(options.preload, options.law, options.budget)
    read_mesh(options.mesh, Mesh())


def _listed(value: Any) -> list[str]:
    return value if isinstance(value, list) else [value]


def both_counts(counts: Sequence[int]) -> tuple[int, int]:
    """Return the places along x and y: one number stands for both."""
    counts = np.hstack(counts).tolist()
    if len(counts) > 2:
        raise Refusal("--subregions", "places along x and y, or one number for both", len(counts))
    return counts[0], counts[-1]


def stated_pair(options: Namespace) -> dict[str, Any]:
    """Return the bodies as `assign_pair` takes them, without an indenter's scan; raise where one is missing."""
    if not (options.materials or options.young_modulus or options.contact_modulus):
        raise Refusal(
            "",
            "the bodies' elastic constants",
            "none",
            f"give --materials A/B (one or two of {', '.join(MATERIALS)}), or --young-modulus and --poisson-ratio, or "
            "--contact-modulus",
        )
    pair = _options_given(options, ["sphere_radius", *BODIES])
    air = _options_given(options, AIR)
    if "humidity" in air:
        pair["humidity"] = HumidAir(**air)
    elif air:
        flags = ", ".join("--" + name.replace("_", "-") for name in air)
        advice = "give it, or leave these options out" + "; a solid film is a --layer" * ("film" in air)
        raise Refusal("humidity", f"one with {flags}", "none", advice)
    return pair


def check_adhesion(scan: xr.Dataset) -> None:
    """Raise where the bodies of a scan have no adhesion."""
    if "work_of_adhesion" not in scan.coords:
        raise Refusal(
            "",
            "the adhesion of the bodies",
            "none",
            "give --work-of-adhesion (or --surface-energy) in J/m²: clean dry solids have about 0.05 to 0.1 by van der "
            "Waals forces alone, and more with water films or bonds",
        )


def _options_given(options: Namespace, names: Sequence[str]) -> dict[str, Any]:
    """Return the options that are given, as numbers, quantities or pairs."""
    stated = {name: getattr(options, name) for name in names}
    return {name: numbers(value) for name, value in stated.items() if value is not None}
