"""The figures of Cheng, Dunn & Brach (2–16) from one run, with the numbers that they print beside those found."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

import numpy as np
import xarray as xr

from ..figures import against_hertz, asperity_curve, sweep
from ..figures import run_plots as of_a_run
from ..figures.forces import hertz_error, jkr_sphere
from ..figures.run_plots import Groups, drawn
from ..vocabulary.numbers import number, quantity
from ..vocabulary.verbs import verb

#: Note on which of the printed values a run can confirm.
_TWIN = (
    "The surface is a synthetic twin, its spectrum, debris and seed fitted to the paper's means and spreads of height, "
    "force and pull-off: agreement with these confirms nothing."
)

#: Printed values by figure, each for the row of its table that begins with these words.
_PRINTED = {
    "figure-05": {"largest": "< 1 %"},
    "figure-06": {"height": "23 nm", "mean distance": "12.842 nm"},
    "figure-07": {"contact centres": "64", "of which": "6"},
    "figure-08": {"Rₐ of the scan": "12.842 nm", "Rₐ of the rec": "12.880 nm", "rms": "1.74 nm *"},
    "figure-09": {
        "mean height of the main": "near 15 nm",
        "mean height of the debris": "near 27 nm",
        "axis ratio": "mean 0.6",
        "less": "most",
    },
    "figure-11": {"force over": "0.4 ± 3 µN", "mean of places on": "near 20 µN"},
    "figure-12": {"force over": "21 ± 11 µN", "mean of places on": "near 80 µN"},
    "figure-13": {"rough / smooth, largest": "< 0.1", "rough / smooth at": "about 0.25"},
    "figure-14": {
        "superposition / direct at δ = 10 nm": "about 1",
        "superposition / direct at δ = 12 nm": "begin to part",
        "superposition / direct at δ = 15.4 nm": "> 1",
    },
    "figure-15": {
        "pull-off, as published": "8.6 µN",
        "pull-off, smooth": "19.1 µN",
        "pulls up to": "12.4 nm",
        "exceeds": "18 nm",
    },
    "figure-16": {"force, as published": "2.0 ± 1.37 µN", "displacement, as published": "9.7 ± 2.52 nm"},
}

#: Methods of figure 16 and their labels: the paper's formulas, those corrected, and the simulation that it has not.
_METHODS = {
    "adhesive": "simulation",
    "published": "as published",
    "self_similar": "corrected",
    "energy": "least energy",
}


class _Numbered(Groups):
    """A run on whose sheets the paper's number of the figure and its printed values stand."""

    def __init__(self, run: Mapping[str, xr.Dataset], name: str):
        super().__init__(run)
        self.name = name

    def sheet(self, title: str, *, rows=(), note: str = "", **options):
        """Return a sheet, its rows with a printed value each."""
        if self.name == "figure-08":
            note += " * printed as 0.0034 nm, which lacks the factor √(MN) = 512."
        rows = [(*row, self._printed(row[0])) for row in rows]
        note = f"{note} {_TWIN if rows else ''}".strip()
        return super().sheet(f"Figure {int(self.name[-2:])}. {title}", rows=rows, note=note, **options)

    def _printed(self, words: str) -> str:
        """Return what the paper prints for a row, a dash where it prints nothing."""
        values = _PRINTED.get(self.name, {})
        return next((value for start, value in values.items() if words.startswith(start)), "–")


@verb
def paper_figures(run: Mapping[str, xr.Dataset]) -> Iterator[tuple[str, object]]:
    """Yield the paper's figures 2–16, each with its number in the paper.

    Parameters
    ----------
    run : mapping of str to Dataset
        As for `figures.run_figures`, and "solutions/published", "solutions/energy", and "statistics/published",
        "statistics/self_similar", "statistics/energy" (superposed, with adhesion).

    Yields
    ------
    (str, Figure)
        "figure-02" … "figure-16"; the Figures belong to no pyplot window.

    Raises
    ------
    ValueError
        If a group that the next figure needs is missing.

    Examples
    --------
    >>> name, figure = next(paper_figures({}))
    >>> name
    'figure-02'
    """
    for name, draw in _FIGURES.items():
        yield name, drawn(name, draw, _Numbered(run, name))


