"""What is said of a surface from a coarse picture of it, against the surface itself.

    python tests/benchmarks/below_the_pixel.py [--cases 40] [--places 3] [--tuned]

Each case makes a self-affine surface with waves down to a few nm, the truth; draws it as a microscope would (a round
tip, larger pixels, sampled or averaged, noise of 0.05 nm), and asks `roughxr.continued` for the mean pull-off at some
places of the picture, with the waves ending where those of the truth end. The truth is solved at the same places as
fine as it is. Printed case by case: truth, answer with its 95 % interval, the picture as it is, and at the end the
share of cases inside, and the bias. With --tuned the cases used while building, else others.
"""

import argparse
import os
import time
import warnings

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import roughxr
from roughxr.scans.synthetic import self_affine

#: Pairs of bodies: E* (GPa), w (J/m²), hardness (GPa) if it is given.
PAIRS = {
    "glass": {"contact_modulus": 39.4, "work_of_adhesion": 0.1},
    "polymer": {"contact_modulus": 3.0, "work_of_adhesion": 0.08},
    "glass that yields": {"contact_modulus": 39.4, "work_of_adhesion": 0.2, "hardness": 6.0},
}
HURSTS, TIPS, PIXELS, SHORTEST = (0.5, 0.7, 0.9), (5.0, 10.0), (4.0, 8.0), 4.0
SIDE, CELL, RADIUS = 768.0, 1.0, 300.0


def case(k, tuned):
    """Return the settings of a case."""
    return {
        "seed": k + (0 if tuned else 100),
        "hurst": HURSTS[k % 3],
        "pair": list(PAIRS)[(k // 3) % 3],
        "tip": TIPS[(k // 2) % 2],
        "pixel": PIXELS[(k // 4) % 2],
        "averaged": bool((k // 5) % 2),
        "isotropic": k % 4 != 3,
    }


def surface(told):
    """Return the truth on fine cells; where it is not isotropic, its waves along x are half as long again."""
    n = int(SIDE / CELL)
    make = {"rms": 1.5, "hurst": told["hurst"], "rolloff": 150, "seed": told["seed"]}
    if told["isotropic"]:
        return self_affine((n, n), CELL, cutoff=SHORTEST, **make)
    long = self_affine((n * 2 // 3, n), CELL, cutoff=SHORTEST, **make)
    height = np.real(np.fft.ifft(_stretched(np.fft.fft(long.height.values, axis=0), n), axis=0)) * n / long.sizes["x"]
    out = self_affine((n, n), CELL, cutoff=SHORTEST, **make)
    return out.assign(height=(("x", "y"), height, out.height.attrs))


def _stretched(waves, n):
    """Return a spectrum along x for more points: the same waves over a longer side."""
    out = np.zeros((n, waves.shape[1]), complex)
    half = waves.shape[0] // 2
    out[:half], out[-half:] = waves[:half], waves[-half:]
    return out


def picture(truth, told):
    """Return the truth as a microscope draws it."""
    drawn = roughxr.scans.dilate(truth, tip_radius=told["tip"])
    n = int(told["pixel"] / CELL)
    if told["averaged"]:
        coarse = drawn.coarsen(x=n, y=n).mean()
    else:
        coarse = drawn.isel(x=slice(n // 2, None, n), y=slice(n // 2, None, n))
    noise = np.random.default_rng(told["seed"]).normal(0, 0.05, coarse.height.shape)
    return coarse.assign(height=coarse.height + noise)


def solved(told, grid):
    """Return the mean pull-off of the truth, of the picture, and what is said of the truth from the picture."""
    truth = surface(told)
    seen = picture(truth, told)
    pair = {"sphere_radius": RADIUS, **PAIRS[told["pair"]]}
    truth, seen = truth.contact.assign_pair(**pair), seen.contact.assign_pair(**pair)
    places = roughxr.scans.regions.centres(seen, (grid, grid))
    simulated = {"subregions": places, "seeds": 1, "method": "adhesive"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fine = truth.contact.scale_dependence(shortest=[SHORTEST], **simulated).pull_off_force  # all its waves, no more
        coarse = seen.contact.scale_dependence(shortest=[2 * told["pixel"]], **simulated).pull_off_force
        said = roughxr.continued(seen, subregions=places, seeds=2, shortest=SHORTEST)
    return float(fine.mean()), float(coarse.mean()), said


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--places", type=int, default=3, help="places along a side")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--tuned", action="store_true", help="the cases used while building, not those held out")
    given = parser.parse_args()
    rows = []
    print(
        "seed  H    pair               tip pixel  drawn     waves  |  truth    said (95 % interval)     picture  in  s"
    )
    for k in range(given.first, given.first + given.cases):
        told, began = case(k, given.tuned), time.process_time()
        fine, coarse, said = solved(told, given.places)
        low, mean, high = (float(said[f"pull_off_{name}"]) for name in ("lower", "mean", "upper"))
        rows.append((fine, mean, low <= fine <= high, coarse))
        drawn = "averaged" if told["averaged"] else "sampled "
        print(
            f"{told['seed']:4d}  {told['hurst']:.1f}  {told['pair']:18s} {told['tip']:3g} {told['pixel']:4g}   "
            f"{drawn}  {'alike' if told['isotropic'] else 'long '}  | {fine:7.2f}  "
            f"{mean:7.2f} ({low:6.2f} … {high:6.2f})  {coarse:8.2f}  {'yes' if rows[-1][2] else 'NO '} "
            f"{time.process_time() - began:4.0f}",
            flush=True,
        )
    truth, said, inside, coarse = np.array(rows, float).T
    print(f"inside the stated interval: {int(inside.sum())} of {inside.size}")
    print(
        f"said over truth: {np.exp(np.mean(np.log(said / truth))):.2f} in the geometric mean, "
        f"{np.mean(said / truth):.2f} in the mean; the picture's: {np.exp(np.mean(np.log(coarse / truth))):.2f}"
    )


if __name__ == "__main__":
    main()
