"""Best estimates from coarse images of measured surfaces, against the surfaces themselves.

    python tests/benchmarks/real_below_the_pixel.py [--cache FILE] [--maps FOLDER] [--surfaces NAME …] [--varied CASE …]

The maps are listed in ``measured_surfaces.json`` with their sources; those that FOLDER lacks are downloaded there.
Each is cropped, scaled alike in all directions (its scale is printed; 1 is native), levelled, and cut off at a few
pixels. This is the truth, with its pull-off at 3 × 3 places of a sphere of 300 nm, glass on glass. An image is dilated
by a tip of 8 nm and sampled at every 4th, 8th or 16th pixel, with noise of 0.05 nm: two, three and four octaves of
pixels are unseen. A second scan is a corner of 160 pixels of the map with a tip of 5 nm, noise of 0.05 or 0.2 nm.

The first table scores one scan, each surface by numbers set on the other AFM maps: the image as it is, 0.65 of it, a
constant with a symmetric width (a), two ends by a split normal distribution (b), the same about a regression on the
pixel series (c), and the ends of `roughxr.extrapolated` set anew: the least interval score over all octaves, times a
factor for surfaces that are harder than all of these; then the same without each of their constants. The interval
score is the width plus 40 times what lies outside, in ln. The second table scores the second scan, the third states
its widths and doubts before a solve, and the last, with ``--varied``, other radii and another pair.
The errors of the pair and of the choice of places are left out of truth and intervals alike.
"""

import argparse
import hashlib
import itertools
import json
import os
import urllib.request
import warnings
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import xarray as xr
from scipy.ndimage import distance_transform_edt
from scipy.optimize import minimize
from scipy.stats import norm, t

import roughxr
from roughxr.mechanics.studies import extrapolation
from roughxr.mechanics.studies.finer_scan import second_scan
from roughxr.mechanics.vocabulary.error_sources import HALF_WIDTH, SECOND_SCAN_PIXEL
from roughxr.scans import ImplausibleScan, UnreadableScan

MAPS = Path(__file__).parents[3] / "shared" / "scans"
LIST = Path(__file__).with_name("measured_surfaces.json")

FINEST = 2.0  # nm, pixels of a truth without a stated scale
RADIUS = 300.0  # nm

#: Root mean square height (nm), Hurst exponent and roll-off wavelength (nm) of self-affine surfaces.
SELF_AFFINE = {
    "smooth": (0.5, 0.8, 150.0),
    "usual": (1.5, 0.8, 150.0),
    "wide": (3.0, 0.8, 400.0),
    "jagged": (1.0, 0.5, 150.0),
    "high": (4.0, 0.7, 250.0),
    "gentle": (2.0, 0.9, 400.0),
}
SIDE = 256  # pixels of a self-affine surface
END_PIXELS = 3

#: Pixels of the truth in one of an image, and of an image with a second scan.
PIXELS = (4, 8, 16)
WITH_SECOND = (8, 4)

TIP = 8.0  # nm
NOISE = 0.05  # nm
SECOND_NOISE = (0.05, 0.2)  # nm
DOOR_NOISE = (0.05, 0.1, 0.2)  # nm
CORNER_PIXELS = 160
CORNER_TIP = 5.0  # nm
GRID = (3, 3)

#: Surfaces, and radii (nm) or pairs, of the third table.
VARIED = ("grains", "di-5", "di-2", "titanate", "stp-1", "lbl_PE13_1", "rough", "veeco")
PAIRS = {
    "R1000": (1000.0, "glass"),
    "R100": (100.0, "glass"),
    "R3000": (3000.0, "glass"),
    "polymer": (RADIUS, ("polystyrene", "silicon")),
}

CONFIDENCE = 0.95

#: Factor on the ends that hold all other surfaces, for one that is harder.
HARDER = 1.2


def surfaces(folder=MAPS):
    """Return the definition of each surface by name."""
    table = json.loads(LIST.read_text())
    table = {name: row | {"radius": RADIUS, "file": Path(folder) / row["file"]} for name, row in table.items()}
    made = {"kind": "self-affine", "radius": RADIUS}
    return table | {name: made | {"heights": form, "seed": k} for k, (name, form) in enumerate(SELF_AFFINE.items())}


