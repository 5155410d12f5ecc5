"""The command that repeats a run, reconstructed from the run itself."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

import xarray as xr

from ..scans import open_sample
from ..vocabulary import schema
from ..vocabulary.verbs import verb


@verb
def command(run: Mapping[str, xr.Dataset]) -> str:
    """Return the command line that repeats a run."""
    scan = run.get("scan", xr.Dataset())
    if "height" in scan and _is_the_papers(scan):
        return "roughxr paper -o paper-run"
    if "source_file" not in scan.attrs or not all(name in scan.coords for name in schema.PAIR):
        return ""
    parts = ["roughxr", "run", str(scan.attrs["source_file"]), *_channel(scan)]
    parts += _pair(scan, schema.arguments_of(scan, "assign_pair"))
    parts += ["--level", str(schema.arguments_of(scan, "level").get("method", "none"))]
    parts += _places(schema.arguments_of(run.get("solutions/direct"), "direct"))
    parts += _adhesion(schema.arguments_of(run.get("solutions/adhesive"), "adhesive"))
    return shlex.join(parts)


def _is_the_papers(scan: xr.Dataset) -> bool:
    """Return whether the heights are those of the sample that the paper is repeated on."""
    sample = open_sample("glass")
    same = scan["height"].shape == sample["height"].shape
    return same and schema.height_hash(scan) == schema.height_hash(sample)


def _channel(scan: xr.Dataset) -> list[str]:
    return ["--channel", str(scan.attrs["channel"])] if scan.attrs.get("channel") else []


def _pair(scan: xr.Dataset, given: dict[str, Any]) -> list[str]:
    """Return the options of the pair of bodies, as given where the run records it."""
    radius, modulus, work = schema.pair(scan, *schema.PAIR, wet=True)
    parts = ["--sphere-radius", f"{radius:g}"]
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
        parts += _told(given, "contact_angle", "temperature", "liquid", "film")
        return [*parts, "--work-of-adhesion", repr(work), repr(work * float(scan["share_under_liquid"]))]
    if "surface_energy" in given:
        return [*parts, "--surface-energy", *_listed(given["surface_energy"])]
    return [*parts, "--work-of-adhesion", repr(work)]


def _told(given: dict[str, Any], *names: str) -> list[str]:
    """Return options of these names as they were given, where they were."""
    return [part for name in names if name in given for part in (f"--{name.replace('_', '-')}", *_listed(given[name]))]


def _listed(value: Any) -> list[str]:
    values = value if isinstance(value, list) else [value]
    return [one if isinstance(one, str) else repr(one) for one in values]


def _adhesion(given: dict[str, Any]) -> list[str]:
    """Return the options of the simulation with adhesion that differ from the defaults."""
    parts = ["--law", given["law"]] if "law" in given else []
    if given.get("preload"):
        parts += ["--preload", *_listed(given["preload"])]
    refine = given.get("mesh", {}).get("refine")
    return parts + (["--mesh", str(refine)] if isinstance(refine, int) else [])


def _places(direct: dict[str, Any]) -> list[str]:
    """Return grid and displacements, where they were given as plain numbers."""
    grid, delta = direct.get("subregions"), direct.get("delta")
    parts = ["--subregions", *map(str, grid)] if isinstance(grid, list) and len(grid) == 2 else []
    return parts + (["--delta", *(f"{d:g}" for d in delta)] if isinstance(delta, list) else [])
