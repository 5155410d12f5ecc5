"""A run: the complete analysis of one scan, from asperities to the statistics of pull-off and detachment.

Its result is a dictionary of Datasets, the groups of its archive:

    scan, asperities, reconstruction
    solutions/adhesive, /extrapolated (with the roughness extrapolated below the scan),
    /rigid, /direct, /contact (fields of one place), /smooth (the same sphere on a flat), /hertz,
    /energy (superposed asperities), /rolling (resisting moments)
    statistics/adhesive, /rigid, /energy, /roughness, /regime (the recommended model), /formulas (pull-off by the
    usual formulas), /extrapolated, /detachment and /detachment_extrapolated (the critical flow), /error_budget,
    /summary (the answer), /places (one row a place)
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import Any

import xarray as xr

from ...files.doors import refuse_place
from ...files.images.backend import open_scan
from ...files.storage import remove_leftovers
from ...mechanics.bodies.pair import assign_pair
from ...mechanics.contact.adhesion import warn_of_time
from ...mechanics.contact.mesh import Mesh, read_mesh
from ...mechanics.jobs.progress import print_line, rough_duration
from ...mechanics.particles import resting
from ...mechanics.particles.force_balance import read_body
from ...mechanics.particles.loads import Flow
from ...mechanics.scans.levelling import METHODS, level
from ...mechanics.specimen import Specimen, need_wide_scan, specimen_of
from ...mechanics.studies.extrapolation import refuse_synthetic
from ...mechanics.studies.finer_scan import second_scan
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal, WrongCall
from ...mechanics.vocabulary.text import did_you_mean, warn
from ...mechanics.vocabulary.units import Places, Quantities, Quantity, positive
from .. import figures, report
from ..checkpoint import checkpointed
from ..wording import render_sentence
from .folder import notes, refuse_own_files, tables_text, write_figures, write_pages, write_tables
from .parts import PARTS, SILENT, Part, Task
from .plan import Plan, plan, usual_mesh
from .run_options import check_output, read_adhesion
from .stages import Stages


def run(
    scan: xr.Dataset | str | os.PathLike,
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
    shortest: Quantity | None = None,
    flow: str | Flow = "air",
    command: str = "",
    **pair: Any,
) -> dict[str, xr.Dataset]:
    """Analyse a scan, and write archive, figures, tables and report; called again after an interruption, it resumes.

    Parameters
    ----------
    scan : Dataset or path
        A scan with an assigned pair, or the file of one for `open_scan`.
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
    shortest : number or quantity, optional
        Shortest wavelength of the surface, nm, where it is known, see `extrapolated`.
    flow : {"air", "water"} or Flow
        The fluid that detaches the sphere, see `critical_load`; it does not change the adhesion (`assign_pair` has the
        medium in which the bodies adhere).
    command : str
        Shown in the report as the command that repeats the run.
    **pair
        The two bodies as for `assign_pair`, if they are not assigned yet.

    Returns
    -------
    dict of str to Dataset
        The groups of the archive. Subregions are solved on the active ``distributed.Client``, on the scheduler that
        ``dask.config.set(scheduler=…)`` names, or else on threads.

    Raises
    ------
    ValueError
        If the sphere does not fit the scan, levelling, law or mesh is not among those listed, or no place has a pull-
        off; or if the output would replace files that are no run's.

    Examples
    --------
    Two places on a small scan without adhesion, the printed tables suppressed.

    >>> from pathlib import Path
    >>> import roughxr
    >>> import contextlib, io, tempfile
    >>> from roughxr.scans import synthetic
    >>> scan = synthetic.self_affine((32, 32), 20, rms=1, hurst=0.8, rolloff=300, cutoff=150, seed=1)
    >>> scan = scan.contact.assign_pair(sphere_radius=500, contact_modulus=40, work_of_adhesion=0)
    >>> with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as printed:
    ...     groups = roughxr.run(scan, Path(folder) / "roughxr.run.nc", subregions=(2, 1), delta=[1.0, 2.0])
    >>> dict(groups["solutions/direct"].force.sizes), "asperities" in printed.getvalue()
    ({'subregion': 2, 'delta': 2}, True)
    """
    output = Path(output)
    check_output(output)
    scan = _paired(scan, pair)
    adhesion = read_adhesion(preload, law, budget)
    if schema.one_of(levelling, (*METHODS, "none"), "levelling") != "none":
        scan = level(scan, method=levelling)
        finer = None if finer is None else level(finer, method=levelling)
    specimen = specimen_of(scan)
    need_wide_scan(specimen.heights, specimen.sides, specimen.pair.sphere_radius)
    if finer is not None:  # refused before minutes are spent
        refuse_synthetic(scan, finer)
        second_scan(specimen.scan, finer)
    if specimen.indenter.map is None:
        flow = read_body(specimen.bodies, None, flow).flow
    adhesion |= {"mesh": read_mesh(mesh, usual_mesh(specimen)), "finer": finer, "flow": flow}
    adhesion |= {"shortest": None if shortest is None else positive(shortest, "nm", "shortest")}
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
    path = output if alone else output / "run.nc"
    if not path.exists():
        _warn_of_time(specimen, wanted)
    return execute(specimen, wanted, path, None if alone else output, command=command)


def execute(
    specimen: Specimen,
    plan: Plan,
    path: Path,
    folder: Path | None,
    *,
    command: str = "",
    parts: Sequence[Part] | None = None,
    tables: Callable = lambda run, general_tables: general_tables,
    as_text: Callable = lambda run, tables: tables_text(tables, notes(run), report.headline(run)),
    draw_figures: Callable = lambda run: [("overview", figures.overview(run))],
) -> dict[str, xr.Dataset]:
    """Compute the groups that a run's archive lacks, write its files or print its tables, and return all groups."""
    refuse_place(path)
    if folder is not None:
        refuse_own_files(folder)
    task = Task(specimen, plan)
    parts = _applicable(task, parts)
    expected, compiling = _durations(parts, task.places)
    labels = {part.name: part.words for part in parts} | {"pages": _PAGES}
    if not path.exists():
        values = _start_values(task, sum(expected.values()), sum(compiling.values()))
        print_line(render_sentence("start.toml", "start", values))
    with Stages(expected, labels, compiling) as stages:
        groups = checkpointed(
            lambda: analyse(specimen, plan, stages, command, parts),
            path,
            scan=specimen.scan,
            arguments=plan._asdict() | {"parts": [part.name for part in parts]},
            title=specimen.bodies.attrs.get("title", ""),
            missing=lambda: f"missing: {', '.join(w for w in stages.later() if w != _PAGES) or 'its log'}",
        )
        general_tables = report.tables(groups)
        made = tables(groups, general_tables)
        printed = as_text(groups, made)
        if folder is not None and not os.access(folder, os.W_OK):
            warn(f"{folder}: is read only: the run is read, and its pages stay as they are")
        elif folder is not None:
            stages("pages")
            remove_leftovers(folder)
            write_tables(made, printed, folder)
            write_figures(groups, draw_figures, folder)
            write_pages(groups, general_tables, path, folder)
    if folder is None:
        print(printed.rstrip("\n"))
    return groups


