"""What is said of a surface from a coarse picture of it, against the surface itself.

    python tests/benchmarks/below_the_pixel.py [--held-out] [--cases 24] [--cache FOLDER] [--again] [--figure FILE]
    python tests/benchmarks/below_the_pixel.py --cost

Each case makes a self-affine surface with waves down to 2 or 4 nm, or takes a measured map as it is: the truth. It is
drawn as a microscope would (a round tip, larger pixels, sampled or averaged, noise of 0.05 nm); `extrapolated` is
asked for the mean pull-off at six places of the picture. The truth is solved at the same places as fine as it is.
Where its last octave changes the mean by more than a tenth, its waves end where they still matter, and those that are
extrapolated are asked to end there too; so they are on a measured map, which ends where its microscope did.

Printed for each case: the truth, the picture as it is, what is said with its 95 % interval, and by how many of the
stated standard deviations it is off, once of all that the interval holds and once of what a truth at the same places,
of the same range and hardness, can show: spectrum, surfaces drawn, waves left out. Where `extrapolated` says that no
self-affine surface describes the picture, only the bound remains: the picture's own pull-off, which must not lie below
the truth's. At the end the shares inside, the bias, and of how many cases the bound holds.

The settings of the first cases lie on a grid, and were seen while `extrapolated` was built. With ``--held-out`` they
are drawn at random over wider ranges: on these nothing was tuned. Measured maps follow (where ``../shared/scans`` has
them), with which at hand it was settled what is refused. With a cache a truth is solved once and a case asked once,
unless ``--again``; a figure shows all it holds.

With ``--cost`` it prints the time of `extrapolated` on the glass twin, down to its shortest waves: at 16 places on two
surfaces, as a run asks, and at 64 on four. The first call has its kernels at hand.
"""

import argparse
import json
import os
import tempfile
import time
import warnings
import zipfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import roughxr
from roughxr.contact.adhesion import settling
from roughxr.contact.subpixel import Below
from roughxr.scans.fine_scales import Spectrum
from roughxr.scans.synthetic import self_affine
from roughxr.studies.extrapolation import Question, Surface, next_guess

#: Pairs of bodies: E* (GPa), w (J/m²), hardness (GPa) if it is given. A soft one feels each patch far off, and is dear:
#: its waves end at 4 nm.
PAIRS = {
    "glass": {"contact_modulus": 39.4, "work_of_adhesion": 0.1},
    "polymer": {"contact_modulus": 3.0, "work_of_adhesion": 0.08},
    "yielding glass": {"contact_modulus": 39.4, "work_of_adhesion": 0.2, "hardness": 6.0},
}
HURSTS, TIPS, PIXELS, SHORTEST = (0.5, 0.7, 0.9), (5.0, 10.0), (4.0, 8.0), (4.0, 2.0)
NOISE, GRID, MAPS = 0.05, (3, 2), Path(__file__).parents[3] / "shared" / "scans"

#: What a truth at the same places, of the same range and hardness, can show.
SHOWN = ("spectrum", "seeds", "finer roughness")


