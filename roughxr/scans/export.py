"""Write a scan for other programs, and as roughxr's own NetCDF-4.

Every file is written beside its place and then moved there, so that no half of one is ever found.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..files.disk import as_characters, uninterrupted, whole
from ..vocabulary import schema
from ..vocabulary.schema import pixel, validate
from ..vocabulary.verbs import verb
from .channel import optional

#: Chunks of a native file: a 512 x 512 block of heights is 2 MiB.
_CHUNK = 512


#: Factor and name of the SI unit of each unit that maps have here.
_SI = {"nm": (1e-9, "m"), "nN": (1e-9, "N"), "GPa": (1e9, "Pa"), "nm2": (1e-18, "m^2"), "J m-2": (1.0, "J/m^2")}
_SI["1"] = (1.0, "")


def _map(ds: xr.Dataset, name: str) -> xr.Dataset:
    """Return a Dataset that holds a map; raise for any other."""
    maps = [str(one) for one in ds.data_vars if set(ds[one].dims) == {"x", "y"}]
    if name not in maps:
        found = tuple(ds[name].dims) if name in ds else "no such variable"
        raise ValueError(
            f"name: expected a map along x and y ({', '.join(maps) or 'none here'}), found {name!r}: {found}"
        )
    return ds


def to_netcdf(ds: xr.Dataset, path: str | os.PathLike) -> Path:
    """Write a scan as roughxr's own NetCDF-4: everything it holds, in chunks, each with a checksum.

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


@verb
def to_surfacetopography(ds: xr.Dataset, path: str | os.PathLike) -> Path:
    """Write a scan as the NetCDF-3 file that SurfaceTopography and contact.engineering open.

    Parameters
    ----------
    ds : Dataset
        A scan.
    path : str or path

    Returns
    -------
    Path

    Notes
    -----
    Variable ``heights`` as (x, y), y counted downwards from the top of the picture; ``length`` of x and y; one
    ``unit`` for all; missing pixels NaN. This is not a CF file, and Gwyddion does not open it.

    Examples
    --------
    >>> import tempfile
    >>> from roughxr.scans.synthetic import self_affine
    >>> scan = self_affine((8, 4), 10, rms=1, hurst=0.8, rolloff=40, seed=1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = xr.load_dataset(to_surfacetopography(scan, folder + "/scan.nc"), engine="scipy")
    >>> written.heights.shape, float(written.x.attrs["length"]), written.x.attrs["unit"]
    ((8, 4), 80.0, 'nm')
    """
    scan = validate(ds, "scan")
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
    return Path(path)


@verb
def to_gsf(ds: xr.Dataset, path: str | os.PathLike, *, name: str = "height") -> Path:
    """Write a scan, or another map along x and y, as a Gwyddion Simple Field, which Gwyddion and many others open.

    Parameters
    ----------
    ds : Dataset
        A scan, or a Dataset with maps such as those of `pull_off_map`.
    path : str or path
        With the extension ``.gsf``.
    name : str
        The variable.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If ``name`` is no map along x and y, or the path does not end in ``.gsf``.
    ImportError
        If the package ``gsffile`` is not installed.

    Notes
    -----
    The format holds 32-bit numbers: heights keep seven digits. Missing pixels stay NaN. Values are written in SI
    units: m, N, Pa, J/m².

    Examples
    --------
    >>> import tempfile, numpy as np, xarray as xr
    >>> axes = {axis: (axis, np.arange(4.0) * 20, {"units": "nm"}) for axis in "xy"}
    >>> pull = xr.Dataset({"pull_off_force": (("x", "y"), np.ones((4, 4)), {"units": "nN"})}, axes)
    >>> to_gsf(pull, tempfile.mkdtemp() + "/pull.gsf", name="pull_off_force").name
    'pull.gsf'
    """
    scan = validate(ds, "scan") if name == "height" else _map(ds, name)
    units = str(scan[name].attrs.get("units", "1"))
    times, si = _SI.get(units, (1.0, units))
    if Path(path).suffix != ".gsf":
        raise ValueError(f"path: expected a name ending in .gsf, found {Path(path).name!r}")
    rows = scan[name].transpose("y", "x").values[::-1]
    dx, dy = pixel(scan)
    title = str(scan.attrs.get("channel", "Topography") if name == "height" else name).replace("=", " ")
    header = {
        "XReal": float(f"{dx * scan.sizes['x'] * 1e-9:.14g}"),  # not 1.2000000000000002e-07
        "YReal": float(f"{dy * scan.sizes['y'] * 1e-9:.14g}"),
        "XYUnits": "m",
        "ZUnits": si,
        "Title": title,
    }
    with whole(path) as temporary:
        optional("gsffile").write_gsf(temporary, (rows * times).astype(np.float32), header)
    return Path(path)


