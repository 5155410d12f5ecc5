"""Bodies too stiff to deform: the pull of the whole surface that faces the indenter, in contact or not.

At given places each place is one task, with all its displacements; for a map of every pixel a task is some rows.
"""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import dask
import numpy as np
import xarray as xr

from .. import regions, schema
from ..jobs import lazy as parallel
from ..kernels.adhesion import potentials
from ..kernels.adhesion import rigid as kernels
from ..kernels.halfspace import displacement_control
from ..substances import CUT_OFF
from ..units import positive, whole_number
from .asperity_sum import DISTANCE
from .maps import EVERY_PIXEL
from .problem import NOT_LOADED, Place, Problem, Surface, first_touches, indenter_of, places, read_problem, surface_at
from .records import Layout, fields_of, labelled, put_fields, window_axes

#: Laws of attraction, and the limits that keep the bodies apart.
RIGID_LAWS = tuple(potentials.POTENTIALS)
LIMITS = ("cut_off", "hardness", "elastic")

#: Height (nm) to which the indenter rises within a window, or this many times the range of heights if that is more
#: (for heights in memory); the ground further out is taken as its mean plane.
_RISE, _RANGES = 300.0, 10.0

#: Default displacements: their number, and the height (nm) above the first touch of all places where they start.
_COUNT, _ABOVE = 60, 10.0

#: Gap, in units of the law's length, up to which a cell counts as in contact.
_TOUCHING = 2.0

#: Share of the pull from beyond the scan above which a place counts as truncated.
_BEYOND_EDGE = 0.01

#: Gaps of the nearest cell, in ε, between which Lennard-Jones's largest pull is searched; range (nm) over which an
#: elastic approach is followed.
_NEAREST = np.linspace(0.31, 1.35, 27)
_DEPTHS = np.geomspace(0.003, 30.0, 41)

#: Share of the pull in one cell above which the result depends on the size of cells.
_ONE_CELL = 0.2

#: Rows of places in one task of a map.
_ROWS = 16

_EVENTS = {
    "pull_off_force": float,
    "pull_off_delta": float,
    "touch_delta": float,
    "pull_beyond_contact": float,
    "truncated": bool,
}


class _Options(NamedTuple):
    """How rigid bodies attract each other, and what keeps them apart."""

    law: potentials.Potential
    limit: str
    hardness: float  # GPa, NaN unless limit="hardness"
    area: float  # nm², of a pixel
    parabola: bool  # whether the indenter is Hertz's paraboloid


