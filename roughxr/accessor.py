"""``ds.contact``: every verb of the library as a method, nothing more.

Each method is the plain function of the same name with the Dataset as its first argument.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import xarray as xr

from . import exports, scans, statistics, tip
from .catalogue import asperities
from .contact.adhesion import adhesive
from .contact.elastic import direct
from .contact.estimates import elastic_pull_off, tabor
from .contact.maps import pull_off_map
from .contact.superposition import superpose
from .materials import assign_pair
from .reconstruction import reconstruct
from .sensitivities import sensitivity


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

    # scans
    assign_pair = _method(assign_pair)
    level = _method(scans.level)
    fill = _method(scans.fill)
    crop = _method(scans.crop)
    resample = _method(scans.resample)
    rotate90 = _method(scans.rotate90)
    dilate = _method(tip.dilate)
    erode = _method(tip.erode)
    roughness = _method(scans.roughness)
    power_spectrum = _method(scans.power_spectrum)
    autocorrelation = _method(scans.autocorrelation)

    # contact
    asperities = _method(asperities)
    reconstruct = _method(reconstruct)
    superpose = _method(superpose)
    direct = _method(direct)
    adhesive = _method(adhesive)
    pull_off_map = _method(pull_off_map)
    sensitivity = _method(sensitivity)

    # statistics
    pull_off = _method(statistics.pull_off)
    elastic_pull_off = _method(elastic_pull_off)
    tabor = _method(tabor)
    tip_flags = _method(tip.tip_flags)
    pdf = _method(statistics.pdf)
    cdf = _method(statistics.cdf)
    fit = _method(statistics.fit)
    summary = _method(statistics.summary)
    bootstrap = _method(statistics.bootstrap)
    reduction = _method(statistics.reduction)
    debris = _method(statistics.debris)

    # files for others
    to_gsf = _method(scans.to_gsf)
    to_surfacetopography = _method(scans.to_surfacetopography)
    to_resuspension = _method(exports.to_resuspension)
    to_table = _method(exports.to_table)
