"""The report's figures, each as an image inside the page, with a caption."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from .. import figures, statistics
from ..figures.style import BLUE, GREY, axes, label_axes, styled
from ..statistics import bootstrap
from ..vocabulary import schema
from .budget import BUDGET, HUMIDITY
from .detachment_section import COMING_OFF, moments_of, remaining
from .intervals import flagged
from .measured_section import COMPARED, MEASURED, prediction
from .template import as_uri

Run = Mapping[str, xr.Dataset]

#: Dots per inch: sharp on a dense screen and on paper at one column's width.
_DPI = 220


class Picture(NamedTuple):
    """A figure on the page."""

    name: str
    caption: str
    source: str  # a data URI; empty where it could not be drawn


class _Drawing(NamedTuple):
    needs: tuple[str, ...]
    draw: Callable[[Run], object]
    caption: str
    optional: bool = False  # left out silently where the run has no such groups
    file: str = ""  # the same figure among the files of a run


def pictures(run: Run, folder: Path | None = None) -> Iterator[Picture]:
    """Yield the figures for which a run holds the groups; those that a folder holds are not drawn again."""
    for name, drawing in _DRAWINGS.items():
        if drawing.optional and not set(drawing.needs) <= set(run):
            continue
        yield _picture(name, drawing, run, folder)


def picture_of(name: str, run: Run, folder: Path | None = None) -> Picture | None:
    """Return one of the figures, None where the run does not hold what it needs."""
    drawing = {"Error budget": _BUDGET, **_DRAWINGS}[name]
    return _picture(name, drawing, run, folder) if set(drawing.needs) <= set(run) else None


def _picture(name: str, drawing: _Drawing, run: Run, folder: Path | None) -> Picture:
    missing = [group for group in drawing.needs if not any(one in run for one in group.split(" or "))]
    if missing:
        return Picture(name, f"Not drawn: the run holds no {', '.join(missing)}.", "")
    if folder and drawing.file:
        return Picture(name, drawing.caption, as_uri((folder / drawing.file).read_bytes()))
    return _drawn(name, drawing, run)


def _drawn(name: str, drawing: _Drawing, run: Run) -> Picture:
    """Return a figure, or the reason why there is none: nothing touched, nothing pulled, only one place."""
    from matplotlib import pyplot

    try:
        return Picture(name, drawing.caption, _embedded(drawing.draw(run)))
    except ValueError as reason:
        pyplot.close()
        return Picture(name, f"Not drawn: {reason}.", "")


def _embedded(ax) -> str:
    """Return a figure as a data URI, and close it."""
    from matplotlib import pyplot

    figure, buffer = np.ravel(ax)[0].figure, io.BytesIO()
    figure.savefig(buffer, format="png", dpi=_DPI)
    pyplot.close(figure)
    return as_uri(buffer.getvalue())


@styled
def _over_humidity(run: Run):
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


def _grid(run: Run):
    flags = flagged(run)
    return figures.scan_map(run["scan"], subregions=run["solutions/direct"], highlight=flags)


def _part(run: Run):
    """Draw asperities on the middle part of the scan that holds about a hundred of them."""
    scan, catalogue = run["scan"], run["asperities"]
    share = min(1.0, np.sqrt(100 / catalogue.sizes["asperity"]))
    sizes = [scan.sizes[axis] for axis in ("x", "y")]
    x, y = (slice(int(n * (1 - share) / 2), int(np.ceil(n * (1 + share) / 2))) for n in sizes)
    return figures.scan_map(scan.isel(x=x, y=y), catalogue=catalogue)


def _contact(run: Run):
    contact = run["solutions/contact"]
    return figures.field_map(contact, scan=run["scan"], subregion=int(contact["subregion"][0]))


def _pulling(run: Run):
    """Draw the superposed forces of all places, each about the displacement of its own pull-off."""
    sweep, at = run["solutions/energy"], run["statistics/energy"]["pull_off_delta"]
    pulling = np.flatnonzero(at.notnull().values)
    if not pulling.size:
        raise ValueError("no place pulls at any of the displacements")
    delta, reach = sweep["delta"].values, 0.1 * float(np.ptp(sweep["delta"].values))
    about = np.linspace(-reach, reach, 201)
    force = [
        np.interp(about + float(at[k]), delta, sweep["force"].isel(subregion=k).transpose("delta").values)
        for k in pulling
    ]
    deepest = -float(np.min(force))
    shifted = xr.Dataset({"force": (("subregion", "delta"), force)}, {"delta": about, "subregion": pulling})
    made = figures.sweep(schema.label(shifted))
    made.set(yscale="linear", ylim=(-1.2 * deepest, 2 * deepest))
    return made


def _loop(run: Run):
    """Draw loading and retraction of a body that yields."""
    both = [run[f"solutions/{way}"][["force"]] for way in ("direct", "retraction")]
    return figures.sweep(xr.concat(both, xr.Variable("branch", ["loading", "retraction"])))


def _compared(run: Run):
    return figures.force_ratio(statistics.force_ratio(run["solutions/hertz"], run["solutions/direct"]))


def _rolls_off(run: Run):
    """Draw the critical flow at each place, or the mode where places differ in it."""
    critical = run["statistics/detachment"]
    if np.unique(critical["mode"].values.astype(str)).size > 1:
        return figures.subregion_map(critical, "mode")
    return figures.subregion_map(critical, "critical_friction_velocity")


_BUDGET = _Drawing(
    (BUDGET,),
    lambda run: figures.error_budget(run[BUDGET]),
    "Error of the mean pull-off by source, one standard deviation each, ± its standard error; the sign is that of the "
    "change. Known biases are subtracted, and half of each stays as its error. *: change if the roughness extrapolated "
    "for another octave below the scan; not part of the total, which is for the surface as scanned.",
    file="error-budget.png",
)

_DRAWINGS = {
    "Pull-off and the shortest wave": _Drawing(
        ("statistics/shorter_waves",),
        lambda run: figures.cut_off(run["statistics/shorter_waves"]),
        "Simulated pull-off at a sample of places over the shortest wavelength of the surface: right of the dashed "
        "line the scan without its shortest waves, left of it with random waves added that continue its spectrum; "
        "error bars are the scatter between random seeds.",
        file="shortest-wave.png",
    ),
    "The scan and the places": _Drawing(
        ("scan", "asperities", "solutions/direct"),
        _grid,
        "Heights; crosses mark the contact centres, rings those on debris.",
    ),
    "Asperities": _Drawing(
        ("scan", "asperities"),
        _part,
        "A part of the scan with its asperities: each ellipse is the fitted paraboloid 0.2 nm below its top.",
    ),
    "Statistics of the asperities": _Drawing(
        ("asperities",),
        lambda run: figures.asperity_statistics(run["asperities"]),
        "Heights, ratio of the principal curvatures, axis ratio of the contact ellipse and direction of its long axis; "
        "deviations from the uniform density within the grey band are due to chance.",
    ),
    "One contact": _Drawing(
        ("scan", "solutions/contact"),
        _contact,
        "Pressure of the direct simulation over the undeformed heights (grey), at the place of median force; where a "
        "hardness is given, yielded pixels are outlined in blue.",
    ),
    "Elastic force": _Drawing(
        ("solutions/direct",),
        lambda run: figures.sweep(run["solutions/direct"]),
        "Direct simulation without adhesion: all places, their median with its 95 % interval, and bands that contain "
        "half and 90 % of them.",
    ),
    "Loading and retraction": _Drawing(
        ("solutions/direct", "solutions/retraction"),
        _loop,
        "Mean force of the direct simulation with yield; the grey area is the work lost.",
        optional=True,
    ),
    "Force with adhesion": _Drawing(
        ("solutions/energy",),
        _pulling,
        "Superposed adhesive asperities (least energy): the force at every place, each counted from the displacement "
        "of its own pull-off.",
    ),
    "Pull-off over humidity": _Drawing(
        ("scan", HUMIDITY),
        _over_humidity,
        "Mean pull-off between rigid bodies (not of the simulation) by the thin-meniscus law, with its 95 % interval; "
        "dashed: the humidity of this run.",
        optional=True,
    ),
    "Pull-off force": _Drawing(
        ("statistics/energy or statistics/adhesive",),
        lambda run: figures.distribution(prediction(run), laws=tuple(statistics.LAWS)),
        "Histogram with a 95 % interval for each bar, the mean with its interval on top, and fitted distributions, "
        "the best first; a larger ΔAIC is a worse fit. Same method as the main numbers.",
    ),
    "Where it sticks": _Drawing(
        ("statistics/energy or statistics/adhesive",),
        lambda run: figures.subregion_map(prediction(run)),
        "Pull-off force at every place, by the method of the main numbers; grey where nothing pulls.",
    ),
    "Predicted and measured": _Drawing(
        (MEASURED, COMPARED),
        lambda run: figures.predicted_and_measured(prediction(run), run[MEASURED], comparison=run[COMPARED]),
        "Left: both distributions. Right: measured over predicted quantiles, which are equal on the grey line and "
        "differ by a constant factor on the dashed line.",
        optional=True,
    ),
    "Which way it rolls": _Drawing(
        COMING_OFF,
        lambda run: figures.moment_rose(moments_of(run)),
        "Resisting moment over the direction in which the sphere begins to roll: the median place, and the middle "
        "half of all places. Lever arms are those of the simulation's contacts (of superposed asperities in humid "
        "air), pull-off forces those of the main numbers.",
        optional=True,
    ),
    "Where it comes off": _Drawing(
        COMING_OFF,
        _rolls_off,
        "Critical friction velocity of air along x at each place; or, where places differ in it, whether the sphere "
        "rolls, slides or lifts.",
        optional=True,
    ),
    "Fraction remaining": _Drawing(
        COMING_OFF,
        lambda run: figures.fraction_remaining(remaining(run)),
        "Fraction of spheres that remain after one second in turbulent air, by Rock'n'Roll with the computed moments, "
        "over the mean friction velocity, with its 95 % band. Turbulent bursts remove spheres well below the critical "
        "velocity of a steady flow. Dotted: outside the range of the formulas for drag and torque.",
        optional=True,
    ),
    "Superposition against direct simulation": _Drawing(
        ("solutions/hertz", "solutions/direct"),
        _compared,
        "Force of superposed single asperities over that of the direct simulation, in which asperities interact; both "
        "without adhesion. Dashed: the median displacement beyond which they differ by more than 10 %.",
    ),
}