def obtained(how):
    """Return whether the map of the list is in its folder; download it if not, and print why it cannot be used."""
    path = how["file"]
    source = f"https://raw.githubusercontent.com/{how['repository']}/{how['commit']}/{how['path']}"
    if not path.exists():
        try:
            with urllib.request.urlopen(source, timeout=60) as answer:
                contents = answer.read()
        except OSError as reason:
            print(f"{path.name}: left out: {source}: {reason}")
            return False
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(contents)
    is_same = hashlib.sha256(path.read_bytes()).hexdigest() == how["sha256"]
    if not is_same:
        print(f"{path.name}: left out: not the file of the list")
    return is_same


def heights_and_pixel(how):
    """Return heights and pixel (nm) of a map, by another reader where roughxr has none."""
    path = how["file"]
    if "width" in how:  # a text of heights in m
        heights = np.loadtxt(path, comments="#").T * 1e9
        return heights, how["width"] / heights.shape[0]
    try:
        scan = roughxr.open_scan(path).load()
        return scan["height"].transpose("x", "y").values.astype(float), float(scan.x[1] - scan.x[0])
    except UnreadableScan:
        from SurfaceTopography import open_topography

        topography = open_topography(str(path)).topography().to_unit("nm")
        return np.ma.filled(topography.heights().astype(float), np.nan), topography.pixel_size[0]


def true_surface(how):
    """Return a map as a surface of known heights, with its shortest wavelength (nm)."""
    if how["kind"] == "self-affine":
        return self_affine_surface(*how["heights"], how["seed"])
    heights, pixel = heights_and_pixel(how)
    scale = how["scale"] or min(1.0, FINEST / pixel)
    first, second = how["at"]
    heights = heights[first : first + how["crop"], second : second + how["crop"]] * scale
    nearest = distance_transform_edt(~np.isfinite(heights), return_indices=True)[1]
    axes = {axis: (axis, pixel * scale * np.arange(n), {"units": "nm"}) for axis, n in zip("xy", heights.shape)}
    scan = xr.Dataset({"height": (("x", "y"), heights[tuple(nearest)], {"units": "nm"})}, axes)
    for form in how["levelling"]:
        scan = roughxr.level(scan, method=form)
    end = how["end_pixels"] * pixel * scale
    return roughxr.scans.smooth(scan, shortest=end).assign_attrs(scale=scale), end


def self_affine_surface(rms, hurst, rolloff, seed):
    """Return a synthetic surface with its shortest wavelength (nm)."""
    end = END_PIXELS * FINEST
    form = {"rms": rms, "hurst": hurst, "rolloff": rolloff, "cutoff": end, "seed": seed}
    return roughxr.level(roughxr.scans.synthetic.self_affine((SIDE, SIDE), FINEST, **form)), end


