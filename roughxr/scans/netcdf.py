"""NetCDF: roughxr's own, SurfaceTopography's, and plain CF files, all without reading the heights.

SurfaceTopography's carry ``heights`` as (x, y) with y counted downwards from the top of the picture, the lateral size
in the attribute ``length`` of x and y, and one ``unit`` for all.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from ..vocabulary.schema import spacing
from ..vocabulary.units import factor
from . import netcdf_reader, reader_process
from .channel import UnreadableScan, first_bytes, is_length
from .plausibility import refuse_absurd

CLASSIC = b"CDF"
HDF5 = b"\x89HDF\r\n\x1a\n"


class _Image(NamedTuple):
    """A two-dimensional variable of a file: how to bring it into (x, y), ascending, in nm."""

    path: Path
    variable: xr.Variable
    dims: tuple[str, str]  # the file's names for x and y
    flipped: tuple[bool, bool]
    ratio: float
    width: float  # the longer side in nm
    mask: xr.Variable | None = None


class _LazyImage(BackendArray):
    """Heights as (x, y) in nm that are read slice by slice."""

    def __init__(self, image: _Image):
        self.image = image
        self.shape = tuple(image.variable.sizes[dim] for dim in image.dims)
        self.dtype = np.dtype(float)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: tuple[int | slice, ...]) -> np.ndarray:
        slices = [slice(k, k + 1) if isinstance(k, (int, np.integer)) else k for k in key]
        try:
            values = self._part(self.image.variable, slices).astype(float) * self.image.ratio
            if self.image.mask is not None:
                values[self._part(self.image.mask, slices) != 0] = np.nan
        except (OSError, RuntimeError) as error:  # what HDF5 says of a wrong checksum, without the file's name
            raise UnreadableScan(self.image.path, f"damaged, its heights cannot be read: {error}") from error
        refuse_absurd(values, self.image.width, self.image.path)
        return values[tuple(0 if isinstance(k, (int, np.integer)) else slice(None) for k in key)]

    def _part(self, variable: xr.Variable, slices: list[slice]) -> np.ndarray:
        """Return the part of a file's variable that lies at ``slices`` of x and y."""
        backwards = [slice(None, None, -1) if flip else slice(None) for flip in self.image.flipped]
        turned = [_mirrored(s, n) if flip else s for s, n, flip in zip(slices, self.shape, self.image.flipped)]
        part = variable.isel(dict(zip(self.image.dims, turned)))
        return part.transpose(*self.image.dims).values[tuple(backwards)]


def _mirrored(part: slice, size: int) -> slice:
    """Return the ascending slice that holds, read backwards, what ``part`` holds of the reversed axis."""
    places = range(size)[part]
    return slice(size - 1 - places[-1], size - places[0], places.step) if places else slice(0, 0)


def is_netcdf(head: bytes) -> bool:
    """Return whether a file begins as NetCDF 3 or 4 does."""
    return head.startswith((CLASSIC, HDF5))


def open_netcdf(path: Path, *, channel: str | int | None = None) -> xr.Dataset:
    """Return the scan in a NetCDF file, unread: heights (x, y) in nm."""
    ds = unread(path)
    try:
        name = _variable_name(ds, channel, path)
        image = _surface_topography(ds, path) if _is_surface_topography(ds, name) else _cf(ds, name, path)
        return _scan(ds, name, *image)
    except BaseException:
        ds.close()
        raise


def unread(path: Path) -> xr.Dataset:
    """Return a file's Dataset, unread; of an archive with groups, the group ``scan``."""
    engine = "scipy" if first_bytes(path, 4) in (b"CDF\1", b"CDF\2") else "netcdf4"
    if engine == "netcdf4":
        refuse_harmful(path)
    opened = partial(xr.open_dataset, path, engine=engine, cache=False, decode_times=False)
    ds = opened()
    if ds.variables or engine == "scipy":
        return ds
    ds.close()
    try:
        return opened(group="scan")
    except OSError:
        raise UnreadableScan(path, "expected a variable of heights or a group 'scan', found neither") from None


def refuse_harmful(path: Path) -> None:
    """Raise unless another process, which can be ended, could look at all of a NetCDF-4 file but its values."""
    try:
        reader_process.ask(path, netcdf_reader.__file__)
    except reader_process.ReadingFailed as failure:
        raise UnreadableScan(path, str(failure)) from None


def variable_names(path: Path) -> list[str]:
    """Return the names of the variables that a scan can be read from."""
    with unread(path) as ds:
        return _lengths(_maps(ds))


def _maps(ds: xr.Dataset) -> dict[str, xr.DataArray]:
    return {str(name): var for name, var in ds.data_vars.items() if var.ndim == 2}


def _lengths(maps: dict[str, xr.DataArray]) -> list[str]:
    return [name for name, var in maps.items() if is_length(_units(var))]


def _variable_name(ds: xr.Dataset, channel: str | int | None, path: Path) -> str:
    maps = _maps(ds)
    lengths = _lengths(maps)
    if isinstance(channel, (int, np.integer)):
        names = lengths[channel : channel + 1] if channel >= 0 else []
    else:
        names = [channel] if channel else [name for name in ("height", "heights") if name in maps] or lengths
    if len(names) != 1 or names[0] not in maps:
        wanted = f"a variable {channel!r}" if channel is not None else "one variable of heights with units of length"
        found = ", ".join(f"{name} [{_units(var) or '?'}]" for name, var in maps.items()) or "none"
        raise UnreadableScan(path, f"expected {wanted} over two dimensions, found {found}; name it with channel=")
    if names[0] not in lengths:
        raise UnreadableScan(
            path, f"{names[0]}: expected a 'units' attribute of a length, found {_units(maps[names[0]])!r}"
        )
    return names[0]


