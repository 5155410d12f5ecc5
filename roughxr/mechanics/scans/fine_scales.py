"""The self-affine spectrum of a scan's shortest wavelengths, and a scan without wavelengths below a cut-off."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..kernels.topography.random_surface import HURST, fit_k_correlation
from ..vocabulary.refusal import Refusal
from ..vocabulary.schema import finite, label, pixel, verb
from ..vocabulary.units import Quantity, positive, single
from . import wavelength
from .spectra import ring_means

#: Fit band: longest over shortest fitted wavelength. Particles on the scan dominate longer wavelengths; a narrower band
#: leaves too few of them.
_FIT_BAND = 5.0

#: Variables of `self_affine_fit`.
_NAMES = (
    "psd_plateau",
    "rolloff_wavelength",
    "hurst_exponent",
    "shortest_wavelength",
    "psd_standard_error",
    "hurst_standard_error",
)

#: Coefficients of a windowed spectrum for each independent one: q and −q are equal, and neighbours are correlated.
_REPEATED = 4.0


@verb("scan")
def self_affine_fit(ds: xr.Dataset, *, hurst: float | None = None, shown: Quantity | None = None) -> xr.Dataset:
    """Fit the self-affine spectrum with a roll-off to a scan's own.

    Parameters
    ----------
    ds : Dataset
        A scan. At most 16 parts of 256 × 256 pixels, spread over it, are used.
    hurst : float, optional
        Fixed Hurst exponent, from 0 to 1; by default it is fitted.
    shown : number or quantity, optional
        The shortest wavelength that the scan shows correctly, nm. By default 95 % of the mean square curvature comes
        from longer wavelengths, and it is at least two pixels. State a larger value for a blunt tip.

    Returns
    -------
    Dataset
        ``hurst_exponent``, ``rolloff_wavelength`` (nm), ``psd_plateau`` (nm⁴) and the ``shortest_wavelength`` (nm) of
        the fit; ``psd_standard_error``, that of ln C at the shortest wavelength, and ``hurst_standard_error``, that of
        H below it. NaN if the scan is flat or every part has missing pixels.

    Notes
    -----
    ln C(q) with C(q) = C₀ [1 + (ℓ₀q/2π)²]^−(1 + H) is fitted over wavelengths from the shortest to five times that.
    The width over which each pixel averages is fitted as well. The prior of H is 0.5 ± 0.5. On synthetic surfaces of
    512² pixels the error of H is 0.1. An H of 1 or 0 is at its bound.

    References
    ----------
    Persson et al., J. Phys.: Condens. Matter 17 (2005) R1, doi:10.1088/0953-8984/17/1/R01.

    Examples
    --------
    >>> import roughxr
    >>> from roughxr.scans import synthetic
    >>> made = synthetic.self_affine((256, 256), 10, rms=1.5, hurst=0.7, rolloff=300, seed=1)
    >>> fitted = roughxr.scans.self_affine_fit(made)
    >>> abs(float(fitted.hurst_exponent) - 0.7) < 0.1
    True
    """
    hurst = None if hurst is None else hurst_exponent(hurst)
    shown = _given_wavelength(shown, ds)
    fitted = _fitted(wavelength.scan_parts(ds["height"].values), pixel(ds), hurst, shown)
    return label(xr.Dataset(fitted))


def _fitted(
    parts: wavelength.Parts | None, steps: tuple[float, float], hurst: float | None, shown: float | None
) -> dict[str, float]:
    """Return the model of the spectrum of a scan's parts with its errors; NaN if all are flat or incomplete."""
    least = np.nan if parts is None else wavelength.spectrum_measures(parts.squares, steps).shortest
    shown = max(least, 2.0 * max(steps)) if shown is None else shown
    if parts is None or not np.isfinite(shown):
        return dict.fromkeys(_NAMES, np.nan) | {"shortest_wavelength": shown}
    q, psd, modes = rings(parts.squares, steps)
    inside = (2 * np.pi / q >= shown) & (2 * np.pi / q <= _FIT_BAND * shown)
    model, spread = fit_k_correlation(q[inside], psd[inside], modes[inside] * parts.number, max(steps), hurst)
    steeper = np.sqrt(max(spread[0, 0] + spread[1, 1] - 2 * spread[0, 1], 0.0)) / (2 * np.log(8))
    return dict(zip(_NAMES, [*model.tolist(), shown, float(np.sqrt(spread[0, 0])), float(steeper)]))


def rings(squares: np.ndarray, steps: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return wavevector (nm⁻¹), C(q) (nm⁴) and number of independent coefficients of each ring of a spectrum."""
    shape = squares.shape
    per_nm = np.hypot(np.fft.fftfreq(shape[0], steps[0])[:, None], np.fft.fftfreq(shape[1], steps[1]))
    width = 1 / min(n * step for n, step in zip(shape, steps))
    q, psd, members = ring_means(squares, per_nm, width)
    scale = steps[0] * steps[1] * squares.size
    occupied = members > 0
    occupied[0] = False
    return 2 * np.pi * q[occupied], scale * psd[occupied], members[occupied] / _REPEATED


@verb("scan")
def smooth(ds: xr.Dataset, *, shortest: Quantity) -> xr.Dataset:
    """Return the scan without wavelengths below a cut-off.

    Parameters
    ----------
    ds : Dataset
        A scan without missing pixels.
    shortest : number or quantity
        Shortest remaining wavelength, nm.

    Returns
    -------
    Dataset
        On the same pixels. The scan is mirrored at its edges. A second application changes nothing.

    Notes
    -----
    A sharp cut-off in the scan's cosine transform, not the Gaussian filter of ISO 16610: each wavelength stays or goes
    entirely, as in theories of a spectrum with a cut-off.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> smoother = roughxr.scans.smooth(scan, shortest="100 nm")
    >>> float(smoother.height.std()) < float(scan.height.std())
    True
    """
    from scipy.fft import idctn

    shortest = positive(shortest, "nm", "shortest")
    longest = 2 * max(n * step for n, step in zip(ds["height"].shape, pixel(ds)))
    if shortest > longest:
        raise Refusal("shortest", f"at most twice the scan's length, {longest:g} nm", f"{shortest:g} nm")
    coefficients, frequency = _cosine_transform(ds)
    coefficients[frequency * shortest > 1 + 1e-12] = 0.0
    height = idctn(coefficients, norm="ortho", overwrite_x=True)
    return label(ds.assign(height=(("x", "y"), height)))


def _cosine_transform(ds: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients of a scan's orthonormal cosine transform, and 1/wavelength (1/nm) of each."""
    from scipy.fft import dctn

    heights = finite(ds["height"].values).astype(float)
    along = (np.arange(n) / (2 * n * step) for n, step in zip(heights.shape, pixel(ds)))
    return dctn(heights, norm="ortho"), np.hypot(*np.meshgrid(*along, indexing="ij"))


def hurst_exponent(value: Any) -> float:
    """Return a Hurst exponent; raise unless it is a number from 0 to 1."""
    return single(value, "1", "hurst", "a number from 0 to 1", lambda number: HURST[0] <= number <= HURST[1])


def _given_wavelength(value: Any, scan: xr.Dataset) -> float | None:
    """Return the given shortest wavelength (nm), None to estimate it."""
    if value is None:
        return None
    number = positive(value, "nm", "shown")
    least = 2 * max(pixel(scan))
    if number < least * (1 - 1e-9):
        raise Refusal("shown", f"at least two pixels, {least:g} nm", f"{number:g} nm")
    return number
