"""Scans: reading AFM files, levelling, roughness and spectra, editing, export."""

from .application.samples import open_sample
from .files.images.backend import RoughxrBackend, open_scan
from .files.images.channel import UnreadableScan
from .files.images.container import open_container
from .files.images.description import describe
from .files.images.export import to_file, to_netcdf
from .mechanics.scans import regions, synthetic
from .mechanics.scans.combined_spectra import combined_spectrum
from .mechanics.scans.editing import crop, fill, resample
from .mechanics.scans.fine_scales import self_affine_fit, smooth
from .mechanics.scans.levelling import level
from .mechanics.scans.plausibility import ImplausibleScan
from .mechanics.scans.roughness_parameters import roughness
from .mechanics.scans.spectra import power_spectrum
from .mechanics.scans.tip import dilate, erode, tip_flags
from .mechanics.vocabulary.calls import public_functions

__all__ = [
    "ImplausibleScan",
    "RoughxrBackend",
    "UnreadableScan",
    "combined_spectrum",
    "crop",
    "describe",
    "dilate",
    "erode",
    "fill",
    "level",
    "open_container",
    "open_sample",
    "open_scan",
    "power_spectrum",
    "regions",
    "resample",
    "roughness",
    "self_affine_fit",
    "smooth",
    "synthetic",
    "tip_flags",
    "to_file",
    "to_netcdf",
]

globals().update(public_functions(globals(), __all__, __name__))
