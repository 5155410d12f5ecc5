"""The results of a run at each of its places: curves, events, pull-offs and numbers, for all values of parameters."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...contact.rigid.bodies import rigid
from ...figures.style import in_words
from ...jobs.records import BRANCHES
from ...statistics.sampling import SHARE
from ...studies.short_waves import quietly
from ...vocabulary import schema
from ..intervals import flagged

Run = Mapping[str, xr.Dataset]

#: Parameters that may be dimensions of a result besides the places; each becomes a slider.
PARAMETERS = ("preload", "sphere_radius", "contact_modulus", "work_of_adhesion", "cycle")

#: Solutions whose force is drawn, by their names in the legend; the first are drawn on top.
METHODS = {
    "adhesive": "simulation with adhesion",
    "direct": "direct, without adhesion",
    "energy": "superposed, least energy",
    "menisci": "superposed asperities",
    "self_similar": "superposed, self-similar",
    "published": "superposed, as published",
    "hertz": "superposed, without adhesion",
    "rigid": "rigid bodies",
}

#: Numbers of one place that are shown beside its images.
_NUMBERS = (
    "pull_off_force",
    "pull_off_error",
    "snap_in_force",
    "work_of_separation",
    "hysteresis",
    "detachment_delta",
    "preload_delta",
    "contact_area",
    "yielded_area",
    "refinement",
)

#: What is shown of a place where particles rest, by group.
_OF_RESTS = (
    ("statistics/rests", SHARE),
    ("statistics/rests", "carriers"),
    ("statistics/rests", "barrier"),
)

#: Largest number of displacements in a curve.
_MOST_POINTS = 320


class Placed(NamedTuple):
    """A run, and the places of its scan that the page shows."""

    run: Run
    places: xr.Dataset  # subregion, subregion_x, subregion_y
    touched: Mapping[float, np.ndarray]  # by radius (nm): first touch at each place, nm below the highest peak

    @property
    def size(self) -> int:
        """Number of places."""
        return self.places.sizes["subregion"]

    def held(self, group: str) -> xr.Dataset | None:
        """Return a group of the run if it has these places, in their order."""
        return _of_places(self.run, self.places, group)

    def shift(self, one: xr.Dataset) -> np.ndarray:
        """Return the offset to add to a result's displacements (nm) so that they count from the highest peak."""
        return self.touched[_radius(one, self.run["scan"])] if _from_touch(one) else np.zeros(self.size)


def placed(run: Run) -> Placed:
    """Return a run with its contact centres: those of its first result that has any."""
    names = [f"solutions/{name}" for name in METHODS] + [f"statistics/{name}" for name in METHODS]
    results = (run[name] for name in [*names, *run] if name in run and "subregion_x" in run[name].coords)
    first = next(results, None)
    if first is None or first.sizes.get("subregion", 0) == 0:
        held = ", ".join(run) or "none"
        raise ValueError(f"expected results at places of the scan (subregion_x, subregion_y), found groups: {held}")
    places = xr.Dataset(coords={name: first[name] for name in ("subregion", "subregion_x", "subregion_y")})
    return Placed(run, places, _touched(run, places))


def _of_places(run: Run, places: xr.Dataset, group: str) -> xr.Dataset | None:
    ds = run.get(group)
    if ds is None or "subregion_x" not in ds.coords or ds.sizes.get("subregion") != places.sizes["subregion"]:
        return None
    same = all(np.allclose(ds[name], places[name]) for name in ("subregion_x", "subregion_y"))
    return ds if same else None


def _from_touch(one: xr.Dataset) -> bool:
    return one.attrs.get("datum") == "first_contact"


def _radius(one: xr.Dataset, scan: xr.Dataset) -> float:
    """Return the sphere's radius (nm) of a result, 0 for an indenter that is no sphere."""
    return float(one.coords.get("sphere_radius", scan.coords.get("sphere_radius", 0.0)))


def _touched(run: Run, places: xr.Dataset) -> dict[float, np.ndarray]:
    """Return the depth of first touch at each place, for each radius whose results count from there."""
    depths: dict[float, np.ndarray] = {}
    for name in METHODS:
        ds = _of_places(run, places, f"solutions/{name}")
        for _, one in cases(ds) if ds is not None and _from_touch(ds) else ():
            radius = _radius(one, run["scan"])
            if radius not in depths:
                depths[radius] = _first_touch(run, places, one, radius)
    return depths


