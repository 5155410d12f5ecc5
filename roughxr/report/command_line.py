"""The command that repeats a run, from the options that its archive records."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

import xarray as xr

from ..vocabulary import schema
from .summary import SUMMARY


def command(run: Mapping[str, xr.Dataset]) -> str:
    """Return the command line that repeats a run; empty where the shell cannot: no file, or places that are no grid."""
    scan = run.get("scan", xr.Dataset())
    pair = schema.arguments_of(scan, "assign_pair")
    if "solutions/published" in run:  # only the paper's own run compares its formulas
        return shlex.join(["roughxr", "paper", "-o", "paper-run", *_materials(pair), *_named(pair, "hardness")])
    has_indenter = "indenter_file" in scan.attrs
    needed = schema.PAIR[1:] if has_indenter else schema.PAIR
    given = schema.arguments_of(run.get(SUMMARY), "run")
    if "source_file" not in scan.attrs or not all(name in scan.coords for name in needed):
        return ""
    if given and "subregions" not in given:
        return ""
    parts = ["roughxr", "run", str(scan.attrs["source_file"]), *_image(scan)]
    parts += ["--indenter", str(scan.attrs["indenter_file"])] if has_indenter else []
    parts += _pair(scan, pair)
    parts += ["--level", str(schema.arguments_of(scan, "level").get("method", "none"))]
    return shlex.join(parts + _options(given))


def _options(given: dict[str, Any]) -> list[str]:
    """Return the options of `run` as its summary records them."""
    particle = ["--particle"] if given.get("particle") else []
    return particle + _named(given, "subregions", "delta", "preload", "law", "mesh", "budget")


def _image(scan: xr.Dataset) -> list[str]:
    """Return which image of the file was read, how, and how missing pixels were filled."""
    opened = schema.arguments_of(scan, "open_scan")
    options = {"channel": scan.attrs.get("channel") or opened.get("channel")} | {
        name: opened.get(name) for name in ("direction", "size", "height_units")
    }
    options["fill"] = schema.arguments_of(scan, "fill").get("method")
    return _named({name: value for name, value in options.items() if value not in (None, "")})


def _pair(scan: xr.Dataset, given: dict[str, Any]) -> list[str]:
    """Return the options of the pair of bodies, as given where the run records it."""
    modulus, work = schema.pair(scan, *schema.PAIR[1:], humid=True)
    parts = ["--sphere-radius", f"{float(scan['sphere_radius']):.12g}"] if "sphere_radius" in scan.coords else []
    if "materials" in given:
        parts += _materials(given)
    elif {"young_modulus", "poisson_ratio"} <= set(given):
        parts += _named(given, "young_modulus", "poisson_ratio")
    else:
        parts += ["--contact-modulus", repr(modulus)]
    assigned = ("adhesion_range", "hamaker_constant", "retardation", "hardness")
    parts += _named({name: float(scan[name]) for name in assigned if name in scan.coords})
    if schema.is_wet(scan):
        parts += ["--humidity", repr(float(scan["humidity"]))]
        parts += _named(given, "contact_angle", "temperature", "liquid", "film")
        return [*parts, "--work-of-adhesion", repr(work), repr(work * float(scan["share_under_liquid"]))]
    if "surface_energy" in given:
        return [*parts, "--surface-energy", *_listed(given["surface_energy"])]
    return [*parts, "--work-of-adhesion", repr(work)]


def _materials(given: dict[str, Any]) -> list[str]:
    return ["--materials", "/".join(_listed(given["materials"]))] if "materials" in given else []


def _named(given: dict[str, Any], *names: str) -> list[str]:
    """Return options of these names, by default of all, where they are given."""
    known = [name for name in names or given if name in given]
    return [part for name in known for part in (f"--{name.replace('_', '-')}", *_listed(given[name]))]


def _listed(value: Any) -> list[str]:
    values = value if isinstance(value, list) else [value]
    return [item if isinstance(item, str) else repr(item) for item in values]
