"""The paper's conclusion, tested at each place: that contacts do not overlap at pull-off, and may thus be summed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from ...mechanics.contact.problem import first_touches
from ...mechanics.specimen import specimen_of
from ...mechanics.statistics.sampling import counted_equally, standard_deviation

Run = Mapping[str, xr.Dataset]

#: The simulation with adhesion, which the paper asks for, and the sums that are compared with it.
SIMULATION = "adhesive"
SUMS = ("published", "self_similar", "energy")

#: Rows of the comparison.
_ROWS = {
    "contacts": "contacts at pull-off, mean",
    "overlapping": "overlapping contacts [%]",
    "places_overlapping": "places with overlapping contacts [%]",
    "beyond_patch": "contacts larger than their patch [%]",
    "ratio_of_means": "sum / simulation, of the means",
    "added": "added by sums too large [% of mean]",
    "taken": "taken by sums too small [% of mean]",
    "median": "sum / simulation, median place",
    "low": "sum / simulation, 5 % of places below",
    "high": "sum / simulation, 95 % of places below",
    "rank_correlation": "rank correlation with the simulation",
    "scatter": "scatter of the places, std / mean",
}


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
    return _compared(run).rename(index=_ROWS)


def _compared(run: Run) -> pd.DataFrame:
    columns = {method: _overlap(run, method) for method in SUMS}
    if has_simulation(run):
        for method in SUMS:
            columns[method] |= _agreement(run, method)
        columns[SIMULATION] = {"scatter": _scatter(run, SIMULATION)}
    return pd.DataFrame(columns)


def _overlap(run: Run, method: str) -> dict[str, float]:
    """Return the contacts at pull-off, and the shares of those that a sum does not describe."""
    states = states_at_pull_off(run[f"solutions/{method}"])
    contacts = states["contacts"].sum()
    return {
        "contacts": float(states["contacts"].mean()),
        "overlapping": 100 * float(states["contacts_overlapping"].sum() / contacts),
        "places_overlapping": 100 * float((states["contacts_overlapping"] > 0).mean()),
        "beyond_patch": 100 * float(states["contacts_beyond_patch"].sum() / contacts),
    }


def _agreement(run: Run, method: str) -> dict[str, float]:
    """Return the agreement of a sum with the simulation in the mean, place by place, and in the scatter."""
    superposed, simulated = (run[f"statistics/{name}"]["pull_off_force"].values for name in (method, SIMULATION))
    ratio = pull_off_ratio(run, method)
    difference = (superposed - simulated) / np.nanmean(simulated)
    return {
        "ratio_of_means": float(np.nanmean(superposed) / np.nanmean(simulated)),
        "added": 100 * float(np.nanmean(difference.clip(min=0))),
        "taken": 100 * float(np.nanmean(-difference.clip(max=0))),
        "median": float(ratio.median()),
        "low": float(ratio.quantile(0.05)),
        "high": float(ratio.quantile(0.95)),
        "rank_correlation": rank_correlation(superposed, simulated),
        "scatter": _scatter(run, method),
    }


def rank_correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Return Spearman's rank correlation of two samples at the same places."""
    from scipy.stats import spearmanr

    return float(spearmanr(first, second, nan_policy="omit").statistic)


def _scatter(run: Run, method: str) -> float:
    """Return the standard deviation of the places' pull-offs over their mean."""
    force = counted_equally(run[f"statistics/{method}"]["pull_off_force"])
    return float(standard_deviation(force) / force.mean())


def conclusion_values(run: Run) -> dict[str, float]:
    """Return the numbers of the paper's conclusion: of its sum, and the scatter by each method."""
    table = _compared(run)
    scatter = {f"{method}_scatter": table.loc["scatter", method] for method in table} if has_simulation(run) else {}
    return dict(table["published"]) | scatter
