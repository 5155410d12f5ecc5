"""The shortest wavelength of a scan, which pixels and patches fitted to summits must resolve.

Longer wavelengths contribute 95 % of the mean square curvature ∫ q⁴ C(q) d²q. For a spectrum with a cut-off it is the
cut-off, within 3 % for Hurst exponents from 0 to 0.9. For roughness or noise down to the pixels it is about two pixels:
such a scan does not resolve its summits. Shorter wavelengths contribute 95 % as well below a longest wavelength: up to
1.4 times the shortest on a regular pattern, twice and more on rough surfaces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .cache import cached

#: Pixels along a side of the parts that are used.
_SIDE = 256

#: Largest number of parts along each axis.
_PARTS = 4


class SpectralMeasures(NamedTuple):
    """Wavelengths and the slope of a scan, from its spectrum."""

    shortest: float  # wavelength, nm
    longest: float  # nm, of the wavelengths that contribute to the curvature
    slope: float  # root mean square, 1


class Parts(NamedTuple):
    """The mean spectrum of a scan's parts."""

    squares: np.ndarray  # |h(q)|², nm²; their sum is the mean square height
    number: int  # of parts


@cached
def spectral_measures(heights: np.ndarray, steps: tuple[float, float]) -> SpectralMeasures:
    """Return wavelengths and slope of heights on pixels of these steps (nm); NaN if pixels are missing.

    Examples
    --------
    >>> from roughxr.scans import synthetic
    >>> scan = synthetic.self_affine((256, 256), 10, rms=1.5, hurst=0.8, rolloff=300, cutoff=60, seed=1)
    >>> 58 < spectral_measures(scan.height.values, (10.0, 10.0)).shortest < 63
    True
    """
    parts = scan_parts(heights)
    return SpectralMeasures(np.nan, np.nan, np.nan) if parts is None else spectrum_measures(parts.squares, steps)


def scan_parts(heights: np.ndarray) -> Parts | None:
    """Return the mean spectrum of evenly spread parts without missing pixels; None if there are none."""
    sides = [min(_SIDE, n) for n in heights.shape]
    starts = [
        np.unique(np.linspace(0, n - side, min(_PARTS, -(-n // side))).astype(int)).tolist()
        for n, side in zip(heights.shape, sides)
    ]
    parts = [heights[i : i + sides[0], j : j + sides[1]].astype(float) for i in starts[0] for j in starts[1]]
    squares = [_squares(part) for part in parts if np.isfinite(part).all()]
    return Parts(np.mean(squares, axis=0), len(squares)) if squares else None


def _squares(height: np.ndarray) -> np.ndarray:
    """Return |h(q)|² (nm²) of a part less its plane, under a Hann window of mean square one."""
    largest = np.abs(height).max()
    x, y = (np.arange(n) - 0.5 * (n - 1) for n in height.shape)
    height = height - height.mean()
    tilt_x = (x @ height).sum() / (x @ x * y.size)
    tilt_y = (height @ y).sum() / (y @ y * x.size)
    height -= tilt_x * x[:, None] + tilt_y * y[None, :]
    # largest rounding error of heights less their plane, over the largest height
    rounding = 1e-11
    if np.abs(height).max() <= rounding * largest:
        height[:] = 0.0
    windows = (0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(n) + 0.5) / n) for n in height.shape)
    window = np.multiply.outer(*windows)
    return np.abs(np.fft.fft2(height * window / np.sqrt(np.mean(window**2)))) ** 2 / height.size**2


def spectrum_measures(squares: np.ndarray, steps: tuple[float, float]) -> SpectralMeasures:
    """Return wavelengths and slope from the mean spectrum of a scan's parts."""
    wavenumber = np.hypot.outer(*map(np.fft.fftfreq, squares.shape, steps))
    slope = 2 * np.pi * float(np.sqrt((wavenumber**2 * squares).sum()))
    order = np.argsort(wavenumber, axis=None, kind="stable")
    summed = np.cumsum((wavenumber**4 * squares).ravel()[order])
    if not summed[-1] > 0:
        return SpectralMeasures(np.inf, np.inf, slope)
    # share of the mean square curvature below the shortest wavelength, and above the longest
    neglected_share = 0.05
    ends = np.searchsorted(summed, np.array([1 - neglected_share, neglected_share]) * summed[-1])
    shortest, longest = 1 / wavenumber.ravel()[order][ends]
    return SpectralMeasures(float(shortest), float(longest), slope)
