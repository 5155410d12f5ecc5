"""Check the structure of a NetCDF-4 file in `reader_process`, before the caller's own process opens the file.

The C library follows groups that contain themselves until no memory is left, and then crashes.
"""

from __future__ import annotations

import math
import os
from typing import Any

#: Bytes of memory needed, library included: no values are read.
MEMORY = 2**29


#: Meaning of the library's error codes.
_IN_WORDS = {
    -51: "it is no NetCDF file",
    -101: "it is cut short or overwritten: its HDF5 content cannot be read",
}

#: The largest ratio of zlib's compression, and the size (bytes) up to which an array does no harm.
_PACKED, _SMALL = 1032, 2**28


def read(path: str) -> dict[str, Any]:
    """Return name, shape and units of all matrices of numbers in a file, after reading all groups and attributes."""
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            return {"images": _images(file, max(_PACKED * os.stat(path).st_size, _SMALL))}
    except OSError as error:
        raise ValueError(_IN_WORDS.get(error.errno or 0, str(error))) from error


def _images(group: Any, most: int) -> list[tuple[str, tuple[int, int], str]]:
    """Return the matrices in a group and below; raise if one declares more bytes than the file can hold."""
    images = []
    for holder in (group, *group.variables.values()):
        for name in holder.ncattrs():
            holder.getncattr(name)
    for name, variable in group.variables.items():
        length = getattr(variable.dtype, "itemsize", 1) * math.prod(variable.shape)
        if length > most:
            raise ValueError(f"{name}: {' x '.join(map(str, variable.shape))} values declared, too many for the file")
        if variable.ndim == 2 and getattr(variable.dtype, "kind", "") in ("f", "i", "u"):
            units = next((str(getattr(variable, key)) for key in ("units", "unit") if hasattr(variable, key)), "")
            images.append((f"{group.path.rstrip('/')}/{name}", (int(variable.shape[0]), int(variable.shape[1])), units))
    for child in group.groups.values():
        images += _images(child, most)
    return images
