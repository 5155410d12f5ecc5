"""Measured pull-off forces: reading, comparison with predictions, and fits of the work of adhesion."""

from .files.curves.curve_fit import fit_curve
from .files.curves.curves import open_curves
from .files.curves.force_curves import ImplausibleCurves, curves_pull_off
from .files.curves.opening import open_pull_off
from .mechanics.studies.comparison import compare
from .mechanics.studies.fitting import fit_pair
from .mechanics.vocabulary.calls import public_functions

__all__ = [
    "ImplausibleCurves",
    "compare",
    "curves_pull_off",
    "fit_curve",
    "fit_pair",
    "open_curves",
    "open_pull_off",
]

globals().update(public_functions(globals(), __all__, __name__))