def on_grid(k):
    """Return the settings of a case that was looked at while building."""
    told = {
        "seed": k,
        "hurst": HURSTS[k % 3],
        "rms": 1.5,
        "rolloff": 150.0,
        "pair": list(PAIRS)[(k // 3) % 3],
        "radius": 300.0,
        "tip": TIPS[(k // 2) % 2],
        "pixel": PIXELS[(k // 4) % 2],
        "averaged": bool((k // 5) % 2),
        "stretch": 1.5 if k % 4 == 3 else 1.0,
    }
    return ends(told, SHORTEST[(k // 2) % 2])


def at_random(k):
    """Return the settings of a case that nothing was tuned on."""
    draw = np.random.default_rng(1000 + k)
    told = {
        "seed": 1000 + k,
        "hurst": HURSTS[k % 3],
        "rms": round(float(np.exp(draw.uniform(np.log(0.7), np.log(3)))), 2),
        "rolloff": round(float(np.exp(draw.uniform(np.log(80), np.log(250)))), 0),
        "pair": (pair := str(draw.choice(list(PAIRS), p=[0.4, 0.2, 0.4]))),
        "radius": round(float(np.exp(draw.uniform(np.log(150), np.log(300 if pair == "polymer" else 800)))), 0),
        "tip": round(float(draw.uniform(5, 10)), 1),
        "pixel": float(draw.choice([4.0, 6.0, 8.0, 10.0])),
        "averaged": bool(draw.integers(2)),
        "stretch": float(draw.choice([1.0, 1.0, 1.5, 2.0])),
    }
    return ends(told, float(draw.choice(SHORTEST)))


def measured():
    """Return the settings of the cases on measured maps: quarters of a granular film, and a film of diamond."""
    park = {"map": "park", "shortest": 6.0, "radius": 300.0, "tip": 8.0, "pixel": 4, "averaged": False}
    out = [park | {"seed": 2000 + k, "pair": pair, "part": k} for k, pair in enumerate((*PAIRS, "glass"))]
    diamond = {"map": "uncd", "shortest": 1.2, "radius": 60.0, "tip": 5.0, "pixel": 10, "averaged": False, "part": 0}
    return out + [diamond | {"seed": 2010 + k, "pair": pair} for k, pair in enumerate(("glass", "polymer"))]


def ends(told, shortest):
    """Return the settings with the shortest wave of the truth, nm."""
    return told | {"shortest": max(shortest, 4.0) if told["pair"] == "polymer" else shortest}


def surface(told):
    """Return the truth on fine cells, and the pixels of its picture in them."""
    if "map" in told:
        return roughxr.scans.smooth(read(told), shortest=told["shortest"]), told["pixel"]
    cell = told["shortest"] / 4
    n, make = int((512 if cell < 1 else 768) / cell), {name: told[name] for name in ("rms", "hurst", "rolloff", "seed")}
    out = self_affine((n, n), cell, cutoff=told["shortest"], **make)
    if told["stretch"] != 1:
        narrow = self_affine((round(n / told["stretch"]), n), cell, cutoff=told["shortest"], **make).height.values
        out["height"] = out.height.copy(data=stretched(narrow, n))
    return out, round(told["pixel"] / cell)


def stretched(height, n):
    """Return heights drawn out along x to n points: the same waves over a longer side."""
    waves = np.fft.rfft(height, axis=0)
    return np.fft.irfft(waves, n, axis=0) * n / height.shape[0]


def read(told):
    """Return a measured map, or a quarter of it."""
    if told["map"] == "park":
        scan = roughxr.open_scan(MAPS / "park_1um_512_grains.tiff")
        i, j = divmod(told["part"], 2)
        return roughxr.level(scan.isel(x=slice(256 * i, 256 * (i + 1)), y=slice(256 * j, 256 * (j + 1))))
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(MAPS / "uncd_container_ccby.zip") as container:
        (name,) = (name for name in container.namelist() if name.endswith(".001"))
        return roughxr.level(roughxr.open_scan(container.extract(name, folder)).load())


def picture(truth, n, told):
    """Return the truth as a microscope draws it, on pixels of n cells."""
    drawn = roughxr.scans.dilate(truth, tip_radius=told["tip"])
    if told["averaged"]:
        coarse = drawn.coarsen(x=n, y=n, boundary="trim").mean()
    else:
        coarse = drawn.isel(x=slice(n // 2, None, n), y=slice(n // 2, None, n))
    noise = np.random.default_rng(told["seed"]).normal(0, NOISE, coarse.height.shape)
    return coarse.assign(height=coarse.height + noise)


def looked_at(told):
    """Return the truth and its picture with the pair, and the places."""
    truth, n = surface(told)
    seen, pair = picture(truth, n, told), {"sphere_radius": told["radius"], **PAIRS[told["pair"]]}
    truth, seen = truth.contact.assign_pair(**pair), seen.contact.assign_pair(**pair)
    return truth, seen, roughxr.scans.regions.centres(seen, GRID)


def true(told):
    """Return the mean pull-off of the truth, with all its waves and without its last octave, and the picture's (nN)."""
    truth, seen, places = looked_at(told)
    end, pixel = told["shortest"], float(seen.x.diff("x")[0])
    before, fine = solved(truth, places, [2 * end, end])
    return {"truth": fine, "octave before": before, "picture": solved(seen, places, [2 * pixel])[0]}


def solved(ds, places, waves):
    """Return the mean pull-off (nN) with waves down to each of some lengths, as `extrapolated` solves it."""
    problem, adhesion = settling(ds)
    out, guess = [], None
    for wave in waves:
        none_added = Below(Spectrum(0.0, 1.0, 0.5, wave), wave, wave)
        drawn = Surface(roughxr.scans.smooth(ds, shortest=wave), problem, places)
        found = drawn.solve(Question(problem, adhesion, none_added), range(places.sizes["subregion"]), 1, guess)
        guess = next_guess(found, guess)
        out.append(float(found[..., 0].mean()))
    return out


def asked(told, known):
    """Return what is said of the truth from the picture."""
    seen, places = looked_at(told)[1:]
    ends = "map" not in told and abs(np.log(known["octave before"] / known["truth"])) < 0.1
    try:
        said = roughxr.extrapolated(seen, subregions=places, seeds=2, shortest=None if ends else told["shortest"])
    except ValueError as error:
        return {"lower": 0.0, "mean": np.nan, "upper": known["picture"], "end": np.nan, "free": bool(ends)} | {
            "entries": dict.fromkeys(SHOWN, np.nan),
            "words": str(error),
        }
    entries = dict(zip(said.entry.values.tolist(), said.relative_error.values.tolist()))
    out = {name: float(said[f"pull_off_{name}"]) for name in ("lower", "mean", "upper")}
    return out | {"end": float(said.shortest_wavelength), "free": bool(ends), "entries": entries, "words": said.assumed}


class Kept:
    """A file of what has been found, by the settings of a case."""

    def __init__(self, folder, name):
        self.path = Path(folder) / f"{name}.json" if folder else None
        self.known = json.loads(self.path.read_text()) if folder and self.path.exists() else {}

    def once(self, told, find, again=False):
        """Return what is known for the settings, or find it."""
        key = json.dumps(told, sort_keys=True)
        if again or key not in self.known:
            began = time.process_time()
            self.known[key] = find() | {"seconds": time.process_time() - began}
            if self.path:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                self.path.write_text(json.dumps(self.known, indent=1))
        return self.known[key]


def off(known, said):
    """Return by how many stated standard deviations the answer is off: of all entries, and of what can be shown."""
    error, entries = np.log(said["mean"] / known["truth"]), said["entries"]
    parts = [list(entries.values()), [entries[name] for name in SHOWN if name in entries]]
    return [float(error / np.sqrt(np.nansum(np.square(part)))) for part in parts]


def row(told, known, said):
    """Return the printed row of a case."""
    what = told["map"] if "map" in told else f"H {told['hurst']:.1f} {told['rms']:3g}/{told['rolloff']:3g}"
    drawn = f"{told['tip']:4.1f} {told['pixel']:3g} {'mean' if told['averaged'] else 'point'}"
    whole, shown = off(known, said)
    first = (
        f"{told['seed']:4d} {what:14s} {told['pair']:14s} {told['radius']:4g} {drawn} {told.get('stretch', 1):3g} "
        f"{said['end']:5.1f}{'*' if said['free'] else ' '} | {known['truth']:7.2f} {known['picture']:8.2f}  "
    )
    if np.isnan(said["mean"]):
        return f"{first}not extrapolated, the bound holds: {'yes' if known['truth'] <= said['upper'] else 'NO '}"
    inside = "yes" if said["lower"] <= known["truth"] <= said["upper"] else "NO "
    return first + (
        f"{said['mean']:7.2f} ({said['lower']:7.2f} … {said['upper']:7.2f})  {whole:5.1f} {shown:5.1f}  "
        f"{inside} {known['seconds']:4.0f} {said['seconds']:4.0f}"
    )


def sums(rows):
    """Return what all cases together say: truth, answer, picture and how far off, a row each."""
    truth, said, coarse, whole, shown = np.array(rows).T
    bounds = coarse[np.isnan(said)] >= truth[np.isnan(said)]
    truth, said, coarse, whole, shown = np.array(rows)[np.isfinite(said)].T
    inside = [int((abs(one) < 1.96).sum()) for one in (whole, shown)]
    middle = np.exp(np.mean(np.log([said / truth, coarse / truth]), axis=1))
    return (
        f"inside the stated interval: {inside[0]} of {whole.size}, of what can be shown alone: {inside[1]}; "
        f"standard deviation in stated ones: {np.sqrt(np.mean(whole**2)):.2f} and {np.sqrt(np.mean(shown**2)):.2f}\n"
        f"said over truth: {np.mean(said / truth):.2f} in the mean, {middle[0]:.2f} in the geometric mean; "
        f"the picture's: {middle[1]:.2f}\n"
        f"not extrapolated: {bounds.size}, of which the bound holds for {bounds.sum()}"
    )


def draw(truths, answers, path):
    """Draw what is said against the truth, of all cases that a cache holds."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    axes = figure.subplots()
    groups = {
        "looked at while building": ("tab:gray", lambda told: told["seed"] < 1000),
        "held out": ("tab:blue", lambda told: 1000 <= told["seed"] < 2000),
        "measured maps": ("tab:orange", lambda told: told["seed"] >= 2000),
    }
    for name, (colour, belongs) in groups.items():
        chosen = [key for key in answers if key in truths and belongs(json.loads(key))]
        if not chosen:
            continue
        truth, picture = (np.array([truths[key][one] for key in chosen]) for one in ("truth", "picture"))
        low, mean, high = (np.array([answers[key][one] for key in chosen]) for one in ("lower", "mean", "upper"))
        style = {"color": colour, "fmt": "o", "markersize": 4, "linewidth": 1, "label": f"extrapolated: {name}"}
        axes.errorbar(truth, mean, [mean - low, high - mean], **style)
        axes.plot(truth[np.isnan(mean)], high[np.isnan(mean)], "v", color=colour, markersize=5)
        axes.plot(truth, picture, "x", color=colour, markersize=4, alpha=0.6)
    known = [truths[key]["truth"] for key in answers if key in truths]
    ends = np.array([0.7 * min(known), 1.4 * max(known)])
    axes.plot(ends, ends, color="black", linewidth=0.8)
    axes.plot([], [], "x", color="tab:gray", label="the picture as it is")
    axes.plot([], [], "v", color="tab:gray", label="not extrapolated: the bound alone")
    axes.set(xscale="log", yscale="log", xlabel="truth, nN", ylabel="said from the coarse picture, nN")
    axes.set(xlim=ends, ylim=ends * [0.1, 4])
    axes.legend(fontsize=8, loc="lower right")
    figure.savefig(path, dpi=90)


def cost():
    """Print what `extrapolated` takes on the glass twin."""
    scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    roughxr.extrapolated(scan, subregions=(1, 1), seeds=1, shortest=20)
    for side, seeds in ((4, 2), (8, 4)):
        processor, wall = time.process_time(), time.monotonic()
        found = roughxr.extrapolated(scan, subregions=(side, side), seeds=seeds)
        processor, wall = time.process_time() - processor, time.monotonic() - wall
        print(
            f"{side * side} places, {seeds} surfaces, waves to {float(found.shortest_wavelength):.2g} nm: "
            f"{processor:.0f} s of processor time ({side * side * seeds / processor:.2g} places a second), "
            f"{wall:.0f} s of wall time; {float(found.pull_off_mean):.3g} nN "
            f"({float(found.pull_off_lower):.3g} … {float(found.pull_off_upper):.3g})",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--held-out", action="store_true", help="the cases that nothing was tuned on")
    parser.add_argument("--cases", type=int, help="on the grid 14, at random 22, if not given")
    parser.add_argument("--cache", help="a folder for truths and answers")
    parser.add_argument("--again", action="store_true", help="ask anew what the cache holds")
    parser.add_argument("--figure", help="a picture of all cases in the cache")
    parser.add_argument("--cost", action="store_true", help="how long it takes on the glass twin, in place of cases")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    if given.cost:
        return cost()
    cases = [on_grid(k) for k in range(given.cases or 14)]
    if given.held_out:
        cases = [at_random(k) for k in range(given.cases or 22)] + (measured() if MAPS.exists() else [])
    truths, answers, rows = Kept(given.cache, "truths"), Kept(given.cache, "answers"), []
    print("seed surface        pair           R, nm tip pixel long   end  |   truth  picture  said (95 % interval)")
    for told in cases:
        known = truths.once(told, lambda told=told: true(told))
        said = answers.once(told, lambda told=told, known=known: asked(told, known), given.again)
        rows.append((known["truth"], said["mean"], known["picture"], *off(known, said)))
        print(row(told, known, said), flush=True)
    print(sums(rows))
    if given.figure:
        draw(truths.known, answers.known, given.figure)


if __name__ == "__main__":
    main()
