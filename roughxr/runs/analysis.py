"""A run: the complete analysis of one scan, from asperities to the statistics of pull-off and detachment.

Its result is a dictionary of Datasets, the groups of its archive:

    scan, asperities, reconstruction
    solutions/adhesive, /extrapolated (with the roughness extrapolated below the scan),
    /rigid, /direct, /contact (fields of one place), /smooth (the same sphere on a flat), /hertz,
    /energy (superposed asperities), /rolling (resisting moments)
    statistics/adhesive, /rigid, /energy, /roughness, /regime (the recommended model), /formulas (pull-off by the
    usual formulas), /extrapolated, /detachment and /detachment_extrapolated (the critical flow), /error_budget,
    /scale_dependence, /summary (the answer), /places (one row a place)
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import figures, report
from ..archive import atomic_write, remove_leftovers
from ..asperity.asperity_sum import fit_options
from ..asperity.catalogue import asperities
from ..asperity.reconstruction import reconstruct
from ..asperity.superposition import superpose
from ..bodies.pair import elastic
from ..contact.adhesion import adhesive
from ..contact.adhesive_options import LONG_STEP, longest_step, usual_step
from ..contact.elastic import direct
from ..contact.mesh import MOST_REFINED, Mesh, TooManyCells, UnresolvedContact, read_mesh
from ..contact.problem import default_deltas
from ..contact.refinement import coarser_mesh_error
from ..contact.regimes import formulas, regime
from ..contact.rigid.bodies import rigid
from ..jobs.checkpoint import checkpointed
from ..jobs.progress import Stages, print_line, rough_duration
from ..jobs.records import loading
from ..particles import critical_load, resting
from ..particles.force_balance import read_body
from ..particles.loads import Flow
from ..particles.resting_places import are_resting_positions
from ..particles.simulated_moments import simulated_moments
from ..report.summary import BUDGET, scan_label
from ..scans import level, power_spectrum, regions, roughness
from ..scans.levelling import METHODS
from ..scans.plausibility import is_noise
from ..specimen import Specimen, specimen_of
from ..statistics import pull_off
from ..statistics.headline import headline, mean_pull_off, mesh_error
from ..studies.extrapolation import real_pull_off, second_scan, without_estimate
from ..studies.roughness_scale import scale_dependence
from ..studies.uncertainty_budget import budget_of
from ..tables import to_table
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import HERTZ, read_law
from ..vocabulary.numbers import number
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import warn, without_warnings
from ..vocabulary.units import Places, Quantities, single, whole_number

#: Largest cells (nm) of rigid bodies, at most eight to a pixel.
_RIGID_CELL = 2.5

#: Places of the pull-off over the shortest wavelength, of the usual formulas, and of force over displacement.
_SCALE_PLACES, _FORMULA_PLACES, _CURVE_PLACES = 3, 16, 4

#: Number of steps from which force over displacement, of soft bodies, is computed at one place only.
_MANY_STEPS = 20

#: Number of displacements of force over displacement, and its range beyond pull-off and preload, over their distance.
_CURVE_POINTS, _CURVE_MARGIN = 12, 0.5


class Plan(NamedTuple):
    """The options of a run."""

    subregions: Any
    direct_deltas: np.ndarray  # nm
    sweep: np.ndarray  # nm, for superpositions
    contact_delta: float  # nm, for the one contact with fields
    superposed: tuple[str, ...] = ("energy",)  # formulations; the first one chooses the catalogue of the run
    preload: float = 0.0  # nN, of the adhesive simulation; 0: the sphere settles under its own adhesion
    law: str = "auto"
    mesh: Mesh = Mesh()
    checked: int = 4  # places also solved on a mesh twice as fine with half the steps
    budget: int = 8  # places solved again under each change of the error budget; 0: no budget
    finer: xr.Dataset | None = None  # a second scan of the surface on finer pixels
    flow: str | Flow = "air"  # the fluid that detaches the sphere


#: Largest contact diameter of a smooth sphere without load, over the scan's side: wider ones leave any rough scan.
_WIDEST_CONTACT = 3.0

#: Radius of JKR's contact without load over that at pull-off.
_WITHOUT_LOAD = 4 ** (1 / 3)

#: Stages that are not shown.
_SILENT = Stages({}, {})

#: Advice where bodies are too soft for the scan, or their contacts too large.
_REMEDY = (
    "use a larger scan, a smaller sphere or preload, a larger modulus or less work of adhesion; or, in Python, "
    "superpose or direct"
)


def run(
    scan: xr.Dataset,
    output: str | Path,
    *,
    subregions: Places = (8, 8),
    particle: bool = False,
    delta: Quantities | None = None,
    preload: Quantities = 0.0,
    law: str = "auto",
    mesh: Mesh | int | str = "auto",
    levelling: str = "plane",
    budget: int = 8,
    finer: xr.Dataset | None = None,
    flow: str | Flow = "air",
    command: str = "",
) -> dict[str, xr.Dataset]:
    """Analyse a scan, and write archive, figures, tables and report; called again after an interruption, it resumes.

    Parameters
    ----------
    scan : Dataset
        A scan with an assigned pair.
    output : path
        A folder, or a file ending in ``.nc`` for the archive alone, whose tables are printed.
    subregions : (int, int), (array, array) or Dataset
        Contact centres, see `regions.centres`; by default a grid of 8 × 8.
    particle : bool
        Whether the sphere is a free particle instead of a fixed probe: from each place of ``subregions`` it rolls to a
        resting position and is solved there, weighted by the share of places that lead to this position (`resting`).
    delta : array_like, optional
        Displacements of the direct simulation, nm; by default 16, half of them beyond the median first contact, the
        last a little beyond that of the lowest place.
    preload, law, mesh
        Options of the simulation with adhesion, see `adhesive`; one preload. "auto": the mesh is refined until the
        mean pull-off of four places changes by less than its accuracy, or to sixteen cells per pixel.
    levelling : {"plane", "quadratic", "none"}
        What is subtracted from the scan first.
    budget : int
        Number of places at which each change of the error budget is simulated; 0: no budget.
    finer : Dataset, optional
        A second scan of the surface on finer pixels, for the best estimate, see `extrapolated`; levelled likewise.
    flow : {"air", "water"} or Flow
        The fluid that detaches the sphere, see `critical_load`; it does not change the adhesion (`assign_pair` has the
        medium in which the bodies adhere).
    command : str
        Shown in the report as the command that repeats the run.

    Returns
    -------
    dict of str to Dataset
        The groups of the archive. Subregions are solved on the active ``distributed.Client``, on the scheduler that
        ``dask.config.set(scheduler=…)`` names, or else on threads.

    Raises
    ------
    ValueError
        If the sphere does not fit the scan, levelling, law or mesh is not among those listed, or no place has a pull-
        off.

    Examples
    --------
    Two places on a small scan without adhesion, the printed tables suppressed.

    >>> from pathlib import Path
    >>> import roughxr
    >>> import contextlib, io, tempfile
    >>> from roughxr.scans.synthetic import self_affine
    >>> scan = self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    >>> scan = scan.contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0)
    >>> with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as printed:
    ...     groups = roughxr.run(scan, Path(folder) / "roughxr.run.nc", subregions=(2, 1), delta=[1.0, 2.0])
    >>> dict(groups["solutions/direct"].force.sizes), "asperities" in printed.getvalue()
    ({'subregion': 2, 'delta': 2}, True)
    """
    output = Path(output)
    if output.is_file() and output.suffix != ".nc":
        raise Refusal("output", "a folder or a file ending in .nc", f"another file, {output}")
    if schema.one_of(levelling, (*METHODS, "none"), "levelling") != "none":
        scan = level(scan, method=levelling)
        finer = None if finer is None else level(finer, method=levelling)
    specimen = specimen_of(scan)
    if finer is not None:
        second_scan(specimen.scan, finer)  # refused before minutes are spent
    expected = "one force of at least 0 nN"
    force = single(preload, "nN", "preload", expected, lambda force: force >= 0)
    adhesion = {"preload": force, "law": read_law(law, "adhesive"), "mesh": read_mesh(mesh, _usual_mesh(specimen))}
    if specimen.indenter.map is None:
        flow = read_body(specimen.bodies, None, flow).flow
    adhesion |= {"budget": whole_number(budget, "budget", least=0), "finer": finer, "flow": flow}
    if particle:
        print_line("resting positions of the particle")
        subregions = resting(specimen.scan, landings=subregions)
        if subregions.sizes["subregion"] == 0:
            raise Refusal(
                "particle",
                "a surface on which the sphere comes to rest",
                subregions.attrs["missing"],
                "leave particle out to run it as a fixed probe",
            )
    wanted = plan(specimen, subregions=subregions, delta=delta, **adhesion)
    alone = output.suffix == ".nc"
    return execute(specimen, wanted, output if alone else output / "run.nc", None if alone else output, command=command)


def execute(
    specimen: Specimen,
    plan: Plan,
    path: Path,
    folder: Path | None,
    *,
    command: str = "",
    parts: Sequence[Part] | None = None,
    tables: Callable = report.tables,
    as_text: Callable = lambda run, tables: tables_text(tables, notes(run), report.headline(run)),
    draw_figures: Callable = lambda run: [("overview", figures.overview(run))],
) -> dict[str, xr.Dataset]:
    """Compute the groups that a run's archive lacks, write its files or print its tables, and return all groups."""
    task = Task(specimen, plan)
    parts = _applicable(task, parts)
    expected = {part.name: part.fixed + part.each * task.places for part in parts} | {"pages": 10.0}
    labels = {part.name: part.words for part in parts} | {"pages": _PAGES}
    if not path.exists():
        pixels = " x ".join(map(str, specimen.heights.shape))
        print_line(
            f"{task.places} places on {pixels} pixels: {rough_duration(sum(expected.values()))} on most scans, longer "
            "on sharp or soft summits and for the first run on a machine. If it is interrupted, the same call "
            "continues it."
        )
    with Stages(expected, labels) as stages:
        groups = checkpointed(
            lambda: analyse(specimen, plan, stages, command, parts),
            path,
            scan=specimen.scan,
            arguments=plan._asdict() | {"parts": [part.name for part in parts]},
            title=specimen.bodies.attrs.get("title", ""),
            missing=lambda: f"missing: {', '.join(w for w in stages.later() if w != _PAGES) or 'its log'}",
        )
        made = tables(groups)
        printed = as_text(groups, made)
        if folder is not None and not os.access(folder, os.W_OK):
            warn(f"{folder}: is read only: the run is read, and its pages stay as they are")
        elif folder is not None:
            stages("pages")
            remove_leftovers(folder)
            write_tables(made, printed, folder)
            write_figures(groups, draw_figures, folder)
            _write_pages(groups, path, folder)
    if folder is None:
        print(printed.rstrip("\n"))
    return groups


