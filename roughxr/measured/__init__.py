"""Measured beside predicted: pull-off forces from the instrument, compared with those that a scan predicts."""

from .comparison import against
from .fitting import fit_work_of_adhesion
from .force_curves import curves_pull_off
from .opening import open_pull_off

__all__ = ["against", "curves_pull_off", "fit_work_of_adhesion", "open_pull_off"]
