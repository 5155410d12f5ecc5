"""Direct simulation with adhesion: approach and retraction of the indenter, wherever it lands.

Every subregion is one task with its whole cycle inside: what holds on retraction depends on all that went before.
"""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import regions, schema
from ..catalogue import asperities
from ..jobs import lazy as parallel
from ..kernels.adhesion import cohesive_laws as cohesion
from ..kernels.adhesion import path as kernel
from ..kernels.asperity import maugis
from ..kernels.halfspace.products import surface_displacement
from ..kernels.halfspace.separation import PROFILES, map_separation, sphere_separation
from ..materials import indenter_map
from ..units import magnitude, positive, whole_number

#: Laws of adhesion.
LAWS = ("griffith", *cohesion.FINITE_RANGE)

BRANCHES = ("loading", "retraction")

#: What is kept along (branch, delta), with the kernel's column.
_STATES = {
    "force": kernel.FORCE,
    "contact_area": kernel.AREA,
    "energy": kernel.ENERGY,
    "dissipated": kernel.DISSIPATED,
    "contacts": kernel.CONTACTS,
    "resolution": kernel.RESOLUTION,
    "iterations": kernel.ITERATIONS,
    "converged": kernel.OK,
}
_FIELDS = ("pressure", "displacement", "gap")
_EVENTS = (
    "snap_in_force",
    "snap_in_delta",
    "pull_off_force",
    "pull_off_delta",
    "detachment_delta",
    "work_of_separation",
    "hysteresis",
    "pull_off_resolution",
    "truncated",
    "complete",
)

#: Scalars of a state, or of a cycle, ahead of any fields.
_COLUMNS = max(len(_STATES), len(_EVENTS))

#: P″ of a paraboloid is half of P′ over the depth. Where an elastic sweep curves by less than half of that (a flat
#: top, or the mesh's noise) the estimate divides by next to nothing and is left out.
_LEAST_CURVATURE = 0.25

#: Contacts of fewer pixels in radius than this at pull-off bring a warning. JKR's sphere is off by up to 0.5 % at
#: twenty pixels, 1.5 % at ten, 3 % at five, and by 3 to 40 % at one (``tests/benchmarks/adhesive_accuracy.py``).
_RESOLVED = 2.0


class _Options(NamedTuple):
    """What every task needs to know."""

    deltas: np.ndarray
    step: float
    first_contact: bool
    pixel: float
    refine: int
    contact_modulus: float
    work_of_adhesion: float
    law: str
    strength: float  # GPa, of a law of finite range
    radius: float
    profile: int
    indenter: tuple | None
    tolerance: float
    max_iterations: int
    max_cells: int
    field_shape: tuple[int, int] | None = None  # of a window, in cells of the solve


