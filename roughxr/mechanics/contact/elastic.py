"""The contact of an indenter with the scan without adhesion at every place, elastic or yielding on loading.

A task solves all displacements of one subregion, so that each solve starts from the last one.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..jobs import spread
from ..jobs.records import BRANCHES, Layout, warn_unconverged
from ..kernels.halfspace import displacement_control, load_control, yielding
from ..specimen import Specimen, need_wide_scan, specimen_of
from ..vocabulary import schema
from ..vocabulary.text import Argument, IncompleteResult, Phrase, warn
from ..vocabulary.units import Places, Quantities
from .problem import Place, Problem, Surface, check_depth, deepest, read_problem, surface_at
from .solving import put_fields, solve, state_fields

_STATES = {
    "force": float,
    "contact_area": float,
    "converged": bool,
    "iterations": int,
    "residual": float,
    "truncated": bool,
}
#: Further variables if a hardness is known, and if the body yields.
ABOVE_HARDNESS = {"yielded_fraction": float, "yielded_area_fraction": float}
YIELDED = {"yielded_area": float, "plastic_work": float}


#: Variables of each solve, in the order of the columns `displacement_control.FORCE` and so on.
_COLUMNS = "force", "contact_area", "status", "iterations", "residual", "hard_force", "yielded_area", "dent"


@schema.recorded
def direct(
    ds: xr.Dataset | Specimen,
    *,
    delta: Quantities | None = None,
    load: Quantities | None = None,
    subregions: Places = None,
    datum: str | None = None,
    fields: bool = False,
) -> xr.Dataset:
    """Solve the adhesionless contact of the assigned indenter with the scan, at each contact centre.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair.
    delta : array_like, optional
        Displacements, nm, ascending. By default 16 from first contact, up to Hertz's displacement under ten times the
        pull-off of a smooth sphere, or at a contact of three pixels in radius if this is larger; without adhesion from
        the highest peak, until every place is in contact.
    load : array_like, optional
        Forces, nN, positive and ascending, in place of ``delta``; the displacement is then a result.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres: a grid, x and y (nm), or a Dataset with them, see `regions.centres`. By default those on
        ``ds``, else one in its middle.
    datum : {"highest_peak", "first_contact"}, optional
        Where delta = 0: the indenter's lowest point level with the highest point of the whole scan (the
        paper's, by default for stated displacements), or this subregion's first touch.
    fields : bool
        Keep pressure, displacement and gap on the window around each centre, and the residual height if the body
        yields; NaN beyond the scan's edge.

    Returns
    -------
    Dataset
        ``force`` (nN), ``contact_area`` (nm²), ``converged``, ``iterations``, ``residual``, ``truncated`` along
        (subregion, delta) or (subregion, load); fields along (subregion, delta, x, y) with x, y from the contact
        centre. The area counts whole cells (2.4 % above Hertz's for a round contact of eight cells in radius). With
        a hardness, assigned or estimated, also ``yielded_fraction`` and ``yielded_area_fraction``, the shares of the
        force and of the area at that pressure or above. If the body yields, all these lie along (subregion, branch,
        delta), for loading and for retraction from the largest delta, with ``yielded_area`` (nm²), ``plastic_work``
        (nN nm) and the field ``residual_height`` (nm) after loading to delta and unloading. Lazy if the scan is a dask
        array.

    Raises
    ------
    ValueError
        If no contact modulus is assigned, both delta and load are stated, or a load is not positive.

    Warns
    -----
    UserWarning
        If solves have not converged, nothing touches at most places, or displacements exceed a tenth of the sphere's
        radius and the range of heights (for input in memory only).

    Notes
    -----
    The pressure on a body that yields is at most its hardness. Where it reaches the hardness, the surface is displaced
    permanently to avoid penetration. The model has no strain hardening, no pile-up and no plastic flow below the
    surface before that. Retraction is elastic on the shape left by loading to the largest displacement.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 36–42; Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990); Almqvist,
    Sahlin, Larsson & Glavatskih, Tribology International 40 (2007) 574.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> scan = roughxr.assign_pair(scan, sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, hardness="6 GPa")
    >>> pressed = scan.contact.direct(delta=[5.08, 15.4], subregions=(2, 2))
    >>> dict(pressed.force.sizes), bool((pressed.plastic_work.sel(delta=15.4) > 0).all())
    ({'subregion': 4, 'branch': 2, 'delta': 2}, True)
    """
    specimen = specimen_of(ds)
    need_wide_scan(specimen.heights, specimen.sides, specimen.pair.sphere_radius)
    positions = specimen.centres(subregions)
    problem = read_problem(specimen, positions, delta=delta, load=load, datum=datum)
    check_depth(specimen, problem)
    axes = {"load" if problem.by_load else "delta": problem.steps}
    out = solve(
        _sweep,
        specimen,
        problem,
        _layout(axes, problem),
        name="direct",
        positions=positions,
        reach=problem.indenter.half_width(deepest(specimen, problem)),
        fields=fields,
    )
    datum = "first_contact" if problem.first_contact else "highest_peak"
    out.attrs = {"datum": datum, "method": "direct", "tolerance": displacement_control.TOLERANCE}
    out = spread.finish(out)
    if not specimen.lazy:
        warn_unconverged(out, "see converged, and residual for their error")
        _warn_if_untouched(out)
    return out


def _warn_if_untouched(out: xr.Dataset) -> None:
    """Warn if most places have no contact at any displacement: their zero forces are easily misread."""
    if "delta" not in out.dims:
        return
    area = out["contact_area"]
    count = out.sizes["subregion"]
    never = int((area.max([name for name in area.dims if name != "subregion"]) <= 0).sum())
    if 2 * never > count:
        warn(
            Phrase(
                f"nothing touches at {never} of {count} places, down to {float(out['delta'][-1]):g} nm below the "
                "highest point of the scan: their forces are 0; leave ",
                Argument("delta", ...),
                " out, so that every place is touched, or take ",
                Argument("datum", "first_contact"),
                ", which counts delta from the first touch at each place",
            ),
            IncompleteResult,
            what="delta",
        )


def _layout(axes: dict[str, Any], problem: Problem) -> Layout:
    """Return the variables of a place: with those of yielding for a known hardness, on both branches if it yields."""
    states = _STATES | ({"delta": float} if problem.by_load else {})
    states |= ABOVE_HARDNESS if np.isfinite(problem.hardness) else {}
    if not problem.yielding:
        return Layout(axes, states)
    return Layout({"branch": list(BRANCHES), **axes}, states | YIELDED, yields=True)


class _Solved(NamedTuple):
    """The solutions of one place, with a leading branch axis if the body yields."""

    deltas: np.ndarray  # (…, step), nm below the datum
    columns: np.ndarray  # (…, step, displacement_control.FORCE … DENT)
    pressure: np.ndarray  # (…, stored, nx, ny), GPa
    residual_height: np.ndarray  # (…, stored, nx, ny), nm ≤ 0


def _sweep(place: Place, problem: Problem, layout: Layout) -> np.ndarray:
    """Solve one place at every step, on both branches if it yields."""
    surface = surface_at(place, problem)
    record = layout.blank()
    keep = problem.steps.size if layout.window is not None else 0
    solved = (_cycle if problem.yielding else _elastic)(surface, problem, keep)
    _put_states(record, solved, surface, problem)
    if layout.window is not None:
        shape = surface._replace(separation=surface.separation - solved.residual_height)
        put_fields(record, surface, state_fields(solved.pressure, shape, solved.deltas, problem))
    if "residual_height" in layout.fields:
        put_fields(record, surface, {"residual_height": solved.residual_height[0]})
    return record


def _put_states(record: np.ndarray, solved: _Solved, surface: Surface, problem: Problem) -> None:
    """Write the variables of each solve."""
    values = dict(zip(_COLUMNS, np.moveaxis(solved.columns, -1, 0)))
    with np.errstate(invalid="ignore"):
        values["yielded_fraction"] = values.pop("hard_force") / values["force"]
        values["yielded_area_fraction"] = values["yielded_area"] / values["contact_area"]
    values["plastic_work"] = problem.hardness * values.pop("dent") if problem.yielding else 0.0
    values["converged"] = values.pop("status") == displacement_control.CONVERGED
    values |= {"truncated": surface.unknown_from < solved.deltas, "delta": solved.deltas - surface.zero}
    for name in set(values) & set(record.dtype.fields or ()):
        record[name] = values[name]
    if problem.yielding:  # yielded cells stay yielded at a lower pressure on retraction
        for name in YIELDED:
            record[name][1] = record[name][0, -1]


def _elastic(surface: Surface, problem: Problem, keep: int) -> _Solved:
    deltas, columns, pressure, _ = _solutions(surface.separation, surface, problem, keep)
    return _Solved(deltas, columns, pressure, np.zeros_like(pressure))


def _cycle(surface: Surface, problem: Problem, keep: int) -> _Solved:
    """Load a place that yields, and retract from the deformed shape; both branches share their last state."""
    separation = surface.separation
    deltas, columns, pressure, displacement = _solutions(separation, surface, problem, max(keep, 1))
    residual_heights = yielding.residual_heights(
        pressure, displacement, separation, deltas[-len(pressure) :], problem.hardness
    )
    elastic = problem._replace(steps=problem.steps[:-1], hardness=np.inf, yielding=False)
    last = slice(-1, None)
    unloaded = _solutions(separation - residual_heights[-1], surface, elastic, max(keep - 1, 0))
    joined = [
        np.concatenate((branch, loaded[last])) for branch, loaded in zip(unloaded, (deltas, columns, pressure[-keep:]))
    ]
    deltas, columns, pressure = (np.stack(pair) for pair in zip((deltas, columns, pressure[-keep:]), joined))
    return _Solved(
        deltas,
        columns,
        pressure,
        np.stack((residual_heights, np.broadcast_to(residual_heights[-1], residual_heights.shape))),
    )


def _solutions(separation: np.ndarray, surface: Surface, problem: Problem, keep: int):
    """Return displacements below the datum, the columns of each solve, and the fields of the last ``keep``."""
    hardness = displacement_control.Hardness(problem.hardness, problem.yielding)
    half_space = problem.dx, problem.contact_modulus, problem.film
    if problem.by_load:
        return load_control.loaded_arrays(separation, problem.steps, *half_space, hardness=hardness, keep=keep)
    deltas = problem.steps + surface.zero
    return deltas, *displacement_control.sweep_arrays(separation, deltas, *half_space, hardness=hardness, keep=keep)
