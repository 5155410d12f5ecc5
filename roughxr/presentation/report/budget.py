"""The headline of a report with the conditions that it holds for, and the error budget as a table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from ...statistics import bootstrap, smooth_pull_off
from ...vocabulary.numbers import percent, prefixed
from ...vocabulary.verbs import verb

Run = Mapping[str, xr.Dataset]

BUDGET, WAVES = "statistics/error_budget", "statistics/shorter_waves"


@verb
def headline(run: Run) -> str:
    """Return the mean pull-off with its interval, and for which surface it holds.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run.

    Returns
    -------
    str
        Empty where the run holds no error budget.

    Examples
    --------
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [40.0])})
    >>> budget = xr.Dataset(attrs={"condition": "for a surface that is smooth below 20 nm"})
    >>> headline({"statistics/adhesive": pull, BUDGET: budget})
    'Pull-off force: 40 nN in the mean of 1 place, for a surface that is smooth below 20 nm.'
    """
    if BUDGET not in run or "statistics/adhesive" not in run:
        return ""
    pull, budget = run["statistics/adhesive"], run[BUDGET]
    pull = pull.isel(preload=0) if "preload" in pull.dims else pull
    mean, count = float(pull["pull_off_force"].mean()), int(pull["pull_off_force"].notnull().sum())
    if not count:
        return "No place pulls."
    unit, size = prefixed(mean)
    smooth = smooth_pull_off(pull) if "sphere_radius" in pull.coords else np.nan
    part = f", {percent(mean / smooth)} of what the sphere holds on a smooth flat" if smooth > 0 else ""
    return (
        f"Pull-off force: {mean / size:.3g} {unit} in the mean of {count} place{'s' * (count > 1)}"
        f"{_interval(pull, unit, size)}{part}, {budget.attrs['condition']}.{_beyond(run, unit, size)}"
    )


def _interval(pull: xr.Dataset, unit: str, size: float) -> str:
    if int(pull["pull_off_force"].notnull().sum()) < 2:
        return ""
    found = bootstrap(pull, "pull_off_force", statistics=["mean"]).isel(statistic=0).sel(resampling="block")
    return f" (95 % interval {float(found['low']) / size:.3g} … {float(found['high']) / size:.3g} {unit})"


def _beyond(run: Run, unit: str, size: float) -> str:
    """Return a sentence on the pull-off if the roughness continued below the wavelengths that the scan shows."""
    if WAVES not in run:
        return ""
    scales = run[WAVES]
    means = scales["pull_off_force"].mean(["subregion", "seed"])
    least, shown = means.isel(shortest_kept=0), scales.attrs["shortest_wavelength"]
    ratio = float(least / means.sel(shortest_kept=shown, method="nearest"))
    return (
        f" If its roughness went on down to {float(least['shortest_kept']):.3g} nm, as the scan's own spectrum does, "
        f"the pull-off would be {percent(ratio)} of that (at {scales.sizes['subregion']} of the places)."
    )


@verb
def budget_table(run: Run) -> pd.DataFrame:
    """Return the error budget: error of the mean pull-off in per cent, and how it was computed.

    Parameters
    ----------
    run : mapping of str to Dataset
        With the group ``statistics/error_budget``.

    Returns
    -------
    DataFrame
        One row for each entry; the total comes before those that are not part of it.

    Raises
    ------
    KeyError
        If the run holds no error budget.

    Examples
    --------
    >>> entries = {"relative_error": ("entry", [0.03, 0.04, 0.1]), "how": ("entry", ["known", "solved again", "added"])}
    >>> names = {"entry": ["work of adhesion", "mesh and step", "shorter waves"]}
    >>> budget_table({BUDGET: xr.Dataset(entries | {"total_error": 0.05}, names)})["error [%]"].to_dict()
    {'work of adhesion': 3.0, 'mesh and step': 4.0, 'all of these': 5.0, 'shorter waves*': 10.0}
    """
    budget = run[BUDGET]
    rows = {
        str(name): (100 * float(value), str(how))
        for name, value, how in zip(budget["entry"].values, budget["relative_error"].values, budget["how"].values)
    }
    apart = rows.pop("shorter waves", None)
    rows["all of these"] = (100 * float(budget["total_error"]), "root of the sum of squares of what was computed")
    if apart is not None:
        rows["shorter waves*"] = (apart[0], f"not in the total: {apart[1]}")
    table = pd.DataFrame.from_dict(rows, orient="index", columns=["error [%]", "how it was got"])
    table.index.name = "entry"
    return table


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
            f"{percent(sharp)} of the asperities are sharper than a tip of {tip:g} nm would draw them truly: if "
            "the scan's was as blunt, the surface is rougher than the scan, and sticks less."
        )
    return said
