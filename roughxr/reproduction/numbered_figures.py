"""The figures of Cheng, Dunn & Brach (2–16) from one run."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from .. import figures
from ..contact import reference
from ..figures.style import BLACK, GREY, SMALL, axes, label_axes, panels, stroke, styled
from ..scans import regions
from ..statistics import debris
from ..vocabulary import schema

Run = Mapping[str, xr.Dataset]

#: Methods of figure 16 and their labels: the paper's formulas, those corrected, and the simulation, not in the paper.
_METHODS = {"published": "published", "self_similar": "corrected", "energy": "least energy", "adhesive": "simulation"}

#: Points of an asperity's curve at which it detaches: words, marker, and (a, δ, P) in JKR's units.
_CRITICAL = (
    ("detaches at a set displacement", "o", {"a": 3 ** (-2 / 3), "delta": -(3 ** (-1 / 3)), "P": -5 / 9}),
    ("detaches under a set load", "s", {"a": 1.0, "delta": -1 / 3, "P": -1.0}),
)

#: The paper's pull-off forces (nN) of the smooth sphere and of figure 15's place, and mean and std of figure 16.
_SMOOTH, _PLACE, _MEAN, _STD = 19.1e3, 8.6e3, 2.0e3, 1.37e3


def paper_figures(run: Run) -> Iterator[tuple[str, object]]:
    """Yield name and Figure of the paper's figures 2–16, from the groups of a run by `paper`."""
    from matplotlib import pyplot

    for name, (title, draw) in _FIGURES.items():
        figure = np.ravel(styled(draw)(run))[0].figure
        lines = textwrap.wrap(f"Figure {int(name[-2:])}. {title}", 46)
        figure.set_figheight(figure.get_figheight() + 0.16 * len(lines))
        figure.suptitle("\n".join(lines), x=0.015, ha="left", fontsize=8, fontweight="bold")
        pyplot.close(figure)
        yield name, figure


def _in_asperity_units(contact: xr.Dataset, units: xr.Dataset) -> dict[str, np.ndarray]:
    """Return a, δ and P of a contact in JKR's units, where the contact exists."""
    exists = np.isfinite(contact["force"].values)
    quantities = {
        "a": ("semi_axis_a", "unit_semi_axis"),
        "delta": ("delta", "unit_delta"),
        "P": ("force", "unit_force"),
    }
    return {key: (contact[name] / units[unit]).values[exists] for key, (name, unit) in quantities.items()}


def _asperity(x: str, y: str) -> Callable:
    """Return the drawing of one asperity's curves by Hertz and JKR, in JKR's own units, with its critical points."""
    words = {"a": "contact radius $a/a_c$", "delta": r"displacement $\delta/\delta_c$", "P": "force $P/P_c$"}

    def draw(run: Run):
        radius, modulus, work = schema.pair(run["scan"], "sphere_radius", "contact_modulus", "work_of_adhesion")
        sphere: dict[str, Any] = {"radius": radius, "contact_modulus": modulus}
        units = reference.jkr_paraboloid([0.0], **sphere, work_of_adhesion=work)
        delta = float(units["unit_delta"]) * np.linspace(0, 1.675, 401) ** 2 + units.attrs["branch_end"]
        both = reference.jkr_paraboloid(delta, **sphere, work_of_adhesion=work)
        stable, unstable = (_in_asperity_units(both.sel(branch=name), units) for name in ("stable", "unstable"))
        jkr = {name: np.concatenate([unstable[name][::-1], stable[name]]) for name in words}
        hertz = _in_asperity_units(reference.hertz(delta[delta > 0], **sphere), units)
        first = int(np.argmin(jkr[x]))  # where the stable branch begins
        ax = axes(aspect=0.8)
        ax.plot(hertz[x], hertz[y], label="Hertz", **stroke(1))
        ax.plot(jkr[x][first:], jkr[y][first:], label="JKR, stable", **stroke(0))
        ax.plot(jkr[x][: first + 1], jkr[y][: first + 1], label="JKR, unstable", **stroke(0) | {"linestyle": ":"})
        for label, marker, point in _CRITICAL:
            label = f"{label}: ({point[x]:.3g}, {point[y]:.3g})".replace("-", "−")
            ax.plot(point[x], point[y], marker, color=BLACK, markerfacecolor="white", label=label)
        ax.set(xlabel=words[x], ylabel=words[y], xlim=(None, jkr[x].max()), ylim=(None, jkr[y].max()))
        ax.figure.legend(loc="outside lower left")  # within the axes it would hide the curves
        return ax

    return draw


