"""The report of a run: one self-contained HTML page with its answer, errors, cautions, figures and tables."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import numpy as np
import pandas as pd
import xarray as xr

from ..._version import __version__
from ...files.doors import refuse_other_page, refuse_place
from ...files.storage import atomic_write
from ...mechanics.scans.regions import sides
from ...mechanics.statistics import LAWS
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.error_sources import error_table
from ...mechanics.vocabulary.numbers import format_number, format_percent
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.text import printable
from .. import archive, figures
from ..figures.maps import critical_map
from ..figures.style import write_png
from ..sentences import liquid_words
from ..wording import names_in_words, render_sentence, render_sentences
from .caveats import cautions
from .detachment import detachment_notes, remaining_fraction
from .run_numbers import METHOD_WORDS, debris_flags, prediction, run_moments
from .run_tables import run_errors, tables
from .summary import (
    BUDGET,
    DETACHMENT,
    best_estimate_notes,
    by_place,
    critical_flow,
    headline_lines,
    run_fluid,
    run_summary,
)

Run = Mapping[str, xr.Dataset]

#: The facts of the page before and after those of the pair of bodies, by their names in `facts.toml`.
_SCAN_FACTS = (
    "file",
    "channel",
    "instrument",
    "measured",
    "size",
    "pixel",
    "levelling",
    "heights",
    "roughness S_q",
    "materials",
    "medium",
)
_RUN_FACTS = (
    "law of adhesion",
    "mesh",
    "preload",
    "places",
    "Tabor's parameter, median asperity",
    "simplest valid model",
)

#: Least error that is named among the sources of an interval, of the mean.
_NAMED_ERROR = 0.005

#: Dots per inch of the figures.
_DPI = 160


@archive.checked_names
def write_report(path: str | os.PathLike, output: str | os.PathLike | None = None) -> Path:
    """Write a run's archive as one self-contained HTML page, and return its path.

    Parameters
    ----------
    path : path
        The archive of a run, NetCDF-4, or the folder that `roughxr run` or `paper` made.
    output : path, optional
        The page, by default ``report.html`` beside the archive; it appears under this name once it is complete.

    Examples
    --------
    >>> import contextlib, io, pathlib, tempfile
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    >>> scan = scan.contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0)
    >>> with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
    ...     groups = roughxr.run(scan, folder + "/run.nc", subregions=(2, 1), delta=[1.0, 2.0])
    ...     page = roughxr.report.write_report(folder + "/run.nc")
    >>> page.name
    'report.html'
    """
    path = archive.run_archive(Path(path))
    output = page_path(path, output, "report.html")
    run = {name: ds.load() for name, ds in archive.load(path).items() if ds.data_vars}
    if not set(run) & {"scan", "solutions/direct", "statistics/energy"}:
        groups = ", ".join(run) or "none"
        raise Refusal(path, "the archive of a run", f"groups: {groups}", "make one with roughxr run")
    text = page(run, archive_name=path.name, missing=archive.root_attributes(path).get(archive.UNFINISHED, ""))
    return write_page(text, output)


def page(
    run: Run, run_tables: Mapping[str, pd.DataFrame] | None = None, *, archive_name: str = "run.nc", missing: str = ""
) -> str:
    """Return the page as text, with the tables of the run where they are known already."""
    run = {name: schema.in_package_units(ds) for name, ds in run.items()}
    return render_template(
        "report.html",
        title=title(run.get("scan", xr.Dataset())),
        archive_name=archive_name,
        headline="\n".join(headline_lines(run)),
        humid=liquid_words(run["scan"]) if "scan" in run else "",
        best=best_estimate_notes(run),
        first=_pictures(run, _FIRST),
        cautions=[f"The run is not finished, {missing}."] * bool(missing) + cautions(run),
        facts=_facts(run).items(),
        methods=methods(run),
        detachment=detachment_notes(run),
        pictures=_pictures(run, _FIGURES),
        tables=[(name, *_rows(table)) for name, table in (run_tables or tables(run)).items()],
        command=run_summary(run).attrs.get("command", ""),
        calls=_calls(run_summary(run)),
    )


def _calls(summary: xr.Dataset) -> str:
    """Return the calls that made a run, one a line."""
    calls = []
    for step in schema.history(summary):
        arguments = ", ".join(f"{name}={value!r}" for name, value in step["arguments"].items())
        calls.append(f"{step['operation']}({arguments})")
    return "\n".join(calls)


def _facts(run: Run) -> dict[str, str]:
    """Return the facts of the page by their names: scan, pair of bodies, simulation, and recommended model."""
    if "scan" not in run:
        return {}
    values = {**_scan_values(run["scan"]), **_simulation_values(run)}
    before, after = (
        {name: render_sentence("facts.toml", name, values) for name in names} for names in (_SCAN_FACTS, _RUN_FACTS)
    )
    return {name: text for name, text in (before | pair_facts(run["scan"]) | after).items() if text}


def _scan_values(scan: xr.Dataset) -> dict[str, Any]:
    """Return the values of the facts about a scan."""
    header = dict(line.split(": ", 1) for line in str(scan.attrs.get("header", "")).splitlines() if ": " in line)
    along_x, along_y = sides(scan)
    pixel = schema.pixel(scan)
    return {
        "source_file": scan.attrs.get("source_file"),
        "channel_name": scan.attrs.get("channel"),
        "instrument_name": header.get("instrument.name"),
        "acquisition_time": header.get("acquisition_time"),
        "width": along_x / 1e3,
        "depth": along_y / 1e3,
        "columns": scan.sizes["x"],
        "rows": scan.sizes["y"],
        "is_oblong": pixel[0] != pixel[1],
        "shorter_side": min(pixel),
        "longer_side": max(pixel),
        "background": scan.attrs.get("levelling"),
        "lowest": scan["height"].min(),
        "highest": scan["height"].max(),
        "material_names": scan.attrs.get("materials"),
        "medium_name": scan.attrs.get("medium"),
    }


def _simulation_values(run: Run) -> dict[str, Any]:
    """Return the values of the facts about roughness, recommended model, places and the simulation with adhesion."""
    regime = run.get("statistics/regime", xr.Dataset())
    recommended = str(regime["recommended"].item()) if "recommended" in regime else ""
    count = by_place(run).sizes.get("subregion")
    values = {
        "s_q": run.get("statistics/roughness", xr.Dataset()).get("s_q"),
        "asperity_tabor": regime.get("asperity_tabor"),
        "model": names_in_words("model").get(recommended),
        "number_of_places": count,
        "several_places": count is not None and count > 1,
    }
    if "solutions/adhesive" not in run:
        return values
    solved = run["solutions/adhesive"]
    cells = solved["mesh"].values
    fewest_cells = cells[cells > 0].min(initial=cells.max())
    return {
        **values,
        "law": solved.attrs["law"],
        "adhesion_length_nm": solved.attrs.get("adhesion_length_nm"),
        "by_front": not cells.max(),
        "is_refined": fewest_cells < cells.max(),
        "fewest_cells": fewest_cells,
        "most_cells": cells.max(),
        "preload_force": float(solved.attrs.get("preload", 0.0)),
        "independent_places": run_summary(run).get("independent_places"),
    }


def setting(run: Run) -> dict[str, str]:
    """Return what distinguishes a run from others in a sheet: label, date, materials, medium and fluid."""
    scan = run["scan"]
    ended = run["log"]["time"].values[-1:].tolist() if "log" in run else []
    return {
        "label": title(scan),
        "date": str(ended[0])[:10] if ended else "",
        "materials": scan.attrs.get("materials", ""),
        "medium": scan.attrs.get("medium", ""),
        "fluid": run_fluid(run),
    }


def methods(run: Run) -> str:
    """Return a paragraph on the methods of a run, for a publication; empty without a simulation with adhesion."""
    facts = _facts(run)
    if "law of adhesion" not in facts:
        return ""
    scan = run["scan"]
    values: dict[str, Any] = {**schema.pair_coordinates(scan), **facts}
    values["version"] = __version__
    values["levelling_words"] = names_in_words("levelling").get(scan.attrs.get("levelling", ""))
    values["preload_force"] = float(run["solutions/adhesive"].attrs.get("preload", 0.0))
    values["errors"] = _errors_in_words(run)
    opening = render_sentences("notes.toml", ["methods"], values)
    return " ".join(
        [*opening, *best_estimate_notes(run), *render_sentences("notes.toml", ["sources", "intervals"], values)]
    )


def _errors_in_words(run: Run) -> str:
    """Return the sources of the interval with their standard deviations, the largest first; empty without a budget."""
    if BUDGET not in run:
        return ""
    errors = {name: error.std for name, error in run_errors(run).items() if error.std > _NAMED_ERROR}
    largest_first = sorted(errors, key=errors.__getitem__, reverse=True)
    words = names_in_words("error")
    return ", ".join(f"{words.get(name, name)} ({format_percent(errors[name])})" for name in largest_first)


def pair_facts(scan: xr.Dataset) -> dict[str, str]:
    """Return the quantities of the pair of bodies in words, each with its value."""
    values = {str(name): value for name, value in schema.pair_coordinates(scan).items() if value.ndim == 0}
    units = {name: schema.VARIABLES[name].units.replace("J/m^2", "J/m²").removesuffix("1") for name in values}
    facts = {schema.VARIABLES[name].long_name: format_number(values[name], units[name]) for name in values}
    if "hamaker_constant" in values:
        facts[schema.VARIABLES["hamaker_constant"].long_name] = format_number(1e3 * values["hamaker_constant"], "zJ")
    return facts


def _rows(table: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Return the head and the rows of a table as text."""
    head = [table.index.name or "", *(METHOD_WORDS.get(str(column), str(column)) for column in table.columns)]
    cells = table.map(lambda value: value if isinstance(value, str) else format_number(round(float(value), 12)))
    return head, [[str(label), *row] for label, row in cells.iterrows()]