def adhesive(
    ds: xr.Dataset,
    *,
    delta: Any,
    subregions: Any = None,
    law: str = "griffith",
    strength: Any = None,
    refine: int = 1,
    step: Any = 0.25,
    datum: str = "highest_peak",
    profile: str = "sphere",
    fields: bool = False,
    tolerance: float = 1e-7,
    max_iterations: int = 1000,
    max_cells: int = 8000,
    progress: bool = False,
) -> xr.Dataset:
    """Follow the adhesive contact of the assigned indenter with the scan through approach and retraction.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair with a work of adhesion.
    delta : array_like
        Displacements, nm, ascending: reached one after the other on loading, and in reverse on retraction,
        which goes on beyond the smallest until all contact is lost.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    law : {"griffith", "dugdale", "exponential"}
        Adhesion without range (the limit of JKR), or of finite range with the same work of adhesion.
    strength : number or quantity, optional
        Largest traction, GPa, of a law of finite range.
    refine : int
        Solve on pixels so many times smaller, heights interpolated by bicubic splines.
    step : number or quantity
        Longest step of the displacement, nm. On retraction shorter ones are taken where a branch ends, and where a
        larger pull may lie between two states: halving the step leaves the pull-off of nearly every place as it is.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0, as in `direct`.
    profile : {"sphere", "parabola"}
        The exact sphere or Hertz's paraboloid.
    fields : bool
        Keep pressure, displacement and gap on the window around each centre, on the cells of the solve, on both
        branches; NaN beyond the scan's edge.
    tolerance : float
        Residual traction over the largest.
    max_iterations, max_cells : int
        Rounds per step; pixels in or near contact (memory: 8 bytes times their square).
    progress : bool
        Show a bar while computing.

    Returns
    -------
    Dataset
        Along (subregion, branch, delta): ``force``, ``contact_area``, ``contacts``, ``energy``, ``dissipated``,
        ``resolution`` (radius, in pixels of the solve, of the smallest contact that bears a tenth of the
        tension), ``iterations``, ``converged``. Along subregion, from all steps of the cycle: ``snap_in_force``,
        ``snap_in_delta``, ``pull_off_force``, ``pull_off_delta``, ``detachment_delta``, ``work_of_separation``,
        ``hysteresis``, ``pull_off_resolution``, ``truncated`` (contact at the scan's edge) and ``complete``. A
        subregion that is never touched, or whose cycle could not be completed, has NaN events. Fields along
        (subregion, branch, delta, x, y) with x, y from the contact centre.

    Raises
    ------
    ValueError
        If no pair or work of adhesion is assigned, a law of finite range has no strength, its process zone spans
        fewer than two pixels, or an option is not as described.

    Warns
    -----
    UserWarning
        If contacts at pull-off are poorly resolved (input in memory only).

    Notes
    -----
    In the Griffith limit a front's cells let go over a zone a few cells wide, whose line tension is taken back from the
    work of adhesion by the outline of each contact (`kernels.adhesion`). ``energy`` counts that
    outline as an ellipse: on a smooth sphere ``dissipated`` closes the loop, ``hysteresis``, to 1 %; where rough
    contacts split and merge it closes less well, and may fall a little on the way: there ``hysteresis``, the work of
    the force, is the figure to take.

    References
    ----------
    Griffith (1921); Johnson, Kendall & Roberts (1971); Pohrt & Popov (2015); Maugis (1992).

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> cycle = adhesive(scan, delta=[5, 10, 15], subregions=([312.5], [937.5]), step=0.5)
    >>> dict(cycle.force.sizes), bool(cycle.pull_off_force[0] > 0)
    ({'subregion': 1, 'branch': 2, 'delta': 3}, True)
    """
    ds = schema.validate(ds, "scan")
    options = _options(ds, delta, law, strength, refine, step, datum, profile, tolerance, max_iterations, max_cells)
    positions = regions.centres(ds, subregions)
    lazy = parallel.is_lazy(ds)
    if not lazy:
        schema.finite(ds["height"].values)
    if fields and lazy and options.first_contact:
        raise ValueError("fields with datum='first_contact' need the height range: load the scan first (ds.load())")
    windows, shape = regions.windows(ds, positions, _reach(ds, options))
    options = options._replace(field_shape=tuple(n * refine for n in shape) if fields else None)
    out = _labelled(_packed(ds, windows, options), ds, positions, windows, options)
    out.attrs = {
        "datum": datum,
        "method": "adhesive",
        "law": law,
        "refine": options.refine,
        "refinement": "bicubic spline" if options.refine > 1 else "none",
    }
    arguments = {"delta": options.deltas, "subregions": subregions, "law": law, "strength": strength}
    arguments |= {"refine": refine, "step": options.step, "datum": datum, "profile": profile, "tolerance": tolerance}
    arguments["fields"] = fields
    out = schema.record(out, "adhesive", ds, **arguments, max_iterations=max_iterations, max_cells=max_cells)
    out = parallel.finish(out, lazy=lazy, progress=progress)
    if not lazy:
        _warn(out)
    return out