def _first_touch(run: Run, places: xr.Dataset, one: xr.Dataset, radius: float) -> np.ndarray:
    kept = _of_places(run, places, "solutions/rigid")
    if kept is not None and kept["touch_delta"].dims == ("subregion",) and _radius(kept, run["scan"]) == radius:
        return kept["touch_delta"].values
    # without warnings about its pull, which is not used
    return quietly(rigid, with_pair(run["scan"], one), delta=[0.0], subregions=places)["touch_delta"].values


def with_pair(scan: xr.Dataset, one: xr.Dataset) -> xr.Dataset:
    """Return the scan with the pair of a result, which may differ from that assigned to the scan."""
    pair = {name: one[name] for name in schema.PAIR if name in one.coords and one[name].ndim == 0}
    return scan.assign_coords({name: float(value) for name, value in pair.items()})


def over(ds: xr.Dataset | xr.DataArray) -> list[str]:
    """Return the parameters that are dimensions of a result."""
    return [name for name in PARAMETERS if name in ds.dims]


def cases(ds: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield a result for each combination of its parameters, with their values as text."""
    names = over(ds)
    for at in itertools.product(*(range(ds.sizes[name]) for name in names)):
        one = ds.isel(dict(zip(names, at)))
        yield ";".join(_word(float(one[name])) for name in names), one


def _word(value: float) -> str:
    return f"{value:.10g}"


def axes(results: list[xr.Dataset]) -> list[dict[str, Any]]:
    """Return the sliders: each parameter with the values in any of the results."""
    sliders = []
    for name in PARAMETERS:
        values = sorted({float(value) for ds in results if name in ds.dims for value in ds[name].values})
        if values:
            words = schema.VARIABLES[name]
            row = {"name": name, "label": words.long_name, "unit": _unit(name), "values": values}
            sliders.append(row | {"words": [_word(value) for value in values]})
    return sliders


def _unit(name: str) -> str:
    units = schema.VARIABLES[name].units
    return "" if units == "1" else units.replace("J/m^2", "J/m²").replace("nm^2", "nm²")


def rows(at: Placed) -> list[dict[str, Any]]:
    """Return the positions of the places, which hold debris by the rule, and what share of particles rests there."""
    flags = flagged(at.run)
    debris = np.zeros(at.size, bool)
    if flags is not None and flags.size == debris.size:
        debris = flags.values
    columns = zip(at.places["subregion_x"].values.tolist(), at.places["subregion_y"].values.tolist(), debris.tolist())
    told = [{"x": x, "y": y, "debris": flag} for x, y, flag in columns]
    rests = at.held("statistics/rests")
    shares = [] if rests is None else numbers(rests[SHARE].values)
    return [{**row, "share": share} for row, share in zip(told, shares)] or told


def curves(at: Placed) -> list[dict[str, Any]]:
    """Return the force over displacement, nm from the highest peak, for every method that has it in the run."""
    shown = []
    for name, words in METHODS.items():
        ds = at.held(f"solutions/{name}")
        if ds is None or "delta" not in ds.dims or "force" not in ds or ds.sizes["delta"] < 2:
            continue
        back = at.held("solutions/retraction") if name == "direct" else None
        lines = {key: _lines(at, one, back) for key, one in cases(ds[["force"]].assign_attrs(ds.attrs))}
        shown.append({"name": name, "label": words, "over": over(ds), "lines": lines})
    return shown


def _lines(at: Placed, one: xr.Dataset, back: xr.Dataset | None) -> list[list[dict[str, Any]]]:
    """Return both branches of each place, or the only one."""
    thin = one.isel(delta=slice(None, None, -(-one.sizes["delta"] // _MOST_POINTS)))
    parts = [("", thin)]
    if "branch" in one.dims:
        parts = [(way, thin.sel(branch=way)) for way in BRANCHES]
    elif back is not None:
        parts = [(BRANCHES[0], thin), (BRANCHES[1], back)]
    offset = at.shift(one)
    return [[_line(way, ds, k, offset[k]) for way, ds in parts] for k in range(at.size)]


def _line(way: str, ds: xr.Dataset, k: int, offset: float) -> dict[str, Any]:
    force = ds["force"].transpose("subregion", "delta").values[k]
    return {"branch": way, "delta": numbers(ds["delta"].values + offset), "force": numbers(force)}


def events(at: Placed) -> dict[str, Any] | None:
    """Return the events of the simulation with adhesion: first contact, turning point, pull-off, detachment."""
    ds = at.held("solutions/adhesive")
    if ds is None or "pull_off_force" not in ds:
        return None
    points = {key: _points(one, at.shift(one)) for key, one in cases(ds)}
    return {"over": over(ds), "points": points}


def _points(one: xr.Dataset, offset: np.ndarray) -> list[list[dict[str, Any]]]:
    """Return the events of each place as points of its loop, without those that the run does not hold."""
    told = {
        "first contact": ("snap_in_delta", -_of(one, "snap_in_force")),
        "turning point": ("preload_delta", np.full(offset.size, _preload(one))),
        "pull-off": ("pull_off_delta", -_of(one, "pull_off_force")),
        "parting": ("detachment_delta", np.zeros(offset.size)),
    }
    points = {words: (_of(one, name) + offset, force) for words, (name, force) in told.items()}
    return [
        [
            {"is": words, "delta": number(delta[k]), "force": number(force[k])}
            for words, (delta, force) in points.items()
            if np.isfinite(delta[k]) and np.isfinite(force[k])
        ]
        for k in range(offset.size)
    ]


def _preload(one: xr.Dataset) -> float:
    preload = one.coords.get("preload", schema.arguments_of(one, "adhesive").get("preload"))
    return 0.0 if preload is None or np.ndim(preload) else float(preload)


def _of(one: xr.Dataset, name: str) -> np.ndarray:
    return one[name].values.astype(float) if name in one else np.full(one.sizes["subregion"], np.nan)


def pull_offs(at: Placed) -> list[dict[str, Any]]:
    """Return the pull-off of every place, by every method that has it, with the bins of its histogram."""
    shown = []
    for name, words in METHODS.items():
        held_there = (at.held(f"{part}/{name}") for part in ("statistics", "solutions"))
        ds = next((ds for ds in held_there if ds is not None and "pull_off_force" in ds), None)
        if ds is None or set(ds["pull_off_force"].dims) - {"subregion", *PARAMETERS}:
            continue
        values = {key: one["pull_off_force"].values for key, one in cases(ds[["pull_off_force"]])}
        known = np.concatenate([row[np.isfinite(row)] for row in values.values()])
        if known.size:
            told = {key: numbers(row) for key, row in values.items()}
            bins = {key: numbers(_bins(row)) for key, row in values.items()}
            shown.append({"name": name, "label": words, "over": over(ds), "values": told, "bins": bins})
    return shown


def _bins(values: np.ndarray) -> np.ndarray:
    known = values[np.isfinite(values)]
    if known.size == 0:
        return np.array([0.0, 1.0])
    edges = np.histogram_bin_edges(known, "auto")
    return edges if edges.size <= 41 else np.linspace(edges[0], edges[-1], 41)


def facts(at: Placed) -> dict[str, Any] | None:
    """Return the numbers of each place from the simulation with adhesion, and of rests, with their names and units."""
    ds = at.held("solutions/adhesive")
    names = [] if ds is None else [name for name in _NUMBERS if name in ds and _of_each_place(ds[name])]
    if ds is None or not names:
        return None
    rests = {name: held[name].values for group, name in _OF_RESTS if (held := at.held(group)) is not None}
    told = [{"label": in_words(name).partition(" [")[0], "unit": _unit(name)} for name in [*rests, *names]]
    values = {}
    for key, one in cases(ds[names].assign_attrs(ds.attrs)):
        offset = at.shift(one)
        values[key] = [numbers(row) for row in rests.values()]
        values[key] += [numbers(_of(one, name) + (offset if name.endswith("_delta") else 0.0)) for name in names]
    return {"over": over(ds), "rows": told, "values": values}


def _of_each_place(array: xr.DataArray) -> bool:
    """Return whether a variable has one number for each place, at least one of which is known."""
    return not set(array.dims) - {"subregion", *PARAMETERS} and bool(array.notnull().any())


def doubts(at: Placed) -> list[list[str]]:
    """Return the reasons to distrust each place, as sentences."""
    said: list[list[str]] = [[] for _ in range(at.size)]
    for name, words in METHODS.items():
        ds = at.held(f"solutions/{name}")
        for flag, bad, what in _FLAGS:
            if ds is not None and flag in ds and (name in ("adhesive", "direct") or flag != "truncated"):
                wrong = ds[flag].astype(bool) == bad
                wrong = wrong.any([dim for dim in wrong.dims if dim != "subregion"])
                for k in np.flatnonzero(wrong.values):
                    said[k].append(f"{what} ({words})")
    return said


_FLAGS = (
    ("converged", False, "a solution has not converged"),
    ("complete", False, "the cycle was not completed"),
    ("truncated", True, "contact reaches the scan's edge"),
)


def number(value: float) -> float | None:
    """Return a number to five digits, None for a missing one."""
    return float(f"{value:.5g}") if np.isfinite(value) else None


def numbers(values: np.ndarray) -> list[float | None]:
    """Return numbers to five digits, None for missing ones."""
    return [number(value) for value in np.asarray(values, float).tolist()]