def _asperity_figure(run: Groups, title: str, x: str, y: str, largest: float):
    figure, (ax,) = run.sheet(title, aspect=0.8)
    asperity_curve(x, y, largest=largest, ax=ax)
    return figure


def _figure_05(run: Groups):
    smooth = run["solutions/smooth"]
    worst = 100 * np.nanmax(np.abs(hertz_error(smooth)))
    title = f"Direct simulation of a smooth sphere on a flat: within {worst:.2g} % of Hertz's law"
    rows = [("largest difference from Hertz", number(worst, "%", 2))]
    figure, axes = run.sheet(title, shape=(2, 1), aspect=0.95, rows=rows, height_ratios=[2.2, 1], sharex=True)
    against_hertz(smooth, ax=axes)
    return figure


def _figure_15(run):
    published, pull = run["solutions/published"], {}
    pulls = run["statistics/published"]["pull_off_force"]
    clean = pulls.where(~run.debris("solutions/published"), 0).fillna(0)
    where = int(pulls["subregion"][int(clean.argmax("subregion"))])
    for key in ("published", "energy"):
        pull[key] = float(run[f"statistics/{key}"]["pull_off_force"].sel(subregion=where))
    smooth = -float(jkr_sphere(published, np.linspace(-100, 0, 4001)).min())
    force = published["force"].sel(subregion=where)
    rows = [
        ("pull-off, as published", quantity(pull["published"])),
        ("pull-off, least energy", quantity(pull["energy"])),
        ("pull-off, smooth sphere", quantity(smooth)),
        ("pulls up to δ, as published", number(float(force["delta"].where(force < 0).max()), "nm")),
        ("exceeds the smooth sphere beyond δ", number(_crossing(force, published), "nm")),
    ]
    title = f"The place without debris that sticks most as published (subregion {where}), by every law"
    figure, (ax,) = run.sheet(title, aspect=0.85, rows=rows)
    solutions = {
        "Hertz, superposed": run["solutions/hertz"],
        "JKR, as published": published,
        "JKR, least energy": run["solutions/energy"],
    }
    rough = max((value for value in pull.values() if np.isfinite(value)), default=smooth)
    deepest = smooth if smooth < 4 * rough else rough  # a value that would dwarf the others is only given in the table
    sweep(solutions, subregion=where, force_limits=(-1.3 * deepest, 1.7 * deepest), ax=ax)
    return figure


def _crossing(force: xr.DataArray, pair: xr.Dataset) -> float:
    """Return the displacement beyond which a rough contact pushes harder than the smooth sphere, NaN if none."""
    excess = force.values - jkr_sphere(pair, force["delta"].values)
    below = np.flatnonzero((excess <= 0) & (force["delta"].values > 0))
    beyond = below[-1] + 1 if below.size else 0
    return float(force["delta"][beyond]) if below.size and beyond < force.size else np.nan


def _figure_16(run: Groups):
    methods = {key: words for key, words in _METHODS.items() if key != "adhesive" or f"statistics/{key}" in run}
    return of_a_run.pull_offs(run, methods, "Pull-off forces over all places: what the slip in the formula is worth")


_FIGURES: dict[str, Callable] = {
    "figure-02": partial(
        _asperity_figure,
        title="Adhesion holds an asperity beyond touch, until its stable branch ends",
        x="delta",
        y="a",
        largest=1.75,
    ),
    "figure-03": partial(
        _asperity_figure,
        title="Under a prescribed load the contact lets go at the largest pull, at a finite radius",
        x="P",
        y="a",
        largest=1.95,
    ),
    "figure-04": partial(
        _asperity_figure,
        title="Load against displacement of any asperity, in its own units",
        x="delta",
        y="P",
        largest=1.75,
    ),
    "figure-05": _figure_05,
    "figure-06": of_a_run.scan_figure,
    "figure-07": of_a_run.places,
    "figure-08": of_a_run.reconstruction,
    "figure-09": of_a_run.asperities,
    "figure-10": of_a_run.one_contact,
    "figure-11": partial(of_a_run.force_distribution, delta=5.08),
    "figure-12": partial(of_a_run.force_distribution, delta=15.4),
    "figure-13": partial(of_a_run.rough_over_smooth, edge=10.0),
    "figure-14": partial(of_a_run.superposed_over_direct, deltas=(10.0, 12.0, 15.4)),
    "figure-15": _figure_15,
    "figure-16": _figure_16,
}
