"""Best estimates from coarse pictures of measured surfaces, against the surfaces themselves.

    python tests/benchmarks/real_below_the_pixel.py [--surfaces NAME …] [--pictures N] [--cache FILE]
    python tests/benchmarks/real_below_the_pixel.py --drawn N [--cache FILE]
    python tests/benchmarks/real_below_the_pixel.py --spectra

A measured map of ``../shared/scans`` is scaled down in x, y and z alike to pixels of 2 nm, unless they are finer, so
that real texture lies at the scale that adhesion feels. This is the truth. It is imaged as a microscope would: a round
tip, every fourth or eighth pixel, sampled or averaged, with noise. `roughxr.extrapolated` gives its estimate from it,
down to two pixels of the truth, at six places. Each surface counts once in the last lines, by its mean over pictures.
``--surfaces`` and ``--pictures`` choose a part; a cache keeps what was solved. ``--drawn`` takes N settings of surface,
pair, radius, tip and averaging at random, each value about equally often. Each setting has three pictures,
a good one, a coarser and a noisier one; the last lines compare their intervals. ``--spectra`` prints by how much
ln(energy) of the maps falls from an octave of wavelengths to shorter ones, on which the added roughness rests.
"""

import argparse
import itertools
import json
import os
import warnings
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import xarray as xr

import roughxr
from roughxr.contact.adhesive_options import preload_problem
from roughxr.contact.subpixel import AddedRoughness
from roughxr.scans.fine_scales import Spectrum, rings
from roughxr.scans.wavelength import scan_parts
from roughxr.studies.extrapolation import Question, Surface

SCANS = Path(__file__).parents[3] / "shared" / "scans"
SURFACES = {
    "grains": "park_1um_512_grains.tiff",
    "rough": "bruker_10um_512_rough.di",
    "icon": "gwyddion_ascii_10um_256.txt",
    "chip": "gsf_80um_300_chip.gsf",
    "film": "asylum_2um_256_film.ibw",
    "titanate": "gwyp_10um_256_pto.gwy",
    "pits": "asylum_20um_256.ibw",
    "flat": "nanosurf_20um_256.nid",
    "streaks": "agilent_20um.mi",
}
PAIRS = {
    "glass": {"contact_modulus": 39.4, "work_of_adhesion": 0.1},
    "wet": {"contact_modulus": 39.4, "work_of_adhesion": 0.2, "hardness": 6.0},
    "polystyrene": {"materials": "glass/polystyrene"},
}
#: Pixels of the truth in one of the picture, averaged or sampled, tip radius (nm), noise (nm); in a fixed mixed order.
PICTURES = list(itertools.product((4, 8), (False, True), (5.0, 8.0, 15.0), (0.05, 0.2)))
PICTURES = [PICTURES[k] for k in np.random.default_rng(1).permutation(len(PICTURES))]
FINEST, GRID = 2.0, (3, 2)

#: Sphere radii (nm), the first in the fixed order; tips (nm). Surfaces that were added last are drawn twice as often.
RADII, TIPS, LAST = (300.0, 1000.0), (5.0, 8.0, 15.0), ("pits", "flat", "streaks")

#: Pixels and noise (nm) of a good picture, of a coarser and of a noisier one.
GOOD, COARSER, NOISIER = (4, 0.05), (8, 0.05), (4, 0.2)


def surface(name):
    """Return a measured map, scaled down where it is coarse."""
    scan = roughxr.level(roughxr.open_scan(SCANS / SURFACES[name]).load())
    scale = min(1.0, FINEST / float(scan.x[1] - scan.x[0]))
    nm = {"units": "nm"}
    axes = {axis: (axis, scale * scan[axis].values, nm) for axis in "xy"}
    return roughxr.level(xr.Dataset({"height": (("x", "y"), scale * scan.height.values.astype(float), nm)}, axes))


