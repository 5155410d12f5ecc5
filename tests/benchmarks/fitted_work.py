"""How often `fit_pair`'s interval holds the work of adhesion with which the simulation made the forces, and its bias.

    python tests/benchmarks/fitted_work.py [SETS]

Two kinds of self-affine surface (64 × 64 pixels of 8 nm, rms 1 and 1.5 nm, roll-off 120 nm, no waves below 40 nm) under
a sphere of 1 µm with E* = 40 GPa and the exponential law of 0.3 nm, on cells of one pixel; w = 0.05 and 0.2 J/m². Each
set has a surface of its own. On it pull-offs are simulated at 12 random places, with 5 % noise of each and a
calibration common to all that is off by 10 % in standard deviation, which the fit is told. It predicts at 4 × 4 other
places of that surface, from 0.1 J/m² on. By default 10 sets of each kind and w: 40 fits, in about two minutes.

Truth and prediction have the same mesh, and scans show all waves of the surface: roughness finer than the scan, and the
mesh's error, are not part of this.
"""

import sys
import warnings

import numpy as np
import xarray as xr

from roughxr.contact.mesh import Mesh
from roughxr.scans.synthetic import self_affine

QUICK = {"mesh": Mesh(1, step=0.5), "law": "exponential"}
WORKS, RMS, MEASURED, NOISE, CALIBRATION = (0.05, 0.2), (1.0, 1.5), 12, 0.05, 0.1


def surface(rms: float, seed: int) -> xr.Dataset:
    """Return a scan with its pair."""
    ds = self_affine((64, 64), 8.0, rms=rms, hurst=0.8, rolloff=120, cutoff=40, seed=seed)
    return ds.contact.assign_pair(sphere_radius=1000, contact_modulus=40, work_of_adhesion=0.1, adhesion_range=0.3)


def measured_on(ds: xr.Dataset, work: float, rng: np.random.Generator) -> xr.Dataset:
    """Return simulated pull-offs at random places, with noise of each and a calibration of all."""
    places = tuple(rng.uniform(-220, 220, (2, MEASURED)) + [[float(ds[axis].mean())] for axis in "xy"])
    found = ds.assign_coords(work_of_adhesion=work).contact.adhesive(subregions=places, **QUICK)
    noise = NOISE * rng.standard_normal(MEASURED) + CALIBRATION * rng.standard_normal()
    return found.assign(pull_off_force=found.pull_off_force * np.exp(noise))


def fits(rms: float, work: float, seeds: range) -> np.ndarray:
    """Return fitted w and the ends of its interval over the true one, for each set."""
    found = []
    for seed in seeds:
        ds = surface(rms, seed)
        measured = measured_on(ds, work, np.random.default_rng(seed))
        fit = ds.contact.fit_pair(measured, force_error=CALIBRATION, **QUICK)
        found.append([float(fit[f"fitted_work_{name}"]) / work for name in ("of_adhesion", "low", "high")])
    return np.array(found)


def main(sets: int) -> None:
    """Print coverage, bias and width, for each kind and w and for all."""
    warnings.simplefilter("ignore")
    print(" rms/nm  w/(J/m²)  fits  held  median  mean of ln ± its error  high/low")
    every = []
    for rms in RMS:
        for work in WORKS:
            every.append(fits(rms, work, range(len(every) * sets, (len(every) + 1) * sets)))
            line(f"{rms:7.1f} {work:9.2f}", every[-1])
    line(" " * 14 + "all", np.concatenate(every))


def line(name: str, found: np.ndarray) -> None:
    """Print one row; an open end of an interval counts as holding nothing."""
    value, low, high = found.T
    held, logs = (low < 1) & (1 < high), np.log(value)
    error = logs.std(ddof=1) / np.sqrt(logs.size)
    words = f"{name} {value.size:5d} {held.mean():5.0%} {np.median(value):7.3f} {logs.mean():+13.3f} ± {error:.3f}"
    print(f"{words} {np.nanmedian(high / low):13.2f}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
