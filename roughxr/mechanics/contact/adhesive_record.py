"""The record of `adhesive` at one place: states, events and fields of its cycles."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..asperity.moments import KEPT, states_layout
from ..jobs.records import BRANCHES, Layout
from ..kernels.adhesion import path as path
from .adhesion_on_cells import Adhesion
from .cycle import Cycles, largest_displacement, reached, yielded_shares
from .edge_front import FrontCycles, front_results, valid_cycles
from .elastic import ABOVE_HARDNESS, YIELDED
from .levers import lever_results
from .problem import Place, Problem
from .refinement import cycles_at
from .solving import put_fields, state_fields

_STATES: dict[str, type] = dict.fromkeys(
    ("force", "contact_area", "energy", "dissipated", "contact_patches", "resolution"), float
)
_STATES |= {"iterations": int, "residual": float, "converged": bool}

_EVENTS: dict[str, type] = dict.fromkeys(("snap_in_force", "snap_in_delta", "pull_off_force", "pull_off_delta"), float)
_EVENTS |= dict.fromkeys(("detachment_delta", "work_of_separation", "hysteresis", "pull_off_resolution"), float)
_EVENTS |= dict.fromkeys(("pull_off_error", "mesh_error", "step_error", "interpolation_error"), float)
_EVENTS |= {"pressed_pull_off_force": float, "mesh": int, "truncated": bool, "complete": bool}

_AT_PRELOAD = {"preload_delta": float, "contact_area": float, "residual": float, "converged": bool}

#: States that are extrapolated for laws with an edge.
_EXTRAPOLATED = ("force", "contact_area", "energy", "dissipated")


def cycle_layout(problem: Problem, adhesion: Adhesion, preload: Any) -> Layout:
    """Return the layout of a record: states along the displacements, or events along preloads and cycles."""
    hard = ABOVE_HARDNESS if np.isfinite(problem.hardness) else {}
    hard = hard | YIELDED if problem.yielding else hard
    if adhesion.preloads.size == 0:
        axes = {"branch": list(BRANCHES), "delta": problem.steps}
        return Layout(axes, _STATES | hard, _EVENTS, yields=problem.yielding)
    if adhesion.directions.size:
        moments = states_layout(adhesion.directions)
        events = {own_name: moments.events[name] for own_name, name in KEPT.items() if name in moments.events}
        return moments._replace(events=_EVENTS | _AT_PRELOAD | hard | events)
    axes = {"cycle": np.arange(1, adhesion.cycles + 1)} if adhesion.cycles > 1 else {}
    axes |= {} if preload is None or np.ndim(preload) == 0 else {"preload": adhesion.preloads}
    return Layout(axes, _EVENTS | _AT_PRELOAD | hard)


def cycle_record(place: Place, problem: Problem, layout: Layout, adhesion: Adhesion) -> np.ndarray:
    """Follow the cycles of one place, one for each preload, and return their record."""
    by_front = valid_cycles(place, problem, adhesion)
    if by_front or not adhesion.on_cells:
        return _front_record(by_front, problem, layout, adhesion)
    cycles, errors = cycles_at(place, problem, adhesion, fields=layout.window is not None)
    record = layout.blank()
    for k, cycle_path in enumerate(cycles.paths):
        results: dict[str, Any] = dict(cycles.events[k]) if reached(cycle_path, adhesion, k) else {}
        reach = largest_displacement(cycle_path, cycles) + (adhesion.liquid.height if adhesion.liquid else 0.0)
        results |= {"complete": bool(results), "truncated": cycles.surface.unknown_from < reach}
        results |= {name: np.broadcast_to(value, len(cycles.paths))[k] for name, value in errors.items()}
        if adhesion.preloads.size and results["complete"]:
            results |= _preload_results(cycles, k)
            results |= lever_results(place, cycles, adhesion) if adhesion.directions.size else {}
        for name, value in results.items():
            at = np.unravel_index(k, record[name].shape) if np.ndim(value) == 0 else ...
            record[name][at] = value
    if "branch" in layout.axes:
        record["complete"] = cycles.paths[0].status == path.CONVERGED
        _put_states(record, cycles, to_edge=layout.window is None)  # so that fields and forces agree
    if layout.window is not None:
        _put_fields(record, cycles, problem)
    return record


def _preload_results(cycles: Cycles, k: int) -> dict[str, Any]:
    """Return the state in which a cycle turns back at its preload, and the accuracy of all its states."""
    cycle_path = cycles.paths[k]
    turns = [paths[k].states[paths[k].first_retraction - 1] for paths in (cycles.paths, cycles.wider or cycles.paths)]
    depth, area = (cycles.edges[k].apply(*(turn[name] for turn in turns)) for name in ("delta", "contact_area"))
    shares = yielded_shares(cycle_path, cycles.problem)
    return {
        "preload_delta": depth,
        "contact_area": max(area, 0.0),
        "converged": bool(cycle_path.states["converged"].all()),
        "residual": cycle_path.states["residual"].max(),
        **{name: values[cycle_path.first_retraction - 1] for name, values in shares.items()},
    }


def _front_record(cycles: FrontCycles | None, problem: Problem, layout: Layout, adhesion: Adhesion) -> np.ndarray:
    """Return the record of cycles by their front; without cycles, that of a place that is not solved."""
    record = layout.blank()
    for k, results in enumerate(front_results(cycles, problem, adhesion) if cycles else []):
        for name, value in results.items():
            record[name][np.unravel_index(k, record[name].shape)] = value
    return record


def _put_states(record: np.ndarray, cycles: Cycles, *, to_edge: bool) -> None:
    """Write the states at the prescribed displacements along (branch, delta); NaN after the end of a broken path."""
    steep = _at_displacements(cycles.paths[0], cycles.problem)
    wide = _at_displacements(cycles.wider[0], cycles.problem) if cycles.wider and to_edge else steep
    extrapolated = cycles.edges[0]
    for name, branches in steep.items():
        for k, (values, wider) in enumerate(zip(branches, wide[name])):
            size = min(len(values), len(wider))
            values = values[:size]
            wider = wider[:size]
            if wide is not steep and name in _EXTRAPOLATED:
                same = steep["contact_patches"][k][:size] == wide["contact_patches"][k][:size]
                same &= (steep["contact_patches"][k][:size] > 0) | (name == "dissipated")
                values = np.where(same, extrapolated.apply(values, wider), values)
            values = np.maximum(values, 0.0) if name == "contact_area" else values
            if k == 0:
                record[name][0, :size] = values
            else:
                record[name][1, record[name].shape[1] - size :] = values[::-1]


def _at_displacements(cycle_path: path.Path, problem: Problem) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return loading and retraction of each quantity at the prescribed displacements."""
    states = {name: cycle_path.states[name] for name in _STATES} | yielded_shares(cycle_path, problem)
    prescribed = cycle_path.states["prescribed"]
    on_loading = np.arange(len(cycle_path.states)) < cycle_path.first_retraction
    return {
        name: (values[prescribed & on_loading], values[prescribed & ~on_loading]) for name, values in states.items()
    }


def _put_fields(record: np.ndarray, cycles: Cycles, problem: Problem) -> None:
    """Write the fields of the states at the prescribed displacements."""
    cycle_path = cycles.paths[0]
    surface = cycles.surface
    if len(cycle_path.pressures) != len(BRANCHES) * problem.steps.size:  # the path broke off: its fields stay NaN
        return
    deltas = np.tile(problem.steps + surface.zero, (len(BRANCHES), 1))
    shape = surface
    if problem.yielding:
        heights = cycle_path.residual_heights
        put_fields(record, surface, {"residual_height": heights})
        residual_heights = np.stack((heights, np.broadcast_to(heights[-1], heights.shape)))
        shape = surface._replace(separation=surface.separation - residual_heights)
    put_fields(record, surface, state_fields(_split_branches(cycle_path.pressures), shape, deltas, problem))


def _split_branches(pressures: np.ndarray) -> np.ndarray:
    """Return (branch, delta, nx, ny) of states in the path's order, in which delta falls on retraction."""
    loading, retraction = np.split(pressures, len(BRANCHES))
    return np.stack([loading, retraction[::-1]])
