"""The pull-off at one place of a surface with roughness added below the shortest wavelength of the scan.

Only the cells within the range of adhesion are solved. They lie in few patches, which are located on coarse cells with
the longer wavelengths, then on finer cells only where finer roughness may still touch. The patches are packed into one
window, at a distance at which they hardly interact.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..kernels.adhesion import path as path
from ..kernels.topography.random_surface import band_rms, roughness_bands, summed_modes
from .cycle import cycles_on, interaction_range, pull_off_force, reached, resolving_cell
from .problem import Surface

#: Cells along the shortest wavelength: of the solution, and of the meshes that locate the patches.
CELLS_PER_WAVELENGTH, _COARSE_CELLS_PER_WAVELENGTH = 8.0, 3.0

#: Side of the smallest cells, in ranges of adhesion, if the shortest wavelength has four of them: amplitudes of such
#: short wavelengths are small.
_LEAST_CELL = 5 / 3

#: Ratio of the shortest wavelengths of two successive meshes.
_WAVELENGTH_FACTOR = 3.0

#: Cut-off of the traction, in lengths of the law: 0.4 % of the largest traction.
_CUT_OFF = 5.5

#: Largest rise of a place by wavelengths not yet added, in their standard deviations.
_RISE_DEVIATIONS = 3.0

#: Largest lift of the surface at one patch by the tension of the others, as a part of the range; sets their distance.
_ELASTIC_LIFT = 0.3

#: Factor of the depth of loading if a preload is not reached, and largest number of such steps.
_DEPTH_FACTOR, _MOST_DEPTHS = 2.0, 6

#: Side of the first cells, in ranges of adhesion, and largest number of them along a side.
_FIRST_CELL, _MOST_FIRST_CELLS = 40 / 3, 400


class AddedRoughness(NamedTuple):
    """The spectrum and wavelengths of the roughness added to the scan."""

    spectrum: Any  # `Spectrum` of the scan, with its density in nm⁴
    longest: float  # wavelength, nm
    shortest: float  # nm


class ScanWindow(NamedTuple):
    """The scan's heights around one place."""

    height: np.ndarray  # (nx, ny), nm
    first: tuple[float, float]  # nm, x and y of the first pixel
    pixel: float  # nm
    centre: tuple[float, float]  # nm


def extrapolated_pull_off(height, first, pixel, centre, seed, depth, estimate, problem, adhesion, added) -> np.ndarray:
    """Return the pull-off (nN) at a place, its depth (nm beyond first contact) at the preload, and the cells; a task.

    ``estimate`` of the pull-off (nN) sets the distance between patches.
    """
    window = ScanWindow(height, first, pixel, centre)
    for _ in range(_MOST_DEPTHS):
        surface, cell = _packed_surface(window, int(seed), float(depth), float(estimate), problem, adhesion, added)
        deeper = problem._replace(steps=np.array([depth]), pixel=cell, refine=1)
        cycles = cycles_on(surface, deeper, adhesion)
        followed = cycles.paths[0]
        if reached(followed, adhesion, 0) or followed.status != path.CONVERGED:
            break
        depth = depth * _DEPTH_FACTOR
    if not (followed.turn and reached(followed, adhesion, 0)):
        return np.full(3, np.nan)
    cells = np.count_nonzero(np.isfinite(surface.separation))
    return np.array([pull_off_force(cycles, 0), followed.states["delta"][followed.turn - 1], cells])


