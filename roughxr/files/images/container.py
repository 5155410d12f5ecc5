"""Containers of contact.engineering: the zip file of a published surface, with maps, lines and metadata.

``index.json`` or ``meta.yml`` lists the topographies of each surface, with the names of their files. A file
``squeezed-netcdf`` contains the heights as contact.engineering shows them; otherwise the instrument's own file is read,
and levelled as stated.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
import zipfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.scans.levelling import level
from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.schema import label, record
from ...mechanics.vocabulary.units import factor
from .channel import UnreadableScan, file_name, first_bytes
from .force_curve_formats import METADATA
from .netcdf import is_netcdf, unread
from .recognition import call_naming_file, file_hash, list_channels, read_scan, regular_file

#: Largest size of the metadata, bytes: JSON, and YAML, which takes ten seconds a megabyte.
_LARGEST_METADATA = {"index.json": 2**24, "meta.yml": 2**19}

#: Attributes of a topography, and their names in a container.
_STATED = {"title": "name", "description": "description", "detrend_mode": "detrend_mode"}

#: Polynomials that are subtracted: their order along a line, and the method for a map.
_DETRENDED = {"center": (0, None), "height": (1, "plane"), "curvature": (2, "quadratic")}


def open_container(path: str | os.PathLike) -> list[xr.Dataset]:
    """Open all topographies of a container of contact.engineering.

    Parameters
    ----------
    path : str or path
        The zip file that is downloaded from a published surface.

    Returns
    -------
    list of Dataset
        In the container's order, in memory: maps as scans, as of `open_scan`, and line profiles as ``height`` (x), nm,
        levelled as the container states. Attributes ``surface``, ``title``, ``description``, ``detrend_mode``.

    Raises
    ------
    UnreadableScan
        If the file is no such container or damaged, or contains a file that cannot be read. See `open_scan`.

    Notes
    -----
    The container's factor on heights is applied to files of bare numbers only; other files state their own.

    References
    ----------
    Röttger et al., Contact.engineering: create, analyze and publish digital surface twins from topography measurements
    across many scales, Surf. Topogr.: Metrol. Prop. 10 (2022) 035032, doi:10.1088/2051-672X/ac860a.

    Examples
    --------
    >>> from pathlib import Path
    >>> import json
    >>> import tempfile
    >>> import zipfile
    >>> import roughxr
    >>> one = {"name": "ridge", "size": [30.0], "unit": "um", "datafile": {"original": "ridge.txt"}}
    >>> path = Path(tempfile.mkdtemp()) / "surface.zip"
    >>> with zipfile.ZipFile(path, "w") as archive:
    ...     archive.writestr("ridge.txt", "0 0\\n10 0.1\\n30 0\\n")
    ...     archive.writestr("meta.yml", json.dumps({"surfaces": [{"topographies": [one]}]}))
    >>> roughxr.scans.open_container(path)[0].height.values.round(6)
    array([-33.333333,  66.666667, -33.333333])
    """
    path = regular_file(path)
    if not zipfile.is_zipfile(path):
        raise UnreadableScan(path, "the zip file of a container of contact.engineering", "no zip file")
    return call_naming_file(path, _read_topographies, path)


def _read_topographies(path: Path) -> list[xr.Dataset]:
    origin = {"source_file": file_name(path), "source_sha256": file_hash(path), "source_format": "contact.engineering"}
    topographies = []
    with zipfile.ZipFile(path) as archive:
        surfaces = _metadata(archive, path)["surfaces"]
        names = Counter(_member_name(entry) for surface in surfaces for entry in surface["topographies"])
        for name, count in names.most_common(1):
            # number of topographies that may be channels of one file
            if count > 16:
                raise UnreadableScan(path, "each file once", f"{name!r} {count:,} times: damaged")
        for number, surface in enumerate(surfaces):
            for entry in surface["topographies"]:
                ds = _topography(archive, entry, path)
                stated = {"surface": surface.get("name", number)}
                stated |= {name: entry.get(key) for name, key in _STATED.items()}
                ds.attrs |= origin | {
                    name: str(value) for name, value in stated.items() if isinstance(value, (str, int))
                }
                step = {"file": file_name(path), "title": ds.attrs.get("title", "")}
                topographies.append(record(label(ds), "open_container", **step))
    return topographies


def _metadata(archive: zipfile.ZipFile, path: Path) -> dict[str, Any]:
    """Return a container's metadata as plain lists, mappings, text and numbers."""
    name = next((name for name in METADATA if name in archive.namelist()), None)
    if name is None:
        raise UnreadableScan(path, "a container of contact.engineering", "a zip file without meta.yml")
    if archive.getinfo(name).file_size > _LARGEST_METADATA[name]:
        raise UnreadableScan(path, f"at most {_LARGEST_METADATA[name] >> 10} KiB", "more", where=(name,))
    text = archive.read(name)
    return json.loads(text) if name == METADATA[0] else _plain_yaml(text)


