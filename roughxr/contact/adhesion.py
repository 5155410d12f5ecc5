"""Direct simulation with adhesion: approach and retraction of the indenter, wherever it lands.

Every subregion is one task with its whole cycle inside: what holds on retraction depends on all that went before.
"""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import regions, schema
from ..jobs import lazy as parallel
from ..kernels.adhesion import cohesive_laws, path
from ..kernels.halfspace.products import coefficients_for
from ..units import fraction, positive, whole_number
from .problem import Problem, Surface, deepest, need_heights, read_problem
from .records import Layout, fields_of, put_fields, solve

#: Laws of adhesion.
COHESIVE_LAWS = ("griffith", *cohesive_laws.COHESIVE)

BRANCHES = ("loading", "retraction")

_STATES = {
    "force": float,
    "contact_area": float,
    "energy": float,
    "dissipated": float,
    "contact_patches": float,
    "resolution": float,
    "iterations": int,
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
    "truncated": bool,
    "complete": bool,
}

#: Contacts of fewer pixels in radius than this at pull-off bring a warning. JKR's sphere is off by up to 0.5 % at
#: twenty pixels, 1.5 % at ten, 3 % at five, and by 3 to 40 % at one (``tests/benchmarks/adhesive_accuracy.py``).
_RESOLVED = 2.0


class _Options(NamedTuple):
    """What a cycle needs beside the problem."""

    step: float  # nm
    work_of_adhesion: float  # J/m²
    law: str
    strength: float  # GPa, of a law of finite range
    tolerance: float
    max_iterations: int
    max_cells: int


def adhesive(
    ds: xr.Dataset,
    *,
    delta: Any,
    subregions: Any = None,
    law: str = "griffith",
    strength: Any = None,
    refine: int = 1,
    step: Any = 0.25,
    datum: str = "highest_peak",
    profile: str = "sphere",
    fields: bool = False,
    tolerance: float = 1e-7,
    max_iterations: int = 1000,
    max_cells: int = 8000,
    progress: bool = False,
) -> xr.Dataset:
    """Follow the adhesive contact of the assigned indenter with the scan through approach and retraction.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair with a work of adhesion.
    delta : array_like
        Displacements, nm, ascending: reached one after the other on loading, and in reverse on retraction,
        which goes on beyond the smallest until all contact is lost.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    law : {"griffith", "dugdale", "exponential"}
        Adhesion without range (the limit of JKR), or of finite range with the same work of adhesion.
    strength : number or quantity, optional
        Largest traction, GPa, of a law of finite range.
    refine : int
        Solve on pixels so many times smaller, heights interpolated by bicubic splines.
    step : number or quantity
        Longest step of the displacement, nm. On retraction shorter ones are taken where a branch ends, and where a
        larger pull may lie between two states: halving the step leaves the pull-off of nearly every place as it is.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0, as in `direct`.
    profile : {"sphere", "parabola"}
        The exact sphere or Hertz's paraboloid.
    fields : bool
        Keep pressure, displacement and gap on the window around each centre, on the cells of the solve, on both
        branches; NaN beyond the scan's edge.
    tolerance : float
        Residual traction over the largest.
    max_iterations, max_cells : int
        Rounds per step; pixels in or near contact (memory: 8 bytes times their square).
    progress : bool
        Show a bar while computing.

    Returns
    -------
    Dataset
        Along (subregion, branch, delta): ``force``, ``contact_area``, ``contact_patches`` (connected patches of cells),
        ``energy``, ``dissipated``, ``resolution`` (radius, in pixels of the solve, of the smallest contact that bears a
        tenth of the tension), ``iterations``, ``converged``. Along subregion, from all steps of the cycle:
        ``snap_in_force``, ``snap_in_delta``, ``pull_off_force``, ``pull_off_delta``, ``detachment_delta``,
        ``work_of_separation``, ``hysteresis``, ``pull_off_resolution``, ``truncated`` (contact at the edge of the scan
        or of the indenter's map) and ``complete``. A subregion that is never touched, or whose cycle could not be
        completed, has NaN events. Fields along
        (subregion, branch, delta, x, y) with x, y from the contact centre.

    Raises
    ------
    ValueError
        If no pair or work of adhesion is assigned, a law of finite range has no strength, its process zone spans
        fewer than two pixels, or an option is not as described.

    Warns
    -----
    UserWarning
        If contacts at pull-off are poorly resolved (input in memory only).

    Notes
    -----
    In the Griffith limit a front's cells let go over a zone a few cells wide, whose line tension is taken back from the
    work of adhesion by the outline of each contact (`kernels.adhesion`). ``energy`` counts that
    outline as an ellipse: on a smooth sphere ``dissipated`` closes the loop, ``hysteresis``, to 1 %; where rough
    contacts split and merge it closes less well, and may fall a little on the way: there ``hysteresis``, the work of
    the force, is the figure to take.

    References
    ----------
    Griffith (1921); Johnson, Kendall & Roberts (1971); Pohrt & Popov (2015); Maugis (1992).

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> cycle = adhesive(scan, delta=[5, 10, 15], subregions=([312.5], [937.5]), step=0.5)
    >>> dict(cycle.force.sizes), bool(cycle.pull_off_force[0] > 0)
    ({'subregion': 1, 'branch': 2, 'delta': 3}, True)
    """
    ds = schema.validate(ds, "scan")
    refine = whole_number(refine, "refine", least=1, most=16)
    positions = regions.centres(ds, subregions)
    problem = read_problem(ds, positions, delta=delta, datum=datum, profile=profile, refine=refine)
    options = _options(ds, law, strength, step, tolerance, max_iterations, max_cells)
    _need_resolved_zone(options, problem)
    if fields:
        need_heights(ds, problem)
    out = solve(
        _cycle,
        ds,
        problem,
        Layout({"branch": list(BRANCHES), "delta": problem.steps}, _STATES, _EVENTS),
        options,
        positions=positions,
        reach=_reach(ds, problem, options),
        fields=fields,
        progress=progress,
    )
    spline = "bicubic spline" if refine > 1 else "none"
    out.attrs = {"datum": datum, "method": "adhesive", "law": law, "refine": refine, "refinement": spline}
    arguments = {"delta": problem.steps, "subregions": subregions, "law": law, "strength": strength, "refine": refine}
    arguments |= {"step": options.step, "datum": datum, "profile": profile, "fields": fields, "tolerance": tolerance}
    out = schema.record(out, "adhesive", ds, **arguments, max_iterations=max_iterations, max_cells=max_cells)
    lazy = parallel.is_lazy(ds)
    out = parallel.finish(out, lazy=lazy, progress=progress)
    if not lazy:
        _warn(out)
    return out


