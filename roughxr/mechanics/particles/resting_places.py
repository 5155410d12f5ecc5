"""`resting`: resting positions of a free sphere, and the share of particles at each."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..kernels.halfspace.separation import distance_at_height
from ..kernels.topography import basins, dilation
from ..kernels.topography.interpolation import band_limited
from ..scans import regions
from ..vocabulary import schema
from ..vocabulary.text import warn
from ..vocabulary.units import Places


@schema.verb("scan")
def resting(
    ds: xr.Dataset,
    *,
    landings: Places = None,
    on: xr.Dataset | None = None,
) -> xr.Dataset:
    """Return the resting positions of a sphere of the assigned radius, with the share of spheres at each.

    Parameters
    ----------
    ds : Dataset
        A scan with an assigned sphere, loaded now. Needs some 130 bytes of memory a pixel.
    landings : (int, int), optional
        Grid of landing places: return only the positions reached from there, with shares of their number. By default
        spheres land everywhere, and shares are of the area.
    on : Dataset, optional
        A catalogue of the scan's asperities. Each resting position is then moved to the nearest resting position on
        their vertices, where `rolling` and `superpose` put the sphere, if there is one near.

    Returns
    -------
    Dataset
        Along ``subregion``, to be passed to any verb as ``subregions``: coordinates ``subregion_x``, ``subregion_y``
        (nm) and ``landing_share``, their weight in all statistics; ``rest_height`` of the sphere's lowest point (nm),
        ``supports``, the number of supporting summits (at most 8), and ``support_x``, ``support_y`` of each (nm); and
        ``truncated``, where the scan's edge is nearer than the farthest support. The attribute ``share_off_scan`` is
        the share of spheres that roll off the scan. Empty, with a warning, where there is no resting position.

    Raises
    ------
    ValueError
        If no sphere is assigned, or the scan has missing pixels.

    Notes
    -----
    Bodies are rigid here, and the sphere rolls down without slip, inertia or adhesion. Heights between pixels are
    interpolated as in the simulations, without wavelengths shorter than two pixels.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> places = scan.contact.resting()
    >>> bool((places.supports >= 3).mean() > 0.9), round(float(places.landing_share.sum()), 6)
    (True, 1.0)
    >>> roughxr.rolling(scan, directions=8, subregions=places.isel(subregion=[0, 1])).sizes["subregion"]
    2
    """
    z, surface = _dilated_surface(ds, schema.sphere_radius(ds))
    if landings is None:
        minima, spheres = basins.drainage_basins(z, surface.pixel)
        start = np.array(surface.first) + minima * np.array(surface.pixel)
    else:
        start = regions.points(regions.centres(ds, landings))
        spheres = np.full(len(start), 1 / len(start))
    # resting positions closer than this (pixels) are one
    places, share = _distinct(basins.settle(surface, start), spheres, 0.05 * max(surface.pixel))
    out = _described(ds, surface, places)
    out = out.assign_coords(landing_share=("subregion", share / max(share.sum(), 1e-300)))
    if on is not None:
        out = _move_to_vertices(out, schema.validate(on, "asperities"), surface)
    out = out.assign_coords(schema.pair_coordinates(ds))
    out.attrs = {"share_off_scan": float(1 - share.sum())}
    if out.sizes["subregion"] == 0:
        out.attrs["missing"] = "no resting position: from every pixel the sphere rolls off the scan"
        warn(out.attrs["missing"])
    if landings is not None:
        out.attrs["landings"] = len(start)
    return schema.label(out)


def are_resting_positions(places: Any) -> bool:
    """Return whether places are resting positions reached from a grid of landings."""
    return isinstance(places, xr.Dataset) and "rest_height" in places and "landings" in places.attrs


def resettled(ds: xr.Dataset, places: xr.Dataset) -> xr.Dataset:
    """Return the places to which the sphere of this pair rolls from former resting positions, NaN off the scan."""
    scan = schema.validate(ds, "scan")
    _, surface = _dilated_surface(scan, schema.sphere_radius(scan))
    return places.assign_coords(_coordinates(basins.settle(surface, regions.points(places))))


def _dilated_surface(scan: xr.Dataset, radius: float) -> tuple[np.ndarray, basins.DilatedSurface]:
    """Return the height (nm) of a sphere's lowest point over a scan on finer cells, and the surface it may touch."""
    height = schema.finite(scan["height"].values)
    # cells along a side of a pixel; heights are interpolated as in the simulations
    refine = 2
    cells = (np.arange(refine) + 0.5) / refine - 0.5
    height = band_limited(height, refine)
    x, y = (
        (scan[axis].values.astype(float)[:, None] + pixel * cells).ravel()
        for axis, pixel in zip("xy", schema.pixel(scan))
    )
    pixel = float(x[1] - x[0]), float(y[1] - y[0])
    ball = dilation.Ball(radius, 0.5 * pixel[0], 0.5 * pixel[1])
    reach = distance_at_height(float(np.ptp(height)), radius)
    return _surface_of_patches(dilation.patches(height, x, y, pixel, radius, reach), x, y, ball)


