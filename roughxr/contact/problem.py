"""On the way down: a scan, its pair and the options of a solve, read once into plain numbers.

A `Problem` holds what all contact centres share. A `Place` holds what one centre's task is given: the pixels around it.
In the task, `surface_at` turns a place into a `Surface`: the undeformed separation on the cells of the solve.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import regions, schema
from ..jobs.lazy import is_lazy
from ..kernels.halfspace.separation import PROFILES, map_separation, sphere_separation
from ..materials import indenter_map

#: Where delta = 0.
DATUMS = ("highest_peak", "first_contact")

#: What is said where displacements are to suit heights that are not in memory, and how many displacements suit.
NOT_LOADED = "delta: expected displacements in nm, since the heights are not loaded; give them, or load the scan"
_COUNT = 16


class Indenter(NamedTuple):
    """What is pressed into the surface: a sphere or a height map."""

    radius: float  # nm, NaN of a map
    profile: int
    map: tuple[np.ndarray, np.ndarray, np.ndarray] | None  # x, y from the contact centre and height, nm

    def separation(self, height: np.ndarray, datum: float, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the undeformed separation, nm, at x, y (nm) from the contact centre; inf beyond the indenter."""
        if self.map is None:
            return sphere_separation(height, datum, x, y, self.radius, self.profile)
        return map_separation(height, datum, x, y, *self.map)

    def reach(self, depth: float) -> float:
        """Return the half-width, nm, within which the indenter lies less than ``depth`` above its lowest point."""
        if self.map is None:
            return float(np.sqrt(2 * self.radius * max(depth, 0.0)))
        x, y, height = self.map
        near = np.argwhere(height.max() - height < depth)
        return float(max(np.abs(x[near[:, 0]]).max(), np.abs(y[near[:, 1]]).max())) if near.size else 0.0


class Problem(NamedTuple):
    """What all contact centres share."""

    steps: np.ndarray  # displacements (nm) or loads (nN), ascending
    by_load: bool
    first_contact: bool  # the datum is each centre's own first contact
    pixel: float  # nm, of the scan
    refine: int  # cells of the solve along a side of a pixel
    contact_modulus: float  # GPa
    indenter: Indenter
    hardness: float = np.inf  # GPa, inf where none is known
    yielding: bool = False  # whether what presses harder yields, or is only told of

    @property
    def dx(self) -> float:
        """Side of the cells of the solve, nm."""
        return self.pixel / self.refine


def read_problem(
    ds: xr.Dataset,
    positions: xr.Dataset,
    *,
    delta: Any = None,
    load: Any = None,
    datum: str,
    profile: str,
    refine: int = 1,
    yielding: bool = True,
) -> Problem:
    """Return the problem of a scan with its pair, or say what is wrong with it."""
    if delta is not None and load is not None:
        raise ValueError("expected either delta or load, found both")
    if delta is None and load is None:
        delta = default_deltas(ds, positions, indenter_of(ds, profile), datum)
    by_load = delta is None
    steps = schema.ascending(load, "nN", "load") if by_load else schema.ascending(delta, "nm", "delta")
    if by_load and steps[0] <= 0:
        raise ValueError(f"load: expected positive loads, found {steps[0]:g} nN")
    schema.one_of(datum, DATUMS, "datum")
    (modulus,) = schema.pair(ds, "contact_modulus")
    hardness, assigned = hardness_of(ds)
    return Problem(
        steps=steps,
        by_load=by_load,
        first_contact=datum == "first_contact",
        pixel=schema.square_pixel(ds),
        refine=refine,
        contact_modulus=modulus,
        indenter=indenter_of(ds, profile),
        hardness=hardness,
        yielding=assigned and yielding,
    )


def hardness_of(ds: xr.Dataset) -> tuple[float, bool]:
    """Return the hardness (GPa) that is assigned, or else estimated, or else inf, and whether it is assigned."""
    names = [name for name in ("hardness", "hardness_estimate") if name in ds.coords]
    return (float(ds[names[0]]) if names else np.inf), "hardness" in ds.coords


def indenter_of(ds: xr.Dataset, profile: str = "sphere") -> Indenter:
    """Return the indenter that is assigned to a scan."""
    schema.one_of(profile, PROFILES, "profile")
    found = indenter_map(ds)
    radius = np.nan if found else schema.pair(ds, "sphere_radius")[0]
    return Indenter(radius, PROFILES[profile], found)


def default_deltas(ds: xr.Dataset, positions: xr.Dataset, indenter: Indenter, datum: str) -> np.ndarray:
    """Return displacements, nm, that suit the scan: evenly up to where every centre is touched, most of them pressed.

    From the highest peak, up to twice the median depth at which the indenter first touches, and to a fifth beyond the
    deepest; from first contact, as far as the median lies below the peak. At least by the heights' standard deviation.
    """
    if is_lazy(ds):
        raise ValueError(NOT_LOADED)
    touches, spread = first_touches(ds, positions, indenter), float(ds["height"].values.std())
    middle = float(np.median(touches))
    last = max(2 * middle, 1.2 * float(touches.max()), spread) if datum == "highest_peak" else max(middle, spread)
    return np.round(np.linspace(last / _COUNT, last, _COUNT), 3) if last > 0 else np.linspace(1 / _COUNT, 1, _COUNT)


