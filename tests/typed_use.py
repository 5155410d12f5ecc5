"""A user's program, for a type checker to read and nothing to run: every public verb, with the type that it returns.

`mypy` (configured in pyproject.toml) checks it as strictly as a user may ask, and the package itself less so.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

import roughxr
from roughxr import reproduction


def scans(path: Path) -> xr.Dataset:
    """Read, mend and describe a scan."""
    scan: xr.Dataset = roughxr.open_scan(path, channel=0, size=("10 um", "10 um"), height_units="nm")
    scan = roughxr.fill(roughxr.scans.crop(scan, x=(0, 500), y=("0 nm", "1 um")), method="nearest")
    scan = roughxr.level(
        roughxr.scans.rotate90(roughxr.scans.resample(scan, size="8 nm"), turns=2), method="polynomial", order=3
    )
    scan = roughxr.scans.erode(roughxr.scans.dilate(scan, tip_radius=10), tip_radius="10 nm")
    scan = roughxr.scans.add_fine_roughness(roughxr.scans.smooth(scan, shortest="20 nm"), shortest=5, seed=1)
    described: tuple[xr.Dataset, xr.Dataset, xr.Dataset, xr.Dataset] = (
        roughxr.scans.self_affine_fit(scan, shown="30 nm"),
        roughxr.roughness(scan, spectra=False),
        roughxr.scans.power_spectrum(scan, window="hann"),
        roughxr.scans.autocorrelation(scan),
    )
    written: Path = roughxr.scans.to_file(scan, path, name="height")
    return scan if written and described else roughxr.open_sample("glass")


def pair(scan: xr.Dataset) -> xr.Dataset:
    """Assign a pair of bodies."""
    energy: float = roughxr.reference.gilman_surface_energy(75, poisson_ratio=0.22)
    modulus: float = roughxr.reference.contact_modulus((75, 210), (0.22, 0.3))
    return roughxr.assign_pair(scan, sphere_radius="3 um", contact_modulus=modulus, work_of_adhesion=2 * energy)


def contact(scan: xr.Dataset) -> dict[str, xr.Dataset]:
    """Solve by every method."""
    catalogue: xr.Dataset = roughxr.scans.tip_flags(roughxr.asperities(scan, patch=5, vertex="pixel"), tip_radius=10)
    places: xr.Dataset = roughxr.scans.regions.centres(scan, (8, 8))
    found: dict[str, xr.Dataset] = {
        "reconstruction": roughxr.reconstruct(scan, catalogue, reach=50),
        "direct": roughxr.direct(scan, delta=[1.0, 2.0], subregions=places, fields=True),
        "load": roughxr.direct(scan, load=np.array([100.0]), subregions=(2, 2)),
        "superposed": roughxr.superpose(catalogue, delta=np.arange(3.0), law="maugis"),
        "map": roughxr.pull_off_map(catalogue, subregions=places),
        "adhesive": roughxr.adhesive(scan, preload=[0.0, 100.0], mesh=roughxr.Mesh("auto", accuracy=0.02)),
        "cycle": roughxr.adhesive(scan, delta=[1.0], law="dugdale", mesh=roughxr.Mesh(2, step=0.5)),
        "tabor": roughxr.reference.tabor(scan),
        "varied": roughxr.vary(scan, roughxr.direct, sphere_radius=[500, 1000], delta=[1.0]),
    }
    found["estimate"] = roughxr.reference.elastic_pull_off(found["direct"], smoothing=1.0)
    return {name: ds.compute() for name, ds in found.items()}


def statistics(solutions: dict[str, xr.Dataset]) -> xr.Dataset:
    """Say what the samples say."""
    pull: xr.Dataset = roughxr.statistics.reduction(roughxr.pull_off(solutions["superposed"]))
    densities: tuple[xr.DataArray, xr.DataArray, xr.DataArray] = (
        roughxr.pdf(pull, "pull_off_force", method="kde"),
        roughxr.statistics.cdf(pull, "pull_off_force"),
        roughxr.statistics.debris(solutions["reconstruction"], threshold=6.0),
    )
    tables: list[xr.Dataset] = [
        roughxr.fit(pull, "pull_off_force", laws=["weibull"]),
        roughxr.bootstrap(pull, "pull_off_force", statistics=("mean",), seed=1),
        roughxr.statistics.force_ratio(solutions["superposed"], solutions["direct"]),
        roughxr.error_budget(solutions["reconstruction"], places=2),
    ]
    return roughxr.summary(pull) if densities else tables[0]


def measured(scan: xr.Dataset, path: Path) -> xr.Dataset:
    """Set what an instrument measured beside what the scan predicts."""
    curves: xr.Dataset = roughxr.measured.open_curves(
        path, piezo_units="nm", sensitivity="50 nm/V", spring_constant=0.2
    )
    forces: list[xr.Dataset] = [
        roughxr.open_pull_off(path, channel="adhesion", units="V", sensitivity="12 nN/V", pulls="positive"),
        roughxr.open_pull_off([path, path]),
        roughxr.measured.curves_pull_off(curves, spring_constant="0.2 N/m", baseline=0.4, curves=True),
    ]
    fitted: xr.Dataset = roughxr.fit_pair(scan, forces[0], method="superposed", subregions=(4, 4), law="jkr")
    others: list[xr.Dataset] = [
        roughxr.fit_pair(scan, forces[0], quantity="adhesion_range", method="rigid", subregions=(2, 2)),
        roughxr.fit_pair(scan, forces[0], quantity="hardness", subregions=(2, 2), preload=10.0),
    ]
    if fitted and others:
        return roughxr.compare(roughxr.pull_off_map(scan), forces[1], shift=("5 nm", 0.0))
    return forces[0]


def both_rough(scan: xr.Dataset, probe: xr.Dataset) -> xr.Dataset:
    """Land a rough probe's face in several ways."""
    roughness: xr.Dataset = roughxr.fit_sphere(probe)
    indenters: xr.Dataset = roughxr.placements(roughness, sphere_radius="3 um", count=4, width=500.0)
    return roughxr.vary(scan, roughxr.direct, indenter=indenters, delta=[1.0])


