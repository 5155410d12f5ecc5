"""The figures of Cheng, Dunn & Brach (2–16) from one run, and one that tests their conclusion."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.bodies.pair_record import read_pair
from ...mechanics.contact import reference
from ...mechanics.scans import regions
from ...mechanics.statistics.sampling import counted_equally
from ...mechanics.vocabulary.adhesion_laws import HERTZ
from .. import figures
from ..figures.distributions import FEWEST_SAMPLES
from ..figures.style import (
    BLACK,
    BLUE,
    GREY,
    SMALL,
    VERMILION,
    axes,
    label_axes,
    label_axis,
    legend,
    log_ticks,
    panels,
    stroke,
    styled,
    ticks_in_unit,
)
from .conclusion import SIMULATION, has_simulation, pull_off_ratio, states_at_pull_off

Run = Mapping[str, xr.Dataset]

#: Methods of figure 16 and their labels: the paper's formulas, those corrected, and the simulation, not in the paper.
_METHODS = {"published": "published", "self_similar": "corrected", "energy": "least energy", "adhesive": "simulation"}

#: The figure that tests the paper's conclusion.
_BY_PLACE = "superposition-by-place"

#: Quantities of an asperity in JKR's units: variable, unit and label.
_IN_UNITS = {
    "a": ("semi_axis_a", "unit_semi_axis", "contact radius $a/a_c$"),
    "delta": ("delta", "unit_delta", r"displacement $\delta/\delta_c$"),
    "P": ("force", "unit_force", "force $P/P_c$"),
}

#: The paper's pull-off force of the smooth sphere, nN.
_SMOOTH = 19.1e3

#: The paper's pull-off force of figure 15's place, nN.
_PLACE = 8.6e3

#: Mean of the paper's figure 16, nN.
_MEAN = 2.0e3

#: Standard deviation of the paper's figure 16, nN.
_STD = 1.37e3


def paper_figures(run: Run, names: Iterable[str] | None = None) -> Iterator[tuple[str, object]]:
    """Yield name and Figure of the paper's figures 2–16 and, with a simulation, of the test of its conclusion.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run by `paper`.
    names : iterable of str, optional
        Such as ``["figure-14"]``; by default all.
    """
    from matplotlib import pyplot

    run = {name: counted_equally(ds) for name, ds in run.items()}  # as in the paper
    drawable = [name for name in FIGURES if name != _BY_PLACE or has_simulation(run)]
    for name in drawable if names is None else names:
        title, draw = FIGURES[name]
        figure = np.ravel(styled(draw)(run))[0].figure
        numbered = title if name == _BY_PLACE else f"Figure {int(name[-2:])}. {title}"
        lines = textwrap.wrap(numbered, 46)
        figure.set_figheight(figure.get_figheight() + 0.16 * len(lines))
        figure.suptitle("\n".join(lines), x=0.015, ha="left", fontsize=8, fontweight="bold")
        pyplot.close(figure)
        yield name, figure


def _asperity_curves(run: Run) -> Iterator[dict[str, np.ndarray]]:
    """Yield the states of one asperity by JKR, from its unstable end, and by Hertz, in JKR's own units."""
    pair = read_pair(run["scan"])
    sphere: dict[str, Any] = {"radius": pair.sphere_radius, "contact_modulus": pair.contact_modulus}
    units = reference.jkr_paraboloid([0.0], **sphere, work_of_adhesion=pair.work)
    delta = float(units["unit_delta"]) * np.linspace(0, 1.675, 401) ** 2 + units.attrs["branch_end"]
    branches = reference.jkr_paraboloid(delta, **sphere, work_of_adhesion=pair.work)[["force", "semi_axis_a"]]
    stable, unstable = (branches.sel(branch=name, drop=True) for name in ("stable", "unstable"))
    path = [unstable.isel(delta=slice(None, None, -1)), stable]
    curve = xr.concat(path, "delta", coords="minimal", compat="override").dropna("delta")
    for contact in (curve, reference.hertz(delta[delta > 0], **sphere)):
        yield {name: (contact[variable] / units[unit]).values for name, (variable, unit, _) in _IN_UNITS.items()}


