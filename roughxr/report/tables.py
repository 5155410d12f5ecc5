"""The main numbers of a run as tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from ..contact.certificate import SOLVED, checked
from ..scans.regions import extent
from ..statistics import force_ratio, smooth_pull_off
from ..statistics.sampling import SHARE, by_share
from ..vocabulary.numbers import number, prefixed
from .intervals import counted_from, marked
from .summary import mesh_change

Run = Mapping[str, xr.Dataset]

#: Columns of the comparison, for the methods that a run holds.
METHODS = ("adhesive", "rigid", "published", "self_similar", "energy", "direct")

_MICRO = 1e-3  # µm per nm

_PARTING = "displacement beyond which superposition differs by over 10 %, median place [nm]"


def contact_table(run: Run, *, deltas: Sequence[float] = ()) -> pd.DataFrame:
    """Return the contact's main numbers by method."""
    pulls = [run[f"statistics/{method}"]["pull_off_force"] for method in METHODS if f"statistics/{method}" in run]
    unit = prefixed(max((float(pull.mean()) for pull in pulls if pull.notnull().any()), default=0.0))
    columns = {}
    for method in METHODS:
        for name, one in _by_preload(run, method) if f"solutions/{method}" in run else ():
            columns[name] = _column(one, method, deltas, *unit) | _kept(one[f"solutions/{method}"], method)
    return pd.DataFrame(columns).rename_axis("quantity")


def _by_preload(run: Run, method: str) -> list[tuple[str, Run]]:
    """Return a run for each preload of a method, and what its column is called; the run itself where there is one."""
    pull = run.get(f"statistics/{method}", xr.Dataset())
    if pull.sizes.get("preload", 1) == 1:
        return [(method, run)]
    of_one = [name for name, ds in run.items() if "preload" in ds.dims]
    return [
        (f"{method}, {load:g} nN", {**run, **{name: run[name].isel(preload=k) for name in of_one}})
        for k, load in enumerate(pull["preload"].values)
    ]


def _column(run: Run, method: str, deltas: Sequence[float], unit: str, size: float) -> dict[str, float]:
    if method == "direct":
        return _direct_column(run, deltas)
    rows = _pull_off_rows(run, method, unit, size)
    if method == "adhesive":
        return rows | _mesh_rows(run)
    if method == "rigid":
        return rows
    return rows | {
        "contacts beyond their patch at pull-off [%]": share_at_pull_off(run, method, "contacts_beyond_patch"),
        "contacts overlapping at pull-off [%]": share_at_pull_off(run, method, "contacts_overlapping"),
    }


def _kept(solution: xr.Dataset, method: str) -> dict[str, float]:
    """Return how many conditions of its contact a solution misses."""
    if method not in SOLVED or "converged" not in solution:
        return {}
    return {"conditions of the contact that are not met (certificate)": float((~checked(solution)["met"]).sum())}


def _mesh_rows(run: Run) -> dict[str, float]:
    """Return the change of the pull-off on a finer mesh with shorter steps, at the places solved on both."""
    if "solutions/finer" not in run:
        return {}
    change = mesh_change(run)
    return {
        "pull-off, error of mesh and step, median [%]": 100 * float(abs(change).median()),
        "places solved on a mesh twice as fine": float(change.notnull().sum()),
    }


def _pull_off_rows(run: Run, method: str, unit: str, size: float) -> dict[str, float]:
    pull = run[f"statistics/{method}"]
    force, delta = pull["pull_off_force"] / size, pull["pull_off_delta"]
    smooth = smooth_pull_off(run[f"solutions/{method}"]) / size
    return {
        f"pull-off, smooth sphere [{unit}]": smooth,
        f"pull-off, mean [{unit}]": float(by_share(force).mean()),
        f"pull-off, std [{unit}]": _spread(force),
        f"pull-off, largest [{unit}]": float(force.max()),
        "pull-off, rough / smooth": float(by_share(force).mean()) / smooth if smooth > 0 else np.nan,
        f"displacement at pull-off {counted_from(pull)}, mean [nm]": float(by_share(delta).mean()),
        f"displacement at pull-off {counted_from(pull)}, std [nm]": _spread(delta),
        "places that pull": float(force.notnull().sum()),
    }


def _spread(values: xr.DataArray) -> float:
    """Return the standard deviation (n − 1) of the finite values, NaN for fewer than two."""
    if int(values.notnull().sum()) < 2:
        return np.nan
    return float(by_share(values).std() if SHARE in values.coords else values.std(ddof=1))


def share_at_pull_off(run: Run, method: str, name: str) -> float:
    """Return the share of contacts at the pull-off of their subregion that are counted as ``name``, in per cent."""
    sweep, at = run[f"solutions/{method}"], run[f"statistics/{method}"]["pull_off_delta"]
    pulling = sweep.isel(subregion=np.flatnonzero(at.notnull().values))
    there = pulling.sel(delta=at.dropna("subregion"), method="nearest")
    contacts = float(there["contacts"].sum())
    return 100 * float(there[name].sum()) / contacts if contacts else np.nan


