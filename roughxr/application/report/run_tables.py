"""The tables of a run: scan, contact by method, main numbers with intervals, error budget and formulas."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd
import xarray as xr
from pandas.api.types import is_numeric_dtype

from ...mechanics import statistics
from ...mechanics.scans.regions import sides
from ...mechanics.statistics import smooth_pull_off
from ...mechanics.statistics.sampling import at_first_preload, by_share, has_debris_flags, standard_deviation
from ...mechanics.studies.uncertainty_budget import accuracy_words
from ...mechanics.vocabulary.adhesion_laws import HERTZ
from ...mechanics.vocabulary.error_sources import UNSEEN, total_std
from ...mechanics.vocabulary.numbers import number, percent, prefixed, value_and_interval, with_error
from ..figures.values import FORMULAS
from ..headline import best_estimate
from .detachment import DETACHMENT, detachment_table
from .summary import BUDGET, run_fluid

Run = Mapping[str, xr.Dataset]

#: Methods of the pull-off, by the names of their groups, in words.
METHOD_WORDS = {
    "adhesive": "simulation as scanned",
    "extrapolated": "real surface, best estimate",
    "rigid": "rigid bodies",
    "published": "superposed, as published",
    "self_similar": "superposed, self-similar",
    "energy": "superposed asperities",
    "direct": "simulation without adhesion",
    HERTZ: "superposed, without adhesion",
}


#: The main numbers of pull-off: words and statistic.
_MAIN = {"mean": "mean", "q5": "5 % of places below", "q50": "median", "q95": "95 % of places below"}


def tables(run: Run) -> dict[str, pd.DataFrame]:
    """Return the tables for which a run has the groups, by their titles."""
    makers: tuple[tuple[str, Callable[[Run], pd.DataFrame], set[str]], ...] = (
        ("Error budget of the mean pull-off", budget_table, {BUDGET}),
        ("Pull-off force", main_numbers, {"statistics/adhesive"}),
        (f"Detachment in a flow of {run_fluid(run)}", detachment_table, set(DETACHMENT)),
        ("Pull-off force by method", contact_table, {"statistics/rigid"}),
        ("Force without adhesion", force_table, {"solutions/direct"}),
        ("Usual formulas", formula_table, {"statistics/formulas"}),
        ("Scan and asperities", scan_table, {"scan", "asperities", "reconstruction"}),
    )
    made = {title: make(run) for title, make, needs in makers if needs <= set(run)}
    return {title: table for title, table in made.items() if len(table)}  # one place has no statistics


def contact_table(run: Run) -> pd.DataFrame:
    """Return the pull-off by method."""
    methods = [method for method in METHOD_WORDS if "pull_off_delta" in run.get(f"statistics/{method}", ())]
    forces = [run[f"statistics/{method}"]["pull_off_force"] for method in methods]
    unit = prefixed(max((float(pull_off.mean()) for pull_off in forces if pull_off.notnull().any()), default=0.0))
    return pd.DataFrame({method: _pull_off_rows(run, method, *unit) for method in methods}).rename_axis("quantity")


def _pull_off_rows(run: Run, method: str, unit: str, size: float) -> dict[str, float]:
    pull_off = run[f"statistics/{method}"]
    force = pull_off["pull_off_force"] / size
    delta = pull_off["pull_off_delta"]
    mean = float(by_share(force).mean())
    smooth = smooth_pull_off(run[f"solutions/{method}"]) / size
    origin = _origin_words(pull_off)
    return {
        f"pull-off, smooth sphere [{unit}]": smooth,
        f"pull-off, mean [{unit}]": mean,
        f"pull-off, std [{unit}]": _spread(force),
        f"pull-off, largest [{unit}]": float(force.max()),
        "pull-off, rough / smooth": mean / smooth if smooth > 0 else np.nan,
        f"displacement at pull-off {origin}, mean [nm]": float(by_share(delta).mean()),
        f"displacement at pull-off {origin}, std [nm]": _spread(delta),
        "places that adhere": float(force.notnull().sum()),
    }


def _origin_words(ds: xr.Dataset) -> str:
    """Return the origin of a result's displacements in words."""
    return "from first touch" if ds.attrs.get("datum") == "first_contact" else "from the highest point"


