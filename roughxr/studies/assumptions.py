"""The assumptions about a scan and its pair of bodies that an error budget changes, one factor at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..bodies.layer import stiffened
from ..bodies.liquid import ANGLES, angles, humidity_coordinates, updated_liquid_share
from ..bodies.pair import attraction_range
from ..contact.problem import known_hardness
from ..scans import level
from ..scans.tip import erode, impossible_share
from ..vocabulary import schema
from ..vocabulary.numbers import percent

#: Radius (nm) of the tip whose effect is removed.
TIP_RADIUS = 10.0

#: Part of a tip's effect, sharper than the tip can image, above which it is that of noise.
_NOISE_SHARE = 0.5


def _scale_coordinate(name: str) -> Callable:
    """Return a change of the pair that multiplies one coordinate by a factor, with the factor as its label."""

    def change(ds: xr.Dataset, factor: float) -> tuple[str, xr.Dataset]:
        (value,) = schema.pair(ds, name, humid=True)
        derived = updated_liquid_share(ds, value * factor) if name == "work_of_adhesion" else {}
        return f"× {factor:.3g}", ds.assign_coords({name: value * factor} | derived)

    return change


def _stiffer(ds: xr.Dataset, factor: float) -> tuple[str, xr.Dataset]:
    return f"× {factor:.3g}", ds.assign_coords(stiffened(ds, factor))


def _with_hardness_factor(ds: xr.Dataset, factor: float) -> tuple[str, xr.Dataset]:
    """Return the pair that yields at a factor times the assigned or estimated hardness."""
    hardness, _ = known_hardness(ds)
    if not np.isfinite(hardness):
        raise ValueError("no hardness is assigned, and none estimated for named materials")
    return f"× {factor:.3g}", ds.drop_vars("hardness_estimate", errors="ignore").assign_coords(
        hardness=hardness * factor
    )


def _with_larger_angles(ds: xr.Dataset, degrees: float) -> tuple[str, xr.Dataset]:
    own = [float(np.degrees(ds[name])) for name in ANGLES]
    changed = angles(tuple(max(angle + degrees, 0.0) for angle in own))
    return f"{degrees:+.3g} degrees", ds.assign_coords(dict(zip(ANGLES, changed)))


def noise_limit(ds: xr.Dataset) -> float:
    """Return an upper limit of a scan's noise (nm, rms): by the second differences of neighbouring lines."""
    heights = ds["height"].values
    differences = [np.diff(heights, 2, axis=axis) for axis in (0, 1)]
    return float(min(np.sqrt(np.mean(difference**2) / 6) for difference in differences))


def _with_noise(ds: xr.Dataset, share: float) -> tuple[str, xr.Dataset]:
    """Return the scan with white noise, a share of its upper limit; raise if roughness hides the noise."""
    limit = noise_limit(ds)
    length = attraction_range(ds)
    if limit > length:
        raise ValueError(
            f"neighbouring lines bound the noise to {limit:.2g} nm only, beyond the range of adhesion, {length:.2g} nm"
        )
    noise = np.random.default_rng(0).normal(0, share * limit, ds["height"].shape)
    return f"{share * limit:.2g} nm", ds.assign(height=ds["height"].copy(data=ds["height"].values + noise))


def _without_tip(ds: xr.Dataset, radius: float) -> tuple[str, xr.Dataset]:
    """Return the scan with a tip's effect removed; raise for a scan that this tip cannot have made."""
    share = impossible_share(ds, tip_radius=radius)
    if share > _NOISE_SHARE:
        raise ValueError(
            f"{percent(share)} of the heights that a tip of {radius:g} nm radius would have added are sharper than it "
            "can image: noise, or a sharper tip"
        )
    return f"{radius:g} nm", erode(ds, tip_radius=radius).assign_coords(tip_radius=radius)


class Factor(NamedTuple):
    """An assumption: settings changed by its typical uncertainty, their description, and the change of scan or pair."""

    settings: tuple
    words: str
    change: Callable[[xr.Dataset, Any], tuple[str, xr.Dataset]] | None = None  # None: only the solve changes
    is_ratio: bool = False  # the setting multiplies a parameter, so that the pull-off has a slope with it


#: By name, with the uncertainties of a careful experiment. The range is only increased: two thirds of it would need
#: finer cells and eight times the time. Modulus and radius are changed in one direction only, which saves a sixth of
#: the time without a change of the result.
FACTORS: dict[str, Factor] = {
    "mesh": Factor((2,), "cells and steps smaller by a factor of {}"),
    "preload": Factor((0.1,), "preload {}"),
    "levelling": Factor(("quadratic",), "another levelling: {}", lambda ds, method: (method, level(ds, method=method))),
    "interpolation": Factor(("splines",), "heights between pixels interpolated by {}"),
    "tip radius": Factor(
        (TIP_RADIUS,),
        "effect of a tip of {} radius removed from the scan",
        _without_tip,
    ),
    "noise": Factor((1.0,), "noise of {} added, as much as neighbouring lines allow", _with_noise),
    "range of adhesion": Factor((4 / 3,), "range of adhesion {}", _scale_coordinate("adhesion_range"), True),
    "work of adhesion": Factor((0.8, 1.2), "work of adhesion {}", _scale_coordinate("work_of_adhesion"), True),
    "modulus": Factor((1.1,), "contact modulus {}", _stiffer, True),
    "layer thickness": Factor((0.9, 1.1), "layer thickness {}", _scale_coordinate("layer_thickness"), True),
    "sphere radius": Factor((1.05,), "radius {}", _scale_coordinate("sphere_radius"), True),
    "hardness": Factor((0.75, 1.25), "hardness {}", _with_hardness_factor, True),
    "humidity": Factor(
        (-0.05, 0.05),
        "humidity {}",
        lambda ds, more: (f"{more:+.3g}", ds.assign_coords(humidity_coordinates(ds, float(ds["humidity"]) + more))),
    ),
    "contact angle": Factor((-5.0, 5.0), "contact angles {}", _with_larger_angles),
}

#: Factors of a humid pair.
HUMID = ("humidity", "contact angle")


def pair_factors(ds: xr.Dataset) -> list[str]:
    """Return the factors of a pair: hardness and layer only if assigned, those of liquid only for a humid pair."""
    absent = {*(() if "hardness" in ds.coords else ("hardness",)), *(() if schema.is_wet(ds) else HUMID)}
    absent |= set() if schema.is_coated(ds) else {"layer thickness"}
    return [name for name in FACTORS if name not in absent]
