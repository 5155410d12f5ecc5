"""Does the error that the adhesive simulation states of its pull-off cover the true one?

Places of the glass twin, and of a stiff and a soft rough surface on which nothing was tuned, are solved with
``mesh="auto"`` and ``accuracy``; true is what a mesh of eight cells to a pixel says in half the steps.
Printed are the share of places whose stated error covers the difference and how large both are. Half an hour.

    python tests/benchmarks/stated_error.py [--places 24] [--accuracy 0.05] [--only soft]
"""

import argparse
import warnings

import numpy as np

import roughxr
from roughxr.scans import regions


def surfaces():
    """Yield names and scans with their pairs."""
    pair = {"sphere_radius": 3000, "adhesion_range": 0.3}
    glass = roughxr.open_sample("glass")
    yield "glass twin", glass.contact.assign_pair(**pair, contact_modulus=39.4, work_of_adhesion=1.35)
    made = roughxr.scans.synthetic.self_affine((256, 256), 10.0, rms=3, hurst=0.8, rolloff=500, cutoff=50, seed=11)
    yield "self-affine", made.contact.assign_pair(**pair, contact_modulus=39.4, work_of_adhesion=0.5)
    made = roughxr.scans.synthetic.self_affine((128, 128), 20.0, rms=12, hurst=0.8, rolloff=1000, cutoff=80, seed=12)
    soft = {"sphere_radius": 2000, "contact_modulus": 0.3, "work_of_adhesion": 0.1, "adhesion_range": 0.3}
    yield "soft", made.contact.assign_pair(**soft)


def covered(scan, places, accuracy):
    """Return the stated and the true errors of the places whose cycles are complete."""
    some = regions.sample(regions.centres(scan, (8, 8)), places)
    told = scan.contact.adhesive(subregions=some, mesh=roughxr.Mesh(accuracy=accuracy))
    true = scan.contact.adhesive(subregions=some, mesh=roughxr.Mesh(8, step=0.125)).pull_off_force
    error = abs(told.pull_off_force / true - 1).values
    known = np.isfinite(error) & np.isfinite(told.pull_off_error.values)
    return told.pull_off_error.values[known], error[known], told.refinement.values


def main():
    """Print one row per surface."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--places", type=int, default=24)
    parser.add_argument("--accuracy", type=float, default=0.05)
    parser.add_argument("--only", help="one surface, by its name; default: all")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    for name, scan in surfaces():
        if options.only not in (None, name):
            continue
        stated, true, refinement = covered(scan, options.places, options.accuracy)
        meshes = ", ".join(f"{int(np.sum(refinement == n))} at {n}" for n in np.unique(refinement))
        print(
            f"{name}: {stated.size} places ({meshes} cells to a pixel), stated error covers the true one in "
            f"{np.mean(true <= stated):.0%}, the larger of it and {options.accuracy:g} in "
            f"{np.mean(true <= np.maximum(stated, options.accuracy)):.0%}; stated median {np.median(stated):.3f}, "
            f"true median {np.median(true):.3f}, largest {true.max():.3f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
