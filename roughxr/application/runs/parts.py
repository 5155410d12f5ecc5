"""The stages of a run, each a function of the run in progress that returns groups of its archive."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...mechanics.asperity.asperity_sum import fit_options
from ...mechanics.asperity.catalogue import asperities
from ...mechanics.asperity.reconstruction import reconstruct
from ...mechanics.asperity.superposition import superpose
from ...mechanics.bodies.pair import elastic
from ...mechanics.contact.adhesion import adhesive, adhesive_and_moments
from ...mechanics.contact.adhesive_options import longest_step
from ...mechanics.contact.elastic import direct
from ...mechanics.contact.mesh import FRONT, TooManyCells, UnresolvedContact
from ...mechanics.contact.regimes import formulas, regime
from ...mechanics.contact.rigid.bodies import rigid
from ...mechanics.jobs.records import loading
from ...mechanics.kernels.jit import share_to_compile
from ...mechanics.particles import critical_load
from ...mechanics.particles.resting_places import are_resting_positions
from ...mechanics.scans import regions
from ...mechanics.scans.levelling import level
from ...mechanics.scans.roughness_parameters import roughness
from ...mechanics.scans.spectra import power_spectrum
from ...mechanics.specimen import Specimen
from ...mechanics.statistics import pull_off
from ...mechanics.studies.extrapolation import pixel_series, real_pull_off, without_estimate
from ...mechanics.studies.uncertainty_budget import budget_of
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.adhesion_laws import ADHESION_LAWS, HERTZ
from ...mechanics.vocabulary.numbers import format_number
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.text import without_warnings
from .. import report
from ..report.summary import BUDGET
from .plan import Plan
from .run_mesh import Converged, converged_mesh, need_pull_off, refuse_soft, show_answer
from .stages import Stages

#: Largest cells (nm) of rigid bodies, at most eight to a pixel.
_RIGID_CELL = 2.5

#: Places of the usual formulas.
_FORMULA_PLACES = 16

#: Places of force over displacement.
_CURVE_PLACES = 4

#: Number of steps from which force over displacement, of soft bodies, is computed at one place only.
_MANY_STEPS = 20

#: Number of displacements of force over displacement.
_CURVE_POINTS = 12

#: Their range beyond pull-off and preload, over the distance of both.
_CURVE_MARGIN = 0.5

#: Duration of the simulation with levers over that without (``tests/benchmarks/levers.py --cost``, plus 1).
_WITH_LEVERS = 1.4

#: Duration of the error budget at a place over that of the simulation, on the same mesh.
_CHANGES_ON_MESH = 12

#: The same on the larger cells from which the mesh was refined (3 to 7 on six scans of microscopes).
_CHANGES_ON_LARGER_CELLS = 5

#: Stages that are not shown.
SILENT = Stages({}, {})


class Task(NamedTuple):
    """A run in progress: its input, its plan and the groups computed so far."""

    specimen: Specimen
    plan: Plan
    stages: Stages = SILENT
    groups: dict[str, xr.Dataset] = {}  # noqa: RUF012

    @property
    def places(self) -> int:
        """The number of places."""
        return self.specimen.centres(self.plan.subregions).sizes["subregion"]

    @property
    def options(self) -> dict[str, Any]:
        """The places, as the solvers take them."""
        return {"subregions": self.plan.subregions}

    @property
    def is_summed(self) -> bool:
        """Whether sums over asperities hold: neighbours' menisci merge, and layers are no half spaces."""
        return self.specimen.pair.menisci is None and not self.is_coated

    @property
    def is_coated(self) -> bool:
        """Whether a layer is bonded to the scan's body: sums over asperities and `regime` take half spaces."""
        return self.specimen.pair.layer is not None

    @property
    def adheres(self) -> bool:
        """Whether anything attracts."""
        return self.specimen.pair.work > 0

    @property
    def is_real(self) -> bool:
        """Whether a body adheres to a measured surface, of which the scan shows a part of the roughness."""
        return self.adheres and not schema.is_synthetic(self.specimen.scan)

    @property
    def has_sphere(self) -> bool:
        """Whether the indenter is a sphere, which can roll."""
        return self.specimen.indenter.map is None

    @property
    def rolls(self) -> bool:
        """Whether the detachment of the sphere is requested, and anything resists it."""
        return self.adheres and self.has_sphere and self.plan.directions > 0


