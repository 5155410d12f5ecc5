"""The error budget as a table, and sentences on humidity and resolution."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd
import xarray as xr

from ..bodies import liquid
from ..statistics.sampling import at_first_preload
from ..vocabulary import schema
from ..vocabulary.numbers import percent, quantity
from .summary import BUDGET

Run = Mapping[str, xr.Dataset]

#: The pull between rigid bodies over humidity.
HUMIDITY = "statistics/humidity"


def humid_words(run: Run) -> str:
    """Return sentences on the pull-off at the run's humidity and at others; nothing for a dry pair."""
    if "scan" not in run or not schema.is_wet(run["scan"]) or HUMIDITY not in run:
        return ""
    scan, over = run["scan"], run[HUMIDITY]
    own = run.get("statistics/adhesive", over.sel(humidity=float(scan["humidity"]), method="nearest"))
    mean = quantity(float(at_first_preload(own)["pull_off_force"].mean()))
    ends = over["pull_off_force"].isel(humidity=[0, -1]).mean("subregion")
    said = [
        f"Mean pull-off at {percent(scan['humidity'])} relative humidity: {mean}.",
        "Between rigid bodies it would be "
        + " and ".join(f"{quantity(float(end))} at {percent(end['humidity'])}" for end in ends)
        + ".",
        f"The thin-meniscus law neglects {percent(over['meniscus_error'].median())} of the pull-off (median place).",
    ]
    return " ".join([*said, liquid.described(scan)])


def budget_table(run: Run) -> pd.DataFrame:
    """Return the error budget in per cent of the mean pull-off: each error, how well it is known, and its source.

    Parameters
    ----------
    run : mapping of str to Dataset
        With the group ``statistics/error_budget``.

    Returns
    -------
    DataFrame
        One row for each entry, with its error, how well that is known (one standard error), and the change of the mean
        with its sign; the total comes before those that are not part of it, and its change is what all known biases
        amount to.

    Raises
    ------
    KeyError
        If the run holds no error budget.

    Examples
    --------
    >>> entries = {"relative_error": ("entry", [0.03, 0.04, 0.1]), "how": ("entry", ["known", "solved again", "added"])}
    >>> names = {"entry": ["work of adhesion", "mesh and step", "shorter waves"]}
    >>> entries |= {"standard_error": ("entry", [0.01] * 3), "pull_off_change": ("entry", [-0.03, 0.08, -0.1])}
    >>> total = {"total_error": 0.05, "total_standard_error": 0.01, "pull_off_mean": 10.0, "pull_off_corrected": 10.8}
    >>> budget_table({BUDGET: xr.Dataset(entries | total, names)})["error [%]"].to_dict()
    {'work of adhesion': 3.0, 'mesh and step': 4.0, 'all of these': 5.0, 'shorter waves*': 10.0}
    """
    budget = run[BUDGET]
    numbers = (list(map(_percent, budget[name])) for name in ("relative_error", "standard_error", "pull_off_change"))
    rows = {str(name): row for name, *row in zip(budget["entry"].values, *numbers, budget["how"].values)}
    apart = rows.pop("shorter waves", None)
    error, own = (_percent(budget[name]) for name in ("total_error", "total_standard_error"))
    shift = _percent(budget["pull_off_corrected"] / budget["pull_off_mean"] - 1)
    words = f"root of the sum of squares of what was computed. {budget.attrs.get('decided', '')}".strip()
    rows["all of these"] = [error, own, shift, words]
    if apart is not None:
        rows["shorter waves*"] = [*apart[:3], f"not in the total: {apart[3]}"]
    table = pd.DataFrame.from_dict(
        rows, orient="index", columns=["error [%]", "± [%]", "change [%]", "how it was computed"]
    )
    table.index.name = "entry"
    return table


def _percent(part: Any) -> float:
    """Return a part in per cent, to three digits: it is known to no more."""
    return float(f"{100 * float(part):.3g}")


def resolution(run: Run) -> list[str]:
    """Return sentences on how well pixels and tip resolve the contacts, none if there is no doubt."""
    if BUDGET not in run:
        return []
    budget, said = run[BUDGET], []
    if float(budget["contact_radius_pixels"]) < 2:
        said.append(str(budget.attrs["resolved"]))
    sharp, tip = float(budget["sharper_than_tip"]), float(budget["tip_radius"])
    if sharp >= 0.05:
        said.append(
            f"{percent(sharp)} of the asperities are too sharp for a tip of {tip:g} nm radius to image them truly: if "
            "the tip of the scan was as blunt, the surface is rougher than the scan and sticks less."
        )
    return said