def _spread(values: xr.DataArray) -> float:
    """Return the standard deviation (n − 1) of the finite values, NaN for fewer than two."""
    if int(values.notnull().sum()) < 2:
        return np.nan
    return float(standard_deviation(values))


def force_table(run: Run) -> pd.DataFrame:
    """Return the force of the direct simulation at the middle and the last displacement."""
    force = run["solutions/direct"]["force"]
    origin = _origin_words(run["solutions/direct"])
    deltas = force["delta"].values
    unit, size = prefixed(float(force.isel(delta=-1).mean()))
    rows = {}
    for delta in sorted({float(deltas[deltas.size // 2]), float(deltas[-1])}):
        at = force.sel(delta=delta, method="nearest")
        rows[number(delta, "nm")] = [float(at.mean()) / size, _spread(at) / size, float(at.max()) / size]
        if "solutions/smooth" in run:
            smooth = run["solutions/smooth"]["force"].sel(delta=delta, method="nearest")
            rows[number(delta, "nm")].append(float(at.mean() / smooth.item() if smooth.item() else np.nan))
    columns = [f"mean [{unit}]", f"std [{unit}]", f"largest [{unit}]", "rough / smooth"]
    table = pd.DataFrame.from_dict(rows, orient="index")
    return table.set_axis(columns[: table.shape[1]], axis="columns").rename_axis(f"displacement {origin}")


def scan_table(run: Run) -> pd.DataFrame:
    """Return the main numbers of scan and asperities."""
    height = run["scan"]["height"]
    catalogue = run["asperities"]
    ratio = run["asperities"]["axis_ratio"]
    along_x, along_y = sides(run["scan"])
    rows = {
        "size along x [µm]": 1e-3 * along_x,
        "size along y [µm]": 1e-3 * along_y,
        "height, least [nm]": float(height.min()),
        "height, greatest [nm]": float(height.max()),
        "height, mean [nm]": round(float(height.mean()), 6),
        "height, std [nm]": float(height.std()),
        "asperities": float(catalogue.sizes["asperity"]),
        "peak height, median [nm]": float(catalogue["height"].median()),
        "axis ratio b/a, mean": float(ratio.mean()),
        "axis ratio b/a, std": float(ratio.std()),
        "asperities with a saddle as their fit [%]": 100 * float(catalogue["saddle"].mean()),
    }
    return pd.DataFrame({"scan": rows}).rename_axis("quantity")


def formula_table(run: Run) -> pd.DataFrame:
    """Return the pull-off by the usual formulas, and its ratio to the sum over the scan."""
    force = run["statistics/formulas"]["pull_off_force"]
    unit, size = prefixed(float(force.sel(formula="sum")))
    columns = {f"pull-off [{unit}]": force / size, "over rigid bodies": force / force.sel(formula="sum", drop=True)}
    if "statistics/adhesive" in run:
        columns["over simulation with adhesion"] = force / float(run["statistics/adhesive"]["pull_off_force"].median())
    table = pd.DataFrame({name: column.values for name, column in columns.items()})
    table.index = pd.Index([FORMULAS[name] for name in force["formula"].values], name="formula")
    return table


def main_numbers(run: Run) -> pd.DataFrame:
    """Return the main numbers of the pull-off with their 95 % intervals, for all places and without debris, as text."""
    pull_off = prediction(run)[["pull_off_force"]]
    flags = debris_flags(run)
    rows = {"all places": pull_off}
    if flags is not None and 0 < int(flags.sum()) < flags.size - 1 and flags.size == pull_off.sizes["subregion"]:
        rows["without debris"] = pull_off.isel(subregion=np.flatnonzero(~flags.values)).drop_vars("debris_share")
    table = {}
    for places, samples in rows.items():
        adhering = int(samples["pull_off_force"].notnull().sum())
        if adhering < 2:
            continue
        # smallest number of places from which the 5 % and 95 % quantiles are given
        chosen = [name for name in _MAIN if adhering >= 20 or name in ("mean", "q50")]
        ends = statistics.bootstrap(samples, "pull_off_force", statistics=chosen, within=pull_off)
        for name in chosen:
            at = ends.sel(statistic=name)
            interval = value_and_interval(float(at["estimate"]), float(at["low"]), float(at["high"]))
            count = number(at["independent_places"], digits=2)
            table[f"{_MAIN[name]}, {places}"] = [*interval, count]
    columns = ["estimate", "95 % interval", "independent places"]
    return pd.DataFrame.from_dict(table, orient="index", columns=columns).rename_axis("quantity")


def debris_flags(run: Run) -> xr.DataArray | None:
    """Return whether each solved place is on debris, or None if the run cannot show it."""
    solved = (run[name] for name in ("solutions/adhesive", "solutions/direct") if name in run)
    places = next(filter(has_debris_flags, solved), None)
    return None if places is None else places["on_debris"].astype(bool)


def budget_table(run: Run) -> pd.DataFrame:
    """Return the error budget in per cent of the mean pull-off: each error, its standard error, its bias, its source.

    The change of the total is the sum of all known biases.
    """
    budget = full_budget(run)
    values = (budget[name].values for name in ("relative_std", "standard_error", "pull_off_change", "how"))
    rows = {str(name): _budget_row(*row) for name, *row in zip(budget["entry"].values, *values)}
    shift = float(budget["pull_off_corrected"] / budget["pull_off_mean"]) - 1
    how = f"root of the sum of squares. {budget.attrs.get('decided', '')}".strip()
    rows["all of these"] = _budget_row(float(budget["total_std"]), float(budget["total_standard_error"]), shift, how)
    columns = ["error [%]", "change [%]", "how it was computed"]
    return pd.DataFrame.from_dict(rows, orient="index", columns=columns).rename_axis("entry")


def full_budget(run: Run) -> xr.Dataset:
    """Return the error budget of a run with an entry for roughness finer than the scan, if it is estimated."""
    budget = run[BUDGET]
    if best_estimate(run) is None:
        return budget
    estimate = run["statistics/extrapolated"]
    unseen = float(estimate["relative_std"].sel(entry=UNSEEN))
    finest = number(float(estimate["finest_shown"]), "nm", 2)
    row = {
        "relative_std": unseen,
        "standard_error": np.nan,
        "pull_off_change": np.nan,
        "known_bias": False,
        "how": f"standard deviation of the logarithm of the factor by roughness finer than {finest}",
    }
    entries = budget[list(row)]
    added = xr.Dataset({name: ("entry", [value]) for name, value in row.items()}, {"entry": [UNSEEN]})
    out = xr.concat([entries.drop_vars(set(entries.coords) - {"entry"}), added], "entry")
    out = out.assign({name: budget[name] for name in ("pull_off_corrected", "pull_off_mean")})
    seen = f"Without roughness finer than {finest} the total is {percent(budget['total_std'])}"
    accuracy = accuracy_words(float(budget["total_std"]), float(budget["total_standard_error"]))
    decided = f"{seen}, which {accuracy}; the error of the entry of that roughness is not known."
    return out.assign(total_std=total_std(out["relative_std"]), total_standard_error=np.nan).assign_attrs(
        budget.attrs, decided=decided
    )


def _budget_row(error: float, deviation: float, change: float, how: str) -> list[str]:
    """Return an error with its standard error and the change of the mean, in per cent, as text."""
    error = round(100 * error, 2)
    deviation = round(100 * deviation, 2)
    error_words = " ± ".join(with_error(error, deviation)) if deviation > 0 else number(error, digits=2)
    sign = "+" if change > 0 else ""
    return [error_words, f"{sign}{number(round(100 * change, 2), digits=2)}", how]


def prediction(run: Run) -> xr.Dataset:
    """Return the pull-off by the simulation, else by superposed asperities."""
    return at_first_preload(run["statistics/adhesive" if "statistics/adhesive" in run else "statistics/energy"])


def text(table: pd.DataFrame, title: str) -> str:
    """Return a table as text, with a dash for missing values."""
    digits = 4 if "paper" in table else 3
    named = table if "paper" in table else table.rename(columns=METHOD_WORDS)
    widths = {name: column.str.len().max() for name, column in named.items() if not is_numeric_dtype(column)}
    left_aligned = {name: f"{{:<{width}}}".format for name, width in widths.items()}  # text is left-aligned
    numbers = {"float_format": lambda v: number(round(v, 9), digits=digits), "na_rep": "–", "justify": "right"}
    return f"{title}\n{'=' * len(title)}\n{named.to_string(formatters=left_aligned, **numbers)}\n"
