"""`paper`, `run`, `report` and `explore`: the analysis of the paper's sample or of scans, and the pages of a run."""

from __future__ import annotations

import webbrowser
from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path

import xarray as xr

from ...files.images.backend import open_scan
from ...files.images.description import describe
from ...mechanics.bodies.pair import assign_pair
from ...mechanics.jobs.spread import use_scheduler
from ...mechanics.scans.editing import on_square_pixels
from ...mechanics.vocabulary.text import without_warnings
from .. import report, reproduction
from ..headline import answer_lines
from ..runs import analysis, several
from .checks import both_counts, stated_pair
from .config import repeating_command
from .file_commands import read_scan
from .options import FLUIDS
from .words import EXPECTED_ERRORS, error_reason, print_error


def paper(options: Namespace) -> None:
    """Repeat the paper's analysis."""
    groups = reproduction.paper(options.output, command=options.line)
    _print_answer(groups, options.output, pictures="figures")


def run(options: Namespace) -> None:
    """Analyse a scan, or each of several."""
    output = Path(options.output)
    if len(options.scan) == 1:
        _print_answer(_run_one(options, options.scan[0], options.output), options.output)
    else:
        _run_each(options, output)


def _run_each(options: Namespace, output: Path) -> None:
    unread: dict[str, str] = {}
    for file in options.scan:  # before minutes are spent on the others
        try:
            without_warnings(describe, file)  # its run warns
        except EXPECTED_ERRORS as error:
            unread[file] = error_reason(error)
            print_error(f"{file}: cannot be read and is left out: {unread[file]}")
    folders = several.scan_folders([file for file in options.scan if file not in unread], output)
    finished, refused = several.run_each(folders, lambda scan, folder: _run_one(options, str(scan), folder))
    pooled_mean = several.write_summary(finished, unread | refused, output)
    for name, reason in refused.items():
        print_error(f"{name}: left out: {reason}")
    table = several.table_name(output)
    print(f"written to {output}: {table}.csv (a row a scan), places.csv, index.html, a folder for each scan")
    left_out = len(unread) + len(refused)
    print(f"{pooled_mean} {left_out} of {len(options.scan)} files were left out.".lstrip() if left_out else pooled_mean)
    for name, run in finished.items():
        print(f"{name}:", *answer_lines(run.summary))


def _run_one(options: Namespace, file: str, output: str | Path) -> Mapping[str, xr.Dataset]:
    scan = paired(on_square_pixels(read_scan(file, options)), options)
    same = ("particle", "delta", "preload", "law", "mesh", "budget", "shortest")
    is_put_together = len(options.scan) > 1 or options.config is not None
    with use_scheduler(options.scheduler):
        return analysis.run(
            scan,
            output,
            subregions=both_counts(options.subregions),
            levelling=options.level,
            finer=read_scan(options.finer, options) if options.finer else None,
            flow=options.fluid or (options.medium if options.medium in FLUIDS else "air"),
            command=repeating_command(options, file, output) if is_put_together else options.line,
            **{name: getattr(options, name) for name in same},
        )


def _print_answer(groups: Mapping[str, xr.Dataset], output: str, pictures: str = "overview.png") -> None:
    """Print the output path of a run, and its answer on the last line."""
    print(f"written to {output}" + f": report.html, places.csv, table.txt, {pictures}" * Path(output).is_dir())
    for sentence in report.headline_lines(groups):
        print(sentence)


def paired(scan: xr.Dataset, options: Namespace) -> xr.Dataset:
    """Return the scan with the pair of bodies of the options; raise where one without a default is missing."""
    pair = stated_pair(options)
    if options.indenter:
        pair["indenter"] = open_scan(options.indenter)
    scan = assign_pair(scan, **pair)
    if options.indenter:
        scan = scan.assign_attrs(indenter_file=Path(options.indenter).name)
    return scan


def write_report(options: Namespace) -> None:
    """Write the report of a finished run."""
    print(f"written to {report.write_report(options.run, options.output)}")


def explore(options: Namespace) -> None:
    """Write the interactive page, and open it on request."""
    page = report.write_explorer(options.run, options.output)
    print(f"written to {page}")
    if options.open:
        webbrowser.open(page.resolve().as_uri())
