"""Coverage of intervals of the mean pull-off force where many curves give a limit only.

    python tests/benchmarks/censored_curves.py [--trials 40] [--count 64] [--seed 0]

Retractions with white noise and exponential or log-normal pulls, of which 0, 30, 60 or 90 % lie below the detection
limit. For each: the share of trials whose interval contains the true mean, by bounds and by the likelihood with
censoring; the median interval of each, and the mean of the measured forces alone, over the true mean; and the number of
trials with too few measured forces for a likelihood.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from roughxr.measured import curves_pull_off
from roughxr.statistics import bootstrap
from tests.force_curves import weak_retractions

#: Depth that is detected, in standard deviations of the noise.
DETECTED = 5.0

SHARES = (0.0, 0.3, 0.6, 0.9)

#: Quantile functions of the pulls' laws with scale 1, and their means.
LAWS = {
    "exponential": (lambda share: -np.log1p(-share), 1.0),
    "log-normal": (lambda share: np.exp(0.5 * _normal_quantile(share)), np.exp(0.125)),
}


def _normal_quantile(share):
    from scipy.stats import norm

    return norm.ppf(share)


def trial(rng, quantile, scale, count):
    """Return the interval of the mean of made curves, and the mean of the measured forces alone."""
    pulls = scale * quantile(rng.uniform(size=count))
    measured = curves_pull_off(weak_retractions(rng, pulls))
    mean = bootstrap(measured, "pull_off_force", statistics=["mean"]).squeeze()
    names = ("low", "high", "likelihood_low", "likelihood_high")
    ends = [float(mean[name]) if name in mean else float(mean[name.removeprefix("likelihood_")]) for name in names]
    return [*ends, float(measured.pull_off_force.mean())]


def main():
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--trials", type=int, default=40)
    options.add_argument("--count", type=int, default=64)
    options.add_argument("--seed", type=int, default=0)
    options = options.parse_args()
    print(
        f"{'law':12s} {'below':>6s} {'bounds':>7s} {'':>14s} {'likelihood':>10s} {'':>14s} {'too few':>8s} {'rest':>6s}"
    )
    for name, (quantile, mean) in LAWS.items():
        for below in SHARES:
            scale = DETECTED / quantile(max(below, 0.01)) * (1 if below else 1.5)
            seeds = range(options.seed, options.seed + options.trials)
            rows = np.array([trial(np.random.default_rng(seed), quantile, scale, options.count) for seed in seeds])
            rows /= scale * mean
            low, high, law_low, law_high, law_shift = rows.T
            is_fitted = np.isfinite(law_low)
            by_bounds = ((low <= 1) & (high >= 1)).mean()
            by_law = ((law_low <= 1) & (law_high >= 1))[is_fitted].mean()
            widths = [
                f"{np.nanmedian(start):.2f} … {np.nanmedian(end):.2f}"
                for start, end in ((low, high), (law_low, law_high))
            ]
            print(
                f"{name:12s} {below:6.0%} {by_bounds:7.2f} {widths[0]:>14s} {by_law:10.2f} {widths[1]:>14s} "
                f"{(~is_fitted).sum():8d} {np.nanmedian(law_shift):6.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
