"""Cautions: sentences on what makes the numbers of a run doubtful."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

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
from ...mechanics.vocabulary.numbers import number, percent
from .run_numbers import METHOD_WORDS, debris_flags
from .summary import BUDGET

Run = Mapping[str, xr.Dataset]

#: Share of unresolved contacts or asperities from which a caution is given.
_UNRESOLVED_SHARE = 0.05


def cautions(run: Run) -> list[str]:
    """Return cautions about the numbers of a run, given by its groups: a list of sentences, empty without a reason.

    Examples
    --------
    >>> import roughxr
    >>> roughxr.report.cautions({"scan": roughxr.open_sample("glass")})[0]
    'The scan is synthetic: ...'
    """
    run = {name: schema.entered(ds) for name, ds in run.items()}
    return [sentence for find in _FINDERS for sentence in find(run)]


def superposition_notes(run: Run) -> list[str]:
    """Return the reliability of the superposed pull-off, and the number of places where it exceeds its upper bound."""
    ds = run.get("solutions/energy", xr.Dataset())
    if "expectation" not in ds.attrs:
        return []
    sentence = f"Superposed asperities: {ds.attrs['expectation']}."
    if "pull_off_force" in ds and (above := int((ds["pull_off_force"] > smooth_pull_off(ds)).sum())):
        sentence += f" At {above} of {ds.sizes['subregion']} places their sum exceeds the pull-off from a smooth flat."
    return [sentence]


def _scan_doubts(run: Run) -> Iterator[str]:
    """Yield doubts about the scan, and the number of places with debris."""
    if "scan" in run and schema.is_synthetic(run["scan"]):
        yield "The scan is synthetic: generated from a random seed, not measured."
    for doubt in doubts(run["scan"]) if "scan" in run else ():
        yield f"About the scan: {doubt}."
    flags = debris_flags(run)
    if flags is not None and flags.any():
        area = f"{percent(flags['debris_share'])} of the area"
        yield f"{int(flags.sum())} of {flags.size} places are on debris, which the sphere touches first on {area}."


def _elastic(run: Run) -> Iterator[str]:
    """Yield cautions on a single place, on bodies that do not touch, and on contacts of too few pixels."""
    if "solutions/direct" not in run:
        return
    direct = run["solutions/direct"]
    if direct.sizes["subregion"] == 1:
        yield "Only one place was computed: the scatter between places is not known."
    if not bool((direct["force"] > 0).any()):
        yield "Nothing touches at any displacement of the direct simulation: use larger displacements."
    if "scan" in run and "contact_area" in direct:
        area = direct["contact_area"].isel(delta=-1).values
        cell = float(np.prod(schema.pixel(run["scan"])))
        share = np.mean(area[area > 0] < 10 * cell) if (area > 0).any() else 0.0
        if share >= _UNRESOLVED_SHARE:
            yield (
                f"In {percent(share)} of the elastic contacts fewer than ten pixels touch at the largest displacement: "
                "too few to resolve them."
            )


def _solved(run: Run) -> Iterator[str]:
    """Yield cautions on solutions that violate a contact condition, end too early, or need a finer mesh."""
    for name, ds in run.items():
        kind, _, method = name.partition("/")
        title = METHOD_WORDS.get(method, method).capitalize()
        if kind == "solutions" and method in SOLVED and "converged" in ds:
            conditions = certificate(ds)
            missed = ~(conditions.met | conditions.check.isin(["mesh", "truncated"]))
            if missed.any():
                rows = conditions.isel(check=missed.values)
                violations = "; ".join(
                    f"{check}: {violation:.2g} of at most {limit:.2g}"
                    for check, violation, limit in zip(
                        rows["check"].values, rows["violation"].values, rows["limit"].values
                    )
                )
                yield f"{title}: conditions of the contact are violated: {violations}."
        if name in ("solutions/direct", "solutions/energy") and "truncated" in ds:
            flags = ds["truncated"].astype(bool)
            if places := int(flags.any([dim for dim in flags.dims if dim == "delta"]).sum()):
                where = f"at {places} of {flags.sizes['subregion']} places"
                yield f"{title}: {where} the contact reaches the scan's edge, and the force is too low."
        if kind == "statistics" and "bracketed" in ds:
            adheres = ds["pull_off_force"].notnull()
            if bad := int((adheres & ~ds["bracketed"].astype(bool)).sum()):
                yield f"{title}: at {bad} of {adheres.size} places the sweep ends before the largest adhesion force."
            if none := int((~adheres).sum()):
                where = f"at {none} of {adheres.size} places"
                yield f"{title}: {where} the sphere does not adhere; the statistics omit them."
    error = mesh_error(run["statistics/adhesive"]) if "statistics/adhesive" in run else np.nan
    # relative error of the mean pull-off by mesh and step above which a caution is given
    if error > 0.1:
        remedy = "law 'jkr' solves its places on cells" if _is_by_front(run) else "use a finer mesh"
        yield f"The numerical error of the mean pull-off is {percent(error)}: {remedy}."


def _settling(run: Run) -> Iterator[str]:
    """Yield a caution on places whose pull-off depends on how hard the sphere was pressed."""
    if "statistics/adhesive" not in run or "pressed_pull_off_force" not in run["statistics/adhesive"]:
        return
    pull = run["statistics/adhesive"]
    depends = is_range(pull["pull_off_force"].values, pull["pressed_pull_off_force"].values)
    if ranges := int(depends.sum()):
        yield (
            f"At {ranges} of {depends.size} places the pull-off depends on how hard the sphere was pressed: it is a "
            "range from pull_off_force to pressed_pull_off_force. State a preload."
        )


def _yielding(run: Run) -> Iterator[str]:
    """Yield cautions on pressures above the hardness, and on results that ignore yield."""
    solved = {
        "solutions/direct": "in the direct simulation at its largest displacement",
        "solutions/adhesive": "in the simulation with adhesion at its preload",
    }
    groups = {name: run[name] for name in solved if name in run and "yielded_fraction" in run[name]}
    shares = [share for name, ds in groups.items() if (share := _share_above_hardness(ds, solved[name]))]
    is_plastic = any("plastic_work" in ds for ds in run.values())
    if shares:
        bodies = next(iter(groups.values())).coords
        above = "; ".join(shares)
        label = "hardness" if "hardness" in bodies else "estimated hardness"
        limit = number(bodies.get("hardness", bodies.get("hardness_estimate")), "GPa")
        if is_plastic:
            yield f"The softer body yields at its hardness, {limit}: {above}."
        else:
            yield f"Summits may yield above the {label} of {limit}: {above}. State a hardness to include this."
    if groups and is_plastic:
        yield "Superposition and rigid bodies in this run do not include yield: they stay elastic or rigid."


def _share_above_hardness(ds: xr.Dataset, where: str) -> str:
    """Return the shares of area and force at the hardness and above, in words; empty for a small share."""
    last = ds.isel(delta=-1) if "delta" in ds["yielded_fraction"].dims else ds
    force, area = (float(last[f"yielded{part}_fraction"].mean()) for part in ("", "_area"))
    # share of the force above the hardness above which a caution is given
    if not force > 0.005:
        return ""
    return f"{where}, {percent(area)} of the contact area with {percent(force)} of the force"


def _left_out(run: Run) -> Iterator[str]:
    """Yield what a run omits because a layer covers the surface."""
    if "solutions/adhesive" in run and schema.is_coated(run["scan"]):
        yield (
            "Left out, since they hold for half spaces without a layer: superposed asperities and the choice of a "
            "model."
        )


def _is_by_front(run: Run) -> bool:
    """Return whether contacts of the run are followed by their front."""
    return "solutions/adhesive" in run and run["solutions/adhesive"].attrs.get("mesh") == FRONT


def _by_front(run: Run) -> Iterator[str]:
    """Yield what a run leaves out whose contacts are followed by their front."""
    if not _is_by_front(run):
        return
    yield (
        "The contact at each place is one region, followed by its edge, since cells would be too many. Left out: "
        "fields, force over displacement, and moments that resist rolling."
    )
    complete = run["solutions/adhesive"]["complete"].astype(bool)
    if lost := int((~complete).sum()):
        yield (
            f"{lost} of {complete.size} places have no valid front (more than one contact, or one too far from a "
            "circle): the statistics omit them, and law 'jkr' solves them on cells."
        )


def _resolution(run: Run) -> Iterator[str]:
    """Yield cautions on contacts smaller than two pixels, and on asperities sharper than the tip."""
    solved = run.get("solutions/adhesive", xr.Dataset())
    if "pull_off_resolution" in solved:
        pixels = float((solved["pull_off_resolution"] / solved["mesh"].clip(1)).median())
        if pixels < 2:
            yield (
                f"At pull-off the smallest relevant contact has a radius of {number(pixels, digits=2)} pixels (median "
                "place): the pull-off depends on the surface within a pixel, which the scan does not show."
            )
    if BUDGET not in run or "asperities" not in run or schema.is_synthetic(run["scan"]):
        return
    sharp = float(tip_flags(run["asperities"], tip_radius=TIP_RADIUS)["sharper_than_tip"].mean())
    tip_error = run[BUDGET]["relative_std"].sel(entry="tip radius")  # unknown for a scan that no such tip has made
    if sharp >= _UNRESOLVED_SHARE and bool(tip_error.notnull()):
        yield (
            f"{percent(sharp)} of the asperities are sharper than a tip of {TIP_RADIUS:g} nm radius can "
            "image. If the tip of the scan was as blunt, the surface is rougher than the scan, and adheres less."
        )


#: The functions that yield cautions, in the order of the page.
_FINDERS: tuple[Callable[[Run], Iterable[str]], ...] = (
    _scan_doubts,
    _elastic,
    _solved,
    _settling,
    _yielding,
    _by_front,
    _resolution,
    _left_out,
    superposition_notes,
)
