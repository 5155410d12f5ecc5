"""Pull-offs of many cases in one batch: slightly different surfaces, pairs and meshes at the same places."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..jobs import spread
from ..specimen import specimen_of
from .adhesion_on_cells import Adhesion
from .adhesive_options import preload_problem, window_half_width
from .cycle import reached
from .edge_front import valid_cycles
from .mesh import Mesh
from .problem import Place, Problem, places
from .refinement import cycles_at


class Case(NamedTuple):
    """One surface with its bodies at one place, and the mesh of its solution."""

    place: Place
    problem: Problem
    adhesion: Adhesion

    def refined(self, refine: int) -> Case:
        """Return the case on cells of another size."""
        return self._replace(adhesion=self.adhesion._replace(refine=refine))


def place_cases(
    ds: xr.Dataset, positions: xr.Dataset, *, preload: float, law: str, mesh: Mesh, splined: bool = False
) -> list[Case]:
    """Return the case of each place of a scan; raise if mesh or bodies do not suit the law."""
    specimen = specimen_of(ds)
    problem, adhesion = preload_problem(specimen, preload=preload, law=law, mesh=mesh)
    solved, _ = places(specimen, positions, window_half_width(specimen, problem, adhesion))
    return [Case(place, problem._replace(splined=splined), adhesion) for place in solved]


def pull_offs(cases: Sequence[Case]) -> np.ndarray:
    """Return the pull-off of each case, nN; NaN where a cycle could not be completed."""
    return np.asarray(spread.task_results(_pull_off, cases, (), name="changes"))


def _pull_off(place: Place, problem: Problem, adhesion: Adhesion) -> np.ndarray:
    """Return the pull-off of one case, as a task."""
    by_front = valid_cycles(place, problem, adhesion)
    if by_front or not adhesion.on_cells:
        return by_front.pull_offs[0] if by_front else np.array(np.nan)
    cycles, _ = cycles_at(place, problem, adhesion, fields=False)
    return np.array(cycles.pull_offs[0] if reached(cycles.paths[0], adhesion, 0) else np.nan)
