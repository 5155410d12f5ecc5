"""The pull-off of the adhesive simulation under each change, at the same places in all cases.

Each change is that of the mean over the places known in both cases, against the base on cells of the same size; the
effect of the mesh is a case of its own. All cases of some places are solved in one batch. A law with a range can only
be solved on small cells: a case that needs smaller ones gets them, and the base beside it too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from ...contact.adhesion import settling
from ...contact.cycle import EDGED, bearing_cell
from ...contact.many_cases import cases_at, pull_offs
from ...contact.mesh import MOST_REFINED, Mesh
from ...jobs.progress import say
from ...statistics.sampling import shares
from ...vocabulary import schema
from ..short_waves import quietly
from .changes import Case

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
    beside: _Ask | None = None


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
        some, groups = self.way.places.isel(subregion=list(places)), {}
        for ask in [ask for k in cases for ask in self.plans[k][2:] if ask is not None]:
            wanted = [(place, ask.key(place)) for place in places if ask.cells[place] <= MOST_REFINED]
            if all(key in self.pulls for _, key in wanted):
                continue
            mesh = Mesh(max(key[2] for _, key in wanted), None, ask.step)
            how = {"preload": ask.preload, "law": self.way.law, "mesh": mesh}
            found = dict(zip(places, cases_at(ask.ds, some, **how, splined=ask.splined)))
            for place, key in wanted:
                if key not in self.pulls:
                    groups.setdefault((place, key[2]), {})[key] = found[place].on(key[2])
        say(f"{len(cases)} cases at {len(places)} places")
        solved = pull_offs([list(group.values()) for group in groups.values()]) if groups else ()
        for group, pulls in zip(groups.values(), solved):
            self.pulls |= zip(group, map(float, pulls))

    def told(self) -> xr.Dataset:
        """Return the results of each case along ``case``, at those places where any is solved."""
        places, weight = range(self.way.meshes.size), shares(self.way.places).values
        force, base = (
            np.array([[self._pull(plan[side], place) for place in places] for plan in self.plans]) for side in (2, 3)
        )
        tried = np.array([[self._is_tried(plan, place) for place in places] for plan in self.plans])
        found = [change_of(*pulls, weight) for pulls in zip(force, base)]
        means = [
            np.average(one[known], weights=weight[known]) if (known := np.isfinite(one)).any() else np.nan
            for one in force
        ]
        none = "no place could be followed in both cases"
        reasons = [plan.reason or none * (not change.places) for plan, change in zip(self.plans, found)]
        told = {
            "pull_off_mean": means,
            "pull_off_std": [np.nanstd(one, ddof=1) if np.isfinite(one).sum() > 1 else np.nan for one in force],
            "pull_off_median": [np.nanmedian(one) if np.isfinite(one).any() else np.nan for one in force],
            "pull_off_change": [change.value for change in found],
            "standard_error": [change.error for change in found],
            "places": [change.places for change in found],
            "missing_places": [int(some.sum()) - change.places for some, change in zip(tried, found)],
            "refinement": [
                int(plan.changed.cells.max()) if plan.changed else self.way.mesh.refine for plan in self.plans
            ],
            "reason": reasons,
        }
        out = xr.Dataset({name: ("case", values) for name, values in told.items()}, self.way.places.coords)
        out = out.assign(pull_off_force=(("case", "subregion"), force))
        out["standard_error"].attrs["units"] = "1"
        out = out.assign_coords(setting=("case", [plan.words for plan in self.plans]))
        ds = self.cases[0].ds
        out = out.assign_coords({name: ds[name] for name in schema.TRAVELLING if name in ds.coords})
        out.attrs = {"law": self.way.law, "preload_nN": self.way.preload}
        return out.isel(subregion=np.flatnonzero(tried.any(axis=0)))

    def known_at(self, k: int) -> int:
        """Return the number of places at which a case and the base beside it are solved."""
        return sum(self._is_tried(self.plans[k], place) for place in range(self.way.meshes.size))

    def _pull(self, ask: _Ask | None, place: int) -> float:
        return self.pulls.get(ask.key(place), np.nan) if ask else np.nan

    def _is_tried(self, plan: _Plan, place: int) -> bool:
        """Return whether a case and the base beside it are solved at a place, be it in vain."""
        return all(ask is not None and ask.key(place) in self.pulls for ask in plan[2:])


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
        changed, beside = _asked(case, base._replace(of=k, ds=ds), base, way)
    except ValueError as refused:
        return _Plan(words, str(refused))
    if case.factor == "preload":
        words = f"+ {changed.preload - base.preload:.3g} nN"
    return _Plan(words, "", changed, beside)


def _asked(case: Case, ask: _Ask, base: _Ask, way: Simulation) -> tuple[_Ask, _Ask]:
    """Return what is solved for a case, and beside it."""
    if case.factor == "base":
        return base, base
    if case.factor == "mesh":
        if (way.meshes * case.value > MOST_REFINED).all():
            raise ValueError(
                f"it needs cells {case.value * way.meshes.min():g} times finer than the pixels, at most {MOST_REFINED} "
                "times is done"
            )
        beside = base._replace(cells=way.meshes)
        return beside._replace(cells=case.value * way.meshes, step=base.step / case.value), beside
    if case.factor == "preload":
        if not np.isfinite(way.pull):
            raise ValueError("no place pulls in the base case")
        return ask._replace(preload=base.preload + case.value * way.pull), base
    if case.factor == "range of adhesion" and way.law == "griffith":
        raise ValueError("this law, Griffith's limit, has no range")
    if case.factor == "interpolation":
        halved = base._replace(cells=np.maximum(base.cells, 2))
        return halved._replace(of=ask.of, splined=True), halved
    times = schema.square_pixel(ask.ds) / schema.square_pixel(base.ds)  # pixels joined to one, along a side
    if times != 1:
        cells = np.clip(np.round(base.cells / times), 1, MOST_REFINED)
        return ask._replace(cells=cells), base._replace(cells=np.round(cells * times))
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
