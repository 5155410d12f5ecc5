"""How runs scale: ``python tests/benchmarks/scaling.py``.

1. Speed-up of two dask threads over one, on the direct job of 64 places x 18 displacements, medians of alternating
   runs; beside it the processor time, which tells on a busy machine whether the threads hinder each other.
2. Overhead of a checkpointed run over a bare loop of kernels, for tasks of about 0.1 s.
3. Time per subregion and peak memory from 64 to 4096 subregions, each in a process of its own.
4. What 10^6 subregions cost on 100 machines, from these figures.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import dask
import numpy as np

import roughxr
from roughxr import parallel
from roughxr.parallel import run_batch
from roughxr.runs import checkpointed

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.675}
DELTAS = [1, 2, 3, 4, 5.08, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15.4, 17, 18.5, 20]
REPEATS = 5


def glass():
    """Return the glass twin with the paper's pair."""
    return roughxr.assign_pair(roughxr.open_sample("glass"), **PAIR)


def a_run(scan, deltas, places, path, scheduler="threads", fields=False):
    """Return the seconds of one run with checkpoints, from nothing to the archive."""
    options = {"delta": deltas, "subregions": places, "fields": fields}
    began = time.perf_counter()
    checkpointed(
        lambda: {"solutions/direct": roughxr.direct(scan, **options)},
        path,
        scan=scan,
        arguments=options,
        scheduler=scheduler,
    )
    return time.perf_counter() - began


def speed_up(scan, folder):
    """Compare one thread with two, by turns."""
    times, processor = {1: [], 2: []}, {1: [], 2: []}
    for k in range(REPEATS):
        for workers in times:
            with dask.config.set(num_workers=workers):
                began = time.process_time()
                times[workers].append(a_run(scan, DELTAS, (8, 8), folder / f"{workers}-{k}.nc"))
                processor[workers].append(time.process_time() - began)
    one, two = (statistics.median(times[workers]) for workers in (1, 2))
    print(f"direct, 64 x {len(DELTAS)}: {one:.2f} s on one thread, {two:.2f} s on two: {one / two:.2f} times")
    one, two = (statistics.median(processor[workers]) for workers in (1, 2))
    print(f"    processor time {one:.2f} s and {two:.2f} s: at most {2 * one / two:.2f} times on free processors")


class Bare:
    """Computes the work of a solve in a plain loop of its tasks."""

    def array(self, work):
        """Return the results, one after the other."""
        began = time.perf_counter()
        results = [run_batch(work.task, [items], *work.shared) for items in work.arguments]
        self.seconds = time.perf_counter() - began
        return np.concatenate(results)

    def finish(self, ds):
        """Return the result as it is."""
        return ds


def overhead(scan, folder):
    """Compare a run on one thread with a bare loop, for tasks of about 0.1 s."""
    deltas, places, bare = np.arange(1.0, 30.0, 0.15), (7, 7), Bare()
    with parallel.kept_by(bare):
        roughxr.direct(scan, delta=deltas, subregions=places)
    ratios = []
    for k in range(3):
        with parallel.kept_by(bare):
            roughxr.direct(scan, delta=deltas, subregions=places)
        with dask.config.set(num_workers=1):
            ratios.append(a_run(scan, deltas, places, folder / f"overhead-{k}.nc") / bare.seconds)
    each = bare.seconds / 49
    print(f"run over bare loop, tasks of {each:.3f} s: {100 * (statistics.median(ratios) - 1):.1f} % more")


def growth(places, fields):
    """Print seconds and peak memory of a run in this process."""
    scan = glass()
    roughxr.direct(scan, delta=[5.0], subregions=(2, 2))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    with tempfile.TemporaryDirectory() as folder:
        seconds = a_run(scan, [5.08, 10.0], (places, places), Path(folder) / "run.nc", fields=fields)
        size = (Path(folder) / "run.nc").stat().st_size / 2**20
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{places**2:5d} subregions{', fields' if fields else ''}: {seconds:.2f} s, "
        f"{seconds / places**2 * 1e3:.2f} ms each, "
        f"peak {peak:.0f} MB ({peak - before:.0f} over its imports), archive {size:.0f} MB",
        flush=True,
    )


def estimate(seconds_each, machines=100, cores=32, subregions=1e6, dispatch=1e-3, kept=1e-3):
    """Print what many subregions cost on many machines."""
    computed = subregions * seconds_each / (machines * cores)
    gathered = subregions / 61.0 * (dispatch + kept)
    print(
        f"10^6 subregions of {seconds_each * 1e3:.0f} ms on {machines} machines of {cores} cores: {computed:.0f} s of "
        f"computing beside {gathered:.0f} s of dispatch and checkpoints in the main process (batches of 61), "
        f"which go on at the same time: {max(computed, gathered):.0f} s"
    )


if __name__ == "__main__":
    if len(sys.argv) > 1:
        growth(int(sys.argv[1]), len(sys.argv) > 2)
        sys.exit()
    with tempfile.TemporaryDirectory() as temporary:
        speed_up(glass(), Path(temporary))
        overhead(glass(), Path(temporary))
    for arguments in (["8"], ["16"], ["32"], ["64"], ["8", "fields"], ["32", "fields"]):
        subprocess.run([sys.executable, __file__, *arguments], check=True)
    estimate(0.1)
