"""Rock'n'Roll and computed adhesion beside the runs of Reeks & Hall (2001): nothing is tuned on them.

    python tests/benchmarks/reeks_hall.py [MEASURED.csv [PICTURE.png]] [--pixels 768]

MEASURED.csv has the columns run, diameter_um, friction_velocity_m_s and fraction_remaining: alumina spheres left on a
polished steel floor after 1 s in air. Without it the models stand alone. Each curve is told by the friction velocity
that half of the particles stand and by its spread: the best log-normal law through its points.

1. Rock'n'Roll to the letter with Biasi's reduction, whose numbers were fitted to such experiments, these among them.
2. The same with adhesion computed on synthetic ground, drag and lift and the lever r/100 as before.
3. Adhesion, lever, drag and torque all computed: `rolling` and `resuspension`, with particles where they landed.
4. The same with particles where they came to rest: `resting`.

The floor's topography was not published. Ground here is self-affine, as polished metal is often described: rms height
5, 20 and 50 nm over waves up to 10 µm, Hurst exponent 0.8, waves down to four pixels; w = 0.56 J/m² is the one of Reeks
& Hall, moduli are alumina's and steel's. The three heights were set down before the first comparison.
"""

import argparse
import csv
import sys
import warnings
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.optimize import curve_fit
from scipy.special import ndtr

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr
from roughxr import particles

WORK = 0.56
ROUGHNESS = (5.0, 20.0, 50.0)
WAVES = 10_000.0
SIDE = 20_000.0
BODIES = {"young_modulus": (380.0, 207.0), "poisson_ratio": (0.22, 0.30), "work_of_adhesion": WORK}
SPEEDS = np.geomspace(0.05, 50, 61)


def measured(path):
    """Return friction velocities (m/s) and fractions of each run, by diameter (µm) and run."""
    runs = defaultdict(lambda: ([], []))
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            speeds, fractions = runs[float(row["diameter_um"]), row["run"]]
            speeds.append(float(row["friction_velocity_m_s"]))
            fractions.append(float(row["fraction_remaining"]))
    return {key: (np.array(speeds), np.array(fractions)) for key, (speeds, fractions) in sorted(runs.items())}


def half_and_spread(speeds, fractions):
    """Return the velocity that half of the particles stand and the spread, of the best log-normal law."""
    start = (np.log(np.interp(-0.5, -np.asarray(fractions), speeds)), 0.7)
    (middle, width), _ = curve_fit(lambda u, m, s: ndtr((m - np.log(u)) / s), speeds, fractions, p0=start)
    return float(np.exp(middle)), float(np.exp(abs(width)))


def by_the_fit(radius, speeds):
    """Return the fraction left by Rock'n'Roll with Biasi's reduction."""
    values, weights = particles.biasi_adhesion(radius)
    adhesion = values * 1.5 * np.pi * WORK * radius
    return particles.rock_n_roll(speeds, radius=radius, adhesion=adhesion, weights=weights)[:, 0]


def grounds(pixels):
    """Yield rms heights and catalogues of their ground."""
    for rms in ROUGHNESS:
        size = SIDE / pixels
        how = {"hurst": 0.8, "rolloff": WAVES, "cutoff": 4 * size, "seed": 1}
        yield rms, roughxr.scans.synthetic.self_affine((pixels, pixels), size, rms=rms, **how)


def computed(scan, radius, speeds):
    """Return fractions left with computed adhesion alone; and with lever and flow, landed and at rest, with moments."""
    pair = roughxr.assign_pair(scan, sphere_radius=radius, **BODIES)
    catalogue = roughxr.asperities(pair)
    held = roughxr.rolling(catalogue, directions=12, subregions=(8, 8))
    places = roughxr.particles.resting(pair, landings=(8, 8), on=catalogue)
    rested = roughxr.rolling(catalogue, directions=12, subregions=places)
    pull = held.pull_off_force.dropna("subregion").values
    adhesion = particles.rock_n_roll(speeds, radius=radius, adhesion=pull)[:, 0]
    flow = {"friction_velocity": speeds, "particle_density": 3960}
    return adhesion, [
        (roughxr.particles.resuspension(landed_or_rested, **flow), landed_or_rested)
        for landed_or_rested in (held, rested)
    ]


