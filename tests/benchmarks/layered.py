"""The cost of a layer: `direct` and `adhesive` on glass with 50 nm of oxide, beside those without it.

Both are solved in turn, in one process, on the twin of the paper's scan; printed are times and their ratio.
"""

import argparse
import time
import warnings

import numpy as np

import roughxr
from roughxr import Layer

SPHERE = {"sphere_radius": 3000, "materials": "glass/silicon"}


def seconds(solve, ds):
    """Return the time of one solve, the tables of coefficients included where they are not stored yet."""
    start = time.perf_counter()
    solve(ds)
    return time.perf_counter() - start


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--places", type=int, default=8, help="places along a side")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", choices=("direct", "adhesive"))
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    scan = roughxr.open_sample("glass")
    at = {"subregions": (arguments.places, arguments.places)}
    bodies = {
        "glass": scan.contact.assign_pair(sphere_radius=3000, materials="glass"),
        "50 nm of oxide on silicon": scan.contact.assign_pair(**SPHERE, layer=Layer("50 nm", "silica")),
    }
    solves = {
        "direct": lambda ds: ds.contact.direct(delta=[5.08, 10.0, 15.4], **at).load(),
        "adhesive": lambda ds: ds.contact.adhesive(law="jkr", mesh=1, **at).load(),
    }
    for name, solve in solves.items():
        if arguments.only not in (None, name):
            continue
        first = [seconds(solve, ds) for ds in bodies.values()]  # compiles; tables are computed
        times = np.array([[seconds(solve, ds) for ds in bodies.values()] for _ in range(arguments.rounds)])
        best = times.min(axis=0)
        print(f"{name} at {arguments.places**2} places, least of {arguments.rounds} alternating rounds:")
        for k, label in enumerate(bodies):
            print(f"  {label:28s} {best[k]:7.2f} s   (median {np.median(times[:, k]):.2f} s, first {first[k]:.2f} s)")
        ratios = times[:, 1] / times[:, 0]
        print(f"  ratio {best[1] / best[0]:.3f} of the least, {np.median(ratios):.3f} median of rounds", flush=True)


if __name__ == "__main__":
    main()
