"""Direct simulation without adhesion: the elastic contact of the indenter with the scan itself, wherever it lands.

Every subregion is one task with its whole sweep inside, so that each displacement starts from the one before.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import regions, schema
from ..jobs import lazy as parallel
from ..kernels.halfspace import displacement_control, load_control
from ..units import fraction, whole_number
from .problem import Place, Problem, Surface, deepest, need_heights, read_problem, surface_at
from .records import Layout, fields_of, put_fields, solve

_STATES = {
    "force": float,
    "contact_area": float,
    "converged": bool,
    "iterations": int,
    "residual": float,
    "truncated": bool,
}


class _Limits(NamedTuple):
    """When a solve ends."""

    tolerance: float
    max_iterations: int


def direct(
    ds: xr.Dataset,
    *,
    delta: Any = None,
    load: Any = None,
    subregions: Any = None,
    datum: str = "highest_peak",
    profile: str = "sphere",
    fields: bool = False,
    tolerance: float = 1e-6,
    max_iterations: int = 5000,
    progress: bool = False,
) -> xr.Dataset:
    """Solve the adhesionless contact of the assigned indenter with the scan, at each contact centre.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair.
    delta : array_like, optional
        Displacements, nm, ascending; by default 16 up to where every place is touched, and one of median
        height pressed as deep as it lies below the highest peak.
    load : array_like, optional
        Forces, nN, positive and ascending, in place of ``delta``; the displacement is then found.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0: the indenter's lowest point level with the highest point of the whole scan (the
        paper's), or this subregion's first touch.
    profile : {"sphere", "parabola"}
        The exact sphere or Hertz's paraboloid.
    fields : bool
        Keep pressure, displacement and gap on the window around each centre; NaN beyond the scan's edge.
    tolerance : float
        Relative error of the force.
    max_iterations : int
        Products with the half space's coefficients at most; a solve that needs more says converged = False.
    progress : bool
        Show a bar while computing (input in memory only; a lazy result is computed by `compute`).

    Returns
    -------
    Dataset
        ``force`` (nN), ``contact_area`` (nm²), ``converged``, ``iterations``, ``residual``, ``truncated`` along
        (subregion, delta) or (subregion, load), the area that of whole cells (for a round contact of eight cells in
        radius 2.4 % above Hertz's, less the more there are), fields along (subregion, delta, x, y) with x, y from the
        contact centre. Lazy where the scan is a dask array.

    Raises
    ------
    ValueError
        If no pair is assigned, pixels are not square or missing, displacements or loads are empty, not finite
        or not ascending, or a name is unknown.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 36–42; Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990).

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> scan = roughxr.assign_pair(scan, sphere_radius=3000, young_modulus=75, poisson_ratio=0.22)
    >>> elastic = direct(scan, delta=[5.08, 15.4], subregions=(2, 2))
    >>> dict(elastic.force.sizes), elastic.force.units
    ({'subregion': 4, 'delta': 2}, 'nN')
    """
    ds = schema.validate(ds, "scan")
    positions = regions.centres(ds, subregions)
    problem = read_problem(ds, positions, delta=delta, load=load, datum=datum, profile=profile)
    limits = _Limits(fraction(tolerance, "tolerance"), whole_number(max_iterations, "max_iterations", least=1))
    if fields:
        need_heights(ds, problem)
    axes = {"load" if problem.by_load else "delta": problem.steps}
    layout = Layout(axes, _STATES | ({"delta": float} if problem.by_load else {}))
    out = solve(
        _sweep,
        ds,
        problem,
        layout,
        limits,
        name="direct",
        positions=positions,
        reach=problem.indenter.reach(deepest(ds, problem)),
        fields=fields,
        cost=_overlapping,
        progress=progress,
    )
    out.attrs = {"datum": datum, "method": "direct"}
    arguments = {"subregions": subregions, "datum": datum, "profile": profile, "fields": fields}
    steps = {"delta": None, "load": None, **axes}
    out = schema.record(out, "direct", ds, **steps, **arguments, **limits._asdict())
    return parallel.finish(out, lazy=parallel.is_lazy(ds), progress=progress)


def _overlapping(surface: Surface, problem: Problem) -> int:
    """Return how many cells overlap at the largest displacement, all where that is not known."""
    known = not problem.by_load and not problem.first_contact
    return np.count_nonzero(surface.separation < (problem.steps[-1] if known else np.inf))


def _sweep(place: Place, problem: Problem, layout: Layout, limits: _Limits) -> np.ndarray:
    """Solve one place at every step."""
    surface = surface_at(place, problem)
    deltas, found, pressure = _solutions(surface, problem, limits, keep=layout.window is not None)
    record = layout.blank()
    record["force"], record["contact_area"] = found[:, displacement_control.FORCE], found[:, displacement_control.AREA]
    record["converged"] = found[:, displacement_control.STATUS] == displacement_control.CONVERGED
    record["iterations"] = found[:, displacement_control.ITERATIONS]
    record["residual"] = found[:, displacement_control.RESIDUAL]
    record["truncated"] = surface.unknown_from < deltas
    if problem.by_load:
        record["delta"] = deltas - surface.zero
    if layout.window is not None:
        put_fields(record, surface, fields_of(pressure, surface, deltas, problem))
    return record


def _solutions(surface: Surface, problem: Problem, limits: _Limits, *, keep: bool):
    """Return displacements below the datum, what is said of each solve, and pressures where they are kept."""
    half_space = problem.dx, problem.contact_modulus
    if problem.by_load:
        return load_control.loaded_arrays(
            surface.separation, problem.steps, *half_space, keep=keep, **limits._asdict()
        )[:3]
    deltas = problem.steps + surface.zero
    found = displacement_control.sweep_arrays(surface.separation, deltas, *half_space, keep=keep, **limits._asdict())
    return deltas, *found[:2]
