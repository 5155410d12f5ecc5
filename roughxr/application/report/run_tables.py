"""The tables of a run: its numbers as frames, its error budget, and tables as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from pandas.api.types import is_numeric_dtype

from ...mechanics.studies.assumptions import noise_limit
from ...mechanics.studies.uncertainty_budget import bias_part
from ...mechanics.vocabulary.error_sources import PLACES, UNSEEN, KnownError, read_errors, total_bias, total_error
from ...mechanics.vocabulary.numbers import format_number
from ..figures.uncertainty_bars import error_in_percent
from ..headline import best_estimate
from ..wording import names_in_words, render_sentence, table_of_words
from ..wording.intervals import value_and_interval
from .run_numbers import METHOD_WORDS, Number, run_numbers
from .summary import BUDGET, run_fluid, run_summary

Run = Mapping[str, xr.Dataset]

#: How errors were computed, in words.
_ERRORS = "errors.toml"

#: Least effect of a tip that the scan's pixels resolve: a sharper tip's flanks are steeper than all slopes.
_LEAST_TIP_EFFECT = 1e-4


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


def run_errors(run: Run) -> dict[str, KnownError]:
    """Return the errors of a run's mean pull-off by their sources, those of its best estimate if there is one."""
    errors = read_errors(run[BUDGET])
    if best_estimate(run) is not None:
        errors |= read_errors(run["statistics/extrapolated"])
    return errors


def budget_table(run: Run) -> pd.DataFrame:
    """Return the errors of the mean pull-off in per cent: each error, its standard error, its bias, its source.

    The change of the total is the sum of all known biases.
    """
    errors = run_errors(run)
    total = total_error(errors.values())._replace(pull_off_change=total_bias(errors.values()))
    seen = total_error(error for name, error in errors.items() if name != UNSEEN)
    facts: dict[str, Any] = {**run[BUDGET].attrs, "seen": seen.std, "error_of_total": seen.standard_error / seen.std}
    if UNSEEN in errors:
        facts["finest_shown"] = run["statistics/extrapolated"]["finest_shown"]
    facts |= _added(run, errors)
    rows = {name: [*_in_percent(error), _basis(name, error, facts)] for name, error in errors.items()}
    rows["all of these"] = [*_in_percent(total), render_sentence(_ERRORS, "total", facts)]
    columns = ["error [%]", "change [%]", "how it was computed"]
    return pd.DataFrame.from_dict(rows, orient="index", columns=columns).rename_axis("entry")


def _added(run: Run, errors: Mapping[str, KnownError]) -> dict[str, Any]:
    """Return the preload (nN) and the noise (nm) that are added, and the number of independent places."""
    added: dict[str, Any] = {"independent_places": run_summary(run).get("independent_places")}
    preload = errors["preload"].setting
    if preload:
        added["added_preload"] = float(preload) * run[BUDGET]["pull_off_mean"]
    noise = errors["noise"].setting
    if noise and "scan" in run:
        added["added_noise"] = float(noise) * noise_limit(run["scan"])
    return added


def _basis(name: str, error: KnownError, facts: Mapping[str, Any]) -> str:
    """Return how an error was computed, or why it was not."""
    values = {
        **facts,
        "setting": error.setting.replace("-", "−"),
        "reason": error.reason,
        "number_of_places": error.places,
        "several_places": error.places > 1,
        "places_without": error.tried_places - error.places,
        "bias_part": bias_part(name, facts["law"]),
        "was_tried": error.tried_places > 0,
        "is_scatter": name == PLACES,
        "without_effect": abs(error.pull_off_change) < _LEAST_TIP_EFFECT,
    }
    return render_sentence(_ERRORS, name if np.isfinite(error.std) else "not_computed", values)


def _in_percent(error: KnownError) -> list[str]:
    """Return an error with its standard error and the change of the mean, in per cent, as text."""
    change = error.pull_off_change
    sign = "+" if change > 0 else ""
    return [error_in_percent(error), f"{sign}{format_number(round(100 * change, 2), digits=2)}"]


def text(table: pd.DataFrame, title: str) -> str:
    """Return a table as text, with a dash for missing values."""
    digits = 4 if "paper" in table else 3
    named = table if "paper" in table else table.rename(columns=METHOD_WORDS)
    widths = {name: column.str.len().max() for name, column in named.items() if not is_numeric_dtype(column)}
    left_aligned = {name: f"{{:<{width}}}".format for name, width in widths.items()}  # text is left-aligned
    numbers = {"float_format": lambda v: format_number(round(v, 9), digits=digits), "na_rep": "–", "justify": "right"}
    return f"{title}\n{'=' * len(title)}\n{named.to_string(formatters=left_aligned, **numbers)}\n"
