"""What a report says of a humid pair: how hard the sphere sticks at its humidity, and what that hangs on."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr

from ...bodies import liquid
from ...statistics.sampling import at_first_preload
from ...vocabulary import schema
from ...vocabulary.numbers import percent, quantity

#: The pull between rigid bodies over humidity.
HUMIDITY = "statistics/humidity"


def humid_words(run: Mapping[str, xr.Dataset]) -> str:
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
