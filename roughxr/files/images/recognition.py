"""Read a file as a labelled scan: detect the format, choose the channel, add missing size and units.

Orientation, the same for every format: a file without coordinates holds a picture, first row at the top.
The scan shows that picture with x to the right, y upwards and height towards the viewer (a right-handed
frame): ``height[0, 0]`` is the lower left pixel, and the picture's row r lies at ``y[ny - 1 - r]``.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ...mechanics.scans.plausibility import ImplausibleScan, doubts, size_doubts
from ...mechanics.vocabulary.provenance import flat
from ...mechanics.vocabulary.refusal import Refusal, WrongCall
from ...mechanics.vocabulary.schema import history, label, pixel, record, validate
from ...mechanics.vocabulary.text import Argument, Phrase, warn
from ...mechanics.vocabulary.units import factor, magnitude
from ..doors import refuse_other_files
from . import formats, gwyddion, hdf5, microscopes, plain, vendors
from .channel import (
    Channel,
    UnreadableScan,
    choose,
    file_name,
    first_bytes,
    is_length,
    length_factor,
    listing,
    naming_file,
    refuse_absurd,
    refuse_small,
    refuse_stated,
    tied_images,
)
from .force_curve_formats import refuse_curves
from .netcdf import HDF5, is_netcdf, open_netcdf, variable_names
from .reader_process import unsupported

#: Format families that only microscopes and Gwyddion write.
_MICROSCOPE_FAMILIES = ("gsf", "gwy", "sxm", "asd", "jpk")


def regular_file(path: Any) -> Path:
    """Return a path to an ordinary, readable file; raise for anything else, without waiting for a pipe."""
    try:
        path = Path(path)
    except TypeError:
        if isinstance(path, (list, tuple)):
            raise WrongCall(
                "path", "one file", f"{len(path)} in a {type(path).__name__}", "open each in turn"
            ) from None
        raise WrongCall("path", "the name of a file", type(path).__name__) from None
    try:
        refuse_other_files(path)
        if not first_bytes(path, 1):
            raise UnreadableScan(path, "a scan", "an empty file")
    except Refusal as refusal:
        raise UnreadableScan(path, *refusal.args[1:]) from None
    return path


def reader_of(path: Path) -> tuple[str, Callable[[Path], list[Channel]]]:
    """Return the name of a file's format family and its reader, by content and never by extension."""
    head = first_bytes(path, 512)
    if head.startswith(gwyddion.GSF):
        return "gsf", gwyddion.gsf_channels
    if head.startswith((gwyddion.GWY, gwyddion.OLD_GWY)):
        return "gwy", gwyddion.gwy_channels
    if head.startswith(plain.NPY):
        return "npy", plain.npy_channels
    if is_netcdf(head):
        other = head.startswith(HDF5) and not hdf5.is_netcdf4(path)
        return ("hdf5", hdf5.hdf5_channels) if other else ("netcdf", _netcdf_channels)
    if head.startswith(microscopes.SXM):
        return "sxm", microscopes.sxm_channels
    if microscopes.is_asd(head):
        return "asd", microscopes.asd_channels
    if head.startswith(microscopes.TIFF) and microscopes.is_jpk(path):
        return "jpk", microscopes.jpk_channels
    if head.startswith(microscopes.TIFF) and not microscopes.is_park(path) and microscopes.is_float_matrix(path):
        return "tiff", microscopes.float_channels
    if plain.is_text(head) and not head.startswith(vendors.TEXT_SIGNATURES) and plain.has_digit(path):
        return "text", plain.text_channels
    return "vendor", vendors.channels


def is_microscope_file(path: Any) -> bool:
    """Return whether a file begins as that of a microscope or Gwyddion's text.

    Other texts, NumPy, NetCDF and HDF5 are read by other backends, too.
    """
    if not isinstance(path, (str, PathLike)) or not Path(path).is_file():
        return False
    path = Path(path)
    family, _ = reader_of(path)
    head = first_bytes(path, 512)
    if family != "vendor":
        return family in _MICROSCOPE_FAMILIES or plain.is_gwyddion_text(head)
    if head.startswith(microscopes.TIFF):
        return microscopes.is_park(path)
    return bool(vendors.code_of(head)) or path.suffix.lower() == ".x3p"  # a zip file, whose first bytes say nothing


def call_naming_file(path: Path, read: Callable[..., Any], *args: Any, **options: Any) -> Any:
    """Return ``read(...)``; any error of a library is raised again with the file's name."""
    try:
        with naming_file(path):
            return read(*args, **options)
    except (UnreadableScan, ImportError):
        raise
    except MemoryError as error:
        raise UnreadableScan(path, "heights that fit into memory", f"more: {error}") from error
    except Exception as error:
        error_text = " ".join(str(error).split())[:300] or "no reason given"
        reason = f"it lacks {error_text}" if isinstance(error, KeyError) else f"{type(error).__name__}: {error_text}"
        raise UnreadableScan(path, *unsupported(reason)) from error


