"""Small AFM files of every format that the tests can write, each with the same heights.

A picture is (rows, columns) in nm, the first row at the top. `WRITERS` maps a format's name to
`write(folder, rows, size) -> path`, the size being (along x, along y) in nm.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import xarray as xr

from roughxr import scans

#: A picture with no symmetry at all, of unequal sides and square pixels.
ROWS, COLUMNS, PIXEL = 18, 24, 5.0


def picture(rows: int = ROWS, columns: int = COLUMNS) -> np.ndarray:
    """Return heights in nm, (rows, columns), without any symmetry."""
    v, u = np.mgrid[:rows, :columns]
    waves = np.sin(0.7 * u + 0.2 * v) + 0.8 * np.cos(0.5 * v) + 0.05 * u
    waves[0, 0] += 2.0  # the top left corner, marked
    return np.round(waves, 4)


def image_size(rows: np.ndarray, pixel: tuple[float, float] = (PIXEL, PIXEL)) -> tuple[float, float]:
    return rows.shape[1] * pixel[0], rows.shape[0] * pixel[1]


def expected_scan(rows: np.ndarray, size: tuple[float, float]) -> xr.Dataset:
    """Return the scan that `open_scan` must return for each of these files."""
    heights = np.ascontiguousarray(rows[::-1].T)
    coords = {
        axis: (axis, (np.arange(n) + 0.5) * length / n, {"units": "nm"})
        for axis, n, length in zip("xy", heights.shape, size)
    }
    return xr.Dataset({"height": (("x", "y"), heights, {"units": "nm"})}, coords)


def write_gsf(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    return scans.to_file(expected_scan(rows, size), folder / "scan.gsf")


def write_gwy(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    from gwyfile.objects import GwyContainer, GwyDataField

    container = GwyContainer()
    units = {"xreal": size[0] * 1e-9, "yreal": size[1] * 1e-9, "si_unit_xy": "m", "si_unit_z": "m"}
    container["/0/data/title"] = "Height"
    container["/0/data"] = GwyDataField(np.nan_to_num(rows) * 1e-9, **units)
    if np.isnan(rows).any():
        container["/0/mask"] = GwyDataField(np.isnan(rows).astype(float), **units)
    container["/1/data/title"] = "Phase"
    container["/1/data"] = GwyDataField(np.ones_like(rows), **{**units, "si_unit_z": "deg"})
    path = folder / "scan.gwy"
    container.tofile(str(path))
    return path


def write_text(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    path = folder / "scan.txt"
    header = f"Channel: Height\nWidth: {size[0] / 1e3:.6f} µm\nHeight: {size[1] / 1e3:.6f} µm\nValue units: m"
    np.savetxt(path, rows * 1e-9, header=header, delimiter="\t", encoding="utf-8")
    return path


def write_npy(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    path = folder / "scan.npy"
    np.save(path, rows)
    return path


def write_native(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    return scans.to_netcdf(expected_scan(rows, size), folder / "native.nc")


def write_surfacetopography(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write heights along (x, y), y counted downwards, in SurfaceTopography's convention."""
    axes = {}
    for axis, n, length in zip("xy", rows.T.shape, size):
        axes[axis] = (axis, np.arange(n) * length / n, {"unit": "nm", "length": float(length), "periodic": 0})
    ds = xr.Dataset({"heights": (("x", "y"), rows.T, {"unit": "nm"})}, axes)
    path = folder / "surfacetopography.nc"
    ds.to_netcdf(
        path, engine="scipy", format="NETCDF3_64BIT", encoding={name: {"_FillValue": None} for name in ds.variables}
    )
    return path


