"""Rigid bodies at every pixel: the pull-off as a map, some rows of pixels in each task."""

from __future__ import annotations

from typing import NamedTuple

import dask
import numpy as np
import xarray as xr

from ...jobs import spread
from ...kernels.adhesion import rigid as kernels
from ...vocabulary import schema
from ..problem import Problem
from .attraction import BEYOND_EDGE, NEAREST_GAPS, Options, largest_pull, reach_of

#: Rows of places in one task of a map.
_ROWS = 16


class _Prepared(NamedTuple):
    """The input that all places of a map share."""

    height: np.ndarray  # padded by the indenter's half-width with the mean height
    rise: np.ndarray  # of the indenter over its lowest point, nm
    near_rise: np.ndarray  # its middle part, which alone can touch first
    top: np.ndarray  # highest point around each place
    mean: float
    cells: tuple[kernels.Cells, kernels.Cells]  # of the heights and of the indenter
    split: kernels.Split
    fields: np.ndarray  # (terms, nx, ny)


def every_pixel(specimen, problem, options, *, kept) -> xr.Dataset:
    """Return the pull-off at every pixel, and the forces there at given displacements."""
    heights, bodies, lazy = specimen.heights, specimen.bodies, specimen.lazy
    shape, half = heights.shape, int(np.ceil(reach_of(specimen, problem) / problem.pixel)) + 1
    steps = problem.steps if kept else np.zeros(0)
    arguments = heights, half, problem, options
    prepared = dask.delayed(_prepare, pure=False)(*arguments) if lazy else _prepare(*arguments)
    cell, rows = _cell(steps.size), min(_ROWS, shape[0])
    starts = [(start,) for start in range(0, shape[0], rows)]
    kind = np.dtype((cell, (rows, shape[1])))
    shared = shape, problem._replace(steps=steps), options, prepared
    records = spread.task_results(_some_rows, starts, kind, *shared, each=rows * shape[1], name="rigid", lazy=lazy)
    records = records.reshape((-1, shape[1]))[: shape[0]]
    names = [name for name in cell.fields or () if name != "force" or kept]
    dims = {"force": ("x", "y", "delta")}
    out = xr.Dataset({name: (dims.get(name, ("x", "y")), records[name]) for name in names})
    axes = {"x": bodies["x"], "y": bodies["y"]} | ({"delta": steps} if kept else {})
    return out.assign_coords(axes | schema.travelling(bodies))


