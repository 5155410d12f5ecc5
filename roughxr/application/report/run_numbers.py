"""The numbers of a run, a row each, which tables, pages and printed lines show.

A new number is a row of `numbers.csv`, with its words and units, and its value here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...mechanics import statistics
from ...mechanics.particles.force_balance import NEITHER, NO_CONTACT, NO_REST, strength_of_places, with_pull_off
from ...mechanics.particles.removal import removing_load, strength_quantile
from ...mechanics.scans.regions import sides
from ...mechanics.statistics import smooth_pull_off
from ...mechanics.statistics.means import scalar_values
from ...mechanics.statistics.sampling import (
    at_first_preload,
    deviation_of_places,
    has_debris_flags,
    mean_of_places,
    quantile_of_places,
)
from ...mechanics.vocabulary.numbers import format_number, prefixed
from ..figures.values import FORMULAS
from ..wording import names_in_words, table_of_words
from .summary import CRITICAL, DETACHMENT, best_method

Run = Mapping[str, xr.Dataset]

#: Methods of the pull-off, by the names of their groups, in words.
METHOD_WORDS = names_in_words("method")

#: Modes of detachment; the shares of all add up to 100 %.
_MODES = ("roll", "lift", NO_REST, NEITHER, NO_CONTACT)

#: Smallest number of contacts on which a sphere rests without rolling.
STABLE_CONTACTS = 3

#: Smallest number of places from which the 5 % and 95 % quantiles are given.
_FEWEST_OF_TAILS = 20


class Number(NamedTuple):
    """A number of a run: name and words, units, value with its 95 % interval, places, method, and a note."""

    name: str
    words: str
    units: str
    value: float
    low: float = np.nan
    high: float = np.nan
    place: str = ""
    source: str = ""
    note: str = ""

    @property
    def label(self) -> str:
        """The words with the units."""
        return f"{self.words} [{self.units}]" if self.units else self.words


#: Words and units of each number.
_MEANING = {name: (words, units) for name, words, units in table_of_words("numbers.csv")}


def _rows(part: str, values: Mapping[str, Any], size: tuple[str, float] = ("nN", 1.0), **common: Any) -> list[Number]:
    """Return values, each alone or with the ends of its interval, as rows; those in nN in a unit of given size."""
    rows = []
    for key, value in values.items():
        name = f"{part}.{key}"
        words, units = _MEANING[name]
        unit, divisor = size if units == "nN" else (units, 1.0)
        rows.append(Number(name, words, unit, *(np.ravel(value) / divisor).tolist(), **common))
    return rows


def _intervals(run: Run) -> Iterator[Number]:
    """Yield the statistics of the pull-off with their intervals, for all places and without debris."""
    pull_off = prediction(run)[["pull_off_force"]]
    flags = debris_flags(run)
    samples = {"all places": pull_off}
    if flags is not None and 0 < int(flags.sum()) < flags.size - 1 and flags.size == pull_off.sizes["subregion"]:
        samples["without debris"] = pull_off.isel(subregion=np.flatnonzero(~flags.values)).drop_vars("debris_share")
    for place, sample in samples.items():
        adhering = int(sample["pull_off_force"].notnull().sum())
        if adhering < 2:
            continue
        chosen = ["mean", "q5", "q50", "q95"] if adhering >= _FEWEST_OF_TAILS else ["mean", "q50"]
        ends = statistics.bootstrap(sample, "pull_off_force", statistics=chosen, within=pull_off)
        for name in chosen:
            at = ends.sel(statistic=name)
            count = format_number(at["independent_places"], digits=2)
            yield from _rows("interval", {name: (at["estimate"], at["low"], at["high"])}, place=place, note=count)


def _by_method(run: Run) -> Iterator[Number]:
    """Yield the pull-off by each method, in one unit."""
    groups = {method: run.get(f"statistics/{method}", xr.Dataset()) for method in METHOD_WORDS}
    groups = {method: ds for method, ds in groups.items() if "pull_off_delta" in ds}
    largest = max((float(ds["pull_off_force"].mean().fillna(0)) for ds in groups.values()), default=0.0)
    for method, ds in groups.items():
        force = ds["pull_off_force"]
        mean = mean_of_places(force)
        smooth = smooth_pull_off(run[f"solutions/{method}"])
        origin = ds.attrs.get("datum", "highest_peak")
        values = {
            "smooth": smooth,
            "mean": mean,
            "std": _spread(force),
            "largest": force.max(),
            "ratio": mean / smooth if smooth > 0 else np.nan,
            f"{origin}_mean": mean_of_places(ds["pull_off_delta"]),
            f"{origin}_std": _spread(ds["pull_off_delta"]),
            "adhering": force.notnull().sum(),
        }
        yield from _rows("method", values, prefixed(largest), source=method)


def _spread(values: xr.DataArray) -> float:
    """Return the standard deviation (n − 1) of the finite values, NaN for fewer than two."""
    if int(values.notnull().sum()) < 2:
        return np.nan
    return deviation_of_places(values)


def _forces(run: Run) -> Iterator[Number]:
    """Yield the force of the direct simulation at the middle and the last displacement."""
    force = run["solutions/direct"]["force"]
    deltas = force["delta"].values
    size = prefixed(float(force.isel(delta=-1).mean()))
    for delta in sorted({float(deltas[deltas.size // 2]), float(deltas[-1])}):
        at = force.sel(delta=delta, method="nearest")
        values = {"mean": at.mean(), "std": _spread(at), "largest": at.max()}
        if "solutions/smooth" in run:
            smooth = run["solutions/smooth"]["force"].sel(delta=delta, method="nearest").item()
            values["ratio"] = at.mean() / smooth if smooth else np.nan
        yield from _rows("force", values, size, place=format_number(delta, "nm"))


def _formulas(run: Run) -> Iterator[Number]:
    """Yield the pull-off by the usual formulas, and its ratio to the sum over the scan and to the simulation."""
    force = run["statistics/formulas"]["pull_off_force"]
    rigid = float(force.sel(formula="sum"))
    for formula, value in zip(force["formula"].values, force.values):
        values = {"force": value, "over_rigid": value / rigid}
        if "statistics/adhesive" in run:
            values["over_adhesive"] = value / float(run["statistics/adhesive"]["pull_off_force"].median())
        yield from _rows("formula", values, prefixed(rigid), place=FORMULAS[formula])


def _detachment(run: Run) -> Iterator[Number]:
    """Yield resisting moments and the critical flow, by method."""
    for method, group in CRITICAL.items():
        if group not in run:
            continue
        critical = run[group]
        moments = run_moments(run, method)
        median, low, high = critical_strength(critical)
        tails = quantile_of_places(strength_of_places(critical), [0.05, 0.95])
        shares = {mode: critical["mode"] == mode for mode in _MODES}
        shares |= {"in_range": critical["in_range"], "unstable": unstable(moments)}
        values = {
            "moment": quantile_of_places(moments["resisting_moment"], 0.5),
            "lever": quantile_of_places(moments["lever"], 0.5),
            "lever_error": _median_percent(moments, "lever_error"),
            "q5": tails[0],
            "q50": (median, low, high),
            "q95": tails[1],
            "error": _median_percent(critical, "critical_load_error"),
            "low": low,
            "high": high,
            **{name: round(100 * mean_of_places(flags.astype(float))) for name, flags in shares.items()},
        }
        yield from _rows("detachment", values, source=method)


def critical_strength(critical: xr.Dataset, share: float | None = None) -> tuple[float, float, float]:
    """Return the median of a critical load, or the load that removes a share, and the ends of its interval."""
    if share is None:
        return strength_quantile(critical)
    load = removing_load(critical, share)
    return float(load["removing_load"]), float(load["removing_load_low"]), float(load["removing_load_high"])


def run_moments(run: Run, method: str | None = None) -> xr.Dataset:
    """Return the run's resisting moments, with the pull-off forces of a method."""
    moments = run["solutions/rolling"]
    method = method or best_method(run)
    if method == "extrapolated":
        moments = moments.assign_attrs(surface="the real surface, with roughness finer than the scan")
        mean = run["statistics/extrapolated"][["pull_off_mean", "pull_off_high"]]
        return with_pull_off(moments, run["solutions/extrapolated"].assign(mean))
    return with_pull_off(moments, at_first_preload(run["statistics/adhesive"]))


