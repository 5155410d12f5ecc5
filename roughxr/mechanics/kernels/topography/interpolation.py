"""Heights between the pixels.

`band_limited` returns the one surface through the pixel centres without wavelengths shorter than two pixels. It is
exact for a scan that resolves its surface. Its modes are those of a cosine transform, sampled at (j + ½)/N of the
window's length as pixels are (DCT-II; Strang, SIAM Review 41 (1999) 135), so that the inverse transform also gives
finer cells. Each edge is extended by the heights turned by 180° about the outermost pixel, which keeps the slope, after
a plane is removed; the effect of this choice falls as the third power of the distance from the edge. Steps ring by a
tenth of their height.

`splined` interpolates by bicubic splines: wavelengths of two to three pixels come out some per cent lower, and steps
ring less. The difference between both estimates the effect of heights that no pixel shows. `heights_on_circles` takes
such splines between finer cells.
"""

from typing import Any

import numpy as np


def band_limited(height: np.ndarray, n: int) -> np.ndarray:
    """Return heights (nx, ny) on n × n cells for each pixel, without wavelengths shorter than two pixels."""
    from scipy.fft import dctn, idct

    if n == 1:
        return np.array(height, dtype=float)
    # pixels by which a window is extended on each side, at most
    margins = [min(16, size - 1) for size in height.shape]
    extended = np.pad(height, [(k, k) for k in margins], "reflect", reflect_type="odd")
    (x, y), (fine_x, fine_y) = ([_centred(size, k) for size in extended.shape] for k in (1, n))
    along_x = _slope(extended.mean(axis=1), x)
    along_y = _slope(extended.mean(axis=0), y)
    modes = dctn(extended - along_x * x[:, None] - along_y * y, norm="forward")
    rows, columns = (slice(n * k, n * (k + size)) for k, size in zip(margins, height.shape))
    fine = idct(modes, n=fine_x.size, axis=0, norm="forward")[rows]
    fine = idct(fine, n=fine_y.size, axis=1, norm="forward")[:, columns]
    return fine + along_x * fine_x[rows, None] + along_y * fine_y[columns]


def splined(height: np.ndarray, n: int) -> np.ndarray:
    """Return heights (nx, ny) on n × n cells for each pixel, by bicubic splines through the pixel centres."""
    coarse, fine = ([_centred(size, k) for size in height.shape] for k in (1, n))
    return np.ascontiguousarray(bicubic_spline(*coarse, height)(*fine))


def bicubic_spline(x: np.ndarray, y: np.ndarray, height: np.ndarray) -> Any:
    """Return the bicubic spline through heights (nx, ny), of a lower degree through few."""
    from scipy.interpolate import RectBivariateSpline

    return RectBivariateSpline(x, y, height, kx=min(3, x.size - 1), ky=min(3, y.size - 1))


def heights_on_circles(axes, height, middle, radii, angles):
    """Return heights and their slopes outwards (radius, angle) about ``middle``, within cells at two uniform axes."""
    from scipy.ndimage import map_coordinates, spline_filter  # a tenth of `bicubic_spline`'s time at single points

    # cells by which heights are extended: the spline depends on those beyond by 1e-5
    margin = 9
    cell = axes[0][1] - axes[0][0]
    coefficients = spline_filter(np.pad(height, margin, "reflect", reflect_type="odd"), mode="mirror")
    centre = [(place - cells[0]) / cell + margin for place, cells in zip(middle, axes)]
    outwards = np.array([np.cos(angles), np.sin(angles)])

    def heights_at(distance):
        places = np.reshape(centre, (2, 1, 1)) + outwards[:, None] * distance[:, None] / cell
        return map_coordinates(coefficients, places, mode="mirror", prefilter=False)

    # half of the distance between the heights whose difference gives a slope, to some 1e-8 of the largest slope
    step = 1e-4 * cell
    return heights_at(radii), (heights_at(radii + step) - heights_at(radii - step)) / (2 * step)


def _centred(size: int, n: int) -> np.ndarray:
    """Return the positions of n cells for each of ``size`` pixels, in pixels from their middle."""
    return (np.arange(size * n) + 0.5) / n - 0.5 * size


def _slope(height: np.ndarray, place: np.ndarray) -> float:
    return float(height @ place) / max(float(place @ place), 1.0) if place.size > 1 else 0.0
