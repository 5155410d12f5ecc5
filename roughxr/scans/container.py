"""Containers of contact.engineering: the zip of a published surface, its maps and lines with their metadata.

``index.json`` or ``meta.yml`` lists the topographies of each surface, with the names of their files. A file
``squeezed-netcdf`` holds the heights as contact.engineering shows them; without it the instrument's own file is read,
and levelled as stated.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..vocabulary.schema import label, record
from ..vocabulary.units import factor
from .channel import UnreadableScan, first_bytes
from .files import file_hash, guarded, list_channels, read_scan, regular_file
from .force_curve_formats import METADATA
from .levelling import level
from .netcdf import is_netcdf, unread

#: The largest size of a zip file's content: in bytes, over the size of the zip file, and the size allowed to any file.
_LARGEST_CONTENT, _LARGEST_RATIO, _ALWAYS_ALLOWED = 2**32, 50, 2**22

#: The largest metadata, bytes: YAML is read slowly.
_LARGEST_METADATA = 2**24

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
        If the file is no such container or damaged, or holds a file that cannot be read. It is a ValueError.
    ImportError
        If an instrument's file needs the extra ``roughxr[afm]``.

    Notes
    -----
    The container's factor on heights is applied to files of bare numbers alone: others state their own.

    References
    ----------
    Röttger et al., Contact.engineering: create, analyze and publish digital surface twins from topography measurements
    across many scales, Surf. Topogr.: Metrol. Prop. 10 (2022) 035032.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     one = {"name": "ridge", "size": [30.0], "unit": "um", "datafile": {"original": "ridge.txt"}}
    ...     with zipfile.ZipFile(Path(folder) / "surface.zip", "w") as archive:
    ...         archive.writestr("ridge.txt", "0 0\\n10 0.1\\n30 0\\n")
    ...         archive.writestr("meta.yml", json.dumps({"surfaces": [{"topographies": [one]}]}))
    ...     (line,) = open_container(Path(folder) / "surface.zip")
    >>> line.x.values, line.height.values.round(6)
    (array([    0., 10000., 30000.]), array([-33.333333,  66.666667, -33.333333]))
    """
    path = regular_file(path)
    if not zipfile.is_zipfile(path):
        raise UnreadableScan(path, "expected the zip file of a container of contact.engineering, found no zip file")
    return guarded(path, _topographies, path)


def _topographies(path: Path) -> list[xr.Dataset]:
    origin = {"source_file": path.name, "source_sha256": file_hash(path), "source_format": "contact.engineering"}
    topographies = []
    with zipfile.ZipFile(path) as archive:
        _refuse_bomb(archive, path)
        for number, surface in enumerate(_metadata(archive, path)["surfaces"]):
            for topography in surface["topographies"]:
                ds = _topography(archive, topography, path)
                attributes = {"surface": surface.get("name", number), "title": topography.get("name")}
                attributes |= {name: topography.get(name) for name in ("description", "detrend_mode")}
                ds.attrs |= origin | {
                    name: str(attributes[name]) for name in attributes if isinstance(attributes[name], (str, int))
                }
                topographies.append(
                    record(label(ds), "open_container", file=path.name, title=ds.attrs.get("title", ""))
                )
    return topographies


def _refuse_bomb(archive: zipfile.ZipFile, path: Path) -> None:
    """Raise for a zip file whose content is far larger than the file: heights shrink by a factor of ten at most."""
    content = sum(member.file_size for member in archive.infolist())
    most = min(_LARGEST_CONTENT, max(_ALWAYS_ALLOWED, _LARGEST_RATIO * path.stat().st_size))
    if content > most:
        raise UnreadableScan(
            path, f"expected a content of at most {most / 2**20:.3g} MiB, found {content / 2**20:.3g} MiB: damaged"
        )


def _metadata(archive: zipfile.ZipFile, path: Path) -> dict[str, Any]:
    """Return a container's metadata as plain lists, mappings, text and numbers."""
    present = [name for name in METADATA if name in archive.namelist()]
    if not present:
        raise UnreadableScan(path, "expected a container of contact.engineering, found a zip file without meta.yml")
    if archive.getinfo(present[0]).file_size > _LARGEST_METADATA:
        raise UnreadableScan(path, f"{present[0]}: expected at most {_LARGEST_METADATA >> 20} MiB, found more")
    text = archive.read(present[0])
    return json.loads(text) if present[0] == METADATA[0] else _plain_yaml(text)


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


def _topography(archive: zipfile.ZipFile, entry: dict[str, Any], path: Path) -> xr.Dataset:
    """Return one map or line."""
    names = entry["datafile"]
    name = names.get("squeezed-netcdf") or names["original"]
    with tempfile.TemporaryDirectory() as folder:
        own = re.sub(r"[^\w.-]", "_", f"{path.name}, {name}")[-80:]  # never a path of its own
        file = Path(folder) / own.lstrip(".")
        with archive.open(name) as packed, file.open("wb") as member:
            shutil.copyfileobj(packed, member)
        try:
            return _heights(file, entry)
        except UnreadableScan as error:
            raise UnreadableScan(path, f"{name}: {str(error).removeprefix(f'{file}: ')}") from error


def _heights(file: Path, entry: dict[str, Any]) -> xr.Dataset:
    """Return the map or line in a file, levelled."""
    if is_netcdf(first_bytes(file, 8)):
        line = _squeezed_line(file)
        return read_scan(file).load().drop_encoding() if line is None else line
    order, method = _DETRENDED[entry.get("detrend_mode", "center")]
    if len(entry["size"]) == 1:
        x, height = np.loadtxt(file, ndmin=2).T[:2]
        return _line(x, height, entry["unit"], float(entry.get("height_scale", 1)), order)
    ds = _map(file, entry)
    return ds.assign(height=ds["height"] - ds["height"].mean()) if method is None else level(ds, method=method)


def _map(file: Path, entry: dict[str, Any]) -> xr.Dataset:
    """Return the map in an instrument's file; size and units of bare numbers come from the metadata."""
    channel = int(entry.get("data_source", 0))
    stated = list_channels(file)[channel]
    given: dict[str, Any] = {} if stated.units else {"height_units": entry["unit"]}
    if stated.size is None:
        given["size"] = tuple(float(side) * factor(entry["unit"], "nm") for side in entry["size"])
    ds = read_scan(file, channel=channel, **given)
    return ds if stated.units else ds.assign(height=ds["height"] * float(entry.get("height_scale", 1)))


def _squeezed_line(file: Path) -> xr.Dataset | None:
    """Return the line in a file of SurfaceTopography, None where it holds a map."""
    with unread(file) as ds:
        if ds["heights"].ndim != 1:
            return None
        known = np.ones(ds["x"].shape, bool) if "mask" not in ds else ds["mask"].values == 0
        x, heights = (ds[name].values[known] for name in ("x", "heights"))
        return _line(x, heights, ds["x"].attrs["unit"], 1.0, None)


def _line(x: np.ndarray, heights: np.ndarray, unit: str, scale: float, order: int | None) -> xr.Dataset:
    """Return a line in nm less its polynomial of this order."""
    x, heights = (np.asarray(values, float) * factor(unit, "nm") for values in (x, heights * scale))
    if order is not None:
        heights = heights - np.polynomial.Polynomial.fit(x, heights, order)(x)
    return xr.Dataset({"height": ("x", heights)}, {"x": x})
