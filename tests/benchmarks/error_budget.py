"""What the error budget of a run costs, and whether its entries are those of every change at many places.

    python tests/benchmarks/error_budget.py [--places 16]

The glass twin under the paper's pair, on the mesh and with the steps of `run`, at 8 × 8 places, four of which `run` has
also solved on cells and with steps half as long. Printed are the processor time of the budget's changes, that of every
change at all of so many places, and for each entry what both say, each with its own standard error, the
difference over both errors, and the places. Ten minutes of one core.
"""

import argparse
import time
import warnings

import dask
import numpy as np

import roughxr
from roughxr.reproduction.printed import PAIR
from roughxr.scans import regions
from roughxr.studies import uncertainty_budget
from roughxr.studies.assumptions import SIMULATED
from roughxr.studies.uncertainty_budget import changes_of

#: The mesh that `run` finds fine enough with its steps, and the one that it is compared to.
MESH, FINER = roughxr.Mesh(4, None, 0.4), roughxr.Mesh(8, None, 0.2)


def timed(work):
    """Return the result of a function, and the processor time that it took, s."""
    begun = time.process_time()
    return work(), time.process_time() - begun


def largest(changes, factor):
    """Return the largest change among a factor's settings, its standard error, and the places that it rests on."""
    cases = changes.isel(case=np.flatnonzero(changes.factor.values == factor))
    one = cases.isel(case=int(np.nanargmax(np.abs(cases.pull_off_change.values))))
    return float(one.pull_off_change), float(one.standard_error), int(one.places)


def main():
    """Print one row per factor, and the times."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--places", type=int, default=16)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    dask.config.set(scheduler="synchronous")
    scan = roughxr.assign_pair(roughxr.open_sample("glass"), **PAIR)
    every = regions.centres(scan, (8, 8))
    roughxr.adhesive(scan, subregions=every.isel(subregion=[0]), mesh=MESH, law="exponential")  # compiles
    solved, whole = timed(lambda: roughxr.adhesive(scan, subregions=every, mesh=MESH, law="exponential"))
    finer = roughxr.adhesive(scan, subregions=regions.sample(every, 4), mesh=FINER, law="exponential")
    how = {"most": 16, "preload": 0.0, "mesh": MESH, "finer": finer}
    found, budget = timed(lambda: changes_of(scan, solved, **how))
    many = regions.sample(every, options.places)
    alone = roughxr.adhesive(scan, subregions=many, mesh=MESH, law="exponential")
    uncertainty_budget._TOTAL_TOLERANCE = 0.0  # solves every change at all places
    truth, each = timed(lambda: changes_of(scan, alone, most=options.places, preload=0.0, mesh=MESH))
    print(f"64 places {whole:.1f} s; the budget's changes {budget:.1f} s, all at {options.places} places {each:.1f} s")
    print(f"{'':>20} {'budget [%]':>16} {'places':>6} {'all [%]':>16} {'places':>6} {'apart':>6}")
    for factor in SIMULATED:
        (value, own, few), (true, error, count) = (largest(changes, factor) for changes in (found, truth))
        apart = (value - true) / max(np.hypot(own, error), 1e-12)
        told = (f"{100 * one:+.2f} ± {100 * off:.2f}" for one, off in ((value, own), (true, error)))
        print(f"{factor:>20} {next(told):>16} {few:>6} {next(told):>16} {count:>6} {apart:>6.1f}")


if __name__ == "__main__":
    main()