def plan(specimen: Specimen, *, subregions: Any = (8, 8), delta: Any = None, **adhesion: Any) -> Plan:
    """Return a plan whose displacements suit the heights of a scan."""
    usual = default_deltas(specimen, specimen.centres(subregions), "highest_peak")
    deltas = usual if delta is None else schema.ascending(delta, "nm", "delta")
    deepest = max(usual[-1], deltas[-1])
    sweep = np.round(np.linspace(-0.25 * deepest, deepest, 401), 4)
    return Plan(subregions, deltas, sweep, float(deltas[-1]), **({"mesh": _usual_mesh(specimen)} | adhesion))


def _usual_mesh(specimen: Specimen) -> Mesh:
    return Mesh(step=LONG_STEP * usual_step(specimen)) if specimen.pair.work > 0 else Mesh()


class Task(NamedTuple):
    """A run in progress: its input, its plan and the groups computed so far."""

    specimen: Specimen
    plan: Plan
    stages: Stages = _SILENT
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
    def is_humid(self) -> bool:
        """Whether menisci condense between the bodies."""
        return self.specimen.pair.menisci is not None

    @property
    def is_coated(self) -> bool:
        """Whether a layer is bonded to the scan's body: sums over asperities and formulas take half spaces."""
        return self.specimen.pair.layer is not None

    @property
    def adheres(self) -> bool:
        """Whether anything attracts."""
        return self.specimen.pair.work > 0

    @property
    def has_sphere(self) -> bool:
        """Whether the indenter is a sphere, which can roll."""
        return self.specimen.indenter.map is None


