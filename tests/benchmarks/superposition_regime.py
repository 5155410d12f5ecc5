"""When asperities may be summed: ``python tests/benchmarks/superposition_regime.py [OPTIONS]``.

Self-affine surfaces over Hurst exponent, roll-off, cutoff and rms height, under two spheres with two works of adhesion:
the pull-off by superposition, with the patch that suits the scan and with those of 3, 5 and 7 pixels, over that of the
adhesive simulation (Griffith's limit) at the same four places, each pressed 1 nm and the rms height beyond touch.

``--measure`` computes what ``datasets/superposition_family.csv`` lacks, a row for each surface and pair, for so many
seconds of processor time. Then the sums are made anew on all rows, and printed: the rule that `superpose` carries
(`roughxr.asperity.expectation`), from the group "made", beside its scatter on the group "held", of other spectra; what
numbers that are known beforehand would add to it; what wider patches do; and the glass twin, whose direct pull-off
(pressed 4 nm, 64 places, half the pixel) is measured with ``--twin``, some minutes. ``--scans`` does the same on
measured scans, four places under each pair, on which nothing was tuned: the rule is tried, not made.
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
from roughxr.asperity import expectation
from roughxr.asperity.pull_off_maps import pull_off_map
from roughxr.asperity.superposition import superpose
from roughxr.contact.adhesion import adhesive
from roughxr.contact.estimates import tabor
from roughxr.scans.synthetic import self_affine
from roughxr.statistics import smooth_pull_off

TABLE = Path(__file__).parents[2] / "datasets" / "superposition_family.csv"
PIXEL = 8.0
PIXELS = 128
ELASTIC = {"young_modulus": 75, "poisson_ratio": 0.22}
PAIRS = [(radius, work) for radius in (500.0, 3000.0) for work in (0.2, 1.35)]  # nm, J/m²
PATCHES = ("auto", 3, 5, 7)

#: Hurst exponent, roll-off (nm), cutoff (nm), rms height (nm).
MADE = tuple(itertools.product((0.4, 0.8), (100.0, 300.0), (20.0, 40.0), (0.8, 2.0)))
HELD = ((0.6, 170.0, 28.0, 1.3), (0.8, 200.0, 24.0, 1.0), (0.2, 60.0, 17.0, 1.6), (0.9, 250.0, 60.0, 2.5))
SEEDS = (1, 2)


def cases():
    """Return all surfaces and pairs, seed by seed, each in an order that covers the family from the first on."""
    groups = (("made", MADE), ("held", HELD))
    combinations = [(name, *case, pair) for name, surfaces in groups for case in surfaces for pair in PAIRS]
    mixed = [combinations[k] for k in np.random.default_rng(0).permutation(len(combinations))]
    return [(*case[:-1], seed, *case[-1]) for seed in SEEDS for case in mixed]


KNOWN = ("slope", "spacing / contact radius", "superposed / smooth", "Tabor", "pixels to a wave", "patch / wave")
KEYS = ("group", "hurst", "rolloff", "cutoff", "rms", "seed", "radius", "work")


def surface_of(hurst, rolloff, cutoff, rms, seed, radius, work):
    """Return the scan with its pair."""
    spectrum = {"rms": rms, "hurst": hurst, "rolloff": rolloff, "cutoff": cutoff}
    scan = self_affine((PIXELS, PIXELS), PIXEL, seed=seed, **spectrum)
    return scan.contact.assign_pair(sphere_radius=radius, work_of_adhesion=work, **ELASTIC)


def measured(scan, subregions=(2, 2), press=None):
    """Return the direct pull-off, the mean over the places, and how it was resolved."""
    press = press or float(scan.height.std()) + 1.0
    options = {"mesh": roughxr.Mesh(refinement(scan), step=0.4), "law": "jkr"}
    cycle = adhesive(scan, delta=[press], subregions=subregions, datum="first_contact", **options)
    return {
        "refine": options["mesh"].cells,
        "direct": float(cycle.pull_off_force.mean(skipna=False)),
        "resolution": float(cycle.pull_off_resolution.min()),
    }


def summed(scan, subregions=(2, 2)):
    """Return the superposed pull-off with each patch."""
    maps = {patch: pull_off_map(scan.contact.asperities(patch=patch), subregions=subregions) for patch in PATCHES}
    return {
        f"superposed_{patch}": float(pull_off_map_of_patch.pull_off_force.mean())
        for patch, pull_off_map_of_patch in maps.items()
    }


def beforehand(scan, subregions=(2, 2)):
    """Return numbers that need no simulation."""
    catalogue = tabor(scan.contact.asperities())
    superposed = pull_off_map(catalogue, subregions=subregions)
    at = superposed.pull_off_delta.values
    sweep = superpose(catalogue, delta=np.unique(at), subregions=subregions)
    swept = [sweep.isel(subregion=k).sel(delta=delta) for k, delta in enumerate(at)]
    contacts = sum(int(sweep_of_place.contacts) for sweep_of_place in swept)
    area = np.prod([end - begin for begin, end in zip(*[iter(roughxr.scans.regions.extent(scan))] * 2)])
    return {
        "pixels to a wave": float(catalogue.shortest_wavelength / catalogue.pixel),
        "patch / wave": float(2 * catalogue.patch_radius / catalogue.shortest_wavelength),
        "overlap": sum(int(sweep_of_place.contacts_overlapping) for sweep_of_place in swept) / contacts,
        "spacing / contact radius": float(np.sqrt(area / catalogue.sizes["asperity"]))
        / contact_radius(scan, catalogue),
        "slope": float(catalogue.rms_slope),
        "Tabor": float(catalogue.tabor_parameter.median()),
        "superposed / smooth": float(superposed.pull_off_force.mean()) / smooth_pull_off(scan),
    }


def contact_radius(scan, catalogue):
    """Return the radius (nm) of a typical asperity's contact at pull-off."""
    curvature = 0.5 * (catalogue.curvature_min + catalogue.curvature_max) + 1 / float(scan.sphere_radius)
    radius = 1 / float(curvature.where(catalogue.curvature_min > 0).median())
    return (9 * np.pi * float(scan.work_of_adhesion) * radius**2 / (8 * float(scan.contact_modulus))) ** (1 / 3)


