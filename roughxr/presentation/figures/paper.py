"""The figures of Cheng, Dunn & Brach (2–16) from one run: the paper's own with its numbers, or those of any other scan.

A run is a mapping of group names, such as "solutions/direct", to Datasets.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

import numpy as np
import xarray as xr

from ...scans import regions
from ...statistics import debris
from ...vocabulary.verbs import verb
from .contact_fields import contact_maps
from .distributions import asperity_statistics, distribution
from .forces import against_hertz, force_ratio, hertz_error, jkr_sphere, mean_force, mean_ratio, sweep
from .maps import contact_grid, scan_map
from .saving import mean_and_spread, number, sheet
from .single import asperity_curve
from .style import GREY, SMALL, display_unit, label_axis, stroke, styled

Run = Mapping[str, xr.Dataset]

#: Displacements at which the paper shows distributions of the force, nm, and its printed values there.
_FORCE_AT = {
    "figure-11": (5.08, "0.4 ± 3 µN", "near 20 µN"),
    "figure-12": (15.4, "21 ± 11 µN", "near 80 µN"),
}

#: Note on which of the paper's values a run can confirm.
_TWIN = (
    "The surface is a synthetic twin, its spectrum, debris and seed fitted to the paper's means and spreads of height, "
    "force and pull-off: agreement with these confirms nothing."
)

#: Labels of the formulations of adhesion in legends.
_FORMULATIONS = {
    "published": "as published",
    "self_similar": "corrected",
    "energy": "least energy",
}


@verb
def paper_figures(run: Run) -> Iterator[tuple[str, object]]:
    """Yield the paper's figures 2–16, each with its number in the paper.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups "scan" (with its pair), "asperities", "reconstruction", "solutions/direct" (many subregions),
        "solutions/contact" (one, with fields), "solutions/smooth" (the sphere on a flat), "solutions/hertz",
        "solutions/published", "solutions/self_similar", "solutions/energy" (superposed), and
        "statistics/published", "statistics/self_similar", "statistics/energy" (their pull-off).

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
        yield name, styled(_drawn)(name, draw, _Groups(run))


@verb
def run_figures(run: Run) -> Iterator[tuple[str, object]]:
    """Yield the same figures for a run on any scan, named by what they show, without the paper's numbers.

    Parameters
    ----------
    run : mapping of str to Dataset
        As for `paper_figures`.

    Yields
    ------
    (str, Figure)
        "scan", "places", …: those of the paper that depend on the scan; the two for single displacements are drawn at
        the middle and the last displacement that was solved.

    Raises
    ------
    ValueError
        If a group that the next figure needs is missing.

    Examples
    --------
    >>> len(_NAMES), next(iter(_NAMES.values()))
    (11, 'scan')
    """
    for name, words in _NAMES.items():
        yield words, styled(_drawn)(words, _FIGURES[name], _Groups(run, paper=False))


def _drawn(name: str, draw: Callable, run: _Groups):
    """Return the figure, or a sheet that says why the data do not allow one (no contact, too few places)."""
    try:
        return draw(run)
    except MissingGroup:
        raise
    except ValueError as reason:
        figure, (ax,) = sheet(f"{name.replace('-', ' ').capitalize()} cannot be drawn", aspect=0.3, note=str(reason))
        ax.set_axis_off()
        return figure


class MissingGroup(ValueError):
    """A group that a figure needs is not in the run."""


class _Groups:
    """A run that raises a clear error for a missing group."""

    def __init__(self, run: Run, *, paper: bool = True):
        self._run, self.paper = run, paper

    def sheet(self, title: str, *, rows=(), note: str = "", explained: str = "", **options):
        """Return a sheet, with the paper's number of the figure and printed values only for the paper's own run."""
        if self.paper:
            note = " ".join([explained, note, _TWIN if rows else ""]).strip()
            return sheet(title, rows=rows, note=note, **options)
        title = re.sub(r"^Figure \d+\. ", "", title)
        return sheet(title, rows=[row[:2] for row in rows], note=explained, **options)

    def __getitem__(self, name: str) -> xr.Dataset:
        if name not in self._run:
            found = ", ".join(self._run) or "none"
            raise MissingGroup(f"expected the group {name!r} in the run, found groups: {found}")
        return self._run[name]

    def debris(self, name: str = "solutions/direct") -> np.ndarray:
        """Return which subregions of a solution hold debris."""
        return debris(self["asperities"], self[name]).values


