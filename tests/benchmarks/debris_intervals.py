"""Coverage of 95 % intervals of the mean pull-off on surfaces with debris, by 9, 16 and 36 places.

    python tests/benchmarks/debris_intervals.py [--surfaces 24] [--trials 400]

First table, values alone: samples of several laws. Printed is the share of intervals that contain the mean, for values
alone and where it is known which values are on debris, and its share of the area.

Second table, surfaces: self-affine roughness with particles of random number, height and width under spheres of random
radius. The true mean is that of the superposed pull-off at 60 × 60 places; each trial takes a grid of some of them with
a random offset. Nothing in the package was fitted to these laws, surfaces and seeds. Some four minutes of one core.
"""

import argparse
import warnings

import numpy as np
import xarray as xr

import roughxr
from roughxr.statistics import bootstrap

#: Places along a side of the grids, and of the grid of the true mean.
SIDES = (3, 4, 6)
FINE = 60

#: Pull-off from a smooth flat over the mean without debris, where values have no surface.
SMOOTH = 40.0


def law_with_mean(draw):
    """Return a law scaled to the mean 1, by a million of its numbers."""
    mean = draw(np.random.default_rng(0), 1_000_000).mean()
    return lambda rng, size: draw(rng, size) / mean


#: Laws of the mean 1, for places off debris and on it.
LAWS = {
    "gamma, shape 4": law_with_mean(lambda rng, size: rng.gamma(4.0, 1.0, size)),
    "Weibull, shape 1.5": law_with_mean(lambda rng, size: rng.weibull(1.5, size)),
    "log-normal, 0.6": law_with_mean(lambda rng, size: rng.lognormal(0.0, 0.6, size)),
    "uniform": law_with_mean(lambda rng, size: rng.uniform(0.2, 1.8, size)),
}

#: Share of debris on the area, and its mean over that of the remaining surface.
DEBRIS = ((0.1, 10.0), (0.04, 15.0), (0.2, 4.0), (0.08, 0.3))


def covers(ds, mean):
    """Return whether the interval contains the mean (NaN without an interval), and its upper over its lower end."""
    interval = bootstrap(ds, statistics=["mean"], resamples=199).isel(statistic=0)
    low = float(interval.low)
    high = float(interval.high)
    return (float(low <= mean <= high), high / low) if np.isfinite(low) else (np.nan, np.nan)


def described(results):
    """Return coverage, the share of trials without an interval, and the median ratio of its ends, as text."""
    held, ratio = np.array(results).T
    return f"{np.nanmean(held):.2f} {np.isnan(held).mean():5.2f} {np.nanmedian(ratio):6.1f}"


def on_grid(values, on_debris, share, spacing=500.0, **pair):
    """Return values (side²,) as places of a square grid."""
    side = int(np.sqrt(values.size))
    x, y = (spacing * axis.ravel() for axis in np.mgrid[:side, :side])
    coords = {"subregion_x": ("subregion", x), "subregion_y": ("subregion", y)}
    coords |= {"on_debris": ("subregion", on_debris), "debris_share": share, **pair}
    return xr.Dataset({"pull_off_force": ("subregion", values, {"units": "nN"})}, coords)


def of_values(trials, rng):
    """Print the coverage for each law and debris."""
    pair = {"sphere_radius": SMOOTH / (1.5 * np.pi), "work_of_adhesion": 1.0}
    for (share, ratio), (name, law) in zip(DEBRIS, LAWS.items()):
        mean = 1 - share + share * ratio
        for side in SIDES:
            alone = []
            classified = []
            for _ in range(trials):
                on_debris = rng.uniform(size=side**2) < share
                values = np.where(on_debris, ratio, 1.0) * law(rng, side**2)
                ds = on_grid(values, on_debris, share, **pair)
                alone.append(covers(ds.drop_vars("debris_share"), mean))
                classified.append(covers(ds, mean))
            label = f"{name}, {100 * share:.0f} % × {ratio:g}"
            print(f"{label:>32} {side**2:>6}   {described(alone)}   {described(classified)}", flush=True)


def surface_with_particles(rng):
    """Return a random surface with particles and a pair of bodies."""
    pixel = 10.0
    pixels = 256
    rms = rng.uniform(0.5, 3.0)
    hurst = rng.uniform(0.4, 0.9)
    rolloff = rng.uniform(80.0, 400.0)
    seed = int(rng.integers(1_000_000))
    scan = roughxr.scans.synthetic.self_affine(
        (pixels, pixels), pixel, rms=rms, hurst=hurst, rolloff=rolloff, cutoff=40, seed=seed
    )
    x = scan["x"].values[:, None]
    y = scan["y"].values
    height = scan["height"].values.copy()
    for _ in range(rng.integers(1, 9)):
        centre = rng.uniform(0.0, pixel * pixels, 2)
        width = rng.uniform(20.0, 90.0)
        top = rms * rng.uniform(5.0, 12.0)
        height += top * np.exp(-(((x - centre[0]) ** 2 + (y - centre[1]) ** 2) ** 2) / width**4)
    scan = scan.assign(height=scan["height"].copy(data=height))
    radius = 10 ** rng.uniform(2.5, 3.7)
    return scan.contact.assign_pair(sphere_radius=radius, contact_modulus=40.0, work_of_adhesion=0.1)


def of_surfaces(count, trials, rng):
    """Print the coverage over surfaces and grids."""
    results = {side: ([], []) for side in SIDES}
    shares = []
    for _ in range(count):
        scan = surface_with_particles(rng)
        everywhere = scan.contact.pull_off_map(subregions=(FINE, FINE))
        mean = float(everywhere.pull_off_force.mean())
        shares.append(float(everywhere.debris_share))
        number = np.arange(FINE**2).reshape(FINE, FINE)
        for side in SIDES:
            for _ in range(max(trials // count, 1)):
                first, second = rng.integers(0, FINE // side, 2)
                at = number[first :: FINE // side, second :: FINE // side].ravel()
                places = everywhere.isel(subregion=at)
                results[side][0].append(covers(places.drop_vars("debris_share"), mean))
                results[side][1].append(covers(places, mean))
    print(f"debris on {np.median(shares):.3f} of the area (median of surfaces, {min(shares):.3f} … {max(shares):.3f})")
    for side in SIDES:
        print(f"{'surfaces':>32} {side**2:>6}   {described(results[side][0])}   {described(results[side][1])}")


def main():
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--surfaces", type=int, default=24)
    parser.add_argument("--trials", type=int, default=400)
    parser.add_argument("--seed", type=int, default=20)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    rng = np.random.default_rng(options.seed)
    print(f"{'':>32} {'places':>6}   {'values alone':<17}   with debris known: coverage, refused, ratio of the ends")
    of_values(options.trials, rng)
    of_surfaces(options.surfaces, options.trials, rng)


if __name__ == "__main__":
    main()
