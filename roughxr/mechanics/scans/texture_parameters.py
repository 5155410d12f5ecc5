"""Spatial and functional parameters of ISO 25178-2:2021: Sal, Str, Std, and Sk, Spk, Svk.

Sal and Str are the least distance at which the autocorrelation falls to 0.2, and its ratio to the largest one. The
autocorrelation at each lag is the mean over all pairs of pixels. Std is the direction of the largest amplitude of the
spectrum. Sk is the height of the equivalent line of the material ratio curve: least squares over the 40 % of the curve
whose secant is least steep. Spk and Svk are the heights of triangles with the areas of peaks and valleys beyond it.
"""

from __future__ import annotations

import numpy as np

#: Names of the parameters.
NAMES = ("s_al", "s_tr", "s_td", "s_k", "s_pk", "s_vk")

#: Points of the material ratio curve, and width of the part that its line fits.
_RATIOS = 10_001
_LINE_WIDTH = 0.4

#: Width of the classes of directions, and points of a ray of the autocorrelation.
_DIRECTION_STEP = np.pi / 360
_RAY_POINTS = 300


def texture_parameters(height: np.ndarray, pixel: tuple[float, float]) -> np.ndarray:
    """Return the `NAMES` of heights (x, y) about their plane; spatial ones are NaN if pixels are missing."""
    core = _core_parameters(height[np.isfinite(height)])
    if not np.isfinite(height).all() or np.ptp(height) == 0:
        return np.array([np.nan, np.nan, np.nan, *core])
    return np.array([*_decay_lengths(_autocorrelation(height), pixel), _direction(height, pixel), *core])


def _core_parameters(height: np.ndarray) -> tuple[float, float, float]:
    """Return Sk, Spk and Svk, nm."""
    if height.size < 2:
        return np.nan, np.nan, np.nan
    ratio = np.linspace(0, 1, _RATIOS)
    # as `np.quantile`, which takes half a second for so many of a scan of 200 × 160 pixels
    curve = np.interp((1 - ratio) * (height.size - 1), np.arange(height.size), np.sort(height))
    span = round(_LINE_WIDTH * (_RATIOS - 1))
    start = int(np.argmax(curve[span:] - curve[:-span]))
    slope, upper = np.polyfit(ratio[start : start + span + 1], curve[start : start + span + 1], 1)
    lower = upper + slope
    return float(upper - lower), _triangle(ratio, curve - upper), _triangle(1 - ratio[::-1], (lower - curve)[::-1])


def _triangle(ratio: np.ndarray, excess: np.ndarray) -> float:
    """Return the height of a triangle as wide and large as the part of a falling curve above 0."""
    above = int(np.argmax(excess <= 0)) if (excess <= 0).any() else excess.size
    if above < 1:
        return 0.0
    share = np.interp(0.0, -excess[above - 1 : above + 1], ratio[above - 1 : above + 1])
    area = np.trapezoid(np.append(excess[:above], 0.0), np.append(ratio[:above], share))
    return float(2 * area / share) if share > 0 else 0.0


def _autocorrelation(height: np.ndarray) -> np.ndarray:
    """Return the autocorrelation of heights at all lags of their parts, 1 at none, which is in the middle."""
    from scipy.fft import fftshift, irfft2, next_fast_len, rfft2

    # larger scans are averaged over parts
    shape = [min(size, 1024) for size in height.shape]
    starts = [_part_starts(size, part) for size, part in zip(height.shape, shape)]
    padded = [next_fast_len(2 * part - 1, real=True) for part in shape]
    power: np.ndarray | float = 0.0
    centred = height - height.mean()
    for x in starts[0]:
        for y in starts[1]:
            part = centred[x : x + shape[0], y : y + shape[1]]
            power = power + np.abs(rfft2(part, padded)) ** 2
    lags = tuple(slice(size // 2 - part + 1, size // 2 + part) for size, part in zip(padded, shape))
    total = fftshift(irfft2(power, padded))[lags]
    pairs = [part - np.abs(np.arange(1 - part, part)) for part in shape]
    mean = total / np.outer(*pairs)
    return mean / mean[shape[0] - 1, shape[1] - 1]


def _part_starts(size: int, part: int) -> np.ndarray:
    """Return the first pixels of evenly spread parts along a side, two at most."""
    count = min(size // part, 2)
    return np.linspace(0, size - part, count).astype(int)


def _decay_lengths(correlation: np.ndarray, pixel: tuple[float, float]) -> tuple[float, float]:
    """Return Sal (nm) and Str; Str is NaN if the autocorrelation falls too slowly for the scan along some direction."""
    from scipy.ndimage import binary_dilation, label, map_coordinates

    centre = np.array(correlation.shape) // 2
    # autocorrelation at which heights count as independent
    independent = 0.2
    regions = label(correlation > independent)[0]
    region = regions == regions[tuple(centre)]
    ends = np.argwhere(binary_dilation(region) & ~region)
    if not len(ends):
        return np.nan, np.nan
    along = np.linspace(0, 1, _RAY_POINTS)
    rays = centre[:, None, None] + (ends - centre).T[:, :, None] * along
    values = map_coordinates(correlation, rays.reshape(2, -1), order=3).reshape(len(ends), _RAY_POINTS)
    crossing = along[np.argmin(np.abs(values - independent), axis=1)]
    lengths = crossing * np.hypot(*((ends - centre) * pixel).T)
    touches = region[0].any() or region[-1].any() or region[:, 0].any() or region[:, -1].any()
    return float(lengths.min()), np.nan if touches else float(lengths.min() / lengths.max())


def _direction(height: np.ndarray, pixel: tuple[float, float]) -> float:
    """Return Std, the direction of the largest amplitude in the spectrum, from x towards y, rad in 0 … π."""
    amplitude = np.abs(np.fft.fft2(height - height.mean()))
    along_x, along_y = (np.fft.fftfreq(size, step) for size, step in zip(height.shape, pixel))
    angle = np.arctan2(along_y[None, :], along_x[:, None]) % np.pi
    classes = np.minimum((angle / _DIRECTION_STEP).astype(int), round(np.pi / _DIRECTION_STEP) - 1)
    return float(np.argmax(np.bincount(classes.ravel(), amplitude.ravel())) * _DIRECTION_STEP)
