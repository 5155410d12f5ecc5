"""When asperities may be summed: ``python tests/benchmarks/superposition_regime.py [OPTIONS]``.

Self-affine surfaces over Hurst exponent, roll-off, cutoff and rms height, under two spheres with two works of adhesion:
the pull-off by superposition, with the patch that suits the scan and with those of 3, 5 and 7 pixels, over that of the
adhesive simulation (Griffith's limit) at the same four places, each pressed 1 nm and the rms height beyond touch: of
the means over the four, and place by place.

``--measure`` computes what ``datasets/superposition_family.csv`` lacks, a row for each surface and pair, for so many
seconds of processor time. Then the sums are made anew on all rows, and printed: the rule that `superpose` carries
(`roughxr.mechanics.asperity.expectation`), from the group "made", beside its scatter on the group "held", of other
spectra; what
numbers that are known beforehand would add to it; what wider patches do; and the glass twin, whose direct pull-off
(pressed 4 nm, 64 places, half the pixel) is measured with ``--twin``, some minutes. ``--scans`` does the same on
measured scans, four places under each pair, on which nothing was tuned: the rule is tried, not made.

``--places`` computes single places that ``datasets/superposition_places.csv`` lacks, of the family's first seed and of
surfaces and pairs drawn at random after the rule was set, the group "fresh". ``--archive`` compares the places of a
run's or a paper's archive.
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
import xarray as xr

import roughxr
from roughxr.application.report.caveats import superposition_notes
from roughxr.application.reproduction.conclusion import rank_correlation
from roughxr.mechanics.asperity import expectation
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.contact.adhesion import adhesive
from roughxr.mechanics.contact.estimates import tabor
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.statistics import smooth_pull_off

TABLE = Path(__file__).parents[2] / "datasets" / "superposition_family.csv"
PLACES = TABLE.with_name("superposition_places.csv")
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


def fresh_cases():
    """Return surfaces and pairs drawn at random from the family's ranges, on which nothing was tuned."""
    rng = np.random.default_rng(70)
    between = [(0.2, 0.9), (60.0, 300.0), (20.0, 45.0), (0.8, 2.5), (400.0, 4000.0), (0.1, 1.35)]
    drawn = np.exp([rng.uniform(*np.log(ends), 40) for ends in between]).T
    numbers = [[float(f"{value:.2g}") for value in row] for row in drawn]
    return [("fresh", *row[:4], 3, *row[4:]) for row in numbers]


def surface_of(hurst, rolloff, cutoff, rms, seed, radius, work):
    """Return the scan with its pair."""
    spectrum = {"rms": rms, "hurst": hurst, "rolloff": rolloff, "cutoff": cutoff}
    scan = self_affine((PIXELS, PIXELS), PIXEL, seed=seed, **spectrum)
    return scan.contact.assign_pair(sphere_radius=radius, work_of_adhesion=work, **ELASTIC)


def simulated(scan, subregions=(2, 2)):
    """Return the direct pull-off at each place."""
    options = {"mesh": roughxr.Mesh(refinement(scan), step=0.4), "law": "jkr"}
    press = float(scan.height.std()) + 1.0
    return adhesive(scan, delta=[press], subregions=subregions, datum="first_contact", **options)


def measured(scan):
    """Return the direct pull-off, the mean over the places, and how it was resolved."""
    cycle = simulated(scan)
    return {
        "refine": refinement(scan),
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


def missing(table, wanted, limit):
    """Yield the cases that a table lacks, until so many seconds of processor time are spent."""
    rows = pd.read_csv(table)[list(KEYS)].itertuples(index=False) if table.exists() else ()
    done = {tuple(row) for row in rows}
    began = time.process_time()
    for case in wanted:
        if tuple(case) not in done and time.process_time() - began <= limit:
            yield case


def append(table, row):
    """Add a row to a table, after a header if the table is new."""
    is_new = not table.exists()
    with table.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, row, lineterminator="\n")
        if is_new:
            writer.writeheader()
        writer.writerow({k: v if isinstance(v, (str, int)) else f"{v:.6g}" for k, v in row.items()})


def measure_missing(limit):
    """Append to the table of means the rows that it lacks."""
    for case in missing(TABLE, cases(), limit):
        scan = surface_of(*case[1:])
        row = dict(zip(KEYS, case)) | measured(scan)
        print(row, f"superposed / direct {summed(scan)['superposed_auto'] / row['direct']:.2f}", flush=True)
        append(TABLE, row)


