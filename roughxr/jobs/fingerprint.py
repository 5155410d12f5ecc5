"""What identifies a run: the scan, the arguments, and roughxr's version."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import dask
import numpy as np
import xarray as xr

from .._version import __version__
from ..vocabulary import schema
from ..vocabulary.provenance import as_json
from .work import Work

#: Longer texts are cut in messages.
_LONGEST_TEXT = 120


def identity(scan: xr.Dataset, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return the identity of a run: plain values, by name."""
    known: dict[str, Any] = {"scan": _name(scan), "scan_sha256": schema.height_hash(scan)}
    known |= {name: float(scan[name]) for name in schema.TRAVELLING if name in scan.coords}
    if "indenter_height" in scan:
        known["indenter"] = dask.base.tokenize(*(scan[f"indenter_{part}"].values for part in ("x", "y", "height")))
    known |= {key: as_json(value, _with_hash) for key, value in arguments.items()}
    return json.loads(json.dumps({**known, "roughxr": __version__}))


def _name(scan: xr.Dataset) -> str:
    names = (scan.attrs.get(key) for key in ("title", "source_file", "source"))
    return next((str(name) for name in names if name), "scan without a title")


def _with_hash(array: np.ndarray) -> str:
    """Return a description of a long array that no other array shares."""
    return f"{array.size} values from {array.flat[0]:g} to {array.flat[-1]:g}, {dask.base.tokenize(array)[:12]}"


def refuse_other(found: Mapping[str, Any], asked: Mapping[str, Any], path: Path) -> None:
    """Raise if the run on disk is not the one asked for, and say how they differ."""
    different = [key for key in (*asked, *(k for k in found if k not in asked)) if found.get(key) != asked.get(key)]
    if different:
        raise ValueError(
            f"{path} holds another run: expected {_listed(asked, different)}; found {_listed(found, different)}; "
            "give the output another name, or remove the file"
        )


def _listed(values: Mapping[str, Any], keys: list[str]) -> str:
    texts = (f"{key}={values.get(key)!r}" for key in keys)
    return ", ".join(text if len(text) <= _LONGEST_TEXT else f"{text[:_LONGEST_TEXT]}…" for text in texts)


def keys_of(work: Work) -> tuple[str, list[bytes]]:
    """Return a hash of everything that the results of ``work`` depend on, and one for the result of each item.

    Plain numbers, of which each subregion has some, are hashed as text: dask's tokens for them all took a tenth of a
    run of 2304 subregions on two threads.
    """
    with dask.config.set({"tokenize.ensure-deterministic": True}):
        common = _hash(f"{work.task.__module__}.{work.task.__qualname__} {work.dtype} {_text(work.shared)}".encode())
        items = [_hash(common + _text(values).encode()) for values in work.arguments]
    return _hash(common + b"".join(items)).hex(), items


def _hash(text: bytes) -> bytes:
    return hashlib.blake2b(text, digest_size=16).digest()


def _text(values: tuple) -> str:
    return repr([value if _is_plain(value) else dask.base.tokenize(value) for value in values])


def _is_plain(value: Any) -> bool:
    """Return whether a value is fully described by its text."""
    if isinstance(value, tuple):
        return all(map(_is_plain, value))
    return value is None or isinstance(value, (int, float, str, slice, np.number, np.bool_))
