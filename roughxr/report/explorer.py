"""A run as an interactive page: a map of the scan with its places, and the results at the place that is chosen.

The page draws what the archive contains. It is self-contained: it needs no network, no server and no library.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from .. import archive
from ..figures.images import colour_map
from ..jobs.records import BRANCHES
from ..statistics.sampling import SHARE
from ..vocabulary import schema
from .caveats import cautions
from .report_page import as_uri, filled, title, written
from .run_tables import METHOD_WORDS, flagged
from .summary import by_place, headline

Run = Mapping[str, xr.Dataset]

#: Parameters along which a result has several conditions.
_PARAMETERS = ("preload", "sphere_radius", "contact_modulus", "work_of_adhesion", "cycle")

#: Groups with the pressure of some of the places.
_FIELDS = ("adhesive", "direct", "contact")

#: Largest number of pixels along a side of the scan and of a contact map, and of displacements in a curve.
_SCAN_PIXELS, _MAP_PIXELS, _POINTS = 1200, 96, 320


def write_explorer(path: str | os.PathLike, output: str | os.PathLike | None = None) -> Path:
    """Write a run's archive as one self-contained, interactive HTML page.

    A click on a place of the scan shows its force over displacement, its position among all pull-offs, its numbers,
    and the map of its contact where the archive contains the pressure.

    Parameters
    ----------
    path, output : path
        As for `write_report`; by default ``explore.html`` beside the archive.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the file contains no results at places of a scan, or results for several values of a parameter.
    """
    path = archive.of_run(Path(path))
    run = {name: ds for name, ds in archive.load(path).items() if ds.variables}
    try:
        text = explorer_page(run, archive_name=path.name)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return written(text, path, output, "explore.html")


def explorer_page(run: Run, *, archive_name: str = "run.nc") -> str:
    """Return the page as text."""
    data = page_data(run)
    return filled(
        "explorer.html",
        title=title(run["scan"]),
        headline=headline(run),
        archive_name=archive_name,
        count=len(data["places"]),
        cautions=cautions(run),
        # within a script, escape whatever could end it, since a file's own text may contain anything
        data=json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
    )


def page_data(run: Run) -> dict[str, Any]:
    """Return all the data that the page's script draws."""
    if "scan" not in run:
        raise ValueError(
            f"expected the archive of a run, with its scan, found groups: {', '.join(run) or 'none'}; make one with "
            "roughxr run"
        )
    scan, places = schema.validate(run["scan"], "scan"), _places(run)
    solved = {name: ds for name in METHOD_WORDS if (ds := _at_places(run, places, f"solutions/{name}")) is not None}
    pulls = {name: _at_places(run, places, f"statistics/{name}") for name in METHOD_WORDS}
    pulls = {name: solved.get(name) if ds is None else ds for name, ds in pulls.items()}
    return {
        "scan": _scan(scan),
        "places": _rows(run, places),
        "curves": list(_curves(run, places, solved)),
        "pulls": list(_pull_offs(pulls)),
        "facts": _facts(by_place(run), places),
        "maps": _maps(run, places),
    }


def _places(run: Run) -> xr.Dataset:
    """Return the contact centres of the first result that has any."""
    names = [f"{part}/{name}" for part in ("solutions", "statistics") for name in METHOD_WORDS]
    first = next((run[name] for name in [*names, *run] if name in run and "subregion_x" in run[name].coords), None)
    if first is None or first.sizes.get("subregion", 0) == 0:
        groups = ", ".join(run) or "none"
        raise ValueError(f"expected results at places of the scan (subregion_x, subregion_y), found groups: {groups}")
    return xr.Dataset(coords={name: first[name] for name in ("subregion", "subregion_x", "subregion_y")})


def _at_places(run: Run, places: xr.Dataset, group: str) -> xr.Dataset | None:
    """Return a group of the run if it has these places, in their order."""
    ds = run.get(group)
    if ds is None or "subregion_x" not in ds.coords or ds.sizes.get("subregion") != places.sizes["subregion"]:
        return None
    if others := [name for name in _PARAMETERS if name in ds.dims]:
        raise ValueError(
            f"{group}: expected one condition, found several along {', '.join(others)}; save one of each, "
            f"isel({others[0]}=0)"
        )
    return ds if all(np.allclose(ds[name], places[name]) for name in ("subregion_x", "subregion_y")) else None


