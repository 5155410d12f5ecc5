"""NetCDF: roughxr's own, SurfaceTopography's, and plain CF files, all without reading the heights.

SurfaceTopography's have ``heights`` as (x, y) with y counted downwards from the top of the picture, the lateral size in
the attribute ``length`` of x and y, and one ``unit`` for all.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from ...mechanics.vocabulary.schema import spacing
from ...mechanics.vocabulary.text import Argument, Phrase
from ..doors import refuse_damage
from .channel import UnreadableScan, first_bytes, is_length, length_factor, only_one, refuse_absurd

CLASSIC = b"CDF"
HDF5 = b"\x89HDF\r\n\x1a\n"


class _Image(BackendArray):
    """Heights (x, y) in nm, read on first use."""

    def __init__(self, read: Callable[[], np.ndarray], shape: tuple[int, ...]):
        self.read = read
        self.shape = shape
        self.dtype = np.dtype(float)
        self._heights: np.ndarray | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_heights": None}

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._part)

    def _part(self, key: tuple[int | slice, ...]) -> np.ndarray:
        if self._heights is None:
            self._heights = self.read()
        return self._heights[key].copy()


def _heights(path: Path, stored: xr.Variable, mask: xr.Variable | None, ratio: float, width: float) -> np.ndarray:
    """Return stored values times ``ratio`` as heights (nm) of a scan of a width (nm)."""
    try:
        heights = stored.values.astype(float) * ratio
        if mask is not None:
            heights[mask.values != 0] = np.nan
    except MemoryError as error:
        raise UnreadableScan(path, "heights that fit into memory", f"more: {error}") from error
    except (OSError, RuntimeError) as error:  # HDF5's words on a wrong checksum, without the file's name
        raise UnreadableScan(path, "heights that can be read", f"damaged ones: {error}") from error
    refuse_absurd(heights, width, path)
    return heights


def is_netcdf(head: bytes) -> bool:
    """Return whether a file begins as NetCDF 3 or 4."""
    return head.startswith((CLASSIC, HDF5))


def open_netcdf(path: Path, *, channel: str | int | None = None) -> xr.Dataset:
    """Return the scan in a NetCDF file, unread: heights (x, y) in nm."""
    ds = unread(path)
    try:
        name = _variable_name(ds, channel, path)
        return _scan(_with_centres(ds, path) if _is_surface_topography(ds, name) else ds, name, path)
    except BaseException:
        ds.close()
        raise


def unread(path: Path) -> xr.Dataset:
    """Return a file's Dataset, unread; for an archive with groups, the group ``scan``."""
    refuse_damage(path)
    engine = "scipy" if first_bytes(path, 4) in (b"CDF\1", b"CDF\2") else "netcdf4"
    opened = partial(xr.open_dataset, path, engine=engine, cache=False, decode_times=False)
    ds = opened()
    if ds.variables or engine == "scipy":
        return ds
    ds.close()
    try:
        return opened(group="scan")
    except OSError:
        raise UnreadableScan(path, "a variable of heights or a group 'scan'", "neither") from None


def variable_names(path: Path) -> list[str]:
    """Return the names of the variables with heights."""
    with unread(path) as ds:
        return _lengths(ds)


def _maps(ds: xr.Dataset) -> dict[str, xr.DataArray]:
    return {str(name): var for name, var in ds.data_vars.items() if var.ndim == 2}


def _lengths(ds: xr.Dataset) -> list[str]:
    return [name for name, var in _maps(ds).items() if is_length(_units(var))]


def _units(variable: xr.DataArray) -> str | None:
    return variable.attrs.get("units", variable.attrs.get("unit"))


