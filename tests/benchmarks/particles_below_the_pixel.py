"""Best estimates for free particles by a second scan, against particles at rest on the surfaces themselves.

    python tests/benchmarks/particles_below_the_pixel.py [--cache FILE] [--surfaces NAME …]

Surfaces, images and pair are those of ``real_below_the_pixel.py``; self-affine surfaces are shown by every 4th pixel,
measured ones by every 8th. The truth is the mean pull-off at the resting positions of the surface itself, reached from
4 × 4 landings. The estimate is that of the image at its resting positions, times the ratio of a second scan: a corner
of up to 240 pixels with a tip of 5 nm. Means are over up to 12 resting positions, and over 3 × 3 places of the second
scan; the stated error contains their scatter. The last column is the pull-off of particles at rest over that of a probe
at 3 × 3 places of the truth. The simplest rival is a constant times the image, set on the other surfaces.
"""

import argparse
import warnings
from pathlib import Path

import numpy as np
from real_below_the_pixel import (
    CORNER_TIP,
    GRID,
    SELF_AFFINE,
    Solved,
    picture,
    surfaces,
    true_surface,
)

import roughxr
from roughxr.mechanics.scans import regions
from roughxr.mechanics.statistics.sampling import shares
from roughxr.mechanics.studies import extrapolation
from roughxr.mechanics.studies.finer_scan import second_scan

#: Surfaces that are scored, and pixels of the truth in one of the image.
CHOSEN = (*list(SELF_AFFINE)[:3], "grains", "rough", "di-1", "di-2", "di-4", "veeco", "film")
PIXELS = {"self-affine": 4, "AFM": 8, "optical": 8}

LAW = "exponential"

#: Grid of landings, and the largest number of resting positions that are solved.
LANDINGS, MOST_RESTS = (4, 4), 12


def corner(surface):
    """Return a finer scan of a corner of the surface."""
    side = min(240, min(surface.height.shape) // 2 + 40)
    return picture(surface.isel(x=slice(side), y=slice(side)), 1, tip=CORNER_TIP, seed=5)


def mean_at_rest(scan):
    """Return the mean pull-off (nN) of particles at rest on a surface, and its relative error."""
    rests = roughxr.particles.resting(scan, landings=LANDINGS)
    inner = rests.isel(subregion=np.flatnonzero(~rests["truncated"].values))
    if inner.sizes["subregion"] < 2:
        raise ValueError("no two resting positions away from its edges")
    pull_off = roughxr.adhesive(scan, subregions=regions.sample(inner, MOST_RESTS), law=LAW).pull_off_force
    adhering = pull_off.dropna("subregion")
    share = shares(adhering) / shares(adhering).sum()
    mean = float((share * adhering).sum())
    variance = float((share**2 * (adhering - mean) ** 2).sum())
    return mean, float(np.sqrt(variance / (1 - float((share**2).sum())))) / mean


def solved_surface(how):
    """Return means at rest with errors, of truth and image; ln(factor) of the second scan with its error; a probe."""
    pair = {"sphere_radius": how["radius"], "materials": "glass"}
    surface, end = true_surface(how)
    truth = surface.contact.assign_pair(**pair)
    image = picture(surface, PIXELS[how["kind"]]).contact.assign_pair(**pair)
    at_rest = [force for scan in (truth, image) for force in mean_at_rest(scan)]
    second = second_scan(image, corner(surface))
    log, noise = extrapolation.second_scan_ratio(second, LAW)
    shown = 2 * max(roughxr.schema.pixel(image))
    factor = extrapolation.second_scan_factor(log, shown, second.shown_wavelength, end)
    probe = float(roughxr.adhesive(truth, subregions=GRID, law=LAW).pull_off_force.mean())
    return [*at_rest, factor.log, float(np.hypot(factor.error.std, noise)), probe]


def main():
    warnings.simplefilter("ignore")
    table = surfaces()
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--surfaces", nargs="+", choices=table, default=list(CHOSEN))
    parser.add_argument("--cache", type=Path, help="a file of solved surfaces")
    arguments = parser.parse_args()
    solved = Solved(arguments.cache)
    rows = []
    print("surface       truth nN  ln(image / truth)  ln(estimate / truth)  stated error  rest / probe")
    for name in arguments.surfaces:
        try:
            values = solved.get(name, solved_surface, table[name])
        except ValueError as reason:
            print(f"{name:12s} refused: {reason}", flush=True)
            continue
        truth, truth_error, image, image_error, log, factor_error, probe = values
        off = np.log(image / truth)
        error = np.hypot.reduce([truth_error, image_error, factor_error])
        rows.append((off, off + log, error, truth / probe))
        print(
            f"{name:12s} {truth:9.3g}  {off:17.2f}  {off + log:20.2f}  {error:12.2f}  {truth / probe:12.2f}", flush=True
        )
    image, estimate, error, ratio = np.transpose(rows)
    constant = image - (image.sum() - image) / (image.size - 1)
    rms = [np.sqrt(np.mean(off**2)) for off in (image, constant, estimate)]
    inside = np.mean(np.abs(estimate) < 1.96 * error)
    print("rms of ln: image {:.2f}, constant {:.2f}, estimate {:.2f}".format(*rms))
    print(f"bias of the estimate: {np.exp(estimate.mean()):.2f}")
    print(f"inside the 95 % interval: {inside:.0%} of {len(rows)}; at rest over probe: median {np.median(ratio):.1f}")


if __name__ == "__main__":
    main()