def rigid(
    ds: xr.Dataset,
    *,
    delta: Any = None,
    subregions: Any = None,
    law: str = "hamaker",
    length: Any = None,
    retardation: Any = None,
    limit: str = "cut_off",
    hardness: Any = None,
    refine: int = 1,
    datum: str = "highest_peak",
    profile: str = "sphere",
    fields: bool = False,
    progress: bool = False,
) -> xr.Dataset:
    """Sum the attraction between the assigned indenter and the scan across the gap, both too stiff to deform.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair with a work of adhesion.
    delta : array_like, optional
        Displacements, nm, ascending; by default 60 from 10 nm above the highest touch to the deepest, and for a map of
        every pixel none.
    subregions : (int, int), (array, array), Dataset or "every pixel", optional
        Contact centres, see `regions.centres`.
    law : {"hamaker", "lennard_jones", "exponential", "dugdale"}
        Traction across a gap, see `reference.rigid_sphere`; all laws have the same work of adhesion.
    length : number or quantity, optional
        nm: the cut-off z₀ of "hamaker", ε of "lennard_jones", ρ of "exponential", the range h of "dugdale". By default
        the length that relates the assigned Hamaker constant to the work of adhesion, A = 12π z₀² w = 16π ε² w; without
        a Hamaker constant 0.165 nm for z₀, and for the others the assigned ``adhesion_range``, else 0.3 nm.
    retardation : number or quantity, optional
        Wavelength, nm, of retarded van der Waals forces (law="hamaker"), about 100 nm; by default they are not
        retarded, which overestimates the contribution of gaps of more than some 10 nm.
    limit : {"cut_off", "hardness", "elastic"}
        What keeps the bodies apart. "cut_off": the closest approach of the nearest cell (for law="lennard_jones" its
        own repulsion). "hardness": summits are flattened until they bear the pull at the hardness. "elastic": summits
        deform elastically under the pull, solved as in `direct`, while the attraction acts across the gaps that are
        left (as in the theory of Derjaguin, Muller & Toporov).
    hardness : number or quantity, optional
        GPa, for limit="hardness"; more than the largest traction.
    refine : int
        Sum over refine × refine cells in each pixel, heights interpolated by bicubic splines; not for every pixel.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0, as in `direct`.
    profile : {"sphere", "parabola"}
        The exact sphere or Hertz's paraboloid.
    fields : bool
        Keep pressure and gap on the window around each centre.
    progress : bool
        Show progress on standard error.

    Returns
    -------
    Dataset
        ``force`` (nN) along (subregion, delta), NaN where the bodies cannot come so close; along subregion
        ``pull_off_force`` and ``pull_off_delta``, the largest pull at any displacement, ``touch_delta`` (nm, where they
        first touch), ``pull_beyond_contact``, the share of that pull from cells more than twice the law's length apart,
        and ``truncated``, where more than 1 % of it comes from beyond the scan. For every pixel along (x, y), without
        ``pull_beyond_contact``. Lazy where the scan is a dask array.

    Raises
    ------
    ValueError
        If no pair or no work of adhesion is assigned, pixels are not square or missing, or options do not go together.

    Warns
    -----
    UserWarning
        If a cell at closest approach holds more than a fifth of the pull at most centres (input in memory only): the
        result then depends on the size of the cells.

    Notes
    -----
    The pull at a place is the sum of tractions over the local gaps of all pixels, on the indenter's front less those on
    its back. Where the indenter has risen by more than 300 nm (or ten times the range of heights), the ground is taken
    as its mean plane. Within a cell the gap is that of its middle. Near a summit of radius r cells should be smaller
    than √(2 r z₀), some 3 nm: ``refine`` makes them so, and `add_fine_roughness` adds roughness finer than the scan
    shows, which changes the result, as it does in nature.

    References
    ----------
    Bhattacharjee & Elimelech, J. Colloid Interface Sci. 193 (1997) 273; Rajupet et al., Langmuir 37 (2021) 13208.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> found = rigid(scan, subregions=(2, 2))
    >>> dict(found.force.sizes), bool((found.pull_off_force > 0).all())
    ({'subregion': 4, 'delta': 60}, True)
    """
    ds = schema.validate(ds, "scan")
    pixels = isinstance(subregions, str)
    if pixels:
        schema.one_of(subregions, (EVERY_PIXEL,), "subregions")
    refine = whole_number(refine, "refine", least=1, most=64)
    options = _options(ds, law, length, retardation, limit, hardness, profile)
    options = options._replace(area=options.area / refine**2)
    positions = regions.centres(ds, None if pixels else subregions)
    given = [0.0] if pixels and delta is None else _default_deltas(ds) if delta is None else delta
    problem = read_problem(ds, positions, delta=given, datum=datum, profile=profile, refine=refine)
    if pixels:
        _refuse_on_pixels(options, problem, fields)
        out = _every_pixel(ds, problem, options, kept=delta is not None, progress=progress)
    else:
        out = _at_places(ds, positions, problem, options, fields=fields, progress=progress)
    named = {"law": law, "length": options.law.length, "limit": limit, "refine": refine}
    out.attrs = {"datum": datum, "method": "rigid", **named, "missing": "NaN where the bodies cannot come so near"}
    arguments = {"delta": problem.steps, "subregions": subregions, "profile": profile, "fields": fields}
    arguments |= {"retardation": retardation, "hardness": hardness, "datum": datum, **named}
    out = schema.record(schema.label(out), "rigid", ds, **arguments)
    out = parallel.finish(out, lazy=parallel.is_lazy(ds), progress=progress)
    if not parallel.is_lazy(ds):
        _warn(out, options)
    return out


