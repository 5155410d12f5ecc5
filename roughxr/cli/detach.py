"""`detach`: what it takes to move the spheres of a finished run, and what other programs need for that."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from .. import archive, figures, particles, report
from .. import tables as exports
from ..particles.adhesion_parameters import by_place
from ..report.detachment import leading
from ..report.run_tables import METHOD_WORDS
from ..statistics.sampling import shares
from ..vocabulary.numbers import number, percent
from ..vocabulary.schema import is_wet, one_of
from . import words
from .files import drawn
from .options import PARTICLE_CODES

#: Endings of pictures.
_PICTURES = (".png", ".pdf", ".svg", ".jpg")


def detach(options: Namespace) -> None:
    """Print at what strength of a load the spheres of a run, or of each run in a folder, move; write what is given."""
    _check_files(options)
    runs = _runs(Path(options.run))
    tables = {}
    for name, path in runs.items():
        if len(runs) > 1:
            print(f"{name}:")
        tables[name] = _detach_run(options, path)
    if options.output:
        table = next(iter(tables.values()))
        if len(runs) > 1:
            rows = [_named(part, name) for name, part in tables.items()]
            table = xr.concat(rows, "scan", data_vars="all", coords="minimal", compat="override")
        print(f"written to {exports.to_table(table, options.output)}")


def _runs(path: Path) -> dict[str, Path]:
    """Return the run at a path, or those in the folders of several scans."""
    if path.is_dir() and not [*path.glob("*.nc")]:
        return {file.parent.name: file.parent for file in sorted(path.glob("*/run.nc"))} or {path.name: path}
    return {path.name: path}


def _named(table: xr.Dataset, name: str) -> xr.Dataset:
    """Return a table of places with the name of its scan in each row."""
    rows = table.drop_vars("subregion", errors="ignore").rename_dims(subregion="scan")
    return rows.assign_coords(scan=[name] * table.sizes["subregion"])


def _detach_run(options: Namespace, path: Path) -> xr.Dataset:
    """Print and write what is given of one run, and return its table of places."""
    groups = _load(path)
    method = options.method or leading(groups)
    if report.CRITICAL[method] not in groups:
        raise ValueError(f"--method {method}: the run has no such pull-off forces; expected --method adhesive")
    moments = report.moments_of(groups, method)
    humid = is_wet(moments)
    if options.fluid == "water" and humid:
        raise ValueError(
            f"--fluid water: expected a dry run, found one at {percent(moments['humidity'])} relative humidity; "
            "run again without --humidity, with the --work-of-adhesion under water"
        )
    body, slides = _body(options)
    critical = particles.critical_load(moments, **body, **slides)
    load = f"flow of {options.fluid}" if options.load == "wall_shear" else options.load
    source = f"{load}, pull-off forces: {METHOD_WORDS[method]}"
    work = f"work of adhesion {number(moments['work_of_adhesion'], 'J/m²')} as in the run"
    _print_critical(critical, f"{source}, {work}", "places on each surface" if method == "extrapolated" else "places")
    if options.parameters:
        numbers = particles.parameters(moments)
        print(f"written to {exports.to_table(numbers, options.parameters)}")
    for code, file in options.dem:
        Path(file).write_text(particles.to_dem(moments, code=code), encoding="utf-8")
        print(f"written to {file}")
    if options.picture:
        _draw(critical, moments, options.picture, source)
    return by_place(moments).merge(critical, compat="override", combine_attrs="override")


def _check_files(options: Namespace) -> None:
    """Raise where a file that is asked for could not be written, before anything is computed."""
    for path in filter(None, (options.output, options.parameters)):
        one_of(Path(path).suffix, exports.FORMATS, f"{path}'s ending")
    if options.picture:
        one_of(Path(options.picture).suffix, _PICTURES, f"{options.picture}'s ending")
    for code, _ in options.dem:
        one_of(code, PARTICLE_CODES, "--dem")
    files = [f"--{name}" for name in ("parameters", "dem", "picture") if getattr(options, name)]
    if files and len(_runs(Path(options.run))) > 1:
        raise ValueError(f"{', '.join(files)}: expected one run, found several in {options.run}; name one of them")


def _load(run: Path) -> Mapping[str, xr.Dataset]:
    groups = archive.load(archive.of_run(run))
    if not set(report.DETACHMENT) <= set(groups):
        raise ValueError(
            f"{run}: expected a run with resisting moments, found none; a run has none without adhesion, with "
            "an indenter instead of a sphere, in very humid air, or if an older roughxr made it (then run it again)"
        )
    return groups


def _body(options: Namespace) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the options of a load on the sphere, and those of its sliding."""
    density = options.particle_density and words.number(options.particle_density)
    strength = options.shear_strength and words.number(options.shear_strength)
    slides = {"friction_coefficient": options.friction_coefficient, "shear_strength": strength}
    return {"load": options.load, "particle_density": density, "flow": options.fluid}, slides


def _print_critical(critical: xr.Dataset, source: str, places: str) -> None:
    """Print the critical strength of a load, and how the sphere detaches."""
    name, rests = next(iter(critical.data_vars)), "landing_share" in critical.coords
    values = critical[name].where(np.isfinite(critical[name]))
    print(f"{source}; {critical[name].attrs['long_name']}, {critical[name].attrs['units']}:")
    if bool(values.notnull().any()):
        least, middle, most = (number(_quantile(values, part)) for part in (0.05, 0.5, 0.95))
        of = "particles where they came to rest" if rests else "places"
        print(f"  5 % of {of} {least}, median {middle}, 95 % {most}")
    counts = ((mode, int((critical["mode"] == mode).sum())) for mode in np.unique(critical["mode"].values.astype(str)))
    print("how it detaches: " + ", ".join(f"{mode} at {count}" for mode, count in counts))
    inside = int(critical["in_range"].sum())
    print(f"within the range of the drag formulas: {inside} of {critical.sizes['subregion']} {places}")


def _quantile(values: xr.DataArray, part: float) -> float:
    """Return a quantile over particles, where places hold shares of them, else over places."""
    return float(values.weighted(shares(values)).quantile(part))


def _draw(critical: xr.Dataset, moments: xr.Dataset, path: str, title: str) -> None:
    """Draw what goes first, or how much it takes where all go alike, beside the rose of resisting moments."""
    figure = Figure(figsize=(6.9, 3.4), layout="constrained")
    left, strength = figure.add_subplot(1, 2, 1), next(iter(critical.data_vars))
    alike = np.unique(critical["mode"].values).size == 1 and bool(critical[strength].notnull().any())
    figures.subregion_map(critical, strength, ax=left) if alike else figures.subregion_map(critical, "mode", ax=left)
    figures.moment_rose(moments, ax=figure.add_subplot(1, 2, 2, projection="polar"))
    figure.suptitle(title)
    drawn(figure, path)
