"""Best estimates from coarse images of self-affine surfaces, against the surfaces themselves.

    python tests/benchmarks/below_the_pixel.py [--held-out] [--cases N] [--cache FILE] [--figure FILE --measured FILE]

Each case draws a self-affine surface with wavelengths down to 2 or 4 nm: the truth. It is imaged as a microscope would:
a round tip, larger pixels, sampled or averaged, noise of 0.05 nm. `roughxr.extrapolated` estimates the mean pull-off at
six places from the image. If the last octave of the truth still changes its pull-off by more than a tenth, the estimate
is asked to end at the same wavelength.

The settings of the first cases lie on a grid and were seen while the method was developed. With ``--held-out`` they are
drawn at random over wider ranges, and nothing was tuned on them. A cache keeps solved cases. ``--figure`` draws the
cases of the cache together with those of measured surfaces, from the cache of ``real_below_the_pixel.py``.
"""

import argparse
import json
import warnings
from pathlib import Path

import numpy as np
from real_below_the_pixel import FINEST, GRID, picture, solved, summary

import roughxr
from roughxr.scans.synthetic import self_affine

#: Pairs of bodies: E* (GPa), w (J/m²), hardness (GPa).
PAIRS = {
    "glass": {"contact_modulus": 39.4, "work_of_adhesion": 0.1},
    "polymer": {"contact_modulus": 3.0, "work_of_adhesion": 0.08},
    "yielding glass": {"contact_modulus": 39.4, "work_of_adhesion": 0.2, "hardness": 6.0},
}
HURSTS, TIPS, PIXELS, SHORTEST = (0.5, 0.7, 0.9), (5.0, 10.0), (4.0, 8.0), (4.0, FINEST)
NOISE = 0.05


def on_grid(k):
    """Return the settings of a case that was seen during development."""
    case = {
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
    return with_end(case, SHORTEST[(k // 2) % 2])


def at_random(k):
    """Return the settings of a held-out case."""
    draw = np.random.default_rng(1000 + k)
    case = {
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
    return with_end(case, float(draw.choice(SHORTEST)))


def with_end(case, shortest):
    """Return the settings with the shortest wavelength of the truth, nm; polymers need more cells, so theirs is 4."""
    return case | {"shortest": max(shortest, 4.0) if case["pair"] == "polymer" else shortest}


def surface(case):
    """Return the true surface, on four cells to its shortest wavelength."""
    cell = case["shortest"] / 4
    n, options = (
        int((512 if cell < 1 else 768) / cell),
        {name: case[name] for name in ("rms", "hurst", "rolloff", "seed")},
    )
    out = self_affine((n, n), cell, cutoff=case["shortest"], **options)
    if case["stretch"] != 1:  # the same waves over a longer side
        narrow = self_affine((round(n / case["stretch"]), n), cell, cutoff=case["shortest"], **options).height.values
        waves = np.fft.rfft(narrow, axis=0)
        out["height"] = out.height.copy(data=np.fft.irfft(waves, n, axis=0) * n / narrow.shape[0])
    return out


def compared(case):
    """Return truth, image and estimate with its interval (nN) of one case."""
    truth, pair = surface(case), {"sphere_radius": case["radius"], **PAIRS[case["pair"]]}
    cells = round(case["pixel"] / float(truth.x[1] - truth.x[0]))
    image = picture(truth, cells, case["averaged"], case["tip"], NOISE, seed=case["seed"])
    truth, image = truth.contact.assign_pair(**pair), image.contact.assign_pair(**pair)
    centres, end = roughxr.scans.regions.centres(image, GRID), case["shortest"]
    pulls = {"truth": solved(truth, centres, end), "picture": solved(image, centres, 2 * case["pixel"])}
    ended = abs(np.log(solved(truth, centres, 2 * end) / pulls["truth"])) < 0.1
    out = roughxr.extrapolated(image, subregions=centres, seeds=2, shortest=None if ended else end)
    return pulls | {key: float(out[f"pull_off_{key}"]) for key in ("mean", "lower", "upper")}


def figure(groups, path):
    """Draw estimates over truths with their intervals, and the images' pull-offs."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    axes = (drawn := Figure(figsize=(8.4, 3.9), layout="constrained")).subplots(1, len(groups), squeeze=False)[0]
    for each, (name, rows) in zip(axes, groups.items()):
        truth, image, mean, low, high = (np.array([row[key] for row in rows]) for key in KEYS)
        each.errorbar(truth, mean, [mean - low, high - mean], fmt="o", markersize=4, linewidth=1, label="best estimate")
        each.plot(truth, image, "x", color="tab:orange", markersize=5, label="as scanned")
        ends = np.array([0.7 * truth.min(), 1.4 * truth.max()])
        each.plot(ends, ends, color="black", linewidth=0.8, label="equal")
        each.set(xscale="log", yscale="log", xlim=ends, title=name)
        each.set(xlabel="pull-off of the full surface (nN)", ylabel="from the coarse image (nN)")
        each.xaxis.set_minor_formatter(NullFormatter())
    axes[0].legend(fontsize=8)
    drawn.savefig(path, dpi=110)


KEYS = ("truth", "picture", "mean", "lower", "upper")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--held-out", action="store_true", help="the cases on which nothing was tuned")
    parser.add_argument("--cases", type=int, help="on the grid 14, held out 22, if not given")
    parser.add_argument("--cache", type=Path, help="a file of solved cases")
    parser.add_argument("--figure", help="a picture of all cases in the cache")
    parser.add_argument("--measured", type=Path, help="the cache of real_below_the_pixel.py, for the picture")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    known = json.loads(given.cache.read_text()) if given.cache and given.cache.exists() else {}
    cases = [at_random(k) for k in range(given.cases or 22)] if given.held_out else []
    cases = cases or [on_grid(k) for k in range(given.cases or 14)]
    print(
        "seed   H  rms/rolloff pair            R, nm  tip pixel | truth  image  estimate (95 % interval), nN",
        flush=True,
    )
    for case in cases:
        key = json.dumps(case, sort_keys=True)
        if key not in known:
            known[key] = compared(case)
            if given.cache:
                given.cache.write_text(json.dumps(known, indent=1))
        row = known[key]
        print(
            f"{case['seed']:4d} {case['hurst']:3.1f} {case['rms']:5g}/{case['rolloff']:3g} {case['pair']:14s} "
            f"{case['radius']:6g} {case['tip']:5.1f} {case['pixel']:3g} | {row['truth']:6.1f} {row['picture']:6.1f} "
            f"{row['mean']:6.1f} ({row['lower']:.1f} … {row['upper']:.1f})"
            f"{'' if row['lower'] <= row['truth'] <= row['upper'] else ', MISSED'}",
            flush=True,
        )
    rows = [known[json.dumps(case, sort_keys=True)] for case in cases]
    summary([case["seed"] for case in cases], [[row[key] for key in KEYS] for row in rows])
    if given.figure:
        groups = {"self-affine surfaces": list(known.values())}
        groups |= {"measured surfaces": list(json.loads(given.measured.read_text()).values())} if given.measured else {}
        figure(groups, given.figure)


if __name__ == "__main__":
    main()
