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

from ..disk import as_characters, uninterrupted, whole
from ..schema import pixel, validate
from .channel import optional

#: Chunks of a native file: a 512 x 512 block of heights is 2 MiB.
_CHUNK = 512


def to_netcdf(ds: xr.Dataset, path: str | os.PathLike) -> Path:
    """Write a scan as roughxr's own NetCDF-4: everything it holds, in chunks, each with a checksum.

    Parameters
    ----------
    ds : Dataset
        A scan; a lazy one is written chunk by chunk.
    path : str or path

    Returns
    -------
    Path

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


def to_gsf(ds: xr.Dataset, path: str | os.PathLike) -> Path:
    """Write a scan as a Gwyddion Simple Field, which Gwyddion and many others open.

    Parameters
    ----------
    ds : Dataset
        A scan.
    path : str or path
        With the extension ``.gsf``.

    Returns
    -------
    Path

    Notes
    -----
    The format holds 32-bit numbers: heights keep seven digits. Missing pixels stay NaN.
    """
    scan = validate(ds, "scan")
    if Path(path).suffix != ".gsf":
        raise ValueError(f"path: expected a name ending in .gsf, found {Path(path).name!r}")
    rows = scan["height"].transpose("y", "x").values[::-1]
    dx, dy = pixel(scan)
    title = str(scan.attrs.get("channel", "Topography")).replace("=", " ")
    header = {
        "XReal": float(f"{dx * scan.sizes['x'] * 1e-9:.14g}"),  # not 1.2000000000000002e-07
        "YReal": float(f"{dy * scan.sizes['y'] * 1e-9:.14g}"),
        "XYUnits": "m",
        "ZUnits": "m",
        "Title": title,
    }
    with whole(path) as temporary:
        optional("gsffile").write_gsf(temporary, (rows * 1e-9).astype(np.float32), header)
    return Path(path)