def _options(ds, delta, law, strength, refine, step, datum, profile, tolerance, max_iterations, max_cells):
    schema.one_of(law, LAWS, "law")
    schema.one_of(datum, ("highest_peak", "first_contact"), "datum")
    schema.one_of(profile, PROFILES, "profile")
    refine = whole_number(refine, "refine", least=1, most=16)
    if not 0 < magnitude(tolerance, "1", "tolerance") < 1:
        raise ValueError(f"tolerance: expected a number between 0 and 1, found {tolerance!r}")
    max_iterations = whole_number(max_iterations, "max_iterations", least=1)
    max_cells = whole_number(max_cells, "max_cells", least=1)
    modulus, w = schema.pair(ds, "contact_modulus", "work_of_adhesion")
    indenter = indenter_map(ds)
    options = _Options(
        deltas=schema.ascending(delta, "nm", "delta"),
        step=positive(step, "nm", "step"),
        first_contact=datum == "first_contact",
        pixel=schema.square_pixel(ds),
        refine=refine,
        contact_modulus=modulus,
        work_of_adhesion=w,
        law=law,
        strength=_strength(law, strength),
        radius=np.nan if indenter else schema.pair(ds, "sphere_radius")[0],
        profile=PROFILES[profile],
        indenter=indenter,
        tolerance=float(tolerance),
        max_iterations=max_iterations,
        max_cells=max_cells,
    )
    _resolved_zone(options)
    return options


def _strength(law: str, strength: Any) -> float:
    if (law == "griffith") != (strength is None):
        found = "none" if strength is None else repr(strength)
        raise ValueError(f"strength: expected for a law of finite range and for no other, found {found} for {law!r}")
    return np.nan if strength is None else positive(strength, "GPa", "strength")


def _resolved_zone(options: _Options) -> None:
    """Refuse a law whose process zone the pixels cannot show."""
    if options.law == "griffith" or options.work_of_adhesion == 0:
        return
    zone = cohesion.process_zone(options.contact_modulus, options.work_of_adhesion, options.strength)
    dx = options.pixel / options.refine
    if zone < cohesion.LEAST_ZONE * dx:
        needed = int(np.ceil(cohesion.LEAST_ZONE * options.pixel / zone))
        raise ValueError(
            f"strength: expected a process zone of at least {cohesion.LEAST_ZONE:g} pixels, found {zone:.3g} nm "
            f"(π E* w/(4 σ₀²)) on pixels of {dx:.3g} nm; take refine={needed}, or law='griffith'"
        )


def _reach(ds: xr.Dataset, options: _Options) -> float:
    """Return the half-width (nm) of the windows: the overlap, and as far as adhesion draws the surface up."""
    x_min, x_max, y_min, y_max = regions.extent(ds)
    whole = float(np.hypot(x_max - x_min, y_max - y_min))
    depth = float(options.deltas[-1])
    if options.first_contact:
        if parallel.is_lazy(ds):
            return whole
        depth += float(np.ptp(ds["height"].values))
    if options.indenter:
        x, y, _ = options.indenter
        return float(max(np.abs(x).max(), np.abs(y).max()))
    attraction = 0.0 if options.law == "griffith" else _law(options).range
    reach = np.sqrt(2 * options.radius * max(depth, 0.0))
    for _ in range(20):  # JKR's contact of that radius draws the surface up by √(2πaw/E*)
        uplift = np.sqrt(2 * np.pi * reach * options.work_of_adhesion / options.contact_modulus)
        reach = np.sqrt(2 * options.radius * max(depth + uplift + attraction, 0.0))
    return min(float(reach) + options.pixel, whole)


def _law(options: _Options) -> cohesion.CohesiveLaw:
    """Return the law on unit cells of unit modulus."""
    dx = options.pixel / options.refine
    w = options.work_of_adhesion * dx / options.contact_modulus
    if options.law == "griffith" or w == 0:
        return cohesion.griffith(w)
    return cohesion.finite_range(options.law, w, options.strength * dx / options.contact_modulus)