class _Figure(NamedTuple):
    name: str
    needs: Sequence[str]
    draw: Callable[[Run], Any]
    caption: str


def _pictures(run: Run, figures: Sequence[_Figure]) -> list[dict[str, str]]:
    """Return the figures for which a run has the groups as data URIs, or the reason why one cannot be drawn."""
    from matplotlib import pyplot

    pictures = []
    for name, needs, draw, caption in figures:
        if not set(needs) <= set(run):
            continue
        try:
            drawn = np.ravel(draw(run))[0].figure
            buffer = io.BytesIO()
            write_png(drawn, buffer, _DPI)
            pictures.append({"name": name, "caption": caption, "source": as_uri(buffer.getvalue())})
        except Refusal as refusal:  # such as nothing touches, or only one place
            pictures.append({"name": name, "caption": f"Not drawn: {refusal}.", "source": ""})
        pyplot.close()
    return pictures


#: The figures of the first screen.
_FIRST = (
    _Figure(
        "Pull-off force",
        ["statistics/adhesive"],
        lambda run: figures.distribution(prediction(run), laws=tuple(LAWS)),
        "Distribution of the pull-off force over places, above it the mean with its 95 % interval. From ten places on: "
        "an interval for each bar, and fitted distributions; a larger ΔAIC is a worse fit.",
    ),
    _Figure(
        "One contact at pull-off",
        ["scan", "solutions/pull_off_contact"],
        lambda run: figures.field_map(run["solutions/pull_off_contact"], scan=run["scan"]),
        "Pressure (red) and tension (blue) of the simulation with adhesion over the undeformed heights (grey), at the "
        "place of median pull-off force.",
    ),
    _Figure(
        "Error budget",
        [BUDGET],
        lambda run: figures.error_budget(error_table(run_errors(run))),
        "Error of the mean pull-off by source, one standard deviation of ln(mean) each (the intervals above are at "
        "95 %), ± its standard error; the sign is that of the change. Known biases are subtracted from the mean, and a "
        "part of each counts as error. Unseen roughness is that finer than the scan.",
    ),
)

