"""Adhesion with a range on the twin of the glass: what a place costs on finer meshes, beside the engine cell by cell.

    python tests/benchmarks/adhesive_engine.py [place …]

Exponential law, range 0.3 nm, pressed by 4 nm from first contact, whole cycles. Prints the pull-off and the processor
time on each mesh with the exponent of the time in cells; then, in one alternating series on the same law and mesh, the
ratio of both engines' times and of their pull-offs (the engine cell by cell only where its mesh is coarse enough to
wait for).
"""

import sys
import time

import dask
import numpy as np

import roughxr
from roughxr.contact import cycle, problem
from roughxr.kernels.adhesion import cohesive_laws, path

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.675}
MESHES, RANGE, DEPTH, STEP = (1, 2, 4, 8), 0.3, 4.0, 0.25


def timed(function, *arguments, **options):
    """Return what a function returns, and the processor time it took."""
    began = time.process_time()
    return function(*arguments, **options), time.process_time() - began


def smooth(scan, place, refine):
    """Return the pull-off force (nN) of one place by Newton's method."""
    options = {"delta": [DEPTH], "datum": "first_contact", "step": STEP, "law": "exponential", "refine": refine}
    return float(scan.contact.adhesive(subregions=place, **options).pull_off_force[0])


def by_cells(scan, place, refine):
    """Return the same by the engine that balances cell by cell."""
    asked = problem.read_problem(scan, place, delta=[DEPTH], datum="first_contact", profile="sphere", refine=refine)
    (where,), _ = problem.places(scan, place, 500.0)
    surface = problem.surface_at(where, asked)
    per_unit, work = asked.dx / asked.contact_modulus, float(scan.work_of_adhesion)
    law = cohesive_laws.finite_range("exponential", work * per_unit, work / RANGE * per_unit)
    limits = {"tolerance": 1e-7, "max_iterations": 1000, "max_cells": 8000}
    deltas = cycle.deltas_of(surface, asked, cycle.Adhesion(work, "", 0, np.zeros(0), 1, 0, 0, 0, 0, 0))
    found = path.follow(surface.separation, deltas, STEP, law, work * per_unit, **limits)
    return -found.states[:, path.FORCE].min() * asked.contact_modulus * asked.dx


def main(places):
    """Print what the places cost."""
    scan = roughxr.open_sample("glass").contact.assign_pair(**PAIR)
    centres = roughxr.regions.centres(scan, (8, 8))
    with dask.config.set(scheduler="synchronous"):
        smooth(scan, centres.isel(subregion=[places[0]]), 1)  # compiles
        by_cells(scan, centres.isel(subregion=[places[0]]), 1)
        for place in places:
            here = centres.isel(subregion=[place])
            took = []
            for refine in MESHES:
                pull, seconds = timed(smooth, scan, here, refine)
                took.append(seconds)
                print(f"place {place}, refine {refine}: {pull:7.1f} nN, {seconds:6.2f} s")
            exponent = np.polyfit(2 * np.log(MESHES), np.log(took), 1)[0]
            print(f"place {place}: time grows with cells to the power of {exponent:.2f}")
            for refine in MESHES[:2]:
                pairs = [[timed(engine, scan, here, refine) for engine in (by_cells, smooth)] for _ in range(3)]
                pulls, times = np.median(pairs, axis=0).T
                print(
                    f"place {place}, refine {refine}: cell by cell over Newton {times[0] / times[1]:.1f}, "
                    f"pull-off {pulls[0] / pulls[1]:.4f}"
                )


if __name__ == "__main__":
    main([int(value) for value in sys.argv[1:]] or [20, 53])
