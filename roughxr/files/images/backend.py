"""`open_scan`, and the xarray backend ``xr.open_dataset(path, engine="roughxr")``."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import xarray as xr
from xarray.backends import BackendEntrypoint

from ...mechanics.vocabulary.units import Quantities
from .recognition import is_microscope_file, read_scan


class RoughxrBackend(BackendEntrypoint):
    """Opens AFM files as scans: ``height(x, y)`` in nm on pixel centres in nm.

    Examples
    --------
    >>> import tempfile
    >>> import roughxr
    >>> import xarray as xr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = roughxr.scans.to_file(roughxr.open_sample("glass"), folder + "/glass.gsf")
    ...     xr.open_dataset(path, engine="roughxr").height.units
    'nm'
    """

    description = "AFM images as scans in nm (Bruker, Asylum, Park, JPK, Gwyddion, text, NetCDF and others)"
    open_dataset_parameters = ("filename_or_obj", "drop_variables", "channel", "scan_direction", "size", "height_units")

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """Return whether a file is that of a microscope, so that ``xr.open_dataset`` needs no engine."""
        return is_microscope_file(filename_or_obj)

    def open_dataset(  # type: ignore[override]  # options of a reader's own, as xarray asks
        self,
        filename_or_obj: str | os.PathLike,
        *,
        drop_variables: str | Iterable[str] | None = None,
        channel: str | int | None = None,
        scan_direction: str | None = None,
        size: Any = None,
        height_units: str | None = None,
    ) -> xr.Dataset:
        """Return the scan in a file; the options are those of :func:`open_scan`."""
        ds = read_scan(
            filename_or_obj, channel=channel, scan_direction=scan_direction, size=size, height_units=height_units
        )
        dropped = [drop_variables] if isinstance(drop_variables, str) else list(drop_variables or ())
        out = ds.drop_vars(dropped, errors="ignore")
        out.set_close(ds.close)  # a new object from xarray does not keep the old one's close
        return out


def open_scan(
    path: str | os.PathLike,
    *,
    channel: str | int | None = None,
    scan_direction: str | None = None,
    size: Quantities | None = None,
    height_units: str | None = None,
    chunks: Any = None,
) -> xr.Dataset:
    """Open an AFM file as a scan.

    Parameters
    ----------
    path : str or path
        Any file that ``roughxr info --formats`` lists: of most microscopes, of Gwyddion, NetCDF, HDF5, text, ``.npy``.
        Some need the extra ``roughxr[afm]``. The content decides, not the extension.
    channel : str or int, optional
        Name (case and direction do not matter) or number of the image, in HDF5 the path of a matrix; by default the
        first image of heights, with a warning that lists other candidates, such as the frames of a movie.
    scan_direction : {"trace", "retrace"}, optional
        By default the forward image if there are both.
    size : length or pair of lengths, optional
        Along x and y, as nm or as text such as ``"5 um"``; for files that do not state it, and only those.
    height_units : str, optional
        For files that do not state them, and only those.
    chunks : int, dict, "auto", optional
        Open lazily with dask, as in :func:`xarray.open_dataset`. A NetCDF file is read chunk by chunk.

    Returns
    -------
    Dataset
        ``height`` (x, y) in nm, NaN where the file has no value; ``x``, ``y`` pixel centres in nm from the
        lower left corner, x to the right and y upwards as in the vendor's program.
        The attributes contain file name, SHA-256, channel, direction, all channels, and the header by lines.

    Raises
    ------
    UnreadableScan
        If the file is not a scan, is damaged or lacks statements that no option gives, or if its vendor's reader takes
        longer than a minute and a second per MB. It is a ValueError.
    OSError
        If the file is absent, a directory, or may not be read.
    ImportError
        If a package is missing; the message states how to install it.

    Warns
    -----
    ImplausibleScan
        If the file's statements are improbable, judged by the heights.

    Examples
    --------
    >>> import roughxr
    >>> import numpy as np, tempfile, os
    >>> path = os.path.join(tempfile.mkdtemp(), "ramp.npy")
    >>> np.save(path, [[1.0, 1.1, 2.5], [0.0, 0.2, 0.3]])  # rows from the top
    >>> scan = roughxr.open_scan(path, size=("150 nm", "100 nm"), height_units="nm")
    >>> scan.height.sel(x=125, y=75).item(), scan.x.values
    (2.5, array([ 25.,  75., 125.]))
    """
    options: dict[str, Any] = {
        "channel": channel,
        "scan_direction": scan_direction,
        "size": size,
        "height_units": height_units,
    }
    return xr.open_dataset(path, engine=RoughxrBackend, chunks=chunks, **options)
