"""Best estimates from coarse images of measured surfaces, against the surfaces themselves.

    python tests/benchmarks/real_below_the_pixel.py [--cache FILE] [--surfaces NAME …]

The maps are those of ``../shared/scans`` and ``../shared/scans/surfaces``: cropped, scaled alike in all directions to
pixels of some 2 nm, levelled, and cut off at a few pixels. This is the truth, with its pull-off at 3 × 3 places of a
sphere of 300 nm, glass on glass. An image is dilated by a tip of 8 nm and sampled at every 4th, 8th or 16th pixel,
with noise of 0.05 nm. A second scan is a corner of 160 pixels of the map with a tip of 5 nm.

Every image of every 4th and 8th pixel is scored with the constants of the estimate set without its surface; surfaces
count equally. The rows of the table are (a) a constant times the image, (b) `roughxr.extrapolated` of one scan, and (c)
of a second scan, once for AFM maps, on which the constants are set, once for optical ones, and once for synthetic
self-affine surfaces, without a second scan. The errors of the pair and of the choice of places are left out of truth
and intervals alike. The last line states the constants of all maps.
"""

import argparse
import json
import os
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
from roughxr.scans import UnreadableScan
from roughxr.studies import extrapolation

SCANS = Path(__file__).parents[3] / "shared" / "scans"

