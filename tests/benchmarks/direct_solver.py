"""The direct solver beside its fastest peer, every solution checked against a plain reference.

    python tests/benchmarks/direct_solver.py [--sizes 256,512,1024] [--repeat 5]

Each row alternates both sides in one process, one thread, and prints the median of the ratios. The peer is ASPHER
(`pip install aspher`; a source build that needs a C++ compiler, CMake and Eigen), driven with the loads found here,
which is generous: a user who has displacements must search for them. Without it, times of this side alone are printed.

1. The paper's job: 64 windows × 12 displacements. 2. Single cold solves of a rough window and a smooth sphere.
3. The same job by two threads over one. 4. The same job through the labelled accessor, over the bare kernels.
5. A prescribed load over its displacement.
"""

import argparse
import os
import platform
import sys
import time
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"
sys.path.insert(0, str(Path(__file__).parents[2]))

import dask
import numpy as np
import scipy.fft

import roughxr
from roughxr.mechanics.jobs import spread
from roughxr.mechanics.kernels.halfspace.love import love_coefficients
from roughxr.mechanics.scans.synthetic import self_affine
from tests import half_space as kalker
from tests.half_space import loaded

DX = 9.77
RADIUS = 3000.0
MODULUS = 39.4
DELTAS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.5, 15.0, 17.5, 20.0)


# ---------------------------------------------------------------- problems


def surface(n):
    """Return heights (nm) of a self-affine surface, Hurst 0.8, 3.5 nm rms, wavelengths above 4 pixels."""
    options = {"rms": 3.5, "hurst": 0.8, "rolloff": 128 * DX, "cutoff": 4 * DX, "seed": 2026}
    return self_affine((n, n), DX, **options).height.values


def sphere(n, dx, radius):
    """Return the height (nm) of a paraboloid over its lowest point on an n × n window."""
    x = (np.arange(n) - (n - 1) / 2) * dx
    return (x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius)


def paper_windows():
    """Return 64 separations of 64 × 64 cells cut from one scan."""
    z = surface(512)
    tiles = (z[64 * i : 64 * i + 64, 64 * j : 64 * j + 64] for i in range(8) for j in range(8))
    return [tile.max() - tile + sphere(64, DX, RADIUS) for tile in tiles]


def single_case(kind, n):
    """Return (separation, dx): a rough window whose sphere grows with it, or a sphere on ever finer cells."""
    if kind == "sphere":
        return sphere(n, 64 * DX / n, RADIUS), 64 * DX / n
    z = surface(max(512, n))[:n, :n]
    return z.max() - z + sphere(n, DX, RADIUS * (n / 64) ** 2), DX


# ---------------------------------------------------------------- reference: plain, slow, its own transforms


