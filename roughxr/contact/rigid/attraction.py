"""How rigid bodies attract each other, and what keeps them apart: the options of `rigid`, read once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from ...bodies.liquid import Menisci, menisci_of
from ...bodies.pair import DEFAULT_RANGE, closest_approach, range_of
from ...kernels.adhesion import potentials
from ...kernels.adhesion import rigid as kernels
from ...specimen import Specimen
from ...vocabulary import schema
from ..problem import Problem

#: How fast bodies part against the evaporation of liquid between them.
RATES = ("slow", "fast")

#: Laws of attraction, and the limits that keep the bodies apart.
RIGID_LAWS = tuple(potentials.POTENTIALS)
LIMITS = ("cut_off", "hardness", "elastic")

#: Height (nm) to which the indenter rises within a window, or this many times the range of heights if that is more
#: (for heights in memory); the ground further out is taken as its mean plane.
_RISE, _HEIGHT_RANGES = 300.0, 10.0

#: Share of the pull from beyond the scan above which a place counts as truncated.
BEYOND_EDGE = 0.01

#: Gaps of the nearest cell, in ε, between which Lennard-Jones's largest pull is searched.
NEAREST_GAPS = np.linspace(0.31, 1.35, 27)


class Options(NamedTuple):
    """How rigid bodies attract each other, and what keeps them apart."""

    law: potentials.Potential
    limit: str
    hardness: float  # GPa, NaN unless limit="hardness"
    area: float  # nm², of a pixel
    menisci: Menisci | None = None  # the liquid between the bodies, if there is any
    fast: bool = False  # whether its bridges keep their volume as the bodies part


def options_of(specimen: Specimen, law: str, limit: str, rate: str = "slow") -> Options:
    """Return the options of `rigid`; raise where they do not go together."""
    ds = specimen.bodies
    schema.one_of(law, RIGID_LAWS, "law")
    schema.one_of(limit, LIMITS, "limit")
    if limit != "cut_off" and law == "lennard_jones":
        raise ValueError(
            f"limit: expected 'cut_off' for law='lennard_jones', which has its own repulsion, found {limit!r}"
        )
    if schema.one_of(rate, RATES, "rate") == "fast" and (limit != "cut_off" or not schema.is_wet(ds)):
        raise ValueError(
            "rate: 'fast' needs a humid pair and limit='cut_off', found no humidity or another limit; take rate='slow'"
        )
    (w,), menisci = schema.pair(ds, "work_of_adhesion", wet=True), menisci_of(ds)
    if not w > 0 and menisci is None:
        raise ValueError(f"work_of_adhesion: expected more than 0 J/m² for bodies that attract, found {w:g}")
    wavelength = float(ds["retardation"]) if law == "hamaker" and "retardation" in ds.coords else np.inf
    length = DEFAULT_RANGE if not w > 0 else closest_approach(ds) if law == "hamaker" else range_of(ds, law)
    found = potentials.potential(law, w, length, wavelength)
    if menisci is not None:
        found = potentials.with_liquid(found, menisci.height, menisci.pull, menisci.share)
    return Options(
        law=found,
        limit=limit,
        hardness=_hardness(ds, found) if limit == "hardness" else np.nan,
        area=specimen.pixel**2,
        menisci=menisci,
        fast=rate == "fast",
    )


def _hardness(ds: xr.Dataset, law: potentials.Potential) -> float:
    """Return the hardness (GPa), which must exceed the largest traction for summits to keep the bodies apart."""
    if "hardness" not in ds.coords:
        raise ValueError("hardness: limit='hardness' needs it, found none; assign_pair(hardness=…) first")
    value, largest = float(ds["hardness"]), potentials.traction(kernels.floor(law), law)
    if value <= largest:
        raise ValueError(
            f"hardness: expected more than the law's largest traction, {largest:.3g} GPa, found {value:g} GPa"
        )
    return value


def reach_of(specimen: Specimen, problem: Problem) -> float:
    """Return the half-width of the windows, nm."""
    height_range = 0.0 if specimen.lazy else float(np.ptp(specimen.heights))
    return problem.indenter.reach(max(_RISE, _HEIGHT_RANGES * height_range))


def largest_pull(deltas: np.ndarray, pulls: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest pulls and their displacements, by quartics through five pulls at even displacements."""
    best = np.clip(pulls.argmax(-1), 2, pulls.shape[-1] - 3)[..., None]
    around = np.take_along_axis(pulls, best + np.arange(-2, 3), -1)
    quartic = around @ np.linalg.inv(np.vander(np.arange(-2.0, 3.0), increasing=True)).T
    x = np.zeros(best.shape[:-1])
    for _ in range(8):
        slope, bend = (np.polynomial.polynomial.polyder(np.moveaxis(quartic, -1, 0), k) for k in (1, 2))
        at = [np.polynomial.polynomial.polyval(x, part, tensor=False) for part in (slope, bend)]
        x = np.clip(x - at[0] / np.where(at[1] < 0, at[1], -np.inf), -2, 2)
    largest = np.polynomial.polynomial.polyval(x, np.moveaxis(quartic, -1, 0), tensor=False)
    nearest, step = np.take_along_axis(deltas, best, -1)[..., 0], deltas[..., 1] - deltas[..., 0]
    return largest, nearest + step * x
