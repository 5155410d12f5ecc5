"""Superposition at many places: ``python tests/benchmarks/superposition_map.py [PICTURE]``.

1. The pull-off force at every pixel of the glass twin (262,144 centres, exact pull-off), on two threads, and the same
   at 200 random centres by `superpose`; drawn beside the scan where a PICTURE is named.
2. 64 subregions x 250 displacements on a catalogue of about 20,000 asperities, with exact pull-off, beside an estimate
   from the operations that one contact needs.
"""

from __future__ import annotations

import sys
import time

import dask
import numpy as np

import roughxr
from roughxr.pull_off_map import pull_off_map

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.675}

#: Floating-point operations of one contact on a collapsed branch: two square roots and a quotient (some 20 cycles
#: each where one waits for the other), weights, three sums of four products, scales and counts.
CYCLES_PER_CONTACT = 130


def timed(function, repeats=3):
    """Return the result and the least time of some repetitions, s."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        result = function()
        times.append(time.perf_counter() - began)
    return result, min(times)


def clock() -> float:
    """Return the processor's rate, GHz, from a loop whose steps wait for each other: an addition takes 4 cycles."""
    from numba import njit

    @njit
    def chain(n):
        x = 1.0
        for _ in range(n):
            x = x * 0.5 + 1.0
        return x

    chain(10)
    _, seconds = timed(lambda: chain(20_000_000))
    return 20_000_000 * 8 / seconds / 1e9


def every_pixel(scan, picture):
    """Time the map, compare it and draw it."""
    pull_off_map(scan, subregions=(2, 2))
    for workers in (1, 2):
        with dask.config.set(scheduler="threads", num_workers=workers):
            cpu = -time.process_time()
            found, seconds = timed(lambda: pull_off_map(scan), repeats=1)
            cpu += time.process_time()
        centres = found.pull_off_force.size
        print(
            f"every pixel, {workers} thread(s): {seconds:.1f} s for {centres} centres, "
            f"{cpu / centres * 1e6:.0f} us of processor time each"
        )
    rng, worst = np.random.default_rng(0), 0.0
    catalogue = scan.contact.asperities()
    for i, j in rng.integers(0, scan.sizes["x"], (200, 2)):
        place = scan.x.values[[i]], scan.y.values[[j]]
        one = roughxr.superpose(catalogue, delta=[float(found.pull_off_delta[i, j])], subregions=place)
        worst = max(worst, abs(-one.force.item() / float(found.pull_off_force[i, j]) - 1))
    print(f"200 random centres against superpose: relative difference at most {worst:.1e}")
    if picture:
        draw(scan, found, picture)


def draw(scan, found, picture):
    """Draw the scan and, beside it, its pull-off force."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    scan.height.plot(x="x", y="y", ax=left, cmap="gray")
    (found.pull_off_force / 1000).assign_attrs(long_name="pull-off force", units="µN").plot(x="x", y="y", ax=right)
    for axes in (left, right):
        axes.set_aspect("equal")
    figure.savefig(picture, dpi=120)
    print(f"drawn as {picture}")


def sweep(scan):
    """Time 64 x 250 on many asperities and compare it with the estimate."""
    catalogue = scan.contact.asperities()
    copies = -(-20_000 // catalogue.sizes["asperity"])
    catalogue = catalogue.isel(asperity=np.tile(np.arange(catalogue.sizes["asperity"]), copies)[:20_000])
    deltas, ghz = np.linspace(-5, 25, 250), clock()
    for formulation in ("energy", "self_similar"):
        options = {"subregions": (8, 8), "formulation": formulation}
        with dask.config.set(scheduler="synchronous"):
            swept, seconds = timed(lambda o=options: roughxr.superpose(catalogue, delta=deltas, **o))
            _, more = timed(lambda o=options: pull_off_map(catalogue, **o))
        contacts = int(swept.contacts.sum())
        estimate = contacts * CYCLES_PER_CONTACT / ghz * 1e-9
        print(
            f"64 x 250 x 20,000, {formulation}: sweep {seconds * 1e3:.0f} ms, exact pull-off {more * 1e3:.0f} ms; "
            f"{contacts} contacts at {CYCLES_PER_CONTACT} cycles and {ghz:.1f} GHz: {estimate * 1e3:.0f} ms, "
            f"{seconds / estimate:.1f} times that"
        )


if __name__ == "__main__":
    glass = roughxr.assign_pair(roughxr.open_sample("glass"), **PAIR)
    sweep(glass)
    every_pixel(glass, sys.argv[1] if len(sys.argv) > 1 else None)
