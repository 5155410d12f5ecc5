"""Results for other programs: adhesion forces for resuspension models, and tidy tables."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from .. import statistics
from .._version import __version__
from ..files.disk import whole
from ..vocabulary import schema
from ..vocabulary.verbs import verb

#: A spreadsheet takes cells that begin with one of these for a formula.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")

#: Formats of a tidy table, by the file's suffix.
FORMATS = (".csv", ".parquet")


@verb
def to_resuspension(ds: xr.Dataset, path: str | os.PathLike) -> Path:
    """Write pull-off forces as the table of adhesion that resuspension models need.

    Rock'n'Roll and similar models can use this distribution of the adhesion force between particle and surface,
    normalised by that of a perfectly smooth contact (Reeks & Hall 2001), in place of a fitted log-normal law.

    Parameters
    ----------
    ds : Dataset
        A pull-off with its pair, for example from `rolling`.
    path : path
        A CSV file; comment lines at its top begin with ``#`` and hold sphere, material and origin.

    Returns
    -------
    Path
        Columns ``force_nN`` (ascending), ``cdf`` (share of the places that detach at or below it) and
        ``force_over_smooth`` (over the force of the same sphere on a smooth flat, 3/2 π w R). From `rolling` also
        ``lever_over_radius``, in the weakest direction, to use in place of the 1/100 of those models. Places where
        nothing pulls are left out; a comment gives their number.

    Raises
    ------
    ValueError
        If ``ds`` is no pull-off with an adhesive pair, or fewer than two places pull.

    References
    ----------
    Reeks & Hall, J. Aerosol Sci. 32 (2001) 1.

    Examples
    --------
    >>> import tempfile
    >>> forces = {"pull_off_force": ("subregion", [2.0, 1.0]), "pull_off_delta": ("subregion", [0.0, 0.0])}
    >>> pair = {"sphere_radius": 100.0, "contact_modulus": 40.0, "work_of_adhesion": 0.1}
    >>> path = to_resuspension(xr.Dataset(forces, coords=pair), Path(tempfile.mkdtemp()) / "adhesion.csv")
    >>> pd.read_csv(path, comment="#").round(4).values.tolist()
    [[1.0, 0.5, 0.0212], [2.0, 1.0, 0.0424]]
    """
    ds = statistics.reduction(ds)
    smooth = statistics.smooth_pull_off(ds)
    steps = statistics.cdf(ds, "pull_off_force")
    force = steps["pull_off_force"].values
    table = pd.DataFrame({"force_nN": force, "cdf": steps.values, "force_over_smooth": force / smooth})
    if "lever" in ds:
        table["lever_over_radius"] = _levers(ds, force) / float(ds["sphere_radius"])
    head = [
        f"adhesion forces, roughxr {__version__}",
        f"smooth sphere's pull-off force: {smooth:.6g} nN",
        *(f"{schema.axis_label(name)}: {float(ds[name]):.6g}" for name in schema.TRAVELLING if name in ds.coords),
        f"places: {steps.attrs['samples']}; where nothing pulls: {steps.attrs['missing']}",
        f"history: {json.dumps([step.get('operation') for step in schema.history(ds)])}",
    ]
    text = "".join(f"# {line}\n" for line in head) + table.to_csv(index=False, float_format="%.8g", lineterminator="\n")
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return Path(path)


def _levers(ds: xr.Dataset, force: np.ndarray) -> np.ndarray:
    """Return the lever (nm) of the weakest direction at the places of these pull-off forces, ascending."""
    pull, lever = ds["pull_off_force"].values, ds["lever"].min("direction").values
    known = np.isfinite(pull)
    return pd.Series(lever[known]).groupby(pull[known]).mean().loc[force].to_numpy()


@verb
def to_table(ds: xr.Dataset, path: str | os.PathLike) -> Path:
    """Write a result as a tidy table: one row for each entry, one column for each variable and coordinate.

    Parameters
    ----------
    ds : Dataset
        For example asperities, a solution without fields, a pull-off, a summary, intervals, or a map, which has one row
        for each pixel. Computed if lazy.
    path : path
        Ending in ``.csv`` or ``.parquet``. Parquet keeps types, and units and history of each column in its
        metadata; it needs pyarrow. In CSV the units are in brackets after the names, and text that a
        spreadsheet would take for a formula begins with an apostrophe. A Dataset of scalars is written as `table`
        returns it.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the suffix is neither, or ``ds`` holds fields of many places, which do not fit a table.
    ImportError
        If Parquet is wanted and pyarrow is not installed.

    Examples
    --------
    >>> import tempfile
    >>> ds = xr.Dataset({"force": (("subregion", "delta"), [[0.0, 1.0]])}, coords={"delta": [1.0, 2.0]})
    >>> pd.read_csv(to_table(schema.label(ds), Path(tempfile.mkdtemp()) / "force.csv")).columns.tolist()
    ['subregion', 'delta [nm]', 'force [nN]']
    """
    path = Path(path)
    write = _writer(path.suffix)
    fields = [name for name in ds.data_vars if {"x", "y"} < set(ds[name].dims)]
    if fields:
        raise ValueError(
            f"expected a table's variables or maps of x and y, found fields along more: {', '.join(fields)}; "
            "select one place and displacement, or drop them"
        )
    frame = (ds.to_dataframe() if ds.dims else table(ds)).reset_index()
    with whole(path) as temporary:
        write(frame, ds, temporary)
    return path


@verb
def table(ds: xr.Dataset) -> pd.DataFrame:
    """Return the scalars of a Dataset, such as a roughness, as a table for reading: value, units and meaning.

    Parameters
    ----------
    ds : Dataset
        Variables along dimensions are left out.

    Returns
    -------
    DataFrame
        One row for each scalar variable, by its name.

    Raises
    ------
    ValueError
        If no variable is a scalar.

    Examples
    --------
    >>> import roughxr
    >>> table(roughxr.roughness(roughxr.open_sample("glass"))).loc["s_q", ["units", "meaning"]].tolist()
    ['nm', 'root mean square height S_q']
    """
    scalars = {str(name): array for name, array in ds.data_vars.items() if array.ndim == 0}
    if not scalars:
        raise ValueError(f"expected scalar variables, found all of them along {', '.join(map(str, ds.dims))}")
    rows = [
        (array.values.item(), array.attrs.get("units", "1"), array.attrs.get("long_name", ""))
        for array in scalars.values()
    ]
    return pd.DataFrame(rows, index=pd.Index(scalars, name="quantity"), columns=["value", "units", "meaning"])


def _writer(suffix: str) -> Callable[[pd.DataFrame, xr.Dataset, str], None]:
    schema.one_of(suffix, FORMATS, "path's ending")
    if suffix == ".csv":
        return _csv
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        raise ImportError('Parquet needs pyarrow; install it with: pip install "roughxr[parquet]"') from error
    return _parquet


def _csv(frame: pd.DataFrame, ds: xr.Dataset, path: str):
    units = {name: ds[name].attrs.get("units", "1") if name in ds.variables else "1" for name in frame}
    named = frame.rename(columns={name: f"{name} [{unit}]" for name, unit in units.items() if unit != "1"})
    for column in named.select_dtypes(include=["object", "string"]):
        named[column] = named[column].map(_no_formula)
    named.to_csv(path, index=False, lineterminator="\n")


def _no_formula(value: object) -> object:
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value


def _parquet(frame: pd.DataFrame, ds: xr.Dataset, path: str):
    frame.attrs = {
        "units": {str(name): str(ds[name].attrs.get("units", "1")) for name in ds.variables},
        "history": schema.history(ds),
    }
    frame.to_parquet(path, engine="pyarrow", index=False)
