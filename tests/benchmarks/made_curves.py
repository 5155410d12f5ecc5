"""Score pull-off forces and their errors on made retractions of known pulls, with interference, tilt, drift and tails.

    python tests/benchmarks/made_curves.py [--count 200] [--seed 100000]

For each kind of curve: numbers of values and of limits, the share of values within two standard errors, the bias of
their mean, the median stated error and the rms of the deviations over it; and the share of limits that hold.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from roughxr.files.curves.force_curves import evaluated_retraction
from tests.force_curves import (
    SLOW_RETURNS,
    fringes_without_pull,
    retraction_with_fringes,
    retraction_with_slow_return,
    retraction_with_tail,
)

AMPLITUDES = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2)


def weak(rng, pull, fringes=0.0):
    """Return a retraction with a pull in units of the noise, and fringes about its baseline."""
    z = np.linspace(150.0, -450.0, 1500)
    force = np.where(z > -pull / 2.0, 2.0 * z, 0.0) + fringes * np.sin(2 * np.pi * z / 330 + rng.uniform(0, 6))
    return z, force + rng.normal(0, 1, z.size), pull


def scored(name, curves):
    """Print the line of one kind."""
    results = [evaluated_retraction(z, force, np.inf, 1.0) for z, force, _ in curves]
    true = np.array([pull for *_, pull in curves])
    force, error, limit = (
        np.array([getattr(result, name) for result in results])
        for name in ("pull_off_force", "pull_off_standard_error", "pull_off_at_most")
    )
    measured = np.isfinite(force)
    limited = np.isfinite(limit)
    off = ((force - true) / error)[measured]
    true_or_nan = np.where(true > 0, true, np.nan)
    relative = (force / true_or_nan - 1)[measured]
    holds = f"{(limit >= true)[limited].mean():.2f}" if limited.any() else "–"
    values = "–" * 5 if not measured.any() else ""
    if measured.any():
        values = (
            f"{(np.abs(off) < 2).mean():8.2f} {relative.mean():+8.1%} {np.median((error / true_or_nan)[measured]):8.1%}"
        )
        values += f" {np.sqrt((off**2).mean()):8.2f}"
    print(f"{name:32s} {len(curves):6d} {measured.sum():6d} {limited.sum():6d} {values:>36s} {holds:>6s}", flush=True)


def main():
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--count", type=int, default=200)
    options.add_argument("--seed", type=int, default=100_000)
    options = options.parse_args()
    print(f"{'kind':32s} {'curves':>6s} {'values':>6s} {'limits':>6s} {'within 2':>8s} {'bias':>8s} {'error':>8s}"
          f" {'rms':>8s} {'hold':>6s}")  # fmt: skip
    seeds = range(options.seed, options.seed + options.count)
    for shape in ("sine", "chirp", "two", "triangle"):
        for amplitude in AMPLITUDES:
            made = [retraction_with_fringes(np.random.default_rng(seed), amplitude, shape=shape) for seed in seeds]
            scored(f"{shape}, {amplitude:.1%} of the pull", made)
    for kind in ("jump", "linear tail", "exponential tail", "fringe", "second rupture", "slow noise"):
        scored(kind, [retraction_with_tail(np.random.default_rng(seed), kind) for seed in seeds])
    for kind in SLOW_RETURNS:
        made = [retraction_with_slow_return(np.random.default_rng(seed), kind) for seed in seeds]
        scored(f"slow return, {kind}", made)
    for pull in (0, 2, 4, 6, 8, 12, 20):
        scored(f"pull of {pull} noises", [weak(np.random.default_rng(seed), float(pull)) for seed in seeds])
    for pull in (0, 6, 12, 20):
        made = [weak(np.random.default_rng(seed), float(pull), 3.0) for seed in seeds]
        scored(f"pull of {pull} noises, fringes of 3", made)
    for shape in ("sine", "triangle"):
        for amplitude in (1, 3, 10, 30):
            made = [(*fringes_without_pull(np.random.default_rng(seed), amplitude, shape=shape), 0.0) for seed in seeds]
            scored(f"no pull, {shape} of {amplitude} noises", made)


if __name__ == "__main__":
    main()
