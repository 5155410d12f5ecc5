"""Coverage of intervals of the mean pull-off force where many curves give a limit only.

    python tests/benchmarks/censored_curves.py [--trials 40] [--count 64] [--seed 0]

Retractions with white noise and exponential or log-normal pulls, of which 0, 30, 60 or 90 % lie below the detection
limit. For each: the share of trials whose interval contains the true mean, by bounds and by the likelihood with
censoring; the median interval of each, and the mean of the measured forces alone, over the true mean; and the number of
trials with too few measured forces for a likelihood. Then soft curves with drift (``--soft``): its amplitude, the
share of maps whose likelihood, and whose bounds, contain the map's mean, the shares of pulls that are detected, of
these within two standard errors, and of limits that hold, and the median limit over the noise.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from roughxr.measured import curves_pull_off
from roughxr.statistics import bootstrap
from tests.force_curves import TENSIONS, soft_retractions, weak_retractions

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


#: Amplitudes (nN) and range of periods (nm) of the drift of soft curves; range of the shares without a visible pull.
DRIFTS = (0.0, 0.05, 0.15)
PERIODS = (2000.0, 9000.0)
HIDDEN = (0.1, 0.9)

#: Noise, and depth that is about detected, nN.
SOFT_NOISE, SOFT_DETECTED = 0.006, 0.02


def soft_trial(rng, drift, tension, count):
    """Return the scores of one map of soft curves, whose pulls are exponential, or zero or log-normal."""
    hidden = rng.uniform(*HIDDEN)
    pulls = SOFT_DETECTED / -np.log1p(-hidden) * rng.exponential(size=count)
    if rng.uniform() < 0.5:
        pulls = np.where(rng.uniform(size=count) < hidden, 0.0, 0.1 * rng.lognormal(0, 0.5, count))
    measured = curves_pull_off(soft_retractions(rng, pulls, drift, rng.uniform(*PERIODS), tension=tension))
    force = measured["pull_off_force"].values
    error = measured["pull_off_standard_error"].values
    limit = measured["pull_off_at_most"].values
    is_measured = np.isfinite(force)
    mean = bootstrap(measured, "pull_off_force", statistics=["mean"]).squeeze()
    ends = [(mean[f"{by}low"], mean[f"{by}high"]) for by in ("likelihood_", "") if f"{by}low" in mean]
    contained = [bool(low <= pulls.mean() <= high) for low, high in ends]
    return (
        contained[0] if np.isfinite(ends[0][0]) else np.nan,
        contained[-1],
        is_measured.mean(),
        (np.abs(force - pulls) < 2 * error)[is_measured].mean() if is_measured.any() else np.nan,
        (pulls <= limit)[~is_measured].mean() if not is_measured.all() else np.nan,
        np.nanmedian(limit) / SOFT_NOISE,
    )


def soft_table(seeds, count):
    """Print the scores of maps of soft curves."""
    print("drift, nN  likelihood  bounds  detected  within 2  limits hold  limit / noise")
    for drift in DRIFTS:
        tensions = list(TENSIONS)
        rows = [soft_trial(np.random.default_rng(seed), drift, tensions[seed % 3], count) for seed in seeds]
        shares = np.nanmean(np.array(rows)[:, :5], axis=0)
        limit = np.nanmedian(np.array(rows)[:, 5])
        print(f"{drift:9.2f}  " + "  ".join(f"{share:8.2f}" for share in shares) + f"  {limit:8.1f}", flush=True)


def main():
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--trials", type=int, default=40)
    options.add_argument("--count", type=int, default=64)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--soft", action="store_true")
    options = options.parse_args()
    if options.soft:
        soft_table(range(options.seed, options.seed + options.trials), options.count)
        return
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
