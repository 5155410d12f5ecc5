"""Contact maps of places: from the archive where it holds fields, else solved again with the options that it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import dask
import numpy as np
import xarray as xr

from ...contact.adhesion import adhesive
from ...contact.elastic import direct
from ...contact.mesh import Mesh
from ...jobs.progress import Progress
from ...jobs.records import BRANCHES
from ...scans import regions
from ...studies.short_waves import quietly
from ...vocabulary import schema
from . import images
from .places import Placed, cases, number, numbers, over, with_pair

#: Largest number of cells along a side of a map: finer maps are averaged.
_MOST_CELLS = 96

#: Number of displacements of a loop that is followed again, on each branch, besides that of pull-off.
_STEPS = 16

#: A map is cropped to this many times the half-width of the contact.
_MARGIN = 1.15

#: The colour scale covers all but this share of the strongest tractions.
_CLIPPED_SHARE = 0.005


class Frames(NamedTuple):
    """The maps of one place: pressures along its branches, and the extent of the maps."""

    branches: list[str]
    delta: np.ndarray  # (frame,), nm from the highest peak
    force: np.ndarray  # (frame,), nN
    area: np.ndarray  # (frame,), nm²
    pressure: np.ndarray  # (frame, nx, ny), GPa
    box: list[float]  # least and greatest x, y of the map, nm from the contact centre


def contact_maps(at: Placed, *, loops: int) -> list[dict[str, Any]]:
    """Return the contact maps that the page shows, by the simulation with adhesion and by that without."""
    ways = (("adhesive", "with adhesion", _with_adhesion), ("direct", "without adhesion", _without))
    maps = []
    for name, words, make in ways:
        ds = at.held(f"solutions/{name}")
        if ds is None or not _known(at.run["scan"], ds):
            continue
        made = {key: make(at, one, loops) for key, one in cases(ds)}
        if any(frames is not None for row in made.values() for frames in row):
            maps.append({"name": name, "label": words, "over": over(ds), **_sheets(made)})
    return maps


def _known(scan: xr.Dataset, ds: xr.Dataset) -> bool:
    """Return whether the pair of bodies is known, without which nothing can be solved again."""
    return "pressure" in ds or "contact_modulus" in scan.coords or "contact_modulus" in ds.coords


def _without(at: Placed, one: xr.Dataset, loops: int) -> list[Frames | None]:
    """Return the maps of the direct simulation at all places, at the displacements that the run holds."""
    if "pressure" in one:
        return _kept(at, one)
    if "delta" not in one.dims:
        return [None] * at.size
    given = schema.arguments_of(one, "direct")
    how = {"datum": given.get("datum", "highest_peak"), "delta": one["delta"].values, "fields": True}
    scan, offset = with_pair(at.run["scan"], one), at.shift(one)

    def solved(k: int) -> Frames | None:
        return _frames(direct(scan, subregions=at.places.isel(subregion=[k]), **how).isel(subregion=0), offset[k])

    return _each(solved, range(at.size), at.size, "places without adhesion")


def _with_adhesion(at: Placed, one: xr.Dataset, loops: int) -> list[Frames | None]:
    """Return the maps along the loops of some places, followed with the run's own options."""
    if "pressure" in one:
        return _kept(at, one)
    none: list[Frames | None] = [None] * at.size
    if "preload_delta" not in one or "delta" in one.dims or float(one.coords.get("cycle", 1)) > 1 or loops == 0:
        return none
    scan, offset, given = with_pair(at.run["scan"], one), at.shift(one), schema.arguments_of(one, "adhesive")
    how = {"law": one.attrs["law"], "datum": one.attrs["datum"], "fields": True}
    step = given.get("mesh", {}).get("step", Mesh().step)

    def followed(k: int) -> Frames | None:
        place = one.isel(subregion=[k])
        delta = _along(place)
        if delta is None:
            return None
        loop = adhesive(scan, subregions=place, delta=delta, mesh=Mesh(int(place["refinement"][0]), None, step), **how)
        return _frames(loop.isel(subregion=0), offset[k]) if bool(loop["complete"][0]) else None

    some = regions.sample(at.places.assign_coords(order=("subregion", np.arange(len(none)))), loops)
    return _each(followed, some["order"].values.tolist(), at.size, "loops with adhesion")


def _along(place: xr.Dataset) -> np.ndarray | None:
    """Return displacements from loss of contact to the turning point, closer together where the force pulls."""
    ends = [float(place[name][0]) for name in ("detachment_delta", "preload_delta", "pull_off_delta")]
    if not np.all(np.isfinite(ends)) or ends[0] >= ends[1]:
        return None
    steps = ends[0] + (ends[1] - ends[0]) * np.linspace(0.0, 1.0, _STEPS) ** 2
    return np.unique(np.append(steps, np.clip(ends[2], ends[0], ends[1])))


