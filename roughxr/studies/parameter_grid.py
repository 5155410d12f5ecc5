"""Runs over parameters: radii, moduli, works of adhesion and rough indenters as further dimensions of one result.

Where everything whose unit contains a mass (work of adhesion, hardness, a load) is the same in units of the
modulus, forces and pressures are proportional to E*: such combinations of the same radius share one solve.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from ..asperity.asperity_sum import fit_of
from ..asperity.catalogue import asperities
from ..bodies import liquid
from ..bodies import pair as materials
from ..vocabulary import schema
from ..vocabulary.units import Quantities, magnitude, mass_power
from ..vocabulary.verbs import OPTIONS, verb

#: Verbs that sum over asperities: a scan's catalogue is made once for all solves.
_OF_ASPERITIES = ("superpose", "pull_off_map", "rolling")

#: Verbs that read nothing but Datasets, the pair, options in `OPTIONS` and numbers without units: their results scale.
_SCALING = (*_OF_ASPERITIES, "direct", "adhesive", "rigid")

#: What contact without adhesion does not read.
_OF_ADHESION = ("work_of_adhesion", "hamaker_constant", "retardation", "adhesion_range")

#: How results are joined along what was varied.
_TOGETHER: dict[str, Any] = {"join": "exact", "combine_attrs": "drop_conflicts", "data_vars": "all"}
_TOGETHER |= {"coords": "minimal", "compat": "override"}


@verb
def vary(
    ds: xr.Dataset,
    solve: Callable[..., xr.Dataset],
    *,
    sphere_radius: Quantities | None = None,
    contact_modulus: Quantities | None = None,
    work_of_adhesion: Quantities | None = None,
    humidity: Quantities | None = None,
    indenter: xr.Dataset | None = None,
    **options: Any,
) -> xr.Dataset:
    """Solve for every combination of radii, moduli, works of adhesion, humidities and placements of a rough indenter.

    Parameters
    ----------
    ds : Dataset
        A scan, or an asperity catalogue where ``solve`` takes one, with an assigned pair.
    solve : callable
        `direct`, `superpose`, `pull_off_map`, `adhesive`, `rigid` or `rolling`; or your own function of a Dataset and
        options.
    sphere_radius, contact_modulus, work_of_adhesion : array_like, optional
        Values in nm, GPa and J/m², ascending; a parameter that is not given stays as assigned, without a dimension.
    humidity : array_like, optional
        Relative humidities between 0 and 0.99, ascending, for a humid pair: its liquid and temperature stay.
    indenter : Dataset, optional
        Result of `placements`, in place of the assigned sphere.
    **options
        Passed to ``solve``.

    Returns
    -------
    Dataset
        The result of ``solve`` with a dimension for each given parameter, and ``placement`` for an indenter.

    Raises
    ------
    ValueError
        If no parameter is given, one is not ascending or not positive (w may be 0), no pair is assigned, fields
        are asked for at several radii, or radii are given together with an indenter.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 20–24 and 36–42, which depend on E* and w in this way.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.assign_pair(roughxr.open_sample("glass"),
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> found = vary(scan, roughxr.superpose, contact_modulus=[30, 60], work_of_adhesion=[0.5, 1], delta=[5.0])
    >>> dict(found.force.sizes)
    {'contact_modulus': 2, 'work_of_adhesion': 2, 'subregion': 1, 'delta': 1}
    """
    given = {"sphere_radius": sphere_radius, "contact_modulus": contact_modulus, "work_of_adhesion": work_of_adhesion}
    given |= {"humidity": humidity}
    if indenter is not None:
        return _placed(ds, solve, indenter, given, options)
    axes = _axes(ds, given)
    if options.get("fields") and len(axes.get("sphere_radius", ())) > 1:
        raise ValueError(
            "fields: expected one sphere_radius, since each has windows of its own size, found "
            f"{len(axes['sphere_radius'])}; vary the other parameters, or leave the fields out"
        )
    varied = [name for name, values in given.items() if values is not None]
    if getattr(solve, "__name__", "") in _OF_ASPERITIES and "asperity" not in ds.dims:
        ds = asperities(ds, **fit_of(options.get("formulation")))
    solved: dict[tuple, xr.Dataset] = {}
    parts: list[xr.Dataset] = []
    for values in itertools.product(*axes.values()):
        pair = dict(zip(axes, values))
        wet = liquid.at_humidity(ds, pair["humidity"]) if "humidity" in pair else {}
        here = ds.assign_coords(pair | wet)
        key = _inputs(here, solve, options)
        if key not in solved:
            solved[key] = solve(here, **options)
        part = _scaled(solved[key], pair).expand_dims(varied)
        if humidity is not None:
            part = part.assign_coords(kelvin_radius=("humidity", [float(here["kelvin_radius"])]))
        parts.append(part)
    refuse_other_deltas(parts)
    out = xr.combine_by_coords(parts, **_TOGETHER)
    assert isinstance(out, xr.Dataset)
    arguments = {name: given[name] for name in varied}
    return schema.record(
        schema.label(out), "vary", parts[0], solve=getattr(solve, "__name__", "a function"), **arguments
    )


def _placed(ds: xr.Dataset, solve: Callable, indenter: xr.Dataset, given: dict[str, Any], options: dict[str, Any]):
    """Return the solutions for every placement of a rough indenter."""
    if given["sphere_radius"] is not None:
        raise ValueError(
            "sphere_radius: expected none beside an indenter, which brings its own; make `placements` of it"
        )
    if not isinstance(indenter, xr.Dataset) or "placement" not in indenter.dims or "indenter_height" not in indenter:
        raise ValueError("indenter: expected a Dataset from `placements`, with indenter_height along placement")
    others = {name: values for name, values in given.items() if values is not None}
    bare = ds.drop_vars(["sphere_radius", "indenter_height", "indenter_x", "indenter_y"], errors="ignore")
    parts = []
    for k in range(indenter.sizes["placement"]):
        face = indenter["indenter_height"].isel(placement=k).reset_coords(drop=True)
        pair = bare.assign(indenter_height=face)
        parts.append(vary(pair, solve, **others, **options) if others else solve(pair, **options))
    refuse_other_deltas(parts)
    out = xr.concat(parts, indenter["placement"].reset_coords(drop=True), **_TOGETHER)
    told = {name: indenter[name] for name in ("patch_x", "patch_y", "rotation") if name in indenter.coords}
    out = schema.label(out.assign_coords(told))
    made = schema.history(indenter)[-1:] or [{"arguments": "given"}]
    return schema.record(
        out, "vary", parts[0], solve=getattr(solve, "__name__", "a function"), indenter=made[0]["arguments"], **others
    )


def refuse_other_deltas(parts: list[xr.Dataset], of: str = "pair") -> None:
    """Raise where displacements must be given because their default differs from part to part."""
    if any("delta" in part.dims and not part["delta"].equals(parts[0]["delta"]) for part in parts):
        raise ValueError(f"delta: expected displacements in nm, since their default differs from one {of} to the next")


def _axes(ds: xr.Dataset, given: dict[str, Any]) -> dict[str, list[float]]:
    """Return the values of each parameter: those given, or the one assigned."""
    if all(values is None for values in given.values()):
        raise ValueError(f"expected values of {', '.join(given)} or several of them, found none")
    axes = {}
    for name, values in given.items():
        if values is not None:
            axes[name] = schema.ascending(values, schema.VARIABLES[name].units, name).tolist()
            for value in axes[name] if name != "humidity" else ():
                materials.check_plausible(name, value, ds)
        elif name in ds.coords:
            axes[name] = [float(ds[name])]
    return axes


def _inputs(ds: xr.Dataset, solve: Callable, options: dict[str, Any]) -> tuple:
    """Return what a solution depends on, in units of the modulus; pairs with the same of it differ by a factor only."""
    read = {name: float(one) for name, one in schema.travelling(ds).items()}
    modulus = read.get("contact_modulus", 1.0)
    if getattr(solve, "__name__", "") not in _SCALING or not solve.__module__.startswith("roughxr."):
        return tuple(read.items())
    if solve.__name__ == "direct" or options.get("law") == "hertz":
        read = {name: value for name, value in read.items() if name not in _OF_ADHESION}
    units = {name: OPTIONS[name] for name in options if options[name] is not None and name in OPTIONS}
    given = {name: magnitude(options[name], units[name], name) for name in units if mass_power(units[name])}
    every = [(name, value, schema.VARIABLES[name].units) for name, value in read.items()]
    every += [(name, value, units[name]) for name, values in given.items() for value in np.ravel(values).tolist()]
    return tuple((name, float(f"{value / modulus ** mass_power(unit):.13g}")) for name, value, unit in every)


def _scaled(solution: xr.Dataset, pair: dict[str, float]) -> xr.Dataset:
    """Return a solution for another modulus from the one that was solved, all else the same in units of the modulus."""
    factor = pair["contact_modulus"] / float(solution["contact_modulus"]) if "contact_modulus" in pair else 1.0
    if factor == 1.0:
        return solution.assign_coords(pair)
    powers = {name: mass_power(array.attrs.get("units") or "1") for name, array in solution.data_vars.items()}
    scaled = {
        name: (solution[name] * factor**power).assign_attrs(solution[name].attrs)
        for name, power in powers.items()
        if power
    }
    return solution.assign(scaled).assign_coords(pair)
