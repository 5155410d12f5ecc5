"""The contents of a roughxr Dataset: validation of input, labels of results, pixels and heights of a scan."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterable, Mapping
from inspect import signature
from typing import Any, TypeVar, cast

import numpy as np
import xarray as xr

from .provenance import height_hash, history, record, recorded, recorded_as  # noqa: F401
from .refusal import Refusal
from .table import KINDS, PAIR, TRAVELLING, VARIABLES, Variable, attributes, axis_label  # noqa: F401
from .text import did_you_mean, warn
from .units import converts, in_units, magnitude, single

_Verb = TypeVar("_Verb", bound=Callable[..., xr.Dataset])

#: Public names; the others are for roughxr's own functions.
__all__ = [
    "KINDS",
    "PAIR",
    "TRAVELLING",
    "VARIABLES",
    "Variable",
    "history",
    "kind_of",
    "label",
    "record",
    "validate",
]

#: Coordinates of an assigned pair that must be positive numbers; the work of adhesion may be 0.
_SIZES = {*PAIR, "adhesion_range", "hamaker_constant", "retardation", "hardness", "kelvin_radius", "surface_tension"}
_SIZES |= {"layer_thickness", "layer_modulus", "liquid_molecule"}

#: Smallest pixel and range of heights, nm: an atom is a hundred times as wide.
SMALLEST_LENGTH = 1e-3

#: Relief of the roughest scans in metres: smaller numbers are no nanometres.
_LARGEST_IN_METRES = 1e-4

#: How Datasets of a kind are made.
_MAKING = {
    "scan": "open a file by roughxr.open_scan, or make a scan of an array, xr.Dataset({'height': (('x', 'y'), "
    "heights)}, {'x': x, 'y': y}) with pixel centres x and y in nm",
    "moments": "pass the result of ds.contact.rolling()",
    "places": "pass the result of ds.contact.resting(), or of a solver",
    "critical_load": "pass the result of .contact.critical_load() of moments",
    "forces": "take .contact.pull_off() of a solution, or open a file of measured forces by roughxr.open_pull_off",
}

#: Choices of the origin of delta.
DATUMS = ("highest_peak", "first_contact")


def label(ds: xr.Dataset) -> xr.Dataset:
    """Return a Dataset with units, long name and meaning set on every variable of a known name.

    Variables that state other units of the same quantity are converted; other numbers are taken to be in the units of
    ``VARIABLES``, since arithmetic keeps the units of its first operand.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> roughxr.schema.label(xr.Dataset({"force": ("delta", [1.0])})).force.units
    'nN'
    >>> roughxr.schema.label(xr.Dataset({"force": ("delta", [1.0], {"units": "uN"})})).force.values
    array([1000.])
    """
    out = ds.copy()
    for name in VARIABLES.keys() & out.variables.keys():
        variable = out.variables[name]
        stated = str(variable.attrs.get("units", ""))
        if stated != VARIABLES[name].units and converts(stated, VARIABLES[name].units):
            out[name] = in_units(variable, VARIABLES[name].units, name)
        out.variables[name].attrs.update(attributes(name))
    return out


def kind_of(ds: xr.Dataset) -> str | None:
    """Return which of ``KINDS`` a Dataset is, by the names and dimensions of its variables, or None.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> roughxr.schema.kind_of(xr.Dataset({"height": (("x", "y"), [[0.0]])})), roughxr.schema.kind_of(xr.Dataset())
    ('scan', None)
    """
    for kind in ("asperities", "scan", "pull_off", "solution"):
        if all(name in ds and set(dims) <= set(ds[name].dims) for name, dims in KINDS[kind].items()):
            return kind
    return None


def in_package_units(data: Any) -> Any:
    """Return a Dataset or DataArray with every known variable in the units of ``VARIABLES``; other types unchanged."""
    if not isinstance(data, (xr.Dataset, xr.DataArray)):
        return data
    if isinstance(data, xr.DataArray):
        coords = _in_table(data.coords.variables)
        converted = _in_table({str(data.name): data.variable}).get(str(data.name))
        out = data if converted is None else data.copy(data=converted.data).assign_attrs(converted.attrs)
        return out.assign_coords(coords) if coords else out
    variables = _in_table(data.variables)
    pint_indexed = [name for name in variables if hasattr(data.xindexes.get(name), "units")]
    return data.drop_vars(pint_indexed).assign(variables) if variables else data


def in_memory(data: Any) -> Any:
    """Return a Dataset or DataArray with its values, computed in this process unless a cluster contains them.

    With an active client, dask would first send all heights to the scheduler.
    """
    distributed = sys.modules.get("distributed")
    if distributed is None:
        return data.compute()
    from dask.base import get_scheduler

    client = getattr(get_scheduler(), "__self__", None)  # of its bound method
    if not isinstance(client, distributed.Client) or distributed.client.futures_of(data):
        return data.compute()
    return data.compute(scheduler="threads")


def _in_table(variables: Mapping[Any, xr.Variable]) -> dict[str, xr.Variable]:
    """Return the variables whose units differ from the table's, converted."""
    units_of = {name: VARIABLES[name].units for name in variables if name in VARIABLES and VARIABLES[name].units}
    converted = {name: in_units(variables[name], units, name) for name, units in units_of.items()}
    return {name: variable for name, variable in converted.items() if variable is not variables[name]}


