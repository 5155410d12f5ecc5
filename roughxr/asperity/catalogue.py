"""Asperities: the peaks of a scan, each with the paraboloid that fits it best."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..kernels.asperity.ellipse import shape
from ..kernels.jit import kernel
from ..kernels.topography.tile_stitching import HALO, Frame, ScanPeaks, join_tiles, search_finer, search_tile
from ..scans import regions, wavelength
from ..scans.cache import cached
from ..scans.wavelength import Waves
from ..vocabulary import schema
from ..vocabulary.units import Quantity, is_whole, positive
from ..vocabulary.verbs import warn
from .ridges import repeated

#: Least number of pixels along a side of a tile: rims and tasks of smaller ones would cost more than their heights.
_TILE_SIDE = 256

#: Pixels along a side of the paper's patch.
PAPER_PATCH = 5

#: Largest patch, as a part of the shortest wave. A narrower one gives the curvature at the very vertex, which a contact
#: outgrows: sums over asperities fall short of the adhesive simulation, while patches over whole waves exceed it.
_PATCH_PER_WAVE = 0.75

#: Least number of pixels in the shortest wave for which a scan resolves it; with fewer, no spline can interpolate.
RESOLVED = 2.0

#: Least number of pixels along a side of a patch; the number from which on pixels are not refined; and the largest.
_LEAST_PIXELS, _UNREFINED_PIXELS, _MOST_PIXELS = 3, 5, 31

#: Largest refinement of the pixels, and how near the patch must come to the wanted width.
_MOST_REFINED, _LEAST_WIDTH = 16, 0.8

#: Largest residual of a fit, as a part of the paraboloid's own drop across the patch; above it the fit is poor.
POOR_FIT = 0.15

#: Variables of a catalogue that have the same names in the fit.
_FITTED = ("height", "curvature_min", "curvature_max", "orientation", "fit_rms", "saddle", "edge", "vertex_fixed")


class _Request(NamedTuple):
    """A scan's pixels, and the options with which its asperities are fitted."""

    shape: tuple[int, int]
    pixel: tuple[float, float]  # nm
    patch: Any  # "auto", pixels (int) or nm (float)
    vertex: str


class _Setup(NamedTuple):
    """What all tiles share."""

    frame: Frame  # on the finer pixels
    refine: int  # refinement of these pixels
    waves: Waves | None


def asperities(ds: xr.Dataset, *, patch: Quantity = "auto", vertex: str = "fitted") -> xr.Dataset:
    """Return the catalogue of a scan's asperities.

    A peak is a pixel, or a plateau of equal pixels, higher than all its neighbours; a plateau is one peak.
    Its paraboloid is the least-squares fit to a square patch around it. A narrow ridge that the pixels break up into
    several peaks is one asperity, unless vertices are at pixels.

    A paraboloid has the summit's curvature only if the patch is narrower than the shortest wave that makes up the
    summit: fitted over two waves it is several times too flat, and the asperity's pull too strong.

    Parameters
    ----------
    ds : Dataset
        A scan. The heights of a lazy one are loaded.
    patch : "auto", "paper", int or length
        Side of the fitted patch. "auto": at most three quarters of the `shortest_wavelength`, as an odd number of
        pixels from 3 to 31, on pixels that splines have made finer where that is too few; a scan whose shortest wave is
        below two pixels is fitted on 3 × 3 of its own. "paper": 5 × 5 pixels. An odd whole number, at least 3: this
        many pixels. A length such as "15 nm": the largest patch that does not exceed it.
    vertex : {"fitted", "pixel"}
        Let the fit place the vertex, between pixels, or fix it at the peak's pixel, as the paper does.
        A free fit that is no summit, or more than one pixel away, is replaced by a fixed one (``vertex_fixed``).

    Returns
    -------
    Dataset
        Along ``asperity``: ``height`` of the vertex (nm), principal curvatures ``curvature_min`` ≤
        ``curvature_max`` (nm⁻¹, positive for a peak), ``orientation`` of the flattest direction (rad),
        ``axis_ratio`` λ = b/a of the Hertz ellipse (NaN for a saddle), ``fit_rms`` (nm), ``plateau_size``, the
        flags ``saddle``, ``edge``, ``vertex_fixed``; coordinates ``x``, ``y`` of the vertex (nm). The scalar
        coordinates ``patch_radius`` and, with "auto", ``shortest_wavelength``, ``pixel`` (nm) and
        ``rms_slope`` say how the fit was made.

    Raises
    ------
    ValueError
        If the scan is not one, has missing pixels, or the patch is even, larger than the scan, or a length of less than
        a fifth of a pixel.

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
    >>> catalogue = asperities(roughxr.open_sample("glass"))
    >>> bool((catalogue.curvature_min <= catalogue.curvature_max).all())
    True
    """
    ds = schema.validate(ds, "scan")
    schema.one_of(vertex, ("fitted", "pixel"), "vertex")
    height, pixel = ds["height"].values, schema.pixel(ds)
    request = _Request(height.shape, pixel, _patch(height.shape, pixel, patch), vertex)
    setup = _setup(request, wavelength.waves(height, pixel) if request.patch == "auto" else None)
    out = _catalogue(_searched(height, setup), ds.coords.to_dataset().assign_attrs(ds.attrs), setup)
    if not (isinstance(patch, str) and patch == "paper"):
        _warn(out)
    return out


