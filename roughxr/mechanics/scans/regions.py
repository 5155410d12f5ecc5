"""Contact centres on a scan, and the window of pixels around each."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..vocabulary import schema
from ..vocabulary.calls import checked_call
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Places, carries_units, is_whole, magnitude
from .landings import debris_landings

__all__ = ["centres", "extent"]


class Window(NamedTuple):
    """The pixels around one centre: index ranges on the scan, and their position in the full window."""

    rows: slice
    columns: slice
    #: Number of pixels of the full window before the scan begins, along x and y (> 0 at the scan's edge only).
    missing: tuple[int, int]
    #: Offsets from the contact centre, nm, of the first pixel in the full window.
    origin: tuple[float, float]


@checked_call
def centres(ds: xr.Dataset, subregions: Places = None) -> xr.Dataset:
    """Return the contact centres as coordinates along ``subregion``.

    Parameters
    ----------
    ds : Dataset
        A scan, or any Dataset with ``subregion_x`` and ``subregion_y``.
    subregions : (int, int), (array, array) or Dataset, optional
        Two whole numbers: the centres of a grid of this many tiles along x and y. Two arrays: x and y of the centres,
        nm. A Dataset: its centres, from `resting` with their shares of particles. By default the centres on ``ds``,
        else one in its middle.

    Returns
    -------
    Dataset
        Coordinates ``subregion`` (number), ``subregion_x`` and ``subregion_y`` (nm). Of a scan in memory with a sphere
        also ``on_debris``, whether the sphere first touches debris there, and ``debris_share``, the share of the area
        where it does: statistics weight the places on and off debris by it. Debris is higher than the median height of
        first touch by more than eight median absolute deviations.

    Examples
    --------
    >>> import roughxr
    >>> roughxr.scans.regions.centres(roughxr.open_sample("glass"), (8, 8)).sizes["subregion"]
    64
    """
    return centres_of(schema.entered_dataset(ds), subregions)


def centres_of(ds: xr.Dataset, subregions: Places) -> xr.Dataset:
    """Return the contact centres on a valid scan, see `centres`."""
    if subregions is None:
        subregions = ds if "subregion_x" in ds.coords else (1, 1)
    if isinstance(subregions, xr.Dataset):
        subregions = schema.validate(subregions, "places", "subregions")
        if subregions["subregion_x"].size == 0:
            raise Refusal("subregions", "at least one contact centre", "none")
    edges = edges_of(ds)
    # largest number of tiles along one axis, where the number of pixels is not known
    x, y = _positions(subregions, edges, (ds.sizes["x"], ds.sizes["y"]) if "x" in ds.dims else (65536,) * 2)
    _refuse_outside(x, y, edges)
    coords: dict[str, Any] = {"subregion": np.arange(x.size)}
    coords |= {"subregion_x": ("subregion", x), "subregion_y": ("subregion", y)}
    if isinstance(subregions, xr.Dataset) and "landing_share" in subregions.coords:
        coords["landing_share"] = "subregion", np.atleast_1d(subregions["landing_share"].values)
    elif schema.kind_of(ds) == "scan" and not ds["height"].chunks and "sphere_radius" in ds.coords:
        height = ds["height"].variable.transpose("x", "y").values
        axes = (ds["x"].values, ds["y"].values)
        share, flags = debris_landings(height, axes, (x, y), float(ds["sphere_radius"]))
        coords |= {"on_debris": ("subregion", flags), "debris_share": share}
    return schema.label(xr.Dataset(coords=coords))


def sample(positions: xr.Dataset, count: int) -> xr.Dataset:
    """Return ``count`` of the contact centres, spread evenly over their order; all if there are fewer."""
    last = positions.sizes["subregion"] - 1
    return positions.isel(subregion=np.unique(np.linspace(0, last, count).round().astype(int)))


def points(positions: xr.Dataset) -> np.ndarray:
    """Return x and y of contact centres, (place, axis), nm."""
    return np.column_stack([positions["subregion_x"].values, positions["subregion_y"].values])


#: Scalar coordinates of a catalogue: its scan's outer edges.
EDGES = ("scan_x_min", "scan_x_max", "scan_y_min", "scan_y_max")


@checked_call
def extent(ds: xr.Dataset) -> tuple[float, float, float, float]:
    """Return the outer edges of a scan, half a pixel beyond its outermost pixel centres.

    Parameters
    ----------
    ds : Dataset
        A scan, or the catalogue of its asperities, which keeps them.

    Returns
    -------
    tuple of float
        Least and greatest x, least and greatest y, nm.

    Examples
    --------
    >>> import roughxr
    >>> roughxr.scans.regions.extent(roughxr.open_sample("glass"))
    (0.0, 5000.0, 0.0, 5000.0)
    """
    return edges_of(schema.entered_dataset(ds))


def edges_of(ds: xr.Dataset) -> tuple[float, float, float, float]:
    """Return the outer edges of a valid scan or catalogue, see `extent`."""
    if "x" not in ds.dims:
        missing = [name for name in EDGES if name not in ds.coords]
        if missing:
            raise Refusal(
                "asperities",
                "the scan's edges as coordinates",
                f"no {', '.join(missing)}",
                "make it by ds.contact.asperities(), or assign them in nm, ds.assign_coords(scan_x_min=0.0, …)",
            )
        x_low, x_high, y_low, y_high = (float(ds[name]) for name in EDGES)
        return x_low, x_high, y_low, y_high
    (dx, dy), x, y = schema.pixel(ds), ds["x"].values, ds["y"].values
    return float(x[0] - dx / 2), float(x[-1] + dx / 2), float(y[0] - dy / 2), float(y[-1] + dy / 2)


def sides(ds: xr.Dataset) -> tuple[float, float]:
    """Return the sides of a valid scan or catalogue along x and y, nm."""
    x_low, x_high, y_low, y_high = edges_of(ds)
    return x_high - x_low, y_high - y_low


def windows(
    axes: tuple[np.ndarray, np.ndarray], positions: xr.Dataset, reach: float
) -> tuple[list[Window], tuple[int, int]]:
    """Return each centre's window of half-width ``reach`` on pixels along x and y, and the full window's shape; nm."""
    x, y = axes
    dx, dy = ((axis[-1] - axis[0]) / (axis.size - 1) for axis in axes)
    ahead = np.ceil(np.array([reach / dx, reach / dy])).astype(int) + 1
    shape = tuple(2 * ahead + 1)
    cut = []
    for cx, cy in points(positions):
        first = [int(np.floor((c - axis[0]) / d + 0.5)) - a for c, axis, d, a in zip((cx, cy), (x, y), (dx, dy), ahead)]
        rows, columns = (slice(max(f, 0), min(f + n, axis.size)) for f, n, axis in zip(first, shape, (x, y)))
        origin = x[0] + first[0] * dx - cx, y[0] + first[1] * dy - cy
        cut.append(Window(rows, columns, (max(-first[0], 0), max(-first[1], 0)), origin))
    return cut, shape


def _positions(subregions: Any, edges: tuple, sizes: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y of the centres on a scan with these edges (nm), at most ``sizes`` tiles along the axes."""
    if isinstance(subregions, xr.Dataset):
        x, y = (np.atleast_1d(subregions[name].values.astype(float)) for name in ("subregion_x", "subregion_y"))
        return x, y
    try:
        first, second = subregions
    except (TypeError, ValueError):
        raise Refusal(
            "subregions", "a grid such as (8, 8), or two arrays of centres in nm", f"{subregions!r}"
        ) from None
    if np.ndim(first) == np.ndim(second) == 0 and not carries_units([first, second]):
        return _grid((first, second), edges, sizes)
    x, y = (np.atleast_1d(magnitude(v, "nm", "subregions")) for v in (first, second))
    if x.shape != y.shape or x.ndim != 1 or x.size == 0:
        raise Refusal("subregions", "two arrays of equal length", f"shapes {x.shape} and {y.shape}")
    return x, y


def _grid(counts: tuple[Any, Any], edges: tuple, sizes: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    for n, size, axis in zip(counts, sizes, "xy"):
        if not is_whole(n) or not 1 <= n <= size:
            raise Refusal("subregions", f"a whole number from 1 to {size} along {axis}", f"{n!r}")
    axes = [low + (np.arange(n) + 0.5) * (high - low) / n for n, low, high in zip(counts, edges[::2], edges[1::2])]
    return tuple(axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))


def _refuse_outside(x: np.ndarray, y: np.ndarray, edges: tuple) -> None:
    x_low, x_high, y_low, y_high = edges
    outside = (x < x_low) | (x > x_high) | (y < y_low) | (y > y_high)
    if outside.any():
        k = int(np.flatnonzero(outside)[0])
        raise Refusal(
            "subregions",
            f"centres on the scan, x {x_low:g} … {x_high:g}, y {y_low:g} … {y_high:g} nm",
            f"{int(outside.sum())} outside, the first at ({x[k]:g}, {y[k]:g})",
        )