def _each(solve: Callable, which: Sequence[int], count: int, what: str) -> list[Frames | None]:
    """Return the results of ``solve`` for some places, computed in parallel; None for the others."""
    bar = Progress(len(which), what=what)

    def told(k: int) -> Frames | None:
        frames = solve(k)
        bar.add()
        return frames

    # the run has given the same warnings, and the page shows its cautions
    made = quietly(dask.compute, *(dask.delayed(told, pure=False)(k) for k in which), scheduler="threads")
    bar.close()
    by_place = dict(zip(which, made))
    return [by_place.get(k) for k in range(count)]


def _kept(at: Placed, one: xr.Dataset) -> list[Frames | None]:
    """Return the maps that the archive holds."""
    offset = at.shift(one)
    return [_frames(one.isel(subregion=k).load(), offset[k]) for k in range(at.size)]


def _frames(one: xr.Dataset, offset: float) -> Frames | None:
    """Return the maps of one place, loading first, cropped to the tractions and thinned."""
    parts = list(_in_order(one))
    pressure = np.nan_to_num(
        np.concatenate([part["pressure"].transpose("delta", "x", "y").values for _, part in parts])
    )
    half = _half_width(pressure, one)
    if half is None:
        return None
    inside = [np.flatnonzero(np.abs(one[axis].values) <= half) for axis in "xy"]
    shown = images.thinned(pressure[:, inside[0][0] : inside[0][-1] + 1, inside[1][0] : inside[1][-1] + 1], _MOST_CELLS)
    box = [edge for axis, part in zip("xy", inside) for edge in images.edges(one[axis].values[part], _MOST_CELLS)]
    states = {name: np.concatenate([part[name].values for _, part in parts]) for name in ("force", "contact_area")}
    delta = np.concatenate([part["delta"].values for _, part in parts]) + offset
    branches = [way for way, part in parts for _ in range(part.sizes["delta"])]
    return Frames(branches, delta, states["force"], states["contact_area"], shown.astype(np.float32), box)


def _in_order(one: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield both branches in the order of the cycle, or the only one."""
    if "branch" not in one.dims:
        yield BRANCHES[0], one
        return
    yield BRANCHES[0], one.sel(branch=BRANCHES[0])
    yield BRANCHES[1], one.sel(branch=BRANCHES[1]).isel(delta=slice(None, None, -1))


def _half_width(pressure: np.ndarray, one: xr.Dataset) -> float | None:
    """Return the distance from the centre to which a map extends, nm; None where there is never any traction."""
    strongest = np.abs(pressure).max(axis=0)
    seen = np.argwhere(strongest > 0.02 * strongest.max())
    if strongest.max() == 0:
        return None
    reach = max(np.abs(one[axis].values[seen[:, k]]).max() for k, axis in enumerate("xy"))
    cell = float(one["x"][1] - one["x"][0]) if one.sizes["x"] > 1 else 1.0
    return _MARGIN * reach + 2 * cell


def _sheets(made: dict[str, list[Frames | None]]) -> dict[str, Any]:
    """Return the maps as pictures on one colour scale, and the tractions at its ends, GPa."""
    push = _strong([frames.pressure for row in made.values() for frames in row if frames is not None])
    pull = _strong([-frames.pressure for row in made.values() for frames in row if frames is not None])
    sheets = {key: [frames and _sheet(frames, pull, push) for frames in row] for key, row in made.items()}
    return {
        "pull": number(pull),
        "push": number(push),
        "colours": images.tractions_legend(pull, push),
        "sheets": sheets,
    }


def _strong(pressures: list[np.ndarray]) -> float:
    """Return the value below which all but a share of the positive values lie; 0 where there are none."""
    positive = np.concatenate([values[values > 0] for values in pressures])
    return float(np.quantile(positive, 1 - _CLIPPED_SHARE)) if positive.size else 0.0


def _sheet(frames: Frames, pull: float, push: float) -> dict[str, Any]:
    """Return the maps of one place, one below the other, x to the right and y upwards."""
    upright = frames.pressure[:, :, ::-1].transpose(0, 2, 1)
    indices = images.tractions_indices(upright, pull, push).reshape(-1, upright.shape[2])
    return {
        "picture": images.picture(indices, images.tractions_palette()),
        "columns": upright.shape[2],
        "rows": upright.shape[1],
        "box": numbers(np.array(frames.box)),
        "branch": frames.branches,
        "delta": numbers(frames.delta),
        "force": numbers(frames.force),
        "area": numbers(frames.area),
    }
