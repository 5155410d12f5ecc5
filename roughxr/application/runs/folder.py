"""The folder of a run: tables, pictures and pages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from textwrap import fill
from types import MappingProxyType
from typing import Any

import xarray as xr

from ...files.doors import is_own_page
from ...files.storage import atomic_write
from ...mechanics.vocabulary.refusal import Refusal
from .. import report
from ..figures.style import write_png
from ..report.summary import scan_label
from ..tables import table_of, written_formats

#: Tables that are also written as files, by the name of the file.
_TABLE_FILES = {
    "scan": "Scan and asperities",
    "contact": "Pull-off force by method",
    "superposition": "Superposition place by place",
    "force": "Force without adhesion",
}

#: Names of what is written into the folder of a run, of the paper among them.
_NAMES = ("table.txt", "table-*.csv", "places.csv", "places.xlsx", "report.html", "overview.png", "figure-[0-9]*.png")

#: Names of the archive in such a folder.
_ARCHIVES = ("run.nc", "paper.nc")


def refuse_own_files(folder: Path, names: Sequence[str] = _NAMES, archives: Sequence[str] = _ARCHIVES) -> None:
    """Raise if a folder without an earlier output, known by its archive or page, has files of the names of outputs."""
    pages = ("report.html", "index.html")
    if any((folder / name).is_file() for name in archives) or any(is_own_page(folder / name) for name in pages):
        return
    existing = sorted(file.name for name in names for file in folder.glob(name))
    if existing:
        listed = ", ".join(existing)
        raise Refusal("output", "a folder of an earlier run, or one without files of these names", listed)


def write_tables(tables: Mapping[str, Any], printed: str, folder: Path) -> None:
    """Write the tables as text, and some of them as files of their own."""
    with atomic_write(folder / "table.txt", is_own=True) as temporary:
        temporary.write_text(printed, encoding="utf-8")
    for part, title in _TABLE_FILES.items():
        if title in tables:
            with atomic_write(folder / f"table-{part}.csv", is_own=True) as temporary:
                tables[title].to_csv(temporary, float_format="%.6g")


def write_figures(groups: Mapping[str, xr.Dataset], draw_figures: Callable, folder: Path) -> None:
    """Write the figures that a function yields by name."""
    groups["solutions/contact"].load()  # else each of its figures reads the fields from the file again
    for name, figure in draw_figures(groups):
        with atomic_write(folder / f"{name}.png", is_own=True) as temporary:
            write_png(figure, temporary, 220)


def write_pages(groups: Mapping[str, xr.Dataset], tables: Mapping[str, Any], path: Path, folder: Path) -> None:
    """Write the table of places, and the report with the tables of any run."""
    if places := report.by_place(groups):
        for ending in written_formats():
            table_of(report.place_table(places, scan_label(groups)), folder / f"places{ending}", is_own=True)
    with atomic_write(folder / "report.html", is_own=True) as temporary:
        temporary.write_text(report.page(groups, tables, archive_name=path.name), encoding="utf-8")


def notes(run: Mapping[str, xr.Dataset]) -> list[str]:
    """Return the notes below a run's tables."""
    return [*report.superposition_notes(run), *report.detachment_notes(run)]


def tables_text(
    tables: Mapping[str, Any],
    below: Sequence[str],
    answer: str = "",
    *,
    explanations: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Return the answer, the tables, each with its explanation by its title, and the notes below them as text."""
    parts = [fill(answer, 100) + "\n"] if answer else []
    for title, table in tables.items():
        parts.append(report.text(table, title))
        if title in explanations:
            parts.append(fill(explanations[title], 100) + "\n")
    return "\n".join([*parts, *(fill(note, 100) for note in below)]) + "\n"
