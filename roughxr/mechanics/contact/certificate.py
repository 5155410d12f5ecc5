"""Check the conditions of a contact solution: each violation, with its limit."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from ..bodies.layer import film_of
from ..bodies.pair_record import read_pair
from ..jobs.records import FIELDS
from ..kernels.adhesion.traction_laws import SmoothLaw
from ..kernels.halfspace.layered import Film
from ..kernels.halfspace.products import surface_displacement
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal
from .adhesion_on_cells import Adhesion, law_on_cells
from .adhesive_options import pair_law

#: Relative tolerance of sums and products, and of the pressure on a body that yields with adhesion.
_ROUNDING, _YIELD_TOLERANCE = 1e-9, 1.1e-3

#: Largest relative error of a pull-off by mesh and step, unless the solution states another accuracy.
_ACCURACY = 0.05

#: Largest relative amount by which a pull-off may leave what the states of its retraction allow.
_PULL_OFF_TOLERANCE = 0.05

#: Share of the work between two states that a jump may dissipate where the pull-off is bounded by that work.
_JUMP = 0.05

#: Methods whose solutions can be checked.
SOLVED = ("direct", "adhesive", "rigid")
_PLANE = ("x", "y")


def certificate(ds: xr.Dataset) -> xr.Dataset:
    """Return the largest violation of each contact condition, with its limit.

    Parameters
    ----------
    ds : Dataset
        Solution of `direct`, `adhesive` or `rigid` at places. With ``fields=True`` the conditions are recomputed from
        the fields. Without fields only sums that the solver reports are compared, as the sentence states.

    Returns
    -------
    Dataset
        Along ``check``: ``violation``, the largest over all places and states, its ``limit``, ``met`` and ``words``;
        the attribute ``sentence`` names the conditions that are not met. An unknown violation is NaN and counts as not
        met. "unconverged" and "truncated" are shares of the solves, "load" the relative difference from the prescribed
        load, "mesh" the stated error of the pull-off, "pull_off" by how much the pull-off force leaves what the states
        of a retraction allow, beyond its stated error: at least their largest pull, at most what the work between the
        two states around it allows. From the fields: "elasticity", displacement less the
        convolution of the pressure, over the largest displacement; "geometry", the change of gap − displacement + δ
        between states, which the undeformed surfaces fix (needs two states at a place); "traction" (with adhesion),
        p + t(gap) out of contact and the gap in contact, over the largest traction; "penetration"
        and "complementarity" (pressure times gap; without adhesion), over the deepest overlap; "force_balance", force
        less Σ p dA; "hardness", the pressure beyond it.

    Raises
    ------
    ValueError
        If ``ds`` is no solution of these methods along places.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, young_modulus=75, poisson_ratio=0.2)
    >>> print(roughxr.certificate(scan.contact.direct(load=[1000.0])).sentence)  # doctest: +ELLIPSIS
    All 4 conditions are met.
    unconverged: 0 of at most 0, met
    residual: ... of at most 1e-06, met
    load: ... of at most 1e-06, met
    truncated: 0 of at most 0, met
    Only sums were checked; solve with fields=True to check elasticity and traction, too.
    """
    ds = schema.entered_dataset(ds, "result")
    stored = [name for name in FIELDS if name in ds]  # which may be larger than memory
    whole = ds
    ds = schema.in_memory(ds.drop_vars(stored))
    method = ds.attrs.get("method")
    if method not in SOLVED or ("converged" not in ds and method != "rigid"):
        raise Refusal("", f"a solution of {', '.join(SOLVED)} along subregion", f"method={method!r}")
    fields = set(FIELDS) <= set(stored) and method != "rigid"
    conditions = [(name, float(value.max(skipna=False)), limit) for name, value, limit in _solver_conditions(ds)]
    if fields:
        conditions += _worst_of_places(whole, method == "adhesive")
    names = [name for name, _, _ in conditions]
    violations = np.array([value for _, value, _ in conditions])
    limits = np.array([limit for _, _, limit in conditions], float)
    met = violations <= limits
    words = [
        f"{name}: {value:.2g} of at most {limit:.2g}, {'met' if fine else 'NOT MET'}"
        for name, value, limit, fine in zip(names, violations, limits, met)
    ]
    rows = {"violation": violations, "limit": limits, "met": met, "words": words}
    out = xr.Dataset({name: ("check", values) for name, values in rows.items()}, {"check": list(names)})
    broken = ", ".join(out["check"].values[~met])
    lines = [f"Not met: {broken}." if broken else f"All {met.size} conditions are met.", *words]
    if not fields:
        lines.append("Only sums were checked; solve with fields=True to check elasticity and traction, too.")
    out.attrs = {"method": method, "fields": int(fields), "sentence": "\n".join(lines)}
    return schema.record(schema.label(out), "certificate", ds)


def _solver_conditions(ds: xr.Dataset) -> Iterator[tuple[str, xr.DataArray, float]]:
    """Yield name, values and limit of the sums that the solver reports."""
    tolerance = ds.attrs.get("tolerance", np.nan)
    if "converged" in ds:  # rigid bodies need no iterations
        yield "unconverged", 1 - ds["converged"].astype(bool).mean(), 0.0
    if "residual" in ds:
        yield "residual", ds["residual"], tolerance
    if "load" in ds.dims:
        yield "load", abs(ds["force"] / ds["load"] - 1), tolerance
    yield "truncated", ds["truncated"].astype(bool).mean(), 0.0
    for name in {"pull_off_error", "cell_error"} & set(ds):
        yield "mesh", abs(ds[name]), ds.attrs.get("accuracy", _ACCURACY)
    if "pull_off_delta" in ds and "branch" in ds.dims:
        yield "pull_off", _pull_off_violation(ds), _PULL_OFF_TOLERANCE


def _pull_off_violation(ds: xr.Dataset) -> xr.DataArray:
    """Return by how much a pull-off leaves what its states allow, beyond its stated error."""
    least, most = _pulls_of_states(ds)
    pull_off = ds["pull_off_force"]
    below, above = least / pull_off - 1, pull_off / most - 1
    outside = xr.where(below > above, below, above) - ds["pull_off_error"].fillna(0.0)
    return outside.clip(min=0).where(least > 0, 0.0)


def _pulls_of_states(ds: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the smallest and the largest pull-off force (nN) that the states of a retraction allow.

    From the state before the pull-off to the pull-off a contact only shrinks, so that its stiffness falls and the pull
    is concave; from there to the next state the pull falls. With the work between the two states both bound the
    largest pull. Without such states, or if a jump lies between them, the upper bound is infinite.
    """
    states = ds[["force", "energy", "dissipated"]].sel(branch="retraction")
    least = (-states["force"]).max("delta")
    before = states["delta"].where(states["delta"] > ds["pull_off_delta"]).min("delta")
    after = states["delta"].where(states["delta"] <= ds["pull_off_delta"]).max("delta")
    known = before.notnull() & after.notnull()
    first = states.sel(delta=before.fillna(states["delta"][0]))
    second = states.sel(delta=after.fillna(states["delta"][0]))
    jump = second["dissipated"] - first["dissipated"]
    work = second["energy"] - first["energy"] + jump
    falling = -second["force"] * (ds["pull_off_delta"] - after)
    most = 2 * (work - falling) / (before - ds["pull_off_delta"]) + first["force"]
    return least, most.where(known & (jump < _JUMP * work), np.inf)