def _warn(out: xr.Dataset, options: _Options) -> None:
    """Warn where the pull is that of a single cell at its closest approach."""
    pull = out["pull_off_force"]
    if pull.chunks:
        return
    law = options.law
    largest = law.closest if law.closest is not None else potentials.LARGEST_AT * law.length
    share = options.area * potentials.traction(max(largest, kernels.floor(law)), law) / float(pull.median())
    if share > _ONE_CELL:
        warnings.warn(
            f"rigid: one cell at closest approach holds {min(share, 1):.0%} of the median pull: the result is "
            "that of the cells' size; take refine, or a scan with add_fine_roughness",
            stacklevel=3,
        )


def _options(ds, law, length, retardation, limit, hardness, profile) -> _Options:
    schema.one_of(law, RIGID_LAWS, "law")
    schema.one_of(limit, LIMITS, "limit")
    wavelength = np.inf if retardation is None else positive(retardation, "nm", "retardation")
    if law != "hamaker" and np.isfinite(wavelength):
        raise ValueError(f"retardation: expected for law='hamaker' alone, found it for {law!r}")
    if (limit == "hardness") != (hardness is not None):
        raise ValueError(f"hardness: expected for limit='hardness' and for no other, found {hardness!r} for {limit!r}")
    if limit != "cut_off" and law == "lennard_jones":
        raise ValueError(f"limit: expected 'cut_off' for law='lennard_jones', which pushes by itself, found {limit!r}")
    (w,) = schema.pair(ds, "work_of_adhesion")
    if not w > 0:
        raise ValueError(f"work_of_adhesion: expected a positive one, found {w:g} J/m2; nothing attracts")
    found = potentials.potential(law, w, _length(ds, law, length, w), wavelength)
    return _Options(
        law=found,
        limit=limit,
        hardness=np.nan if hardness is None else _hardness(hardness, found),
        area=schema.square_pixel(ds) ** 2,
        parabola=profile == "parabola",
    )


def _hardness(given: Any, law: potentials.Potential) -> float:
    """Return a hardness (GPa), which must exceed the largest traction for summits to keep the bodies apart."""
    value, largest = positive(given, "GPa", "hardness"), potentials.traction(kernels.floor(law), law)
    if value <= largest:
        raise ValueError(f"hardness: expected more than the largest traction, {largest:.3g} GPa, found {value:g} GPa")
    return value


def _length(ds: xr.Dataset, law: str, given: Any, w: float) -> float:
    """Return the law's length, nm: as given, else by the assigned pair, else the usual one."""
    if given is not None:
        return positive(given, "nm", "length")
    if law in ("exponential", "dugdale"):
        return float(ds["adhesion_range"]) if "adhesion_range" in ds.coords else DISTANCE
    if "hamaker_constant" in ds.coords:
        return float(np.sqrt(float(ds["hamaker_constant"]) / ((12 if law == "hamaker" else 16) * np.pi * w)))
    return CUT_OFF if law == "hamaker" else DISTANCE


def _default_deltas(ds: xr.Dataset) -> np.ndarray:
    """Return displacements (nm) from above the highest touch of all places to where the lowest height is reached."""
    if parallel.is_lazy(ds):
        raise ValueError(NOT_LOADED)
    middle = regions.centres(ds, tuple(min(16, ds.sizes[axis]) for axis in "xy"))
    deepest = float(first_touches(ds, middle, indenter_of(ds)).max())
    return np.linspace(-_ABOVE, deepest, _COUNT)


