"""The adhesive contact of an indenter with the scan, followed through approach and retraction at every place.

One task holds the whole cycle of one subregion, because each state on retraction depends on all states before it. The
options are read and the results labelled here; `cycle` follows one place.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..bodies.liquid import Menisci, menisci_of, work_of
from ..bodies.pair import range_of
from ..jobs import spread
from ..jobs.records import BRANCHES, Layout
from ..kernels.adhesion import path as path
from ..kernels.adhesion.states import ON_THE_WAY, TOLERANCE
from ..kernels.adhesion.traction_laws import TAIL
from ..specimen import Specimen, specimen_of
from ..vocabulary import schema
from ..vocabulary.text import warn
from ..vocabulary.units import Places, Quantities, whole_number
from .cycle import (
    LEAST_RADIUS,
    MOST_CELLS,
    Adhesion,
    Cycles,
    cycles_at,
    deepest_of,
    events,
    extrapolation,
    largest_cell,
    overlapping_cells,
    reach_of_law,
    reached,
    yielding_of,
)
from .elastic import ABOVE_HARDNESS, YIELDED
from .estimates import law_of_range, median_tabor
from .mesh import MOST_REFINED, Mesh, mesh_of
from .problem import Place, Problem, deepest, places, read_problem, surface_at
from .solving import fields_of, put_fields, solve

#: Laws of adhesion; "auto" chooses between the first two.
LAWS_OF_ADHESION = ("auto", "exponential", "griffith", "dugdale", "lennard_jones")

_STATES = {
    "force": float,
    "contact_area": float,
    "energy": float,
    "dissipated": float,
    "contact_patches": float,
    "resolution": float,
    "iterations": int,
    "residual": float,
    "converged": bool,
}
_EVENTS = {
    "snap_in_force": float,
    "snap_in_delta": float,
    "pull_off_force": float,
    "pull_off_delta": float,
    "detachment_delta": float,
    "work_of_separation": float,
    "hysteresis": float,
    "pull_off_resolution": float,
    "pull_off_error": float,
    "mesh_error": float,
    "step_error": float,
    "interpolation_error": float,
    "settling_error": float,
    "refinement": int,
    "truncated": bool,
    "complete": bool,
}
_AT_PRELOAD = {"preload_delta": float, "contact_area": float, "residual": float, "converged": bool}

#: States of a law with an edge that are extrapolated.
_EXTRAPOLATED = ("force", "contact_area", "energy", "dissipated")

#: By these words a warning is known that a run gives on its page.
SMALL_CONTACTS = "contacts with a radius below"

#: Tabor's parameter above which a sphere jumps into contact.
_LEAST_JUMP = 0.7

#: Below first contact, a body under a preload is followed as deep as a smooth sphere would sink in, and deeper by so
#: many standard deviations of the heights.
_ROUGH_DEPTH = 4.0

#: The usual step, in ranges of adhesion and as a part of JKR's displacement δ_c: the longer of both. A run takes steps
#: longer by the last factor, and compares them with half of them.
_STEP_OF_RANGE, _STEP_OF_DISPLACEMENT, LONG_STEP = 5 / 6, 1 / 40, 1.6

#: Side of the cells on the coarsest mesh without range, in ranges of adhesion and as a part of JKR's radius a_c: the
#: larger of both.
_CELL_OF_RANGE, _CELL_OF_RADIUS = 50 / 3, 0.1

#: Cells so many times larger than "exponential" bears (`largest_cell`) are refused: pull-offs are many times too large
#: there, and Newton's method hardly converges.
_LARGEST_EXCESS = 20.0

#: The cells are the scan's pixels.
_AS_SCANNED = Mesh(1, None)


def adhesive(
    ds: xr.Dataset | Specimen,
    *,
    preload: Quantities | None = None,
    delta: Quantities | None = None,
    subregions: Places = None,
    law: str = "auto",
    mesh: Mesh | int | str = "auto",
    datum: str | None = None,
    cycles: int = 1,
    fields: bool = False,
) -> xr.Dataset:
    """Follow the adhesive contact of the assigned indenter with the scan through approach and retraction.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair with a work of adhesion.
    preload : number, quantity or array of them, optional
        Force (nN) at which the indenter turns back, once loading reaches it. 0, the default: it settles under its own
        adhesion, as a particle that lands. Several preloads, ascending, share one loading path and lie along
        ``preload``.
    delta : array_like, optional
        Displacements, nm, ascending, in place of a preload. Loading visits them one after the other, retraction in
        reverse order and then further out until all contact is lost.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    law : {"auto", "exponential", "griffith", "dugdale", "lennard_jones"}
        The traction t between the surfaces across a gap u, with the same work of adhesion w for all laws:
        "exponential", t = (w/ρ) exp(−u/ρ); "griffith", the limit without range (JKR's); "dugdale", a constant tension
        up to a gap; "lennard_jones", the 9-3 potential of two half spaces beyond a hard contact, cut at 11 z₀. "auto"
        takes "griffith" where the median of Tabor's parameter over the asperities is at least 5 and the body does not
        yield, else "exponential". The solids of a humid pair attract by "exponential"; condensed liquid adds its
        tension up to its height.
    mesh : "auto", int or Mesh
        "auto": at each place cells and steps are halved until the estimated error of the pull-off is below 0.05. Or the
        cells along a side of a pixel, as ``mesh=4``, or a `Mesh`, which also states the accuracy and the steps. Heights
        between the pixels are those of the surface without wavelengths shorter than two pixels.
    datum : {"highest_peak", "first_contact"}, optional
        Where delta = 0, as in `direct`; by default the highest peak with ``delta``, first contact with a preload.
    cycles : int
        Number of cycles at each place, with a preload, each on the shape that the cycle before has left; along
        ``cycle`` where there are several.
    fields : bool
        Keep pressure, displacement and gap on the cells of the window around each centre, on both branches, at the
        displacements of ``delta``; NaN beyond the scan's edge. Needs one mesh for all places.

    Returns
    -------
    Dataset
        Along subregion (and preload), from all steps of the cycle: ``snap_in_force``, ``snap_in_delta``,
        ``pull_off_force``, ``pull_off_delta``, ``detachment_delta`` (to half a step), ``work_of_separation``,
        ``hysteresis``, ``pull_off_resolution``, ``truncated`` (contact or liquid at the edge of the scan or of the
        indenter's map) and ``complete``. NaN where nothing is touched, the cycle could not be completed or the preload
        was not reached. With a preload also ``preload_delta``, the displacement at which the indenter turned back, and
        ``contact_area`` there.

        ``refinement`` and ``pull_off_error``, the estimated relative error of the pull-off. With mesh="auto" it
        combines ``mesh_error``, ``step_error``, ``interpolation_error`` (the change if splines interpolate the heights
        between pixels) and ``settling_error`` (the change, without range, after a preload as large as the pull-off,
        which closes gaps that attraction does not). On one mesh it is known for "griffith" and "dugdale" only, from
        the contact's radius in cells, the difference of both edges (see below) and the settling error.

        With ``delta``, along (subregion, branch, delta): ``force``, ``contact_area``, ``contact_patches`` (connected
        patches of cells), ``energy``, ``dissipated``, ``resolution`` (radius, in cells, of the smallest contact that
        bears a tenth of the tension), ``iterations``, ``residual``, ``converged``; fields along
        (subregion, branch, delta, x, y) with x, y from the contact centre.

        The coordinate ``shortest_wavelength`` (nm) is the shortest that the scan shows: finer roughness lowers the
        adhesion (`scale_dependence`).

        Where a hardness is assigned, or estimated for named materials, also ``yielded_fraction`` and
        ``yielded_area_fraction``, the shares of the pushing force and of the contact area at that pressure or above, at
        the preload or along the displacements. Where the body yields, also
        ``yielded_area``, ``plastic_work`` and the field ``residual_height``, as in `direct`.

    Raises
    ------
    ValueError
        If no pair or work of adhesion is assigned, the cells are too large for the law, or a mesh has too many.

    Warns
    -----
    UserWarning
        If contacts at pull-off are poorly resolved, places did not reach the accuracy, or contact or liquid reaches the
        scan's edge (for input in memory only).

    Notes
    -----
    The traction of "griffith" and "dugdale" ends abruptly. It is replaced by a traction with a steep edge, solved with
    the steepest edge that the cells resolve and with half that steepness, and the results are extrapolated. Fields and
    the states beside them are those of the steeper edge. Where both edges find different contacts, or the steeper edge
    pulls more (as at a rim that cannot move), its result is not extrapolated, and ``pull_off_error`` includes their
    difference. Without range only cells attract that have touched or come so near that the pair's attraction snaps
    them in, and the cells around them up to the opening of the edge.

    "lennard_jones" is cut off at a gap of 11 z₀ (the attribute ``cut_off_nm``), which leaves out 0.9 % of the work of
    adhesion. A smooth sphere pulls that much too little; stiff bodies of 0.5, 1.5 and 3 nm rms under a sphere of
    500 nm about 2, 10 and 17 %. ``pull_off_error`` does not include this; compare with `rigid`, which counts all gaps.

    A body yields on loading, where the pressure less the attraction would exceed its hardness by more than a part of
    1e-3 (see `direct`). Retraction is elastic on the shape that is left, and its tension is not limited.
    ``dissipated`` includes the plastic work. A flattened summit recovers and peels off.

    The errors leave out roughness finer than the scan's pixels.

    References
    ----------
    Griffith (1921); Johnson, Kendall & Roberts (1971); Pohrt & Popov (2015); Maugis (1992); Greenwood, Proc. R. Soc. A
    453 (1997) 1277.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> cycle = adhesive(scan, delta=[5, 10, 15], subregions=([312.5], [937.5]), mesh=1, law="griffith")
    >>> dict(cycle.force.sizes), bool(cycle.pull_off_force[0] > 0)
    ({'subregion': 1, 'branch': 2, 'delta': 3}, True)
    """
    specimen = specimen_of(ds)
    if preload is not None and delta is not None:
        raise ValueError("expected either preload or delta, found both")
    by_preload = delta is None
    datum = datum or ("first_contact" if by_preload else "highest_peak")
    positions = specimen.centres(subregions)
    adhesion = _adhesion_of(
        specimen,
        pair_law(specimen, law),
        preloads=_preloads(preload) if by_preload else np.zeros(0),
        mesh=mesh_of(mesh, Mesh()),
        cycles=cycles,
    )
    delta = [_settling_depth(specimen, adhesion)] if by_preload else delta
    problem = read_problem(specimen, positions, delta=delta, datum=datum, refine=max(adhesion.refine, 1))
    _need_resolved_law(adhesion, problem, ("dugdale", "lennard_jones", "exponential"))
    reach = reach_of(specimen, problem, adhesion)
    _need_few_cells(specimen, problem, adhesion, positions, reach)
    if fields:
        _need_one_mesh(specimen, problem, adhesion, by_preload)
    out = solve(
        _solve,
        specimen,
        problem,
        _layout(problem, adhesion, preload),
        adhesion,
        name="adhesive",
        positions=positions,
        reach=reach,
        fields=fields,
    )
    out.attrs = {"datum": datum, "method": "adhesive", **_described(adhesion)}
    arguments: dict[str, Any] = {"preload": preload, "delta": None if by_preload else problem.steps}
    arguments["subregions"] = subregions
    arguments |= {"datum": datum, "fields": fields, "mesh": mesh_of(mesh, Mesh())}
    arguments |= {"cycles": adhesion.cycles} if adhesion.cycles > 1 else {}
    out = schema.record(out, "adhesive", specimen.bodies, law=adhesion.law, **arguments)
    out = spread.finish(out)
    if not specimen.lazy:
        _warn(out, adhesion)
    return schema.label(out.assign_coords(shortest_wavelength=specimen.shortest_wavelength))


def _adhesion_of(specimen: Specimen, law, *, preloads, mesh: Mesh, cycles) -> Adhesion:
    """Return how the bodies adhere and how they are followed; raise where an option is out of its range."""
    step, first_cell = _usual_step_and_cell(specimen)
    settings = Adhesion(
        preloads=preloads,
        refine=0 if isinstance(mesh.refine, str) else mesh.refine,
        accuracy=np.nan if mesh.accuracy is None else mesh.accuracy,
        step=step if mesh.step is None else mesh.step,
        first_cell=first_cell,
        capture=_capture(specimen) if law["law"] == "griffith" and law["work"] > 0 else 0.0,
        cycles=whole_number(cycles, "cycles", least=1),
        **law,
    )
    if settings.cycles > 1 and not preloads.size:
        raise ValueError(
            f"cycles: several need a preload, found {cycles} with displacements (delta); leave delta or cycles out"
        )
    return settings


def step_of(specimen: Specimen, mesh: Mesh) -> float:
    """Return the longest step (nm) of a mesh: as stated, or the usual one."""
    return usual_step(specimen) if mesh.step is None else mesh.step


def usual_step(specimen: Specimen) -> float:
    """Return the longest step (nm) of a mesh that states none."""
    return _usual_step_and_cell(specimen)[0]


def _usual_step_and_cell(specimen: Specimen) -> tuple[float, float]:
    """Return the usual step and the side of the first cells (nm), from the range and JKR's lengths."""
    (modulus,), radius = schema.pair(specimen.bodies, "contact_modulus"), _contact_radius(specimen)
    work = work_of(specimen.bodies)
    displacement = 0.75 * (np.pi**2 * work**2 * radius / modulus**2) ** (1 / 3)
    contact_radius, length = (9 * np.pi * work * radius**2 / (8 * modulus)) ** (1 / 3), range_of(specimen.bodies)
    step = max(_STEP_OF_RANGE * length, _STEP_OF_DISPLACEMENT * displacement)
    return step, max(_CELL_OF_RANGE * length, _CELL_OF_RADIUS * contact_radius)


def settling(
    ds: xr.Dataset | Specimen, *, preload: Any = 0.0, law: str = "exponential", mesh: Mesh = _AS_SCANNED
) -> tuple[Problem, Adhesion]:
    """Return how the indenter is followed to a preload (nN) and off again on one mesh.

    The one displacement of the problem is the depth (nm beyond first contact) down to which the preload is looked for.
    """
    specimen = specimen_of(ds)
    adhesion = _adhesion_of(specimen, pair_law(specimen, law), preloads=_preloads(preload), mesh=mesh, cycles=1)
    depth = [_settling_depth(specimen, adhesion)]
    at = specimen.centres(None)
    problem = read_problem(specimen, at, delta=depth, datum="first_contact", refine=adhesion.refine)
    _need_resolved_law(adhesion, problem)
    return problem, adhesion


def pair_law(specimen: Specimen, law: str) -> dict[str, Any]:
    """Return the law and its length; raise where law and yielding do not go together."""
    ds = specimen.bodies
    schema.one_of(law, LAWS_OF_ADHESION, "law")
    yields = "hardness" in ds.coords
    (work,) = schema.pair(ds, "work_of_adhesion", humid=True)
    length = range_of(ds, law)
    if (menisci := menisci_of(ds)) is not None:
        return _law_with_liquid(ds, law, menisci, length)
    if law == "auto":
        law = law_of_range(_tabor_parameter(specimen, length), yields=yields) if work > 0 else "griffith"
    if yields:
        _need_hardness_above(float(ds["hardness"]), work, length, law)
    return {"law": law, "length": np.nan if law == "griffith" else length, "work": work}


def _capture(specimen: Specimen) -> float:
    """Return the gap (nm) at which the pair's attraction snaps in a summit of the scan."""
    length = range_of(specimen.bodies)
    return snap_in_gap(length, median_tabor(specimen, length))


def _tabor_parameter(specimen: Specimen, length: float) -> float:
    """Return the median of Tabor's parameter over the asperities; where there are none, that of the sphere alone."""
    parameter = median_tabor(specimen, length)
    if np.isfinite(parameter) or specimen.indenter.map:
        return parameter
    modulus, work = schema.pair(specimen.bodies, "contact_modulus", "work_of_adhesion", humid=True)
    return float((_indenter_radius(specimen) * work**2 / (modulus**2 * length**3)) ** (1 / 3))


def snap_in_gap(length: float, parameter: float) -> float:
    """Return the gap (nm) at which van der Waals attraction of a range z₀ (nm) snaps in a sphere.

    The undeformed gap (2.641 µ^{3/7} − 1) z₀ by Tabor's parameter µ (Wu, J. Adhesion 86 (2010) 1071). The balance of
    attraction and elasticity gives the power; a solution of the sphere's equations confirms the factor to 0.7 % at µ of
    1 to 100 (``tests/test_soft_bodies.py``). Below 0.7 a sphere does not jump.
    """
    return (2.641 * parameter ** (3 / 7) - 1.0) * length if parameter > _LEAST_JUMP else 0.0


def _law_with_liquid(ds, law: str, menisci: Menisci, length: float) -> dict[str, Any]:
    """Return the sum of the liquid's law and the solids', whose work beyond the liquid's edge is added within it."""
    if law not in ("auto", "exponential"):
        raise ValueError(f"law: expected 'exponential' for the solids of a humid pair, found {law!r}")
    (work,) = schema.pair(ds, "work_of_adhesion", humid=True)
    beyond = np.exp(-menisci.height / length)
    work *= menisci.share + (1 - menisci.share) * beyond
    if "hardness" in ds.coords:
        _need_hardness_above(float(ds["hardness"]), work + menisci.pull * length, length, "exponential")
    return {"law": "exponential", "length": length, "work": work, "liquid": menisci}


def _need_hardness_above(hardness: float, work: float, length: float, law: str) -> None:
    """Raise where a body cannot yield: without adhesion, or under adhesion alone."""
    advice = "or assign no hardness, for elastic bodies"
    if work == 0:
        raise ValueError(
            f"work_of_adhesion: expected more than 0 for bodies that yield, found 0; take direct, {advice}"
        )
    if law != "griffith" and hardness <= work / length:  # without range the pull has no bound to be held against
        raise ValueError(
            f"hardness: expected more than the adhesive traction, {work / length:.3g} GPa over {length:.3g} nm, found "
            f"{hardness:.3g} GPa; assign the adhesion_range that belongs to the work of adhesion, {advice}"
        )


def _preloads(preload: Any) -> np.ndarray:
    """Return preloads in nN, ascending; raise where one is negative."""
    given = 0.0 if preload is None else preload
    values = schema.ascending(given, "nN", "preload")
    if values[0] < 0:
        raise ValueError(f"preload: expected at least 0 nN (a particle that settles), found {values[0]:g} nN")
    return values


def _settling_depth(specimen: Specimen, adhesion: Adhesion) -> float:
    """Return the depth (nm) beyond first contact down to which loading is followed to find its preload.

    It is the depth to which the largest load and the adhesion press a smooth sphere, by Hertz's and JKR's formulas,
    and some standard deviations of the heights, so that nearly all of the surface lies higher.
    """
    ds = specimen.bodies
    (modulus,) = schema.pair(ds, "contact_modulus")
    radius = _indenter_radius(specimen)
    load = float(adhesion.preloads[-1]) + 6 * np.pi * adhesion.whole * radius
    hertz = (0.75 * load / (modulus * np.sqrt(radius))) ** (2 / 3)
    if "hardness" in ds.coords:  # a fully yielding sphere sinks in until the area, at the hardness, bears the load
        hertz += load / (2 * np.pi * radius * float(ds["hardness"]))
    return float(hertz + _ROUGH_DEPTH * specimen.heights.std() + 12 * np.nan_to_num(adhesion.length))


def _indenter_radius(specimen: Specimen) -> float:
    """Return the sphere's radius (nm), or that of the paraboloid whose mean depth is that of an indenter's map."""
    ds = specimen.bodies
    if "sphere_radius" in ds.coords:
        return float(ds["sphere_radius"])
    height = ds["indenter_height"]
    r2 = (height["indenter_x"] ** 2 + height["indenter_y"] ** 2).transpose(*height.dims)
    depth = float((height.max() - height).mean())
    return float(r2.mean()) / (2 * depth) if depth > 0 else float(np.sqrt(r2.max()))


def _contact_radius(specimen: Specimen) -> float:
    """Return the radius (nm) by which JKR's lengths scale steps and cells: the indenter's, or that of the heights.

    Across the half-width L of a scan whose heights differ by z, an indenter flatter than L²/2z is as good as a plane.
    """
    heights = specimen.heights
    half, rise = 0.5 * specimen.pixel * min(heights.shape), float(np.ptp(heights))
    radius = _indenter_radius(specimen)
    return min(radius, half**2 / (2 * rise)) if rise > 0 else radius


def _need_resolved_law(adhesion: Adhesion, problem: Problem, laws=("dugdale", "lennard_jones")) -> None:
    """Refuse laws with a wall or a process zone that the cells cannot show: their forces would be wrong."""
    if adhesion.law not in laws or adhesion.work == 0:
        return
    cell = largest_cell(adhesion.law, adhesion.length, problem.contact_modulus, adhesion.work)
    cell *= _LARGEST_EXCESS if adhesion.law == "exponential" else 1.0
    smallest = problem.pixel / (adhesion.refine or MOST_REFINED)
    if smallest > cell:
        refine = int(np.ceil(problem.pixel / cell))
        other = "griffith" if adhesion.law == "exponential" else "exponential"
        advice = f"mesh={refine}, or law={other!r}" if refine <= MOST_REFINED else f"law={other!r}"
        raise ValueError(
            f"law={adhesion.law!r}: expected cells of at most {cell:.3g} nm (larger ones cannot follow its traction), "
            f"found {smallest:.3g} nm; take {advice}"
        )


def _need_few_cells(specimen: Specimen, problem: Problem, adhesion: Adhesion, positions: xr.Dataset, reach) -> None:
    """Refuse one mesh for all places that is too fine for any of them; name the finest that is not."""
    if not adhesion.refine:
        return
    solved, shape = places(specimen, positions, reach)
    if shape[0] * shape[1] * adhesion.refine**2 <= MOST_CELLS:  # windows are wider than what they hold
        return
    surfaces = [surface_at(place, problem._replace(refine=1)) for place in solved]
    cells = max(overlapping_cells(surface, problem, adhesion) for surface in surfaces)
    if cells * adhesion.refine**2 > MOST_CELLS:
        finest = int(np.sqrt(MOST_CELLS / cells))
        advice = f"take mesh={finest}" if finest else "take a smaller preload or delta, or a coarser scan"
        raise ValueError(
            f"mesh: expected at most {MOST_CELLS:g} cells within reach, found {cells * adhesion.refine**2:.3g} with "
            f"mesh={adhesion.refine}; {advice}"
        )


def _need_one_mesh(specimen: Specimen, problem: Problem, adhesion: Adhesion, by_preload: bool) -> None:
    """Raise where fields are asked for without displacements, or on meshes that differ between places."""
    if by_preload or not adhesion.refine:
        raise ValueError("fields: expected displacements (delta) and one mesh for all places, such as mesh=4")


def reach_of(specimen: Specimen, problem: Problem, adhesion: Adhesion) -> float:
    """Return the half-width (nm) of the windows: the overlap, and as far as adhesion draws the surface up."""
    if problem.indenter.map:
        return problem.indenter.reach(np.inf)
    depth = deepest(specimen, problem._replace(first_contact=problem.first_contact or adhesion.preloads.size > 0))
    if np.isinf(depth):
        return np.inf
    attraction = reach_of_law(adhesion, problem)
    reach = problem.indenter.reach(depth)
    for _ in range(20):  # JKR's contact of that radius draws the surface up by √(2πaw/E*)
        uplift = np.sqrt(2 * np.pi * reach * adhesion.whole / problem.contact_modulus)
        reach = problem.indenter.reach(depth + uplift + attraction)
    return reach + problem.pixel


def _layout(problem: Problem, adhesion: Adhesion, preload: Any) -> Layout:
    hard = ABOVE_HARDNESS if np.isfinite(problem.hardness) else {}
    hard = hard | YIELDED if problem.yielding else hard
    if adhesion.preloads.size == 0:
        axes = {"branch": list(BRANCHES), "delta": problem.steps}
        return Layout(axes, _STATES | hard, _EVENTS, yields=problem.yielding)
    axes = {"cycle": np.arange(1, adhesion.cycles + 1)} if adhesion.cycles > 1 else {}
    axes |= {} if preload is None or np.ndim(preload) == 0 else {"preload": adhesion.preloads}
    return Layout(axes, _EVENTS | _AT_PRELOAD | hard)


def _solve(place: Place, problem: Problem, layout: Layout, adhesion: Adhesion) -> np.ndarray:
    """Follow the cycles of one place, one for each preload, and return their record."""
    cycles, errors = cycles_at(place, problem, adhesion, fields=layout.window is not None)
    record = layout.blank()
    for k, followed in enumerate(cycles.paths):
        results: dict[str, Any] = events(cycles, k) if reached(followed, adhesion, k) else {}
        reach = deepest_of(followed, cycles) + (adhesion.liquid.height if adhesion.liquid else 0.0)
        results |= {"complete": bool(results), "truncated": cycles.surface.unknown_from < reach}
        results |= {name: np.broadcast_to(value, len(cycles.paths))[k] for name, value in errors.items()}
        if adhesion.preloads.size and results["complete"]:
            turns = [paths[k].states[paths[k].turn - 1] for paths in (cycles.paths, cycles.wider or cycles.paths)]
            to_edge = extrapolation(cycles, k)
            depth, area = (to_edge.of(*(turn[name] for turn in turns)) for name in ("delta", "contact_area"))
            results |= {"preload_delta": depth, "contact_area": max(area, 0.0)}
            results |= {"converged": bool(followed.states["converged"].all())}
            results |= {"residual": followed.states["residual"].max()}
            shares = yielding_of(followed, cycles.problem)
            results |= {name: values[followed.turn - 1] for name, values in shares.items()}
        for name, value in results.items():
            record[name][np.unravel_index(k, record[name].shape)] = value
    if "branch" in layout.axes:
        record["complete"] = cycles.paths[0].status == path.CONVERGED
        _put_states(record, cycles, extrapolated=layout.window is None)  # so that fields and forces agree
    if layout.window is not None:
        _put_fields(record, cycles, problem)
    return record


def _put_states(record: np.ndarray, cycles: Cycles, *, extrapolated: bool) -> None:
    """Write the states at the prescribed displacements along (branch, delta); NaN after a path that broke off."""
    steep = _at_displacements(cycles.paths[0], cycles.problem)
    wide = _at_displacements(cycles.wider[0], cycles.problem) if cycles.wider and extrapolated else steep
    to_edge = extrapolation(cycles, 0)
    for name, branches in steep.items():
        for k, (values, wider) in enumerate(zip(branches, wide[name])):
            size = min(len(values), len(wider))
            values, wider = values[:size], wider[:size]
            if wide is not steep and name in _EXTRAPOLATED:
                same = steep["contact_patches"][k][:size] == wide["contact_patches"][k][:size]
                same &= (steep["contact_patches"][k][:size] > 0) | (name == "dissipated")
                values = np.where(same, to_edge.of(values, wider), values)
            values = np.maximum(values, 0.0) if name == "contact_area" else values
            if k == 0:
                record[name][0, :size] = values
            else:
                record[name][1, record[name].shape[1] - size :] = values[::-1]


def _at_displacements(followed: path.Path, problem: Problem) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return loading and retraction of each quantity at the prescribed displacements."""
    states = {name: followed.states[name] for name in _STATES} | yielding_of(followed, problem)
    prescribed, on_loading = followed.states["asked"], np.arange(len(followed.states)) < followed.turn
    return {
        name: (values[prescribed & on_loading], values[prescribed & ~on_loading]) for name, values in states.items()
    }


def _put_fields(record: np.ndarray, cycles: Cycles, problem: Problem) -> None:
    """Write the fields of the states at the prescribed displacements."""
    followed, surface = cycles.paths[0], cycles.surface
    if len(followed.pressures) != len(BRANCHES) * problem.steps.size:  # the path broke off: its fields stay NaN
        return
    deltas = np.tile(problem.steps + surface.zero, (len(BRANCHES), 1))
    shape = surface
    if problem.yielding:
        put_fields(record, surface, {"residual_height": followed.left})
        left = np.stack((followed.left, np.broadcast_to(followed.left[-1], followed.left.shape)))
        shape = surface._replace(separation=surface.separation - left)
    put_fields(record, surface, fields_of(_of_branches(followed.pressures), shape, deltas, problem))


def _of_branches(pressures: np.ndarray) -> np.ndarray:
    """Return (branch, delta, nx, ny) of states in the order of the path, in which retraction has falling delta."""
    loading, retraction = np.split(pressures, len(BRANCHES))
    return np.stack([loading, retraction[::-1]])


def _described(adhesion: Adhesion) -> dict[str, Any]:
    """Return the law and the mesh as attributes of a result."""
    mesh: dict[str, Any] = {"refine": adhesion.refine or "auto"}
    if not adhesion.refine and np.isfinite(adhesion.accuracy):
        mesh |= {"accuracy": adhesion.accuracy}
    if adhesion.refine != 1:
        mesh |= {"refinement_method": "band-limited"}
    length = {} if np.isnan(adhesion.length) else {"adhesion_length_nm": adhesion.length}
    length |= {"cut_off_nm": TAIL * adhesion.length} if adhesion.law == "lennard_jones" else {}
    missing = "NaN where nothing was touched, the preload was not reached or the cycle not completed"
    limit = {"tolerance": ON_THE_WAY if adhesion.preloads.size else TOLERANCE}
    return {"law": adhesion.law, **length, **mesh, **limit, "missing": missing}


def _warn(out: xr.Dataset, adhesion: Adhesion) -> None:
    """Warn of places that are less accurate than was asked for, and of a law that is cut."""
    if adhesion.law == "lennard_jones":
        warn(
            f"law='lennard_jones' is cut off at a gap of {TAIL * adhesion.length:.3g} nm: the pull-off of a smooth "
            "sphere is 0.9 % too small, that of stiff rough bodies up to 20 %, and pull_off_error does not include "
            "it; compare with `rigid`, which has no cut-off"
        )
    resolution, size = out["pull_off_resolution"].values, out["pull_off_resolution"].size
    if adhesion.refine and (resolution < LEAST_RADIUS).any():
        few = int((resolution < LEAST_RADIUS).sum())
        warn(
            f"{few} of {size} subregions have {SMALL_CONTACTS} {LEAST_RADIUS:g} "
            f"pixels at pull-off (smallest {np.nanmin(resolution):.2g}): compare with a finer mesh, or "
            "take mesh='auto'"
        )
    settling = np.nan_to_num(out["settling_error"].values)
    solving = np.sqrt(np.maximum(out["pull_off_error"].values ** 2 - settling**2, 0.0))
    missed = int((solving > adhesion.accuracy).sum())
    if missed and not adhesion.refine:
        warn(
            f"{missed} of {size} subregions did not reach accuracy={adhesion.accuracy:g} (largest error "
            f"{np.nanmax(solving):.2g}): their mesh is too coarse, see pull_off_error"
        )
    unknown = int((np.isnan(out["pull_off_error"].values) & (out["pull_off_force"].values > 0)).sum())
    if unknown and not adhesion.refine and np.isfinite(adhesion.accuracy):
        warn(
            f"{unknown} of {size} subregions have no error estimate (pull_off_error is NaN), since the second mesh or "
            "step gave no pull-off; compare with another mesh or a smaller step"
        )
    rough = out["residual"].notnull() & ~out["converged"].astype(bool)
    if rough.any():
        what = "cycles contain states that" if "preload_delta" in out else "states"
        warn(
            f"{int(rough.sum())} of {rough.size} {what} have not converged (converged is False); results that depend "
            "on them are NaN: compare with a smaller step or a finer mesh"
        )
    short = out["truncated"].values & out["complete"].values
    if short.any():
        warn(
            f"{int(short.sum())} of {short.size} subregions have contact or liquid at the edge of the scan or of the "
            "indenter's map (truncated is True): their forces leave out what lies beyond; take a larger scan, a "
            "smaller sphere or places farther inside"
        )
    lost = int((~out["complete"].values).sum())
    if lost:
        what = "did not reach their preload or " if adhesion.preloads.size else ""
        warn(f"{lost} subregions {what}needed more than {MOST_CELLS:g} cells; their results are NaN")