def _smooth_sphere(run: Run):
    smooth = run["solutions/smooth"]
    radius, modulus = schema.pair(smooth, "sphere_radius", "contact_modulus")
    deltas = np.linspace(0, float(smooth["delta"][-1]), 201)
    hertz = reference.hertz(deltas, radius=radius, contact_modulus=modulus).expand_dims("subregion")
    return figures.mean_force({"Hertz": hertz, "direct simulation": smooth})


def _places(run: Run):
    direct = run["solutions/direct"]
    ax = figures.scan_map(run["scan"], subregions=direct, highlight=debris(run["asperities"], direct))
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


def _above(aspect: float = 1.25):
    """Return two Axes of a new figure, one above the other, with one displacement axis."""
    upper, lower = panels(None, 2, 1, aspect=aspect)
    lower.sharex(upper)
    upper.tick_params(labelbottom=False)
    return upper, lower


def _mean_forces(run: Run):
    """Draw the mean forces on a rough and a smooth surface, and their ratio."""
    rough, smooth = run["solutions/direct"], run["solutions/smooth"]
    upper, lower = _above()
    figures.mean_force({"rough": rough, "smooth": smooth}, ax=upper)
    ratio = rough["force"].mean("subregion") / smooth["force"].isel(subregion=0)
    lower.plot(ratio["delta"], ratio, marker="o", markersize=2.6, **stroke(0))
    last = float(ratio["delta"][-1])
    lower.hlines([0.1, 0.25], [0, 10], [10, last], color=BLACK, linewidth=0.8, linestyle=":", label="paper")
    lower.text(0, 0.1, "paper: below 0.1 to 10 nm", va="bottom", fontsize=SMALL)
    lower.text(10, 0.25, "paper: 0.25 later", va="bottom", fontsize=SMALL)
    lower.set_ylim(0, max(0.3, 1.1 * float(ratio.max())))
    return _labelled(upper, lower, "rough / smooth force")


def _labelled(upper, lower, ratio: str | None = None):
    """Label two panels of forces, or of a force and a ratio, over one displacement axis; return both."""
    label_axes(upper, "delta", "force").set_xlabel("")
    label_axes(lower, "delta", ratio or "force")
    return upper, lower


def _superposed(run: Run):
    """Draw the mean forces without adhesion by both methods at places without debris, and their ratio."""
    direct = run["solutions/direct"]
    clean = {"subregion": np.flatnonzero(~debris(run["asperities"], direct).values)}
    direct = direct.isel(clean)
    sums = {"the paper's sum": "hertz", "corrected sum": "hertz_corrected"}
    solutions = {name: run[f"solutions/{key}"].isel(clean) for name, key in sums.items() if f"solutions/{key}" in run}
    solutions = {name: ds.sel(delta=slice(0, float(direct["delta"].max()))) for name, ds in solutions.items()}
    upper, lower = _above()
    figures.mean_force({"direct simulation": direct, **solutions}, ax=upper)
    mean = direct["force"].mean("subregion")
    for order, ds in enumerate(solutions.values(), 1):
        ratio = ds["force"].mean("subregion").interp(delta=mean["delta"]) / mean.where(mean > 0)
        lower.plot(ratio["delta"], ratio, marker="os^"[order], markersize=2.6, **stroke(order))
    lower.axhline(1, color=GREY, linewidth=0.5, zorder=0)
    for ax in (upper, lower):
        ax.axvline(12, color=BLACK, linewidth=0.8, linestyle=":")
    style = {"transform": lower.get_xaxis_transform(), "va": "top", "ha": "right", "fontsize": SMALL}
    lower.text(11.8, 0.95, "paper: similar\nbelow 12 nm", **style)
    return _labelled(upper, lower, "superposed / direct force")