def write_cf(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a labelled map as another program does: y before x, y descending, in um and m."""
    scan = expected_scan(rows, size).rename(height="topography").transpose("y", "x").isel(y=slice(None, None, -1))
    scan["topography"] = (scan["topography"] * 1e-9).assign_attrs(units="m")
    for axis in "xy":
        scan[axis] = (scan[axis] / 1e3).assign_attrs(units="um")
    path = folder / "cf.nc"
    scan.to_netcdf(path, engine="netcdf4")
    return path


def write_bruker(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a Nanoscope file of two channels, Height trace and Height retrace (upside down in height)."""
    counts = np.round(rows / NANOMETRES_PER_COUNT)
    return write_nanoscope(folder / "scan.spm", [("Height", "Trace", counts), ("Height", "Retrace", -counts)], size)


#: Sensitivity (nm/V) and range (V) of Nanoscope files, and the height of one of 65536 counts.
SENSITIVITY, VOLTS = 10.0, 440.0
NANOMETRES_PER_COUNT = SENSITIVITY * VOLTS / 65536


def write_nanoscope(path: Path, images: list[tuple[str, str, np.ndarray]], size: tuple[float, float]) -> Path:
    """Write a Nanoscope file of images (name, direction, counts as rows from the top)."""
    blocks = [np.round(counts).astype("<i2")[::-1].tobytes() for _, _, counts in images]  # the last line comes first
    lines = [r"\*File list", r"\Version: 0x07200000", r"\*Scanner list", rf"\@Sens. Zsens: V {SENSITIVITY} nm/V"]
    lines += [r"\*Ciao scan list", rf"\Scan Size: {size[0]:g} nm"]
    for number, (name, direction, counts) in enumerate(images):
        lines += [
            r"\*Ciao image list",
            rf"\Data offset: {8192 + number * len(blocks[0])}",
            rf"\Data length: {len(blocks[0])}",
            r"\Bytes/pixel: 2",
            rf"\Samps/line: {counts.shape[1]}",
            rf"\Number of lines: {counts.shape[0]}",
            rf"\Scan Size: {size[0]:g} {size[1]:g} nm",
            rf"\Line Direction: {direction}",
            rf'\@2:Image Data: S [{name}] "{name}"',
            rf"\@2:Z scale: V [Sens. Zsens] ({VOLTS / 65536:.9f} V/LSB) {VOLTS} V",
        ]
    header = "\r\n".join([*lines, r"\*File list end", ""]).encode("latin-1") + b"\x1a"
    path.write_bytes(header.ljust(8192, b"\0") + b"".join(blocks))
    return path


def write_igor(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write an Asylum Igor wave of version 5 with the one layer HeightRetrace."""
    columns, lines = rows.shape[1], rows.shape[0]
    data = (rows[::-1] * 1e-9).astype("<f4").tobytes()  # x fastest, the last line first
    note = f"ScanSize: {size[0] * 1e-9:.6e}\rScanPoints: {columns}\r".encode()
    labels = b"".join(name.ljust(32, b"\0") for name in (b"", b"HeightRetrace"))
    step = (size[0] * 1e-9 / columns, size[1] * 1e-9 / lines, 1.0, 1.0)
    wave = struct.pack(
        "<3IihH6xh32s2i4i4d4d4s16shh2d10i64x3hxxiihh2i",
        *(0, 0, 0, rows.size, 2, 0, 1, b"scan", 0, 0, columns, lines, 1, 0, *step, 0.0, 0.0, 0.0, 0.0),
        *(b"m", b"m\0\0\0m".ljust(16, b"\0"), 0, 0, 0.0, 0.0, *[0] * 10, 0, 0, 0, 0, 0, 0, 0, 0, 0),
    )
    assert len(wave) == 320
    sizes = (len(wave) + len(data), 0, len(note), 0, 0, 0, 0, 0, 0, 0, len(labels), 0, 0, 0, 0)

    def header(checksum: int) -> bytes:
        return struct.pack("<hh15i", 5, checksum, *sizes) + wave

    total = int(np.frombuffer(header(0), "<i2").sum(dtype=np.int64))
    checksum = (-total) & 0xFFFF
    path = folder / "scan.ibw"
    path.write_bytes(header(checksum - 0x10000 if checksum > 0x7FFF else checksum) + data + note + labels)
    return path


def write_park(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a Park TIFF: one 1 x 1 thumbnail, heights in um as float32 in a private tag."""
    data = (rows[::-1] * 1e-3).astype("<f4").tobytes()  # the bottom line first

    def text(words: str, length: int) -> bytes:
        return words.encode("utf-16-le").ljust(2 * length, b"\0")

    header = struct.pack("<I", 0) + text("Z Height", 32) + text("Tapping", 8)
    header += struct.pack("<dIIIIdId4I", 0.0, 0, 1, rows.shape[1], rows.shape[0], 0.0, 0, 0.1, 1, 0, 0, 0)[:-4]
    header += struct.pack("<6d", size[0] / 1e3, size[1] / 1e3, 0, 0, 1, 0) + text("um", 8)
    header += struct.pack("<5d", 0, 0, 1.0, 1.0, 0.0) + text("um", 8) + struct.pack("<iii3I", 0, 0, 0, 0, 0, 0)
    header += struct.pack("<dd", 1.0, 0.7) + text("", 8) * 3 + struct.pack("<IIIdd", 2, 0, 0, 0, 0) + text("", 16)
    tags = [(256, 4, 1, 1), (257, 4, 1, 1), (258, 4, 1, 8), (259, 4, 1, 1), (262, 4, 1, 1), (273, 4, 1, 8)]
    tags += [(277, 4, 1, 1), (278, 4, 1, 1), (279, 4, 1, 1), (50432, 4, 1, 0x0E031301), (50433, 4, 1, 0x1000002)]
    start = 16 + 2 + 12 * (len(tags) + 2) + 4
    tags += [(50434, 1, len(data), start), (50435, 1, len(header), start + len(data))]
    table = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + b"\0" * 4
    path = folder / "scan.tiff"
    path.write_bytes(b"II*\0" + struct.pack("<I", 16) + b"\0" * 8 + table + data + header)
    return path


#: Formats that hold 64-bit heights and the size as written; others round.
WRITERS = {
    "gsf": write_gsf,
    "gwy": write_gwy,
    "text": write_text,
    "npy": write_npy,
    "native": write_native,
    "surfacetopography": write_surfacetopography,
    "cf": write_cf,
    "bruker": write_bruker,
    "igor": write_igor,
    "park": write_park,
}

#: Largest error of a height in nm by format: 16-bit counts, 32-bit numbers, decimals.
ROUNDING = {"bruker": 0.04, "gsf": 1e-6, "igor": 1e-6, "park": 1e-6}


def given(name: str, size: tuple[float, float]) -> dict[str, object]:
    """Return the options that must be given with a file whose format does not state them."""
    return {"size": size, "height_units": "nm"} if name == "npy" else {}
