"""Soft rough bodies at preload 0: law="auto" beside the exponential law at ranges that a mesh can solve.

    python tests/benchmarks/soft_bodies.py [--only 0 4 9] [--seeds 21 22 23]

Each row is one place of a surface of 64 × 64 pixels of 20 nm without wavelengths below 80 nm; with ``--seeds`` nine
places of each of these surfaces, 21 … 30 for the ten that nothing was tuned on. The exponential law is solved on one
mesh at the shortest range that its cells bear, and at 1.5 times that range. A straight line through both leads to the
pair's range of 0.3 nm. The uncertainty of this reference is the way from the shorter range, and 2 % for the cells. If
both ranges lead to different contacts, the cells are halved, up to 16 to a pixel; then the shorter range counts alone.
Printed are the pull-off of "auto" with its stated error, or its range, the reference with its uncertainty, and whether
both together cover the difference; the first row's processor time includes compiling. At the end the coverage, that
without ranges and the median error of these.
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
from roughxr.mechanics.contact.adhesive_options import usual_step
from roughxr.mechanics.contact.pressing import is_range
from roughxr.mechanics.specimen import specimen_of

PIXEL = 20.0
RANGE = 0.3

#: Pull-offs that differ by more than this part belong to different contacts.
OTHER_CONTACT = 0.3

#: Most cells to a pixel of a reference.
FINEST = 16


class Row(NamedTuple):
    """One surface, its pair, and the cells to a pixel of the reference."""

    modulus: float  # GPa
    radius: float  # nm
    rms: float = 12.0  # nm
    work: float = 0.1  # J/m²
    seed: int = 1
    hurst: float = 0.8
    rolloff: float = 640.0  # nm; that of a band-limited surface is little longer than its shortest wavelength
    place: tuple[float, float] = (640.0, 640.0)  # nm, the contact centre
    refine: int = 4


ROWS = (
    Row(0.3, 2000, place=(840.0, 840.0), refine=8),  # first contact is one low summit
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


def nine_places(seed):
    """Return rows of nine places of a surface by its seed."""
    centres = PIXEL * 64 / 6 * np.array([1.0, 3.0, 5.0])
    return [Row(0.3, 2000, seed=seed, place=(x, y)) for x in centres for y in centres]


def subregion(row):
    """Return the place of a row as subregions."""
    x, y = row.place
    return [x], [y]


def exponential_pull_off(row, length):
    """Return the pull-off (nN) of the exponential law of a range (nm) on the mesh of a row."""
    ds = surface(row)
    mesh = roughxr.Mesh(row.refine, None, 2 * usual_step(specimen_of(ds)))
    ranged = ds.assign_coords(adhesion_range=length)
    return float(ranged.contact.adhesive(law="exponential", mesh=mesh, subregions=subregion(row)).pull_off_force[0])


def reference(row):
    """Return ranges (nm), the pull-offs (nN) of the exponential law there, and the reference with its uncertainty."""
    ranges = np.sqrt(row.work * PIXEL / row.refine / row.modulus) * np.array([1.0, 1.5])
    pulls = np.array([exponential_pull_off(row, length) for length in ranges])
    if abs(pulls[1] / pulls[0] - 1) > OTHER_CONTACT:
        if row.refine < FINEST:
            return reference(row._replace(refine=2 * row.refine))
        return ranges, pulls, pulls[0], 0.02 * pulls[0]
    extrapolated = pulls[0] + (pulls[1] - pulls[0]) * (RANGE - ranges[0]) / (ranges[1] - ranges[0])
    return ranges, pulls, extrapolated, abs(extrapolated - pulls[0]) + 0.02 * pulls[0]


def main():
    """Print a line for each row."""
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", type=int, nargs="+", default=range(len(ROWS)), help="rows; default: all")
    parser.add_argument("--seeds", type=int, nargs="+", help="nine places of each of these surfaces, in place of rows")
    parser.add_argument("--mesh", type=int, help="cells to a pixel; default: auto")
    options = parser.parse_args()
    rows = [ROWS[k] for k in options.only]
    if options.seeds:
        rows = [row for seed in options.seeds for row in nine_places(seed)]
    covered = []
    has_range = []
    errors = []
    for row in rows:
        began = time.process_time()
        pull_off = surface(row).contact.adhesive(subregions=subregion(row), mesh=options.mesh or "auto")
        pull = float(pull_off.pull_off_force[0])
        stated = float(pull_off.pull_off_error[0])
        pressed = float(pull_off.pressed_pull_off_force[0])
        spent = time.process_time() - began
        has_range.append(bool(is_range(pull, pressed)))
        ends = [pull, pressed] if has_range[-1] else [pull]
        low = min(ends) * (1 - stated)
        high = max(ends) * (1 + stated)
        ranges, pulls, extrapolated, uncertain = reference(row)
        covered.append(low - uncertain <= extrapolated <= high + uncertain)
        errors.append(stated)
        interval = " … ".join(f"{end:.1f}" for end in sorted(ends))
        print(
            f"seed {row.seed}, {row.place[0]:.0f}, {row.place[1]:.0f} nm: E* {row.modulus:g} GPa, R {row.radius:g} nm, "
            f"{pull_off.attrs['law']}, {spent:.0f} s: {interval} nN ± {stated:.1%}; "
            f"exponential {np.round(pulls, 1)} nN at {np.round(ranges, 2)} nm, "
            f"extrapolated {extrapolated:.1f} ± {uncertain:.1f} nN; ratio {pull / extrapolated:.2f}, "
            f"{'covered' if covered[-1] else 'NOT covered'} ({time.process_time() - began:.0f} s)",
            flush=True,
        )
    single = ~np.array(has_range)
    without = np.array(covered)[single]
    print(
        f"covered: {sum(covered)} of {len(covered)}, without ranges {without.sum()} of {without.size} "
        f"with a median error of {np.median(np.array(errors)[single]):.1%}"
    )


if __name__ == "__main__":
    main()
