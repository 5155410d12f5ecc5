"""From many places to distributions: pull-off, densities, laws, and how far each of them can be trusted.

One room each: `samples` (what is counted, and where it lies), `pull_off`, `densities`, `summaries`, `laws`,
`places` (how many independent ones), `uncertainty` (bootstrap), `pooling` (several scans), `debris`, `comparison`
(superposed against direct).
"""

from .comparison import compare
from .debris_rule import debris, with_and_without
from .densities import cdf, pdf
from .laws import LAWS, fit, law_density
from .pooling import pooled
from .pull_off_events import pull_off, reduction, smooth_pull_off
from .sampling import SAMPLES
from .summaries import summary
from .uncertainty import bootstrap, bootstrap_sweep, density_intervals

__all__ = [
    "LAWS",
    "SAMPLES",
    "bootstrap",
    "bootstrap_sweep",
    "cdf",
    "compare",
    "debris",
    "density_intervals",
    "fit",
    "law_density",
    "pdf",
    "pooled",
    "pull_off",
    "reduction",
    "smooth_pull_off",
    "summary",
    "with_and_without",
]
