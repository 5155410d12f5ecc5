"""Does the error that is stated of a lever cover the true one?

    python tests/benchmarks/levers.py [--places 8] [--only "soft 54"]
    python tests/benchmarks/levers.py --cost
    python tests/benchmarks/levers.py --pixels

The levers of single bumps, of the glass twin and of rough surfaces, stiff, soft and humid, on the mesh of a pull-off
with two cells to a pixel; true are those on cells four times smaller than the last, at most 16 to a pixel. Only the
glass twin and the surfaces 54 and 55 set constants; places with 16 cells to a pixel are left out. Printed are the share
of places at which the stated error covers the largest difference in any direction, and the share of all directions in
which it does. Half an hour. ``--cost``: the processor time of the levers over that of the pull-off of the same places,
in one process and in alternation, of the glass twin and of the rough sample. ``--pixels``: the same shares at 24
places of stiff surfaces on every second pixel, where true are the levers on all pixels, with cells half as large: of
surfaces whose roughness the second pixels show, and of such whose finest third of an octave or more they do not.
"""

import argparse
import time
import warnings
from functools import partial

import numpy as np
import xarray as xr

import roughxr
from roughxr.mechanics.contact.adhesion import adhesive_and_moments
from roughxr.mechanics.contact.mesh import MOST_REFINED
from roughxr.mechanics.scans import regions

#: Seed, rms height (nm), cutoff (nm), E* (GPa), work of adhesion (J/m²), radius (nm), Hurst exponent, law.
ROUGH = {
    "stiff 51": (51, 2.0, 60, 40.0, 0.06, 500, 0.8, "auto"),
    "stiff 52": (52, 4.0, 60, 40.0, 0.3, 2000, 0.5, "auto"),
    "medium 53": (53, 5.0, 80, 3.0, 0.1, 1000, 0.8, "auto"),
    "soft 54": (54, 8.0, 80, 0.5, 0.1, 1500, 0.8, "jkr"),
    "soft 55": (55, 6.0, 80, 0.3, 0.05, 1000, 0.6, "jkr"),
    "medium 56": (56, 5.0, 80, 3.0, 0.1, 1000, 0.8, "auto"),
    "soft 58": (58, 8.0, 80, 0.5, 0.1, 1500, 0.8, "jkr"),
    "soft 61": (61, 6.0, 90, 1.0, 0.1, 2000, 0.9, "jkr"),
}


#: The same of surfaces whose every second pixel is taken, but for the cutoff; pixel (nm), and cutoffs (nm) that every
#: second pixel shows, and does not.
HALVED = {
    "stiff 51": (51, 2.0, 40.0, 0.06, 500, 0.8),
    "stiff 52": (52, 4.0, 40.0, 0.3, 2000, 0.5),
    "medium 53": (53, 5.0, 3.0, 0.1, 1000, 0.8),
    "medium 57": (57, 3.0, 10.0, 0.1, 1000, 0.7),
}
HALVED_PIXEL = 8.0
CUTOFFS = (34, 24)


def scan_of(height, pixel):
    """Return heights as a scan whose middle is at zero."""
    axes = {name: (np.arange(n) - (n - 1) / 2) * pixel for name, n in zip("xy", height.shape)}
    scan = xr.Dataset({"height": (("x", "y"), height)}, axes)
    for name in ("height", "x", "y"):
        scan[name].attrs["units"] = "nm"
    return scan


def bump(pixel, place, radius=100.0):
    """Return one summit on pixels (nm), its middle at a part of a pixel, under a plane."""
    half = int(60 / pixel) + 8
    x, y = (pixel * (np.arange(-half, half + 1) - part) for part in place)
    height = np.maximum(-(x[:, None] ** 2 + y**2) / (2 * radius), -20.0)
    pair = {"sphere_radius": 1e6, "contact_modulus": 40.0, "work_of_adhesion": 0.06}
    return scan_of(height, pixel).contact.assign_pair(**pair)


