# Public names of `roughxr.measured`, which `lazy_loader` imports on first use.

from .files.curves.curve_fit import fit_curve as fit_curve
from .files.curves.curves import open_curves as open_curves
from .files.curves.force_curves import ImplausibleCurves as ImplausibleCurves
from .files.curves.force_curves import curves_pull_off as curves_pull_off
from .files.curves.opening import open_pull_off as open_pull_off
from .mechanics.studies.comparison import compare as compare
from .mechanics.studies.fitting import fit_pair as fit_pair
