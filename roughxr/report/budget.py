"""The headline of a report with the conditions that it holds for, and the error budget as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from ..bodies import liquid
from ..scans.regions import extent
from ..statistics import smooth_pull_off
from ..statistics.headline import best_estimate
from ..statistics.sampling import at_first_preload, by_share
from ..vocabulary import schema
from ..vocabulary.numbers import percent, quantity
from ..vocabulary.verbs import verb

Run = Mapping[str, xr.Dataset]

BUDGET = "statistics/error_budget"

#: The pull between rigid bodies over humidity.
HUMIDITY = "statistics/humidity"

#: Shortest wave (nm) of a scan too coarse for the question: contacts at pull-off are smaller.
_COARSE_WAVELENGTH = 50.0


@verb
def headline(run: Run) -> str:
    """Return the mean pull-off of the surface as it would be and as the scan shows it, and what is known and assumed.

    Parameters
    ----------
    run : mapping of str to Dataset
        The groups of a run.

    Returns
    -------
    str
        Empty where the run holds no simulation with adhesion.

    Examples
    --------
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [40.0])})
    >>> print(headline({"statistics/adhesive": pull}))
    From the scan alone: a mean pull-off of 40 nN over 1 place, an upper bound.
    """
    if "statistics/adhesive" not in run:
        return ""
    pull = at_first_preload(run["statistics/adhesive"])
    mean, count = float(by_share(pull["pull_off_force"]).mean()), int(pull["pull_off_force"].notnull().sum())
    if not count:
        return "The sphere sticks at no place."
    smooth = smooth_pull_off(pull) if "sphere_radius" in pull.coords else np.nan
    more = ", a limit for soft bodies that stiff ones can exceed by up to a third" * bool(mean > smooth)
    part = f" ({percent(mean / smooth)} of the pull-off from a smooth flat{more})"
    air = f" at {percent(pull['humidity'])} relative humidity" if "humidity" in pull.coords else ""
    bound = (
        f"From the scan alone{air}: a mean pull-off of {quantity(mean)} over {count} place{'s' * (count > 1)}"
        f"{part if smooth > 0 else ''}, an upper bound."
    )
    estimate = _as_it_would_be(run)
    said = [estimate, bound] if best_estimate(run) else [bound, estimate]  # a number before why there is no other
    return " ".join(filter(None, [_scan_too_small(run), *said]))


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
    return " ".join([*said, liquid.told(scan)])


def _as_it_would_be(run: Run) -> str:
    """Return the best estimate, and what is known and assumed; empty where the run has not looked for it."""
    if "statistics/continued" not in run:
        return ""
    estimate = run["statistics/continued"]
    if (known := best_estimate(run)) is None:
        return str(estimate.attrs["known"])
    mean, lower, upper = map(quantity, known)
    settled = "" if bool(estimate["converged"]) else " Shorter waves would still lower it."
    return (
        f"Best estimate, roughness finer than the pixel included: a mean pull-off of {mean} (95 % interval {lower} … "
        f"{upper}, from places, bodies and spectrum, which shift the upper bound as well). {estimate.attrs['known']} "
        f"{estimate.attrs['assumed']}{settled}"
    )


def _scan_too_small(run: Run) -> str:
    """Return a sentence on a scan that is smaller than what the sphere feels, or too coarse for its question."""
    if "scan" not in run or "sphere_radius" not in run["scan"].coords:
        return ""
    scan, said = run["scan"], ""
    x_low, x_high, y_low, y_high = extent(scan)
    side, radius = min(x_high - x_low, y_high - y_low), float(scan["sphere_radius"])
    height = scan["height"].values
    feels = 2 * np.sqrt(2 * radius * 2 * float(np.nanstd(height)))
    if side < 2 * feels:
        said = (
            f"This scan of {side:.3g} nm is hardly larger than the region that the sphere can touch, {feels:.3g} nm: "
        )
        said += "all places share the same few summits, and say little about the rest of the surface. "
    known = run.get("solutions/adhesive", run["statistics/adhesive"]).coords.get("shortest_wavelength")
    shown = float(known) if known is not None else np.nan
    if shown > _COARSE_WAVELENGTH:
        said += (
            f"This scan does not resolve roughness finer than {shown:.3g} nm; the true pull-off is probably much lower."
        )
    return said.strip()


@verb
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
