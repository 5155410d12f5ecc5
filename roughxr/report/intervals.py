"""The main numbers of a run with their intervals, for all places and for those without debris."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from .. import statistics
from ..statistics.headline import best_estimate
from ..vocabulary import schema
from ..vocabulary.numbers import number, prefixed

#: The main numbers of pull-off: words, variable, statistic.
_PULL_OFF = (
    ("pull-off force, mean", "pull_off_force", "mean"),
    ("pull-off force, median", "pull_off_force", "q50"),
    ("pull-off force, std", "pull_off_force", "std"),
    ("pull-off force, rough / smooth", "pull_off_ratio", "mean"),
    ("displacement at pull-off {datum}, mean", "pull_off_delta", "mean"),
)

PLACES = ("all places", "without debris")
_COLUMNS = ("estimate", "low", "high", "naive low", "naive high", "independent places")


def interval_table(run: Mapping[str, xr.Dataset], method: str | None = None) -> pd.DataFrame:
    """Return the main numbers with their 95 % intervals by block and by naive bootstrap."""
    rows = {}
    flags = flagged(run)
    pull = _pull_off(run, method or ("adhesive" if "statistics/adhesive" in run else "energy"))
    if known := best_estimate(run):
        count = float(run["solutions/extrapolated"].sizes["subregion"])  # its interval is no bootstrap's
        rows["pull-off force, mean, best estimate [nN]", PLACES[0]] = [*known, np.nan, np.nan, count]
    for words, name, what in _PULL_OFF:
        if pull is None or name not in pull:
            continue
        unit, size = _unit_of(pull, name)
        words = words.format(datum=counted_from(pull))
        rows |= _rows(f"{words} [{unit}]" if unit else words, pull, name, what, size, flags)
    if "solutions/direct" in run:
        direct = run["solutions/direct"]
        for delta in marked(direct):
            at = direct.sel(delta=delta, method="nearest")
            unit, size = _unit_of(direct, "force")
            rows |= _rows(
                f"elastic force at δ = {number(delta, 'nm')}, mean [{unit}]", at, "force", "mean", size, flags
            )
    table = pd.DataFrame.from_dict(rows, orient="index", columns=_COLUMNS)
    table.index = pd.MultiIndex.from_tuples(rows, names=["quantity", "places"])
    return table


def _pull_off(run: Mapping[str, xr.Dataset], method: str) -> xr.Dataset | None:
    """Return a run's pull-off, with its ratio to the smooth sphere's where the bodies adhere."""
    pull = run.get(f"statistics/{method}")
    if pull is None or (float(pull.coords.get("work_of_adhesion", 0.0)) <= 0 and not schema.is_wet(pull)):
        return pull
    return statistics.reduction(pull)


def counted_from(ds: xr.Dataset) -> str:
    """Return from where a result counts its displacements, in words."""
    return "from first touch" if ds.attrs.get("datum") == "first_contact" else "from the highest point"


def _unit_of(ds: xr.Dataset, name: str) -> tuple[str, float]:
    """Return the unit in which a variable is printed, and its size in the schema's units."""
    if name in ("force", "pull_off_force"):
        values = ds[name].values
        mean = np.nanmean(values.reshape(len(values), -1)[:, -1]) if np.isfinite(values).any() else 0.0
        return prefixed(float(mean))
    return ("" if ds[name].attrs.get("units", "1") == "1" else str(ds[name].attrs["units"])), 1.0


def flagged(run: Mapping[str, xr.Dataset]) -> xr.DataArray | None:
    """Return which of the places that were solved hold debris, None where the run does not say."""
    solved = (ds for name, ds in run.items() if name.startswith("solutions/") and "subregion_x" in ds.coords)
    places = next(solved, None)
    if places is None or places.sizes.get("subregion", 0) < 2 or "asperities" not in run:
        return None
    return statistics.debris(run["asperities"], places)


def marked(direct: xr.Dataset) -> list[float]:
    """Return the middle and the last displacement that were solved."""
    deltas = direct["delta"].values
    return sorted({float(deltas[deltas.size // 2]), float(deltas[-1])})


def _rows(words: str, ds: xr.Dataset, name: str, what: str, size: float, flags: xr.DataArray | None) -> dict:
    values = ds[name].values[np.isfinite(ds[name].values)]
    if values.size < 2:  # an estimate without an interval, or none: reported nevertheless
        alone = float(values[0]) / size if values.size and what != "std" else np.nan
        return {(words, PLACES[0]): [alone, *[np.nan] * 4, float(values.size)]}
    rows = {(words, PLACES[0]): _row(ds, name, what, size)}
    if flags is not None and 0 < int(flags.sum()) < flags.size - 1 and flags.size == ds.sizes["subregion"]:
        rows[words, PLACES[1]] = _row(ds.isel(subregion=np.flatnonzero(~flags.values)), name, what, size, within=ds)
    return rows


def _row(ds: xr.Dataset, name: str, what: str, size: float, within: xr.Dataset | None = None) -> list[float]:
    interval = statistics.bootstrap(ds, name, statistics=[what], within=within).isel(statistic=0)
    ends = [float(interval[end].sel(resampling=way)) / size for way in ("block", "naive") for end in ("low", "high")]
    return [float(interval["estimate"]) / size, *ends, float(interval["independent_places"].sel(resampling="block"))]
