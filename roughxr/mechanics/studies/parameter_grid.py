"""`vary`: radii, moduli, works of adhesion and rough indenters as further dimensions of one result."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from inspect import ismethod
from typing import Any

import xarray as xr

from ..bodies import liquid
from ..bodies import pair as materials
from ..vocabulary import schema
from ..vocabulary.refusal import Refusal, shown
from ..vocabulary.units import Quantities

#: Options of xarray to join results along the varied parameters.
_TOGETHER: dict[str, Any] = {"join": "exact", "combine_attrs": "drop_conflicts", "data_vars": "all"}
_TOGETHER |= {"coords": "minimal", "compat": "override"}


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
        A scan, or an asperity catalogue if ``solve`` takes one, with an assigned pair.
    solve : callable
        `direct`, `superpose`, `pull_off_map`, `adhesive`, `rigid` or `rolling`; or your own function of a Dataset and
        options.
    sphere_radius, contact_modulus, work_of_adhesion : array_like, optional
        Values in nm, GPa and J/m², or texts with units, ascending; a parameter that is not given keeps its assigned
        value, without a dimension.
    humidity : array_like, optional
        Relative humidities between 0 and 0.99, ascending, for a humid pair.
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
        If nothing is varied, or ``delta`` is not stated where its default differs from pair to pair.

    References
    ----------
    Cheng, Dunn & Brach, eqs. 20–24 and 36–42, which depend on E* and w in this way.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius="3 um", materials="glass")
    >>> found = scan.contact.vary(
    ...     roughxr.superpose, contact_modulus=[30, 60], work_of_adhesion=[0.05, 0.1], delta=[5.0])
    >>> dict(found.force.sizes)
    {'contact_modulus': 2, 'work_of_adhesion': 2, 'subregion': 1, 'delta': 1}
    """
    ds = schema.entered_dataset(ds)
    _need_function(solve)
    varied = {
        "sphere_radius": sphere_radius,
        "contact_modulus": contact_modulus,
        "work_of_adhesion": work_of_adhesion,
        "humidity": humidity,
    }
    axes = {name: _values(values, name, ds) for name, values in varied.items() if values is not None}
    if not axes and indenter is None:
        raise Refusal("", f"values of {', '.join(varied)} or several of them", "none")
    _need_possible(ds, axes, options)
    parts: list[xr.Dataset] = []
    for placement, bodies in _each_placement(ds, indenter, axes):
        for values in itertools.product(*axes.values()):
            part = _solved(bodies, solve, dict(zip(axes, values)), options)
            parts.append(part if placement is None else part.expand_dims(placement=[placement]))
    if any("delta" in part.dims and not part["delta"].equals(parts[0]["delta"]) for part in parts):
        raise Refusal("delta", "displacements in nm, since their default differs from one pair to the next")
    out = xr.combine_by_coords(parts, **_TOGETHER)
    assert isinstance(out, xr.Dataset)
    recorded: dict[str, Any] = {"solve": getattr(solve, "__name__", type(solve).__name__), **axes}
    if indenter is not None:
        out = out.assign_coords(
            {name: indenter[name] for name in ("patch_x", "patch_y", "rotation") if name in indenter}
        )
        recorded["indenter"] = (schema.history(indenter)[-1:] or [{"arguments": "given"}])[0]["arguments"]
    return schema.record(schema.label(out), "vary", parts[0], **recorded)


def _need_function(solve: Any) -> None:
    """Raise where ``solve`` is the name or the result of a function, or a verb of one Dataset."""
    if not callable(solve):
        given = shown(solve) if isinstance(solve, str) else f"a {type(solve).__name__}"
        raise Refusal("solve", "a function, such as roughxr.adhesive without brackets", given)
    if ismethod(solve) and hasattr(solve, "__wrapped__"):
        raise Refusal("solve", "a function of any Dataset", "a verb of one Dataset", f"take roughxr.{solve.__name__}")


def _need_possible(ds: xr.Dataset, axes: dict[str, list[float]], options: dict[str, Any]) -> None:
    """Raise for a modulus where a layer has its own, and for fields of several radii."""
    if "contact_modulus" in axes and schema.is_coated(ds):
        raise Refusal("contact_modulus", "a half space", "a layer with its own moduli", "leave it out")
    if options.get("fields") and len(axes.get("sphere_radius", ())) > 1:
        raise Refusal(
            "fields",
            "one sphere_radius, since each has windows of its own size",
            len(axes["sphere_radius"]),
            "vary the other parameters, or leave the fields out",
        )


def _solved(ds: xr.Dataset, solve: Callable[..., xr.Dataset], pair: dict[str, float], options: dict[str, Any]):
    """Return the solution for one combination of parameters, with these as dimensions."""
    derived = liquid.humidity_coordinates(ds, pair["humidity"]) if "humidity" in pair else {}
    derived |= liquid.updated_liquid_share(ds, pair["work_of_adhesion"]) if "work_of_adhesion" in pair else {}
    bodies = ds.assign_coords(pair | derived)
    part = solve(bodies, **options).assign_coords(pair).expand_dims(list(pair))
    if "humidity" in pair:
        part = part.assign_coords(kelvin_radius=("humidity", [float(bodies["kelvin_radius"])]))
    if "share_under_liquid" in derived:
        part = part.assign_coords(share_under_liquid=("work_of_adhesion", [derived["share_under_liquid"]]))
    return part


def _each_placement(
    ds: xr.Dataset, indenter: xr.Dataset | None, axes: dict[str, Any]
) -> Iterator[tuple[Any, xr.Dataset]]:
    """Yield the pair as assigned, or with each placement of a rough indenter."""
    if indenter is None:
        yield None, ds
        return
    if "sphere_radius" in axes:
        raise Refusal("sphere_radius", "none with an indenter", "some", "take `placements` of another one")
    if not isinstance(indenter, xr.Dataset) or "placement" not in indenter.dims or "indenter_height" not in indenter:
        raise Refusal("indenter", "a Dataset from `placements`, with indenter_height along placement")
    bare = ds.drop_vars(["sphere_radius", "indenter_height", "indenter_x", "indenter_y"], errors="ignore")
    for k, placement in enumerate(indenter["placement"].values):
        yield (
            placement,
            bare.assign(indenter_height=indenter["indenter_height"].isel(placement=k).reset_coords(drop=True)),
        )


def _values(stated: Any, name: str, ds: xr.Dataset) -> list[float]:
    """Return the values of a parameter, ascending and plausible."""
    values = schema.ascending(stated, schema.VARIABLES[name].units, name).tolist()
    for value in values if name != "humidity" else ():
        materials.check_plausible(name, value, ds)
    return values
