# Public names of `roughxr.statistics`, which `lazy_loader` imports on first use.

from .mechanics.statistics.debris_rule import debris as debris
from .mechanics.statistics.densities import cdf as cdf
from .mechanics.statistics.densities import pdf as pdf
from .mechanics.statistics.force_ratios import force_ratio as force_ratio
from .mechanics.statistics.laws import LAWS as LAWS
from .mechanics.statistics.laws import fit as fit
from .mechanics.statistics.pooling import pooled as pooled
from .mechanics.statistics.pull_off_events import pull_off as pull_off
from .mechanics.statistics.pull_off_events import reduction as reduction
from .mechanics.statistics.pull_off_events import smooth_pull_off as smooth_pull_off
from .mechanics.statistics.summaries import summary as summary
from .mechanics.statistics.uncertainty import bootstrap as bootstrap
