"""Figures: every kind of result drawn for one column of a paper, units on every axis.

Each function takes Datasets and, as ``ax``, where to draw; it returns the Axes. matplotlib is imported only
when something is drawn.
"""

from .any_result import plot, plot_array
from .budget_figure import budget_figures, cut_off, error_budget
from .comparison import method_comparison
from .contact_fields import contact_maps, contact_section, field_map
from .detachment_figure import fraction_remaining, landed_and_at_rest, mode_map, moment_rose
from .distributions import asperity_statistics, distribution
from .fits import fitted_distribution
from .forces import against_hertz, force_fan, force_ratio, mean_force, sweep
from .maps import asperity_map, contact_grid, scan_map, subregion_map
from .measured_figure import predicted_and_measured, quantile_quantile
from .overview_figure import overview
from .rose import orientation_rose
from .run_plots import run_figures
from .saving import save
from .single import asperity_curve
from .yielding_figure import force_loop, preload_curve

__all__ = [
    "against_hertz",
    "asperity_curve",
    "asperity_map",
    "asperity_statistics",
    "budget_figures",
    "contact_grid",
    "contact_maps",
    "contact_section",
    "cut_off",
    "distribution",
    "error_budget",
    "field_map",
    "fitted_distribution",
    "force_fan",
    "force_loop",
    "force_ratio",
    "fraction_remaining",
    "landed_and_at_rest",
    "mean_force",
    "method_comparison",
    "mode_map",
    "moment_rose",
    "orientation_rose",
    "overview",
    "plot",
    "plot_array",
    "predicted_and_measured",
    "preload_curve",
    "quantile_quantile",
    "run_figures",
    "save",
    "scan_map",
    "subregion_map",
    "sweep",
]
