"""The tables of a run: its numbers as frames, its error budget, and tables as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from pandas.api.types import is_numeric_dtype

from ...mechanics.vocabulary.error_sources import UNSEEN, total_std
from ...mechanics.vocabulary.numbers import format_number, format_percent, value_and_interval, with_error
from ..headline import best_estimate
from ..wording import names_in_words, table_of_words
from .run_numbers import METHOD_WORDS, Number, run_numbers
from .summary import BUDGET, run_fluid

Run = Mapping[str, xr.Dataset]


def tables(run: Run) -> dict[str, pd.DataFrame]:
    """Return the tables for which a run has the groups, by their titles."""
    made = {"Error budget of the mean pull-off": budget_table(run)} if BUDGET in run else {}
    datum = run.get("solutions/direct", xr.Dataset()).attrs.get("datum", "highest_peak")
    values = {"fluid": run_fluid(run), "origin": names_in_words("origin")[datum]}
    rows = run_numbers(run)
    for part, title, head in table_of_words("tables.csv"):
        if rows.get(part):  # one place has no statistics
            made[title.format(**values)] = _frame(rows[part]).rename_axis(head.format(**values))
    return made


def _frame(rows: Sequence[Number]) -> pd.DataFrame:
    """Return rows as a frame: a column for each method, for each number of a place, or for value and interval."""
    columns: dict[str, dict[str, Any]] = {}
    for row in rows:
        cells: dict[tuple[str, str], Any] = {
            (row.source, row.label) if row.source else (row.label, row.place): row.value
        }
        if row.note:
            index = f"{row.words}, {row.place}"
            estimate, interval = value_and_interval(row.value, row.low, row.high)
            cells = {("estimate", index): estimate, ("95 % interval", index): interval}
            cells["independent places", index] = row.note
        for (column, index), cell in cells.items():
            columns.setdefault(column, {})[index] = cell
    return pd.DataFrame(columns)


def budget_table(run: Run) -> pd.DataFrame:
    """Return the error budget in per cent of the mean pull-off: each error, its standard error, its bias, its source.

    The change of the total is the sum of all known biases.
    """
    budget = full_budget(run)
    values = (budget[name].values for name in ("relative_std", "standard_error", "pull_off_change", "how"))
    rows = {str(name): _budget_row(*row) for name, *row in zip(budget["entry"].values, *values)}
    shift = float(budget["pull_off_corrected"] / budget["pull_off_mean"]) - 1
    how = f"root of the sum of squares. {_accuracy_of_total(run)}"
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
    finest = format_number(float(estimate["finest_shown"]), "nm", 2)
    how = f"standard deviation of the logarithm of the factor by roughness finer than {finest}"
    variables = ["relative_std", "standard_error", "pull_off_change", "known_bias", "how"]
    variables += ["pull_off_corrected", "pull_off_mean"]
    row = {"relative_std": unseen, "known_bias": False, "how": how}
    out = budget[variables].reindex(entry=[*budget["entry"].values, UNSEEN], fill_value=row)
    return out.assign(total_std=total_std(out["relative_std"]), total_standard_error=np.nan)


def _accuracy_of_total(run: Run) -> str:
    """Return how well the total of a run's budget is known, without the roughness that the scan does not show."""
    budget = run[BUDGET]
    total, deviation = (float(budget[name]) for name in ("total_std", "total_standard_error"))
    accuracy = "has no error of its own, since places are too few"
    if deviation >= 0:
        accuracy = f"is known to ± {format_percent(deviation / total)}"
    if best_estimate(run) is None:
        places = f"{budget.attrs['changed_places']} of {budget.attrs['solved_places']} places"
        return f"The total {accuracy}. Each change is solved at {places}."
    finest = format_number(float(run["statistics/extrapolated"]["finest_shown"]), "nm", 2)
    seen = f"Without roughness finer than {finest} the total is {format_percent(total)}"
    return f"{seen}, which {accuracy}; the error of the entry of that roughness is not known."


def _budget_row(error: float, deviation: float, change: float, how: str) -> list[str]:
    """Return an error with its standard error and the change of the mean, in per cent, as text."""
    error = round(100 * error, 2)
    deviation = round(100 * deviation, 2)
    error_words = " ± ".join(with_error(error, deviation)) if deviation > 0 else format_number(error, digits=2)
    sign = "+" if change > 0 else ""
    return [error_words, f"{sign}{format_number(round(100 * change, 2), digits=2)}", how]


def text(table: pd.DataFrame, title: str) -> str:
    """Return a table as text, with a dash for missing values."""
    digits = 4 if "paper" in table else 3
    named = table if "paper" in table else table.rename(columns=METHOD_WORDS)
    widths = {name: column.str.len().max() for name, column in named.items() if not is_numeric_dtype(column)}
    left_aligned = {name: f"{{:<{width}}}".format for name, width in widths.items()}  # text is left-aligned
    numbers = {"float_format": lambda v: format_number(round(v, 9), digits=digits), "na_rep": "–", "justify": "right"}
    return f"{title}\n{'=' * len(title)}\n{named.to_string(formatters=left_aligned, **numbers)}\n"
