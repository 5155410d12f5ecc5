"""Power spectrum of a height map, averaged over directions, with its normalisation.

Convention of Jacobs, Junge and Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001: with
h~(q) = dx dy sum h exp(-i q r) the two-dimensional spectrum is C(q) = |h~(q)|² / A, in nm⁴, A being the area
of all pixels, so that sum C / A = mean h² (Parseval). ``psd`` is the mean of C over the modes of a ring and
``psd_modes`` their number; rings cover every mode, corners and mean included, so that
sum(psd * psd_modes) / A = mean h² to rounding.
"""

from __future__ import annotations

import functools

import numpy as np
import xarray as xr

from ..vocabulary.schema import label, pixel, validate
from ..vocabulary.text import warn

#: Largest share of missing pixels for a spectrum.
MOST_MISSING = 0.01


def power_spectrum(ds: xr.Dataset, *, window: str | None = None) -> xr.Dataset:
    """Return the power spectrum of a scan's heights, averaged over rings of wavevectors, without levelling.

    Parameters
    ----------
    ds : Dataset
        A scan; level it first, since a tilt leaks into all wavevectors. Missing pixels, up to 1 % of all, are set to
        the mean of the others.
    window : str, optional
        Name of a window of :func:`scipy.signal.get_window`, such as ``"hann"``, by which the heights are
        multiplied; it is scaled to a mean square of one.

    Returns
    -------
    Dataset
        ``psd`` nm⁴ and ``psd_modes`` over ``wavevector`` nm⁻¹ (2 pi over wavelength), the first being zero.
        NaN with a warning and an attribute ``missing`` if more pixels are missing. Rings beyond the attribute
        ``nyquist_wavevector``, π over the pixel, contain corners alone, for Parseval's sum; the figure omits them.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> spectrum = roughxr.scans.power_spectrum(scan)  # Parseval: the mean square height
    >>> bool(abs((spectrum.psd * spectrum.psd_modes).sum() / 5000**2 / (scan.height**2).mean() - 1) < 1e-9)
    True
    """
    scan = validate(ds, "scan")
    shape = (scan.sizes["x"], scan.sizes["y"])
    steps = pixel(scan)
    frequencies = [2 * np.pi * np.fft.fftfreq(n, step) for n, step in zip(shape, steps)]
    radius = np.hypot(frequencies[0][:, None], frequencies[1])
    width = 2 * np.pi / min(n * step for n, step in zip(shape, steps))
    weights = 1.0 if window is None else unit_window(window, shape)
    q, psd, modes = ring_means(_spectrum(scan["height"].values, weights, steps), radius, width)
    maps = {"psd": ("wavevector", psd), "psd_modes": ("wavevector", modes)}
    out = label(xr.Dataset(maps, {"wavevector": q}, scan.attrs | {"nyquist_wavevector": np.pi / max(steps)}))
    share = float(scan["height"].isnull().mean())
    if share > MOST_MISSING:
        out.attrs["missing"] = (
            f"no spectrum: expected at most {100 * MOST_MISSING:g} % missing pixels, found {100 * share:.2g} %; fill "
            "them first (ds.contact.fill()) or crop them away"
        )
        warn(out.attrs["missing"])
    return out


def ring_means(values: np.ndarray, radius: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mean radius, mean value and number of members of rings of this width; NaN radii are left out."""
    inside = ~np.isnan(radius)
    ring = np.rint(radius[inside] / width).astype(int)
    members = np.bincount(ring)
    centre, mean = (
        np.divide(np.bincount(ring, part[inside]), members, out=np.full(members.size, np.nan), where=members > 0)
        for part in (radius, values)
    )
    return np.where(members > 0, centre, np.arange(members.size) * width), mean, members


def unit_window(name: str, shape: tuple[int, ...]) -> np.ndarray:
    """Return a separable window of mean square one."""
    from scipy.signal import get_window

    window = functools.reduce(np.multiply.outer, (get_window(name, n) for n in shape))
    return window / np.sqrt(np.mean(window**2))


def _spectrum(height: np.ndarray, scale: np.ndarray | float, steps: tuple[float, float]) -> np.ndarray:
    """Return C(q) = |dx dy FFT(h)|² / A of a height map, in nm⁴."""
    finite = np.isfinite(height)
    if not finite.all():
        if finite.mean() < 1 - MOST_MISSING:
            return np.full(height.shape, np.nan)
        height = np.where(finite, height, height[finite].mean())
    transformed = np.fft.fft2(height * scale)
    return np.abs(transformed) ** 2 * (steps[0] * steps[1] / height.size)
