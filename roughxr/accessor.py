"""``ds.contact``: every verb of the library as a method, nothing more; shown, it says which verbs there are.

Each method is the plain function of the same name with the Dataset as its first argument.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import xarray as xr

from . import scans, statistics
from .asperity.catalogue import asperities
from .asperity.maps import pull_off_map
from .asperity.moments import rolling
from .asperity.reconstruction import reconstruct
from .asperity.superposition import superpose
from .bodies import probes
from .bodies.materials import assign_pair
from .contact.adhesion import adhesive
from .contact.elastic import direct
from .contact.estimates import tabor
from .contact.regimes import formulas, regime
from .contact.rigid_bodies import rigid
from .detachment import critical_load, resting, resuspension, to_dem
from .measured import compare, curves_pull_off, fit_pair
from .presentation import exports, figures
from .scans import tip
from .studies.parameter_grid import vary
from .studies.sensitivities import error_budget, sensitivity
from .studies.short_waves import scale_dependence
from .vocabulary import schema


def _method(function: Callable) -> Callable:
    """Return ``function`` as a method of the accessor, with its own help text and signature."""

    @functools.wraps(function)
    def method(self, *arguments, **options):
        return function(self._of, *arguments, **options)

    return method


@xr.register_dataset_accessor("contact")
class ContactAccessor:
    """Contact mechanics on scans, asperity catalogues and solutions."""

    def __init__(self, ds: xr.Dataset):
        self._of = ds

    def __repr__(self) -> str:
        kind = schema.kind_of(self._of) or "Dataset of no kind that roughxr knows"
        pair = [f"{name} {float(self._of[name]):g} {schema.VARIABLES[name].units}" for name in _assigned(self._of)]
        lines = [f"<roughxr: {kind}; {', '.join(pair) or 'no pair of bodies assigned'}>"]
        return "\n".join([*lines, *(f"  .{name:22s}{words}" for name, words in _verbs(type(self)).items())])

    # scans
    assign_pair = _method(assign_pair)
    level = _method(scans.level)
    fill = _method(scans.fill)
    crop = _method(scans.crop)
    resample = _method(scans.resample)
    rotate90 = _method(scans.rotate90)
    dilate = _method(tip.dilate)
    erode = _method(tip.erode)
    smooth = _method(scans.smooth)
    fit_sphere = _method(probes.fit_sphere)
    placements = _method(probes.placements)
    add_fine_roughness = _method(scans.add_fine_roughness)
    roughness = _method(scans.roughness)
    power_spectrum = _method(scans.power_spectrum)
    autocorrelation = _method(scans.autocorrelation)
    self_affine_fit = _method(scans.self_affine_fit)

    # contact
    asperities = _method(asperities)
    reconstruct = _method(reconstruct)
    superpose = _method(superpose)
    direct = _method(direct)
    adhesive = _method(adhesive)
    pull_off_map = _method(pull_off_map)
    rigid = _method(rigid)
    rolling = _method(rolling)
    regime = _method(regime)
    formulas = _method(formulas)
    scale_dependence = _method(scale_dependence)
    sensitivity = _method(sensitivity)
    error_budget = _method(error_budget)

    # coming off
    resting = _method(resting)
    critical_load = _method(critical_load)
    resuspension = _method(resuspension)

    # statistics
    pull_off = _method(statistics.pull_off)
    tabor = _method(tabor)
    tip_flags = _method(tip.tip_flags)
    pdf = _method(statistics.pdf)
    cdf = _method(statistics.cdf)
    fit = _method(statistics.fit)
    summary = _method(statistics.summary)
    bootstrap = _method(statistics.bootstrap)
    pooled = _method(statistics.pooled)
    reduction = _method(statistics.reduction)
    debris = _method(statistics.debris)

    # measured
    compare = _method(compare)
    curves_pull_off = _method(curves_pull_off)
    fit_pair = _method(fit_pair)

    vary = _method(vary)
    plot = _method(figures.plot)

    # files for others
    to_gsf = _method(scans.to_gsf)
    to_tiff = _method(scans.to_tiff)
    to_surfacetopography = _method(scans.to_surfacetopography)
    to_dem = _method(to_dem)
    to_table = _method(exports.to_table)


def _assigned(ds: xr.Dataset) -> list[str]:
    """Return which of the pair's scalars are on a Dataset."""
    return [name for name in schema.TRAVELLING if name in ds.coords and ds[name].ndim == 0]


def _verbs(accessor: type) -> dict[str, str]:
    """Return the accessor's verbs with the first sentence of what they say of themselves."""
    found = {name: value.__doc__ for name, value in vars(accessor).items() if callable(value) and name[0] != "_"}
    return {name: (words or "").strip().split("\n")[0] for name, words in found.items()}


@xr.register_dataarray_accessor("contact")
class ContactArrayAccessor:
    """Drawing of a single variable, such as a density."""

    def __init__(self, array: xr.DataArray):
        self._of = array

    def __repr__(self) -> str:
        return "\n".join(["<roughxr: a variable>", *(f"  .{k:22s}{v}" for k, v in _verbs(type(self)).items())])

    plot = _method(figures.plot_array)