def analyse(
    specimen: Specimen,
    plan: Plan,
    stages: Stages = _SILENT,
    command: str = "",
    parts: Sequence[Part] | None = None,
) -> Iterator[dict[str, xr.Dataset]]:
    """Yield the groups computed so far after each stage of a run, finally all of them."""
    groups: dict[str, xr.Dataset] = {}
    for part in _applicable(Task(specimen, plan), parts):
        stages(part.name)
        groups |= part.make(Task(specimen, plan, stages, groups))
        yield groups
    options = {name: getattr(plan, name) for name in ("subregions", "preload", "law", "mesh", "budget")}
    yield groups | report.summary_groups(groups, command, **options)


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


def _elastic_simulation(task: Task) -> dict[str, xr.Dataset]:
    """Return the direct simulation, one contact with its fields, a smooth flat, and superposed asperities."""
    specimen = task.specimen
    plan = task.plan
    catalogue = task.groups["asperities"]
    solved = direct(specimen, delta=plan.direct_deltas, **task.options)
    flat = specimen.scan.assign(height=xr.zeros_like(specimen.scan["height"]))
    groups = {
        "solutions/direct": loading(solved),
        "solutions/contact": _one_contact(specimen, plan, loading(solved)),
        "solutions/smooth": loading(without_warnings(direct, flat, delta=plan.direct_deltas)),
    }
    if not task.is_coated:  # without yield, to show its effect by comparison
        dry = {"law": HERTZ, "formulation": plan.superposed[0]}
        groups["solutions/hertz"] = superpose(elastic(catalogue), delta=plan.sweep, **dry, **task.options)
    if "branch" in solved.dims:  # where the body yields
        groups["solutions/retraction"] = solved.sel(branch="retraction", drop=True)
    return groups


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