def _refuse_on_pixels(options: _Options, problem: Problem, fields: bool) -> None:
    if options.limit != "cut_off" or fields or problem.indenter.map is not None or problem.refine > 1:
        raise ValueError(
            "subregions='every pixel': expected a sphere, limit='cut_off', no fields, no refine; else give places"
        )


def _reach(ds: xr.Dataset, problem: Problem) -> float:
    """Return the half-width of the windows, nm."""
    height_range = 0.0 if parallel.is_lazy(ds) else float(np.ptp(schema.complete(ds)["height"].values))
    return problem.indenter.reach(max(_RISE, _RANGES * height_range))


# one place


def _at_places(ds, positions, problem, options, *, fields, progress) -> xr.Dataset:
    """Return the curves and events at given places."""
    ds, lazy = schema.complete(ds), parallel.is_lazy(ds)
    found, shape = places(ds, positions, _reach(ds, problem))
    window = tuple(problem.refine * n for n in shape) if fields else None
    layout = Layout({"delta": problem.steps}, {"force": float}, _EVENTS, window)
    mean = ds["height"].data.mean()
    arguments = [(*place, mean) for place in found]
    shared = problem, layout, options
    records = parallel.spread(_place, arguments, layout.dtype, *shared, lazy=lazy, progress=progress)
    out = labelled(records, layout, ds, positions)
    return out.assign_coords(window_axes([place.window for place in found], problem, layout)) if fields else out


class _Setting(NamedTuple):
    """The indenter and the surface at one place, and the law between them."""

    surface: Surface
    ground: float  # nm below the datum, the mean plane beyond the window
    rectangle: tuple[float, float, float, float]  # sides of the window from the centre, nm
    problem: Problem
    options: _Options

    def pulls(self, deltas: np.ndarray) -> np.ndarray:
        """Return the pull (nN) at displacements (nm below the datum)."""
        o = self.options
        inside = kernels.pulls(self.surface.separation, deltas, o.law, kernels.floor(o.law), o.area)
        return inside + self.beyond(deltas)

    def beyond(self, deltas: np.ndarray) -> np.ndarray:
        """Return the part of the pull (nN) that comes from beyond the window."""
        indenter, o = self.problem.indenter, self.options
        if indenter.map is not None:
            return np.zeros(deltas.size)
        return kernels.outside(self.ground - deltas, o.law, indenter.radius, o.parabola, self.rectangle)

    def touch(self) -> float:
        """Return the displacement (nm below the datum) of first touch."""
        return float(self.surface.separation.min())


def _place(height, datum, window, ends, mean, problem, layout, options) -> np.ndarray:
    """Solve one place; the function that a task runs."""
    surface = surface_at(Place(height, datum, window, ends), problem)
    low = [-(first + problem.pixel * (lost - 0.5)) for first, lost in zip(window.origin, window.missing)]
    sides = [(a, n * problem.pixel - a) for a, n in zip(low, height.shape)]
    rectangle = tuple(max(side, 1e-6) for pair in sides for side in pair)
    here = _Setting(surface, float(datum) - float(mean), rectangle, problem, options)
    record, deltas = layout.blank(), problem.steps + surface.zero
    closest, pull = {"cut_off": _cut_off, "hardness": _flattened, "elastic": _yielding}[options.limit](here)
    within = deltas <= closest + 1e-9
    record["force"][within] = -here.pulls(deltas[within])
    record["touch_delta"] = here.touch() - surface.zero
    record["pull_off_force"], record["pull_off_delta"] = pull[0], pull[1] - surface.zero
    touching = _touching(here, pull[1])
    record["pull_beyond_contact"] = 1 - touching / pull[0]
    record["truncated"] = any(ends) and here.beyond(np.array([pull[1]]))[0] > _BEYOND_EDGE * pull[0]
    if layout.window is not None:
        put_fields(record, surface, _fields(here, np.where(within, deltas, np.nan)))
    return record


