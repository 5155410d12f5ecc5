"""The choice of the mesh at one contact centre, and the errors of the pull-off.

The cells are halved until meshes agree on the pull-off: two successive ones if they resolve the contact, else three. On
one mesh the errors of laws without range follow from the radius of the contact in cells and from the difference between
both edges (`cycle`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..vocabulary.adhesion_laws import ADHESION_LAWS
from .adhesion_on_cells import Adhesion, resolving_cell
from .cycle import LARGEST_CORRECTION, LARGEST_DIFFERENCE, MOST_CELLS, Cycles, cycles_on, overlapping_cells
from .pressing import LARGEST_SETTLING, settled_errors
from .problem import Place, Problem, surface_at

#: Largest part of the error of a pull-off without range that remains on cells of half the side. At edges that cannot
#: move, the error falls as the root of the side, to 0.71. The sum of all further changes is then up to 3 times the last
#: change, and stated as the error. ``tests/benchmarks/stated_error.py`` counts the places that this covers.
_LARGEST_ERROR_RATIO = 0.75

#: Cells on which the sphere is pressed, over those of its pull-off: they change the ratio of both by a tenth, where the
#: pressed sphere touches many times as many summits, and takes minutes on the smallest cells.
_PRESSED_CELLS = 4

#: Least stated error without range: the mean error of smooth spheres.
_LEAST_ERROR = 0.006

#: The refinements that mesh="auto" may choose.
REFINEMENTS = (1, 2, 4, 8, 16)

#: The largest number of meshes at a place: a fifth would cost four times as much as the others together.
_MOST_MESHES = 4

#: Root mean square of the relative error of a mesh without range, times the square of the radius (cells) of the
#: smallest contact at pull-off: spheres of 1.5 to 14 cells (``tests/benchmarks/without_range.py``).
_MESH_ERROR = 0.5

#: A single mesh states so many times that error. Two meshes state it as well, since they may agree by chance.
_DEVIATIONS = 3.0

#: Radius (pixels) of a contact at pull-off from which on pixels are taken, where finer meshes do not agree.
_PIXEL_RADIUS = 4.0

#: Relative error without range on a film that changes the contact, times the film's thickness in cells: the width of
#: the cohesive zone must be small beside the thickness. Smooth spheres on films of 2 to 20 cells are off by 0.1 of it
#: over the thickness if compressible, by 0.2 if not (``tests/benchmarks/without_range.py``).
_FILM_ERROR = 0.2


def cycles_at(place: Place, problem: Problem, adhesion: Adhesion, *, fields: bool) -> tuple[Cycles, dict]:
    """Return the cycles at one place, on a mesh that meets the accuracy, and the errors of their pull-offs."""
    if adhesion.refine:
        press = _presses_once(adhesion)
        cycles = _solved(place, problem, adhesion, adhesion.refine, fields=fields, press=press)
        pressed = _pressed_pull_offs(place, problem, adhesion, cycles)
        error = with_settling(_single_mesh_error(cycles), cycles.pull_offs, pressed, adhesion)
        return cycles, {"mesh": adhesion.refine, "pressed_pull_off_force": pressed, "pull_off_error": error}
    return _refined_until_accurate(place, problem, adhesion)


def _refined_until_accurate(place: Place, problem: Problem, adhesion: Adhesion) -> tuple[Cycles, dict]:
    """Halve the cells until the pull-off changes by less than the accuracy, or there are too many cells.

    The change from one mesh to the next is the error of the finer mesh: an upper bound if the meshes converge at first
    order or better. Without range more is stated, `_slow_convergence_error`. A mesh that has not converged is not taken
    after one that has. The error of the step is the change between the step and twice the step on the coarsest mesh.
    """
    meshes = _possible_meshes(place, problem, adhesion)
    press = _presses_once(adhesion)
    cycles = _solved(place, problem, adhesion, meshes[0], press=press)
    if np.isnan(adhesion.accuracy):
        return cycles, {"mesh": meshes[0], "pressed_pull_off_force": cycles.pressed_pulls}
    step_error = _change(_solved(place, problem, adhesion._replace(step=2 * adhesion.step), meshes[0]), cycles)
    spline_change = _change_by_splines(place, problem, adhesion, cycles)
    mesh_error, slow = _single_mesh_error(cycles), _slow_convergence_error(cycles)
    if not meshes[1:] and meshes[0] > 1:  # cells too large for the law give an upper bound
        mesh_error = _change(_solved(place, problem, adhesion, meshes[0] // 2), cycles)
        slow = _slow_convergence_error(cycles, mesh_error)
    agrees = False
    for n in meshes[1:]:
        finer = _solved(place, problem, adhesion, n, press=press)
        if (np.isnan(finer.pull_offs) & (cycles.pull_offs > 0)).any():
            break
        before, cycles = cycles, finer
        mesh_error = _error_of_finer_mesh(before, cycles)
        slow = np.fmax(_slow_convergence_error(cycles, _change(before, cycles)), _LARGEST_ERROR_RATIO * slow)
        if spline_change is None:
            spline_change = _change_by_splines(place, problem, adhesion, cycles)
        agreed_before = agrees
        agrees = _meets_accuracy(mesh_error, cycles, adhesion)
        if agrees and (agreed_before or _is_resolved(cycles, adhesion)):
            break
    on_pixels = None if agrees else _resolved_on_pixels(place, problem, adhesion, cycles)
    if on_pixels:
        cycles = on_pixels
        mesh_error = _single_mesh_error(on_pixels)
        slow = 0.0
        spline_change = None
    interpolation_error = 0.0 * mesh_error if spline_change is None else spline_change
    numerical = np.sqrt(np.maximum(mesh_error, slow) ** 2 + step_error**2 + interpolation_error**2)
    pressed = _pressed_pull_offs(place, problem, adhesion, cycles)
    return cycles, {
        "mesh": cycles.problem.refine,
        "pressed_pull_off_force": pressed,
        "mesh_error": mesh_error,
        "step_error": step_error,
        "interpolation_error": interpolation_error,
        "pull_off_error": with_settling(numerical, cycles.pull_offs, pressed, adhesion),
    }


def _possible_meshes(place: Place, problem: Problem, adhesion: Adhesion) -> list[int]:
    """Return the refinements that resolve the law on few enough cells, the coarsest first."""
    on_pixels = problem._replace(refine=1)
    pixels = overlapping_cells(surface_at(place, on_pixels), on_pixels, adhesion)
    finest = max((n for n in REFINEMENTS if pixels * n**2 <= MOST_CELLS), default=1)
    first = min(first_refinement(problem, adhesion), finest)
    return [n for n in REFINEMENTS if first <= n <= finest][:_MOST_MESHES]


def _error_of_finer_mesh(coarse: Cycles, fine: Cycles) -> np.ndarray:
    """Return the relative errors of pull-offs without those of slow convergence; NaN where the coarse mesh has none."""
    change = _change(coarse, fine)
    radius_errors = np.fmax(_radius_errors(fine), _film_errors(fine))
    is_new = np.isnan(change) & (fine.pull_offs > 0)
    return np.where(is_new, np.nan, np.fmax.reduce([change, _edge_errors(fine), radius_errors]))


def _meets_accuracy(errors: np.ndarray, cycles: Cycles, adhesion: Adhesion) -> bool:
    """Return whether the errors of all pull-offs are known and within the accuracy."""
    is_known = not np.isnan(errors[cycles.pull_offs > 0]).any()
    return is_known and bool((errors < adhesion.accuracy)[np.isfinite(errors)].all())


def _resolved_on_pixels(place: Place, problem: Problem, adhesion: Adhesion, cycles: Cycles) -> Cycles | None:
    """Return the cycles on pixels if these resolve the contact, and finer cells, which do not agree, find another one.

    Heights between pixels ring beside a cliff, by band-limited interpolation as by splines: the sphere then rests on
    the ripples.
    """
    if cycles.problem.refine == 1:  # there are no finer cells
        return None
    on_pixels = _solved(place, problem, adhesion, 1)
    is_other = _change(on_pixels, cycles) > LARGEST_DIFFERENCE
    return on_pixels if (is_other & (_contact_radii(on_pixels) > _PIXEL_RADIUS)).all() else None


def _slow_convergence_error(cycles: Cycles, change: Any = 0.0) -> Any:
    """Return the error without range by a change from larger cells, or from the wider edge, that goes on slowly.

    Changes beyond `LARGEST_DIFFERENCE` belong to different contacts and are left out.
    """
    if not cycles.wider or ADHESION_LAWS[cycles.law].has_range:
        return 0.0
    rises = 1 - cycles.wide_pulls / np.where(cycles.steep_pulls > 0, cycles.steep_pulls, np.nan)
    return np.maximum(np.maximum(_remaining_series(rises), _remaining_series(change)), _LEAST_ERROR)


def coarser_mesh_error(change: np.ndarray, law: str | None) -> np.ndarray:
    """Return the error of the coarser of two meshes by the relative change: without range the changes go on slowly."""
    if law is None or ADHESION_LAWS[law].has_range:
        return change
    return np.maximum(change + _remaining_series(change), _LEAST_ERROR)


def _remaining_series(change: Any) -> Any:
    """Return the sum of all changes that follow one of a slow series; 0 after one that is not part of it."""
    first = np.where((change > 0) & (change <= LARGEST_DIFFERENCE), change, 0.0)
    return first * _LARGEST_ERROR_RATIO / (1 - _LARGEST_ERROR_RATIO)


def _change_by_splines(place: Place, problem: Problem, adhesion: Adhesion, cycles: Cycles) -> np.ndarray | None:
    """Return the change of the pull-off if heights are interpolated by splines; None if cells are pixels."""
    refine = cycles.problem.refine
    if refine == 1:
        return None
    return _change(_solved(place, problem._replace(splined=True), adhesion, refine), cycles)


def _pressed_pull_offs(place: Place, problem: Problem, adhesion: Adhesion, cycles: Cycles) -> np.ndarray:
    """Return each pull-off (nN) after the sphere was pressed as hard as it holds; NaN where that is not solved.

    A law without range closes gaps up to `snap_in_gap` only, a preload the others. The sphere may then hold more than
    the preload, and is pressed again. The ratio to the pull-off as it settles is that of larger cells. If the sphere
    settles there on other summits, which hold more, the pull-off itself is.
    """
    if not _is_pressed_on_larger_cells(adhesion):
        return cycles.pressed_pulls
    refine = max(cycles.problem.refine // _PRESSED_CELLS, first_refinement(problem, adhesion))
    on_larger = _solved(place, problem, adhesion, refine) if refine < cycles.problem.refine else cycles
    pulls = on_larger.pull_offs
    load = 0.0
    pressed = np.nanmax(np.append(pulls, on_larger.wide_pulls), initial=0.0)  # wider edges may settle on more summits
    light = np.resize(adhesion.preloads, pulls.size) < pressed
    while light.any() and pressed > (1 + LARGEST_SETTLING) * load:
        load = pressed
        harder = adhesion._replace(preloads=np.array([load]), cycles=1)
        (pressed,) = _solved(place, problem, harder, on_larger.problem.refine).pull_offs
    with np.errstate(invalid="ignore", divide="ignore"):
        scaled = cycles.pull_offs * pressed / pulls
        is_elsewhere = pulls > (1 + LARGEST_DIFFERENCE) * cycles.pull_offs
        return np.where(light, np.where(is_elsewhere, pressed, scaled), cycles.pull_offs)


def _is_pressed_on_larger_cells(adhesion: Adhesion) -> bool:
    """Return whether places are solved once more after the sphere was pressed: without range, where cells are small."""
    return adhesion.presses and not ADHESION_LAWS[adhesion.law].has_range and not np.isnan(adhesion.accuracy)


def _presses_once(adhesion: Adhesion) -> bool:
    """Return whether loading continues beyond the preload, on the cells of the pull-off."""
    return adhesion.presses and not _is_pressed_on_larger_cells(adhesion)


def with_settling(errors: np.ndarray, pulls: np.ndarray, pressed: np.ndarray, adhesion: Adhesion) -> np.ndarray:
    """Return the errors of pull-offs, with their changes by pressing where these are requested."""
    return settled_errors(errors, pulls, pressed) if adhesion.presses else errors


def _contact_radii(cycles: Cycles) -> np.ndarray:
    """Return the radii (cells) of the smallest contacts at pull-off."""
    return np.array([events.get("pull_off_resolution", np.nan) for events in cycles.events])


def _radius_errors(cycles: Cycles) -> np.ndarray:
    """Return the usual error of the mesh for the radii of the contacts at pull-off."""
    return _MESH_ERROR / _contact_radii(cycles) ** 2


def _is_resolved(cycles: Cycles, adhesion: Adhesion) -> bool:
    """Return whether the mesh resolves all contacts so well that one more mesh cannot agree by chance."""
    errors = _DEVIATIONS * _radius_errors(cycles)
    return bool((errors < adhesion.accuracy)[np.isfinite(errors)].all())


def _film_errors(cycles: Cycles) -> np.ndarray:
    """Return the error of a law with an edge on a film of few cells, as far as the film changes the contact."""
    film, radii = cycles.problem.film, _contact_radii(cycles)
    if film is None or not cycles.wider:
        return 0.0 * radii
    softening = film.softening(radii)
    return _FILM_ERROR / film.thickness * np.abs(1.0 - softening) / np.maximum(1.0, softening)


def _edge_errors(cycles: Cycles) -> np.ndarray:
    return np.array([extrapolation.error for extrapolation in cycles.edges])


def _single_mesh_error(cycles: Cycles) -> np.ndarray:
    """Return the stated errors of pull-offs by a law with an edge, NaN for a law without."""
    if not cycles.wider:
        return np.full(len(cycles.paths), np.nan)
    pulls = cycles.pull_offs
    steep = cycles.steep_pulls
    radius_errors = np.fmax(_DEVIATIONS * _radius_errors(cycles), _film_errors(cycles))
    errors = np.fmax(np.fmax(_edge_errors(cycles), _slow_convergence_error(cycles)), radius_errors)
    with np.errstate(invalid="ignore", divide="ignore"):
        limited = np.abs(pulls - steep) > 0.99 * LARGEST_CORRECTION * steep  # edges differ by more than their width
        return errors + np.where(limited | ADHESION_LAWS[cycles.law].has_range, np.abs(pulls - steep) / pulls, 0.0)


def first_refinement(problem: Problem, adhesion: Adhesion) -> int:
    """Return the number of cells along a pixel of the coarsest mesh."""
    cell = resolving_cell(adhesion, problem)
    if np.isfinite(adhesion.accuracy):  # on pixels wider than the contacts, two meshes would agree by chance
        cell = min(cell, adhesion.first_cell)
    return next((n for n in REFINEMENTS if problem.pixel / n <= cell), REFINEMENTS[-2])


def _change(cycles: Cycles, reference: Cycles) -> np.ndarray:
    """Return the relative difference of the pull-offs of two meshes; NaN where the reference does not adhere."""
    pulls = cycles.pull_offs
    expected = reference.pull_offs
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(expected > 0, np.abs(pulls - expected) / expected, np.nan)


def _solved(
    place: Place,
    problem: Problem,
    adhesion: Adhesion,
    refine: int,
    *,
    fields: bool = False,
    press: bool = False,
) -> Cycles:
    """Return the cycles at one place on one mesh."""
    problem = problem._replace(refine=refine)
    return cycles_on(surface_at(place, problem), problem, adhesion, fields=fields, press=press)
