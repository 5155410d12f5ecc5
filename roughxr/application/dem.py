"""`to_dem`: adhesion as input for LAMMPS (jkr: pull-off 3 π γ R), or its distribution as a table; SI units."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from ..mechanics.bodies.pair_record import read_pair
from ..mechanics.particles.adhesion_parameters import parameters
from ..mechanics.statistics import cdf, reduction, smooth_pull_off
from ..mechanics.statistics.sampling import (
    SHARE,
    place_numbers,
    refuse_several,
    shares,
    standard_deviation,
    weighted_by_landing_share,
)
from ..mechanics.vocabulary import schema
from ..mechanics.vocabulary.refusal import Refusal
from ..mechanics.vocabulary.units import Quantity, fraction, positive, whole_number

#: Factors from roughxr's units to SI.
_NEWTON, _METRE, _PASCAL = 1e-9, 1e-9, 1e9

#: A code with one adhesion for each particle type, and one that reads the distribution.
LAMMPS, LIGGGHTS, TABLE = CODES = ("lammps", "liggghts", "rock_n_roll")


def to_dem(
    ds: xr.Dataset,
    *,
    code: str,
    classes: int = 5,
    poisson_ratio: float = 0.3,
    young_modulus: Quantity | None = None,
) -> str:
    """Return the adhesion of these places as input of a discrete-element code or a resuspension model.

    Parameters
    ----------
    ds : Dataset
        A pull-off with its pair, or a result of `rolling`, which also gives the coefficient of rolling friction.
    code : {"lammps", "liggghts", "rock_n_roll"}
        "lammps": fix wall/gran granular jkr. "liggghts": the cohesion energy density of its model sjkr for a sphere of
        this radius on a wall; and the mean and standard deviation of the surface energy, F / (4πR), half the work of
        adhesion, as 4C draws it from a distribution (its pull-off force is 4πRγ).
        "rock_n_roll": a table (CSV) of the distribution:
        ``force_nN`` (ascending), ``cdf``, ``force_over_smooth`` (over that of the same sphere on a smooth flat), and
        from `rolling` ``lever_over_radius``, the mean over directions, for use in place of the usual 1/100, and from
        the simulation ``lever_error``, relative to it. Places without adhesion are only counted; those without a lever
        get the median of the others.
    classes : int
        For "lammps": particle types of equal share among which the places are divided, by their pull-off; at most one
        for each place. 1: all alike, with the mean pull-off. Any number keeps the mean; more keep the spread.
    poisson_ratio : float
        Of both bodies, for codes that need Young's modulus, E = 2(1 − ν²)E*.
    young_modulus : number or quantity, optional
        For "liggghts": of both bodies in the simulation, GPa, where it is softer than the pair.

    Returns
    -------
    str
        Lines with comments and SI units, one particle type for each class, at the sphere's radius. They contain the
        adhesion between sphere and wall; add the dynamics (friction, time step) yourself. Include them after ``units
        si``, the atoms and ``variable damping equal …`` (kg/s).

    Notes
    -----
    In LAMMPS, run with these lines, the pull-off force of a particle agrees within 1e-5 (``tests/benchmarks/
    dem_codes.py``). For other codes take `parameters`.

    LIGGGHTS's sjkr adds the tension k A to Hertz' force, with the energy density k and the area of the intersection, on
    a wall A = π(2Rδ − δ²) at an overlap δ (manual, "gran cohesion sjkr"). The tension is largest where
    k = E*√(Rδ)/(π(R − δ)), and the overlap is the one whose tension is the pull-off force; for δ ≪ R
    k = (3 F E*²/(2π³R²))^(1/3). So k depends on the modulus and the radius of the simulation. sjkr2, with 4πRδ, takes
    half of it.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> moments = scan.contact.rolling(directions=8, subregions=(3, 3))
    >>> text = roughxr.particles.to_dem(moments, code="lammps", classes=2)
    >>> [line.split()[:4] for line in text.splitlines() if line.startswith("fix wall1")]
    [['fix', 'wall1', 'class1', 'wall/gran']]
    """
    if code not in CODES:
        raise Refusal(
            "code", f"one of {', '.join(CODES)}", f"{code!r}", "for other codes write the table of parameters"
        )
    refuse_several(ds)
    ds = reduction(ds)
    if code == TABLE:
        return _distribution(ds)
    force = ds["pull_off_force"].dropna("subregion") * _NEWTON
    force = force.isel(subregion=np.argsort(force.values))
    count = min(whole_number(classes, "classes", least=1), force.size)
    share = shares(force).values / shares(force).values.sum()
    below, sums = (np.append(0.0, np.cumsum(values)) for values in (share, share * force.values))
    means = count * np.diff(np.interp(np.arange(count + 1) / count, below, sums))  # of whole and cut places
    poisson_ratio = fraction(poisson_ratio, "poisson_ratio")
    if code == LIGGGHTS:
        lines = _liggghts_lines(ds, force, means.tolist(), poisson_ratio, young_modulus)
    else:
        lines = _lammps_lines(ds, means.tolist(), poisson_ratio)
    return "\n".join([*(f"# {line}" for line in _header(ds, force)), *lines]) + "\n"


def places_in_words(ds: xr.Dataset) -> str:
    """Return the number of places, and of random surfaces at each of them if there are several."""
    count = int(place_numbers(ds).max()) + 1
    surfaces = ds.sizes["subregion"]
    return f"{count} places" + f" on {surfaces // count} random surfaces each" * (surfaces > count)


def _header(ds: xr.Dataset, force: xr.DataArray) -> list[str]:
    law = parameters(ds)
    mean_force = float(weighted_by_landing_share(force).mean())
    deviation = float(standard_deviation(force))
    radius = float(ds["sphere_radius"]) * _METRE
    misfit = float(law.adhesion_law_distance)
    mean = float(law.adhesion_mean)
    spread = float(law.adhesion_spread)
    surface = ds.attrs.get("surface", "the surface as the scan shows it: finer roughness lowers adhesion")
    return [
        f"adhesion of a sphere of {radius:.4g} m on a rough wall, from {places_in_words(ds)}",
        f"pull-off force: mean {mean_force:.5g} N, standard deviation {deviation:.3g} N over places",
        f"over the smooth sphere's {smooth_pull_off(ds) * _NEWTON:.5g} N log-normal, geometric mean {mean:.4g}, spread",
        f"{spread:.4g}, which differs from the cumulative distribution over places by up to {misfit:.2g}",
        f"places {'of rest' if SHARE in ds.coords else 'where particles land, without settling'}; {surface}",
    ]


def _lammps_lines(ds: xr.Dataset, forces: list[float], poisson_ratio: float) -> list[str]:
    if schema.is_coated(ds):
        raise Refusal(
            "code",
            "'lammps' for bodies without a layer: its jkr has one modulus",
            f"a layer of {float(ds['layer_thickness']):.3g} nm",
            "take 'rock_n_roll', or the table of parameters",
        )
    count = len(forces)
    radius = float(ds["sphere_radius"]) * _METRE
    modulus = read_pair(ds, "contact_modulus").contact_modulus
    young_modulus = 2 * (1 - poisson_ratio**2) * modulus * _PASCAL
    lines = [
        f"# {count} types of equal share; jkr: pull-off force 3 pi gamma R, one E for both",
        f"# include after: units si, atom_style sphere, a box of {count} types with atoms, variable damping (kg/s)",
    ]
    friction = ""
    if "lever" in ds:  # coefficient of rolling friction, from the lever arm at rest
        lever_ratio = float(weighted_by_landing_share(ds["lever"] / ds["sphere_radius"]).quantile(0.5))
        friction = f" rolling sds 0.0 0.0 {0.5 * lever_ratio:.4g}"
    for k, force in enumerate(forces, 1):
        normal = f"jkr {young_modulus:.6g} ${{damping}} {poisson_ratio:g} {force / (3 * np.pi * radius):.6g}"
        lines += [
            f"group class{k} type {k}  # {1 / count:.4g} of the particles, pull-off {force:.5g} N",
            f"fix wall{k} class{k} wall/gran granular {normal} tangential linear_nohistory 0.0 0.0{friction} "
            "damping velocity zplane 0.0 NULL",
        ]
    if friction:
        lines.append("# rolling sds takes k_roll, gamma_roll (yours to choose; 0 here) and mu_roll, the moment at rest")
    return lines


def _sjkr_excess(strain: float, pull_off: float) -> float:
    """Return sjkr's largest tension at an overlap less a pull-off force, over E*R²."""
    return np.sqrt(strain) * (2 * strain - strain**2) / (1 - strain) - 4 / 3 * strain**1.5 - pull_off


