"""`to_dem`: adhesion as input for LAMMPS (jkr: pull-off 3 π γ R), or its distribution as a table; SI units."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from ..statistics import cdf, fit, reduction, smooth_pull_off
from ..vocabulary import schema
from ..vocabulary.units import fraction, whole_number
from .force_balance import refuse_varied, scope_of

#: From the project's units to those of every code here.
_NEWTON, _METRE, _PASCAL = 1e-9, 1e-9, 1e9


class _Adhesion(NamedTuple):
    """Adhesion in SI units."""

    pulls: np.ndarray  # N, mean pull-off of each class of the places, ascending; the classes have equal shares
    mean: float  # N
    std: float  # N
    radius: float  # m
    modulus: float  # Pa, E*
    poisson_ratio: float
    friction: float  # of rolling: lever over twice the radius, NaN where no levers are known
    misfit: float  # largest distance of that law from the places' distribution function
    log_normal: tuple[float, float]  # geometric mean and spread of the pull-off over the smooth sphere's

    @property
    def young_modulus(self) -> float:
        """Young's modulus (Pa) of sphere and wall alike that gives E*."""
        return 2 * (1 - self.poisson_ratio**2) * self.modulus


def to_dem(ds: xr.Dataset, *, code: str, classes: int | None = None, poisson_ratio: float | None = None) -> str:
    """Return the lines that give a discrete-element code, or a resuspension model, the adhesion of these places.

    Parameters
    ----------
    ds : Dataset
        A pull-off with its pair, or a result of `rolling`, which also gives the coefficient of rolling friction.
    code : {"lammps", "rock_n_roll"}
        "lammps": pair_style granular and fix wall/gran, jkr. "rock_n_roll": a table (CSV) of the distribution:
        ``force_nN`` (ascending), ``cdf``, ``force_over_smooth`` (over that of the same sphere on a smooth flat), and
        from `rolling` ``lever_over_radius`` in the weakest direction, for use in place of the usual 1/100. Places where
        nothing pulls are only counted.
    classes : int
        For "lammps": particle types of equal share among which the places are divided, by their pull-off; by default
        up to 5. 1: all alike, with the mean pull-off.
    poisson_ratio : float
        Of both bodies, for "lammps", which needs Young's modulus, E = 2(1 − ν²)E*; by default 0.3.

    Returns
    -------
    str
        Lines with comments and SI units, one particle type for each class, at the sphere's radius. They hold the
        adhesion between sphere and wall; its dynamics (damping, friction, time step) are for you to add.

    Raises
    ------
    ValueError
        If ``ds`` is no pull-off with an adhesive pair, or an option is not as described.

    Notes
    -----
    LAMMPS was run with these lines: pulling a particle off the wall takes the pull-off force given here, within 1e-5
    (``tests/benchmarks/dem_codes.py``). For other codes take `parameters`.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(
    ...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
    >>> text = to_dem(roughxr.rolling(scan, directions=8, subregions=(3, 3)), code="lammps", classes=2)
    >>> [line.split()[:4] for line in text.splitlines() if line.startswith("fix wall1")]
    [['fix', 'wall1', 'class1', 'wall/gran']]
    """
    schema.one_of(code, CODES, "code")
    refuse_varied(ds)
    ds = reduction(ds)
    if code == TABLE:
        schema.refuse_unused(f"code={code!r}", classes=classes, poisson_ratio=poisson_ratio)
        return _distribution(ds)
    pulling = int(ds["pull_off_force"].notnull().sum())
    count = min(_CLASSES, pulling) if classes is None else whole_number(classes, "classes", least=1)
    ratio = _POISSON_RATIO if poisson_ratio is None else fraction(poisson_ratio, "poisson_ratio")
    adhesion = _adhesion_of(ds, count, ratio)
    return "\n".join([*(f"# {line}" for line in _head(ds, adhesion)), *_lammps(adhesion)]) + "\n"


