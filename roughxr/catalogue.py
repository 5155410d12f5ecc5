"""Asperities: the peaks of a scan, each with the paraboloid that fits it best.

The catalogue remembers what superposition needs of its scan: the datum, the outer edges, the patch's size.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import accumulate
from typing import Any

import dask
import dask.array as da
import numpy as np
import xarray as xr

from . import regions, schema
from .kernels.asperity.ellipse import shape
from .kernels.jit import kernel
from .kernels.topography.tile_stitching import Frame, ScanPeaks, join_tiles, search_tile

#: Pixels along a side of a tile at least: rims and tasks of smaller ones would cost more than their heights.
_SIDE = 256

#: Variables of a catalogue that the fit gives by these very names.
_FITTED = (
    "height",
    "curvature_min",
    "curvature_max",
    "orientation",
    "fit_rms",
    "saddle",
    "edge",
    "vertex_fixed",
)


def asperities(ds: xr.Dataset, *, patch: int = 5, vertex: str = "fitted") -> xr.Dataset:
    """Return the catalogue of a scan's asperities.

    A peak is a pixel, or a plateau of equal pixels, higher than all its neighbours; a plateau is one peak.
    Its paraboloid is the least-squares fit to the ``patch`` × ``patch`` pixels around it.

    Parameters
    ----------
    ds : Dataset
        A scan. A lazy one is read now, since only then the number of asperities is known: tile by tile, each chunk
        once, with the same result to the last bit. Beside the catalogue, what is held at a time is a tile for each
        of dask's threads, and the heights near the seams between tiles and around flat tops that reach across one.
    patch : int
        Pixels along a side of the fitted patch, odd, at least 3.
    vertex : {"fitted", "pixel"}
        Let the fit place the vertex, to a part of a pixel, or hold it at the peak's pixel, as the paper does.
        A free fit that is no summit, or strays beyond one pixel, is replaced by a held one (``vertex_fixed``).

    Returns
    -------
    Dataset
        Along ``asperity``: ``height`` of the vertex (nm), principal curvatures ``curvature_min`` ≤
        ``curvature_max`` (nm⁻¹, positive for a peak), ``orientation`` of the flattest direction (rad),
        ``axis_ratio`` λ = b/a of the Hertz ellipse (NaN for a saddle), ``fit_rms`` (nm), ``plateau_size``, the
        flags ``saddle``, ``edge``, ``vertex_fixed``; coordinates ``x``, ``y`` of the vertex (nm).

    Raises
    ------
    ValueError
        If the scan is not one, has missing pixels, or the patch is even or larger than the scan.

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
    ds, frame = _prepared(ds, patch, vertex)
    if ds["height"].chunks:
        return later(ds, patch=patch, vertex=vertex).compute()
    found = join_tiles([[search_tile(ds["height"].values, (0, 0), frame)]], frame)
    return _catalogue(found, _without_maps(ds), frame)


def later(ds: xr.Dataset, *, patch: int = 5, vertex: str = "fitted") -> Any:
    """Return `asperities` of a lazy scan as a dask task that is still to be computed.

    Parameters
    ----------
    ds : Dataset
        A scan.
    patch, vertex
        As for `asperities`.

    Returns
    -------
    dask.delayed.Delayed
    """
    ds, frame = _prepared(ds, patch, vertex)
    return dask.delayed(_catalogue)(_searched_later(da.asarray(ds["height"].data), frame), _without_maps(ds), frame)


def _prepared(ds: xr.Dataset, patch: int, vertex: str) -> tuple[xr.Dataset, Frame]:
    ds = schema.validate(ds, "scan")
    patch = _patch(ds, patch)
    schema.one_of(vertex, ("fitted", "pixel"), "vertex")
    return ds, Frame(ds["height"].shape, schema.pixel(ds), patch, vertex)


def _without_maps(ds: xr.Dataset) -> xr.Dataset:
    """Return the axes, scalars and attributes of a scan: what a task may carry along."""
    return ds.coords.to_dataset().assign_attrs(ds.attrs)


def _searched_later(height: da.Array, frame: Frame) -> Any:
    """Return what is found on lazy heights, as one task after those of the tiles."""
    sizes = [_joined_sizes(chunks, max(_SIDE, frame.patch)) for chunks in height.chunks]
    x, y = ([0, *accumulate(n)] for n in sizes)
    blocks = height.rechunk(tuple(sizes), method="tasks").to_delayed()
    search, join = (dask.delayed(function, pure=False) for function in (search_tile, join_tiles))
    return join([[search(block, (i, j), frame) for block, j in zip(row, y)] for row, i in zip(blocks, x)], frame)


def _joined_sizes(chunks: Iterable[int], least: int) -> tuple[int, ...]:
    """Return the sizes of tiles that are whole chunks side by side, with ``least`` pixels or more in each."""
    out = [0]
    for size in chunks:
        if out[-1] >= least:
            out.append(0)
        out[-1] += size
    if len(out) > 1 and out[-1] < least:
        out[-2:] = [sum(out[-2:])]
    return tuple(out)


def _catalogue(found: ScanPeaks, ds: xr.Dataset, frame: Frame) -> xr.Dataset:
    """Return with labels what is found on a scan; of ``ds``, its heights are not needed."""
    schema.none_missing(found.missing, frame.shape[0] * frame.shape[1])
    peaks, fit = found.peaks, found.fit
    out = xr.Dataset({name: ("asperity", getattr(fit, name)) for name in _FITTED})
    out["plateau_size"] = "asperity", peaks.size
    out["axis_ratio"] = "asperity", _axis_ratios(fit.curvature_min, fit.curvature_max)
    out = out.assign_coords(
        asperity=np.arange(peaks.ix.size),
        x=("asperity", ds["x"].values[peaks.ix] + fit.vertex_x),
        y=("asperity", ds["y"].values[peaks.iy] + fit.vertex_y),
        datum_height=found.highest,
        patch_radius=0.5 * frame.patch * max(frame.pixel),
        **dict(zip(regions.EDGES, regions.extent(ds))),
        **{name: ds[name] for name in (*schema.PAIR, "subregion_x", "subregion_y") if name in ds.coords},
    )
    return schema.record(schema.label(out), "asperities", ds, patch=frame.patch, vertex=frame.vertex)


def _patch(ds: xr.Dataset, patch: int) -> int:
    most = min(ds.sizes["x"], ds.sizes["y"])
    if not isinstance(patch, (int, np.integer)) or patch % 2 != 1 or not 3 <= patch <= most:
        raise ValueError(f"patch: expected an odd number of pixels from 3 to {most}, found {patch!r}")
    return int(patch)


@kernel
def _axis_ratios(curvature_min, curvature_max):
    out = np.empty(curvature_min.size)
    for n in range(out.size):
        out[n] = shape(curvature_min[n], curvature_max[n])
    return out
