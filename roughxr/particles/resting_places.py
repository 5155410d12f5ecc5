"""`resting`: where particles lie still, the share of them that does so there, and the pass over which each leaves."""

from __future__ import annotations

from typing import Any, NamedTuple

import dask
import numpy as np
import xarray as xr

from ..asperity.catalogue import asperities
from ..asperity.moments import rolling
from ..kernels.topography import dilation, rests
from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.units import Places, Quantities, Quantity, magnitude, positive, single
from ..vocabulary.verbs import verb, warn
from .force_balance import critical_load
from .loads import weight

SETTLED = ("gravity", "adhesion")

#: Pixels along a side of a tile.
_TILE_SIDE = 512

#: Motion of the sphere, in pixels, within which a summit counts as carrying it.
_CARRYING_MOTION = 0.05

#: Pixels that rests may lie apart on a scan and on the vertices of its asperities.
_PAIRING_DISTANCE = 20.0

#: Stops on the way from where a sphere lands to where it rests, at each of which it may be held.
_STOPS = 12


class _Rests(NamedTuple):
    """Places of rest, numbered from 1 in ``labels``, and the passes between them."""

    places: np.ndarray  # (rests, 3): x, y, height, nm
    labels: np.ndarray  # of each pixel, 0 where the sphere rolls off the scan
    pairs: np.ndarray  # (passes, 2): labels on both sides
    passes: np.ndarray  # (passes, 3): x, y, height, nm


@verb
def resting(
    ds: xr.Dataset,
    *,
    settle: str = "gravity",
    least_barrier: Quantity = 0.001,
    landings: Places = None,
    on: xr.Dataset | None = None,
    particle_density: Quantity | None = None,
    friction_velocity: Quantities = 0.0,
) -> xr.Dataset:
    """Return where a sphere of the assigned radius comes to rest, with the share of spheres that do so at each place.

    Parameters
    ----------
    ds : Dataset
        A scan with an assigned sphere. A lazy one is read now; some 40 bytes to a pixel are held.
    settle : {"gravity", "adhesion"}
        "gravity": it rolls down to where its height is least. "adhesion": it stops on the way, or stays where it lands,
        as soon as the resisting moment of `rolling` exceeds that of its weight and of the flow.
    least_barrier : number or quantity
        nm; a rest whose lowest pass is less high above it counts as a part of the rest beyond that pass.
    landings : (int, int), optional
        Grid of places where spheres land: only what these reach is returned, with shares of their number. By default
        spheres land everywhere, and shares are those of the area; for "adhesion" on a grid of 16 × 16.
    on : Dataset, optional
        For "gravity": a catalogue of the scan's asperities. Each rest is then moved to the nearest one on
        their vertices, on which `rolling` and `superpose` put the sphere; where there is none near, it stays.
    particle_density : number or quantity
        For "adhesion": kg/m³.
    friction_velocity : number or quantity
        For "adhesion": of a flow while it settles, m/s, towards the weakest direction of each place.

    Returns
    -------
    Dataset
        Along ``subregion``, to be given to any verb as ``subregions``: coordinates ``subregion_x``, ``subregion_y``
        (nm) and ``landing_share``, their weight in all statistics; ``rest_height`` of the sphere's lowest point (nm),
        ``carriers``, the summits that it stands on (at most 8), and ``carrier_x``, ``carrier_y`` of each (nm). With
        "gravity" also ``barrier``, the height of the lowest pass over the rest (nm), ``pass_x``, ``pass_y`` (nm),
        ``pass_to``, the rest beyond it, −1 off the scan; and ``truncated``, where the basin or the sphere over its
        carriers reaches the scan's edge. With "adhesion" ``at_bottom``, whether the place is one of "gravity". The
        attribute ``share_off_scan`` is the share of the area from which a sphere rolls off the scan. Empty, with a
        warning, where there is no rest at all.

    Raises
    ------
    ValueError
        If no sphere is assigned, pixels are missing, an option is out of its range, or a density is missing.

    Notes
    -----
    Bodies are rigid here, and roll without slip or inertia. Between pixels the surface is the paraboloid through nine
    of them.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> places = resting(scan)
    >>> bool((places.carriers >= 3).mean() > 0.9), round(float(places.landing_share.sum()), 6)
    (True, 1.0)
    >>> roughxr.rolling(scan, directions=8, subregions=places.isel(subregion=[0, 1])).sizes["subregion"]
    2
    """
    scan = schema.validate(ds, "scan")
    schema.one_of(settle, SETTLED, "settle")
    (radius,) = schema.pair(scan, "sphere_radius")
    words = "a height in nm of at least 0"
    shallow = single(least_barrier, "nm", "least_barrier", words, lambda barrier: barrier >= 0)
    flown = {"particle_density": particle_density, "friction_velocity": friction_velocity or None}
    summits = {"on": None if on is None else "asperities"}
    schema.refuse_unused(f"settle={settle!r}", **(summits if settle == "adhesion" else flown))
    given: dict[str, Any] = {"settle": settle, "least_barrier": shallow, **summits}
    z, ground = _ground(scan, radius)
    settled = _settled(z, ground, shallow)
    if settle == "adhesion":
        landings = landings or (16, 16)
        given |= {"particle_density": particle_density, "friction_velocity": friction_velocity}
        out = _held_on_the_way(scan, (z, ground), settled, landings, particle_density, friction_velocity)
    else:
        out = _at_the_bottom(scan, ground, settled)
        if landings is not None:
            out = _reached(out, [label for _, label in _ways_down(scan, z, ground, settled, landings)])
        if on is not None:
            out = _on_vertices(out, schema.validate(on, "asperities"), ground)
    out = out.assign_coords(schema.travelling(scan))
    off = float(rests.areas(settled.labels, len(settled.places) + 1)[rests.OFF]) / settled.labels.size
    out.attrs = {"settle": settle, "share_off_scan": off}
    if out.sizes["subregion"] == 0:
        out.attrs["missing"] = "no place of rest: from every pixel the sphere rolls off the scan"
        warn(out.attrs["missing"])
    if landings is not None:
        out.attrs["landings"] = np.asarray(landings, dtype=int).tolist()
    return schema.record(schema.label(out), "resting", scan, **given, landings=landings)


