"""The interactive page of a run: a map of the scan with its places, and the results at the selected place.

The page is self-contained: it needs no network, no server and no library.
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

from ...mechanics.jobs.records import BRANCHES
from ...mechanics.scans.regions import extent
from ...mechanics.statistics.sampling import SHARE, at_first_preload
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal
from .. import archive
from ..figures.images import colour_map
from .caveats import cautions
from .report_page import as_uri, page_path, render_template, title, write_page
from .run_numbers import METHOD_WORDS, debris_flags
from .summary import by_place, headline_lines

Run = Mapping[str, xr.Dataset]

#: Columns of the table of places with a pull-off, by the method that computes it.
_PULL_OFFS = {
    "adhesive": "pull_off_force",
    "extrapolated": "pull_off_force_extrapolated",
    "energy": "pull_off_force_superposed",
    "rigid": "pull_off_force_rigid",
}

#: Largest number of pixels along a side of the scan.
_SCAN_PIXELS = 1200

#: Largest number of displacements in a curve.
_POINTS = 320


@archive.checked_names
def write_explorer(path: str | os.PathLike, output: str | os.PathLike | None = None) -> Path:
    """Write a run's archive as one self-contained, interactive HTML page, and return its path.

    A click on a place of the scan shows its force over displacement, its position among all pull-offs and its numbers.

    Parameters
    ----------
    path, output : path
        As for `write_report`; by default ``explore.html`` beside the archive.

    Examples
    --------
    >>> import contextlib, io, pathlib, tempfile
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    >>> scan = scan.contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0)
    >>> with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
    ...     groups = roughxr.run(scan, folder + "/run.nc", subregions=(2, 1), delta=[1.0, 2.0])
    ...     page = roughxr.report.write_explorer(folder + "/run.nc")
    >>> page.name
    'explore.html'
    """
    path = archive.run_archive(Path(path))
    output = page_path(path, output, "explore.html")
    run = {name: ds for name, ds in archive.load(path).items() if ds.variables}
    try:
        text = explorer_page(run, archive_name=path.name)
    except Refusal as error:
        raise Refusal(path, error.expected, error.found, error.advice) from error
    return write_page(text, output)


def explorer_page(run: Run, *, archive_name: str = "run.nc") -> str:
    """Return the page as text."""
    data = page_data(run)
    return render_template(
        "explorer.html",
        title=title(run["scan"]),
        headline="\n".join(headline_lines(run)),
        archive_name=archive_name,
        count=len(data["places"]),
        cautions=cautions(run),
        # within a script, escape whatever could end it, since a file's own text may contain anything
        data=json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
    )


def page_data(run: Run) -> dict[str, Any]:
    """Return the data of the page's script."""
    table = by_place(run)
    places = table or run.get("solutions/direct", xr.Dataset())
    if "scan" not in run or places.sizes.get("subregion", 0) == 0:
        raise Refusal(
            "",
            "the archive of a run, with its scan and results at places",
            f"groups: {', '.join(run) or 'none'}",
            "make one with roughxr run",
        )
    columns = {name: table[column] for name, column in _PULL_OFFS.items() if column in table}
    return {
        "scan": _scan(schema.validate(run["scan"], "scan")),
        "places": _rows(run, places),
        "curves": list(_curves(run, places.sizes["subregion"])),
        "pulls": [
            {"name": n, "label": METHOD_WORDS[n], "values": _numbers(pull.values)} for n, pull in columns.items()
        ],
        "facts": _facts(table),
    }


def _rows(run: Run, places: xr.Dataset) -> list[dict[str, Any]]:
    """Return for each place its position, whether it contains debris, and the share of particles that rest there."""
    count = places.sizes["subregion"]
    flags = debris_flags(run)
    debris = flags.values if flags is not None and flags.size == count else np.zeros(count, bool)
    shares = _numbers(places[SHARE].values) if SHARE in places else [None] * count
    positions = zip(*(places[f"subregion_{axis}"].values.tolist() for axis in "xy"))
    return [
        {"x": x, "y": y, "debris": bool(flag), "share": share} for (x, y), flag, share in zip(positions, debris, shares)
    ]