def _worst_of_places(ds: xr.Dataset, adheres: bool) -> list[tuple[str, float, float]]:
    """Return name, largest violation and limit of each condition on fields; lazy fields are read place by place."""
    places = [ds]
    if ds.chunks and "subregion" in ds.dims:
        places = [ds.isel(subregion=[place]) for place in range(ds.sizes["subregion"])]
    rows = [
        [(name, float(value.max(skipna=False)), limit) for name, value, limit in _field_conditions(part, adheres)]
        for part in map(schema.in_memory, places)
    ]
    return [(same[0][0], float(np.max([value for _, value, _ in same])), same[0][2]) for same in zip(*rows)]


def _field_conditions(ds: xr.Dataset, adheres: bool) -> Iterator[tuple[str, xr.DataArray, float]]:
    """Yield name, values and limit of the conditions on pressure, displacement and gap of each state."""
    pressure, displacement, gap = (ds[name] for name in FIELDS)
    cell = float(ds["x"][1] - ds["x"][0])
    tolerance = ds.attrs.get("tolerance", np.nan)
    modulus = float(ds["contact_modulus"])
    film = film_of(ds, cell)
    windows: dict[str, Any] = {"input_core_dims": [_PLANE, [], []], "output_core_dims": [_PLANE]}
    windows["kwargs"] = {"film": film}
    elastic = xr.apply_ufunc(surface_displacement, pressure.fillna(0.0), cell, modulus, **windows)
    yield "elasticity", abs(elastic - displacement).max(_PLANE) / _divisor(abs(elastic).max(_PLANE)), _ROUNDING
    undeformed = gap - displacement + ds["delta"] + _residual_height(ds)
    states = [dim for dim in undeformed.dims if dim not in ("subregion", *_PLANE)]
    span = (undeformed.max(states, skipna=False) - undeformed.min(states, skipna=False)).max(_PLANE)
    yield "geometry", span / _divisor(abs(undeformed.where(gap.notnull())).max([*states, *_PLANE])), _ROUNDING
    if adheres:
        yield (
            "traction",
            _traction_violation(pressure, gap, _law_on_cells(ds, cell, modulus, film), cell / modulus),
            tolerance,
        )
    moves = abs(pressure).max(_PLANE) * cell / modulus
    depth = moves if adheres else (displacement - gap).max(_PLANE)
    yield "penetration", (-gap).max(_PLANE).clip(min=0) / _divisor(depth), tolerance
    forces = cell**2 * pressure
    if not adheres:
        product = (forces * np.abs(gap)).sum(_PLANE, min_count=1)
        yield "complementarity", product / _divisor(depth * ds["force"]), tolerance
    difference = abs(forces.sum(_PLANE, min_count=1) - ds["force"])
    yield "force_balance", difference / _divisor(abs(forces).sum(_PLANE)), _ROUNDING
    if "plastic_work" in ds:
        beyond = pressure.max(_PLANE) / float(ds["hardness"]) - 1
        yield "hardness", beyond.clip(min=0), _YIELD_TOLERANCE if adheres else _ROUNDING


