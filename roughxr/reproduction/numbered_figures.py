"""The figures of Cheng, Dunn & Brach (2–16) from one run."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from .. import figures
from ..contact import reference
from ..statistics import debris
from ..vocabulary import schema

Run = Mapping[str, xr.Dataset]

#: Methods of figure 16 and their labels: the paper's formulas, those corrected, and the simulation, not in the paper.
_METHODS = {"adhesive": "simulation", "published": "published", "self_similar": "corrected", "energy": "least energy"}


def paper_figures(run: Run) -> Iterator[tuple[str, object]]:
    """Yield name and Figure of the paper's figures 2–16, from the groups of a run by `paper`."""
    from matplotlib import pyplot

    for name, (title, draw) in _FIGURES.items():
        figure = np.ravel(draw(run))[0].figure
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
    """Return the drawing of one asperity's curves by Hertz and JKR, in JKR's own units."""
    words = {"a": "contact radius $a/a_c$", "delta": r"displacement $\delta/\delta_c$", "P": "force $P/P_c$"}

    def draw(run: Run):
        from matplotlib import pyplot

        radius, modulus, work = schema.pair(run["scan"], "sphere_radius", "contact_modulus", "work_of_adhesion")
        sphere: dict[str, Any] = {"radius": radius, "contact_modulus": modulus}
        units = reference.jkr_paraboloid([0.0], **sphere, work_of_adhesion=work)
        delta = float(units["unit_delta"]) * np.linspace(0, 1.675, 401) ** 2 + units.attrs["branch_end"]
        both = reference.jkr_paraboloid(delta, **sphere, work_of_adhesion=work)
        stable, unstable = (_in_asperity_units(both.sel(branch=name), units) for name in ("stable", "unstable"))
        jkr = {name: np.concatenate([unstable[name][::-1], stable[name]]) for name in words}
        hertz = _in_asperity_units(reference.hertz(delta[delta > 0], **sphere), units)
        first = int(np.argmin(jkr[x]))  # where the stable branch begins
        with pyplot.rc_context({"font.size": 7}):
            _, ax = pyplot.subplots(figsize=(3.35, 2.4), layout="constrained")
            ax.plot(hertz[x], hertz[y], "--", label="Hertz")
            ax.plot(jkr[x][first:], jkr[y][first:], label="JKR, stable")
            ax.plot(jkr[x][: first + 1], jkr[y][: first + 1], ":", color="C1", label="JKR, unstable")
            ax.set(xlabel=words[x], ylabel=words[y], xlim=(None, jkr[x].max()), ylim=(None, jkr[y].max()))
            ax.legend(frameon=False)
        return ax

    return draw


def _smooth_sphere(run: Run):
    smooth = run["solutions/smooth"]
    radius, modulus = schema.pair(smooth, "sphere_radius", "contact_modulus")
    hertz = reference.hertz(smooth["delta"].values, radius=radius, contact_modulus=modulus).expand_dims("subregion")
    return figures.mean_force({"direct simulation": smooth, "Hertz": hertz})


def _places(run: Run):
    direct = run["solutions/direct"]
    return figures.scan_map(run["scan"], subregions=direct, highlight=debris(run["asperities"], direct))


def _forces_at(delta: float) -> Callable:
    return lambda run: figures.distribution(run["solutions/direct"].sel(delta=delta, method="nearest"), "force")


def _superposed(run: Run):
    direct, superposed = run["solutions/direct"], run["solutions/hertz"]
    clean = np.flatnonzero(~debris(run["asperities"], direct).values)
    superposed = superposed.sel(delta=slice(0, float(direct["delta"].max())))
    solutions = {"direct simulation": direct, "superposed asperities": superposed}
    ax = figures.mean_force({name: ds.isel(subregion=clean) for name, ds in solutions.items()})
    highest = ax.get_ylim()[1]
    ax.set(yscale="log", ylim=(1e-5 * highest, 20 * highest))
    return ax


def strongest_place(run: Run) -> int:
    """Return the place of figure 15: of those without debris, the one with the largest published pull-off."""
    pull_off = run["statistics/published"]["pull_off_force"]
    clean = pull_off.where(~debris(run["asperities"], run["solutions/published"]).values)
    return int(clean.fillna(0).argmax("subregion"))


def _strongest_place(run: Run):
    keys = {"Hertz": "hertz", "JKR, published": "published", "JKR, least energy": "energy"}
    place = {"subregion": [strongest_place(run)]}
    laws = {name: run[f"solutions/{key}"].isel(place)[["force"]] for name, key in keys.items()}
    published = run["solutions/published"]
    names = {"radius": "sphere_radius", "contact_modulus": "contact_modulus", "work_of_adhesion": "work_of_adhesion"}
    sphere = {option: float(published[name]) for option, name in names.items()}
    jkr = reference.jkr_sphere(published["delta"].values, **sphere).fillna(0).expand_dims("subregion")
    ax = figures.mean_force(laws | {"smooth sphere, JKR": jkr})
    deepest = max(-float(laws["JKR, published"]["force"].min()), 1e-9)
    hertz = laws["Hertz"]["force"].isel(subregion=0)
    ax.set(xlim=(None, float(hertz["delta"][hertz <= 3 * deepest].max())), ylim=(-2.5 * deepest, 3 * deepest))
    return ax


def _pull_offs(run: Run):
    ax = None
    for order, (key, words) in enumerate(_METHODS.items()):
        if f"statistics/{key}" in run:
            ax = figures.distribution(run[f"statistics/{key}"], label=words, order=order, ax=ax)
    return ax


def _mean_forces(run: Run):
    return figures.mean_force({"rough": run["solutions/direct"], "smooth": run["solutions/smooth"]})


#: Title and drawing of each figure.
_FIGURES: dict[str, tuple[str, Callable]] = {
    "figure-02": ("Contact radius of an asperity", _asperity("delta", "a")),
    "figure-03": ("Contact radius of an asperity under a load", _asperity("P", "a")),
    "figure-04": ("Load on an asperity", _asperity("delta", "P")),
    "figure-05": ("A smooth sphere on a flat", _smooth_sphere),
    "figure-06": ("The rough surface", lambda run: figures.scan_map(run["scan"])),
    "figure-07": ("The contact centres, those on debris ringed", _places),
    "figure-08": (
        "The surface of the asperities alone",
        lambda run: figures.scan_map(run["reconstruction"], robust=True),
    ),
    "figure-09": ("Asperities", lambda run: figures.asperity_statistics(run["asperities"])),
    "figure-10": (
        "Pressure of one contact",
        lambda run: figures.field_map(run["solutions/contact"], scan=run["scan"]),
    ),
    "figure-11": ("Contact force at δ = 5.08 nm (paper: 0.4 ± 3 µN)", _forces_at(5.08)),
    "figure-12": ("Contact force at δ = 15.4 nm (paper: 21 ± 11 µN)", _forces_at(15.4)),
    "figure-13": ("Mean force on the rough and on a smooth surface", _mean_forces),
    "figure-14": ("Mean force without adhesion, places without debris", _superposed),
    "figure-15": ("The place without debris that adheres most as published (paper: 8.6 µN)", _strongest_place),
    "figure-16": ("Pull-off forces by method (paper: 2.0 ± 1.37 µN)", _pull_offs),
}
