"""One power spectrum from maps and lines of several sizes of one surface, each within its size and pixels.

A line through an isotropic surface of spectrum C has the spectrum C¹(q) = (1/π) ∫ C(√(q² + k²)) dk. Their ratio is that
of the K-correlation model: C/C¹ = 2√π Γ(1 + H)/Γ(½ + H)/√(q² + (2π/ℓ₀)²), with ℓ₀ and H of a fit to the line's own
spectrum, C¹ ~ [1 + (ℓ₀q/2π)²]^−(½ + H).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ..kernels.topography.random_surface import HURST, fit_k_correlation
from ..vocabulary.refusal import Refusal
from ..vocabulary.schema import label, pixel, record, validate
from ..vocabulary.units import Quantities, plain, positive, whole_number
from .spectra import power_spectrum, unit_window

#: Window by which heights are multiplied: without a window the scans' edges act as steps.
_WINDOW = "hann"


def combined_spectrum(
    scans: Sequence[xr.Dataset],
    *,
    shortest: Quantities | None = None,
    per_decade: int = 10,
) -> xr.Dataset:
    """Return the power spectrum of a surface from scans of several sizes.

    Parameters
    ----------
    scans : sequence of Dataset
        Levelled, of one surface; of any sizes and pixels. Lines are ``height`` along ``x`` alone, at any steps, of an
        isotropic surface.
    shortest : number or quantity, optional
        Shortest wavelength (nm) for which the scans are used, or one value for each scan. Use the wavelength below
        which the tip rounds the image. It is at least four pixels of each scan, or four mean steps of a line.
    per_decade : int
        Bins of wavevectors.

    Returns
    -------
    Dataset
        ``psd`` (nm⁴) over ``wavevector`` (nm⁻¹), the mean over all modes of all scans in a bin; ``psd_modes``, the
        number of modes; ``psd_scans``, the number of scans with modes in the bin; ``psd_between_std`` (nm⁴), the
        standard deviation between these scans. Bins without modes are left out.

    Examples
    --------
    >>> import roughxr
    >>> from roughxr.scans import synthetic
    >>> make = {"rms": 1.5, "hurst": 0.8, "rolloff": 400}
    >>> made = [synthetic.self_affine((64, 64), step, seed=1, **make) for step in (5, 20)]
    >>> spectrum = roughxr.scans.combined_spectrum(made)
    >>> bool(spectrum.wavevector.min() < 0.02 and spectrum.wavevector.max() > 0.2), int(spectrum.psd_scans.max())
    (True, 2)
    """
    if len(scans) == 0:
        raise Refusal("scans", "at least one", "none")
    whole_number(per_decade, "per_decade", least=1)
    least = _least(shortest, len(scans))
    parts = [
        (_usable if "y" in scan.dims else _usable_line)(scan, wavelength) for scan, wavelength in zip(scans, least)
    ]
    bins = [np.floor(per_decade * np.log10(q)).astype(int) for q, _, _ in parts]
    if not sum(scan.size for scan in bins):
        raise Refusal("shortest", "at most the longest wavelength of some scan", f"{min(least):g} nm")
    wavevectors = np.unique(np.concatenate(bins))
    sums = np.array(
        [_binned(np.searchsorted(wavevectors, at), *part, wavevectors.size) for at, part in zip(bins, parts)]
    )
    modes, power, wavevector = np.moveaxis(sums, 1, 0)
    total = modes.sum(axis=0)
    means = np.ma.divide(power, modes)  # masked without modes
    out = xr.Dataset(
        {
            "psd": ("wavevector", power.sum(axis=0) / total),
            "psd_modes": ("wavevector", total),
            "psd_between_std": ("wavevector", np.ma.filled(means.std(axis=0, ddof=1), np.nan)),
            "psd_scans": ("wavevector", (modes > 0).sum(axis=0)),
        },
        {"wavevector": wavevector.sum(axis=0) / total},
    )
    arguments = {"shortest": shortest, "per_decade": per_decade}
    return record(label(out), "combined_spectrum", scans[0], scans=len(scans), **arguments)


def _least(shortest: Any, count: int) -> list[float]:
    """Return the shortest wavelength (nm) for which each scan may be used."""
    shortest = plain(shortest, "nm", "shortest") if shortest is not None else None
    stated = list(shortest) if isinstance(shortest, (list, tuple, np.ndarray)) else [shortest] * count
    if len(stated) != count:
        raise Refusal("shortest", f"one wavelength, or one for each of {count} scans", len(stated))
    return [0.0 if wavelength is None else positive(wavelength, "nm", "shortest") for wavelength in stated]


def _usable(scan: xr.Dataset, least: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the wavevectors for which a scan is used, the spectrum and the numbers of modes."""
    scan = validate(scan, "scan")
    spectrum = power_spectrum(scan, window=_WINDOW)
    side = min(scan.sizes[axis] * step for axis, step in zip("xy", pixel(scan)))
    q, psd, modes = (spectrum[name].values.astype(float) for name in ("wavevector", "psd", "psd_modes"))
    inside = _resolved(q, side, max(pixel(scan)), least) & np.isfinite(psd)
    return q[inside], psd[inside], modes[inside]


def _resolved(q: np.ndarray, side: float, step: float, least: float) -> np.ndarray:
    """Return a mask of the wavevectors that a scan of this size and step resolves."""
    # longest wavelength used of a scan, as a part of its side, and shortest, in pixels
    return (q > 2 * np.pi / (0.5 * side)) & (q <= 2 * np.pi / max(4.0 * step, least))


def _usable_line(line: xr.Dataset, least: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the wavevectors for which a line is used, the spectrum of its surface and the numbers of modes."""
    from scipy.interpolate import make_interp_spline
    from scipy.special import gamma

    x = validate(line, "line")["x"].values
    heights = line["height"].values
    if not (np.isfinite(heights).all() and x.size >= 4 and (np.diff(x) > 0).all()):
        raise Refusal("height", "four heights of a line or more, none missing, along ascending x")
    even, step = np.linspace(x[0], x[-1], x.size, retstep=True)
    weights = unit_window(_WINDOW, (x.size,))
    psd = step / x.size * np.abs(np.fft.rfft(weights * make_interp_spline(x, heights)(even))) ** 2
    q = 2 * np.pi * np.fft.rfftfreq(x.size, step)
    inside = _resolved(q, x.size * step, step, least)
    # least number of wavevectors for a fit of the model to a line
    inside &= inside.sum() >= 4
    q = q[inside]
    psd = psd[inside]
    bounds = HURST[0] - 0.5, HURST[1] - 0.5
    (_, rolloff, half), _ = fit_k_correlation(q, psd, np.ones(q.size), bounds=bounds)
    hurst = half + 0.5
    surface = 2 * np.sqrt(np.pi) * gamma(1 + hurst) / gamma(0.5 + hurst) / np.hypot(q, 2 * np.pi / rolloff) * psd
    return q, surface, np.full(q.size, 2.0)


def _binned(at: np.ndarray, q: np.ndarray, psd: np.ndarray, modes: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the sums of modes, power and wavevectors in each bin."""
    return [np.bincount(at, weights, count) for weights in (modes, modes * psd, modes * q)]
