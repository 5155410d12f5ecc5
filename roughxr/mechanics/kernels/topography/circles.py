"""Heights on circles about a point, and their slopes outwards, by cubic B-splines along x and y through cells' heights.

The heights are extended by those turned by 180° about the outermost cell, as in ``interpolation``. Source: Unser, IEEE
Signal Process. Mag. 16 (1999) 22.
"""

import numpy as np

from ..jit import kernel

#: Cells by which heights are extended: the spline depends on those beyond by 1e-5.
_MARGIN = 9


def heights_on_circles(axes, height, middle, radii, angles):
    """Return heights and their slopes outwards (radius, angle) about ``middle``, within cells at uniform ``axes``."""
    from scipy.ndimage import spline_filter

    cell = axes[0][1] - axes[0][0]
    extended = np.pad(height, _MARGIN, "reflect", reflect_type="odd")
    x, y = ((place - cells[0]) / cell + _MARGIN for place, cells in zip(middle, axes))
    coefficients = spline_filter(extended, mode="mirror")
    values, slopes = _on_circles(coefficients, x, y, radii / cell, np.cos(angles), np.sin(angles))
    return values, slopes / cell


@kernel
def _on_circles(coefficients, x, y, radii, cosines, sines):
    """Return the spline and its derivative outwards on circles about (x, y); lengths are in cells."""
    values = np.empty((radii.size, cosines.size))
    slopes = np.empty((radii.size, cosines.size))
    for i in range(radii.size):
        for k in range(cosines.size):
            u = x + radii[i] * cosines[k]
            v = y + radii[i] * sines[k]
            row = int(u)
            column = int(v)
            along, slope_along = _weights(u - row)
            across, slope_across = _weights(v - column)
            value = 0.0
            along_x = 0.0
            along_y = 0.0
            for m in range(4):
                line = 0.0
                line_slope = 0.0
                for n in range(4):
                    coefficient = coefficients[row - 1 + m, column - 1 + n]
                    line += across[n] * coefficient
                    line_slope += slope_across[n] * coefficient
                value += along[m] * line
                along_x += slope_along[m] * line
                along_y += along[m] * line_slope
            values[i, k] = value
            slopes[i, k] = along_x * cosines[k] + along_y * sines[k]
    return values, slopes


@kernel
def _weights(t):
    """Return the four cubic B-splines over a cell and their derivatives, at 0 ≤ t ≤ 1 within it."""
    u = 1.0 - t
    weights = (
        u * u * u / 6.0,
        2.0 / 3.0 - t * t * (1.0 - 0.5 * t),
        2.0 / 3.0 - u * u * (1.0 - 0.5 * u),
        t * t * t / 6.0,
    )
    slopes = (-0.5 * u * u, t * (1.5 * t - 2.0), u * (2.0 - 1.5 * u), 0.5 * t * t)
    return weights, slopes