def _touching(here: _Setting, delta: float) -> float:
    """Return the part of the pull (nN) from cells in contact, or close enough to count as such."""
    o = here.options
    gap = np.maximum(here.surface.separation.ravel() - delta, kernels.floor(o.law))
    near = gap[gap < _TOUCHING * o.law.length]
    return o.area * float(potentials.tractions(near, o.law).sum())


def _fields(here: _Setting, deltas: np.ndarray) -> dict[str, np.ndarray]:
    """Return pressures and gaps on the window; rigid bodies have no displacement field."""
    law = here.options.law
    gap = np.maximum(here.surface.separation - deltas[:, None, None], kernels.floor(law))
    pressure = -potentials.tractions(np.minimum(gap, 1e12).ravel(), law).reshape(gap.shape)
    return {"pressure": pressure, "displacement": np.where(np.isnan(gap), np.nan, 0.0), "gap": gap}


def _cut_off(here: _Setting) -> tuple[float, tuple[float, float]]:
    """Return the displacement of closest approach, and the largest pull with its displacement."""
    law = here.options.law
    if law.closest is not None:
        closest = here.touch() - kernels.floor(law)
        return closest, (float(here.pulls(np.array([closest]))[0]), closest)
    deltas = here.touch() - law.length * _NEAREST
    return np.inf, tuple(map(float, _largest(deltas, here.pulls(deltas))))


