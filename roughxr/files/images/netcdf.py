"""NetCDF: roughxr's own, SurfaceTopography's, and plain CF files, all without reading the heights.

SurfaceTopography's have ``heights`` as (x, y) with y counted downwards from the top of the picture, the lateral size in
the attribute ``length`` of x and y, and one ``unit`` for all.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from ...mechanics.vocabulary.schema import spacing
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
        return (_surface_topography if _is_surface_topography(ds, name) else _cf)(ds, name, path)
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
    name = only_one(path, fitting, f"{wanted} over two dimensions", listed, "name it with channel=")
    length_factor(path, _units(maps[name]), "'units' of a length", where=(name,))
    return name


def _is_surface_topography(ds: xr.Dataset, name: str) -> bool:
    """Return whether a file has any mark of SurfaceTopography's convention; incomplete files are refused later."""
    marks = any("length" in ds[axis].attrs for axis in ("x", "y") if axis in ds.variables)
    return name == "heights" and (marks or "unit" in ds[name].attrs)


def _surface_topography(ds: xr.Dataset, name: str, path: Path) -> xr.Dataset:
    """Return the scan of a file in SurfaceTopography's convention."""
    _refuse_other_dims(path, name, ds[name].dims, ds[name].dims)
    centres = {}
    for axis in ("x", "y"):
        if axis not in ds.variables or "length" not in ds[axis].attrs:
            raise UnreadableScan(path, "a variable with its size in an attribute 'length'", "none", where=(axis,))
        pixel = float(ds[axis].attrs["length"]) / ds.sizes[axis]
        if ds.sizes[axis] > 1 and abs(spacing(ds[axis]) - pixel) > 1e-6 * pixel:
            raise UnreadableScan(path, f"steps of {pixel:g} by 'length'", f"{spacing(ds[axis]):g}", where=(axis,))
        centres[axis] = (np.arange(ds.sizes[axis]) + 0.5) * pixel * _ratio(ds[axis], path, "unit")
    upwards = ds.isel(y=slice(None, None, -1))
    return _scan(ds, upwards, name, ("x", "y"), centres, _ratio(ds[name], path, "unit"), path)


def _cf(ds: xr.Dataset, name: str, path: Path) -> xr.Dataset:
    """Return the scan of a labelled file, with ascending axes."""
    dims = {}
    for dim in map(str, ds[name].dims):
        if dim not in ds.coords:
            raise UnreadableScan(path, "a coordinate with units along this dimension", "none", where=(dim,))
        dims[str(ds[dim].attrs.get("axis", dim)).lower()] = dim
    _refuse_other_dims(path, name, dims, ds[name].dims)
    values = {axis: np.asarray(ds[dims[axis]].values, dtype=float) * _ratio(ds[dims[axis]], path) for axis in "xy"}
    turned = {dims[a]: slice(None, None, -1 if v.size > 1 and v[-1] < v[0] else 1) for a, v in values.items()}
    centres = {axis: v[turned[dims[axis]]] for axis, v in values.items()}
    return _scan(ds, ds.isel(turned), name, (dims["x"], dims["y"]), centres, _ratio(ds[name], path), path)


def _refuse_other_dims(path: Path, name: str, axes: Iterable[Hashable], dims: tuple[Hashable, ...]) -> None:
    """Raise unless the axes of a variable are x and y."""
    if set(axes) != {"x", "y"}:
        raise UnreadableScan(path, "dimensions x and y (or axis attributes)", f"{tuple(dims)}", where=(name,))


def _ratio(variable: xr.DataArray, path: Path, attribute: str = "units") -> float:
    """Return nm per unit of a variable; the attribute is ``units``, in SurfaceTopography ``unit``."""
    what = f"{attribute!r} of a length"
    return length_factor(path, variable.attrs.get(attribute), what, where=(str(variable.name),))


def _scan(
    ds: xr.Dataset,
    turned: xr.Dataset,
    name: str,
    dims: tuple[str, str],
    centres: dict[str, np.ndarray],
    ratio: float,
    path: Path,
) -> xr.Dataset:
    """Return the labelled, unread scan, heights of ``turned`` along ``dims``; roughxr's own files keep everything else.

    Drop the encoding: packing would quantise results.
    """
    stored = turned[name].variable.transpose(*dims)
    is_scan = name == "height" and dims == ("x", "y")
    mask = turned["mask"].variable.transpose(*dims) if name == "heights" and "mask" in ds.variables else None
    width = max(np.ptp(values) for values in centres.values())
    image = indexing.LazilyIndexedArray(_Image(partial(_heights, path, stored, mask, ratio, width), stored.shape))
    height = xr.Variable(("x", "y"), image, {**(ds[name].attrs if is_scan else {}), "units": "nm"})
    coords = {a: (a, v, {**(ds[a].attrs if is_scan else {}), "units": "nm"}) for a, v in centres.items()}
    base = ds.drop_vars([name, *[axis for axis in "xy" if axis in ds.variables]]) if is_scan else xr.Dataset()
    out = base.assign_coords(coords).assign(height=height).assign_attrs(ds.attrs)
    out.set_close(ds.close)
    return out