def _packed(ds: xr.Dataset, windows: list[regions.Window], options: _Options):
    """Return the lazy results of all tasks: (subregion, 2 deltas + 1, scalars, then fields flattened)."""
    height = ds["height"].data
    last = height.shape
    arguments = [
        (
            height[w.rows, w.columns],
            height.max(),
            w,
            (w.rows.start == 0, w.rows.stop == last[0], w.columns.start == 0, w.columns.stop == last[1]),
        )
        for w in windows
    ]
    columns = _COLUMNS + (0 if options.field_shape is None else len(_FIELDS) * int(np.prod(options.field_shape)))
    return parallel.spread(_cycle, arguments, (2 * options.deltas.size + 1, columns), options)


def _cycle(height, datum, window, at_edge, options: _Options) -> np.ndarray:
    """Follow one subregion's cycle; return states on loading, on retraction, and a row of events."""
    height = schema.finite(np.ascontiguousarray(height, dtype=float))
    separation = _separation(height, float(datum), window, options)
    zero = float(separation.min()) if options.first_contact else 0.0
    dx = options.pixel / options.refine
    path = kernel.follow(
        separation,
        options.deltas + zero,
        options.step,
        _law(options),
        options.work_of_adhesion * dx / options.contact_modulus,
        tolerance=options.tolerance,
        max_iterations=options.max_iterations,
        max_cells=options.max_cells,
        fields=options.field_shape is not None,
    )
    states = path.states.copy()
    states[:, kernel.FORCE] *= options.contact_modulus * dx
    states[:, [kernel.ENERGY, kernel.DISSIPATED]] *= options.contact_modulus * dx
    states[:, kernel.AREA] *= dx * dx
    rows = _rows(path._replace(states=states), zero, separation, at_edge, options)
    if options.field_shape is None:
        return rows
    return np.hstack([rows, _fields(path, zero, separation, window, options)])


def _fields(path, zero, separation, window, options) -> np.ndarray:
    """Return pressure, displacement and gap of every state asked for on the full window; NaN beyond the scan."""
    size, dx = options.deltas.size, options.pixel / options.refine
    fields = np.full((2 * size + 1, len(_FIELDS), *options.field_shape), np.nan)
    rows, columns = (
        slice(n * options.refine, n * options.refine + m) for n, m in zip(window.missing, separation.shape)
    )
    pressures = path.pressures * options.contact_modulus / dx
    order = [*range(size), *range(2 * size - 1, size - 1, -1)]  # retraction comes with falling displacement
    for row, (delta, pressure) in enumerate(zip(np.tile(options.deltas + zero, 2), pressures[order])):
        displacement = surface_displacement(pressure, dx, options.contact_modulus)
        gap = np.where(np.isfinite(separation), displacement + separation - delta, np.nan)
        fields[row, :, rows, columns] = pressure, displacement, gap
    return fields.reshape(2 * size + 1, -1)


def _rows(path, zero, separation, at_edge, options) -> np.ndarray:
    out = np.full((2 * options.deltas.size + 1, _COLUMNS), np.nan)
    asked = path.states[:, kernel.ASKED] > 0
    loading = path.states[: path.turn][asked[: path.turn]]
    retraction = path.states[path.turn :][asked[path.turn :]][::-1]
    size = options.deltas.size
    out[: loading.shape[0], : len(_STATES)] = loading[:, list(_STATES.values())]
    out[2 * size - retraction.shape[0] : 2 * size, : len(_STATES)] = retraction[:, list(_STATES.values())]
    reached = separation < options.deltas[-1] + zero
    sides = reached[:1], reached[-1:], reached[:, :1], reached[:, -1:]
    truncated = any(edge and side.any() for edge, side in zip(at_edge, sides))
    complete = path.status == kernel.CONVERGED
    events = _events(path, zero) if complete else [np.nan] * (len(_EVENTS) - 2)
    out[-1, : len(_EVENTS)] = [*events, truncated, complete]
    return out


