"""Wavelengths that a scan does not show: its spectrum extrapolated below its pixels, or cut off above them.

The K-correlation model is fitted to the scan's longer wavelengths and assumed to hold below them. A seed selects one of
the many random surfaces with this spectrum. The scatter of results over seeds is the uncertainty.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..kernels.topography.interpolation import band_limited
from ..kernels.topography.random_surface import HURST, fit_k_correlation, k_correlation, lay_factor, nested_roughness
from ..vocabulary.refusal import Refusal
from ..vocabulary.schema import entered, finite, label, pixel, record, validate
from ..vocabulary.units import Quantity, positive, single, whole_number
from . import wavelength
from .editing import on_square_pixels
from .spectra import ring_means

#: Fit band: longest over shortest fitted wavelength. Particles on the scan dominate longer wavelengths; a narrower band
#: leaves too few of them.
_FIT_BAND = 5.0

#: Variables of `self_affine_fit`, in the order of the first fields of ``Spectrum``.
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


class Spectrum(NamedTuple):
    """The K-correlation model of a scan, and the shortest wavelength that the scan shows."""

    plateau: float  # nm⁴
    rolloff: float  # nm
    hurst: float
    shown: float  # nm
    error: float = 0.0  # of ln C(q) at the shortest wavelength shown
    hurst_standard_error: float = 0.0  # the error of ln C grows by twice this for each factor e below that wavelength
    tilt: float = 0.0  # shift of ln C(q), in these standard errors
    measured: tuple[np.ndarray, np.ndarray] | None = None  # ln q and ln C, used within their range
    lay: complex = 0.0  # see `lay_factor`

    @property
    def shortest_measured(self) -> float:
        """The shortest wavelength with measured power, nm."""
        return self.shown if self.measured is None else 2 * np.pi * float(np.exp(-self.measured[0][-1]))

    def density(self, q):
        """Return C(q), nm⁴."""
        density = k_correlation(q, self.plateau, self.rolloff, self.hurst)
        log_end = np.log(2 * np.pi / self.shortest_measured)
        if self.measured is not None:
            density = np.where(np.log(q) <= log_end, np.exp(np.interp(np.log(q), *self.measured)), density)
        shorter = np.maximum(np.log(q) - log_end, 0.0)
        return density * np.exp(self.tilt * (self.error + 2 * self.hurst_standard_error * shorter))

    def directional_density(self, kx, ky):
        """Return C(kx, ky), nm⁴, with the lay of the wavelengths that the scan shows."""
        return self.density(np.hypot(kx, ky)) * lay_factor(kx, ky, self.lay)


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
        H below it. ``lay_strength``, 0 if no direction differs significantly, and ``lay_direction`` (°), the
        direction of grooves. NaN if the scan is flat or every part has missing pixels.

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
    >>> from roughxr.scans.synthetic import self_affine
    >>> fitted = roughxr.scans.self_affine_fit(self_affine((256, 256), 10, rms=1.5, hurst=0.7, rolloff=300, seed=1))
    >>> abs(float(fitted.hurst_exponent) - 0.7) < 0.1
    True
    """
    scan = validate(ds, "scan")
    hurst = None if hurst is None else hurst_exponent(hurst)
    shown = _given_wavelength(shown, scan)
    model = _fitted_parts(wavelength.scan_parts(scan["height"].values), pixel(scan), hurst, shown)
    out = xr.Dataset(dict(zip(_NAMES, model[: len(_NAMES)])))
    across = np.degrees(np.angle(model.lay)) / 2 if model.lay else np.nan
    out = out.assign(lay_strength=abs(model.lay), lay_direction=(across + 90) % 180)
    return record(label(out), "self_affine_fit", scan, hurst=hurst, shown=shown)


def _fitted_parts(
    parts: wavelength.Parts | None, steps: tuple[float, float], hurst: float | None, shown: float | None
) -> Spectrum:
    """Fit the model to the spectrum of a scan's parts; NaN where all parts are flat or incomplete."""
    least = np.nan if parts is None else wavelength.spectrum_measures(parts.squares, steps).shortest
    shown = max(least, 2.0 * max(steps)) if shown is None else shown
    if parts is None or not np.isfinite(shown):
        return Spectrum(np.nan, np.nan, np.nan, shown, np.nan, np.nan)
    model = _fitted(*fit_band_rings(parts, steps, shown), shown, pixel=max(steps), hurst=hurst)
    return model._replace(lay=_lay(parts, steps, shown))


