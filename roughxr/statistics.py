"""Statistics over places: pull-off forces, distributions and their uncertainty."""

from .mechanics.statistics.debris_rule import debris
from .mechanics.statistics.densities import cdf, pdf
from .mechanics.statistics.force_ratios import force_ratio
from .mechanics.statistics.laws import LAWS, fit
from .mechanics.statistics.pooling import pooled
from .mechanics.statistics.pull_off_events import pull_off, reduction, smooth_pull_off
from .mechanics.statistics.summaries import summary
from .mechanics.statistics.uncertainty import bootstrap

__all__ = [
    "LAWS",
    "bootstrap",
    "cdf",
    "debris",
    "fit",
    "force_ratio",
    "pdf",
    "pooled",
    "pull_off",
    "reduction",
    "smooth_pull_off",
    "summary",
]
