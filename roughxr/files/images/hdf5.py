"""HDF5 files that are no NetCDF: any matrix, named by its path, and the layouts of TopoStats, JPK, Nanosurf and NeXus.

Only those four state sizes. Facts from the public readers of TopoStats, AFMReader, playNano and Nanosurf, and from the
definition of NXdata. The first row of a matrix is the top of the picture; JPK and Nanosurf store the lowest line first,
NeXus as its axis states.
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...mechanics.vocabulary.units import factor
from ..doors import open_hdf5
from ..storage import open_locked_raw
from .channel import Channel, UnreadableScan, stated_direction

#: TopoStats' image of the whole scan; other images are grains.
_TOPOSTATS_IMAGE = "image"

#: Beginning of the names of JPK's attributes of the grid.
_GRID = "position-pattern.grid."

#: Beginning of the names of JPK's attributes of the scale.
_SCALE = "net-encoder.scaling."


def is_netcdf4(path: Path) -> bool:
    """Return whether an HDF5 file was written as NetCDF."""
    try:
        with open_locked_raw(path) as file:
            return bool(file.getncattr("_IsNetcdf4"))
    except (OSError, RuntimeError, AttributeError):
        return False


def hdf5_channels(path: Path) -> list[Channel]:
    """Return the images of a file."""
    images: list[Channel] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf" and item.size:
            images.extend(_images(path, name, item))

    with open_hdf5(path) as file:
        file.visititems(visit)
    if not images:
        raise UnreadableScan(path, "a matrix of numbers", "none")
    return sorted(images, key=lambda image: image.name != _TOPOSTATS_IMAGE or image.size is None)


def _images(path: Path, name: str, item: Any) -> list[Channel]:
    """Return the images of one dataset: those of a layout that is known, else the matrix."""
    stated = {  # by the dataset, its group, and the group above, the nearest one first
        key: value.decode() if isinstance(value, bytes) else value
        for owner in (item.parent.parent, item.parent, item)
        for key, value in owner.attrs.items()
    }
    if f"{_GRID}ilength" in stated and item.ndim == 2:
        return _jpk_frames(path, name, item, stated)
    for kind in ("signal_calibration", "base_calibration"):
        if f"{kind}_max" in item.attrs:
            return _nanosurf_images(path, name, item, stated, kind)
    if item.ndim != 2:
        return []
    if _text(item.parent.attrs.get("NX_class", "")) == "NXdata" and _is_signal(item):
        return _nexus_images(path, name, item)
    pixel = item.parent.get("pixel_to_nm_scaling") if item.dtype.kind == "f" else None  # TopoStats
    size = None if pixel is None else (item.shape[1] * float(pixel[()]), item.shape[0] * float(pixel[()]))
    units = "nm" if size else item.attrs.get("units", item.attrs.get("unit"))
    return [Channel(name, units and str(units), item.shape, size, "nm", partial(_values, path, name))]


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _is_signal(item: h5py.Dataset) -> bool:
    """Return whether a dataset is what its NXdata group shows, or the group does not say."""
    signal = _text(item.parent.attrs.get("signal", ""))
    return not signal or item.name.rsplit("/", 1)[-1] == signal


def _nexus_images(path: Path, name: str, item: h5py.Dataset) -> list[Channel]:
    """Return the image of an NXdata group, whose axes are those of rows and columns."""
    stated = item.parent.attrs.get("axes", item.attrs.get("axes", ()))
    names = re.split("[:,]", _text(stated)) if isinstance(stated, (str, bytes)) else [_text(axis) for axis in stated]
    axes = [item.parent[axis] for axis in names if axis in item.parent]
    units = _text(item.attrs.get("units", "")) or None
    title = _text(item.attrs.get("long_name", name))
    if len(axes) != 2 or tuple(axis.size for axis in axes) != item.shape or min(item.shape) < 2:
        return [Channel(title, units, item.shape, None, None, partial(_values, path, name))]
    y_axis, x_axis = (np.asarray(axis[()], dtype=float).ravel() for axis in axes)
    y_units, x_units = (_text(axis.attrs.get("units", "")) for axis in axes)
    width, height = (np.ptp(axis) * axis.size / (axis.size - 1) for axis in (x_axis, y_axis))
    if y_units != x_units:
        height *= factor(y_units, x_units)
    rows = slice(None, None, -1 if y_axis[-1] > y_axis[0] else 1)
    columns = slice(None, None, 1 if x_axis[-1] > x_axis[0] else -1)
    size = (float(width), float(height))
    return [Channel(title, units, item.shape, size, x_units or None, lambda: _values(path, name)[rows, columns])]


def _jpk_frames(path: Path, name: str, item: Any, stated: dict[str, Any]) -> list[Channel]:
    """Return a channel's frames, one in each column."""
    shape = int(stated[f"{_GRID}jlength"]), int(stated[f"{_GRID}ilength"])
    size = float(stated[f"{_GRID}ulength"]), float(stated[f"{_GRID}vlength"])
    title = str(stated.get("channel.fancy-name") or stated.get("channel.name") or name)
    scale = float(stated.get(f"{_SCALE}multiplier", 1.0)), float(stated.get(f"{_SCALE}offset", 0.0))
    units = stated.get(f"{_SCALE}unit.unit")
    direction = "retrace" if str(stated.get("retrace")).lower() in ("true", "1") else "trace"
    images = []
    for k in range(item.shape[1]):
        read = partial(_values, path, name, scale, shape, part=(slice(None), k))
        images.append(
            Channel(f"{title} {k + 1}" if item.shape[1] > 1 else title, units, shape, size, "m", read, direction)
        )
    return images