def strongest_place(run: Run) -> int:
    """Return the place of figure 15: of those without debris, the one with the largest published pull-off."""
    pull_off = run["statistics/published"]["pull_off_force"]
    clean = pull_off.where(~debris(run["asperities"], run["solutions/published"]).values)
    return int(clean.fillna(0).argmax("subregion"))


def smooth_sphere(solution: xr.Dataset) -> xr.Dataset:
    """Return JKR's smooth sphere at the displacements of a solution, for its pair of bodies; 0 before it adheres."""
    names = ("sphere_radius", "contact_modulus", "work_of_adhesion")
    radius, modulus, work = schema.pair(solution, *names)
    options = {"radius": radius, "contact_modulus": modulus, "work_of_adhesion": work}
    return reference.jkr_sphere(solution["delta"].values, **options).fillna(0)


def surpassing_delta(force: xr.DataArray, smooth: xr.DataArray) -> float:
    """Return the displacement from which a force exceeds the smooth sphere's to the end of the sweep; NaN if none."""
    below = np.flatnonzero(force.values <= smooth.values)
    first = below[-1] + 1 if below.size else 0
    return float(force["delta"][first]) if first < force.size else np.nan


def _strongest_place(run: Run):
    """Draw the force at one place by both laws and on a smooth surface: the crossing, and below the attraction."""
    keys = {"paper's sum, Hertz": "hertz", "paper's sum, JKR": "published", "least energy, JKR": "energy"}
    place = {"subregion": [strongest_place(run)]}
    laws = {name: run[f"solutions/{key}"].isel(place)[["force"]] for name, key in keys.items()}
    smooth = smooth_sphere(run["solutions/published"])
    laws["smooth sphere, JKR"] = smooth.expand_dims("subregion")
    upper, lower = _above()
    for ax in (upper, lower):
        figures.mean_force(laws, ax=ax)
    lower.get_legend().remove()
    crossing = surpassing_delta(laws["paper's sum, JKR"]["force"].isel(subregion=0), smooth["force"])
    last = float(smooth["delta"][-1]) if np.isnan(crossing) else min(1.15 * crossing, float(smooth["delta"][-1]))
    if np.isfinite(crossing):
        upper.axvline(crossing, color=BLACK, linewidth=0.8, linestyle=":")
        words = f"{crossing:.3g} nm (paper: 18) "
        upper.text(crossing, 0.02, words, transform=upper.get_xaxis_transform(), ha="right", fontsize=SMALL)
    deepest = float(smooth["force"].min())
    upper.set(xlim=(None, last), ylim=(2 * deepest, 1.3 * float(smooth["force"].sel(delta=last, method="nearest"))))
    lower.set_ylim(1.1 * deepest, -deepest)
    for force, words in ((-_PLACE, "paper: −8.6 µN "), (-_SMOOTH, "paper, smooth: −19.1 µN ")):
        lower.axhline(force, color=BLACK, linewidth=0.8, linestyle=":")
        lower.text(1, force, words, transform=lower.get_yaxis_transform(), va="bottom", ha="right", fontsize=SMALL)
    return _labelled(upper, lower)


def _pull_offs(run: Run):
    """Draw the pull-off forces by method, one above the other, with the paper's mean and standard deviation."""
    samples = {words: run[f"statistics/{key}"] for key, words in _METHODS.items() if f"statistics/{key}" in run}
    made = panels(None, len(samples), 1, aspect=0.42 * len(samples))
    largest = max(float(ds["pull_off_force"].max()) for ds in samples.values())
    bins = np.linspace(0, largest, 41)
    for ax, (words, ds) in zip(made, samples.items()):
        ax.axvspan(_MEAN - _STD, _MEAN + _STD, color=GREY, alpha=0.25, linewidth=0, label="paper, mean ± std")
        figures.distribution(ds, bins=bins, label=words, ax=ax)
        if ax is not made[-1]:
            ax.set_xlabel("")
    return made


#: Title and drawing of each figure.
_FIGURES: dict[str, tuple[str, Callable]] = {
    "figure-02": ("Contact radius of an asperity over its displacement", _asperity("delta", "a")),
    "figure-03": ("Contact radius of an asperity over its load", _asperity("P", "a")),
    "figure-04": ("Load on an asperity over its displacement", _asperity("delta", "P")),
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
}
