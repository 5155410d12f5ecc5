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
from ..report.detachment_section import leading
from ..statistics.sampling import shares
from ..vocabulary.numbers import number, percent
from ..vocabulary.schema import is_wet, one_of
from . import words
from .files import drawn
from .options import PARTICLE_CODES

#: Endings of pictures.
_PICTURES = (".png", ".pdf", ".svg", ".jpg")


def detach(options: Namespace) -> None:
    """Print at what strength of a load the spheres come off, and write what is asked for."""
    _check_files(options)
    groups = _load(options.run)
    method = options.method or leading(groups)
    held = report.moments_of(groups, method)
    wet = is_wet(held)
    if options.fluid == "water" and wet:
        raise ValueError(
            f"--fluid water: expected a dry run, found one at {percent(held['humidity'])} relative humidity; "
            "run again without --humidity, with the --work-of-adhesion under water"
        )
    body, slides = _body(options)
    critical = particles.critical_load(held, **body, **slides)
    source = f"{options.load} in {options.fluid}, pull-off forces of {method!r}"
    work = f"work of adhesion {number(held['work_of_adhesion'], 'J/m²')} as in the run"
    _tell_critical(critical, f"{source}, {work}", "cases (places × surfaces)" if method == "extrapolated" else "places")
    if "solutions/rolling_landed" in groups:
        _tell_rests(groups, body, slides)
    _write(options, groups, held, critical)
    if options.picture:
        _draw(critical, held, options.picture, source)


def _check_files(options: Namespace) -> None:
    """Raise where a file that is asked for could not be written, before anything is computed."""
    for path in filter(None, (options.output, options.parameters)):
        one_of(Path(path).suffix, exports.FORMATS, f"{path}'s ending")
    if options.picture:
        one_of(Path(options.picture).suffix, _PICTURES, f"{options.picture}'s ending")
    for code, _ in options.dem:
        one_of(code, PARTICLE_CODES, "--dem")


def _load(run: str) -> Mapping[str, xr.Dataset]:
    groups = archive.load(archive.of_run(Path(run)))
    if not set(report.COMING_OFF) <= set(groups):
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


def _write(options: Namespace, groups: Mapping[str, xr.Dataset], held: xr.Dataset, critical: xr.Dataset) -> None:
    """Write the tables, and the lines for particle codes, that are asked for."""
    if options.output:
        table = by_place(held).merge(critical, compat="override", combine_attrs="override")
        print(f"written to {exports.to_table(table, options.output)}")
    if options.parameters:
        numbers = particles.parameters(held, catalogue=groups["asperities"])
        print(f"written to {exports.to_table(numbers, options.parameters)}")
    for code, path in options.dem:
        Path(path).write_text(particles.to_dem(held, code=code), encoding="utf-8")
        print(f"written to {path}")


def _tell_critical(critical: xr.Dataset, source: str, places: str) -> None:
    """Print the critical strength of a load, and how the sphere comes off."""
    name, rests = next(iter(critical.data_vars)), "landing_share" in critical.coords
    values = critical[name].where(np.isfinite(critical[name]))
    print(f"{source}; {critical[name].attrs['long_name']}, {critical[name].attrs['units']}:")
    if bool(values.notnull().any()):
        least, middle, most = (number(_quantile(values, part)) for part in (0.05, 0.5, 0.95))
        of = "particles where they came to rest" if rests else "places"
        print(f"  5 % of {of} {least}, median {middle}, 95 % {most}")
    counts = ((mode, int((critical["mode"] == mode).sum())) for mode in np.unique(critical["mode"].values.astype(str)))
    print("how it comes off: " + ", ".join(f"{mode} at {count}" for mode, count in counts))
    inside = int(critical["in_range"].sum())
    print(f"within the range of the drag formulas: {inside} of {critical.sizes['subregion']} {places}")


def _quantile(values: xr.DataArray, part: float) -> float:
    """Return a quantile over particles, where places hold shares of them, else over places."""
    return float(values.weighted(shares(values)).quantile(part))


def _tell_rests(groups: Mapping[str, xr.Dataset], body: dict[str, Any], slides: dict[str, Any]) -> None:
    """Print what half of the particles of a run stand at rest and where they landed."""
    at = {"at rest": "solutions/rolling_superposed", "where they landed": "solutions/rolling_landed"}
    critical = {where: particles.critical_load(groups[name], **body, **slides) for where, name in at.items()}
    told = [(where, next(iter(ds.data_vars.values()))) for where, ds in critical.items()]
    medians = ", ".join(f"{where} {number(_quantile(values, 0.5))}" for where, values in told)
    print(f"the median by superposed asperities: {medians} {told[0][1].attrs['units']}")


def _draw(critical: xr.Dataset, held: xr.Dataset, path: str, title: str) -> None:
    """Draw what goes first, or how much it takes where all go alike, beside the rose of resisting moments."""
    figure = Figure(figsize=(6.9, 3.4), layout="constrained")
    left, strength = figure.add_subplot(1, 2, 1), next(iter(critical.data_vars))
    alike = np.unique(critical["mode"].values).size == 1 and bool(critical[strength].notnull().any())
    figures.subregion_map(critical, strength, ax=left) if alike else figures.subregion_map(critical, "mode", ax=left)
    figures.moment_rose(held, ax=figure.add_subplot(1, 2, 2, projection="polar"))
    figure.suptitle(title.replace("_", " "))
    drawn(figure, path)
