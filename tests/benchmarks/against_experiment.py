"""Published measurements beside predictions, nothing fitted: what is not stated is drawn from a prior.

    python tests/benchmarks/against_experiment.py [--only NAME] [--draws 100] [--film CONTAINER.zip] [--picture PNG]

Each experiment is predicted as many times as it has draws, every time with other values of the inputs that its
publication, as far as it could be read, does not state; the prediction is the range of 95 % of them. Only abstracts
could be read, but of Reeks & Hall, whose runs were read off their figures. Each prior was set down before its first
comparison, but for the film's, of which three single surfaces had been seen, and none was changed after it.

1. Thimons, Gujrati, Sanner, Pastewka & Jacobs, Exp. Mech. (2021), doi 10.1007/s11340-021-00733-6: ruby spheres of
   0.5 mm diameter on four diamond films, effective works of adhesion from 0.08 to 7.15 mJ/m². Their work of adhesion
   46.3 mJ/m² and range 5.6 nm are used; they come from a fit to these forces on the measured surfaces. Roughness
   of 43 to 1.8 nm acts most: its share of the fall, in ln, is taken as more than half.
2. Laitinen, Bauer, Niinimäki & Peuker, Powder Technol. 246 (2013) 545: alumina on alumina, the force falls about
   five-fold from 1.5 to 12 nm rms.
3. Jacobs et al., Tribol. Lett. 50 (2013) 81: carbon tips on diamond, rms 0.18 to 1.58 nm; the work of adhesion falls by
   more than an order of magnitude with roughness. That the fall is between the ends of this range is assumed.
4. Çolak et al., Appl. Surf. Sci. 258 (2012) 6938: a flat tip of 2 µm on silicon in humid air; etching it takes more
   than an order of magnitude off the force, depending on the humidity.
5. Reeks & Hall, J. Aerosol Sci. 32 (2001) 1: alumina spheres of 10 and 20 µm blown off polished steel, three runs
   each. The tangential force that removes them is of order 1/100 of the normal one, taken as 0.005 to 0.02. First with
   equal spheres and the 0.56 J/m² of the models of that paper, then with the work of adhesion of alumina and steel by
   Hamaker's constants in `assign_pair`, within the factor of the error budget, and spheres of unequal size and shape.
6. Heim, Blum, Preuss & Butt, Phys. Rev. Lett. 83 (1999) 3328: silica spheres of 0.5 to 2.5 µm in radius roll on each
   other at some 1/100 of their pull-off, taken as 0.005 to 0.02.
7. Langmuir 23 (2007) 1195: pull-offs of glass spheres of different radii on silicon below 3 % humidity do not
   correlate with the radius. Number and radii of the spheres are assumed.

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
from scipy.special import ndtri

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr
from roughxr.mechanics.kernels.topography.random_surface import normal, uniform

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


#: Wavelength (nm) below which roughness acts most on the diamond films.
SHORT_WAVE = 43.0

#: Cells along a pixel of `adhesive`; see ``--mesh``.
CELLS_PER_PIXEL = 1

#: Spheres of unequal size and shape in one draw.
SPHERES = 6


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
    verb: str  # that computes it
    cells: tuple[int, int]  # along a side, of a full run and of a quick one
    draws: int = 100


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


def adhesive_pull(scan):
    """Return the pull-off (nN) in the middle of a scan by `adhesive`."""
    solved = roughxr.adhesive(scan, subregions=(1, 1), mesh=CELLS_PER_PIXEL, law="exponential")
    return float(solved.pull_off_force[0])


def touched_width(radius, rms):
    """Return the width (nm) of a scan that holds what a sphere can touch, four standard deviations deep."""
    return 1.1 * np.sqrt(8 * radius * rms)


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


def on_diamond(seed, cells, *, ruby, spectrum, law):
    """Return a ruby sphere's effective work of adhesion (mJ/m²) on the film, and the share of roughness below 43 nm.

    The work is the pull-off over 2πR. ``ruby`` is the sphere's own rms over the film's, ``spectrum`` the part of its
    continued spectrum's distribution.
    """
    radius = 250_000.0
    work = 0.0463
    cell = 9400.0 / cells
    model = extrapolated_spectrum(film_spectrum())._replace(tilt=float(ndtri(spectrum)))
    at = (np.arange(cells) + 0.5) * cell
    coarse = nested_roughness(at, at, model.density, 1e5, SHORT_WAVE, seed)
    fine = nested_roughness(at, at, model.density, SHORT_WAVE, 4 * cell, 1000 + seed)
    works = []
    for height in (coarse, coarse + fine):
        scan = scan_of(np.hypot(1, ruby) * height, cell)
        pair = roughxr.assign_pair(
            scan, sphere_radius=radius, contact_modulus=280.0, work_of_adhesion=work, adhesion_range=5.6
        )
        force = pull(pair, law="lennard_jones" if law < 0.5 else "exponential")
        works.append(force / (2 * np.pi * radius))
    share = np.log(works[0] / works[1]) / np.log(work / works[1])
    return 1e3 * works[1], share


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
        forces.append(np.mean([adhesive_pull(surface_of_pair) for surface_of_pair in pairs]))
    return (forces[0] / forces[1],)


def alumina(seed, cells, *, radius, own_rms, hurst, rolloff, shortest, length, hardness):
    """Return by how much the pull-off of an alumina sphere falls from 1.5 to 12 nm rms."""
    pixel = shortest / 4
    surface = {"pixel": pixel, "hurst": hurst, "rolloff": rolloff, "cutoff": shortest}
    bodies = {"contact_modulus": 200.0, "work_of_adhesion": 0.148, "adhesion_range": length, "hardness": hardness}
    needed = touched_width(radius, np.hypot(12.0, own_rms)) / pixel
    return divided(seed, max(cells, int(np.ceil(needed))), (1.5, 12.0), own_rms, radius, surface, bodies)


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


def floor(seed, cells, rms, hurst, rolloff, fine):
    """Return a steel floor of 20 µm whose roughness ends at four cells of a side / (cells · fine)."""
    cell = reeks_hall.SIDE / (cells * fine)
    shape = (round(cells * fine),) * 2
    return roughxr.scans.synthetic.self_affine(
        shape, cell, rms=rms, hurst=hurst, rolloff=rolloff, cutoff=4 * cell, seed=seed
    )


def moments(catalogue, radius, work, subregions):
    """Return the resistance to rolling of alumina spheres on the asperities of a steel floor."""
    bodies = {**reeks_hall.BODIES, "work_of_adhesion": work}
    pair = roughxr.assign_pair(catalogue, sphere_radius=radius, **bodies)
    return roughxr.rolling(pair, directions=12, subregions=subregions)


def remaining(held):
    """Return the fraction of spheres left at each friction velocity."""
    flow = {"friction_velocity": reeks_hall.SPEEDS, "particle_density": 3960}
    return roughxr.particles.resuspension(held, **flow).remaining.values[:, 0]


def equal_spheres(seed, cells, *, rms, hurst, rolloff, fine):
    """Return the friction velocity (m/s) that half of the spheres stand and the spread, of 10 and 20 µm."""
    catalogue = roughxr.asperities(floor(seed, cells, rms, hurst, rolloff, fine))
    half_and_spread = []
    for radius in (5000.0, 10_000.0):
        held = moments(catalogue, radius, reeks_hall.WORK, (8, 8))
        half_and_spread += reeks_hall.half_and_spread(reeks_hall.SPEEDS, remaining(held))
    return tuple(half_and_spread)


def unequal_spheres(seed, cells, *, rms, hurst, rolloff, fine, work, own_rms, own_spread, sizes):
    """Return half and spread of the velocities and the ratio of tangential to normal force, of 10 and 20 µm.

    Each of six spheres has its own size, log-normal with a geometric standard deviation ``sizes``, and its own rms
    height, of median ``own_rms`` (nm) and geometric standard deviation ``own_spread``.
    """
    ground = floor(seed, cells, rms, hurst, rolloff, fine)
    size, shape = normal((2, SPHERES), seed, 2000)
    catalogues = []
    for deviation in shape:
        roughness = np.hypot(rms, own_rms * own_spread**deviation)
        height = ground.height.copy(data=ground.height.values * (roughness / rms))
        catalogues.append(roughxr.asperities(ground.assign(height=height)))
    quantities = []
    for radius in (5000.0, 10_000.0):
        radii = radius * sizes**size
        spheres = [moments(catalogue, length, work, (4, 4)) for catalogue, length in zip(catalogues, radii)]
        remaining_share = np.mean([remaining(held) for held in spheres], axis=0)
        tangential = np.mean([held.resisting_moment.mean() / length for held, length in zip(spheres, radii)])
        normal_force = np.mean([held.pull_off_force.mean() for held in spheres])
        quantities += reeks_hall.half_and_spread(reeks_hall.SPEEDS, remaining_share)
        quantities.append(tangential / normal_force)
    return tuple(quantities)


def rolling_silica(seed, cells, *, radius, rms, hurst, rolloff, shortest, work):
    """Return the force that rolls a silica sphere on another over their pull-off."""
    effective_radius = radius / 2
    pixel = shortest / 4
    side = max(cells * pixel, 2 * touched_width(effective_radius, rms))
    count = int(np.ceil(side / pixel))
    ground = roughxr.scans.synthetic.self_affine(
        (count, count), pixel, rms=rms, hurst=hurst, rolloff=rolloff, cutoff=shortest, seed=seed
    )
    pair = roughxr.assign_pair(ground, sphere_radius=effective_radius, materials="silica", work_of_adhesion=work)
    held = roughxr.rolling(roughxr.asperities(pair), directions=12, subregions=(4, 4))
    return (float(held.resisting_moment.mean()) / (radius * float(held.pull_off_force.mean())),)


def glass_on_silicon(seed, cells, *, least_rms, ratio, hurst, rolloff, length):
    """Return the rank correlation of force and radius of six spheres with own roughness."""
    from scipy.stats import spearmanr  # whose import takes a second of whoever imports this file alone

    radii = np.geomspace(1000.0, 20_000.0, 6)
    forces = []
    for k, share in enumerate(uniform(radii.size, seed, 3000)):
        rms = least_rms * ratio**share
        pixel = max(2.0, touched_width(radii[k], rms) / cells)
        ground = roughxr.scans.synthetic.self_affine(
            (cells, cells), pixel, rms=rms, hurst=hurst, rolloff=rolloff, cutoff=4 * pixel, seed=10 * seed + k
        )
        pair = roughxr.assign_pair(ground, sphere_radius=radii[k], materials="glass/silicon", adhesion_range=length)
        forces.append(adhesive_pull(pair))
    return (float(spearmanr(radii, forces).statistic),)


#: The runs of Reeks & Hall, least, most and the one between, by `reeks_hall.half_and_spread`.
RUNS = (
    Fact("half of 10 µm leave at, m/s", 0.41, 0.89, 0.76),
    Fact("spread of 10 µm", 1.43, 3.09, 1.89),
    Fact("half of 20 µm leave at, m/s", 0.48, 0.57, 0.50),
    Fact("spread of 20 µm", 1.38, 2.06, 1.73),
)

#: The ratio of tangential to normal force of the same spheres, "of order 1/100".
TANGENTIAL = (
    Fact("tangential over normal force, 10 µm", 0.005, 0.02),
    Fact("tangential over normal force, 20 µm", 0.005, 0.02),
)

#: What is not known of the floor.
FLOOR = {
    "rms": (5, 50, "log"),
    "hurst": (0.6, 0.9, "even"),
    "rolloff": (2000, 10_000, "log"),
    "fine": (0.7, 1.4, "log"),
}

EXPERIMENTS = (
    Experiment(
        "Thimons 2021",
        (
            Fact("effective work, mJ/m²", 0.08, 7.15),
            Fact("share of roughness below 43 nm in the fall", 0.5, 1),
        ),
        on_diamond,
        {
            "ruby": (0, 1, "even"),
            "spectrum": (0.01, 0.99, "even"),
            "law": (0, 1, "even"),
        },
        "rigid",
        (1600, 1200),
        24,
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
        "adhesive",
        (512, 256),
        24,
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
        "adhesive",
        (320, 160),
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
        "rigid",
        (600, 300),
    ),
    Experiment("Reeks & Hall 2001, 0.56 J/m²", RUNS, equal_spheres, FLOOR, "rolling", (400, 256)),
    Experiment(
        "Reeks & Hall 2001",
        (*RUNS[:2], TANGENTIAL[0], *RUNS[2:], TANGENTIAL[1]),
        unequal_spheres,
        {
            **FLOOR,
            "work": (0.174 / 1.5, 0.174 * 1.5, "log"),
            "own_rms": (5, 50, "log"),
            "own_spread": (1, 2, "even"),
            "sizes": (1, 1.3, "even"),
        },
        "rolling",
        (400, 256),
    ),
    Experiment(
        "Heim 1999",
        (Fact("rolling force over pull-off", 0.005, 0.02),),
        rolling_silica,
        {
            "radius": (500, 2500, "log"),
            "rms": (0.2, 2, "log"),
            "hurst": (0.5, 0.9, "even"),
            "rolloff": (50, 500, "log"),
            "shortest": (8, 32, "log"),
            "work": (0.063 / 1.5, 0.063 * 1.5, "log"),
        },
        "rolling",
        (256, 128),
    ),
    Experiment(
        "Langmuir 23 (2007) 1195",
        (Fact("rank correlation of force and radius", 0, 0),),
        glass_on_silicon,
        {
            "least_rms": (0.2, 1, "log"),
            "ratio": (1, 10, "log"),
            "hurst": (0.5, 0.9, "even"),
            "rolloff": (50, 500, "log"),
            "length": (0.2, 0.5, "log"),
        },
        "adhesive",
        (384, 192),
        24,
    ),
)


def predicted(experiment, draws=None, quick=False, stream=0):
    """Return the inputs of each draw, and the predictions (draw, fact) of an experiment."""
    cells = experiment.cells[quick]
    inputs = [drawn(experiment.prior, seed, 1000 + stream) for seed in range(draws or experiment.draws)]
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


def named(part):
    """Return the experiments with this in their names."""
    return tuple(experiment for experiment in EXPERIMENTS if part in experiment.name)


def compared(draws=None, quick=False, experiments=EXPERIMENTS):
    """Return a table of what is stated and what is predicted, one row for each fact."""
    rows = []
    for experiment in experiments:
        inputs, values = predicted(experiment, draws, quick, EXPERIMENTS.index(experiment))
        for fact, column in zip(experiment.stated, values.T):
            low, middle, high = np.nanquantile(column, (0.025, 0.5, 0.975))
            verdict = fact.judged(low, high)
            strongest = strongest_inputs(inputs, column)
            row = (experiment.name, *fact, low, middle, high, verdict, experiment.verb, len(inputs), strongest)
            rows.append(row)
    names = (
        *("experiment", "quantity", "stated_low", "stated_high", "stated_middle", "low", "middle", "high"),
        *("verdict", "computed_by", "draws", "depends_on"),
    )
    return pd.DataFrame(rows, columns=names)


COLOURS = {"agrees": "#0173b2", "in part": "0.35", "misses": "#d55e00"}


def draw(table, ax):
    """Draw predicted against stated, each with its interval; arrows are bounds. Correlations are left out."""
    for k, row in enumerate(table.itertuples(), 1):
        if row.stated_high <= 0:
            continue
        colour = COLOURS[row.verdict]
        is_bound = bool(np.isinf(row.stated_high))
        last = 4 * row.stated_low if is_bound else row.stated_high
        x = row.stated_low if is_bound else row.stated_middle
        if np.isnan(x):
            x = np.sqrt(row.stated_low * last)
        ax.plot([row.stated_low, last], [row.middle] * 2, color=colour, linewidth=1.2)
        ax.plot([x, x], [row.low, row.high], color=colour, linewidth=1.2)
        label = f"{k} {row.experiment}: {row.quantity}"
        ax.plot(x, row.middle, "o", color=colour, markersize=4, label=label)
        ax.plot([last] * is_bound, [row.middle] * is_bound, ">", color=colour, markersize=4)
        ax.annotate(str(k), (x, row.middle), (4, 4), textcoords="offset points", color=colour, fontsize=8)
    ends = np.array([0.003, 200.0])
    ax.plot(ends, ends, color="0.6", linewidth=0.8, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel="measured, as stated", ylabel="predicted, nothing fitted")
    ax.legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(0, -0.14), ncols=1, handlelength=0.6)


def main():
    """Compare all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, help="default: as each experiment has them")
    parser.add_argument("--only", default="", help="experiments with this in their names")
    parser.add_argument("--mesh", type=int, default=CELLS_PER_PIXEL, help="cells along a pixel of `adhesive`")
    parser.add_argument("--quick", action="store_true", help="coarser surfaces, as the notebook's quick run")
    parser.add_argument("--film", help="container from which to print the film's spectrum, and end")
    parser.add_argument("--picture")
    options = parser.parse_args()
    globals()["CELLS_PER_PIXEL"] = options.mesh
    if options.film:
        film = film_of(options.film)
        for wave, power in zip(2 * np.pi / film.wavevector.values, film.psd.values):
            print(f"    ({wave:.4g}, {power:.3g}),")
        return
    table = compared(options.draws, options.quick, named(options.only))
    with pd.option_context("display.width", 220, "display.max_columns", 20):
        print(table.round(3).to_string())
    if options.picture:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(5, 5.6), layout="constrained")
        draw(table, figure.subplots())
        figure.savefig(options.picture, dpi=150)


if __name__ == "__main__":
    main()
