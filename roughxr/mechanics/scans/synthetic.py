"""Synthetic surfaces from a seed, equal on any machine and with any version of the libraries."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..kernels.topography.random_surface import normal
from ..vocabulary import schema
from ..vocabulary.calls import checked_call
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Quantity, is_whole, positive, whole_number
from .fine_scales import hurst_exponent

#: Separate PCG64 streams for heights and for particles on them, so that they are independent.
HEIGHTS, OTHERS = 0, 1


@checked_call
@schema.recorded
def self_affine(
    shape: tuple[int, int],
    pixel: Quantity,
    *,
    rms: Quantity,
    hurst: float,
    rolloff: Quantity,
    cutoff: Quantity | None = None,
    seed: int,
) -> xr.Dataset:
    """Return a Gaussian random surface with a power-law spectrum.

    White noise is filtered so that the spectral density at wavelength ℓ goes as [1 + (rolloff/ℓ)²]^−(1 + hurst):
    flat at wavelengths above the roll-off, self-affine below. The surface is periodic.

    Parameters
    ----------
    shape : (int, int)
        Pixels along x and y, at least 2.
    pixel, rms : number or quantity
        Side of a pixel, and standard deviation of this surface's heights, whose mean is zero, nm.
    hurst : float
        Hurst exponent, between 0 and 1; the density falls as q^−2(1 + hurst).
    rolloff : number or quantity
        Roll-off wavelength, nm.
    cutoff : number or quantity, optional
        Shortest wavelength, nm; by default two pixels.
    seed : int
        The same seed gives the same surface.

    Returns
    -------
    Dataset
        A scan: ``height`` (x, y), nm, with its parameters in the attributes.

    References
    ----------
    Persson et al., On the nature of surface roughness, J. Phys.: Condens. Matter 17 (2005) R1,
    doi:10.1088/0953-8984/17/1/R01, for the spectrum; the smooth crossover is the K-correlation model.

    Examples
    --------
    >>> scan = self_affine((64, 32), 10, rms="1.5 nm", hurst=0.8, rolloff="0.2 um", seed=7)
    >>> dict(scan.sizes), round(float(scan.height.std()), 6)
    ({'x': 64, 'y': 32}, 1.5)
    """
    shape = _shape(shape)
    seed = whole_number(seed, "seed", least=0)
    pixel, rms, rolloff = (
        positive(value, "nm", name) for value, name in ((pixel, "pixel"), (rms, "rms"), (rolloff, "rolloff"))
    )
    cutoff = None if cutoff is None else positive(cutoff, "nm", "cutoff")
    hurst = hurst_exponent(hurst)
    made = {"pixel": pixel, "rms": rms, "hurst": hurst, "rolloff": rolloff, "cutoff": cutoff, "seed": seed}
    height = rms * unit_surface(shape, pixel, hurst, rolloff, cutoff, seed)
    return labelled(height, pixel, "Self-affine random surface", made)


def unit_surface(shape, pixel, hurst, rolloff, cutoff, seed) -> np.ndarray:
    """Return filtered white noise of mean 0 and standard deviation 1."""
    from scipy.fft import irfft2, rfft2

    noise = normal(shape, seed, HEIGHTS)
    per_nm = np.hypot(np.fft.fftfreq(shape[0], pixel)[:, None], np.fft.rfftfreq(shape[1], pixel))
    amplitude = (1 + (rolloff * per_nm) ** 2) ** (-(1 + hurst) / 2)
    amplitude[0, 0] = 0.0
    if cutoff is not None:
        amplitude[per_nm * cutoff > 1] = 0.0
        if not amplitude.any():
            longest = pixel * max(shape)
            raise Refusal("cutoff", f"at most the scan's length of {longest:g} nm", f"{cutoff:g} nm")
    surface = irfft2(rfft2(noise) * amplitude, s=shape)
    return surface / surface.std()


def labelled(height: np.ndarray, pixel: float, title: str, made: dict[str, Any]) -> xr.Dataset:
    """Return heights as a scan with the parameters of its making in the attributes."""
    axes = {axis: (axis, (np.arange(n) + 0.5) * pixel) for axis, n in zip("xy", height.shape)}
    attrs: dict[str, Any] = {"title": title, "synthetic": "yes", "source": "roughxr.scans.synthetic"}
    attrs |= {name: list(v) if isinstance(v, tuple) else v for name, v in made.items() if v is not None}
    return schema.label(xr.Dataset({"height": (("x", "y"), height)}, coords=axes, attrs=attrs))


def _shape(shape: Any) -> tuple[int, int]:
    sizes = tuple(shape) if isinstance(shape, (tuple, list)) else ()
    if len(sizes) != 2 or not all(is_whole(n) and n >= 2 for n in sizes):
        raise Refusal("shape", "two whole numbers of pixels of at least 2", f"{shape!r}")
    return int(sizes[0]), int(sizes[1])