def _options(ds, law, strength, step, tolerance, max_iterations, max_cells) -> _Options:
    schema.one_of(law, COHESIVE_LAWS, "law")
    if (law == "griffith") != (strength is None):
        found = "none" if strength is None else repr(strength)
        raise ValueError(f"strength: expected for a law of finite range and for no other, found {found} for {law!r}")
    return _Options(
        step=positive(step, "nm", "step"),
        work_of_adhesion=schema.pair(ds, "work_of_adhesion")[0],
        law=law,
        strength=np.nan if strength is None else positive(strength, "GPa", "strength"),
        tolerance=fraction(tolerance, "tolerance"),
        max_iterations=whole_number(max_iterations, "max_iterations", least=1),
        max_cells=whole_number(max_cells, "max_cells", least=1),
    )


def _need_resolved_zone(options: _Options, problem: Problem) -> None:
    """Refuse a law whose process zone the pixels cannot show."""
    if options.law == "griffith" or options.work_of_adhesion == 0:
        return
    least = cohesive_laws.LEAST_ZONE
    zone = cohesive_laws.process_zone(problem.contact_modulus, options.work_of_adhesion, options.strength)
    if zone < least * problem.dx:
        needed = int(np.ceil(least * problem.pixel / zone))
        raise ValueError(
            f"strength: expected a process zone of at least {least:g} pixels, found {zone:.3g} nm "
            f"(π E* w/(4 σ₀²)) on pixels of {problem.dx:.3g} nm; take refine={needed}, or law='griffith'"
        )


def _reach(ds: xr.Dataset, problem: Problem, options: _Options) -> float:
    """Return the half-width (nm) of the windows: the overlap, and as far as adhesion draws the surface up."""
    if problem.indenter.map:
        return problem.indenter.reach(np.inf)
    depth = deepest(ds, problem)
    if np.isinf(depth):
        return np.inf
    attraction = 0.0 if options.law == "griffith" else _law(options, problem).range
    reach = problem.indenter.reach(depth)
    for _ in range(20):  # JKR's contact of that radius draws the surface up by √(2πaw/E*)
        uplift = np.sqrt(2 * np.pi * reach * options.work_of_adhesion / problem.contact_modulus)
        reach = problem.indenter.reach(depth + uplift + attraction)
    return reach + problem.pixel


def _law(options: _Options, problem: Problem) -> cohesive_laws.Law:
    """Return the law on unit cells of unit modulus."""
    per_unit = problem.dx / problem.contact_modulus
    w = options.work_of_adhesion * per_unit
    if options.law == "griffith" or w == 0:
        return cohesive_laws.griffith(w)
    return cohesive_laws.cohesive(options.law, w, options.strength * per_unit)


