"""Gaussian random surfaces of a given spectrum, the same for the same seed with any version of numpy.

White noise of variance 1 per pixel has the two-dimensional spectrum C = a, the area of a pixel (C as in
``scans.spectra``: |a Σ h exp(−iqr)|²/A). Filtered by √(C(q)/a) it becomes a surface of the spectrum C, periodic over
the map. The random numbers come from the raw bits of PCG64 and the inverse normal distribution: a library's normal
numbers may change between its versions.

K-correlation model: C(q) = C₀ [1 + (ℓ₀q/2π)²]^−(1 + H), flat at wavelengths above ℓ₀, self-affine below (Persson et
al., J. Phys.: Condens. Matter 17 (2005) R1).

q    wavevector, nm⁻¹;  C₀ nm⁴;  ℓ₀ ``rolloff``, nm;  H ``hurst``, Hurst exponent
"""

import numpy as np

#: The largest and smallest Hurst exponent of a self-affine surface.
HURST = 0.0, 1.0


def uniform(count, seed, stream):
    """Return uniform random numbers in (0, 1) from PCG64's raw bits, the same in all versions of numpy."""
    bits = np.random.PCG64([seed, stream]).random_raw(count)
    return ((bits >> np.uint64(11)) + 0.5) * 2.0**-53


def normal(shape, seed, stream):
    """Return independent normal numbers of mean 0 and variance 1."""
    from scipy.special import ndtri

    return ndtri(uniform(shape[0] * shape[1], seed, stream)).reshape(shape)


def k_correlation(q, plateau, rolloff, hurst):
    """Return C(q), nm⁴, of the K-correlation model."""
    return plateau * (1.0 + (rolloff * q / (2.0 * np.pi)) ** 2) ** -(1.0 + hurst)


def fit_k_correlation(q, psd, modes, pixel=0.0, hurst=None, bounds=HURST):
    """Fit the K-correlation model to a spectrum at wavevectors q.

    Returns (C₀, ℓ₀, H), and the covariance of ln C at q₁ and 8q₁, q₁ the largest wavevector: the uncertainty of an
    extrapolation.

    ``modes`` is the number of independent Fourier modes that each value averages; ``hurst`` fixes H, which lies in
    ``bounds``. Heights averaged over a pixel of side a keep exp(−(qa)²/12) of their power, over a part of it
    exp(−u(qa)²/12); u, from 0 to 1, is fitted as well. Wavevectors without power are left out; NaN where fewer than
    four have any.
    """
    from scipy.optimize import least_squares

    has_power = (q > 0) & (psd > 0)
    if has_power.sum() < 4:
        return np.full(3, np.nan), np.full((2, 2), np.nan)
    # so that the result does not depend on the unit of length
    unit = 1.0 / q[has_power][-1]
    level = np.log(psd[has_power][0])
    q = q[has_power] * unit
    pixel = pixel / unit
    modes = modes[has_power]
    measured = np.log(psd[has_power]) - level + 0.5 / modes  # the mean logarithm of a mean over m modes is 1/2m too low
    error = _logarithmic_errors(q, modes)
    longest = 2.0 * np.pi / q[0]
    shortest = 2.0 * np.pi / q[-1]
    # of u, ln ℓ₀, H
    prior = np.array([0.0, np.log(longest), np.mean(bounds)])
    prior_error = np.array([1.0, 2.0, 0.5])

    def residuals(unknown):
        averaged = _log_spectrum(unknown, q, hurst) - unknown[1] * (q * pixel) ** 2 / 12.0
        off_prior = (unknown[1:] - prior[: count - 1]) / prior_error[: count - 1]
        return np.concatenate([(averaged - measured) / error, off_prior])

    low = [-np.inf, 0.0, np.log(shortest), bounds[0] - 1e-9]
    high = [np.inf, 1.0, np.log(100.0 * longest), bounds[1]]
    start = [measured[0], 0.1, np.log(np.sqrt(longest * shortest)), np.mean(bounds)]
    count = 4 if hurst is None else 3
    tight = dict.fromkeys(("ftol", "xtol", "gtol"), 1e-13)  # so that rounding of the input is not amplified
    solved = least_squares(residuals, start[:count], "3-point", (low[:count], high[:count]), **tight)
    fitted = solved.x
    gradient = _gradient(fitted, q[-1] * np.array([1.0, 8.0]), hurst)
    spread = gradient.T @ np.linalg.inv(solved.jac.T @ solved.jac) @ gradient
    H = hurst if hurst is not None else max(fitted[3], bounds[0])
    return np.array([np.exp(fitted[0] + level), np.exp(fitted[2]) * unit, H]), spread


def _logarithmic_errors(q, modes):
    """Return the errors of ln C by sampling, and since no surface is exactly self-affine."""
    # error of ln C over a factor e of wavelengths
    model_error = 0.05
    return np.sqrt(1.0 / modes + model_error**2 * q / np.gradient(q))


def _log_spectrum(unknown, q, hurst):
    """Return ln C at ln C₀, u (without effect), ln ℓ₀ and, unless ``hurst`` is known, H."""
    H = hurst if hurst is not None else unknown[3]
    return unknown[0] + np.log(k_correlation(q, 1.0, np.exp(unknown[2]), H))


def _gradient(unknown, q, hurst):
    """Return the derivatives of ln C by the unknowns, (unknown, q)."""
    small = 1e-4
    moved = (unknown + small * axis for axis in np.eye(unknown.size))
    at_fit = _log_spectrum(unknown, q, hurst)
    return np.array([_log_spectrum(shifted, q, hurst) - at_fit for shifted in moved]) / small
