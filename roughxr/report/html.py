"""A run as one self-contained page: what was analysed and how, main numbers with intervals, figures, and caveats."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from .. import archive
from .._version import __version__
from ..scans import level
from ..scans.regions import extent
from ..vocabulary import schema
from ..vocabulary.numbers import interval, number
from .budget import budget_table, humid_words
from .command_line import command
from .detachment_section import COMING_OFF, coming_off_words, detachment_table
from .embedded_figures import picture_of, pictures
from .intervals import interval_table
from .measured_section import COMPARED, MEASURED, compared, measured_table, measured_words
from .run_warnings import cautions
from .summary import BUDGET, headline
from .tables import contact_table, formula_table, scan_table
from .template import filled, title, written

#: How to cite this library, and what it implements.
CITATION = (
    f"roughxr {__version__}: contact mechanics on AFM scans as labelled xarray datasets.",
    "W. Cheng, P. F. Dunn, R. M. Brach: Contact between a smooth microsphere and an anisotropic rough surface, "
    "The Journal of Adhesion 79 (2003) 749–776.",
)


def write_report(
    path: str | os.PathLike, output: str | os.PathLike | None = None, *, measured: xr.Dataset | None = None
) -> Path:
    """Write a run's archive as one self-contained HTML page.

    Parameters
    ----------
    path : path
        The archive of a run, NetCDF-4, or the folder that `roughxr run` or `paper` made.
    output : path, optional
        The page, by default ``report.html`` beside the archive; it appears under this name once it is complete.
    measured : Dataset, optional
        From `open_pull_off`: compared with the run's prediction in a section of its own. An archive may also hold it,
        as its group ``measured/pull_off``.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the file holds no group for a report.
    OSError
        If the file is absent or no NetCDF-4.

    Examples
    --------
    >>> import tempfile, roughxr
    >>> folder = Path(tempfile.mkdtemp())
    >>> scan = roughxr.scans.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> run = {"scan": scan, "asperities": roughxr.asperities(scan)}
    >>> write_report(roughxr.archive.save(run, folder / "run.nc"), folder / "report.html").name
    'report.html'
    """
    measured = schema.entered(measured)
    path = archive.of_run(Path(path))
    run = {name: ds.load() for name, ds in archive.load(path).items() if ds.data_vars}
    if not set(run) & {"scan", "solutions/direct", "statistics/energy"}:
        found = ", ".join(run) or "none"
        raise ValueError(f"{path}: expected the archive of a run, found groups: {found}; make one with roughxr run")
    run = run if measured is None else {**run, MEASURED: measured}
    text = page(run, archive_name=path.name, missing=archive.root_of(path).get(archive.UNFINISHED, ""))
    return written(text, path, output, "report.html")


def page(
    run: Mapping[str, xr.Dataset],
    *,
    archive_name: str = "run.nc",
    folder: Path | None = None,
    missing: str = "",
) -> str:
    """Return the page as text; figures of the budget that a folder holds are taken from there."""
    run = compared(run)
    return filled(
        "roughxr.report",
        title=title(run.get("scan", xr.Dataset())),
        archive_name=archive_name,
        facts=_facts(run),
        cautions=[f"The run is not finished, {missing}."] * bool(missing) + cautions(run),
        numbers=list(_numbers(run)),
        headline=" ".join(filter(None, (headline(run), humid_words(run)))),
        budget=_as_text(budget_table(run))[1] if BUDGET in run else [],
        budget_picture=picture_of("Error budget", run, folder),
        adhesion=_adhesion(run),
        model=_model(run),
        measured=measured_words(run),
        coming_off=coming_off_words(run),
        coming_off_table=_as_text(detachment_table(run)) if set(COMING_OFF) <= set(run) else None,
        pictures=list(pictures(run, folder)),
        tables=_tables(run),
        steps=_steps(run),
        command=command(run),
        citation=CITATION,
        version=__version__,
    )


def _facts(run: Mapping[str, xr.Dataset]) -> list[tuple[str, str]]:
    """Return what was analysed, and the sphere."""
    if "scan" not in run:
        return []
    scan = run["scan"]
    x_low, x_high, y_low, y_high = extent(scan)
    pixels = " × ".join(str(scan.sizes[axis]) for axis in ("x", "y"))
    facts = [
        ("file", scan.attrs.get("source_file", "none: synthetic")),
        ("channel", scan.attrs.get("channel", "")),
        ("size", f"{(x_high - x_low) / 1e3:.4g} × {(y_high - y_low) / 1e3:.4g} µm, {pixels} pixels"),
        ("heights", _heights(scan)),
        *[(schema.VARIABLES[name].long_name, _value(one, name)) for name, one in schema.travelling(scan).items()],
        ("places", _places(run)),
        ("checksum of the heights", scan.attrs.get("input_sha256", "")[:16]),
    ]
    return [(name, str(value)) for name, value in facts if value]


def _heights(scan: xr.Dataset) -> str:
    """Return the range of heights, and for a tilted scan also that about its mean plane."""
    low, high = float(scan["height"].min()), float(scan["height"].max())
    words = f"{number(low)} … {number(high)} nm"
    flat = float(np.ptp(level(schema.label(scan))["height"].values))
    tilted = f", most of it tilt (when levelled {number(flat, 'nm')}): level the scan first"
    return words + (tilted if flat < 0.8 * (high - low) else "")


def _value(one: xr.DataArray, name: str) -> str:
    return number(one, schema.VARIABLES[name].units.replace("J/m^2", "J/m²").removesuffix("1"), digits=5)


def _places(run: Mapping[str, xr.Dataset]) -> str:
    counts = {
        ds.sizes["subregion"] for name, ds in run.items() if "subregion" in ds.sizes and "extrapolated" not in name
    }
    return f"{max(counts)} contact centres" if counts else ""


def _adhesion(run: Mapping[str, xr.Dataset]) -> str:
    """Return the method of the adhesion on the page."""
    if "statistics/adhesive" in run:
        return "Adhesion by direct simulation of approach and retraction."
    return "Adhesion by superposed asperities (least energy)." if "statistics/energy" in run else ""


def _model(run: Mapping[str, xr.Dataset]) -> str:
    """Return the sentence that recommends a model for the scan and its pair."""
    if "statistics/regime" not in run:
        return ""
    said = run["statistics/regime"].attrs
    alone = "" if BUDGET in run else said.get("resolved", "")  # the simulation's own contacts are told above
    return f"{said['recommendation']} {alone}".strip()


def _numbers(run: Mapping[str, xr.Dataset]):
    """Yield the main numbers as they are printed: quantity, places, estimate, intervals, independent places."""
    before = None
    for (quantity, places), row in interval_table(run).iterrows():
        block, naive = (interval(row[low], row[high]) for low, high in (("low", "high"), ("naive low", "naive high")))
        shown = "" if quantity == before else quantity
        before = quantity
        estimate, count = number(round(row["estimate"], 12)), number(row["independent places"], digits=2)
        yield shown, places, estimate, block, naive, count


def _tables(run: Mapping[str, xr.Dataset]) -> list[tuple[str, list[str], list[list[str]]]]:
    """Return the tables of the command line: title, head and rows of text."""
    makers: dict[str, Any] = {
        "Scan and asperities": (scan_table, {"scan", "asperities", "reconstruction"}),
        "Contact, by method": (contact_table, {"solutions/energy", "statistics/energy", "solutions/direct"}),
        "Predicted and measured": (measured_table, {COMPARED}),
        "Usual formulas": (formula_table, {"statistics/formulas"}),
    }
    return [(title, *_as_text(make(run))) for title, (make, needs) in makers.items() if needs <= set(run)]


def _as_text(table: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    head = [table.index.name or "", *(str(column).replace("_", " ") for column in table.columns)]
    return head, [[str(words), *map(_cell, row)] for words, row in table.iterrows()]


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else number(round(float(value), 12))


def _steps(run: Mapping[str, xr.Dataset]) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return the last steps of each group with their arguments, without the steps of earlier groups."""
    known: list = []
    groups = []
    for name, ds in run.items():
        steps = [step for step in schema.history(ds) if step not in known]
        known += steps
        if steps:
            groups.append((name, [(str(step.get("operation")), _arguments(step)) for step in steps]))
    return groups


def _arguments(step: Mapping[str, Any]) -> str:
    arguments = step.get("arguments", {})
    return ", ".join(f"{key} = {_short(value)}" for key, value in arguments.items())


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 120 else text[:117] + "…"