def _cycle(surface: Surface, problem: Problem, layout: Layout, options: _Options) -> np.ndarray:
    """Follow one surface's cycle."""
    followed = path.follow(
        surface.separation,
        problem.steps + surface.zero,
        options.step,
        coefficients_for([n + 2 for n in surface.separation.shape]),  # the path pads the window
        _law(options, problem),
        options.work_of_adhesion * problem.dx / problem.contact_modulus,
        tolerance=options.tolerance,
        max_iterations=options.max_iterations,
        max_cells=options.max_cells,
        fields=layout.window is not None,
    )
    followed = _in_units(followed, surface, problem)
    record = layout.blank()
    _put_states(record, followed)
    for name, value in _events(followed).items():
        record[name] = value
    record["truncated"] = surface.unknown_from < problem.steps[-1] + surface.zero
    record["complete"] = followed.status == path.CONVERGED
    if layout.window is not None:
        pressure = _of_branches(followed.pressures)
        deltas = np.tile(problem.steps + surface.zero, (len(BRANCHES), 1))
        put_fields(record, surface, fields_of(pressure, surface, deltas, problem))
    return record


def _in_units(followed: path.Path, surface: Surface, problem: Problem) -> path.Path:
    """Return a path in nm, nN and GPa, its displacements counted from the datum of the result."""
    states, stiffness = followed.states.copy(), problem.contact_modulus * problem.dx
    states[:, [path.FORCE, path.ENERGY, path.DISSIPATED]] *= stiffness
    states[:, path.AREA] *= problem.dx * problem.dx
    states[:, path.DELTA] -= surface.zero
    return followed._replace(states=states, pressures=followed.pressures * problem.contact_modulus / problem.dx)


#: The path's columns of what is kept along (branch, delta).
_COLUMNS = {
    "force": path.FORCE,
    "contact_area": path.AREA,
    "energy": path.ENERGY,
    "dissipated": path.DISSIPATED,
    "contact_patches": path.CONTACTS,
    "resolution": path.RESOLUTION,
    "iterations": path.ITERATIONS,
    "converged": path.OK,
}


def _put_states(record: np.ndarray, followed: path.Path) -> None:
    """Write the states that were asked for along (branch, delta); a path that broke off leaves the others missing."""
    loading, retraction = followed.states[: followed.turn], followed.states[followed.turn :]
    loading, retraction = (part[part[:, path.ASKED] > 0] for part in (loading, retraction))
    for name, column in _COLUMNS.items():
        record[name][0, : len(loading)] = loading[:, column]
        record[name][1, record[name].shape[1] - len(retraction) :] = retraction[::-1, column]


def _of_branches(pressures: np.ndarray) -> np.ndarray:
    """Return (branch, delta, nx, ny) of the states in the order of the path: retraction comes with falling delta."""
    loading, retraction = np.split(pressures, len(BRANCHES))
    return np.stack([loading, retraction[::-1]])


def _events(followed: path.Path) -> dict[str, float]:
    """Return snap-in, pull-off, work of separation and so on; none of a path that broke off or never touched."""
    states, back = followed.states, followed.states[followed.turn :]
    touching = states[:, path.AREA] > 0
    if followed.status != path.CONVERGED or not touching.any():
        return {}
    first, lowest = states[np.argmax(touching)], back[np.argmin(back[:, path.FORCE])]
    delta, force = states[:, path.DELTA], states[:, path.FORCE]
    return {
        "snap_in_force": max(-first[path.FORCE], 0.0),
        "snap_in_delta": first[path.DELTA],
        "pull_off_force": max(-lowest[path.FORCE], 0.0),
        "pull_off_delta": lowest[path.DELTA],
        "detachment_delta": delta[touching].min() if touching[followed.turn :].any() else np.nan,
        "work_of_separation": _work(np.minimum(back[:, path.FORCE], 0.0), back[:, path.DELTA]),
        "hysteresis": _work(force, delta),
        "pull_off_resolution": lowest[path.RESOLUTION],
    }


def _work(force: np.ndarray, delta: np.ndarray) -> float:
    """Return the work of a force along a path, nN nm."""
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(delta)))


def _warn(out: xr.Dataset) -> None:
    resolution = out["pull_off_resolution"].values
    poor = resolution < _RESOLVED
    if poor.any():
        warnings.warn(
            f"{int(poor.sum())} of {resolution.size} subregions have contacts of less than {_RESOLVED:g} pixels in "
            f"radius at pull-off (smallest {np.nanmin(resolution):.2g}): compare with a larger refine",
            stacklevel=3,
        )
    lost = int((~out["complete"].values).sum())
    if lost:
        warnings.warn(f"{lost} subregions needed more than max_cells pixels; their events are NaN", stacklevel=3)
