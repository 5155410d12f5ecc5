"""Landings on debris: where a sphere first touches heights far above all others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

#: Number of landings along each axis by which the share of debris is sampled.
_LANDINGS = 64


def debris_landings(
    height: np.ndarray, axes: Sequence[np.ndarray], places: Sequence[np.ndarray], radius: float
) -> tuple[float, np.ndarray]:
    """Return the share of a scan's area where a sphere first touches debris, and whether it does at some places.

    Parameters
    ----------
    height : ndarray (nx, ny), nm
    axes : x (nx,) and y (ny,) of the pixels, nm
    places : x and y of the places, nm
    radius : radius of the sphere, nm; its profile is taken as a parabola

    Examples
    --------
    >>> axis = np.arange(100) * 10.0
    >>> height = np.random.default_rng(0).normal(0.0, 0.5, (100, 100))
    >>> height[50, 50] = 20.0  # touched within the root of 2 R h, 200 nm
    >>> places = np.array([450.0, 900.0]), np.array([450.0, 100.0])
    >>> share, flags = debris_landings(height, (axis, axis), places, 1000.0)
    >>> round(share, 2), flags.tolist()
    (0.12, [True, False])
    """
    height, axes = _block_maxima(np.where(np.isfinite(height), height, np.nanmin(height)), axes)
    grid = [np.linspace(axis[0], axis[-1], _LANDINGS) for axis in axes]
    touched = _touched_on_grid(height, axes, grid, radius)
    median = np.median(touched)
    # debris lies this many median absolute deviations above the median height at which the sphere first touches. The
    # highest point of 180 self-affine surfaces without debris lay at most 7.9 above it.
    limit = median + 8.0 * np.median(np.abs(touched - median))
    clean = np.where(height > limit, height.min(), height)
    if not (height > limit).any():
        return 0.0, np.zeros(len(places[0]), bool)
    share = np.mean(touched > _touched_on_grid(clean, axes, grid, radius))
    flags = _touched_at(height, axes, places, radius) > _touched_at(clean, axes, places, radius)
    return float(share), flags


def _block_maxima(height: np.ndarray, axes: Sequence[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the highest points of blocks of pixels, and the axes of their centres."""
    # pixels along each axis; finer scans are reduced to the highest points of blocks
    sides = [max(axis.size // 512, 1) for axis in axes]
    counts = [axis.size // side for axis, side in zip(axes, sides)]
    centres = [axis[: n * side].reshape(n, side).mean(axis=1) for axis, n, side in zip(axes, counts, sides)]
    whole = height[: counts[0] * sides[0], : counts[1] * sides[1]]
    return whole.reshape(counts[0], sides[0], counts[1], sides[1]).max(axis=(1, 3)), centres


def _touched_on_grid(height: np.ndarray, axes: Sequence[np.ndarray], grid: Sequence[np.ndarray], radius: float):
    """Return the height (nm) of the sphere's lowest point at first touch, on a grid of landings."""
    rows = _touched_along(height, axes[0], grid[0], radius)
    return _touched_along(rows.T, axes[1], grid[1], radius).T


def _touched_at(height: np.ndarray, axes: Sequence[np.ndarray], places: Sequence[np.ndarray], radius: float):
    """Return the height (nm) of the sphere's lowest point at first touch, at single places."""
    columns, number = np.unique(places[0], return_inverse=True)
    rows = _touched_along(height, axes[0], columns, radius)
    return np.array([_touched_along(rows[k][:, None], axes[1], [y], radius)[0, 0] for k, y in zip(number, places[1])])


def _touched_along(height: np.ndarray, axis: np.ndarray, at: Any, radius: float) -> np.ndarray:
    """Return the largest heights over a parabola, (at, second axis), whose apex moves along the first axis."""
    at = np.asarray(at)
    reach = np.sqrt(2 * radius * np.ptp(height))
    depth = (axis - at[:, None]) ** 2 / (2 * radius)
    first = np.minimum(np.searchsorted(axis, at - reach), axis.size - 1)
    last = np.maximum(np.searchsorted(axis, at + reach), first + 1)
    return np.array([(height[i:j] - row[i:j, None]).max(axis=0) for i, j, row in zip(first, last, depth)])
