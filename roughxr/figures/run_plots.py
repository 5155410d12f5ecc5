"""The figures of a run, a mapping of group names to Datasets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np
import xarray as xr

from ..scans import regions
from ..statistics import debris
from ..statistics.headline import best_estimate
from ..statistics.sampling import at_first_preload
from ..vocabulary.numbers import number, quantity
from ..vocabulary.verbs import verb
from .contact_fields import contact_maps
from .distributions import asperity_statistics, distribution
from .forces import force_ratio, mean_force, mean_ratio
from .maps import contact_grid, scan_map
from .saving import mean_and_spread, sheet
from .style import GREY, SMALL, display_unit, label_axis, log_ticks, stroke, styled

Run = Mapping[str, xr.Dataset]

#: Methods whose pull-off is drawn, the simulation first, and their labels.
_METHODS = {
    "adhesive": "simulation",
    "rigid": "rigid bodies",
    "energy": "superposed asperities",
    "menisci": "superposed asperities",
}


@verb
def run_figures(run: Run) -> Iterator[tuple[str, object]]:
    """Yield the figures of a run on any scan, named by what they show.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups "scan" (with its pair), "asperities", "reconstruction", "solutions/direct" (many subregions),
        "solutions/contact" (one, with fields), "solutions/smooth" (the sphere on a flat), "solutions/hertz"
        (superposed), and of "statistics/adhesive", "statistics/rigid" and "statistics/energy" those that there are.

    Yields
    ------
    (str, Figure)
        "scan", "places", …; the Figures belong to no pyplot window.

    Raises
    ------
    ValueError
        If a group that the next figure needs is missing.

    Examples
    --------
    >>> len(_FIGURES), next(iter(_FIGURES))
    (10, 'scan')
    """
    for name, draw in _FIGURES.items():
        yield name, drawn(name, draw, Groups(run))


@styled
def drawn(name: str, draw: Callable, run: Groups):
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


class Groups(dict[str, xr.Dataset]):
    """A run that raises a clear error for a missing group, and the sheets that its figures are drawn on."""

    def __missing__(self, name: str) -> xr.Dataset:
        raise MissingGroup(f"expected the group {name!r} in the run, found groups: {', '.join(self) or 'none'}")

    def sheet(self, title: str, **options):
        """Return a sheet with its panels."""
        return sheet(title, **options)

    def debris(self, name: str = "solutions/direct") -> np.ndarray:
        """Return which subregions of a solution hold debris."""
        return debris(self["asperities"], self[name]).values

    def pull_off(self, method: str) -> xr.Dataset:
        """Return the pull-off by a method, at the first preload."""
        return at_first_preload(self[f"statistics/{method}"])

    def solved_delta(self, share: float) -> float:
        """Return the displacement at this share of those of the direct simulation: 1, the last."""
        deltas = self["solutions/direct"]["delta"].values
        return float(deltas[min(int(share * deltas.size), deltas.size - 1)])


def scan_figure(run: Groups):
    """Draw the heights."""
    scan = run["scan"]
    height = scan["height"].values
    rows = [
        ("height, highest − lowest", number(float(np.ptp(height)), "nm")),
        ("mean distance from the datum, Rₐ", f"{np.abs(height).mean():.3f} nm"),
    ]
    side = regions.extent(scan)
    size = f"{(side[1] - side[0]) / 1e3:.3g} × {(side[3] - side[2]) / 1e3:.3g} µm"
    figure, (ax,) = run.sheet(f"The rough surface, {size}", aspect=0.84, rows=rows)
    scan_map(scan, ax=ax)
    return figure


def places(run: Groups):
    """Draw the contact centres on the scan."""
    direct = run["solutions/direct"]
    flags = run.debris()
    rows = [("contact centres", str(flags.size)), ("of which on debris (framed)", str(int(flags.sum())))]
    title = f"The {flags.size} contact centres, those on debris framed"
    figure, (ax,) = run.sheet(title, aspect=0.84, rows=rows)
    contact_grid(run["scan"], direct, highlight=flags, ax=ax)
    return figure


def reconstruction(run: Groups):
    """Draw the surface that the asperities alone would make."""
    original, envelope = run["scan"]["height"].values, run["reconstruction"]
    roughness = [f"{np.nanmean(np.abs(height)):.3f} nm" for height in (original, envelope["height"].values)]
    rows = [
        ("Rₐ of the scan", roughness[0]),
        ("Rₐ of the reconstruction", roughness[1]),
        ("rms difference", number(float(envelope.attrs["residual_rms"]), "nm")),
    ]
    words = (
        "Colour scale of the scan; a triangle at its end marks heights beyond it. Long streaks are single paraboloids "
        "fitted to the summit of a particle."
    )
    title = "The surface reconstructed from the asperities matches the peaks, not the valleys"
    figure, (ax,) = run.sheet(title, aspect=0.84, rows=rows, note=words)
    scan_map(envelope, ax=ax, limits=(original.min(), original.max()))
    return figure


def asperities(run: Groups):
    """Draw what the asperities are like."""
    catalogue = run["asperities"]
    height, ratio = catalogue["height"].values, catalogue["axis_ratio"].values
    lowest = debris(catalogue, run["solutions/direct"]).attrs["threshold_value"]
    groups = [height[height < lowest], height[height >= lowest]]
    rows = [
        ("mean height of the main group", mean_and_spread(groups[0], "nm", digits=1)),
        ("mean height of the debris", mean_and_spread(groups[1], "nm", digits=1)),
        ("axis ratio b/a", mean_and_spread(ratio, "")),
        ("less than ten times as long as wide", number(100 * np.nanmean(ratio[np.isfinite(ratio)] > 0.1), "%")),
    ]
    groups_found = "two groups of heights" if groups[1].size else "one group of heights"
    title = f"The {height.size} asperities: {groups_found}, contact ellipses rather than circles"
    figure, axes = run.sheet(title, shape=(2, 2), aspect=0.98, rows=rows)
    asperity_statistics(catalogue, ax=axes)
    return figure


def one_contact(run: Groups):
    """Draw the fields of one contact."""
    contact = run["solutions/contact"]
    delta = float(contact["delta"][-1])
    spots = _spots(contact["pressure"].isel(subregion=0, delta=-1).values)
    count = f"{spots} spots touch, and the surface between them sinks too" if spots > 1 else "one spot touches"
    if spots == 0:
        count = "nothing touches"
    x, y = (float(contact[f"subregion_{axis}"][0]) / 1e3 for axis in "xy")
    place = f"the place at x = {x:.3g}, y = {y:.3g} µm" if {"subregion_x", "subregion_y"} <= set(contact.coords) else ""
    title = f"{place.capitalize()}, δ = {number(delta, 'nm')}: {count}"
    figure, axes = run.sheet(title, shape=(2, 2), aspect=1.16)
    contact_maps(contact, run["scan"], subregion=int(contact["subregion"][0]), ax=axes)
    return figure


def _spots(pressure: np.ndarray) -> int:
    """Return the number of separate spots that carry pressure; pixels that meet at a corner belong to one spot."""
    from scipy.ndimage import label

    return label(pressure > 0, structure=np.ones((3, 3)))[1]


def force_distribution(run: Groups, *, share: float = 1.0, delta: float | None = None):
    """Draw the distribution of forces at one displacement (nm), by default at a share of those that were solved."""
    wanted = run.solved_delta(share) if delta is None else delta
    at = run["solutions/direct"].sel(delta=wanted, method="nearest")
    force, flags = at["force"].values, run.debris()
    rows = [
        (f"force over {force.size} places", as_forces(force)),
        ("largest force", quantity(force.max())),
        ("mean of places on debris", quantity(_mean(force[flags]))),
        ("mean of places without debris", quantity(_mean(force[~flags]))),
    ]
    carried = 100 * force[flags].sum() / force.sum() if force.sum() else 0.0
    whose = f"debris in {int(flags.sum())} of {flags.size} places carries {carried:.0f} % of it"
    whose = whose if flags.any() else f"{force.size} places, none on debris"
    figure, (ax,) = run.sheet(f"Contact force at δ = {number(at['delta'], 'nm')}: {whose}", aspect=0.66, rows=rows)
    distribution(at, "force", ax=ax, kde=False)
    return figure


def rough_over_smooth(run: Groups, *, edge: float | None = None):
    """Draw the mean force on rough and smooth ground, and their ratio; its largest value is told below an edge (nm)."""
    rough, smooth = run["solutions/direct"], run["solutions/smooth"]
    ratio = mean_ratio(rough, smooth)
    edge = float(ratio["delta"][ratio.size // 2]) if edge is None else edge
    low = float(ratio.where(ratio["delta"] < edge).max())
    rows = [
        (f"rough / smooth, largest for δ < {number(edge, 'nm')}", number(low, digits=2)),
        (f"rough / smooth at δ = {number(ratio['delta'][-1], 'nm')}", number(float(ratio[-1]), digits=2)),
    ]
    most, least = 100 * (1 - float(ratio.min())), 100 * (1 - float(ratio.max()))
    title = f"Roughness lowers the contact force by {least:.0f} to {most:.0f} %"
    figure, (upper, lower) = _stacked(run, title, rows)
    mean_force({"rough, mean of all places": rough, "smooth flat at the datum": smooth}, ax=upper)
    force_ratio(rough, smooth, ax=lower, words="rough / smooth")
    lower.set_ylim(bottom=0)
    upper.set_xlabel("")
    return figure


def superposed_over_direct(run: Groups, *, deltas: Sequence[float] = ()):
    """Draw both mean forces without adhesion, and their ratio, which is told at some displacements (nm)."""
    direct, superposed, clean = run["solutions/direct"], run["solutions/hertz"], ~run.debris()
    ratio = 1 / mean_ratio(direct, superposed, where=clean)
    rows = [
        (f"superposition / direct at δ = {number(delta, 'nm')}", number(_at(ratio, delta), digits=2))
        for delta in deltas or ratio["delta"].values[[ratio.size // 2, -1]]
    ]
    title = f"{_parting(ratio)} ({int(clean.sum())} of {clean.size} places, no debris)"
    figure, (upper, lower) = _stacked(run, title, rows)
    span = slice(0, float(direct["delta"].max()))
    mean_force(
        {"direct simulation": direct, "superposed asperities": superposed.sel(delta=span)}, where=clean, ax=upper
    )
    upper.set_yscale("log")
    highest = upper.get_ylim()[1]
    upper.set_ylim(1e-5 * highest, 8 * highest)  # the legend stands above the curves
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
        return "Superposition overestimates the force by no more than 20 %"
    return f"Superposition overestimates the force by more than 20 % from δ = {number(beyond[0], 'nm')} on"


def pull_offs(run: Groups, methods: Mapping[str, str], title: str):
    """Draw the pull-off forces of several methods below one another, with a common axis of forces."""
    pulls = {key: run.pull_off(key) for key in methods}
    forces = [
        (f"force, {words} ± std", as_forces(pulls[key]["pull_off_force"].values)) for key, words in methods.items()
    ]
    deltas = [
        (f"displacement, {words} ± std", mean_and_spread(pulls[key]["pull_off_delta"].values, "nm"))
        for key, words in methods.items()
        if pulls[key].attrs.get("datum") != "first_contact"  # counted from elsewhere than the others'
    ]
    if known := best_estimate(run):
        forces = [("mean force, best estimate", quantity(known[0])), *forces]
    options = {"shape": (len(methods), 1), "aspect": 0.4 * len(methods), "rows": forces + deltas, "sharex": True}
    figure, axes = run.sheet(title, **options)
    largest = max(float(one["pull_off_force"].max()) for one in pulls.values())
    for order, (ax, (key, words)) in enumerate(zip(axes, methods.items())):
        ax.set_xlim(0, 1.05 * largest if np.isfinite(largest) and largest > 0 else 1)
        _one_method(ax, pulls[key], words, order, last=order == len(axes) - 1)
    return figure


def _pull_off(run: Groups):
    methods = {key: words for key, words in _METHODS.items() if f"statistics/{key}" in run}
    return pull_offs(run, methods or {"energy": _METHODS["energy"]}, "Pull-off forces over all places, by method")


def _one_method(ax, pull: xr.Dataset, words: str, order: int, *, last: bool):
    """Draw the pull-off forces by one method as one of several panels with a common axis of forces."""
    distribution(pull, "pull_off_force", ax=ax, order=order, kde=False, rug=False, interval=None)
    mean = float(pull["pull_off_force"].mean())
    ax.axvline(mean, **{**stroke(order), "linewidth": 1.0})
    ax.set_title(f"{words}, mean {quantity(mean)}", fontsize=SMALL, loc="right")
    if not last:
        ax.set_xlabel("")
    if order != 1:
        ax.set_ylabel("")


def _stacked(run: Groups, title: str, rows):
    """Return a sheet with forces above and their ratio below."""
    return run.sheet(title, shape=(2, 1), aspect=0.98, rows=rows, height_ratios=[2.2, 1], sharex=True)


def _inverse_ratio(ax, ratio: xr.DataArray):
    """Draw a ratio that grows without bound on a logarithmic axis, with a line at agreement."""
    ax.axhline(1, color=GREY, linewidth=0.6)
    ax.plot(ratio["delta"], ratio, marker="s", markersize=2.6, **stroke(1))
    ax.set_yscale("log")
    log_ticks(ax.yaxis)
    ax.set_ylabel("superposed / direct")
    label_axis(ax.xaxis, "delta")


def _at(ratio: xr.DataArray, delta: float) -> float:
    """Return the ratio at a displacement that was solved, NaN at any other."""
    near = ratio.sel(delta=delta, method="nearest")
    return float(near) if np.isclose(near["delta"], delta) else np.nan


def as_forces(values: np.ndarray) -> str:
    """Return mean and standard deviation of forces (nN) in a unit that suits the largest."""
    unit = display_unit("nN", float(np.nanmax(np.abs(values), initial=0.0)))
    return mean_and_spread(values, unit.text, size=unit.size)


def _mean(values: np.ndarray) -> float:
    return float(np.mean(values)) if values.size else np.nan


#: By name; each takes Groups. Distributions of force are drawn at the middle and the last displacement.
_FIGURES: dict[str, Callable] = {
    "scan": scan_figure,
    "places": places,
    "reconstruction": reconstruction,
    "asperities": asperities,
    "one-contact": one_contact,
    "force-distribution": partial(force_distribution, share=0.5),
    "force-distribution-deepest": partial(force_distribution, share=1.0),
    "rough-over-smooth": rough_over_smooth,
    "superposed-over-direct": superposed_over_direct,
    "pull-off": _pull_off,
}
