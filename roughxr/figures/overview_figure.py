"""A run in one figure: the scan, one contact on it, and the pull-off forces over all places."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ..statistics.headline import best_estimate
from ..statistics.sampling import at_first_preload, by_share
from ..vocabulary.numbers import number, quantity
from .contact_fields import field_map
from .distributions import distribution
from .maps import contact_grid
from .style import BLACK, PAGE, TITLE, legend, styled

#: The methods that are drawn, and their labels.
_METHODS = {"adhesive": "simulation, as the scan shows it", "energy": "superposed, least energy"}


@styled
def overview(run: Mapping[str, xr.Dataset]):
    """Draw the scan with its contact centres, the pressure under one of them, and the pull-off forces.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run: "scan", "solutions/direct", "solutions/contact" and "statistics/energy", and
        "statistics/adhesive" and "statistics/extrapolated" if the run has them.

    Returns
    -------
    Figure
        Belongs to no pyplot window.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((32, 32), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    >>> scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40)
    >>> direct = roughxr.direct(scan, delta=[2.0], fields=True)
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [1.0, 2.0, 4.0], {"units": "nN"})})
    >>> run = {"scan": scan, "solutions/direct": direct, "solutions/contact": direct.isel(subregion=0)}
    >>> [ax.get_title("left") for ax in overview(run | {"statistics/energy": pull}).axes[:3]]
    ['The scan and the places', 'How hard it presses, at δ = 2 nm', 'How hard it sticks']
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(PAGE * 1.25, PAGE * 0.42), layout="constrained")
    where, pressure, pull = figure.subplots(1, 3, width_ratios=[1, 1, 1.05])
    contact_grid(run["scan"], run["solutions/direct"], ax=where)
    contact = run["solutions/contact"]
    field_map(contact, "pressure", ax=pressure)
    shown = {label: run[f"statistics/{name}"] for name, label in _METHODS.items() if f"statistics/{name}" in run}
    _pull_offs({_with_mean(label, ds): ds for label, ds in shown.items()}, pull)
    _best_estimate(run, pull)
    delta = float(contact["delta"][0])
    titles = "The scan and the places", f"How hard it presses, at δ = {number(delta, 'nm')}", "How hard it sticks"
    for ax, title in zip((where, pressure, pull), titles):
        ax.set_title(title, fontsize=TITLE, fontweight="bold", pad=22)
    return figure


def _with_mean(label: str, pull: xr.Dataset) -> str:
    """Return a method's name with its mean; that of the simulation as the scan shows the surface."""
    mean = float(by_share(at_first_preload(pull["pull_off_force"])).mean())
    return f"{label},\nmean {quantity(mean)}" if np.isfinite(mean) else label


def _pull_offs(pulls: Mapping[str, xr.Dataset], ax) -> None:
    """Draw the distributions with at least two places that pull, or write how few there are."""
    counts = {label: int(ds["pull_off_force"].notnull().sum()) for label, ds in pulls.items()}
    for order, (label, ds) in enumerate(pulls.items()):
        if counts[label] > 1:
            distribution(ds, "pull_off_force", label=label, ax=ax, order=order)
    if max(counts.values()) > 1:
        return
    words = "one place pulls" if max(counts.values()) else "no place pulls"
    ax.text(0.5, 0.5, words, ha="center", va="center", transform=ax.transAxes)
    ax.set_axis_off()


def _best_estimate(run: Mapping[str, xr.Dataset], ax) -> None:
    """Mark the mean with the roughness below the scan, and its interval, where the run extrapolated it."""
    if (known := best_estimate(run)) is None:
        return
    mean, *ends = known
    words = f"best estimate of the mean, {quantity(mean)}:\nroughness below the scan included"
    style = {"transform": ax.get_xaxis_transform(), "color": BLACK, "zorder": 5}
    ax.plot(ends, [0.04, 0.04], linewidth=1.2, **style)
    ax.plot([mean], [0.04], marker="D", markersize=4, linestyle="none", label=words, **style)
    legend(ax)