def _units(variable: xr.DataArray) -> str | None:
    return variable.attrs.get("units", variable.attrs.get("unit"))


def _is_surface_topography(ds: xr.Dataset, name: str) -> bool:
    """Return whether a file has any mark of the convention: half of one must not pass for another."""
    marks = any("length" in ds[axis].attrs for axis in ("x", "y") if axis in ds.variables)
    return name == "heights" and (marks or "unit" in ds[name].attrs)


def _surface_topography(ds: xr.Dataset, path: Path) -> tuple[_Image, dict[str, np.ndarray]]:
    """Return the image and pixel centres of a file in SurfaceTopography's convention."""
    if set(ds["heights"].dims) != {"x", "y"}:
        raise UnreadableScan(path, f"heights: expected dimensions (x, y), found {ds['heights'].dims}")
    centres = {}
    for axis in ("x", "y"):
        if axis not in ds.variables:
            raise UnreadableScan(path, f"{axis}: expected a variable with its 'length', found none")
        if "length" not in ds[axis].attrs:
            raise UnreadableScan(path, f"{axis}: expected its lateral size in an attribute 'length', found none")
        pixel = float(ds[axis].attrs["length"]) / ds.sizes[axis]
        if ds.sizes[axis] > 1 and abs(spacing(ds[axis]) - pixel) > 1e-6 * pixel:
            raise UnreadableScan(path, f"{axis}: expected steps of {pixel:g} by 'length', found {spacing(ds[axis]):g}")
        centres[axis] = (np.arange(ds.sizes[axis]) + 0.5) * pixel * _ratio(ds[axis], path, "unit")
    mask = ds["mask"].variable if "mask" in ds.variables else None
    ratio = _ratio(ds["heights"], path, "unit")
    image = _Image(path, ds["heights"].variable, ("x", "y"), (False, True), ratio, _width(centres), mask)
    return image, centres


def _cf(ds: xr.Dataset, name: str, path: Path) -> tuple[_Image, dict[str, np.ndarray]]:
    """Return the image and pixel centres of a labelled file, whichever way its axes run."""
    dims = _axes(ds, name, path)
    values = [np.asarray(ds[dim].values, dtype=float) * _ratio(ds[dim], path) for dim in dims]
    flip_x, flip_y = flipped = [bool(v.size > 1 and v[-1] < v[0]) for v in values]
    centres = {axis: v[::-1] if flip else v for axis, v, flip in zip("xy", values, flipped)}
    return _Image(path, ds[name].variable, dims, (flip_x, flip_y), _ratio(ds[name], path), _width(centres)), centres


def _width(centres: dict[str, np.ndarray]) -> float:
    return max(float(np.ptp(values)) for values in centres.values())


def _axes(ds: xr.Dataset, name: str, path: Path) -> tuple[str, str]:
    """Return the file's names for x and y."""
    dims = {}
    for dim in map(str, ds[name].dims):
        if dim not in ds.coords:
            raise UnreadableScan(path, f"{dim}: expected a coordinate with units along this dimension, found none")
        dims[str(ds[dim].attrs.get("axis", dim)).lower()] = dim
    if set(dims) != {"x", "y"}:
        raise UnreadableScan(
            path, f"{name}: expected dimensions x and y (or axis attributes), found {tuple(ds[name].dims)}"
        )
    return dims["x"], dims["y"]


def _ratio(variable: xr.DataArray, path: Path, attribute: str = "units") -> float:
    """Return nm per unit of a variable; SurfaceTopography says ``unit``, all others ``units``."""
    units = variable.attrs.get(attribute)
    if not is_length(units):
        raise UnreadableScan(path, f"{variable.name}: expected {attribute!r} of a length, found {units!r}")
    return factor(units, "nm")


def _scan(ds: xr.Dataset, name: str, image: _Image, centres: dict[str, Any]) -> xr.Dataset:
    """Return the labelled, unread scan; of roughxr's own files all else stays as it is."""
    own = name == "height" and image.dims == ("x", "y")
    kept = {axis: ds[axis].attrs if own else {} for axis in ("x", "y")}
    height = xr.Variable(
        ("x", "y"),
        indexing.LazilyIndexedArray(_LazyImage(image)),
        {**(ds[name].attrs if own else {}), "units": "nm"},
        _encoding(image),
    )
    coords = {axis: (axis, values, {**kept[axis], "units": "nm"}) for axis, values in centres.items()}
    base = ds.drop_vars([name, *[axis for axis in "xy" if axis in ds.variables]]) if own else xr.Dataset()
    out = base.assign_coords(coords).assign(height=height).assign_attrs(ds.attrs)
    out.set_close(ds.close)
    return out


def _encoding(image: _Image) -> dict[str, Any]:
    """Return the chunks in which the file is read best; packing is left behind, it would quantise results."""
    chunks = image.variable.encoding.get("preferred_chunks", {})
    named = {axis: chunks[dim] for axis, dim in zip("xy", image.dims) if dim in chunks}
    return {"preferred_chunks": named} if named else {}
