"""The samples of a distribution: finite values along ``subregion`` or ``asperity``, with places and weights."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import IncompleteResult, did_you_mean, warn

#: Dimensions along which samples lie, and the coordinates of their places.
PLACES = {"subregion": ("subregion_x", "subregion_y"), "asperity": ("x", "y")}

SAMPLES = tuple(PLACES)

#: Coordinate of resting positions: share of particles at each, the default weight.
SHARE = "landing_share"

#: Variables with the limits of the pull-off forces that are known by them alone.
AT_MOST = "pull_off_at_most"
AT_LEAST = "pull_off_at_least"

#: Attributes of a result: numbers of samples below and above a limit, the largest upper and the least lower limit (nN).
LIMITS = ("limits_below", "largest_limit", "limits_above", "least_limit")

#: Smallest force that is detected: for a likelihood, a force below its limit is censored there, since limits above it
#: would count forces that are known twice.
DETECTION = "detection_limit"

#: Coordinate of measured forces: a condition that was varied.
CONDITION = "condition"


class Samples(NamedTuple):
    """Finite values, their weights (None: equal), their places (None: unknown), and the number of missing values.

    A sample that is a limit has the middle of its bounds as value, or the lower of them if there is no upper.
    """

    values: np.ndarray
    weights: np.ndarray | None
    places: Any  # (samples, 2), nm, or None
    missing: int
    on_debris: np.ndarray | None = None  # None: unknown, or landing shares are known
    bounds: np.ndarray | None = None  # (2, samples), equal where a value is known; None if all are
    censored: np.ndarray | None = None  # the same for a likelihood: below what is detected


def samples(ds: xr.Dataset, name: str, *, quiet: bool = False) -> Samples:
    """Return the finite samples of a variable, with a warning of missing ones unless ``quiet``.

    Pull-off forces that are known by their limits are samples, too.
    """
    weights = unequal_shares(ds[name]) if name in ds else None
    ds = map_samples(ds, name)
    dim = sample_dimension(ds, name)
    bounds = sample_bounds(ds, name)
    values = np.where(np.isinf(bounds[1]), bounds[0], bounds.mean(axis=0))
    finite = np.isfinite(values)
    if finite.sum() < 2:
        raise Refusal(name, "at least two finite samples", f"{finite.sum()} of {values.size}")
    places = None
    if all(axis in ds.coords for axis in PLACES[dim]):
        places = np.c_[tuple(ds[axis].values[finite] for axis in PLACES[dim])].astype(float)
    missing = int((~finite).sum())
    if not quiet:
        warn_of_missing(name, missing, values.size, ds[name].attrs.get("missing", ds.attrs.get("missing")))
    weight = None if weights is None else weights.values[finite]
    flagged = has_debris_flags(ds[name]) and SHARE not in ds.coords
    on_debris = ds["on_debris"].values.astype(bool)[finite] if flagged else None
    if not (bounds[0] < bounds[1]).any():
        return Samples(values[finite], weight, places, missing, on_debris)
    censored = _censored_bounds(ds, bounds)
    return Samples(values[finite], weight, places, missing, on_debris, bounds[:, finite], censored[:, finite])


def _censored_bounds(ds: xr.Dataset, bounds: np.ndarray) -> np.ndarray:
    """Return bounds for a likelihood: below what is detected, where that is known."""
    censored = bounds.copy()
    if DETECTION in ds:
        limits = ds[DETECTION].values
        # noise decides which pulls below the limit are read; the law would take the few that are for all
        is_limit = (bounds[0] < bounds[1]) | (bounds[1] < limits)
        is_below = is_limit & np.isfinite(bounds[1]) & np.isfinite(limits)
        censored[0, is_below] = 0.0
        censored[1, is_below] = limits[is_below]
    return censored


def sample_bounds(ds: xr.Dataset, name: str) -> np.ndarray:
    """Return the ends (2, …) between which the values of a variable lie: equal where known, NaN where missing."""
    values = np.asarray(ds[name].values, dtype=float)
    bounds = np.array([values, values])
    limits = [limit for limit in (AT_MOST, AT_LEAST) if limit in ds and ds[limit].dims == ds[name].dims]
    for limit in limits if name == "pull_off_force" else ():
        is_limit = np.isnan(values) & np.isfinite(ds[limit].values)
        end = ds[limit].values[is_limit]
        bounds[:, is_limit] = (0.0 * end, end) if limit == AT_MOST else (end, np.inf + end)
    return bounds


def limit_attributes(bounds: np.ndarray | None) -> dict[str, float]:
    """Return the `LIMITS` of samples, those that there are: empty if all values are known."""
    if bounds is None:
        return {}
    is_open = np.isinf(bounds[1])
    is_below = (bounds[0] < bounds[1]) & ~is_open
    attributes: dict[str, float] = {}
    if is_below.any():
        attributes |= {"limits_below": int(is_below.sum()), "largest_limit": float(bounds[1][is_below].max())}
    if is_open.any():
        attributes |= {"limits_above": int(is_open.sum()), "least_limit": float(bounds[0][is_open].min())}
    return attributes


def at_first_preload(ds: Any) -> Any:
    """Return a result at its first preload, if it has several."""
    return ds.isel(preload=0) if "preload" in ds.dims else ds


def unequal_shares(array: xr.Dataset | xr.DataArray) -> xr.DataArray | None:
    """Return the weights of places, or None if there are none or all are equal.

    They are the shares of particles that rest at the places, else the shares of the area off and on debris. They have
    no coordinates, which each operation would compare.
    """
    coords = array.coords.variables
    if SHARE in coords:
        weights = coords[SHARE].astype(float)
    elif has_debris_flags(array):
        on_debris = coords["on_debris"].astype(bool)
        debris = coords["debris_share"]
        debris_places = on_debris.sum("subregion")
        clean_places = on_debris.sizes["subregion"] - debris_places
        weights = on_debris * debris / debris_places.clip(min=1) + ~on_debris * (1 - debris) / clean_places.clip(min=1)
    else:
        return None
    # shares that differ by less, relative to the largest, are equal
    is_equal = np.ptp(weights.values) <= 1e-9 * weights.values.max()
    return None if is_equal or not set(weights.dims) <= set(array.dims) else xr.DataArray(weights)


def has_debris_flags(array: xr.Dataset | xr.DataArray) -> bool:
    """Return whether it is known which places are on debris, and on which share of the area it is touched."""
    return {"on_debris", "debris_share"} <= set(array.coords) and "subregion" in array["on_debris"].dims


def shares(ds: xr.Dataset | xr.DataArray) -> xr.DataArray:
    """Return the weights of places, equal ones if they have no shares."""
    weights = unequal_shares(ds)
    return xr.ones_like(ds["subregion"], float) if weights is None else weights


def place_numbers(ds: xr.Dataset) -> np.ndarray:
    """Return the number of each sample's place; the random surfaces of one place share its number."""
    if not set(PLACES["subregion"]) <= set(ds.coords):
        return np.arange(ds.sizes["subregion"])
    return pd.MultiIndex.from_arrays([ds[axis].values for axis in PLACES["subregion"]]).factorize()[0]


