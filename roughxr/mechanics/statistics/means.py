"""The mean pull-off force over places, its interval and its numerical error."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..contact.mesh import FRONT
from ..contact.pressing import is_range
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.table import SCALARS
from .pull_off_events import pull_off, smooth_pull_off
from .sampling import (
    LIMITS,
    at_first_preload,
    forces_of_one_condition,
    mean_of_places,
    refuse_several,
    sample_bounds,
    weighted_by_landing_share,
    with_limits,
)
from .uncertainty import bootstrap

#: Relative errors of places, of the simulation with adhesion and of rigid bodies.
_PLACE_ERRORS = ("pull_off_error", "cell_error")

#: Mean pull-offs of a sphere that was pressed as little, and as hard, as it may be.
PRESSED = ("pressed_low", "pressed_high")

#: Mean pull-off of the real surface in a result of `extrapolated`, and the ends of its interval.
BEST_ESTIMATE = ("pull_off_mean", "pull_off_low", "pull_off_high")

#: Variables of an interval that the answer takes over.
INTERVAL = ("low", "high", "likelihood_low", "likelihood_high", "independent_places")


@schema.recorded_as("answer")
def mean_pull_off(ds: xr.Dataset) -> xr.Dataset:
    """Return the Dataset of `answer` without its sentences."""
    if "pull_off_force" not in ds and "force" not in ds:
        raise Refusal("", "a solution, or its pull_off", "neither", "run adhesive, rigid or superpose first")
    pull = at_first_preload(ds if "pull_off_force" in ds else pull_off(ds))
    force = pull["pull_off_force"].load()
    bounds = _adhering_bounds(pull)
    mean, interval, limits = _mean_with_interval(pull, bounds)
    smooth = smooth_pull_off(pull) if {"sphere_radius", "work_of_adhesion"} <= set(pull.coords) else 0.0
    scalars = {
        "pull_off_force": mean,
        **interval,
        "places": int(np.isfinite(bounds[0]).sum()),
        "solved_places": force.size,
        "debris_share": pull.coords.get("debris_share", np.nan),
        "debris_places": (pull["on_debris"] & force.notnull()).sum() if "on_debris" in pull.coords else np.nan,
        "mesh_error": mesh_error(pull),
        "smooth_share": mean / smooth if smooth > 0 else np.nan,
    }
    if ends := pressed_means(pull):
        scalars |= dict(zip(PRESSED, ends))
    out = with_units(xr.Dataset(scalars, coords=schema.pair_coordinates(pull)))
    out.attrs |= limits | {name: pull.attrs[name] for name in ("switching_tabor", "measured") if name in pull.attrs}
    if pull.attrs.get("mesh") == FRONT:
        out.attrs["by_front"] = "yes"
    return out.assign_attrs(rigid="yes") if "cell_error" in pull and "pull_off_error" not in pull else out


def _mean_with_interval(pull: xr.Dataset, bounds: np.ndarray) -> tuple[float, dict[str, float], dict[str, Any]]:
    """Return the mean over places with forces between bounds (2, …), its interval, and its limits."""
    mean = mean_of_places(pull["pull_off_force"])
    if np.isfinite(bounds[0]).sum() <= 1:
        interval = dict.fromkeys(INTERVAL, np.nan)
        if np.isnan(mean):
            interval |= {"low": np.nanmax(bounds[0]), "high": np.nanmax(bounds[1])}
        return mean, interval, {}
    sampled = bootstrap(with_limits(pull, "pull_off_force"), "pull_off_force", statistics=["mean"])
    interval = {name: sampled[name].item() if name in sampled else np.nan for name in INTERVAL}
    limits = {name: sampled.attrs[name] for name in (*LIMITS, "law") if name in sampled.attrs}
    return sampled["estimate"].item() if limits else mean, interval, limits


def _adhering_bounds(pull: xr.Dataset) -> np.ndarray:
    """Return the ends (2, …) of the pull-off forces; raise unless they are those of places of which some adhere."""
    force = pull["pull_off_force"]
    refuse_several(pull)
    if not force.dims and not {"subregion", "subregion_x"} & set(force.coords):
        raise Refusal(
            "",
            "places along subregion",
            "a single force",
            "take the answer before the mean over places, or of one place, isel(subregion=0)",
        )
    forces_of_one_condition(pull, "pull_off_force")
    bounds = sample_bounds(pull, "pull_off_force")
    if not (bounds[1] > 0).any():
        raise Refusal("pull_off_force", "at least one place that adheres", f"none of {force.size}")
    return bounds


def mesh_error(pull: xr.Dataset) -> float:
    """Return the relative numerical error of the mean pull-off, if errors of places add; NaN if unknown.

    Errors are weighted by the force of each place, as in the mean. Ranges are no errors, see `pressed_means`.
    """
    error_name = next((name for name in _PLACE_ERRORS if name in pull), None)
    if error_name is None:
        return np.nan
    force = pull["pull_off_force"].where(pull[error_name].notnull())
    return float(
        weighted_by_landing_share(force * abs(pull[error_name])).mean() / weighted_by_landing_share(force).mean()
    )


def estimated_mean(extrapolated: xr.Dataset | None) -> tuple[float, float, float] | None:
    """Return the mean of a result of `extrapolated` and the ends of its interval, nN, or None."""
    if extrapolated is None or BEST_ESTIMATE[0] not in extrapolated:
        return None
    mean, low, high = (float(extrapolated[name]) for name in BEST_ESTIMATE)
    return (mean, low, high) if np.isfinite(mean) else None


def scalar_values(summary: xr.Dataset) -> dict[str, float]:
    """Return the scalars of a summary by name, in their units; NaN where it lacks one."""
    return {name: float(summary[name]) if name in summary else np.nan for name in SCALARS}


def with_units(summary: xr.Dataset) -> xr.Dataset:
    """Return scalars with their units and meaning."""
    for name in set(SCALARS) & set(summary.data_vars):
        summary[name].attrs = {"units": SCALARS[name].units, "long_name": SCALARS[name].long_name}
    return summary


def pressed_means(pull: xr.Dataset) -> tuple[float, float] | None:
    """Return the means of the lower and of the upper ends of pull-offs that are ranges by pressing, None without any.

    A place whose pull-off is no range counts in both with its pull-off.
    """
    if "pressed_pull_off_force" not in pull:
        return None
    force = pull["pull_off_force"]
    pressed = pull["pressed_pull_off_force"]
    depends = is_range(force, pressed)
    if not depends.any():
        return None
    pressed = pressed.where(depends, force)
    low, high = (mean_of_places(end) for end in (np.minimum(force, pressed), np.maximum(force, pressed)))
    return low, high