#: The other figures; each is left out where the run lacks a group that it needs.
_FIGURES = (
    _Figure(
        "Pull-off and the pixel",
        ["statistics/extrapolated"],
        lambda run: figures.force_over_pixel(run["statistics/extrapolated"]),
        "Mean pull-off force as scanned, and on every second and fourth pixel of the scan at up to nine of the places; "
        "left of them the real surface with its 95 % interval.",
    ),
    _Figure(
        "Pull-off force by place",
        ["statistics/adhesive"],
        lambda run: figures.subregion_map(prediction(run)),
        "Pull-off force at every place; grey where the sphere does not adhere.",
    ),
    _Figure(
        "The scan and the places",
        ["scan", "solutions/direct"],
        lambda run: figures.scan_map(run["scan"], subregions=run["solutions/direct"], highlight=debris_flags(run)),
        "Heights; crosses mark the contact centres, rings those on debris.",
    ),
    _Figure(
        "One contact without adhesion",
        ["scan", "solutions/contact"],
        lambda run: figures.field_map(run["solutions/contact"], scan=run["scan"]),
        "Pressure of the direct simulation over the undeformed heights (grey), at the place of median force; where a "
        "hardness is given, yielded pixels are outlined in blue.",
    ),
    _Figure(
        "Elastic force",
        ["solutions/direct"],
        lambda run: figures.sweep(run["solutions/direct"]),
        "Direct simulation without adhesion: all places, their median, and bands that contain half and 90 % of them.",
    ),
    _Figure(
        "Resisting moment by direction",
        DETACHMENT,
        lambda run: figures.moment_rose(run_moments(run)),
        "Resisting moment over the direction in which the sphere begins to roll: the median place, the middle half of "
        "all places, and the median of all directions (dashed).",
    ),
    _Figure(
        "Critical flow by place",
        DETACHMENT,
        lambda run: critical_map(critical_flow(run)),
        "Critical friction velocity of the flow along x at each place; or, if places differ in this, whether the "
        "sphere rolls, slides or lifts first.",
    ),
    _Figure(
        "Fraction remaining",
        DETACHMENT,
        lambda run: figures.fraction_remaining(remaining_fraction(run)),
        "Fraction of spheres that remain after one second in turbulent flow, by Rock'n'Roll with the computed moments, "
        "over the mean friction velocity, with its 95 % band. Turbulent bursts remove spheres well below the critical "
        "velocity of a steady flow. Dotted: outside the range of the formulas for drag and torque.",
    ),
)


