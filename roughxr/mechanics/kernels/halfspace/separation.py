"""The undeformed separation S (nm) between a rough surface and the indenter.

S(x, y) = Z_max − Z(x, y) + S₀(x, y)   (Cheng, Dunn & Brach, eq. 38), S₀ the indenter's height over its lowest
point at (x, y) from the contact centre, of a sphere of radius R: R − √(R² − r²). It exceeds that of Hertz's paraboloid,
r²/2R, by a part r²/4R².
"""

import numpy as np

from ..jit import kernel


@kernel
def sphere_height(r2, radius):
    """Return the height S₀ (nm) at squared distance r2 (nm²) from the axis; inf beyond the sphere."""
    if r2 >= radius * radius:
        return np.inf
    return r2 / (radius + np.sqrt(radius * radius - r2))  # without cancellation near the axis


@kernel
def distance_at_height(height, radius):
    """Return the distance from the axis (nm) at which the sphere has this height (nm) over its lowest point."""
    if height <= 0.0:
        return 0.0
    return radius if height >= radius else np.sqrt(height * (2.0 * radius - height))


@kernel
def sphere_separation(height, datum, x, y, radius):
    """Return S (nm), shape (x.size, y.size), of a sphere over heights (nm) at x, y from the contact centre."""
    separation = np.empty((x.size, y.size))
    for i in range(x.size):
        for j in range(y.size):
            separation[i, j] = datum - height[i, j] + sphere_height(x[i] * x[i] + y[j] * y[j], radius)
    return separation


def map_separation(height, datum, x, y, map_x, map_y, map_height):
    """Return S (nm) for an indenter's height map about the contact centre, interpolated linearly; inf beyond it."""
    from scipy.interpolate import RegularGridInterpolator

    depth = map_height.max() - map_height
    between = RegularGridInterpolator((map_x, map_y), depth, bounds_error=False, fill_value=np.inf)
    x = _snap_to_rim(x, map_x)
    y = _snap_to_rim(y, map_y)
    return datum - height + between(np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1))


def _snap_to_rim(x, map_x):
    """Return x, with points that are outside the map by rounding only moved back to its rim."""
    inside = np.clip(x, map_x[0], map_x[-1])
    return np.where(np.abs(x - inside) < 1e-6 * (map_x[1] - map_x[0]), inside, x)