def _error_budget(task: Task) -> dict[str, xr.Dataset]:
    """Return the error budget of the simulated pull-off, and the pull-off against the shortest wavelength."""
    plan = task.plan
    scan = task.specimen.scan
    solved = task.groups["solutions/adhesive"]
    mesh = replace(plan.mesh, cells=solved.attrs["mesh"], accuracy=None)
    finer = task.groups.get("solutions/finer")
    out = budget_of(scan, solved, places=plan.budget, preload=plan.preload, mesh=mesh, finer=finer)
    how = {"preload": plan.preload, "mesh": mesh, "places": plan.budget, "law": solved.attrs["law"]}
    groups = {BUDGET: schema.record(out, "error_budget", scan, **how)}
    sampled = regions.sample(regions.centres(scan, solved), min(plan.budget, _SCALE_PLACES))
    try:
        scales = scale_dependence(scan, seeds=2, subregions=sampled, preload=plan.preload)
    except ValueError:  # no sphere, or no spectrum to extrapolate
        return groups
    return groups | {"statistics/scale_dependence": scales}


def _extrapolated_pull_off(task: Task) -> dict[str, xr.Dataset]:
    """Return the pull-off of the real surface, or the reason for its absence."""
    scan = task.specimen.scan
    finer = task.plan.finer
    try:
        estimate = real_pull_off(scan, task.groups["solutions/adhesive"], task.groups.get(BUDGET), finer=finer)
    except ValueError as error:
        return {"statistics/extrapolated": without_estimate(scan, str(error))}
    return {
        "solutions/extrapolated": estimate[["pull_off_force"]],
        "statistics/extrapolated": estimate.drop_vars("pull_off_force").drop_dims("subregion"),
    }


