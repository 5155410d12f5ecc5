"""The adhesive contact of an indenter with the scan, followed through approach and retraction at every place.

A task is the whole cycle of one place, because each state on retraction depends on all states before it:

adhesive_options   reads options and pair into an `Adhesion`: law, preloads, mesh, step
refinement         solves one place on a mesh that is accurate enough, with the errors of the pull-off
cycle              follows one place on one mesh, with its events
adhesion_on_cells  the law on the cells of a mesh, and the cells that resolve it
levers             the moments that resist rolling, and the errors of their levers, at one place
adhesive_record    writes states, events and fields into one record
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..asperity.moments import read_directions, split_moments
from ..jobs import spread
from ..kernels.adhesion.states import INTERMEDIATE_TOLERANCE, TOLERANCE
from ..kernels.adhesion.traction_laws import TAIL
from ..specimen import Specimen, need_wide_scan, specimen_of
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import ADHESION_LAWS, AUTO, JKR
from ..vocabulary.numbers import format_number
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import Argument, IncompleteResult, Phrase, RoughxrWarning, warn
from ..vocabulary.units import Places, Quantities, Quantity
from .adhesion_on_cells import NO_DIRECTIONS, Adhesion, resolving_cell
from .adhesive_options import (
    changes_the_law,
    need_few_cells,
    need_resolved_law,
    preload_problem,
    read_adhesion,
    read_preloads,
    settling_depth,
    window_half_width,
)
from .adhesive_record import cycle_layout, cycle_record
from .cycle import LEAST_RADIUS, MOST_CELLS
from .edge_front import seconds_on_cells, with_front
from .mesh import FRONT, Mesh, UnresolvedContact, read_mesh
from .pressing import is_range, settling_changes
from .problem import Problem, check_depth, read_problem
from .solving import solve

#: Processor time (s) of a place on cells, of which a warning tells before it is spent.
_LONG = 30.0

#: Why a variable is missing at places that were solved.
_MISSING = dict.fromkeys(
    ("pull_off_error", "mesh_error", "step_error", "interpolation_error"),
    "NaN without a second mesh that gives a pull-off: one mesh states no error",
)
_MISSING["pressed_pull_off_force"] = "NaN with displacements, and where a place was not solved"


def adhesive(
    ds: xr.Dataset | Specimen,
    *,
    preload: Quantities | None = None,
    delta: Quantities | None = None,
    subregions: Places = None,
    law: str = AUTO,
    mesh: Mesh | int | str = "auto",
    datum: str | None = None,
    cycles: int = 1,
    fields: bool = False,
) -> xr.Dataset:
    """Solve the contact with adhesion through approach and retraction, with its pull-off force and error.

    Parameters
    ----------
    ds : Dataset
        A scan with an assigned pair.
    preload : number, quantity or array of them, optional
        Force (nN) at which the indenter turns back, by default 0. Several lie along ``preload``.
    delta : array_like, optional
        Displacements (nm), ascending, in place of a preload.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    law : {"auto", "exponential", "jkr", "dugdale", "lennard_jones"}
        Traction across a gap. "auto" chooses by Tabor's parameter.
    mesh : "auto", "front", int or Mesh
        Cells along a side of a pixel. "auto" halves them until the pull-off changes by less than 5 %; soft spheres that
        need many take "front", the contact's edge.
    datum : {"highest_peak", "first_contact"}, optional
        Where delta = 0; by default first contact with a preload, else the highest peak.
    cycles : int
        Cycles with a preload.
    fields : bool
        Keep pressure, displacement and gap at ``delta``; needs one mesh.

    Returns
    -------
    Dataset
        Along subregion: ``pull_off_force`` (nN), its relative error ``pull_off_error`` (95 %), ``pull_off_delta``,
        ``snap_in_force``, ``hysteresis`` and more. With ``delta``, ``force`` and ``contact_area`` on both branches.

    Raises
    ------
    ValueError
        Without a work of adhesion, or with cells too large for the law or too many.

    Warns
    -----
    UserWarning
        If a place missed the accuracy, or contact reaches the scan's edge.
    UnresolvedContact
        If one mesh does not resolve the contacts.

    Notes
    -----
    The page of physics states laws, solution, errors and all variables.

    References
    ----------
    Johnson, Kendall & Roberts, doi:10.1098/rspa.1971.0141; Maugis, doi:10.1016/0021-9797(92)90285-T.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=500, materials="glass")
    >>> settled = scan.contact.adhesive(subregions=(2, 2), law="jkr", mesh=16)
    >>> dict(settled.pull_off_force.sizes), bool((settled.pull_off_force > 0).all())
    ({'subregion': 4}, True)
    """
    if preload is not None and delta is not None:
        raise Refusal("", "either preload or delta", "both")
    how: dict[str, Any] = {"law": law, "mesh": mesh, "datum": datum, "cycles": cycles, "fields": fields}
    return _solution(specimen_of(ds), preload, delta, subregions, **how)


def adhesive_and_moments(
    ds: xr.Dataset | Specimen, *, directions: Quantities, preload: Quantity = 0.0, **options: Any
) -> tuple[xr.Dataset, xr.Dataset]:
    """Return `adhesive` by one preload, and the moments of its contacts by direction in the form of `rolling`.

    ``options`` are places, law and mesh. Levers then have errors, which `rolling` of fields cannot state.
    """
    if np.ndim(preload):  # type: ignore[arg-type]
        raise Refusal("preload", "one number", "several of them")
    return split_moments(_solution(specimen_of(ds), preload, directions=read_directions(directions), **options))


@schema.recorded_as("adhesive")
def _solution(
    specimen: Specimen,
    preload: Quantities | None,
    delta: Quantities | None = None,
    subregions: Places = None,
    *,
    law: str = AUTO,
    mesh: Mesh | int | str = "auto",
    datum: str | None = None,
    cycles: int = 1,
    fields: bool = False,
    directions: np.ndarray = NO_DIRECTIONS,
) -> xr.Dataset:
    """Return the states by displacement, or the events by preload, with the moments in directions (rad)."""
    need_wide_scan(specimen.heights, specimen.sides, specimen.pair.sphere_radius)
    by_preload = delta is None
    mesh = read_mesh(mesh, Mesh())
    datum = datum or ("first_contact" if by_preload else "highest_peak")
    positions = specimen.centres(subregions)
    adhesion = read_adhesion(
        specimen,
        law,
        preloads=read_preloads(preload) if by_preload else np.zeros(0),
        mesh=mesh,
        cycles=cycles,
    )
    adhesion = adhesion._replace(presses=by_preload, directions=directions)
    delta = [settling_depth(specimen, adhesion)] if by_preload else delta
    problem = read_problem(specimen, positions, delta=delta, datum=datum, refine=max(adhesion.refine, 1))
    if not by_preload:
        check_depth(specimen, problem)
    adhesion = with_front(problem, adhesion, fields=fields)
    need_resolved_law(adhesion, problem)
    reach = window_half_width(specimen, problem, adhesion)
    need_few_cells(specimen, problem, adhesion, positions, reach)
    if fields:
        _need_one_mesh(adhesion)
    _warn_of_time(adhesion, problem)
    out = solve(
        cycle_record,
        specimen,
        problem,
        cycle_layout(problem, adhesion, preload),
        adhesion._replace(tabor=np.nan),  # stored results do not depend on how the law was chosen
        name="adhesive",
        positions=positions,
        reach=reach,
        fields=fields,
    )
    out.attrs = {"datum": datum, "method": "adhesive", **_described(adhesion)}
    if by_preload and "preload" not in out.dims:
        out.attrs["preload"] = float(adhesion.preloads[0])
    out = spread.finish(out)
    if not specimen.lazy:
        _warn(out.drop_vars(out.coords), adhesion, problem)  # each operation would compare coordinates
    for name, reason in _MISSING.items():
        out[name].attrs["missing"] = reason
    return schema.label(out.assign_coords(shortest_wavelength=specimen.shortest_wavelength))


def _need_one_mesh(adhesion: Adhesion) -> None:
    """Raise where fields are requested without displacements, or on meshes that differ between places."""
    if adhesion.preloads.size or not adhesion.refine:
        expected = Phrase("displacements (delta) and one mesh for all places, such as ", Argument("mesh", 4))
        raise Refusal("fields", expected)


def _described(adhesion: Adhesion) -> dict[str, Any]:
    """Return the law and the mesh as attributes of a result."""
    settings: dict[str, Any] = {"mesh": FRONT if adhesion.by_front else adhesion.refine or "auto"}
    if not adhesion.refine and np.isfinite(adhesion.accuracy):
        settings |= {"accuracy": adhesion.accuracy}
    if adhesion.refine != 1:
        settings |= {"interpolation": "band-limited"}
    length = {} if np.isnan(adhesion.length) else {"adhesion_length_nm": adhesion.length}
    length |= {"cut_off_nm": TAIL * adhesion.length} if ADHESION_LAWS[adhesion.law].has_hamaker_tail else {}
    missing = "NaN where nothing was touched, the preload was not reached or the cycle not completed"
    limit = {"tolerance": INTERMEDIATE_TOLERANCE if adhesion.preloads.size else TOLERANCE}
    tabor = {"switching_tabor": adhesion.tabor} if changes_the_law(adhesion.tabor) else {}
    return {"law": adhesion.law, **length, **settings, **limit, "missing": missing, **tabor}


def warn_of_time(specimen: Specimen, *, preload: Quantities, law: str) -> None:
    """Warn of a refined mesh of cells that takes minutes a place, before a run solves it."""
    problem, adhesion = preload_problem(specimen, preload=preload, law=law, mesh=Mesh())
    _warn_of_time(with_front(problem, adhesion, fields=False), problem)


def _warn_of_time(adhesion: Adhesion, problem: Problem) -> None:
    """Warn of meshes that take minutes a place, before they are solved."""
    is_refined = not adhesion.refine and not adhesion.by_front and np.isfinite(adhesion.accuracy)
    if not is_refined or not adhesion.preloads.size or problem.indenter.map is not None:
        return
    if ADHESION_LAWS[adhesion.law].has_range:  # bodies so stiff touch single summits, in a tenth of this time
        return
    seconds = seconds_on_cells(problem, adhesion)
    if seconds > _LONG:
        warn(
            Phrase(
                "these bodies are soft and their contacts large: a place takes about "
                f"{format_number(float(f'{seconds:.1g}'), 's')} of processor time; one mesh, as ",
                Argument("mesh", 2),
                ", takes less and has no error",
            )
        )


def _warn_of_errors(out: xr.Dataset, adhesion: Adhesion) -> None:
    """Warn of places whose pull-off depends on the mesh, or on the heights between the pixels, or has no error."""
    mesh, step, between = (out[f"{name}_error"] for name in ("mesh", "step", "interpolation"))
    change = xr.apply_ufunc(np.fmax, mesh, step).where(out["mesh"] > 0)  # the front states its error, on no mesh
    accuracy = f"accuracy={adhesion.accuracy:g}"
    _warn_of_places(
        change > adhesion.accuracy,
        f"did not reach {accuracy} (largest change by cells or steps {float(change.max()):.2g}): their mesh is too "
        "coarse, see pull_off_error",
    )
    _warn_of_places(
        between > adhesion.accuracy,
        f"miss {accuracy} since the heights between the pixels are not known (largest interpolation_error "
        f"{float(between.max()):.2g}): no mesh mends this; take a scan with smaller pixels",
    )
    _warn_of_places(
        out["pull_off_error"].isnull() & (out["pull_off_force"] > 0),
        "have no error estimate (pull_off_error is NaN), since there was no second mesh, or it or another step gave no "
        "pull-off; compare with another mesh or a smaller step",
    )


def _warn_of_places(flags: xr.DataArray, words: str, category: type[Warning] = RoughxrWarning) -> None:
    """Warn of the places with a flag at any preload, if there are any."""
    flagged = flags.any([dim for dim in flags.dims if dim != "subregion"])
    if flagged.any():
        warn(Phrase(f"{int(flagged.sum())} of {flagged.size} subregions ", words), category)


def _warn_of_one_mesh(out: xr.Dataset, adhesion: Adhesion, problem: Problem) -> None:
    """Warn of contacts that one mesh does not resolve, and of pull-offs without an error."""
    radius = out["pull_off_resolution"]
    _warn_of_places(
        radius < LEAST_RADIUS,
        Phrase(
            f"have contacts with a radius below {LEAST_RADIUS:g} cells at pull-off (smallest "
            f"{float(radius.min()):.2g}): compare with a finer mesh, or take ",
            Argument("mesh", "auto"),
        ),
        UnresolvedContact,
    )
    if np.isnan(adhesion.accuracy):
        return
    largest = resolving_cell(adhesion, problem)
    coarse = (
        f", and cells of {problem.dx:.3g} nm do not resolve its traction (at most {largest:.3g} nm do): rounding may "
        "change the pull-off by 10 % or more"
    )
    _warn_of_places(
        out["pull_off_error"].isnull() & (out["pull_off_force"] > 0),
        Phrase(
            "have no error estimate (pull_off_error is NaN): one mesh gives none for ",
            Argument("law", adhesion.law),
            f"{coarse if problem.dx > largest else ''}; take ",
            Argument("mesh", "auto"),
            ", or compare with a finer mesh",
        ),
        UnresolvedContact,
    )


def _warn_of_ranges(out: xr.Dataset) -> None:
    """Warn of places whose pull-off depends on how hard the sphere was pressed."""
    pull = out["pull_off_force"].values.ravel()
    pressed = out["pressed_pull_off_force"].values.ravel()
    is_ranged = out["pull_off_force"].copy(data=is_range(pull, pressed).reshape(out["pull_off_force"].shape))
    if is_ranged.any():
        widest = np.nanargmax(settling_changes(pull, pressed))
        low, high = sorted([pull[widest], pressed[widest]])
        _warn_of_places(
            is_ranged,
            f"have a range and not one pull-off, at the widest {low:.3g} … {high:.3g} nN, from pull_off_force to "
            "pressed_pull_off_force. There attraction ends before the next summits, which only pressing reaches: state "
            "a preload",
        )


def _warn(out: xr.Dataset, adhesion: Adhesion, problem: Problem) -> None:
    """Warn of inaccurate, truncated or incomplete places, and of a law that is cut off."""
    if ADHESION_LAWS[adhesion.law].has_hamaker_tail:
        warn(
            Phrase(
                Argument("law", adhesion.law),
                f" is cut off at a gap of {TAIL * adhesion.length:.3g} nm: the pull-off of a smooth sphere is 0.9 % "
                "too small, that of stiff rough bodies up to 20 %, and pull_off_error does not include this error; "
                "compare with `rigid`, which has no cut-off",
            )
        )
    if adhesion.refine:
        _warn_of_one_mesh(out, adhesion, problem)
    elif np.isfinite(adhesion.accuracy):
        _warn_of_errors(out, adhesion)
    _warn_of_ranges(out)
    rough = out["residual"].notnull() & ~out["converged"].astype(bool)
    if rough.any():
        what = "cycles contain states that" if "preload_delta" in out else "states"
        warn(
            f"{int(rough.sum())} of {rough.size} {what} have not converged (converged is False); results that depend "
            "on them are NaN: compare with a smaller step or a finer mesh",
            IncompleteResult,
        )
    _warn_of_places(
        out["truncated"] & out["complete"],
        "have contact or liquid at the edge of the scan or of the indenter's map (truncated is True): their forces do "
        "not include the surface beyond; take a larger scan, a smaller sphere or places farther inside",
        IncompleteResult,
    )
    if adhesion.on_cells:
        what = "did not reach their preload or " if adhesion.preloads.size else ""
        reason = f"{what}needed more than {MOST_CELLS:g} cells; their results are NaN"
    else:
        seconds = format_number(float(f"{seconds_on_cells(problem, adhesion):.1g}"), "s")
        reason = Phrase(
            "have no valid front (more than one contact, or one too far from a circle); their results are NaN: ",
            Argument("law", JKR),
            f" solves them on cells, in about {seconds} each",
        )
    _warn_of_places(~out["complete"], reason, IncompleteResult)
