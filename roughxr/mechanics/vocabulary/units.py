"""Conversion of input by pint to the units of roughxr: nm, nN, GPa, J/m²."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import lru_cache
from numbers import Real
from typing import Any, SupportsFloat, TypeAlias

import numpy as np
import xarray as xr

from .refusal import Refusal, shown

#: A number in the documented units, text such as "3 um", or a pint quantity.
Quantity: TypeAlias = SupportsFloat | str

#: One or several quantities.
Quantities: TypeAlias = Quantity | Sequence[Quantity] | np.ndarray | xr.DataArray

#: Contact centres: a grid (nx, ny), x and y of the centres (nm), or a Dataset that has centres, see `centres`.
Places: TypeAlias = Sequence[int] | Sequence[Quantities] | xr.Dataset | None

# Powers without an operator, "J m-2", which UDUNITS reads and pint does not; not the power of ten in "6.5e-20 J".
_UDUNITS_POWER = re.compile(r"(?<![\d.][eE])(?<=[A-Za-zµμ])(?=[-+]?\d)")


#: Text that can be units: letters, powers, products and quotients; pint would read "~m" as 1/m.
_UNIT_TEXT = re.compile(r"[\w\s.*/^()°ÅµμΩ%+-]+")


#: The beginning of a quantity in words, its number: pint would read "um" as one micrometre, and a date as a difference.
_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")


@lru_cache(maxsize=1)
def _registry():
    import pint  # not at the top: it takes a third of the import time and plain numbers never need it

    return pint.UnitRegistry(preprocessors=[lambda text: _UDUNITS_POWER.sub("**", text)], cache_folder=None)


@lru_cache(maxsize=256)
def factor(source: str, target: str) -> float:
    """Return the factor that converts values in ``source`` units to ``target`` units."""
    import pint

    if source == target:
        return 1.0
    try:
        if not _UNIT_TEXT.fullmatch(source):
            raise ValueError
        ratio = float(_registry().Quantity(1.0, source).to(target).magnitude)
    except (pint.errors.PintError, pint.errors.UndefinedUnitError, AttributeError, TypeError, ValueError):
        raise Refusal("", f"units that convert to {target!r}", f"{source!r}") from None
    return float(f"{ratio:.15g}")  # 1000.0000000000001 nm per um would spoil exact coordinates


def converts(source: str | None, target: str) -> bool:
    """Return whether values in ``source`` units convert to ``target`` units; no units do not."""
    if not source or not target:
        return False
    try:
        return factor(source, target) > 0
    except ValueError:
        return False


def magnitude(value: Any, units: str, name: str) -> Any:
    """Return ``value`` as plain float(s) in ``units``."""
    number = plain(value, units, name)
    try:
        number = np.asarray(number)
        if number.dtype == bool:
            raise ValueError("a flag is no quantity")
        number = number.astype(float)
    except (TypeError, ValueError):
        raise Refusal(name, f"a number in {units}", shown(value)) from None
    if not np.isfinite(number).all():
        raise Refusal(name, f"finite numbers in {units}", shown(value))
    return float(number) if number.ndim == 0 else number


def carries_units(value: Any) -> bool:
    """Return whether a value, or one of several, states its units: a quantity, text with a number, a DataArray."""
    if isinstance(value, str):
        return bool(_NUMBER.match(value))
    if isinstance(value, (list, tuple)):
        return any(carries_units(item) for item in value)
    return isinstance(value, xr.DataArray) or (hasattr(value, "magnitude") and hasattr(value, "units"))


def plain(value: Any, units: str, name: str) -> Any:
    """Return ``value`` converted to ``units`` if it states units, else unchanged."""
    if isinstance(value, (list, tuple)) and carries_units(value):
        return [plain(item, units, name) for item in value]
    if isinstance(value, (Real, np.ndarray, list, tuple, range)):
        return value
    stated = value
    try:
        if isinstance(value, str):
            value = _quantity(value, units)
            if value.unitless and units != "1":
                return value.magnitude
        if isinstance(value, xr.DataArray):
            return in_units(value.variable, units, name).values
        if hasattr(value, "magnitude") and hasattr(value, "units"):
            return value.magnitude * factor(f"{value.units}", units)
    except Refusal as error:
        shown_input = error.found if not isinstance(stated, str) or stated in error.found else shown(stated)
        raise Refusal(name, error.expected, shown_input, error.advice) from None
    except Exception as error:
        raise Refusal(name, f"a quantity such as '3 {units}'", f"{value!r} ({error})") from None
    return value


def _quantity(text: str, units: str) -> Any:
    """Return the quantity that a text states; raise for a decimal comma, or for anything but a number and units."""
    if re.match(r"\s*[-+]?\d*,\d", text):
        raise Refusal("", "a decimal point", f"a comma in {text!r}")
    number = _NUMBER.match(text)
    if not number:
        expected = "a number, or per cent as '90 %'" if units == "1" else f"a number with its units such as '3 {units}'"
        raise Refusal("", expected, f"{text!r}")
    return _registry().Quantity(float(number[0]), _registry().parse_units(text[number.end() :]))


def single(value: Any, units: str, name: str, words: str, fits: Callable[[float], bool]) -> float:
    """Return ``value`` as one float in ``units``; raise, with ``words``, unless it is one number and ``fits`` it."""
    number = magnitude(value, units, name)
    if not isinstance(number, float) or not fits(number):
        raise Refusal(name, words, shown(value))
    return number


def positive(value: Any, units: str, name: str) -> float:
    """Return ``value`` as one float in ``units``; raise unless it is a single positive number."""
    return single(value, units, name, f"one positive number in {units}", lambda number: number > 0)


def is_whole(value: Any) -> bool:
    """Return whether ``value`` is an integer, not a bool."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def whole_number(value: Any, name: str, *, least: int, most: int | None = None) -> int:
    """Return ``value`` as an int; raise unless it is a whole number between bounds."""
    if not is_whole(value) or value < least or (most is not None and value > most):
        bounds = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise Refusal(name, f"a whole number {bounds}", shown(value))
    return int(value)