def _surface(task: Task) -> dict[str, xr.Dataset]:
    """Return the scan, its asperities and its roughness."""
    scan = task.specimen.scan
    catalogue = _catalogue(task.specimen, task.plan.superposed[0])
    if not bool((catalogue["curvature_min"] > 0).any()):
        raise Refusal(
            "scan",
            "asperities",
            f"no peak among {catalogue.sizes['asperity']} (is it flat?)",
            "use JKR's formula for a smooth flat, or roughxr.adhesive",
        )
    return {
        "scan": scan,
        "asperities": catalogue,
        "reconstruction": reconstruct(scan, catalogue),
        "statistics/roughness": roughness(scan).merge(power_spectrum(level(scan)), combine_attrs="override"),
    }


def _catalogue(specimen: Specimen, formulation: str) -> xr.Dataset:
    """Return the asperities that a formulation sums: the paper's own for its formulas."""
    return without_warnings(asperities, specimen.scan, **fit_options(formulation))


def _adhesive_simulation(task: Task) -> dict[str, xr.Dataset]:
    """Return the simulation with adhesion at all places, and its error by mesh and step from a sample of places."""
    specimen = task.specimen
    plan = task.plan
    stages = task.stages
    if task.has_sphere:
        refuse_soft(specimen)
    options = task.options | {"preload": plan.preload, "law": plan.law}
    with warnings.catch_warnings():
        # the choice of the mesh and the report's page deal with contacts that a mesh does not resolve
        warnings.simplefilter("ignore", UnresolvedContact)
        mesh, finer, pace = _checked_mesh(task, options)
        before = stages.passed()
        has_levers = task.rolls and mesh.cells != FRONT
        with_levers = _WITH_LEVERS if has_levers else 1.0
        if pace > 0:
            stage = before + with_levers * pace * task.places
            stages.expect(f"each place takes {format_number(with_levers * pace, 's', 2)}", adhesive=stage)
        moments = {}
        if has_levers:
            rolled = adhesive_and_moments(specimen, directions=plan.directions, mesh=mesh, **options)
            solved, moments["solutions/rolling"] = rolled
        else:
            solved = adhesive(specimen, mesh=mesh, **options)
        took = (stages.passed() - before) / with_levers
        is_refined = mesh.cells != plan.mesh.cells and not ADHESION_LAWS[solved.attrs["law"]].has_edge
        why, seconds = _durations_after(took, task.places, plan.budget, is_refined)
        stages.expect(why, **seconds)
    groups = {"solutions/adhesive": solved, "statistics/adhesive": pull_off(solved)} | moments
    groups = groups if finer is None else report.with_mesh_error(groups | {"solutions/finer": finer})
    show_answer(groups["statistics/adhesive"], specimen, stages)
    return groups


def _checked_mesh(task: Task, options: dict[str, Any]) -> Converged:
    """Return the mesh, with results on a finer one and the duration of a place, by a sample of the places."""
    specimen = task.specimen
    plan = task.plan
    sampled = options | {"subregions": regions.sample(specimen.centres(plan.subregions), plan.checked)}
    if plan.mesh.cells == "auto":
        return converged_mesh(specimen, plan, sampled, task.stages)
    mesh = replace(plan.mesh, accuracy=None)
    if sampled["subregions"].sizes["subregion"] == task.places:
        return Converged(mesh, None, 0.0)
    first = adhesive(specimen, mesh=mesh, **sampled)
    need_pull_off(first)
    pace = task.stages.pace()
    show_answer(first, specimen, task.stages)
    return Converged(mesh, None, pace)


def _durations_after(took: float, places: int, budget: int, is_refined: bool) -> tuple[str, dict[str, float]]:
    """Return why stages that solve places again may last longer than usual, and how long, s.

    ``took`` is the duration of the simulation with adhesion at all places without levers, s. Where its mesh
    ``is_refined``, changes of the budget are solved on larger cells.
    """
    one_place = took / places
    why = f"each place took {format_number(one_place, 's', 2)}"
    changes = _CHANGES_ON_LARGER_CELLS if is_refined else _CHANGES_ON_MESH
    seconds = {
        "curves": 0.1 + 2.5 * min(places, _CURVE_PLACES) * one_place,
        "budget": 0.1 + changes * budget * one_place,
    }
    return why, seconds