def _figure_02(run):
    title = "Figure 2. Adhesion holds an asperity beyond touch, until its stable branch ends"
    return _asperity_figure(run, title, "delta", "a", largest=1.75)


def _figure_03(run):
    title = "Figure 3. Under a prescribed load the contact lets go at the largest pull, at a finite radius"
    return _asperity_figure(run, title, "P", "a", largest=1.95)


def _figure_04(run):
    title = "Figure 4. Load against displacement of any asperity, in its own units"
    return _asperity_figure(run, title, "delta", "P", largest=1.75)


def _asperity_figure(run, title: str, x: str, y: str, *, largest: float):
    figure, (ax,) = run.sheet(title, aspect=0.8)
    asperity_curve(x, y, largest=largest, ax=ax)
    return figure


def _figure_05(run):
    smooth = run["solutions/smooth"]
    worst = 100 * np.nanmax(np.abs(hertz_error(smooth)))
    rows = [("largest difference from Hertz", number(worst, "%", 2), "< 1 %")]
    title = f"Figure 5. Direct simulation of a smooth sphere on a flat: within {worst:.2g} % of Hertz's law"
    figure, axes = run.sheet(title, shape=(2, 1), aspect=0.95, rows=rows, height_ratios=[2.2, 1], sharex=True)
    against_hertz(smooth, ax=axes)
    return figure


def _figure_06(run):
    scan = run["scan"]
    height = scan["height"].values
    rows = [
        ("height, highest − lowest", number(float(np.ptp(height)), "nm"), "23 nm"),
        ("mean distance from the datum, Rₐ", f"{np.abs(height).mean():.3f} nm", "12.842 nm"),
    ]
    side = regions.extent(scan)
    size = f"{(side[1] - side[0]) / 1e3:.3g} × {(side[3] - side[2]) / 1e3:.3g} µm"
    figure, (ax,) = run.sheet(f"Figure 6. The rough surface, {size}", aspect=0.84, rows=rows)
    scan_map(scan, ax=ax)
    return figure


def _figure_07(run):
    direct = run["solutions/direct"]
    flags = run.debris()
    rows = [
        ("contact centres", str(flags.size), "64"),
        ("of which on debris (framed)", str(int(flags.sum())), "6"),
    ]
    title = f"Figure 7. The {flags.size} places where the sphere lands, those on debris framed"
    figure, (ax,) = run.sheet(title, aspect=0.84, rows=rows)
    contact_grid(run["scan"], direct, highlight=flags, ax=ax)
    return figure


def _figure_08(run):
    original, envelope = run["scan"]["height"].values, run["reconstruction"]
    roughness = [f"{np.nanmean(np.abs(height)):.3f} nm" for height in (original, envelope["height"].values)]
    rows = [
        ("Rₐ of the scan", roughness[0], "12.842 nm"),
        ("Rₐ of the reconstruction", roughness[1], "12.880 nm"),
        ("rms difference", number(float(envelope.attrs["residual_rms"]), "nm"), "1.74 nm *"),
    ]
    note = "* printed as 0.0034 nm, which lacks the factor √(MN) = 512." if run.paper else ""
    words = (
        "Colours as of the scan; a triangle at their end stands for heights beyond. Comets are single paraboloids, "
        "each fitted to the summit of a particle."
    )
    title = "Figure 8. The surface that the asperities alone would make matches the peaks, not the valleys"
    figure, (ax,) = run.sheet(title, aspect=0.84, rows=rows, note=note, explained=words)
    scan_map(envelope, ax=ax, limits=(original.min(), original.max()))
    return figure


