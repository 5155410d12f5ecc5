"""Write a scan for other programs, and as roughxr's own NetCDF-4."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..archive import as_characters, uninterrupted, whole
from ..vocabulary import schema
from ..vocabulary.schema import pixel, validate
from .channel import optional

#: Chunks of a native file: a 512 x 512 block of heights is 2 MiB.
_CHUNK = 512


#: Factor and name of the SI unit of each unit that maps have here.
_SI = {"nm": (1e-9, "m"), "nN": (1e-9, "N"), "GPa": (1e9, "Pa"), "nm^2": (1e-18, "m^2"), "J/m^2": (1.0, "J/m^2")}
_SI["1"] = (1.0, "")


def _map(ds: xr.Dataset, name: str) -> xr.Dataset:
    """Return a Dataset that holds a map; raise for any other."""
    maps = [str(variable) for variable in ds.data_vars if set(ds[variable].dims) == {"x", "y"}]
    if name not in maps:
        dims = tuple(ds[name].dims) if name in ds else "no such variable"
        raise ValueError(
            f"name: expected a map along x and y ({', '.join(maps) or 'none here'}), found {name!r}: {dims}"
        )
    return ds


def to_netcdf(ds: xr.Dataset, path: str | os.PathLike) -> Path:
    """Write a scan as roughxr's own NetCDF-4: everything it holds, in chunks, each with a checksum.

    Parameters
    ----------
    ds : Dataset
    path : path

    Returns
    -------
    Path
        The file.

    Examples
    --------
    >>> import tempfile, numpy as np, xarray as xr
    >>> from roughxr.scans import open_scan
    >>> axes = {axis: (axis, np.arange(4.0) * 20, {"units": "nm"}) for axis in "xy"}
    >>> scan = xr.Dataset({"height": (("x", "y"), np.ones((4, 4)), {"units": "nm"})}, axes)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     again = open_scan(to_netcdf(scan, folder + "/scan.nc")).load()
    >>> bool((again.height == scan.height).all())
    True
    """
    scan = validate(ds, "scan").drop_encoding()
    scan = scan.assign_attrs(Conventions="CF-1.11")
    encoding = as_characters(scan) | {
        name: {"chunksizes": tuple(min(_CHUNK, n) for n in scan[name].shape), "fletcher32": True}
        for name in ("x", "y", "height")
    }
    encoding["height"]["_FillValue"] = np.nan
    with whole(path) as temporary, uninterrupted():
        scan.to_netcdf(temporary, engine="netcdf4", format="NETCDF4", encoding=encoding)
    return Path(path)


def _surfacetopography(scan: xr.Dataset, path: str | os.PathLike) -> None:
    """Write ``heights`` along (x, y), y counted downwards from the picture's top, with ``length`` of x and y."""
    height = scan["height"].isel(y=slice(None, None, -1)).variable
    coords: dict[str, Any] = {}
    for axis, step in zip("xy", pixel(scan)):
        n = scan.sizes[axis]
        coords[axis] = (axis, np.arange(n) * step, {"unit": "nm", "length": n * step, "periodic": 0})
    out = xr.Dataset({"heights": (("x", "y"), height.data, {"unit": "nm"})}, coords)
    out.attrs["json"] = json.dumps({"raw_metadata": {k: str(v) for k, v in scan.attrs.items()}})
    encoding = {name: {"_FillValue": None} for name in ("x", "y", "heights")}
    with whole(path) as temporary:
        out.to_netcdf(temporary, engine="scipy", format="NETCDF3_64BIT", encoding=encoding)