def _variable_name(ds: xr.Dataset, channel: str | int | None, path: Path) -> str:
    maps = _maps(ds)
    lengths = _lengths(ds)
    if isinstance(channel, (int, np.integer)):
        names = lengths[channel : channel + 1] if channel >= 0 else []
    else:
        names = [channel] if channel else [name for name in ("height", "heights") if name in maps] or lengths
    wanted = f"a variable {channel!r}" if channel is not None else "one variable of heights with units of length"
    listed = ", ".join(f"{name} [{_units(var) or '?'}]" for name, var in maps.items()) or "none"
    fitting = [name for name in names if name in maps]
    advice = Phrase("name it with ", Argument("channel", ...))
    name = only_one(path, fitting, f"{wanted} over two dimensions", listed, advice)
    length_factor(path, _units(maps[name]), "'units' of a length", where=(name,))
    return name


def _is_surface_topography(ds: xr.Dataset, name: str) -> bool:
    """Return whether a file has any mark of SurfaceTopography's convention; incomplete files are refused later."""
    marks = any("length" in ds[axis].attrs for axis in ("x", "y") if axis in ds.variables)
    return name == "heights" and (marks or "unit" in ds[name].attrs)


def _with_centres(ds: xr.Dataset, path: Path) -> xr.Dataset:
    """Return a file in SurfaceTopography's convention with its pixel centres as coordinates."""
    for axis in ("x", "y"):
        if axis not in ds.variables or "length" not in ds[axis].attrs:
            raise UnreadableScan(path, "a variable with its size in an attribute 'length'", "none", where=(axis,))
        count = ds[axis].size
        pixel = float(ds[axis].attrs["length"]) / count
        if count > 1 and abs(spacing(ds[axis]) - pixel) > 1e-6 * pixel:
            raise UnreadableScan(path, f"steps of {pixel:g} by 'length'", f"{spacing(ds[axis]):g}", where=(axis,))
        centres = (np.arange(count) + 0.5) * pixel
        ds = ds.assign_coords({axis: (axis, centres if axis == "x" else centres[::-1], ds[axis].attrs)})
    return ds


def _ratio(variable: xr.DataArray, path: Path) -> float:
    """Return nm per unit of a variable."""
    return length_factor(path, _units(variable), "'units' of a length", where=(str(variable.name),))


def _axes(ds: xr.Dataset, name: str, path: Path) -> tuple[str, str]:
    """Return the names of the dimensions of a variable along x and y."""
    named = {}
    for dim in map(str, ds[name].dims):
        if dim not in ds.coords:
            raise UnreadableScan(path, "a coordinate with units along this dimension", "none", where=(dim,))
        named[str(ds[dim].attrs.get("axis", dim)).lower()] = dim
    if set(named) != {"x", "y"}:
        raise UnreadableScan(path, "dimensions x and y (or axis attributes)", f"{ds[name].dims}", where=(name,))
    return named["x"], named["y"]


def _scan(ds: xr.Dataset, name: str, path: Path) -> xr.Dataset:
    """Return the labelled, unread scan of a variable, with ascending axes; roughxr's own files keep everything else.

    Drop the encoding: packing would quantise results.
    """
    dims = _axes(ds, name, path)
    ratios = [_ratio(ds[dim], path) for dim in dims]
    upwards = ds.isel({dim: slice(None, None, -1) for dim in dims if ds[dim].values[-1] < ds[dim].values[0]})
    values = [np.asarray(upwards[dim].values, dtype=float) * ratio for dim, ratio in zip(dims, ratios)]
    stored = upwards[name].variable.transpose(*dims)
    mask = upwards["mask"].variable.transpose(*dims) if name == "heights" and "mask" in ds.variables else None
    read = partial(_heights, path, stored, mask, _ratio(ds[name], path), max(map(np.ptp, values)))
    image = indexing.LazilyIndexedArray(_Image(read, stored.shape))
    is_scan = name == "height" and dims == ("x", "y")
    base = ds.drop_vars([name, *dims]) if is_scan else xr.Dataset()
    attrs = {variable: {**(ds[variable].attrs if is_scan else {}), "units": "nm"} for variable in (name, *dims)}
    height = xr.Variable(("x", "y"), image, attrs[name])
    coords = {axis: (axis, centres, attrs[dim]) for axis, dim, centres in zip("xy", dims, values)}
    out = base.assign_coords(coords).assign(height=height).assign_attrs(ds.attrs)
    out.set_close(ds.close)
    return out
