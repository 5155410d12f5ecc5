"""From a file to measured pull-off forces: a table of places, or the image of adhesion that the microscope wrote."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from .. import schema
from ..scans import files
from ..scans.channel import Channel, UnreadableScan, along, listing, named
from ..statistics.sampling import of_a_map
from ..units import factor
from .forces import Calibration, converts, forces, magnitudes
from .tables import Column, force_column, place_columns, read_table
from .vendor_scales import in_true_units


def open_pull_off(
    path: str | os.PathLike,
    *,
    channel: str | int | None = None,
    direction: str | None = None,
    size: Any = None,
    units: str | None = None,
    place_units: str | None = None,
    sensitivity: Any = None,
    spring_constant: Any = None,
    pulls: str | None = None,
) -> xr.Dataset:
    """Open pull-off forces that were measured: a table of them, or an adhesion image of an AFM file.

    Parameters
    ----------
    path : str or path
        A text table (CSV and the like) with names above its columns, such as ``x [um], y [um], force [nN]``; or any AFM
        file that `open_scan` reads and that holds an image of adhesion. The content decides, not the extension.
    channel : str or int, optional
        Name of the column, or name or number of the image; by default the only one that can be meant.
    direction : {"trace", "retrace"}, optional
        Of an image; by default the forward one where there are both.
    size : length or pair of lengths, optional
        Of an image, where the file does not state it; a text file of bare numbers is an image where this is given.
    units : str, optional
        Of what was measured, where the file does not state them, and only there: those of a force, or V, or those of a
        deflection.
    place_units : str, optional
        Of the columns x and y, where the file does not state them.
    sensitivity : quantity, optional
        Of values in V: force per volt, "12 nN/V", or deflection per volt, "50 nm/V".
    spring_constant : number or quantity, optional
        Of values that are deflections, or of a sensitivity in nm/V: N/m.
    pulls : {"positive", "negative"}, optional
        Which sign a pull has in the file; needed where there are values of both.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN, a positive magnitude) along ``subregion``, NaN where nothing was measured; coordinates
        ``subregion_x``, ``subregion_y`` (nm) where places are known, those of an image from its lower left corner as of
        a scan of the same file. The attribute ``measured`` is "table" or "adhesion image"; others keep file name,
        SHA-256, channel, and by what the values became forces.

    Raises
    ------
    UnreadableScan
        If the file holds no such thing, is damaged, or several columns or images can be meant. It is a ValueError, as
        where units, a sensitivity or a spring constant are missing: none of them is ever guessed.
    OSError
        If the file is absent, a directory, or may not be read.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "curves.csv"
    >>> _ = path.write_text("x [um],y [um],adhesion [nN]\\n0,0,12.5\\n1,0,\\n0,1,9.5\\n")
    >>> found = open_pull_off(path)
    >>> found.pull_off_force.values, found.subregion_x.values, found.measured
    (array([12.5,  nan,  9.5]), array([   0., 1000.,    0.]), 'table')
    """
    path = files.regular_file(path)
    family, read = files.reader_of(path)
    if family == "netcdf":
        raise UnreadableScan(path, "expected a table or an AFM file, found NetCDF; open it with xarray.open_dataset")
    given = Calibration(units, sensitivity, spring_constant, pulls)
    tabular = family == "text" and size is None and not _is_matrix(path)
    if tabular:
        ds = _of_table(path, channel, place_units, given)
    else:
        found = files.guarded(path, read, path)
        chosen = in_true_units(path, found, _adhesion(found, channel, direction, path), family)
        ds = _of_image(path, chosen, size, given)
        ds.attrs.update(channels=listing(found))
    if ds["pull_off_force"].isnull().all():
        raise UnreadableScan(path, "expected pull-off forces, found missing values only")
    ds.attrs.update(
        source_file=path.name, source_sha256=files.file_hash(path), missing="NaN where nothing was measured"
    )
    said = {"channel": channel, "direction": direction, "size": size, "units": units, "place_units": place_units}
    said |= {"sensitivity": sensitivity, "spring_constant": spring_constant, "pulls": pulls}
    return schema.record(schema.label(ds), "open_pull_off", file=path.name, **said)


def _is_matrix(path: Path) -> bool:
    """Return whether a text states the size of an image, as Gwyddion writes it above the numbers."""
    with path.open("rb") as file:
        head = file.read(2000).decode("utf-8", "replace")
    comments = [line for line in head.splitlines() if line.lstrip().startswith("#")]
    return any("Width:" in line for line in comments) and any("Height:" in line for line in comments)


def _of_table(path: Path, channel: Any, place_units: str | None, given: Calibration) -> xr.Dataset:
    columns = files.guarded(path, read_table, path)
    column = force_column(path, columns, channel)
    values, how = _as_pulls(path, column.values, column.units, given)
    ds = xr.Dataset({"pull_off_force": ("subregion", values)}, {"subregion": np.arange(values.size)})
    for axis, one in place_columns(columns).items():
        ds.coords[f"subregion_{axis}"] = ("subregion", lengths(path, one, place_units))
    return ds.assign_attrs(measured="table", channel=column.name, **how)


def lengths(path: Path, column: Column, place_units: str | None) -> np.ndarray:
    """Return a column of lengths in nm, in the units that the file or else the caller states."""
    units = column.units or place_units
    if units is None or not converts(units, "nm"):
        found = repr(units) if units else "none"
        raise UnreadableScan(
            path, f"expected units of a length for {column.name!r}, found {found}; state place_units=, such as 'um'"
        )
    if not np.isfinite(column.values).all():
        raise UnreadableScan(path, f"expected a place in every row, found empty cells in column {column.name!r}")
    return column.values * factor(units, "nm")


def _as_pulls(path: Path, values: np.ndarray, units: str | None, given: Calibration):
    try:
        found, how = forces(values, units, given)
        turned, pulls = magnitudes(found, given.pulls)
    except ValueError as error:
        raise UnreadableScan(path, str(error)) from error
    return turned, {**how, "pulls": pulls}


def _adhesion(channels: list[Channel], channel: Any, direction: str | None, path: Path) -> Channel:
    """Return the image asked for, or the one of adhesion."""
    schema.one_of(direction, (None, "trace", "retrace"), "direction")
    if channel is None:
        found = [one for one in channels if "adhes" in one.name.lower()]
        found = found or [one for one in channels if converts(one.units, "nN")]
        found = found or [one for one in channels if len(channels) == 1 and one.units is None]
    else:
        found = named(channels, channel)
    found = along(found, direction)
    if len(found) != 1:
        wanted = "an image of adhesion" if channel is None else f"channel {channel!r}"
        raise UnreadableScan(
            path, f"expected {wanted}, found {len(found)} among {listing(channels)}; name one or its number, channel="
        )
    return found[0]


def _of_image(path: Path, channel: Channel, size: Any, given: Calibration) -> xr.Dataset:
    """Return an image's pixels as places: the picture's top row at the largest y, as in a scan."""
    channel = files.sized(channel, size, path)
    rows = np.asarray(files.guarded(path, channel.read), dtype=float)
    if rows.shape != channel.shape:
        raise UnreadableScan(path, f"expected {channel.shape} pixels (rows, columns), found {rows.shape}")
    if np.isinf(rows).any():
        raise UnreadableScan(path, "expected finite values, found infinite ones: damaged")
    values, how = _as_pulls(path, rows[::-1].T, channel.units, given)
    axes = {axis: (np.arange(n) + 0.5) * (length / n) for axis, n, length in zip("xy", values.shape, channel.size)}
    ds = of_a_map(xr.Dataset({"pull_off_force": (("x", "y"), np.ascontiguousarray(values))}, axes))
    ds = ds.assign_coords(subregion=np.arange(values.size))
    return ds.assign_attrs(
        measured="adhesion image", channel=channel.name, direction=channel.direction or "not stated", **how
    )
