"""A run as one self-contained page: the answer, its errors, cautions, figures and tables, and how to repeat it."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from .. import archive, figures
from .._version import __version__
from ..bodies import liquid
from ..figures.style import BLUE, GREY, axes, label_axes, styled
from ..scans.regions import extent
from ..statistics import LAWS, bootstrap
from ..statistics.sampling import at_first_preload
from ..vocabulary import schema
from ..vocabulary.numbers import number, percent, quantity
from ..vocabulary.text import printable
from .caveats import cautions
from .command_line import command
from .detachment import COMING_OFF, coming_off_words, detachment_table, moments_of, remaining
from .run_tables import budget_table, contact_table, flagged, formula_table, main_numbers, prediction, scan_table
from .summary import BUDGET, by_place, headline

Run = Mapping[str, xr.Dataset]

#: The pull between rigid bodies over humidity.
HUMIDITY = "statistics/humidity"

#: Dots per inch of the figures.
_DPI = 160


def write_report(path: str | os.PathLike, output: str | os.PathLike | None = None) -> Path:
    """Write a run's archive as one self-contained HTML page.

    Parameters
    ----------
    path : path
        The archive of a run, NetCDF-4, or the folder that `roughxr run` or `paper` made.
    output : path, optional
        The page, by default ``report.html`` beside the archive; it appears under this name once it is complete.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the file contains no group for a report.
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
    path = archive.of_run(Path(path))
    run = {name: ds.load() for name, ds in archive.load(path).items() if ds.data_vars}
    if not set(run) & {"scan", "solutions/direct", "statistics/energy"}:
        groups = ", ".join(run) or "none"
        raise ValueError(f"{path}: expected the archive of a run, found groups: {groups}; make one with roughxr run")
    text = page(run, archive_name=path.name, missing=archive.root_of(path).get(archive.UNFINISHED, ""))
    return written(text, path, output, "report.html")


def page(run: Run, *, archive_name: str = "run.nc", missing: str = "") -> str:
    """Return the page as text."""
    run = {name: schema.entered(ds) for name, ds in run.items()}
    words = [f"The run is not finished, {missing}."] * bool(missing)
    return filled(
        "report.html",
        title=title(run.get("scan", xr.Dataset())),
        archive_name=archive_name,
        version=__version__,
        today=date.today().isoformat(),
        headline=headline(run),
        humid=humid_words(run),
        first=[picture for picture in map(_picture(run), _FIRST) if picture],
        cautions=words + cautions(run),
        facts=facts(run),
        model=_model(run),
        coming_off=coming_off_words(run),
        pictures=[picture for picture in map(_picture(run), _FIGURES) if picture],
        tables=list(_tables(run)),
        command=command(run),
    )


def facts(run: Run) -> list[tuple[str, str]]:
    """Return what was analysed, and the pair of bodies."""
    if "scan" not in run:
        return []
    scan = run["scan"]
    x_low, x_high, y_low, y_high = extent(scan)
    pixels = " × ".join(str(scan.sizes[axis]) for axis in ("x", "y"))
    known = [
        ("file", scan.attrs.get("source_file", "none: synthetic")),
        ("channel", scan.attrs.get("channel", "")),
        ("size", f"{(x_high - x_low) / 1e3:.4g} × {(y_high - y_low) / 1e3:.4g} µm, {pixels} pixels"),
        ("heights", f"{number(scan['height'].min())} … {number(scan['height'].max())} nm"),
        *pair_facts(scan),
        ("places", f"{by_place(run).sizes['subregion']} contact centres" if by_place(run) else ""),
        ("checksum of the heights", scan.attrs.get("input_sha256", "")[:16]),
    ]
    return [(name, str(value)) for name, value in known if value]


def pair_facts(scan: xr.Dataset) -> list[tuple[str, str]]:
    """Return the pair of bodies, by name."""
    names = [str(name) for name in scan.coords]
    units = {name: schema.VARIABLES[name].units.replace("J/m^2", "J/m²").removesuffix("1") for name in names}
    return [
        (schema.VARIABLES[name].long_name, number(value, units[name], digits=5))
        for name, value in schema.travelling(scan).items()
        if value.ndim == 0
    ]


def _model(run: Run) -> str:
    """Return the sentence that recommends a model for the scan and its pair."""
    attrs = run["statistics/regime"].attrs if "statistics/regime" in run else {}
    alone = "" if BUDGET in run else attrs.get("resolved", "")
    return f"{attrs.get('recommendation', '')} {alone}".strip()


