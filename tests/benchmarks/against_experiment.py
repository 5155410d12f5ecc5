"""Published measurements beside predictions, nothing fitted: what is not stated is drawn from a prior.

    python tests/benchmarks/against_experiment.py [--draws 24] [--film CONTAINER.zip] [--picture PICTURE.png]

Each experiment is predicted as many times as there are draws, every time with other values of the inputs that its
publication, as far as it could be read, does not state; the prediction is the range of 95 % of them. Only abstracts
could be read, but of Reeks & Hall, whose runs were read off their figures. The priors were set down before the first
comparison, but for the film's, of which three single surfaces had been seen, and none was changed after it.

1. Thimons, Gujrati, Sanner, Pastewka & Jacobs, Exp. Mech. (2021), doi 10.1007/s11340-021-00733-6: ruby spheres of
   0.5 mm diameter on four diamond films, effective works of adhesion from 0.08 to 7.15 mJ/m². Their work of adhesion
   46.3 mJ/m² and range 5.6 nm are used; they come from a fit to these forces on the measured surfaces.
2. Laitinen, Bauer, Niinimäki & Peuker, Powder Technol. 246 (2013) 545: alumina on alumina, the force falls about
   five-fold from 1.5 to 12 nm rms.
3. Jacobs et al., Tribol. Lett. 50 (2013) 81: carbon tips on diamond, the work of adhesion falls by more than an order
   of magnitude from 0.18 to 1.58 nm rms.
4. Çolak et al., Appl. Surf. Sci. 258 (2012) 6938: a flat tip of 2 µm on silicon in humid air; etching it takes more
   than an order of magnitude off the force, depending on the humidity.
5. Reeks & Hall, J. Aerosol Sci. 32 (2001) 1: alumina spheres of 10 and 20 µm blown off polished steel, three runs
   each.

FILM is the spectrum of a container of contact.engineering, "Demo UNCD data" by L. Pastewka (CC BY 4.0), of an
ultrananocrystalline diamond film: a TEM profile down to 12 nm, an AFM map down to 25 nm, where its tip of some 20 nm
begins to round it, and a stylus line down to 2.5 µm, by ``film_of``. Whether it is one of the four films is not known.
"""

import argparse
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from scipy.optimize import brentq
from scipy.special import ndtri

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr
from roughxr.kernels.topography.random_surface import uniform

sys.path.insert(0, str(Path(__file__).parent))

import reeks_hall
from nested_roughness import extrapolated_spectrum, nested_roughness

#: Wavelengths (nm) and power (nm⁴) of the film, as `film_of` finds them.
FILM = (
    (9.959e04, 4.45e08),
    (7.47e04, 1.07e08),
    (5.432e04, 4.28e08),
    (3.515e04, 2.57e08),
    (2.298e04, 6.47e08),
    (1.573e04, 3.6e08),
    (1.086e04, 2.65e08),
    (7470, 2.97e08),
    (5107, 1.85e08),
    (3474, 8.88e07),
    (2692, 7.25e07),
    (77.32, 1.38e04),
    (47.55, 1.95e03),
    (33.43, 286),
    (24.42, 138),
    (16, 18.9),
    (12.54, 20.8),
)


class Fact(NamedTuple):
    """One number that was measured, and its range."""

    quantity: str
    low: float
    high: float  # infinite where only a bound is stated
    middle: float = np.nan  # of several runs

    def judged(self, low, high):
        """Return whether a predicted interval contains what is stated."""
        run = self.middle if np.isfinite(self.middle) else np.clip(low, self.low, self.high)
        if self.high < low or high < self.low or not low <= run <= high:
            return "misses"
        whole = self.low <= low if np.isinf(self.high) else low <= self.low and self.high <= high
        return "agrees" if whole else "in part"


class Experiment(NamedTuple):
    """What is stated, and a function that predicts it from the numbers of one draw."""

    name: str
    stated: tuple[Fact, ...]
    predict: Callable[..., tuple[float, ...]]
    prior: dict[str, tuple]  # low, high and how a number is drawn between: "log" or "even"


def drawn(prior, seed, stream):
    """Return the inputs of one draw."""
    sampled = {}
    for u, (name, (low, high, how)) in zip(uniform(len(prior), seed, stream), prior.items()):
        sampled[name] = float(low * (high / low) ** u if how == "log" else low + (high - low) * u)
    return sampled


def scan_of(height, cell):
    """Return heights (nm) on square cells as a scan."""
    nm = {"units": "nm"}
    axes = {axis: (axis, (np.arange(n) + 0.5) * cell, nm) for axis, n in zip("xy", height.shape)}
    return xr.Dataset({"height": (("x", "y"), height, nm)}, axes)


