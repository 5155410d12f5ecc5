"""Direct simulation: the elastic contact of the indenter with the scan itself, wherever it lands.

Every subregion is one task with its whole sweep inside, so that each displacement starts from the one before.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .. import regions, schema
from ..jobs import lazy as parallel
from ..kernels.halfspace import displacement_control as kalker
from ..kernels.halfspace import load_control
from ..kernels.halfspace.products import surface_displacement
from ..kernels.halfspace.separation import PROFILES, map_separation, sphere_separation
from ..materials import indenter_map
from ..units import magnitude

#: Scalars of one solve in the order in which a task returns them, then the fields.
_SCALARS = ("force", "contact_area", "converged", "iterations", "residual", "truncated", "delta")
_FIELDS = ("pressure", "displacement", "gap")
_FLAGS = ("converged", "truncated")


class _Options(NamedTuple):
    """What every task needs to know."""

    values: np.ndarray  # displacements (nm) or loads (nN), ascending
    by_load: bool
    first_contact: bool
    dx: float
    contact_modulus: float
    radius: float  # nan with an indenter's map
    profile: int
    indenter: tuple | None
    tolerance: float
    max_iterations: int
    field_shape: tuple[int, int] | None


def direct(
    ds: xr.Dataset,
    *,
    delta: Any = None,
    load: Any = None,
    subregions: Any = None,
    datum: str = "highest_peak",
    profile: str = "sphere",
    fields: bool = False,
    tolerance: float = 1e-6,
    max_iterations: int = 5000,
    progress: bool = False,
) -> xr.Dataset:
    """Solve the adhesionless contact of the assigned indenter with the scan, at each contact centre.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair.
    delta : array_like
        Displacements, nm, ascending. Either this or ``load``.
    load : array_like
        Forces, nN, positive and ascending; the displacement is then found.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0: the indenter's lowest point level with the highest point of the whole scan (the
        paper's), or this subregion's first touch.
    profile : {"sphere", "parabola"}
        The exact sphere or Hertz's paraboloid.
    fields : bool
        Keep pressure, displacement and gap on the window around each centre; NaN beyond the scan's edge.
    tolerance : float
        Relative error of the force.
    max_iterations : int
        Products with the half space's coefficients at most; a solve that needs more says converged = False.
    progress : bool
        Show a bar while computing (input in memory only; a lazy result is computed by `compute`).

    Returns
    -------
    Dataset
        ``force`` (nN), ``contact_area`` (nm²), ``converged``, ``iterations``, ``residual``, ``truncated`` along
        (subregion, delta) or (subregion, load), fields along (subregion, delta, x, y) with x, y from the
        contact centre. Lazy where the scan is a dask array.

    Raises
    ------
    ValueError
        If no pair is assigned, pixels are not square or missing, displacements or loads are empty, not finite
        or not ascending, or a name is unknown.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 36–42; Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990).

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass")
    >>> scan = roughxr.assign_pair(scan, sphere_radius=3000, young_modulus=75, poisson_ratio=0.22)
    >>> elastic = direct(scan, delta=[5.08, 15.4], subregions=(2, 2))
    >>> dict(elastic.force.sizes), elastic.force.units
    ({'subregion': 4, 'delta': 2}, 'nN')
    """
    ds = schema.validate(ds, "scan")
    options = _options(ds, delta, load, datum, profile, tolerance, max_iterations)
    positions = regions.centres(ds, subregions)
    lazy = parallel.is_lazy(ds)
    if not lazy:
        schema.finite(ds["height"].values)
    windows, shape = regions.windows(ds, positions, _reach(ds, options, lazy and fields))
    options = options._replace(field_shape=shape if fields else None)
    packed = _packed(ds, windows, options, lazy=lazy, progress=progress)
    out = _labelled(packed, ds, positions, windows, options)
    out = schema.record(
        out,
        "direct",
        ds,
        delta=None if options.by_load else options.values,
        load=options.values if options.by_load else None,
        subregions=subregions,
        datum=datum,
        profile=profile,
        fields=fields,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
    return parallel.finish(out, lazy=lazy, progress=progress)


def _options(ds, delta, load, datum, profile, tolerance, max_iterations) -> _Options:
    if (delta is None) == (load is None):
        raise ValueError("expected either delta or load, found " + ("neither" if delta is None else "both"))
    by_load = delta is None
    values = schema.ascending(load, "nN", "load") if by_load else schema.ascending(delta, "nm", "delta")
    if by_load and values[0] <= 0:
        raise ValueError(f"load: expected positive loads, found {values[0]:g} nN")
    schema.one_of(datum, ("highest_peak", "first_contact"), "datum")
    schema.one_of(profile, PROFILES, "profile")
    (modulus,) = schema.pair(ds, "contact_modulus")
    indenter = indenter_map(ds)
    radius = np.nan if indenter else schema.pair(ds, "sphere_radius")[0]
    if not 0 < magnitude(tolerance, "1", "tolerance") < 1:
        raise ValueError(f"tolerance: expected a number between 0 and 1, found {tolerance!r}")
    return _Options(
        values=values,
        by_load=by_load,
        first_contact=datum == "first_contact",
        dx=schema.square_pixel(ds),
        contact_modulus=modulus,
        radius=radius,
        profile=PROFILES[profile],
        indenter=indenter,
        tolerance=float(tolerance),
        max_iterations=int(max_iterations),
        field_shape=None,
    )


def _reach(ds: xr.Dataset, options: _Options, lazy_fields: bool) -> float:
    """Return the half-width (nm) beyond which no cell can overlap at the largest displacement or load.

    Where the displacement from the highest peak is not known beforehand it is bounded: the surface lies
    nowhere lower than a flat at its lowest point, which the indenter presses no harder at the same depth.
    """
    x_min, x_max, y_min, y_max = regions.extent(ds)
    whole = float(np.hypot(x_max - x_min, y_max - y_min))
    largest = float(options.values[-1])
    if options.by_load or options.first_contact:
        if lazy_fields:
            raise ValueError(
                "fields with a load or with datum='first_contact' need the height range: "
                "load the scan first (ds.load())"
            )
        if parallel.is_lazy(ds) or options.indenter:
            return whole
        largest = np.ptp(ds["height"].values) + (_hertz_depth(largest, options) if options.by_load else largest)
    if options.indenter:
        x, y, height = options.indenter
        near = np.argwhere(height.max() - height < largest)
        return float(max(np.abs(x[near[:, 0]]).max(), np.abs(y[near[:, 1]]).max())) if near.size else options.dx
    return min(np.sqrt(2 * options.radius * max(largest, 0.0)), whole)


def _hertz_depth(load: float, options: _Options) -> float:
    return (0.75 * load / (options.contact_modulus * np.sqrt(options.radius))) ** (2 / 3)


def _packed(ds: xr.Dataset, windows: list[regions.Window], options: _Options, **when):
    """Return the results of all tasks: scalars, then fields, flattened per displacement."""
    height = ds["height"].data
    datum = height.max()
    last = height.shape[0], height.shape[1]
    arguments = [
        (
            height[w.rows, w.columns],
            datum,
            w,
            (w.rows.start == 0, w.rows.stop == last[0], w.columns.start == 0, w.columns.stop == last[1]),
        )
        for w in windows
    ]
    cells = 0 if options.field_shape is None else len(_FIELDS) * int(np.prod(options.field_shape))
    return parallel.spread(
        _solve,
        arguments,
        (options.values.size, len(_SCALARS) + cells),
        options,
        cost=partial(_costs, arguments, options),
        **when,
    )


def _costs(arguments, options: _Options) -> np.ndarray:
    """Return how many cells overlap in each window at the largest displacement, all where that is not known."""
    known = not options.by_load and not options.first_contact
    limit = options.values[-1] if known else np.inf
    return np.array(
        [(_separation(np.asarray(h, dtype=float), float(d), w, options) < limit).sum() for h, d, w, _ in arguments]
    )


def _solve(height, datum, window, at_edge, options) -> np.ndarray:
    """Solve one subregion's sweep; return (values, scalars and flattened fields)."""
    height = schema.finite(np.ascontiguousarray(height, dtype=float))
    separation = _separation(height, float(datum), window, options)
    zero = float(separation.min()) if options.first_contact and separation.size else 0.0
    deltas, found, pressures = _solutions(separation, zero, options)
    reached = _lowest_at(separation, at_edge) < deltas
    scalars = [
        found[:, kalker.FORCE],
        found[:, kalker.AREA],
        found[:, kalker.STATUS] == kalker.CONVERGED,
        found[:, kalker.ITERATIONS],
        found[:, kalker.RESIDUAL],
        reached,
        deltas - zero,
    ]
    if options.field_shape is None:
        return np.stack(scalars, axis=1)
    return np.hstack([np.stack(scalars, axis=1), _fields(pressures, separation, deltas, window, options)])


