"""How right the Griffith limit is on a mesh, and whether the stated error covers what it is off by.

``python tests/benchmarks/without_range.py`` prints one row per case: the pull-off over the exact one, that of a finer
mesh where there is no formula, the stated relative error, and processor time; that of the first row includes compiling.
Half an hour on two cores.
"""

import sys
import time
import warnings
from pathlib import Path

import numpy as np
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr
from roughxr.mechanics.kernels.asperity.asperity_laws import asperity_scales, law
from tests.asperity_loops import asperity_events

# GPa, J/m²
E = 40.0
W = 1.0
PLACES = [(0.0, 0.0), (0.5, 0.5), (0.31, 0.17)]
MORE = [*PLACES, *map(tuple, np.random.default_rng(0).uniform(0, 0.5, (13, 2)).tolist())]

#: Rough surfaces on which no constant of the solver was tuned: Hurst exponent, rms height (nm), seed, work (J/m²).
OTHERS = [(0.5, 2.0, 21, 0.3), (0.9, 5.0, 22, 0.8), (0.7, 1.0, 23, 0.1)]


def scan_of(height, pixel):
    """Return heights as a scan whose middle is at zero."""
    axes = {name: (np.arange(n) - (n - 1) / 2) * pixel for name, n in zip("xy", height.shape)}
    ds = xr.Dataset({"height": (("x", "y"), height)}, axes)
    ds["height"].attrs["units"] = ds["x"].attrs["units"] = ds["y"].attrs["units"] = "nm"
    return ds


def bump(cells, place=(0.0, 0.0), ratio=1.0, radius=1000.0, modulus=E, work=W):
    """Return a paraboloid of so many cells to the contact's radius, under a plane; and its exact pull-off, nN."""
    pixel = (9 * np.pi * work * radius**2 / (8 * modulus)) ** (1 / 3) / cells
    half = int(1.9 * cells * ratio**0.35) + 12
    x, y = (pixel * (np.arange(-half, half + 1) + part) for part in place)
    height = -(x[:, None] ** 2 / np.sqrt(ratio) + y**2 * np.sqrt(ratio)) / (2 * radius)
    pair = {"sphere_radius": 1e9, "contact_modulus": modulus, "work_of_adhesion": work}
    exact = 1.5 * np.pi * work * radius * least_energy(ratio)
    return scan_of(height, pixel).contact.assign_pair(**pair), exact


def least_energy(ratio):
    """Return the pull-off of the ellipse of least energy over the sphere's."""
    A = 0.5 / np.sqrt(ratio)
    B = 0.5 * np.sqrt(ratio)
    energy = law("energy")
    return -asperity_events(asperity_scales(A, B, 1.0, 1.0, energy), energy).largest_tension.P / (1.5 * np.pi)


def four_bumps():
    """Return four unequal summits on a plane, 500 nm apart."""
    x = (np.arange(201) - 100) * 5.0
    height = np.full((201, 201), -40.0)
    for k, (u, v) in enumerate([(-250, -250), (-250, 250), (250, -250), (250, 250)]):
        r2 = (x[:, None] - u) ** 2 + (x - v) ** 2
        height = np.maximum(height, -0.3 * k - r2 / (2 * (300 + 100 * k)))
    pair = {"sphere_radius": 1e9, "contact_modulus": E, "work_of_adhesion": 0.2}
    return scan_of(height, 5.0).contact.assign_pair(**pair)


def row(name, ds, places, exact=None, finer=None, **options):
    """Print one case."""
    begin = time.process_time()
    solution = ds.contact.adhesive(subregions=places, law="jkr", **options)
    spent = time.process_time() - begin
    if exact is None:
        exact = ds.contact.adhesive(subregions=places, law="jkr", mesh=finer).pull_off_force.values
    ratio = solution.pull_off_force.values / exact
    stated = solution.pull_off_error.values
    held = np.mean(np.abs(1 / ratio - 1) <= stated)
    figures = f"{np.round(ratio, 4)}, stated {np.round(stated, 3)}, covered {held:.0%}"
    print(f"{name}: {figures}, cells per pixel {solution.mesh.values}, {spent:.0f} s", flush=True)