def _rows(run: Run, places: xr.Dataset) -> list[dict[str, Any]]:
    """Return the places, which of them contain debris by the rule, and what share of particles rests there."""
    count, flags, rests = places.sizes["subregion"], flagged(run), _at_places(run, places, "statistics/rests")
    debris = flags.values if flags is not None and flags.size == count else np.zeros(count, bool)
    shares = [None] * count if rests is None else _numbers(rests[SHARE].values)
    positions = zip(*(places[f"subregion_{axis}"].values.tolist() for axis in "xy"))
    return [
        {"x": x, "y": y, "debris": bool(flag), "share": share} for (x, y), flag, share in zip(positions, debris, shares)
    ]


def _curves(run: Run, places: xr.Dataset, solved: dict[str, xr.Dataset]) -> Iterator[dict[str, Any]]:
    """Yield the force over displacement from the highest peak of each method that has it; of events, their points."""
    touch = solved.get("rigid", xr.Dataset()).get("touch_delta")
    for name, ds in solved.items():
        offset = np.zeros(places.sizes["subregion"])
        if ds.attrs.get("datum") == "first_contact":
            if touch is None or touch.dims != ("subregion",) or "sphere_radius" in ds.dims:
                continue  # its displacements have no common origin
            offset = touch.values
        if "delta" in ds.dims and "force" in ds and ds.sizes["delta"] > 1:
            retraction = _at_places(run, places, "solutions/retraction") if name == "direct" else None
            lines = _lines(ds[["force"]], retraction, offset)
        elif name == "adhesive" and {"pull_off_delta", "detachment_delta"} <= set(ds):
            lines = _events(ds, offset)
        else:
            continue
        events = "delta" not in ds.dims
        yield {"name": name, "label": METHOD_WORDS[name], "events": events, "lines": lines}