def render_template(template: str, **values: Any) -> str:
    """Return a rendered template of this package; text is escaped for HTML, and its control characters written out."""
    import jinja2

    options: dict[str, Any] = {"autoescape": True, "trim_blocks": True, "lstrip_blocks": True}
    options["finalize"] = lambda value: printable(value, keep="\n\t") if type(value) is str else value
    environment = jinja2.Environment(loader=jinja2.PackageLoader("roughxr.application.report", "web"), **options)
    environment.filters["address"] = address
    made = {"version": __version__, "today": date.today().isoformat()}
    return environment.get_template(template).render(**made, **values)


def address(path: str) -> str:
    """Return the address of a file below a page's folder: its name is neither a scheme, a query nor a fragment."""
    return "./" + quote(path, errors="surrogateescape")


def page_path(path: Path, output: str | os.PathLike | None, name: str) -> Path:
    """Return the path of a page, by default ``name`` beside its archive; raise if it is that of another file."""
    output = path.with_name(name) if output is None else Path(output)
    refuse_place(output)
    refuse_other_page(output)  # before the page is made
    return output


def write_page(text: str, output: Path) -> Path:
    """Write a page, and return its path."""
    with atomic_write(output) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return output


def as_uri(png: bytes) -> str:
    """Return an image as a data URI."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def title(scan: xr.Dataset) -> str:
    """Return the title of a page about a scan."""
    return str(scan.attrs.get("title") or scan.attrs.get("source_file") or "A run of roughxr")
