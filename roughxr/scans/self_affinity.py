"""Whether a scan looks like a self-affine surface, which alone can be extrapolated below its pixels.

Its spectrum falls as that of Hurst exponents from 0 to 1, and its curvature is Gaussian: grains or a blunt tip skew it,
sharp edges of a few particles or steps raise its kurtosis.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..kernels.topography.random_surface import HURST, fit_k_correlation
from ..vocabulary.schema import pixel
from . import wavelength
from .fine_scales import in_band

#: Hurst exponents that are tried beside those of self-affine surfaces, as far to either side.
_OTHER_EXPONENTS = HURST[0] - 1.0, HURST[1] + 1.0

#: One of them must lower the sum of squared errors by this, as chance does in one case of twenty. A spectrum that is
#: off by more than so many squared errors in the mean is fitted by no power law.
_FIT_GAIN, _MISFIT = 2.71, 2.0

#: Skewness and excess kurtosis of a curvature that is no longer Gaussian, and at least so many standard errors. With
#: these limits few self-affine surfaces are refused that a tip of 5 to 10 nm draws on pixels of 4 to 10 nm with noise.
_SKEWNESS, _EXCESS_KURTOSIS, _STANDARD_ERRORS = 0.5, 1.0, 3.0

#: Pixels along a side of the parts whose median is taken, so that debris on a few of them does not count.
_PART_SIDE = 64


def unlike_self_affine(ds: xr.Dataset, shown: float) -> str:
    """Return what of a scan that shows waves down to a shortest one (nm) no self-affine surface would have."""
    steps, heights = pixel(ds), ds["height"].values
    spectra = [wavelength.spectrum(heights[part]) for part in wavelength.parts(heights.shape)]
    independent = heights.size * 4 * steps[0] * steps[1] / shown**2
    skewness, kurtosis = _moments(heights, steps)
    reasons = ["a spectrum that no power law fits"] if _off(spectra, steps, shown) else []
    if abs(skewness) > max(_SKEWNESS, _STANDARD_ERRORS * np.sqrt(6 / independent)):
        reasons.append(f"a curvature of skewness {skewness:.2g}, as of grains or under a blunt tip")
    elif abs(kurtosis) > max(_EXCESS_KURTOSIS, _STANDARD_ERRORS * np.sqrt(24 / independent)):
        reasons.append(f"a curvature of excess kurtosis {kurtosis:.2g}, as of particles or steps")
    return " and ".join(reasons)


def _off(spectra: list, steps: tuple[float, float], shown: float) -> bool:
    """Return whether another exponent fits better than that of any self-affine surface, or none fits."""
    q, psd, modes = in_band(spectra, steps, shown)
    inside, beyond = (
        fit_k_correlation(q, psd, modes, max(steps), bounds=bounds)[2] for bounds in (HURST, _OTHER_EXPONENTS)
    )
    return bool(inside > min(beyond + _FIT_GAIN, _MISFIT * q.size))


def _moments(height: np.ndarray, steps: tuple[float, float]) -> np.ndarray:
    """Return the skewness of the curvature, below 0 where valleys are sharper than summits, and its excess kurtosis."""
    middle = 2 * height[1:-1, 1:-1]
    along_x, along_y = height[2:, 1:-1] + height[:-2, 1:-1] - middle, height[1:-1, 2:] + height[1:-1, :-2] - middle
    bent = -along_x / steps[0] ** 2 - along_y / steps[1] ** 2
    counts = [max(n // _PART_SIDE, 1) for n in height.shape]
    parts = [part for rows in np.array_split(bent, counts[0]) for part in np.array_split(rows, counts[1], axis=1)]
    scaled = [(part - part.mean()) / part.std() for part in parts if part.std() > 0]
    return np.median([[np.mean(block**3), np.mean(block**4) - 3] for block in scaled] or [[0, 0]], axis=0)
