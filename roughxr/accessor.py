"""The accessor ``ds.contact``: each method is the function of the same name with the Dataset as first argument."""

from __future__ import annotations

import functools
from collections.abc import Callable
from html import escape

import xarray as xr

from .application import figures
from .application import tables as exports
from .application.headline import answer
from .files.curves.curve_fit import fit_curve
from .mechanics import statistics
from .mechanics.asperity.catalogue import asperities
from .mechanics.asperity.moments import rolling
from .mechanics.asperity.pull_off_maps import pull_off_map
from .mechanics.asperity.reconstruction import reconstruct
from .mechanics.asperity.superposition import superpose
from .mechanics.bodies import indenter as probes
from .mechanics.bodies.pair import assign_pair
from .mechanics.contact.adhesion import adhesive
from .mechanics.contact.certificate import certificate
from .mechanics.contact.elastic import direct
from .mechanics.contact.regimes import formulas, regime
from .mechanics.contact.rigid.bodies import rigid
from .mechanics.particles import critical_load, resting, resuspension
from .mechanics.scans.editing import fill
from .mechanics.scans.levelling import level
from .mechanics.scans.roughness_parameters import roughness
from .mechanics.studies.comparison import compare
from .mechanics.studies.extrapolation import extrapolated
from .mechanics.studies.fitting import fit_pair
from .mechanics.studies.parameter_grid import vary
from .mechanics.studies.uncertainty_budget import error_budget
from .mechanics.vocabulary import schema
from .mechanics.vocabulary.calls import check_call, checked_call
from .mechanics.vocabulary.numbers import format_number
from .mechanics.vocabulary.text import did_you_mean


def _method(function: Callable) -> Callable:
    """Return ``function`` as a method of the accessor, with its own help text and signature."""

    @functools.wraps(checked_call(function))
    def method(self, *arguments, **options):
        check_call(function, arguments, options, f"ds.contact.{function.__name__}", given=1)
        return function(self._ds, *arguments, **options)

    return method


class ContactAccessor:
    """Contact mechanics on scans, asperity catalogues and solutions."""

    def __init__(self, ds: xr.Dataset):
        self._ds = ds

    def __repr__(self) -> str:
        lines = [f"<roughxr: {_described(self._ds)}>"]
        is_several = "solved_places" in self._ds and self._ds["solved_places"].ndim > 0  # with the first's sentence
        if "sentence" in self._ds.attrs and not is_several:
            lines.append(self._ds.attrs["sentence"])
        for group, verbs in _fitting(self._ds).items():
            if verbs:
                lines += [f"{group}:", *(f"  .{name:20s} {_words(type(self), name)}" for name in verbs)]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"

    def __dir__(self) -> list[str]:
        return sorted(name for verbs in _fitting(self._ds).values() for name in verbs)

    def __getattr__(self, name: str):
        # only for names that are no verb
        verbs = [verb for verb in vars(type(self)) if not verb.startswith("_")]
        raise AttributeError(f"contact: no verb {name!r}{did_you_mean(name, verbs)}; list them by print(ds.contact)")


#: Verbs by their use, the paper's first, each with the kinds of Datasets that it fits.
_GROUPS: dict[str, dict[Callable, str]] = {
    "the paper's": {
        assign_pair: "scan",
        level: "scan",
        fill: "scan",
        roughness: "scan",
        asperities: "scan",
        reconstruct: "scan",
        superpose: "scan asperities",
        direct: "scan",
        statistics.pull_off: "force pull_off",
        statistics.pdf: "samples",
        statistics.cdf: "samples",
        figures.plot: "any",
        exports.to_table: "any",
    },
    "adhesion": {
        adhesive: "scan",
        rigid: "scan",
        pull_off_map: "scan asperities",
        extrapolated: "scan",
        regime: "scan",
        formulas: "scan",
        certificate: "force pull_off",
        probes.fit_sphere: "scan",
        probes.placements: "scan",
    },
    "statistics": {
        answer: "force pull_off fitted",
        statistics.summary: "samples",
        statistics.bootstrap: "samples",
        statistics.fit: "samples",
        compare: "pull_off",
        fit_pair: "pull_off",
        fit_curve: "curves",
    },
    "particles": {
        resting: "scan",
        rolling: "scan asperities",
        critical_load: "moments",
        resuspension: "moments",
    },
    "studies": {
        vary: "scan",
        error_budget: "scan",
    },
}

for _verb in [verb for group in _GROUPS.values() for verb in group]:
    setattr(ContactAccessor, _verb.__name__, _method(_verb))


def _fitting(ds: xr.Dataset) -> dict[str, list[str]]:
    """Return the verbs that fit a Dataset, by its variables and dimensions, in their groups."""
    is_map = any(set(array.dims) == {"x", "y"} for array in ds.data_vars.values()) and "height" not in ds
    is_kind = {
        "scan": schema.kind_of(ds) == "scan",
        "asperities": "asperity" in ds.dims,
        "force": "force" in ds,
        "pull_off": "pull_off_force" in ds,
        "curves": "piezo" in ds,
        "fitted": "quantile_distance" in ds,
        "samples": is_map or bool({"subregion", "asperity"} & set(ds.dims)),
        "moments": "resisting_moment" in ds,
        "any": True,
    }
    return {
        group: [verb.__name__ for verb, kinds in verbs.items() if any(is_kind[kind] for kind in kinds.split())]
        for group, verbs in _GROUPS.items()
    }


def _described(ds: xr.Dataset) -> str:
    """Return the kind of a Dataset and its pair."""
    last = schema.history(ds)
    kind = schema.kind_of(ds) or (
        f"result of {last[-1]['operation']}" if last else "Dataset of no kind that roughxr knows"
    )
    scalars = {name: value for name, value in schema.pair_coordinates(ds).items() if value.ndim == 0}
    pair = [f"{name} {format_number(float(value), schema.VARIABLES[name].units)}" for name, value in scalars.items()]
    return f"{kind}; {', '.join(pair) or 'no pair of bodies assigned'}"


def _words(accessor: type, name: str) -> str:
    """Return the first line of a verb's docstring."""
    return (getattr(accessor, name).__doc__ or "").strip().split("\n")[0]


class ContactArrayAccessor:
    """Drawing and table of a single variable, such as a density."""

    def __init__(self, array: xr.DataArray):
        self._ds = array

    def __repr__(self) -> str:
        return "<roughxr: a variable>" + "".join(
            f"\n  .{name}  {_words(type(self), name)}" for name in ("plot", "to_table")
        )

    plot = _method(figures.plot)
    to_table = _method(exports.to_table)
