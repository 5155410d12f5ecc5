"""What adhesion costs: cycles of approach and retraction at 64 places on the twin of the glass.

    python tests/benchmarks/adhesive_cost.py

Prints the cost of 64 places, pressed by 4 nm from first contact: with glass's range on a quarter of the pixel, and
without range on half and on a quarter of it.
"""

import time
import warnings

import roughxr
from roughxr.mechanics.contact.adhesion import adhesive

PAIR = {"sphere_radius": 3000, "young_modulus": 75, "poisson_ratio": 0.22, "surface_energy": 0.6747}

#: Law and refinement of the cycles that press by 4 nm.
PRESSED = (("exponential", 4), ("jkr", 2), ("jkr", 4))


def pressed():
    """Print a line per law and refinement: wall and processor time, mean pull-off and its standard deviation."""
    warnings.simplefilter("ignore", UserWarning)
    scan = roughxr.open_sample("glass").contact.assign_pair(**PAIR, adhesion_range=0.3)
    options = {"delta": [4.0], "datum": "first_contact"}
    for law in ("exponential", "jkr"):
        adhesive(scan, subregions=(1, 1), law=law, mesh=1, **options)  # compile
    for law, refine in PRESSED:
        wall = time.perf_counter()
        processor = time.process_time()
        cycle = adhesive(scan, subregions=(8, 8), law=law, mesh=refine, **options)
        wall = time.perf_counter() - wall
        processor = time.process_time() - processor
        pull = cycle.pull_off_force
        ends = int(cycle.complete.sum())
        print(
            f"{law}, refine {refine}: {wall:.0f} s, {processor:.0f} s of processor time, "
            f"pull-off {float(pull.mean()):.0f} ± {float(pull.std()):.0f} nN, complete {ends}/64",
            flush=True,
        )


if __name__ == "__main__":
    pressed()
