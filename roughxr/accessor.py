"""``ds.contact``: each verb is the plain function of the same name, with the Dataset as its first argument."""

from __future__ import annotations

import functools
from collections.abc import Callable
from html import escape

import xarray as xr

from . import figures, scans, statistics
from . import tables as exports
from .asperity.catalogue import asperities
from .asperity.maps import pull_off_map
from .asperity.moments import rolling
from .asperity.reconstruction import reconstruct
from .asperity.superposition import superpose
from .bodies import indenter as probes
from .bodies.pair import assign_pair
from .contact.adhesion import adhesive
from .contact.certificate import certificate
from .contact.elastic import direct
from .contact.regimes import formulas, regime
from .contact.rigid.bodies import rigid
from .measured import compare, fit_pair
from .particles import critical_load, resting, resuspension
from .statistics.headline import answer
from .studies.extrapolation import extrapolated
from .studies.parameter_grid import vary
from .studies.short_waves import scale_dependence
from .studies.uncertainty_budget import error_budget
from .vocabulary import schema
from .vocabulary.numbers import number


def _method(function: Callable) -> Callable:
    """Return ``function`` as a method of the accessor, with its own help text and signature."""

    @functools.wraps(function)
    def method(self, *arguments, **options):
        return function(self._of, *arguments, **options)

    return method


class ContactAccessor:
    """Contact mechanics on scans, asperity catalogues and solutions."""

    def __init__(self, ds: xr.Dataset):
        self._of = ds

    def __repr__(self) -> str:
        lines = [
            f"{title}\n" + "\n".join(f"  .{name:20s} {_words(type(self), name)}" for name in names)
            for title, names in _fitting(self._of)
        ]
        return "\n".join([f"<roughxr: {_described(self._of)}>", *lines])

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"

    def __dir__(self) -> list[str]:
        return sorted(name for _, names in _fitting(self._of) for name in names)

    # scans
    assign_pair = _method(assign_pair)
    level = _method(scans.level)
    fill = _method(scans.fill)
    fit_sphere = _method(probes.fit_sphere)
    placements = _method(probes.placements)
    roughness = _method(scans.roughness)

    # contact
    asperities = _method(asperities)
    reconstruct = _method(reconstruct)
    superpose = _method(superpose)
    direct = _method(direct)
    adhesive = _method(adhesive)
    pull_off_map = _method(pull_off_map)
    extrapolated = _method(extrapolated)
    rigid = _method(rigid)
    rolling = _method(rolling)
    regime = _method(regime)
    formulas = _method(formulas)
    scale_dependence = _method(scale_dependence)
    error_budget = _method(error_budget)

    # coming off
    resting = _method(resting)
    critical_load = _method(critical_load)
    resuspension = _method(resuspension)

    # statistics
    answer = _method(answer)
    certificate = _method(certificate)
    pull_off = _method(statistics.pull_off)
    pdf = _method(statistics.pdf)
    fit = _method(statistics.fit)
    summary = _method(statistics.summary)
    bootstrap = _method(statistics.bootstrap)

    # measured
    compare = _method(compare)
    fit_pair = _method(fit_pair)

    vary = _method(vary)
    plot = _method(figures.plot)

    to_table = _method(exports.to_table)


#: Verbs by task, and the kinds of Dataset that they take, see `_kinds`.
_TASKS: tuple[tuple[str, set[str], str], ...] = (
    ("the bodies", {"scan"}, "assign_pair fit_sphere placements"),
    ("the scan", {"scan"}, "level fill"),
    ("its roughness", {"scan"}, "roughness asperities"),
    ("its asperities", {"asperities"}, "reconstruct"),
    ("how hard it presses and sticks", {"scan"}, "adhesive extrapolated direct rigid resting"),
    ("the same by single asperities", {"scan", "asperities"}, "superpose pull_off_map rolling"),
    ("which model, and how sure", {"scan"}, "regime formulas vary error_budget scale_dependence"),
    ("the answer", {"force", "pull_off"}, "answer pull_off certificate"),
    ("over all places", {"samples", "map"}, "summary bootstrap pdf fit"),
    ("coming off", {"moments"}, "critical_load resuspension"),
    ("beside what was measured", {"pull_off"}, "compare fit_pair"),
    ("pictures and tables", {"any"}, "plot to_table"),
)


def _kinds(ds: xr.Dataset) -> set[str]:
    """Return what a Dataset is, by its variables and dimensions, for the verbs that fit it."""
    signs = {
        "scan": schema.kind_of(ds) == "scan",
        "map": any(set(array.dims) == {"x", "y"} for array in ds.data_vars.values()) and "height" not in ds,
        "asperities": "asperity" in ds.dims,
        "force": "force" in ds,
        "pull_off": "pull_off_force" in ds,
        "moments": "resisting_moment" in ds,
        "samples": bool({"subregion", "asperity"} & set(ds.dims)),
    }
    return {"any"} | {kind for kind, fits in signs.items() if fits}


def _fitting(ds: xr.Dataset) -> list[tuple[str, list[str]]]:
    """Return the verbs that fit a Dataset, by task."""
    kinds = _kinds(ds)
    return [(title, names.split()) for title, fits, names in _TASKS if fits & kinds]


def _described(ds: xr.Dataset) -> str:
    """Return the kind of a Dataset and its pair."""
    last = schema.history(ds)
    kind = schema.kind_of(ds) or (
        f"result of {last[-1]['operation']}" if last else "Dataset of no kind that roughxr knows"
    )
    scalars = {name: value for name, value in schema.travelling(ds).items() if value.ndim == 0}
    pair = [f"{name} {number(float(value), schema.VARIABLES[name].units)}" for name, value in scalars.items()]
    return f"{kind}; {', '.join(pair) or 'no pair of bodies assigned'}"


def _words(accessor: type, name: str) -> str:
    """Return the first sentence of what a verb says of itself."""
    return (getattr(accessor, name).__doc__ or "").strip().split("\n")[0]


class ContactArrayAccessor:
    """Drawing of a single variable, such as a density."""

    def __init__(self, array: xr.DataArray):
        self._of = array

    def __repr__(self) -> str:
        return f"<roughxr: a variable>\n  .plot  {_words(type(self), 'plot')}"

    plot = _method(figures.plot)
