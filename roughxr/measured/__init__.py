"""Measured beside predicted: pull-off forces from the instrument, compared with those that a scan predicts.

One room each: `opening` (which file holds what), `several` (files as one), `tables`, `vendor_scales` (of images that
are no lengths), `forces` (units and signs); `curves`, `curve_files` and `curve_reader` (curves as recorded),
`force_curves`, `baselines` and `kept_curves` (what they tell); `comparison`, `registration`; `fitting` and
`fitting_held` by `matching`; `elsewhere` (one fit that must hold on other surfaces).
"""

from .comparison import against
from .curves import open_curves
from .elsewhere import predict_others
from .fitting import fit_work_of_adhesion
from .fitting_held import fit_adhesion_range, fit_hardness
from .force_curves import ImplausibleCurves, curves_pull_off
from .opening import open_pull_off

__all__ = [
    "ImplausibleCurves",
    "against",
    "curves_pull_off",
    "fit_adhesion_range",
    "fit_hardness",
    "fit_work_of_adhesion",
    "open_curves",
    "open_pull_off",
    "predict_others",
]
