"""List the images in a file as one small Dataset."""

from __future__ import annotations

import os
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.scans.levelling import level
from ...mechanics.scans.plausibility import ImplausibleScan, doubts
from ...mechanics.vocabulary import schema
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.units import factor
from .channel import Channel, file_name, is_length
from .recognition import call_naming_file, file_hash, labelled, list_channels, reader_of, regular_file, with_size


def describe(path: str | os.PathLike) -> xr.Dataset:
    """Return a list of the images in a file, along ``channel``.

    Parameters
    ----------
    path : path

    Returns
    -------
    Dataset
        Name, scan direction and units of each image, its shape and size (nm), and, of heights, their range and
        roughness.

    Raises
    ------
    UnreadableScan, OSError, ImportError
        As :func:`open_scan`.

    Examples
    --------
    >>> import tempfile
    >>> import roughxr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = roughxr.scans.to_file(roughxr.open_sample("glass"), folder + "/glass.gsf")
    ...     images = roughxr.scans.describe(path)
    >>> images.sizes["channel"]
    1
    """
    path = regular_file(path)
    family, _ = reader_of(path)
    rows = [call_naming_file(path, _described, channel, path) for channel in list_channels(path)]
    columns = {name: ("channel", [row[name] for row in rows]) for name in rows[0] if name not in ("format", "doubts")}
    out = schema.label(xr.Dataset(columns, {"channel": np.arange(len(rows))}))
    return out.assign_attrs(
        source_file=file_name(path),
        source_format=rows[0]["format"] or family,
        source_sha256=file_hash(path),
        doubts="; ".join(sorted({doubt for row in rows for doubt in row["doubts"]})),
    )


def _described(channel: Channel, path: Path) -> dict[str, Any]:
    """Return the properties of one image, with range and roughness for heights."""
    values = channel.read()
    row: dict[str, Any] = {
        "name": channel.name,
        "scan_direction": channel.direction or "not stated",
        "units": channel.units or "not stated",
        "columns": channel.shape[1],
        "rows": channel.shape[0],
        "size_x": np.nan,
        "size_y": np.nan,
        "missing": int(np.isnan(values).sum()),
        "lowest": np.nan,
        "highest": np.nan,
        "s_q": np.nan,
        "format": channel.header.get("format"),
        "doubts": [],
    }
    if channel.size and is_length(channel.lateral_units):
        row |= zip(("size_x", "size_y"), (v * factor(channel.lateral_units, "nm") for v in channel.size))
        if channel.is_length:
            ds = labelled(with_size(channel._replace(read=lambda: values), None, path), path)
            row |= {"lowest": float(ds["height"].min()), "highest": float(ds["height"].max())}
            with warnings.catch_warnings(), suppress(Refusal):  # listed as doubts; too few pixels for a plane
                warnings.simplefilter("ignore", ImplausibleScan)
                row["s_q"] = float(level(ds)["height"].std())
            row["doubts"] += map(str, doubts(ds) if channel.is_topography else [])
    return row
