"""How runs scale: ``python tests/benchmarks/scaling.py``.

1. Speed-up of two dask threads over one, on a direct job of 48 x 48 subregions x 18 displacements, without and with
   checkpoints, medians of alternating runs; beside it the processor time, which tells on a busy machine whether the
   threads hinder each other.
2. Overhead of a checkpointed run over a bare loop of kernels, for tasks of about 0.1 s.
3. Speed-up of two dask.distributed workers over one, on 48 x 48 subregions.
4. Wall and processor time, and peak memory, from 64 to 4096 subregions, each in a process of its own; a line
   through the processor times says whether the cost is linear.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import dask
import numpy as np

import roughxr
from roughxr import checkpointed
from roughxr.jobs import spread

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.675}
DELTAS = [1, 2, 3, 4, 5.08, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15.4, 17, 18.5, 20]
PLACES = (48, 48)
REPEATS = 5

#: Displacements that make a place cost 5 ms or more.
HEAVY = np.arange(1.0, 25.0, 0.5)


def glass():
    """Return the glass twin with the paper's pair."""
    return roughxr.assign_pair(roughxr.open_sample("glass"), **PAIR)


def a_run(scan, deltas, subregions, path, scheduler="threads", fields=False):
    """Return the seconds of one run with checkpoints, from nothing to the archive."""
    options = {"delta": deltas, "subregions": subregions, "fields": fields}
    began = time.perf_counter()
    checkpointed(
        lambda: {"solutions/direct": roughxr.direct(scan, **options)},
        path,
        scan=scan,
        arguments=options,
        scheduler=scheduler,
    )
    return time.perf_counter() - began


def direct_job(scan, path):
    """Return the seconds of the direct job without checkpoints."""
    began = time.perf_counter()
    roughxr.direct(scan, delta=DELTAS, subregions=PLACES)
    return time.perf_counter() - began


def kept_job(scan, path):
    """Return the seconds of the direct job as a run."""
    return a_run(scan, DELTAS, PLACES, path)


def speed_up(job, scan, folder):
    """Compare one thread with two, by turns."""
    times, processor = {1: [], 2: []}, {1: [], 2: []}
    for k in range(REPEATS):
        for workers in times:
            with dask.config.set(num_workers=workers):
                began = time.process_time()
                times[workers].append(job(scan, folder / f"{job.__name__}-{workers}-{k}.nc"))
                processor[workers].append(time.process_time() - began)
    name = f"{job.__name__}, {PLACES[0]} x {PLACES[1]} x {len(DELTAS)}"
    one, two = (statistics.median(times[workers]) for workers in (1, 2))
    print(f"{name}: {one:.2f} s on one thread, {two:.2f} s on two: {one / two:.2f} times")
    one, two = (statistics.median(processor[workers]) for workers in (1, 2))
    print(f"    processor time {one:.2f} s and {two:.2f} s: at most {2 * one / two:.2f} times on free processors")


class Bare:
    """Computes the work of a solve in a plain loop of its tasks."""

    def array(self, work):
        """Return the results, one after the other."""
        began = time.perf_counter()
        results = [spread._batch_results(work.task, [items], work.dtype, *work.shared) for items in work.arguments]
        self.seconds = time.perf_counter() - began
        return np.concatenate(results)

    def finish(self, ds):
        """Return the result as it is."""
        return ds


def overhead(scan, folder):
    """Compare a run on one thread with a bare loop, for tasks of about 0.1 s."""
    deltas, subregions, bare = np.arange(1.0, 30.0, 0.05), (7, 7), Bare()
    with spread.computed_by(bare):
        roughxr.direct(scan, delta=deltas, subregions=subregions)
    ratios = []
    for k in range(3):
        with spread.computed_by(bare):
            roughxr.direct(scan, delta=deltas, subregions=subregions)
        with dask.config.set(num_workers=1):
            ratios.append(a_run(scan, deltas, subregions, folder / f"overhead-{k}.nc") / bare.seconds)
    each = bare.seconds / 49
    print(f"run over bare loop, tasks of {each:.3f} s: {100 * (statistics.median(ratios) - 1):.1f} % more")


def peak_memory():
    """Return the most memory that this process held, MiB: what getrusage tells begins with its parent's on Linux."""
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def growth(subregions, fields):
    """Print seconds and peak memory of a run in this process."""
    scan = glass()
    roughxr.direct(scan, delta=[5.0], subregions=(2, 2))
    before, began = peak_memory(), time.process_time()
    deltas = HEAVY[-2:] if fields else HEAVY
    with tempfile.TemporaryDirectory() as folder:
        seconds = a_run(scan, deltas, (subregions, subregions), Path(folder) / "run.nc", fields=fields)
        size = (Path(folder) / "run.nc").stat().st_size / 2**20
    peak = peak_memory()
    processor = time.process_time() - began
    print(
        f"{subregions**2:5d} subregions{', fields' if fields else ''}: {seconds:.2f} s, processor {processor:.2f} s, "
        f"{processor / subregions**2 * 1e3:.2f} ms each, "
        f"peak {peak:.0f} MB ({peak - before:.0f} over its imports), archive {size:.0f} MB",
        flush=True,
    )


def told(arguments):
    """Return the processor seconds that ``growth`` prints in a process of its own."""
    done = subprocess.run([sys.executable, __file__, *arguments], check=True, stdout=subprocess.PIPE, text=True)
    print(done.stdout, end="", flush=True)
    return float(done.stdout.split("processor ")[1].split(" s")[0])


def linearity(sides=(8, 16, 32, 64)):
    """Fit a fixed cost and a cost per place, relative errors weighted alike, and compare largest and smallest."""
    seconds = np.array([told([str(side)]) for side in sides])
    count = np.array(sides, float) ** 2
    each, fixed = np.polyfit(count, seconds, 1, w=1 / seconds)
    per_place = (seconds - fixed) / count
    ratio = per_place[-1] / per_place[0]
    exponent = np.polyfit(np.log(count[1:]), np.log(seconds[1:] - fixed), 1)[0]
    verdict = "linear" if abs(exponent - 1) < 0.1 else "not linear"
    print(
        f"{fixed:.2f} s and {each * 1e3:.2f} ms a place; over the fixed cost a place of {sides[-1] ** 2} costs "
        f"{ratio:.2f} times one of {sides[0] ** 2}; exponent {exponent:.2f}: {verdict}"
    )


def two_workers(scan, folder):
    """Compare one worker of a local cluster with two, by turns."""
    from distributed import Client, LocalCluster

    times = {1: [], 2: []}
    for k in range(3):
        for workers in times:
            with (
                LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster,
                Client(cluster, set_as_default=False),
            ):
                address = cluster.scheduler_address
                a_run(scan, [5.0], (4, 4), folder / f"warm-{workers}-{k}.nc", address)
                times[workers].append(a_run(scan, HEAVY, (48, 48), folder / f"far-{workers}-{k}.nc", address))
    one, two = (statistics.median(times[workers]) for workers in (1, 2))
    print(f"direct, 48 x 48 x {HEAVY.size}: {one:.2f} s on one distributed worker, {two:.2f} s on two: {one / two:.2f}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        growth(int(sys.argv[1]), len(sys.argv) > 2)
        sys.exit()
    with tempfile.TemporaryDirectory() as temporary:
        speed_up(direct_job, glass(), Path(temporary))
        speed_up(kept_job, glass(), Path(temporary))
        overhead(glass(), Path(temporary))
        two_workers(glass(), Path(temporary))
        linearity()
        for side in ("8", "32", "64"):
            told([side, "fields"])