def measure_places(limit):
    """Append to the table of places what it lacks: the family's surfaces with their first seed, and fresh ones."""
    family = [case for case in cases() if case[5] == SEEDS[0]]
    shuffled = [case for pair in itertools.zip_longest(family, fresh_cases()) for case in pair if case]
    for case in missing(PLACES, shuffled, limit):
        cycle = simulated(surface_of(*case[1:]))
        for place, direct in enumerate(cycle.pull_off_force.values.tolist()):
            append(PLACES, dict(zip(KEYS, case)) | {"place": place, "direct": direct})


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
    for group, part in [*rows.groupby("group"), ("all", rows)]:
        ratio = part.superposed_auto
        low, middle, high = np.quantile(ratio, (0.05, 0.5, 0.95))
        inside = int(np.sum((ratio >= expectation.LOW) & (ratio <= expectation.HIGH)))
        wide = 100 * np.mean((ratio >= 0.6) & (ratio <= 1.5))
        print(
            f"{group}: {len(part)} rows, superposed / direct {middle:.2f}, {low:.2f} … {high:.2f} "
            f"(least {ratio.min():.2f}, greatest {ratio.max():.2f}); {inside} within the rule, "
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


def places_with_sums():
    """Return the simulated places with the superposed pull-off of each."""
    rows = []
    for key, part in pd.read_csv(PLACES).groupby(list(KEYS), sort=False):
        pulls = pull_off_map(surface_of(*key[1:]).contact.asperities(), subregions=(2, 2))
        rows.append(part.assign(superposed=pulls.pull_off_force.values[part.place]))
    return pd.concat(rows)


def tell_places(rows):
    """Print the ratio at single places, and whether the sums rank the places of a surface."""
    rows = rows.assign(ratio=rows.superposed / rows.direct)
    logarithms = np.log(rows[["superposed", "direct"]])
    within = logarithms - logarithms.groupby([rows[key] for key in KEYS]).transform("mean")
    for group, part in [*rows.groupby("group"), ("all", rows)]:
        low, middle, high = part.ratio.quantile([0.05, 0.5, 0.95])
        inside = int(part.ratio.between(expectation.LOW, expectation.HIGH).sum())
        # of four places three deviate freely from their mean
        scatter = np.sqrt((within.loc[part.index] ** 2).mean() * 4 / 3)
        print(
            f"{group}: {len(part)} places, superposed / direct {middle:.2f}, {low:.2f} … {high:.2f} (least "
            f"{part.ratio.min():.2f}, greatest {part.ratio.max():.2f}); {inside} ({100 * inside / len(part):.0f} %) "
            f"within the rule; within a surface: correlation {within.loc[part.index].corr().iloc[0, 1]:.2f}, "
            f"scatter of the logarithm {scatter.superposed:.2f} for {scatter.direct:.2f}"
        )


def tell_archive(path):
    """Print how the superposed pull-offs of an archive compare with the simulated ones, place by place."""
    with xr.open_datatree(path) as tree:
        names = [name for name in ("published", "energy", "adhesive") if name in tree["statistics"]]
        forces = {name: tree[f"statistics/{name}"]["pull_off_force"].values for name in names}
    simulated = forces.pop("adhesive")
    for name, force in forces.items():
        ratio = force / simulated
        low, middle, high = np.nanquantile(ratio, (0.05, 0.5, 0.95))
        inside = int(np.sum((ratio >= expectation.LOW) & (ratio <= expectation.HIGH)))
        means, spreads = zip(*((np.nanmean(values), np.nanstd(values, ddof=1)) for values in (force, simulated)))
        print(
            f"{name}: {ratio.size} places, superposed / direct of the means {means[0] / means[1]:.2f}, by place "
            f"{middle:.2f}, {low:.2f} … {high:.2f}; {inside} within the rule; rank correlation "
            f"{rank_correlation(force, simulated):.2f}; scatter over mean {spreads[0] / means[0]:.2f} for "
            f"{spreads[1] / means[1]:.2f}"
        )


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
            summed_up = superpose(scan.contact.asperities(), delta=[0.0], subregions=(2, 2))
            said = superposition_notes({"solutions/energy": summed_up})[0]
            ratios = {name: round(force / measures["direct"], 2) for name, force in summed(scan).items()}
            print(f"{Path(path).name}, R {radius:g} nm, w {work:g} J/m²: direct {measures['direct']:.0f} nN; {ratios}")
            print(f"    {said}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--measure", type=float, metavar="SECONDS", default=0.0)
    parser.add_argument("--places", type=float, metavar="SECONDS", default=0.0)
    parser.add_argument("--archive", metavar="FILE")
    parser.add_argument("--twin", action="store_true")
    parser.add_argument("--scans", nargs="+", metavar="FILE", default=())
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    with dask.config.set(scheduler="threads", num_workers=2):
        if asked.measure:
            measure_missing(asked.measure)
        elif asked.places:
            measure_places(asked.places)
        elif asked.archive:
            tell_archive(asked.archive)
        elif not asked.scans:
            tell(with_sums(pd.read_csv(TABLE)))
            tell_places(places_with_sums())
        tell_scans(asked.scans)
        if asked.twin:
            tell_twin()
