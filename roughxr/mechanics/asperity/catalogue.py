"""Asperities: the peaks of a scan with their least-squares paraboloids."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.spatial import cKDTree

from ..kernels.asperity.ellipse import axis_ratios
from ..kernels.topography.interpolation import bicubic_spline
from ..kernels.topography.paraboloid import Fit, fit_paraboloids
from ..kernels.topography.peaks import Peaks, ascend, search
from ..scans import regions, wavelength
from ..scans.cache import cached
from ..scans.wavelength import SpectralMeasures
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import RoughxrWarning, warn
from ..vocabulary.units import Quantity, is_whole, positive

#: Least number of pixels in the shortest wavelength that a scan resolves; with fewer, no spline can interpolate.
RESOLVED = 2.0

#: Least number of pixels along a side of a patch.
_LEAST_PIXELS = 3

#: Least number on pixels that are not refined.
_UNREFINED_PIXELS = 5

#: Largest number of pixels along a side of a patch.
_MOST_PIXELS = 31

#: Largest refinement of the pixels.
_MOST_REFINED = 16

#: Least width of the patch over the requested width.
_LEAST_WIDTH = 0.8

#: Variables of a catalogue that have the same names in the fit.
_FITTED = ("height", "curvature_min", "curvature_max", "orientation", "fit_rms", "saddle", "edge", "vertex_fixed")


class DoubtfulAsperities(RoughxrWarning):
    """Asperities whose curvatures or sums may differ from those of the surface.

    Examples
    --------
    >>> import warnings
    >>> import roughxr
    >>> warnings.simplefilter("error", roughxr.DoubtfulAsperities)  # stop instead of warning
    """


class _Setup(NamedTuple):
    """Pixels and patch of the search for asperities and of their fits."""

    pixel: tuple[float, float]  # nm, of the finer pixels
    refine: int  # refinement of the scan's pixels
    patch: int  # finer pixels along its side
    vertex: str
    measures: SpectralMeasures | None


def asperities(ds: xr.Dataset, *, patch: Quantity = "auto") -> xr.Dataset:
    """Return the catalogue of a scan's asperities.

    A peak is a pixel, or a plateau of equal pixels, higher than all its neighbours; a ridge with several such pixels
    and one summit counts once, except for the paper's patch. The paraboloid of a peak is the least-squares fit to a
    square patch around it, and has the summit's curvature only if the patch is narrower than the shortest wavelength:
    fitted over two wavelengths it is several times too flat, and its adhesion too strong. The fit also
    places the vertex, between pixels, except for the paper's patch. A fit that is no summit, or whose vertex is more
    than one pixel away, is replaced by one with its vertex at the peak's pixel (``vertex_fixed``).

    Parameters
    ----------
    ds : Dataset
        A scan. The heights of a lazy one are loaded.
    patch : "auto", "paper", int or length
        Side of the fitted patch. "auto": at most three quarters of the `shortest_wavelength`, or 0.15 of it on a
        regular pattern of one wavelength, as an odd number of pixels from 3 to 31, on pixels refined by splines if
        these are too few; 3 × 3 pixels if the shortest wavelength is below two pixels. "paper": the paper's fit, 5 × 5
        pixels with all vertices at the peaks' pixels. An odd whole number, at least 3: this many pixels. A length such
        as "15 nm": the largest patch that does not exceed it.

    Returns
    -------
    Dataset
        Along ``asperity``: ``height`` of the vertex (nm), principal curvatures ``curvature_min`` ≤
        ``curvature_max`` (nm⁻¹, positive for a peak), ``orientation`` of the flattest direction (rad),
        ``axis_ratio`` λ = b/a of the Hertz ellipse (NaN for a saddle), ``fit_rms`` (nm), ``plateau_size``, the
        flags ``saddle``, ``edge``, ``vertex_fixed``; coordinates ``x``, ``y`` of the vertex (nm). The scalar
        coordinates ``patch_radius`` and, with "auto", ``shortest_wavelength``, ``pixel`` (nm) and
        ``rms_slope`` describe the fit.

    Raises
    ------
    ValueError
        If ``patch`` is no width that fits the scan, or needs too many heights.

    Warns
    -----
    UserWarning
        If at least half of the patches are poorly fitted by a paraboloid (`poorly_fitted`), unless the patch is
        "paper".

    References
    ----------
    Cheng, Dunn & Brach, eqs. 25–34 (the printed dz/dx² holds for heights in counts, and arctan loses the
    quadrant).

    Examples
    --------
    >>> import roughxr
    >>> catalogue = roughxr.asperities(roughxr.open_sample("glass"))
    >>> bool((catalogue.curvature_min <= catalogue.curvature_max).all())
    True
    """
    return catalogue_of(schema.validate(ds, "scan"), patch)


@schema.recorded_as("asperities")
def catalogue_of(ds: xr.Dataset, patch: Any = "auto") -> xr.Dataset:
    """Return the asperities of a valid scan, see `asperities`."""
    is_paper = isinstance(patch, str) and patch == "paper"
    height = schema.in_memory(ds["height"]).values
    pixel = schema.pixel(ds)
    patch_size = _patch(height.shape, pixel, patch)
    measures = wavelength.spectral_measures(height, pixel) if patch_size == "auto" else None
    setup = _setup(height.shape, pixel, patch_size, "pixel" if is_paper else "fitted", measures)
    peaks, fit = _fitted_peaks(schema.finite(height), setup)
    out = _catalogue(peaks, fit, ds.assign_coords(datum_height=height.max()), setup)
    if not is_paper:
        _warn(out)
    return out


def _setup(
    shape: tuple[int, int], pixel: tuple[float, float], patch: Any, vertex: str, measures: SpectralMeasures | None
) -> _Setup:
    """Return the set-up for a scan's pixels and a patch of "auto", pixels (int) or nm (float)."""
    if measures is not None:
        resolved = measures.shortest >= RESOLVED * max(pixel)
        patch = _patch_width(measures, max(pixel)) if resolved else _LEAST_PIXELS
    count, refine = (patch, 1) if isinstance(patch, int) else _pixels(patch, shape, pixel)
    # largest number of heights of a scan on finer pixels: some 4 GB
    most_values = 5e8
    if refine**2 * shape[0] * shape[1] > most_values:
        raise Refusal(
            "patch",
            f"at most {most_values:.2g} heights",
            f"{refine**2 * shape[0] * shape[1]:.2g} on pixels {refine} times finer",
            "take a wider patch or a smaller scan",
        )
    return _Setup((pixel[0] / refine, pixel[1] / refine), refine, count, vertex, measures)