def every(scan, pixels):
    """Return every so many pixels of a scan."""
    return scan.isel(x=slice(pixels // 2, None, pixels), y=slice(pixels // 2, None, pixels))


def picture(surface, pixels, tip=TIP, noise=NOISE, *, seed=1):
    """Return a surface as a microscope shows it, on pixels of so many of its own."""
    return sampled(roughxr.scans.dilate(surface, tip_radius=tip), pixels, noise, seed)


def sampled(dilated, pixels, noise=NOISE, seed=1):
    """Return what a tip touches on pixels of so many of its own, with noise."""
    shown = every(dilated, pixels)
    return shown.assign(height=shown.height + np.random.default_rng(seed).normal(0, noise, shown.height.shape))


def corner(surface, noise=NOISE):
    """Return a finer scan of a corner of the surface."""
    side = min(CORNER_PIXELS, min(surface.height.shape) // 2)
    return picture(surface.isel(x=slice(side), y=slice(side)), 1, tip=CORNER_TIP, noise=noise, seed=5)


class Solved:
    """Results of the maps, each computed once and stored in a file if there is one."""

    def __init__(self, path):
        self.path = path
        self.results = json.loads(path.read_text()) if path and path.exists() else {}

    def get(self, key, compute, *arguments):
        """Return a stored result, or compute and store it."""
        if key not in self.results:
            self.results[key] = compute(*arguments)
            print(key, flush=True)
            if self.path:
                self.path.write_text(json.dumps(self.results))
        return self.results[key]


class Row(NamedTuple):
    """An image of a surface."""

    pixels: int
    octaves: float  # unseen, as shipped
    without_least: float  # the same without the fewest octaves that tip and noise hide
    alike: float  # the same where those below the tested wavelengths count as those above
    log: float  # ln(truth / image)
    series: float  # ln(image / every second pixel of it)


class SecondRow(NamedTuple):
    """An image of a surface with a second scan."""

    pixels: int
    noise: float  # nm
    off: float  # ln(ratio of the second scan / truth over image)
    error: float  # ln(estimate / truth)
    below: float  # distances from the ends of the estimate's interval
    above: float


class DoorRow(NamedTuple):
    """An image of a surface with a second scan, before a pull-off is solved."""

    pixels: int
    noise: float  # nm
    width: float  # of the interval of the factor at the default end, in ln
    promised: float  # the same as promised before
    one_scan: float  # the same without the second scan
    is_doubted: bool
    is_doubted_inverted: bool


def is_doubted(image, finer):
    """Return whether a second scan is doubted or refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", ImplausibleScan)
        try:
            second_scan(image, finer)
        except (ImplausibleScan, ValueError):
            return True
    return False


def simulated(scan, places, radius, materials):
    """Return the mean pull-off, and that of each place; None where the simulation refuses."""
    pair = scan[["height"]].reset_coords(drop=True).contact.assign_pair(sphere_radius=radius, materials=materials)
    try:
        forces = roughxr.adhesive(pair, subregions=places).pull_off_force.values
    except ValueError as reason:
        return {"error": str(reason)}
    return {"mean": float(np.nanmean(forces)), "each": forces.tolist()}


def counted_octaves(longest, end):
    """Return unseen octaves without the fewest that tip and noise hide."""
    least = extrapolation._FEWEST_OCTAVES
    extrapolation._FEWEST_OCTAVES = 0.0
    try:
        return extrapolation.unseen_octaves(longest, end)
    finally:
        extrapolation._FEWEST_OCTAVES = least


class Surface:
    """A measured surface, its images and its results."""

    def __init__(self, name, how, solved):
        self.name = name
        self.surface, self.end = true_surface(how)
        self.pixel = float(self.surface.x[1] - self.surface.x[0])
        self.dilated = roughxr.scans.dilate(self.surface, tip_radius=TIP)
        self.places = roughxr.scans.regions.centres(sampled(self.dilated, 8), GRID)
        self.solved = solved

    def mean(self, key, scan, radius=RADIUS, materials="glass", places=None):
        """Return a mean pull-off, NaN where the simulation refuses; ``scan`` is a function that returns the scan."""
        places = self.places if places is None else places
        result = self.solved.get(f"{self.name}{key}", lambda: simulated(scan(), places, radius, materials))
        return result.get("mean", np.nan)

    def rows(self, case="", radius=RADIUS, materials="glass"):
        """Return the images."""
        tag = f"@{case}" if case else ""
        how = (radius, materials)
        truth = self.mean(f"{tag}/truth", lambda: self.surface, *how)
        out = []
        for pixels in PIXELS:
            image = self.mean(f"{tag}/{pixels}", lambda k=pixels: sampled(self.dilated, k), *how)
            coarser = np.nan
            if not case:
                coarser = self.mean(f"/{pixels}/2", lambda k=pixels: every(sampled(self.dilated, k), 2), *how)
            longest = 2 * pixels * self.pixel
            octaves = extrapolation.unseen_octaves(longest, self.end)
            alike = max(float(np.log2(longest / self.end)), extrapolation._FEWEST_OCTAVES)
            counts = octaves, counted_octaves(longest, self.end), alike
            out.append(Row(pixels, *counts, float(np.log(truth / image)), float(np.log(image / coarser))))
        return out

    def paired(self, pixels):
        """Return an image with the pair."""
        return sampled(self.dilated, pixels).contact.assign_pair(sphere_radius=RADIUS, materials="glass")

    def second_rows(self):
        """Return the images with a second scan."""
        out = []
        truth = self.mean("/truth", lambda: self.surface)
        for noise in SECOND_NOISE:
            finer = corner(self.surface, noise)
            places = roughxr.scans.regions.centres(finer, GRID)
            for pixels in WITH_SECOND if noise == NOISE else WITH_SECOND[:1]:
                image = sampled(self.dilated, pixels)
                try:
                    second = second_scan(self.paired(pixels), finer)
                except ValueError as reason:
                    print(f"{self.name}, every {pixels}th pixel, refused: {reason}")
                    continue
                scans = {"": second.finer} | {
                    f"/{pixels}/{phase}": shown for phase, shown in zip((0.25, 0.75), second.as_shown)
                }
                keys = [f"/second{noise}{key}" for key in scans]
                for key, scan in zip(keys, scans.values()):
                    self.mean(key, lambda scan=scan: scan, places=places)
                results = [self.solved.results[self.name + key] for key in keys]
                if any("error" in result for result in results):
                    continue
                fine, *shown = (np.array(result["each"], float).ravel() for result in results)
                adheres = np.isfinite([fine, *shown]).all(axis=0)
                ratio = float(np.log(fine[adheres].mean() / np.mean(shown, axis=0)[adheres].mean()))
                log = np.log(truth / self.mean(f"/{pixels}", lambda scan=image: scan))
                longest = 2 * pixels * self.pixel
                with_second = extrapolation.second_scan_factor(ratio, longest, second.shown_wavelength, self.end)
                ends = HALF_WIDTH * with_second.error.below, HALF_WIDTH * with_second.error.above
                out.append(SecondRow(pixels, noise, ratio - log, with_second.log - log, *ends))
        return out

    def door_rows(self):
        """Return the images with a second scan, before a pull-off is solved."""
        out = []
        end = extrapolation._SHORTEST_WAVELENGTH
        for pixels, noise in itertools.product(WITH_SECOND, DOOR_NOISE):
            image = self.paired(pixels)
            finer = corner(self.surface, noise)
            longest = 2 * pixels * self.pixel
            try:
                shown = second_scan(image, finer).shown_wavelength
            except ValueError:
                continue
            factors = (
                extrapolation.second_scan_factor(0.0, longest, shown, end),
                extrapolation.second_scan_factor(0.0, longest, 2 * SECOND_SCAN_PIXEL, end),
                extrapolation.one_scan_factor(extrapolation.unseen_octaves(longest, end)),
            )
            widths = [2 * HALF_WIDTH * factor.error.std for factor in factors]
            doubts = [is_doubted(image, finer.assign(height=sign * finer.height)) for sign in (1, -1)]
            out.append(DoorRow(pixels, noise, *widths, *doubts))
        return out


class Ends(NamedTuple):
    """An interval of ln(truth / image)."""

    low: float
    centre: float
    high: float


def widening(count):
    """Return the factor on a standard deviation of so many values with which a normal interval holds another one."""
    quantile = 0.5 + CONFIDENCE / 2
    return float(t.ppf(quantile, count - 1) / norm.ppf(quantile) * np.sqrt((count + 1) / (count - 1)))


def symmetric(logs):
    """Return the ends by a normal distribution."""
    half = norm.ppf(0.5 + CONFIDENCE / 2) * np.std(logs) * widening(len(logs))
    return Ends(np.mean(logs) - half, np.mean(logs), np.mean(logs) + half)


def split_normal(logs):
    """Return the ends by the most likely distribution of two half normals."""
    logs = np.asarray(logs)

    def misfit(parameters):
        mode, below, above = parameters[0], *np.exp(parameters[1:])
        return np.sum(np.log(below + above) + 0.5 * ((logs - mode) / np.where(logs < mode, below, above)) ** 2)

    starts = ([mode, np.log(logs.std() + 0.05), np.log(0.1)] for mode in (logs.max(), np.median(logs), 0.0))
    options = {"xatol": 1e-4, "fatol": 1e-6, "maxiter": 4000}
    best = min(
        (minimize(misfit, start, method="Nelder-Mead", options=options) for start in starts), key=lambda x: x.fun
    )
    mode = best.x[0]
    below, above = np.exp(best.x[1:]) * widening(logs.size)
    share = below / (below + above)

    def quantile(p):
        if p < share:
            return mode + below * norm.ppf(0.5 * p / share)
        return mode + above * norm.ppf(0.5 + 0.5 * (p - share) / (1 - share))

    return Ends(*(quantile(p) for p in (0.5 - CONFIDENCE / 2, 0.5, 0.5 + CONFIDENCE / 2)))


def on_series(rows, row):
    """Return the ends about a regression on the pixel series."""
    series, logs = np.array([(other.series, other.log) for other in rows]).T
    slope, offset = np.polyfit(series, logs, 1)
    centre = offset + slope * row.series
    return Ends(*(centre + end for end in split_normal(logs - offset - slope * series)))


def least_score(sizes, distances):
    """Return the factor on sizes of least interval score for distances that lie outside beyond them."""
    factors = np.unique(np.clip(distances / sizes, 0, None))
    missed = np.maximum(distances[:, None] - sizes[:, None] * factors, 0.0).sum(axis=0)
    return float(factors[np.argmin(sizes.sum() * factors + 2 / (1 - CONFIDENCE) * missed)])


class Constants(NamedTuple):
    """The ends of one scan by unseen octaves."""

    centre: float  # for each octave
    lowest: float  # for each octave
    highest: float
    count: str  # of octaves, a field of `Row`

    def ends(self, row):
        """Return the ends for an image."""
        octaves = getattr(row, self.count)
        return Ends(self.lowest * octaves, self.centre * octaves, self.highest)


def fitted(rows, harder=HARDER, count="octaves"):
    """Return the constants of images of some surfaces."""
    octaves, logs = np.array([(getattr(row, count), row.log) for row in rows]).T  # of all images
    centre = float((octaves * logs).sum() / (octaves**2).sum())
    lowest = -harder * least_score(octaves, -logs)
    return Constants(centre, lowest, harder * least_score(np.ones(logs.size), logs), count)


#: Arguments of `fitted` by what is left out of what is shipped.
LEFT_OUT = {
    "unseen octaves": {},
    f"- ends not times {HARDER:g}": {"harder": 1.0},
    f"- no least of {extrapolation._FEWEST_OCTAVES:g} octaves": {"count": "without_least"},
    "- all octaves count alike": {"count": "alike"},
}


def score(ends, log):
    """Return the interval score."""
    missed = max(ends.low - log, 0.0) + max(log - ends.high, 0.0)
    return ends.high - ends.low + 2 / (1 - CONFIDENCE) * missed


def print_one_scan(title, rows, training):
    """Print the scores of one scan on some surfaces, with the numbers set on the others of the training maps."""
    print(f"\nOne scan: {title}, {len(rows)}")
    print("pixels  estimate                      rms of ln  inside  width  interval score")
    for at, pixels in enumerate(PIXELS):
        results = {}
        for name, images in rows.items():
            row = images[at]
            all_others = [other for other_name, other in training.items() if other_name != name]
            rows_of_others = list(itertools.chain(*all_others))
            others = [images_of_other[at] for images_of_other in all_others]
            logs = [other.log for other in others]
            ways = {
                "(a) a constant, symmetric": symmetric(logs),
                "(b) two ends": split_normal(logs),
                "(c) two ends, pixel series": on_series(others, row),
            }
            ways |= {way: fitted(rows_of_others, **arguments).ends(row) for way, arguments in LEFT_OUT.items()}
            for constant in (1.0, 0.65):
                results.setdefault(f"{constant:g} of the image", []).append((np.log(constant) - row.log, *[np.nan] * 3))
            for way, ends in ways.items():
                inside = ends.low <= row.log <= ends.high
                result = (ends.centre - row.log, inside, ends.high - ends.low, score(ends, row.log))
                results.setdefault(way, []).append(result)
        for way, values in results.items():
            error, inside, width, total = np.transpose(values)
            rms = np.sqrt(np.mean(error**2))
            text = "" if np.isnan(inside).any() else f"{inside.sum():4.0f}  {width.mean():5.2f}  {total.mean():6.2f}"
            print(f"{pixels:6d}  {way:28s}  {rms:9.2f}  {text}", flush=True)


def by_conditions(rows):
    """Return the rows of all surfaces by pixels and noise."""
    out = {}
    for row in itertools.chain(*rows.values()):
        out.setdefault((row.pixels, row.noise), []).append(row)
    return out


def print_second_scan(rows):
    """Print the scores of the second scan."""
    print("\nSecond scan, with the shipped constants")
    print("pixels  noise nm  surfaces  rms of ln(ratio)  rms of ln(estimate)  inside")
    for (pixels, noise), chosen in by_conditions(rows).items():
        rms = [np.sqrt(np.mean([getattr(row, name) ** 2 for row in chosen])) for name in ("off", "error")]
        inside = sum(-row.above <= row.error <= row.below for row in chosen)
        print(f"{pixels:6d}  {noise:8g}  {len(chosen):8d}  {rms[0]:16.2f}  {rms[1]:19.2f}  {inside:6d}")


def print_door(rows):
    """Print how many second scans keep the promised width, narrow the interval, and are doubted."""
    print("\nSecond scan, before a pull-off is solved: interval at the default end, and doubts")
    print("pixels  noise nm  surfaces  as promised  below 0.8 × one scan  doubted  doubted upside down")
    for (pixels, noise), chosen in by_conditions(rows).items():
        promised = sum(abs(row.promised / row.width - 1) <= 0.1 for row in chosen)
        narrower = sum(row.width <= 0.8 * row.one_scan for row in chosen)
        doubted = sum(row.is_doubted for row in chosen)
        inverted = sum(row.is_doubted_inverted for row in chosen)
        counts = f"{promised:11d}  {narrower:20d}  {doubted:7d}  {inverted:19d}"
        print(f"{pixels:6d}  {noise:8g}  {len(chosen):8d}  {counts}", flush=True)


def main():
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--surfaces", nargs="+", help="names of the list; default: all")
    parser.add_argument("--maps", type=Path, default=MAPS, help="folder of the maps")
    parser.add_argument("--cache", type=Path, help="a file of solved maps")
    parser.add_argument("--varied", nargs="*", choices=PAIRS, help="other radii and another pair, too; default: all")
    arguments = parser.parse_args()
    table = {name: how for name, how in surfaces(arguments.maps).items() if how["kind"] != "self-affine"}
    names = [name for name in arguments.surfaces or table if obtained(table[name])]
    solved = Solved(arguments.cache)
    rows = {}
    scales = {}
    second = {}
    door = {}
    cases = [] if arguments.varied is None else arguments.varied or list(PAIRS)
    varied = {case: {} for case in cases}
    print("map                        kind     scale  end nm  ln(truth / image) at every 4th, 8th, 16th pixel")
    for name in names:
        surface = Surface(name, table[name], solved)
        rows[name] = surface.rows()
        second[name] = surface.second_rows()
        door[name] = surface.door_rows()
        for case in cases:
            if name in VARIED:
                varied[case][name] = surface.rows(case, *PAIRS[case])
        logs = "  ".join(f"{row.log:6.2f}" for row in rows[name])
        scales[name] = surface.surface.attrs["scale"]
        print(f"{name:26s} {table[name]['kind']:7s}  {scales[name]:.2g}  {surface.end:6.1f}  {logs}", flush=True)
    training = {name: images for name, images in rows.items() if table[name]["kind"] == "AFM"}
    native = {name: images for name, images in training.items() if scales[name] == 1}
    optical = {name: images for name, images in rows.items() if name not in training}
    print_one_scan("all AFM maps", training, training)
    print_one_scan("native AFM maps", native, training)
    print_one_scan("shrunk AFM maps", {name: training[name] for name in training if name not in native}, training)
    print_one_scan("optical maps", optical, training)
    for case, images in varied.items():
        if images:
            print_varied(case, images, training)
    print_second_scan({name: second[name] for name in training})
    print_door({name: door[name] for name in training})
    shipped = fitted(list(itertools.chain(*training.values())))
    print(f"\nconstants of all AFM maps: {', '.join(f'{value:.2f}' for value in shipped[:3])}")


def print_varied(case, rows, training):
    """Print how many truths of another radius or pair lie inside the ends set on all other surfaces."""
    inside = []
    for name, images in rows.items():
        others = (other for other_name, other in training.items() if other_name != name)
        constants = fitted(list(itertools.chain(*others)))
        solved_images = [row for row in images if np.isfinite(row.log)]
        inside += [constants.ends(row).low <= row.log <= constants.ends(row).high for row in solved_images]
    rms = [np.sqrt(np.nanmean([images[at].log ** 2 for images in rows.values()])) for at in range(len(PIXELS))]
    texts = "  ".join(f"{value:.2f}" for value in rms)
    print(f"\n{case}: {sum(inside)} of {len(inside)} inside; rms of ln(truth / image) by pixels {texts}")


if __name__ == "__main__":
    main()
