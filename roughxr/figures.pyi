# Public names of `roughxr.figures`, which `lazy_loader` imports on first use.

from .application.figures.any_result import plot as plot
from .application.figures.below_the_pixel import force_over_pixel as force_over_pixel
from .application.figures.contact_fields import field_map as field_map
from .application.figures.distributions import asperity_statistics as asperity_statistics
from .application.figures.distributions import distribution as distribution
from .application.figures.maps import scan_map as scan_map
from .application.figures.maps import subregion_map as subregion_map
from .application.figures.measured_figure import predicted_and_measured as predicted_and_measured
from .application.figures.particle_figures import fraction_remaining as fraction_remaining
from .application.figures.particle_figures import moment_rose as moment_rose
from .application.figures.run_figure import overview as overview
from .application.figures.sweeps import mean_force as mean_force
from .application.figures.sweeps import sweep as sweep
from .application.figures.uncertainty_bars import error_budget as error_budget
