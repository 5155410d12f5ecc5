"""The command that repeats a run, reconstructed from the run itself."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

import xarray as xr

from ...vocabulary import schema
from ...vocabulary.verbs import verb


@verb
def command(run: Mapping[str, xr.Dataset]) -> str:
    """Return the command line that repeats a run.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run. If its scan has the attribute ``command``, it is returned; otherwise the line is built
        from the steps that the run records, with the bodies as they were given.

    Returns
    -------
    str
        Empty where the run does not record enough.

    Examples
    --------
    >>> command({"scan": xr.Dataset(attrs={"command": "roughxr paper"})})
    'roughxr paper'
    """
    scan = run.get("scan", xr.Dataset())
    if scan.attrs.get("command"):
        return str(scan.attrs["command"])
    steps = [step for ds in run.values() for step in schema.history(ds)]
    if _first(steps, "glass"):
        return "roughxr paper -o paper-run"
    if "source_file" not in scan.attrs or not all(name in scan.coords for name in schema.PAIR):
        return ""
    parts = ["roughxr", "run", str(scan.attrs["source_file"]), *_channel(scan)]
    parts += _pair(scan, _last(schema.history(scan), "assign_pair"))
    parts += ["--level", _first(steps, "level").get("method", "none"), *_places(_first(steps, "direct"))]
    parts += _adhesion(_first(steps, "adhesive"))
    return shlex.join(parts)


def _first(steps: list[dict[str, Any]], operation: str) -> dict[str, Any]:
    """Return the arguments of the first step of this name, or the step itself where it has none."""
    return next((step.get("arguments") or step for step in steps if step.get("operation") == operation), {})


def _last(steps: list[dict[str, Any]], operation: str) -> dict[str, Any]:
    """Return the arguments of the last step of this name."""
    return _first(steps[::-1], operation)


def _channel(scan: xr.Dataset) -> list[str]:
    return ["--channel", str(scan.attrs["channel"])] if scan.attrs.get("channel") else []


def _pair(scan: xr.Dataset, given: dict[str, Any]) -> list[str]:
    """Return the options of the pair of bodies, as given where the run records it."""
    radius, modulus, work = schema.pair(scan, *schema.PAIR)
    parts = ["--sphere-radius", f"{radius:g}"]
    if "materials" in given:
        parts += ["--materials", "/".join(_listed(given["materials"]))]
    elif {"young_modulus", "poisson_ratio"} <= set(given):
        for name in ("young_modulus", "poisson_ratio"):
            parts += [f"--{name.replace('_', '-')}", *_listed(given[name])]
    else:
        parts += ["--contact-modulus", repr(modulus)]
    for name in ("adhesion_range", "hamaker_constant", "hardness"):
        if name in scan.coords:
            parts += [f"--{name.replace('_', '-')}", repr(float(scan[name]))]
    if "surface_energy" in given:
        return [*parts, "--surface-energy", *_listed(given["surface_energy"])]
    return [*parts, "--work-of-adhesion", repr(work)]


def _listed(value: Any) -> list[str]:
    values = value if isinstance(value, list) else [value]
    return [one if isinstance(one, str) else repr(one) for one in values]


def _adhesion(given: dict[str, Any]) -> list[str]:
    """Return the options of the simulation with adhesion that differ from the defaults."""
    parts = ["--law", given["law"]] if "law" in given else []
    if given.get("preload"):
        parts += ["--preload", *_listed(given["preload"])]
    return parts + (["--refine", str(given["refine"])] if isinstance(given.get("refine"), int) else [])


def _places(direct: dict[str, Any]) -> list[str]:
    """Return grid and displacements, where they were given as plain numbers."""
    grid, delta = direct.get("subregions"), direct.get("delta")
    parts = ["--subregions", *map(str, grid)] if isinstance(grid, list) and len(grid) == 2 else []
    return parts + (["--delta", *(f"{d:g}" for d in delta)] if isinstance(delta, list) else [])
