"""How often a curve's stated error holds the sphere's pull-off, and an interval of many curves its work of adhesion.

JKR spheres with noise, offset, drift and virtual deflection. Run as ``python tests/benchmarks/curve_rates.py``.
"""

import sys
from pathlib import Path

import numpy as np
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[2]))

import roughxr
from tests import force_curves as made

TRIALS, CURVES = 40, 25


def retractions(rng, count, noise, n=1000):
    step = 950.0 / n
    piezo = np.linspace(150.0, -800.0, n) + step * rng.uniform(size=(count, 1))  # it is torn off between samples
    force = np.stack([made.recorded(rng, one, noise) for one in piezo])
    ds = xr.Dataset({"piezo": (("subregion", "sample"), piezo), "force": (("subregion", "sample"), force)})
    return roughxr.measured.curves_pull_off(roughxr.schema.label(ds), spring_constant=made.STIFFNESS)


def held(ds):
    """Return whether the 95 % interval of the mean holds the work of adhesion that the curves were made of."""
    mean = roughxr.bootstrap(ds, "pull_off_force", statistics=["mean"], resamples=299).sel(resampling="block")
    low, high = (float(mean[end].squeeze()) / (1.5 * np.pi * made.RADIUS) for end in ("low", "high"))
    return low < made.WORK < high


def rates(noise):
    rng = np.random.default_rng(0)
    trials = [retractions(rng, CURVES, noise) for _ in range(TRIALS)]
    off = np.concatenate([(ds.pull_off_force - made.PULL) / ds.pull_off_uncertainty for ds in trials])
    bias = np.concatenate([ds.pull_off_force / made.PULL - 1 for ds in trials]).mean()
    inside = [np.mean(np.abs(off) < k) for k in (1.0, 1.96)]
    return f"{noise:8.1f} {inside[0]:10.2f} {inside[1]:10.2f} {np.mean([held(ds) for ds in trials]):10.2f} {bias:12.4f}"


if __name__ == "__main__":
    print("noise nN  within 1 s  within 1.96  w held at 95 %  bias of the pull-off")
    for noise in (0.03, 0.3, 1.0, 4.0):
        print(rates(noise))
