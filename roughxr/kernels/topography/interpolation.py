"""Heights between the pixels.

`band_limited` gives the one surface through the pixel centres that has no wave shorter than two pixels: of a scan that
resolves its surface it is that surface. Its waves are those of a cosine transform, whose cells lie as pixels do, at
(j + ½)/N of the window's length (DCT-II; Strang, SIAM Review 41 (1999) 135), so that finer cells need only be asked.
Beyond its edges the window is continued by its mirror image, after a plane is taken off, whose kink would be seen
farthest; what is left of it falls off as the square of the distance from the edge. Steps, which no such surface has,
ring by a tenth of their height.

`splined` is the smoother choice, whose waves of two to three pixels come out some per cent lower and which rings less.
By what results differ between both it is told how much they hang on what no pixel shows.
"""

import numpy as np


def band_limited(height: np.ndarray, n: int) -> np.ndarray:
    """Return heights (nx, ny) on n × n cells for each pixel, without waves shorter than two pixels."""
    from scipy.fft import dctn, idctn

    if n == 1:
        return np.array(height, dtype=float)
    (x, y), (fine_x, fine_y) = ([_centred(size, k) for size in height.shape] for k in (1, n))
    mean, along_x, along_y = height.mean(), _slope(height.mean(axis=1), x), _slope(height.mean(axis=0), y)
    waves = np.zeros((fine_x.size, fine_y.size))
    left = height - mean - along_x * x[:, None] - along_y * y
    waves[: x.size, : y.size] = dctn(left, norm="forward")
    fine = idctn(waves, norm="forward", overwrite_x=True)
    fine += mean + along_x * fine_x[:, None] + along_y * fine_y
    return fine


def splined(height: np.ndarray, n: int) -> np.ndarray:
    """Return heights (nx, ny) on n × n cells for each pixel, by bicubic splines through the pixel centres."""
    from scipy.interpolate import RectBivariateSpline

    coarse, fine = ([_centred(size, k) for size in height.shape] for k in (1, n))
    order = [min(3, size - 1) for size in height.shape]
    return np.ascontiguousarray(RectBivariateSpline(*coarse, height, kx=order[0], ky=order[1])(*fine))


def _centred(size: int, n: int) -> np.ndarray:
    """Return the places of n cells for each of ``size`` pixels, in pixels from their middle."""
    return (np.arange(size * n) + 0.5) / n - 0.5 * size


def _slope(height: np.ndarray, place: np.ndarray) -> float:
    return float(height @ place) / max(float(place @ place), 1.0) if place.size > 1 else 0.0
