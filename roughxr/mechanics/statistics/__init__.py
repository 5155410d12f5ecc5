"""Statistics over places: pull-off forces, distributions and their uncertainty.

sampling          dimension, places and weights of the samples
pull_off_events   pull-off forces of solutions, and their reduction by roughness
densities         probability densities and cumulative distributions
summaries         mean, standard deviation, extremes and quantiles
laws              fits of distributions such as Weibull's
places            effective sample size of correlated places
uncertainty       bootstrap of as many draws as places are independent
pooling           several scans together
force_ratios      superposed forces over those of the simulation
means             the mean pull-off force, its interval and its numerical error
censoring         estimates of samples that are known by limits
"""

from .densities import cdf, pdf
from .force_ratios import force_ratio
from .laws import LAWS, fit
from .pooling import pooled
from .pull_off_events import pull_off, reduction, smooth_pull_off
from .summaries import summary
from .uncertainty import bootstrap

__all__ = [
    "LAWS",
    "bootstrap",
    "cdf",
    "fit",
    "force_ratio",
    "pdf",
    "pooled",
    "pull_off",
    "reduction",
    "smooth_pull_off",
    "summary",
]
