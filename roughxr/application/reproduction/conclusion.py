"""The paper's conclusion, tested at each place: that contacts do not overlap at pull-off, and may thus be summed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from ...mechanics.contact.problem import first_touches
from ...mechanics.specimen import specimen_of
from ...mechanics.statistics.sampling import counted_equally, standard_deviation
from ...mechanics.vocabulary.numbers import format_number

Run = Mapping[str, xr.Dataset]

#: The simulation with adhesion, which the paper asks for, and the sums that are compared with it.
SIMULATION = "adhesive"
SUMS = ("published", "self_similar", "energy")

#: Rows of the table that the sentences below it take up.
_OVERLAPPING = "overlapping contacts [%]"
_PLACES_OVERLAPPING = "places with overlapping contacts [%]"
_MEANS = "sum / simulation, of the means"
_ADDED = "added by sums too large [% of mean]"
_TAKEN = "taken by sums too small [% of mean]"
_MEDIAN = "sum / simulation, median place"
_END = "sum / simulation, {} % of places below"
_RANKS = "rank correlation with the simulation"
_SCATTER = "scatter of the places, std / mean"

#: Ends (%) of the range that contains nine of ten places.
_ENDS = (5, 95)


def has_simulation(run: Run) -> bool:
    """Whether a run has reached the simulation with adhesion."""
    return f"statistics/{SIMULATION}" in run


def states_at_pull_off(solution: xr.Dataset) -> xr.Dataset:
    """Return the numbers of contacts at each place's pull-off, at the nearest displacement of the sweep."""
    pull_off_delta = solution["pull_off_delta"]
    nearest = abs(solution["delta"] - pull_off_delta.fillna(0)).argmin("delta")
    counts = solution[["contacts", "contacts_overlapping", "contacts_beyond_patch"]]
    return counts.isel(delta=nearest).where(pull_off_delta.notnull())


def pull_off_ratio(run: Run, method: str) -> xr.DataArray:
    """Return the superposed pull-off over that of the simulation at each place."""
    superposed, simulated = (run[f"statistics/{name}"]["pull_off_force"] for name in (method, SIMULATION))
    return superposed / simulated.where(simulated > 0).values


def delta_from_highest_point(run: Run, method: str) -> xr.DataArray:
    """Return the displacement at pull-off from the highest point of the scan, nm."""
    pull_off = run[f"statistics/{method}"]
    if pull_off.attrs.get("datum") != "first_contact":
        return pull_off["pull_off_delta"]
    cells = int(pull_off["mesh"].max())
    return pull_off["pull_off_delta"] + first_touches(specimen_of(run["scan"]), pull_off, cells)


def comparison_table(run: Run) -> pd.DataFrame:
    """Return the overlap of contacts at pull-off and, after the simulation, each sum compared with it by place."""
    columns = {method: _overlap_rows(run, method) for method in SUMS}
    if has_simulation(run):
        for method in SUMS:
            columns[method] |= _agreement_rows(run, method)
        columns[SIMULATION] = {_SCATTER: _scatter(run, SIMULATION)}
    return pd.DataFrame(columns)


def _overlap_rows(run: Run, method: str) -> dict[str, float]:
    """Return the contacts at pull-off, and the shares of those that a sum does not describe."""
    states = states_at_pull_off(run[f"solutions/{method}"])
    contacts = states["contacts"].sum()
    return {
        "contacts at pull-off, mean": float(states["contacts"].mean()),
        _OVERLAPPING: 100 * float(states["contacts_overlapping"].sum() / contacts),
        _PLACES_OVERLAPPING: 100 * float((states["contacts_overlapping"] > 0).mean()),
        "contacts larger than their patch [%]": 100 * float(states["contacts_beyond_patch"].sum() / contacts),
    }


def _agreement_rows(run: Run, method: str) -> dict[str, float]:
    """Return the agreement of a sum with the simulation in the mean, place by place, and in the scatter."""
    superposed, simulated = (run[f"statistics/{name}"]["pull_off_force"].values for name in (method, SIMULATION))
    ratio = pull_off_ratio(run, method)
    difference = (superposed - simulated) / np.nanmean(simulated)
    ends = {_END.format(end): float(ratio.quantile(end / 100)) for end in _ENDS}
    return {
        _MEANS: float(np.nanmean(superposed) / np.nanmean(simulated)),
        _ADDED: 100 * float(np.nanmean(difference.clip(min=0))),
        _TAKEN: 100 * float(np.nanmean(-difference.clip(max=0))),
        _MEDIAN: float(ratio.median()),
        **ends,
        _RANKS: float(rank_correlation(superposed, simulated)),
        _SCATTER: _scatter(run, method),
    }


def rank_correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Return Spearman's rank correlation of two samples at the same places."""
    from scipy.stats import spearmanr

    return float(spearmanr(first, second, nan_policy="omit").statistic)


def _scatter(run: Run, method: str) -> float:
    """Return the standard deviation of the places' pull-offs over their mean."""
    force = counted_equally(run[f"statistics/{method}"]["pull_off_force"])
    return float(standard_deviation(force) / force.mean())


def conclusion(run: Run) -> str:
    """Return the paper's conclusion, what its sum gives and what it does not, in sentences."""
    table = comparison_table(run)
    published = table["published"]
    overlap = (
        "The paper concludes that contacts do not overlap at pull-off. With its formulas "
        f"{_percent(published, _OVERLAPPING)} of them do, at {_percent(published, _PLACES_OVERLAPPING)} of the places."
    )
    if not has_simulation(run):
        return overlap
    low, high = (format_number(published[_END.format(end)], digits=2) for end in _ENDS)
    gives = (
        f"Its method gives the mean of many places, {format_number(published[_MEANS], digits=2)} times the "
        f"simulation's, by cancellation: sums that are too large add {_percent(published, _ADDED)} to the mean, sums "
        f"that are too small take {_percent(published, _TAKEN)} from it."
    )
    gives_not = (
        f"It does not give the pull-off of one place: {format_number(published[_MEDIAN], digits=2)} times the "
        f"simulation's at the median place, {low} … {high} at nine of ten, with a rank correlation of "
        f"{format_number(published[_RANKS], digits=2)}."
    )
    scatter = [format_number(table.loc[_SCATTER, method], digits=2) for method in ("published", "energy", SIMULATION)]
    width = (
        f"Nor does it give the width of the distribution: the standard deviation is {scatter[0]} of the mean as "
        f"published and {scatter[1]} corrected, for {scatter[2]} in the simulation."
    )
    return f"{overlap} {gives} {gives_not} {width}"


def _percent(rows: pd.Series, name: str) -> str:
    return f"{rows[name]:.0f} %"
