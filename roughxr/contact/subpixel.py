"""The pull-off at one place of a surface whose roughness is extrapolated below what its scan shows.

The few cells within reach lie in patches far from each other. They are located on coarse cells with the longer
wavelengths, then only where finer roughness may still touch. Patches are moved together, but for a distance at which
they hardly interact.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..kernels.adhesion import path as path
from ..kernels.topography.random_surface import band_rms, roughness_bands, summed_modes
from .cycle import bearing_cell, cycles_on, largest_pull, reach_of_law, reached
from .problem import Surface

#: Cells along the shortest wavelength, and on the meshes that locate the cells within reach.
PER_WAVE, _COARSE_PER_WAVE = 8.0, 3.0

#: Cells need not be smaller than so many ranges of adhesion, as long as the shortest wavelength has four: such short
#: wavelengths are low.
_LEAST_CELL = 5 / 3

#: Factor from the shortest wavelength of one such mesh to the next.
_WAVE_FACTOR = 3.0

#: Lengths of the law beyond which its pull is not counted: a part of 0.4 % of the largest.
_REACH_OF_LAW = 5.5

#: Standard deviations of the roughness still missing by which a place may rise.
_RISE_DEVIATIONS = 3.0

#: Patches keep the distance at which their pull lifts the surface by at most this part of the range.
_ELASTIC_LIFT = 0.3

#: Where a preload is not reached, loading goes deeper by this factor, at most so many times.
_DEPTH_FACTOR, _MOST_DEPTHS = 2.0, 6

#: Cells (ranges of adhesion) on which the surface that the scan shows is looked at first, and at most so many of them
#: along a side.
_FIRST_CELL, _MOST_FIRST_CELLS = 40 / 3, 400


class Below(NamedTuple):
    """The surface that a place is solved on: what the scan shows, and the roughness added."""

    spectrum: Any  # with ``at(q)``, C(q), nm⁴, and ``of(kx, ky)`` in a direction
    longest: float  # nm, longest wavelength added
    shortest: float  # nm


class Patch(NamedTuple):
    """The heights around one place."""

    height: np.ndarray  # (nx, ny), nm
    first: tuple[float, float]  # nm, x and y of the first pixel
    pixel: float  # nm
    centre: tuple[float, float]  # nm


def pull_off_below(height, first, pixel, centre, seed, depth, pull, problem, adhesion, below) -> np.ndarray:
    """Return the pull-off (nN) at a place, and how deep (nm beyond first contact) the preload is met; a task."""
    patch = Patch(height, first, pixel, centre)
    for _ in range(_MOST_DEPTHS):
        surface, cell = _surface(patch, int(seed), float(depth), float(pull), problem, adhesion, below)
        deeper = problem._replace(steps=np.array([depth]), pixel=cell, refine=1)
        cycles = cycles_on(surface, deeper, adhesion)
        followed = cycles.paths[0]
        if reached(followed, adhesion, 0) or followed.status != path.CONVERGED:
            break
        depth = depth * _DEPTH_FACTOR
    if not (followed.turn and reached(followed, adhesion, 0)):
        return np.full(2, np.nan)
    return np.array([largest_pull(cycles, 0), followed.states["delta"][followed.turn - 1]])


def _surface(patch, seed, depth, pull, problem, adhesion, below) -> tuple[Surface, float]:
    """Return the separation on the cells within reach, inf on those in between, and the side of the cells."""
    from scipy.interpolate import RectBivariateSpline

    pixels = [first + patch.pixel * np.arange(size) for first, size in zip(patch.first, patch.height.shape)]
    shown = RectBivariateSpline(*pixels, patch.height)
    softest = bearing_cell(adhesion, problem.contact_modulus)
    least = min(_LEAST_CELL * adhesion.length, 2 * below.shortest / PER_WAVE)
    last = min(max(below.shortest / PER_WAVE, least), softest, adhesion.first_cell)  # the sphere's contact may be small
    within = depth + _REACH_OF_LAW * adhesion.length
    if adhesion.liquid is not None:
        alone = adhesion._replace(work=0.0)
        within = max(within, depth + reach_of_law(alone, problem._replace(pixel=last, refine=1)))
    distance = pull / (np.pi * problem.contact_modulus * _ELASTIC_LIFT * adhesion.span)

    def separations(boxes, shortest):
        waves = roughness_bands(below.spectrum.of, below.longest, shortest, seed)
        offsets = [(x - patch.centre[0], y - patch.centre[1]) for x, y in boxes]
        heights = [shown(*box) + summed_modes(waves, *box) for box in boxes]
        return [problem.indenter.separation(height, 0.0, *offset) for height, offset in zip(heights, offsets)]

    cell = max(
        min(_FIRST_CELL * adhesion.length, patch.pixel), patch.pixel * max(patch.height.shape) / _MOST_FIRST_CELLS
    )
    boxes = [tuple(_between(axis[0] - 0.5 * patch.pixel, axis[-1] + 0.5 * patch.pixel, cell) for axis in pixels)]
    wave, finest = below.longest, False
    while not finest:
        near = _near(
            separations(boxes, wave), within + _RISE_DEVIATIONS * band_rms(below.spectrum.at, wave, below.shortest)
        )
        finest, wave = wave <= _WAVE_FACTOR * below.shortest, wave / _WAVE_FACTOR
        finer = last if finest else min(cell, wave / _COARSE_PER_WAVE)
        boxes = [smaller for box, part in zip(boxes, near) for smaller in _finer(box, part, cell, finer, distance)]
        cell = finer
    separated = separations(boxes, below.shortest)
    parts = [np.where(part, box, np.inf) for part, box in zip(_near(separated, within), separated)]
    margin = int(np.ceil(distance / last)) + 1
    sheet = _side_by_side([patch for part in parts for patch in _patches(part, margin)])
    return Surface(sheet, float(sheet.min()), np.inf, (0, 0)), last


def _near(separations: list[np.ndarray], within: float) -> list[np.ndarray]:
    """Return where boxes come as near as this (nm) to the nearest of all."""
    least = min(separation.min() for separation in separations)
    return [separation < least + within for separation in separations]


def _between(low: float, high: float, cell: float) -> np.ndarray:
    """Return the middles of cells, on one lattice for all ranges."""
    return cell * (np.arange(np.floor(low / cell), np.ceil(high / cell)) + 0.5)


def _finer(box: tuple, near: np.ndarray, cell: float, finer: float, distance: float) -> list[tuple]:
    """Return boxes of finer points for the coarser ones that are near, and a distance; no two share a point."""
    wanted = _dilated(near, int(np.ceil(distance / cell)) + 1)
    parts = _boxes_of(wanted)
    while sum(wanted[part].size for part in parts) > wanted.sum():
        for part in parts:
            wanted[part] = True
        parts = _boxes_of(wanted)
    return [tuple(_finer_points(axis[along], cell, finer) for axis, along in zip(box, part)) for part in parts]


def _boxes_of(cells: np.ndarray) -> list[tuple[slice, slice]]:
    """Return the boxes of connected cells, also across corners."""
    from scipy import ndimage

    return ndimage.find_objects(ndimage.label(cells, np.ones((3, 3)))[0])


def _finer_points(points: np.ndarray, cell: float, finer: float) -> np.ndarray:
    """Return the finer points inside a range of cells."""
    low, high = points[0] - 0.5 * cell, points[-1] + 0.5 * cell
    points = _between(low, high, finer)
    return points[(points >= low) & (points < high)]


def _dilated(near: np.ndarray, margin: int) -> np.ndarray:
    from scipy import ndimage

    return ndimage.maximum_filter(near, 2 * margin + 1, mode="constant")


def _patches(separation: np.ndarray, margin: int) -> list[np.ndarray]:
    """Return the patches of finite separation more than two margins (cells) from each other, each with a margin."""
    from scipy import ndimage

    padded = np.pad(separation, margin, constant_values=np.inf)
    labels, _ = ndimage.label(_dilated(np.isfinite(padded), margin), np.ones((3, 3)))
    boxes = enumerate(ndimage.find_objects(labels), 1)
    return [np.where(labels[box] == label, padded[box], np.inf) for label, box in boxes]


def _side_by_side(patches: list[np.ndarray]) -> np.ndarray:
    """Return patches side by side, in rows about as long as all are together high."""
    patches = sorted(patches, key=len, reverse=True)
    width = max(int(np.sqrt(sum(patch.size for patch in patches))), *(patch.shape[1] for patch in patches))
    rows: list[list[np.ndarray]] = [[]]
    for patch in patches:
        if sum(other.shape[1] for other in rows[-1]) + patch.shape[1] > width and rows[-1]:
            rows.append([])
        rows[-1].append(patch)
    out, low = np.full((sum(len(row[0]) for row in rows), width), np.inf), 0
    for row in rows:
        left = 0
        for patch in row:
            out[low : low + len(patch), left : left + patch.shape[1]] = patch
            left += patch.shape[1]
        low += len(row[0])
    return out
