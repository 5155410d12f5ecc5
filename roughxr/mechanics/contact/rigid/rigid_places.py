"""Rigid bodies at given places: a task for each place, with the adhesion force at all displacements."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...jobs.records import Layout
from ...kernels.adhesion import potentials
from ...kernels.adhesion import rigid as kernels
from ...kernels.topography import dilation
from .. import menisci
from ..problem import Place, Problem, Surface, surface_at
from ..solving import put_fields
from .attraction import BEYOND_EDGE, NEAREST_GAPS, Options, interpolated_pull_off

_EVENTS = {
    "pull_off_force": float,
    "pull_off_delta": float,
    "touch_delta": float,
    "share_beyond_contact": float,
    "cell_error": float,
    "truncated": bool,
}

#: Further variables of condensed liquid, also at humidities at which nothing condenses.
_OF_LIQUID = {"meniscus_error": float, "work_of_separation": float}


def rigid_layout(problem: Problem, *, is_humid: bool) -> Layout:
    """Return the variables of a place."""
    return Layout({"delta": problem.steps}, {"force": float}, _EVENTS | (_OF_LIQUID if is_humid else {}))


class _Setting(NamedTuple):
    """The indenter and the surface at one place, and the law between them."""

    surface: Surface
    mean_plane: float  # nm below the datum, the surface beyond the window
    rectangle: tuple[float, ...]  # sides of the window from the centre, nm
    problem: Problem
    options: Options
    cells: kernels.Cells

    def attractions(self, deltas: np.ndarray) -> np.ndarray:
        """Return the adhesion force (nN) at displacements (nm below the datum)."""
        o = self.options
        closest = kernels.smallest_gap(o.law)
        inside = kernels.attractions(self.surface.separation, self.cells, deltas, o.law, closest, o.area)
        return inside + self.attractions_beyond(deltas)

    def attractions_beyond(self, deltas: np.ndarray) -> np.ndarray:
        """Return the adhesion force (nN) from beyond the window."""
        indenter = self.problem.indenter
        o = self.options
        if indenter.map is not None:
            return np.zeros(deltas.size)
        return kernels.force_outside(self.mean_plane - deltas, o.law, indenter.radius, self.rectangle)

    def first_touch(self) -> float:
        """Return the displacement (nm below the datum) of first touch."""
        return float(self.surface.separation.min())


def _setting(place: Place, problem: Problem, options: Options) -> _Setting:
    """Return the indenter over the surface at one place."""
    surface = surface_at(place, problem)
    low = [-(first + problem.pixel * (lost - 0.5)) for first, lost in zip(place.window.origin, place.window.missing)]
    sides = [(a, n * problem.pixel - a) for a, n in zip(low, place.height.shape)]
    rectangle = tuple(max(side, 1e-6) for pair in sides for side in pair)
    mean_plane = float(place.datum) - options.mean_height
    return _Setting(surface, mean_plane, rectangle, problem, options, kernels.cells(surface.separation, options.law))


def rigid_record(place: Place, problem: Problem, layout: Layout, options: Options) -> np.ndarray:
    """Return the record of one place, as a task."""
    setting = _setting(place, problem, options)
    surface = setting.surface
    law = options.law
    record = layout.blank()
    deltas = problem.steps + surface.zero
    closest, (force, delta) = _pull_off(setting)
    within = deltas <= closest + 1e-9
    record["force"][within] = -setting.attractions(deltas[within])
    if "meniscus_error" in layout.events:
        error = menisci.relative_error(setting.cells, delta, law, options.menisci, problem.dx, force)
        record["meniscus_error"] = error
        record["work_of_separation"] = menisci.work(surface.separation, delta, law, options.area)
    record["touch_delta"] = setting.first_touch() - surface.zero
    record["pull_off_force"] = force
    record["pull_off_delta"] = delta - surface.zero
    if law.closest is not None:
        exact = setting.attractions(np.array([delta - minimum_below_cells(surface.separation)]))[0]
        record["cell_error"] = force / exact - 1 if exact > 0 else np.nan
    record["share_beyond_contact"] = 1 - _contact_attraction(setting, delta) / force
    record["truncated"] = any(place.ends) and setting.attractions_beyond(np.array([delta]))[0] > BEYOND_EDGE * force
    if layout.window is not None:
        put_fields(record, surface, _fields(setting, np.where(within, deltas, np.nan)))
    return record


def minimum_below_cells(separation: np.ndarray) -> float:
    """Return the depth (nm) of the least separation below the lowest cell, by a paraboloid through 3 × 3 cells.

    Examples
    --------
    >>> x = np.arange(5.0) - 2.3
    >>> round(minimum_below_cells(x[:, None] ** 2 + (x - 0.2) ** 2), 6)
    0.34
    """
    i, j = np.unravel_index(np.argmin(separation), separation.shape)
    if not np.isfinite(separation[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2]).all():
        return 0.0
    patch = np.zeros(dilation.RISE + 1)
    dilation.put_patch(patch, separation, i, j, (1.0, 1.0), np.inf)
    slope = patch[[dilation.GX, dilation.GY]]
    bend = patch[[[dilation.HXX, dilation.HXY], [dilation.HXY, dilation.HYY]]]
    if bend[0, 0] * bend[1, 1] <= bend[0, 1] ** 2 or bend[0, 0] <= 0:  # also at the rim, where the patch is level
        return 0.0
    return float(0.5 * slope @ np.linalg.solve(bend, slope))


def _contact_attraction(setting: _Setting, delta: float) -> float:
    """Return the adhesion force (nN) from cells that count as in contact."""
    o = setting.options
    gap = np.maximum(setting.surface.separation.ravel() - delta, kernels.smallest_gap(o.law))
    # gap, in units of the law's length, up to which a cell counts as in contact
    near = gap[gap < 2.0 * o.law.length]
    return o.area * float(potentials.tractions(near, o.law).sum())


def _fields(setting: _Setting, deltas: np.ndarray) -> dict[str, np.ndarray]:
    """Return pressures and gaps on the window; rigid bodies have no displacement field."""
    law = setting.options.law
    gap = np.maximum(setting.surface.separation - deltas[:, None, None], kernels.smallest_gap(law))
    pressure = -potentials.tractions(np.minimum(gap, 1e12).ravel(), law).reshape(gap.shape)
    return {"pressure": pressure, "displacement": np.where(np.isnan(gap), np.nan, 0.0), "gap": gap}


def _pull_off(setting: _Setting) -> tuple[float, tuple[float, float]]:
    """Return the displacement of closest approach, and the largest adhesion force with its displacement."""
    law = setting.options.law
    if law.closest is not None:
        closest = setting.first_touch() - kernels.smallest_gap(law)
        return closest, (float(setting.attractions(np.array([closest]))[0]), closest)
    deltas = setting.first_touch() - law.length * NEAREST_GAPS
    return np.inf, interpolated_pull_off(deltas, setting.attractions(deltas))
