"""What a hardness costs the direct simulation, over the elastic one, and how exact it is.

    python tests/benchmarks/yielding.py [--repeat 5] [--windows 16]

Processor time, both sides alternating in one process on one thread; medians of the ratios. 1. A sweep of loading on
rough windows, elastic and yielding, and the same by loads. 2. The same job through the labelled function, where the
yielding side draws back as well. 3. A paraboloid that yields, against the figures of axisymmetric rings. 4. Pull-offs
of a flat punch by law and mesh over those in closed form. 5. The same of an asperity that was pressed flat.
"""

import argparse
import os
import statistics
import sys
import time
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"
sys.path.insert(0, str(Path(__file__).parents[2]))

import dask
import numpy as np

import roughxr
from roughxr.mechanics.kernels.adhesion import traction_laws as smooth_laws
from roughxr.mechanics.kernels.adhesion.path import follow_path
from roughxr.mechanics.kernels.halfspace.load_control import loaded_arrays
from roughxr.mechanics.kernels.halfspace.yielding import residual_heights
from roughxr.mechanics.scans.synthetic import self_affine
from tests import half_space as kalker
from tests.closed_forms import flattened_pull_off, punch_pull_off

DX = 9.77
RADIUS = 3000.0
MODULUS = 39.4
DELTAS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.5, 15.0, 17.5, 20.0)
LOADS = np.geomspace(100.0, 1e5, 12)

#: GPa: the first hardly matters on these windows, the last leaves most of the contact yielding.
HARDNESSES = 20.0, 6.0, 2.0, 0.5

#: Displacement over that of first yield -> force over that of first yield.
RINGS = {1: 1.0, 2: 2.7204, 5: 9.0327}


def windows(count):
    """Return separations of 64 × 64 cells cut from one scan."""
    options = {"rms": 3.5, "hurst": 0.8, "rolloff": 128 * DX, "cutoff": 4 * DX, "seed": 2026}
    z = self_affine((512, 512), DX, **options).height.values
    tiles = [z[64 * i : 64 * i + 64, 64 * j : 64 * j + 64] for i in range(8) for j in range(8)][:count]
    x = (np.arange(64) - 31.5) * DX
    return [tile.max() - tile + (x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS) for tile in tiles]


def ratio(other, baseline, repeat):
    """Return the median of the ratios of the times of two functions, called in turn."""
    ratios = []
    for _ in range(repeat + 1):
        times = []
        for function in (baseline, other):
            begun = time.process_time()
            function()
            times.append(time.process_time() - begun)
        ratios.append(times[1] / times[0])
    return statistics.median(ratios[1:])  # the first compiles


def sweeps(solve, steps, separations, hardness):
    """Return a function that solves all windows, and says how many solves failed."""

    def run():
        options = {"hardness": kalker.Hardness(hardness)}
        solved = [solve(window, steps, DX, MODULUS, **options) for window in separations]
        return sum(int((arrays[-3][:, kalker.STATUS] != kalker.CONVERGED).sum()) for arrays in solved)

    return run


def kernel_rows(separations, repeat):
    """Print cost and convergence by displacements and by loads."""
    for name, solve, steps in (("delta", kalker.sweep_arrays, DELTAS), ("load", loaded_arrays, LOADS)):
        elastic = sweeps(solve, steps, separations, np.inf)
        for hardness in HARDNESSES:
            if name == "load" and LOADS[-1] > 0.7 * hardness * 64**2 * DX**2:
                continue  # more than the windows bear
            hard = sweeps(solve, steps, separations, hardness)
            print(f"by {name:5s} H = {hardness:4g} GPa   {ratio(hard, elastic, repeat):.2f} x   failed {hard()}")


def labelled_rows(repeat):
    """Print the cost of a whole cycle over the elastic sweep, from scan to Dataset."""
    scan = roughxr.open_sample("glass")
    pair = {"sphere_radius": RADIUS, "contact_modulus": MODULUS}
    elastic = roughxr.assign_pair(scan, **pair)
    for hardness in HARDNESSES:
        hard = roughxr.assign_pair(scan, **pair, hardness=hardness)
        runs = [lambda ds=ds: ds.contact.direct(delta=DELTAS, subregions=(4, 4)) for ds in (hard, elastic)]
        with dask.config.set(scheduler="synchronous"):
            print(f"loading and retraction, H = {hardness:4g} GPa   {ratio(*runs, repeat):.2f} x the elastic sweep")


