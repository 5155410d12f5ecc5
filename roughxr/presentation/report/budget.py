"""The headline of a report with the conditions that it holds for, and the error budget as a table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from ...scans.regions import extent
from ...statistics import smooth_pull_off
from ...statistics.sampling import by_share
from ...vocabulary.numbers import percent, quantity
from ...vocabulary.verbs import verb

Run = Mapping[str, xr.Dataset]

BUDGET = "statistics/error_budget"

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
    pull = run["statistics/adhesive"]
    pull = pull.isel(preload=0) if "preload" in pull.dims else pull
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
    known = "statistics/continued" in run and np.isfinite(float(run["statistics/continued"]["pull_off_mean"]))
    said = [estimate, bound] if known else [bound, estimate]  # a number before why there is no other
    return " ".join(filter(None, [_scan_too_small(run), *said]))


def _as_it_would_be(run: Run) -> str:
    """Return the best estimate, and what is known and assumed; empty where the run has not looked for it."""
    if "statistics/continued" not in run:
        return ""
    estimate = run["statistics/continued"]
    if not np.isfinite(float(estimate["pull_off_mean"])):
        return str(estimate.attrs["known"])
    mean, lower, upper = (
        quantity(float(estimate[name])) for name in ("pull_off_mean", "pull_off_lower", "pull_off_upper")
    )
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
    """Return the error budget: error of the mean pull-off in per cent, and how it was computed."""
    budget = run[BUDGET]
    rows = {
        str(name): (100 * float(value), str(how))
        for name, value, how in zip(budget["entry"].values, budget["relative_error"].values, budget["how"].values)
    }
    apart = rows.pop("shorter waves", None)
    rows["all of these"] = (100 * float(budget["total_error"]), "root of the sum of squares of what was computed")
    if apart is not None:
        rows["shorter waves*"] = (apart[0], f"not in the total: {apart[1]}")
    table = pd.DataFrame.from_dict(rows, orient="index", columns=["error [%]", "how it was computed"])
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
            f"{percent(sharp)} of the asperities are too sharp for a tip of {tip:g} nm radius to image them truly: if "
            "the tip of the scan was as blunt, the surface is rougher than the scan and sticks less."
        )
    return said
