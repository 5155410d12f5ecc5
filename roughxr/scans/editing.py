"""Change what a scan covers or how finely: fill, crop, resample, rotate. Labels follow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary.schema import label, pixel, record, validate
from ..vocabulary.units import Quantity, is_whole, magnitude, plain, positive

#: Pairs of coordinates ``…_x``, ``…_y`` (nm) that are positions on the scan, and turn with it.
_POSITIONS = ("subregion", "pass", "carrier", "apex")


def fill(ds: xr.Dataset, *, method: Quantity = "linear") -> xr.Dataset:
    """Return a scan whose missing pixels are filled from those around them.

    Parameters
    ----------
    ds : Dataset
        A scan.
    method : {"linear", "nearest"} or length
        Interpolate linearly across each hole (nearest pixel where it opens to the edge), take the nearest
        pixel, or set all to one height in nm.

    Returns
    -------
    Dataset
        The history contains the number of filled pixels. The heights of a lazy scan are loaded.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> nm, places = {"units": "nm"}, ("place", [0.0, 1.0, 2.0])
    >>> height = np.add.outer([0.0, 1.0, 2.0], [0.0, 1.0, 2.0])
    >>> height[1, 1] = np.nan
    >>> axes = {axis: (axis, [0.0, 1.0, 2.0], nm) for axis in "xy"}
    >>> fill(xr.Dataset({"height": (("x", "y"), height, nm)}, axes)).height[1, 1].item()
    2.0
    """
    scan = validate(ds, "scan")
    if not isinstance(method, str) or method not in ("linear", "nearest"):
        method = _constant(method)
    height = scan["height"].compute()
    count = int(height.isnull().sum())
    if isinstance(method, float):
        filled = height.fillna(method)
    else:
        filled = height.copy(data=_filled(height.values, method, pixel(scan)))
    return record(label(scan.assign(height=filled)), "fill", method=method, pixels=count)


def _constant(method: Any) -> float:
    try:
        return float(magnitude(method, "nm", "method"))
    except (ValueError, TypeError):
        raise ValueError(f"method: expected 'linear', 'nearest' or a height in nm, found {method!r}") from None


def _filled(height: np.ndarray, method: str, steps: tuple[float, float]) -> np.ndarray:
    """Return heights without NaN, interpolated from the rim of each hole only."""
    from scipy.interpolate import griddata
    from scipy.ndimage import binary_dilation

    missing = np.isnan(height)
    if not missing.any():
        return height
    if missing.all():
        raise ValueError("fill: expected known heights around the missing ones, found none")
    rim = binary_dilation(missing, iterations=2) & ~missing
    places, holes = (np.argwhere(where) * steps for where in (rim, missing))
    values = griddata(places, height[rim], holes, method="nearest")
    if method == "linear" and len(places) > 3:
        inside = griddata(places, height[rim], holes, method="linear")
        values = np.where(np.isnan(inside), values, inside)
    out = height.copy()
    out[missing] = values
    return out


def crop(ds: xr.Dataset, *, x: Sequence[Quantity] | None = None, y: Sequence[Quantity] | None = None) -> xr.Dataset:
    """Return the part of a scan whose pixel centres lie within ranges of x and y.

    Parameters
    ----------
    ds : Dataset
        A scan.
    x, y : pair of lengths, optional
        Lowest and highest place, inclusive, as nm or text such as ``"2 um"``; by default all.

    Returns
    -------
    Dataset
        With its old coordinates: places keep their names.

    Examples
    --------
    >>> import xarray as xr, numpy as np
    >>> axes = {axis: (axis, np.arange(5.0) * 500, {"units": "nm"}) for axis in "xy"}
    >>> scan = xr.Dataset({"height": (("x", "y"), np.zeros((5, 5)), {"units": "nm"})}, axes)
    >>> crop(scan, x=("0.4 um", "1.6 um")).x.values
    array([ 500., 1000., 1500.])
    """
    scan = validate(ds, "scan")
    ranges = {axis: _range(value, axis) for axis, value in (("x", x), ("y", y)) if value is not None}
    out = scan.sel({axis: slice(*limits) for axis, limits in ranges.items()})
    for axis in ranges:
        if out.sizes[axis] < 2:
            low, high = float(scan[axis][0]), float(scan[axis][-1])
            raise ValueError(
                f"{axis}: expected a range of two pixels or more in {low:g} to {high:g} nm, found {ranges[axis]}"
            )
    return record(out, "crop", **ranges)


def _range(value: Any, axis: str) -> tuple[float, float]:
    value = plain(value, "nm", axis)
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise ValueError(f"{axis}: expected a pair (lowest, highest) in nm, found {value!r}")
    low, high = (float(magnitude(end, "nm", axis)) for end in value)
    if not low < high:
        raise ValueError(f"{axis}: expected (lowest, highest) in nm, found {value!r}")
    return low, high


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
        From the first to the last pixel centre at most; lazy where the scan is. A pixel without both neighbours is
        missing.

    Notes
    -----
    Nothing is averaged: for pixels several times coarser, ``ds.coarsen(x=2, y=2).mean()`` keeps fine
    roughness from being taken for coarse.

    Examples
    --------
    >>> import xarray as xr, numpy as np
    >>> axes = {a: (a, np.arange(n) * s, {"units": "nm"}) for a, n, s in (("x", 5, 10.0), ("y", 3, 20.0))}
    >>> scan = xr.Dataset({"height": (("x", "y"), np.zeros((5, 3)), {"units": "nm"})}, axes)
    >>> dict(resample(scan).sizes)
    {'x': 5, 'y': 5}
    """
    scan = validate(ds, "scan")
    step = min(pixel(scan)) if size is None else positive(size, "nm", "size")
    places = {axis: _places(scan[axis].values, step, axis) for axis in ("x", "y")}
    out = scan
    for axis in ("x", "y"):  # one after the other: a scan of lazy chunks can then be interpolated too
        out = out.interp({axis: places[axis]}, kwargs={"bounds_error": False})
    out = out.assign_coords({axis: (axis, places[axis], scan[axis].attrs) for axis in ("x", "y")})
    return record(label(out.transpose("x", "y", ...)), "resample", size=step)


