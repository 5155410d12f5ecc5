"""Ridges, narrow and oblique to the pixels' rows, which break up into several peaks: the highest of each is kept.

A paraboloid of B/A = 50 turned by 0.5 rad is three peaks, of 100 five, each with the whole ridge's paraboloid.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.spatial import cKDTree

#: Least ratio of the principal curvatures: a wider ridge has one peak, whatever its direction.
_RIDGE_RATIO = 20.0

#: How much of one ridge two paraboloids are: largest relative difference of their curvatures across it, and of their
#: directions (rad). Of 17,800 asperities of the glass twin five are on another's ridge.
_RIDGE_TOLERANCE = 0.1

#: Among so many nearest peaks a higher one of the same ridge is looked for.
_NEIGHBOURS = 8


def repeated(catalogue: xr.Dataset, pixel: float) -> np.ndarray:
    """Return which asperities are a higher one's ridge found again, on pixels of this size in nm."""
    x, y, height = (catalogue[name].values for name in ("x", "y", "height"))
    along, across = 0.5 * catalogue["curvature_min"].values, 0.5 * catalogue["curvature_max"].values
    direction, out = catalogue["orientation"].values, np.zeros(x.size, bool)
    long = np.flatnonzero(catalogue["vertex_fixed"].values & (along > 0) & (across > _RIDGE_RATIO * along))
    if x.size < 2 or long.size == 0:
        return out
    places = np.column_stack((x, y))
    near = cKDTree(places).query(places[long], k=min(_NEIGHBOURS + 1, x.size))[1]
    i, j = np.repeat(long, near.shape[1]), near.ravel()
    first = (height[j] > height[i]) | ((height[j] == height[i]) & (j < i))
    u = np.cos(direction[j]) * (x[i] - x[j]) + np.sin(direction[j]) * (y[i] - y[j])
    v = np.cos(direction[j]) * (y[i] - y[j]) - np.sin(direction[j]) * (x[i] - x[j])
    fall = along[j] * u**2 + across[j] * v**2
    # a vertex fixed at a pixel may lie beside the true one: hence as much as the fall along the ridge, twice
    on_it = (along[j] > 0) & (np.abs(v) < pixel) & (np.abs(height[j] - height[i] - fall) <= 2 * along[j] * u**2)
    alike = np.abs(across[j] - across[i]) < _RIDGE_TOLERANCE * across[j]
    out[i[first & on_it & alike & (np.abs(np.sin(direction[i] - direction[j])) < _RIDGE_TOLERANCE)]] = True
    return out