def _adhesion_of(ds: xr.Dataset, classes: int, poisson_ratio: float) -> _Adhesion:
    pulls = np.sort(ds["pull_off_force"].values[np.isfinite(ds["pull_off_force"].values)].ravel()) * _NEWTON
    if pulls.size < classes:
        raise ValueError(f"classes: expected at most {pulls.size}, the number of places that pull, found {classes}")
    law = fit(ds, "pull_off_ratio", laws=["log_normal"], simulations=0).isel(law=0)
    lever = float((ds["lever"] / ds["sphere_radius"]).median()) if "lever" in ds else np.nan
    return _Adhesion(
        pulls=np.array([part.mean() for part in np.array_split(pulls, classes)]),
        mean=float(pulls.mean()),
        std=float(pulls.std(ddof=1)),
        radius=float(ds["sphere_radius"]) * _METRE,
        modulus=float(ds["contact_modulus"]) * _PASCAL,
        poisson_ratio=poisson_ratio,
        friction=0.5 * lever,
        misfit=float(law["ks_distance"]),
        log_normal=(float(law["scale"]), float(np.exp(law["shape"]))),
    )


def _head(ds: xr.Dataset, adhesion: _Adhesion) -> list[str]:
    mean, spread = adhesion.log_normal
    return [
        f"adhesion of a sphere of {adhesion.radius:.4g} m on a rough wall, from {ds['pull_off_force'].size} places",
        f"pull-off force: mean {adhesion.mean:.5g} N, standard deviation {adhesion.std:.3g} N between places; over the",
        f"smooth sphere's {smooth_pull_off(ds) * _NEWTON:.5g} N log-normal, geometric mean {mean:.4g} and spread",
        f"{spread:.4g}, which differs from the cumulative distribution over places by up to {adhesion.misfit:.2g};",
        "if that is too much, take more classes",
        scope_of(ds),
    ]


def _lammps(adhesion: _Adhesion) -> list[str]:
    count, nu = len(adhesion.pulls), adhesion.poisson_ratio
    lines = ["units si", f"# {count} types of equal share; jkr pulls off at 3 pi gamma R, E of sphere and wall alike"]
    friction = "" if np.isnan(adhesion.friction) else f" rolling sds 0.0 0.0 {adhesion.friction:.4g}"
    for k, pull in enumerate(adhesion.pulls, 1):
        gamma = pull / (3 * np.pi * adhesion.radius)
        normal = f"jkr {adhesion.young_modulus:.6g} ${{damping}} {nu:g} {gamma:.6g}"
        lines += [
            f"group class{k} type {k}  # {1 / count:.4g} of the particles, pull-off {pull:.5g} N",
            f"fix wall{k} class{k} wall/gran granular {normal} tangential linear_nohistory 0.0 0.0{friction} "
            "damping velocity zplane 0.0 NULL",
        ]
    if friction:
        lines.append(
            "# rolling sds takes k_roll, gamma_roll (yours to choose; 0 here) and mu_roll, by the moment at rest"
        )
    return lines


def _distribution(ds: xr.Dataset) -> str:
    """Return the distribution of the pull-off over the places as CSV, with the levers where they are known."""
    steps = cdf(ds, "pull_off_force")
    force = steps["pull_off_force"].values
    table = pd.DataFrame({"force_nN": force, "cdf": steps.values, "force_over_smooth": force / smooth_pull_off(ds)})
    if "lever" in ds:
        table["lever_over_radius"] = _levers(ds, force) / float(ds["sphere_radius"])
    head = [
        f"smooth sphere's pull-off force: {smooth_pull_off(ds):.6g} nN",
        *(f"{schema.axis_label(name)}: {float(one):.6g}" for name, one in schema.travelling(ds).items()),
        f"places: {steps.attrs['samples']}; where nothing pulls: {steps.attrs['missing']}",
    ]
    return "".join(f"# {line}\n" for line in head) + table.to_csv(index=False, float_format="%.8g", lineterminator="\n")


def _levers(ds: xr.Dataset, force: np.ndarray) -> np.ndarray:
    """Return the lever (nm) of the weakest direction at the places of these pull-off forces, ascending."""
    pull, lever = ds["pull_off_force"].values, ds["lever"].min("direction").values
    known = np.isfinite(pull)
    return pd.Series(lever[known]).groupby(pull[known]).mean().loc[force].to_numpy()


#: Classes and Poisson's ratio where none are given.
_CLASSES, _POISSON_RATIO = 5, 0.3

#: A code with one adhesion for each particle type, and the one that takes the distribution itself.
LAMMPS, TABLE = CODES = ("lammps", "rock_n_roll")
