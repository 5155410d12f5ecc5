"""The report's figures, each as an image inside the page, with a caption."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from ... import statistics
from ...statistics import bootstrap
from ...vocabulary import schema
from .. import figures
from ..figures.style import BLUE, GREY, axes, label_axes, styled
from .beside_measured import COMPARED, MEASURED, prediction
from .coming_off import COMING_OFF, moments_of, remaining
from .humid import HUMIDITY
from .intervals import flagged

Run = Mapping[str, xr.Dataset]

_OVER_HUMIDITY = "Pull-off over humidity"

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


def pictures(run: Run) -> Iterator[Picture]:
    """Yield the figures for which a run holds the groups."""
    for name, drawing in _DRAWINGS.items():
        if drawing.optional and not set(drawing.needs) <= set(run):
            continue
        yield _picture(name, drawing, run)


def budget_picture(run: Run) -> Picture | None:
    """Return the figure of the error budget, None where the run holds none."""
    return _picture("Error budget", _BUDGET, run) if set(_BUDGET.needs) <= set(run) else None


def humidity_picture(run: Run) -> Picture | None:
    """Return the figure of the pull-off over humidity, None where the run holds none."""
    drawing = _DRAWINGS[_OVER_HUMIDITY]
    return _picture(_OVER_HUMIDITY, drawing, run) if set(drawing.needs) <= set(run) else None


def _picture(name: str, drawing: _Drawing, run: Run) -> Picture:
    missing = [group for group in drawing.needs if not any(one in run for one in group.split(" or "))]
    if missing:
        return Picture(name, f"Not drawn: the run holds no {', '.join(missing)}.", "")
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
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


@styled
def _over_humidity(run: Run):
    """Draw the mean pull-off between rigid bodies over humidity, with its interval, the run's own humidity marked."""
    found = run[HUMIDITY]
    mean = bootstrap(found, "pull_off_force", statistics=["mean"]).isel(statistic=0).sel(resampling="block")
    made = axes(None)
    made.fill_between(mean["humidity"], mean["low"], mean["high"], color=BLUE, alpha=0.25, linewidth=0)
    made.plot(mean["humidity"], mean["estimate"], color=BLUE, marker="o")
    made.axvline(float(run["scan"]["humidity"]), color=GREY, linestyle="--")
    made.set_ylim(bottom=0)
    label_axes(made, "humidity", "pull_off_force")
    return made


def _grid(run: Run):
    flags = flagged(run)
    return figures.contact_grid(run["scan"], run["solutions/direct"], highlight=None if flags is None else flags.values)


def _part(run: Run):
    """Draw asperities on the middle part of the scan that holds about a hundred of them."""
    scan, catalogue = run["scan"], run["asperities"]
    share = min(1.0, np.sqrt(100 / catalogue.sizes["asperity"]))
    sizes = [scan.sizes[axis] for axis in ("x", "y")]
    x, y = (slice(int(n * (1 - share) / 2), int(np.ceil(n * (1 + share) / 2))) for n in sizes)
    return figures.asperity_map(scan.isel(x=x, y=y), catalogue)


def _contact(run: Run):
    contact = run["solutions/contact"]
    return figures.pressure_on_topography(contact, run["scan"], subregion=int(contact["subregion"][0]))


def _pulling(run: Run):
    """Draw the superposed forces of all places, each about the displacement of its own pull-off."""
    sweep, at = run["solutions/energy"], run["statistics/energy"]["pull_off_delta"]
    pulling = np.flatnonzero(at.notnull().values)
    if not pulling.size:
        raise ValueError("no place pulls at any displacement that was computed")
    delta, reach = sweep["delta"].values, 0.1 * float(np.ptp(sweep["delta"].values))
    about = np.linspace(-reach, reach, 201)
    force = [
        np.interp(about + float(at[k]), delta, sweep["force"].isel(subregion=k).transpose("delta").values)
        for k in pulling
    ]
    deepest = -float(np.min(force))
    shifted = xr.Dataset({"force": (("subregion", "delta"), force)}, {"delta": about, "subregion": pulling})
    return figures.force_fan(schema.label(shifted), interval=None, force_limits=(-1.2 * deepest, 2 * deepest))


def _loop(run: Run):
    """Draw loading and retraction of a body that yields."""
    both = [run[f"solutions/{way}"][["force"]] for way in ("direct", "retraction")]
    return figures.force_loop(xr.concat(both, xr.Variable("branch", ["loading", "retraction"])))


def _compared(run: Run):
    found = statistics.force_ratio(run["solutions/hertz"], run["solutions/direct"])
    parting = found["parting_delta"].dropna("subregion")
    return figures.method_comparison(found, mark=float(parting.median()) if parting.size else None)


def _rolls_off(run: Run):
    """Draw the critical flow at each place, or the mode where places differ in it."""
    found = run["statistics/detachment"]
    if np.unique(found["mode"].values.astype(str)).size > 1:
        return figures.mode_map(found)
    return figures.subregion_map(found, "critical_friction_velocity")


_BUDGET = _Drawing(
    ("statistics/error_budget",),
    lambda run: figures.error_budget(run["statistics/error_budget"]),
    "By how much the mean pull-off may be off, and from what: one standard deviation each, known to ± one standard "
    "error, with the sign of the change that it is; of what is known to be off, half is left once it is taken off. *: "
    "the change if the roughness went on for another octave; not in the total, which is for the surface as scanned.",
)