def _figure_09(run):
    catalogue = run["asperities"]
    height, ratio = catalogue["height"].values, catalogue["axis_ratio"].values
    lowest = debris(catalogue, run["solutions/direct"]).attrs["threshold_value"]
    groups = [height[height < lowest], height[height >= lowest]]
    rows = [
        ("mean height of the main group", mean_and_spread(groups[0], "nm", digits=1), "near 15 nm"),
        ("mean height of the debris", mean_and_spread(groups[1], "nm", digits=1), "near 27 nm"),
        ("axis ratio b/a", mean_and_spread(ratio, ""), "mean 0.6"),
        ("less than ten times as long as wide", number(100 * np.nanmean(ratio[np.isfinite(ratio)] > 0.1), "%"), "most"),
    ]
    found = "two groups of heights" if groups[1].size else "one group of heights"
    title = f"Figure 9. What the {height.size} asperities are like: {found}, and ellipses more than circles"
    figure, axes = run.sheet(title, shape=(2, 2), aspect=0.98, rows=rows)
    asperity_statistics(catalogue, ax=axes)
    return figure


def _figure_10(run):
    contact = run["solutions/contact"]
    delta = float(contact["delta"][-1])
    spots = _spots(contact["pressure"].isel(subregion=0, delta=-1).values)
    count = f"{spots} spots touch, and the surface between them sinks too" if spots > 1 else "one spot touches"
    if spots == 0:
        count = "nothing touches"
    x, y = (float(contact[f"subregion_{axis}"][0]) / 1e3 for axis in "xy")
    place = f"the place at x = {x:.3g}, y = {y:.3g} µm" if {"subregion_x", "subregion_y"} <= set(contact.coords) else ""
    title = f"Figure 10. {place.capitalize()}, δ = {delta:g} nm: {count}"
    figure, axes = run.sheet(title, shape=(2, 2), aspect=1.16)
    contact_maps(contact, run["scan"], subregion=int(contact["subregion"][0]), ax=axes)
    return figure


def _spots(pressure: np.ndarray) -> int:
    """Return the number of separate spots that carry pressure; pixels that meet at a corner belong to one spot."""
    from scipy.ndimage import label

    return label(pressure > 0, structure=np.ones((3, 3)))[1]


