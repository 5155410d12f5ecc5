"""The effect of unseen roughness, calibrated by pull-offs of one probe, for another pair or radius.

    python tests/benchmarks/calibrated_factor.py [--cache FILE] [--surfaces NAME …]

Surfaces and images (every 4th pixel) are those of ``real_below_the_pixel.py``. Truth and image are solved at 2 × 2
places for six pairs and two radii. The ratio truth / image of each is the measured factor that predicts the truth of
all others, beside the factor of one scan. The places of all are the same, so that their choice adds no error. The
transfer is the root mean square of the difference of ln(truth / image) between two pairs or radii on one surface, and
on all other surfaces.
"""

import argparse
import itertools
import warnings
from pathlib import Path

import numpy as np
from real_below_the_pixel import Solved, picture, surfaces, true_surface

import roughxr
from roughxr.mechanics.studies import extrapolation

CHOSEN = ("usual", "jagged", "grains", "di-1")
PIXELS = 4
GRID = (2, 2)
RADII = (150.0, 300.0)  # nm
PAIRS = {
    "glass": {"materials": "glass"},
    "polystyrene": {"materials": "polystyrene"},
    "glass and silicon": {"materials": "glass/silicon"},
    "strong and yielding": {"contact_modulus": 39.4, "work_of_adhesion": 0.2, "hardness": 6.0},
    "stiff": {"contact_modulus": 100.0, "work_of_adhesion": 0.1},
    "soft": {"contact_modulus": 1.0, "work_of_adhesion": 0.05},
}


def solved_pair(how, pair, radius):
    """Return ln(truth / image) of mean pull-offs."""
    surface, _ = true_surface(how)
    image = picture(surface, PIXELS)
    places = roughxr.scans.regions.centres(image, GRID)
    assigned = [scan.contact.assign_pair(sphere_radius=radius, **pair) for scan in (surface, image)]
    truth, shown = (roughxr.adhesive(scan, subregions=places) for scan in assigned)
    means = [float(solved.pull_off_force.mean()) for solved in (truth, shown)]
    return float(np.log(means[0] / means[1]))


def main():
    warnings.simplefilter("ignore")
    table = surfaces()
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--surfaces", nargs="+", choices=table, default=list(CHOSEN))
    parser.add_argument("--cache", type=Path, help="a file of solved surfaces")
    options = parser.parse_args()
    solved = Solved(options.cache)
    results = {"image": [], "one scan": [], "measured": []}
    differences = {}
    print("surface       ln(truth / image): mean; transfer on this surface")
    for name in options.surfaces:
        surface, end = true_surface(table[name])
        pixel = PIXELS * float(surface.x[1] - surface.x[0])
        cases = [
            solved.get(f"{name}/{pair}/{radius}", solved_pair, table[name], PAIRS[pair], radius)
            for pair, radius in itertools.product(PAIRS, RADII)
        ]
        differences[name] = []
        estimate = extrapolation.one_scan_factor(extrapolation.unseen_octaves(2 * pixel, end))
        for measured, log in itertools.permutations(cases, 2):
            differences[name].append(measured - log)
            results["image"].append((-log, np.nan))
            results["one scan"].append((estimate.log - log, estimate.error.std))
            results["measured"].append((measured - log, extrapolation._TRANSFER_ERROR))
        print(f"{name:12s} {np.mean(cases):6.2f} {rms(differences[name]):6.2f}", flush=True)
    for name in options.surfaces:
        others = [differences[other] for other in options.surfaces if other != name]
        print(f"transfer on all but {name}: {rms(np.concatenate(others or [[np.nan]])):.2f}")
    for way, rows in results.items():
        off, error = np.transpose(rows)
        inside = np.mean(np.abs(off) < 1.96 * error)
        print(f"{way:10s} rms of ln {rms(off):.2f}, inside 95 %: {inside:.0%} of {len(rows)}")


def rms(values):
    """Return the root mean square."""
    return np.sqrt(np.mean(np.square(values)))


if __name__ == "__main__":
    main()