def _patch_width(measures: SpectralMeasures, pixel: float) -> float:
    """Return the width (nm) of the patch for a scan's wavelengths."""
    # largest patch, as a part of the shortest wavelength. On narrower patches, with the curvature of the very vertex,
    # sums over asperities are below the adhesive simulation; on wider ones above it.
    width = 0.75 * measures.shortest
    if np.isinf(width):
        return width
    # a regular pattern takes less, but at least a pixel: a fit over three quarters of its wave is 1.6 times too blunt
    narrow = max(0.15 * measures.shortest, min(width, pixel))
    # longest over shortest wavelength of the curvature: up to 1.4 of a single wavelength on small scans, 2 and more of
    # self-affine surfaces and real scans
    return float(np.interp(measures.longest / measures.shortest, (1.5, 1.9), (narrow, width)))


def _pixels(width: float, shape: tuple[int, int], pixel: tuple[float, float]) -> tuple[int, int]:
    """Return a patch's number of pixels (odd, at least 3) and their refinement, for a width (nm)."""
    pixels = width / max(pixel) * (1 + 1e-9)
    widest = int(min(pixels, _MOST_PIXELS, *shape))
    if widest >= _UNREFINED_PIXELS:
        return widest - (widest + 1) % 2, 1
    for refine in range(1, _MOST_REFINED + 1):
        count = int(refine * pixels)
        count -= (count + 1) % 2
        if count >= _LEAST_PIXELS and count >= _LEAST_WIDTH * refine * pixels:
            return count, refine
    return _LEAST_PIXELS, _MOST_REFINED


@cached
def _fitted_peaks(height: np.ndarray, setup: _Setup) -> tuple[Peaks, Fit]:
    """Return the peaks of heights, refined if the set-up requires it, and their paraboloids."""
    pixels = height
    if setup.refine > 1:
        finer = _spline(height)(*(np.arange(setup.refine * (n - 1) + 1) / setup.refine for n in height.shape))
        # decimals (nm) to which splined heights are rounded, so that flat areas stay flat
        pixels = np.round(finer, 9)
    pixels = np.ascontiguousarray(pixels, dtype=float)
    peaks = search(pixels)
    fit = fit_paraboloids(pixels, peaks.ix, peaks.iy, *setup.pixel, size=setup.patch, vertex=setup.vertex)
    if setup.vertex == "pixel":  # the paper's: each highest pixel counts
        return peaks, fit
    distinct = np.ones(peaks.ix.size, np.bool_)
    distinct[_repeated_ridges(height, peaks, fit, setup.refine)] = False
    return Peaks(*(array[distinct] for array in peaks)), Fit(*(array[distinct] for array in fit))


def _spline(height: np.ndarray) -> Any:
    """Return the bicubic spline through the pixel centres, whose coordinates are the pixels' numbers."""
    rows, columns = height.shape
    return bicubic_spline(np.arange(rows), np.arange(columns), height)