def _setup(request: _Request, waves: Waves | None) -> _Setup:
    """Return the set-up of the search for the waves of a scan; None where these were not needed."""
    patch = request.patch
    if patch == "auto" and waves is not None:
        resolved = waves.shortest >= RESOLVED * max(request.pixel)
        patch = _PATCH_PER_WAVE * waves.shortest if resolved else _LEAST_PIXELS
    count, refine = (patch, 1) if isinstance(patch, int) else _pixels(patch, request)
    (nx, ny), (dx, dy) = request.shape, request.pixel
    shape = refine * (nx - 1) + 1, refine * (ny - 1) + 1
    frame = Frame(shape, (dx / refine, dy / refine), count, request.vertex)
    return _Setup(frame, refine, waves)


def _pixels(width: float, request: _Request) -> tuple[int, int]:
    """Return a patch's pixels (odd, at least 3) and the refinement by which it comes near to a width (nm)."""
    pixels = width / max(request.pixel) * (1 + 1e-9)
    most = int(min(pixels, _MOST_PIXELS, *request.shape))
    if most >= _UNREFINED_PIXELS:
        return most - (most + 1) % 2, 1
    for refine in range(1, _MOST_REFINED + 1):
        count = int(refine * pixels)
        count -= (count + 1) % 2
        if count >= _LEAST_PIXELS and count >= _LEAST_WIDTH * refine * pixels:
            return count, refine
    return _LEAST_PIXELS, _MOST_REFINED


@cached
def _searched(height: np.ndarray, setup: _Setup) -> ScanPeaks:
    """Return the peaks of the heights of a scan."""
    if setup.refine > 1:
        return _searched_finer(height, setup)
    return join_tiles([[search_tile(height, (0, 0), setup.frame)]], setup.frame)


def _searched_finer(height: np.ndarray, setup: _Setup) -> ScanPeaks:
    """Return the peaks on finer pixels, tile by tile: all finer pixels at once would fill the memory."""
    tiles = [
        [search_finer(height[part], corner, halo, setup.refine, setup.frame) for part, corner, halo in row]
        for row in _tiles(height.shape)
    ]
    return join_tiles(tiles, setup.frame)


def _tiles(shape: tuple[int, int]) -> list[list[tuple]]:
    """Return rows of tiles: pixels with their halo, first pixel, and halo."""
    side = max(_TILE_SIDE, _MOST_PIXELS)
    starts = (range(0, max(n - side, 0) + 1, side) for n in shape)
    x, y = ([(i, min(i + side, n) if n - i >= 2 * side else n) for i in each] for each, n in zip(starts, shape))
    return [[_with_halo(shape, (i, j), (ends_x, ends_y)) for j, ends_y in y] for i, ends_x in x]


def _with_halo(shape: tuple[int, int], start: tuple[int, int], stop: tuple[int, int]) -> tuple:
    halo = tuple((min(HALO, i), min(HALO, n - j)) for i, j, n in zip(start, stop, shape))
    part = tuple(slice(i - low, j + high) for i, j, (low, high) in zip(start, stop, halo))
    return part, start, halo


