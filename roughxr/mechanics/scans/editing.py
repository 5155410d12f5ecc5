"""Fill missing pixels of a scan, crop it, resample it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary.refusal import Refusal, shown
from ..vocabulary.schema import in_memory, is_square, label, pixel, verb
from ..vocabulary.text import warn
from ..vocabulary.units import Quantity, magnitude, plain, positive


@verb("scan")
def fill(ds: xr.Dataset, *, method: Quantity = "linear") -> xr.Dataset:
    """Return a scan with its missing pixels filled from their neighbours.

    Parameters
    ----------
    ds : Dataset
        A scan.
    method : {"linear", "nearest"} or length
        Interpolate linearly across each hole (nearest pixel at the scan's edge), take the nearest pixel, or set all to
        one height in nm.

    Returns
    -------
    Dataset
        The history contains the number of filled pixels. The heights of a lazy scan are loaded.

    Raises
    ------
    ValueError
        If ``method`` is not among those listed, or all heights are missing.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").isel(x=slice(3), y=slice(3))
    >>> holed = scan.assign(height=scan.height.where(scan.x != scan.x[1]))
    >>> bool(holed.contact.fill().height.isnull().any())
    False
    """
    height = in_memory(ds["height"])
    missing = height.isnull().values
    if not isinstance(method, str) or method not in ("linear", "nearest"):
        try:
            method = float(magnitude(method, "nm", "method"))
        except (ValueError, TypeError):
            raise Refusal("method", "'linear', 'nearest' or a height in nm", f"{method!r}") from None
        height = height.fillna(method)
    elif missing.any():
        height = height.copy(data=_filled(height.values, missing, method, pixel(ds)))
    return label(ds.assign(height=height)).assign_attrs(filled_pixels=int(missing.sum()))


def _filled(height: np.ndarray, missing: np.ndarray, method: str, steps: tuple[float, float]) -> np.ndarray:
    """Return heights without NaN, interpolated from the rim of each hole."""
    from scipy.interpolate import griddata
    from scipy.ndimage import binary_dilation

    if missing.all():
        raise Refusal("fill", "known heights around the missing ones", "none")
    rim = binary_dilation(missing, iterations=2) & ~missing
    places, holes = (np.argwhere(where) * steps for where in (rim, missing))
    values = griddata(places, height[rim], holes, method="nearest")
    if method == "linear" and np.linalg.matrix_rank(places - places[0]) > 1:  # not all on one line
        inside = griddata(places, height[rim], holes, method="linear")
        values = np.where(np.isnan(inside), values, inside)
    height = height.copy()
    height[missing] = values
    return height


@verb("scan")
def crop(ds: xr.Dataset, *, x: Sequence[Quantity] | None = None, y: Sequence[Quantity] | None = None) -> xr.Dataset:
    """Return the part of a scan whose pixel centres lie within ranges of x and y.

    Parameters
    ----------
    ds : Dataset
        A scan.
    x, y : pair of lengths, optional
        Lowest and highest coordinate, inclusive, as nm or text such as ``"2 um"``; by default all.

    Returns
    -------
    Dataset
        With unchanged coordinates.

    Examples
    --------
    >>> import roughxr
    >>> dict(roughxr.scans.crop(roughxr.open_sample("glass"), x=("0.4 um", "1.6 um")).sizes)
    {'x': 123, 'y': 512}
    """
    ranges = {axis: _range(value, axis) for axis, value in (("x", x), ("y", y)) if value is not None}
    out = ds.sel({axis: slice(*limits) for axis, limits in ranges.items()})
    for axis in ranges:
        if out.sizes[axis] < 2:
            low = float(ds[axis][0])
            high = float(ds[axis][-1])
            raise Refusal(axis, f"a range of two pixels or more in {low:g} to {high:g} nm", ranges[axis])
    return out


def _range(value: Any, axis: str) -> tuple[float, float]:
    value = plain(value, "nm", axis)
    ends = value if isinstance(value, (tuple, list, np.ndarray)) else ()
    limits = [float(magnitude(end, "nm", axis)) for end in ends]
    if len(limits) != 2 or not limits[0] < limits[1]:
        raise Refusal(axis, "a pair (lowest, highest) in nm", shown(value))
    return limits[0], limits[1]


@verb("scan")
def resample(ds: xr.Dataset, *, size: Quantity | None = None) -> xr.Dataset:
    """Return a scan on square pixels, interpolated linearly between the old pixel centres.

    Parameters
    ----------
    ds : Dataset
        A scan, of square pixels or not.
    size : length, optional
        The new pixel size, in nm or as text; by default the smaller of the two.

    Returns
    -------
    Dataset
        From the first pixel centre to the last. A pixel with a missing neighbour is missing.

    Notes
    -----
    Heights are not averaged: for pixels several times coarser take ``ds.coarsen(x=2, y=2).mean()``, which avoids
    aliasing.

    Examples
    --------
    >>> import roughxr
    >>> dict(roughxr.scans.resample(roughxr.open_sample("glass"), size="20 nm").sizes)
    {'x': 250, 'y': 250}
    """
    step = min(pixel(ds)) if size is None else positive(size, "nm", "size")
    places = {axis: _places(ds[axis].values, step, axis) for axis in ("x", "y")}
    out = in_memory(ds).interp(places, kwargs={"bounds_error": False})
    out = out.assign_coords({axis: (axis, places[axis], ds[axis].attrs) for axis in ("x", "y")})
    return label(out.transpose("x", "y", ...))


def on_square_pixels(scan: xr.Dataset) -> xr.Dataset:
    """Return a scan, resampled to the smaller side of its pixels with a warning if they are not square."""
    dx, dy = pixel(scan)
    if is_square(dx, dy):
        return scan
    warn(f"pixels of {dx:.6g} × {dy:.6g} nm are not square: heights are interpolated to {min(dx, dy):.6g} nm")
    return resample(scan)


def _places(old: np.ndarray, step: float, axis: str) -> np.ndarray:
    count = int(np.floor((old[-1] - old[0]) / step * (1 + 1e-12))) + 1
    if count < 2:
        raise Refusal("size", f"a pixel size below {old[-1] - old[0]:g} nm along {axis}", f"{step:g}")
    return np.minimum(old[0] + np.arange(count) * step, old[-1])