def _residual_height(ds: xr.Dataset) -> xr.DataArray | float:
    """Return the residual height (nm) of each state; on retraction that of the largest displacement."""
    if "residual_height" not in ds:
        return 0.0
    left = ds["residual_height"]
    step = "load" if "load" in left.dims else "delta"
    return left.where(ds["branch"] == "loading", left.isel({step: -1}, drop=True))


def _law_on_cells(ds: xr.Dataset, cell: float, modulus: float, film: Film | None) -> SmoothLaw:
    """Return the law of adhesion on cells of a solution."""
    cells: Any = SimpleNamespace(dx=cell, contact_modulus=modulus, film=film)  # what the law reads of a problem
    law = pair_law(read_pair(ds), ds.attrs["law"])
    adhesion = Adhesion(preloads=np.zeros(0), refine=1, accuracy=np.nan, step=np.nan, **law)
    return law_on_cells(adhesion, cells)


def _traction_violation(pressure: xr.DataArray, gap: xr.DataArray, law: SmoothLaw, per_pressure: float) -> xr.DataArray:
    """Return the largest violation of p + t(g) = 0 out of contact, and of g = 0 in contact, over the largest traction.

    Lengths are in cells, the modulus is 1. Without range, cells that have never touched have no traction.
    """
    p = pressure * per_pressure
    traction = _traction(gap, law)
    difference = abs(p + traction)
    violation = xr.where(p + traction > 0.5 * gap, abs(gap), difference).where(gap.notnull())
    if law.exponential.size + law.waals.size == 0 and law.step.near == 0:
        violation = xr.where((abs(p) < difference) & ((p == 0) | (p + traction <= 0.5 * gap)), abs(p), violation)
    return violation.max(_PLANE) / np.maximum(law.strength, 0.1 * p.max(_PLANE))


def _traction(gap: xr.DataArray, law: SmoothLaw) -> xr.DataArray:
    """Return the traction across gaps, by formulas independent of the solver's kernel."""
    u = gap.clip(min=0)
    (e, v, s) = (law.exponential, law.waals, law.step)
    ratio = v.near / (v.near + u)
    decay: xr.DataArray = np.exp(-u / e.near)  # type: ignore[assignment]
    out = decay * (e.size / e.near) + 8 * v.size / (3 * v.near) * (ratio**3 - ratio**9)
    out = out + s.size * (1 - ((u - s.near) / (s.far - s.near)).clip(0, 1)) ** 2
    return out.where(u < law.range, 0.0)


def _divisor(scale: xr.DataArray) -> xr.DataArray:
    """Return the scale as a divisor: 1 without contact, NaN if unknown."""
    return scale.where(~(scale <= 0), 1.0)