def _gsf(ds: xr.Dataset, path: str | os.PathLike, name: str) -> None:
    """Write a map in SI units and 32-bit numbers, all that the format knows."""
    units = str(ds[name].attrs.get("units", "1"))
    times, si = _SI.get(units, (1.0, units))
    rows = ds[name].transpose("y", "x").values[::-1]
    dx, dy = pixel(ds)
    title = str(ds.attrs.get("channel", "Topography") if name == "height" else name).replace("=", " ")
    header = {
        "XReal": float(f"{dx * ds.sizes['x'] * 1e-9:.14g}"),  # not 1.2000000000000002e-07
        "YReal": float(f"{dy * ds.sizes['y'] * 1e-9:.14g}"),
        "XYUnits": "m",
        "ZUnits": si,
        "Title": title,
    }
    with whole(path) as temporary:
        optional("gsffile").write_gsf(temporary, (rows * times).astype(np.float32), header)


def _tiff(ds: xr.Dataset, path: str | os.PathLike, name: str) -> None:
    """Write a map in 64-bit numbers: GeoTIFF's tags ModelPixelScale and ModelTiepoint, and GDAL's for NaN."""
    dx, dy = pixel(ds)
    left, top = float(ds["x"].min()) - dx / 2, float(ds["y"].max()) + dy / 2
    words = {key: str(value) for key, value in ds[name].attrs.items()}
    about = {"variable": name, **words, "lateral units": "nm", "history": str(ds.attrs.get("history", ""))}
    tags = [
        (33550, "d", 3, (dx, dy, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, left, top, 0.0), True),
        (42113, "s", 4, "nan", True),
    ]
    with whole(path) as temporary:
        optional("tifffile").imwrite(
            temporary,
            np.ascontiguousarray(ds[name].transpose("y", "x").values[::-1], dtype=float),
            photometric="minisblack",
            description=json.dumps(about),
            resolution=(1e7 / dx, 1e7 / dy),
            resolutionunit="CENTIMETER",
            extratags=tags,
            metadata=None,
        )


#: Writers by the ending of a file.
_WRITERS = {".gsf": _gsf, ".tif": _tiff, ".tiff": _tiff}


def to_file(ds: xr.Dataset, path: str | os.PathLike, *, name: str | None = None) -> Path:
    """Write a scan, or another map along x and y, for other programs; the path's ending selects the format.

    Parameters
    ----------
    ds : Dataset
        A scan, or a Dataset with maps such as those of `pull_off_map`.
    path : str or path
        Ending in ``.gsf``, a Gwyddion Simple Field; ``.tif`` or ``.tiff``, a GeoTIFF with place and pixel size for GIS
        programs; or ``.nc``, the NetCDF-3 file of a scan that SurfaceTopography and contact.engineering open.
    name : str, optional
        The variable, for ``.gsf`` and ``.tif``; by default the height.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the ending is none of these, or there is no such map.
    ImportError
        If a package that the format needs is not installed.

    Notes
    -----
    Missing pixels stay NaN; the picture's top row comes first. ``.gsf`` holds 32-bit numbers (seven digits) in SI
    units: m, N, Pa, J/m². ``.tif`` holds 64-bit numbers in the variable's own units, its tags the pixel's size and the
    upper left corner in nm without a coordinate reference system, its description units and history as JSON. ``.nc``
    is no CF file, and Gwyddion does not open it.

    References
    ----------
    OGC 19-008r4, GeoTIFF 1.1, tags 33550 (ModelPixelScale) and 33922 (ModelTiepoint); GDAL's tag 42113 for NaN.

    Examples
    --------
    >>> import tempfile
    >>> from roughxr.scans.synthetic import self_affine
    >>> scan = self_affine((8, 4), 10, rms=1, hurst=0.8, rolloff=40, seed=1)
    >>> [to_file(scan, tempfile.mkdtemp() + "/scan" + ending).name for ending in (".gsf", ".nc")]
    ['scan.gsf', 'scan.nc']
    """
    ending = schema.one_of(Path(path).suffix.lower(), (*_WRITERS, ".nc"), "path's ending")
    if ending == ".nc":
        schema.refuse_unused("a path ending in '.nc'", name=name)
        _surfacetopography(validate(ds, "scan"), path)
    else:
        name = name or "height"
        _WRITERS[ending](validate(ds, "scan") if name == "height" else _map(schema.entered(ds), name), path, name)
    return Path(path)