def cases(count):
    """Yield names, scans with their pairs, places and laws."""
    random = np.random.default_rng(7)
    for pixel in (2.0, 4.0, 8.0, 15.0):
        for place in random.uniform(-0.5, 0.5, (max(count // 2, 1), 2)):
            yield f"bump on {pixel:g} nm", bump(pixel, place), ([0.0], [0.0]), "auto"
    glass = roughxr.open_sample("glass")
    for name, pair in {"glass twin": {}, "glass twin, 60 % humidity": {"humidity": 0.6}}.items():
        scan = glass.contact.assign_pair(sphere_radius=1000, materials="glass", **pair)
        yield name, scan, regions.sample(regions.centres(scan, (8, 8)), count), "auto"
    for name, (seed, rms, cutoff, modulus, work, radius, hurst, law) in ROUGH.items():
        options = {"rms": rms, "hurst": hurst, "rolloff": 800, "cutoff": cutoff, "seed": seed}
        made = roughxr.scans.synthetic.self_affine((128, 128), 20.0, **options)
        pair = {"sphere_radius": radius, "contact_modulus": modulus, "work_of_adhesion": work}
        scan = made.contact.assign_pair(**pair)
        yield name, scan, regions.sample(regions.centres(scan, (8, 8)), count), law


def rolled(scan, places, law, cells):
    """Return the resisting moments at some places, from the states of their pull-off on a mesh."""
    mesh = roughxr.Mesh(cells, accuracy=None)
    return adhesive_and_moments(scan, subregions=places, law=law, mesh=mesh, directions=24)[1]


def finest(scan, moments, law):
    """Return the levers of each place on cells four times smaller, at most 16 to a pixel."""
    levers = []
    for k, cells in enumerate(moments["mesh"].values):
        place = moments[["pull_off_force"]].isel(subregion=[k])
        levers.append(rolled(scan, place, law, min(4 * int(cells), MOST_REFINED)).lever)
    return xr.concat(levers, "subregion").assign_coords(subregion=moments["subregion"])


def errors(scan, places, law):
    """Return the stated error of each place, and the true one in each direction, over the mean of all directions."""
    moments = rolled(scan, places, law, 2)
    true = finest(scan, moments, law)
    difference = abs(moments.lever - true) / abs(true).mean("direction")
    has_finer = moments["mesh"] < MOST_REFINED
    return moments.lever_error.where(has_finer).values, difference.values, abs(true).mean("direction").values


def cost(repeats=3):
    """Print for two samples the processor time of the levers over that of the pull-off alone."""
    glass = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    rough = roughxr.open_sample("rough").contact.level().contact.assign_pair(sphere_radius=500, materials="glass")
    for name, scan, mesh in (
        ("glass twin", glass, roughxr.Mesh(4, step=0.4, accuracy=None)),
        ("rough sample", rough, roughxr.Mesh(8, step=0.4, accuracy=None)),
    ):
        solvers = {"pull-off": roughxr.adhesive, "both": partial(adhesive_and_moments, directions=24)}
        solvers["both"](scan, subregions=(1, 1), mesh=mesh)  # compile
        seconds = dict.fromkeys(solvers, 0.0)
        for _ in range(repeats):
            for way, solve in solvers.items():
                start = time.process_time()
                solve(scan, subregions=(3, 3), mesh=mesh)
                seconds[way] += time.process_time() - start
        pull_off = seconds["pull-off"]
        levers = seconds["both"] - pull_off
        print(f"{name}: levers {levers:.1f} s, pull-off {pull_off:.1f} s, ratio {levers / pull_off:.2f}", flush=True)


def main():
    """Print one row per surface, and one for all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--places", type=int, default=8)
    parser.add_argument("--only", help="one surface, by its name; default: all")
    parser.add_argument("--cost", action="store_true", help="print the cost of the levers instead")
    parser.add_argument("--pixels", action="store_true", help="print the effect of larger pixels instead")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    if options.cost:
        cost()
        return
    if options.pixels:
        print_pixels(6)
        return
    rows = {}
    for name, scan, places, law in cases(options.places):
        if options.only in (None, name):
            rows.setdefault(name, []).append(errors(scan, places, law))
            print_row(name, rows[name])
    print_row("all", [part for parts in rows.values() for part in parts])


def print_pixels(count):
    """Print the coverage of the levers on every second pixel of surfaces that these show, and do not show."""
    for cutoff in CUTOFFS:
        parts = []
        for seed, rms, modulus, work, radius, hurst in HALVED.values():
            options = {"rms": rms, "hurst": hurst, "rolloff": 400, "cutoff": cutoff, "seed": seed}
            made = roughxr.scans.synthetic.self_affine((160, 160), HALVED_PIXEL, **options)
            pair = {"sphere_radius": radius, "contact_modulus": modulus, "work_of_adhesion": work}
            fine = made.contact.assign_pair(**pair)
            scan = fine.isel(x=slice(None, None, 2), y=slice(None, None, 2))
            moments = rolled(scan, regions.sample(regions.centres(scan, (8, 8)), count), "auto", 2)
            true = rolled(fine, moments[["pull_off_force"]], "auto", 2).lever
            lever = abs(true).mean("direction")
            parts.append((moments.lever_error.values, (abs(moments.lever - true) / lever).values, lever.values))
        print_row(f"cutoff {cutoff} nm on pixels of {2 * HALVED_PIXEL:g} nm", parts)


def print_row(name, parts):
    """Print the coverage of the errors of some places."""
    stated, true, lever = (np.concatenate(part) for part in zip(*parts))
    is_finite = np.isfinite(stated) & np.isfinite(true).all(axis=1)
    stated = stated[is_finite]
    true = true[is_finite]
    print(
        f"{name}: {stated.size} places ({(~is_finite).sum()} left out), lever {np.median(lever[is_finite]):.3g} nm; "
        f"the stated error covers the largest difference at {np.mean(true.max(axis=1) <= stated):.0%} of places and "
        f"{np.mean(true <= stated[:, None]):.0%} of directions; stated median {np.median(stated):.2f}, true median "
        f"{np.median(true.max(axis=1)):.2f}, in the mean of directions {np.median(true.mean(axis=1)):.2f}",
        flush=True,
    )


if __name__ == "__main__":
    main()
