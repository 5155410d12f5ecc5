"""Measured beside predicted: pull-off forces from the instrument, compared with those that a scan predicts.

One room each: `opening` (which file holds what), `tables`, `curve_tables`, `vendor_scales` (of images that are no
lengths), `forces` (units and signs), `force_curves`, `comparison`, `registration`, `fitting`.
"""

from .comparison import against
from .curve_tables import open_curves
from .fitting import fit_work_of_adhesion
from .force_curves import curves_pull_off
from .opening import open_pull_off

__all__ = ["against", "curves_pull_off", "fit_work_of_adhesion", "open_curves", "open_pull_off"]