def _detachment(task: Task) -> dict[str, xr.Dataset]:
    """Return resisting moments, of the simulation's contacts, and the critical flow."""
    groups = task.groups
    places = task.plan.subregions
    solved = task.groups["solutions/adhesive"]
    moments = simulated_moments(task.specimen, solved, preload=task.plan.preload)
    out = {"solutions/rolling": moments}
    all_groups = groups | out
    for way, group in report.CRITICAL.items():
        if f"solutions/{way}" in groups:
            out[group] = without_warnings(critical_load, report.run_moments(all_groups, way), flow=task.plan.flow)
    return out | ({"statistics/rests": places} if are_resting_positions(places) else {})


def _adhesive_simulation(task: Task) -> dict[str, xr.Dataset]:
    """Return the simulation with adhesion at all places, and its error by mesh and step from a sample of places."""
    specimen = task.specimen
    plan = task.plan
    stages = task.stages
    options = task.options
    if task.has_sphere:
        _refuse_soft(specimen)
    how = {"preload": plan.preload, "law": plan.law}
    mesh = replace(plan.mesh, accuracy=None)
    finer = None
    with warnings.catch_warnings():
        # the choice of the mesh and the report's page deal with contacts that a mesh does not resolve
        warnings.simplefilter("ignore", UnresolvedContact)
        sampled = options | how | {"subregions": regions.sample(specimen.centres(plan.subregions), plan.checked)}
        if plan.mesh.cells == "auto":
            mesh, finer = _converged_mesh(specimen, plan, sampled, stages)
        elif sampled["subregions"].sizes["subregion"] < task.places:
            _need_pull_off(first := adhesive(specimen, mesh=mesh, **sampled))
            _show_answer(first, specimen, stages)
        before = stages.passed()
        solved = adhesive(specimen, mesh=mesh, **options | how)
        took = stages.passed() - before
        why, seconds = _durations_after(took, task.places, plan.budget)
        stages.expect(why, **seconds)
    groups = {"solutions/adhesive": solved, "statistics/adhesive": pull_off(solved)}
    groups = groups if finer is None else report.with_mesh_error(groups | {"solutions/finer": finer})
    _show_answer(groups["statistics/adhesive"], specimen, stages)
    return groups


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
    mesh = replace(task.plan.mesh, cells=int(median_place["mesh"].max()), accuracy=None)
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


def _durations_after(took: float, places: int, budget: int) -> tuple[str, dict[str, float]]:
    """Return why stages that solve places again may last longer than usual, and how long, s.

    ``took`` is the duration of the simulation with adhesion at all places, s.
    """
    one_place = took / places
    why = f"each place took {number(one_place, 's', 2)}"
    seconds = {
        "curves": 2 + 2.5 * min(places, _CURVE_PLACES) * one_place,
        "budget": 5 + 17 * budget * one_place,  # as many solves of each place
        "rolling": 3 + 0.8 * took,
    }
    return why, seconds


def _show_answer(solved: xr.Dataset, specimen: Specimen, stages: Stages) -> None:
    """Print the preliminary answer from the solved places, once their mesh was checked."""
    no_pull_off = not bool((solved["pull_off_force"] > 0).any())
    if no_pull_off or np.isnan(mesh_error(solved)) or is_noise(specimen.scan):
        return
    stages.answer(headline(mean_pull_off(solved).drop_vars(["smooth_share", "independent_places"])))


def _need_pull_off(first: xr.Dataset) -> None:
    """Raise if none of the first places could be solved, before hours are spent on the others."""
    if bool(first["pull_off_force"].notnull().any()):
        return
    lost, edge = (int(flags.sum()) for flags in (~first["complete"], first["truncated"]))
    raise Refusal(
        "simulation with adhesion",
        f"a pull-off at one of the first {first['pull_off_force'].size} places",
        f"none ({lost} not completed, {edge} in contact at the scan's edge)",
        _REMEDY,
    )