def _curves_around_pull_off(task: Task) -> dict[str, xr.Dataset]:
    """Return force over displacement around the pull-off at some places, and the fields of one contact at pull-off."""
    specimen = task.specimen
    solved = task.groups["solutions/adhesive"]
    adhering = solved.isel(subregion=np.flatnonzero((solved["pull_off_force"] > 0).values))
    if not adhering.sizes["subregion"]:
        return {}
    low = float(adhering["pull_off_delta"].quantile(0.05))
    high = float(adhering["preload_delta"].quantile(0.95))
    margin = _CURVE_MARGIN * max(high - low, 0.1 * abs(low))
    deltas = np.round(np.linspace(low - margin, high + margin, _CURVE_POINTS), 4)
    median_place = adhering.sortby("pull_off_force").isel(subregion=[adhering.sizes["subregion"] // 2])
    cells = int(median_place["mesh"].max())
    if not cells:  # by the front, since cells would be too many
        return {}
    mesh = replace(task.plan.mesh, cells=cells, accuracy=None)
    how = {"law": solved.attrs["law"], "mesh": mesh, "datum": "first_contact"}
    steps = (deltas[-1] - deltas[0]) / longest_step(specimen, mesh)
    sample = regions.sample(adhering, _CURVE_PLACES if steps < _MANY_STEPS else 1)
    at_pull_off = np.round(median_place["pull_off_delta"].values, 6)
    try:
        curves = without_warnings(adhesive, specimen, subregions=sample, delta=deltas, **how)
        fields = without_warnings(adhesive, specimen, subregions=median_place, delta=at_pull_off, fields=True, **how)
    except TooManyCells:  # at a place that needs fewer; the report is whole without these pictures
        return {}
    retraction = fields.sel(branch="retraction", drop=True)
    return {"solutions/curves": curves, "solutions/pull_off_contact": retraction}


def _error_budget(task: Task) -> dict[str, xr.Dataset]:
    """Return the error budget of the simulated pull-off."""
    plan = task.plan
    scan = task.specimen.scan
    solved = task.groups["solutions/adhesive"]
    mesh = replace(plan.mesh, cells=solved.attrs["mesh"], accuracy=None)
    finer = task.groups.get("solutions/finer")
    out = budget_of(scan, solved, places=plan.budget, preload=plan.preload, mesh=mesh, finer=finer)
    how = {"preload": plan.preload, "mesh": mesh, "places": plan.budget, "law": solved.attrs["law"]}
    return {BUDGET: schema.record(out, "error_budget", scan, **how)}


def _extrapolated_pull_off(task: Task) -> dict[str, xr.Dataset]:
    """Return the pull-off of the real surface, or the reason for its absence."""
    scan = task.specimen.scan
    plan = task.plan
    solved = task.groups["solutions/adhesive"]
    how = {"finer": plan.finer, "shortest": plan.shortest}
    try:
        # the run has warned of a doubtful second scan before its first stage
        estimate = without_warnings(real_pull_off, scan, solved, task.groups.get(BUDGET), **how)
    except Refusal as refusal:
        return {"statistics/extrapolated": without_estimate(scan, refusal.reason)}
    series = pixel_series(scan, solved, plan.preload, plan.mesh.step)
    return {
        "solutions/extrapolated": estimate[["pull_off_force"]],
        "statistics/extrapolated": estimate.drop_vars("pull_off_force").drop_dims("subregion").assign(series),
    }


def _rigid_bodies(task: Task) -> dict[str, xr.Dataset]:
    """Return the force between rigid bodies and, for a sphere, the recommended model and the usual formulas."""
    specimen = task.specimen
    mesh = int(np.clip(np.ceil(task.specimen.pixel / _RIGID_CELL), 1, 8))
    # without warnings about the cell size, which the report gives for all methods
    summed = without_warnings(rigid, specimen, delta=[0.0], mesh=mesh, **task.options)
    groups = {"solutions/rigid": summed, "statistics/rigid": without_warnings(pull_off, summed)}
    if task.has_sphere:
        sampled = regions.sample(specimen.centres(task.plan.subregions), _FORMULA_PLACES)
        if not task.is_coated:
            groups["statistics/regime"] = without_warnings(regime, specimen, subregions=sampled, mesh=mesh)
        groups["statistics/formulas"] = without_warnings(formulas, specimen, subregions=sampled, mesh=mesh)
    return groups


def _elastic_simulation(task: Task) -> dict[str, xr.Dataset]:
    """Return the direct simulation, one contact with its fields, a smooth flat, and superposed asperities."""
    specimen = task.specimen
    plan = task.plan
    catalogue = task.groups["asperities"]
    options: dict[str, Any] = {"delta": plan.direct_deltas, "datum": plan.datum}
    solved = direct(specimen, **options, **task.options)
    flat = specimen.scan.assign(height=xr.zeros_like(specimen.scan["height"]))
    groups = {
        "solutions/direct": loading(solved),
        "solutions/contact": _one_contact(specimen, plan, loading(solved)),
        "solutions/smooth": loading(without_warnings(direct, flat, **options)),
    }
    if not task.is_coated:  # without yield, to show its effect by comparison
        dry = {"law": HERTZ, "formulation": plan.superposed[0]}
        groups["solutions/hertz"] = superpose(elastic(catalogue), delta=plan.sweep, **dry, **task.options)
    if "branch" in solved.dims:  # where the body yields
        groups["solutions/retraction"] = solved.sel(branch="retraction", drop=True)
    return groups


def _one_contact(specimen: Specimen, plan: Plan, solved: xr.Dataset) -> xr.Dataset:
    """Return the fields at the place of median force among those away from the scan's edge."""
    last = solved.isel(delta=-1)
    inner = last.where(~last["truncated"] & (last["force"] > 0), drop=True)
    inner = inner if inner.sizes["subregion"] else last
    middle = inner.sortby("force").isel(subregion=[inner.sizes["subregion"] // 2])
    return loading(direct(specimen, delta=[plan.contact_delta], datum=plan.datum, subregions=middle, fields=True))


def _superposed_asperities(task: Task) -> dict[str, xr.Dataset]:
    """Return superposed asperities and their pull-off."""
    specimen = task.specimen
    groups = dict[str, xr.Dataset]()
    places = specimen.centres(task.plan.subregions)
    debris = {name: places[name] for name in ("on_debris", "debris_share") if name in places.coords}
    for name in task.plan.superposed:
        catalogue = elastic(_catalogue(specimen, name))
        swept = without_warnings(superpose, catalogue, delta=task.plan.sweep, formulation=name, **task.options)
        swept = swept.assign_coords(debris)  # which the asperities do not show
        groups |= {f"solutions/{name}": swept, f"statistics/{name}": without_warnings(pull_off, swept)}
    return groups


def _detachment(task: Task) -> dict[str, xr.Dataset]:
    """Return the critical flow, by the resisting moments of the simulation's contacts."""
    groups = task.groups
    places = task.plan.subregions
    if "solutions/rolling" not in groups:
        return {}
    out = {"statistics/rests": places} if are_resting_positions(places) else {}
    for way, group in report.CRITICAL.items():
        if f"solutions/{way}" in groups:
            out[group] = without_warnings(critical_load, report.run_moments(groups, way), flow=task.plan.flow)
    return out


#: Duration (s) of compiling the kernels of a folder that a run needs.
_COMPILING = {"halfspace": 4.0, "asperity": 5.0, "adhesion": 12.0}

#: Largest share of a folder's kernels that the disk lacks after a run: others are those of other runs.
_NEVER_COMPILED = 0.5


class Part(NamedTuple):
    """A stage of a run, with its duration (s) and its duration per place (s): medians of six runs on two idle cores."""

    name: str
    words: str
    applies: Callable[[Task], bool]
    fixed: float
    each: float
    make: Callable[[Task], dict[str, xr.Dataset]]
    kernels: str = ""  # folder of the kernels that it is the first to compile

    @property
    def compiling(self) -> float:
        """The duration (s) of compiling its kernels; 0 if they are stored."""
        if not self.kernels or share_to_compile(self.kernels) <= _NEVER_COMPILED:
            return 0.0
        return _COMPILING[self.kernels]


#: The stages of a run, in order.
PARTS = (
    Part("asperities", "asperities", lambda task: True, 0.1, 0.0, _surface),
    Part(
        "adhesive", "simulation with adhesion", lambda task: task.adheres, 0.6, 0.03, _adhesive_simulation, "adhesion"
    ),
    Part("curves", "force over displacement", lambda task: task.adheres, 0.2, 0.0, _curves_around_pull_off),
    Part("budget", "error budget", lambda task: task.adheres and task.plan.budget > 0, 0.6, 0.0, _error_budget),
    Part("extrapolated", "roughness below the pixel", lambda task: task.is_real, 0.3, 0.0, _extrapolated_pull_off),
    Part("rigid", "rigid bodies", lambda task: task.adheres, 0.1, 0.006, _rigid_bodies),
    Part("direct", "simulation without adhesion", lambda task: True, 0.1, 0.002, _elastic_simulation, "halfspace"),
    Part(
        "superposition",
        "superposed asperities",
        lambda task: task.is_summed,
        0.1,
        0.0,
        _superposed_asperities,
        "asperity",
    ),
    Part("rolling", "detachment", lambda task: task.rolls, 0.4, 0.0, _detachment),
)
