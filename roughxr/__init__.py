"""roughxr: how hard a small sphere presses, and how hard it sticks, wherever it lands on a rough surface.

Scans, asperity catalogues and contact solutions are labelled xarray Datasets; the functions here are also
methods of ``ds.contact``.

>>> import roughxr
>>> scan = roughxr.open_sample("glass").contact.assign_pair(
...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
>>> elastic = scan.contact.direct(delta=[5.08, 15.4], subregions=(2, 2))
>>> elastic.force.units
'nN'
"""

from . import archive, figures, regions, schema, synthetic
from ._version import __version__
from .accessor import ContactAccessor
from .asperities import asperities
from .direct import direct
from .materials import assign_pair, contact_modulus, gilman_surface_energy
from .parallel import compute
from .reconstruction import reconstruct
from .scans import (
    autocorrelation,
    crop,
    fill,
    level,
    open_sample,
    open_scan,
    power_spectrum,
    resample,
    rotate90,
    roughness,
    to_gsf,
    to_surfacetopography,
)
from .statistics import pdf, pull_off, summary
from .superposition import superpose

__all__ = [
    "ContactAccessor",
    "__version__",
    "archive",
    "asperities",
    "assign_pair",
    "autocorrelation",
    "compute",
    "contact_modulus",
    "crop",
    "direct",
    "figures",
    "fill",
    "gilman_surface_energy",
    "level",
    "open_sample",
    "open_scan",
    "pdf",
    "power_spectrum",
    "pull_off",
    "reconstruct",
    "regions",
    "resample",
    "rotate90",
    "roughness",
    "schema",
    "summary",
    "superpose",
    "synthetic",
    "to_gsf",
    "to_surfacetopography",
]
