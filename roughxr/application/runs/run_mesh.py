"""The mesh on which the mean pull-off of a run has converged, and its preliminary answers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...mechanics.contact.adhesion import adhesive
from ...mechanics.contact.adhesive_options import longest_step
from ...mechanics.contact.mesh import FRONT, MOST_REFINED, Mesh, TooManyCells
from ...mechanics.contact.refinement import coarser_mesh_error
from ...mechanics.scans import regions
from ...mechanics.scans.plausibility import is_noise
from ...mechanics.specimen import Specimen
from ...mechanics.statistics.means import mean_pull_off, mesh_error
from ...mechanics.vocabulary.refusal import Refusal
from ..headline import answer_lines
from .plan import Plan
from .stages import Stages

#: Advice where bodies are too soft for the scan, or their contacts too large.
_REMEDY = (
    "use a larger scan, a smaller sphere or preload, a larger modulus or less work of adhesion; or, in Python, "
    "superpose or direct"
)

#: Largest contact diameter of a smooth sphere without load, over the scan's side: wider ones leave any rough scan.
_WIDEST_CONTACT = 3.0

#: Radius of JKR's contact without load over that at pull-off.
_WITHOUT_LOAD = 4 ** (1 / 3)


class Converged(NamedTuple):
    """A mesh on which the mean pull-off has converged."""

    mesh: Mesh
    finer: xr.Dataset | None  # results on a finer mesh, if one could be solved
    pace: float  # time for each place on the mesh, s


def converged_mesh(specimen: Specimen, plan: Plan, options: dict[str, Any], stages: Stages) -> Converged:
    """Return the mesh on which the mean pull-off has converged, and results on a finer one.

    On pixels wider than the contacts, the pull-off on the coarsest valid mesh may be wrong by a factor.
    """
    mesh = replace(plan.mesh, accuracy=None)
    coarse = adhesive(specimen, mesh=mesh, **options)
    pace = stages.pace()
    need_pull_off(coarse)
    show_answer(coarse, specimen, stages)
    n = int(coarse["mesh"].max())
    checked = Converged(mesh, None, pace)
    if not n:  # by the front, which states the error of each place
        return Converged(replace(mesh, cells=FRONT), None, pace)
    while 2 * n <= MOST_REFINED:
        try:
            finer = adhesive(specimen, mesh=Mesh(2 * n, step=0.5 * longest_step(specimen, mesh)), **options)
        except TooManyCells:  # the largest error that was found is stated with the result
            break
        change = abs(coarse["pull_off_force"] / finer["pull_off_force"] - 1).drop_attrs()
        stated = change.copy(data=coarser_mesh_error(change.values, finer.attrs["law"]))
        show_answer(finer.assign(pull_off_error=stated), specimen, stages)
        if not mesh_error(finer.assign(pull_off_error=change)) > (plan.mesh.accuracy or np.inf) or 4 * n > MOST_REFINED:
            return Converged(mesh, finer, pace)
        checked = Converged(mesh, finer, pace)
        pace = stages.pace()
        mesh = replace(mesh, cells=2 * n)
        coarse = finer
        n = 2 * n
    return checked


def need_pull_off(first: xr.Dataset) -> None:
    """Raise if none of the first places could be solved, before hours are spent on the others."""
    if bool(first["pull_off_force"].notnull().any()):
        return
    lost, edge = (int(flags.sum()) for flags in (~first["complete"], first["truncated"]))
    raise Refusal(
        "simulation with adhesion",
        f"a pull-off at one of the first {first['pull_off_force'].size} places",
        f"none ({lost} not completed, {edge} in contact at the scan's edge)",
        _REMEDY,
    )


def refuse_soft(specimen: Specimen) -> None:
    """Raise if JKR's contact of the smooth sphere without load is much wider than the scan."""
    pair = specimen.pair
    wide = 2 * _WITHOUT_LOAD * pair.contact_at_pull_off(pair.sphere_radius, pair.work)[0]
    side = min(regions.sides(specimen.bodies))
    if wide > _WIDEST_CONTACT * side:
        raise Refusal(
            "sphere_radius",
            f"a smooth sphere's contact that fits on a scan of {side:.3g} nm",
            f"one {wide:.3g} nm wide",
            _REMEDY,
        )


def show_answer(solved: xr.Dataset, specimen: Specimen, stages: Stages) -> None:
    """Print the preliminary answer from the solved places, once their mesh was checked."""
    no_pull_off = not bool((solved["pull_off_force"] > 0).any())
    if no_pull_off or np.isnan(mesh_error(solved)) or is_noise(specimen.scan):
        return
    preliminary = mean_pull_off(solved).drop_vars(["smooth_share", "independent_places"])
    stages.answer(" ".join(answer_lines(preliminary)))
