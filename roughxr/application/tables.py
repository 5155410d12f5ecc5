"""Results as tidy tables."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from ..files.doors import MARK, refuse_source
from ..files.storage import atomic_write
from ..mechanics.vocabulary import schema
from ..mechanics.vocabulary.refusal import Refusal
from ..mechanics.vocabulary.text import printable

#: Characters with which a cell begins that a spreadsheet reads as a formula.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")

#: Formats of a tidy table, by the file's suffix.
FORMATS = (".csv", ".xlsx")


def to_table(ds: xr.Dataset | xr.DataArray, path: str | os.PathLike | None = None) -> Any:
    """Return a result as a tidy table, or write it: a row for each entry, a column for each variable and coordinate.

    Parameters
    ----------
    ds : Dataset or DataArray
        For example asperities, a solution without fields, a pull-off, a summary, intervals, or a map, which has one row
        for each pixel. Computed if lazy. Scalars, such as a roughness, are one row each: value, units and meaning.
    path : path, optional
        Ending in ``.csv`` or ``.xlsx`` (needs openpyxl). Units are in brackets after the names, and text that a
        spreadsheet would take for a formula begins with an apostrophe.

    Returns
    -------
    DataFrame, or Path where one is given

    Raises
    ------
    ValueError
        If ``ds`` contains fields of many places, which do not fit a table; or if the path is that of the file from
        which ``ds`` was read, or of an existing file that is no table of these columns.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import pandas as pd
    >>> import xarray as xr
    >>> import roughxr
    >>> ds = xr.Dataset({"force": (("subregion", "delta"), [[0.0, 1.0]])}, coords={"delta": [1.0, 2.0]})
    >>> pd.read_csv(roughxr.to_table(roughxr.schema.label(ds), Path(tempfile.mkdtemp()) / "force.csv")).columns.tolist()
    ['subregion', 'delta [nm]', 'force [nN]']
    >>> roughxr.to_table(roughxr.roughness(roughxr.open_sample("glass"))).loc["s_q", ["units", "meaning"]].tolist()
    ['nm', 'root mean square height S_q']
    """
    return table_of(ds, path)


def table_of(ds: xr.Dataset | xr.DataArray, path: str | os.PathLike | None, *, is_own: bool = False) -> Any:
    """Return or write a table as `to_table` does; a file of a run's folder, which ``is_own``, is replaced."""
    if isinstance(ds, xr.DataArray):
        ds = ds.to_dataset(name=ds.name or "value")
    ds = schema.entered_dataset(ds)
    write = None if path is None else table_writer(Path(path))
    fields = [str(name) for name in ds.data_vars if {"x", "y"} < set(ds[name].dims)]
    if fields:
        raise Refusal(
            "",
            "variables that fit a table",
            f"fields of several places: {', '.join(fields)}",
            "select one place and displacement, or drop them",
        )
    frame = ds.to_dataframe() if ds.dims else _scalars(ds)
    if path is None or write is None:
        return frame
    if not is_own:
        refuse_source(Path(path), ds.attrs)
    with atomic_write(path, is_own=is_own) as temporary:
        write(_headed(frame.reset_index(), ds), temporary)
    return Path(path)


def _scalars(ds: xr.Dataset) -> pd.DataFrame:
    """Return the variables of a Dataset without dimensions as rows: value, units and meaning."""
    rows = [
        (array.values.item(), array.attrs.get("units", "1"), array.attrs.get("long_name", ""))
        for array in ds.data_vars.values()
    ]
    return pd.DataFrame(
        rows, index=pd.Index(list(ds.data_vars), name="quantity"), columns=["value", "units", "meaning"]
    )


def written_formats() -> tuple[str, ...]:
    """Return the formats for which the packages are installed."""
    return FORMATS if find_spec("openpyxl") else FORMATS[:1]


def table_writer(path: Path) -> Callable[[pd.DataFrame, Path], None]:
    """Return the function that writes a table to a path; raise where its format is none of `FORMATS`."""
    suffix = schema.one_of(path.suffix, FORMATS, f"{path}'s ending")
    if suffix == ".csv":
        return lambda frame, path: frame.to_csv(path, index=False, lineterminator="\n")
    if suffix not in written_formats():
        raise ImportError("a table in .xlsx needs openpyxl, which is not installed: pip install openpyxl")
    return _write_workbook


def _write_workbook(frame: pd.DataFrame, path: Path) -> None:
    with pd.ExcelWriter(path, engine="openpyxl") as writer:
        frame.to_excel(writer, index=False)
        writer.book.properties.creator = MARK  # type: ignore[attr-defined]


def _headed(frame: pd.DataFrame, ds: xr.Dataset) -> pd.DataFrame:
    """Return a table with units in its header, and no text that a spreadsheet refuses or takes for a formula."""
    units = {name: ds[name].attrs.get("units", "1") if name in ds.variables else "1" for name in frame}
    named = frame.rename(columns={name: f"{name} [{unit}]" for name, unit in units.items() if unit != "1"})
    for column in named.select_dtypes(include=["object", "string"]):
        named[column] = named[column].map(_safe_cell)
    return named


def _safe_cell(value: object) -> object:
    if not isinstance(value, str):
        return value
    return "'" * value.startswith(_FORMULA) + printable(value, keep="\n\t")
