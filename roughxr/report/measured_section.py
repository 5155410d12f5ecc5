"""Measured pull-off forces beside those that the run predicts, where a run holds or is given measured ones."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
import xarray as xr

from ..measured import compare
from ..statistics.sampling import at_first_preload
from ..vocabulary import numbers

Run = Mapping[str, xr.Dataset]

#: Groups of the measured pull-offs, and of their comparison with the method of the main numbers.
MEASURED, COMPARED = "measured/pull_off", "measured/against"


def prediction(run: Run) -> xr.Dataset:
    """Return the pull-off of the main numbers, that of the first preload where there are several."""
    return at_first_preload(run["statistics/adhesive" if "statistics/adhesive" in run else "statistics/energy"])


def compared(run: Run) -> Run:
    """Return a run with the comparison added; unchanged where there is nothing to compare."""
    predicted = {"statistics/adhesive", "statistics/energy"} & set(run)
    if MEASURED not in run or not predicted:
        return run
    return {**run, COMPARED: compare(prediction(run), run[MEASURED])}


def measured_words(run: Run) -> list[str]:
    """Return sentences on what was measured, and on whether it agrees with the predicted distribution."""
    if COMPARED not in run:
        return []
    comparison, measured = run[COMPARED], run[MEASURED]
    mean = comparison.sel(statistic="mean")
    origin = f"{measured.attrs.get('measured', 'pull-offs')} in {measured.attrs.get('source_file', 'no file')}"
    said = [f"Measured: {int(measured['pull_off_force'].notnull().sum())} places of {origin}."]
    interval = numbers.interval(float(mean["ratio_low"]), float(mean["ratio_high"]))
    said += [f"The measured mean is {numbers.number(mean['ratio'])} times the predicted (95 % interval {interval})."]
    p_value, distance = float(comparison["distribution_p_value"]), float(comparison["distribution_distance"])
    verdict = "differ significantly" if p_value < 0.05 else "do not differ significantly"
    said += [
        f"The distributions {verdict}: the largest difference of their cumulative distributions is "
        f"{numbers.percent(distance)}, p = {numbers.number(p_value)}."
    ]
    return [*said, f"Places: {comparison.attrs['places']}."]


def measured_table(run: Run) -> pd.DataFrame:
    """Return predicted and measured statistics with their ratio, in a suitable unit."""
    comparison = run[COMPARED]
    unit, size = numbers.prefixed(float(comparison["predicted"].sel(statistic="mean")))
    columns = {f"{name} [{unit}]": comparison[name].values / size for name in ("predicted", "measured")}
    columns |= {name.replace("_", ", "): comparison[name].values for name in ("ratio", "ratio_low", "ratio_high")}
    return pd.DataFrame(columns, index=pd.Index(comparison["statistic"].values.astype(str), name="statistic"))
