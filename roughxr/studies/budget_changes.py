"""The pull-off of the adhesive simulation under each change, at the same places in all cases.

Each change is that of the mean over the places known in both cases, against the base on cells of the same size; the
effect of the mesh is a case of its own. All cases of some places are solved in one batch. A law with a range can only
be solved on small cells: a case that needs smaller ones gets them, and the base beside it too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..contact.adhesion import settling
from ..contact.batch import cases_at, pull_offs
from ..contact.cycle import EDGED, bearing_cell
from ..contact.mesh import MOST_REFINED, Mesh
from ..jobs.progress import say
from ..statistics.sampling import shares
from ..vocabulary import schema
from .assumptions import RATIOS, Case
from .short_waves import quietly

#: Cells may exceed the size that a law needs by this factor before a case is solved on finer ones.
_SLACK = 1.25


class Simulation(NamedTuple):
    """How the base is simulated, and all cases unless they change it."""

    places: xr.Dataset
    preload: float  # nN
    law: str  # not "auto"
    mesh: Mesh  # on whose cells and with whose steps cases are compared
    pull: float  # nN, mean pull-off: the unit of a change of the preload
    meshes: np.ndarray  # (place,) cells to a pixel on which the mean was solved: "mesh" compares finer ones to them


class Change(NamedTuple):
    """The relative change of the mean over places."""

    value: float
    error: float  # its standard error by the scatter over places, NaN for one place
    places: int  # known in both cases


class _Ask(NamedTuple):
    """A scan and its pair, and how they are solved at each place."""

    of: int  # the case whose scan and pair they are, 0 for the base
    ds: xr.Dataset
    preload: float  # nN
    cells: np.ndarray  # (place,) to a pixel
    step: float  # nm
    splined: bool = False

    def key(self, place: int) -> tuple[int, int, int, float]:
        """Return what tells this pull-off from others."""
        return self.of, place, int(self.cells[place]), self.step


class _Plan(NamedTuple):
    """A case in words, what is solved for it and what it is compared to, or why nothing is."""

    words: str
    reason: str = ""
    changed: _Ask | None = None
    reference: _Ask | None = None


class Comparison:
    """The pull-offs of cases, and of the base beside each, at those places where they are solved so far.

    Known pull-offs (place,) of the base are given by cells to a pixel and step, NaN where they are not known.
    """

    def __init__(self, cases: Sequence[Case], way: Simulation, known: Mapping[tuple[int, float], np.ndarray]):
        self.cases, self.way = cases, way
        base = _Ask(0, cases[0].ds, way.preload, np.full(way.meshes.shape, way.mesh.refine), float(way.mesh.step))
        self.plans = [_planned(case, k, base, way) for k, case in enumerate(cases)]
        self.pulls = {
            (0, int(place), cells, float(step)): float(pulls[place])
            for (cells, step), pulls in known.items()
            for place in np.flatnonzero(np.isfinite(pulls))
        }

    def solve(self, cases: Sequence[int], places: Sequence[int]) -> None:
        """Solve cases at some places, as far as they are not known."""
        some, tasks = self.way.places.isel(subregion=list(places)), {}
        for ask in [ask for k in cases for ask in self.plans[k][2:] if ask is not None]:
            wanted = [(place, ask.key(place)) for place in places if ask.cells[place] <= MOST_REFINED]
            if all(key in self.pulls for _, key in wanted):
                continue
            mesh = Mesh(max(key[2] for _, key in wanted), None, ask.step)
            solve = partial(cases_at, preload=ask.preload, law=self.way.law, mesh=mesh, splined=ask.splined)
            solved = dict(zip(places, solve(ask.ds, some)))
            for place, key in wanted:
                if key not in self.pulls:
                    tasks[key] = solved[place].refined(key[2])
        say(f"{len(cases)} cases at {len(places)} places")
        if tasks:
            self.pulls |= zip(tasks, map(float, pull_offs(list(tasks.values()))))

    def results(self) -> xr.Dataset:
        """Return the results of each case along ``case``, at those places where any is solved."""
        at_places, weight = [self._at_places(plan) for plan in self.plans], shares(self.way.places).values
        rows = [_row(plan, *pulls, weight) for plan, pulls in zip(self.plans, at_places)]
        out = xr.Dataset({name: ("case", [row[name] for row in rows]) for name in rows[0]}, self.way.places.coords)
        out["standard_error"].attrs["units"] = "1"
        out = out.assign(pull_off_force=(("case", "subregion"), np.array([force for force, *_ in at_places])))
        out = out.assign_coords(setting=("case", [plan.words for plan in self.plans]))
        ratios = [case.value if case.factor in RATIOS else np.nan for case in self.cases]
        out = out.assign_coords(factor=("case", [case.factor for case in self.cases]), parameter_ratio=("case", ratios))
        ds = self.cases[0].ds
        out = out.assign_coords({name: ds[name] for name in schema.TRAVELLING if name in ds.coords})
        out.attrs = {"law": self.way.law, "preload_nN": self.way.preload}
        return out.isel(subregion=np.flatnonzero(np.any([tried for *_, tried in at_places], axis=0)))

    def _at_places(self, plan: _Plan) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return a case's pull-offs and the base's beside it, and where both are solved, be it in vain."""
        count = self.way.meshes.size
        if plan.changed is None or plan.reference is None:
            return np.full(count, np.nan), np.full(count, np.nan), np.zeros(count, bool)
        keys = [[ask.key(place) for place in range(count)] for ask in (plan.changed, plan.reference)]
        force, base = (np.array([self.pulls.get(key, np.nan) for key in some]) for some in keys)
        return force, base, np.array([all(key in self.pulls for key in both) for both in zip(*keys)])

    def known_at(self, k: int) -> int:
        """Return the number of places at which a case and the base beside it are solved."""
        return int(self._at_places(self.plans[k])[2].sum())