def _prepare(height, half, problem, options) -> _Prepared:
    """Return what all places share."""
    from scipy.ndimage import maximum_filter

    height = np.asarray(height, dtype=float)
    mean, top = float(height.mean()), float(height.max())
    padded = np.pad(height, half, constant_values=mean)
    x = problem.pixel * np.arange(-half, half + 1)
    flat = np.zeros((x.size, x.size))
    rise = problem.indenter.separation(flat, 0.0, x, x)
    middle = int(np.count_nonzero(rise[half, half:] <= top - height.min() + 1e-9)) + 1
    inner = slice(max(half - middle, 0), half + middle + 1)
    near_rise = np.ascontiguousarray(rise[inner, inner])
    touches = _touches(padded, near_rise, rise, height.shape, slice(0, height.shape[0], max(1, height.shape[0] // 64)))
    farthest = top - height.min() + float(rise[np.isfinite(rise)].max())
    cells = kernels.cells(padded, options.law), kernels.cells(rise, options.law)
    split = kernels.split(options.law, top - float(touches.min()), farthest, _wet_reach(options.law, *cells))
    reach = int(np.count_nonzero(rise[half, half:] < split.near + top - float(touches.min())))
    around = maximum_filter(height, size=2 * min(reach, half) + 1, mode="constant", cval=mean)
    fields = kernels.far_fields(padded, rise, split, height.shape)
    return _Prepared(padded, rise, near_rise, around, mean, cells, split, fields)


def _wet_reach(law, ground: kernels.Cells, indenter: kernels.Cells) -> float:
    """Return the gap (nm) in the middle of a cell beyond which no part of it is wetted."""
    if not ground.mean.size:
        return 0.0
    near = indenter.mean < law.wet + np.ptp(ground.mean)
    slope = sum(np.abs(one).max() + np.abs(other[near]).max() for one, other in zip(ground[1:3], indenter[1:3]))
    return law.wet + 0.5 * slope


def _touches(padded, near_rise, rise, shape, rows) -> np.ndarray:
    """Return the height of the indenter's lowest point at first touch, at the places in a slice of rows."""
    lost = (rise.shape[0] - near_rise.shape[0]) // 2
    inner = padded[lost : padded.shape[0] - lost, lost : padded.shape[1] - lost]
    chosen = range(*rows.indices(shape[0]))
    out = np.empty((len(chosen), shape[1]))
    if rows.step in (None, 1):
        kernels.first_touches(np.ascontiguousarray(inner), near_rise, rows.start, out)
        return out
    for k, row in enumerate(chosen):
        kernels.first_touches(inner, near_rise, row, out[k : k + 1])
    return out


def _some_rows(start, shape, problem, options, prepared) -> np.ndarray:
    """Return the records of some rows of places; the function that a task runs."""
    rows = min(_ROWS, shape[0])
    records = np.zeros((rows, shape[1]), _cell(problem.steps.size))
    stop = min(start + rows, shape[0])
    touches = _touches(prepared.height, prepared.near_rise, prepared.rise, shape, slice(start, stop))
    datum = touches if problem.first_contact else float(prepared.height.max())
    offsets = options.law.length * NEAREST_GAPS if options.law.closest is None else [kernels.floor(options.law)]
    heights = touches[..., None] + np.asarray(offsets)
    pulls = _pulls(heights, start, problem, options, prepared)
    found = records[: stop - start]
    if options.law.closest is None:
        found["pull_off_force"], delta = largest_pull(-heights, pulls)
        z = -delta
    else:
        found["pull_off_force"], z = pulls[..., 0], heights[..., 0]
    found["pull_off_delta"], found["touch_delta"] = datum - z, datum - touches
    found["truncated"] = _from_beyond_scan(start, shape, z, found["pull_off_force"], problem, options, prepared)
    if problem.steps.size:
        z = np.asarray(datum)[..., None] - problem.steps + np.zeros((*touches.shape, 1))
        least = -np.inf if options.law.closest is None else kernels.floor(options.law)
        z = np.where(z >= touches[..., None] + least - 1e-9, z, np.nan)
        found["force"] = -_pulls(z, start, problem, options, prepared)
    return records


def _from_beyond_scan(start, shape, z, pull, problem, options, prepared) -> np.ndarray:
    """Return where more than the allowed share of the pull comes from beyond the nearest side of the scan."""
    rows, columns = start + np.arange(z.shape[0]), np.arange(shape[1])
    off = [np.minimum(n, size - 1 - n) + 0.5 for n, size in zip((rows, columns), shape)]
    off = problem.pixel * np.minimum(off[0][:, None], off[1])
    distances = problem.pixel * np.geomspace(0.5, prepared.rise.shape[0], 24)
    gap = np.array([np.median(z) - prepared.mean])
    law, sphere = options.law, (problem.indenter.radius, problem.indenter.parabola)
    beyond = [kernels.outside(gap, law, *sphere, (side, *[np.inf] * 3))[0] for side in distances]
    return np.interp(off, distances, beyond) > BEYOND_EDGE * pull


def _cell(steps: int) -> np.dtype:
    events = [("pull_off_force", float), ("pull_off_delta", float), ("touch_delta", float), ("truncated", bool)]
    return np.dtype([*events, ("force", float, (steps,))])


def _pulls(z, start, problem, options, prepared) -> np.ndarray:
    """Return the pull (nN) at heights z (rows, columns, heights) of the lowest point; NaN where z is."""
    split, law = prepared.split, options.law
    arguments = prepared.height, prepared.rise, *prepared.cells, prepared.top, start, z, law, split, kernels.floor(law)
    near = kernels.near_pulls(*arguments)
    fields = prepared.fields[:, start : start + z.shape[0]]
    far = kernels.far_pulls(fields, float(prepared.height.max()), z, split)
    return options.area * (near + far) + _around(z - prepared.mean, problem, options, prepared.rise.shape[0])


def _around(gaps: np.ndarray, problem: Problem, options: Options, size: int) -> np.ndarray:
    """Return the pull (nN) of the mean plane beyond the whole window, from a table over the gap."""
    from scipy.interpolate import CubicSpline

    known = gaps[np.isfinite(gaps)]
    if known.size == 0:
        return np.zeros(gaps.shape)
    side = (0.5 * size * problem.pixel,) * 4
    table = np.linspace(known.min() - 1e-6, known.max() + 1e-6, 40)
    pulls = kernels.outside(table, options.law, problem.indenter.radius, problem.indenter.parabola, side)
    return np.where(np.isfinite(gaps), CubicSpline(table, pulls)(np.nan_to_num(gaps, nan=table[0])), np.nan)