def _asperity(run: Run, x: str, y: str):
    """Draw one asperity's curves by Hertz and JKR, in JKR's own units, with its critical points."""
    jkr, hertz = _asperity_curves(run)
    first = int(np.argmin(jkr[x]))  # where the stable branch begins
    ax = axes(aspect=0.8)
    ax.plot(hertz[x], hertz[y], label="Hertz", **stroke(1))
    ax.plot(jkr[x][first:], jkr[y][first:], label="JKR, stable", **stroke(0))
    ax.plot(jkr[x][: first + 1], jkr[y][: first + 1], label="JKR, unstable", **stroke(0) | {"linestyle": ":"})
    for control, least, marker in (("displacement", "delta", "o"), ("load", "P", "s")):
        end = int(np.argmin(jkr[least]))
        label = f"detaches at a fixed {control}: ({jkr[x][end]:.2f}, {jkr[y][end]:.2f})".replace("-", "−")
        ax.plot(jkr[x][end], jkr[y][end], marker, color=BLACK, markerfacecolor="white", label=label)
    ax.set(xlabel=_IN_UNITS[x][2], ylabel=_IN_UNITS[y][2], xlim=(None, jkr[x].max()), ylim=(None, jkr[y].max()))
    return legend(ax)


def _smooth_sphere(run: Run):
    smooth = run["solutions/smooth"]
    pair = read_pair(smooth)
    deltas = np.linspace(0, float(smooth["delta"][-1]), 201)
    hertz = reference.hertz(deltas, radius=pair.sphere_radius, contact_modulus=pair.contact_modulus)
    return figures.mean_force({"Hertz": hertz.expand_dims("subregion"), "direct simulation": smooth})


def _places(run: Run):
    direct = run["solutions/direct"]
    ax = figures.scan_map(run["scan"], subregions=direct, highlight=direct["on_debris"])
    x_low, x_high, y_low, y_high = regions.extent(run["scan"])
    columns, rows = (np.unique(direct[f"subregion_{axis}"]).size for axis in "xy")
    lines = {"color": "white", "linewidth": 0.5}
    ax.vlines(np.linspace(x_low, x_high, columns + 1)[1:-1], y_low, y_high, **lines)
    ax.hlines(np.linspace(y_low, y_high, rows + 1)[1:-1], x_low, x_high, **lines)
    return ax


def _reconstruction(run: Run):
    """Draw the surface of the asperities alone, with the colours of the scan."""
    height = run["scan"]["height"]
    return figures.scan_map(run["reconstruction"], limits=(float(height.min()), float(height.max())))


def _contact(run: Run):
    contact = run["solutions/contact"]
    pressure, displacement = made = panels(None, 2, 1, aspect=1.6)
    figures.field_map(contact, scan=run["scan"], ax=pressure)
    figures.field_map(contact, "displacement", ax=displacement)
    return made


def _forces_at(delta: float) -> Callable:
    return lambda run: figures.distribution(run["solutions/direct"].sel(delta=delta, method="nearest"), "force")


def _above():
    """Return two Axes of a new figure, one above the other, with one displacement axis."""
    upper, lower = panels(None, 2, 1, aspect=1.25)
    lower.sharex(upper)
    upper.tick_params(labelbottom=False)
    return upper, lower


def _mark_x(ax, label: str, x: float, height: float) -> None:
    """Draw a dotted line at a displacement, with words to its left at a part of the Axes' height."""
    ax.axvline(x, color=BLACK, linewidth=0.8, linestyle=":")
    ax.annotate(f"{label} ", (x, height), xycoords=("data", "axes fraction"), ha="right", fontsize=SMALL)


def _mark_y(ax, label: str, y: float, side: str = "left") -> None:
    """Draw a dotted line at a value, with words above it on one side."""
    ax.axhline(y, color=BLACK, linewidth=0.8, linestyle=":")
    at = (0.01 if side == "left" else 1, y)
    ax.annotate(label, at, xycoords=("axes fraction", "data"), ha=side, va="bottom", fontsize=SMALL)


def _with_ratios(solutions: dict[str, xr.Dataset], over: str, label: str):
    """Draw mean forces, and below the ratios of the others to one of them."""
    upper, lower = _above()
    figures.mean_force(solutions, ax=upper).set_xlabel("")
    mean = solutions[over]["force"].mean("subregion")
    for order, (name, ds) in enumerate(solutions.items()):
        if name != over:
            ratio = ds["force"].mean("subregion").interp(delta=mean["delta"]) / mean.where(mean > 0)
            lower.plot(ratio["delta"], ratio, marker="os^"[order], markersize=2.6, **stroke(order))
    label_axes(lower, "delta", label)
    return upper, lower