def _refuse_soft(specimen: Specimen) -> None:
    """Raise if JKR's contact of the smooth sphere without load is much wider than the scan."""
    pair = specimen.pair
    wide = 2 * _WITHOUT_LOAD * pair.contact_at_pull_off(pair.sphere_radius, pair.work)[0]
    x_low, x_high, y_low, y_high = regions.extent(specimen.bodies)
    side = min(x_high - x_low, y_high - y_low)
    if wide > _WIDEST_CONTACT * side:
        raise Refusal(
            "sphere_radius",
            f"a smooth sphere's contact that fits on a scan of {side:.3g} nm",
            f"one {wide:.3g} nm wide",
            _REMEDY,
        )


def _converged_mesh(specimen: Specimen, plan: Plan, options: dict[str, Any], stages: Stages) -> tuple[Mesh, Any]:
    """Return the mesh on which the mean pull-off has converged, and results on a finer one.

    On pixels wider than the contacts, the pull-off on the coarsest valid mesh may be wrong by a factor.
    """
    mesh = replace(plan.mesh, accuracy=None)
    coarse = adhesive(specimen, mesh=mesh, **options)
    _need_pull_off(coarse)
    _show_answer(coarse, specimen, stages)
    n = int(coarse["mesh"].max())
    checked_mesh: tuple[Mesh, Any] = mesh, None
    while 2 * n <= MOST_REFINED:
        try:
            finer = adhesive(specimen, mesh=Mesh(2 * n, step=0.5 * longest_step(specimen, mesh)), **options)
        except TooManyCells:  # the largest error that was found is stated with the result
            break
        change = abs(coarse["pull_off_force"] / finer["pull_off_force"] - 1)
        stated = change.copy(data=coarser_mesh_error(change.values, finer.attrs["law"]))
        _show_answer(finer.assign(pull_off_error=stated), specimen, stages)
        if not mesh_error(finer.assign(pull_off_error=change)) > (plan.mesh.accuracy or np.inf) or 4 * n > MOST_REFINED:
            return mesh, finer
        checked_mesh = mesh, finer
        mesh = replace(mesh, cells=2 * n)
        coarse = finer
        n = 2 * n
    return checked_mesh


def _rigid_bodies(task: Task) -> dict[str, xr.Dataset]:
    """Return the force between rigid bodies and, for a sphere, the recommended model and the usual formulas."""
    specimen = task.specimen
    mesh = int(np.clip(np.ceil(task.specimen.pixel / _RIGID_CELL), 1, 8))
    # without warnings about the cell size, which the report gives for all methods
    summed = without_warnings(rigid, specimen, delta=[0.0], mesh=mesh, **task.options)
    groups = {"solutions/rigid": summed, "statistics/rigid": without_warnings(pull_off, summed)}
    if task.has_sphere and not task.is_coated:
        sampled = regions.sample(specimen.centres(task.plan.subregions), _FORMULA_PLACES)
        groups["statistics/regime"] = without_warnings(regime, specimen, subregions=sampled, mesh=mesh)
        groups["statistics/formulas"] = without_warnings(formulas, specimen, subregions=sampled, mesh=mesh)
    return groups