def _row(plan: _Plan, force: np.ndarray, base: np.ndarray, tried: np.ndarray, weight: np.ndarray) -> dict[str, Any]:
    """Return the results of one case; NaN, and the reason, where it cannot be computed."""
    change, known = change_of(force, base, weight), np.isfinite(force)
    none = "" if change.places else "no place could be followed in both cases"
    return {
        "pull_off_mean": np.average(force[known], weights=weight[known]) if known.any() else np.nan,
        "pull_off_std": force[known].std(ddof=1) if known.sum() > 1 else np.nan,
        "pull_off_median": np.median(force[known]) if known.any() else np.nan,
        "pull_off_change": change.value,
        "standard_error": change.error,
        "places": change.places,
        "missing_places": int(tried.sum()) - change.places,
        "refinement": int(plan.changed.cells.max()) if plan.changed else 0,
        "reason": plan.reason or none,
    }


def change_of(force: np.ndarray, base: np.ndarray, weight: np.ndarray) -> Change:
    """Return the change of the mean over the places known in both, and its error by the scatter of their changes.

    Examples
    --------
    >>> change_of(np.array([2.0, 4.0, np.nan]), np.array([1.0, 2.0, 1.0]), np.ones(3))
    Change(value=1.0, error=0.0, places=2)
    """
    both = np.isfinite(force) & np.isfinite(base)
    n, force, base = int(both.sum()), force[both], base[both]
    part = weight[both] / max(weight[both].sum(), 1e-300)
    mean = float(part @ base)
    if not n or not mean > 0:
        return Change(np.nan, np.nan, 0)
    change = float(part @ force) / mean - 1
    off = part * (force - (1 + change) * base)
    return Change(change, float(np.sqrt((off**2).sum() * n / (n - 1))) / mean if n > 1 else np.nan, n)


def _planned(case: Case, k: int, base: _Ask, way: Simulation) -> _Plan:
    """Return how a case is solved; why not, where its scan or pair cannot be changed or solved so."""
    words = str(case.value)
    try:
        words, ds = quietly(case.changed)
        changed, reference = _solves_of(case, base._replace(of=k, ds=ds), base, way)
    except ValueError as refused:
        return _Plan(words, str(refused))
    if case.factor == "preload":
        words = f"+ {changed.preload - base.preload:.3g} nN"
    return _Plan(words, "", changed, reference)


def _solves_of(case: Case, ask: _Ask, base: _Ask, way: Simulation) -> tuple[_Ask, _Ask]:
    """Return what is solved for a case, and beside it."""
    if case.factor == "base":
        return base, base
    if case.factor == "mesh":
        if (way.meshes * case.value > MOST_REFINED).all():
            raise ValueError(
                f"it needs cells {case.value * way.meshes.min():g} times finer than the pixels, at most {MOST_REFINED} "
                "times is done"
            )
        reference = base._replace(cells=way.meshes)
        return reference._replace(cells=case.value * way.meshes, step=base.step / case.value), reference
    if case.factor == "preload":
        if not np.isfinite(way.pull):
            raise ValueError("no place pulls in the base case")
        return ask._replace(preload=base.preload + case.value * way.pull), base
    if case.factor == "range of adhesion" and way.law == "griffith":
        raise ValueError("this law, Griffith's limit, has no range")
    if case.factor == "interpolation":
        halved = base._replace(cells=np.maximum(base.cells, 2))
        return halved._replace(of=ask.of, splined=True), halved
    finer = 1 if way.law in EDGED else cells_for(ask.ds, way.preload, way.law, _SLACK)
    cells = np.maximum(base.cells, finer)
    return ask._replace(cells=cells), base._replace(cells=cells)


def cells_for(ds: xr.Dataset, preload: float, law: str, slack: float = 1.0) -> int:
    """Return how many cells to a pixel a law needs between the bodies, but for a slack."""
    problem, adhesion = settling(ds, preload=preload, law=law, mesh=Mesh(MOST_REFINED, None))
    n, cell = 1, slack * bearing_cell(adhesion, problem.contact_modulus)
    while problem.pixel / n > cell and n < MOST_REFINED:
        n *= 2
    return n
