"""The pull-off of the adhesive simulation under each change, at the same few places in all cases.

Each change is that of the mean over the places, against the base case on cells of the same size; the effect of the mesh
is a case of its own. A law with a range can only be solved on small cells: a case that needs smaller ones gets them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...contact.adhesion import adhesive
from ...contact.cycle import EDGED, largest_cell
from ...contact.mesh import MOST_REFINED, Mesh
from ...jobs.progress import say
from ...vocabulary import schema
from ..short_waves import quietly
from .changes import Case

#: Cells may exceed the size that a law needs by this factor before a case is solved on finer ones.
_SLACK = 1.25


class Simulation(NamedTuple):
    """Options of the simulation in all cases, unless a case changes them."""

    places: xr.Dataset
    preload: float  # nN
    law: str
    mesh: Mesh  # of the base case


class _Solver:
    """Solves the base case, once on each mesh, and cases that differ from it."""

    def __init__(self, ds: xr.Dataset, way: Simulation):
        found = quietly(adhesive, ds, mesh=way.mesh, **_options(way))
        self.ds, self.way, self.refine = ds, way._replace(law=found.attrs["law"]), int(found["refinement"].max())
        self._base = {self.refine: found["pull_off_force"]}
        self.resolution = float(found["pull_off_resolution"].median()) / self.refine

    def pull(self, ds: xr.Dataset, refine: int, times: float = 1.0, **changed: Any) -> xr.DataArray:
        """Return the pull-off at each place (nN), with steps so many times as long."""
        if refine > MOST_REFINED:
            raise ValueError(
                f"it needs cells {refine} times finer than the pixels, at most {MOST_REFINED} times is done"
            )
        mesh = Mesh(refine, step=times * self.way.mesh.step)
        return quietly(adhesive, ds, mesh=mesh, **{**_options(self.way), **changed})["pull_off_force"]

    def base(self, refine: int) -> xr.DataArray:
        """Return the base case's pull-off on a mesh."""
        if refine not in self._base:
            self._base[refine] = self.pull(self.ds, refine)
        return self._base[refine]

    def refinement_for(self, ds: xr.Dataset) -> int:
        """Return the refinement, that of the base case or finer, on which the law can be solved for a pair."""
        if self.way.law in EDGED:
            return self.refine
        length, modulus, work = schema.pair(ds, "adhesion_range", "contact_modulus", "work_of_adhesion", wet=True)
        work *= float(ds.coords.get("share_under_liquid", 1.0))
        cell = _SLACK * largest_cell(self.way.law, length, modulus, work)
        n = self.refine
        while schema.square_pixel(self.ds) / n > cell and n < MOST_REFINED:
            n *= 2
        return n


def simulated(ds: xr.Dataset, cases: Sequence[Case], way: Simulation) -> xr.Dataset:
    """Return the results of each case along ``case``, and its pull-offs along (case, subregion)."""
    say(f"sensitivity of the simulation at {way.places.sizes['subregion']} places, {len(cases) - 1} changes")
    solver = _Solver(ds, way)
    rows = []
    for k, case in enumerate(cases[1:], 1):
        rows.append(_row(case, solver))
        say(f"  {k} of {len(cases) - 1}: {case.factor}, {rows[-1]['setting'].values[0]}")
    out = xr.concat(
        [_row(cases[0], solver), *rows], dim="case", data_vars="minimal", coords="minimal", compat="override"
    )
    out = out.assign_coords({name: ds[name] for name in schema.TRAVELLING if name in ds.coords})
    attrs = {"law": solver.way.law, "preload_nN": way.preload, "contact_radius_pixels": solver.resolution}
    return out.assign_attrs(attrs)


def _options(way: Simulation) -> dict[str, Any]:
    return {"subregions": way.places, "preload": way.preload, "law": way.law}


def _row(case: Case, solver: _Solver) -> xr.Dataset:
    """Return the results of one case; NaN, and the reason, where it cannot be computed."""
    base = solver.base(solver.refine)
    words, reason, refine = str(case.value), "", solver.refine
    try:
        words, ds = quietly(case.changed)
        words, force, base, refine = _solved(case, words, ds, solver)
    except ValueError as refused:
        force, reason = xr.full_like(base, np.nan), str(refused)
    both = force.notnull() & base.notnull()
    if not reason and not both.any():
        reason = "no place could be followed in both cases"
    values = {
        "pull_off_mean": float(force.mean()),
        "pull_off_std": float(force.std(ddof=1)) if int(force.count()) > 1 else np.nan,
        "pull_off_median": float(force.median()),
        "pull_off_change": float(force.where(both).mean() / base.where(both).mean()) - 1,
        "refinement": refine,
        "reason": reason,
    }
    row = xr.Dataset({name: ("case", [value]) for name, value in values.items()}, {"setting": ("case", [words])})
    others = [name for name in force.coords if "subregion" not in str(name)]
    return row.assign(pull_off_force=force.drop_vars(others).expand_dims("case"))


def _solved(case: Case, words: str, ds: xr.Dataset, solver: _Solver) -> tuple[str, xr.DataArray, xr.DataArray, int]:
    """Return a case in words, its pull-offs, those of the base case on cells of the same size, and the refinement."""
    n, way = solver.refine, solver.way
    if case.factor == "mesh":
        return words, solver.base(case.value * n), solver.base(n), case.value * n
    if case.factor == "step":
        return words, solver.pull(ds, n, case.value), solver.base(n), n
    if case.factor == "preload":
        more = case.value * float(solver.base(n).mean())
        return f"+ {more:.3g} nN", solver.pull(ds, n, preload=way.preload + more), solver.base(n), n
    if case.factor == "range of adhesion" and way.law == "griffith":
        raise ValueError("this law, Griffith's limit, has no range")
    if case.factor in ("pixel", "interpolation"):
        times = schema.square_pixel(solver.ds) / schema.square_pixel(ds)  # pixels joined to one, along a side
        cells = int(min(max(round(n / times), 1), MOST_REFINED))
        return words, solver.pull(ds, cells), solver.base(round(cells * times)), cells
    n = solver.refinement_for(ds)
    return words, solver.base(n) if case.factor == "base" else solver.pull(ds, n), solver.base(n), n
