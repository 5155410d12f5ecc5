"""The main numbers of a run beside the paper's, with its values at one place, in one group, or along a curve."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from .. import report
from ..statistics import debris, force_ratio
from ..vocabulary.verbs import verb
from .printed import CONTACT, SCAN

Run = Mapping[str, xr.Dataset]

_MICRO = 1e-3  # µN per nN

#: Displacements (nm) at which the paper shows distributions of forces, and at which both methods agree in it.
_DISTRIBUTION_DELTAS, _AGREEMENT_DELTAS = (5.08, 15.4), (9.0, 10.0, 12.0)


#: Displacements (nm) whose forces the paper prints, alone or over those on smooth ground.
_PRINTED = (5.08, 10.0, 15.4, 20.0)


@verb
def scan_table(run: Run) -> pd.DataFrame:
    """Return the main numbers of scan and asperities beside the printed ones."""
    return _beside(report.scan_table(run), SCAN)


@verb
def contact_table(run: Run) -> pd.DataFrame:
    """Return the contact's main numbers by method beside the printed ones."""
    table = report.contact_table(run, deltas=_PRINTED)
    more = {method: _of_direct(run) if method == "direct" else _of_figure_15(run, method) for method in table}
    return _beside(pd.concat([table, pd.DataFrame(more)]).rename_axis("quantity"), CONTACT)


def _beside(table: pd.DataFrame, printed: Mapping[str, tuple[float, str]]) -> pd.DataFrame:
    """Return a table with the printed values in its first column, and how to read them in the second."""
    paper = pd.DataFrame.from_dict(printed, orient="index", columns=["paper", "paper's is"], dtype=object)
    paper = paper.reindex(table.index).astype({"paper": float}).fillna({"paper's is": ""})
    return paper.join(table)


def _of_figure_15(run: Run, method: str) -> dict[str, float]:
    """Return values at the place of figure 15: of those without debris, the one with the largest published pull-off."""
    clean = run["statistics/published"]["pull_off_force"].where(~_debris(run, "solutions/published"))
    place = {"subregion": int(clean.fillna(0).argmax("subregion"))}
    rows = {
        "pull-off, place of figure 15 [µN]": _MICRO * float(run[f"statistics/{method}"]["pull_off_force"].isel(place))
    }
    if "force" not in run[f"solutions/{method}"] or run[f"solutions/{method}"].sizes["delta"] < 2:
        return rows  # with a preload, and for rigid bodies, there are only events
    force = run[f"solutions/{method}"]["force"].isel(place)
    pulling = force["delta"].values[force.values < 0]
    return rows | {
        "that place pulls from [nm]": float(pulling.min(initial=np.inf)),
        "that place pulls to [nm]": float(pulling.max(initial=-np.inf)),
    }


def _of_direct(run: Run) -> dict[str, float]:
    direct, superposed = run["solutions/direct"], run["solutions/hertz"]
    rows = {
        f"force at {delta:g} nm, second group [µN]": _MICRO * second_group(_at(direct["force"], delta).values)
        for delta in _DISTRIBUTION_DELTAS
    }
    clean = np.flatnonzero(~_debris(run, "solutions/direct"))
    ratio = force_ratio(superposed.isel(subregion=clean), direct.isel(subregion=clean))
    rows |= {
        f"superposed / direct at {delta:g} nm, no debris": 1 + float(_at(ratio["mean_difference"], delta))
        for delta in _AGREEMENT_DELTAS
    }
    agree = (abs(ratio["force_difference"]) <= 0.1).any("delta")
    return rows | {"places without debris that agree to 10 % somewhere": float(agree.sum())}


def _at(values: xr.DataArray, delta: float) -> xr.DataArray:
    return values.sel(delta=delta, method="nearest")


def _debris(run: Run, solution: str) -> np.ndarray:
    return debris(run["asperities"], run[solution]).values


def second_group(values: np.ndarray) -> float:
    """Return the mean of the values above the widest gap between consecutive ones.

    Examples
    --------
    >>> float(second_group(np.array([0.0, 1.0, 2.0, 9.0, 10.0])))
    9.5
    """
    values = np.sort(values)
    return float(values[np.argmax(np.diff(values)) + 1 :].mean()) if values.size > 1 else np.nan
