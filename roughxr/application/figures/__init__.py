"""Figures of results, one column of a paper wide, with units on every axis.

Each function takes Datasets and, as ``ax``, the Axes of the panel (a sequence of Axes for several panels), by default
those of a new figure, and returns the Axes. Legends stand above the Axes, and the title of ``ax.set_title`` above its
legend. matplotlib is imported at the first figure.
"""

from .any_result import plot
from .below_the_pixel import force_over_pixel
from .contact_fields import field_map
from .distributions import asperity_statistics, distribution
from .maps import scan_map, subregion_map
from .measured_figure import predicted_and_measured
from .particle_figures import fraction_remaining, moment_rose
from .run_figure import overview
from .sweeps import mean_force, sweep
from .uncertainty_bars import error_budget

__all__ = [
    "asperity_statistics",
    "distribution",
    "error_budget",
    "field_map",
    "force_over_pixel",
    "fraction_remaining",
    "mean_force",
    "moment_rose",
    "overview",
    "plot",
    "predicted_and_measured",
    "scan_map",
    "subregion_map",
    "sweep",
]
