"""The command that repeats a run, found in the run itself."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

import xarray as xr

from .. import schema


def command(run: Mapping[str, xr.Dataset]) -> str:
    """Return the command line that repeats a run.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run. Where its scan has the attribute ``command``, that is it; else the line is put
        together from the steps that the run records. Moduli and energies of the two bodies are recorded only as
        what acts on the contact, so that the line names two equal bodies of Poisson ratio 0 with the same
        contact modulus and work of adhesion.

    Returns
    -------
    str
        Empty where the run does not tell enough.

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
    parts = ["roughxr", "run", str(scan.attrs["source_file"]), *_channel(scan), *_pair(scan)]
    parts += ["--level", _first(steps, "level").get("method", "none"), *_places(_first(steps, "direct"))]
    return shlex.join(parts)


def _first(steps: list[dict[str, Any]], operation: str) -> dict[str, Any]:
    """Return the arguments of the first step of this name; of a step without any, the step."""
    return next((step.get("arguments") or step for step in steps if step.get("operation") == operation), {})


def _channel(scan: xr.Dataset) -> list[str]:
    return ["--channel", str(scan.attrs["channel"])] if scan.attrs.get("channel") else []


def _pair(scan: xr.Dataset) -> list[str]:
    radius, modulus, work = schema.pair(scan, *schema.PAIR)
    values = {
        "--sphere-radius": radius,
        "--young-modulus": 2 * modulus,
        "--poisson-ratio": 0.0,
        "--surface-energy": work / 2,
    }
    return [part for option, value in values.items() for part in (option, repr(float(value)))]


def _places(direct: dict[str, Any]) -> list[str]:
    """Return grid and displacements, as far as they were given as plain numbers."""
    grid, delta = direct.get("subregions"), direct.get("delta")
    parts = ["--subregions", *map(str, grid)] if isinstance(grid, list) and len(grid) == 2 else []
    return parts + (["--delta", *(f"{d:g}" for d in delta)] if isinstance(delta, list) else [])
