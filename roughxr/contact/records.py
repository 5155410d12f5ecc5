"""The output of a solve: one record for each contact centre, and the labelled Dataset made of all of them.

A solver fills one record of a structured dtype: states along the steps of the solve, events of the whole centre, and
fields on the window around it. All records together are one array, computed or lazy; its parts become variables.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import regions, schema
from ..jobs import lazy as parallel
from ..kernels.halfspace.products import surface_displacement
from .problem import Place, Problem, Surface, places, surface_at

#: The two branches of a cycle.
BRANCHES = ("loading", "retraction")

#: Fields on the window around a centre, along all axes, where they are asked for.
FIELDS = ("pressure", "displacement", "gap")


class Layout(NamedTuple):
    """The parts of a record, and the axes of each."""

    axes: Mapping[str, Any]  # dimension of the states -> its coordinate
    states: Mapping[str, type]
    events: Mapping[str, type] = {}
    window: tuple[int, int] | None = None  # cells of the full window, where fields are kept
    yields: bool = False  # whether the field residual_height is kept as well, along all axes but the branch

    @property
    def dtype(self) -> np.dtype:
        """The structured dtype of a record."""
        parts = [(name, kind, self.along(name)) for name, kind in self.states.items()]
        parts += [(name, kind) for name, kind in self.events.items()]
        parts += [(name, float, (*self.along(name), *self.window)) for name in self.fields]
        return np.dtype(parts)

    @property
    def fields(self) -> tuple[str, ...]:
        """The fields that are kept."""
        return (*FIELDS, *(("residual_height",) if self.yields else ())) if self.window else ()

    def along(self, name: str) -> tuple[int, ...]:
        """Return the lengths of the axes of a part."""
        return tuple(len(self.axes[axis]) for axis in self._axes_of(name))

    def _axes_of(self, name: str) -> tuple[str, ...]:
        if name in self.events:
            return ()
        return tuple(axis for axis in self.axes if name != "residual_height" or axis != "branch")

    def blank(self) -> np.ndarray:
        """Return a record in which every number is missing, every count 0 and every flag False."""
        record = np.zeros((), self.dtype)
        for name in self.dtype.names:
            if self.dtype[name].base.kind == "f":
                record[name] = np.nan
        return record

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the dimensions of a part after ``subregion``."""
        return (*self._axes_of(name), *(("x", "y") if name in self.fields else ()))


def solve(
    solver: Any,
    ds: xr.Dataset,
    problem: Problem,
    layout: Layout,
    options: Any,
    *,
    name: str,
    positions: xr.Dataset,
    reach: float,
    fields: bool = False,
    cost: Any = None,
    progress: bool = False,
) -> xr.Dataset:
    """Solve a problem at every contact centre and label what comes back.

    Parameters
    ----------
    solver : callable
        ``solver(place, problem, layout, options)`` returns a filled `Layout.blank` record. At the top of a module,
        so that other processes can import it.
    ds : Dataset
        A valid scan.
    problem : Problem
    layout : Layout
    options : NamedTuple
        Further options of the solver.
    name : str
        Name of the solve in logs and messages.
    positions : Dataset
        Contact centres, as `regions.centres` returns them.
    reach : float
        Half-width of the windows, nm.
    fields : bool
        Keep fields on the windows.
    cost : callable, optional
        ``cost(surface, problem)`` returns the cost of a centre, in any unit.
    progress : bool

    Returns
    -------
    Dataset
        Lazy where the scan is; within a checkpointed run also not yet computed.
    """
    ds, lazy = schema.complete(ds), parallel.is_lazy(ds)
    found, shape = places(ds, positions, reach)
    if fields:
        layout = layout._replace(window=tuple(problem.refine * n for n in shape))
    records = parallel.spread(
        _solve_one,
        found,
        layout.dtype,
        solver,
        problem,
        layout,
        options,
        name=name,
        cost=partial(_costs, found, problem, cost) if cost else None,
        lazy=lazy,
        progress=progress,
    )
    out = labelled(records, layout, ds, positions)
    return out.assign_coords(window_axes([place.window for place in found], problem, layout)) if fields else out


def _solve_one(height, datum, window, ends, solver, problem, layout, options) -> np.ndarray:
    """Solve one place; the function that a task runs."""
    return solver(Place(height, datum, window, ends), problem, layout, options)


def _costs(found: list[Place], problem: Problem, cost: Any) -> np.ndarray:
    return np.array([cost(surface_at(place, problem), problem) for place in found])


def labelled(records: Any, layout: Layout, ds: xr.Dataset, positions: xr.Dataset) -> xr.Dataset:
    """Return the Dataset of an array of records (subregion,), computed or lazy."""
    out = xr.Dataset({name: (("subregion", *layout.dims(name)), records[name]) for name in layout.dtype.names})
    pair = {name: ds[name] for name in schema.TRAVELLING if name in ds.coords}
    return schema.label(out.assign_coords({**layout.axes, **positions.coords, **pair}))


def loading(ds: xr.Dataset) -> xr.Dataset:
    """Return the loading branch of a solution that has both branches, else the solution itself."""
    return ds.sel(branch=BRANCHES[0], drop=True) if "branch" in ds.dims else ds


def fields_of(pressure: np.ndarray, surface: Surface, deltas: np.ndarray, problem: Problem) -> dict[str, np.ndarray]:
    """Return pressure (GPa), displacement and gap (nm) of the states at ``deltas`` (nm below the datum)."""
    displacement = surface_displacement(pressure, problem.dx, problem.contact_modulus)
    gap = displacement + surface.separation - deltas[..., None, None]
    return {
        "pressure": pressure,
        "displacement": displacement,
        "gap": np.where(np.isfinite(surface.separation), gap, np.nan),
    }


def put_fields(record: np.ndarray, surface: Surface, found: Mapping[str, np.ndarray]) -> None:
    """Write the fields of the solved cells into a record's full windows; cells beyond the scan stay NaN."""
    (i, j), (rows, columns) = surface.corner, surface.separation.shape
    for name, values in found.items():
        record[name][..., i : i + rows, j : j + columns] = values


def window_axes(windows: list[regions.Window], problem: Problem, layout: Layout) -> dict:
    """Return x, y from the contact centre, and each centre's offset where they lie unequally within their pixels."""
    half = 0.5 * (problem.pixel - problem.dx)  # from a pixel's centre to its first cell's
    origins = np.array([window.origin for window in windows]) - half
    alike = np.ptp(origins, axis=0).max() < 1e-6 * problem.dx
    common = origins[0] if alike else np.round(origins[0] / problem.pixel) * problem.pixel - half
    axes = {axis: common[k] + problem.dx * np.arange(layout.window[k]) for k, axis in enumerate("xy")}
    if alike:
        return axes
    shifts = origins - common
    return axes | {f"subpixel_{axis}": ("subregion", shifts[:, k]) for k, axis in enumerate("xy")}