def _catalogue(scan_peaks: ScanPeaks, ds: xr.Dataset, setup: _Setup) -> xr.Dataset:
    """Return the peaks of a scan as a labelled catalogue; the heights in ``ds`` are not needed."""
    frame = setup.frame
    schema.none_missing(scan_peaks.missing, ds.sizes["x"] * ds.sizes["y"])
    peaks, fit = scan_peaks.peaks, scan_peaks.fit
    out = xr.Dataset({name: ("asperity", getattr(fit, name).copy()) for name in _FITTED})  # the fit is kept
    out["plateau_size"] = "asperity", peaks.size.copy()
    out["axis_ratio"] = "asperity", _axis_ratios(fit.curvature_min, fit.curvature_max)
    places = (
        ds[axis].values[at // setup.refine] + at % setup.refine * step
        for axis, at, step in zip("xy", (peaks.ix, peaks.iy), frame.pixel)
    )
    x, y = (place + off for place, off in zip(places, (fit.vertex_x, fit.vertex_y)))
    out = out.assign_coords(
        asperity=np.arange(peaks.ix.size),
        x=("asperity", x),
        y=("asperity", y),
        datum_height=scan_peaks.highest,
        patch_radius=0.5 * frame.patch * max(frame.pixel),
    )
    out = out.assign_coords(dict(zip(regions.EDGES, regions.extent(ds))) | schema.travelling(ds))
    out = out.assign_coords({name: ds[name] for name in ("subregion_x", "subregion_y") if name in ds.coords})
    if frame.vertex == "fitted":
        out = out.isel(asperity=~repeated(out, max(frame.pixel)))
        out = out.assign_coords(asperity=np.arange(out.sizes["asperity"]))
    if setup.waves is not None:
        known = {"shortest_wavelength": setup.waves.shortest, "rms_slope": setup.waves.slope}
        out = out.assign_coords(known | {"pixel": max(schema.pixel(ds))})
    done = {"patch": frame.patch, "refine": setup.refine, "vertex": frame.vertex}
    return schema.record(schema.label(out), "asperities", ds, **done)


def _patch(shape: tuple[int, int], pixel: tuple[float, float], patch: Any) -> Any:
    """Return "auto", pixels as an int, or nm as a float."""
    if isinstance(patch, str) and patch in ("auto", "paper"):
        return "auto" if patch == "auto" else _patch(shape, pixel, PAPER_PATCH)
    most = min(shape)
    if isinstance(patch, str) or hasattr(patch, "units"):
        finest = _LEAST_PIXELS * max(pixel) / _MOST_REFINED
        if (width := positive(patch, "nm", "patch")) < finest:
            least = f"{finest:.3g} nm, {_LEAST_PIXELS}/{_MOST_REFINED} of a pixel"
            raise ValueError(f"patch: expected a length of at least {least}, found {patch!r}")
        return width
    if not is_whole(patch) or patch % 2 != 1 or not 3 <= patch <= most:
        raise ValueError(
            f"patch: expected 'auto', 'paper', a length such as '15 nm', or an odd number of pixels from 3 to {most}, "
            f"found {patch!r}"
        )
    return int(patch)


def poorly_fitted(catalogue: xr.Dataset) -> float:
    """Return the share of asperities whose rms residual exceeds `POOR_FIT` of the paraboloid's drop on their patch."""
    if catalogue.sizes["asperity"] == 0:
        return np.nan
    mean_curvature = 0.5 * np.abs(catalogue["curvature_min"] + catalogue["curvature_max"])
    fall = 0.5 * mean_curvature * float(catalogue["patch_radius"]) ** 2
    return float((catalogue["fit_rms"] > POOR_FIT * fall).mean())


def _warn(out: xr.Dataset) -> None:
    share = poorly_fitted(out)
    if share >= 0.5:
        auto = "shortest_wavelength" in out.coords
        remedy = "the scan does not resolve them" if auto else "take patch='auto', which follows the surface"
        warn(
            f"patch: {100 * share:.0f} % of the asperities do not fit a paraboloid on a patch of "
            f"{2 * float(out['patch_radius']):.3g} nm: their curvatures are not those of the summits; {remedy}"
        )


@kernel
def _axis_ratios(curvature_min, curvature_max):
    out = np.empty(curvature_min.size)
    for n in range(out.size):
        out[n] = shape(curvature_min[n], curvature_max[n])
    return out