def _direct_column(run: Run, deltas: Sequence[float]) -> dict[str, float]:
    direct = run["solutions/direct"]
    deltas = deltas or marked(direct)
    unit, size = prefixed(float(direct["force"].isel(delta=-1).mean()))
    force = direct["force"] / size
    rows = {}
    for delta in deltas:
        here = force.sel(delta=delta, method="nearest")
        rows[f"force at {number(delta, 'nm')}, mean [{unit}]"] = float(here.mean())
        rows[f"force at {number(delta, 'nm')}, std [{unit}]"] = _spread(here)
        rows[f"force at {number(delta, 'nm')}, largest [{unit}]"] = float(here.max())
    if "solutions/smooth" in run:
        smooth = run["solutions/smooth"]["force"].isel(subregion=0, drop=True) / size
        for delta in deltas:
            rough, flat = (one.sel(delta=delta, method="nearest") for one in (force.mean("subregion"), smooth))
            rows[f"rough / smooth force at {number(delta, 'nm')}"] = float(rough / flat)
    if "solutions/hertz" in run:
        rows[_PARTING] = float(force_ratio(run["solutions/hertz"], direct)["parting_delta"].median())
    return rows


def scan_table(run: Run) -> pd.DataFrame:
    """Return the main numbers of scan and asperities."""
    height, catalogue = run["scan"]["height"], run["asperities"]
    x_min, x_max, y_min, y_max = extent(run["scan"])
    envelope = run["reconstruction"]
    ratio = catalogue["axis_ratio"]
    rows = {
        "size along x [µm]": (x_max - x_min) * _MICRO,
        "size along y [µm]": (y_max - y_min) * _MICRO,
        "height, least [nm]": float(height.min()),
        "height, greatest [nm]": float(height.max()),
        "height, mean [nm]": float(height.mean()),
        "height, std [nm]": float(height.std()),
        "R_q about zero, original [nm]": float(np.sqrt((height**2).mean())),
        "R_q about zero, reconstructed [nm]": float(np.sqrt((envelope["height"] ** 2).mean())),
        "R_a about zero, original [nm]": float(np.abs(height).mean()),
        "R_a about zero, reconstructed [nm]": float(np.abs(envelope["height"]).mean()),
        "R_a, reconstructed above original [%]": _above(abs(envelope["height"]), abs(height), 1),
        "R_q, reconstructed above original [%]": _above(envelope["height"], height, 2),
        "original - reconstructed, rms [nm]": envelope.attrs["residual_rms"],
        "asperities": float(catalogue.sizes["asperity"]),
        "peak height, median [nm]": float(catalogue["height"].median()),
        "axis ratio b/a, mean": float(ratio.mean()),
        "axis ratio b/a, std": float(ratio.std()),
        "less than ten times as long as wide [%]": 100 * float((ratio > 0.1).sum() / ratio.notnull().sum()),
        "directions, least / greatest of twelve bins": _evenness(catalogue["orientation"].values),
        "peaks that fit no summit [%]": 100 * float(catalogue["saddle"].mean()),
    }
    return pd.DataFrame({"scan": rows}).rename_axis("quantity")


#: Formulas and the names that readers know them by.
_FORMULAS = {
    "sum": "rigid bodies, attraction summed over the scan (median place)",
    "bradley": "Bradley, smooth sphere",
    "rumpf": "Rumpf, median radius of the asperities",
    "rumpf_rms": "Rumpf, by rms height",
    "rabinovich": "Rabinovich, one scale",
    "rabinovich_two_scales": "Rabinovich, two scales",
    "gaussian_heights": "rigid bodies, Gaussian heights with the scan's rms",
    "smooth": "smooth sphere, 4πRγ cos θ plus the dry van der Waals pull",
    "summit": "the same on one hemisphere with the summits' median radius",
    "plane_below": "Rabinovich 2002, over a plane 1.82 rms below (0: no liquid reaches it)",
}


def formula_table(run: Run) -> pd.DataFrame:
    """Return the pull-off by the usual formulas, and its ratio to the sum over the scan."""
    force = run["statistics/formulas"]["pull_off_force"]
    unit, size = prefixed(float(force.sel(formula="sum")))
    columns = {f"pull-off [{unit}]": force / size, "over rigid bodies": force / force.sel(formula="sum", drop=True)}
    if "statistics/adhesive" in run:
        columns["over simulation with adhesion"] = force / float(run["statistics/adhesive"]["pull_off_force"].median())
    table = pd.DataFrame({name: column.values for name, column in columns.items()})
    table.index = pd.Index([_FORMULAS[name] for name in force["formula"].values], name="formula")
    return table


def _above(values: xr.DataArray, others: xr.DataArray, power: int) -> float:
    """Return the excess, in per cent, of one set's mean power over another's, as a length."""
    return 100 * float(((values**power).mean() / (others**power).mean()) ** (1 / power) - 1)


def _evenness(angles: np.ndarray) -> float:
    """Return the ratio of the least to the most frequent of twelve bins of directions: 1 where all are equal."""
    counts = np.histogram(angles[np.isfinite(angles)], bins=12, range=(-np.pi / 2, np.pi / 2))[0]
    return float(counts.min() / counts.max()) if counts.max() else np.nan


def text(table: pd.DataFrame, title: str) -> str:
    """Return a table as lines of text, numbers to four digits at least, a dash for missing ones."""
    body = table.to_string(float_format=lambda v: number(round(v, 9), digits=4), na_rep="–", justify="right")
    return f"{title}\n{'=' * len(title)}\n{body}\n"
