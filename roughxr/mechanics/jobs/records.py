"""Results of solvers: one record for each contact centre, and the labelled Dataset of all records.

A solver fills one record of a structured dtype: states along the steps of the solve, events (one value for the whole
cycle), and fields on the window around the centre. All records form one array, computed or lazy, whose parts become
variables.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.text import IncompleteResult, warn

#: The two branches of a cycle.
BRANCHES = ("loading", "retraction")

#: Fields on the window around a centre, along all axes, where requested.
FIELDS = ("pressure", "displacement", "gap")


class Layout(NamedTuple):
    """The parts of a record, and the axes of each."""

    axes: Mapping[str, Any]  # dimension of the states -> its coordinate
    states: Mapping[str, type]
    events: Mapping[str, type] = {}
    window: tuple[int, int] | None = None  # cells of the full window, where fields are kept
    yields: bool = False  # whether the field residual_height is kept as well, along all axes but the branch

    @property
    def dtype(self) -> np.dtype:
        """The structured dtype of a record."""
        parts: list[tuple] = [(name, kind, self.along(name)) for name, kind in self.states.items()]
        parts += self.events.items()
        parts += [(name, float, (*self.along(name), *(self.window or ()))) for name in self.fields]
        return np.dtype(parts)

    @property
    def fields(self) -> tuple[str, ...]:
        """The fields that are kept."""
        return (*FIELDS, *(("residual_height",) if self.yields else ())) if self.window else ()

    def along(self, name: str) -> tuple[int, ...]:
        """Return the lengths of the axes of a part."""
        return tuple(len(self.axes[axis]) for axis in self._axes_of(name))

    def _axes_of(self, name: str) -> tuple[str, ...]:
        if name in self.events:
            return ()
        return tuple(axis for axis in self.axes if name != "residual_height" or axis != "branch")

    def blank(self) -> np.ndarray:
        """Return a record in which every number is missing, every count 0 and every flag False."""
        record = np.zeros((), self.dtype)
        for name in record.dtype.fields or ():
            if record.dtype[name].base.kind == "f":
                record[name] = np.nan
        return record

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the dimensions of a part after ``subregion``."""
        return (*self._axes_of(name), *(("x", "y") if name in self.fields else ()))


def labelled(records: Any, layout: Layout, ds: xr.Dataset, positions: xr.Dataset) -> xr.Dataset:
    """Return the Dataset of an array of records (subregion,), computed or lazy."""
    parts = {name: (("subregion", *layout.dims(name)), records[name]) for name in layout.dtype.fields or ()}
    return schema.label(xr.Dataset(parts, {**layout.axes, **positions.coords, **schema.pair_coordinates(ds)}))


def converged(ds: xr.Dataset) -> xr.DataArray | bool:
    """Return where the solves of a solution met their tolerance; True if it does not record this."""
    return ds["converged"].astype(bool) if "converged" in ds else True


def warn_unconverged(out: xr.Dataset, remedy: str) -> None:
    """Warn once about computed solves that did not meet their tolerance, with the remedy."""
    lost = int((~out["converged"].astype(bool)).sum())
    if lost:
        warn(
            f"{out.attrs['method']}: {lost} of {out['converged'].size} solutions have not converged; {remedy}",
            IncompleteResult,
        )


def loading(ds: xr.Dataset) -> xr.Dataset:
    """Return the loading branch of a solution that has both branches, else the solution itself."""
    return ds.sel(branch=BRANCHES[0], drop=True) if "branch" in ds.dims else ds