def place_order(places: Any, solved: Any) -> list[int | None]:
    """Return the index of each place among those of another result, None for a place that it has not."""
    positions = [zip(*(ds[axis].values.tolist() for axis in PLACES["subregion"])) for ds in (places, solved)]
    order = {position: index for index, position in enumerate(positions[1])}
    return [order.get(position) for position in positions[0]]


def first_surface_of_each_place(ds: xr.Dataset) -> xr.Dataset:
    """Return places with the first of the random surfaces of each."""
    return ds.isel(subregion=np.unique(place_numbers(ds), return_index=True)[1])


def counted_equally(array: Any) -> Any:
    """Return places that count equally, also those on debris."""
    return array.drop_vars([SHARE, "debris_share"], errors="ignore")


def weighted_by_landing_share(array: Any) -> Any:
    """Return values weighted by the shares of their places if these differ, else the values."""
    weights = unequal_shares(array)
    return array if weights is None else array.weighted(weights)


def mean_of_places(array: Any) -> float:
    """Return the mean of all values, weighted as by `weighted_by_landing_share`."""
    return float(_weighted_values(array).mean())


def quantile_of_places(array: Any, share: Any) -> np.ndarray:
    """Return quantiles of all values, weighted as by `weighted_by_landing_share`."""
    return _weighted_values(array).quantile(share).values


def deviation_of_places(array: Any) -> float:
    """Return the `standard_deviation` of all values."""
    return float(standard_deviation(xr.DataArray(array.variable), weights=unequal_shares(array)))


def _weighted_values(array: Any) -> Any:
    """Return values as `weighted_by_landing_share`, without coordinates, which each operation would compare."""
    values = xr.DataArray(array.variable)
    weights = unequal_shares(array)
    return values if weights is None else values.weighted(weights)