def _median_percent(ds: xr.Dataset, name: str) -> float:
    if name not in ds or not bool(ds[name].notnull().any()):  # such as where the sphere rolls off by itself
        return np.nan
    return 100 * float(quantile_of_places(ds[name], 0.5))


def unstable(moments: xr.Dataset) -> xr.DataArray:
    """Return whether the sphere rests on too few contacts at a place."""
    return (moments["contacts"] < STABLE_CONTACTS) & moments["resisting_moment"].notnull().all("direction")


def _scan(run: Run) -> list[Number]:
    """Return the main numbers of scan and asperities."""
    height = run["scan"]["height"]
    catalogue = run["asperities"]
    ratio = catalogue["axis_ratio"]
    along_x, along_y = sides(run["scan"])
    values = {
        "size_x": 1e-3 * along_x,
        "size_y": 1e-3 * along_y,
        "least": height.min(),
        "greatest": height.max(),
        "mean": round(float(height.mean()), 6),
        "std": height.std(),
        "asperities": catalogue.sizes["asperity"],
        "peak": catalogue["height"].median(),
        "ratio_mean": ratio.mean(),
        "ratio_std": ratio.std(),
        "saddles": 100 * float(catalogue["saddle"].mean()),
    }
    return _rows("scan", values, source="scan")


#: The parts of `numbers.csv`, what makes them, and the groups of a run that they need.
_PARTS: dict[str, tuple[Callable[[Run], Iterable[Number]], set[str]]] = {
    "interval": (_intervals, {"statistics/adhesive"}),
    "detachment": (_detachment, set(DETACHMENT)),
    "method": (_by_method, {"statistics/rigid"}),
    "force": (_forces, {"solutions/direct"}),
    "formula": (_formulas, {"statistics/formulas"}),
    "scan": (_scan, {"scan", "asperities", "reconstruction"}),
}


def run_numbers(run: Run) -> dict[str, list[Number]]:
    """Return the numbers for which a run has the groups, by their part of `numbers.csv`."""
    return {part: list(make(run)) for part, (make, needs) in _PARTS.items() if needs <= set(run)}


def summary_numbers(summary: xr.Dataset) -> list[Number]:
    """Return the numbers of a run's summary that a page of several scans shows; notes are heads of intervals."""
    value = scalar_values(summary)
    return [
        Number(name, head, units, value[name], value.get(low, np.nan), value.get(high, np.nan), note=interval)
        for name, low, high, head, units, interval in table_of_words("sheet.csv")
    ]


def prediction(run: Run) -> xr.Dataset:
    """Return the pull-off by the simulation, else by superposed asperities."""
    return at_first_preload(run["statistics/adhesive" if "statistics/adhesive" in run else "statistics/energy"])


def debris_flags(run: Run) -> xr.DataArray | None:
    """Return whether each solved place is on debris, or None if the run cannot show it."""
    solved = (run[name] for name in ("solutions/adhesive", "solutions/direct") if name in run)
    places = next(filter(has_debris_flags, solved), None)
    return None if places is None else places["on_debris"].astype(bool)