def several(scans: list[xr.Dataset]) -> xr.Dataset:
    """Take scans of one surface together."""
    film: list[xr.Dataset] = roughxr.scans.open_container("film.zip")
    spectrum: xr.Dataset = roughxr.scans.combined_spectrum(scans + film, window=None, shortest="20 nm", per_decade=5)
    pulls: xr.Dataset = xr.concat([roughxr.pull_off_map(scan, subregions=(8, 8)) for scan in scans], "scan")
    pooled: xr.Dataset = roughxr.statistics.pooled(
        pulls, "pull_off_force", over="scan", statistics=["mean"], resamples=99
    )
    return pooled if spectrum else pulls


def stiff(scan: xr.Dataset) -> xr.Dataset:
    """Take bodies too stiff to bend, and what finer scales would do."""
    constant: float = roughxr.reference.hamaker_constant("glass")
    tables: list[xr.Dataset] = [
        roughxr.formulas(scan),
        roughxr.regime(scan),
        roughxr.scale_dependence(scan, shortest=[20.0]),
        roughxr.answer(roughxr.extrapolated(scan, subregions=(2, 1), seeds=1)),
        roughxr.certificate(roughxr.direct(scan, delta=[5.0])),
    ]
    return roughxr.rigid(scan, subregions=(2, 2)) if constant and tables else scan


def lifted(scan: xr.Dataset) -> xr.Dataset:
    """Ask at what flow particles leave."""
    rests: xr.Dataset = roughxr.resting(scan)
    holds: xr.Dataset = roughxr.rolling(scan, directions=8, subregions=rests)
    holds = roughxr.particles.with_pull_off(holds, roughxr.pull_off_map(scan, subregions=rests))
    critical: xr.Dataset = roughxr.critical_load(holds)
    numbers: xr.Dataset = roughxr.particles.parameters(holds, catalogue=roughxr.asperities(scan))
    lines: str = roughxr.particles.to_dem(holds, code="lammps", classes=3)
    roughxr.figures.subregion_map(critical, "mode", ax=None).set_title("what goes first")
    return roughxr.resuspension(holds, friction_velocity=[0.1, 1.0]) if critical and numbers and lines else holds


def shown(ds: xr.Dataset) -> pd.DataFrame:
    """Look at a result."""
    roughxr.plot(ds, "height", ax=None).set_title("as it is")
    table: pd.DataFrame = roughxr.to_table(ds)
    return table


def runs(scan: xr.Dataset, path: Path) -> dict[str, xr.Dataset]:
    """Run, keep, and write for others."""
    groups: dict[str, xr.Dataset] = roughxr.run(scan, path, subregions=(4, 4), budget=2)
    with roughxr.progress():
        groups |= reproduction.paper(str(path))
    groups |= roughxr.checkpointed(lambda: {"solutions/direct": roughxr.direct(scan, delta=[1.0])}, path, scan=scan)
    written: Path = roughxr.to_table(groups["asperities"], path)
    pages: tuple[Path, Path] = roughxr.report.write_report(path), roughxr.report.write_explorer(path)
    version: str = roughxr.__version__
    return groups if written and pages and version else {}
