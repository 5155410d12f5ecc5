"""The overview of a run: the scan, one contact on it and the pull-off forces."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ...mechanics.statistics.sampling import at_first_preload, mean_of_places
from ...mechanics.vocabulary.numbers import format_number
from ...mechanics.vocabulary.refusal import Refusal
from ..headline import best_estimate
from ..wording.intervals import bounds_in_words
from .contact_fields import field_map
from .distributions import distribution
from .maps import scan_map
from .style import BLACK, PAGE, TITLE, label_axis, styled

#: Group of a run that contains the fields of one contact at its pull-off.
PULL_OFF_CONTACT = "solutions/pull_off_contact"

#: Methods of the pull-off distributions, and their labels.
_METHODS = {"adhesive": "simulation, as scanned", "energy": "superposed asperities"}

#: Height of the last panel over its highest bar, with room for the legend.
_ROOM = 1.9


@styled
def overview(run: Mapping[str, xr.Dataset]):
    """Draw the scan with its contact centres, one contact at its pull-off, and the pull-off forces of a run.

    Takes the groups of a run, and returns a Figure that belongs to no pyplot window.

    Examples
    --------
    >>> import contextlib, io, tempfile
    >>> import roughxr
    >>> scan = roughxr.scans.synthetic.self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    >>> scan = scan.contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0)
    >>> with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
    ...     groups = roughxr.run(scan, folder + "/run.nc", subregions=(2, 1), delta=[1.0, 2.0])
    ...     panels = roughxr.figures.overview(groups).axes
    >>> len(panels)
    3
    """
    from matplotlib.figure import Figure

    if not isinstance(run, Mapping) or "scan" not in run:
        raise Refusal("run", "the groups of a run, from roughxr.archive.load", type(run).__name__)
    figure = Figure(figsize=(PAGE * 1.25, PAGE * 0.36), layout="constrained")
    heights, pressure, pull_off = panels = figure.subplots(1, 3, width_ratios=[1, 1, 1.25])
    scan_map(run["scan"], subregions=run["solutions/direct"], ax=heights)
    contact = run.get(PULL_OFF_CONTACT, run["solutions/contact"])
    field_map(contact, "pressure", scan=run["scan"], ax=pressure)
    _pull_offs(run, pull_off)
    delta = format_number(float(contact["delta"][0]), "nm")
    state = "pull-off" if PULL_OFF_CONTACT in run else f"δ = {delta}"
    for ax, title in zip(panels, ("Heights and contact centres", f"One contact, at {state}", "Pull-off force")):
        ax.set_title(title, fontsize=TITLE, fontweight="bold", pad=18)
    return figure


def _pull_offs(run: Mapping[str, xr.Dataset], ax) -> None:
    """Draw the distributions of pull-off forces with their means, the legend above them."""
    groups = {name: run[f"statistics/{name}"] for name in _METHODS if f"statistics/{name}" in run}
    samples = {name: ds for name, ds in groups.items() if int(ds["pull_off_force"].notnull().sum()) > 1}
    for order, (name, ds) in enumerate(samples.items()):
        distribution(ds, label=_METHODS[name], order=order, ax=ax)
    if not samples:
        alone = any(bool(ds["pull_off_force"].notnull().any()) for ds in groups.values())
        text = "one place with adhesion" if alone else "no place with adhesion"
        ax.text(0.5, 0.5, text, ha="center", va="center", transform=ax.transAxes)
        ax.set_axis_off()
        return
    unit, size = label_axis(ax.xaxis, "pull_off_force")
    means = {}
    for name, ds in samples.items():
        force = at_first_preload(ds["pull_off_force"])
        means[f"{_METHODS[name]} ({int(force.notnull().sum())})"] = mean_of_places(force)
    if (estimate := best_estimate(run)) is not None:
        _draw_estimate(ax, *estimate, unit, size)
    if np.isfinite(ax.dataLim.y1):
        ax.set_ylim(top=_ROOM * ax.dataLim.y1)
    handles, labels = ax.get_legend_handles_labels()
    labels = [
        f"{label}, mean {format_number(means[label] / size, unit)}" if label in means else label for label in labels
    ]
    ax.legend(handles, labels, loc="upper right", borderaxespad=0)


def _draw_estimate(ax, mean: float, low: float, high: float, unit: str, size: float) -> None:
    """Draw the best estimate of the mean with its interval, near the lower edge."""
    ends = bounds_in_words(low / size, high / size, unit)
    text = f"best estimate of the mean, with finer\nroughness, {format_number(mean / size, unit, 2)} ({ends})"
    style = {"fmt": "D", "color": BLACK, "transform": ax.get_xaxis_transform(), "zorder": 5}
    ax.errorbar([mean], [0.04], xerr=[[mean - low], [high - mean]], label=text, **style)