def _places(old: np.ndarray, step: float, axis: str) -> np.ndarray:
    count = int(np.floor((old[-1] - old[0]) / step * (1 + 1e-12))) + 1
    if count < 2:
        raise ValueError(f"size: expected a pixel size below {old[-1] - old[0]:g} nm along {axis}, found {step:g}")
    return np.minimum(old[0] + np.arange(count) * step, old[-1])


def rotate90(ds: xr.Dataset, *, turns: int = 1) -> xr.Dataset:
    """Return a scan turned by quarter turns anticlockwise, as seen with x to the right and y upwards.

    Parameters
    ----------
    ds : Dataset
        A scan, of square pixels or not.
    turns : int
        Quarter turns; negative ones are clockwise.

    Returns
    -------
    Dataset
        Its lower left corner lies where the old one lay. Contact centres on the scan turn with it.

    Examples
    --------
    >>> import xarray as xr
    >>> axes = {axis: (axis, [0.0, 1.0], {"units": "nm"}) for axis in "xy"}
    >>> scan = xr.Dataset({"height": (("x", "y"), [[0.0, 0.0], [7.0, 0.0]], {"units": "nm"})}, axes)
    >>> rotate90(scan).height.sel(x=1, y=1).item()  # from lower right to upper right
    7.0
    """
    scan = validate(ds, "scan")
    if not is_whole(turns):
        raise ValueError(f"turns: expected a whole number of quarter turns, found {turns!r}")
    out = scan
    for _ in range(turns % 4):
        out = _turned(out)
    return record(label(out), "rotate90", turns=int(turns))


def _turned(scan: xr.Dataset) -> xr.Dataset:
    """Return a scan after a quarter turn: what lay at (x, y) lies at (y measured from the far end, x)."""
    dx, dy = pixel(scan)
    corner = {"x": float(scan["x"][0]) - dx / 2, "y": float(scan["y"][0]) - dy / 2}
    along_x = corner["x"] + dy * (np.arange(scan.sizes["y"]) + 0.5)
    along_y = corner["y"] + dx * (np.arange(scan.sizes["x"]) + 0.5)
    maps = [name for name in scan.data_vars if {"x", "y"} <= set(scan[name].dims)]
    bare = scan[maps].isel(y=slice(None, None, -1)).drop_vars(["x", "y"])
    turned = bare.rename_dims(x="y_", y="x_").rename_dims(x_="x", y_="y").transpose("x", "y", ...)
    turned = turned.assign_coords(x=("x", along_x, scan["x"].attrs), y=("y", along_y, scan["y"].attrs))
    rest = scan.drop_dims(["x", "y"])
    far = corner["y"] + dy * scan.sizes["y"]
    for name in _POSITIONS:
        if {f"{name}_x", f"{name}_y"} <= set(rest.variables):
            old_x, old_y = rest[f"{name}_x"], rest[f"{name}_y"]
            new_x = (corner["x"] + far - old_y).assign_attrs(old_x.attrs)
            new_y = (corner["y"] + old_x - corner["x"]).assign_attrs(old_y.attrs)
            rest = rest.assign_coords({f"{name}_x": new_x, f"{name}_y": new_y})
    return turned.merge(rest).assign_attrs(scan.attrs)