def validate(ds: Any, kind: str, what: str = "") -> xr.Dataset:
    """Return ``ds`` in roughxr's units and dimension order; raise where it is not of the kind.

    Parameters
    ----------
    ds : Dataset
    kind : {"scan", "asperities", "solution", "pull_off", "line", "moments", "critical_load", "forces", "places"}
    what : str, optional
        The argument's name, for errors.

    Returns
    -------
    Dataset
        In the units of ``VARIABLES``; a scan with ``height`` along (x, y).

    Raises
    ------
    ValueError
        If ``ds`` is no Dataset, or its variables, dimensions or units are not those of the kind.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> axes = {axis: (axis, [0.0, 1.0], {"units": "um"}) for axis in "xy"}
    >>> scan = xr.Dataset({"height": (("y", "x"), [[0.0, 5.0], [0.0, 0.0]], {"units": "nm"})}, axes)
    >>> valid = roughxr.schema.validate(scan, "scan")
    >>> valid.height.dims, valid.x.values.tolist()
    (('x', 'y'), [0.0, 1000.0])
    """
    need_dataset(ds, kind, what)
    for name, dims in KINDS[kind].items():
        if name not in ds:
            names = ", ".join(map(str, ds.data_vars)) or "none"
            raise Refusal(what or kind, f"a variable {name!r}", names, _MAKING.get(kind, ""))
        if not set(dims) <= set(ds[name].dims):
            raise Refusal(name, f"dimensions {dims}", tuple(ds[name].dims))
        if ds[name].dtype.kind not in "fiu":
            raise Refusal(
                name,
                "real numbers",
                f"values of type {ds[name].dtype}",
                f"if numbers are meant, convert them, for example ds[{name!r}].astype(float)",
            )
    ds = in_package_units(ds)
    if kind in ("scan", "asperities"):
        for name in _SIZES & set(ds.coords):
            _assigned(ds[name], name)
    return _validated_scan(ds) if kind == "scan" else ds


def verb(kind: str) -> Callable[[_Verb], _Verb]:
    """Return a decorator of functions of a Dataset of this kind, which is validated, and of others, in known units.

    The result gets a step in its history, see `recorded`. A "result" is any Dataset.
    """

    def decorate(function: _Verb) -> _Verb:
        parameters = tuple(signature(function).parameters)

        @functools.wraps(function)
        def checked(*arguments: Any, **options: Any) -> xr.Dataset:
            stated = dict(zip(parameters, arguments)) | options
            ds = stated.pop(parameters[0])
            valid = validate(ds, kind) if kind in KINDS else entered_dataset(ds, kind)
            return function(valid, **{name: in_package_units(value) for name, value in stated.items()})

        return recorded(cast(_Verb, checked))

    return decorate


def need_dataset(data: Any, kind: str = "scan", what: str = "") -> None:
    """Raise unless data are a Dataset."""
    if not isinstance(data, xr.Dataset):
        advice = _MAKING.get(kind, "pass what a function of roughxr returned, whole")
        raise Refusal(what, f"an xarray.Dataset of kind {kind!r}", type(data).__name__, advice)