def _surface_of_patches(
    patches: np.ndarray, x: np.ndarray, y: np.ndarray, ball: dilation.Ball
) -> tuple[np.ndarray, basins.DilatedSurface]:
    """Return the height (nm) of a sphere's lowest point over patches, at pixel centres (nm), and their surface."""
    z, bounds, lists = dilation.dilation(patches, x, y, ball)
    pixel = float(x[1] - x[0]), float(y[1] - y[0])
    return z, basins.DilatedSurface(z.shape, (float(x[0]), float(y[0])), pixel, patches, bounds, lists, ball)


def _distinct(rolled: np.ndarray, spheres: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (x, y, height) farther apart than a distance (nm), and the share of spheres at each."""
    on_scan = ~np.isnan(rolled[:, 2])
    rolled = rolled[on_scan]
    if not len(rolled):
        return rolled, spheres[on_scan]
    i, j = cKDTree(rolled[:, :2]).query_pairs(distance, output_type="ndarray").T
    equal = coo_array((np.ones(i.size), (i, j)), (len(rolled), len(rolled)))
    number = connected_components(equal, directed=False)[1]
    return rolled[np.unique(number, return_index=True)[1]], np.bincount(number, spheres[on_scan])


def _described(scan: xr.Dataset, surface: basins.DilatedSurface, places: np.ndarray) -> xr.Dataset:
    """Return resting positions (x, y, height) with their supports."""
    x, y, height = places.T
    out = xr.Dataset(coords={"subregion": np.arange(x.size), **_coordinates(places)})
    # motion of the sphere, in pixels, within which a summit counts as a support
    number, at = basins.supports(places, surface, 0.05)
    at = at[:, : max(int(number.max(initial=0)), 1)]
    out = out.assign(rest_height=("subregion", height), supports=("subregion", number))
    out = out.assign({f"support_{axis}": (("subregion", "support"), at[:, :, k]) for k, axis in enumerate("xy")})
    x_low, x_high, y_low, y_high = regions.extent(scan)
    off = np.min([x - x_low, x_high - x, y - y_low, y_high - y], axis=0, initial=np.inf)
    far = np.nan_to_num(np.hypot(at[:, :, 0] - x[:, None], at[:, :, 1] - y[:, None])).max(axis=1, initial=0.0)
    return out.assign(truncated=("subregion", off < far))


def _move_to_vertices(out: xr.Dataset, catalogue: xr.Dataset, surface: basins.DilatedSurface) -> xr.Dataset:
    """Move resting positions to the nearest resting positions on the vertices of asperities."""
    summits = catalogue.isel(asperity=(catalogue["curvature_min"] > 0).values)
    rows = np.zeros((summits.sizes["asperity"], dilation.RISE + 1))
    for column, name in ((dilation.X, "x"), (dilation.Y, "y"), (dilation.H, "height")):
        rows[:, column] = summits[name].values
    before = np.column_stack([regions.points(out), out["rest_height"].values])
    x, y = (first + step * np.arange(n) for first, step, n in zip(surface.first, surface.pixel, surface.shape))
    _, vertices = _surface_of_patches(rows, x, y, dilation.Ball(surface.ball.radius, 0.0, 0.0))
    moved = basins.settle(vertices, before[:, :2])
    # largest distance (cells) between a resting position and the one on the vertices of asperities
    farthest = 20.0 * max(surface.pixel)
    is_near = (np.abs(moved - before) <= farthest).all(axis=1, keepdims=True)
    moved = np.where(is_near, moved, before)
    return out.assign_coords(_coordinates(moved)).assign(rest_height=("subregion", moved[:, 2]))


def _coordinates(places: np.ndarray) -> dict[str, tuple[str, np.ndarray]]:
    """Return the coordinates of contact centres at positions (x, y, …)."""
    return {"subregion_x": ("subregion", places[:, 0]), "subregion_y": ("subregion", places[:, 1])}
