"""Gaussian random surfaces of a given spectrum, the same for the same seed with any version of numpy.

White noise of one unit per pixel has the two-dimensional spectrum C = a, the area of a pixel (C as in
``scans.spectra``: |a Σ h exp(−iqr)|²/A). Filtered by √(C(q)/a) it becomes a surface of the spectrum C, periodic over
the map. The random numbers come from the raw bits of PCG64 and the inverse normal distribution, not from a library's
way of drawing normal numbers, which may change between versions.

K-correlation model: C(q) = C₀ [1 + (ℓ₀q/2π)²]^−(1 + H), flat at wavelengths above ℓ₀, self-affine below (Persson et
al., J. Phys.: Condens. Matter 17 (2005) R1).

q    wavevector, nm⁻¹;  C₀ nm⁴;  ℓ₀ ``rolloff``, nm;  H ``hurst``, Hurst exponent
"""

import numpy as np

#: The largest and smallest Hurst exponent of a self-affine surface.
HURST = 0.0, 1.0


def uniform(count, seed, stream):
    """Return numbers inside (0, 1) from PCG64's raw bits, which no version of numpy changes."""
    bits = np.random.PCG64([seed, stream]).random_raw(count)
    return ((bits >> np.uint64(11)) + 0.5) * 2.0**-53


def normal(shape, seed, stream):
    """Return independent normal numbers of mean 0 and variance 1."""
    from scipy.special import ndtri

    return ndtri(uniform(shape[0] * shape[1], seed, stream)).reshape(shape)


def k_correlation(q, plateau, rolloff, hurst):
    """Return C(q), nm⁴, of the K-correlation model."""
    return plateau * (1.0 + (rolloff * q / (2.0 * np.pi)) ** 2) ** -(1.0 + hurst)


def fit_k_correlation(q, psd, hurst=None):
    """Return the (C₀, ℓ₀, H) that fit the logarithm of a spectrum at wavevectors q best, with equal weight per octave.

    ``hurst`` fixes H. Wavevectors without power are left out; NaN where fewer than four have any.
    """
    from scipy.optimize import least_squares

    known = (q > 0) & (psd > 0)
    if known.sum() < 4:
        return np.full(3, np.nan)
    q, wanted = q[known], np.log(psd[known])
    weight = 1.0 / np.sqrt(q / q[0])  # rings have equal width, so that their number in an octave grows with q

    def off(unknown):
        H = hurst if hurst is not None else unknown[2]
        return weight * (unknown[0] + np.log(k_correlation(q, 1.0, np.exp(unknown[1]), H)) - wanted)

    longest, shortest = 2.0 * np.pi / q[0], 2.0 * np.pi / q[-1]
    low = [-np.inf, np.log(shortest), HURST[0] - 1e-9]
    high = [np.inf, np.log(100.0 * longest), HURST[1]]
    start = [wanted[0], np.log(np.sqrt(longest * shortest)), 0.5]
    count = 3 if hurst is None else 2
    found = least_squares(off, start[:count], bounds=(low[:count], high[:count])).x
    return np.array([np.exp(found[0]), np.exp(found[1]), hurst if hurst is not None else max(found[2], 0.0)])


def band_limited(shape, pixel, spectrum, longest, shortest, seed, stream):
    """Return a surface, nm, with the spectrum C(q) at wavelengths from ``shortest`` up to ``longest`` and no others."""
    from scipy.fft import irfft2, rfft2

    per_nm = np.hypot(np.fft.fftfreq(shape[0], pixel)[:, None], np.fft.rfftfreq(shape[1], pixel))
    inside = (per_nm * longest > 1.0) & (per_nm * shortest <= 1.0)
    amplitude = np.zeros(per_nm.shape)
    amplitude[inside] = np.sqrt(spectrum(2.0 * np.pi * per_nm[inside])) / pixel
    return irfft2(rfft2(normal(shape, seed, stream)) * amplitude, s=shape)