def _solutions(separation, zero, options):
    """Return displacements above the highest peak, what is said of each solve, and pressures where fields are kept."""
    arguments = options.dx, options.contact_modulus
    limits = {"tolerance": options.tolerance, "max_iterations": options.max_iterations}
    limits["keep"] = options.field_shape is not None
    if options.by_load:
        return load_control.loaded_arrays(separation, options.values, *arguments, **limits)[:3]
    deltas = options.values + zero
    return deltas, *kalker.sweep_arrays(separation, deltas, *arguments, **limits)[:2]


def _separation(height, datum, window, options):
    x, y = (
        origin + options.dx * (missing + np.arange(size))
        for origin, missing, size in zip(window.origin, window.missing, height.shape)
    )
    if options.indenter:
        return map_separation(height, datum, x, y, *options.indenter)
    return sphere_separation(height, datum, x, y, options.radius, options.profile)


def _lowest_at(separation, at_edge) -> float:
    """Return the least separation along the sides of the window at which the scan ends."""
    sides = separation[:1], separation[-1:], separation[:, :1], separation[:, -1:]
    return min((side.min(initial=np.inf) for edge, side in zip(at_edge, sides) if edge), default=np.inf)


def _fields(pressures, separation, deltas, window, options) -> np.ndarray:
    """Return pressure, displacement and gap on the full window, flattened; NaN beyond the scan's edge."""
    fields = np.full((deltas.size, len(_FIELDS), *options.field_shape), np.nan)
    i, j = window.missing
    part = fields[:, :, i : i + separation.shape[0], j : j + separation.shape[1]]
    part[:, 0] = pressures
    part[:, 1] = surface_displacement(pressures, options.dx, options.contact_modulus)
    gap = part[:, 1] + separation - deltas[:, None, None]
    part[:, 2] = np.where(np.isfinite(separation), gap, np.nan)
    return fields.reshape(deltas.size, -1)