def _force_distribution(name: str) -> Callable:
    """Return the function that draws the forces' distribution at one displacement."""

    def draw(run):
        wanted, printed, second = _FORCE_AT[name]
        if not run.paper:
            deltas = run["solutions/direct"]["delta"].values
            wanted = deltas[deltas.size // 2] if name == "figure-11" else deltas[-1]
        at = run["solutions/direct"].sel(delta=wanted, method="nearest")
        force, flags = at["force"].values, run.debris()
        rows = [
            (f"force over {force.size} subregions", _forces(force), printed),
            ("largest force", _force(force.max()), "–"),
            ("mean of places on debris", _force(_mean(force[flags])), second),
            ("mean of places without debris", _force(_mean(force[~flags])), "–"),
        ]
        share = 100 * force[flags].sum() / force.sum() if force.sum() else 0.0
        whose = f"debris in {int(flags.sum())} of {flags.size} places carries {share:.0f} % of it"
        whose = whose if flags.any() else "no place holds debris"
        title = f"Figure {int(name[-2:])}. Contact force at δ = {float(at['delta']):g} nm: {whose}"
        figure, (ax,) = run.sheet(title, aspect=0.66, rows=rows)
        distribution(at, "force", ax=ax, kde=False)
        return figure

    return draw


def _figure_13(run):
    rough, smooth = run["solutions/direct"], run["solutions/smooth"]
    ratio = mean_ratio(rough, smooth)
    edge = 10.0 if run.paper else float(ratio["delta"][ratio.size // 2])
    low = float(ratio.where(ratio["delta"] < edge).max())
    rows = [
        (f"rough / smooth, largest for δ < {edge:g} nm", number(low, digits=2), "< 0.1"),
        (
            f"rough / smooth at δ = {float(ratio['delta'][-1]):g} nm",
            number(float(ratio[-1]), digits=2),
            "about 0.25",
        ),
    ]
    most, least = 100 * (1 - float(ratio.min())), 100 * (1 - float(ratio.max()))
    title = f"Figure 13. Roughness takes {least:.0f} to {most:.0f} % of the contact force away"
    figure, (upper, lower) = _stacked(run, title, rows)
    mean_force({"rough, mean of all subregions": rough, "smooth flat at the datum": smooth}, ax=upper)
    force_ratio(rough, smooth, ax=lower, words="rough / smooth")
    lower.set_ylim(bottom=0)
    upper.set_xlabel("")
    return figure


def _figure_14(run):
    direct, superposed, clean = run["solutions/direct"], run["solutions/hertz"], ~run.debris()
    ratio = 1 / mean_ratio(direct, superposed, where=clean)
    printed = {10.0: "about 1", 12.0: "begin to part", 15.4: "> 1"}
    if not run.paper:
        printed = {float(delta): "" for delta in ratio["delta"].values[[ratio.size // 2, -1]]}
    rows = [
        (f"superposition / direct at δ = {delta:g} nm", number(_at(ratio, delta), digits=2), words)
        for delta, words in printed.items()
    ]
    title = f"Figure 14. {_parting(ratio)} ({int(clean.sum())} of {clean.size} places, no debris)"
    figure, (upper, lower) = _stacked(run, title, rows)
    span = slice(0, float(direct["delta"].max()))
    mean_force(
        {"direct simulation": direct, "superposed asperities": superposed.sel(delta=span)},
        where=clean,
        ax=upper,
    )
    upper.set_yscale("log")
    upper.set_ylim(bottom=1e-5 * upper.get_ylim()[1])
    begun = ratio["delta"].values[np.isfinite(ratio.values)]
    if begun.size > 1:
        upper.set_xlim(begun[0] - 0.1 * np.ptp(begun), begun[-1] + 0.03 * np.ptp(begun))
    label_axis(upper.yaxis, "force")
    _inverse_ratio(lower, ratio)
    upper.set_xlabel("")
    return figure


def _parting(ratio: xr.DataArray) -> str:
    """Return a sentence on the displacement from which on superposition exceeds the direct simulation by a fifth."""
    close = np.flatnonzero((ratio <= 1.2).values)
    beyond = ratio["delta"].values[close[-1] + 1 :] if close.size else ratio["delta"].values
    if beyond.size == 0:
        return "Superposition overrates the force by no more than a fifth"
    return f"Superposition overrates the force by more than a fifth from δ = {beyond[0]:g} nm on"


def _figure_15(run):
    published, pull = run["solutions/published"], {}
    found = run["statistics/published"]["pull_off_force"]
    clean = found.where(~run.debris("solutions/published"), 0).fillna(0)
    where = int(found["subregion"][int(clean.argmax("subregion"))])
    for key in ("published", "energy"):
        pull[key] = float(run[f"statistics/{key}"]["pull_off_force"].sel(subregion=where))
    smooth = -float(jkr_sphere(published, np.linspace(-100, 0, 4001)).min())
    force = published["force"].sel(subregion=where)
    rows = [
        ("pull-off, as published", _force(pull["published"]), "8.6 µN"),
        ("pull-off, least energy", _force(pull["energy"]), "–"),
        ("pull-off, smooth sphere", _force(smooth), "19.1 µN"),
        (
            "pulls up to δ, as published",
            number(float(force["delta"].where(force < 0).max()), "nm"),
            "12.4 nm",
        ),
        ("exceeds the smooth sphere beyond δ", number(_crossing(force, published), "nm"), "18 nm"),
    ]
    title = f"Figure 15. The place without debris that sticks most as published (subregion {where}), by every law"
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


def _figure_16(run):
    figures = {key: run[f"statistics/{key}"] for key in _FORMULATIONS}
    rows = []
    for key, words in _FORMULATIONS.items():
        printed = ("2.0 ± 1.37 µN", "9.7 ± 2.52 nm") if key == "published" else ("–", "–")
        force, delta = figures[key]["pull_off_force"].values, figures[key]["pull_off_delta"].values
        rows.append((f"force, {words}", _forces(force), printed[0]))
        rows.append((f"displacement, {words}", mean_and_spread(delta, "nm"), printed[1]))
    rows.sort(key=lambda row: row[0].startswith("displacement"))
    title = "Figure 16. Pull-off forces over all places: what the place and the slip in the formula are worth"
    figure, axes = run.sheet(title, shape=(3, 1), aspect=1.2, rows=rows, sharex=True)
    largest = max(float(one["pull_off_force"].max()) for one in figures.values())
    for order, (ax, (key, words)) in enumerate(zip(axes, _FORMULATIONS.items())):
        ax.set_xlim(0, 1.05 * largest if np.isfinite(largest) and largest > 0 else 1)
        _one_formulation(ax, figures[key], words, order, last=order == len(axes) - 1)
    return figure


def _one_formulation(ax, pull: xr.Dataset, words: str, order: int, *, last: bool):
    """Draw the pull-off forces of one formulation as one of several panels with a common axis of forces."""
    distribution(pull, "pull_off_force", ax=ax, order=order, kde=False, rug=False, interval=None)
    mean = float(pull["pull_off_force"].mean())
    ax.axvline(mean, **{**stroke(order), "linewidth": 1.0})
    ax.text(0.98, 0.9, f"{words}\nmean {_force(mean)}", transform=ax.transAxes, ha="right", va="top", fontsize=SMALL)
    if not last:
        ax.set_xlabel("")
    if order != 1:
        ax.set_ylabel("")


def _stacked(run: _Groups, title: str, rows):
    """Return a sheet with forces above and their ratio below."""
    return run.sheet(title, shape=(2, 1), aspect=0.98, rows=rows, height_ratios=[2.2, 1], sharex=True)


def _inverse_ratio(ax, ratio: xr.DataArray):
    """Draw a ratio that grows without bound on a logarithmic axis, with a line at agreement."""
    from matplotlib.ticker import LogLocator

    ax.axhline(1, color=GREY, linewidth=0.6)
    ax.plot(ratio["delta"], ratio, marker="s", markersize=2.6, **stroke(1))
    ax.set_yscale("log")
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_formatter("")
    ax.set_ylabel("superposed / direct")
    label_axis(ax.xaxis, "delta")


def _at(ratio: xr.DataArray, delta: float) -> float:
    """Return the ratio at a displacement that was solved, NaN at any other."""
    near = ratio.sel(delta=delta, method="nearest")
    return float(near) if np.isclose(near["delta"], delta) else np.nan


def _force(value: float) -> str:
    """Return a force (nN) in a suitable unit."""
    unit = display_unit("nN", abs(value))
    return number(value / unit.size, unit.text)


def _forces(values: np.ndarray) -> str:
    """Return mean and standard deviation of forces (nN) in a unit that suits the largest."""
    unit = display_unit("nN", float(np.nanmax(np.abs(values), initial=0.0)))
    return mean_and_spread(values, unit.text, size=unit.size)


def _mean(values: np.ndarray) -> float:
    return float(np.mean(values)) if values.size else np.nan


_FIGURES: dict[str, Callable] = {
    "figure-02": _figure_02,
    "figure-03": _figure_03,
    "figure-04": _figure_04,
    "figure-05": _figure_05,
    "figure-06": _figure_06,
    "figure-07": _figure_07,
    "figure-08": _figure_08,
    "figure-09": _figure_09,
    "figure-10": _figure_10,
    "figure-11": _force_distribution("figure-11"),
    "figure-12": _force_distribution("figure-12"),
    "figure-13": _figure_13,
    "figure-14": _figure_14,
    "figure-15": _figure_15,
    "figure-16": _figure_16,
}

#: The figures that make sense for any scan, and their names.
_NAMES = {
    "figure-06": "scan",
    "figure-07": "places",
    "figure-08": "reconstruction",
    "figure-09": "asperities",
    "figure-10": "one-contact",
    "figure-11": "force-distribution",
    "figure-12": "force-distribution-deepest",
    "figure-13": "rough-over-smooth",
    "figure-14": "superposed-over-direct",
    "figure-15": "place-that-sticks-most",
    "figure-16": "pull-off",
}
