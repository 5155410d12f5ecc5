"""Random surfaces of a measured spectrum, extrapolated below its shortest wavelength.

Bands of half an octave of wavelengths, each a sum of Fourier modes h = Σ Re 2c exp(ikr) over half of the plane, with
|c|² = C/P² in the mean, P the period of the band. Bands of shorter wavelengths are added without a change of the
longer ones.
"""

from typing import NamedTuple

import numpy as np

from roughxr.mechanics.kernels.topography.random_surface import fit_k_correlation, k_correlation, normal

#: Period of a band, in its longest wavelengths.
PERIODS = 32

#: Ratio of the longest to the shortest wavelength of a band.
BAND = 2.0**0.5

#: Longest over shortest wavelength of the fit.
FIT_BAND = 5.0

#: Coefficients of a windowed spectrum for each independent one.
REPEATED = 4.0


class Spectrum(NamedTuple):
    """A measured spectrum, with the K-correlation model below its shortest wavelength."""

    log_q: np.ndarray
    log_psd: np.ndarray
    plateau: float  # nm⁴
    rolloff: float  # nm
    hurst: float
    error: float  # of ln C at the shortest wavelength
    hurst_standard_error: float
    tilt: float = 0.0  # shift of ln C, in these standard errors

    def density(self, q):
        """Return C(q), nm⁴."""
        log_q = np.log(q)
        modelled = k_correlation(q, self.plateau, self.rolloff, self.hurst)
        density = np.where(log_q <= self.log_q[-1], np.exp(np.interp(log_q, self.log_q, self.log_psd)), modelled)
        shorter = np.maximum(log_q - self.log_q[-1], 0.0)
        return density * np.exp(self.tilt * (self.error + 2 * self.hurst_standard_error * shorter))


def extrapolated_spectrum(measured):
    """Return a measured spectrum with the model fitted to its shortest wavelengths."""
    q, psd = (measured[name].values for name in ("wavevector", "psd"))
    modes = measured["psd_modes"].values / REPEATED if "psd_modes" in measured else np.ones(q.size)
    fitted = q >= q[-1] / (FIT_BAND * (1 - 1e-9))
    model, spread = fit_k_correlation(q[fitted], psd[fitted], modes[fitted])
    steeper = np.sqrt(max(spread[0, 0] + spread[1, 1] - 2 * spread[0, 1], 0.0)) / (2 * np.log(8))
    return Spectrum(np.log(q), np.log(psd), *model.tolist(), float(np.sqrt(spread[0, 0])), float(steeper))


def nested_roughness(x, y, density, longest, shortest, seed):
    """Return the heights (x, y), nm, of wavelengths from ``longest`` down to ``shortest`` at points x, y (nm)."""
    out = np.zeros((x.size, y.size))
    band = 0
    while longest > shortest * (1.0 + 1e-9):
        least = max(longest / BAND, shortest)
        amplitude, kx, ky = _band_modes(density, longest, least, seed, band)
        inner = np.exp(1j * np.outer(x, kx)) @ amplitude
        along_y = np.exp(1j * np.outer(ky, y))
        out += inner.real @ along_y.real - inner.imag @ along_y.imag
        longest = least
        band += 1
    return out


def _band_modes(density, longest, shortest, seed, band):
    """Return the amplitudes 2c (kx, ky), nm, of one band, and its wavevectors, nm⁻¹."""
    highest_mode = int(np.ceil(PERIODS * BAND))
    unit = 2.0 * np.pi / (PERIODS * longest)
    kx = np.arange(highest_mode + 1)
    ky = np.arange(-highest_mode, highest_mode + 1)
    periods = np.hypot(kx[:, None], ky)
    inside = (periods > PERIODS) & (periods * shortest <= PERIODS * longest * (1.0 + 1e-12))
    inside &= (kx[:, None] > 0) | (ky > 0)
    first_stream = 100
    parts = normal((2, periods.size), seed, first_stream + band).reshape(2, *periods.shape)
    amplitude = np.zeros(periods.shape, complex)
    root = np.sqrt(2.0 * density(unit * periods[inside])) * unit / (2.0 * np.pi)
    amplitude[inside] = root * (parts[0][inside] + 1j * parts[1][inside])
    return amplitude, unit * kx, unit * ky
