"""`open_curves`: recorded force-distance curves, from microscopes' files or from text tables."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.units import Quantity, converts
from ..images import recognition as files
from ..images.channel import UnreadableScan, naming_file, refuse_stated
from .curve_files import curve_kind, open_curve_file, read_curves
from .force_tables import is_spreadsheet, lengths, read_table
from .forces import Calibration, forces
from .segments import approach_and_retraction


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
        A microscope's file of a curve or of a map of curves, in a format that afmformats knows (extra ``curves``: JPK,
        Asylum, AFM Workshop, text of NT-MDT and Chiaro, afmformats' own); the content decides, not the extension. Of
        a curve in two Asylum waves, ``…Defl.ibw`` and ``…ZSnsr.ibw`` in one folder, either.
        Or a table of one curve: columns ``piezo`` and ``force`` or ``deflection``, with their units in brackets, one
        row for each sample; ``piezo`` grows towards the surface. Approach and holds are left out.
    units, piezo_units : str, optional
        Units of a table's force or deflection and of its piezo, only if the table does not state them.
    sensitivity, spring_constant : quantity, optional
        As for `open_pull_off`, only if the file does not state them. Three columns of numbers without names are taken
        as NT-MDT's curves if the sensitivity is in nm/nA.

    Returns
    -------
    Dataset
        ``piezo`` (nm) and ``force`` (nN) along ``sample``, or for a microscope's file along (subregion, branch,
        sample), NaN after the end of shorter curves; the places; spring constant (N/m) and sensitivity as attributes.

    Raises
    ------
    UnreadableScan
        If columns, units or calibration are missing. See `open_scan` for other reasons.

    Examples
    --------
    >>> from pathlib import Path
    >>> import roughxr
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "curve.csv"
    >>> _ = path.write_text("piezo [um],force [nN]\\n0.01,5\\n0,-2\\n")
    >>> roughxr.measured.open_curves(path).piezo.values
    array([10.,  0.])
    """
    path = files.regular_file(path)
    family, _ = files.reader_of(path)
    calibration = Calibration(units, sensitivity, spring_constant)
    kind = files.call_naming_file(path, curve_kind, path, family, calibration)
    with naming_file(path):
        if kind is None and family != "text" and not is_spreadsheet(path):
            other_kind = "an image or another file"
            raise UnreadableScan(path, "force-distance curves", other_kind, "heights are opened by roughxr.open_scan")
        if kind is None:
            ds = read_curve_table(path, piezo_units, calibration)
        elif piezo_units is not None:
            refuse_stated(path, "piezo_units", piezo_units)
        else:
            ds = read_curves(open_curve_file(path, kind, calibration))
    ds.attrs.update(source_file=path.name, source_sha256=files.file_hash(path))
    options: dict[str, Any] = {"units": units, "piezo_units": piezo_units}
    options |= {"sensitivity": sensitivity, "spring_constant": spring_constant}
    return schema.record(schema.label(ds), "open_curves", file=path.name, **options)


def read_curve_table(path: Path, piezo_units: str | None, calibration: Calibration) -> xr.Dataset:
    """Return the curve in a table."""
    columns = {column.name.lower(): column for column in files.call_naming_file(path, read_table, path)}
    signal = [name for name in ("force", "deflection") if name in columns]
    if "piezo" not in columns or len(signal) != 1:
        names = ", ".join(map(repr, columns)) or "none"
        raise UnreadableScan(path, "columns 'piezo' and either 'force' or 'deflection'", names)
    column = columns[signal[0]]
    stated = column.units or calibration.units
    if signal[0] == "deflection" and converts(stated, "nN"):
        raise UnreadableScan(path, "units of a length or V for 'deflection'", repr(stated))
    force, how = forces(column.values, column.units, calibration)
    piezo = lengths(path, columns["piezo"], "piezo_units", piezo_units)
    _, retraction = approach_and_retraction(piezo)
    retraction = np.arange(piezo.size) if retraction is None else retraction
    return xr.Dataset({"piezo": ("sample", piezo[retraction]), "force": ("sample", force[retraction])}, attrs=how)
