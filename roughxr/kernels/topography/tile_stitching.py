"""Tile stitching: the peaks of a scan that is read tile by tile, each tile once, exactly as for the scan in one piece.

Plateaus (``peaks``) that end within a tile are decided there. Seams are the borders between tiles. For plateaus that
reach a seam, a tile keeps three things, small compared with its heights:

rims      the k − 1 outermost lines at each seam. Beside the neighbour's rim they hold every patch of k by k pixels
          that reaches across the seam.
open      plateaus that reach a seam and have no higher neighbour within the tile: their pixels (one bit each), and the
          sums of coordinates that give the centroid.
around    the heights within k // 2 pixels of open plateaus, where the patch of a stitched plateau may lie.

Across a seam, open plateaus of one height that touch are one plateau. A plateau is a peak unless a pixel beside it,
in any tile, is higher, or belongs to a part of the same plateau that is no peak. It may extend over any number of
tiles. The result and its order are those of the scan in one piece, a single tile without seams. Source: own.

Where a tile is searched on finer pixels, its heights are interpolated by splines through it and ``HALO`` pixels around
it: what lies further out has an effect of less than 0.27^HALO = 1e-9.

Letters: z heights (nm) as z[ix, iy]; k pixels along a patch's side.
"""

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .paraboloid import Fit, fit_paraboloids
from .peaks import Peaks, off_centroid, search

_NEIGHBOURHOOD = np.ones((3, 3))

#: Pixels around a tile that its spline also goes through.
HALO = 16

#: Decimals (nm) to which splined heights are rounded, so that what is flat in the scan stays flat.
_DECIMALS = 9


class Frame(NamedTuple):
    """What all tiles of a scan share."""

    shape: tuple[int, int]  # of the scan, pixels
    pixel: tuple[float, float]  # nm
    patch: int  # k
    vertex: str  # "fitted" or "pixel"


class Open(NamedTuple):
    """Plateaus of a tile that reach a seam and may be peaks, numbered from 1."""

    size: np.ndarray  # pixels of each
    sum_ix: np.ndarray  # sums of their places on the scan
    sum_iy: np.ndarray
    first: np.ndarray  # place of the first pixel in a walk along the scan's rows
    height: np.ndarray  # nm
    bits: np.ndarray  # the tile's map of their pixels, eight in a byte
    around: np.ndarray  # heights (nm) near them, row by row


class Tile(NamedTuple):
    """The results of the search in one tile; places are those on the scan."""

    corner: tuple[int, int]
    shape: tuple[int, int]
    missing: int  # number of missing pixels; where there are any, nothing else is searched
    highest: float  # nm
    peaks: Peaks
    first: np.ndarray  # place of each peak's first pixel in a walk along the scan's rows
    fit: Fit
    open: Open
    rims: tuple  # heights (low, high) along each axis; of no width at the scan's edge
    numbers: tuple  # of the open plateaus along the outermost line of each rim, 0 where there is none


class ScanPeaks(NamedTuple):
    """Peaks of a scan in the order in which a walk along its rows first meets their plateaus."""

    missing: int
    highest: float
    peaks: Peaks
    fit: Fit


def search_tile(z: np.ndarray, corner: tuple[int, int], frame: Frame) -> Tile:
    """Return the results for the tile of heights ``z`` (nm) whose first pixel is the scan's ``corner``."""
    z = np.ascontiguousarray(z, dtype=float)
    missing = int(np.count_nonzero(~np.isfinite(z)))
    cut = np.array([(c > 0, c + n < whole) for c, n, whole in zip(corner, z.shape, frame.shape)], dtype=int)
    known = np.pad(z, cut, constant_values=-np.inf) if cut.any() else z
    if missing:
        known = known[:0]
    origin_x, origin_y = np.array(corner) - cut[:, 0]
    tile_peaks = search(known)
    peaks = Peaks(tile_peaks.peaks.ix + origin_x, tile_peaks.peaks.iy + origin_y, tile_peaks.peaks.size)
    inside = tile_peaks.is_open[tuple(slice(before, before + n) for n, (before, _) in zip(z.shape, cut))]
    plateaus, numbers = _opened(z, inside, corner, frame)
    return Tile(
        corner=corner,
        shape=z.shape,
        missing=missing,
        highest=float(z.max()),
        peaks=peaks,
        first=_place(tile_peaks.first_ix + origin_x, tile_peaks.first_iy + origin_y, frame),
        fit=_fitted(known, peaks, (origin_x, origin_y), frame),
        open=plateaus,
        rims=_rims(z, cut, frame.patch - 1),
        numbers=_rims(numbers, cut, 1),
    )