def pull(scan, **options):
    """Return the pull-off (nN) in the middle of a scan with a pair."""
    pulled = roughxr.rigid(scan, subregions=(1, 1), delta=[0.0], **options)
    return float(pulled.pull_off_force[0])


def flattened_pull(scan):
    """Return the pull-off (nN) in the middle of a scan whose summits are flat until they bear the pull at the hardness.

    Traction across gaps is exponential; heights that the sphere would overlap are cut off level with it.
    """
    approached = roughxr.rigid(
        scan, subregions=(1, 1), delta=[0.0], datum="first_contact", law="exponential", fields=True
    ).isel(subregion=0, delta=0)
    gap = np.sort(approached.gap.values[np.isfinite(approached.gap.values)])
    area = float(scan.x[1] - scan.x[0]) ** 2
    length = float(scan.adhesion_range)
    work = float(scan.work_of_adhesion)

    def pulled(depth):
        return area * work / length * np.exp(-np.maximum(gap - depth, 0.0) / length).sum()

    def lacking(depth):
        return pulled(depth) - float(scan.hardness) * np.interp(depth, gap, area * np.arange(gap.size))

    return pulled(brentq(lacking, 0.0, gap[-1], xtol=1e-9))


def film_of(path):
    """Return the spectrum of a film from its container."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", roughxr.scans.ImplausibleScan)
        profile, image, stylus = roughxr.scans.open_container(path)
    parts = [profile, roughxr.scans.level(image, method="quadratic"), stylus]
    return roughxr.scans.combined_spectrum(parts, shortest=["10 nm", "25 nm", "2.5 um"], per_decade=6)


def film_spectrum():
    """Return the film's spectrum as it stands in `FILM`."""
    waves, psd = np.array(FILM).T
    return xr.Dataset({"psd": ("wavevector", psd)}, {"wavevector": 2 * np.pi / waves})


def on_diamond(seed, cells, *, hardness, ruby, spectrum, law):
    """Return the effective work of adhesion (mJ/m²) of a ruby sphere on the film, 2πRw_eff being its pull-off.

    ``ruby`` is the sphere's own rms over the film's, ``spectrum`` the part of its continued spectrum's distribution.
    """
    radius = 250_000.0
    cell = 9400.0 / cells
    model = extrapolated_spectrum(film_spectrum())._replace(tilt=float(ndtri(spectrum)))
    at = (np.arange(cells) + 0.5) * cell
    height = np.hypot(1, ruby) * nested_roughness(at, at, model.density, 1e5, 4 * cell, seed)
    bodies = {"contact_modulus": 280.0, "work_of_adhesion": 0.0463, "adhesion_range": 5.6, "hardness": hardness}
    pair = roughxr.assign_pair(scan_of(height, cell), sphere_radius=radius, **bodies)
    force = pull(pair, law="lennard_jones") if law < 0.5 else flattened_pull(pair)
    return (1e3 * force / (2 * np.pi * radius),)


def divided(seed, cells, rms, own_rms, radius, surface, bodies):
    """Return the ratio of the mean pull-offs on two rms heights, under a sphere of ``own_rms`` (nm)."""
    forces = []
    for height in rms:
        made = (
            roughxr.scans.synthetic.self_affine(
                (cells, cells), rms=np.hypot(height, own_rms), seed=10 * seed + k, **surface
            )
            for k in range(3)
        )
        pairs = (roughxr.assign_pair(surface_of_pair, sphere_radius=radius, **bodies) for surface_of_pair in made)
        forces.append(np.mean([flattened_pull(surface_of_pair) for surface_of_pair in pairs]))
    return (forces[0] / forces[1],)


def alumina(seed, cells, *, radius, own_rms, hurst, rolloff, shortest, length, hardness):
    """Return by how much the pull-off of an alumina sphere falls from 1.5 to 12 nm rms."""
    surface = {"pixel": shortest / 4, "hurst": hurst, "rolloff": rolloff, "cutoff": shortest}
    bodies = {"contact_modulus": 200.0, "work_of_adhesion": 0.148, "adhesion_range": length, "hardness": hardness}
    return divided(seed, cells, (1.5, 12.0), own_rms, radius, surface, bodies)


