"""Runs of several scans in one folder, with a table of the scans, a table of all places, and a summary page."""

from __future__ import annotations

import glob
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...files.storage import atomic_write
from ...mechanics.jobs.interrupts import is_interrupt
from ...mechanics.jobs.progress import print_line, rough_duration
from ...mechanics.scans.regions import sides
from ...mechanics.statistics import pooled
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.numbers import format_percent, format_quantity
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.table import SCALARS
from .. import report
from ..headline import answer_lines
from ..report.report_page import pair_facts, render_template, setting
from ..report.run_numbers import summary_numbers
from ..report.summary import few_digits, place_table
from ..tables import FORMATS, table_of, written_formats
from ..wording import render_sentence
from ..wording.intervals import value_and_interval, with_interval
from .folder import refuse_own_files
from .stages import TimeLeft

_FORCE = "pull_off_force"

#: The page of all scans.
_PAGE = "index.html"

#: Largest relative difference of sides and pixels between scans that are pooled.
_ALIKE = 0.02


class ScanResult(NamedTuple):
    """The results of one scan that the table and the page of all scans show."""

    setting: dict[str, str]
    pair: dict[str, str]
    size: np.ndarray  # sides and pixel, nm
    summary: xr.Dataset
    places: xr.Dataset
    cautions: list[str]


def table_name(output: Path) -> str:
    """Return the name of the table of scans: the folder's, also where it is given as "." or ".."."""
    return output.resolve().name


def scan_folders(scans: Iterable[str | Path], output: Path) -> dict[Path, Path]:
    """Return an output folder for each scan, named after its file; raise if two files have the same name.

    Raise, too, if the output has files that the tables or the page of all scans would replace.
    """
    chosen: dict[Path, Path] = {}
    reserved = {f"{name}{ending}" for name in ("places", table_name(output)) for ending in FORMATS} | {_PAGE}
    refuse_own_files(output, [glob.escape(name) for name in reserved], archives=())
    for scan in map(Path, scans):
        if scan.stem in reserved:
            raise Refusal(scan, f"another name than that of the runs' {scan.stem}: rename the scan")
        if output / scan.stem in chosen.values():
            raise Refusal(scan, "files of different names", f"two called {scan.stem!r}: rename one")
        chosen[scan] = output / scan.stem
    return chosen


def run_each(scans: Mapping[Path, Path], run_one: Callable[[Path, Path], Mapping[str, xr.Dataset]]):
    """Run each scan, and return the results of those that succeeded and the error messages of the others.

    Called again after an interruption, it resumes.
    """
    finished: dict[str, ScanResult] = {}
    refused: dict[str, str] = {}
    took: dict[str, float] = {}  # s, of scans that were computed from their beginning
    time_left = TimeLeft()
    for count, (scan, folder) in enumerate(scans.items()):
        estimate = ""
        if took:
            last, duration = list(took.items())[-1]
            remaining = sum(took.values()) / len(took) * (len(scans) - count)
            estimate = f", {time_left(remaining, f'{last} took {rough_duration(duration)}')} for all of them"
        print_line(f"scan {count + 1} of {len(scans)}: {scan.name}{estimate}")
        begun = time.monotonic()
        resumed = folder.exists()
        try:
            finished[scan.name] = _scan_result(run_one(scan, folder))
        except Exception as error:
            if is_interrupt(error):
                raise
            is_in_words = isinstance(error, (Refusal, OSError, ImportError))
            refused[scan.name] = str(error) if is_in_words else f"{type(error).__name__}: {error}"
            continue
        if not resumed:
            took[scan.name] = time.monotonic() - begun
    adhering = {name: run for name, run in finished.items() if _FORCE in run.summary}
    without = {name: run.summary.attrs for name, run in finished.items() if name not in adhering}
    refused |= {name: attrs.get("missing", "its run has no pull-off force") for name, attrs in without.items()}
    if not adhering:
        raise Refusal("", "at least one scan with a pull-off", f"none: {'; '.join(refused.values())}")
    return adhering, refused


def _scan_result(run: Mapping[str, xr.Dataset]) -> ScanResult:
    scan = run["scan"]
    size = np.array([*sides(scan), max(schema.pixel(scan))])
    places = report.by_place(run)
    return ScanResult(setting(run), pair_facts(scan), size, report.run_summary(run), places, report.cautions(run))


