"""Where particles rest, on the glass twin and on scans of one's own: how many places, on what, and the flow they stand.

    python tests/benchmarks/resting.py [SCAN ...]
    python tests/benchmarks/resting.py --large 4096

Spheres of 3 µm of radius, of glass, with w = 0.1 J/m², land on a grid of 8 × 8 places: first they stay where they land,
as a probe does; then they roll down to where they rest. Critical velocities are those of air at which half of them
move; each is the median over places, weighted by the share of particles there.
``--large`` takes a self-affine scan of so many pixels instead, in memory and lazily: time, and the largest memory.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr

BODIES = {"sphere_radius": 3000.0, "young_modulus": 75.0, "poisson_ratio": 0.22, "work_of_adhesion": 0.1}
GRID = (8, 8)
SPEEDS = (0.05, 0.1, 0.2, 0.5)


def median(values, share):
    """Return the weighted median of those that are known."""
    is_finite = np.isfinite(values)
    order = np.argsort(values[is_finite])
    part = np.cumsum(share[is_finite][order])
    return float(values[is_finite][order][np.searchsorted(part, 0.5 * part[-1])]) if is_finite.any() else np.nan


def told(label, ds, critical, held):
    """Print one line: contacts, pull-off, critical velocity and what is left, of some places."""
    share = ds["landing_share"].values if "landing_share" in ds.coords else np.full(held.sizes["subregion"], 1.0)
    share = share / share.sum()
    contacts = held["contacts"].values
    of = [float(share[contacts == n].sum()) for n in (1, 2)] + [float(share[contacts >= 3].sum())]
    remaining = [share[critical > speed].sum() for speed in SPEEDS]  # of NaN none remain
    print(
        f"  {label:8s} {held.sizes['subregion']:4d} places; on 1, 2, ≥ 3 contacts {of[0]:.2f} {of[1]:.2f} {of[2]:.2f}; "
        f"pull-off {median(held['pull_off_force'].values, share):6.1f} nN; critical "
        f"{median(critical, share):.3f} m/s; left at {SPEEDS} m/s: " + " ".join(f"{x:.2f}" for x in remaining)
    )


def compare(name, scan):
    """Print places, contacts and critical velocities, landed and at rest, on one scan."""
    area = np.prod([high - low for low, high in zip(*[iter(roughxr.scans.regions.extent(scan))] * 2)]) / 1e6
    places = roughxr.particles.resting(scan)
    inner = places.isel(subregion=~places["truncated"].values)
    share = places["landing_share"].values
    print(
        f"{name}: {places.sizes['subregion'] / area:.1f} rests per µm² ({places.sizes['subregion']}); on ≥ 3 summits "
        f"{share[places['supports'].values >= 3].sum():.3f} of the area; from "
        f"{places.attrs['share_off_scan']:.2f} of the area off the scan; {inner.sizes['subregion']} away from the edge"
    )
    catalogue = roughxr.asperities(scan)
    at_rest = roughxr.particles.resting(scan, landings=GRID, on=catalogue)
    for label, where in (("landed", roughxr.scans.regions.centres(scan, GRID)), ("at rest", at_rest)):
        held = roughxr.rolling(catalogue, directions=24, subregions=where)
        critical = roughxr.particles.critical_load(held)["critical_friction_velocity"].values
        told(label, held, critical, held)


def large(pixels, form, path):
    """Print time and memory of a large scan kept in a file: kernels are compiled before, on a small one."""
    small = roughxr.scans.synthetic.self_affine((64, 64), 10.0, rms=2.0, hurst=0.8, rolloff=300.0, cutoff=40.0, seed=1)
    roughxr.particles.resting(roughxr.assign_pair(small, **BODIES))
    scan = xr.open_dataset(path, chunks={"x": 512, "y": 512} if form == "lazy" else None)
    scan = roughxr.assign_pair(scan if form == "lazy" else scan.load(), **BODIES)
    start = time.perf_counter()
    busy = time.process_time()
    places = roughxr.particles.resting(scan)
    took = time.perf_counter() - start
    busy = time.process_time() - busy
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{pixels}², {form}: {places.sizes['subregion']} rests in {took:.1f} s ({busy:.1f} s of processor time, "
        f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}); the process held at most {memory:.0f} MiB, "
        f"the scan's {scan.height.nbytes / 2**20:.0f} MiB among them"
    )


def large_each(pixels):
    """Write a self-affine scan and measure it in memory and lazily, each in a process of its own."""
    how = {"rms": 2.0, "hurst": 0.8, "rolloff": 1000.0, "cutoff": 40.0, "seed": 1}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scan.nc"
        roughxr.scans.to_netcdf(roughxr.scans.synthetic.self_affine((pixels, pixels), 10.0, **how), path)
        for form in ("in memory", "lazy"):
            subprocess.run([sys.executable, __file__, "--large", str(pixels), "--form", form, str(path)], check=True)


def main():
    """Print the comparison for the twin and the scans given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", nargs="*")
    parser.add_argument("--large", type=int, metavar="PIXELS")
    parser.add_argument("--form", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.form:
        large(options.large, options.form, options.scans[0])
        return
    if options.large:
        large_each(options.large)
        return
    warnings.simplefilter("ignore")
    compare("glass twin", roughxr.assign_pair(roughxr.open_sample("glass"), **BODIES))
    for path in options.scans:
        scan = roughxr.level(roughxr.open_scan(path))
        compare(Path(path).name, roughxr.assign_pair(scan, **BODIES))


if __name__ == "__main__":
    main()