def _one_contact(specimen: Specimen, plan: Plan, solved: xr.Dataset) -> xr.Dataset:
    """Return the fields at the place of median force among those away from the scan's edge."""
    last = solved.isel(delta=-1)
    inner = last.where(~last["truncated"] & (last["force"] > 0), drop=True)
    inner = inner if inner.sizes["subregion"] else last
    middle = inner.sortby("force").isel(subregion=[inner.sizes["subregion"] // 2])
    return loading(direct(specimen, delta=[plan.contact_delta], subregions=middle, fields=True))


def _has_asperity_sums(task: Task) -> bool:
    return not task.is_humid and not task.is_coated


class Part(NamedTuple):
    """A stage of a run, with its duration (s) and its duration per place (s): medians of runs on two cores."""

    name: str
    words: str
    applies: Callable[[Task], bool]
    fixed: float
    each: float
    make: Callable[[Task], dict[str, xr.Dataset]]


#: The stages of a run, in order.
PARTS = (
    Part("asperities", "asperities", lambda task: True, 3.0, 0.0, _surface),
    Part("adhesive", "simulation with adhesion", lambda task: task.adheres, 5.0, 0.2, _adhesive_simulation),
    Part("curves", "force over displacement", lambda task: task.adheres, 5.0, 0.0, _curves_around_pull_off),
    Part("budget", "error budget", lambda task: task.adheres and task.plan.budget > 0, 10.0, 0.0, _error_budget),
    Part("extrapolated", "roughness below the pixel", lambda task: task.adheres, 1.0, 0.0, _extrapolated_pull_off),
    Part("rigid", "rigid bodies", lambda task: task.adheres, 2.0, 0.15, _rigid_bodies),
    Part("direct", "simulation without adhesion", lambda task: True, 2.0, 0.05, _elastic_simulation),
    # neighbours' menisci merge, and layers are no half spaces: no sum over asperities
    Part("superposition", "superposed asperities", _has_asperity_sums, 3.0, 0.0, _superposed_asperities),
    Part("rolling", "detachment", lambda task: task.adheres and task.has_sphere, 4.0, 0.4, _detachment),
)

#: The last stage, after those of `PARTS`.
_PAGES = "figures and report"

#: Tables that are also written as files, by the name of the file.
_TABLE_FILES = {"scan": "Scan and asperities", "contact": "Pull-off force by method", "force": "Force without adhesion"}


def _applicable(task: Task, parts: Sequence[Part] | None) -> list[Part]:
    """Return those of some stages, by default of all, that apply to a run."""
    return [part for part in (PARTS if parts is None else parts) if part.applies(task)]


def write_tables(tables: Mapping[str, Any], printed: str, folder: Path) -> None:
    """Write the tables as text, and some of them as files of their own."""
    with atomic_write(folder / "table.txt") as temporary:
        temporary.write_text(printed, encoding="utf-8")
    for part, title in _TABLE_FILES.items():
        if title in tables:
            with atomic_write(folder / f"table-{part}.csv") as temporary:
                tables[title].to_csv(temporary, float_format="%.6g")


def write_figures(groups: Mapping[str, xr.Dataset], draw_figures: Callable, folder: Path) -> None:
    """Write the figures that a function yields by name."""
    groups["solutions/contact"].load()  # else each of its figures reads the fields from the file again
    for name, figure in draw_figures(groups):
        with atomic_write(folder / f"{name}.png") as temporary:
            figure.savefig(temporary, dpi=220)


def _write_pages(groups: Mapping[str, xr.Dataset], path: Path, folder: Path) -> None:
    """Write the table of places and the report."""
    if places := report.by_place(groups):
        for ending in (".csv", ".xlsx") if find_spec("openpyxl") else (".csv",):
            to_table(report.place_table(places, scan_label(groups)), folder / f"places{ending}")
    with atomic_write(folder / "report.html") as temporary:
        temporary.write_text(report.page(groups, archive_name=path.name), encoding="utf-8")


def notes(run: Mapping[str, xr.Dataset]) -> list[str]:
    """Return the notes below a run's tables."""
    return [*report.superposition_notes(run), *report.detachment_notes(run)]


def tables_text(tables: Mapping[str, Any], below: Sequence[str], answer: str = "") -> str:
    """Return the answer, the tables and the notes below them as text."""
    first = [fill(answer, 100) + "\n"] if answer else []
    parts = [report.text(table, title) for title, table in tables.items()]
    return "\n".join([*first, *parts, *(fill(note, 100) for note in below)]) + "\n"
