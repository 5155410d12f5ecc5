"""Cautions: sentences on what makes the numbers of a run doubtful."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.contact.certificate import SOLVED, certificate
from ...mechanics.contact.mesh import FRONT
from ...mechanics.contact.pressing import is_range
from ...mechanics.scans.plausibility import doubts
from ...mechanics.scans.tip import tip_flags
from ...mechanics.statistics import smooth_pull_off
from ...mechanics.statistics.means import mesh_error
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.error_sources import TIP_RADIUS
from ..wording import render_sentence
from .run_numbers import METHOD_WORDS, debris_flags
from .summary import BUDGET

Run = Mapping[str, xr.Dataset]

#: A sentence of `cautions.toml` by its name, and the values of its fields.
Caution = tuple[str, dict[str, Any]]

_FILE = "cautions.toml"

#: Share of unresolved contacts or asperities from which a caution is given.
_UNRESOLVED_SHARE = 0.05

#: Relative error of the mean pull-off by mesh and step above which a caution is given.
_LARGE_ERROR = 0.1

#: Share of the force above the hardness above which a caution is given.
_YIELDED_SHARE = 0.005

#: Radius of contacts at pull-off, in pixels, below which a caution is given.
_FEW_PIXELS = 2.0


def cautions(run: Run) -> list[str]:
    """Return cautions about the numbers of a run, given by its groups: a list of sentences, empty without a reason.

    Examples
    --------
    >>> import roughxr
    >>> roughxr.report.cautions({"scan": roughxr.open_sample("glass")})[0]
    'The scan is synthetic: ...'
    """
    run = {name: schema.in_package_units(ds) for name, ds in run.items()}
    return _sentences_of(caution for find in _FINDERS for caution in find(run))


def superposition_notes(run: Run) -> list[str]:
    """Return the reliability of the superposed pull-off, and the number of places where it exceeds its upper bound."""
    return _sentences_of(_superposed(run))


def _sentences_of(entries: Iterable[Caution]) -> list[str]:
    """Return the sentences of cautions, without those of which a value is not known."""
    return list(filter(None, (render_sentence(_FILE, name, values) for name, values in entries)))


def _superposed(run: Run) -> Iterator[Caution]:
    """Yield what is expected of superposed asperities, and the number of places where they exceed a smooth flat."""
    ds = run.get("solutions/energy", xr.Dataset())
    if not {"expected_ratio", "unknown_by"} & set(ds.attrs):
        return
    unknown_by = ds.attrs.get("unknown_by")
    values = {
        **ds.attrs,
        "places": ds.sizes.get("subregion"),
        "by_law": unknown_by == "law",
        "by_patch": unknown_by == "patch",
    }
    if "pull_off_force" in ds:
        values["places_above"] = int((ds["pull_off_force"] > smooth_pull_off(ds)).sum())
    yield "superposed", values


def _scan_doubts(run: Run) -> Iterator[Caution]:
    """Yield doubts about the scan, and the number of places with debris."""
    if "scan" in run:
        yield "synthetic", {"is_synthetic": schema.is_synthetic(run["scan"])}
        for doubt in doubts(run["scan"]):
            yield "doubt", {"doubt_of_scan": str(doubt)}
    flags = debris_flags(run)
    if flags is not None:
        count = int(flags.sum())
        yield "debris", {"places_on_debris": count, "places": flags.size, "share": flags.coords.get("debris_share")}


def _elastic(run: Run) -> Iterator[Caution]:
    """Yield cautions on a single place, on bodies that do not touch, and on contacts of too few pixels."""
    if "solutions/direct" not in run:
        return
    direct = run["solutions/direct"]
    yield "one_place", {"is_one": direct.sizes["subregion"] == 1}
    yield "no_touch", {"touches_nowhere": not bool((direct["force"] > 0).any())}
    if "scan" in run and "contact_area" in direct:
        area = direct["contact_area"].isel(delta=-1).values
        cell = float(np.prod(schema.pixel(run["scan"])))
        share = np.mean(area[area > 0] < 10 * cell) if (area > 0).any() else 0.0
        yield "few_pixels", {"share_of_contacts": share if share >= _UNRESOLVED_SHARE else None}


def _solved(run: Run) -> Iterator[Caution]:
    """Yield cautions on solutions that violate a contact condition, end too early, or need a finer mesh."""
    for name, ds in run.items():
        kind, _, method = name.partition("/")
        values: dict[str, Any] = {"method": METHOD_WORDS.get(method, method).capitalize()}
        if kind == "solutions" and method in SOLVED and "converged" in ds:
            yield "violated", {**values, "violations": _violations(ds)}
        if name in ("solutions/direct", "solutions/energy") and "truncated" in ds:
            flags = ds["truncated"].astype(bool)
            places = int(flags.any([dim for dim in flags.dims if dim == "delta"]).sum())
            yield "edge", {**values, "places_at_edge": places, "places": flags.sizes["subregion"]}
        if kind == "statistics" and "bracketed" in ds:
            adheres = ds["pull_off_force"].notnull()
            values["places"] = adheres.size
            values["places_beyond"] = int((adheres & ~ds["bracketed"].astype(bool)).sum())
            values["places_without"] = int((~adheres).sum())
            yield "sweep_ends", values
            yield "no_adhesion", values
    error = mesh_error(run["statistics/adhesive"]) if "statistics/adhesive" in run else np.nan
    yield "mesh", {"large_error": error if error > _LARGE_ERROR else None, "by_front": _is_by_front(run)}


def _violations(solved: xr.Dataset) -> str:
    """Return the conditions of the contact that a solution violates, with the violation of each and its limit."""
    conditions = certificate(solved)
    missed = ~(conditions.met | conditions.check.isin(["mesh", "truncated"]))
    rows = conditions.isel(check=missed.values)
    columns = zip(rows["check"].values.tolist(), rows["violation"].values, rows["limit"].values)
    return "; ".join(f"{check}: {violation:.2g} of at most {limit:.2g}" for check, violation, limit in columns)


def _settling(run: Run) -> Iterator[Caution]:
    """Yield a caution on places whose pull-off depends on how hard the sphere was pressed."""
    pull = run.get("statistics/adhesive", xr.Dataset())
    if "pressed_pull_off_force" in pull:
        depends = is_range(pull["pull_off_force"].values, pull["pressed_pull_off_force"].values)
        yield "ranges", {"places_with_range": int(depends.sum()), "places": depends.size}


def _yielding(run: Run) -> Iterator[Caution]:
    """Yield cautions on pressures above the hardness, and on results that ignore yield."""
    names = ("solutions/direct", "solutions/adhesive")
    groups = {name: run[name] for name in names if "yielded_fraction" in run.get(name, ())}
    if not groups:
        return
    shares = [render_sentence(_FILE, "above_hardness", _above_hardness(ds, name)) for name, ds in groups.items()]
    bodies = next(iter(groups.values())).coords
    values = {
        "shares": "; ".join(filter(None, shares)),
        "hardness": bodies.get("hardness"),
        "limit": bodies.get("hardness", bodies.get("hardness_estimate")),
        "is_plastic": any("plastic_work" in ds for ds in run.values()),
    }
    yield "yielding", values
    yield "elastic_methods", values


def _above_hardness(ds: xr.Dataset, name: str) -> dict[str, Any]:
    """Return the shares of area and force at the hardness and above; no force for a small share."""
    last = ds.isel(delta=-1) if "delta" in ds["yielded_fraction"].dims else ds
    force, area = (float(last[f"yielded{part}_fraction"].mean()) for part in ("", "_area"))
    is_direct = name == "solutions/direct"
    return {"force": force if force > _YIELDED_SHARE else None, "area": area, "at_largest_displacement": is_direct}


def _left_out(run: Run) -> Iterator[Caution]:
    """Yield what a run omits because a layer covers the surface."""
    yield "layer", {"is_coated": "solutions/adhesive" in run and schema.is_coated(run["scan"])}


def _is_by_front(run: Run) -> bool:
    """Return whether contacts of the run are followed by their front."""
    return "solutions/adhesive" in run and run["solutions/adhesive"].attrs.get("mesh") == FRONT


def _by_front(run: Run) -> Iterator[Caution]:
    """Yield what a run leaves out whose contacts are followed by their front."""
    if _is_by_front(run):
        complete = run["solutions/adhesive"]["complete"].astype(bool)
        yield "front", {"by_front": True}
        yield "no_front", {"places_without_front": int((~complete).sum()), "places": complete.size}


def _resolution(run: Run) -> Iterator[Caution]:
    """Yield cautions on contacts smaller than two pixels, and on asperities sharper than the tip."""
    solved = run.get("solutions/adhesive", xr.Dataset())
    if "pull_off_resolution" in solved:
        pixels = float((solved["pull_off_resolution"] / solved["mesh"].clip(1)).median())
        yield "resolution", {"few_pixels_of_radius": pixels if pixels < _FEW_PIXELS else None}
    if BUDGET not in run or "asperities" not in run or schema.is_synthetic(run["scan"]):
        return
    sharp = float(tip_flags(run["asperities"], tip_radius=TIP_RADIUS)["sharper_than_tip"].mean())
    tip_error = run[BUDGET]["relative_std"].sel(entry="tip radius")  # unknown for a scan that no such tip has made
    if sharp >= _UNRESOLVED_SHARE and bool(tip_error.notnull()):
        yield "tip", {"share_sharper": sharp, "tip_radius": TIP_RADIUS}


#: The functions that yield cautions, in the order of the page.
_FINDERS: tuple[Callable[[Run], Iterable[Caution]], ...] = (
    _scan_doubts,
    _elastic,
    _solved,
    _settling,
    _yielding,
    _by_front,
    _resolution,
    _left_out,
    _superposed,
)