def picture(truth, pixels, averaged, tip, noise, *, seed=None):
    """Return the truth as a microscope shows it, on pixels of so many of its own."""
    draw = np.random.default_rng(pixels if seed is None else seed)
    dilated = roughxr.scans.dilate(truth, tip_radius=tip)
    if averaged:
        coarse = dilated.coarsen(x=pixels, y=pixels, boundary="trim").mean()
    else:
        coarse = dilated.isel(x=slice(pixels // 2, None, pixels), y=slice(pixels // 2, None, pixels))
    return coarse.assign(height=coarse.height + draw.normal(0, noise, coarse.height.shape))


def solved(scan, centres, shortest):
    """Return the mean pull-off (nN) of the surface as scanned, with wavelengths down to the shortest (nm)."""
    problem, adhesion = preload_problem(scan)
    bare = AddedRoughness(Spectrum(0.0, 1.0, 0.5, shortest), shortest, shortest)
    places = range(centres.sizes["subregion"])
    return float(Surface(scan, problem, centres).solve(Question(problem, adhesion, bare), places, 1)[..., 0].mean())


def drawn(count, *, seed=2):
    """Return surface, pair, picture and radius of cases at random, three to each of so many settings."""
    draw = np.random.default_rng(seed)
    values = ([*LAST, *SURFACES], list(PAIRS), RADII, TIPS, (False, True))
    settings = zip(*([each[k % len(each)] for k in draw.permutation(count)] for each in values))
    return [
        (name, pair, (pixels, averaged, tip, noise), radius)
        for name, pair, radius, tip, averaged in settings
        for pixels, noise in (GOOD, COARSER, NOISIER)
    ]


def case(name, pair, how, radius):
    """Return truth, picture and estimate with its interval (nN) of one picture."""
    truth = surface(name).contact.assign_pair(sphere_radius=radius, **PAIRS[pair])
    pixel, seen = float(truth.x[1] - truth.x[0]), picture(truth, *how)
    centres = roughxr.scans.regions.centres(truth, GRID)
    out = roughxr.extrapolated(seen, subregions=centres, seeds=2, shortest=2 * pixel)
    found = {key: float(out[f"pull_off_{key}"]) for key in ("mean", "lower", "upper")}
    own = "self-affine" if "lies between both" not in out.attrs["assumed"] else "real"
    sides = {"truth": solved(truth, centres, 2 * pixel), "picture": solved(seen, centres, 2 * pixel * how[0])}
    return sides | found | {"taken for": own, "assumed": out.attrs["assumed"]}


def spectra():
    """Print the falls of ln(energy) to the octave of 4 to 8 pixels, from the next longer one and from two octaves."""
    print("surface    one octave  two octaves", flush=True)
    falls = []
    for name in SURFACES:
        heights, pixel = (truth := surface(name)).height.values, float(truth.x[1] - truth.x[0])
        q, psd, _ = rings(scan_parts(heights).squares, (pixel, pixel))
        octave, energy = np.floor(np.log2(2 * np.pi / q / pixel) + 1e-9), q * psd * np.gradient(q)
        logs = [np.log(energy[octave == k].sum()) for k in (4, 3, 2)]
        falls.append((logs[1] - logs[2], logs[0] - logs[2]))
        print(f"{name:9s} {falls[-1][0]:11.2f} {falls[-1][1]:12.2f}")
    for words, fall in zip(("one octave", "two octaves"), np.transpose(falls)):
        print(f"{words}: {fall.mean():.2f} ± {fall.std(ddof=1):.2f}, {fall.size} surfaces")


def summary(surfaces, rows):
    """Print the errors of estimates and how many intervals hold: rows of truth, picture, mean and ends (nN)."""
    names, (truth, seen, mean, low, high) = np.array(surfaces), np.array(rows).T
    errors = {"estimate": np.log(mean / truth), "picture": np.log(seen / truth), "0.7 x": np.log(0.7 * seen / truth)}
    inside, each = (low <= truth) & (truth <= high), [names == name for name in dict.fromkeys(surfaces)]
    for words, error in errors.items():
        rms, close = (
            np.sqrt(np.mean([np.mean(error[which] ** 2) for which in each])),
            int((abs(error) < np.log(2)).sum()),
        )
        print(
            f"ln({words} / truth), each surface once: rms {rms:.2f}; ratio {np.mean(np.exp(error)):.2f} in the mean, "
            f"{np.exp(error.mean()):.2f} in the geometric mean; within a factor of 2: {close} of {error.size}"
        )
    share = np.mean([inside[which].mean() for which in each])
    print(f"inside: {inside.sum()} of {inside.size} pictures, {share:.0%} with each surface once")
    print(f"half width of the interval, median: x {np.exp(np.median(np.log(high / low)) / 2):.2f}")


def narrower(rows):
    """Print how many worse pictures have a narrower interval than the good one of the same surface."""
    width = {key: np.log(row["upper"] / row["lower"]) for key, row in rows.items()}
    for words, worse in (("coarser", COARSER), ("noisier", NOISIER)):
        good = {key: (*key[:2], (GOOD[0], *key[2][1:3], GOOD[1]), key[3]) for key in width if key[2][::3] == worse}
        ratios = np.exp([(width[key] - width[other]) / 2 for key, other in good.items() if other in width])
        if ratios.size:
            print(
                f"half width of the {words} picture over that of the good one: median {np.median(ratios):.2f}, least "
                f"{ratios.min():.2f}; below 1 in {(ratios < 1).sum()}, below 0.95 in {(ratios < 0.95).sum()} of "
                f"{ratios.size}"
            )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--surfaces", nargs="+", choices=SURFACES, default=list(SURFACES))
    parser.add_argument("--pictures", type=int, default=4, help=f"of each surface and pair, at most {len(PICTURES)}")
    parser.add_argument("--drawn", type=int, help="settings at random instead, three pictures of each")
    parser.add_argument("--cache", type=Path)
    parser.add_argument("--spectra", action="store_true", help="print the falls of energy by octave alone")
    given = parser.parse_args()
    if given.spectra:
        return spectra()
    warnings.simplefilter("ignore")
    known = json.loads(given.cache.read_text()) if given.cache and given.cache.exists() else {}
    chosen = itertools.product(PICTURES[: given.pictures], given.surfaces, PAIRS)
    cases = drawn(given.drawn) if given.drawn else [(name, pair, how, RADII[0]) for how, name, pair in chosen]
    print(
        "surface   pair         R, nm pixel mean tip noise | truth  picture  estimate (95 % interval), nN", flush=True
    )
    rows = {}
    for settings in cases:
        name, pair, how, radius = settings
        key = json.dumps(settings)
        if key not in known:
            known[key] = case(*settings)
            if given.cache:
                given.cache.write_text(json.dumps(known, indent=1))
        row = rows[settings] = known[key]
        print(
            f"{name:9s} {pair:11s} {radius:6.0f} {how[0]:5d} {how[1]!s:>5s} {how[2]:3.0f} {how[3]:5.2f} | "
            f"{row['truth']:6.1f} {row['picture']:7.1f}  {row['mean']:6.1f} ({row['lower']:.1f} … {row['upper']:.1f}), "
            f"taken for {row['taken for']}{'' if row['lower'] <= row['truth'] <= row['upper'] else ', MISSED'}",
            flush=True,
        )
    parts = "truth", "picture", "mean", "lower", "upper"
    summary([settings[0] for settings in rows], [[row[part] for part in parts] for row in rows.values()])
    narrower(rows)


if __name__ == "__main__":
    main()