def _curves(run: Run, count: int) -> Iterator[dict[str, Any]]:
    """Yield the force over displacement from the highest peak by method; the pull-off is a point."""
    touch = run.get("solutions/rigid", xr.Dataset()).get("touch_delta")
    for name, label in METHOD_WORDS.items():
        ds = run.get(f"solutions/{name}", xr.Dataset())
        offset = np.zeros(count)
        if ds.sizes.get("subregion") != count:
            continue
        if ds.attrs.get("datum") == "first_contact":
            if touch is None:
                continue  # its displacements have no common origin
            offset = touch.values
        if "force" in ds and ds.sizes.get("delta", 0) > 1:
            retraction = run.get("solutions/retraction") if name == "direct" else None
            yield {
                "name": name,
                "label": label,
                "events": False,
                "lines": _branch_curves(ds, retraction, offset),
            }
        elif name == "adhesive" and "pull_off_delta" in ds:
            yield {"name": name, "label": label, "events": True, "lines": _events(at_first_preload(ds), offset)}


def _branch_curves(case: xr.Dataset, retraction: xr.Dataset | None, offset: np.ndarray) -> list[list[dict[str, Any]]]:
    """Return force over displacement of each place, a curve for each branch."""
    parts = [case[["force"]].sel(branch=way) for way in BRANCHES] if "branch" in case.dims else [case]
    parts += [] if retraction is None else [retraction]
    return [[_curve(part.isel(subregion=k), shift) for part in parts] for k, shift in enumerate(offset)]


def _curve(place: xr.Dataset, shift: float) -> dict[str, Any]:
    """Return force over displacement of one place, thinned, with its exact pull-off and more points near it."""
    delta = place["delta"].values
    force = place["force"].values
    if "pull_off_delta" in place and np.isfinite(place["pull_off_delta"]):
        pull_off = float(place["pull_off_delta"])
        delta = np.append(delta, pull_off)
        force = np.append(force, -float(place["pull_off_force"]))
        nearest = np.argsort(abs(delta - pull_off), kind="stable")
        near = nearest[np.geomspace(1, delta.size, _POINTS // 2).astype(int) - 1]
        near = np.append(near, delta.size - 1)
    else:
        near = np.array([], int)
    shown = np.union1d(np.arange(0, delta.size, -(-delta.size // _POINTS)), near)
    shown = shown[np.argsort(delta[shown], kind="stable")]
    return {"delta": np.round(delta[shown] + shift, 4).tolist(), "force": _numbers(force[shown])}


def _events(case: xr.Dataset, offset: np.ndarray) -> list[list[dict[str, Any]]]:
    """Return the pull-off of each place as a point."""
    deltas = case["pull_off_delta"].values[:, None] + offset[:, None]
    forces = -case["pull_off_force"].values[:, None]
    return [[{"delta": _numbers(delta), "force": _numbers(force)}] for delta, force in zip(deltas, forces)]


def _facts(table: xr.Dataset) -> list[dict[str, Any]]:
    """Return the columns of the table of places: words, unit, and a value for each place."""
    facts = []
    for name, column in table.data_vars.items():
        label = str(column.attrs.get("long_name", name))
        unit = str(column.attrs.get("units", ""))
        if str(name).endswith("_error"):
            column = (100 * column).round(1)
            label = f"estimated {label.removeprefix('relative ')}"
            unit = "%"
        values = column.values.tolist() if column.dtype.kind in "OUT" else _numbers(column.values.astype(float))
        facts.append({"name": name, "label": label, "unit": unit.removesuffix("1"), "values": values})
    return facts


def _scan(scan: xr.Dataset) -> dict[str, Any]:
    """Return the scan as an image, x to the right and y upwards, with its edges and its colour scale, nm."""
    from matplotlib.image import imsave

    height = scan["height"].transpose("x", "y")
    blocks = {axis: -(-n // _SCAN_PIXELS) for axis, n in height.sizes.items()}
    heights = height.coarsen(blocks, boundary="pad").mean().values
    finite = heights[np.isfinite(heights)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    file = io.BytesIO()
    imsave(file, heights.T, vmin=low, vmax=high, cmap=colour_map("mako"), origin="lower", format="png")
    return {"picture": as_uri(file.getvalue()), "box": extent(scan), "low": low, "high": high}


def _numbers(values: np.ndarray) -> list[float | None]:
    """Return numbers to five digits, None for missing ones."""
    return [float(f"{value:.5g}") if np.isfinite(value) else None for value in np.asarray(values, float).tolist()]
