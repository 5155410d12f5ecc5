"""The assumptions about a scan and its pair of bodies that an error budget changes, one factor at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from ..bodies.layer import stiffened
from ..bodies.liquid import ANGLES, angles, humidity_coordinates, updated_liquid_share
from ..bodies.pair_record import read_pair
from ..scans.levelling import level
from ..scans.tip import erode, impossible_share
from ..vocabulary import schema
from ..vocabulary.error_sources import CHANGED, ERROR_SOURCES, KNOWN_RANGE, RANGE, UNKNOWN_RANGE
from ..vocabulary.numbers import format_percent
from ..vocabulary.refusal import Refusal


def _scale_coordinate(name: str) -> Callable:
    """Return a change of the pair that multiplies one coordinate by a factor."""

    def change(ds: xr.Dataset, factor: float) -> xr.Dataset:
        schema.need_assigned(ds, name)
        value = float(ds[name])
        derived = updated_liquid_share(ds, value * factor) if name == "work_of_adhesion" else {}
        return ds.assign_coords({name: value * factor} | derived)

    return change


def _with_hardness_factor(ds: xr.Dataset, factor: float) -> xr.Dataset:
    """Return the pair that yields at a factor times the assigned or estimated hardness."""
    hardness = read_pair(ds).hardness
    if not np.isfinite(hardness):
        raise Refusal("hardness", "one that is assigned, or estimated for named materials", "none")
    return ds.drop_vars("hardness_estimate", errors="ignore").assign_coords(hardness=hardness * factor)


def _with_larger_angles(ds: xr.Dataset, degrees: float) -> xr.Dataset:
    degrees_now = [float(np.degrees(ds[name])) for name in ANGLES]
    changed = angles(tuple(max(angle + degrees, 0.0) for angle in degrees_now))
    return ds.assign_coords(dict(zip(ANGLES, changed)))


def noise_limit(ds: xr.Dataset) -> float:
    """Return an upper limit of a scan's noise (nm, rms): by the second differences of neighbouring lines."""
    heights = ds["height"].values
    differences = [np.diff(heights, 2, axis=axis) for axis in (0, 1)]
    return float(min(np.sqrt(np.mean(difference**2) / 6) for difference in differences))


def _with_noise(ds: xr.Dataset, share: float) -> xr.Dataset:
    """Return the scan with white noise, a share of its upper limit; raise if roughness hides the noise."""
    limit = noise_limit(ds)
    length = read_pair(ds).range
    if limit > length:
        expected = f"neighbouring lines that bound it below the range of adhesion, {length:.2g} nm"
        raise Refusal("noise", expected, f"a bound of {limit:.2g} nm")
    noise = np.random.default_rng(0).normal(0, share * limit, ds["height"].shape)
    return ds.assign(height=ds["height"].copy(data=ds["height"].values + noise))


def _without_tip(ds: xr.Dataset, radius: float) -> xr.Dataset:
    """Return the scan with a tip's effect removed; raise for a scan that this tip cannot have made."""
    share = impossible_share(ds, tip_radius=radius)
    # part of a tip's effect, sharper than the tip can image, above which it is that of noise
    if share > 0.5:
        noise = f"{format_percent(share)} of what it would have added sharper than that: noise, or a sharper tip"
        raise Refusal("tip radius", f"heights as a tip of {radius:g} nm radius can image them", noise)
    return erode(ds, tip_radius=radius).assign_coords(tip_radius=radius)


def _with_added_humidity(ds: xr.Dataset, added: float) -> xr.Dataset:
    return ds.assign_coords(humidity_coordinates(ds, float(ds["humidity"]) + added))


#: Changes of scan or pair by a source of error and its setting. Of the sources without one only the solution changes.
CHANGES: dict[str, Callable[[xr.Dataset, Any], xr.Dataset]] = {
    "levelling": lambda ds, method: level(ds, method=method),
    "tip radius": _without_tip,
    "noise": _with_noise,
    RANGE: _scale_coordinate("adhesion_range"),
    "work of adhesion": _scale_coordinate("work_of_adhesion"),
    "modulus": lambda ds, factor: ds.assign_coords(stiffened(ds, factor)),
    "layer thickness": _scale_coordinate("layer_thickness"),
    "sphere radius": _scale_coordinate("sphere_radius"),
    "hardness": _with_hardness_factor,
    "humidity": _with_added_humidity,
    "contact angle": _with_larger_angles,
}

#: Factors of a humid pair.
HUMID = ("humidity", "contact angle")


def pair_factors(ds: xr.Dataset) -> dict[str, tuple]:
    """Return a pair's factors and settings: hardness and layer only if assigned, of liquid only for a humid pair."""
    is_assigned = dict.fromkeys(HUMID, schema.is_humid(ds))
    is_assigned |= {"hardness": "hardness" in ds.coords, "layer thickness": schema.is_coated(ds)}
    return {name: ERROR_SOURCES[name].settings for name in CHANGED if is_assigned.get(name, True)}


def range_deviation(ds: xr.Dataset) -> float:
    """Return the standard deviation of the range of adhesion, as a factor."""
    return KNOWN_RANGE if {"adhesion_range", "hamaker_constant"} & set(ds.coords) else UNKNOWN_RANGE
