"""How well a solution meets the conditions of its contact: each violation, with its limit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from ..jobs.records import FIELDS
from ..vocabulary import schema
from ..vocabulary.verbs import verb

#: What is only rounded may be off by this part; the pressure of a body that yields with adhesion by the second.
_ROUNDING, _YIELD_TOLERANCE = 1e-9, 1.1e-3

#: Relative error of a pull-off by mesh and step that is kept, unless the solution was asked for another.
_ACCURACY = 0.05

#: Methods whose solutions have conditions to keep.
SOLVED = ("direct", "adhesive", "rigid")
_PLANE = ("x", "y")


@verb
def certificate(ds: xr.Dataset) -> xr.Dataset:
    """Return by how much a solution violates the conditions of its contact, each with its limit, and print it.

    Parameters
    ----------
    ds : Dataset
        Of `direct`, `adhesive` or `rigid` at places. With fields the conditions are recomputed from these; without,
        the residual of the solves stands for them.

    Returns
    -------
    Dataset
        Along ``check``: ``found``, the largest over all places and states, its ``limit``, ``kept`` and ``words``; the
        attribute ``verdict`` names what is not kept. "unconverged" and "truncated" are shares of the solves;
        "residual", "penetration" and "complementarity" (pressure times gap over force times overlap, summed over the
        cells; not with adhesion, where pressure acts across gaps) parts of the deepest overlap, with adhesion of what
        the largest pressure moves one cell by; "force_balance" that of Σ p dA; "hardness" the pressure beyond it;
        "load" the force off the prescribed one; "mesh" the stated error of the pull-off. What is not known is NaN, and
        not kept.

    Raises
    ------
    ValueError
        If the Dataset is no such solution.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, young_modulus=75, poisson_ratio=0.2)
    >>> certificate(scan.contact.direct(load=[1000.0])).verdict  # doctest: +ELLIPSIS
    unconverged: 0 of at most 0, met
    residual: ... of at most 1e-06, met
    load: ... of at most 1e-06, met
    truncated: 0 of at most 0, met
    'all 4 conditions are met'
    """
    out = checked(ds)
    print("\n".join(out["words"].values))
    return out


def checked(ds: xr.Dataset) -> xr.Dataset:
    """Return the certificate of a solution."""
    method = ds.attrs.get("method")
    if method not in SOLVED or "converged" not in ds:
        raise ValueError(f"expected a solution of {', '.join(SOLVED)} along subregion, found method={method!r}")
    fields = set(FIELDS) <= set(ds) and method != "rigid"
    names, values, most = zip(*_of_solves(ds), *(_of_fields(ds, method == "adhesive") if fields else ()))
    found, limits = np.array([one.max(skipna=False) for one in values], float), np.array(most, float)
    kept = found <= limits
    words = [
        f"{name}: {value:.2g} of at most {limit:.2g}, {'met' if fine else 'NOT MET'}"
        for name, value, limit, fine in zip(names, found, limits, kept)
    ]
    rows = {"found": found, "limit": limits, "kept": kept, "words": words}
    out = xr.Dataset({name: ("check", values) for name, values in rows.items()}, {"check": list(names)})
    lost = ", ".join(out["check"].values[~kept])
    out.attrs = {"method": method, "verdict": f"not met: {lost}" if lost else f"all {kept.size} conditions are met"}
    return schema.record(schema.label(out), "certificate", ds)


def _of_solves(ds: xr.Dataset) -> Iterator[tuple[str, xr.DataArray, float]]:
    """Yield what the solves tell of themselves: the name of a check, its values and their limit."""
    tolerance = ds.attrs.get("tolerance", np.nan)
    yield "unconverged", 1 - ds["converged"].astype(bool).mean(), 0.0
    if "residual" in ds:
        yield "residual", ds["residual"], tolerance
    if "load" in ds.dims:
        yield "load", abs(ds["force"] / ds["load"] - 1), tolerance
    yield "truncated", ds["truncated"].astype(bool).mean(), 0.0
    for name in {"pull_off_error", "cell_error"} & set(ds):
        yield "mesh", abs(ds[name]), ds.attrs.get("accuracy", _ACCURACY)


def _of_fields(ds: xr.Dataset, adheres: bool) -> Iterator[tuple[str, xr.DataArray, float]]:
    """Yield what pressure, displacement and gap of each state tell."""
    pressure, displacement, gap = (ds[name] for name in FIELDS)
    cell, tolerance = float(ds["x"][1] - ds["x"][0]), ds.attrs.get("tolerance", np.nan)
    moves = abs(pressure).max(_PLANE) * cell / float(ds["contact_modulus"])
    depth = moves if adheres else (displacement - gap).max(_PLANE)
    yield "penetration", (-gap).max(_PLANE).clip(min=0) / _over(depth), tolerance
    forces = cell**2 * pressure
    if not adheres:
        product = (forces * np.abs(gap)).sum(_PLANE, min_count=1)
        yield "complementarity", product / _over(depth * ds["force"]), tolerance
    off = abs(forces.sum(_PLANE, min_count=1) - ds["force"])
    yield "force_balance", off / _over(abs(forces).sum(_PLANE)), _ROUNDING
    if "plastic_work" in ds:
        beyond = pressure.max(_PLANE) / float(ds["hardness"]) - 1
        yield "hardness", beyond.clip(min=0), _YIELD_TOLERANCE if adheres else _ROUNDING


def _over(scale: xr.DataArray) -> xr.DataArray:
    """Return a divisor: 1 where nothing touches, NaN where that is not known."""
    return scale.where(~(scale <= 0), 1.0)
