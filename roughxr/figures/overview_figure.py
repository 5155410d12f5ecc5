"""A run in one picture: the scan, one contact on it, and how hard the sphere sticks over all places."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr

from .distributions import distribution
from .maps import contact_grid, field_map
from .style import PAGE, TITLE, styled

#: Formulations drawn, and what they are called.
_SHOWN = {"published": "as published", "energy": "corrected, least energy"}


@styled
def overview(run: Mapping[str, xr.Dataset]):
    """Draw the scan with its contact centres, the pressure under one of them, and the pull-off forces.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run: "scan", "solutions/direct", "solutions/contact", "statistics/published" and
        "statistics/energy".

    Returns
    -------
    Figure
        Belongs to no pyplot window.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(PAGE * 1.25, PAGE * 0.42), layout="constrained")
    where, pressure, pull = figure.subplots(1, 3, width_ratios=[1, 1, 1.05])
    contact_grid(run["scan"], run["solutions/direct"], ax=where)
    contact = run["solutions/contact"]
    field_map(contact, "pressure", ax=pressure)
    for name, label in _SHOWN.items():
        distribution(run[f"statistics/{name}"], "pull_off_force", label=label, ax=pull, order=list(_SHOWN).index(name))
    delta = float(contact["delta"][0])
    titles = "Where the sphere lands", f"How hard it presses, at δ = {delta:g} nm", "How hard it sticks"
    for ax, title in zip((where, pressure, pull), titles):
        ax.set_title(title, fontsize=TITLE, fontweight="bold", pad=16)
    return figure
