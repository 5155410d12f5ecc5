"""Detachment of the sphere of a run by a flow: notes of the report's table, and the fraction remaining."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.particles import resuspension
from ...mechanics.particles.force_balance import fluid_of, strength_of_places
from ...mechanics.statistics.sampling import mean_of_places, quantile_of_places
from ...mechanics.vocabulary.refusal import Refusal
from ..wording import render_sentences
from .run_numbers import STABLE_CONTACTS, run_moments, unstable
from .summary import DETACHMENT, RESTS, critical_flow, fluid_in_words

Run = Mapping[str, xr.Dataset]


def detachment_notes(run: Run) -> list[str]:
    """Return the assumptions of the table as sentences; none for a run without its groups."""
    if not set(DETACHMENT) <= set(run):
        return []
    critical = critical_flow(run)
    moments = run["solutions/rolling"]
    speed = strength_of_places(critical)
    fluid = fluid_of(critical)
    stress = fluid.density * float(quantile_of_places(speed, 0.5)) ** 2
    values = {
        "fluid": fluid_in_words(fluid),
        "at_rest": RESTS in run,
        "wall_shear_stress": stress if stress > 0 else None,
        "places_out": int(((speed > 0) & ~critical["in_range"].astype(bool)).sum()),
        "number_of_places": speed.size,
        "stable": mean_of_places(moments["contacts"] >= STABLE_CONTACTS),
        "places_unstable": int(unstable(moments).sum()),
    }
    return render_sentences("notes.toml", ["flow", "range_of_drag", "rest"], values)


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