def search_finer(z: np.ndarray, corner: tuple[int, int], halo: tuple, refine: int, frame: Frame) -> Tile:
    """Return the results for a tile on pixels ``refine`` times finer, in which ``frame`` and the places are counted.

    ``z`` holds ((before, after), (before, after)) pixels of ``halo`` beyond the tile along its axes; ``corner`` is the
    tile's first pixel on the scan.
    """
    z = np.ascontiguousarray(z, dtype=float)
    tile = z[tuple(slice(low, n - high) for n, (low, high) in zip(z.shape, halo))]
    if refine == 1:
        return search_tile(tile, corner, frame)
    corner = tuple(refine * c for c in corner)
    shape = tuple(min(refine * n, whole - c) for n, whole, c in zip(tile.shape, frame.shape, corner))
    known = np.isfinite(z).all()
    fine = _splined(z, [low for low, _ in halo], refine, shape) if known else np.full(shape, np.nan)
    peaks = search_tile(fine, corner, frame)
    return peaks._replace(missing=int(np.count_nonzero(~np.isfinite(tile))), highest=float(tile.max()))


def _splined(z: np.ndarray, first: list[int], refine: int, shape: tuple[int, int]) -> np.ndarray:
    """Return heights ``refine`` times finer, from pixel ``first`` on, by bicubic splines through the pixel centres."""
    from scipy.interpolate import RectBivariateSpline

    pixels = [np.arange(n) for n in z.shape]
    order = [min(3, n - 1) for n in z.shape]
    places = [low + np.arange(n) / refine for low, n in zip(first, shape)]
    return np.round(RectBivariateSpline(*pixels, z, kx=order[0], ky=order[1])(*places), _DECIMALS)


def _fitted(z: np.ndarray, peaks: Peaks, corner: tuple[int, int], frame: Frame) -> Fit:
    """Return the fit of peaks to the heights ``z`` of the part of the scan that begins at ``corner``."""
    places = peaks.ix - corner[0], peaks.iy - corner[1]
    return fit_paraboloids(z, *places, *frame.pixel, size=frame.patch, vertex=frame.vertex)


def _place(ix, iy, frame: Frame):
    """Return the place of pixels in a walk along the scan's rows."""
    return ix * frame.shape[1] + iy


def _rims(array: np.ndarray, cut: np.ndarray, width: int) -> tuple:
    """Return copies of the outermost lines at each seam: a view would keep the whole tile."""
    nx, ny = array.shape
    (west, east), (south, north) = cut
    return (
        (array[: width * west].copy(), array[nx - width * east :].copy()),
        (array[:, : width * south].copy(), array[:, ny - width * north :].copy()),
    )


def _labels(is_open: np.ndarray) -> np.ndarray:
    from scipy.ndimage import label

    return label(is_open, structure=_NEIGHBOURHOOD)[0]


def _near(is_open: np.ndarray, patch: int) -> np.ndarray:
    """Return which other pixels a patch around an open plateau's pixel holds."""
    from scipy.ndimage import maximum_filter

    return maximum_filter(is_open, size=patch, mode="constant") & ~is_open


def _opened(z: np.ndarray, is_open: np.ndarray, corner: tuple[int, int], frame: Frame) -> tuple[Open, np.ndarray]:
    """Return a tile's open plateaus, and the map of their numbers."""
    if not is_open.size:
        nothing = np.zeros(0, np.intp)
        return Open(*[nothing] * 4, np.zeros(0), np.zeros(0, np.uint8), np.zeros(0)), np.zeros(z.shape, np.int32)
    numbers = _labels(is_open)
    ix, iy = np.nonzero(is_open)
    number = numbers[ix, iy] - 1
    _, first = np.unique(number, return_index=True)
    height = z[ix[first], iy[first]]
    ix, iy = ix + corner[0], iy + corner[1]
    size, sum_ix, sum_iy = (_sums(number, values) for values in (None, ix, iy))
    around = z[_near(is_open, frame.patch)]
    return Open(size, sum_ix, sum_iy, _place(ix, iy, frame)[first], height, np.packbits(is_open), around), numbers