def _plain_yaml(text: bytes) -> Any:
    """Load YAML without its tags, which could create any Python object."""
    import yaml

    class Plain(yaml.SafeLoader):
        pass

    def plain(loader, _tag, node):
        if isinstance(node, yaml.MappingNode):
            return loader.construct_mapping(node, deep=True)
        return loader.construct_sequence(node, deep=True) if node.id == "sequence" else loader.construct_scalar(node)

    Plain.add_multi_constructor("", plain)
    return yaml.load(text, Plain)


def _member_name(entry: dict[str, Any]) -> str:
    """Return the name of a topography's file in the container."""
    names = entry["datafile"]
    return names.get("squeezed-netcdf") or names["original"]


def _topography(archive: zipfile.ZipFile, entry: dict[str, Any], path: Path) -> xr.Dataset:
    """Return one map or line."""
    name = _member_name(entry)
    with tempfile.TemporaryDirectory() as folder:
        file_stem = re.sub(r"[^\w.-]", "_", f"{path.name}, {name}")[-80:]  # never a path of its own
        file = Path(folder) / file_stem.lstrip(".")
        with archive.open(name) as packed, file.open("wb") as member:
            shutil.copyfileobj(packed, member)
        try:
            return _heights(file, entry)
        except Refusal as refusal:
            where = (name, *refusal.where)
            raise UnreadableScan(path, *refusal.args[1:], where=where) from refusal


def _heights(file: Path, entry: dict[str, Any]) -> xr.Dataset:
    """Return the map or line in a file, levelled."""
    if is_netcdf(first_bytes(file, 8)):
        with unread(file) as ds:
            if ds["heights"].ndim == 1:
                measured = np.ones(ds["x"].shape, bool) if "mask" not in ds else ds["mask"].values == 0
                return _line(ds["x"].values[measured], ds["heights"].values[measured], ds["x"].attrs["unit"], None)
        return read_scan(file).load().drop_encoding()
    order, method = _DETRENDED[entry.get("detrend_mode", "center")]
    unit = entry["unit"]
    scale = float(entry.get("height_scale", 1))
    if len(entry["size"]) == 1:
        x, height = np.loadtxt(file, ndmin=2).T[:2]
        return _line(x, height * scale, unit, order)
    channel = int(entry.get("data_source", 0))
    stated = list_channels(file)[channel]
    options: dict[str, Any] = {} if stated.units else {"height_units": unit}
    if stated.size is None:
        options["size"] = tuple(float(side) * factor(unit, "nm") for side in entry["size"])
    ds = read_scan(file, channel=channel, **options)
    height = ds["height"] if stated.units else ds["height"] * scale
    return (
        ds.assign(height=height - height.mean()) if method is None else level(ds.assign(height=height), method=method)
    )


def _line(x: np.ndarray, heights: np.ndarray, unit: str, order: int | None) -> xr.Dataset:
    """Return a line in nm, without the polynomial of an order."""
    x, heights = (np.asarray(values, float) * factor(unit, "nm") for values in (x, heights))
    if order is not None:
        heights = heights - np.polynomial.Polynomial.fit(x, heights, order)(x)
    return xr.Dataset({"height": ("x", heights)}, {"x": x})
