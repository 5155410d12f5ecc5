"""Force-distance curves as they were recorded, from microscopes' files or from text tables with one row per sample."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..scans import files
from ..scans.channel import UnreadableScan
from ..vocabulary import schema
from ..vocabulary.units import Quantity
from .curve_files import curve_kind, curves_of, opened
from .forces import Calibration, converts, forces
from .tables import Column, lengths, place_columns, read_table


def open_curves(
    path: str | os.PathLike,
    *,
    units: str | None = None,
    piezo_units: str | None = None,
    sensitivity: Quantity | None = None,
    spring_constant: Quantity | None = None,
) -> xr.Dataset:
    """Open force-distance curves, for `curves_pull_off`.

    Parameters
    ----------
    path : str or path
        A microscope's file of one curve or of a map of them, in a format that afmformats knows (extra ``curves``: JPK,
        Asylum, AFM Workshop, text of NT-MDT and Chiaro, afmformats' own); the content decides, not the extension.
        Or a table of retractions: columns ``piezo`` and ``force`` or ``deflection``, with their units in brackets, one
        row for each sample, the most pressed one first; ``piezo`` grows towards the surface. Where there are several
        curves, a column ``curve`` numbers them; columns ``x`` and ``y`` say where each was taken.
    units, piezo_units : str, optional
        Units of a table's force or deflection and of its piezo, only where the table does not state them.
    sensitivity, spring_constant : quantity, optional
        As for `open_pull_off`, only where the file does not state them. Three bare columns of numbers are taken as
        NT-MDT's curves if the sensitivity is in nm/nA.

    Returns
    -------
    Dataset
        ``piezo`` (nm) and ``force`` (nN) along (subregion, sample), or for a microscope's file along (subregion,
        branch, sample), NaN after the end of shorter curves; the places; spring constant (N/m) and sensitivity as
        attributes.

    Raises
    ------
    UnreadableScan
        If columns, units or calibration are missing, or a curve of a table moves from place to place. See `open_scan`
        for the others.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "curves.csv"
    >>> _ = path.write_text("curve,piezo [um],force [nN]\\n1,0.01,5\\n1,0,-2\\n2,0.01,4\\n")
    >>> open_curves(path).piezo.values
    array([[10.,  0.],
           [10., nan]])
    """
    path = files.regular_file(path)
    family, _ = files.reader_of(path)
    given = Calibration(units, sensitivity, spring_constant)
    kind = files.guarded(path, curve_kind, path, family, given)
    if kind is None:
        ds = _of_table(path, piezo_units, given)
    elif piezo_units is not None:
        raise UnreadableScan(path, f"piezo_units: the file states them, found {piezo_units!r}; leave piezo_units= out")
    else:
        ds = curves_of(opened(path, kind, given))
    ds.attrs.update(source_file=path.name, source_sha256=files.file_hash(path))
    options: dict[str, Any] = {"units": units, "piezo_units": piezo_units}
    options |= {"sensitivity": sensitivity, "spring_constant": spring_constant}
    return schema.record(schema.label(ds), "open_curves", file=path.name, **options)


def _of_table(path: Path, piezo_units: str | None, given: Calibration) -> xr.Dataset:
    columns = {column.name.lower(): column for column in files.guarded(path, read_table, path)}
    force, how = _forces(path, columns, given)
    own = _curves(path, columns, force.size)
    recorded = {"piezo": lengths(path, columns["piezo"], piezo_units), "force": force}
    made = {name: (("subregion", "sample"), _padded(values, own)) for name, values in recorded.items()}
    return xr.Dataset(made, {"subregion": np.arange(len(own)), **_places(path, columns, own)}, how)


def _forces(path: Path, columns: dict[str, Column], given: Calibration) -> tuple[np.ndarray, dict[str, Any]]:
    """Return the forces of all samples, nN, and attributes that say how they were converted."""
    signal = [name for name in ("force", "deflection") if name in columns]
    if "piezo" not in columns or len(signal) != 1:
        names = ", ".join(map(repr, columns)) or "none"
        raise UnreadableScan(path, f"expected columns 'piezo' and either 'force' or 'deflection', found {names}")
    column = columns[signal[0]]
    stated = column.units or given.units
    if signal[0] == "deflection" and converts(stated, "nN"):
        raise UnreadableScan(path, f"expected units of a length or V for 'deflection', found {stated!r}")
    try:
        return forces(column.values, column.units, given)
    except ValueError as error:
        raise UnreadableScan(path, str(error)) from error


def _curves(path: Path, columns: dict[str, Column], size: int) -> list[np.ndarray]:
    """Return the rows of each curve."""
    number = columns["curve"].values if "curve" in columns else np.zeros(size)
    if np.isnan(number).any():
        raise UnreadableScan(path, "expected a number in every row of column 'curve', found empty cells")
    return [np.flatnonzero(number == label) for label in dict.fromkeys(number.tolist())]


def _places(path: Path, columns: dict[str, Column], own: list[np.ndarray]) -> dict[str, Any]:
    """Return the place of each curve; empty if unknown."""
    places = {}
    for axis, column in place_columns(path, list(columns.values())).items():
        values = lengths(path, column, None)
        if any(np.ptp(values[rows]) > 0 for rows in own):
            raise UnreadableScan(path, f"expected one place for each curve, found {column.name!r} to change within one")
        places[f"subregion_{axis}"] = ("subregion", [values[rows[0]] for rows in own])
    return places


def _padded(values: np.ndarray, own: list[np.ndarray]) -> np.ndarray:
    """Return the curves as rows of one array, NaN after their ends."""
    out = np.full((len(own), max(map(len, own))), np.nan)
    for row, members in zip(out, own):
        row[: members.size] = values[members]
    return out