@verb
def to_tiff(ds: xr.Dataset, path: str | os.PathLike, *, name: str = "height") -> Path:
    """Write a scan, or another map along x and y, as a GeoTIFF, with its place and pixel size, for GIS programs.

    Parameters
    ----------
    ds : Dataset
        A scan, or a Dataset with maps such as those of `pull_off_map`.
    path : str or path
        With the extension ``.tif`` or ``.tiff``.
    name : str
        The variable.

    Returns
    -------
    Path

    Notes
    -----
    64-bit numbers in the variable's own units, the picture's top row first, missing pixels NaN. The tags of GeoTIFF
    tell the pixel's size and the upper left corner, in nm without a system of reference; the resolution in pixels per
    cm and the description, JSON, tell units and history. Needs tifffile, which comes with the extra ``roughxr[afm]``.

    Raises
    ------
    ValueError
        If there is no map of this name, or the path has another extension.
    ImportError
        If tifffile is not installed.

    References
    ----------
    OGC 19-008r4, GeoTIFF 1.1, tags 33550 (ModelPixelScale) and 33922 (ModelTiepoint); GDAL's tag 42113 for NaN.

    Examples
    --------
    >>> import tempfile, numpy as np, tifffile, xarray as xr
    >>> axes = {axis: (axis, np.arange(4.0) * 20 + 10, {"units": "nm"}) for axis in "xy"}
    >>> pull = xr.Dataset({"pull_off_force": (("x", "y"), np.ones((4, 4)), {"units": "nN"})}, axes)
    >>> path = to_tiff(pull, tempfile.mkdtemp() + "/pull.tif", name="pull_off_force")
    >>> page = tifffile.TiffFile(path).pages[0]
    >>> page.tags[33550].value, page.tags[33922].value
    ((20.0, 20.0, 0.0), (0.0, 0.0, 0.0, 0.0, 80.0, 0.0))
    """
    scan = validate(ds, "scan") if name == "height" else _map(ds, name)
    if Path(path).suffix not in (".tif", ".tiff"):
        raise ValueError(f"path: expected a name ending in .tif or .tiff, found {Path(path).name!r}")
    dx, dy = pixel(scan)
    left, top = float(scan["x"].min()) - dx / 2, float(scan["y"].max()) + dy / 2
    words = {key: str(value) for key, value in scan[name].attrs.items()}
    about = {"variable": name, **words, "lateral units": "nm", "history": str(scan.attrs.get("history", ""))}
    tags = [
        (33550, "d", 3, (dx, dy, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, left, top, 0.0), True),
        (42113, "s", 4, "nan", True),
    ]
    with whole(path) as temporary:
        optional("tifffile").imwrite(
            temporary,
            np.ascontiguousarray(scan[name].transpose("y", "x").values[::-1], dtype=float),
            photometric="minisblack",
            description=json.dumps(about),
            resolution=(1e7 / dx, 1e7 / dy),
            resolutionunit="CENTIMETER",
            extratags=tags,
            metadata=None,
        )
    return Path(path)


#: Writers by the ending of a file.
_WRITERS = {".gsf": to_gsf, ".tif": to_tiff, ".tiff": to_tiff}


@verb
def to_file(ds: xr.Dataset, path: str | os.PathLike, *, name: str | None = None) -> Path:
    """Write a scan, or another map along x and y, for other programs; the path's ending says in which format.

    Parameters
    ----------
    ds : Dataset
        A scan, or a Dataset with maps such as those of `pull_off_map`.
    path : str or path
        Ending in ``.gsf``, a Gwyddion Simple Field; ``.tif``, a GeoTIFF with place and pixel size for GIS programs; or
        ``.nc``, the NetCDF-3 file of a scan that SurfaceTopography and contact.engineering open.
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
        return to_surfacetopography(ds, path)
    return _WRITERS[ending](ds, path, name=name or "height")
