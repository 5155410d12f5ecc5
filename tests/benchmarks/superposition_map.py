"""Superposition at many places: ``python tests/benchmarks/superposition_map.py [PICTURE]``.

1. The pull-off force at every pixel of the glass twin (262,144 centres, exact pull-off), on two threads, and the same
   at 200 random centres by `superpose`; drawn beside the scan where a PICTURE is named.
2. 64 subregions x 250 displacements on a catalogue of 20,000 asperities: processor time on one thread.
3. The catalogues of two 4096 x 4096 scans, and the reconstruction of a 2048 x 2048 one: processor time of the first
   calls, of compiled kernels. Repeated calls take the catalogue from memory.
"""

from __future__ import annotations

import sys
import time

import dask
import numpy as np

import roughxr
from roughxr.mechanics.asperity.asperity_sum import FORMULATIONS
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.vocabulary.adhesion_laws import laws_of

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.675}


def timed(function, repeats=3, clock=time.perf_counter):
    """Return the result and the least time of some repetitions, s."""
    times = []
    for _ in range(repeats):
        began = clock()
        result = function()
        times.append(clock() - began)
    return result, min(times)


def spent(function):
    """Return the processor time that a function takes once compiled, s."""
    function()
    return timed(function, repeats=7, clock=time.process_time)[1]


def every_pixel(scan, picture):
    """Time the map, compare it and draw it."""
    pull_off_map(scan, subregions=(2, 2))
    for workers in (1, 2):
        with dask.config.set(scheduler="threads", num_workers=workers):
            cpu = -time.process_time()
            mapped, seconds = timed(lambda: pull_off_map(scan), repeats=1)
            cpu += time.process_time()
        centres = mapped.pull_off_force.size
        print(
            f"every pixel, {workers} thread(s): {seconds:.1f} s for {centres} centres, "
            f"{cpu / centres * 1e6:.0f} us of processor time each"
        )
    rng = np.random.default_rng(0)
    worst = 0.0
    catalogue = scan.contact.asperities()
    for i, j in rng.integers(0, scan.sizes["x"], (200, 2)):
        place = scan.x.values[[i]], scan.y.values[[j]]
        single = roughxr.superpose(catalogue, delta=[float(mapped.pull_off_delta[i, j])], subregions=place)
        worst = max(worst, abs(-single.force.item() / float(mapped.pull_off_force[i, j]) - 1))
    print(f"200 random centres against superpose: relative difference at most {worst:.1e}")
    if picture:
        draw(scan, mapped, picture)


def draw(scan, mapped, picture):
    """Draw the scan and, beside it, its pull-off force."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (height_axes, force_axes) = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    scan.height.plot(x="x", y="y", ax=height_axes, cmap="gray")
    (mapped.pull_off_force / 1000).assign_attrs(long_name="pull-off force", units="µN").plot(
        x="x", y="y", ax=force_axes
    )
    for axes in (height_axes, force_axes):
        axes.set_aspect("equal")
    figure.savefig(picture, dpi=120)
    print(f"drawn as {picture}")


def sweep(scan):
    """Time 64 x 250 displacements on many asperities."""
    catalogue = scan.contact.asperities()
    copies = -(-20_000 // catalogue.sizes["asperity"])
    catalogue = catalogue.isel(asperity=np.tile(np.arange(catalogue.sizes["asperity"]), copies)[:20_000])
    catalogue["x"] = catalogue.x + 1e-6 * np.arange(20_000)  # each once
    deltas = np.linspace(-5, 25, 250)
    for law in (*FORMULATIONS, "dugdale", "hertz"):
        options = {"law": law} if law in laws_of("superpose") else {"formulation": law}
        with dask.config.set(scheduler="synchronous"):
            whole = spent(lambda o=options: roughxr.superpose(catalogue, delta=deltas, subregions=(8, 8), **o))
        print(f"{law:18} 64 x 250 x 20,000: {1e3 * whole:.0f} ms")


def large_scans():
    """Time the catalogues of 4096 x 4096 scans of longer and shorter waves, and the reconstruction of a 2048² one."""
    for cutoff in (120, 60):  # nm; below eight pixels heights between the pixels are searched, too
        options = {"rms": 3.0, "hurst": 0.8, "rolloff": 1000, "cutoff": cutoff, "seed": 1}
        large, small, tiny = (self_affine((n, n), 10.0, **options) for n in (4096, 2048, 256))
        roughxr.reconstruct(tiny, roughxr.asperities(tiny))  # compiles
        catalogue, seconds = timed(lambda scan=large: roughxr.asperities(scan), 1, time.process_time)
        print(f"{catalogue.sizes['asperity']} asperities of a 4096 x 4096 scan, waves of {cutoff} nm: {seconds:.2f} s")
        catalogue = roughxr.asperities(small)
        _, seconds = timed(lambda scan=small, c=catalogue: roughxr.reconstruct(scan, c), 1, time.process_time)
        print(f"reconstruction of a 2048 x 2048 scan: {seconds:.2f} s")


if __name__ == "__main__":
    glass = roughxr.assign_pair(roughxr.open_sample("glass"), **PAIR)
    sweep(glass)
    large_scans()
    every_pixel(glass, sys.argv[1] if len(sys.argv) > 1 else None)
