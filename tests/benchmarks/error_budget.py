"""The processor time of a run's error budget, and its entries beside those of the same changes at more places.

    python tests/benchmarks/error_budget.py [--places 16]

The glass twin under the paper's pair, on the mesh and with the steps of `run`, at 8 × 8 places, four of which `run` has
also solved on cells and with steps half as long. Printed are the processor time of the budget, that of a budget at more
places, and each entry of both with its standard error, and their difference over both errors. Ten minutes of one core.
"""

import argparse
import time
import warnings

import dask
import numpy as np

import roughxr
from roughxr.application.reproduction.printed import PAIR
from roughxr.mechanics.scans import regions
from roughxr.mechanics.studies.uncertainty_budget import budget_of

#: The mesh that `run` finds fine enough with its steps, and the one that it is compared to.
MESH = roughxr.Mesh(4, None, 0.4)
FINER = roughxr.Mesh(8, None, 0.2)


def timed(work):
    """Return the result of a function, and the processor time that it took, s."""
    begun = time.process_time()
    return work(), time.process_time() - begun


def main():
    """Print one row per factor, and the times."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--places", type=int, default=16)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    dask.config.set(scheduler="synchronous")
    scan = roughxr.assign_pair(roughxr.open_sample("glass"), **PAIR)
    places = regions.centres(scan, (8, 8))
    roughxr.adhesive(scan, subregions=places.isel(subregion=[0]), mesh=MESH, law="exponential")  # compiles
    solved, whole = timed(lambda: roughxr.adhesive(scan, subregions=places, mesh=MESH, law="exponential"))
    finer = roughxr.adhesive(scan, subregions=regions.sample(places, 4), mesh=FINER, law="exponential")
    how = {"preload": 0.0, "mesh": MESH}
    budget, took = timed(lambda: budget_of(scan, solved, places=8, finer=finer, **how))
    more, longer = timed(lambda: budget_of(scan, solved, places=options.places, **how))
    print(f"64 places {whole:.1f} s; the budget {took:.1f} s, at {options.places} places {longer:.1f} s")
    print(f"{'':>20} {'budget [%]':>16} {'more places [%]':>16} {'apart':>6}")
    for entry in budget.entry.values[1:]:
        pair = [ds.sel(entry=entry) for ds in (budget, more)]
        values, errors = ([float(ds[name]) for ds in pair] for name in ("pull_off_change", "standard_error"))
        apart = (values[0] - values[1]) / max(np.hypot(*errors), 1e-12)
        columns = [f"{100 * change:+.2f} ± {100 * error:.2f}" for change, error in zip(values, errors)]
        print(f"{entry:>20} {columns[0]:>16} {columns[1]:>16} {apart:>6.1f}")


if __name__ == "__main__":
    main()
