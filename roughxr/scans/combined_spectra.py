"""One power spectrum from scans of several sizes of one surface, each used where size and pixels allow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary.schema import label, pixel, record, validate
from ..vocabulary.units import positive, whole_number
from ..vocabulary.verbs import verb
from .spectra import power_spectrum

#: A scan is used for waves shorter than this part of its side, and longer than this many pixels.
_LONGEST, _PIXELS = 0.5, 4.0


@verb
def combined_spectrum(
    scans: Sequence[xr.Dataset], *, window: str | None = "hann", shortest: Any = None, per_decade: int = 10
) -> xr.Dataset:
    """Return the power spectrum of a surface from scans of several sizes.

    Parameters
    ----------
    scans : sequence of Dataset
        Levelled, of one surface; of any sizes and pixels.
    window : str, optional
        See `power_spectrum`; without one the scans' edges look like steps.
    shortest : number or quantity, optional
        Shortest wavelength, nm, for which the scans are used, for example that below which the tip rounds the image;
        at least four pixels of each scan.
    per_decade : int
        Bins of wavevectors.

    Returns
    -------
    Dataset
        ``psd`` (nm⁴) over ``wavevector`` (nm⁻¹), the mean over all modes of a bin, whichever scan has them;
        ``psd_modes``, their number; ``psd_between_std`` (nm⁴), the standard deviation from scan to scan where
        several reach a bin, and ``psd_scans``, how many do. Bins that no scan reaches are left out.

    Raises
    ------
    ValueError
        If there is no scan, or none reaches a usable wavelength.

    Examples
    --------
    >>> from roughxr.scans.synthetic import self_affine
    >>> make = {"rms": 1.5, "hurst": 0.8, "rolloff": 400}
    >>> found = combined_spectrum([self_affine((64, 64), step, seed=1, **make) for step in (5, 20)])
    >>> bool(found.wavevector.min() < 0.02 and found.wavevector.max() > 0.2), int(found.psd_scans.max())
    (True, 2)
    """
    if len(scans) == 0:
        raise ValueError("scans: expected at least one, found none")
    whole_number(per_decade, "per_decade", least=1)
    least = 0.0 if shortest is None else positive(shortest, "nm", "shortest")
    parts = [_usable(validate(one, "scan"), window, least) for one in scans]
    bins = [np.floor(per_decade * np.log10(q)).astype(int) for q, _, _ in parts]
    if not sum(one.size for one in bins):
        raise ValueError(f"shortest: expected waves that a scan reaches, found none down to {least:g} nm")
    known = np.unique(np.concatenate(bins))
    sums = np.array([_binned(np.searchsorted(known, at), *part, known.size) for at, part in zip(bins, parts)])
    modes, power, wave = np.moveaxis(sums, 1, 0)
    total = modes.sum(axis=0)
    means = np.divide(power, modes, out=np.full(power.shape, np.nan), where=modes > 0)
    out = xr.Dataset(
        {
            "psd": ("wavevector", power.sum(axis=0) / total),
            "psd_modes": ("wavevector", total),
            "psd_between_std": ("wavevector", _spread(means)),
            "psd_scans": ("wavevector", (modes > 0).sum(axis=0)),
        },
        {"wavevector": wave.sum(axis=0) / total},
    )
    given = {"window": window, "shortest": shortest, "per_decade": per_decade}
    return record(label(out), "combined_spectrum", scans[0], scans=len(scans), **given)


def _usable(scan: xr.Dataset, window: str | None, least: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the wavevectors for which a scan is used, their spectrum and their numbers of modes."""
    found = power_spectrum(scan, window=window)
    side = min(scan.sizes[axis] * step for axis, step in zip("xy", pixel(scan)))
    shortest = max(_PIXELS * max(pixel(scan)), least)
    q, psd, modes = (found[name].values.astype(float) for name in ("wavevector", "psd", "psd_modes"))
    inside = (q > 2 * np.pi / (_LONGEST * side)) & (q <= 2 * np.pi / shortest) & np.isfinite(psd)
    return q[inside], psd[inside], modes[inside]


def _binned(at: np.ndarray, q: np.ndarray, psd: np.ndarray, modes: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the sums of modes, power and wavevectors in each bin."""
    return [np.bincount(at, weights, count) for weights in (modes, modes * psd, modes * q)]


def _spread(means: np.ndarray) -> np.ndarray:
    """Return the standard deviation over scans, NaN where one alone reaches."""
    count = np.isfinite(means).sum(axis=0)
    off = means - np.nansum(means, axis=0) / np.maximum(count, 1)
    return np.sqrt(np.divide(np.nansum(off**2, axis=0), count - 1, out=np.full(count.shape, np.nan), where=count > 1))
