"""How often `fit_pair`'s interval holds the work of adhesion with which the simulation made the forces, and its bias.

    python tests/benchmarks/fitted_work.py FILE [hidden]

Four kinds of self-affine surface, five of each, of 64 × 64 pixels of 8 nm under a sphere of 1 µm with E* = 40 GPa and
the exponential law of 0.3 nm. On each, with w = 0.05 and 0.2 J/m², pull-offs are simulated at 20 random places; a set
is 12 of them, with 5 % noise of each and a calibration common to all that is off by 10 % in standard deviation, which
the fit is told. Five sets of each make 200. The scan is every second pixel along both axes; on it, divided into cells
as small as the surface's, the fit predicts at 4 × 4 places. What it asks of the simulation is interpolated between five
works of adhesion, so that the sets of a surface share their solves. Each set is fitted on the scan of its own surface,
and on that of another surface of its kind, as if the scan was taken elsewhere.

The surfaces have no waves shorter than 64 nm, which the scan shows; "hidden" continues them down to 16 nm, two pixels
of the surface and one of the scan. Results are appended to FILE, and what it holds is not computed again: about five
minutes of processor time for each of both.
"""

import json
import sys
import warnings
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

import roughxr
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.studies import fitting

QUICK = {"law": "exponential", "mesh": roughxr.Mesh(1, step=0.5)}
PAIR = {"sphere_radius": 1000, "contact_modulus": 40, "work_of_adhesion": 0.1, "adhesion_range": 0.3}

#: rms (nm), Hurst exponent and roll-off wavelength (nm) of each kind.
KINDS = {"low": (1.0, 0.8, 160), "high": (1.5, 0.8, 160), "flat": (1.0, 0.6, 240), "long": (1.5, 0.9, 240)}
WORKS = (0.05, 0.2)
TABLE = np.geomspace(0.0125, 0.8, 5)
SURFACES = 5
SETS = 5
PLACES = 20
MEASURED = 12
NOISE = 0.05
CALIBRATION = 0.1


class Surface:
    """A surface, the forces on it by w, and the emulator of the simulation on its scan."""

    def __init__(self, kind: str, seed: int, shortest: float):
        rms, hurst, rolloff = KINDS[kind]
        fine = self_affine((64, 64), 8.0, rms=rms, hurst=hurst, rolloff=rolloff, cutoff=shortest, seed=seed)
        fine = fine.contact.assign_pair(**PAIR)
        self.rng = np.random.default_rng(seed)
        places = tuple(self.rng.uniform(-190, 190, (2, PLACES)) + [[float(fine[axis].mean())] for axis in "xy"])
        self.forces = {work: simulated(fine, work, places)["pull_off_force"].values for work in WORKS}
        self.scan = fine.isel(x=slice(0, None, 2), y=slice(0, None, 2))
        solved = [simulated(self.scan, work, (4, 4), mesh=roughxr.Mesh(2, step=0.5)) for work in TABLE]
        self.like = solved[0]
        self.ln_force = PchipInterpolator(
            np.log(TABLE), np.log([solution["pull_off_force"].values for solution in solved])
        )

    def predicted(self, ds: xr.Dataset, **options) -> xr.Dataset:
        """Return what the simulation would, interpolated; in place of it."""
        work = float(ds["work_of_adhesion"])
        if not TABLE[0] <= work <= TABLE[-1]:
            raise ValueError("beyond the works of adhesion that were solved")
        return self.like.assign(pull_off_force=("subregion", np.exp(self.ln_force(np.log(work)))))

    def measured(self, work: float) -> xr.Dataset:
        """Return a set of forces."""
        places = self.rng.choice(PLACES, MEASURED, replace=False)
        noise = NOISE * self.rng.standard_normal(MEASURED) + CALIBRATION * self.rng.standard_normal()
        return xr.Dataset({"pull_off_force": ("subregion", self.forces[work][places] * np.exp(noise))})


def simulated(ds: xr.Dataset, work: float, places, **mesh) -> xr.Dataset:
    """Return pull-offs at places."""
    return ds.assign_coords(work_of_adhesion=work).contact.adhesive(subregions=places, **QUICK | mesh)


def fitted(surface: Surface, measured: xr.Dataset, work: float) -> list[float]:
    """Return the fitted w and the ends of its interval over the true one."""
    fitting.METHODS["adhesive"] = surface.predicted, fitting.METHODS["adhesive"][1]
    fit = surface.scan.contact.fit_pair(measured, force_std=CALIBRATION, **QUICK)
    return [float(fit[f"fitted_work_{name}"]) / work for name in ("of_adhesion", "low", "high")]


def sets_of(kind: str, shortest: float) -> list[dict]:
    """Return the fits of all sets of a kind."""
    surfaces = [Surface(kind, 100 * list(KINDS).index(kind) + seed, shortest) for seed in range(SURFACES)]
    rows = []
    for k, surface in enumerate(surfaces):
        for work in WORKS * SETS:
            measured = surface.measured(work)
            other = surfaces[(k + 1) % SURFACES]
            fits = {"own": fitted(surface, measured, work), "other": fitted(other, measured, work)}
            rows.append({"kind": kind, "shortest": shortest, "surface": k, "work": work, **fits})
    return rows


def main(file: Path, shortest: float) -> None:
    """Fit what the file lacks, and print coverage, bias and width."""
    warnings.simplefilter("ignore")
    stored = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    for kind in KINDS:
        if not any(row["kind"] == kind and row["shortest"] == shortest for row in stored):
            stored += (new := sets_of(kind, shortest))
            with file.open("a") as out:
                out.writelines(json.dumps(row) + "\n" for row in new)
        for scan in ("own", "other"):
            told(f"{kind}, {scan}", [row for row in stored if row["kind"] == kind], shortest, scan)
    for scan in ("own", "other"):
        told(f"all, {scan}", stored, shortest, scan)


def told(name: str, rows: list[dict], shortest: float, scan: str) -> None:
    """Print one row; an open end of an interval counts as holding nothing, and surfaces, not sets, as independent."""
    rows = [row for row in rows if row["shortest"] == shortest]
    ratio, low, high = np.array([row[scan] for row in rows]).T
    held = (low < 1) & (1 < high)
    logs = np.log(ratio)
    groups = [f"{row['kind']} {row['surface']}" for row in rows]
    means = [np.nanmean(logs[np.array(groups) == group]) for group in sorted(set(groups))]
    error = np.std(means, ddof=1) / np.sqrt(len(means))
    line = f"{name:12s} {ratio.size:4d} fits, {held.mean():5.1%} held, mean of ln {np.nanmean(logs):+.3f} ± {error:.3f}"
    print(f"{line}, high/low {np.nanmedian(high / low):.2f}", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), 16.0 if sys.argv[2:] == ["hidden"] else 64.0)