def _events(path, zero: float) -> list[float]:
    """Return snap-in, pull-off, work of separation and so on from all states of the cycle."""
    states = path.states
    delta, force = states[:, kernel.DELTA] - zero, states[:, kernel.FORCE]
    touching = states[:, kernel.AREA] > 0
    back = slice(path.turn, None)
    if not touching.any():
        return [np.nan] * (len(_EVENTS) - 2)
    first = int(np.argmax(touching))
    lowest = path.turn + int(np.argmin(force[back]))
    work = 0.5 * (force[1:] + force[:-1]) * np.diff(delta)
    pulling = np.minimum(force[back], 0.0)
    separation = np.sum(0.5 * (pulling[1:] + pulling[:-1]) * np.diff(delta[back]))
    return [
        max(-force[first], 0.0),
        delta[first],
        max(-force[lowest], 0.0),
        delta[lowest],
        delta[touching].min() if touching[back].any() else np.nan,
        separation,
        work.sum(),
        states[lowest, kernel.RESOLUTION],
    ]


def _separation(height, datum, window, options: _Options) -> np.ndarray:
    n, dx = options.refine, options.pixel / options.refine
    height = _refined(height, n)
    x, y = (
        origin + options.pixel * (missing - 0.5 + 0.5 / n) + dx * np.arange(size)
        for origin, missing, size in zip(window.origin, window.missing, height.shape)
    )
    if options.indenter:
        return map_separation(height, datum, x, y, *options.indenter)
    return sphere_separation(height, datum, x, y, options.radius, options.profile)


def _refined(height: np.ndarray, n: int) -> np.ndarray:
    """Return the heights on n × n cells in place of each pixel, by splines through the pixel centres."""
    if n == 1:
        return height
    from scipy.interpolate import RectBivariateSpline

    coarse = [np.arange(size) for size in height.shape]
    fine = [(np.arange(size * n) + 0.5) / n - 0.5 for size in height.shape]
    order = [min(3, size - 1) for size in height.shape]
    return np.ascontiguousarray(RectBivariateSpline(*coarse, height, kx=order[0], ky=order[1])(*fine))


def _labelled(packed, ds: xr.Dataset, positions: xr.Dataset, windows, options: _Options) -> xr.Dataset:
    size = options.deltas.size
    dims = ("subregion", "branch", "delta")
    shape = (packed.shape[0], len(BRANCHES), size)
    out = xr.Dataset({name: (dims, packed[:, :-1, k].reshape(shape)) for k, name in enumerate(_STATES)})
    out = out.assign({name: ("subregion", packed[:, -1, k]) for k, name in enumerate(_EVENTS)})
    for name in ("converged", "truncated", "complete"):
        out[name] = out[name] == 1
    out = out.assign_coords(delta=options.deltas, branch=list(BRANCHES)).assign_coords(positions.coords)
    if options.field_shape is not None:
        parts = packed[:, :-1, _COLUMNS:].reshape(*shape, len(_FIELDS), *options.field_shape)
        out = out.assign({name: ((*dims, "x", "y"), parts[:, :, :, k]) for k, name in enumerate(_FIELDS)})
        out = out.assign_coords(_field_axes(windows, options))
    return schema.label(out.assign_coords({name: ds[name] for name in schema.PAIR if name in ds.coords}))


