"""The provenance of a Dataset: the history of operations that produced it, and the hash of a scan."""

from __future__ import annotations

import functools
import hashlib
import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, is_dataclass
from inspect import signature
from typing import Any, TypeVar, cast

import numpy as np
import xarray as xr

from ..._version import __version__

#: A line of the history: version, operation, arguments as name=JSON.
_LINE = re.compile(r"roughxr (\S+): (\w+)\((.*)\)")

_Verb = TypeVar("_Verb", bound=Callable[..., xr.Dataset])


def recorded_as(operation: str) -> Callable[[_Verb], _Verb]:
    """Return a decorator of functions whose result gets a step of this name, by `record`.

    The step has the arguments that are not the default. The history continues that of the first argument, if that is a
    Dataset or contains one as ``bodies``. Other Datasets are stated by a name.
    """

    def decorate(verb: _Verb) -> _Verb:
        parameters = signature(verb).parameters
        subject = next(iter(parameters))
        defaults = {name: _stated(parameter.default) for name, parameter in parameters.items()}

        @functools.wraps(verb)
        def recorded_verb(*arguments: Any, **options: Any) -> xr.Dataset:
            out = verb(*arguments, **options)
            given = dict(zip(parameters, arguments)) | options
            source = getattr(given[subject], "bodies", given[subject])
            if isinstance(source, xr.Dataset):
                del given[subject]
            in_order = {name: _stated(given[name]) for name in (*parameters, *options) if name in given}
            changed = {name: value for name, value in in_order.items() if value != defaults.get(name)}
            return record(out, operation, source if isinstance(source, xr.Dataset) else None, **changed)

        return cast(_Verb, recorded_verb)

    return decorate


def recorded(verb: _Verb) -> _Verb:
    """Return a function whose result has a further step in its history, the call: see `recorded_as`."""
    return recorded_as(verb.__name__)(verb)


def record(ds: xr.Dataset, operation: str, source: xr.Dataset | None = None, /, **arguments: Any) -> xr.Dataset:
    """Return a Dataset with one more step in its history: operation, arguments and roughxr's version.

    The attribute ``history`` has the form of the CF conventions, a line for each step; it continues that of ``source``,
    by default of ``ds``, whose ``title`` is kept, too, and that it is ``synthetic``. Arguments that are None are left
    out, arrays of more than 64 values shortened. Displacements state their datum.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> roughxr.schema.history(roughxr.schema.record(xr.Dataset(), "trim", size=3, edge=None))[0]["arguments"]
    {'size': 3}
    """
    attrs = (ds if source is None else source).attrs
    before = str(attrs.get("history", ""))
    stated = flat({key: _stated(value) for key, value in arguments.items()})
    call = ", ".join(f"{key}={json.dumps(value, ensure_ascii=False)}" for key, value in stated.items())
    line = f"roughxr {__version__}: {operation}({call})"
    inherited = {name: attrs[name] for name in ("title", "synthetic") if name in attrs}
    out = ds.assign_attrs({**inherited, **ds.attrs, "history": f"{before}\n{line}" if before else line})
    for name in out.variables if "datum" in out.attrs else ():
        if str(name).endswith("delta"):
            out[name].attrs["datum"] = out.attrs["datum"]
    return out


def _stated(value: Any) -> Any:
    """Return an argument as a step states it: a Dataset or an image by its file, its title or its size."""
    is_named = isinstance(value, xr.Dataset) or (isinstance(value, xr.DataArray) and value.ndim > 1)
    if not is_named:
        return as_json(value)
    sizes = ", ".join(f"{dim}: {size}" for dim, size in value.sizes.items())
    return str(value.attrs.get("source_file") or value.attrs.get("title") or f"{type(value).__name__} ({sizes})")


def flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping without inner mappings, whose values get names such as "mesh.cells", and without None."""
    out: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            out |= {f"{name}.{inner}": item for inner, item in flat(value).items()}
        elif value is not None:
            out[name] = value
    return out


def history(ds: xr.Dataset) -> list[dict[str, Any]]:
    """Return the steps that made a Dataset, oldest first: ``operation``, ``arguments`` and ``roughxr``, the version.

    A line by another program is a step "unknown".

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> recorded = roughxr.schema.record(roughxr.schema.record(xr.Dataset(), "level"), "crop")
    >>> [step["operation"] for step in roughxr.schema.history(recorded)]
    ['level', 'crop']
    """
    return [_step(line) for line in str(ds.attrs.get("history", "")).split("\n") if line.strip()]


def _step(line: str) -> dict[str, Any]:
    """Return the step that a line of the history states."""
    unknown = {"operation": "unknown", "arguments": {"history": line}}
    if not (match := _LINE.fullmatch(line)):
        return unknown
    version, operation, rest = match.groups()
    arguments = {}
    try:
        while rest:
            key, _, rest = rest.partition("=")
            arguments[key], end = json.JSONDecoder().raw_decode(rest)
            rest = rest[end:].removeprefix(", ")
    except (ValueError, RecursionError):
        return unknown
    return {"operation": operation, "arguments": arguments, "roughxr": version}


def height_hash(ds: xr.Dataset) -> str:
    """Return the SHA-256 of a scan's heights and axes: scans with the same hash are the same."""
    digest = hashlib.sha256()
    for name in ("x", "y", "height"):
        digest.update(np.ascontiguousarray(ds[name].values, dtype="<f8").tobytes())
    return digest.hexdigest()


def _first_last_size(values: np.ndarray) -> dict[str, Any]:
    return {"first": values.flat[0].item(), "last": values.flat[-1].item(), "size": int(values.size)}


def as_json(value: Any, long: Callable[[np.ndarray], Any] = _first_last_size) -> Any:
    """Return ``value`` in types of JSON; ``long`` converts arrays of more than 64 values."""
    if isinstance(value, xr.Dataset):
        value = {name: value[name].values for name in value.variables}
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {str(key): as_json(item, long) for key, item in value.items()}
    if isinstance(value, (str, bool, int, float)) or value is None:
        return value
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        return f"{value.magnitude} {value.units}"
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (np.ndarray, xr.DataArray)):
        values = np.asarray(value)
        return values.tolist() if values.size <= 64 else long(values)
    if isinstance(value, Iterable):
        return [as_json(item, long) for item in value]
    return str(value)