def _liggghts_lines(
    ds: xr.Dataset, force: xr.DataArray, means: list[float], poisson_ratio: float, young_modulus: Quantity | None
) -> list[str]:
    if schema.is_coated(ds):
        raise Refusal("code", "'liggghts' for bodies without a layer", "a layer", "take the table of parameters")
    radius = float(ds["sphere_radius"]) * _METRE
    if young_modulus is None:
        modulus = read_pair(ds, "contact_modulus").contact_modulus * _PASCAL
    else:
        modulus = positive(young_modulus, "GPa", "young_modulus") * _PASCAL / (2 * (1 - poisson_ratio**2))
    energy = force / (4 * np.pi * radius)  # 4C's pull-off force is 4πRγ
    from scipy.optimize import brentq

    lines = [
        f"# sjkr at E* = {modulus:.4g} Pa and R = {radius:.4g} m; about (3 F E*^2 / (2 pi^3 R^2))^(1/3)",
        "# 4C's surface energy F / (4 pi R), half the work of adhesion, over places:",
        f"# mean {float(weighted_by_landing_share(energy).mean()):.5g} J/m^2,",
        f"# standard deviation {float(standard_deviation(energy)):.3g} J/m^2",
    ]
    for k, mean in enumerate(means, 1):
        strain = brentq(_sjkr_excess, 0.0, 0.99, args=(mean / (modulus * radius**2),), xtol=1e-15)
        overlap = strain * radius
        density = modulus * np.sqrt(strain) / (np.pi * (1 - strain))
        lines.append(
            f"# class {k}, {1 / len(means):.4g} of the particles: pull-off {mean:.5g} N, overlap {overlap:.3g} m"
        )
        lines.append(f"variable cohesion{k} equal {density:.6g}  # J/m^3, for property/global cohesionEnergyDensity")
    return lines