def standard_deviation(array: Any, dim: Any = None, weights: xr.DataArray | None = None) -> xr.DataArray:
    """Return the standard deviation with n − 1; for weighted values n is Kish's effective number.

    The weights are the shares of the places by default. The variance is unbiased: that of weighted values about their
    own mean is too small by 1 − 1/n on average.
    """
    weights = unequal_shares(array) if weights is None else weights
    if weights is None:
        return array.std(dim, ddof=1)
    counted = weights * array.notnull()
    effective = counted.sum(dim) ** 2 / (counted**2).sum(dim)
    return array.weighted(weights).std(dim) * np.sqrt(effective / (effective - 1).clip(min=1e-12))


def refuse_several(ds: xr.Dataset) -> None:
    """Raise for pull-off forces of several scans or conditions, with advice on how to select or pool them."""
    force = ds.get("pull_off_force", xr.DataArray())
    others = [str(dim) for dim in force.dims if dim not in ("subregion", "x", "y")]
    if others:
        ways = ", ".join(f"{dim}=0" for dim in others)
        pooling = "bootstrap(statistics=['mean']) of its pull_off"
        if "scan" in others:
            pooling = "statistics.pooled(pull, 'pull_off_force')"
        raise Refusal(
            "", "one condition", f"several along {', '.join(others)}", f"take one by isel({ways}), or {pooling}"
        )


def without_weights(sample: Samples, verb: str) -> Samples:
    """Return samples without weights, with a warning if they differed."""
    if sample.weights is not None:
        warn(
            f"{verb}: all places count equally here, although they represent unequal shares (of the particles at rest, "
            "or of the area with and without debris); means and their intervals use the shares"
        )
    return sample._replace(weights=None)


def warn_of_missing(name: str, missing: int, total: int, why: str | None = None) -> None:
    """Warn if samples are missing."""
    if missing:
        reason = f" ({why})" if why else ""
        warn(
            f"{name}: computed from {total - missing} of {total} samples, the others are missing{reason}",
            IncompleteResult,
        )


def forces_of_one_condition(ds: Any, what: str) -> xr.Dataset:
    """Return pull-off forces; raise for other Datasets, and for several conditions, such as loads."""
    ds = schema.validate(ds, "forces", what)
    values = np.unique(ds.coords.get(CONDITION, ()))
    if values.size > 1:
        name = ds.attrs.get(CONDITION, CONDITION)
        listed = ", ".join(f"{value:g}" for value in values[:8])
        raise Refusal(
            what,
            "one condition",
            f"{values.size} values of {name!r}: {listed}",
            f"select one, measured.where(measured.condition == {values[0]:g}, drop=True)",
        )
    return ds


def with_limits(ds: xr.Dataset, *names: str) -> xr.Dataset:
    """Return variables of a Dataset alone, pull-off forces with their limits."""
    limits = [limit for limit in (AT_MOST, AT_LEAST, DETECTION) if limit in ds and "pull_off_force" in names]
    return ds[[*names, *limits]]


def map_samples(ds: xr.Dataset, *names: str) -> xr.Dataset:
    """Stack variables along ``x`` and ``y`` alone, such as a pull-off at every pixel, to samples along subregions."""
    if any(name not in ds or set(ds[name].dims) != {"x", "y"} for name in names or ds.data_vars):
        return ds
    return ds.stack(subregion=("x", "y"), create_index=False).rename(x="subregion_x", y="subregion_y")


def sample_dimension(ds: xr.Dataset, name: str) -> str:
    """Return the only dimension of a variable's samples; raise if there is none or more than one."""
    if name not in ds:
        raise Refusal("", f"one of {', '.join(map(str, ds.data_vars))}", f"{name!r}{did_you_mean(name, ds.data_vars)}")
    if len(ds[name].dims) != 1 or ds[name].dims[0] not in SAMPLES:
        raise Refusal(
            name,
            f"one dimension, {' or '.join(SAMPLES)}, or a map along x and y",
            tuple(ds[name].dims),
            "select first, for example ds.sel(delta=10, method='nearest')",
        )
    return str(ds[name].dims[0])


def other_dimensions(ds: xr.Dataset, name: str) -> list[str]:
    """Return the dimensions of a variable besides its samples; empty if it has no samples."""
    if name not in ds:
        return []
    dims = [str(dim) for dim in ds[name].dims]
    sampled = ["x", "y"] if {"x", "y"} <= set(dims) else [dim for dim in dims if dim in SAMPLES]
    return [dim for dim in dims if dim not in sampled] if sampled else []


def density_units(units: str) -> str:
    """Return the units of a density over ``units``."""
    if units == "1":
        return units
    above, _, below = units.partition("/")
    simple = above.isalpha() or re.fullmatch(r"[A-Za-z]+\^\d", above)
    return f"{below}/{above if simple else f'({above})'}" if below else f"1/{above if simple else f'({above})'}"