def reference_force(separation, delta, dx, start, tolerance=1e-9):
    """Return the force (nN) by projected conjugate gradients on the whole window, to max|gap| < tolerance δ."""
    shape = separation.shape
    padded = [scipy.fft.next_fast_len(2 * n, real=True) for n in shape]
    offsets = [np.minimum(np.arange(n), n - np.arange(n)) for n in padded]
    table = love_coefficients(padded[0] // 2 + 1, padded[1] // 2 + 1) * dx / MODULUS
    transfer = scipy.fft.rfft2(table[np.ix_(*offsets)])

    def product(p):
        return scipy.fft.irfft2(scipy.fft.rfft2(p, padded) * transfer, padded)[: shape[0], : shape[1]]

    p = start.copy()
    direction = np.zeros(shape)
    old = 0.0
    for _ in range(3000):
        gap = product(p) + separation - delta
        contact = p > 0
        outside = gap[~contact].min(initial=0.0)
        if np.abs(gap[contact]).max(initial=0.0) < tolerance * delta and outside > -tolerance * delta:
            break
        new = float((gap[contact] ** 2).sum())
        direction = np.where(contact, gap + (new / old if old else 0.0) * direction, 0.0)
        step = float((gap * direction)[contact].sum() / (product(direction) * direction)[contact].sum())
        p = np.maximum(p - step * direction, 0.0)
        joining = (p == 0) & (gap < 0) & ~contact
        p[joining] = -step * gap[joining]
        old = 0.0 if joining.any() else new
    return float(p.sum()) * dx * dx


# ---------------------------------------------------------------- the peer


def aspher_solver():
    """Return a function (separation, dx, load) that solves with ASPHER's two FFT solvers, or None."""
    try:
        import aspher
    except ImportError:
        return None

    def nested(separation, dx, load, tolerance=1e-7):
        n = separation.shape[0]
        nominal = load / (separation.size * dx * dx)
        options = {"domain_size": n * dx, "E_star": MODULUS, "coarsest": min(64, n // 2), "tol": tolerance}
        return aspher.solve_nested(grid_size=n, gap=separation.ravel(), p_nominal=nominal, backend="fft", **options)

    return nested


# ---------------------------------------------------------------- measuring


def seconds(call):
    """Return the wall time of one call."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def alternate(ours, theirs, repeat):
    """Return the median times of both and the median of their ratios, run in turn."""
    pairs = np.array([(seconds(ours), seconds(theirs)) for _ in range(repeat)])
    return *np.median(pairs, axis=0), float(np.median(pairs[:, 0] / pairs[:, 1]))


def show(name, ours, theirs=None, ratio=None, note=""):
    """Print one row."""
    beside = "" if theirs is None else f"  beside {theirs:8.4f} s  ratio {ratio:6.3f}"
    print(f"{name:44s} {ours:8.4f} s{beside}  {note}", flush=True)


def sweep_all(windows):
    """Solve the paper's job with the bare kernels."""
    return [kalker.sweep(s, DELTAS, DX, MODULUS) for s in windows]


def paper_job(nested, repeat):
    """Row 1: the paper's job against ASPHER, loads handed to it."""
    windows = paper_windows()
    solved = sweep_all(windows)
    cases = [(s, d, x) for s, row in zip(windows, solved) for d, x in zip(DELTAS, row) if x.force > 0]
    errors = [abs(x.force / reference_force(s, d, DX, x.pressure) - 1) for s, d, x in cases]
    note = f"{len(cases)} contacts, largest force error {max(errors):.1e}"
    assert max(errors) < 1e-6, note

    def theirs():
        for s, _, x in cases:
            nested(s, DX, x.force)

    if nested is None:
        return show("paper's job", np.median([seconds(lambda: sweep_all(windows)) for _ in range(repeat)]), note=note)
    return show("paper's job, over ASPHER nested", *alternate(lambda: sweep_all(windows), theirs, repeat), note)


def single_solves(nested, sizes, repeat):
    """Row 2: cold solves; row 5: the same by its load."""
    for kind in ("rough", "sphere"):
        for n in sizes:
            separation, dx = single_case(kind, n)

            def ours(separation=separation, dx=dx):
                return kalker.solve(separation, 15.0, dx, MODULUS)

            solution = ours()
            error = abs(solution.force / reference_force(separation, 15.0, dx, solution.pressure) - 1)
            note = f"{np.count_nonzero(solution.pressure)} cells touch, force error {error:.1e}"
            assert error < 1e-6, note
            if nested is None:
                show(f"{kind} {n}", np.median([seconds(ours) for _ in range(repeat)]), note=note)
            else:
                peer = (lambda s=separation, d=dx, f=solution.force: nested(s, d, f)) if nested else None
                show(f"{kind} {n}, over ASPHER nested", *alternate(ours, peer, repeat), note)

            def by_load(separation=separation, dx=dx, load=solution.force):
                return loaded(separation, [load], dx, MODULUS)

            show(f"{kind} {n}, by load over by displacement", *alternate(by_load, ours, repeat))


def forces_of(window):
    """Return the forces of a sweep, as a task."""
    return kalker.sweep_arrays(window, DELTAS, DX, MODULUS)[0][:, kalker.FORCE]


def parallel_and_labelled(repeat):
    """Rows 3 and 4: two threads over one; the accessor over the bare kernels."""
    windows = paper_windows()

    def on_threads(workers):
        with dask.config.set(scheduler="threads", num_workers=workers):
            return spread.task_results(forces_of, [(s,) for s in windows], (len(DELTAS),), lazy=False)

    show_speed_up("paper's job: 2 dask threads over 1", on_threads, repeat)
    scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=RADIUS, contact_modulus=MODULUS)

    def labelled(workers, places=8):
        with dask.config.set(scheduler="threads", num_workers=workers):
            return scan.contact.direct(delta=DELTAS, subregions=(places, places))

    forces = labelled(1).force.values
    assert np.array_equal(forces, labelled(2).force.values)
    for places in (8, 24):
        name = f"glass twin, labelled, {places}²: 2 threads over 1"
        show_speed_up(name, lambda workers, places=places: labelled(workers, places), repeat)
    bare = bare_kernels(scan)
    show("glass twin: labelled over bare kernels", *alternate(lambda: labelled(1), bare, repeat))


def show_speed_up(name, run, repeat):
    """Print the row of a job on two threads over one."""
    double, single, ratio = alternate(lambda: run(2), lambda: run(1), repeat)
    show(name, double, single, ratio, f"speed-up {1 / ratio:.2f}")


def bare_kernels(scan):
    """Return the same job as a loop over kernels on windows cut beforehand."""
    from roughxr.mechanics.kernels.halfspace.separation import sphere_separation
    from roughxr.mechanics.scans import regions

    z = scan.height.values
    dx = float(scan.x[1] - scan.x[0])
    axes = scan.x.values, scan.y.values
    windows, _ = regions.windows(axes, regions.centres(scan, (8, 8)), np.sqrt(2 * RADIUS * DELTAS[-1]))
    cut = []
    for w in windows:
        part = np.ascontiguousarray(z[w.rows, w.columns])
        x, y = (o + dx * (m + np.arange(n)) for o, m, n in zip(w.origin, w.missing, part.shape))
        cut.append((part, x, y))

    def run():
        for part, x, y in cut:
            kalker.sweep(sphere_separation(part, z.max(), x, y, RADIUS), DELTAS, dx, MODULUS)

    return run


def main():
    """Print every row."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--sizes", default="256,512,1024")
    options.add_argument("--repeat", type=int, default=5)
    chosen = options.parse_args()
    import numba

    print(f"roughxr {roughxr.__version__}, Python {platform.python_version()}, NumPy {np.__version__},", end=" ")
    print(f"Numba {numba.__version__}, {os.cpu_count()} cores, {platform.machine()}")
    start = time.perf_counter()
    kalker.solve(sphere(64, DX, RADIUS), 15.0, DX, MODULUS)
    print(f"first call, compilation or its cache included: {time.perf_counter() - start:.1f} s")
    nested = aspher_solver()
    if nested is None:
        print("ASPHER is not installed: times of this side alone", file=sys.stderr)
    paper_job(nested, chosen.repeat)
    parallel_and_labelled(chosen.repeat)
    single_solves(nested, [int(n) for n in chosen.sizes.split(",")], chosen.repeat)
    if platform.system() != "Windows":
        import resource

        print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB, references included")


if __name__ == "__main__":
    main()
