"""A user's program for the type checker, never run: a function of each kind, with the type that it returns.

`mypy` (configured in pyproject.toml) checks it as strictly as a user may ask, and the package itself less so.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

import roughxr


def scans(path: Path) -> xr.Dataset:
    """Read, mend and describe a scan, and assign a pair of bodies."""
    scan: xr.Dataset = roughxr.open_scan(path, channel=0, size=("10 um", "10 um"), height_units="nm")
    scan = roughxr.fill(roughxr.scans.crop(scan, x=(0, 500), y=("0 nm", "1 um")), method="nearest")
    scan = roughxr.level(roughxr.scans.resample(scan, size="8 nm"), method="cubic")
    written: Path = roughxr.scans.to_file(scan, path, name="height")
    modulus: float = roughxr.reference.contact_modulus((75, 210), (0.22, 0.3))
    pair = roughxr.assign_pair(scan, sphere_radius="3 um", contact_modulus=modulus, work_of_adhesion=0.1)
    return pair if written else roughxr.open_sample("glass")


def contact(scan: xr.Dataset) -> dict[str, xr.Dataset]:
    """Solve by several methods."""
    catalogue: xr.Dataset = roughxr.asperities(scan, patch="paper")
    places: xr.Dataset = roughxr.scans.regions.centres(scan, (8, 8))
    return {
        "direct": roughxr.direct(scan, delta=[1.0, 2.0], subregions=places, fields=True),
        "load": roughxr.direct(scan, load=np.array([100.0]), subregions=(2, 2)),
        "superposed": roughxr.superpose(catalogue, delta=np.arange(3.0), law="dugdale"),
        "adhesive": roughxr.adhesive(scan, preload=[0.0, 100.0], mesh=roughxr.Mesh("auto", accuracy=0.02)),
        "varied": roughxr.vary(scan, roughxr.direct, sphere_radius=[500, 1000], delta=[1.0]),
    }


def statistics(solutions: dict[str, xr.Dataset], path: Path) -> pd.DataFrame:
    """Evaluate samples, and compare them with measurements."""
    pull: xr.Dataset = roughxr.statistics.reduction(roughxr.pull_off(solutions["superposed"]))
    density: xr.DataArray = roughxr.statistics.pdf(pull, "pull_off_force")
    fitted: xr.Dataset = roughxr.statistics.fit(pull, "pull_off_force", laws=["weibull"])
    measured: xr.Dataset = roughxr.open_pull_off([path, path], units="V", sensitivity="12 nN/V")
    beside: xr.Dataset = roughxr.compare(pull, measured, resamples=99)
    table: pd.DataFrame = roughxr.to_table(beside if density.size and fitted else pull)
    return table


def particles(scan: xr.Dataset, path: Path) -> dict[str, xr.Dataset]:
    """Compute the detachment of particles, and a whole run."""
    holds: xr.Dataset = roughxr.rolling(scan, directions=8, subregions=roughxr.particles.resting(scan))
    lines: str = roughxr.particles.to_dem(holds, code="lammps", classes=3)
    resuspended: xr.Dataset = roughxr.particles.resuspension(holds, friction_velocity=[0.1, 1.0])
    roughxr.figures.plot(resuspended, "remaining", ax=None).set_title(lines)
    with roughxr.progress():
        groups: dict[str, xr.Dataset] = roughxr.run(scan, path, subregions=(4, 4), budget=2)
    written: Path = roughxr.report.write_report(path)
    return groups if written else {}