def humid_words(run: Run) -> str:
    """Return sentences on the pull-off at the run's humidity and at others; nothing for a dry pair."""
    if "scan" not in run or not schema.is_wet(run["scan"]) or HUMIDITY not in run:
        return ""
    scan, over = run["scan"], run[HUMIDITY]
    own = run.get("statistics/adhesive", over.sel(humidity=float(scan["humidity"]), method="nearest"))
    mean = quantity(float(at_first_preload(own)["pull_off_force"].mean()))
    ends = over["pull_off_force"].isel(humidity=[0, -1]).mean("subregion")
    sentences = [
        f"Mean pull-off at {percent(scan['humidity'])} relative humidity: {mean}.",
        "Between rigid bodies it would be "
        + " and ".join(f"{quantity(float(end))} at {percent(end['humidity'])}" for end in ends)
        + ".",
        f"The thin-meniscus law neglects {percent(over['meniscus_error'].median())} of the pull-off (median place).",
    ]
    return " ".join([*sentences, liquid.described(scan)])


def _tables(run: Run) -> Iterator[tuple[str, list[str], list[list[str]]]]:
    """Yield title, head and rows of each table for which the run has the groups."""
    makers: tuple[tuple[str, Callable[[Run], pd.DataFrame], set[str]], ...] = (
        ("Error budget of the mean pull-off", budget_table, {BUDGET}),
        ("Main numbers", main_numbers, {"statistics/adhesive"}),
        ("Coming off in a flow of air", detachment_table, set(COMING_OFF)),
        ("Contact, by method", contact_table, {"solutions/energy", "statistics/energy", "solutions/direct"}),
        ("Usual formulas", formula_table, {"statistics/formulas"}),
        ("Scan and asperities", scan_table, {"scan", "asperities", "reconstruction"}),
    )
    for name, make, needs in makers:
        if needs <= set(run):
            table = make(run)
            head = [table.index.name or "", *(str(column).replace("_", " ") for column in table.columns)]
            yield name, head, [[str(words), *map(_cell, row)] for words, row in table.iterrows()]


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else number(round(float(value), 12))


class Picture(NamedTuple):
    """A figure on the page."""

    name: str
    caption: str
    source: str  # a data URI; empty where it could not be drawn


class _Figure(NamedTuple):
    name: str
    needs: Sequence[str]
    draw: Callable[[Run], Any]
    caption: str


def _picture(run: Run) -> Callable[[_Figure], Picture | None]:
    """Return what draws a figure of a run, or states why it cannot: nothing touches, nothing pulls, only one place."""

    def draw(figure: _Figure) -> Picture | None:
        from matplotlib import pyplot

        if not set(figure.needs) <= set(run):
            return None
        try:
            drawn, buffer = np.ravel(figure.draw(run))[0].figure, io.BytesIO()
        except ValueError as reason:
            pyplot.close()
            return Picture(figure.name, f"Not drawn: {reason}.", "")
        drawn.savefig(buffer, format="png", dpi=_DPI)
        pyplot.close(drawn)
        return Picture(figure.name, figure.caption, as_uri(buffer.getvalue()))

    return draw


def humidity_picture(run: Run) -> Picture | None:
    """Return the figure of the pull-off over humidity, None for a dry run."""
    return _picture(run)(_OVER_HUMIDITY)


@styled
def _draw_humidity(run: Run):
    """Draw the mean pull-off between rigid bodies over humidity, with its interval, the run's own humidity marked."""
    pull = run[HUMIDITY]
    mean = bootstrap(pull, "pull_off_force", statistics=["mean"]).isel(statistic=0).sel(resampling="block")
    made = axes(None)
    made.fill_between(mean["humidity"], mean["low"], mean["high"], color=BLUE, alpha=0.25, linewidth=0)
    made.plot(mean["humidity"], mean["estimate"], color=BLUE, marker="o")
    made.axvline(float(run["scan"]["humidity"]), color=GREY, linestyle="--")
    made.set_ylim(bottom=0)
    label_axes(made, "humidity", "pull_off_force")
    return made


def _draw_contact(run: Run):
    contact = run["solutions/contact"]
    return figures.field_map(contact, scan=run["scan"], subregion=int(contact["subregion"][0]))


def _draw_critical_flow(run: Run):
    """Draw the critical flow at each place, or the mode where places differ in it."""
    critical = run["statistics/detachment"]
    if np.unique(critical["mode"].values.astype(str)).size > 1:
        return figures.subregion_map(critical, "mode")
    return figures.subregion_map(critical, "critical_friction_velocity")


