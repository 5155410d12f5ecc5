"""Peak memory of a large scan that is opened lazily: run as ``python tests/benchmarks/scan_memory.py``.

Each step runs in a process of its own, so that its peak is its own, after a scan of 2 MiB has gone the same way. The
figure to look at is the rise of the resident set over what modules and compiled kernels take, beside the size of all
heights and of a chunk. Each of dask's threads works on a chunk of its own. The netCDF library would keep up to 64 MiB
of chunks that nobody asks for twice: ``--cache`` says how much it may.
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

#: Shortest and longest waves of the surface, pixels.
WAVES = 30, 300


def make(path: Path, pixels: int, chunk: int = CHUNK) -> None:
    """Write a tilted scan of pixels x pixels, the sum of 200 random waves, strip by strip."""
    import netCDF4

    rng = np.random.default_rng(0)
    wavenumber, direction, phase = 2 * np.pi / rng.uniform(*WAVES, 200), *rng.uniform(0, 2 * np.pi, (2, 200))
    along_y = np.exp(1j * np.outer(wavenumber * np.sin(direction), np.arange(pixels))) / 10

    with netCDF4.Dataset(path, "w") as file:
        for axis in "xy":
            file.createDimension(axis, pixels)
            places = file.createVariable(axis, "f8", (axis,))
            places[:], places.units = (np.arange(pixels) + 0.5) * 2.5, "nm"
        height = file.createVariable("height", "f8", ("x", "y"), chunksizes=(chunk, chunk))
        height.units = "nm"
        for start in range(0, pixels, chunk):
            rows = np.arange(start, min(start + chunk, pixels))
            along_x = np.exp(1j * (np.outer(rows, wavenumber * np.cos(direction)) + phase))
            height[rows[0] : rows[-1] + 1] = (along_x @ along_y).real + 0.1 * rows[:, None]


def _level(scan, **options):
    from roughxr.scans import level

    return level(scan, **options)["height"].max().compute()


def _write(scan):
    from roughxr.scans import level, to_netcdf

    with tempfile.TemporaryDirectory() as folder:
        to_netcdf(level(scan), Path(folder) / "levelled.nc")


def _asperities(scan):
    import roughxr

    return roughxr.asperities(roughxr.level(scan))


#: What is done with the lazy scan.
STEPS = {
    "open": lambda scan: None,
    "read": lambda scan: scan["height"].max().compute(),
    "level plane": _level,
    "level plane, particles left out": lambda scan: _level(scan, exclude_above=3.0),
    "level order 4": lambda scan: _level(scan, method="polynomial", order=4),
    "level median": lambda scan: _level(scan, method="median"),
    "level plane, write": _write,
    "level plane, asperities": _asperities,
    "level plane, in memory": lambda scan: _level(scan.load()),
    "level plane, asperities, in memory": lambda scan: _asperities(scan.load()),
}


def peak() -> float:
    """Return the largest resident set so far, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def measure(path: Path, small: Path, step: str, cache: int) -> None:
    """Print seconds and the rise of peak memory in MiB of one step."""
    import netCDF4

    from roughxr.scans import open_scan

    netCDF4.set_chunk_cache(cache * 2**20, 1000, 0.75)
    STEPS[step](open_scan(small, chunks={}))
    before, start = peak(), time.perf_counter()
    found = STEPS[step](open_scan(path, chunks={}))
    took, rise = time.perf_counter() - start, peak() - before
    size = (
        f", {found.nbytes / 2**20:.1f} MiB of it {found.sizes['asperity']} asperities" if "asperities" in step else ""
    )
    print(f"{step:34s} {took:7.1f} s {before:8.0f} MiB before {rise:8.0f} MiB more{size}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pixels", type=int, default=4096)
    parser.add_argument("--cache", type=int, default=4, help="MiB of chunks that the netCDF library may keep")
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--step", choices=STEPS, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.step:
        measure(options.folder / "large.nc", options.folder / "small.nc", options.step, options.cache)
        return
    print(f"heights: {options.pixels**2 * 8 / 2**20:.0f} MiB, a chunk: {CHUNK**2 * 8 / 2**20:.0f} MiB")
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder) / "large.nc", options.pixels)
        make(Path(folder) / "small.nc", CHUNK, CHUNK // 2)
        for step in STEPS:
            command = [sys.executable, __file__, "--folder", folder, "--step", step, "--cache", str(options.cache)]
            subprocess.run(command, check=True)


if __name__ == "__main__":
    main()
