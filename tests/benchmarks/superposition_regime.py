"""When asperities may be summed: ``python tests/benchmarks/superposition_regime.py [--measure | --twin]``.

Self-affine surfaces over Hurst exponent, roll-off, cutoff and rms height, two seeds each, under two spheres with two
works of adhesion: the pull-off by superposition, with the patch that suits the scan and with those of 3, 5 and 7 pixels,
over that of the adhesive simulation (Griffith's limit) at the same four places.

``--measure`` computes what ``datasets/superposition_family.csv`` lacks, a row for each surface and pair (about half an
hour of processor time for all of it). Without it the rows are read, the rule that `superpose` carries is fitted
to the group "made", and its scatter is told on it and on the group "held", other spectra that the rule was not made
from. ``--twin`` adds the glass twin, measured now.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import time
import warnings
from pathlib import Path

import dask
import numpy as np
import pandas as pd

import roughxr
from roughxr.contact.adhesion import adhesive
from roughxr.contact.estimates import tabor
from roughxr.contact.maps import pull_off_map
from roughxr.contact.superposition import superpose
from roughxr.statistics import smooth_pull_off
from roughxr.synthetic import self_affine

TABLE = Path(__file__).parents[2] / "datasets" / "superposition_family.csv"
PIXEL, PIXELS = 8.0, 128
ELASTIC = {"young_modulus": 75, "poisson_ratio": 0.22}
PAIRS = [(radius, work) for radius in (500.0, 3000.0) for work in (0.2, 1.35)]  # nm, J/m²
PATCHES = ("auto", 3, 5, 7)

#: Hurst exponent, roll-off (nm), cutoff (nm), rms height (nm).
MADE = tuple(itertools.product((0.4, 0.8), (100.0, 300.0), (20.0, 40.0), (0.8, 2.0)))
HELD = ((0.6, 170.0, 28.0, 1.3), (0.8, 200.0, 24.0, 1.0), (0.2, 60.0, 17.0, 1.6), (0.9, 250.0, 60.0, 2.5))
SEEDS = (1, 2)

#: Pixels near a contact beyond which a place is given up, and its row left without a number: adhesion has then drawn
#: whole grounds of many waves into one contact, where nobody sums asperities.
MOST_CELLS = 2500


def cases():
    """Return all surfaces and pairs, seed by seed, each in an order that covers the family from the first on."""
    groups = (("made", MADE), ("held", HELD))
    every = [(name, *one, pair) for name, surfaces in groups for one in surfaces for pair in PAIRS]
    mixed = [every[k] for k in np.random.default_rng(0).permutation(len(every))]
    return [(*one[:-1], seed, *one[-1]) for seed in SEEDS for one in mixed]


KEYS = ("group", "hurst", "rolloff", "cutoff", "rms", "seed", "radius", "work")


def surface_of(hurst, rolloff, cutoff, rms, seed, radius, work):
    """Return the scan with its pair."""
    spectrum = {"rms": rms, "hurst": hurst, "rolloff": rolloff, "cutoff": cutoff}
    scan = self_affine((PIXELS, PIXELS), PIXEL, seed=seed, **spectrum)
    return scan.contact.assign_pair(sphere_radius=radius, work_of_adhesion=work, **ELASTIC)


def measure(scan, subregions=(2, 2), press=None):
    """Return what is known of a scan and its pair beforehand, and both pull-offs at the same places."""
    known, at = beforehand(scan, subregions)
    press = press or float(scan.height.std()) + 1.0
    began = time.process_time()
    options = {"refine": refinement(scan, at), "step": 0.4, "max_cells": MOST_CELLS, "datum": "first_contact"}
    cycle = adhesive(scan, delta=[press], subregions=subregions, **options)
    known["refine"] = options["refine"]
    known["direct"] = float(cycle.pull_off_force.mean(skipna=False))
    known["resolution"] = float(cycle.pull_off_resolution.min())
    known["seconds"] = time.process_time() - began
    for patch in PATCHES:
        catalogue = roughxr.asperities(scan, patch=patch)
        known[f"superposed_{patch}"] = float(pull_off_map(catalogue, subregions=subregions).pull_off_force.mean())
    return known


def beforehand(scan, subregions):
    """Return numbers that need no simulation, and the radius (nm) of a typical asperity's contact at pull-off."""
    catalogue = tabor(scan.contact.asperities())
    found = pull_off_map(catalogue, subregions=subregions)
    deltas = np.unique(found.pull_off_delta.values)
    sweep = superpose(catalogue, delta=deltas, subregions=subregions)
    each = [
        sweep.isel(subregion=k).sel(delta=d, method="nearest")
        for k, d in enumerate(found.pull_off_delta.values.ravel())
    ]
    contacts = max(sum(int(one.contacts) for one in each), 1)
    curvature = 0.5 * (catalogue.curvature_min + catalogue.curvature_max) + 1 / float(scan.sphere_radius)
    R = 1 / float(curvature.where(catalogue.curvature_min > 0).median())
    a = (9 * np.pi * float(scan.work_of_adhesion) * R**2 / (8 * float(scan.contact_modulus))) ** (1 / 3)
    sides = PIXEL * np.array([scan.sizes["x"], scan.sizes["y"]])
    return {
        "pixels_per_wave": float(catalogue.shortest_wavelength / catalogue.pixel),
        "patch_per_wave": float(2 * catalogue.patch_radius / catalogue.shortest_wavelength),
        "overlap": sum(int(one.contacts_overlapping) for one in each) / contacts,
        "contacts": contacts / len(each),
        "spacing": float(np.sqrt(sides.prod() / catalogue.sizes["asperity"])) / a,
        "slope": float(roughxr.roughness(scan, spectra=False).s_dq),
        "tabor": float(catalogue.tabor_parameter.median()),
        "smooth": smooth_pull_off(scan),
    }, a


def refinement(scan, a):
    """Return by how much the simulation is refined: five of its pixels to a wave, and one to a contact's radius."""
    pixel = roughxr.schema.pixel(scan)[0]
    wave = roughxr.scans.wavelength.shortest_wavelength(scan)
    return int(np.clip(np.ceil(max(4.8 * pixel / wave, pixel / a)), 1, 4 if a < 0.4 * pixel else 2))


def measure_missing(limit):
    """Append to the table the rows that it lacks, until so many seconds of processor time are spent."""
    done = (
        set() if not TABLE.exists() else {tuple(row) for row in pd.read_csv(TABLE)[list(KEYS)].itertuples(index=False)}
    )
    began = time.process_time()
    for case in cases():
        if tuple(case) in done or time.process_time() - began > limit:
            continue
        row = dict(zip(KEYS, case)) | measure(surface_of(*case[1:]))
        ratio = row["superposed_auto"] / row["direct"]
        print({k: v if isinstance(v, str) else float(f"{v:.4g}") for k, v in row.items()}, f"{ratio:.2f}", flush=True)
        new = not TABLE.exists()
        with TABLE.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, row, lineterminator="\n")
            if new:
                writer.writeheader()
            writer.writerow({k: v if isinstance(v, (str, int)) else f"{v:.6g}" for k, v in row.items()})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--measure", type=float, nargs="?", const=3600.0, metavar="SECONDS")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    if asked.measure:
        with dask.config.set(scheduler="threads", num_workers=2):
            measure_missing(asked.measure)