def _repeated_ridges(height: np.ndarray, peaks: Peaks, fit: Fit, refine: int) -> np.ndarray:
    """Return the numbers of the peaks on a ridge whose summit has another peak already."""
    # ratio of the principal curvatures of a ridge. A paraboloid below 6 has one highest pixel however it lies on them.
    ridges = np.flatnonzero(10.0 * np.abs(fit.curvature_min) < fit.curvature_max)
    if ridges.size < 2 or not fit.vertex_fixed[ridges].any():
        return ridges[:0]
    ridges = ridges[np.lexsort((-fit.height[ridges], fit.vertex_fixed[ridges]))]
    pixels = np.stack([peaks.ix[ridges], peaks.iy[ridges]], axis=-1)
    derivatives = functools.cache(_spline(height).partial_derivative)  # `ev` would compute those of all pixels anew
    summits = ascend(lambda x, y, dx=0, dy=0: derivatives(dx, dy)(x, y, grid=False), pixels / refine)
    # summits closer than this (pixels) are one
    pairs = cKDTree(refine * summits).query_pairs(0.1, output_type="ndarray")
    return ridges[np.unique(pairs[:, 1])]


def _catalogue(peaks: Peaks, fit: Fit, ds: xr.Dataset, setup: _Setup) -> xr.Dataset:
    """Return the fitted peaks of a scan as a labelled catalogue."""
    columns = {name: getattr(fit, name).copy() for name in _FITTED}  # the fit is cached
    columns["plateau_size"] = peaks.size.copy()
    columns["axis_ratio"] = axis_ratios(fit.curvature_min, fit.curvature_max)
    places = (
        ds[axis].values[at // setup.refine] + at % setup.refine * step
        for axis, at, step in zip("xy", (peaks.ix, peaks.iy), setup.pixel)
    )
    x, y = (place + off for place, off in zip(places, (fit.vertex_x, fit.vertex_y)))
    coords = {
        "asperity": np.arange(peaks.ix.size),
        "x": ("asperity", x),
        "y": ("asperity", y),
        "datum_height": ds["datum_height"],
        "patch_radius": 0.5 * setup.patch * max(setup.pixel),
        **dict(zip(regions.EDGES, regions.edges_of(ds))),
        **schema.pair_coordinates(ds),
        **{name: ds[name] for name in ("subregion_x", "subregion_y") if name in ds.coords},
    }
    if setup.measures is not None:
        coords["shortest_wavelength"] = setup.measures.shortest
        coords["rms_slope"] = setup.measures.slope
        coords["pixel"] = max(schema.pixel(ds))
    out = xr.Dataset({name: ("asperity", column) for name, column in columns.items()}, coords)
    return schema.label(out)


def _patch(shape: tuple[int, int], pixel: tuple[float, float], patch: Any) -> Any:
    """Return "auto", pixels as an int, or nm as a float."""
    # pixels along a side of the paper's patch
    paper_patch = 5
    if isinstance(patch, str) and patch in ("auto", "paper"):
        return "auto" if patch == "auto" else _patch(shape, pixel, paper_patch)
    widest = min(shape)
    if isinstance(patch, str) or hasattr(patch, "units"):
        finest = _LEAST_PIXELS * max(pixel) / _MOST_REFINED
        if (width := positive(patch, "nm", "patch")) < finest:
            least = f"{finest:.3g} nm, {_LEAST_PIXELS}/{_MOST_REFINED} of a pixel"
            raise Refusal("patch", f"a length of at least {least}", f"{patch!r}")
        return width
    if not is_whole(patch) or patch % 2 != 1 or not 3 <= patch <= widest:
        raise Refusal(
            "patch",
            f"'auto', 'paper', a length such as '15 nm', or an odd number of pixels from 3 to {widest}",
            f"{patch!r}",
        )
    return int(patch)


def poorly_fitted(catalogue: xr.Dataset) -> float:
    """Return the share of asperities whose rms residual exceeds 0.15 of the paraboloid's drop on their patch."""
    if catalogue.sizes["asperity"] == 0:
        return np.nan
    mean_curvature = 0.5 * np.abs(catalogue["curvature_min"].values + catalogue["curvature_max"].values)
    fall = 0.5 * mean_curvature * float(catalogue["patch_radius"]) ** 2
    # largest residual of a fit, as a part of the paraboloid's own drop across the patch; above it the fit is poor
    return float((catalogue["fit_rms"].values > 0.15 * fall).mean())


def _warn(out: xr.Dataset) -> None:
    share = poorly_fitted(out)
    if share >= 0.5:
        auto = "shortest_wavelength" in out.coords
        remedy = "the scan does not resolve them" if auto else "take patch='auto', which follows the surface"
        warn(
            f"patch: {100 * share:.0f} % of the asperities do not fit a paraboloid on a patch of "
            f"{2 * float(out['patch_radius']):.3g} nm: these are not the curvatures of the summits; {remedy}",
            DoubtfulAsperities,
        )