def _field_axes(windows, options: _Options) -> dict:
    """Return x, y from the contact centre; where centres lie unequally within their pixels, how far each is off."""
    dx = options.pixel / options.refine
    origins = np.array([window.origin for window in windows]) - 0.5 * (options.pixel - dx)
    alike = np.ptp(origins, axis=0).max() < 1e-6 * dx
    common = origins[0] if alike else np.round(origins[0] / options.pixel) * options.pixel - 0.5 * (options.pixel - dx)
    axes = {axis: common[k] + dx * np.arange(options.field_shape[k]) for k, axis in enumerate("xy")}
    shifts = origins - common
    return axes if alike else axes | {f"subpixel_{axis}": ("subregion", shifts[:, k]) for k, axis in enumerate("xy")}


def _warn(out: xr.Dataset) -> None:
    resolution = out["pull_off_resolution"].values
    poor = resolution < _RESOLVED
    if poor.any():
        warnings.warn(
            f"{int(poor.sum())} of {resolution.size} subregions have contacts of less than {_RESOLVED:g} pixels in "
            f"radius at pull-off (smallest {np.nanmin(resolution):.2g}): compare with a larger refine",
            stacklevel=3,
        )
    lost = int((~out["complete"].values).sum())
    if lost:
        warnings.warn(f"{lost} subregions needed more than max_cells pixels; their events are NaN", stacklevel=3)


def elastic_pull_off(ds: xr.Dataset, *, smoothing: Any = 2.0) -> xr.Dataset:
    """Estimate the pull-off from an adhesionless sweep alone.

    Adhesion moves each state of force P, area A and displacement δ₁ to δ = δ₁ − √(2wA′/P″) and
    P − P′ (δ₁ − δ), derivatives with respect to δ₁: the energy of adhesion wA against the
    elastic energy of a rigid withdrawal. Exact for a sphere. Derivatives are those of cubics (P) and
    parabolas (A) in the root of the depth, fitted to the sweep near each displacement.

    Parameters
    ----------
    ds : Dataset
        A solution of `direct` along ``delta``, of at least eight displacements, with a work of adhesion.
    smoothing : number or quantity
        Half-width of the fits, nm; at least three displacements to either side are taken.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) and ``pull_off_delta`` (nm) along subregion, NaN where nothing is in contact;
        ``bracketed`` is False where the largest pull stands at an end of the sweep.

    Raises
    ------
    ValueError
        If ``ds`` is no such sweep, or has adhesion already, or no work of adhesion is assigned.

    See Also
    --------
    pull_off : the same by method="ciavarella".

    References
    ----------
    Ciavarella, arXiv 1712.05844.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> sweep = scan.contact.direct(delta=np.arange(0, 17, 0.25), subregions=([312.5], [937.5]))
    >>> bool(elastic_pull_off(sweep).pull_off_force > 0)
    True
    """
    if not all(name in ds and "delta" in ds[name].dims for name in ("force", "contact_area")):
        found = ", ".join(map(str, ds.variables))
        raise ValueError(f"expected a sweep with 'force' and 'contact_area' along 'delta', found variables: {found}")
    (w,) = schema.pair(ds, "work_of_adhesion")
    if ds.attrs.get("method") == "adhesive" or ds.attrs.get("law") in ("jkr", "maugis"):
        raise ValueError("expected a sweep without adhesion (of direct, or law='hertz'), found one with; take pull_off")
    if ds.sizes["delta"] < 8:
        raise ValueError(f"delta: expected a sweep of at least eight displacements, found {ds.sizes['delta']}")
    moved = xr.apply_ufunc(
        _lowest_pull,
        ds["force"],
        ds["contact_area"],
        input_core_dims=[["delta"], ["delta"]],
        output_core_dims=[["event"]],
        kwargs={"delta": ds["delta"].values, "w": w, "half": positive(smoothing, "nm", "smoothing")},
        vectorize=True,
        dask="parallelized",
        output_dtypes=[float],
        dask_gufunc_kwargs={"output_sizes": {"event": 3}, "allow_rechunk": True},
    )
    out = xr.Dataset({name: moved[..., k] for k, name in enumerate(("pull_off_force", "pull_off_delta", "bracketed"))})
    out["bracketed"] = out["bracketed"] == 1
    out.attrs = {"datum": ds.attrs.get("datum", ""), "method": "elastic_pull_off"}
    return schema.record(schema.label(out), "elastic_pull_off", ds, smoothing=smoothing)