def _labelled(packed, ds, positions, windows, options) -> xr.Dataset:
    along = "load" if options.by_load else "delta"
    scalars = {name: (("subregion", along), packed[:, :, k]) for k, name in enumerate(_SCALARS)}
    if not options.by_load:
        del scalars["delta"]
    out = xr.Dataset(scalars, coords={along: options.values}).assign_coords(positions.coords)
    out = out.assign_coords({name: ds[name] for name in schema.PAIR if name in ds.coords})
    for name in _FLAGS:
        out[name] = out[name].astype(bool)
    out["iterations"] = out["iterations"].astype(int)
    if options.field_shape is not None:
        out = out.assign(_field_variables(packed, along, options)).assign_coords(_field_axes(windows, options))
    out.attrs = {"datum": "first_contact" if options.first_contact else "highest_peak", "method": "direct"}
    return schema.label(out)


def _field_variables(packed, along, options) -> dict:
    fields = packed[:, :, len(_SCALARS) :].reshape(*packed.shape[:2], len(_FIELDS), *options.field_shape)
    return {name: (("subregion", along, "x", "y"), fields[:, :, k]) for k, name in enumerate(_FIELDS)}


def _field_axes(windows, options) -> dict:
    """Return x, y from the contact centre; where centres lie unequally within their pixels, how far each is off."""
    origins = np.array([window.origin for window in windows])
    alike = np.ptp(origins, axis=0).max() < 1e-6 * options.dx
    common = origins[0] if alike else np.round(origins[0] / options.dx) * options.dx
    axes = {axis: common[k] + options.dx * np.arange(options.field_shape[k]) for k, axis in enumerate("xy")}
    if alike:
        return axes
    shifts = origins - common
    return axes | {f"subpixel_{axis}": ("subregion", shifts[:, k]) for k, axis in enumerate("xy")}
