"""Detachment of the sphere of a run by a flow: the report's table, its notes, and the fraction remaining."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from ...mechanics.particles import resuspension
from ...mechanics.particles.force_balance import (
    NEITHER,
    NO_CONTACT,
    NO_REST,
    fluid_of,
    strength_of_places,
    with_pull_off,
)
from ...mechanics.particles.loads import fluid_in_words
from ...mechanics.particles.removal import strength_quantile
from ...mechanics.statistics.sampling import at_first_preload, by_share
from ...mechanics.vocabulary.numbers import percent, quantity
from ...mechanics.vocabulary.refusal import Refusal
from .summary import CRITICAL, RESTS, best_method, critical_flow

Run = Mapping[str, xr.Dataset]

#: The groups that the table needs.
DETACHMENT = ("solutions/rolling", "statistics/adhesive", "statistics/detachment")

#: Modes of detachment in words; the shares of all add up to 100 %.
_MODES = {
    "roll": "rolls first",
    "lift": "lifts first",
    NO_REST: "rolls off without a flow",
    NEITHER: "stays in any flow",
    NO_CONTACT: "has no contact",
}

#: Smallest number of contacts on which a sphere rests without rolling.
_STABLE_CONTACTS = 3


def detachment_table(run: Run) -> pd.DataFrame:
    """Return resisting moments and the critical flow, by method."""
    columns = {way: _column(run_moments(run, way), run[group]) for way, group in CRITICAL.items() if group in run}
    return pd.DataFrame(columns).rename_axis("quantity")


def run_moments(run: Run, method: str | None = None) -> xr.Dataset:
    """Return the run's resisting moments, with the pull-off forces of a method."""
    moments = run["solutions/rolling"]
    method = method or best_method(run)
    if method == "extrapolated":
        moments = moments.assign_attrs(surface="the real surface, with roughness finer than the scan")
        mean = run["statistics/extrapolated"][["pull_off_mean", "pull_off_high"]]
        return with_pull_off(moments, run["solutions/extrapolated"].assign(mean))
    return with_pull_off(moments, at_first_preload(run["statistics/adhesive"]))


def _column(moments: xr.Dataset, critical: xr.Dataset) -> dict[str, float]:
    speed = strength_of_places(critical)
    moment, lever = (float(by_share(moments[name]).quantile(0.5)) for name in ("resisting_moment", "lever"))
    rows = {
        "resisting moment, median over places and directions [nN nm]": moment,
        "lever arm, median over places and directions [nm]": lever,
        "error of the lever arm by mesh, states and heights between pixels, median place [%]": _median_percent(
            moments, "lever_error"
        ),
    }
    for part, label in ((0.05, "5 %"), (0.5, "median"), (0.95, "95 %")):
        rows[f"critical friction velocity, {label} [m/s]"] = float(by_share(speed).quantile(part))
    error = _median_percent(critical, "critical_load_error")
    rows["error of the critical friction velocity by levers and pull-offs, median place [%]"] = error
    for end, value in zip(("lower", "upper"), strength_quantile(critical)[1:]):
        rows[f"{end} end of the median's 95 % interval, all known errors [m/s]"] = value
    shown = {
        **{f"places where the sphere {label} [%]": critical["mode"] == mode for mode, label in _MODES.items()},
        "places in the range of the drag formulas (r⁺ ≤ 1) [%]": critical["in_range"],
        f"places on fewer than {_STABLE_CONTACTS} contacts [%]": _unstable(moments),
    }
    return rows | {label: round(100 * float(by_share(flags.astype(float)).mean())) for label, flags in shown.items()}


def _median_percent(ds: xr.Dataset, name: str) -> float:
    if name not in ds or not bool(ds[name].notnull().any()):  # such as where the sphere rolls off by itself
        return np.nan
    return 100 * float(by_share(ds[name]).quantile(0.5))


def _unstable(moments: xr.Dataset) -> xr.DataArray:
    return (moments["contacts"] < _STABLE_CONTACTS) & moments["resisting_moment"].notnull().all("direction")


def detachment_notes(run: Run) -> list[str]:
    """Return the assumptions of the table as sentences; none for a run without its groups."""
    if not set(DETACHMENT) <= set(run):
        return []
    critical = critical_flow(run)
    moments = run["solutions/rolling"]
    speed = strength_of_places(critical)
    at_rest = RESTS in run
    fluid = fluid_of(critical)
    stress = fluid.density * float(by_share(speed).quantile(0.5)) ** 2
    middle = f", {quantity(stress, 'Pa')} at the median place" if stress > 0 else ""
    notes = [
        f"A steady flow of {fluid_in_words(fluid)} along x acts on the sphere "
        f"{'at its resting position' if at_rest else 'at each place'}. "
        "Its weight is neglected. The sphere can roll or lift off, but not slide, since no friction is given. The wall "
        f"shear stress is the density times the square of the friction velocity{middle}. The resisting moment is the "
        f"pull-off force times the lever arm of the simulation's contacts about the foremost edge. A single elastic "
        "contact may roll earlier: it closes in front as it opens behind, and resists by its hysteresis alone."
    ]
    if out := int(((speed > 0) & ~critical["in_range"].astype(bool)).sum()):
        notes.append(
            f"At {out} of {speed.size} places the critical flow is outside the range of the formulas for drag and "
            "torque (r u*/ν above 1), and thus an extrapolation."
        )
    if at_rest:
        stable = percent(by_share(moments["contacts"] >= _STABLE_CONTACTS).mean())
        notes.append(
            f"Particles rolled from the grid to resting positions; {stable} of them rest on three or more contacts."
        )
    elif unstable_places := int(_unstable(moments).sum()):
        notes.append(
            f"At {unstable_places} of {moments.sizes['subregion']} places the sphere rests on fewer than three "
            "contacts: a free particle would roll on until three support it. A run of particles analyses their resting "
            "positions."
        )
    return notes


def turbulent_speed(
    moments: xr.Dataset, critical: xr.Dataset, share: float, **options: Any
) -> tuple[float, float, float]:
    """Return the friction velocity of turbulence that removes a share in one second, and the ends of its interval."""
    strength = critical["critical_friction_velocity"].values
    strength = strength[strength > 0]
    speeds = np.geomspace(strength.min() / 20, strength.max() * 3, 80)
    fractions = resuspension(moments, friction_velocity=speeds, time=1.0, flow=fluid_of(critical), **options)

    def speed(name: str) -> float:
        if name not in fractions:
            return np.nan
        removed = 1 - fractions[name].isel(time=0).values
        return float(np.interp(share, removed, speeds, left=np.nan, right=np.nan))

    return speed("remaining"), speed("remaining_low"), speed("remaining_high")


def remaining_fraction(run: Run) -> xr.Dataset:
    """Return the fraction remaining in the run's flow, over all critical friction velocities of the run."""
    critical = critical_flow(run)
    speed = critical["critical_friction_velocity"].values
    speed = speed[speed > 0]
    if not speed.size:
        raise Refusal("critical_friction_velocity", "a place at which the sphere detaches in a flow", "none")
    speeds = np.geomspace(speed.min() / 3, speed.max() * 3, 40)
    return resuspension(run_moments(run), friction_velocity=speeds, time=1.0, flow=fluid_of(critical))
