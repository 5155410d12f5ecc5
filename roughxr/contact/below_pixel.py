"""The pull-off at one place of a surface whose roughness is continued below what its scan shows.

Waves of one octave lift the sphere off all but the highest summits of the next longer ones. So few cells are within
reach, a few hundred, in patches that lie far apart. They are found step by step: on coarse cells with the longer waves,
then only where shorter ones may still touch. Rows and columns of cells in which nothing is within reach are left out,
and the patches moved together, but for a distance at which they hardly feel each other through the solid.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.adhesion import smooth_path as path
from ..kernels.topography.random_surface import nested_waves, rms_of
from .cycle import bearing_cell, cycles_on, largest_pull, reach_of_law, reached
from .problem import Surface

#: Cells along the shortest wave, and on the meshes on which the cells within reach are looked for.
PER_WAVE, _PER_WAVE_LOOKED = 8.0, 3.0

#: Cells need not be smaller than this (nm), as long as the shortest wave has four: such short waves are low.
_LEAST_CELL = 0.5

#: Factor from the shortest wave of one such mesh to the next.
_SHORTER = 3.0

#: Lengths of the law beyond which its pull is not counted: a part of 0.4 % of the largest.
_REACH = 5.5

#: Standard deviations of the waves that are still missing by which a place may rise.
_HIGH = 3.0

#: Patches keep the distance at which their pull lifts the surface by at most this part of the range.
_FELT = 0.3

#: A preload that is not reached is looked for this factor deeper, at most so many times.
_DEEPER, _TRIES = 2.0, 6

#: Cells (nm) on which the surface that the scan shows is looked at first, and at most so many of them along a side.
_FIRST_CELL, _MOST_FIRST = 4.0, 400


class Below(NamedTuple):
    """The surface that a place is solved on: what the scan shows, and the waves that are added."""

    spectrum: object  # with ``at(q)``: C(q), nm⁴
    longest: float  # nm, of the waves that are added
    shortest: float  # nm


class Patch(NamedTuple):
    """The heights around one place."""

    height: np.ndarray  # (nx, ny), nm
    first: tuple[float, float]  # nm, x and y of the first pixel
    pixel: float  # nm
    centre: tuple[float, float]  # nm


def pull_off_below(height, first, pixel, centre, seed, depth, pull, problem, adhesion, below) -> np.ndarray:
    """Return the pull-off (nN) at a place, and how deep (nm beyond first contact) the preload is met; a task.

    ``depth`` and ``pull`` are guesses of them; NaN where the preload is not met.
    """
    patch = Patch(height, first, pixel, centre)
    for _ in range(_TRIES):
        surface, cell = _surface(patch, int(seed), float(depth), float(pull), problem, adhesion, below)
        here = problem._replace(steps=np.array([depth]), pixel=cell, refine=1)
        found = cycles_on(surface, here, adhesion)
        followed = found.paths[0]
        if reached(followed, adhesion, 0) or followed.status != path.CONVERGED:
            break
        depth = depth * _DEEPER
    if not (followed.turn and reached(followed, adhesion, 0)):
        return np.full(2, np.nan)
    return np.array([largest_pull(found, 0), followed.states[followed.turn - 1, path.DELTA]])


def _surface(patch, seed, depth, pull, problem, adhesion, below) -> tuple[Surface, float]:
    """Return the separation on the cells within reach, inf on those in between, and the side of the cells."""
    from scipy.interpolate import RectBivariateSpline

    pixels = [first + patch.pixel * np.arange(size) for first, size in zip(patch.first, patch.height.shape)]
    shown = RectBivariateSpline(*pixels, patch.height)
    softest = bearing_cell(adhesion, problem.contact_modulus)
    last = min(max(below.shortest / PER_WAVE, min(_LEAST_CELL, 2 * below.shortest / PER_WAVE)), softest)
    within = depth + _REACH * adhesion.length
    if adhesion.liquid is not None:
        alone = adhesion._replace(work=0.0)
        within = max(within, depth + reach_of_law(alone, problem._replace(pixel=last, refine=1)))
    apart = pull / (np.pi * problem.contact_modulus * _FELT * adhesion.span)

    def separation(points, shortest):
        x, y = points
        heights = shown(x, y) + nested_waves(x, y, below.spectrum.at, below.longest, shortest, seed)
        return problem.indenter.separation(heights, 0.0, x - patch.centre[0], y - patch.centre[1])

    cell = max(min(_FIRST_CELL, patch.pixel), patch.pixel * max(patch.height.shape) / _MOST_FIRST)
    points = [_between(axis[0] - 0.5 * patch.pixel, axis[-1] + 0.5 * patch.pixel, cell) for axis in pixels]
    wave = below.longest
    while wave > _SHORTER * below.shortest:
        left = rms_of(below.spectrum.at, wave, below.shortest)
        near = separation(points, wave)
        near = near < near.min() + within + _HIGH * left
        wave = wave / _SHORTER
        finer = min(cell, wave / _PER_WAVE_LOOKED)
        points, cell = [_kept(p, near.any(1 - k), cell, finer, apart) for k, p in enumerate(points)], finer
    near = separation(points, wave)
    near = near < near.min() + within + _HIGH * rms_of(below.spectrum.at, wave, below.shortest)
    points = [_kept(p, near.any(1 - k), cell, last, apart) for k, p in enumerate(points)]
    found = separation(points, below.shortest)
    found = np.where(found < found.min() + within, found, np.inf)
    return Surface(found, float(found.min()), np.inf, (0, 0)), last


def _between(low: float, high: float, cell: float) -> np.ndarray:
    """Return the middles of cells, on one lattice for all ranges."""
    return cell * (np.arange(np.floor(low / cell), np.ceil(high / cell)) + 0.5)


def _kept(points: np.ndarray, near: np.ndarray, cell: float, finer: float, apart: float) -> np.ndarray:
    """Return finer points along one axis, where any coarser point is near, and a distance around them."""
    known = points[near]
    breaks = np.flatnonzero(np.diff(known) > 2 * apart + 3 * cell)
    firsts, lasts = known[np.r_[0, breaks + 1]], known[np.r_[breaks, -1]]
    margin = apart + cell
    ranges = [_between(low - margin, high + margin, finer) for low, high in zip(firsts, lasts)]
    found = np.unique(np.rint(np.concatenate(ranges) / finer - 0.5))
    found = finer * (found + 0.5)
    return found[(found > points[0] - 0.5 * cell) & (found < points[-1] + 0.5 * cell)]
