"""Scans: reading AFM files, levelling, roughness and spectra, editing, export."""

from . import regions, synthetic
from .backend import RoughxrBackend, open_scan
from .channel import UnreadableScan
from .combined_spectra import combined_spectrum
from .container import open_container
from .description import describe
from .editing import crop, fill, resample
from .export import to_file, to_netcdf
from .fine_scales import self_affine_fit, smooth
from .levelling import level
from .plausibility import ImplausibleScan
from .roughness_parameters import roughness
from .samples import open_sample
from .spectra import power_spectrum
from .tip import dilate, erode, tip_flags

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