def accuracy_rows():
    """Print the errors of a paraboloid's force."""
    radius = 1000.0
    hardness = 6.0
    depth = radius * (np.pi * hardness / (2 * MODULUS)) ** 2
    load = np.pi**3 * radius**2 * hardness**3 / (6 * MODULUS**2)
    areas = {1: 1.0, 2: 2.07, 5: 6.08}
    for times, expected in RINGS.items():
        for cells in (12, 25, 50):
            dx = np.sqrt(areas[times] * radius * depth) / cells
            half = int(np.sqrt(2 * radius * times * depth) / dx) + 2
            x = np.arange(-half, half + 1) * dx
            separation = (x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius)
            contact = kalker.solve(separation, times * depth, dx, MODULUS, hardness=kalker.Hardness(hardness))
            error = contact.force / (expected * load) - 1
            print(f"delta / delta_Y = {times}, {cells:2d} cells in radius: force off by {error:+.1e}")


def punch_rows():
    """Print pull-offs of a flat punch of 10 nm over Griffith's, and Dugdale's over their closed form."""
    flat = {"radius": 10.0, "contact_modulus": MODULUS, "work_of_adhesion": 0.1}
    griffith = punch_pull_off(**flat)
    for cells in (5, 10, 20):
        x = np.arange(-cells - 3, cells + 4)
        disc = np.hypot(x[:, None], x) <= cells
        separation = np.where(disc, 0.0, np.inf)
        dx = 10.0 / np.sqrt(disc.sum() / np.pi)
        w = 0.1 * dx / MODULUS
        row = []
        for label, law, exact in (
            ("no range", smooth_laws.without_range(w, 0.25), griffith),
            (
                "1 GPa",
                smooth_laws.dugdale(w, 0.1, 0.25),
                punch_pull_off(adhesion_range=0.1, **flat),
            ),
        ):
            (path,) = follow_path(separation, np.array([0.2]), 0.02, law)
            row.append(f"{label} {-path.states['force'].min() * MODULUS * dx / exact:.3f} of the closed form")
        for length in (0.3, 0.1):
            law = smooth_laws.smooth_law(exponential=(w, length))
            (path,) = follow_path(separation, np.array([0.2]), 0.02, law)
            pull = -path.states["force"].min() * MODULUS * dx
            row.append(f"exponential over {length} nm {pull / griffith:.3f} of Griffith's")
        print(f"flat punch, {cells:2d} cells in radius: {', '.join(row)}")


def pressed_flat(cells, hardness, edge=10.0):
    """Return separation and displacement (nm) of a paraboloid that was pressed until all of its contact bore H."""
    radius = min(6 * edge, 0.05 * MODULUS * edge / hardness)
    dx = edge / cells
    delta = edge**2 / (2 * radius) + 4 * hardness * edge / (np.pi * MODULUS)
    half = int(np.sqrt(2 * radius * delta) / dx) + 4
    x = np.arange(-half, half + 1) * dx
    deltas = np.array([delta])
    separation = (x[:, None] ** 2 + x**2) / (2 * radius)
    limit = kalker.Hardness(hardness)
    records, *fields = kalker.sweep_arrays(separation, deltas, dx, MODULUS, hardness=limit, tolerance=1e-9, keep=1)
    residual = residual_heights(*fields, separation, deltas, hardness)[0]
    return separation - residual, delta, np.sqrt(records[0, kalker.AREA] / np.pi)


def flattened_rows(edge=10.0, work=0.1):
    """Print pull-offs without range of an asperity pressed flat, by hardness, over closed forms."""
    flat = {"contact_modulus": MODULUS, "work_of_adhesion": work}
    unit = np.sqrt(work * MODULUS / edge)
    for hard in (0.03, 0.1, 0.3, 1.0, 3.0, 10.0):
        punch = punch_pull_off(radius=edge, **flat)
        closed = flattened_pull_off(radius=edge, hardness=hard * unit, **flat)
        row = [f"closed form {closed / punch:.3f} of a flat punch's"]
        for cells in (10, 20):
            separation, delta, radius = pressed_flat(cells, hard * unit, edge)
            w = work * edge / cells / MODULUS
            law = smooth_laws.without_range(w, 0.25)
            (path,) = follow_path(separation, np.array([delta]), 0.02, law)
            pull = -path.states["force"].min() * MODULUS * edge / cells
            exact = flattened_pull_off(radius=radius, hardness=hard * unit, **flat)
            row.append(f"{cells} cells in radius {pull / exact:.3f} of the closed form")
        print(f"pressed flat, H = {hard:4g} sqrt(w E*/a): {', '.join(row)}")


def main():
    """Run all rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--windows", type=int, default=16)
    options = parser.parse_args()
    kernel_rows(windows(options.windows), options.repeat)
    labelled_rows(options.repeat)
    accuracy_rows()
    punch_rows()
    flattened_rows()


if __name__ == "__main__":
    main()