def told(label, speeds, fractions):
    """Print the middle and the spread of a curve."""
    half, spread = half_and_spread(speeds, fractions)
    print(f"  {label:58s} half stay at {half:7.2f} m/s, spread {spread:5.2f}")
    return half


def off_by(fractions, runs):
    """Return the rms difference of a curve from all runs."""
    differences = [np.interp(np.log(u), np.log(SPEEDS), fractions) - stay for u, stay in runs.values()]
    return float(np.sqrt(np.mean(np.concatenate(differences) ** 2)))


def describe(rms, scan, held, label):
    """Print what the ground is, and what was computed on it."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "fit: each place counts as one")  # the law is of places here
        numbers = particles.parameters(held)
    slope = float(scan.contact.roughness().s_dq)
    print(
        f"  rms {rms:g} nm, {label} (slope {slope:.2f}): pull-off over smooth {float(numbers.adhesion_mean):.4f}, "
        f"spread {float(numbers.adhesion_spread):.2f}; lever over radius {float(numbers.lever_median):.4f}; "
        f"{int((held.contacts < 3).sum())} of {held.sizes['subregion']} places on fewer than 3 asperities"
    )


def compare(diameter, runs, surfaces, ax=None):
    """Print all curves of one size, and draw them."""
    radius = 500.0 * diameter
    print(f"{diameter:g} µm:")
    for name, (speeds, fractions) in runs.items():
        told(f"measured, {name}", speeds, fractions)
    curves = {"Rock'n'Roll with Biasi's fit": by_the_fit(radius, SPEEDS)}
    for rms, scan in surfaces:
        adhesion, flights = computed(scan, radius, SPEEDS)
        curves[f"adhesion computed, rms {rms:g} nm"] = adhesion
        for label, (flight, held) in zip(("landed", "at rest"), flights):
            curves[f"all computed, {label}, rms {rms:g} nm"] = flight.remaining.values[:, 0]
            describe(rms, scan, held, label)
    values, weights = particles.biasi_adhesion(radius)
    mean = np.exp(np.log(values) @ weights)
    print(f"  Biasi's: pull-off over smooth {mean:.4f}; lever over radius 0.0100")
    for label, fractions in curves.items():
        told(label + (f" (rms off by {off_by(fractions, runs):.2f})" if runs else ""), SPEEDS, fractions)
    if ax is not None:
        draw(ax, diameter, runs, curves)


def draw(ax, diameter, runs, curves):
    """Draw the runs as points, the fit black, computed adhesion dashed and all computed full."""
    for marker, (name, (speeds, fractions)) in zip("os^", runs.items()):
        ax.plot(speeds, fractions, marker, color="0.3", markersize=3, label=f"measured, {name}")
    colours = iter(("0.0", *(colour for pair in zip(*[("#0173b2", "#de8f05", "#029e73")] * 3) for colour in pair)))
    for k, (label, fractions) in enumerate(curves.items()):
        ax.plot(
            SPEEDS,
            fractions,
            color=next(colours),
            linestyle=("-", "--", "-", ":")[(k - 1) % 3 + 1 if k else 0],
            linewidth=1.2,
            label=label,
        )
    ax.set(xscale="log", xlabel="friction velocity [m/s]", ylabel="fraction left after 1 s", title=f"{diameter:g} µm")
    ax.legend(fontsize=6.5, frameon=False, loc="upper left", bbox_to_anchor=(0, -0.17))


def main():
    """Compare both sizes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", nargs="?")
    parser.add_argument("picture", nargs="?")
    parser.add_argument("--pixels", type=int, default=768)
    options = parser.parse_args()
    runs = measured(options.measured) if options.measured else {}
    surfaces = list(grounds(options.pixels))
    axes = [None, None]
    if options.picture:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8, 5.2), layout="constrained")
        axes = figure.subplots(1, 2)
    for diameter, ax in zip((10.0, 20.0), axes):
        measured_runs = {f"run {run}": curve for (size, run), curve in runs.items() if size == diameter}
        compare(diameter, measured_runs, surfaces, ax)
    if options.picture:
        figure.savefig(options.picture, dpi=200)


if __name__ == "__main__":
    main()
