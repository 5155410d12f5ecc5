"""What the pull between rigid bodies costs at every pixel, and what it needs of memory.

    python tests/benchmarks/rigid_map.py [--large]

Prints processor time and peak memory of the glass twin (512 × 512 pixels, 3 µm sphere): the pull-off alone, forces at 60
heights, Lennard-Jones's law; and the ratio to sums place by place. With ``--large`` 2048 × 2048 pixels too. Each case runs
in a process of its own, after a small one that compiles.
"""

import argparse
import resource
import subprocess
import sys
import time

CASES = {
    "pull-off": {},
    "60 heights": {"delta": [-10 + 22 * k / 59 for k in range(60)]},
    "lennard_jones": {"law": "lennard_jones"},
    "2048 x 2048": {"repeat": 4},
}
_PLACES = 16


def run(name):
    """Run one case here and print its line."""
    import warnings

    import numpy as np

    import roughxr

    warnings.simplefilter("ignore", UserWarning)
    options = dict(CASES[name])
    scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    repeat = options.pop("repeat", 1)
    small = scan.isel(x=slice(24), y=slice(24))
    small.contact.rigid(subregions="every pixel", **options)
    if repeat > 1:
        pair = {name: scan[name] for name in roughxr.schema.TRAVELLING if name in scan.coords}
        height = np.tile(scan.height.values, (repeat, repeat))
        axis = (np.arange(height.shape[0]) + 0.5) * float(scan.x[1] - scan.x[0])
        axes = {a: (a, axis, {"units": "nm"}) for a in "xy"}
        scan = type(scan)({"height": (("x", "y"), height, {"units": "nm"})}, {**axes, **pair})
    begun = time.process_time()
    scan.contact.rigid(subregions="every pixel", **options)
    every = time.process_time() - begun
    each_options = {"delta": [0.0], **options, "subregions": (_PLACES, 1)}
    scan.contact.rigid(**each_options)
    begun = time.process_time()
    scan.contact.rigid(**each_options)
    each = (time.process_time() - begun) / _PLACES
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    ratio = each * scan.height.size / every
    print(
        f"{name:14s} {every:7.1f} s of processor time, {peak:5.2f} GB at most, place by place {ratio:6.0f} times as long"
    )


def main():
    """Run each case in its own process, or the one that is named."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--case")
    options = parser.parse_args()
    if options.case:
        run(options.case)
        return
    for name in CASES:
        if options.large or "repeat" not in CASES[name]:
            subprocess.run([sys.executable, __file__, "--case", name], check=True)


if __name__ == "__main__":
    main()
