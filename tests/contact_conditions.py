"""The conditions of a contact, recomputed from pressure, displacement and gap by laws independent of the solver's."""

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import xarray as xr

import roughxr
from roughxr.mechanics.bodies.layer import film_of
from roughxr.mechanics.bodies.pair_record import read_pair
from roughxr.mechanics.contact.adhesion_on_cells import Adhesion, law_on_cells
from roughxr.mechanics.contact.adhesive_options import pair_law
from roughxr.mechanics.jobs.records import FIELDS
from roughxr.mechanics.kernels.adhesion.traction_laws import SmoothLaw
from roughxr.mechanics.kernels.halfspace.layered import Film
from roughxr.mechanics.kernels.halfspace.products import surface_displacement

#: Relative tolerance of sums and products.
ROUNDING = 1e-9

#: Relative tolerance of the pressure on a body that yields with adhesion.
YIELD_TOLERANCE = 1.1e-3

PLANE = ("x", "y")


def certificate_of_fields(solution: xr.Dataset) -> xr.Dataset:
    """Return the certificate of a solution and the conditions on its fields, with violation, limit and met.

    "elasticity": displacement less the convolution of the pressure, over the largest displacement. "geometry": the
    change of gap − displacement + δ between states, which the undeformed surfaces fix (needs two states at a place).
    "traction" (with adhesion): p + t(gap) out of contact and the gap in contact, over the largest traction.
    "penetration" and "complementarity" (pressure times gap; without adhesion): over the deepest overlap.
    "force_balance": force less Σ p dA. "hardness": the pressure beyond it.
    """
    certificate = roughxr.certificate(solution)
    if not set(FIELDS) <= set(solution):
        return certificate
    conditions = list(field_conditions(solution, solution.attrs["method"] == "adhesive"))
    rows = {
        "violation": [float(value.max(skipna=False)) for _, value, _ in conditions],
        "limit": [limit for _, _, limit in conditions],
    }
    names = [name for name, _, _ in conditions]
    fields = xr.Dataset({name: ("check", values) for name, values in rows.items()}, {"check": names})
    return xr.concat([certificate, fields.assign(met=fields.violation <= fields.limit)], "check")


def field_conditions(ds: xr.Dataset, adheres: bool) -> Iterator[tuple[str, xr.DataArray, float]]:
    """Yield name, values and limit of the conditions on pressure, displacement and gap of each state."""
    pressure, displacement, gap = (ds[name] for name in FIELDS)
    cell = float(ds["x"][1] - ds["x"][0])
    tolerance = ds.attrs.get("tolerance", np.nan)
    modulus = float(ds["contact_modulus"])
    layer = film_of(ds)
    film = None if layer is None else layer.on_cells(cell)
    windows = {"input_core_dims": [PLANE, [], []], "output_core_dims": [PLANE], "kwargs": {"film": film}}
    elastic = xr.apply_ufunc(surface_displacement, pressure.fillna(0.0), cell, modulus, **windows)
    yield "elasticity", abs(elastic - displacement).max(PLANE) / divisor(abs(elastic).max(PLANE)), ROUNDING
    undeformed = gap - displacement + ds["delta"] + residual_height(ds)
    states = [dim for dim in undeformed.dims if dim not in ("subregion", *PLANE)]
    span = (undeformed.max(states, skipna=False) - undeformed.min(states, skipna=False)).max(PLANE)
    yield "geometry", span / divisor(abs(undeformed.where(gap.notnull())).max([*states, *PLANE])), ROUNDING
    if adheres:
        law = law_of_solution(ds, cell, modulus, film)
        yield "traction", traction_violation(pressure, gap, law, cell / modulus), tolerance
    moves = abs(pressure).max(PLANE) * cell / modulus
    depth = moves if adheres else (displacement - gap).max(PLANE)
    yield "penetration", (-gap).max(PLANE).clip(min=0) / divisor(depth), tolerance
    forces = cell**2 * pressure
    if not adheres:
        product = (forces * np.abs(gap)).sum(PLANE, min_count=1)
        yield "complementarity", product / divisor(depth * ds["force"]), tolerance
    difference = abs(forces.sum(PLANE, min_count=1) - ds["force"])
    yield "force_balance", difference / divisor(abs(forces).sum(PLANE)), ROUNDING
    if "plastic_work" in ds:
        beyond = pressure.max(PLANE) / float(ds["hardness"]) - 1
        yield "hardness", beyond.clip(min=0), YIELD_TOLERANCE if adheres else ROUNDING


def residual_height(ds: xr.Dataset) -> xr.DataArray | float:
    """Return the residual height (nm) of each state; on retraction that of the largest displacement."""
    if "residual_height" not in ds:
        return 0.0
    height = ds["residual_height"]
    step = "load" if "load" in height.dims else "delta"
    return height.where(ds["branch"] == "loading", height.isel({step: -1}, drop=True))


def law_of_solution(ds: xr.Dataset, cell: float, modulus: float, film: Film | None) -> SmoothLaw:
    """Return the law of adhesion on cells of a solution."""
    cells = SimpleNamespace(dx=cell, contact_modulus=modulus, film=film)  # what the law reads of a problem
    law = pair_law(read_pair(ds), ds.attrs["law"])
    adhesion = Adhesion(preloads=np.zeros(0), refine=1, accuracy=np.nan, step=np.nan, **law)
    return law_on_cells(adhesion, cells)


def traction_violation(pressure: xr.DataArray, gap: xr.DataArray, law: SmoothLaw, per_pressure: float) -> xr.DataArray:
    """Return the largest violation of p + t(g) = 0 out of contact, and of g = 0 in contact, over the largest traction.

    Lengths are in cells, the modulus is 1. Without range, cells that have never touched have no traction.
    """
    p = pressure * per_pressure
    traction = law_traction(gap, law)
    difference = abs(p + traction)
    violation = xr.where(p + traction > 0.5 * gap, abs(gap), difference).where(gap.notnull())
    if law.exponential.size + law.waals.size == 0 and law.step.near == 0:
        violation = xr.where((abs(p) < difference) & ((p == 0) | (p + traction <= 0.5 * gap)), abs(p), violation)
    return violation.max(PLANE) / np.maximum(law.strength, 0.1 * p.max(PLANE))


def law_traction(gap: xr.DataArray, law: SmoothLaw) -> xr.DataArray:
    """Return the traction across gaps, by formulas independent of the solver's kernel."""
    u = gap.clip(min=0)
    e, v, s = (law.exponential, law.waals, law.step)
    ratio = v.near / (v.near + u)
    out = np.exp(-u / e.near) * (e.size / e.near) + 8 * v.size / (3 * v.near) * (ratio**3 - ratio**9)
    out = out + s.size * (1 - ((u - s.near) / (s.far - s.near)).clip(0, 1)) ** 2
    return out.where(u < law.range, 0.0)


def divisor(scale: xr.DataArray) -> xr.DataArray:
    """Return the scale as a divisor: 1 without contact, NaN if unknown."""
    return scale.where(~(scale <= 0), 1.0)
