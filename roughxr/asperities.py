"""Asperities: the peaks of a scan, each with the paraboloid that fits it best.

The catalogue remembers what superposition needs of its scan: the datum, the outer edges, the patch's size.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from . import regions, schema
from .kernels.ellipse import shape
from .kernels.jit import kernel
from .kernels.paraboloid import fit_paraboloids
from .kernels.peaks import find_peaks

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
        A scan. A lazy one is computed, since only then the number of asperities is known.
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
    ds = schema.validate(ds, "scan")
    patch = _patch(ds, patch)
    schema.one_of(vertex, ("fitted", "pixel"), "vertex")
    height = schema.finite(np.ascontiguousarray(ds["height"].values, dtype=float))
    dx, dy = schema.pixel(ds)
    peaks = find_peaks(height)
    fit = fit_paraboloids(height, peaks.ix, peaks.iy, dx, dy, size=patch, vertex=vertex)
    out = xr.Dataset({name: ("asperity", getattr(fit, name)) for name in _FITTED})
    out["plateau_size"] = "asperity", peaks.size
    out["axis_ratio"] = "asperity", _axis_ratios(fit.curvature_min, fit.curvature_max)
    out = out.assign_coords(
        asperity=np.arange(peaks.ix.size),
        x=("asperity", ds["x"].values[peaks.ix] + fit.vertex_x),
        y=("asperity", ds["y"].values[peaks.iy] + fit.vertex_y),
        datum_height=float(height.max()),
        patch_radius=0.5 * patch * max(dx, dy),
        **dict(zip(regions.EDGES, regions.extent(ds))),
        **{name: ds[name] for name in (*schema.PAIR, "subregion_x", "subregion_y") if name in ds.coords},
    )
    return schema.record(schema.label(out), "asperities", ds, patch=patch, vertex=vertex)


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
