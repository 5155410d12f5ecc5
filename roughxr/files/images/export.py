"""Write a scan as NetCDF-4, or for other programs."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import xarray as xr

from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.schema import pixel, validate
from ..doors import refuse_source
from ..storage import as_characters, atomic_write, check_name, refuse_unstorable, uninterrupted
from .channel import optional

#: Factor and name of the SI unit of each unit of a map.
_SI = {"nm": (1e-9, "m"), "nN": (1e-9, "N"), "GPa": (1e9, "Pa"), "nm^2": (1e-18, "m^2"), "J/m^2": (1.0, "J/m^2")}
_SI["1"] = (1.0, "")


def to_netcdf(ds: xr.Dataset, path: str | os.PathLike) -> Path:
    """Write a scan with all its variables and attributes as NetCDF-4, in chunks with checksums.

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
    >>> import roughxr
    >>> import tempfile, roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     again = roughxr.open_scan(roughxr.scans.to_netcdf(scan, folder + "/scan.nc")).load()
    >>> bool((again.height == scan.height).all())
    True
    """
    scan = validate(ds, "scan").drop_encoding()
    scan = scan.assign_attrs(Conventions="CF-1.11")
    # side of a chunk, pixels: a 512 x 512 block of heights is 2 MiB
    encoding = as_characters(scan) | {
        name: {"chunksizes": tuple(min(512, n) for n in scan[name].shape), "fletcher32": True}
        for name in ("x", "y", "height")
    }
    encoding["height"]["_FillValue"] = np.nan
    check_name(path)
    refuse_unstorable(scan, "scan")
    refuse_source(Path(path), scan.attrs)
    with atomic_write(path) as temporary, uninterrupted():
        scan.to_netcdf(temporary, engine="netcdf4", format="NETCDF4", encoding=encoding)
    return Path(path)


def _gsf(ds: xr.Dataset, path: str | os.PathLike, name: str) -> None:
    """Write a map as a Gwyddion Simple Field, in SI units and 32-bit numbers."""
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
    refuse_source(Path(path), ds.attrs)
    with atomic_write(path) as temporary:
        optional("gsffile").write_gsf(temporary, (rows * times).astype(np.float32), header)


def to_file(ds: xr.Dataset, path: str | os.PathLike, *, name: str = "height") -> Path:
    """Write a scan, or another map along x and y, as a Gwyddion Simple Field for other programs.

    Parameters
    ----------
    ds : Dataset
        A scan, or a Dataset with maps such as those of `pull_off_map`.
    path : str or path
        Ending in ``.gsf``.
    name : str
        The variable.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ImportError
        If gsffile is not installed.

    Notes
    -----
    Missing pixels stay NaN; the picture's top row comes first. Numbers have 32 bits (seven digits) and SI units: m, N,
    Pa, J/m².

    Examples
    --------
    >>> import roughxr
    >>> import tempfile
    >>> from roughxr.scans import synthetic
    >>> scan = synthetic.self_affine((8, 4), 10, rms=1, hurst=0.8, rolloff=40, seed=1)
    >>> roughxr.scans.to_file(scan, tempfile.mkdtemp() + "/scan.gsf").name
    'scan.gsf'
    """
    schema.one_of(Path(path).suffix.lower(), (".gsf",), "path's ending")
    ds = validate(ds, "scan") if name == "height" else schema.in_package_units(ds)
    maps = [str(variable) for variable in ds.data_vars if set(ds[variable].dims) == {"x", "y"}]
    _gsf(ds, path, schema.one_of(name, tuple(maps), "name"))
    return Path(path)