@contextmanager
def naming_format(path: Path, code: str) -> Iterator[None]:
    """Name the format of a file in the errors that it raises."""
    code = vendors.code_of(first_bytes(path, 512)) if code == "vendor" else code
    try:
        yield
    except UnreadableScan as error:
        error.where = (formats.name_of(code), *error.where) if code else error.where
        raise


def images(path: Path, family: str, read: Callable[[Path], list[Channel]]) -> tuple[str, list[Channel]]:
    """Return the format of a file and the images that it holds."""
    with naming_format(path, family):
        channels = call_naming_file(path, read, path)
        if not channels:
            raise UnreadableScan(path, "an AFM image", "none")
    return str(channels[0].header.get("format", family)), channels


def list_channels(path: Any) -> list[Channel]:
    """Return the images in a file, their values not read yet if the format allows."""
    path = regular_file(path)
    refuse_curves(path)
    return images(path, *reader_of(path))[1]


def _netcdf_channels(path: Path) -> list[Channel]:
    """Return the images of a NetCDF file, each read on demand."""
    names = variable_names(path)
    if not names:
        raise UnreadableScan(path, "a variable over two dimensions with units of a length", "none")
    channels = []
    for name in names:
        with open_netcdf(path, channel=name) as ds:
            shape = (ds.sizes["y"], ds.sizes["x"])
            steps = pixel(ds)
            size = (steps[0] * shape[1], steps[1] * shape[0])
            direction = str(ds.attrs.get("scan_direction", ""))
        channels.append(Channel(name, "nm", shape, size, "nm", partial(_netcdf_rows, path, name), direction))
    return channels


def _netcdf_rows(path: Path, name: str) -> np.ndarray:
    with open_netcdf(path, channel=name) as ds:
        return ds["height"].values.T[::-1]


def read_scan(
    path: Any,
    *,
    channel: str | int | None = None,
    scan_direction: str | None = None,
    size: Any = None,
    height_units: str | None = None,
) -> xr.Dataset:
    """Return the scan in a file; see :func:`roughxr.scans.open_scan`."""
    path = regular_file(path)
    if size is None:  # with a size the file is a matrix of numbers
        refuse_curves(path)
    family, read = reader_of(path)
    options = {"channel": channel, "scan_direction": scan_direction, "size": size, "height_units": height_units}
    if family == "netcdf":
        with naming_format(path, family):
            return _labelled_netcdf(path, options)
    code, channels = images(path, family, read)
    with naming_format(path, code):
        chosen = choose(_with_units(channels, height_units, path), channel, scan_direction, path)
        chosen = with_size(chosen, size, path)
        ds = labelled(chosen, path)
    ds.attrs.update(_origin(path, code, chosen, channels))
    tied = tied_images(channels, chosen, scan_direction) if channel is None else []
    if tied:
        images_in_words = f"{len(tied)} images may be the heights ({listing(channels, tied)})"
        choice = f"{file_name(path)}: {images_in_words}; {chosen.name!r} is read; choose another one, "
        warn(Phrase(choice, Argument("channel", ...)), ImplausibleScan)
    for doubt in doubts(ds):
        warn(f"{file_name(path)}: {doubt}", ImplausibleScan)
    return record(ds, "open_scan", file=file_name(path), **options)


def _labelled_netcdf(path: Path, options: dict[str, Any]) -> xr.Dataset:
    """Return a NetCDF file's scan, not read yet; roughxr's own files keep their history and origin."""
    opened = call_naming_file(path, open_netcdf, path, channel=options["channel"])
    try:
        for option in ("scan_direction", "size", "height_units"):
            if options[option] is not None:
                refuse_stated(path, option, options[option])
        with naming_file(path):  # such as coordinates that are not uniform
            ds = _with_origin(validate(opened, "scan"), path, options)
    except BaseException:
        opened.close()
        raise
    ds.set_close(opened.close)
    return ds


def _with_origin(ds: xr.Dataset, path: Path, options: dict[str, Any]) -> xr.Dataset:
    if "source_sha256" in ds.attrs or any("roughxr" in step for step in history(ds)):
        return ds
    for doubt in size_doubts(ds):
        warn(f"{file_name(path)}: {doubt}", ImplausibleScan)
    ds = label(ds).assign_attrs(source_file=file_name(path), source_sha256=file_hash(path), source_format="netcdf")
    return record(ds, "open_scan", file=file_name(path), **options)