def carbon(seed, cells, *, radius, hurst, rolloff, work, length, hardness):
    """Return by how much the pull-off of a carbon tip falls from 0.18 to 1.58 nm rms."""
    cell = 64 / cells
    surface = {"pixel": cell, "hurst": hurst, "rolloff": rolloff, "cutoff": 4 * cell}
    bodies = {"contact_modulus": 400.0, "work_of_adhesion": work, "adhesion_range": length, "hardness": hardness}
    return divided(seed, cells, (0.18, 1.58), 0.0, radius, surface, bodies)


def silicon(seed, cells, *, humidity, angle, smooth, etched, tip, hurst, rolloff, slope):
    """Return by how much the pull of a flat tip of 2 µm falls from smooth to etched silicon."""
    cell = 2400 / cells
    forces = []
    at = (np.arange(cells | 1) - (cells | 1) // 2) * cell
    away = np.hypot(at[:, None], at)
    face = np.where(away < 1000, np.radians(slope) * at[:, None], -1e4)
    surface = {"pixel": cell, "hurst": hurst, "rolloff": rolloff, "cutoff": 4 * cell, "seed": seed}
    for rms in (smooth, etched):
        ground = roughxr.scans.synthetic.self_affine((cells | 1, cells | 1), rms=np.hypot(rms, tip), **surface)
        flat = xr.DataArray(face, {"x": at, "y": at}, ("x", "y"))
        air = roughxr.HumidAir(humidity, contact_angle=angle)
        pair = roughxr.assign_pair(ground, indenter=flat, materials="silicon", humidity=air)
        forces.append(pull(pair))
    return (forces[0] / forces[1],)


def steel(seed, cells, *, rms, hurst, rolloff, fine):
    """Return the friction velocity (m/s) that half of the spheres stand and the spread, of 10 and 20 µm."""
    cell = reeks_hall.SIDE / (cells * fine)
    surface = {"hurst": hurst, "rolloff": rolloff, "cutoff": 4 * cell, "seed": seed}
    shape = (round(cells * fine),) * 2
    ground = roughxr.scans.synthetic.self_affine(shape, cell, rms=rms, **surface)
    half_and_spread = []
    for radius in (5000.0, 10_000.0):
        catalogue = roughxr.asperities(roughxr.assign_pair(ground, sphere_radius=radius, **reeks_hall.BODIES))
        held = roughxr.rolling(catalogue, directions=12, subregions=(8, 8))
        resuspended = roughxr.particles.resuspension(held, friction_velocity=reeks_hall.SPEEDS, particle_density=3960)
        half_and_spread += reeks_hall.half_and_spread(reeks_hall.SPEEDS, resuspended.remaining.values[:, 0])
    return tuple(half_and_spread)


#: The runs of Reeks & Hall, least, most and the one between, by `reeks_hall.half_and_spread`.
RUNS = (
    Fact("half of 10 µm leave at, m/s", 0.41, 0.89, 0.76),
    Fact("spread of 10 µm", 1.43, 3.09, 1.89),
    Fact("half of 20 µm leave at, m/s", 0.48, 0.57, 0.50),
    Fact("spread of 20 µm", 1.38, 2.06, 1.73),
)

EXPERIMENTS = (
    Experiment(
        "Thimons 2021",
        (Fact("effective work, mJ/m²", 0.08, 7.15),),
        on_diamond,
        {
            "hardness": (10, 30, "log"),
            "ruby": (0, 1, "even"),
            "spectrum": (0.01, 0.99, "even"),
            "law": (0, 1, "even"),
        },
    ),
    Experiment(
        "Laitinen 2013",
        (Fact("force at 1.5 nm over that at 12 nm", 4.5, 5.5),),
        alumina,
        {
            "radius": (2500, 15_000, "log"),
            "own_rms": (0, 3, "even"),
            "hurst": (0.5, 0.9, "even"),
            "rolloff": (50, 500, "log"),
            "shortest": (4, 16, "log"),
            "length": (0.2, 0.5, "log"),
            "hardness": (15, 30, "log"),
        },
    ),
    Experiment(
        "Jacobs 2013",
        (Fact("force at 0.18 nm over that at 1.58 nm", 10, np.inf),),
        carbon,
        {
            "radius": (5, 50, "log"),
            "hurst": (0.5, 0.9, "even"),
            "rolloff": (2, 10, "log"),
            "work": (0.05, 0.5, "log"),
            "length": (0.15, 0.6, "log"),
            "hardness": (20, 80, "log"),
        },
    ),
    Experiment(
        "Çolak 2012",
        (Fact("force on smooth over etched", 10, np.inf),),
        silicon,
        {
            "humidity": (0.3, 0.7, "even"),
            "angle": (0, 30, "even"),
            "smooth": (0.1, 0.5, "log"),
            "etched": (1, 10, "log"),
            "tip": (0.2, 1, "even"),
            "hurst": (0.5, 0.9, "even"),
            "rolloff": (50, 500, "log"),
            "slope": (0, 0.2, "even"),
        },
    ),
    Experiment(
        "Reeks & Hall 2001",
        RUNS,
        steel,
        {
            "rms": (5, 50, "log"),
            "hurst": (0.6, 0.9, "even"),
            "rolloff": (2000, 10_000, "log"),
            "fine": (0.7, 1.4, "log"),
        },
    ),
)

#: Cells along a side, of a full run and of a quick one.
CELLS = {
    "Thimons 2021": (2400, 1200),
    "Laitinen 2013": (1024, 512),
    "Jacobs 2013": (320, 160),
    "Çolak 2012": (600, 300),
    "Reeks & Hall 2001": (400, 256),
}


def predicted(experiment, draws, quick=False, stream=0):
    """Return the inputs of each draw, and the predictions (draw, fact) of an experiment."""
    cells = CELLS[experiment.name][quick]
    inputs = [drawn(experiment.prior, seed, 1000 + stream) for seed in range(draws)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        predictions = np.array([experiment.predict(seed, cells, **values) for seed, values in enumerate(inputs)])
    return pd.DataFrame(inputs), predictions


def strongest_inputs(inputs, values, count=2):
    """Return the inputs with the largest rank correlations to the predictions, and these."""
    correlations = inputs.corrwith(pd.Series(values), method="spearman")
    return ", ".join(
        f"{name} {correlations[name]:+.1f}" for name in correlations.abs().sort_values(ascending=False).index[:count]
    )


def compared(draws, quick=False, experiments=EXPERIMENTS):
    """Return a table of what is stated and what is predicted, one row for each fact."""
    rows = []
    for stream, experiment in enumerate(experiments):
        inputs, values = predicted(experiment, draws, quick, stream)
        for fact, column in zip(experiment.stated, values.T):
            low, middle, high = np.nanquantile(column, (0.025, 0.5, 0.975))
            verdict = fact.judged(low, high), strongest_inputs(inputs, column)
            rows.append((experiment.name, *fact[:3], low, middle, high, *verdict))
    names = ("experiment", "quantity", "stated_low", "stated_high", "low", "middle", "high", "verdict", "depends_on")
    return pd.DataFrame(rows, columns=names)


COLOURS = {"agrees": "#0173b2", "in part": "0.35", "misses": "#d55e00"}


def draw(table, ax):
    """Draw predicted against stated, each with its interval; arrows are bounds."""
    facts = [fact for experiment in EXPERIMENTS for fact in experiment.stated]
    for k, (row, fact) in enumerate(zip(table.itertuples(), facts), 1):
        colour = COLOURS[row.verdict]
        bound = bool(np.isinf(fact.high))
        last = 4 * fact.low if bound else fact.high
        x = fact.low if bound else np.sqrt(fact.low * last) if np.isnan(fact.middle) else fact.middle
        ax.plot([fact.low, last], [row.middle] * 2, color=colour, linewidth=1.2)
        ax.plot([x, x], [row.low, row.high], color=colour, linewidth=1.2)
        label = f"{k} {row.experiment}: {row.quantity}"
        ax.plot(x, row.middle, "o", color=colour, markersize=4, label=label)
        ax.plot([last] * bound, [row.middle] * bound, ">", color=colour, markersize=4)
        ax.annotate(str(k), (x, row.middle), (4, 4), textcoords="offset points", color=colour, fontsize=8)
    ends = np.array([0.05, 200.0])
    ax.plot(ends, ends, color="0.6", linewidth=0.8, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel="measured, as stated", ylabel="predicted, nothing fitted")
    ax.legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(0, -0.14), ncols=1, handlelength=0.6)


def main():
    """Compare all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=24)
    parser.add_argument("--quick", action="store_true", help="coarser surfaces, as the notebook's quick run")
    parser.add_argument("--film", help="container from which to print the film's spectrum, and end")
    parser.add_argument("--picture")
    options = parser.parse_args()
    if options.film:
        film = film_of(options.film)
        for wave, power in zip(2 * np.pi / film.wavevector.values, film.psd.values):
            print(f"    ({wave:.4g}, {power:.3g}),")
        return
    table = compared(options.draws, options.quick)
    with pd.option_context("display.width", 220, "display.max_columns", 20):
        print(table.round(3).to_string())
    if options.picture:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(5, 5.6), layout="constrained")
        draw(table, figure.subplots())
        figure.savefig(options.picture, dpi=150)


if __name__ == "__main__":
    main()
