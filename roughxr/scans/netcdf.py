"""NetCDF: roughxr's own, SurfaceTopography's, and plain CF files, all without reading the heights.

SurfaceTopography's carry ``heights`` as (x, y) with y counted downwards from the top of the picture, the lateral size
in the attribute ``length`` of x and y, and one ``unit`` for all.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from ..vocabulary.schema import spacing
from ..vocabulary.units import factor
from . import netcdf_reader
from .channel import Channel, UnreadableScan, direction_in, first_bytes, is_length, read_in_process
from .plausibility import refuse_absurd

CLASSIC = b"CDF"
HDF5 = b"\x89HDF\r\n\x1a\n"


class _Image(BackendArray):
    """A two-dimensional variable of a file as heights (x, y) in nm, ascending, read at the first look."""

    def __init__(self, path: Path, variable: xr.Variable, dims: tuple[str, str], ratio: float, width: float):
        self.path, self.variable, self.dims = path, variable, dims  # the file's names for x and y
        self.ratio, self.width = ratio, width  # nm per unit; the longer side in nm
        self.flipped = (False, False)
        self.mask: xr.Variable | None = None
        self.shape = tuple(variable.sizes[dim] for dim in dims)
        self.dtype = np.dtype(float)
        self._heights: np.ndarray | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_heights": None}

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._part)

    def _part(self, key: tuple[int | slice, ...]) -> np.ndarray:
        if self._heights is None:
            self._heights = self._read()
        return self._heights[key].copy()

    def _read(self) -> np.ndarray:
        try:
            heights = self.variable.transpose(*self.dims).values.astype(float) * self.ratio
            if self.mask is not None:
                heights[self.mask.transpose(*self.dims).values != 0] = np.nan
        except (OSError, RuntimeError) as error:  # HDF5's words on a wrong checksum, without the file's name
            raise UnreadableScan(self.path, f"damaged, its heights cannot be read: {error}") from error
        refuse_absurd(heights, self.width, self.path)
        return heights[tuple(slice(None, None, -1 if flip else 1) for flip in self.flipped)]


def is_netcdf(head: bytes) -> bool:
    """Return whether a file begins as NetCDF 3 or 4 does."""
    return head.startswith((CLASSIC, HDF5))


def open_netcdf(path: Path, *, channel: str | int | None = None) -> xr.Dataset:
    """Return the scan in a NetCDF file, unread: heights (x, y) in nm."""
    ds = unread(path)
    try:
        name = _variable_name(ds, channel, path)
        image, centres = (_surface_topography if _is_surface_topography(ds, name) else _cf)(ds, name, path)
        return _scan(ds, name, image, centres)
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


def refuse_harmful(path: Path) -> list[tuple[str, tuple[int, int], str]]:
    """Return the matrices in an HDF5 file; raise unless a separate process could read its whole structure."""
    return read_in_process(path, netcdf_reader, "netCDF4")["images"]


def unlabelled_images(path: Path) -> list[Channel]:
    """Return the matrices of an HDF5 file, rows from the top, as images without a size."""
    images = refuse_harmful(path) if first_bytes(path, len(HDF5)) == HDF5 else []
    return [
        Channel(name, units or None, shape, None, None, partial(_matrix, path, name), direction_in(name))
        for name, shape, units in images
    ]


def _matrix(path: Path, name: str) -> np.ndarray:
    import netCDF4

    with netCDF4.Dataset(path) as file:
        return np.ma.filled(np.ma.asarray(file[name][:], dtype=float), np.nan)


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
        listed = ", ".join(f"{name} [{_units(var) or '?'}]" for name, var in maps.items()) or "none"
        raise UnreadableScan(path, f"expected {wanted} over two dimensions, found {listed}; name it with channel=")
    if names[0] not in lengths:
        raise UnreadableScan(
            path, f"{names[0]}: expected a 'units' attribute of a length, found {_units(maps[names[0]])!r}"
        )
    return names[0]


def _units(variable: xr.DataArray) -> str | None:
    return variable.attrs.get("units", variable.attrs.get("unit"))


def _is_surface_topography(ds: xr.Dataset, name: str) -> bool:
    """Return whether a file has any mark of SurfaceTopography's convention; an incomplete one is refused later."""
    marks = any("length" in ds[axis].attrs for axis in ("x", "y") if axis in ds.variables)
    return name == "heights" and (marks or "unit" in ds[name].attrs)


def _surface_topography(ds: xr.Dataset, name: str, path: Path) -> tuple[_Image, dict[str, np.ndarray]]:
    """Return the image and pixel centres of a file in SurfaceTopography's convention."""
    if set(ds[name].dims) != {"x", "y"}:
        raise UnreadableScan(path, f"{name}: expected dimensions (x, y), found {ds[name].dims}")
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
    image = _Image(path, ds[name].variable, ("x", "y"), _ratio(ds[name], path, "unit"), _width(centres))
    image.flipped = (False, True)
    image.mask = ds["mask"].variable if "mask" in ds.variables else None
    return image, centres


def _cf(ds: xr.Dataset, name: str, path: Path) -> tuple[_Image, dict[str, np.ndarray]]:
    """Return the image and pixel centres of a labelled file, whichever way its axes run."""
    dims = _axes(ds, name, path)
    values = [np.asarray(ds[dim].values, dtype=float) * _ratio(ds[dim], path) for dim in dims]
    flipped = [bool(v.size > 1 and v[-1] < v[0]) for v in values]
    centres = {axis: v[::-1] if flip else v for axis, v, flip in zip("xy", values, flipped)}
    image = _Image(path, ds[name].variable, dims, _ratio(ds[name], path), _width(centres))
    image.flipped = (flipped[0], flipped[1])
    return image, centres


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
    """Return nm per unit of a variable; SurfaceTopography's attribute is ``unit``, all others' ``units``."""
    units = variable.attrs.get(attribute)
    if not is_length(units):
        raise UnreadableScan(path, f"{variable.name}: expected {attribute!r} of a length, found {units!r}")
    return factor(units, "nm")


def _scan(ds: xr.Dataset, name: str, image: _Image, centres: dict[str, np.ndarray]) -> xr.Dataset:
    """Return the labelled, unread scan, with all other variables of roughxr's own files.

    Drop the encoding: packing would quantise results.
    """
    own = name == "height" and image.dims == ("x", "y")
    attributes = {axis: ds[axis].attrs if own else {} for axis in ("x", "y")}
    height = xr.Variable(
        ("x", "y"),
        indexing.LazilyIndexedArray(image),
        {**(ds[name].attrs if own else {}), "units": "nm"},
    )
    coords = {axis: (axis, values, {**attributes[axis], "units": "nm"}) for axis, values in centres.items()}
    base = ds.drop_vars([name, *[axis for axis in "xy" if axis in ds.variables]]) if own else xr.Dataset()
    out = base.assign_coords(coords).assign(height=height).assign_attrs(ds.attrs)
    out.set_close(ds.close)
    return out
