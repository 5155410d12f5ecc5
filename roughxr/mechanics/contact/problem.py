"""The input of a solver: a scan, its pair of bodies and the options, read once into plain numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from ..bodies.layer import need_computable
from ..kernels.halfspace.layered import Film
from ..kernels.halfspace.working_set import slack_of
from ..kernels.topography.interpolation import band_limited, splined
from ..scans import regions
from ..specimen import Indenter, Specimen, ask_about_depth
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Quantities

#: The number of default displacements.
_COUNT = 16


class Problem(NamedTuple):
    """The input common to all contact centres."""

    steps: np.ndarray  # displacements (nm) or loads (nN), ascending
    by_load: bool
    first_contact: bool  # the datum is each centre's own first contact
    pixel: float  # nm, of the scan
    refine: int  # cells of the solve along a side of a pixel
    contact_modulus: float  # GPa
    indenter: Indenter
    hardness: float = np.inf  # GPa, inf if unknown
    yielding: bool = False  # whether the body yields at the hardness; else only shares above it are reported
    splined: bool = False  # whether heights between the pixels are interpolated by splines, else band-limited
    layer: Film | None = None  # on the scan's body, nm
    shown: float = np.inf  # area of the scan, nm²

    @property
    def dx(self) -> float:
        """Side of the cells of the solve, nm."""
        return self.pixel / self.refine

    @property
    def film(self) -> Film | None:
        """The layer, its thickness in cells."""
        return self.layer and self.layer.on_cells(self.dx)

    @property
    def softest(self) -> float:
        """Contact modulus of the indenter with the layer or its base, the smaller of both, GPa."""
        return self.contact_modulus / (max(1.0, self.layer.softening(np.inf)) if self.layer else 1.0)

    @property
    def depth_factor(self) -> float:
        """Largest depth of touching surface over the indenter's: a thin incompressible layer rises by as much."""
        return 2.0 if slack_of(self.layer) else 1.0


def read_problem(
    specimen: Specimen,
    positions: xr.Dataset,
    *,
    delta: Quantities | None = None,
    load: Quantities | None = None,
    datum: str | None,
    refine: int = 1,
) -> Problem:
    """Return the problem of a scan, its pair and the options; raise if they do not define one."""
    if delta is not None and load is not None:
        raise Refusal("", "either delta or load", "both")
    specimen.pair.need("contact_modulus")
    is_default = delta is None and load is None
    if datum is None:
        datum = default_datum(specimen) if is_default else "highest_peak"
    if is_default:
        delta = default_deltas(specimen, positions, datum)
    by_load = delta is None
    steps = schema.ascending(load, "nN", "load") if by_load else schema.ascending(delta, "nm", "delta")
    if by_load and steps[0] <= 0:
        raise Refusal("load", "positive loads", f"{steps[0]:g} nN")
    schema.one_of(datum, schema.DATUMS, "datum")
    pair = specimen.pair
    if pair.layer is not None:
        need_computable(pair.layer, specimen.pixel * max(specimen.heights.shape), yields=pair.yields)
    return Problem(
        steps=steps,
        by_load=by_load,
        first_contact=datum == "first_contact",
        pixel=specimen.pixel,
        refine=refine,
        contact_modulus=pair.contact_modulus,
        indenter=specimen.indenter,
        hardness=pair.hardness,
        yielding=pair.yields,
        layer=pair.layer,
        shown=float(np.prod(specimen.sides)),
    )


def check_depth(specimen: Specimen, problem: Problem) -> None:
    """Warn where the largest displacement is improbable."""
    if not problem.by_load and not specimen.lazy:
        ask_about_depth(float(problem.steps[-1]), specimen.pair.sphere_radius, specimen.heights)


def default_datum(specimen: Specimen) -> str:
    """Return the datum of the default displacements: where anything attracts, each place's first contact."""
    return "first_contact" if specimen.pair.work > 0 else "highest_peak"


def default_deltas(specimen: Specimen, positions: xr.Dataset, datum: str) -> np.ndarray:
    """Return evenly spaced displacements (nm).

    From first contact: up to loads of adhesion, or one standard deviation of the heights if nothing attracts. From the
    highest peak: half beyond the median first contact, the last beyond all.
    """
    spread = float(specimen.heights.std())
    if datum == "first_contact":
        last = _adhesive_depth(specimen) or spread
        first = last / _COUNT
    else:
        touches = first_touches(specimen, positions)
        # largest default displacement over the depth of the lowest first contact
        last = max(1.2 * float(touches.max()), spread)
        first = max(last / _COUNT, 2 * float(np.median(touches)) - last)
    if last <= 0:
        return np.linspace(1 / _COUNT, 1, _COUNT)
    decimals = 3 - int(np.floor(np.log10(last)))
    return np.round(np.linspace(first, last, _COUNT), decimals)