_DRAWINGS = {
    "What the pull-off hangs on": _Drawing(
        ("statistics/sensitivity",),
        lambda run: figures.tornado(run["statistics/sensitivity"]),
        "Change of the mean simulated pull-off at a sample of places when one thing is changed, as the bar's end says: "
        "the longer of two bars is the budget's entry.",
    ),
    "Pull-off and the shortest wave": _Drawing(
        ("statistics/shorter_waves",),
        lambda run: figures.cut_off(run["statistics/shorter_waves"]),
        "Simulated pull-off at a sample of places on surfaces that end at another wavelength: right of the dashed line "
        "the scan with its shortest waves cut off, left of it with waves added that continue its spectrum, from seeds; "
        "bars are their scatter.",
    ),
    "The scan and the places": _Drawing(
        ("scan", "asperities", "solutions/direct"),
        _grid,
        "Heights, with the contact centres as crosses and the tiles that hold debris framed.",
    ),
    "Asperities": _Drawing(
        ("scan", "asperities"),
        _part,
        "A part of the scan with its asperities: each ellipse is the fitted paraboloid 0.2 nm below its top.",
    ),
    "Which way asperities are long": _Drawing(
        ("asperities",),
        lambda run: figures.orientation_rose(run["asperities"]),
        "Flattest direction of the asperities. Petal areas tell shares; within the grey ring they are chance.",
    ),
    "One contact": _Drawing(
        ("scan", "solutions/contact"),
        _contact,
        "Pressure of the direct simulation over the undeformed heights (grey), at the place of median force; what has "
        "yielded, where a hardness is given, ringed in blue.",
    ),
    "Elastic force": _Drawing(
        ("solutions/direct",),
        lambda run: figures.force_fan(run["solutions/direct"]),
        "Direct simulation without adhesion: each place, their median with its 95 % interval, bands of places.",
    ),
    "Way in and way out": _Drawing(
        ("solutions/direct", "solutions/retraction"),
        _loop,
        "Mean force of the direct simulation of what yields: the grey between both ways is the work lost.",
        optional=True,
    ),
    "Force with adhesion": _Drawing(
        ("solutions/energy",),
        _pulling,
        "Superposed asperities that adhere (least energy): every place about the displacement at which it lets go, "
        "as far as the push is small.",
    ),
    _OVER_HUMIDITY: _Drawing(
        ("scan", HUMIDITY),
        _over_humidity,
        "Mean pull-off between rigid bodies, not that of the simulation, by the law of thin menisci, with its 95 % "
        "interval; dashed the humidity of the main numbers.",
        optional=True,
    ),
    "Pull-off force": _Drawing(
        ("statistics/energy or statistics/adhesive",),
        lambda run: figures.fitted_distribution(prediction(run)),
        "By the method of the main numbers: histogram with a 95 % interval for each bar, the mean with its own on top, "
        "and fitted laws, the best first; ΔAIC tells how much worse the others are.",
    ),
    "Where it sticks": _Drawing(
        ("statistics/energy or statistics/adhesive",),
        lambda run: figures.subregion_map(prediction(run)),
        "Pull-off force of every place, by the method of the main numbers; grey where nothing pulls.",
    ),
    "Predicted beside measured": _Drawing(
        (MEASURED, COMPARED),
        lambda run: figures.predicted_and_measured(prediction(run), run[MEASURED], found=run[COMPARED]),
        "Left both distributions, right their quantiles against one another: equal on the grey line, and different "
        "by a factor alone along the dashed one.",
        optional=True,
    ),
    "Which way it rolls": _Drawing(
        COMING_OFF,
        lambda run: figures.moment_rose(moments_of(run)),
        "Moment that places resist by the direction in which the sphere begins to roll, at the levers of the "
        "superposed asperities and the pull-off of the main numbers: the median place, and half of all places around "
        "it.",
        optional=True,
    ),
    "Where it comes off": _Drawing(
        COMING_OFF,
        _rolls_off,
        "Friction velocity of air along x that each place stands, or how the sphere comes off where places differ in "
        "that.",
        optional=True,
    ),
    "How many stay": _Drawing(
        COMING_OFF,
        lambda run: figures.fraction_remaining(remaining(run)),
        "Fraction of spheres left after a second in turbulent air by Rock'n'Roll, from the computed moments, with its "
        "95 % band, over the mean friction velocity: bursts of the flow take spheres off well before it reaches the "
        "critical one of a steady flow; dotted where the formulas of drag and torque are stretched.",
        optional=True,
    ),
    "Landed and at rest": _Drawing(
        ("solutions/rolling_landed", "solutions/rolling"),
        lambda run: figures.landed_and_at_rest(run["solutions/rolling_landed"], run["solutions/rolling"]),
        "Pull-off force, asperities in contact and critical friction velocity by superposition, of particles where "
        "they landed and where they then came to rest.",
        optional=True,
    ),
    "Superposition against direct simulation": _Drawing(
        ("solutions/hertz", "solutions/direct"),
        _compared,
        "Both without adhesion: the sum of single asperities over the half space that lets them feel one another. "
        "Dashed: the median displacement from which on they differ by more than 10 %.",
    ),
}