def _packed_surface(window, seed, depth, estimate, problem, adhesion, added) -> tuple[Surface, float]:
    """Return the separation on the packed patches, inf between them, and the side of the cells."""
    from scipy.interpolate import RectBivariateSpline

    pixels = [first + window.pixel * np.arange(size) for first, size in zip(window.first, window.height.shape)]
    scanned = RectBivariateSpline(*pixels, window.height)
    softest = resolving_cell(adhesion, problem)
    least = min(_LEAST_CELL * adhesion.length, 2 * added.shortest / CELLS_PER_WAVELENGTH)
    resolving = max(added.shortest / CELLS_PER_WAVELENGTH, least)
    last = min(resolving, softest, adhesion.first_cell)  # the sphere's contact may be small
    within = depth + _CUT_OFF * adhesion.length
    if adhesion.liquid is not None:
        alone = adhesion._replace(work=0.0)
        within = max(within, depth + interaction_range(alone, problem._replace(pixel=last, refine=1)))
    distance = estimate / (np.pi * problem.softest * _ELASTIC_LIFT * adhesion.main_range)

    def separations(boxes, shortest):
        bands = roughness_bands(added.spectrum.directional_density, added.longest, shortest, seed)
        offsets = [(x - window.centre[0], y - window.centre[1]) for x, y in boxes]
        heights = [scanned(*box) + summed_modes(bands, *box) for box in boxes]
        return [problem.indenter.separation(height, 0.0, *offset) for height, offset in zip(heights, offsets)]

    smallest = window.pixel * max(window.height.shape) / _MOST_FIRST_CELLS
    cell = max(min(_FIRST_CELL * adhesion.length, window.pixel), smallest)
    half = 0.5 * window.pixel
    boxes = [tuple(_cell_centres(axis[0] - half, axis[-1] + half, cell) for axis in pixels)]
    wavelength = added.longest
    finest = False
    while not finest:
        rise = _RISE_DEVIATIONS * band_rms(added.spectrum.density, wavelength, added.shortest)
        near = _cells_within(separations(boxes, wavelength), within + rise)
        finest = wavelength <= _WAVELENGTH_FACTOR * added.shortest
        wavelength = wavelength / _WAVELENGTH_FACTOR
        finer = last if finest else min(cell, wavelength / _COARSE_CELLS_PER_WAVELENGTH)
        boxes = [
            smaller for box, part in zip(boxes, near) for smaller in _finer_boxes(box, part, cell, finer, distance)
        ]
        cell = finer
    separated = separations(boxes, added.shortest)
    parts = [np.where(part, box, np.inf) for part, box in zip(_cells_within(separated, within), separated)]
    margin = int(np.ceil(distance / last)) + 1
    sheet = pack_patches([patch for part in parts for patch in _patches(part, margin)])
    return Surface(sheet, float(sheet.min()), np.inf, (0, 0)), last


def _cells_within(separations: list[np.ndarray], within: float) -> list[np.ndarray]:
    """Return the cells of boxes whose separation exceeds the least of all by less than ``within`` (nm)."""
    least = min(separation.min() for separation in separations)
    return [separation < least + within for separation in separations]


def _cell_centres(low: float, high: float, cell: float) -> np.ndarray:
    """Return the centres of cells in a range, on one lattice for all ranges."""
    return cell * (np.arange(np.floor(low / cell), np.ceil(high / cell)) + 0.5)


def _finer_boxes(box: tuple, near: np.ndarray, cell: float, finer: float, distance: float) -> list[tuple]:
    """Return boxes of finer points around the coarse cells that are near, without common points."""
    wanted = _dilated(near, int(np.ceil(distance / cell)) + 1)
    parts = _bounding_boxes(wanted)
    while sum(wanted[part].size for part in parts) > wanted.sum():
        for part in parts:
            wanted[part] = True
        parts = _bounding_boxes(wanted)
    return [tuple(_finer_points(axis[along], cell, finer) for axis, along in zip(box, part)) for part in parts]


def _bounding_boxes(cells: np.ndarray) -> list[tuple[slice, slice]]:
    """Return the bounding boxes of connected cells, corners included."""
    from scipy import ndimage

    return ndimage.find_objects(ndimage.label(cells, np.ones((3, 3)))[0])


def _finer_points(points: np.ndarray, cell: float, finer: float) -> np.ndarray:
    """Return the finer points inside a range of cells."""
    low = points[0] - 0.5 * cell
    high = points[-1] + 0.5 * cell
    points = _cell_centres(low, high, finer)
    return points[(points >= low) & (points < high)]


def _dilated(near: np.ndarray, margin: int) -> np.ndarray:
    from scipy import ndimage

    return ndimage.maximum_filter(near, 2 * margin + 1, mode="constant")


def _patches(separation: np.ndarray, margin: int) -> list[np.ndarray]:
    """Return the patches of finite separation, more than two margins (cells) apart, each with a margin."""
    from scipy import ndimage

    padded = np.pad(separation, margin, constant_values=np.inf)
    labels, _ = ndimage.label(_dilated(np.isfinite(padded), margin), np.ones((3, 3)))
    boxes = enumerate(ndimage.find_objects(labels), 1)
    return [np.where(labels[box] == label, padded[box], np.inf) for label, box in boxes]


def pack_patches(patches: list[np.ndarray]) -> np.ndarray:
    """Return patches packed in rows into a nearly square array, inf between them."""
    patches = sorted(patches, key=len, reverse=True)
    width = max(int(np.sqrt(sum(patch.size for patch in patches))), *(patch.shape[1] for patch in patches))
    rows: list[list[np.ndarray]] = [[]]
    for patch in patches:
        if sum(other.shape[1] for other in rows[-1]) + patch.shape[1] > width and rows[-1]:
            rows.append([])
        rows[-1].append(patch)
    out = np.full((sum(len(row[0]) for row in rows), width), np.inf)
    low = 0
    for row in rows:
        column = 0
        for patch in row:
            out[low : low + len(patch), column : column + patch.shape[1]] = patch
            column += patch.shape[1]
        low += len(row[0])
    return out
