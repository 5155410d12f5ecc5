"""What adhesion costs: cycles of approach and retraction at 64 places on the twin of the glass.

``python tests/benchmarks/adhesive_cost.py pressed`` prints what 64 places cost, pressed by 4 nm from first contact:
with glass's range on a quarter of the pixel, and without one on half and on a quarter of it.
``adhesive_cost.py [refine …]`` prints the time of deeper cycles without range, and where it goes; and how much the
pull-off of single places hangs on the step.
"""

import cProfile
import pstats
import sys
import time
import warnings
from functools import partial

import dask
import numpy as np

import roughxr
from roughxr.contact.adhesion import adhesive

#: The limit without range on the pixels as they are.
by_cells = partial(adhesive, law="griffith", mesh=1)

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.6747}


def main(refines):
    """Print a line per refinement: seconds, and mean pull-off with its standard deviation."""
    warnings.simplefilter("ignore", UserWarning)
    scan = roughxr.open_sample("glass").contact.assign_pair(**PAIR)
    delta = np.arange(-2, 17.01, 0.25)
    by_cells(scan, delta=delta[:3], mesh=roughxr.Mesh(1, step=0.25))  # compile
    for refine in refines:
        start = time.perf_counter()
        cycle = by_cells(scan, delta=delta, subregions=(8, 8), mesh=refine)
        seconds = time.perf_counter() - start
        pull = cycle.pull_off_force
        print(
            f"refine={refine}: {seconds:6.1f} s, pull-off {float(pull.mean()):.0f} ± {float(pull.std()):.0f} nN, "
            f"converged {bool(cycle.converged.all())}, complete {int(cycle.complete.sum())}/64"
        )
    halvings(scan)
    profile = cProfile.Profile()
    with dask.config.set(scheduler="synchronous"):
        profile.runcall(adhesive, scan, delta=delta, subregions=(8, 8), mesh=roughxr.Mesh(1, step=0.25))
    pstats.Stats(profile).sort_stats("tottime").print_stats(6)


#: Law and refinement of the cycles that press by 4 nm.
PRESSED = (("exponential", 4), ("griffith", 2), ("griffith", 4))


def pressed():
    """Print a line per law and refinement: wall and processor time, mean pull-off and its standard deviation."""
    warnings.simplefilter("ignore", UserWarning)
    scan = roughxr.open_sample("glass").contact.assign_pair(**PAIR, adhesion_range=0.3)
    options = {"delta": [4.0], "datum": "first_contact"}
    for law in ("exponential", "griffith"):
        adhesive(scan, subregions=(1, 1), law=law, mesh=1, **options)  # compile
    for law, refine in PRESSED:
        wall, processor = time.perf_counter(), time.process_time()
        cycle = adhesive(scan, subregions=(8, 8), law=law, mesh=refine, **options)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        pull, ends = cycle.pull_off_force, int(cycle.complete.sum())
        print(
            f"{law}, refine {refine}: {wall:.0f} s, {processor:.0f} s of processor time, "
            f"pull-off {float(pull.mean()):.0f} ± {float(pull.std()):.0f} nN, complete {ends}/64",
            flush=True,
        )


def halvings(scan, steps=(0.5, 0.25, 0.125, 0.0625, 0.01)):
    """Print how little the pull-off of single places changes from step to step: peaks and jumps are closed in upon."""
    before = None
    for step in steps:
        began = time.process_time()
        cycle = by_cells(scan, delta=[4.0], subregions=(8, 8), datum="first_contact", mesh=roughxr.Mesh(1, step=step))
        seconds, force = time.process_time() - began, cycle.pull_off_force.values
        line = f"step {step:5g} nm: {seconds:4.1f} s of processor time, mean {force.mean():.1f} nN"
        if before is not None:
            change = np.abs(force / before - 1)
            line += f"; from the one before, {(change > 0.01).sum()} of 64 by more than 1 %, at most {change.max():.1%}"
        print(line)
        before = force


if __name__ == "__main__":
    if sys.argv[1:] == ["pressed"]:
        pressed()
    else:
        main([int(value) for value in sys.argv[1:]] or [1, 2])
