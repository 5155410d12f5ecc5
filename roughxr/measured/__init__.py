"""Measured pull-off forces: reading, comparison with predictions, and fits of the work of adhesion.

opening                              any file of measured forces, one or many
force_tables, vendor_scales, forces  tables; images of adhesion and their scales; units and signs of forces
curves, curve_files, curve_reader    recorded force-distance curves
segments                             approach and retraction of a curve
force_curves, baselines              pull-off forces from curves
comparison                           measured and predicted forces, by statistics and distributions
curve_fit                            modulus and work of adhesion, fitted to curves
fitting, likelihood                  work of adhesion, fitted to measured pull-offs
"""

from .comparison import compare
from .curve_fit import fit_curve
from .curves import open_curves
from .fitting import fit_pair
from .force_curves import ImplausibleCurves, curves_pull_off
from .opening import open_pull_off

__all__ = [
    "ImplausibleCurves",
    "compare",
    "curves_pull_off",
    "fit_curve",
    "fit_pair",
    "open_curves",
    "open_pull_off",
]