def _lines(case: xr.Dataset, retraction: xr.Dataset | None, offset: np.ndarray) -> list[list[dict[str, Any]]]:
    """Return both branches of each place, or the only one."""
    thin = case.isel(delta=slice(None, None, -(-case.sizes["delta"] // _POINTS)))
    parts = [thin.sel(branch=way) for way in BRANCHES] if "branch" in case.dims else [thin]
    parts += [] if retraction is None else [retraction]
    forces = [(part["delta"].values, part["force"].transpose("subregion", "delta").values) for part in parts]
    return [
        [{"delta": _numbers(delta + shift), "force": _numbers(force[k])} for delta, force in forces]
        for k, shift in enumerate(offset)
    ]


def _events(case: xr.Dataset, offset: np.ndarray) -> list[list[dict[str, Any]]]:
    """Return pull-off and detachment of each place as points."""
    deltas = np.stack([case["pull_off_delta"].values, case["detachment_delta"].values], axis=1) + offset[:, None]
    forces = np.stack([-case["pull_off_force"].values, np.zeros(offset.size)], axis=1)
    return [[{"delta": _numbers(delta), "force": _numbers(force)}] for delta, force in zip(deltas, forces)]


def _pull_offs(pulls: Mapping[str, xr.Dataset | None]) -> Iterator[dict[str, Any]]:
    """Yield the pull-off of every place by every method that has it."""
    for name, ds in pulls.items():
        force = None if ds is None else ds.get("pull_off_force")
        if force is not None and force.dims == ("subregion",) and bool(force.notnull().any()):
            yield {"name": name, "label": METHOD_WORDS[name], "values": _numbers(force.values)}


def _facts(table: xr.Dataset, places: xr.Dataset) -> list[dict[str, Any]]:
    """Return the columns of the table of places: words, unit, and a value for each place."""
    if table.sizes.get("subregion") != places.sizes["subregion"]:
        return []
    facts = []
    for name, column in table.data_vars.items():
        label, unit = str(column.attrs.get("long_name", name)), str(column.attrs.get("units", ""))
        values = column.values.tolist() if column.dtype.kind in "OUT" else _numbers(column.values.astype(float))
        facts.append({"name": name, "label": label, "unit": unit.removesuffix("1"), "values": values})
    return facts


def _scan(scan: xr.Dataset) -> dict[str, Any]:
    """Return the scan as an image, x to the right and y upwards, with its edges and its colour scale, nm."""
    heights = _thinned(scan["height"].transpose("x", "y").values, _SCAN_PIXELS)
    known = heights[np.isfinite(heights)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    shares = (heights - low) / ((high - low) or 1.0)
    colours = colour_map("mako")
    box = [edge for axis in "xy" for edge in _edges(scan[axis].values)]
    return {"picture": _picture(colours(shares)), "box": box, "low": low, "high": high}


def _maps(run: Run, places: xr.Dataset) -> dict[int, list[dict[str, Any]]]:
    """Return by place the contact maps that the archive contains, one for each state of the first parameters."""
    maps: dict[int, list[dict[str, Any]]] = {}
    centres = np.stack([places["subregion_x"].values, places["subregion_y"].values], axis=1)
    for ds in (run[f"solutions/{name}"] for name in _FIELDS if f"solutions/{name}" in run):
        if "pressure" not in ds or "subregion_x" not in ds.coords:
            continue
        case = ds.sel(branch=BRANCHES[0]) if "branch" in ds.dims else ds
        for k in range(case.sizes["subregion"]):
            place = case.isel(subregion=k)
            far = np.hypot(*(centres - [float(place["subregion_x"]), float(place["subregion_y"])]).T)
            if far.min() < 1e-6 and int(far.argmin()) not in maps and (states := _states(place.load())):
                maps[int(far.argmin())] = states
    return maps


def _states(place: xr.Dataset) -> list[dict[str, Any]]:
    """Return the maps of one place along its displacements, cropped to its contact, on one colour scale."""
    pressure = np.nan_to_num(place["pressure"].transpose("delta", "x", "y").values)
    push, pull = max(float(pressure.max()), 0.0), max(-float(pressure.min()), 0.0)
    strongest = abs(pressure).max(axis=0)
    if not strongest.any():
        return []
    inside = [np.flatnonzero((strongest > 0.02 * strongest.max()).any(axis=other)) for other in (1, 0)]
    window = tuple(slice(max(part[0] - 2, 0), part[-1] + 3) for part in inside)
    box = [edge for axis, part in zip("xy", window) for edge in _edges(place[axis].values[part])]
    return [
        {
            "picture": _picture(_tractions(_thinned(pressure[state][window], _MAP_PIXELS), pull, push)),
            "box": box,
            "delta": _number(float(place["delta"][state])),
            "force": _number(float(place["force"][state])),
            "area": _number(float(place["contact_area"][state])),
            "pull": _number(pull),
            "push": _number(push),
        }
        for state in range(pressure.shape[0])
    ]


def _tractions(values: np.ndarray, pull: float, push: float) -> np.ndarray:
    """Return colours: pushes red, pulls blue, darker for stronger ones; transparent where there is none."""
    pushes, pulls = (np.clip(sign * values / (most or 1.0), 0.0, 1.0) for sign, most in ((1, push), (-1, pull)))
    reds, blues = colour_map("rocket_r")(0.12 + 0.83 * pushes), colour_map("Blues")(0.25 + 0.7 * pulls)
    colours = np.where((values > 0)[..., None], reds, blues)
    colours[..., 3] = (pushes > 0) | (pulls > 0.02)
    return colours


def _picture(colours: np.ndarray) -> str:
    """Return colours (x, y, RGBA) as a data URI, x to the right and y upwards."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray((colours * 255).round().astype(np.uint8).transpose(1, 0, 2)[::-1]).save(file, "PNG")
    return as_uri(file.getvalue())


def _thinned(values: np.ndarray, most: int) -> np.ndarray:
    """Return averages over blocks of pixels, so that no side exceeds ``most``."""
    rows, columns = (max(1, -(-n // most)) for n in values.shape)
    return xr.DataArray(values, dims=("x", "y")).coarsen(x=rows, y=columns, boundary="pad").mean().values


def _edges(axis: np.ndarray) -> tuple[float, float]:
    cell = float(axis[1] - axis[0]) if axis.size > 1 else 1.0
    return float(axis[0]) - cell / 2, float(axis[-1]) + cell / 2


def _number(value: float) -> float | None:
    """Return a number to five digits, None for a missing one."""
    return float(f"{value:.5g}") if np.isfinite(value) else None


def _numbers(values: np.ndarray) -> list[float | None]:
    return [_number(value) for value in np.asarray(values, float).tolist()]