def write_summary(finished: Mapping[str, ScanResult], refused: Mapping[str, str], output: Path) -> str:
    """Write the tables of scans and of all places, and the summary page; return the pooled mean as scanned in words."""
    pooled_mean = render_sentence("scans.toml", "pooled", _pooled_values(finished))
    with atomic_write(output / _PAGE, is_own=True) as temporary:
        temporary.write_text(_page(finished, refused, output, pooled_mean), encoding="utf-8")
    all_scans = scan_table(finished)
    places = [place_table(run.places, name) for name, run in finished.items()]
    all_places = xr.concat(places, "scan", data_vars="all", coords="minimal")
    for ending in written_formats():  # after the page, by which a later call knows them as its own
        table_of(all_scans, output / f"{table_name(output)}{ending}", is_own=True)
        table_of(all_places, output / f"places{ending}", is_own=True)
    return pooled_mean


def _page(finished: Mapping[str, ScanResult], refused: Mapping[str, str], output: Path, pooled_mean: str) -> str:
    """Return the summary page: the pair of bodies, the pooled mean and a row for each scan."""
    first = next(iter(finished.values()))
    named = {name: first.setting[name] for name in ("materials", "medium") if first.setting[name]}
    rows = [
        (name, Path(name).stem, _cells(run), " ".join(answer_lines(run.summary)), run.cautions)
        for name, run in finished.items()
    ]
    return render_template(
        _PAGE,
        title=f"{len(finished)} scans",
        table=f"{table_name(output)}{written_formats()[-1]}",
        pooled=pooled_mean,
        pair=(named | first.pair).items(),
        fluid=first.summary.attrs.get("fluid", ""),
        rows=rows,
        refused=refused,
    )


def scan_table(finished: Mapping[str, ScanResult]) -> xr.Dataset:
    """Return the pair of bodies and the summary of each scan as a row, without empty columns."""
    out = xr.Dataset(coords={"scan": list(finished)})
    for name in next(iter(finished.values())).setting:
        texts = [run.setting[name] for run in finished.values()]
        if any(texts):
            out[name] = ("scan", texts)
    summaries = [run.summary.reset_coords() for run in finished.values()]
    for name in (*schema.TRAVELLING, *SCALARS):
        values = np.array([float(summary.get(name, np.nan)) for summary in summaries])
        if np.isfinite(values).any():
            is_count = name in SCALARS and (values % 1 == 0).all()
            column = {"low": f"{_FORCE}_low", "high": f"{_FORCE}_high"}.get(name, name)
            column = f"relative_{name}" if name.endswith("_error") else column
            attrs = next(summary[name].attrs for summary in summaries if name in summary)
            out[column] = ("scan", values.astype(int) if is_count else few_digits(values, name), attrs)
        if name == "largest_error" and np.isfinite(values).any():
            out["largest_source"] = ("scan", [run.summary.attrs.get("largest_source", "") for run in finished.values()])
    out["warnings"] = ("scan", [" ".join(run.cautions) for run in finished.values()])
    return out.assign(path=("scan", [f"{Path(name).stem}/report.html" for name in finished]))


def _pooled_values(finished: Mapping[str, ScanResult]) -> dict[str, Any]:
    """Return the mean over scans with its interval and the scatter between scans, if they are of the same size."""
    enough = [run for run in finished.values() if int(run.places[_FORCE].notnull().sum()) > 1]
    if len(enough) < 2:
        return {}
    sizes = np.array([run.size for run in enough])
    if np.ptp(sizes, axis=0).max() > _ALIKE * sizes.max():
        return {"differ": True}
    samples = [run.places[[_FORCE]].where(run.places[_FORCE].notnull(), drop=True) for run in enough]
    numbered = [run.assign_coords(subregion=np.arange(run.sizes["subregion"])) for run in samples]
    all_samples = xr.concat(numbered, "scan", join="outer", data_vars="all", coords="minimal", compat="override")
    pooled_mean = pooled(all_samples, _FORCE, statistics=["mean"]).isel(statistic=0)
    value, low, high = (float(pooled_mean[name]) for name in ("pooled", "pooled_low", "pooled_high"))
    return {
        "scans": len(enough),
        "mean": with_interval(value, low, high),
        "between_std": float(pooled_mean["between_std"]),
    }


def _cells(run: ScanResult) -> list[tuple[str, str]]:
    """Return the row of a scan on the summary page: head and text of each cell."""
    cells = []
    for row in summary_numbers(run.summary):
        text = format_percent(row.value) if row.units == "%" else format_quantity(row.value, row.units)
        if row.note:
            text, interval = value_and_interval(row.value, row.low, row.high, row.units)
        cells.append((row.words, text))
        if row.note:
            cells.append((row.note, interval))
    cells.append(("cautions", str(len(run.cautions))))
    return [(head, text.replace(" ", "\u00a0") if len(text) < 25 else text) for head, text in cells]  # on one line