def _paired(scan: xr.Dataset | str | os.PathLike, pair: Mapping[str, Any]) -> xr.Dataset:
    """Return a scan, read from its file if it is one, with its pair of bodies."""
    options = signature(assign_pair).parameters
    if unknown := [name for name in pair if name not in options]:
        similar = did_you_mean(unknown[0], (*signature(run).parameters, *options))
        raise WrongCall(unknown[0], "an option of run or assign_pair", f"no such option{similar}")
    opened = scan if isinstance(scan, xr.Dataset) else open_scan(scan)
    return assign_pair(opened, **pair) if pair else opened


def _durations(parts: Sequence[Part], places: int) -> tuple[dict[str, float], dict[str, float]]:
    """Return the usual duration (s) of each stage, and of compiling its kernels, which it contains."""
    compiling = {part.name: part.compiling for part in parts if part.compiling > 0}
    expected = {part.name: part.fixed + part.each * places + compiling.get(part.name, 0.0) for part in parts}
    return expected | {"pages": _PAGES_DURATION}, compiling


def _warn_of_time(specimen: Specimen, plan: Plan) -> None:
    """Warn of soft places that take minutes on a mesh that is refined."""
    if specimen.pair.work > 0 and plan.mesh.cells == "auto":
        warn_of_time(specimen, preload=plan.preload, law=plan.law)


def _start_values(task: Task, expected: float, compiling: float) -> dict[str, Any]:
    """Return how many places a run has, and how long it takes (s), of which kernels are compiled for some time."""
    rows, columns = task.specimen.heights.shape
    return {
        "places": task.places,
        "several": task.places > 1,
        "rows": rows,
        "columns": columns,
        "duration": rough_duration(expected),
        "compiling_time": rough_duration(compiling) if compiling else None,
    }


def analyse(
    specimen: Specimen,
    plan: Plan,
    stages: Stages = SILENT,
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


#: The last stage, after those of `PARTS`.
_PAGES = "figures and report"

#: Its duration (s), with the archive's.
_PAGES_DURATION = 4.5


def _applicable(task: Task, parts: Sequence[Part] | None) -> list[Part]:
    """Return those of some stages, by default of all, that apply to a run."""
    return [part for part in (PARTS if parts is None else parts) if part.applies(task)]
