"""The specimen: a validated scan in memory with its pair of bodies, as the solvers take it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr

from .bodies.pair import indenter_map
from .bodies.pair_record import Pair, read_pair
from .jobs.spread import is_lazy
from .kernels.halfspace.separation import map_separation, sphere_separation
from .kernels.topography import peaks
from .scans import regions, wavelength
from .scans.editing import on_square_pixels
from .vocabulary import schema
from .vocabulary.numbers import format_number
from .vocabulary.refusal import Refusal
from .vocabulary.text import warn
from .vocabulary.units import Places


class Indenter(NamedTuple):
    """The body pressed into the surface: a sphere or a height map."""

    radius: float  # nm, NaN for a map
    map: tuple[np.ndarray, np.ndarray, np.ndarray] | None  # x, y from the contact centre and height, nm

    def separation(self, height: np.ndarray, datum: float, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the undeformed separation, nm, at x, y (nm) from the contact centre; inf beyond the indenter."""
        if self.map is None:
            return sphere_separation(height, datum, x, y, self.radius)
        return map_separation(height, datum, x, y, *self.map)

    @property
    def mean_radius(self) -> float:
        """Radius, nm; of a map, that of the paraboloid of its mean depth."""
        if self.map is None:
            return self.radius
        x, y, height = self.map
        r2 = x[:, None] ** 2 + y**2
        depth = float((height.max() - height).mean())
        return float(r2.mean()) / (2 * depth) if depth > 0 else float(np.sqrt(r2.max()))

    def half_width(self, depth: float) -> float:
        """Return the half-width, nm, within which the indenter lies less than ``depth`` above its lowest point."""
        if self.map is None:
            return float(np.sqrt(2 * self.radius * max(depth, 0.0)))
        x, y, height = self.map
        near = np.argwhere(height.max() - height < depth)
        return float(max(np.abs(x[near[:, 0]]).max(), np.abs(y[near[:, 1]]).max())) if near.size else 0.0


@dataclass(frozen=True, eq=False)
class Specimen:
    """A valid scan in memory with its pair of bodies; derived values are computed once."""

    scan: xr.Dataset
    lazy: bool = False  # whether the given scan was lazy; then results are computed later

    @cached_property
    def bodies(self) -> xr.Dataset:
        """Everything but the heights: axes, pair and indenter, contact centres, history."""
        return self.scan.drop_vars("height")

    @cached_property
    def heights(self) -> np.ndarray:
        """Heights (nx, ny), nm; raises if pixels are missing."""
        return schema.finite(self.scan["height"].values)

    @cached_property
    def pixel(self) -> float:
        """Side of the pixels, nm; raises if they are not square."""
        return schema.square_pixel(self.bodies)

    @cached_property
    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Centres of the pixels along x and y, nm."""
        return self.scan["x"].values, self.scan["y"].values

    @cached_property
    def sides(self) -> tuple[float, float]:
        """Sides of the scan along x and y, nm."""
        return regions.sides(self.scan)

    @cached_property
    def pair(self) -> Pair:
        """The pair of bodies as plain numbers, NaN where a value is not assigned."""
        return read_pair(self.bodies)

    @cached_property
    def indenter(self) -> Indenter:
        """The assigned sphere or map."""
        height_map = indenter_map(self.bodies)
        if height_map:
            return Indenter(np.nan, height_map)
        self.pair.need("sphere_radius")
        return Indenter(self.pair.sphere_radius, None)

    @cached_property
    def shortest_wavelength(self) -> float:
        """Shortest wavelength (nm) that the scan resolves."""
        return wavelength.spectral_measures(self.scan["height"].values, schema.pixel(self.bodies)).shortest

    def centres(self, subregions: Places) -> xr.Dataset:
        """Return contact centres, see `regions.centres`."""
        return regions.centres_of(self.scan, subregions)


def need_wide_scan(heights: np.ndarray, sides: tuple[float, float], radius: float) -> None:
    """Raise where a sphere (of NaN nm: none) can touch the surface beyond the scan.

    That is where its cap over the whole scan is lower than the standard deviation of the heights. A single bump, and
    summits within edges below the mean height, are no part of a larger surface.
    """
    width = 2 * Indenter(radius, None).half_width(float(heights.std()))
    shown = min(sides)
    edges = heights[0], heights[-1], heights[:, 0], heights[:, -1]
    if max(edge.max() for edge in edges) <= heights.mean():
        return
    if width > shown and peaks.search(heights).ix.size > 1:
        raise Refusal(
            "sphere_radius",
            f"a sphere that touches no more than the scan's {format_number(shown, 'nm')}",
            f"{format_number(radius, 'nm')}, which touches this roughness over {format_number(width, 'nm')}",
            "take a scan at least as wide as that, or a smaller sphere",
        )


def ask_about_depth(largest: float, radius: float, heights: np.ndarray) -> None:
    """Warn where the largest displacement (nm) exceeds a tenth of the sphere's radius and the range of heights."""
    if largest and largest > radius / 10 + float(np.ptp(heights)):
        warn(
            f"{format_number(largest, 'nm')} is more than a tenth of the sphere's radius, "
            f"{format_number(radius, 'nm')}: is this intended? (contacts are computed as on half spaces; plain numbers "
            "are in nm)",
            what="delta",
        )


def specimen_of(given: xr.Dataset | Specimen) -> Specimen:
    """Return the specimen of a scan, on square pixels; a specimen is returned unchanged."""
    if isinstance(given, Specimen):
        return given
    scan = schema.validate(given, "scan")
    return Specimen(on_square_pixels(schema.in_memory(scan)), is_lazy(scan))