def spheres(cells):
    """Print how far spheres of so many cells in radius are off, over sixteen places on the pixels."""
    off = []
    held = []
    for place in MORE:
        ds, exact = bump(cells, place)
        solution = ds.contact.adhesive(subregions=([0.0], [0.0]), law="jkr", mesh=1)
        off.append(float(solution.pull_off_force[0]) / exact - 1)
        held.append(abs(1 / (1 + off[-1]) - 1) <= float(solution.pull_off_error[0]))
    mean = np.mean(off)
    square = np.sqrt(np.mean(np.square(off)))
    largest = np.abs(off).max()
    print(
        f"spheres, {cells:g} cells: mean {mean:+.2%}, root mean square {square:.2%}, largest {largest:.2%}, "
        f"covered {np.mean(held):.0%}",
        flush=True,
    )


def smooth_films():
    """Print how far smooth spheres on soft films of few cells are off, times the film's thickness in cells."""
    for poisson_ratio in (0.3, 0.49):
        for cells in (2, 5, 10, 20):
            layer = roughxr.Layer(float(cells), young_modulus=1.0, poisson_ratio=poisson_ratio)
            pair = {"sphere_radius": 500, "young_modulus": 75, "poisson_ratio": 0.2, "work_of_adhesion": 0.05}
            ds = scan_of(np.zeros((101, 101)), 1.0).contact.assign_pair(**pair, layer=layer)
            pull_offs = {
                refine: ds.contact.adhesive(subregions=([0.0], [0.0]), law="jkr", mesh=refine) for refine in (1, 4)
            }
            ratio = float(pull_offs[1].pull_off_force[0] / pull_offs[4].pull_off_force[0])
            print(
                f"film of {cells} cells, Poisson's ratio {poisson_ratio:g}: off by {ratio - 1:+.1%}, "
                f"{abs(ratio - 1) * cells:.2f} / cells, stated {float(pull_offs[1].pull_off_error[0]):.1%}",
                flush=True,
            )


def rough(name, ds, places):
    """Print how far rough places are off on single meshes, from one of eight cells to a pixel."""
    finest = ds.contact.adhesive(subregions=places, law="jkr", mesh=8).pull_off_force.values
    for refine in (1, 2, 4):
        row(f"{name}, refine={refine}", ds, places, finest, mesh=refine)


def main():
    """Print one row per case, the quick ones first."""
    warnings.simplefilter("ignore")
    middle = ([0.0], [0.0])
    for cells in (2.5, 5.0, 10.0, 20.0, 40.0):
        spheres(cells)
    ds, exact = bump(5.0, PLACES[2])
    row("sphere, 5 cells, default settings", ds, middle, exact)
    for ratio in (5.0, 10.0):
        ds, exact = bump(10.0, PLACES[2], ratio)
        row(f"ellipse {ratio:g}", ds, middle, exact, mesh=2)
    for modulus, work in ((2e-3, 0.05), (0.5, 0.05), (3.0, 0.1)):
        ds, exact = bump(10.0, PLACES[2], radius=10000.0, modulus=modulus, work=work)
        row(f"sphere, E* {modulus:g} GPa", ds, middle, exact, mesh=1)
    smooth_films()
    row("four bumps", four_bumps(), middle, finer=4, preload=500.0, mesh=2)
    made = roughxr.scans.synthetic.self_affine((256, 256), 10.0, rms=3, hurst=0.8, rolloff=500, cutoff=50, seed=11)
    for name, scan, work in (("glass twin", roughxr.open_sample("glass"), 1.35), ("self-affine", made, 0.5)):
        ds = scan.contact.assign_pair(sphere_radius=3000, contact_modulus=39.4, work_of_adhesion=work)
        row(
            f"8 places of {name}",
            ds,
            roughxr.scans.regions.sample(roughxr.scans.regions.centres(ds, (8, 8)), 8),
            finer=8,
        )
    for hurst, rms, seed, work in OTHERS:
        made = roughxr.scans.synthetic.self_affine(
            (256, 256), 10.0, rms=rms, hurst=hurst, rolloff=500, cutoff=50, seed=seed
        )
        ds = made.contact.assign_pair(sphere_radius=2000, contact_modulus=30, work_of_adhesion=work)
        rough(f"Hurst {hurst:g}", ds, roughxr.scans.regions.sample(roughxr.scans.regions.centres(ds, (8, 8)), 12))
    ds, exact = bump(100.0, PLACES[2])
    row("sphere, 100 cells", ds, middle, exact, mesh=1)


if __name__ == "__main__":
    main()
