"""Superposition at many places: ``python tests/benchmarks/superposition_map.py [PICTURE]``.

1. The pull-off force at every pixel of the glass twin (262,144 centres, exact pull-off), on two threads, and the same
   at 200 random centres by `superpose`; drawn beside the scan where a PICTURE is named.
2. 64 subregions x 250 displacements on a catalogue of 20,000 asperities, with exact pull-off: processor time of each
   part on one thread, beside an estimate from the operations that it needs.
"""

from __future__ import annotations

import sys
import time

import dask
import numpy as np

import roughxr
from roughxr.asperity.asperity_sum import FORMULATIONS, LAWS, catalogue_field, options_of
from roughxr.asperity.maps import pull_off_map
from roughxr.kernels.asperity import superposition as kernel

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.675}

#: Cycles of one unit of work on one core, counted from the operations, nothing waiting for anything: a square root or a
#: quotient keeps its unit busy for 5, of products, sums and loads two are begun in one.
CYCLES = {
    "contact": 60,  # two roots, a quotient; weights, three sums of four products, sizes, scales: 70 products and sums
    "contact, closed": 60,  # five roots, four quotients, 30 products and sums
    "contact, hertz": 10,  # a root, 8 products and sums
    "offset": 5,  # a root, a quotient, 8 products and sums, four offsets at once
    "scales": 1200,  # six secant steps for the ellipse, each a logarithm, an exponential and a mean of four steps
    "neighbour": 700,  # 14 levels of a tree, down and up, a few points in each leaf
}


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


def clock() -> float:
    """Return the processor's rate, GHz, from six operations on one integer that wait for each other, a cycle each."""
    from numba import njit

    @njit
    def chain(n):
        x = np.uint64(88172645463325252)
        for _ in range(n):
            x ^= x << np.uint64(13)
            x ^= x >> np.uint64(7)
            x ^= x << np.uint64(17)
        return x

    return 20_000_000 * 6 / spent(lambda: chain(20_000_000)) / 1e9


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
    """Time 64 x 250 on many asperities, by parts, and compare with the estimate."""
    catalogue = scan.contact.asperities()
    copies = -(-20_000 // catalogue.sizes["asperity"])
    catalogue = catalogue.isel(asperity=np.tile(np.arange(catalogue.sizes["asperity"]), copies)[:20_000])
    deltas, ghz = np.linspace(-5, 25, 250), clock()
    print(f"64 x 250 x 20,000, processor time in ms (estimate at {ghz:.1f} GHz)")
    for law in (*FORMULATIONS, "maugis", "hertz"):
        options = {"law": law} if law in LAWS else {"formulation": law}
        with dask.config.set(scheduler="synchronous"):
            contacts = int(roughxr.superpose(catalogue, delta=deltas, subregions=(8, 8), **options).contacts.sum())
            whole = spent(lambda o=options: roughxr.superpose(catalogue, delta=deltas, subregions=(8, 8), **o))
            exact = None
            if law in ("energy", "maugis"):
                exact = spent(lambda o=options: pull_off_map(catalogue, subregions=(8, 8), **o))
        print(words(law, parts(catalogue, deltas, options), estimates(law, contacts, catalogue, ghz), whole, exact))


def parts(catalogue, deltas, options):
    """Return the processor time of what a sweep consists of, s."""
    named = {"law": "jkr", "formulation": "energy"} | options
    options = options_of(catalogue, named["law"], named["formulation"], "highest_peak")
    positions = roughxr.scans.regions.centres(catalogue, (8, 8))
    places = list(zip(positions.subregion_x.values, positions.subregion_y.values))
    field, patch, _ = catalogue_field(catalogue, options)

    def offsets():
        return [kernel.offsets(field, x, y, options.radius, options.profile) for x, y in places]

    above, branch = offsets(), options.kernel_law().spline
    return {
        "scales and neighbours": spent(lambda: catalogue_field(catalogue, options)),
        "offsets": spent(offsets),
        "contacts": spent(lambda: [kernel.superpose(deltas, field, each, patch, branch) for each in above]),
    }


def estimates(law, contacts, catalogue, ghz):
    """Return what the same should cost, s."""
    kind = {"hertz": "contact, hertz", "published": "contact, closed", "self_similar": "contact, closed"}
    count = catalogue.sizes["asperity"]
    cycles = {
        "scales and neighbours": count * (CYCLES["scales"] + CYCLES["neighbour"]),
        "offsets": 64 * count * CYCLES["offset"],
        "contacts": contacts * CYCLES[kind.get(law, "contact")],
    }
    return {part: n / ghz * 1e-9 for part, n in cycles.items()}


def words(law, parts, estimates, whole, exact):
    """Return one line of the table: each part beside its estimate, and the rest, which is labels and dask."""
    each = ", ".join(f"{part} {1e3 * parts[part]:.0f} ({1e3 * estimates[part]:.0f})" for part in parts)
    total, rest = sum(estimates.values()), whole - sum(parts.values())
    line = f"{law:18} {1e3 * whole:.0f}, {whole / total:.1f} times {1e3 * total:.0f}: {each}"
    return f"{line}, labels and dask {1e3 * rest:.0f}" + (
        "" if exact is None else f"; exact pull-off {1e3 * exact:.0f}"
    )


if __name__ == "__main__":
    glass = roughxr.assign_pair(roughxr.open_sample("glass"), **PAIR)
    sweep(glass)
    every_pixel(glass, sys.argv[1] if len(sys.argv) > 1 else None)
