"""Figures: every kind of result drawn for one column of a paper, units on every axis.

Each function takes Datasets and, as ``ax``, where to draw; it returns the Axes. matplotlib is imported only
when something is drawn.
"""

from .distributions import asperity_statistics, distribution
from .forces import against_hertz, force_fan, force_ratio, mean_force, sweep
from .maps import (
    asperity_map,
    contact_grid,
    contact_maps,
    contact_section,
    field_map,
    scan_map,
    subregion_map,
    topography_map,
)
from .overview import overview
from .paper import debris, paper_figures
from .sheet import save
from .single import asperity_curve

__all__ = [
    "against_hertz",
    "asperity_curve",
    "asperity_map",
    "asperity_statistics",
    "contact_grid",
    "contact_maps",
    "contact_section",
    "debris",
    "distribution",
    "field_map",
    "force_fan",
    "force_ratio",
    "mean_force",
    "overview",
    "paper_figures",
    "save",
    "scan_map",
    "subregion_map",
    "sweep",
    "topography_map",
]
