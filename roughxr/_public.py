"""Every public name; imported when the first of them is used, so that ``import roughxr`` takes little time."""

from . import archive, figures, measured, particles, report, scans, statistics
from ._version import __version__
from .asperity.catalogue import asperities
from .asperity.maps import pull_off_map
from .asperity.moments import rolling
from .asperity.reconstruction import reconstruct
from .asperity.superposition import superpose
from .bodies.indenter import fit_sphere, placements
from .bodies.liquid import HumidAir
from .bodies.pair import assign_pair
from .contact import reference
from .contact.adhesion import adhesive
from .contact.certificate import certificate
from .contact.elastic import direct
from .contact.mesh import Mesh
from .contact.regimes import formulas, regime
from .contact.rigid.bodies import rigid
from .figures import plot
from .jobs.lazy import compute
from .jobs.progress import progress
from .jobs.run import checkpointed
from .measured import compare, fit_pair, open_pull_off
from .particles import critical_load, resting, resuspension
from .runs.analysis import run
from .scans import fill, level, open_sample, open_scan, roughness
from .statistics import bootstrap, fit, pdf, pull_off, summary
from .statistics.headline import answer
from .studies.extrapolation import extrapolated
from .studies.parameter_grid import vary
from .studies.several_scans import over_scans
from .studies.short_waves import scale_dependence
from .studies.uncertainty_budget import error_budget
from .tables import to_table
from .vocabulary import schema

__all__ = [
    "HumidAir",
    "Mesh",
    "__version__",
    "adhesive",
    "answer",
    "archive",
    "asperities",
    "assign_pair",
    "bootstrap",
    "certificate",
    "checkpointed",
    "compare",
    "compute",
    "critical_load",
    "direct",
    "error_budget",
    "extrapolated",
    "figures",
    "fill",
    "fit",
    "fit_pair",
    "fit_sphere",
    "formulas",
    "level",
    "measured",
    "open_pull_off",
    "open_sample",
    "open_scan",
    "over_scans",
    "particles",
    "pdf",
    "placements",
    "plot",
    "progress",
    "pull_off",
    "pull_off_map",
    "reconstruct",
    "reference",
    "regime",
    "report",
    "resting",
    "resuspension",
    "rigid",
    "rolling",
    "roughness",
    "run",
    "scale_dependence",
    "scans",
    "schema",
    "statistics",
    "summary",
    "superpose",
    "to_table",
    "vary",
]