def _largest(deltas: np.ndarray, pulls: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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


def _flattened(here: _Setting) -> tuple[float, tuple[float, float]]:
    """Return closest approach and largest pull where flattened summits bear the pull at the hardness.

    Between the overlaps of two pixels the flattened area is interpolated.
    """
    from scipy.optimize import brentq

    o, start = here.options, here.touch() - kernels.floor(here.options.law)
    lowest = np.sort(here.surface.separation[np.isfinite(here.surface.separation)]) - here.touch()
    areas = o.area * np.arange(lowest.size)

    def lacking(depth):
        return float(here.pulls(np.array([start + depth]))[0]) - o.hardness * np.interp(depth, lowest, areas)

    depth = brentq(lacking, 0.0, float(lowest[-1]), xtol=1e-9)
    return start + depth, (float(here.pulls(np.array([start + depth]))[0]), start + depth)


def _yielding(here: _Setting) -> tuple[float, tuple[float, float]]:
    """Return closest approach and largest pull where summits deform elastically under the attraction of all the gaps.

    The pull at a displacement is the attraction across the gaps less Hertz's push in the contacts. The largest over the
    displacements counts, or the rigid bodies' pull, with which an elastic approach begins, if that is larger.
    """
    law, problem = here.options.law, here.problem
    start, pulls = here.touch(), []
    deltas = start + _DEPTHS
    limits = {"tolerance": 1e-6, "max_iterations": 5000}
    separation, half_space = here.surface.separation, (problem.dx, problem.contact_modulus)
    for delta in deltas:
        states, pressure = displacement_control.sweep_arrays(
            separation, np.array([delta]), *half_space, keep=1, **limits
        )[:2]
        gap = fields_of(pressure, here.surface, np.array([delta]), problem)["gap"] + kernels.floor(law)
        open_gap = gap[(np.asarray(pressure).reshape(gap.shape) == 0) & np.isfinite(gap)]
        attraction = here.options.area * potentials.tractions(open_gap, law).sum()
        pulls.append(float(attraction + here.beyond(np.array([delta]))[0] - states[0, displacement_control.FORCE]))
        if pulls[-1] < 0.5 * max(pulls):
            break
    rigid_pull = float(here.pulls(np.array([start - kernels.floor(law)]))[0])
    best = int(np.argmax(pulls))
    if pulls[best] <= rigid_pull:
        return start - kernels.floor(law), (rigid_pull, start - kernels.floor(law))
    return start - kernels.floor(law), (pulls[best], float(deltas[best]))


# every pixel


class _Prepared(NamedTuple):
    """The input that all places of a map share."""

    height: np.ndarray  # padded by the indenter's half-width with the mean height
    rise: np.ndarray  # of the indenter over its lowest point, nm
    near_rise: np.ndarray  # its middle part, which alone can touch first
    top: np.ndarray  # highest point around each place
    mean: float
    split: kernels.Split
    fields: np.ndarray  # (terms, nx, ny)


def _every_pixel(ds, problem, options, *, kept, progress) -> xr.Dataset:
    """Return the pull-off at every pixel, and the forces there at given displacements."""
    ds, lazy = schema.complete(ds), parallel.is_lazy(ds)
    shape, half = ds["height"].shape, int(np.ceil(_reach(ds, problem) / problem.pixel)) + 1
    steps = problem.steps if kept else np.zeros(0)
    arguments = ds["height"].data, half, problem, options, float(steps[-1]) if kept else np.nan
    prepared = dask.delayed(_prepare, pure=False)(*arguments) if lazy else _prepare(*arguments)
    cell, rows = _cell(steps.size), min(_ROWS, shape[0])
    starts = [(start,) for start in range(0, shape[0], rows)]
    kind = np.dtype((cell, (rows, shape[1])))
    shared = shape, problem._replace(steps=steps), options, prepared
    records = parallel.spread(_some_rows, starts, kind, *shared, each=rows * shape[1], lazy=lazy, progress=progress)
    records = records.reshape((-1, shape[1]))[: shape[0]]
    names = [name for name in cell.names if name != "force" or kept]
    dims = {"force": ("x", "y", "delta")}
    out = xr.Dataset({name: (dims.get(name, ("x", "y")), records[name]) for name in names})
    pair = {name: ds[name] for name in schema.TRAVELLING if name in ds.coords}
    return out.assign_coords({"x": ds["x"], "y": ds["y"], **pair, **({"delta": steps} if kept else {})})


def _prepare(height, half, problem, options, last) -> _Prepared:
    """Return what all places share; ``last`` is the largest of the given displacements, NaN for none."""
    from scipy.ndimage import maximum_filter

    height = np.asarray(height, dtype=float)
    mean, top = float(height.mean()), float(height.max())
    padded = np.pad(height, half, constant_values=mean)
    x = problem.pixel * np.arange(-half, half + 1)
    flat = np.zeros((x.size, x.size))
    rise = problem.indenter.separation(flat, 0.0, x, x)
    middle = int(np.count_nonzero(rise[half, half:] <= top - height.min() + 1e-9)) + 1
    inner = slice(max(half - middle, 0), half + middle + 1)
    near_rise = np.ascontiguousarray(rise[inner, inner])
    touches = _touches(padded, near_rise, rise, height.shape, slice(0, height.shape[0], max(1, height.shape[0] // 64)))
    farthest = top - height.min() + float(rise[np.isfinite(rise)].max())
    split = kernels.split(options.law, top - float(touches.min()), farthest)
    reach = int(np.count_nonzero(rise[half, half:] < split.near + top - float(touches.min())))
    around = maximum_filter(height, size=2 * min(reach, half) + 1, mode="constant", cval=mean)
    fields = kernels.far_fields(padded, rise, split, height.shape)
    return _Prepared(padded, rise, near_rise, around, mean, split, fields)


def _touches(padded, near_rise, rise, shape, rows) -> np.ndarray:
    """Return the height of the indenter's lowest point at first touch, at the places in a slice of rows."""
    lost = (rise.shape[0] - near_rise.shape[0]) // 2
    inner = padded[lost : padded.shape[0] - lost, lost : padded.shape[1] - lost]
    chosen = range(*rows.indices(shape[0]))
    out = np.empty((len(chosen), shape[1]))
    if rows.step in (None, 1):
        kernels.first_touches(np.ascontiguousarray(inner), near_rise, rows.start, out)
        return out
    for k, row in enumerate(chosen):
        kernels.first_touches(inner, near_rise, row, out[k : k + 1])
    return out


def _some_rows(start, shape, problem, options, prepared) -> np.ndarray:
    """Return the records of some rows of places; the function that a task runs."""
    rows = min(_ROWS, shape[0])
    records = np.zeros((rows, shape[1]), _cell(problem.steps.size))
    stop = min(start + rows, shape[0])
    touches = _touches(prepared.height, prepared.near_rise, prepared.rise, shape, slice(start, stop))
    datum = touches if problem.first_contact else float(prepared.height.max())
    offsets = options.law.length * _NEAREST if options.law.closest is None else [kernels.floor(options.law)]
    heights = touches[..., None] + np.asarray(offsets)
    pulls = _pulls(heights, start, problem, options, prepared)
    found = records[: stop - start]
    if options.law.closest is None:
        found["pull_off_force"], delta = _largest(-heights, pulls)
        z = -delta
    else:
        found["pull_off_force"], z = pulls[..., 0], heights[..., 0]
    found["pull_off_delta"], found["touch_delta"] = datum - z, datum - touches
    found["truncated"] = _from_beyond_scan(start, shape, z, found["pull_off_force"], problem, options, prepared)
    if problem.steps.size:
        z = np.asarray(datum)[..., None] - problem.steps + np.zeros((*touches.shape, 1))
        least = -np.inf if options.law.closest is None else kernels.floor(options.law)
        z = np.where(z >= touches[..., None] + least - 1e-9, z, np.nan)
        found["force"] = -_pulls(z, start, problem, options, prepared)
    return records


def _from_beyond_scan(start, shape, z, pull, problem, options, prepared) -> np.ndarray:
    """Return where more than the allowed share of the pull comes from beyond the nearest side of the scan."""
    rows, columns = start + np.arange(z.shape[0]), np.arange(shape[1])
    off = [np.minimum(n, size - 1 - n) + 0.5 for n, size in zip((rows, columns), shape)]
    off = problem.pixel * np.minimum(off[0][:, None], off[1])
    distances = problem.pixel * np.geomspace(0.5, prepared.rise.shape[0], 24)
    gap = np.array([np.median(z) - prepared.mean])
    law, sphere = options.law, (problem.indenter.radius, options.parabola)
    beyond = [kernels.outside(gap, law, *sphere, (side, *[np.inf] * 3))[0] for side in distances]
    return np.interp(off, distances, beyond) > _BEYOND_EDGE * pull


def _cell(steps: int) -> np.dtype:
    events = [("pull_off_force", float), ("pull_off_delta", float), ("touch_delta", float), ("truncated", bool)]
    return np.dtype([*events, ("force", float, (steps,))])


def _pulls(z, start, problem, options, prepared) -> np.ndarray:
    """Return the pull (nN) at heights z (rows, columns, heights) of the lowest point; NaN where z is."""
    split, law = prepared.split, options.law
    arguments = prepared.height, prepared.rise, prepared.top, start, z, law, split, kernels.floor(law)
    near = kernels.near_pulls(*arguments)
    fields = prepared.fields[:, start : start + z.shape[0]]
    far = kernels.far_pulls(fields, float(prepared.height.max()), z, split)
    return options.area * (near + far) + _around(z - prepared.mean, problem, options, prepared.rise.shape[0])


def _around(gaps: np.ndarray, problem: Problem, options: _Options, size: int) -> np.ndarray:
    """Return the pull (nN) of the mean plane beyond the whole window, from a table over the gap."""
    from scipy.interpolate import CubicSpline

    known = gaps[np.isfinite(gaps)]
    if known.size == 0:
        return np.zeros(gaps.shape)
    side = (0.5 * size * problem.pixel,) * 4
    table = np.linspace(known.min() - 1e-6, known.max() + 1e-6, 40)
    pulls = kernels.outside(table, options.law, problem.indenter.radius, options.parabola, side)
    return np.where(np.isfinite(gaps), CubicSpline(table, pulls)(np.nan_to_num(gaps, nan=table[0])), np.nan)