def _mean_forces(run: Run):
    """Draw the mean forces on a rough and a smooth surface, and their ratio."""
    solutions = {"rough": run["solutions/direct"], "smooth": run["solutions/smooth"]}
    upper, lower = _with_ratios(solutions, "smooth", "rough / smooth force")
    _mark_y(lower, "paper: below 0.1 to 10 nm", 0.1)
    _mark_y(lower, "paper: about 0.25 later", 0.25)
    return upper, lower


def _superposed(run: Run):
    """Draw the mean forces without adhesion by both methods at places without debris, and their ratios."""
    direct = places_without_debris(run, "direct")
    keys = {"the paper's sum": HERTZ, "corrected sum": "hertz_corrected"}
    swept = slice(0, float(direct["delta"].max()))
    sums = {name: places_without_debris(run, key).sel(delta=swept) for name, key in keys.items()}
    solutions = {"direct simulation": direct, **sums}
    upper, lower = _with_ratios(solutions, "direct simulation", "superposed / direct force")
    lower.axhline(1, color=GREY, linewidth=0.5, zorder=0)
    _mark_x(upper, "", 12, 0)
    _mark_x(lower, "paper: similar below 12 nm", 12, 0.9)
    nothing_touches = last_without_contact(direct)
    if np.isfinite(nothing_touches):
        no_contact = f"no place touches\nto {nothing_touches:g} nm: no ratio"
        lower.annotate(no_contact, (0.02, 0.35), xycoords="axes fraction", fontsize=SMALL, color=GREY)
    return upper, lower


def places_without_debris(run: Run, method: str) -> xr.Dataset:
    """Return a solution at the places without debris."""
    return run[f"solutions/{method}"].isel(subregion=_clean(run))


def _clean(run: Run) -> np.ndarray:
    """Return the numbers of the places without debris; sums of a catalogue do not know it, the simulation does."""
    return np.flatnonzero(~run["solutions/direct"]["on_debris"].values)


def last_without_contact(solution: xr.Dataset) -> float:
    """Return the last displacement (nm) at which no place is in contact, NaN if there is none."""
    mean = solution["force"].mean("subregion")
    return float(mean["delta"].where(mean == 0).max())


def strongest_place(run: Run) -> int:
    """Return the place of figure 15: of those without debris, the one with the largest published pull-off."""
    pull_off = run["statistics/published"]["pull_off_force"]
    clean = _clean(run)
    return int(clean[pull_off[clean].fillna(0).argmax("subregion")])


def smooth_sphere(solution: xr.Dataset) -> xr.Dataset:
    """Return JKR's smooth sphere at the displacements of a solution, for its pair of bodies; 0 before it adheres."""
    pair = read_pair(solution)
    options = {"contact_modulus": pair.contact_modulus, "work_of_adhesion": pair.work}
    return reference.jkr_sphere(solution["delta"].values, radius=pair.sphere_radius, **options).fillna(0)


def surpassing_delta(force: xr.DataArray, smooth: xr.DataArray) -> float:
    """Return the displacement from which a force exceeds the smooth sphere's to the end of the sweep; NaN if none."""
    below = np.flatnonzero(force.values <= smooth.values)
    first = below[-1] + 1 if below.size else 0
    return float(force["delta"][first]) if first < force.size else np.nan


def _strongest_place(run: Run):
    """Draw the force at one place by both laws and on a smooth surface: the crossing, and below the attraction."""
    keys = {"paper's sum, Hertz": HERTZ, "paper's sum, JKR": "published", "least energy, JKR": "energy"}
    place = {"subregion": [strongest_place(run)]}
    laws = {name: run[f"solutions/{key}"].isel(place)[["force"]] for name, key in keys.items()}
    smooth = smooth_sphere(run["solutions/published"])
    laws["smooth sphere, JKR"] = smooth.expand_dims("subregion")
    upper, lower = _above()
    for ax in (upper, lower):
        figures.mean_force(laws, ax=ax)
    lower.get_legend().remove()
    upper.set_ylim(2 * float(smooth["force"].min()), 1.05 * float(smooth["force"].max()))
    lower.set_ylim(1.2 * float(smooth["force"].min()), -float(smooth["force"].min()))
    crossing = surpassing_delta(laws["paper's sum, JKR"]["force"].isel(subregion=0), smooth["force"])
    if np.isfinite(crossing):
        _mark_x(upper, f"{crossing:.3g} nm (paper: 18)", crossing, 0.02)
    _mark_y(lower, "paper: −8.6 µN", -_PLACE, "right")
    _mark_y(lower, "paper, smooth: −19.1 µN", -_SMOOTH, "right")
    label_axes(upper, "delta", "force").set_xlabel("")
    label_axes(lower, "delta", "force")
    return upper, lower


