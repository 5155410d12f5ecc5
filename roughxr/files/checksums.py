"""Checksums of all that an archive holds, kept in its root: HDF5 has none for attributes and unchunked values.

Each group has one for its names, sizes and attributes, and one for the values of each variable; a field, which is read
in parts, has one for each part.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Hashable, Iterable, Iterator
from typing import Any

import netCDF4
import numpy as np

#: Attribute of the root that holds them.
ATTRIBUTE = "checksums"

#: Key, among those of a group's variables, for names, sizes and attributes.
_OTHER = ""

#: Values are read so many bytes at a time.
_BYTES = 2**26


def write(file: netCDF4.Dataset) -> None:
    """Store the checksums of an archive that is open for writing: of its root, and of the groups that have none yet."""
    kept = _kept(file) if ATTRIBUTE in file.ncattrs() else {}
    new = {group.path: _of(group, parts=True) for group in _groups(file) if group is file or group.path not in kept}
    file.setncattr(ATTRIBUTE, json.dumps(kept | new))


def read(file: netCDF4.Dataset) -> dict[str, dict[str, Any]]:
    """Return the checksums that an archive keeps, once all but those of its fields are verified.

    Empty for a file that keeps none.
    """
    if ATTRIBUTE not in file.ncattrs():
        return {}
    kept, groups = _kept(file), {group.path: group for group in _groups(file)}
    for path, expected in kept.items():
        if path not in groups:
            raise ValueError(path)
        stored = _of(groups[path], parts=False)
        for name in expected | stored:
            same = stored.get(name) == expected.get(name)
            if not same and not _as_many(stored.get(name), expected.get(name)):
                raise ValueError(f"{path.rstrip('/')}/{name}")
    return kept


def _as_many(parts: Any, kept: Any) -> bool:
    """Return whether there is a checksum for each part of a field."""
    return isinstance(parts, int) and isinstance(kept, list) and len(kept) == parts


def _kept(file: netCDF4.Dataset) -> dict[str, dict[str, Any]]:
    """Return what the attribute holds."""
    try:
        kept = json.loads(file.getncattr(ATTRIBUTE))
        if all(isinstance(name, str) for checksums in kept.values() for name in checksums):
            return kept
    except (AttributeError, TypeError, ValueError):
        pass
    raise ValueError(ATTRIBUTE)


def _groups(group: netCDF4.Dataset) -> Iterator[netCDF4.Dataset]:
    yield group
    for child in group.groups.values():
        yield from _groups(child)


def _of(group: netCDF4.Dataset, *, parts: bool) -> dict[str, Any]:
    """Return the checksums of a group; of fields those of all parts, or just the number of parts."""
    said = [repr(sorted((name, len(dim)) for name, dim in group.dimensions.items())).encode(), *_attributes(group)]
    sums: dict[str, Any] = {}
    for name, variable in sorted(group.variables.items()):
        variable.set_auto_maskandscale(False)
        variable.set_auto_chartostring(False)
        said += [repr((name, str(variable.dtype), variable.dimensions)).encode(), *_attributes(variable)]
        if not is_field(variable.dimensions, variable.dtype):
            sums[name] = _digest(_slabs(variable))
        elif parts:
            sums[name] = [part for slab in _slabs(variable) for part in of_planes(slab, variable.dimensions)]
        else:
            sums[name] = math.prod(variable.shape[: planes_from(variable.dimensions)])
    return {_OTHER: _digest(said), **sums}


def is_field(dims: tuple[Hashable, ...], dtype: Any) -> bool:
    """Return whether a variable is read in parts: numbers over a plane for each of several places."""
    return dims[:1] == ("subregion",) and "x" in dims and getattr(dtype, "kind", "") == "f"


def of_planes(values: np.ndarray, dims: tuple[Hashable, ...]) -> list[str]:
    """Return the checksum of each plane of a field, in their order."""
    shape = values.shape[planes_from(dims) - len(dims) :]
    return [_digest([plane]) for plane in values.reshape(math.prod(values.shape) // max(math.prod(shape), 1), *shape)]


def planes_from(dims: tuple[Hashable, ...]) -> int:
    """Return the number of dimensions before those of a plane."""
    return min(dims.index(dim) for dim in "xy" if dim in dims)


def _slabs(variable: netCDF4.Variable) -> Iterator[np.ndarray]:
    """Yield the stored values, some rows at a time."""
    if not variable.shape or getattr(variable.dtype, "kind", "O") not in "fiuSb":
        yield variable[...]
        return
    rows = max(_BYTES // max(variable.dtype.itemsize * math.prod(variable.shape[1:]), 1), 1)
    for first in range(0, variable.shape[0], rows):
        yield variable[first : first + rows]


def _attributes(holder: Any) -> Iterator[bytes]:
    """Yield the attributes of a group or variable but for the checksums themselves."""
    for name in sorted(holder.ncattrs()):
        value = holder.getncattr(name)
        if name != ATTRIBUTE:
            yield repr((name, value if isinstance(value, str) else np.asarray(value).tolist())).encode()


def _digest(pieces: Iterable[Any]) -> str:
    """Return a checksum of bytes and arrays one after the other; every NaN is the same."""
    digest = hashlib.blake2b(digest_size=8)
    for piece in pieces:
        if isinstance(piece, np.ndarray) and piece.dtype.kind == "f":
            piece = np.where(np.isnan(piece), np.nan, piece).astype(piece.dtype.newbyteorder("<"), copy=False)
        elif isinstance(piece, (str, np.ndarray)) and getattr(piece, "dtype", np.dtype(object)).kind == "O":
            piece = repr(np.asarray(piece, dtype=object).tolist()).encode()
        digest.update(piece if isinstance(piece, bytes) else np.ascontiguousarray(piece).tobytes())
    return digest.hexdigest()
