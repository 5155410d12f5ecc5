"""Figures of results, one column of a paper wide, with units on every axis."""

from .application.figures.any_result import plot
from .application.figures.below_the_pixel import force_over_pixel
from .application.figures.contact_fields import field_map
from .application.figures.distributions import asperity_statistics, distribution
from .application.figures.maps import scan_map, subregion_map
from .application.figures.measured_figure import predicted_and_measured
from .application.figures.particle_figures import fraction_remaining, moment_rose
from .application.figures.run_figure import overview
from .application.figures.sweeps import mean_force, sweep
from .application.figures.uncertainty_bars import error_budget

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
