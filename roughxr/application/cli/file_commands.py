"""`info` and `convert`: the contents of a file, and its conversion to another format."""

from __future__ import annotations

import warnings
from argparse import Namespace
from pathlib import Path
from typing import Any

import xarray as xr

from ...files.images import formats
from ...files.images.backend import open_scan
from ...files.images.description import describe
from ...files.images.export import to_file, to_netcdf
from ...files.storage import atomic_write
from ...mechanics.scans.editing import fill, on_square_pixels
from ...mechanics.scans.levelling import level
from ...mechanics.scans.plausibility import ImplausibleScan
from ...mechanics.scans.roughness_parameters import roughness
from ...mechanics.vocabulary.numbers import format_number
from ...mechanics.vocabulary.refusal import Refusal
from .. import archive
from . import words


def read_scan(file: str, options: Namespace) -> xr.Dataset:
    """Read the scan of a file with the given options."""
    scan = open_scan(file, **image_options(options), height_units=options.height_units)
    return scan if options.fill is None else fill(scan, method=words.number(options.fill))


def image_options(options: Namespace) -> dict[str, Any]:
    """Return the options that choose an image of a file, and its size if the file does not state it."""
    channel = int(options.channel) if (options.channel or "").isdecimal() else options.channel
    size = None if options.size is None else tuple(map(words.number, options.size))
    return {"channel": channel, "scan_direction": options.scan_direction, "size": size}


def info(options: Namespace) -> None:
    """Print the channels of a file and the roughness of the one that is read, or the formats that are read."""
    if options.formats:
        for format in formats.READ.values():
            needs = f"; needs the extra {format.extra!r}" if format.extra else ""
            print(f"{format.name} ({', '.join(format.endings.split())}){needs}")
        print(f"and what SurfaceTopography reads besides, of optical profilers: {formats.BESIDES}")
        return
    if options.file is None:
        raise Refusal("", "a FILE, or --formats", "neither")
    channels = describe(options.file)
    print_attributes(channels)
    if options.file.endswith(".nc") and (missing := archive.root_attributes(options.file).get(archive.UNFINISHED)):
        print(f"run: not finished, {missing}")
    print("images, with sizes and heights in nm, and the rms height s_q about the mean plane:")
    listed = channels.rename(units="units in file").to_dataframe()
    print(listed.to_string(float_format=lambda value: format_number(value, digits=4)))
    with warnings.catch_warnings():
        if channels.attrs["doubts"]:  # they are printed above
            warnings.simplefilter("ignore", ImplausibleScan)
        scan = read_scan(options.file, options).load()
    print(f"\nroughness of {scan.attrs.get('channel', 'height')}, about its mean plane:")
    for variable, value in roughness(scan).data_vars.items():
        if value.ndim == 0:
            units = value.attrs["units"].removesuffix("1")
            print(f"  {variable!s:10s} {format_number(value, digits=6):>10s} {units:5s} {value.attrs['long_name']}")
    if options.picture:
        from matplotlib.figure import Figure

        from .. import figures

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ImplausibleScan)  # printed above
            levelled = level(scan)
        axes = figures.scan_map(levelled, ax=Figure(figsize=(4, 3.4), layout="constrained").subplots())
        save_picture(axes.figure, options.picture)


def convert(options: Namespace) -> None:
    """Write a scan in another format."""
    scan = on_square_pixels(read_scan(options.file, options))
    write = to_netcdf if Path(options.output).suffix == ".nc" else to_file
    write(scan, options.output)
    print(f"written to {options.output}")


def print_attributes(ds: xr.Dataset) -> None:
    """Print the attributes of a file, one a line."""
    print("\n".join(f"{key}: {value or 'none'}" for key, value in ds.attrs.items() if key != "history"))


def save_picture(figure: Any, path: str) -> None:
    """Write a figure to a file, and print its path."""
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=150)
    print(f"drawn in {path}")