def entered_dataset(data: Any, kind: str = "scan") -> xr.Dataset:
    """Return a Dataset as `in_package_units`; raise for other types."""
    need_dataset(data, kind)
    return in_package_units(data)


def _validated_scan(ds: xr.Dataset) -> xr.Dataset:
    """Return a scan with height as (x, y) in nm on uniform pixel centres."""
    others = [str(dim) for dim in ds["height"].dims if dim not in ("x", "y")]
    if others:
        raise Refusal(
            "height",
            "dimensions ('x', 'y')",
            f"({', '.join(map(str, ds['height'].dims))})",
            f"take one image, ds.isel({others[0]}=0), or each in turn",
        )
    steps = {}
    for axis in ("x", "y"):
        if axis not in ds.coords:
            raise Refusal(axis, "a coordinate of pixel centres in nm", "none", "assign one")
        steps[axis] = spacing(ds[axis])
        if steps[axis] < SMALLEST_LENGTH:
            raise Refusal(
                axis,
                f"pixels of at least {SMALLEST_LENGTH:g} nm",
                f"{steps[axis]:.3g} nm",
                f"state their units, for example ds[{axis!r}].attrs['units'] = 'm'",
            )
    height = ds["height"].variable
    checked = _float_heights(height if height.dims == ("x", "y") else height.transpose("x", "y"))
    out = ds.copy() if checked is height else ds.assign(height=checked)
    bare = [name for name in ("x", "y", "height") if not out[name].attrs.get("units")]
    if bare:  # state the size of the scan in nm, so that a wrong unit is noticed
        sides = " x ".join(f"{out.sizes[axis] * step:.4g}" for axis, step in steps.items())
        relief = np.nan if out.chunks else float(out["height"].max() - out["height"].min())
        heights = "" if out.chunks else f" and heights over {relief:.4g} nm"
        warn(
            f"{', '.join(bare)}: expected units, found none; taken as nm, a scan of {sides} nm{heights}. Set them, for "
            f"example ds[{bare[-1]!r}].attrs['units'] = 'm'"
        )
    for name in bare:
        out[name].attrs["units"] = "nm"
    return out


def _float_heights(height: xr.Variable) -> xr.Variable:
    """Return heights as floating-point numbers, whose squares do not overflow; raise for infinite ones."""
    if height.dtype.kind in "iu":
        return _float_heights(height.astype(float))
    data = height.data
    if not isinstance(data, np.ndarray):
        return height
    lowest = np.fmin.reduce(data, axis=None)
    highest = np.fmax.reduce(data, axis=None)
    if np.isinf([lowest, highest]).any():
        raise Refusal(
            "height",
            "finite heights",
            f"{np.isinf(data).sum()} infinite ones",
            "if they are missing, make them NaN, ds['height'].where(np.isfinite(ds['height'])), then ds.contact.fill()",
        )
    relief = float(highest - lowest)
    if 0 < relief < _LARGEST_IN_METRES:
        raise Refusal(
            "height",
            f"units and heights over at least {SMALLEST_LENGTH:g} nm",
            f"{height.attrs.get('units') or 'no units'} and {relief:.3g}",
            "state them, for example ds['height'].attrs['units'] = 'm'",
        )
    return height


def spacing(coordinate: xr.DataArray) -> float:
    """Return the pixel size along a coordinate; raise where it is not uniform."""
    values = np.asarray(coordinate.values, dtype=float)
    name = coordinate.name
    if values.size < 2:
        raise Refusal(name, "at least two pixels", values.size)
    steps = np.diff(values)
    step = (values[-1] - values[0]) / (values.size - 1)
    if not np.isfinite(values).all() or step <= 0 or np.abs(steps - step).max() > 1e-6 * abs(step):
        raise Refusal(
            name,
            "uniform, ascending pixel centres",
            f"steps from {steps.min():g} to {steps.max():g} nm",
            f"sort with .sortby({name!r}) or resample onto a uniform grid with .interp",
        )
    return float(step)


def pixel(ds: xr.Dataset) -> tuple[float, float]:
    """Return the pixel sizes (dx, dy) of a scan in nm."""
    return spacing(ds["x"]), spacing(ds["y"])


def is_square(dx: float, dy: float) -> bool:
    """Return whether pixels are square but for rounding."""
    return abs(dx - dy) <= 1e-6 * dx


