"""List the images in a file as one small Dataset."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary.units import factor
from .channel import Channel, is_length
from .files import file_hash, guarded, labelled, list_channels, reader_of, regular_file, sized
from .levelling import level
from .plausibility import doubts

_WORDS = {"name": "channel", "direction": "direction", "units": "units in the file"}
_NUMBERS = {
    "columns": ("1", "pixels along x"),
    "rows": ("1", "pixels along y"),
    "size_x": ("nm", "scan size along x"),
    "size_y": ("nm", "scan size along y"),
    "missing": ("1", "missing pixels"),
    "lowest": ("nm", "lowest height"),
    "highest": ("nm", "highest height"),
    "s_q": ("nm", "root mean square height S_q about the mean plane"),
}


def describe(path: str | os.PathLike) -> xr.Dataset:
    """Return what a file holds: one entry per image along ``channel``.

    Parameters
    ----------
    path : path

    Returns
    -------
    Dataset
        Name, direction and units of each image, its shape and size (nm), and, of heights, their range and roughness.

    Raises
    ------
    UnreadableScan, OSError, ImportError
        As :func:`open_scan`.

    Examples
    --------
    >>> import numpy as np, tempfile, os
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "a.txt")
    ...     np.savetxt(path, np.eye(4), header="Width: 2 um\\nHeight: 2 um\\nValue units: nm")
    ...     found = describe(path)
    >>> found.size_x.values, found.highest.values
    (array([2000.]), array([1.]))
    """
    path = regular_file(path)
    family, _ = reader_of(path)
    rows = [guarded(path, _described, channel, path) for channel in list_channels(path)]
    out = xr.Dataset(coords={"channel": np.arange(len(rows))})
    for name, words in _WORDS.items():
        out[name] = ("channel", [row[name] for row in rows], {"long_name": words})
    for name, (units, words) in _NUMBERS.items():
        out[name] = ("channel", [row.get(name, np.nan) for row in rows], {"long_name": words, "units": units})
    doubts_found = sorted({doubt for row in rows for doubt in row["doubts"]})
    return out.assign_attrs(
        source_file=path.name,
        source_format=rows[0]["format"] or family,
        source_sha256=file_hash(path),
        doubts="; ".join(doubts_found),
    )


def _described(channel: Channel, path: Path) -> dict[str, Any]:
    """Return the entries of one image; range and roughness of heights only."""
    values = channel.read()
    row = {
        "name": channel.name,
        "direction": channel.direction or "not stated",
        "units": channel.units or "not stated",
        "columns": channel.shape[1],
        "rows": channel.shape[0],
        "missing": int(np.isnan(values).sum()),
        "format": channel.header.get("format"),
        "doubts": [channel.doubt] if channel.doubt else [],
    }
    if channel.size and is_length(channel.lateral_units):
        row |= zip(("size_x", "size_y"), (v * factor(channel.lateral_units, "nm") for v in channel.size))
        if channel.is_length:
            relief = _relief(labelled(sized(channel, None, path), values, path), channel.is_topography)
            row |= relief | {"doubts": row["doubts"] + relief["doubts"]}
    return row


def _relief(ds: xr.Dataset, is_topography: bool) -> dict[str, Any]:
    return {
        "lowest": float(ds["height"].min()),
        "highest": float(ds["height"].max()),
        "s_q": float(level(ds)["height"].std()),
        "doubts": doubts(ds) if is_topography else [],
    }
