"""The mean pull-off of superposed asperities under each change, with its interval from the scatter between places."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...asperity.catalogue import asperities
from ...asperity.superposition import superpose
from ...bodies.liquid import menisci_of, work_of
from ...bodies.pair import elastic
from ...scans.tip import tip_flags
from ...statistics import bootstrap, pull_off
from ...vocabulary import schema
from .changes import Case


class Sweep(NamedTuple):
    """How asperities are fitted and summed in all cases, unless a case changes it."""

    places: xr.Dataset
    deltas: np.ndarray  # nm, from first touch


def superposed(ds: xr.Dataset, cases: Sequence[Case], sweep: Sweep) -> xr.Dataset:
    """Return the results of each case along ``case``."""
    image = asperities(ds)
    return xr.concat([_computed(case, sweep, image) for case in cases], dim="case")


def sweep_of(ds: xr.Dataset) -> np.ndarray:
    """Return displacements from first touch that should include every pull-off."""
    (radius, modulus), work = schema.pair(ds, "sphere_radius", "contact_modulus"), work_of(ds)
    if (menisci := menisci_of(ds)) is not None:
        return np.linspace(-menisci.height, max(4 * menisci.height, float(ds["height"].std())), 161)
    end = (np.pi**2 * work**2 * radius / modulus**2) ** (1 / 3)  # JKR displacement at pull-off within a factor of two
    return np.linspace(-2 * end, max(4 * end, float(ds["height"].std())), 161)


def _computed(case: Case, sweep: Sweep, image: xr.Dataset) -> xr.Dataset:
    """Return the results of one case."""
    patch = case.value if case.factor == "fit window" else "auto"
    vertex = case.value if case.factor == "vertex" else "fitted"
    words, scan = case.changed()
    catalogue = asperities(scan, patch=patch, vertex=vertex)
    summed = superpose(elastic(catalogue), delta=sweep.deltas, subregions=sweep.places, datum="first_contact")
    pull = pull_off(summed)
    found = bootstrap(pull, "pull_off_force", statistics=["mean", "std", "q50"]).drop_vars("independent_places")
    ends = found.sel(resampling="block", statistic="mean")
    values: dict[str, Any] = {
        "pull_off_mean": found["estimate"].sel(statistic="mean"),
        "pull_off_mean_low": ends["low"],
        "pull_off_mean_high": ends["high"],
        "pull_off_std": found["estimate"].sel(statistic="std"),
        "pull_off_median": found["estimate"].sel(statistic="q50"),
        "asperities": catalogue.sizes["asperity"],
        "unbracketed": (~pull["bracketed"]).sum(),
        "sharper_than_tip": _hidden(scan, image),
    }
    return xr.Dataset({name: ((), float(value)) for name, value in values.items()}, coords={"setting": words})


def _hidden(scan: xr.Dataset, image: xr.Dataset) -> float:
    """Return the share of the image's asperities that are sharper than the removed tip."""
    if "tip_radius" not in scan.coords:
        return np.nan
    return float(tip_flags(image, tip_radius=scan["tip_radius"].item())["sharper_than_tip"].mean())
