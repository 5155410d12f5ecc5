"""The assumptions about a scan and its pair of bodies that an error budget changes, one factor at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..bodies.liquid import ANGLES, angles, at_humidity, share_of_work
from ..contact.problem import hardness_of
from ..scans import level
from ..scans.tip import erode
from ..vocabulary import schema

#: Settings, the typical uncertainties of a careful experiment: cells this many times finer and steps as much shorter,
#: preload increased by this many mean pull-offs, levelling, interpolation of the heights between the pixels, radius of
#: the tip removed (nm), and factors on the parameters of the pair. A shorter range takes finer cells: at two thirds
#: each place takes eight times as long. Modulus and radius are changed one way: the other would take a sixth of the
#: time and change nothing.
SIMULATED: dict[str, tuple] = {
    "mesh": (2,),
    "preload": (0.1,),
    "levelling": ("quadratic",),
    "interpolation": ("splines",),
    "tip radius": (10.0,),
    "range of adhesion": (4 / 3,),
    "surface energy": (0.8, 1.2),
    "modulus": (1.1,),
    "sphere radius": (1.05,),
}

#: Further settings for the simulation of a body that yields: factors on its hardness.
OF_YIELD: dict[str, tuple] = {"hardness": (0.75, 1.25)}

#: Further settings for a humid pair: humidity added, and degrees added to the contact angles on both bodies.
OF_LIQUID: dict[str, tuple] = {"humidity": (-0.05, 0.05), "contact angle": (-5.0, 5.0)}

#: Factors that change how the contact is solved, not the scan or its pair.
OF_SOLVES = ("mesh", "preload", "interpolation")

#: Factors whose setting multiplies a parameter, so that the pull-off has a slope with it.
RATIOS = ("range of adhesion", "surface energy", "modulus", "sphere radius", "hardness")


class Case(NamedTuple):
    """One factor at one of its settings."""

    factor: str
    value: Any
    ds: xr.Dataset  # the scan and the pair as given

    def changed(self) -> tuple[str, xr.Dataset]:
        """Return the setting in words, and the scan and pair with it, which are unchanged if only the solve changes.

        Raises
        ------
        ValueError
            If the scan or its pair cannot be changed in this way.
        """
        if self.factor in CHANGES:
            return CHANGES[self.factor](self.ds, self.value)
        return _WORDS[self.factor](self.value), self.ds


def cases(ds: xr.Dataset, settings: Mapping[str, Sequence]) -> list[Case]:
    """Return the base case and each change."""
    changes = [Case(factor, value, ds) for factor, values in settings.items() for value in values]
    return [Case("base", None, ds), *changes]


#: Changes of the solve, in words.
_WORDS: dict[str, Callable[[Any], str]] = {
    "base": lambda _: "as given",
    "mesh": lambda value: f"{value} times as fine",
    "interpolation": str,
    "preload": lambda value: f"+ {value:.3g} pull-offs",
}


def _levelled(ds: xr.Dataset, method: str) -> tuple[str, xr.Dataset]:
    return method, level(ds, method=method)


def _without_tip(ds: xr.Dataset, radius: float) -> tuple[str, xr.Dataset]:
    return f"{radius:g} nm", erode(ds, tip_radius=radius).assign_coords(tip_radius=radius)


def _scaled(name: str) -> Callable:
    """Return the change that multiplies a coordinate of the pair."""

    def change(ds: xr.Dataset, factor: float) -> tuple[str, xr.Dataset]:
        (value,) = schema.pair(ds, name, humid=True)
        derived = share_of_work(ds, value * factor) if name == "work_of_adhesion" else {}
        return f"× {factor:.3g}", ds.assign_coords({name: value * factor} | derived)

    return change


def _harder(ds: xr.Dataset, factor: float) -> tuple[str, xr.Dataset]:
    """Return the pair with the assigned or estimated hardness multiplied by a factor, so that it yields there."""
    hardness, _ = hardness_of(ds)
    if not np.isfinite(hardness):
        raise ValueError("no hardness is assigned, and none estimated for named materials")
    return f"× {factor:.3g}", ds.drop_vars("hardness_estimate", errors="ignore").assign_coords(
        hardness=hardness * factor
    )


def _more_humid(ds: xr.Dataset, more: float) -> tuple[str, xr.Dataset]:
    return f"{more:+.3g}", ds.assign_coords(at_humidity(ds, float(ds["humidity"]) + more))


def _wets_less(ds: xr.Dataset, degrees: float) -> tuple[str, xr.Dataset]:
    own = [float(np.degrees(ds[name])) for name in ANGLES]
    changed = angles(tuple(max(angle + degrees, 0.0) for angle in own))
    return f"{degrees:+.3g} degrees", ds.assign_coords(dict(zip(ANGLES, changed)))


#: The function that changes the scan or its pair, by factor.
CHANGES: dict[str, Callable[[xr.Dataset, Any], tuple[str, xr.Dataset]]] = {
    "levelling": _levelled,
    "tip radius": _without_tip,
    "surface energy": _scaled("work_of_adhesion"),
    "modulus": _scaled("contact_modulus"),
    "sphere radius": _scaled("sphere_radius"),
    "range of adhesion": _scaled("adhesion_range"),
    "hardness": _harder,
    "humidity": _more_humid,
    "contact angle": _wets_less,
}
