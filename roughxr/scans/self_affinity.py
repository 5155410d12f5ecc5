"""Test whether a scan is self-affine, a condition to extrapolate its roughness below the pixels.

A self-affine surface has a power-law spectrum with a Hurst exponent from 0 to 1, and a Gaussian curvature. Grains or a
blunt tip skew the curvature. Edges of particles or steps raise its kurtosis.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..kernels.topography.random_surface import HURST, fit_k_correlation
from ..vocabulary.schema import pixel
from . import wavelength
from .fine_scales import fit_band_rings

#: Hurst exponents of the alternative fit: one beyond the self-affine range on either side.
_OTHER_EXPONENTS = HURST[0] - 1.0, HURST[1] + 1.0

#: Not self-affine: the alternative fit lowers chi-squared by more than the first number (5 % significance), or the mean
#: squared residual of the self-affine fit exceeds the second, in squared standard errors.
_FIT_GAIN, _MISFIT = 2.71, 2.0

#: Limits of skewness and excess kurtosis of the curvature, and the least significance in standard errors. These limits
#: refuse few self-affine surfaces imaged with noise by a tip of 5 to 10 nm on pixels of 4 to 10 nm.
_SKEWNESS, _EXCESS_KURTOSIS, _STANDARD_ERRORS = 0.5, 1.0, 3.0

#: Side of the parts, pixels. The median over parts is not affected by debris on a few of them.
_PART_SIDE = 64


def unlike_self_affine(ds: xr.Dataset, shown: float) -> str:
    """Return why a scan is not self-affine down to the wavelength ``shown`` (nm); empty if it is."""
    steps, heights = pixel(ds), ds["height"].values
    parts = wavelength.scan_parts(heights)
    independent = heights.size * 4 * steps[0] * steps[1] / shown**2
    skewness, kurtosis = _moments(heights, steps)
    reasons = ["a spectrum that no power law fits"] if parts is not None and _misfits(parts, steps, shown) else []
    if abs(skewness) > max(_SKEWNESS, _STANDARD_ERRORS * np.sqrt(6 / independent)):
        reasons.append(f"a curvature of skewness {skewness:.2g}, as of grains or under a blunt tip")
    elif abs(kurtosis) > max(_EXCESS_KURTOSIS, _STANDARD_ERRORS * np.sqrt(24 / independent)):
        reasons.append(f"a curvature of excess kurtosis {kurtosis:.2g}, as of particles or steps")
    return " and ".join(reasons)


def _misfits(parts: wavelength.Parts, steps: tuple[float, float], shown: float) -> bool:
    """Return whether the spectrum deviates from that of every self-affine surface."""
    q, psd, modes = fit_band_rings(parts, steps, shown)
    inside, beyond = (
        fit_k_correlation(q, psd, modes, max(steps), bounds=bounds)[2] for bounds in (HURST, _OTHER_EXPONENTS)
    )
    return bool(inside > min(beyond + _FIT_GAIN, _MISFIT * q.size))


def _moments(height: np.ndarray, steps: tuple[float, float]) -> np.ndarray:
    """Return skewness (< 0 if valleys are sharper than summits) and excess kurtosis of the curvature."""
    middle = 2 * height[1:-1, 1:-1]
    along_x, along_y = height[2:, 1:-1] + height[:-2, 1:-1] - middle, height[1:-1, 2:] + height[1:-1, :-2] - middle
    bent = -along_x / steps[0] ** 2 - along_y / steps[1] ** 2
    counts = [max(n // _PART_SIDE, 1) for n in height.shape]
    parts = [part for rows in np.array_split(bent, counts[0]) for part in np.array_split(rows, counts[1], axis=1)]
    scaled = [(part - part.mean()) / part.std() for part in parts if part.std() > 0]
    return np.median([[np.mean(block**3), np.mean(block**4) - 3] for block in scaled] or [[0, 0]], axis=0)