#: Maps of ``../shared/scans``, AFM.
FILES = {
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
FINEST = 2.0  # nm, pixels of the truth
USUAL = {"crop": 512, "at": (0, 0), "levelling": ("plane",), "end_pixels": 3, "radius": 300.0, "kind": "AFM"}

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

#: Pixels of the truth in one of an image: all, and those that are scored.
PIXELS = (4, 8, 16)
SCORED = (4, 8)

TIP = 8.0  # nm
NOISE = 0.05  # nm
CORNER_PIXELS = 160
CORNER_TIP = 5.0  # nm
GRID = (3, 3)

#: Confidence of the interval score.
CONFIDENCE = 0.95

TOLERANCE = {"xatol": 1e-3, "fatol": 1e-4, "maxiter": 2000}


def surfaces():
    """Return the definition of each surface by name."""
    table = {name: USUAL | {"file": SCANS / file} for name, file in FILES.items()}
    stored = json.loads((SCANS / "surfaces" / "surfaces.json").read_text())
    table |= {row["file"].split(".")[0]: row | {"file": SCANS / "surfaces" / row["file"]} for row in stored}
    made = {"kind": "self-affine", "radius": USUAL["radius"]}
    return table | {name: made | {"heights": form, "seed": k} for k, (name, form) in enumerate(SELF_AFFINE.items())}


def heights_and_pixel(path):
    """Return heights and pixel (nm) of a file, by another reader where roughxr has none."""
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
    heights, pixel = heights_and_pixel(how["file"])
    scale = how.get("scale") or min(1.0, FINEST / pixel)
    first, second = how["at"]
    heights = heights[first : first + how["crop"], second : second + how["crop"]] * scale
    nearest = distance_transform_edt(~np.isfinite(heights), return_indices=True)[1]
    axes = {axis: (axis, pixel * scale * np.arange(n), {"units": "nm"}) for axis, n in zip("xy", heights.shape)}
    scan = xr.Dataset({"height": (("x", "y"), heights[tuple(nearest)], {"units": "nm"})}, axes)
    for form in how["levelling"]:
        scan = roughxr.level(scan, method=form)
    end = how["end_pixels"] * pixel * scale
    return roughxr.scans.smooth(scan, shortest=end), end


def self_affine_surface(rms, hurst, rolloff, seed):
    """Return a synthetic surface with its shortest wavelength (nm)."""
    end = USUAL["end_pixels"] * FINEST
    form = {"rms": rms, "hurst": hurst, "rolloff": rolloff, "cutoff": end, "seed": seed}
    return roughxr.level(roughxr.scans.synthetic.self_affine((SIDE, SIDE), FINEST, **form)), end


def picture(surface, pixels, averaged=False, tip=TIP, noise=NOISE, *, seed=1):
    """Return a surface as a microscope shows it, on pixels of so many of its own."""
    dilated = roughxr.scans.dilate(surface, tip_radius=tip)
    if averaged:
        shown = dilated.coarsen(x=pixels, y=pixels, boundary="trim").mean()
    else:
        shown = dilated.isel(x=slice(pixels // 2, None, pixels), y=slice(pixels // 2, None, pixels))
    return shown.assign(height=shown.height + np.random.default_rng(seed).normal(0, noise, shown.height.shape))


def second_scan(surface):
    """Return a finer scan of a corner of the surface."""
    side = min(CORNER_PIXELS, min(surface.height.shape) // 2)
    return picture(surface.isel(x=slice(side), y=slice(side)), 1, tip=CORNER_TIP, seed=5)


class Solved:
    """Results of the maps, each computed once and stored in a file if there is one."""

    def __init__(self, path):
        self.path = path
        self.results = json.loads(path.read_text()) if path and path.exists() else {}

    def get(self, key, compute, *arguments):
        """Return a stored result, or compute and store it."""
        if key not in self.results:
            self.results[key] = compute(*arguments)
            print(key, np.round(np.mean(self.results[key]), 3), flush=True)
            if self.path:
                self.path.write_text(json.dumps(self.results))
        return self.results[key]


class Row(NamedTuple):
    """An image of a surface."""

    pixels: int
    longest: float  # nm, of the unseen wavelengths: two pixels
    end: float  # nm, the shortest wavelength of the surface
    lowering: float  # ln(smooth flat / image), of pull-offs
    log: float  # ln(truth / image)
    second: float  # ln(factor) by the second scan
    error: float  # of it, by the scatter of its places
    scatter: float  # relative standard deviation over places, over that of the truth


def rows_of(name, how, solved):
    """Return the images of a surface."""
    surface, end = true_surface(how)
    pixel = float(surface.x[1] - surface.x[0])
    places = roughxr.scans.regions.centres(picture(surface, 8), GRID)

    def simulated(pixels=None):
        scan = surface if pixels is None else picture(surface, pixels)
        pair = (
            scan[["height"]].reset_coords(drop=True).contact.assign_pair(sphere_radius=how["radius"], materials="glass")
        )
        return roughxr.adhesive(pair, subregions=places).pull_off_force.values.tolist()

    def by_second_scan(pixels):
        image = picture(surface, pixels).contact.assign_pair(sphere_radius=how["radius"], materials="glass")
        try:
            return extrapolation.second_scan_ratio(image, second_scan(surface), "exponential")
        except ValueError as reason:
            print(f"{name}, every {pixels}th pixel, refused: {reason}")
            return np.nan, np.nan

    pair = surface.contact.assign_pair(sphere_radius=how["radius"], materials="glass")
    smooth = roughxr.statistics.smooth_pull_off(pair.assign_attrs(law="exponential"))
    at_places = np.array(solved.get(f"{name}/truth", simulated))
    truth = np.nanmean(at_places)
    is_measured = how["kind"] != "self-affine"
    out = []
    for pixels in PIXELS if is_measured else SCORED:
        shown = np.array(solved.get(f"{name}/{pixels}", simulated, pixels))
        image = np.nanmean(shown)
        scatter = np.nanstd(shown / image) / np.nanstd(at_places / truth)
        factor = (np.nan, np.nan)
        if pixels in SCORED and is_measured:
            factor = solved.get(f"{name}/{pixels}/second", by_second_scan, pixels)
        lowering = max(float(np.log(smooth / image)), 0.0)
        out.append(
            Row(pixels, 2 * pixels * pixel, end, lowering, float(np.log(truth / image)), *factor, float(scatter))
        )
    return out


class Constants(NamedTuple):
    """The constants of the estimate."""

    fall: float
    missed: float  # 1/nm
    scatter: float
    least_second: float  # of a second scan
    second: float

    def factor(self, row):
        """Return ln(factor) and its standard deviation for an image."""
        part = 1 - row.end / row.longest
        deviation = part * np.hypot(self.missed * row.longest, self.scatter * row.lowering)
        return -self.fall * part * row.lowering, deviation

    def second_error(self, row):
        """Return the standard deviation of ln(factor) by a second scan."""
        return np.hypot(row.error, np.hypot(self.least_second, self.second * row.lowering))


def fitted(rows):
    """Return the most likely constants of the images of some surfaces, each surface counted once.

    The scatter is widened for the number of surfaces, as an interval of Student's t for another surface is.
    """
    wide = widening(len(rows))

    def one_scan(parameters):
        fall, *logs = parameters
        return Constants(fall, *(wide * np.exp(logs)), np.nan, np.nan)

    def second_scan(parameters):
        return Constants(np.nan, np.nan, np.nan, *(wide * np.exp(parameters)))

    with_scan = most_likely(rows, one_scan, [0.3, *np.log([0.008, 0.4])], lambda constants, row: constants.factor(row))
    start = np.log([0.15, 0.2])
    second = most_likely(rows, second_scan, start, lambda constants, row: (row.second, constants.second_error(row)))
    return with_scan._replace(least_second=second.least_second, second=second.second)


def most_likely(rows, constants_of, start, estimate):
    """Return the constants whose estimates of all images, ln(factor) and its deviation, are most likely.

    The deviations of ``constants_of`` are widened; those of the likelihood are not.
    """
    wide = widening(len(rows))

    def misfit(parameters):
        constants = constants_of(parameters)
        total = 0.0
        for rows_of_surface in rows.values():
            logs, deviations = np.transpose([estimate(constants, row) for row in rows_of_surface])
            deviations = deviations / wide
            off = (np.array([row.log for row in rows_of_surface]) - logs) / deviations
            total += np.nanmean(np.log(deviations) + 0.5 * off**2)
        return total

    return constants_of(minimize(misfit, start, method="Nelder-Mead", options=TOLERANCE).x)


def widening(count):
    """Return the factor on a standard deviation of so many values with which a normal interval holds another one."""
    quantile = 0.5 + CONFIDENCE / 2
    return float(t.ppf(quantile, count - 1) / norm.ppf(quantile) * np.sqrt((count + 1) / (count - 1)))


def estimates(rows, others):
    """Return ln(estimate / truth) and its stated deviation, for each way and image of one surface.

    The constants are set on the other surfaces.
    """
    constants = fitted(others)
    logs = [
        np.mean([row.log for row in rows_of_surface if row.pixels in SCORED]) for rows_of_surface in others.values()
    ]
    constant = np.mean(logs)
    spread = np.std(logs) * widening(len(logs))
    out = {"a constant": [], "one scan": [], "second scan": []}
    for row in rows:
        log, error = constants.factor(row)
        out["a constant"].append((constant - row.log, spread))
        out["one scan"].append((log - row.log, error))
        if np.isnan(row.second):  # refused
            continue
        errors = np.array([error, constants.second_error(row)])
        combined, deviation = (np.average(values, weights=errors**-2) for values in ([log, row.second], errors))
        out["second scan"].append((combined - row.log, deviation))
    return out


def scores(results):
    """Return the scores of (surface, image) results (ln error, deviation), each surface counted once."""
    columns = []
    for result in results:
        error, deviation = np.transpose(result)
        half = norm.ppf(0.5 + CONFIDENCE / 2) * deviation
        missed = np.maximum(np.abs(error) - half, 0.0)
        inside = [np.mean(np.abs(error) < norm.ppf(0.5 + share / 2) * deviation) for share in (0.5, 0.8, 0.95)]
        score = 2 * half + 2 / (1 - CONFIDENCE) * missed
        columns.append([np.mean(error**2), np.mean(error), *inside, np.mean(half), np.mean(score)])
    square, bias, *shares, half, score = np.mean(columns, axis=0)
    return [np.sqrt(square), np.exp(bias), *shares, np.exp(half), score]


def print_scores(title, rows, training):
    """Print a table of scores of some surfaces, the constants set on the others of the training maps."""
    print(f"\n{len(rows)} {title}")
    ratios = np.log([row.scatter for rows_of_surface in rows.values() for row in rows_of_surface])
    mean, *ends = np.exp([ratios.mean(), *np.quantile(ratios, [0.1, 0.9])])
    print(f"scatter over places, image / truth: {mean:.2f} (80 %: {ends[0]:.2f} … {ends[1]:.2f})")
    print("estimate        rms of ln  bias  in 50 %  80 %  95 %  half width  interval score")
    estimated = {name: estimates(rows[name], {k: v for k, v in training.items() if k != name}) for name in rows}
    for way in ("a constant", "one scan", "second scan"):
        results = [result[way] for result in estimated.values() if result[way]]
        if not results:
            continue
        rms, bias, *shares, half, score = scores(results)
        inside = "  ".join(f"{share:4.0%}" for share in shares)
        print(f"{way:15s} {rms:9.2f}  {bias:4.2f}  {inside:>20s}  × {half:8.2f}  {score:14.2f}", flush=True)


def main():
    warnings.simplefilter("ignore")
    table = surfaces()
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--surfaces", nargs="+", choices=table, default=list(table))
    parser.add_argument("--cache", type=Path, help="a file of solved maps")
    arguments = parser.parse_args()
    solved = Solved(arguments.cache)
    rows = {}
    for name in arguments.surfaces:
        rows[name] = rows_of(name, table[name], solved)
    print("\nln(truth / image) at every 4th, 8th, 16th pixel; by a second scan, every 4th and 8th")
    for name, rows_of_surface in rows.items():
        logs = "  ".join(f"{row.log:6.2f}" for row in rows_of_surface)
        print(
            f"{name:22s} {logs}  | "
            + "  ".join(f"{row.second:6.2f}" for row in rows_of_surface if row.pixels in SCORED)
        )
    training = {name: rows_of_surface for name, rows_of_surface in rows.items() if table[name]["kind"] == "AFM"}
    if not training:
        return
    scored = {name: [row for row in rows_of_surface if row.pixels in SCORED] for name, rows_of_surface in rows.items()}
    for kind in ("AFM", "optical", "self-affine"):
        chosen = {name: rows_of_surface for name, rows_of_surface in scored.items() if table[name]["kind"] == kind}
        if chosen:
            print_scores(f"{kind} surfaces", chosen, training)
    print("\nconstants of all AFM maps:", ", ".join(f"{k} {v:.2f}" for k, v in fitted(training)._asdict().items()))


if __name__ == "__main__":
    main()
