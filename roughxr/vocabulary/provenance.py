"""Where a Dataset comes from: the steps that made it, and what tells one scan from any other."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, is_dataclass
from typing import Any

import numpy as np
import xarray as xr

from .._version import __version__


def record(ds: xr.Dataset, operation: str, source: xr.Dataset | None = None, /, **arguments: Any) -> xr.Dataset:
    """Return a Dataset with one more step in its history: operation, arguments and roughxr's version.

    Parameters
    ----------
    ds : Dataset
    operation : str
        The function's name.
    source : Dataset, optional
        The Dataset whose history is continued; by default ``ds``.
    **arguments
        The function's arguments; None is left out, and arrays of more than 64 values are kept by their ends and
        size.

    Returns
    -------
    Dataset
        With the attribute ``history``, JSON text that `history` reads.

    Examples
    --------
    >>> history(record(xr.Dataset(), "trim", size=3, edge=None))[0]["arguments"]
    {'size': 3}
    """
    steps = history(ds if source is None else source)
    given = {key: value for key, value in arguments.items() if value is not None}
    steps.append({"operation": operation, "arguments": as_json(given), "roughxr": __version__})
    return ds.assign_attrs(history=json.dumps(steps))


def history(ds: xr.Dataset) -> list[dict[str, Any]]:
    """Return the steps that made a Dataset, oldest first.

    Parameters
    ----------
    ds : Dataset

    Returns
    -------
    list of dict
        For each step ``operation``, ``arguments`` and ``roughxr``, the version. A history by another program is one
        step "unknown".

    Examples
    --------
    >>> [step["operation"] for step in history(record(record(xr.Dataset(), "level"), "crop"))]
    ['level', 'crop']
    """
    text = str(ds.attrs.get("history", ""))
    try:
        steps = json.loads(text) if text else []
    except (ValueError, RecursionError):
        steps = None
    if isinstance(steps, list) and all(
        isinstance(one, dict) and isinstance(one.get("arguments", {}), dict) for one in steps
    ):
        return steps
    return [{"operation": "unknown", "arguments": {"history": text}}]


def arguments_of(ds: xr.Dataset | None, operation: str) -> dict[str, Any]:
    """Return the arguments of the last step of this name, none where there is no such step."""
    steps = [] if ds is None else history(ds)[::-1]
    return next((step.get("arguments", {}) for step in steps if step.get("operation") == operation), {})


def height_hash(ds: xr.Dataset) -> str:
    """Return the SHA-256 of a scan's heights and axes: scans with the same hash are the same."""
    digest = hashlib.sha256()
    for name in ("x", "y", "height"):
        digest.update(np.ascontiguousarray(ds[name].values, dtype="<f8").tobytes())
    return digest.hexdigest()


def _ends(values: np.ndarray) -> dict[str, Any]:
    return {"first": values.flat[0].item(), "last": values.flat[-1].item(), "size": int(values.size)}


def as_json(value: Any, long: Callable[[np.ndarray], Any] = _ends) -> Any:
    """Return ``value`` as something JSON can hold; arrays of more than 64 values as ``long`` shortens them."""
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
