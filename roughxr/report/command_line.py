"""The command that repeats a run, from the options that its archive records."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

import xarray as xr

from ..scans import open_sample
from ..vocabulary import schema
from .summary import SUMMARY


def command(run: Mapping[str, xr.Dataset]) -> str:
    """Return the command line that repeats a run; empty where the shell cannot: no file, or places that are no grid."""
    scan = run.get("scan", xr.Dataset())
    if "height" in scan and _is_the_papers(scan):
        return "roughxr paper -o paper-run"
    has_indenter = "indenter_file" in scan.attrs
    needed = schema.PAIR[1:] if has_indenter else schema.PAIR
    given = schema.arguments_of(run.get(SUMMARY), "run")
    if "source_file" not in scan.attrs or not all(name in scan.coords for name in needed):
        return ""
    if given and "subregions" not in given:
        return ""
    parts = ["roughxr", "run", str(scan.attrs["source_file"]), *_image(scan)]
    parts += ["--indenter", str(scan.attrs["indenter_file"])] if has_indenter else []
    parts += _pair(scan, schema.arguments_of(scan, "assign_pair"))
    parts += ["--level", str(schema.arguments_of(scan, "level").get("method", "none"))]
    return shlex.join(parts + _options(given))


def _options(given: dict[str, Any]) -> list[str]:
    """Return the options of `run` as its summary records them."""
    parts = ["--particle"] if given.get("particle") else []
    for name in ("subregions", "delta", "preload", "law", "mesh", "budget"):
        if name in given:
            parts += [f"--{name}", *_listed(given[name])]
    return parts


def _is_the_papers(scan: xr.Dataset) -> bool:
    """Return whether the heights are those of the sample that the paper is repeated on."""
    sample = open_sample("glass")
    same = scan["height"].shape == sample["height"].shape
    return same and schema.height_hash(scan) == schema.height_hash(sample)


def _image(scan: xr.Dataset) -> list[str]:
    """Return which image of the file was read, how, and how missing pixels were filled."""
    opened, parts = schema.arguments_of(scan, "open_scan"), []
    channel = scan.attrs.get("channel") or opened.get("channel")
    options = {"channel": channel, **{name: opened.get(name) for name in ("direction", "size", "height_units")}}
    options["fill"] = schema.arguments_of(scan, "fill").get("method")
    for name, value in options.items():
        if value not in (None, ""):
            parts += [f"--{name.replace('_', '-')}", *_listed(value)]
    return parts


def _pair(scan: xr.Dataset, given: dict[str, Any]) -> list[str]:
    """Return the options of the pair of bodies, as given where the run records it."""
    modulus, work = schema.pair(scan, *schema.PAIR[1:], wet=True)
    parts = ["--sphere-radius", f"{float(scan['sphere_radius']):.12g}"] if "sphere_radius" in scan.coords else []
    if "materials" in given:
        parts += ["--materials", "/".join(_listed(given["materials"]))]
    elif {"young_modulus", "poisson_ratio"} <= set(given):
        for name in ("young_modulus", "poisson_ratio"):
            parts += [f"--{name.replace('_', '-')}", *_listed(given[name])]
    else:
        parts += ["--contact-modulus", repr(modulus)]
    for name in ("adhesion_range", "hamaker_constant", "retardation", "hardness"):
        if name in scan.coords:
            parts += [f"--{name.replace('_', '-')}", repr(float(scan[name]))]
    if schema.is_wet(scan):
        parts += ["--humidity", repr(float(scan["humidity"]))]
        parts += _as_given(given, "contact_angle", "temperature", "liquid", "film")
        return [*parts, "--work-of-adhesion", repr(work), repr(work * float(scan["share_under_liquid"]))]
    if "surface_energy" in given:
        return [*parts, "--surface-energy", *_listed(given["surface_energy"])]
    return [*parts, "--work-of-adhesion", repr(work)]


def _as_given(given: dict[str, Any], *names: str) -> list[str]:
    """Return options of these names as they were given, where they were."""
    return [part for name in names if name in given for part in (f"--{name.replace('_', '-')}", *_listed(given[name]))]


def _listed(value: Any) -> list[str]:
    values = value if isinstance(value, list) else [value]
    return [one if isinstance(one, str) else repr(one) for one in values]