def is_rests(places: Any) -> bool:
    """Return whether places are rests by gravity, with their passes, reached from a grid of landings."""
    return isinstance(places, xr.Dataset) and "pass_x" in places and "landings" in places.attrs


def _ground(scan: xr.Dataset, radius: float) -> tuple[np.ndarray, rests.Ground]:
    """Return the height (nm) of a sphere's lowest point over a scan, and what it may touch, tile by tile."""
    height, pixel = _heights(scan["height"]), schema.pixel(scan)
    low, high = float(height.min()), float(height.max())
    if not np.isfinite(high - low):
        schema.none_missing(int((~np.isfinite(height)).sum()), height.size)
    x, y = (scan[axis].values.astype(float) for axis in "xy")
    ball = dilation.Ball(radius, 0.5 * pixel[0], 0.5 * pixel[1])
    reach = dilation.reach_of(radius, high - low)
    z, bounds = np.empty(height.shape), np.empty((*(-(-n // dilation.SIDE) for n in height.shape), 2), np.int64)
    lists, listed = np.empty(0, np.int32), 0
    tile = dask.delayed(_tile, pure=False, traverse=False)
    for row in range(
        0, height.shape[0], _TILE_SIDE
    ):  # a row of tiles at a time, so that little waits to be put together
        parts = [_part((row, column), height.shape, pixel, reach) for column in range(0, height.shape[1], _TILE_SIDE)]
        todo = [tile(height[outer], x[outer[0]], y[outer[1]], inner, outer, ball, reach) for inner, outer in parts]
        for (inner, outer), (z[inner], edges, pixels) in zip(parts, dask.compute(*todo)):
            boxes = tuple(slice(s.start // dilation.SIDE, -(-s.stop // dilation.SIDE)) for s in inner)
            bounds[boxes] = edges + listed
            listed += pixels.size
            if listed > lists.size:
                lists.resize(int(1.2 * listed), refcheck=False)  # in place: no second copy is made
            i, j = np.divmod(pixels, outer[1].stop - outer[1].start)
            lists[listed - pixels.size : listed] = (i + outer[0].start) * height.shape[1] + j + outer[1].start
    first = float(x[0]), float(y[0])
    return z, rests.Ground(height, bounds, lists, first, pixel, ball)


def _heights(height: xr.DataArray) -> np.ndarray:
    """Return heights in memory; lazy ones a row of chunks at a time, so that they are not held twice."""
    if height.chunks is None:
        return np.ascontiguousarray(height.values, dtype=float)
    out, stop = np.empty(height.shape), 0
    for rows in height.chunks[0]:
        start, stop = stop, stop + rows
        out[start:stop] = height[start:stop].values
    return out


def _part(corner: tuple[int, int], shape: tuple[int, int], pixel: tuple, reach: float) -> tuple[tuple, tuple]:
    """Return the pixels of a tile, and those around it that a sphere over it may touch."""
    inner = tuple(slice(k, min(k + _TILE_SIDE, n)) for k, n in zip(corner, shape))
    halo = [int(np.ceil(reach / step)) + dilation.FARTHEST + 1 for step in pixel]
    outer = tuple(slice(max(s.start - m, 0), min(s.stop + m, n)) for s, m, n in zip(inner, halo, shape))
    return inner, outer


def _tile(height, x, y, inner, outer, ball, reach) -> tuple[np.ndarray, ...]:
    """Return the sphere's heights over a tile, and the lists of what it may touch, as pixels of the heights."""
    pixel = 2 * ball.half_x, 2 * ball.half_y
    patches, chosen = dilation.patches(np.ascontiguousarray(height), x, y, pixel, ball.radius, reach)
    own = tuple(slice(one.start - all_.start, one.stop - all_.start) for one, all_ in zip(inner, outer))
    z, bounds, lists = dilation.dilation(patches, x[own[0]], y[own[1]], ball)
    return z, bounds, chosen.astype(np.int32)[lists]


def _settled(z: np.ndarray, ground: rests.Ground, shallow: float) -> _Rests:
    """Return the places of rest, with those behind too low a barrier joined to the next."""
    labels, minima = rests.basins(z, ground.pixel)
    places, to = _rolled(ground, labels, minima)
    _relabel(labels, to)
    pairs, pixels = _borders(z, labels)
    passes = rests.passes(z, pixels, ground)
    to = _joined(pairs, passes[:, 2], places[:, 2], shallow)
    kept = np.unique(to[np.flatnonzero(rests.areas(labels, len(to)))])
    kept = kept[kept != rests.OFF]
    number = np.zeros(len(to), np.int64)
    number[kept] = np.arange(1, kept.size + 1)
    _relabel(labels, number[to])
    pairs = number[to[pairs]]
    between = pairs[:, 0] != pairs[:, 1]
    pairs, chosen = _lowest(np.sort(pairs[between], axis=1), passes[between, 2], np.flatnonzero(between))
    return _Rests(places[kept], labels, pairs, passes[chosen])


def _rolled(ground: rests.Ground, labels: np.ndarray, minima: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return where spheres rest that roll from each minimum, and of each label that of the basin where it then is."""
    pixels = np.column_stack(np.unravel_index(minima, labels.shape))
    start = np.array(ground.first) + pixels * np.array(ground.pixel)
    rolled = rests.settle(ground, labels, start, np.arange(1, minima.size + 1, dtype=np.int32))
    places = np.concatenate([[[np.nan, np.nan, np.inf]], rolled[:, :3]])
    to = np.append(rests.OFF, rolled[:, 3].astype(np.int64))
    lowest = [ring[np.argmin(places[ring, 2])] for ring in _rings(to)]
    to[lowest] = lowest  # in a ring each rolls into the next one's basin: they rest at one place, on a border of theirs
    rolled = rests.settle(ground, labels, places[lowest, :2], np.zeros(len(lowest), np.int32))
    for k, (*place, label) in zip(lowest, rolled):
        places[k] = place
        if _root(to, int(label)) != k:
            to[k] = int(label)
    return places, _ends(to)


def _rings(to: np.ndarray) -> list[list[int]]:
    """Return the rings into which chains of labels lead."""
    end = to
    for _ in range(int(to.size).bit_length()):
        end = end[end]
    rings, seen = [], set()
    for first in np.unique(end[to[end] != end]).tolist():
        ring = []
        while first not in seen:
            seen.add(first)
            ring.append(first)
            first = int(to[first])
        rings += [ring] if ring else []
    return rings


def _borders(z: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of basins that touch, and the lowest pixel of the border of each; strip by strip."""
    strips = []
    for start in range(0, len(z), _TILE_SIDE // 2):
        pairs, heights = rests.borders(z, labels, start, start + _TILE_SIDE // 2)
        strips.append(_lowest(pairs[:, :2], heights, pairs[:, 2]))
    pairs, pixels = (np.concatenate(parts) for parts in zip(*strips))
    return _lowest(pairs, z.ravel()[pixels], pixels)


def _ends(to: np.ndarray) -> np.ndarray:
    """Return where chains of basins end."""
    while (to[to] != to).any():
        to = to[to]
    return to


def _relabel(labels: np.ndarray, to: np.ndarray) -> None:
    """Replace labels in place, row by row, so that no second map is needed."""
    for row in labels:
        row[:] = to[row]


def _lowest(pairs: np.ndarray, heights: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the different pairs, and of each the value where its height is least."""
    order = np.lexsort((heights, pairs[:, 1], pairs[:, 0]))
    pairs = pairs[order]
    first = np.ones(len(pairs), bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    return pairs[first], values[order][first]


def _joined(pairs: np.ndarray, heights: np.ndarray, lowest: np.ndarray, shallow: float) -> np.ndarray:
    """Return the label of the deepest rest that each can reach over barriers lower than ``shallow`` (nm)."""
    to = np.arange(lowest.size)
    for k in np.argsort(heights):
        a, b = (_root(to, label) for label in pairs[k])
        if a == b:
            continue
        deep, other = (a, b) if lowest[a] <= lowest[b] else (b, a)
        if rests.OFF in (a, b):
            deep, other = rests.OFF, max(a, b)
        if heights[k] - lowest[other] < shallow:
            to[other] = deep
    return _ends(to)


def _root(to: np.ndarray, label: int) -> int:
    while to[label] != label:
        to[label] = to[to[label]]
        label = to[label]
    return int(label)


def _placed(x: np.ndarray, y: np.ndarray, share: np.ndarray) -> xr.Dataset:
    """Return places and their weights as coordinates."""
    places = {"subregion_x": x, "subregion_y": y, "landing_share": share}
    along = {name: ("subregion", values) for name, values in places.items()}
    return xr.Dataset(coords={"subregion": np.arange(x.size), **along})


def _carried(out: xr.Dataset, ground: rests.Ground, places: np.ndarray) -> xr.Dataset:
    """Add what carries the sphere."""
    number, at = rests.carriers(places, ground, _CARRYING_MOTION)
    at = at[:, : max(int(number.max(initial=0)), 1)]
    out = out.assign(rest_height=("subregion", places[:, 2]), carriers=("subregion", number))
    return out.assign({f"carrier_{axis}": (("subregion", "carrier"), at[:, :, k]) for k, axis in enumerate("xy")})


def _at_the_bottom(scan: xr.Dataset, ground: rests.Ground, settled: _Rests) -> xr.Dataset:
    """Return all places of rest with their lowest passes."""
    count = len(settled.places)
    area = rests.areas(settled.labels, count + 1)[1:]
    x, y = settled.places.T[:2]
    out = _placed(x, y, area / max(area.sum(), 1))
    out = _carried(out, ground, settled.places)
    lowest = np.full((count, 4), np.nan)
    lowest[:, 3] = -1
    here, there = np.concatenate([settled.pairs, settled.pairs[:, ::-1]]).T
    order = np.lexsort((np.tile(settled.passes[:, 2], 2), here))
    which, first = np.unique(here[order], return_index=True)
    of = order[first[which != rests.OFF]]  # the lowest of each rest
    lowest[here[of] - 1] = np.column_stack([settled.passes[of % len(settled.pairs)], there[of] - 1])
    out["barrier"] = "subregion", lowest[:, 2] - settled.places[:, 2]
    for k, axis in enumerate("xy"):
        out[f"pass_{axis}"] = "subregion", lowest[:, k]
    out["pass_to"] = "subregion", lowest[:, 3].astype(int)
    rim = np.concatenate([settled.labels[[0, -1]].ravel(), settled.labels[:, [0, -1]].ravel()])
    touches = np.isin(np.arange(1, count + 1), rim)
    return out.assign(truncated=("subregion", touches | _beyond_edge(scan, out)))


def _on_vertices(out: xr.Dataset, catalogue: xr.Dataset, ground: rests.Ground) -> xr.Dataset:
    """Return rests moved to the nearest on the vertices of asperities."""
    summits = catalogue.isel(asperity=(catalogue["curvature_min"] > 0).values)
    rows = np.zeros((summits.sizes["asperity"], dilation.RISE + 1))
    for column, name in ((dilation.X, "x"), (dilation.Y, "y"), (dilation.H, "height")):
        rows[:, column] = summits[name].values
    places = np.column_stack([out["subregion_x"].values, out["subregion_y"].values])
    points, largest = dilation.Ball(ground.ball.radius, 0.0, 0.0), max(ground.pixel)
    farthest = _PAIRING_DISTANCE * largest
    moved = rests.settle_near(rows, places, points, largest, farthest)
    last = np.array(ground.first) + np.array(ground.pixel) * (np.array(ground.height.shape) - 1)
    outside = (moved[:, :2] < ground.first) | (moved[:, :2] > last) | (np.abs(moved[:, :2] - places) > 0.5 * farthest)
    stays = outside.any(axis=1)  # no rest on vertices is near
    moved[stays] = np.column_stack([places, out["rest_height"].values])[stays]
    out = out.assign_coords({f"subregion_{axis}": ("subregion", moved[:, k]) for k, axis in enumerate("xy")})
    return out.assign(rest_height=("subregion", moved[:, 2]))


def _reached(out: xr.Dataset, labels: list[int]) -> xr.Dataset:
    """Return the rests that some landings reach, with shares of their number; numbers stay those of all rests."""
    rest, count = np.unique(np.array(labels, int) - 1, return_counts=True)
    return out.isel(subregion=rest).assign_coords(landing_share=("subregion", count / max(count.sum(), 1)))


def _beyond_edge(scan: xr.Dataset, out: xr.Dataset) -> np.ndarray:
    """Return where the sphere over its carriers reaches beyond the scan."""
    x_low, x_high, y_low, y_high = regions.extent(scan)
    x, y = out["subregion_x"].values, out["subregion_y"].values
    off = np.min([x - x_low, x_high - x, y - y_low, y_high - y], axis=0, initial=np.inf)
    far = np.hypot(out["carrier_x"].values - x[:, None], out["carrier_y"].values - y[:, None])
    return off < np.nan_to_num(far).max(axis=1, initial=0.0)


def _held_on_the_way(scan, over, settled, landings, density, speed) -> xr.Dataset:
    """Return where spheres that land on a grid are held, on their way down or at the bottom, with their shares."""
    if density is None:
        raise ValueError("particle_density: expected a density in kg/m³ for settle='adhesion', found none")
    speed = float(magnitude(speed, "m s-1", "friction_velocity"))
    (radius,) = schema.pair(scan, "sphere_radius")
    load = float(weight(radius, positive(density, "kg m-3", "particle_density")))
    catalogue = asperities(scan)
    z, ground = over
    ways = _ways_down(scan, z, ground, settled, landings)
    at, stops = np.array([way[0] for way, _ in ways]).reshape(-1, 2), np.zeros(len(ways), int)
    rolls = np.ones(len(ways), bool)
    for stop in range(_STOPS):
        if not rolls.any():
            break
        held = rolling(catalogue, directions=12, load=load, subregions=tuple(at[rolls].T))
        given = {"particle_density": density, "direction": "weakest"}
        held = critical_load(held, **given)["critical_friction_velocity"].values > speed
        rolls[np.flatnonzero(rolls)[held]] = False
        for k in np.flatnonzero(rolls):
            way = ways[k][0]
            stops[k] = min(-(-(stop + 1) * (len(way) - 1) // _STOPS), len(way) - 1)
            at[k] = way[stops[k]]
    bottom = np.array([(n == len(way) - 1) for n, (way, _) in zip(stops, ways)], bool)
    rest = np.array([label for _, label in ways], int)
    which = np.where(bottom, rest, -1 - np.arange(len(ways)))  # all that reach one bottom are one place
    _, first, count = np.unique(which, return_index=True, return_counts=True)
    order = np.argsort(first)
    first, count = first[order], count[order]
    x, y = at[first].T
    out = _placed(x, y, count / max(count.sum(), 1))
    out = _carried(out, ground, np.column_stack([at[first], rests.heights(at[first], ground)]))
    return out.assign(at_bottom=("subregion", bottom[first]))


def _ways_down(
    scan: xr.Dataset, z: np.ndarray, ground: rests.Ground, settled: _Rests, landings: Any
) -> list[tuple[np.ndarray, int]]:
    """Return for each landing that comes to rest its way down, pixel by pixel and to the rest itself, and the rest."""
    grid = regions.centres(scan, landings)
    ways = []
    for place in zip(grid["subregion_x"].values, grid["subregion_y"].values):
        i, j = (
            int(np.clip(round((v - first) / step), 0, n - 1))
            for v, first, step, n in zip(place, ground.first, ground.pixel, z.shape)
        )
        label = int(settled.labels[i, j])
        if label == rests.OFF:
            continue
        pixels = rests.way_down(z, i, j, ground.pixel)
        along = np.array(ground.first) + pixels[1:] * np.array(ground.pixel)
        ways.append((np.concatenate([[place], along, settled.places[label - 1 : label, :2]]), label))
    return ways
