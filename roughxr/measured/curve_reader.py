"""Read force-distance curves through afmformats in `scans.reader_process`; imports nothing of roughxr.

The content of a file decides its format, not its name. The piezo's travel separates approach and retraction, since not
every format marks them.
"""

from __future__ import annotations

import os
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

#: afmformats' readers by the kind of file; the first that accepts the file is used.
_MODULES = {
    "zip": ("fmt_jpk", "fmt_workshop.ws_map"),
    "hdf5": ("fmt_hdf5",),
    "igor": ("fmt_igor",),
    "afmformats": ("fmt_tab",),
    "workshop": ("fmt_workshop.ws_single",),
    "chiaro": ("fmt_chiaro_txt",),
    "nt-mdt": ("fmt_ntmdt_txt",),
}

#: Columns of the travel, the sensor's first. In Chiaro's files "height (measured)" is an indentation.
_TRAVELS = {"chiaro": ("height (piezo)",)}
_TRAVEL = ("height (measured)", "height (piezo)")

#: Values of each curve's header that are returned.
_HEADER_VALUES = ("spring constant", "sensitivity", "position x", "position y")


def read(path: str, kind: str, known: dict[str, float], first: int = 0, last: int | None = None) -> dict[str, Any]:
    """Return the headers of a file of curves, or its curves from ``first`` to before ``last``."""
    from afmformats import errors

    stat = os.stat(path)
    try:
        name, read_by = _opened(path, kind, tuple(sorted(known.items())), stat.st_mtime_ns, stat.st_size)
        if last is None:
            return {"format": name, "curves": [_stated(curve["metadata"]) for curve in read_by]}
        return {"branches": [_branches(curve["data"], kind) for curve in read_by[first:last]]}
    except errors.MissingMetaDataError as error:
        return {"missing": list(error.meta_keys)}
    except errors.AFMFileFormatError as error:  # not a subclass of Exception
        raise ValueError(str(error)) from None


@lru_cache(maxsize=1)
def _opened(path: str, kind: str, known: tuple, *_state: int) -> tuple[str, list[dict[str, Any]]]:
    """Return the name of a file's format and its curves, with samples not read yet if the format allows."""
    from afmformats.formats import formats_available
    from afmformats.formats.fmt_jpk.jpk_reader import ArchiveCache

    ArchiveCache.open_archives.clear()  # afmformats caches by file name, also files that have changed since
    for module in _MODULES[kind]:
        recipe = next(
            recipe_class
            for recipe_class in formats_available
            if recipe_class.loader.__module__ == f"afmformats.formats.{module}"
        )
        if recipe.recipe.get("detect", lambda _: True)(Path(path)):
            return f"{recipe.maker} ({recipe.descr})", recipe.loader(Path(path), meta_override=dict(known))
    raise ValueError("expected force-distance curves, found none that afmformats can read")


def _stated(metadata: Any) -> dict[str, float]:
    return {name: float(metadata[name]) for name in _HEADER_VALUES if name in metadata and np.isfinite(metadata[name])}


def _branches(data: Any, kind: str) -> list[tuple[np.ndarray, np.ndarray] | None]:
    """Return the last approach and the retraction after it, or None for each."""
    names = list(data.keys())
    travel = next((name for name in _TRAVELS.get(kind, _TRAVEL) if name in names), None)
    if travel is None or "force" not in names:
        raise ValueError(f"expected a force and a height of the piezo, found columns {', '.join(sorted(names))}")
    piezo, force = (np.asarray(values, dtype=float) for values in (-np.asarray(data[travel]), data["force"]))
    if piezo.shape != force.shape:
        raise ValueError(f"expected as many heights as forces, found {piezo.size} and {force.size}")
    parts = _segments(piezo, np.asarray(data["segment"]) if "segment" in names else np.zeros(piezo.size))
    gains = [piezo[part][-1] - piezo[part][0] for part in parts]
    retraction = next((k for k in range(len(parts) - 1, -1, -1) if gains[k] < 0), None)
    approach = next(
        (k for k in range(len(parts) - 1 if retraction is None else retraction - 1, -1, -1) if gains[k] > 0), None
    )
    return [None if k is None else (piezo[parts[k]], force[parts[k]]) for k in (approach, retraction)]


def _segments(piezo: np.ndarray, number: np.ndarray) -> list[slice]:
    """Return the file's segments of a curve; split a single segment where the piezo turns back."""
    if piezo.size == 0:
        return []
    cuts = np.flatnonzero(np.diff(number)) + 1
    if cuts.size == 0:
        turn = int(np.nanargmax(piezo))
        cuts = np.array([turn + 1] if 0 < turn < piezo.size - 1 else [], dtype=int)
    ends = [0, *cuts.tolist(), piezo.size]
    return [slice(a, b) for a, b in pairwise(ends)]
