"""Small AFM files of every format that the tests can write, each with the same heights.

A picture is (rows, columns) in nm, the first row at the top. `WRITERS` maps a format's name to
`write(folder, rows, size) -> path`, the size being (along x, along y) in nm.
"""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

import numpy as np
import xarray as xr

from roughxr import scans

#: A picture with no symmetry at all, of unequal sides and square pixels.
ROWS = 18
COLUMNS = 24
PIXEL = 5.0


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


def write_tiff(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    from PIL import Image

    path = folder / "scan.tif"
    Image.fromarray(rows.astype("f4")).save(path)
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
SENSITIVITY = 10.0
VOLTS = 440.0
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
    columns = rows.shape[1]
    lines = rows.shape[0]
    samples = (rows[::-1] * 1e-9).astype("<f4").tobytes()  # x fastest, the last line first
    note = f"ScanSize: {size[0] * 1e-9:.6e}\rScanPoints: {columns}\r".encode()
    labels = b"".join(name.ljust(32, b"\0") for name in (b"", b"HeightRetrace\0remains"))
    step = (size[0] * 1e-9 / columns, size[1] * 1e-9 / lines, 1.0, 1.0)
    wave = struct.pack(
        "<3IihH6xh32s2i4i4d4d4s16shh2d10i64x3hxxiihh2i",
        *(0, 0, 0, rows.size, 2, 0, 1, b"scan", 0, 0, columns, lines, 1, 0, *step, 0.0, 0.0, 0.0, 0.0),
        *(b"m", b"m\0\0\0m".ljust(16, b"\0"), 0, 0, 0.0, 0.0, *[0] * 10, 0, 0, 0, 0, 0, 0, 0, 0, 0),
    )
    assert len(wave) == 320
    sizes = (len(wave) + len(samples), 0, len(note), 0, 0, 0, 0, 0, 0, 0, len(labels), 0, 0, 0, 0)

    def header(checksum: int) -> bytes:
        return struct.pack("<hh15i", 5, checksum, *sizes) + wave

    total = int(np.frombuffer(header(0), "<i2").sum(dtype=np.int64))
    checksum = (-total) & 0xFFFF
    path = folder / "scan.ibw"
    path.write_bytes(header(checksum - 0x10000 if checksum > 0x7FFF else checksum) + samples + note + labels)
    return path


def write_park(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a Park TIFF: one 1 x 1 thumbnail, heights in um as float32 in a private tag."""
    samples = (rows[::-1] * 1e-3).astype("<f4").tobytes()  # the bottom line first

    def text(label: str, length: int) -> bytes:
        return label.encode("utf-16-le").ljust(2 * length, b"\0")

    header = struct.pack("<I", 0) + text("Z Height", 32) + text("Tapping", 8)
    header += struct.pack("<dIIIIdId4I", 0.0, 0, 1, rows.shape[1], rows.shape[0], 0.0, 0, 0.1, 1, 0, 0, 0)[:-4]
    header += struct.pack("<6d", size[0] / 1e3, size[1] / 1e3, 0, 0, 1, 0) + text("um", 8)
    header += struct.pack("<5d", 0, 0, 1.0, 1.0, 0.0) + text("um", 8) + struct.pack("<iii3I", 0, 0, 0, 0, 0, 0)
    header += struct.pack("<dd", 1.0, 0.7) + text("", 8) * 3 + struct.pack("<IIIdd", 2, 0, 0, 0, 0) + text("", 16)
    tags = [(256, 4, 1, 1), (257, 4, 1, 1), (258, 4, 1, 8), (259, 4, 1, 1), (262, 4, 1, 1), (273, 4, 1, 8)]
    tags += [(277, 4, 1, 1), (278, 4, 1, 1), (279, 4, 1, 1), (50432, 4, 1, 0x0E031301), (50433, 4, 1, 0x1000002)]
    start = 16 + 2 + 12 * (len(tags) + 2) + 4
    tags += [(50434, 1, len(samples), start), (50435, 1, len(header), start + len(samples))]
    table = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + b"\0" * 4
    path = folder / "scan.tiff"
    path.write_bytes(b"II*\0" + struct.pack("<I", 16) + b"\0" * 8 + table + samples + header)
    return path


def write_jpk(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a JPK image: a thumbnail, Height (measured) trace, and retrace, which is upside down in height."""
    counts = np.round(rows / JPK_COUNT).astype("<i4")[::-1]  # the first line is the lowest
    return write_jpk_pages(
        folder / "scan.jpk",
        [
            ("Height (measured)", 0, counts, ("m", JPK_COUNT * 1e-9)),
            ("Height (measured)", 1, -counts, ("m", JPK_COUNT * 1e-9)),
        ],
        size,
    )


#: Nanometres of one count in a JPK image.
JPK_COUNT = 1e-6


def write_jpk_pages(path: Path, pages: list[tuple[str, int, np.ndarray, tuple[str, float]]], size: tuple[float, float]):
    """Write pages (name, 1 for a retrace, counts from the first line, units and their value of a count)."""
    grid = [
        (0x8003, 2, b"2020-01-02 10:11:12 +0000\0"),
        (0x8042, 12, struct.pack("<d", size[0] * 1e-9)),
        (0x8043, 12, struct.pack("<d", size[1] * 1e-9)),
    ]
    written = [(grid, np.zeros((2, 2), "<i4"))]
    for name, retrace, counts, (units, multiplier) in pages:
        tags = [(0x8050, 2, name.encode() + b"\0"), (0x8051, 4, struct.pack("<I", retrace))]
        tags += [(0x8052, 2, name.encode() + b"\0"), (0x8080, 4, struct.pack("<I", 2)), (0x8081, 2, b"calibrated\0")]
        tags += [(0x8090, 2, b"volts\0"), (0x80A2, 2, b"V\0"), (0x80A3, 2, b"LinearScaling\0")]
        tags += [(0x80A4, 12, struct.pack("<d", 1.0)), (0x80A5, 12, struct.pack("<d", 0.0))]
        tags += [(0x80C0, 2, b"calibrated\0"), (0x80D2, 2, units.encode() + b"\0"), (0x80D3, 2, b"LinearScaling\0")]
        tags += [(0x80D4, 12, struct.pack("<d", multiplier)), (0x80D5, 12, struct.pack("<d", 0.0))]
        written.append((tags, counts))
    out = bytearray(b"II*\0" + struct.pack("<I", 8))
    for number, (tags, counts) in enumerate(written):
        lines, columns = counts.shape
        whole = [(256, 4, columns), (257, 4, lines), (258, 3, 32), (259, 3, 1), (262, 3, 1), (273, 4, 0), (277, 3, 1)]
        whole += [(278, 4, lines), (279, 4, counts.nbytes), (339, 3, 2), *tags]
        at = len(out) + 2 + 12 * len(whole) + 4
        entries = b""
        behind = b""
        for tag, kind, content in whole:
            content = struct.pack("<I", at if tag == 273 else content) if isinstance(content, int) else content
            count = len(content) // {2: 1, 3: 4, 4: 4, 12: 8}[kind]
            if tag == 273:
                place = len(entries)
            if len(content) > 4:
                content, behind = struct.pack("<I", at + len(behind)), behind + content
            entries += struct.pack("<HHI", tag, kind, count) + content.ljust(4, b"\0")
        entries = entries[: place + 8] + struct.pack("<I", at + len(behind)) + entries[place + 12 :]
        end = at + len(behind) + counts.nbytes
        following = struct.pack("<I", end if number < len(written) - 1 else 0)
        out += struct.pack("<H", len(whole)) + entries + following + behind + counts.tobytes()
    path.write_bytes(bytes(out))
    return path


def write_sxm(folder: Path, rows: np.ndarray, size: tuple[float, float], up: bool = True) -> Path:
    """Write a Nanonis image, scanned upwards: Z and Current, forward and backward; Z backward is upside down."""
    head = f""":NANONIS_VERSION:
2
:SCANIT_TYPE:
              FLOAT            MSBFIRST
:SCAN_PIXELS:
       {rows.shape[1]}       {rows.shape[0]}
:SCAN_RANGE:
           {size[0] * 1e-9:.9E}           {size[1] * 1e-9:.9E}
:SCAN_ANGLE:
            0.000E+0
:SCAN_DIR:
{"up" if up else "down"}
:DATA_INFO:
\tChannel\tName\tUnit\tDirection\tCalibration\tOffset
\t14\tZ\tm\tboth\t9.000E-9\t0.000E+0
\t0\tCurrent\tA\tboth\t1.000E-9\t0.000E+0

:SCANIT_END:


"""
    lines = rows[:: -1 if up else 1] * 1e-9
    images = (lines, -lines[:, ::-1], 0 * lines, 0 * lines)
    path = folder / "scan.sxm"
    path.write_bytes(head.encode() + b"\x1a\x04" + b"".join(image.astype(">f4").tobytes() for image in images))
    return path


def write_asd(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    return write_movie(folder / "scan.asd", [rows], size)


#: Nanometres of one level of a movie: a range of 10 V in 4096 levels.
ASD_LEVEL = 2.0 * 1.0 * 10 / 4096


def write_movie(path: Path, frames: list[np.ndarray], size: tuple[float, float], version: int = 1) -> Path:
    """Write a high-speed movie of topographies and their phase 0, the last line first."""
    lines, columns = frames[0].shape
    if version == 0:
        head = struct.pack(
            "<i2s2s5i4h3fIi?ih",
            0,
            b"TP",
            b"PH",
            0,
            32,
            3,
            0,
            2,
            columns,
            lines,
            *map(int, size),
            1,
            2,
            1,
            1 << 18,
            12,
            0,
            0,
            0,
        )
        head += struct.pack(
            "<h6B2f6ih3s2fi2s", 2020, *[1] * 6, 0, 0, 0, 0, 0, len(frames), len(frames), 1, 1, b"abc", 1, 1, 0, b"ok"
        )
        head = head[: 12 - 4] + struct.pack("<i", len(head)) + head[12:]
    else:
        head = struct.pack(
            "<6i2s2x2s2x8i",
            version,
            0,
            32,
            932,
            3,
            2,
            b"TP",
            b"PH",
            len(frames),
            len(frames),
            0,
            1,
            columns,
            lines,
            *map(int, size),
        )
        head += struct.pack("<?9i3fi12xiIi6f", False, *[1] * 9, 1.0, 1.0, 1.0, 0, 1, 1 << 18, 12, 1, 1, 1, 1, 2.0, 1.0)
        head += b"abcok" + (struct.pack("<2id5i2i", 1, 0, 0.0, 255, 0, 1, 0, 0, 7, 7) if version == 2 else b"")
        head = head[:4] + struct.pack("<i", len(head)) + head[8:]
    levels = [np.round((5 * 2.0 - rows) / ASD_LEVEL).astype("<i2")[::-1].tobytes() for rows in frames]
    parts = [
        struct.pack("<i", k).ljust(32, b"\0") + frame
        for k, frame in enumerate([*levels, *(bytes(len(x)) for x in levels)])
    ]
    path.write_bytes(head + b"".join(parts))
    return path


def write_topostats(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    import h5py

    path = folder / "scan.topostats"
    with h5py.File(path, "w") as file:
        file["topostats_version"] = "2.3.0"
        file["filename"] = "minicircle"
        file["pixel_to_nm_scaling"] = size[0] / rows.shape[1]
        file["image"] = rows
        file["grain_masks/above"] = (rows > 1).astype(int)
    return path


def write_h5_jpk(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a file as of JPK's fast instruments: a frame in each column, the lowest line first."""
    import h5py

    path = folder / "scan.h5-jpk"
    with h5py.File(path, "w") as file:
        for number, (retrace, sign) in enumerate(((b"false", 1), (b"true", -1))):
            channel = file.create_group(f"Measurement_000/Channel_{number:03d}")
            channel["Height"] = (sign * rows[::-1] * 1e-9).reshape(-1, 1)
            channel.attrs.update({"channel.name": b"height", "retrace": retrace})
            scale = "net-encoder.scaling."
            channel.attrs.update({f"{scale}multiplier": 1.0, f"{scale}offset": 0.0, f"{scale}unit.unit": b"m"})
        grid = "position-pattern.grid."
        pattern = {f"{grid}ilength": rows.shape[1], f"{grid}jlength": rows.shape[0]}
        file["Measurement_000"].attrs.update(
            {**pattern, f"{grid}ulength": size[0] * 1e-9, f"{grid}vlength": size[1] * 1e-9}
        )
    return path


def write_nhf(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a Nanosurf file of version 1: 32-bit counts over the calibrated range, the lowest line first."""
    import h5py

    path = folder / "scan.nhf"
    reach = 1e-7
    with h5py.File(path, "w") as file:
        group = file.create_group("measurement_0")
        group.attrs.update(image_points_per_line=rows.shape[1], image_number_of_lines=rows.shape[0])
        group.attrs.update(image_size_x=size[0] * 1e-9, image_size_y=size[1] * 1e-9)
        for number, name in enumerate(("Forward", "Backward")):
            segment = group.create_group(f"segment_{number}")
            segment.attrs["name"] = name
            counts = (rows[::-1] * 1e-9 / (2 * reach) * 2**32).round().astype("i4") * (-1) ** number
            segment["data_0"] = counts.ravel()
            about = {"name": "Topography", "base_calibration_unit": "m", "dataset_element_type": 0}
            segment["data_0"].attrs.update({**about, "base_calibration_min": -reach, "base_calibration_max": reach})
    return path


def write_hdf5(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    import h5py

    path = folder / "scan.h5"
    with h5py.File(path, "w") as file:
        file["scans/first"] = rows
    return path


def write_xyz(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    scan = expected_scan(rows, size)
    places = np.meshgrid(scan.x, scan.y, indexing="ij")
    path = folder / "scan.xyz"
    points = np.stack([*places, scan.height.values], -1).reshape(-1, 3)
    np.savetxt(path, points, header="X[nm] Y[nm] Z[nm]", comments="")
    return path


def write_sdf(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write an ISO 25178-71 file as text."""
    steps = f"Xscale = {size[0] * 1e-9 / rows.shape[1]!r}\nYscale = {size[1] * 1e-9 / rows.shape[0]!r}\nZscale = 1.0e-9"
    head = f"aISO-1.0\nManufacID = any\nCreateDate = 010120200000\nModDate = 010120200000\nNumPoints = {rows.shape[1]}"
    head += f"\nNumProfiles = {rows.shape[0]}\n{steps}\nZresolution = 1e-12\nCompression = 0\nDataType = 7"
    head += "\nCheckType = 0\n*\n"
    path = folder / "scan.sdf"
    path.write_text(head + "\n".join(" ".join(map(repr, line.tolist())) for line in rows) + "\n*\n")
    return path


def write_binary_sdf(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write an ISO 25178-71 file of 64-bit heights without a trailer."""
    steps = [length * 1e-9 / n for length, n in zip(size, rows.shape[::-1])]
    shape = rows.shape[::-1]
    head = struct.pack(
        "<8s10s12s12sHHddddBBB", b"bISO-1.0", b"any", b"0" * 12, b"0" * 12, *shape, *steps, 1e-9, 0, 0, 7, 0
    )
    path = folder / "binary.sdf"
    path.write_bytes(head + rows.astype("<f8").tobytes())
    return path


def write_mi(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write an Agilent image of 16-bit counts over a range, the lowest line first."""
    reach = 10.0  # nm
    head = {"fileType": "Image", "xPixels": rows.shape[1], "yPixels": rows.shape[0]}
    head |= {"xLength": size[0] * 1e-9, "yLength": size[1] * 1e-9, "bufferLabel": "Topography", "bufferUnit": "nm"}
    head |= {"bufferRange": reach, "data": "BINARY"}
    text = "".join(f"{key:<14s}{entry}\n" for key, entry in head.items())
    path = folder / "scan.mi"
    path.write_bytes(text.encode() + np.round(rows[::-1] / reach * 32768).astype("<i2").tobytes())
    return path


def write_nid(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a Nanosurf image of 16-bit counts over a range, the lowest line first."""
    reach = 20.0  # nm
    image = {"Points": rows.shape[1], "Lines": rows.shape[0], "SaveMode": "Binary", "SaveOrder": "Intel"}
    image |= {"SaveSign": "Signed", "SaveBits": 16, "Frame": "Scan forward", "Dim0Unit": "m", "Dim1Unit": "m"}
    image |= {"Dim2Unit": "m", "Dim2Name": "Z-Axis", "Dim0Range": size[0] * 1e-9, "Dim1Range": size[1] * 1e-9}
    image |= {"Dim2Range": reach * 1e-9, "Dim2Min": -reach / 2 * 1e-9}
    parts = {"DataSet": {"GroupCount": 1, "Gr0-Count": 1, "Gr0-Ch0": "DataSet-0:0"}}
    parts |= {"DataSet-Info": {"Date": "01-02-2020", "Time": "10:11:12"}, "DataSet-0:0": image}
    lines = [line for name, part in parts.items() for line in (f"[{name}]", *(f"{k}={v}" for k, v in part.items()))]
    text = "\r\n".join(lines)
    path = folder / "scan.nid"
    path.write_bytes(text.encode() + b"\r\n#!" + np.round(rows[::-1] / reach * 65536).astype("<i2").tobytes())
    return path


def write_wsxm(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a WSxM image of 64-bit heights, turned by half a turn."""
    parts = {"Control": {"X Amplitude": f"{size[0]} nm", "Y Amplitude": f"{size[1]} nm"}}
    parts["General Info"] = {"Number of rows": rows.shape[0], "Number of columns": rows.shape[1]}
    parts["General Info"] |= {"Image Data Type": "double", "Z Amplitude": f"{np.ptp(rows)} nm"}
    lines = [line for name, part in parts.items() for line in (f"[{name}]", *(f"{k}: {v}" for k, v in part.items()))]
    head = "\r\n".join(
        ["WSxM file copyright UAM", "SxM Image file", "Image header size: 512", *lines, "[Header end]", ""]
    )
    path = folder / "scan.stp"
    path.write_bytes(head.encode() + rows[::-1, ::-1].astype("<f8").tobytes())
    return path


def write_bcr(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    head = f"fileformat = bcrf\nheadersize = 2048\nxpixels = {rows.shape[1]}\nypixels = {rows.shape[0]}\n"
    head += (
        f"xlength = {size[0]}\nylength = {size[1]}\nxunit = nm\nyunit = nm\nzunit = nm\nintelmode = 1\nbit2nm = 1.0\n"
    )
    path = folder / "scan.bcrf"
    path.write_bytes(head.encode().ljust(2048) + rows.astype("<f4").tobytes())
    return path


def write_x3p(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    steps = [length * 1e-9 / n for length, n in zip(size, rows.shape[::-1])]
    axes = "".join(
        f"<{name}><AxisType>{kind}</AxisType><DataType>D</DataType><Increment>{step!r}</Increment>"
        f"<Offset>0</Offset></{name}>"
        for name, kind, step in (("CX", "I", steps[0]), ("CY", "I", steps[1]), ("CZ", "A", 1.0))
    )
    xml = '<?xml version="1.0"?><p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1>'
    xml += "<Revision>ISO5436 - 2000</Revision>"
    xml += f"<FeatureType>SUR</FeatureType><Axes>{axes}</Axes></Record1>"
    xml += "<Record2><Date>2020-01-01T00:00:00</Date></Record2><Record3><MatrixDimension>"
    xml += f"<SizeX>{rows.shape[1]}</SizeX><SizeY>{rows.shape[0]}</SizeY><SizeZ>1</SizeZ></MatrixDimension>"
    xml += "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink></Record3></p:ISO5436_2>"
    path = folder / "scan.x3p"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("main.xml", xml)
        archive.writestr("bindata/data.bin", (rows * 1e-9).astype("<f8").tobytes())
    return path


def write_sur(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write a Digital Surf file of 32-bit counts of 1e-4 nm."""
    counts = np.round(rows / 1e-4).astype("<i4")
    steps = [length / n for length, n in zip(size, rows.shape[::-1])]
    names = b"".join(word.ljust(16) for word in (b"X", b"Y", b"Z", *[b"nm"] * 6))
    head = b"DIGITAL SURF" + struct.pack("<4H", 0, 1, 1, 2) + b" " * 60 + struct.pack("<5H2IH", 0, 0, 0, 0, 1, 0, 0, 32)
    head += struct.pack("<4iI3f", counts.min(), counts.max(), *rows.shape[::-1], rows.size, *steps, 1e-4) + names
    head += struct.pack("<3f3H3I7Hf2I3H", 1, 1, 1, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 2020, 1, 1.0, 0, 0, 0, 0, 0)
    path = folder / "scan.sur"
    path.write_bytes(head + bytes(128) + struct.pack("<3f", 0, 0, 0) + bytes(34) + counts.tobytes())
    return path


def write_mdt(folder: Path, rows: np.ndarray, size: tuple[float, float]) -> Path:
    """Write an NT-MDT file of one scanned frame of 16-bit counts of 1e-3 nm, the lowest line first."""
    counts = np.round(rows[::-1] / MDT_COUNT).astype("<i2")
    steps = [length / n for length, n in zip(size, rows.shape[::-1])]
    scales = struct.pack("<2fh2fh2fh", 0, steps[0], -1, 0, steps[1], -1, 0, MDT_COUNT, -1)  # -1: nm
    variables = scales + struct.pack("<2B2H", 0, 0, *rows.shape[::-1])
    body = variables + struct.pack("<4H", 0, *rows.shape[::-1], 0) + counts.tobytes()
    frame = struct.pack("<I2H2B5HH", 22 + len(body), 0, 2020, 1, 1, 1, 1, 1, 1, 1, len(variables))
    path = folder / "scan.mdt"
    path.write_bytes(b"\x01\xb0\x93\xff" + struct.pack("<I4xH18xB", len(frame) + len(body), 0, 0) + frame + body)
    return path


#: Nanometres of one count in an NT-MDT file.
MDT_COUNT = 1e-3


#: Formats that hold 64-bit heights and the size as written; others round.
WRITERS = {
    "gsf": write_gsf,
    "gwy": write_gwy,
    "text": write_text,
    "npy": write_npy,
    "tiff": write_tiff,
    "native": write_native,
    "surfacetopography": write_surfacetopography,
    "cf": write_cf,
    "bruker": write_bruker,
    "igor": write_igor,
    "park": write_park,
    "jpk": write_jpk,
    "sxm": write_sxm,
    "asd": write_asd,
    "topostats": write_topostats,
    "h5-jpk": write_h5_jpk,
    "nhf": write_nhf,
    "hdf5": write_hdf5,
    "xyz": write_xyz,
    "sdf": write_sdf,
    "mi": write_mi,
    "nid": write_nid,
    "wsxm": write_wsxm,
    "bcr": write_bcr,
    "x3p": write_x3p,
    "sur": write_sur,
    "mdt": write_mdt,
}

#: Largest error of a height in nm by format: 16-bit counts, 32-bit numbers, decimals.
ROUNDING = {"bruker": 0.04, "asd": 0.003, "mdt": 0.001, "mi": 2e-4, "nid": 2e-4, "sur": 1e-4}
ROUNDING |= dict.fromkeys(("gsf", "igor", "park", "jpk", "sxm", "nhf", "bcr", "tiff"), 1e-6)


def given(name: str, size: tuple[float, float]) -> dict[str, object]:
    """Return the options that must be given with a file whose format does not state them."""
    return {"size": size, "height_units": "nm"} if name in ("npy", "hdf5", "tiff") else {}
