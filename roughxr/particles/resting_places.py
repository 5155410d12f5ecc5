"""`resting`: resting positions, the share of particles at each, and the lowest saddle for escape."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.spatial import cKDTree

from ..jobs.spread import task_results
from ..kernels.topography import basins, dilation
from ..kernels.topography.interpolation import band_limited
from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.text import warn
from ..vocabulary.units import Places

#: Motion of the sphere, in pixels, within which a summit counts as a support.
_CARRYING_MOTION = 0.05

#: Resting positions closer than this (pixels) are merged.
_EQUAL_POSITIONS = 0.05

#: Pixels count as equally low within this share of the range of the sphere's heights.
_EQUAL_HEIGHTS = 1e-9

#: Cells along a side of a pixel; heights are interpolated as in the simulations.
_REFINE = 2

#: Least resolved barrier, in pixel²/R: the rise of the sphere's front over about one pixel.
_RESOLVED_BARRIER = 0.01

#: Borders between basins whose passes one task computes.
_BORDERS = 64

#: Largest distance (cells) between a resting position and the one on the vertices of asperities.
_PAIRING_DISTANCE = 40.0


class _RestingPositions(NamedTuple):
    """Resting positions, numbered from 1 in ``labels``, and the passes between them."""

    places: np.ndarray  # (rests, 3): x, y, height, nm
    labels: np.ndarray  # of each pixel, 0 where the sphere rolls off the scan
    pairs: np.ndarray  # (passes, 2): labels on both sides
    passes: np.ndarray  # (passes, 3): x, y, height, nm


def resting(
    ds: xr.Dataset,
    *,
    landings: Places = None,
    on: xr.Dataset | None = None,
) -> xr.Dataset:
    """Return the resting positions of a sphere of the assigned radius, with the share of spheres at each.

    Parameters
    ----------
    ds : Dataset
        A scan with an assigned sphere, loaded now. Needs some 130 bytes of memory a pixel.
    landings : (int, int), optional
        Grid of landing places: return only the positions reached from there, with shares of their number. By default
        spheres land everywhere, and shares are of the area.
    on : Dataset, optional
        A catalogue of the scan's asperities. Each resting position is then moved to the nearest resting position on
        their vertices, where `rolling` and `superpose` put the sphere, if there is one near.

    Returns
    -------
    Dataset
        Along ``subregion``, to be passed to any verb as ``subregions``: coordinates ``subregion_x``, ``subregion_y``
        (nm) and ``landing_share``, their weight in all statistics; ``rest_height`` of the sphere's lowest point (nm),
        ``supports``, the number of supporting summits (at most 8), and ``support_x``, ``support_y`` of each (nm);
        ``barrier``, the height of the lowest pass over the resting position (nm), ``pass_x``, ``pass_y`` (nm),
        ``pass_to``, the position beyond it, −1 off the scan; and ``truncated``, where the basin or the sphere over its
        supports reaches the scan's edge. The attribute ``share_off_scan`` is the share of the area from which a sphere
        rolls off the scan. Empty, with a warning, where there is no resting position.

    Notes
    -----
    Bodies are rigid here, and the sphere rolls down without slip, inertia or adhesion. Heights between pixels are
    interpolated as in the simulations, without wavelengths shorter than two pixels.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> places = scan.contact.resting()
    >>> bool((places.supports >= 3).mean() > 0.9), round(float(places.landing_share.sum()), 6)
    (True, 1.0)
    >>> roughxr.rolling(scan, directions=8, subregions=places.isel(subregion=[0, 1])).sizes["subregion"]
    2
    """
    scan = schema.validate(ds, "scan")
    z, surface = _dilated_surface(scan, schema.sphere_radius(scan))
    settled = _resting_positions(z, surface)
    out = _with_barriers(scan, surface, settled)
    if landings is not None:
        rest, count = np.unique(_landing_basins(scan, surface, settled, landings).astype(int) - 1, return_counts=True)
        share = "subregion", count / max(count.sum(), 1)
        out = out.isel(subregion=rest).assign_coords(landing_share=share)  # labels stay those of all resting positions
    if on is not None:
        out = _move_to_vertices(out, schema.validate(on, "asperities"), surface)
    out = out.assign_coords(schema.pair_coordinates(scan))
    off = float((settled.labels == basins.OFF).mean())
    out.attrs = {"share_off_scan": off}
    if out.sizes["subregion"] == 0:
        out.attrs["missing"] = "no resting position: from every pixel the sphere rolls off the scan"
        warn(out.attrs["missing"])
    if landings is not None:
        out.attrs["landings"] = int(regions.centres(scan, landings).sizes["subregion"])
    return schema.record(schema.label(out), "resting", scan, landings=landings, on=None if on is None else "asperities")


def are_resting_positions(places: Any) -> bool:
    """Return whether places are resting positions, with their passes, reached from a grid of landings."""
    return isinstance(places, xr.Dataset) and "pass_x" in places and "landings" in places.attrs


def resettled(ds: xr.Dataset, places: xr.Dataset) -> xr.Dataset:
    """Return the places to which the sphere of this pair rolls from former resting positions, NaN off the scan."""
    scan = schema.validate(ds, "scan")
    _, surface = _dilated_surface(scan, schema.sphere_radius(scan))
    former = np.stack([places["subregion_x"].values, places["subregion_y"].values], axis=-1)
    x, y, _ = basins.settle(surface, former).T
    return places.assign_coords(subregion_x=("subregion", x), subregion_y=("subregion", y))


def _dilated_surface(scan: xr.Dataset, radius: float) -> tuple[np.ndarray, basins.DilatedSurface]:
    """Return the height (nm) of a sphere's lowest point over a scan on finer cells, and the surface it may touch."""
    height = schema.finite(scan["height"].values)
    cells = (np.arange(_REFINE) + 0.5) / _REFINE - 0.5
    height = band_limited(height, _REFINE)
    x, y = (
        (scan[axis].values.astype(float)[:, None] + pixel * cells).ravel()
        for axis, pixel in zip("xy", schema.pixel(scan))
    )
    pixel = float(x[1] - x[0]), float(y[1] - y[0])
    ball = dilation.Ball(radius, 0.5 * pixel[0], 0.5 * pixel[1])
    reach = dilation.contact_distance(radius, float(np.ptp(height)))
    patches, pixels = dilation.patches(height, x, y, pixel, radius, reach)
    z, bounds, lists = dilation.dilation(patches, x, y, ball)
    lists = pixels.astype(np.int32)[lists]
    return z, basins.DilatedSurface(height, bounds, lists, (float(x[0]), float(y[0])), pixel, ball)


