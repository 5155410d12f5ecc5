"""The folder of a run: tables, pictures and pages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from textwrap import fill
from types import MappingProxyType
from typing import Any

import xarray as xr

from .. import report
from ..archive import atomic_write
from ..report.summary import scan_label
from ..tables import to_table, written_formats

#: Tables that are also written as files, by the name of the file.
_TABLE_FILES = {
    "scan": "Scan and asperities",
    "contact": "Pull-off force by method",
    "superposition": "Superposition place by place",
    "force": "Force without adhesion",
}


def write_tables(tables: Mapping[str, Any], printed: str, folder: Path) -> None:
    """Write the tables as text, and some of them as files of their own."""
    with atomic_write(folder / "table.txt") as temporary:
        temporary.write_text(printed, encoding="utf-8")
    for part, title in _TABLE_FILES.items():
        if title in tables:
            with atomic_write(folder / f"table-{part}.csv") as temporary:
                tables[title].to_csv(temporary, float_format="%.6g")


def write_figures(groups: Mapping[str, xr.Dataset], draw_figures: Callable, folder: Path) -> None:
    """Write the figures that a function yields by name."""
    groups["solutions/contact"].load()  # else each of its figures reads the fields from the file again
    for name, figure in draw_figures(groups):
        with atomic_write(folder / f"{name}.png") as temporary:
            figure.savefig(temporary, dpi=220)


def write_pages(groups: Mapping[str, xr.Dataset], path: Path, folder: Path) -> None:
    """Write the table of places and the report."""
    if places := report.by_place(groups):
        for ending in written_formats():
            to_table(report.place_table(places, scan_label(groups)), folder / f"places{ending}")
    with atomic_write(folder / "report.html") as temporary:
        temporary.write_text(report.page(groups, archive_name=path.name), encoding="utf-8")


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