#: The figures of the first screen.
_FIRST = (
    _Figure(
        "Pull-off force",
        ["statistics/adhesive"],
        lambda run: figures.distribution(prediction(run), laws=tuple(LAWS)),
        "Pull-off force over places, with a 95 % interval for each bar, its mean, and fitted distributions; a larger "
        "ΔAIC is a worse fit.",
    ),
    _Figure(
        "Error budget",
        [BUDGET],
        lambda run: figures.error_budget(run[BUDGET]),
        "Error of the mean pull-off by source, one standard deviation each, ± its standard error; the sign is that of "
        "the change. Known biases are subtracted, and half of each stays as its error.",
    ),
)

_OVER_HUMIDITY = _Figure(
    "Pull-off over humidity",
    ["scan", HUMIDITY],
    _draw_humidity,
    "Mean pull-off between rigid bodies (not of the simulation) by the thin-meniscus law, with its 95 % interval; "
    "dashed: the humidity of this run.",
)

#: The other figures; each is left out where the run lacks a group that it needs.
_FIGURES = (
    _Figure(
        "Pull-off and the shortest wavelength",
        ["statistics/shorter_waves"],
        lambda run: figures.cut_off(run["statistics/shorter_waves"]),
        "Simulated pull-off at a sample of places over the shortest wavelength of the surface: right of the dashed "
        "line the scan without its shortest wavelengths, left of it with random roughness added that continues its "
        "spectrum; error bars are the scatter between random seeds.",
    ),
    _Figure(
        "Where it sticks",
        ["statistics/adhesive"],
        lambda run: figures.subregion_map(prediction(run)),
        "Pull-off force at every place; grey where nothing pulls.",
    ),
    _Figure(
        "The scan and the places",
        ["scan", "solutions/direct"],
        lambda run: figures.scan_map(run["scan"], subregions=run["solutions/direct"], highlight=flagged(run)),
        "Heights; crosses mark the contact centres, rings those on debris.",
    ),
    _Figure(
        "One contact",
        ["scan", "solutions/contact"],
        _draw_contact,
        "Pressure of the direct simulation over the undeformed heights (grey), at the place of median force; where a "
        "hardness is given, yielded pixels are outlined in blue.",
    ),
    _Figure(
        "Elastic force",
        ["solutions/direct"],
        lambda run: figures.sweep(run["solutions/direct"]),
        "Direct simulation without adhesion: all places, their median with its 95 % interval, and bands that contain "
        "half and 90 % of them.",
    ),
    _OVER_HUMIDITY,
    _Figure(
        "Which way it rolls",
        COMING_OFF,
        lambda run: figures.moment_rose(moments_of(run)),
        "Resisting moment over the direction in which the sphere begins to roll: the median place, and the middle "
        "half of all places.",
    ),
    _Figure(
        "Where it comes off",
        COMING_OFF,
        _draw_critical_flow,
        "Critical friction velocity of air along x at each place; or, where places differ in it, whether the sphere "
        "rolls, slides or lifts.",
    ),
    _Figure(
        "Fraction remaining",
        COMING_OFF,
        lambda run: figures.fraction_remaining(remaining(run)),
        "Fraction of spheres that remain after one second in turbulent air, by Rock'n'Roll with the computed moments, "
        "over the mean friction velocity, with its 95 % band. Turbulent bursts remove spheres well below the critical "
        "velocity of a steady flow. Dotted: outside the range of the formulas for drag and torque.",
    ),
)


def filled(template: str, **values: Any) -> str:
    """Return a template of this package, filled; text is escaped for HTML, and its control characters written out."""
    import jinja2

    options: dict[str, Any] = {"autoescape": True, "trim_blocks": True, "lstrip_blocks": True, "finalize": _printable}
    environment = jinja2.Environment(loader=jinja2.PackageLoader("roughxr.report", "web"), **options)
    return environment.get_template(template).render(**values)


def _printable(value: Any) -> Any:
    return printable(value, keep="\n\t") if type(value) is str else value


def written(text: str, path: Path, output: str | os.PathLike | None, name: str) -> Path:
    """Write a page, by default under this name beside its archive, and return its path."""
    output = path.with_name(name) if output is None else Path(output)
    with archive.whole(output) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return output


def as_uri(png: bytes) -> str:
    """Return an image as text that stands inside a page."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def title(scan: xr.Dataset) -> str:
    """Return the title of a page about a scan."""
    return str(scan.attrs.get("title") or scan.attrs.get("source_file") or "A run of roughxr")