def _lowest_pull(force, area, *, delta, w, half):
    """Return (largest pull, its displacement, whether it lies inside the sweep)."""
    touched = force > 0
    if touched.sum() < 8:
        return np.full(3, np.nan)
    delta, force, area = delta[touched], force[touched], area[touched]
    root = _roots(delta, force)
    derivatives = np.array([_derivatives(root, force, area, k, half) for k in range(delta.size)])
    growth, first, second = derivatives.T
    possible = (growth > 0) & (second > _LEAST_CURVATURE * first / root**2)
    if not possible.any():
        return np.full(3, np.nan)
    drop = np.sqrt(2 * w * growth[possible] / second[possible])
    pull = first[possible] * drop - force[possible]
    k = int(np.argmax(pull))
    inside = 0 < k < pull.size - 1
    return np.array([pull[k], delta[possible][k] - drop[k], inside]) if pull[k] > 0 else np.full(3, np.nan)


def _derivatives(root, force, area, k, half):
    """Return A′, P′ and P″ at the k-th displacement, by fits in the root of the depth: a sphere's P is its cube."""
    depth, s = root**2, root[k]
    offset = np.abs(depth - depth[k])
    near = offset <= max(half, np.sort(offset)[min(6, root.size - 1)])
    cubic = np.polynomial.polynomial.polyfit(root[near] - s, force[near], 3)
    parabola = np.polynomial.polynomial.polyfit(root[near] - s, area[near], 2)
    return parabola[1] / (2 * s), cubic[1] / (2 * s), (2 * cubic[2] - cubic[1] / s) / (4 * s * s)


def _roots(delta, force):
    """Return √(δ − first touch), the touch found from force^{2/3}, straight for a sphere, at the first two states."""
    first, second = force[:2] ** (2 / 3)
    before = np.clip(first / (second - first), 1e-3, 1.0) if second > first else 1e-3
    return np.sqrt(delta - delta[0] + before * (delta[1] - delta[0]))


def tabor(ds: xr.Dataset, *, equilibrium_distance: Any = 0.3) -> xr.Dataset:
    """Return the catalogue with Tabor's parameter of each asperity under the assigned sphere.

    Above about 5 the Griffith limit (JKR) holds, below about 0.1 the limit of long range (DMT).

    Parameters
    ----------
    ds : Dataset
        An asperity catalogue, or a scan (its asperities are then found with the default patch), with an assigned pair
        and work of adhesion.
    equilibrium_distance : number or quantity
        z₀ of the interatomic potential, nm.

    Returns
    -------
    Dataset
        With ``tabor_parameter`` along asperity, (R w²/(E*² z₀³))^{1/3} with R of the asperity and the
        sphere together; NaN for a saddle.

    References
    ----------
    Tabor, J. Colloid Interface Sci. 58, 2 (1977).

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> tabor(scan.contact.asperities()).tabor_parameter.dims
    ('asperity',)
    """
    ds = schema.validate(ds, "asperities") if "asperity" in ds.dims else asperities(ds)
    radius, modulus, w = schema.pair(ds, "sphere_radius", "contact_modulus", "work_of_adhesion")
    z0 = positive(equilibrium_distance, "nm", "equilibrium_distance")
    A, B = (0.5 * (ds[name].values + 1 / radius) for name in ("curvature_min", "curvature_max"))
    with np.errstate(invalid="ignore", divide="ignore"):
        parameter = np.where(A > 0, maugis.tabor(A, B, modulus, w, z0), np.nan)
    out = ds.assign(tabor_parameter=("asperity", parameter))
    return schema.record(schema.label(out), "tabor", ds, equilibrium_distance=z0)
