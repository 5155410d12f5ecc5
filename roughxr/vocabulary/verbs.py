"""The decorator of every public verb, which converts all input to the units of the vocabulary's table.

Datasets and DataArrays are converted by the names of their variables, options by their own names: a pint quantity, text
such as "3 um", a DataArray with ``units``, or several of these. Plain numbers pass as they are.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from itertools import chain, repeat
from typing import Any, ParamSpec, TypeVar

import numpy as np
import xarray as xr

from .schema import VARIABLES, entered
from .text import warn as warn
from .units import carries_units, plain

_P = ParamSpec("_P")
_R = TypeVar("_R")

#: Units of options: of those named as variables are, and of the others.
OPTIONS = {name: known.units for name, known in VARIABLES.items() if known.units not in ("", "1")} | {
    "atomic_radius": "nm",
    "block": "nm",
    "closest_approach": "nm",
    "density": "kg/m^3",
    "friction_coefficient": "1",
    "gravity": "m/s^2",
    "length": "nm",
    "mark": "nm",
    "medium_density": "kg/m^3",
    "particle_density": "kg/m^3",
    "plane_spacing": "nm",
    "radius": "nm",
    "reach": "nm",
    "shear_strength": "GPa",
    "shift": "nm",
    "shortest": "nm",
    "shown": "nm",
    "smoothing": "nm",
    "spring_constant": "nN/nm",
    "step": "nm",
    "subregions": "nm",
    "surface_energy": "J/m^2",
    "viscosity": "m^2/s",
    "width": "nm",
    "young_modulus": "GPa",
}


def verb(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Return a public function whose Datasets and options enter in the units of the vocabulary's table."""
    names = list(inspect.signature(function).parameters)

    @functools.wraps(function)
    def called(*given: _P.args, **options: _P.kwargs) -> _R:
        arguments: Any = [_entered(value, name) for value, name in zip(given, chain(names, repeat("")))]
        return function(*arguments, **{name: _entered(value, name) for name, value in options.items()})

    return called


def _entered(value: Any, name: str) -> Any:
    """Return an argument in the table's units; itself where nothing is to convert."""
    if name in OPTIONS and carries_units(value):
        return _number(value, name)
    if isinstance(value, (xr.Dataset, xr.DataArray)):
        return entered(value)
    if isinstance(value, Mapping):
        parts = {key: _entered(one, str(key)) for key, one in value.items()}
        return value if all(parts[key] is value[key] for key in parts) else parts
    if isinstance(value, (list, tuple)):
        new = [_entered(one, "") for one in value]
        return value if all(one is other for one, other in zip(new, value)) else type(value)(new)
    return value


def _number(value: Any, name: str) -> Any:
    """Return an option that carries units as plain numbers; two scalars of ``subregions`` are one place."""
    if name == "subregions" and isinstance(value, (list, tuple)):
        return tuple(np.atleast_1d(plain(one, "nm", name)) if carries_units(one) else one for one in value)
    return plain(value, OPTIONS[name], name)
