"""``ds.contact``: every verb of the library as a method, nothing more.

Each method is the plain function of the same name with the Dataset as its first argument.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import xarray as xr

from .asperities import asperities
from .direct import direct
from .materials import assign_pair
from .reconstruction import reconstruct
from .scans import (
    autocorrelation,
    crop,
    fill,
    level,
    power_spectrum,
    resample,
    rotate90,
    roughness,
    to_gsf,
    to_surfacetopography,
)
from .statistics import pdf, pull_off, summary
from .superposition import superpose


def _method(function: Callable) -> Callable:
    """Return ``function`` as a method of the accessor, with its own help text and signature."""

    @functools.wraps(function)
    def method(self, *arguments, **options):
        return function(self._ds, *arguments, **options)

    return method


@xr.register_dataset_accessor("contact")
class ContactAccessor:
    """Contact mechanics on scans, asperity catalogues and solutions."""

    def __init__(self, ds: xr.Dataset):
        self._ds = ds

    assign_pair = _method(assign_pair)
    level = _method(level)
    fill = _method(fill)
    crop = _method(crop)
    resample = _method(resample)
    rotate90 = _method(rotate90)
    roughness = _method(roughness)
    power_spectrum = _method(power_spectrum)
    autocorrelation = _method(autocorrelation)
    to_gsf = _method(to_gsf)
    to_surfacetopography = _method(to_surfacetopography)
    asperities = _method(asperities)
    reconstruct = _method(reconstruct)
    superpose = _method(superpose)
    direct = _method(direct)
    pull_off = _method(pull_off)
    pdf = _method(pdf)
    summary = _method(summary)