def refinement(scan):
    """Return by how much the simulation is refined: five of its pixels to a wave, and one to a contact's radius."""
    catalogue = scan.contact.asperities()
    pixel = float(catalogue.pixel)
    a = contact_radius(scan, catalogue)
    wave = float(catalogue.shortest_wavelength)
    return int(np.clip(np.ceil(max(4.8 * pixel / wave, pixel / a)), 1, 4 if a < 0.4 * pixel else 2))


def measure_missing(limit):
    """Append to the table the rows that it lacks, until so many seconds of processor time are spent."""
    rows = pd.read_csv(TABLE)[list(KEYS)].itertuples(index=False) if TABLE.exists() else ()
    done = {tuple(row) for row in rows}
    began = time.process_time()
    for case in cases():
        if tuple(case) in done or time.process_time() - began > limit:
            continue
        scan = surface_of(*case[1:])
        row = dict(zip(KEYS, case)) | measured(scan)
        print(row, f"superposed / direct {summed(scan)['superposed_auto'] / row['direct']:.2f}", flush=True)
        new = not TABLE.exists()
        with TABLE.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, row, lineterminator="\n")
            if new:
                writer.writeheader()
            writer.writerow({k: v if isinstance(v, (str, int)) else f"{v:.6g}" for k, v in row.items()})


def with_sums(table):
    """Return the rows that were measured with superposed over direct pull-off by each patch, and what is known."""
    rows = []
    for row in table.dropna(subset=["direct"]).to_dict("records"):
        scan = surface_of(*(row[key] for key in KEYS[1:]))
        ratios = {name: force / row["direct"] for name, force in summed(scan).items()}
        rows.append(row | ratios | beforehand(scan))
    return pd.DataFrame(rows)