def _nanosurf_images(path: Path, name: str, item: Any, stated: dict[str, Any], kind: str) -> list[Channel]:
    """Return an image of a segment; none for what is no image."""
    if "image_points_per_line" in stated:
        shape = int(stated["image_number_of_lines"]), int(stated["image_points_per_line"])
        size = float(stated["image_size_x"]), float(stated["image_size_y"])
    elif {"rect_axis_size", "rect_axis_range"} <= set(stated):
        (rows, columns) = stated["rect_axis_size"]
        (height, width) = stated["rect_axis_range"]
        shape = (int(rows), int(columns))
        size = (float(width), float(height))
    else:
        return []
    if item.size != np.prod(shape):
        return []
    low = float(stated[f"{kind}_min"])
    high = float(stated[f"{kind}_max"])
    least = 0.0
    largest = 1.0
    missing = None
    if item.dtype.kind in "iu":
        least = float(np.iinfo(item.dtype).min)
        largest = float(np.iinfo(item.dtype).max)
        if kind == "signal_calibration" and least < 0:  # version 2 of the format
            missing = least
            least = least + 1.0
    factor = (high - low) / (largest - least)
    units = re.sub(r".*\[(.*)\].*", r"\1", str(stated.get(f"{kind}_unit", ""))) or None
    title = str(stated.get("signal_name", stated.get("name", name)))
    direction = stated_direction(str(item.parent.attrs.get("segment_name", item.parent.attrs.get("name", ""))))
    read = partial(_values, path, name, (factor, low - factor * least), shape, missing)
    return [Channel(title, units, shape, size, "m", read, direction)]


def _values(
    path: Path,
    name: str,
    scale: tuple[float, float] = (1.0, 0.0),
    shape: tuple[int, int] | None = None,
    missing: float | None = None,
    part: Any = ...,
) -> np.ndarray:
    """Return a dataset or a part of it, scaled; lines of a ``shape`` come from the lowest upwards."""
    with open_hdf5(path) as file:
        values = np.asarray(file[name][part], dtype=float)
    values = np.where(values == missing, np.nan, values * scale[0] + scale[1])
    return values if shape is None else values.reshape(shape)[::-1]