def _with_units(channels: list[Channel], height_units: str | None, path: Path) -> list[Channel]:
    """Return the channels, with the given units if they state none."""
    if height_units is None:
        return channels
    if not is_length(height_units):
        raise Refusal("height_units", "units of a length such as 'nm'", f"{height_units!r}")
    if all(channel.units for channel in channels):
        refuse_stated(path, "height_units", height_units)
    return [channel if channel.units else channel._replace(units=height_units) for channel in channels]


def with_size(channel: Channel, size: Any, path: Path) -> Channel:
    """Return the channel with its lateral size in nm, stated by the file or given, never assumed."""
    rows, columns = channel.shape
    if rows < 2 or columns < 2:
        raise UnreadableScan(path, "at least 2 x 2 pixels", f"{columns} x {rows}")
    stated = _stated_size(channel, path)
    wanted = None if size is None else _given_size(size, channel.shape)
    used = wanted or stated
    if used is None:
        advice = Phrase("give it, for example ", Argument("size", ("5 um", "5 um")))
        raise UnreadableScan(path, "a lateral size", "none in the file", advice)
    if stated and wanted and not np.allclose(stated, wanted, rtol=1e-6):
        refuse_stated(path, "size", size, f"{stated} nm")
    if stated and not wanted and not channel.counted:
        _check_square(channel, stated, path)
    refuse_small(path, "pixels of", min(used[0] / columns, used[1] / rows))
    return channel._replace(size=used, lateral_units="nm")


def _stated_size(channel: Channel, path: Path) -> tuple[float, float] | None:
    if channel.size is None:
        return None
    nanometres = length_factor(path, channel.lateral_units, "lateral units of a length")
    width, height = (float(value) * nanometres for value in channel.size)
    if not (0 < width < np.inf and 0 < height < np.inf):
        raise UnreadableScan(path, "a positive lateral size", f"{(width, height)} nm")
    return width, height


def _given_size(size: Any, shape: tuple[int, int]) -> tuple[float, float]:
    """Return the size (along x, along y) in nm; a single length needs as many columns as rows."""
    both = size if isinstance(size, (tuple, list)) else (size,)
    values = tuple(float(magnitude(value, "nm", "size")) for value in both)
    if len(values) == 1 and shape[0] == shape[1]:
        values *= 2
    if len(values) != 2 or min(values) <= 0:
        raise Refusal("size", "two positive lengths (along x, along y)", f"{size!r}")
    return values[0], values[1]


def _check_square(channel: Channel, size: tuple[float, float], path: Path) -> None:
    rows, columns = channel.shape
    if abs(size[0] / columns - size[1] / rows) > 1e-6 * size[0] / columns:
        fault = f"{columns} columns and {rows} rows on {size[0]:g} x {size[1]:g} nm: the file seems cut short"
        advice = Phrase("if it is whole, give ", Argument("size", ...), " as well")
        raise UnreadableScan(path, "square pixels", fault, advice)


def picture(channel: Channel, path: Path) -> xr.DataArray:
    """Return a channel's values over x and y (nm): the picture's top row at the largest y."""
    rows = np.asarray(call_naming_file(path, channel.read), dtype=float)
    if rows.shape != channel.shape:
        raise UnreadableScan(path, f"{channel.shape} pixels (rows, columns)", f"{rows.shape}")
    assert channel.size is not None  # by `with_size`
    columns = rows[::-1].T
    coords = {
        axis: (axis, (np.arange(n) + 0.5) * (length / n), {"axis": axis.upper()})
        for axis, n, length in zip("xy", columns.shape, channel.size)
    }
    return xr.DataArray(np.ascontiguousarray(columns), coords, ("x", "y"))


def labelled(channel: Channel, path: Path) -> xr.Dataset:
    """Return a channel as a scan."""
    height = picture(channel, path) * factor(channel.units, "nm")
    if np.isnan(height.values).all():
        raise UnreadableScan(path, "heights", "missing pixels only")
    assert channel.size is not None  # by `with_size`
    refuse_absurd(height.values, max(channel.size), path)
    return label(height.to_dataset(name="height"))


def _origin(path: Path, code: str, chosen: Channel, channels: list[Channel]) -> dict[str, Any]:
    """Return the attributes that state a scan's origin."""
    assert chosen.size is not None  # by `with_size`
    header = {key: value for key, value in chosen.header.items() if key != "format"}
    return {
        "source_file": file_name(path),
        "source_sha256": file_hash(path),
        "source_format": code,
        "source_size_x": chosen.size[0],
        "source_size_y": chosen.size[1],
        "channel": chosen.name,
        "scan_direction": chosen.direction or "not stated",
        "channels": listing(channels),
        "pixel_registration": "center",
        "header": "\n".join(f"{name}: {' '.join(str(value).split())}" for name, value in flat(header).items()),
    }


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
