"""Peak memory of a large scan that is opened lazily: run as ``python tests/benchmarks/scan_memory.py``.

Each step runs in a process of its own, so that its peak is its own. The figure to look at is the rise of the
resident set over what the imports take, beside the size of all heights.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

CHUNK = 512


def make(path: Path, pixels: int) -> None:
    """Write a tilted, rough scan of pixels x pixels, strip by strip."""
    import netCDF4

    with netCDF4.Dataset(path, "w") as file:
        for axis in "xy":
            file.createDimension(axis, pixels)
            places = file.createVariable(axis, "f8", (axis,))
            places[:], places.units = (np.arange(pixels) + 0.5) * 2.5, "nm"
        height = file.createVariable("height", "f8", ("x", "y"), chunksizes=(CHUNK, CHUNK))
        height.units = "nm"
        rng = np.random.default_rng(0)
        for start in range(0, pixels, CHUNK):
            rows = np.arange(start, min(start + CHUNK, pixels))
            height[rows[0] : rows[-1] + 1] = rng.normal(0, 1, (rows.size, pixels)) + 0.1 * rows[:, None]


def _level(scan, **options):
    from roughxr.scans import level

    return level(scan, **options)["height"].max().compute()


def _write(scan):
    from roughxr.scans import level, to_netcdf

    with tempfile.TemporaryDirectory() as folder:
        to_netcdf(level(scan), Path(folder) / "levelled.nc")


#: What is done with the lazy scan.
STEPS = {
    "open": lambda scan: None,
    "read": lambda scan: scan["height"].max().compute(),
    "level plane": _level,
    "level plane, particles left out": lambda scan: _level(scan, exclude_above=3.0),
    "level order 4": lambda scan: _level(scan, method="polynomial", order=4),
    "level median": lambda scan: _level(scan, method="median"),
    "level plane, write": _write,
    "level plane, in memory": lambda scan: _level(scan.load()),
}


def measure(path: Path, step: str) -> None:
    """Print seconds and the rise of peak memory in MiB of one step."""
    from roughxr.scans import open_scan

    scan = open_scan(path, chunks={})
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    STEPS[step](scan)
    rise = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    print(f"{step:34s} {time.perf_counter() - start:7.1f} s {before / 1024:8.0f} MiB before {rise:8.0f} MiB more")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pixels", type=int, default=4096)
    parser.add_argument("--file", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--step", choices=STEPS, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.step:
        measure(options.file, options.step)
        return
    print(f"heights: {options.pixels**2 * 8 / 2**20:.0f} MiB, a chunk: {CHUNK**2 * 8 / 2**20:.0f} MiB")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.nc"
        make(path, options.pixels)
        for step in STEPS:
            subprocess.run([sys.executable, __file__, "--file", str(path), "--step", step], check=True)


if __name__ == "__main__":
    main()