def _distribution(ds: xr.Dataset) -> str:
    """Return the distribution of the pull-off over the places as CSV, with levers if they are known."""
    steps = cdf(ds, "pull_off_force")
    force = steps["pull_off_force"].values
    table = pd.DataFrame({"force_nN": force, "cdf": steps.values, "force_over_smooth": force / smooth_pull_off(ds)})
    unknown = 0
    if "lever" in ds:
        columns = {"lever_over_radius": ds["lever"].mean("direction") / ds["sphere_radius"]}
        columns |= {"lever_error": ds["lever_error"]} if "lever_error" in ds else {}
        levers = pd.DataFrame({name: column.values for name, column in columns.items()})
        unknown = int((levers["lever_over_radius"].isna() & ds["pull_off_force"].notnull().values).sum())
        mean_levers = levers.fillna(levers.median()).groupby(ds["pull_off_force"].values).mean().loc[force]
        table[list(columns)] = mean_levers.to_numpy()
    head = [
        f"smooth sphere's pull-off force: {smooth_pull_off(ds):.6g} nN",
        *(f"{schema.axis_label(name)}: {float(value):.6g}" for name, value in schema.pair_coordinates(ds).items()),
        f"{places_in_words(ds)}; pull-off forces: {steps.attrs['samples']}; without adhesion: {steps.attrs['missing']}",
        *([f"{unknown} places without a known lever have the median one"] if unknown else []),
    ]
    return "".join(f"# {line}\n" for line in head) + table.to_csv(index=False, float_format="%.8g", lineterminator="\n")
