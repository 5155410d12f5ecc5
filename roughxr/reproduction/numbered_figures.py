"""The figures of Cheng, Dunn & Brach (2–16) from one run."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping

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
    """Yield the paper's figures 2–16, each with its number in the paper.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run by `paper`.

    Yields
    ------
    (str, Figure)
        "figure-02" … "figure-16"; the Figures belong to no pyplot window.

    Raises
    ------
    KeyError
        If a group that the next figure needs is missing.

    Examples
    --------
    >>> name, figure = next(paper_figures({}))
    >>> name, figure.get_suptitle()
    ('figure-02', 'Figure 2. Contact radius of an asperity')
    """
    from matplotlib.figure import Figure

    for name, (title, shape, draw) in _FIGURES.items():
        figure = Figure(figsize=(3.4, 2.6 if shape[0] == 1 else 1.2 + 1.1 * shape[0]), layout="constrained")
        axes = figure.subplots(*shape, squeeze=False, sharex=shape[0] > 2).ravel()
        draw(run, axes)
        words = f"Figure {int(name[-2:])}. {title}"
        figure.suptitle("\n".join(textwrap.wrap(words, 55)), x=0.015, ha="left", fontsize=8, fontweight="bold")
        yield name, figure


def _asperity(x: str, y: str) -> Callable:
    """Return the drawing of one asperity's curves by Hertz and JKR, in JKR's own units."""
    words = {"a": "contact radius $a/a_c$", "delta": r"displacement $\delta/\delta_c$", "P": "force $P/P_c$"}

    def draw(run: Run, axes: np.ndarray):
        a = np.linspace(0, 2, 801)
        jkr = {"a": a, "delta": a**2 - 4 / 3 * np.sqrt(a), "P": a**3 - 2 * a**1.5}
        first = int(np.argmin(jkr["P"] if x == "P" else jkr["delta"]))  # where the stable branch begins
        axes[0].plot(*({"a": a, "delta": a**2, "P": a**3}[name] for name in (x, y)), "--", label="Hertz")
        axes[0].plot(jkr[x][first:], jkr[y][first:], label="JKR, stable")
        axes[0].plot(jkr[x][: first + 1], jkr[y][: first + 1], ":", color="C1", label="JKR, unstable")
        axes[0].set(xlabel=words[x], ylabel=words[y])
        axes[0].legend(frameon=False, fontsize=6.5)

    return draw


def _smooth_sphere(run: Run, axes: np.ndarray):
    smooth = run["solutions/smooth"]
    radius, modulus = schema.pair(smooth, "sphere_radius", "contact_modulus")
    hertz = reference.hertz(smooth["delta"].values, radius=radius, contact_modulus=modulus).expand_dims("subregion")
    figures.mean_force({"direct simulation": smooth, "Hertz": hertz}, ax=axes[0])


def _places(run: Run, axes: np.ndarray):
    direct = run["solutions/direct"]
    figures.scan_map(run["scan"], subregions=direct, highlight=debris(run["asperities"], direct), ax=axes[0])


def _one_contact(run: Run, axes: np.ndarray):
    contact = run["solutions/contact"]
    place = {"subregion": int(contact["subregion"][0])}
    figures.field_map(contact, scan=run["scan"], ax=axes[0], **place)
    figures.field_map(contact, "displacement", ax=axes[1], **place)


def _forces_at(delta: float) -> Callable:
    def draw(run: Run, axes: np.ndarray):
        figures.distribution(run["solutions/direct"].sel(delta=delta, method="nearest"), "force", ax=axes[0])

    return draw


def _superposed(run: Run, axes: np.ndarray):
    direct, superposed = run["solutions/direct"], run["solutions/hertz"]
    clean = np.flatnonzero(~debris(run["asperities"], direct).values)
    superposed = superposed.sel(delta=slice(0, float(direct["delta"].max())))
    solutions = {"direct simulation": direct, "superposed asperities": superposed}
    figures.mean_force({name: ds.isel(subregion=clean) for name, ds in solutions.items()}, ax=axes[0])
    highest = axes[0].get_ylim()[1]
    axes[0].set(yscale="log", ylim=(1e-5 * highest, 8 * highest))


def strongest_place(run: Run) -> int:
    """Return the place of figure 15: of those without debris, the one with the largest published pull-off."""
    pull_off = run["statistics/published"]["pull_off_force"]
    clean = pull_off.where(~debris(run["asperities"], run["solutions/published"]).values)
    return int(clean.fillna(0).argmax("subregion"))


def _strongest_place(run: Run, axes: np.ndarray):
    keys = {"Hertz": "hertz", "JKR, published": "published", "JKR, least energy": "energy"}
    place = {"subregion": [strongest_place(run)]}
    laws = {name: run[f"solutions/{key}"].isel(place)[["force"]] for name, key in keys.items()}
    published = run["solutions/published"]
    names = ("sphere_radius", "contact_modulus", "work_of_adhesion")
    radius, modulus, work = schema.pair(published, *names)
    sphere = {"radius": radius, "contact_modulus": modulus, "work_of_adhesion": work}
    jkr = reference.jkr_sphere(published["delta"].values, **sphere).fillna(0).expand_dims("subregion")
    figures.mean_force(laws | {"smooth sphere, JKR": jkr}, ax=axes[0])
    deepest = max(-float(laws["JKR, published"]["force"].min()), 1e-9)
    axes[0].set(xlim=(None, _last_below(laws["Hertz"], 3 * deepest)), ylim=(-2.5 * deepest, 3 * deepest))


def _last_below(ds: xr.Dataset, force: float) -> float:
    """Return the largest displacement at which a force does not exceed a limit."""
    return float(ds["delta"].where((ds["force"] <= force).all("subregion")).max())


def _pull_offs(run: Run, axes: np.ndarray):
    """Draw the pull-off forces by each method below one another, with a common axis of forces."""
    for order, (ax, (key, words)) in enumerate(zip(axes, _METHODS.items())):
        if f"statistics/{key}" in run:
            figures.distribution(run[f"statistics/{key}"], label=words, order=order, ax=ax)
        ax.set(xlabel=ax.get_xlabel() if ax is axes[-1] else "", ylabel=ax.get_ylabel() if order == 1 else "")


#: Title, rows and columns of panels, and drawing of each figure.
_FIGURES: dict[str, tuple[str, tuple[int, int], Callable]] = {
    "figure-02": ("Contact radius of an asperity", (1, 1), _asperity("delta", "a")),
    "figure-03": ("Contact radius of an asperity under a load", (1, 1), _asperity("P", "a")),
    "figure-04": ("Load on an asperity", (1, 1), _asperity("delta", "P")),
    "figure-05": ("A smooth sphere on a flat", (1, 1), _smooth_sphere),
    "figure-06": ("The rough surface", (1, 1), lambda run, axes: figures.scan_map(run["scan"], ax=axes[0])),
    "figure-07": ("The contact centres, those on debris ringed", (1, 1), _places),
    "figure-08": (
        "The surface reconstructed from the asperities",
        (1, 1),
        lambda run, axes: figures.scan_map(run["reconstruction"], robust=True, ax=axes[0]),
    ),
    "figure-09": ("Asperities", (2, 2), lambda run, axes: figures.asperity_statistics(run["asperities"], ax=axes)),
    "figure-10": ("One contact", (2, 1), _one_contact),
    "figure-11": ("Contact force at δ = 5.08 nm (paper: 0.4 ± 3 µN)", (1, 1), _forces_at(5.08)),
    "figure-12": ("Contact force at δ = 15.4 nm (paper: 21 ± 11 µN)", (1, 1), _forces_at(15.4)),
    "figure-13": (
        "Mean force on the rough and on a smooth surface",
        (1, 1),
        lambda run, axes: figures.mean_force(
            {"rough": run["solutions/direct"], "smooth": run["solutions/smooth"]}, ax=axes[0]
        ),
    ),
    "figure-14": ("Mean force without adhesion, places without debris", (1, 1), _superposed),
    "figure-15": ("The place without debris that adheres most as published (paper: 8.6 µN)", (1, 1), _strongest_place),
    "figure-16": ("Pull-off forces by method (paper: 2.0 ± 1.37 µN)", (4, 1), _pull_offs),
}
