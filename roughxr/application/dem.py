"""`to_dem`: adhesion as input for LAMMPS (jkr: pull-off 3 π γ R), or its distribution as a table; SI units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from ..mechanics.bodies.pair_record import read_pair
from ..mechanics.particles.adhesion_parameters import parameters
from ..mechanics.statistics import cdf, reduction, smooth_pull_off
from ..mechanics.statistics.sampling import (
    SHARE,
    deviation_of_places,
    mean_of_places,
    place_numbers,
    quantile_of_places,
    refuse_several,
    shares,
)
from ..mechanics.vocabulary import schema
from ..mechanics.vocabulary.refusal import Refusal
from ..mechanics.vocabulary.units import Quantity, fraction, positive, whole_number
from .wording import render_sentence, render_sentences

#: The lines, with fields for the numbers.
_FILE = "dem.toml"

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
    means = _class_means(force, whole_number(classes, "classes", least=1))
    values = _adhesion_values(ds, force)
    poisson_ratio = fraction(poisson_ratio, "poisson_ratio")
    if code == LIGGGHTS:
        lines = _liggghts_lines(ds, force, means, poisson_ratio, young_modulus)
    else:
        lines = _lammps_lines(ds, means, poisson_ratio)
    head = render_sentences(_FILE, ["sphere", "pull_off", "law", "scope"], values)
    return "\n".join([*head, *lines]) + "\n"


def _class_means(force: xr.DataArray, classes: int) -> list[float]:
    """Return the mean pull-off of each class of equal share, ascending; a place may be cut between two classes."""
    force = force.isel(subregion=np.argsort(force.values))
    count = min(classes, force.size)
    share = shares(force).values / shares(force).values.sum()
    below, sums = (np.append(0.0, np.cumsum(values)) for values in (share, share * force.values))
    return (count * np.diff(np.interp(np.arange(count + 1) / count, below, sums))).tolist()


def places_in_words(ds: xr.Dataset) -> str:
    """Return the number of places, and of random surfaces at each of them if there are several."""
    return render_sentence(_FILE, "places", _place_values(ds))


def _place_values(ds: xr.Dataset) -> dict[str, Any]:
    """Return the number of places, and of random surfaces at each of them if there are several."""
    count = int(place_numbers(ds).max()) + 1
    surfaces = ds.sizes["subregion"]
    return {
        "places_of_scan": count,
        "several_places": count > 1,
        "surfaces_of_place": surfaces // count if surfaces > count else None,
    }


def _adhesion_values(ds: xr.Dataset, force: xr.DataArray) -> dict[str, Any]:
    """Return the pull-off forces (N), their log-normal law, and what they are of."""
    law = parameters(ds)
    return {
        **_place_values(ds),
        "radius": float(ds["sphere_radius"]) * _METRE,
        "mean_force": mean_of_places(force),
        "deviation": deviation_of_places(force),
        "smooth_force": smooth_pull_off(ds) * _NEWTON,
        "adhesion_mean": law["adhesion_mean"],
        "adhesion_spread": law["adhesion_spread"],
        "misfit": law["adhesion_law_distance"],
        "at_rest": SHARE in ds.coords,
        "surface_of_result": ds.attrs.get("surface"),
    }


def _lammps_lines(ds: xr.Dataset, forces: list[float], poisson_ratio: float) -> list[str]:
    if schema.is_coated(ds):
        raise Refusal(
            "code",
            "'lammps' for bodies without a layer: its jkr has one modulus",
            f"a layer of {float(ds['layer_thickness']):.3g} nm",
            "take 'rock_n_roll', or the table of parameters",
        )
    radius = float(ds["sphere_radius"]) * _METRE
    modulus = read_pair(ds, "contact_modulus").contact_modulus * _PASCAL
    values = {
        "types": len(forces),
        "share": 1 / len(forces),
        "young_modulus": 2 * (1 - poisson_ratio**2) * modulus,
        "poisson_ratio": poisson_ratio,
    }
    if "lever" in ds:  # coefficient of rolling friction, from the lever arm at rest
        lever_ratio = quantile_of_places(ds["lever"] / ds["sphere_radius"], 0.5)
        values["friction_coefficient"] = 0.5 * float(lever_ratio)
    types = []
    for number, force in enumerate(forces, 1):
        energy = force / (3 * np.pi * radius)
        own = {"number": number, "force": force, "surface_energy": energy}
        types.append(render_sentence(_FILE, "lammps_type", values | own))
    first, last = (render_sentences(_FILE, [name], values) for name in ("lammps", "lammps_friction"))
    return [*first, *types, *last]


def _sjkr_strain(pull_off: float) -> float:
    """Return the overlap over the radius at which sjkr's largest tension is a pull-off force over E*R²."""
    from scipy.optimize import brentq

    def excess(strain: float) -> float:
        tension = np.sqrt(strain) * (2 * strain - strain**2) / (1 - strain) - 4 / 3 * strain**1.5
        return tension - pull_off

    return brentq(excess, 0.0, 0.99, xtol=1e-15)


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
    values = {
        "radius": radius,
        "contact_modulus": modulus,
        "mean_energy": mean_of_places(energy),
        "energy_deviation": deviation_of_places(energy),
        "share": 1 / len(means),
    }
    types = []
    for number, mean in enumerate(means, 1):
        strain = _sjkr_strain(mean / (modulus * radius**2))
        density = modulus * np.sqrt(strain) / (np.pi * (1 - strain))
        own = {"number": number, "force": mean, "overlap": strain * radius, "energy_density": density}
        types.append(render_sentence(_FILE, "liggghts_type", values | own))
    return [*render_sentences(_FILE, ["liggghts", "energy"], values), *types]


def _distribution(ds: xr.Dataset) -> str:
    """Return the distribution of the pull-off over the places as CSV, with levers if they are known."""
    steps = cdf(ds, "pull_off_force")
    force = steps["pull_off_force"].values
    smooth_force = smooth_pull_off(ds)
    table = pd.DataFrame({"force_nN": force, "cdf": steps.values, "force_over_smooth": force / smooth_force})
    values = {
        **_place_values(ds),
        "smooth_force": smooth_force,
        "number_of_samples": steps.attrs["samples"],
        "without_adhesion": steps.attrs["missing"],
    }
    if "lever" in ds:
        levers = _levers(ds)
        is_unknown = levers["lever_over_radius"].isna() & ds["pull_off_force"].notnull().values
        values["without_lever"] = int(is_unknown.sum())
        mean_levers = levers.fillna(levers.median()).groupby(ds["pull_off_force"].values).mean().loc[force]
        table[list(levers)] = mean_levers.to_numpy()
    pair = [f"# {schema.axis_label(name)}: {float(value):.6g}" for name, value in schema.pair_coordinates(ds).items()]
    first, last = (render_sentences(_FILE, names, values) for names in (["smooth"], ["samples", "levers"]))
    head = "".join(f"{line}\n" for line in [*first, *pair, *last])
    return head + table.to_csv(index=False, float_format="%.8g", lineterminator="\n")


def _levers(ds: xr.Dataset) -> pd.DataFrame:
    """Return the lever over the radius at each place, the mean over directions, and its relative error if known."""
    columns = {"lever_over_radius": ds["lever"].mean("direction") / ds["sphere_radius"]}
    if "lever_error" in ds:
        columns["lever_error"] = ds["lever_error"]
    return pd.DataFrame({name: column.values for name, column in columns.items()})
