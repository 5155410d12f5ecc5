"""How often `compare` finds that places explain the scatter of 20 measured forces.

    python tests/benchmarks/scatter_verdict.py [--draws 200]

Predicted are 64 independent places with a relative standard deviation of 30 %, measured 20 forces of the same law with
one 0.4, 1 or 2.5 times as large. Prints the shares of the draws whose scatter is called less, explained, more and
undecided.
"""

import argparse

import numpy as np
import xarray as xr

import roughxr

PREDICTED_SCATTER = 0.3
PLACES = 64
MEASURED = 20


def drawn(rng, law, scatter, count):
    """Return forces with a mean of 1 and a relative standard deviation."""
    if law == "log-normal":
        return rng.lognormal(-0.5 * np.log1p(scatter**2), np.sqrt(np.log1p(scatter**2)), count)
    if law == "gamma":
        return rng.gamma(scatter**-2, scatter**2, count)
    return np.maximum(rng.normal(1, scatter, count), 0.01)


def verdict(ratio, rng, law):
    """Return what the sentence decides of one draw."""
    values = [drawn(rng, law, PREDICTED_SCATTER, PLACES), 3 * drawn(rng, law, ratio * PREDICTED_SCATTER, MEASURED)]
    predicted, measured = (xr.Dataset({"pull_off_force": ("subregion", row, {"units": "nN"})}) for row in values)
    sentence = roughxr.answer(roughxr.compare(predicted, measured, statistics=["mean"], resamples=199)).sentence
    sentence_parts = {"scatter less": "less", "explains the scatter (": "explained", "scatter more": "more"}
    return next((name for part, name in sentence_parts.items() if part in sentence), "undecided")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--draws", type=int, default=200)
    options = parser.parse_args()
    print("law          ratio   less  explained   more  undecided")
    for law in ("log-normal", "gamma", "normal"):
        for ratio in (0.4, 1.0, 2.5):
            rng = np.random.default_rng(0)
            verdicts = [verdict(ratio, rng, law) for _ in range(options.draws)]
            shares = [verdicts.count(name) / options.draws for name in ("less", "explained", "more", "undecided")]
            print(f"{law:12} {ratio:5.1f} " + " ".join(f"{100 * share:6.1f}%" for share in shares))


if __name__ == "__main__":
    main()
