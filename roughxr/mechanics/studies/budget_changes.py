"""The change of the simulated pull-off when one factor is changed, at some places.

Each change is that of the mean over the places known in both cases, against the base on cells of equal size. A law with
a range can only be solved on small cells: if a case needs smaller cells, its base is solved on them as well. All cases
are solved in one batch.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..contact.adhesion_on_cells import resolving_cell
from ..contact.adhesive_options import preload_problem
from ..contact.batch import place_cases, pull_offs
from ..contact.mesh import FRONT, MOST_REFINED, Mesh
from ..jobs.progress import print_line
from ..particles.resting_places import resettled
from ..statistics.sampling import SHARE, shares
from ..vocabulary.adhesion_laws import ADHESION_LAWS
from ..vocabulary.error_sources import MESH, RANGE
from ..vocabulary.refusal import Refusal
from ..vocabulary.text import without_warnings
from .assumptions import CHANGES


class Change(NamedTuple):
    """The relative change of the mean over places."""

    value: float
    error: float  # its standard error by the scatter over places, NaN for one place
    places: int  # known in both cases


class Base(NamedTuple):
    """A scan with its pair, and the options of its simulation at some places."""

    ds: xr.Dataset
    preload: float  # nN
    law: str  # not "auto"
    cells: np.ndarray  # (place,) to a pixel; 0: by the front
    step: float  # nm
    splined: bool = False

    @property
    def key(self) -> tuple:
        """Identity of the case: equal keys are equal cases."""
        return id(self.ds), self.preload, self.cells.tobytes(), self.step, self.splined


class FactorCase(NamedTuple):
    """A factor at one of its settings, with its change, or the reason why it is refused."""

    factor: str
    setting: Any
    change: Change = Change(np.nan, np.nan, 0)
    reason: str = ""


def changes(
    base: Base, places: xr.Dataset, settings: Mapping[str, Iterable], *, pull: float, meshes: np.ndarray
) -> list[FactorCase]:
    """Return the change of the mean pull-off for each factor and setting.

    ``pull`` is the mean pull-off (nN), the unit of a change of the preload; ``meshes`` (place,) are the cells along a
    pixel on which the mean was simulated, the base of the factor "mesh".
    """
    cases: list[FactorCase] = []
    pairs: dict[int, tuple[Base, Base]] = {}
    for factor, values in settings.items():
        for value in values:
            try:
                pairs[len(cases)] = without_warnings(_changed_and_reference, base, factor, value, pull, meshes)
                cases.append(FactorCase(factor, value))
            except Refusal as refusal:
                cases.append(FactorCase(factor, value, reason=str(refusal)))
    count = places.sizes["subregion"]
    print_line(f"error budget: {len(pairs)} changes at {count} place{'s' * (count > 1)}")
    weight = shares(places).values
    solved = _solved([case_base for pair in pairs.values() for case_base in pair], places, base.ds)
    for k, (changed, reference) in pairs.items():
        cases[k] = cases[k]._replace(change=mean_change(solved[changed.key], solved[reference.key], weight))
    return cases


def _solved(bases: Sequence[Base], places: xr.Dataset, unchanged: xr.Dataset) -> dict[tuple, np.ndarray]:
    """Return the pull-offs (place,), nN, of each base by its key; NaN if they cannot be solved."""
    tasks: dict[tuple, Any] = {}
    different = {case_base.key: case_base for case_base in bases}
    for key, (ds, preload, law, cells, step, splined) in different.items():
        mesh = Mesh(int(cells[cells <= MOST_REFINED].max()) or FRONT, None, step)
        rests = resettle_if_changed(ds, places, unchanged)
        on_scan = np.flatnonzero(np.isfinite(rests["subregion_x"].values))  # a free particle may roll off
        solvable = rests.isel(subregion=on_scan)
        at_places = (
            place_cases(ds, solvable, preload=preload, law=law, mesh=mesh, splined=splined) if on_scan.size else []
        )
        tasks |= {(key, k): case.refined(cells[k]) for k, case in zip(on_scan, at_places) if cells[k] <= MOST_REFINED}
    pulls = dict(zip(tasks, pull_offs(list(tasks.values())).tolist())) if tasks else {}
    return {
        key: np.array([pulls.get((key, k), np.nan) for k in range(case_base.cells.size)])
        for key, case_base in different.items()
    }


def resettle_if_changed(ds: xr.Dataset, places: xr.Dataset, unchanged: xr.Dataset) -> xr.Dataset:
    """Return the places, and of a free particle on other heights or with another radius its own resting positions."""
    same = all(
        ds[name].variable.equals(unchanged[name].variable) for name in {"height", "sphere_radius"} & {*ds.variables}
    )
    return places if same or SHARE not in places.coords else resettled(ds, places)


def mean_change(force: np.ndarray, base: np.ndarray, weight: np.ndarray) -> Change:
    """Return the change of the mean over the places known in both, with its error by the scatter of their changes."""
    both = np.isfinite(force) & np.isfinite(base)
    n = int(both.sum())
    force = force[both]
    base = base[both]
    part = weight[both] / max(weight[both].sum(), 1e-300)
    mean = float(part @ base)
    if not n or not mean > 0:
        return Change(np.nan, np.nan, 0)
    change = float(part @ force) / mean - 1
    off = part * (force - (1 + change) * base)
    return Change(change, float(np.sqrt((off**2).sum() * n / (n - 1))) / mean if n > 1 else np.nan, n)


def _changed_and_reference(base: Base, factor: str, value: Any, pull: float, meshes: np.ndarray) -> tuple[Base, Base]:
    """Return the changed case and its reference; raise if the setting is impossible."""
    if factor == MESH:
        if (meshes * value > MOST_REFINED).all():
            raise Refusal(factor, f"at most {MOST_REFINED} cells per pixel", float(value * meshes.min()))
        reference = base._replace(cells=meshes)
        return reference._replace(cells=value * meshes, step=base.step / value), reference
    if factor == "preload":
        if not np.isfinite(pull):
            raise Refusal(factor, "a place at which the sphere adheres", "none")
        return base._replace(preload=base.preload + value * pull), base
    if factor == "interpolation":
        reference = base._replace(cells=np.where(base.cells == 1, 2, base.cells))
        return reference._replace(splined=True), reference
    if factor == RANGE and not ADHESION_LAWS[base.law].has_range:
        raise Refusal(factor, "a law that has a range", base.law)
    ds = CHANGES[factor](base.ds, value)
    # largest size of the cells over the size that a law needs; larger cells are refined
    finer = 0 if ADHESION_LAWS[base.law].has_edge else needed_cells(ds, base.preload, base.law, 1.25)
    reference = base._replace(cells=np.maximum(base.cells, finer))
    return reference._replace(ds=ds), reference


def needed_cells(ds: xr.Dataset, preload: float, law: str, slack: float = 1.0) -> int:
    """Return the number of cells along a pixel that a law needs, if they may be larger by a factor ``slack``."""
    problem, adhesion = preload_problem(ds, preload=preload, law=law, mesh=Mesh(MOST_REFINED, None))
    n = 1
    cell = slack * resolving_cell(adhesion, problem)
    while problem.pixel / n > cell and n < MOST_REFINED:
        n *= 2
    return n
