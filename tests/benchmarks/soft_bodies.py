"""Soft rough bodies at preload 0: law="auto" beside the exponential law at ranges that a mesh can solve.

    python tests/benchmarks/soft_bodies.py [--only 0 4 9]

Each row is one place of a surface of 64 × 64 pixels of 20 nm without wavelengths below 80 nm. The exponential law is
solved on one mesh at 1.5 and at 2 times the shortest range that its cells bear. A straight line through both leads to
the pair's range of 0.3 nm. The uncertainty of this reference is the way from the shorter range, and 2 % for the cells.
Printed are the pull-off of "auto" with its stated error, the reference with its uncertainty, the ratio, and whether
both errors together cover the difference.
"""

import argparse
import sys
import time
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr
from roughxr.contact.adhesive_options import usual_step
from roughxr.specimen import specimen_of

PIXEL, RANGE = 20.0, 0.3


class Row(NamedTuple):
    """One surface, its pair, and the cells to a pixel of the reference."""

    modulus: float  # GPa
    radius: float  # nm
    rms: float = 12.0  # nm
    work: float = 0.1  # J/m²
    seed: int = 1
    hurst: float = 0.8
    rolloff: float = 640.0  # nm; that of a band-limited surface is little longer than its shortest wavelength
    place: float = 640.0  # nm, x and y of the contact centre
    refine: int = 4


ROWS = (
    Row(0.3, 2000, place=840, refine=8),  # first contact is one low summit
    Row(0.002, 500, seed=2),
    Row(0.005, 500, seed=3, work=0.05),
    Row(0.02, 1000, seed=4, rolloff=160),
    Row(0.05, 1000, seed=5),
    Row(0.1, 1000, seed=6, rolloff=160),
    Row(0.2, 1000, seed=7, hurst=0.5, refine=8),
    Row(0.3, 1000, seed=8, rolloff=160, refine=8),
    Row(0.6, 1000, rms=4, seed=9, refine=8),
    Row(1.0, 2000, rms=2, seed=10, refine=8),
)


def surface(row):
    """Return the scan of a row with its pair."""
    options = {"rms": row.rms, "hurst": row.hurst, "rolloff": row.rolloff, "cutoff": 80, "seed": row.seed}
    scan = roughxr.scans.synthetic.self_affine((64, 64), PIXEL, **options)
    pair = {"sphere_radius": row.radius, "contact_modulus": row.modulus, "work_of_adhesion": row.work}
    return scan.contact.assign_pair(**pair, adhesion_range=RANGE)


def reference(row):
    """Return ranges (nm), the pull-offs (nN) of the exponential law there, and the reference with its uncertainty."""
    ranges = np.sqrt(row.work * PIXEL / row.refine / row.modulus) * np.array([1.5, 2.0])
    place = [row.place], [row.place]
    mesh = roughxr.Mesh(row.refine, None, 2 * usual_step(specimen_of(surface(row))))
    pulls = []
    for length in ranges:
        ds = surface(row).assign_coords(adhesion_range=length)
        pulls.append(float(ds.contact.adhesive(law="exponential", mesh=mesh, subregions=place).pull_off_force[0]))
    value = pulls[0] + (pulls[1] - pulls[0]) * (RANGE - ranges[0]) / (ranges[1] - ranges[0])
    return ranges, np.array(pulls), value, abs(value - pulls[0]) + 0.02 * pulls[0]


def main():
    """Print a line for each row."""
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", type=int, nargs="+", default=range(len(ROWS)), help="rows; default: all")
    parser.add_argument("--mesh", type=int, help="cells to a pixel; default: auto")
    given = parser.parse_args()
    covered = []
    for k in given.only:
        row, began = ROWS[k], time.process_time()
        ds, place = surface(row), ([row.place], [row.place])
        found = ds.contact.adhesive(subregions=place, mesh=given.mesh or "auto")
        pull, stated = float(found.pull_off_force[0]), float(found.pull_off_error[0])
        settling, spent = float(found.settling_error[0]), time.process_time() - began
        ranges, pulls, value, uncertain = reference(row)
        covered.append(abs(pull - value) <= stated * pull + uncertain)
        print(
            f"{k}: E* {row.modulus:g} GPa, R {row.radius:g} nm, {found.attrs['law']}, {spent:.0f} s: "
            f"{pull:.1f} nN ± {stated:.1%} (settling {settling:.1%}); exponential {np.round(pulls, 1)} nN at "
            f"{np.round(ranges, 2)} nm, extrapolated {value:.1f} ± {uncertain:.1f} nN; ratio {pull / value:.2f}, "
            f"{'covered' if covered[-1] else 'NOT covered'} ({time.process_time() - began:.0f} s)",
            flush=True,
        )
    print(f"covered: {sum(covered)} of {len(covered)}")


if __name__ == "__main__":
    main()