def _pull_offs(run: Run):
    """Draw the pull-off forces by method, one above the other, with the paper's mean and standard deviation."""
    samples = {label: run[f"statistics/{key}"] for key, label in _METHODS.items() if f"statistics/{key}" in run}
    made = panels(None, len(samples), 1, aspect=0.42 * len(samples))
    largest = max(float(ds["pull_off_force"].max()) for ds in samples.values())
    bins = np.linspace(0, largest, 41)
    for ax, (label, ds) in zip(made, samples.items()):
        ax.axvspan(_MEAN - _STD, _MEAN + _STD, color=GREY, alpha=0.25, linewidth=0, label="paper, mean ± std")
        few = ds.sizes["subregion"] < FEWEST_SAMPLES
        figures.distribution(ds, bins="auto" if few else bins, label=label, ax=ax)
        if ax is not made[-1]:
            ax.set_xlabel("")
    return made


def _by_place(run: Run):
    """Draw superposed over simulated pull-off at each place, those marked where contacts overlap."""
    upper, lower = made = _above()
    simulated = run[f"statistics/{SIMULATION}"]["pull_off_force"].values
    for ax, method in zip(made, ("published", "energy")):
        ratio = pull_off_ratio(run, method)
        overlapping = states_at_pull_off(run[f"solutions/{method}"])["contacts_overlapping"].values > 0
        ax.set(xscale="log", yscale="log")
        ax.axhline(1, color=BLACK, linewidth=0.8, linestyle=":")
        ax.axhspan(*ratio.quantile([0.05, 0.95]).values, color=GREY, alpha=0.2, linewidth=0, label="nine of ten places")
        ax.axhline(float(ratio.median()), color=GREY, linewidth=0.8, label="median place")
        ax.plot(simulated[~overlapping], ratio[~overlapping], "o", color=BLUE, label="no contacts overlap")
        rings = {"color": VERMILION, "markerfacecolor": "none", "label": "contacts overlap"}
        ax.plot(simulated[overlapping], ratio[overlapping], "s", **rings)
        log_ticks(ax.xaxis)
        log_ticks(ax.yaxis)
        ticks_in_unit(ax.yaxis, 1)
        ax.set_ylabel(f"{_METHODS[method]} sum / simulation")
    unit, _ = label_axis(lower.xaxis, "pull_off_force")
    lower.set_xlabel(f"pull-off force in the simulation [{unit}]")
    legend(upper)
    return made


#: Title and drawing of each figure.
FIGURES: dict[str, tuple[str, Callable]] = {
    "figure-02": ("Contact radius of an asperity over its displacement", lambda run: _asperity(run, "delta", "a")),
    "figure-03": ("Contact radius of an asperity over its load", lambda run: _asperity(run, "P", "a")),
    "figure-04": ("Load on an asperity over its displacement", lambda run: _asperity(run, "delta", "P")),
    "figure-05": ("A smooth sphere on a flat (paper: within 1 % of Hertz)", _smooth_sphere),
    "figure-06": ("The rough surface", lambda run: figures.scan_map(run["scan"])),
    "figure-07": ("The areas and their contact centres, those on debris ringed", _places),
    "figure-08": ("The surface of the asperities alone", _reconstruction),
    "figure-09": ("Asperities", lambda run: figures.asperity_statistics(run["asperities"])),
    "figure-10": ("Pressure, on the heights in grey, and displacement of one contact at δ = 17 nm", _contact),
    "figure-11": ("Contact force at δ = 5.08 nm (paper: 0.4 ± 3 µN)", _forces_at(5.08)),
    "figure-12": ("Contact force at δ = 15.4 nm (paper: 21 ± 11 µN)", _forces_at(15.4)),
    "figure-13": ("Mean force on the rough and on a smooth surface, and their ratio", _mean_forces),
    "figure-14": ("Mean force without adhesion by both methods, places without debris", _superposed),
    "figure-15": ("The place without debris that adheres most as published", _strongest_place),
    "figure-16": ("Pull-off forces by method (paper: 2.0 ± 1.37 µN)", _pull_offs),
    _BY_PLACE: ("Not in the paper: superposed over simulated pull-off force, place by place", _by_place),
}

#: Figures that show the simulation with adhesion, where a run contains it.
SIMULATED_FIGURES = ("figure-16", _BY_PLACE)