def _sums(group: np.ndarray, values: np.ndarray | None) -> np.ndarray:
    """Return the sums of whole numbers, or counts, over each group."""
    return np.bincount(group, values).astype(np.intp)  # exact below 2⁵³


class Seam(NamedTuple):
    """The rims along one seam, from one edge of the scan to the other."""

    axis: int  # that the seam cuts
    place: int  # first pixel after it
    heights: np.ndarray  # rims of both sides, nm
    numbers: np.ndarray  # of the open plateaus in the line before and the line after, (2, along)


def join_tiles(grid: list[list[Tile]], frame: Frame) -> ScanPeaks:
    """Return the peaks of the scan that the tiles ``grid[along x][along y]`` make up, each of k − 1 pixels or more."""
    tiles = [tile for row in grid for tile in row]
    missing, highest = sum(tile.missing for tile in tiles), max(tile.highest for tile in tiles)
    if missing or len(tiles) == 1:
        return ScanPeaks(missing, highest, tiles[0].peaks, tiles[0].fit)
    grid = _numbered(grid)
    joined, first = _joined(tiles, _seams(grid))
    peaks = _stacked([*(tile.peaks for tile in tiles), joined])
    fit = _stacked([*(tile.fit for tile in tiles), _fit_within(tiles, joined, frame)])
    for seam in _seams(grid):  # stacked one at a time: all at once would double the memory of the rims
        _fit_across(fit, peaks, seam, frame)
    order = np.argsort(np.concatenate([*(tile.first for tile in tiles), first]))
    return ScanPeaks(missing, highest, _taken(peaks, order), _taken(fit, order))


def _stacked(parts):
    return type(parts[0])(*map(np.concatenate, zip(*parts)))


def _taken(columns, which):
    return type(columns)(*(column[which] for column in columns))


def _put(columns, which, values) -> None:
    for column, new in zip(columns, values):
        column[which] = new


def _numbered(grid: list[list[Tile]]) -> list[list[Tile]]:
    """Return the tiles with open plateaus numbered through all of them."""
    out, before = [], 0
    for row in grid:
        out.append([])
        for tile in row:
            numbers = tuple(tuple(np.where(n > 0, n + before, 0) for n in pair) for pair in tile.numbers)
            out[-1].append(tile._replace(numbers=numbers))
            before += tile.open.size.size
    return out


def _seams(grid: list[list[Tile]]) -> Iterator[Seam]:
    for axis, lines in enumerate((grid, list(zip(*grid)))):
        for before, after in pairwise(lines):
            sides = (before, 1), (after, 0)
            heights, numbers = (
                np.concatenate(
                    [np.concatenate([part(tile)[axis][k] for tile in side], 1 - axis) for side, k in sides], axis
                )
                for part in (lambda tile: tile.rims, lambda tile: tile.numbers)
            )
            yield Seam(axis, after[0].corner[axis], heights, np.moveaxis(numbers, axis, 0))


def _joined(tiles: list[Tile], seams: Iterable[Seam]) -> tuple[Peaks, np.ndarray]:
    """Return the peaks among the plateaus that reach a seam, and the places of their first pixels."""
    size, sum_ix, sum_iy, first = (np.concatenate(column) for column in zip(*(tile.open[:4] for tile in tiles)))
    group = _groups(seams, size.size)
    is_part = group >= 0
    group_of_part, count = group[is_part], group.max(initial=-1) + 1
    totals = [np.zeros(count, np.intp) for _ in range(3)]
    for total, part in zip(totals, (size, sum_ix, sum_iy)):
        np.add.at(total, group_of_part, part[is_part])
    begins = np.full(count, np.iinfo(np.intp).max)
    np.minimum.at(begins, group_of_part, first[is_part])
    best = np.full(count, np.inf), np.zeros(count, np.intp), np.zeros(count, np.intp)
    for tile, groups in zip(tiles, np.split(group, np.cumsum([tile.open.size.size for tile in tiles])[:-1])):
        if (groups >= 0).any():
            _seek_nearest(_labels(_open_pixels(tile)), *tile.corner, groups, *totals, *best)
    return Peaks(best[1], best[2], totals[0]), begins


