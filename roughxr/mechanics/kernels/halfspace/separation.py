"""The undeformed separation S (nm) between a rough surface and the indenter.

S(x, y) = Z_max − Z(x, y) + S₀(x, y)   (Cheng, Dunn & Brach, eq. 38), S₀ the indenter's height over its lowest
point at (x, y) from the contact centre. The paper's sphere of radius R has S₀ = R − √(R² − r²), Hertz's
paraboloid S₀ = r²/2R; their relative difference is r²/4R².
"""

import numpy as np

from ..jit import kernel

SPHERE, PARABOLA = 0, 1

#: Profiles by name.
PROFILES = {"sphere": SPHERE, "parabola": PARABOLA}


@kernel
def profile_height(r2, radius, profile):
    """Return the height S₀ (nm) at squared distance r2 (nm²) from the axis; inf beyond the sphere."""
    if profile == PARABOLA:
        return r2 / (2.0 * radius)
    if r2 >= radius * radius:
        return np.inf
    return r2 / (radius + np.sqrt(radius * radius - r2))  # without cancellation near the axis


@kernel
def profile_radius(height, radius, profile):
    """Return the distance from the axis (nm) at which the sphere's profile has this height (nm)."""
    if height <= 0.0:
        return 0.0
    if profile == PARABOLA:
        return np.sqrt(2.0 * radius * height)
    return radius if height >= radius else np.sqrt(height * (2.0 * radius - height))


@kernel
def sphere_separation(height, datum, x, y, radius, profile):
    """Return S (nm), shape (x.size, y.size), of a sphere over heights (nm) at x, y from the contact centre."""
    separation = np.empty((x.size, y.size))
    for i in range(x.size):
        for j in range(y.size):
            separation[i, j] = datum - height[i, j] + profile_height(x[i] * x[i] + y[j] * y[j], radius, profile)
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