def fraction(value: Any, name: str) -> float:
    """Return ``value`` as a float; raise unless it lies between 0 and 1."""
    words = "a number between 0 and 1, such as 0.9 or '90 %'"
    return single(value, "1", name, words, lambda number: 0 < number < 1)


def in_units(variable: xr.Variable, units: str, name: str) -> xr.Variable:
    """Return a variable in ``units``, converted if it states others; lazy data stay lazy."""
    stated = variable.attrs.get("units")
    if stated == units or variable.dtype.kind not in "fiu":
        return variable
    data = variable.data if stated is None else None  # a file's data are not read for what its attributes say
    own_units = getattr(data, "units", None)
    if not stated and own_units is None:
        return variable
    stated = str(own_units if stated is None else stated)
    try:
        ratio = factor(stated, units)
    except ValueError:
        raise Refusal(
            name,
            f"units that convert to {units!r}",
            f"{stated!r}",
            "correct its attribute 'units', or rename what is something else",
        ) from None
    if data is None and ratio == 1.0:
        out = variable.copy(deep=False)
        out.attrs = {**variable.attrs, "units": units}
        return out
    data = variable.data if data is None else data.magnitude
    return xr.Variable(variable.dims, data * ratio if ratio != 1.0 else data, {**variable.attrs, "units": units})


def converted(array: xr.DataArray, units: str, name: str) -> xr.DataArray:
    """Return ``array`` in ``units``, lazily where it is lazy; raise where its ``units`` are missing or wrong."""
    if not array.attrs.get("units"):
        raise Refusal(
            name,
            f"a 'units' attribute that converts to {units!r}",
            "none",
            f"set it, for example ds[{name!r}].attrs['units'] = {units!r}",
        )
    variable = in_units(array.variable, units, name)
    return array if variable is array.variable else array.copy(data=variable.data).assign_attrs(variable.attrs)