def square_pixel(ds: xr.Dataset) -> float:
    """Return the pixel size of a scan in nm; raise where its pixels are not square."""
    dx, dy = pixel(ds)
    if not is_square(dx, dy):
        raise Refusal("", "square pixels", f"{dx:g} x {dy:g} nm", "resample first (roughxr.scans.resample)")
    return dx


def pair_coordinates(ds: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return the coordinates of the pair that a Dataset has, for results computed from it."""
    return {name: ds[name] for name in TRAVELLING if name in ds.coords}


def is_coated(ds: xr.Dataset) -> bool:
    """Return whether a layer is bonded to the scan's body."""
    return "layer_thickness" in ds.coords


def is_synthetic(ds: xr.Dataset) -> bool:
    """Return whether a scan, or the scan of a result, was generated and not measured: it has no real surface."""
    return ds.attrs.get("synthetic") == "yes"


def is_humid(ds: xr.Dataset) -> bool:
    """Return whether the pair of bodies carries condensed liquid, of menisci thicker than a molecule."""
    coords = ds.coords.variables
    return "kelvin_radius" in coords and bool(2 * coords["kelvin_radius"].max() > coords["liquid_molecule"])


def need_assigned(ds: xr.Dataset, *names: str) -> None:
    """Raise unless each of these values of the pair is assigned, as one plausible number."""
    refuse_unassigned([name for name in names if name not in ds.coords])
    for name in names:
        _assigned(ds[name], name)


def refuse_unassigned(missing: list[str]) -> None:
    """Raise if any values of the pair are missing."""
    if missing:
        raise Refusal(
            "",
            f"{', '.join(missing)} on the dataset",
            "no such coordinate",
            "assign the pair of bodies first, for example ds.contact.assign_pair(sphere_radius='3 um', "
            "materials='glass')",
        )


def sphere_radius(ds: xr.Dataset) -> float:
    """Return the radius (nm) of the assigned sphere; raise if there is none."""
    need_assigned(ds, "sphere_radius")
    return float(ds["sphere_radius"])


def _assigned(value: xr.DataArray, name: str) -> None:
    """Raise if a value of the pair has been made an array or implausible since assignment."""
    if value.ndim:
        raise Refusal(name, "one value", f"{value.size} along {value.dims}", "select or solve one at a time")
    adhesion = name == "work_of_adhesion"  # which may be none
    units = VARIABLES[name].units
    least = 0.0 if adhesion else np.nextafter(0.0, 1.0)
    expected = f"a number in {units} that is {'not negative' if adhesion else 'positive'}; assign the pair anew"
    single(value.item(), units, name, expected, lambda number: number >= least)


def finite(height: np.ndarray) -> np.ndarray:
    """Return a height map; raise where pixels are missing."""
    if missing := int(np.count_nonzero(~np.isfinite(height))):
        raise Refusal(
            "height",
            "finite heights",
            f"{missing} missing pixels of {height.size}",
            "fill them first (ds.contact.fill(), in a shell --fill linear) or crop them away "
            "(roughxr.scans.crop(ds, x=…, y=…))",
        )
    return height


def ascending(values: Any, units: str, name: str) -> np.ndarray:
    """Return values as a float array in ``units``; raise unless they are finite and ascending."""
    array = np.atleast_1d(np.asarray(magnitude(values, units, name), dtype=float))
    if array.ndim != 1 or array.size == 0:
        raise Refusal(name, f"at least one value in {units} along one dimension", f"shape {array.shape}")
    if (np.diff(array) <= 0).any():
        first = array[:-1][np.diff(array) <= 0][0]
        raise Refusal(name, "ascending values", f"{first:g} before a smaller or equal one", "sort them")
    return array


def refuse_unused(where: str, **given: Any) -> None:
    """Raise for options that were given, other than None, where they would change nothing."""
    for name, value in given.items():
        if value is not None:
            raise Refusal(name, f"none with {where}", f"{value!r}", "leave it out")


def one_of(value: Any, allowed: Iterable[str], name: str) -> str:
    """Return ``value``; raise with the known names where it is none of them."""
    allowed = tuple(allowed)
    if value not in allowed:
        raise Refusal(name, f"one of {', '.join(map(repr, allowed))}", f"{value!r}{did_you_mean(value, allowed)}")
    return value