def _resting_positions(z: np.ndarray, surface: basins.DilatedSurface) -> _RestingPositions:
    """Return the resting positions; merge those with barriers below the pixels' resolution."""
    shallow = _RESOLVED_BARRIER * max(surface.pixel) ** 2 / surface.ball.radius
    labels, minima = basins.drainage_basins(z, surface.pixel)
    places, to = _rolled(surface, minima)
    _relabel(labels, to)
    _claim_own_pixels(labels, places, to, surface)
    pairs, pixels = _borders(z, labels)
    passes = _passes(z, labels, pairs, pixels, places[:, 2], surface)
    to = _merged_basins(pairs, passes[:, 2], places[:, 2], shallow)
    reached = np.unique(to[np.unique(labels)])
    reached = reached[reached != basins.OFF]
    number = np.zeros(len(to), np.int64)
    number[reached] = np.arange(1, reached.size + 1)
    _relabel(labels, number[to])
    pairs = number[to[pairs]]
    between = pairs[:, 0] != pairs[:, 1]
    pairs, chosen = _lowest_passes(np.sort(pairs[between], axis=1), passes[between, 2], np.flatnonzero(between))
    return _RestingPositions(places[reached], labels, pairs, passes[chosen])


def _rolled(surface: basins.DilatedSurface, minima: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return each minimum's resting position, and the first label with that position.

    Entries begin at the label `basins.OFF`, whose position is infinitely high.
    """
    rolled = basins.settle(surface, np.array(surface.first) + minima * np.array(surface.pixel))
    to = np.arange(len(minima) + 1)
    off = np.isnan(rolled[:, 2])
    to[1:][off] = basins.OFF
    on_scan = np.flatnonzero(~off)
    equal = cKDTree(rolled[on_scan, :2]).query_pairs(_EQUAL_POSITIONS * max(surface.pixel)) if on_scan.size else ()
    for a, b in equal:
        first, second = sorted(_root(to, int(on_scan[k]) + 1) for k in (a, b))
        to[second] = first
    return np.concatenate([[[np.nan, np.nan, np.inf]], rolled]), _chain_ends(to)


def _claim_own_pixels(labels: np.ndarray, places: np.ndarray, to: np.ndarray, surface: basins.DilatedSurface) -> None:
    """Label the pixel of each resting position by that position: the sphere may have come from another basin."""
    labels_there = np.unique(to)
    labels_there = labels_there[labels_there != basins.OFF]
    i, j = np.round((places[labels_there, :2] - surface.first) / surface.pixel).astype(int).T
    order = np.argsort(-places[labels_there, 2])  # the lowest one of a pixel last
    labels[i[order], j[order]] = labels_there[order]


def _borders(z: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of basins that touch, and the lowest pixels of the border of each.

    Over a summit at the scan's edge pixels on both sides are equally low: all of them are returned.
    """
    equal = _EQUAL_HEIGHTS * float(np.ptp(z))
    (nx, ny) = z.shape
    flat = np.arange(z.size).reshape(z.shape)
    parts = []
    for i, j in ((1, 0), (0, 1), (1, 1), (1, -1)):
        cells = slice(0, nx - i), slice(max(-j, 0), ny - max(j, 0))
        others = slice(i, nx), slice(max(j, 0), ny - max(-j, 0))
        for first, second in ((cells, others), (others, cells)):
            higher = (labels[first] != labels[second]) & (z[first] >= z[second] - equal)  # both where they are equal
            a = labels[first][higher]
            b = labels[second][higher]
            parts.append(np.stack([np.minimum(a, b), np.maximum(a, b), flat[first][higher]], axis=-1))
    pairs = np.concatenate(parts)
    pairs = _lowest_rows(pairs, z.ravel()[pairs[:, 2]], equal)
    return pairs[:, :2], pairs[:, 2]


def _passes(
    z: np.ndarray,
    labels: np.ndarray,
    pairs: np.ndarray,
    pixels: np.ndarray,
    heights: np.ndarray,
    surface: basins.DilatedSurface,
) -> np.ndarray:
    """Return x, y and height (nm) of the pass on each border, computed in tasks of equal size."""
    if not len(pixels):
        return np.zeros((0, 3))
    rows = np.resize(np.arange(len(pixels)), (-(-len(pixels) // _BORDERS), _BORDERS))  # the last repeats the first
    tasks = [(pairs[row], pixels[row]) for row in rows]
    shape = (_BORDERS, 3)
    passes = task_results(_passes_of, tasks, shape, z, labels, heights, surface, each=_BORDERS, name="resting")
    return passes.reshape(-1, 3)[: len(pixels)]


def _passes_of(
    pairs: np.ndarray,
    pixels: np.ndarray,
    z: np.ndarray,
    labels: np.ndarray,
    heights: np.ndarray,
    surface: basins.DilatedSurface,
) -> np.ndarray:
    return basins.passes(z, labels, pairs, pixels, heights, surface)


def _lowest_rows(pairs: np.ndarray, heights: np.ndarray, equal: float) -> np.ndarray:
    """Return the rows (label, label, pixel) of each pair of labels with the least height."""
    pairs, first = np.unique(pairs, axis=0, return_index=True)
    if not len(pairs):
        return pairs
    new = np.r_[True, (pairs[1:, :2] != pairs[:-1, :2]).any(axis=1)]
    least = np.minimum.reduceat(heights[first], np.flatnonzero(new))
    return pairs[heights[first] <= least[np.cumsum(new) - 1] + equal]


def _chain_ends(to: np.ndarray) -> np.ndarray:
    """Follow chains of labels to their ends."""
    while (to[to] != to).any():
        to = to[to]
    return to


def _relabel(labels: np.ndarray, to: np.ndarray) -> None:
    """Replace labels in place, row by row to save memory."""
    for row in labels:
        row[:] = to[row]


def _lowest_passes(pairs: np.ndarray, heights: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the distinct pairs, each with the value at its lowest pass."""
    order = np.lexsort((heights, pairs[:, 1], pairs[:, 0]))
    pairs = pairs[order]
    first = np.ones(len(pairs), bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    return pairs[first], values[order][first]


def _merged_basins(pairs: np.ndarray, heights: np.ndarray, lowest: np.ndarray, shallow: float) -> np.ndarray:
    """Return for each label the deepest basin that barriers lower than ``shallow`` (nm) lead to."""
    to = np.arange(lowest.size)
    for k in np.argsort(heights):
        a, b = (_root(to, label) for label in pairs[k])
        if a == b:
            continue
        deep, other = (a, b) if lowest[a] <= lowest[b] else (b, a)
        if basins.OFF in (a, b):
            deep = basins.OFF
            other = max(a, b)
        if heights[k] - lowest[other] < shallow:
            to[other] = deep
    return _chain_ends(to)


def _root(to: np.ndarray, label: int) -> int:
    while to[label] != label:
        to[label] = to[to[label]]
        label = to[label]
    return int(label)


def _with_barriers(scan: xr.Dataset, surface: basins.DilatedSurface, settled: _RestingPositions) -> xr.Dataset:
    """Return all resting positions with their lowest saddles."""
    count = len(settled.places)
    area = np.bincount(settled.labels.ravel(), minlength=count + 1)[1:]
    x, y = settled.places.T[:2]
    places = {"subregion_x": x, "subregion_y": y, "landing_share": area / max(area.sum(), 1)}
    out = xr.Dataset(coords={"subregion": np.arange(x.size), **{n: ("subregion", v) for n, v in places.items()}})
    number, at = basins.supports(settled.places, surface, _CARRYING_MOTION)
    at = at[:, : max(int(number.max(initial=0)), 1)]
    out = out.assign(rest_height=("subregion", settled.places[:, 2]), supports=("subregion", number))
    out = out.assign({f"support_{axis}": (("subregion", "support"), at[:, :, k]) for k, axis in enumerate("xy")})
    lowest = np.full((count, 4), np.nan)
    lowest[:, 3] = -1
    source, target = np.concatenate([settled.pairs, settled.pairs[:, ::-1]]).T
    order = np.lexsort((np.tile(settled.passes[:, 2], 2), source))
    which, first = np.unique(source[order], return_index=True)
    lowest_pass = order[first[which != basins.OFF]]  # of each resting position
    passes = settled.passes[lowest_pass % len(settled.pairs)]
    lowest[source[lowest_pass] - 1] = np.column_stack([passes, target[lowest_pass] - 1])
    out["barrier"] = "subregion", lowest[:, 2] - settled.places[:, 2]
    for k, axis in enumerate("xy"):
        out[f"pass_{axis}"] = "subregion", lowest[:, k]
    out["pass_to"] = "subregion", lowest[:, 3].astype(int)
    rim = np.concatenate([settled.labels[[0, -1]].ravel(), settled.labels[:, [0, -1]].ravel()])
    touches = np.isin(np.arange(1, count + 1), rim)
    x_low, x_high, y_low, y_high = regions.extent(scan)
    off = np.min([x - x_low, x_high - x, y - y_low, y_high - y], axis=0, initial=np.inf)
    far = np.nan_to_num(np.hypot(at[:, :, 0] - x[:, None], at[:, :, 1] - y[:, None])).max(axis=1, initial=0.0)
    return out.assign(truncated=("subregion", touches | (off < far)))


def _move_to_vertices(out: xr.Dataset, catalogue: xr.Dataset, surface: basins.DilatedSurface) -> xr.Dataset:
    """Move resting positions to the nearest resting positions on the vertices of asperities."""
    summits = catalogue.isel(asperity=(catalogue["curvature_min"] > 0).values)
    rows = np.zeros((summits.sizes["asperity"], dilation.RISE + 1))
    for column, name in ((dilation.X, "x"), (dilation.Y, "y"), (dilation.H, "height")):
        rows[:, column] = summits[name].values
    places = np.column_stack([out["subregion_x"].values, out["subregion_y"].values])
    points = dilation.Ball(surface.ball.radius, 0.0, 0.0)
    largest = max(surface.pixel)
    farthest = _PAIRING_DISTANCE * largest
    moved = basins.settle_near(rows, places, points, largest, farthest)
    last = np.array(surface.first) + np.array(surface.pixel) * (np.array(surface.height.shape) - 1)
    outside = (moved[:, :2] < surface.first) | (moved[:, :2] > last) | (np.abs(moved[:, :2] - places) > 0.5 * farthest)
    stays = outside.any(axis=1)  # no resting position on vertices is near
    moved[stays] = np.column_stack([places, out["rest_height"].values])[stays]
    out = out.assign_coords({f"subregion_{axis}": ("subregion", moved[:, k]) for k, axis in enumerate("xy")})
    return out.assign(rest_height=("subregion", moved[:, 2]))


def _landing_basins(
    scan: xr.Dataset, surface: basins.DilatedSurface, settled: _RestingPositions, landings: Any
) -> np.ndarray:
    """Return the labels of the basins in which spheres land on a grid, without those that roll off the scan."""
    grid = regions.centres(scan, landings)
    axes = zip("xy", surface.first, surface.pixel, settled.labels.shape)
    i, j = (
        np.clip(np.round((grid[f"subregion_{axis}"].values - first) / step).astype(int), 0, n - 1)
        for axis, first, step, n in axes
    )
    labels = settled.labels[i, j]
    return labels[labels != basins.OFF]