def tell(rows):
    """Print the rule, its scatter and what would narrow it."""
    print(f"the rule: {expectation.RATIO:g}, {expectation.LOW:g} … {expectation.HIGH:g}")
    for group, part in rows.groupby("group"):
        ratio = part.superposed_auto
        low, middle, high = np.quantile(ratio, (0.05, 0.5, 0.95))
        inside = 100 * np.mean((ratio >= expectation.LOW) & (ratio <= expectation.HIGH))
        wide = 100 * np.mean((ratio >= 0.6) & (ratio <= 1.5))
        print(
            f"{group}: {len(part)} rows, superposed / direct {middle:.2f}, {low:.2f} … {high:.2f} "
            f"(least {ratio.min():.2f}, greatest {ratio.max():.2f}); {inside:.0f} % within the rule, "
            f"{wide:.0f} % within 0.6 … 1.5"
        )
    made = rows[rows.group == "made"]
    y = np.log(made.superposed_auto)
    print(f"scatter of its logarithm {y.std():.2f}; what a straight line in the logarithm of one number leaves of it:")
    for name in KNOWN:
        x = np.log(made[name])
        print(f"  {name:26} {(y - np.polyval(np.polyfit(x, y, 1), x)).std(ddof=2):.2f}")
    print(f"  {'overlap':26} {(y - np.polyval(np.polyfit(made.overlap, y, 1), made.overlap)).std(ddof=2):.2f}")
    print("patches of so many waves, superposed / direct, 5 %, half and 95 % of the rows:")
    of_patch = [pd.DataFrame({"waves": k * PIXEL / rows.cutoff, "ratio": rows[f"superposed_{k}"]}) for k in PATCHES[1:]]
    wide = pd.concat(of_patch)
    for low, high in itertools.pairwise((0.4, 0.8, 1.2, 1.6, 2.2, 3.5)):
        part = wide[(wide.waves >= low) & (wide.waves < high)].ratio
        if len(part):
            a, b, c = np.quantile(part, (0.05, 0.5, 0.95))
            print(f"  {low:g} … {high:g}: {a:.2f}, {b:.2f}, {c:.2f} ({len(part)} rows)")


def tell_twin():
    """Print the same of the glass twin, its direct pull-off measured now."""
    scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, surface_energy=0.6747, **ELASTIC)
    cycle = adhesive(scan, delta=[4.0], subregions=(8, 8), mesh=2, law="jkr", datum="first_contact")
    direct = float(cycle.pull_off_force.mean())
    ratios = {name: round(force / direct, 2) for name, force in summed(scan, (8, 8)).items()}
    print(f"glass twin: direct {direct:.0f} nN; superposed / direct {ratios}")


def tell_scans(paths):
    """Print the same of measured scans, levelled, with the rule's own sentence for each."""
    for path in paths:
        ground = roughxr.open_scan(path).contact.level().contact.fill()
        for radius, work in PAIRS:
            scan = ground.contact.assign_pair(sphere_radius=radius, work_of_adhesion=work, **ELASTIC)
            measures = measured(scan)
            said = superpose(scan.contact.asperities(), delta=[0.0], subregions=(2, 2)).attrs["expectation"]
            ratios = {name: round(force / measures["direct"], 2) for name, force in summed(scan).items()}
            print(f"{Path(path).name}, R {radius:g} nm, w {work:g} J/m²: direct {measures['direct']:.0f} nN; {ratios}")
            print(f"    {said}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--measure", type=float, metavar="SECONDS", default=0.0)
    parser.add_argument("--twin", action="store_true")
    parser.add_argument("--scans", nargs="+", metavar="FILE", default=())
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    with dask.config.set(scheduler="threads", num_workers=2):
        if asked.measure:
            measure_missing(asked.measure)
        elif not asked.scans:
            tell(with_sums(pd.read_csv(TABLE)))
        tell_scans(asked.scans)
        if asked.twin:
            tell_twin()