def first_touches(ds: xr.Dataset, positions: xr.Dataset, indenter: Indenter) -> np.ndarray:
    """Return the depth (nm) below the highest point at which the indenter first touches, at each centre."""
    reach = indenter.reach(float(np.ptp(schema.complete(ds)["height"].values)))
    found, _ = places(ds, positions, reach)
    pixel = schema.square_pixel(ds)
    bare = Problem(np.zeros(1), False, False, pixel, 1, np.nan, indenter)
    return np.array([surface_at(place, bare).separation.min() for place in found])


def deepest(ds: xr.Dataset, problem: Problem) -> float:
    """Return how deep (nm) below the datum the indenter can come; inf where the heights must be known and are not.

    From its first contact, or under a load, it starts no lower than the lowest height; and a surface with gaps holds
    it no better than a flat one, which Hertz's sphere enters by (3 F/(4 E* √R))^{2/3}, and one that yields by at most
    F/(2π R H) more.
    """
    last = float(problem.steps[-1])
    if not problem.by_load and not problem.first_contact:
        return last
    if is_lazy(ds) or (problem.by_load and problem.indenter.map):
        return np.inf
    if problem.by_load:
        radius, load = problem.indenter.radius, last
        last = (0.75 * load / (problem.contact_modulus * np.sqrt(radius))) ** (2 / 3)
        last += load / (2 * np.pi * radius * problem.hardness) if problem.yielding else 0.0
    return float(np.ptp(ds["height"].values)) + last


def need_heights(ds: xr.Dataset, problem: Problem) -> None:
    """Refuse fields on windows whose size hangs on heights that are not loaded."""
    if is_lazy(ds) and (problem.by_load or problem.first_contact):
        raise ValueError(
            "fields with a load or with datum='first_contact' need the height range: load the scan first (ds.load())"
        )


class Place(NamedTuple):
    """The pixels around one contact centre; heights may still be a dask array."""

    height: Any  # (nx, ny), nm
    datum: Any  # nm, the highest point of the whole scan
    window: regions.Window
    ends: tuple[bool, bool, bool, bool]  # whether the scan ends at the window's first and last row and column


def places(ds: xr.Dataset, positions: xr.Dataset, reach: float) -> tuple[list[Place], tuple[int, int]]:
    """Return the place of each contact centre, and the shape in pixels of a window that no edge cuts off."""
    x_min, x_max, y_min, y_max = regions.extent(ds)
    windows, shape = regions.windows(ds, positions, min(reach, float(np.hypot(x_max - x_min, y_max - y_min))))
    height = ds["height"].data
    datum, (nx, ny) = height.max(), height.shape
    return [
        Place(
            height[w.rows, w.columns],
            datum,
            w,
            (w.rows.start == 0, w.rows.stop == nx, w.columns.start == 0, w.columns.stop == ny),
        )
        for w in windows
    ], shape


class Surface(NamedTuple):
    """The surface and the indenter over one contact centre, undeformed, on the cells of the solve."""

    separation: np.ndarray  # (nx, ny), nm below the datum; inf where there is nothing to touch
    zero: float  # displacement counted as zero, nm below the datum
    unknown_from: float  # displacement (nm below the datum) from which contact reaches the scan's or the map's edge
    corner: tuple[int, int]  # of these cells in the full window


def surface_at(place: Place, problem: Problem) -> Surface:
    """Return the surface at one place."""
    height, datum = np.ascontiguousarray(place.height, dtype=float), float(place.datum)
    n, fine = problem.refine, refined(height, problem.refine)
    x, y = (
        first + problem.dx * (n * missing + 0.5 * (1 - n) + np.arange(size))
        for first, missing, size in zip(place.window.origin, place.window.missing, fine.shape)
    )
    separation = problem.indenter.separation(fine, datum, x, y)
    zero = float(separation.min()) if problem.first_contact and separation.size else 0.0
    unknown_from = min(_lowest_at_ends(separation, place.ends), _lowest_at_rim(separation, problem.indenter))
    return Surface(separation, zero, unknown_from, tuple(n * k for k in place.window.missing))


def refined(height: np.ndarray, n: int) -> np.ndarray:
    """Return the heights on n × n cells in place of each pixel, by splines through the pixel centres."""
    if n == 1:
        return height
    from scipy.interpolate import RectBivariateSpline

    coarse = [np.arange(size) for size in height.shape]
    fine = [(np.arange(size * n) + 0.5) / n - 0.5 for size in height.shape]
    order = [min(3, size - 1) for size in height.shape]
    return np.ascontiguousarray(RectBivariateSpline(*coarse, height, kx=order[0], ky=order[1])(*fine))


def _lowest_at_ends(separation: np.ndarray, ends: tuple[bool, bool, bool, bool]) -> float:
    """Return the least separation along the sides of the window at which the scan ends."""
    sides = separation[:1], separation[-1:], separation[:, :1], separation[:, -1:]
    return min((side.min(initial=np.inf) for end, side in zip(ends, sides) if end), default=np.inf)


def _lowest_at_rim(separation: np.ndarray, indenter: Indenter) -> float:
    """Return the least separation along the rim of an indenter's map: beyond it nothing is known of the indenter."""
    if indenter.map is None:
        return np.inf
    known = np.pad(np.isfinite(separation), 1, constant_values=True)
    inside = known[:-2, 1:-1] & known[2:, 1:-1] & known[1:-1, :-2] & known[1:-1, 2:]
    return float(separation[~inside].min(initial=np.inf))
