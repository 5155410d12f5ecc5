"""The interactive page: its content put together, and written."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from ... import archive
from ..._version import __version__
from ...vocabulary import schema
from ...vocabulary.units import whole_number
from ...vocabulary.verbs import verb
from ..budget import humid_words
from ..embedded_figures import picture_of
from ..run_warnings import cautions
from ..summary import headline
from ..template import filled, title, written
from . import images, places
from .contact_maps import contact_maps

#: Largest number of the scan's pixels along a side: more are averaged.
_MOST_PIXELS = 1200


def write_explorer(path: str | os.PathLike, output: str | os.PathLike | None = None, *, loops: int = 16) -> Path:
    """Write a run's archive as one self-contained, interactive HTML page.

    Clicking a place of the scan shows its contact map, its force over displacement and its position among all
    pull-offs. There is a slider for each parameter, such as preload, radius, modulus or work of adhesion, that the
    archive varies.

    Parameters
    ----------
    path : path
        The archive of a run, NetCDF-4, or the folder that `roughxr run` or `paper` made.
    output : path, optional
        The page, by default ``explore.html`` beside the archive; it appears under this name once it is complete.
    loops : int
        Of the simulation with adhesion a run keeps the events, not the states between them. At this many places, spread
        evenly, it is followed again, for a second or more each, to show loop and contact maps; 0: at none.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the file holds no scan, or no results at places of it.
    OSError
        If the file is absent or no NetCDF-4.

    See Also
    --------
    write_report : the same run as a page to read and to print.

    Examples
    --------
    >>> import tempfile, roughxr
    >>> folder = Path(tempfile.mkdtemp())
    >>> scan = roughxr.scans.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40)
    >>> run = {"scan": scan, "solutions/direct": roughxr.direct(scan, delta=[2, 4], subregions=(2, 2))}
    >>> write_explorer(roughxr.archive.save(run, folder / "run.nc")).name
    'explore.html'
    """
    path = archive.of_run(Path(path))
    run = {name: ds for name, ds in archive.load(path).items() if ds.variables}
    try:
        text = explorer_page(run, archive_name=path.name, loops=loops)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return written(text, path, output, "explore.html")


@verb
def explorer_page(run: Mapping[str, xr.Dataset], *, archive_name: str = "run.nc", loops: int = 16) -> str:
    """Return the page as text."""
    told = _page_data(run, whole_number(loops, "loops", least=0))
    return filled(
        "roughxr.report.explorer",
        title=title(run["scan"]),
        headline=headline(run),
        archive_name=archive_name,
        version=__version__,
        count=len(told["places"]),
        cautions=cautions(run),
        humid=humid_words(run),
        humidity_picture=picture_of("Pull-off over humidity", run),
        # within a script, escape whatever could end it, since a file's own text may hold anything
        told=json.dumps(told, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
    )


def _page_data(run: Mapping[str, xr.Dataset], loops: int) -> dict[str, Any]:
    """Return all the data that the page's script shows."""
    if "scan" not in run:
        raise ValueError(
            f"expected the archive of a run, with its scan, found groups: {', '.join(run) or 'none'}; make one with "
            "roughxr run"
        )
    scan = schema.validate(run["scan"], "scan")
    at = places.placed({**run, "scan": scan})
    return {
        "scan": _scan(scan),
        "places": places.rows(at),
        "axes": places.axes([ds for ds in map(at.held, run) if ds is not None]),
        "curves": places.curves(at),
        "events": places.events(at),
        "pulls": places.pull_offs(at),
        "facts": places.facts(at),
        "doubts": places.doubts(at),
        "maps": contact_maps(at, loops=loops),
    }


def _scan(scan: xr.Dataset) -> dict[str, Any]:
    """Return the scan as an image, x to the right and y upwards, with its edges and its colour scale, nm."""
    heights = images.thinned(scan["height"].transpose("x", "y").values, _MOST_PIXELS)
    indices, low, high = images.heights_indices(heights.T[::-1])
    return {
        "picture": images.picture(indices, images.heights_palette()),
        "colours": images.heights_legend(),
        "box": [edge for axis in "xy" for edge in images.edges(scan[axis].values, _MOST_PIXELS)],
        "low": places.number(low),
        "high": places.number(high),
    }