def _groups(seams: Iterable[Seam], count: int) -> np.ndarray:
    """Return the plateau to which each of the tiles' ``count`` open ones belongs, −1 if it is no peak."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    refuted, links = np.zeros(count + 1, np.bool_), []
    for number, other, z, other_z in (pair for seam in seams for pair in _neighbours(seam)):
        equal = z == other_z
        refuted[number[(z < other_z) | (equal & (other == 0))]] = True
        refuted[other[(z > other_z) | (equal & (number == 0))]] = True
        links.append(np.stack([number, other])[:, equal & (number > 0) & (other > 0)])
    links = np.concatenate(links, axis=1)
    graph = coo_array((np.ones(links.shape[1], np.bool_), tuple(links)), shape=(count + 1, count + 1))
    groups, group = connected_components(graph, directed=False)
    is_peak = np.ones(groups, np.bool_)
    is_peak[group[refuted]] = False
    group = group[1:]
    return np.where(is_peak[group], (np.cumsum(is_peak) - 1)[group], -1)


def _neighbours(seam: Seam) -> Iterator[tuple]:
    """Yield numbers and heights of the pixels before a seam and of those after it that they touch."""
    middle = seam.heights.shape[seam.axis] // 2
    before, after = (np.take(seam.heights, line, seam.axis) for line in (middle - 1, middle))
    for here, there in (
        (slice(1, None), slice(None, -1)),
        (slice(None), slice(None)),
        (slice(None, -1), slice(1, None)),
    ):
        yield seam.numbers[0, here], seam.numbers[1, there], before[here], after[there]


def _open_pixels(tile: Tile) -> np.ndarray:
    return np.unpackbits(tile.open.bits, count=tile.shape[0] * tile.shape[1]).reshape(tile.shape).astype(np.bool_)


@kernel
def _seek_nearest(numbers, corner_ix, corner_iy, groups, size, sum_ix, sum_iy, best, best_ix, best_iy):
    """Replace each group's pixel by one of this tile that lies nearer to the centroid."""
    for p in range(numbers.shape[0]):
        for q in range(numbers.shape[1]):
            g = groups[numbers[p, q] - 1] if numbers[p, q] else -1
            if g >= 0:
                i, j = p + corner_ix, q + corner_iy
                distance = off_centroid(i, j, size[g], sum_ix[g], sum_iy[g])
                if (distance, i, j) < (best[g], best_ix[g], best_iy[g]):
                    best[g], best_ix[g], best_iy[g] = distance, i, j


def _fit_within(tiles: list[Tile], peaks: Peaks, frame: Frame) -> Fit:
    """Return the fit of joined plateaus, each to the heights kept by the tile that contains its middle."""
    fit = Fit(*(np.empty(peaks.ix.size, column.dtype) for column in tiles[0].fit))
    for tile in tiles:
        (low_x, low_y), (nx, ny) = tile.corner, tile.shape
        here = (peaks.ix >= low_x) & (peaks.ix < low_x + nx) & (peaks.iy >= low_y) & (peaks.iy < low_y + ny)
        if here.any():
            _put(fit, here, _fitted(_kept_heights(tile, frame.patch), _taken(peaks, here), tile.corner, frame))
    return fit


def _kept_heights(tile: Tile, patch: int) -> np.ndarray:
    """Return a tile's heights in and near its open plateaus, NaN elsewhere."""
    is_open = _open_pixels(tile)
    z = np.full(tile.shape, np.nan)
    z[is_open] = tile.open.height[_labels(is_open)[is_open] - 1]
    z[_near(is_open, patch)] = tile.open.around
    return z


def _fit_across(fit: Fit, peaks: Peaks, seam: Seam, frame: Frame) -> None:
    """Fit the peaks whose patch reaches across a seam to the heights on both its sides."""
    half, place = frame.patch // 2, (peaks.ix, peaks.iy)[seam.axis]
    across = (place >= seam.place - half) & (place < seam.place + half)
    start = seam.place - (frame.patch - 1)
    corner = (start, 0) if seam.axis == 0 else (0, start)
    _put(fit, across, _fitted(seam.heights, _taken(peaks, across), corner, frame))
