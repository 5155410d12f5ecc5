"""Every public name; imported when the first of them is used, so that ``import roughxr`` takes little time."""

from . import detachment
from ._version import __version__
from .accessor import ContactAccessor
from .asperity.catalogue import asperities
from .asperity.maps import pull_off_map
from .asperity.moments import rolling
from .asperity.reconstruction import reconstruct
from .asperity.superposition import superpose
from .bodies.liquid import HumidAir
from .bodies.materials import assign_pair, contact_modulus, gilman_surface_energy, hamaker_constant
from .bodies.probes import fit_sphere, placements
from .contact import reference
from .contact.adhesion import adhesive
from .contact.elastic import direct
from .contact.estimates import tabor
from .contact.mesh import Mesh
from .contact.regimes import formulas, regime
from .contact.rigid_bodies import rigid
from .detachment import critical_load, resting, resuspension, to_dem
from .files import archive
from .jobs.lazy import compute
from .jobs.progress import progress
from .jobs.run import checkpointed
from .measured import (
    compare,
    curves_pull_off,
    fit_pair,
    open_curves,
    open_pull_off,
    predict_others,
)
from .presentation import figures, report
from .presentation.answer import answer
from .presentation.exports import to_table
from .presentation.figures import plot
from .reproduction import paper
from .runs.analysis import run
from .scans import (
    add_fine_roughness,
    autocorrelation,
    combined_spectrum,
    crop,
    fill,
    level,
    open_sample,
    open_scan,
    power_spectrum,
    regions,
    resample,
    rotate90,
    roughness,
    self_affine_fit,
    smooth,
    synthetic,
    to_file,
)
from .scans.tip import dilate, erode, tip_flags
from .statistics import bootstrap, cdf, debris, fit, force_ratio, pdf, pooled, pull_off, reduction, summary
from .studies.continuation import continued
from .studies.parameter_grid import vary
from .studies.sensitivities import error_budget, sensitivity
from .studies.several_scans import over_scans
from .studies.short_waves import scale_dependence
from .vocabulary import schema

__all__ = [
    "ContactAccessor",
    "HumidAir",
    "Mesh",
    "__version__",
    "add_fine_roughness",
    "adhesive",
    "answer",
    "archive",
    "asperities",
    "assign_pair",
    "autocorrelation",
    "bootstrap",
    "cdf",
    "checkpointed",
    "combined_spectrum",
    "compare",
    "compute",
    "contact_modulus",
    "continued",
    "critical_load",
    "crop",
    "curves_pull_off",
    "debris",
    "detachment",
    "dilate",
    "direct",
    "erode",
    "error_budget",
    "figures",
    "fill",
    "fit",
    "fit_pair",
    "fit_sphere",
    "force_ratio",
    "formulas",
    "gilman_surface_energy",
    "hamaker_constant",
    "level",
    "open_curves",
    "open_pull_off",
    "open_sample",
    "open_scan",
    "over_scans",
    "paper",
    "pdf",
    "placements",
    "plot",
    "pooled",
    "power_spectrum",
    "predict_others",
    "progress",
    "pull_off",
    "pull_off_map",
    "reconstruct",
    "reduction",
    "reference",
    "regime",
    "regions",
    "report",
    "resample",
    "resting",
    "resuspension",
    "rigid",
    "rolling",
    "rotate90",
    "roughness",
    "run",
    "scale_dependence",
    "schema",
    "self_affine_fit",
    "sensitivity",
    "smooth",
    "summary",
    "superpose",
    "synthetic",
    "tabor",
    "tip_flags",
    "to_dem",
    "to_file",
    "to_table",
    "vary",
]