def _lay(parts: wavelength.Parts, steps: tuple[float, float], shown: float) -> complex:
    """Return the power-weighted mean of exp(2iθ) over the fit band; 0 if it is not significant."""
    per_nm = [np.fft.fftfreq(n, step) for n, step in zip(parts.squares.shape, steps)]
    wavevector = (per_nm[0][:, None] + 1j * per_nm[1]).ravel()
    in_fit = (np.abs(wavevector) * shown <= 1) & (np.abs(wavevector) * _FIT_BAND * shown >= 1)
    wavevector = wavevector[in_fit]
    power = parts.squares.ravel()[in_fit]
    ring = np.rint(np.log(np.abs(wavevector)) / np.log(1.1)).astype(int)
    ring -= ring.min()
    ring_power = (np.bincount(ring, power) / np.maximum(np.bincount(ring), 1))[ring]
    lay = np.mean(power / ring_power * (wavevector / np.abs(wavevector)) ** 2)
    # a lay (preferred direction) is significant beyond this many standard errors
    return complex(lay) if abs(lay) > 3.0 * np.sqrt(_REPEATED / (wavevector.size * parts.number)) else 0.0


def fit_band_rings(
    parts: wavelength.Parts, steps: tuple[float, float], shown: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return `rings` of a scan's parts within the fit band."""
    q, psd, modes = rings(parts.squares, steps)
    return _fit_band_part(q, psd, modes * parts.number, shown)


def _fit_band_part(q, psd, modes, shown: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the part of a spectrum within the fit band."""
    inside = (2 * np.pi / q >= shown) & (2 * np.pi / q <= _FIT_BAND * shown)
    return q[inside], psd[inside], modes[inside]


def _fitted(q, psd, modes, shown: float, *, pixel: float = 0.0, hurst: float | None = None) -> Spectrum:
    """Fit the model, with its errors, to a spectrum (nm⁻¹, nm⁴)."""
    model, spread, _ = fit_k_correlation(q, psd, modes, pixel, hurst)
    steeper = np.sqrt(max(spread[0, 0] + spread[1, 1] - 2 * spread[0, 1], 0.0)) / (2 * np.log(8))
    plateau, rolloff, fitted_hurst = model.tolist()
    return Spectrum(plateau, rolloff, fitted_hurst, shown, float(np.sqrt(spread[0, 0])), float(steeper))


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


def add_fine_roughness(
    ds: xr.Dataset,
    *,
    shortest: Quantity,
    seed: int,
    mesh: int | None = None,
    spectrum: xr.Dataset | None = None,
) -> xr.Dataset:
    """Return the scan on smaller pixels, with roughness added below the shortest wavelength that it shows.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels, none of them missing.
    shortest : number or quantity
        Shortest added wavelength, nm. The longest added wavelength is the shortest that the scan shows. If the scan
        shows wavelengths below ``shortest``, nothing is added.
    seed : int
        The same seed gives the same roughness at the same x, y on any pixels. A smaller ``shortest`` adds finer
        roughness to it.
    mesh : int, optional
        Cells along a side of each pixel; by default the shortest wavelength spans four cells.
    spectrum : Dataset, optional
        Result of `self_affine_fit` for another scan, by default for this one; or a measured spectrum,
        `combined_spectrum`, extrapolated by the model fitted to its shortest wavelengths.

    Returns
    -------
    Dataset
        The scan, interpolated without wavelengths below two pixels, plus a Gaussian random surface. Attributes:
        ``fine_shortest``, ``fine_longest`` (nm), ``fine_hurst``, ``fine_rms`` (nm), ``fine_seed``.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").isel(x=slice(64), y=slice(64))
    >>> fine = roughxr.scans.add_fine_roughness(scan, shortest=10, seed=1)
    >>> dict(fine.sizes), fine.attrs["fine_longest"] > 20 > 1 > fine.attrs["fine_rms"] > 0.1
    ({'x': 256, 'y': 256}, True)
    """
    scan = on_square_pixels(validate(ds, "scan"))
    side = min(pixel(scan))
    shortest = positive(shortest, "nm", "shortest")
    seed = whole_number(seed, "seed", least=0)
    # cells along the shortest added wavelength
    n = int(np.ceil(4 * side / shortest)) if mesh is None else whole_number(mesh, "mesh", least=1)
    if shortest < 2 * side / n * (1 - 1e-9):
        raise Refusal("mesh", f"pixels of at most half of {shortest:g} nm", f"{side / n:g} nm")
    finite(scan["height"].values)
    model = known_spectrum(self_affine_fit(scan))
    if spectrum is not None:
        model = known_spectrum(spectrum, model.shown, model.lay)
    if not np.isfinite(model.plateau):
        raise Refusal("height", "a spectrum to extrapolate", "none in a flat or nearly flat scan")
    out, added = with_fine_roughness(scan, model, shortest, seed, n)
    made = {"shortest": shortest, "longest": model.shown, "hurst": model.hurst, "rms": float(added.std()), "seed": seed}
    made = {f"fine_{name}": value for name, value in made.items()}
    arguments = {"shortest": shortest, "seed": seed, "mesh": n}
    return record(label(out.assign_attrs({**scan.attrs, **made})), "add_fine_roughness", **arguments)


def with_fine_roughness(
    scan: xr.Dataset, model: Spectrum, shortest: float, seed: int, n: int
) -> tuple[xr.Dataset, np.ndarray]:
    """Return a scan on n × n cells a pixel with a model's wavelengths down to the shortest (nm), and these heights."""
    axes = {}
    for axis, side in zip("xy", pixel(scan)):
        places = float(scan[axis][0]) - side / 2 + side / n * (np.arange(scan.sizes[axis] * n) + 0.5)
        axes[axis] = xr.Variable(axis, places, scan[axis].attrs)
    added = nested_roughness(axes["x"].values, axes["y"].values, model.directional_density, model.shown, shortest, seed)
    heights = xr.Variable(("x", "y"), band_limited(scan["height"].values, n) + added, scan["height"].attrs)
    return scan.drop_dims(["x", "y"]).assign(height=heights).assign_coords(axes), added


def known_spectrum(fit: xr.Dataset, shown: float = np.nan, lay: complex = 0.0) -> Spectrum:
    """Return the model of `self_affine_fit`, or a measured spectrum with the model below its shortest wavelength.

    The fit of a finer scan is measured down to the shortest wavelength of that scan; ``shown`` is that of the coarser.
    """
    fit = entered(fit)
    if "psd" not in fit:
        lay = float(fit["lay_strength"]) * np.exp(2j * np.radians(float(fit["lay_direction"]) - 90))
        parameters: Any = [float(fit[name]) for name in _NAMES]
        model = Spectrum(*parameters)._replace(lay=complex(lay) if np.isfinite(lay) else 0.0)
        if not model.shown < shown:
            return model
        # points of a finer scan's fit between its own shortest wavelength and that of the coarser scan
        q = 2 * np.pi / np.geomspace(shown, model.shown, 64)
        return model._replace(shown=shown, measured=(np.log(q), np.log(model.density(q))))
    q, psd = (fit[name].values for name in ("wavevector", "psd"))
    modes = fit["psd_modes"].values / _REPEATED if "psd_modes" in fit else np.ones(q.size)
    last = 2 * np.pi / q[-1] * (1 - 1e-9)
    model = _fitted(*_fit_band_part(q, psd, modes, last), last)
    return model._replace(shown=shown, lay=lay, measured=(np.log(q), np.log(psd)))


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

    scan = validate(ds, "scan")
    shortest = positive(shortest, "nm", "shortest")
    longest = 2 * max(n * step for n, step in zip(scan["height"].shape, pixel(scan)))
    if shortest > longest:
        raise Refusal("shortest", f"at most twice the scan's length, {longest:g} nm", f"{shortest:g} nm")
    coefficients, frequency = _cosine_transform(scan)
    coefficients[frequency * shortest > 1 + 1e-12] = 0.0
    height = idctn(coefficients, norm="ortho", overwrite_x=True)
    return record(label(scan.assign(height=(("x", "y"), height))), "smooth", shortest=shortest)


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