def _adhesive_depth(specimen: Specimen) -> float:
    """Return the largest default displacement (nm) from first contact; 0 if nothing attracts, or for a map.

    Hertz's displacement under ten times the pull-off of a smooth sphere, or at a contact of three pixels in radius if
    this is larger; at most a tenth of the radius.
    """
    pair = specimen.pair
    if specimen.indenter.map or not pair.work > 0:
        return 0.0
    radius = specimen.indenter.radius
    _, modulus = pair.contact_at_pull_off(radius, pair.work)
    under_load = hertz_displacement(10 * pair.smooth_pull_off(stiff=False), radius, modulus)
    resolved = (3 * specimen.pixel) ** 2 / radius
    return min(max(under_load, resolved), radius / 10)


def hertz_displacement(load: float, radius: float, modulus: float) -> float:
    """Return the displacement (nm) of a smooth sphere under a load (nN)."""
    return (0.75 * load / (modulus * np.sqrt(radius))) ** (2 / 3)


def first_touches(specimen: Specimen, positions: xr.Dataset, cells: int = 1) -> np.ndarray:
    """Return the depth (nm) below the highest point at which the indenter first touches, on so many cells per pixel."""
    placed, _ = places(specimen, positions, specimen.indenter.half_width(float(np.ptp(specimen.heights))))
    bare = Problem(np.zeros(1), False, False, specimen.pixel, cells, np.nan, specimen.indenter)
    return np.array([surface_at(place, bare).separation.min() for place in placed])


def deepest(specimen: Specimen, problem: Problem) -> float:
    """Return an upper bound (nm below the datum) of the depth at which the surface touches; inf for a load on a map.

    The depth under a load is bounded by that on a flat at the lowest height: (3 F/(4 E* √R))^{2/3} by Hertz's formula,
    and up to F/(2π R H) more if the body yields.
    """
    last = float(problem.steps[-1])
    if not problem.by_load and not problem.first_contact:
        return problem.depth_factor * last
    if problem.by_load and problem.indenter.map:
        return np.inf
    if problem.by_load:
        radius = problem.indenter.radius
        load = last
        last = hertz_displacement(load, radius, problem.softest)
        last += load / (2 * np.pi * radius * problem.hardness) if problem.yielding else 0.0
    return problem.depth_factor * (float(np.ptp(specimen.heights)) + last)


class Place(NamedTuple):
    """The pixels around one contact centre."""

    height: np.ndarray  # (nx, ny), nm
    datum: float  # nm, the highest point of the whole scan
    window: regions.Window
    ends: tuple[bool, bool, bool, bool]  # whether the scan ends at the window's first and last row and column


def places(specimen: Specimen, positions: xr.Dataset, reach: float) -> tuple[list[Place], tuple[int, int]]:
    """Return the place of each contact centre, and the shape in pixels of an unclipped window."""
    windows, shape = regions.windows(specimen.axes, positions, min(reach, float(np.hypot(*specimen.sides))))
    height = specimen.heights
    datum = float(height.max())
    (nx, ny) = height.shape
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
    """The undeformed surface and indenter over one contact centre, on the cells of the solve."""

    separation: np.ndarray  # (nx, ny), nm below the datum; inf where there is nothing to touch
    zero: float  # displacement counted as zero, nm below the datum
    unknown_from: float  # displacement (nm below the datum) from which contact reaches the scan's or the map's edge
    corner: tuple[int, int]  # of these cells, within the full window


def surface_at(place: Place, problem: Problem) -> Surface:
    """Return the surface at one place."""
    height = np.ascontiguousarray(place.height, dtype=float)
    datum = place.datum
    between = splined if problem.splined else band_limited
    n = problem.refine
    fine = between(height, problem.refine)
    separation = problem.indenter.separation(fine, datum, *cell_axes(place, problem))
    zero = float(separation.min()) if problem.first_contact and separation.size else 0.0
    before_x, before_y = place.window.missing
    unknown_from = min(_lowest_at_ends(separation, place.ends), _lowest_at_rim(separation, problem.indenter))
    if problem.depth_factor > 1.0:
        unknown_from = 0.5 * (unknown_from + float(separation.min(initial=np.inf)))
    return Surface(separation, zero, unknown_from, (n * before_x, n * before_y))


def cell_axes(place: Place, problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """Return the centres of the cells along x and y, nm from the contact centre."""
    n = problem.refine
    parts = zip(place.window.origin, place.window.missing, place.height.shape)
    x, y = (first + problem.dx * (n * out + 0.5 * (1 - n) + np.arange(n * size)) for first, out, size in parts)
    return x, y


def _lowest_at_ends(separation: np.ndarray, ends: tuple[bool, bool, bool, bool]) -> float:
    """Return the least separation along those sides of the window at which the scan ends."""
    sides = separation[:1], separation[-1:], separation[:, :1], separation[:, -1:]
    return min((side.min(initial=np.inf) for end, side in zip(ends, sides) if end), default=np.inf)


def _lowest_at_rim(separation: np.ndarray, indenter: Indenter) -> float:
    """Return the least separation along the rim of an indenter's map, beyond which the indenter is unknown."""
    if indenter.map is None:
        return np.inf
    is_finite = np.pad(np.isfinite(separation), 1, constant_values=True)
    inside = is_finite[:-2, 1:-1] & is_finite[2:, 1:-1] & is_finite[1:-1, :-2] & is_finite[1:-1, 2:]
    return float(separation[~inside].min(initial=np.inf))
