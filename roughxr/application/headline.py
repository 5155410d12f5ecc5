"""The result in words: mean pull-off force, its uncertainty, what limits it, and the next step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from ..mechanics.bodies.pair_record import read_pair
from ..mechanics.contact.estimates import automatic_law
from ..mechanics.statistics.means import (
    INTERVAL,
    PRESSED,
    estimated_mean,
    mean_pull_off,
    scalar_values,
    with_units,
)
from ..mechanics.statistics.sampling import LIMITS
from ..mechanics.statistics.uncertainty import FEWEST_SAMPLES, missed_share
from ..mechanics.vocabulary import schema
from ..mechanics.vocabulary.adhesion_laws import ADHESION_LAWS, SHORT_RANGE
from ..mechanics.vocabulary.error_sources import (
    ERROR_SOURCES,
    HALF_WIDTH,
    ONE_SCAN,
    PLACES,
    PRESSING,
    SECOND_SCAN_PIXEL,
    SECOND_SCAN_WIDTH,
    UNSEEN,
    KnownError,
    read_errors,
    total_error,
)
from ..mechanics.vocabulary.numbers import format_number, prefixed, significant
from .sentences import comparison_sentence, fit_sentence, recommendation
from .wording import names_in_words, render_sentences
from .wording.intervals import bounds_in_words, is_too_wide, value_and_interval, with_interval


def answer(ds: xr.Dataset) -> xr.Dataset:
    """Return the mean pull-off force with its 95 % interval, and the sentences that state it.

    Parameters
    ----------
    ds : Dataset
        A solution, for example of `adhesive`, `rigid`, `superpose` or `extrapolated`, or its `pull_off`, or the group
        ``statistics/summary`` of a run. Of several preloads the first; of several radii or humidities
        select one, or take `bootstrap`. Results of `compare`, `fit_pair` and `regime` get a sentence alone.

    Returns
    -------
    Dataset
        Scalars: ``pull_off_force`` (nN), the mean over the places that adhere, ``low`` and ``high``,
        the ends of its interval, ``places``, ``solved_places``, ``independent_places``, ``mesh_error`` and
        ``smooth_share``; NaN if unknown, as the ends are for too few independent places. If some measured forces are
        known by limits, ``low`` … ``high`` holds wherever they lie below them, and ``likelihood_low`` …
        ``likelihood_high`` is the interval by a likelihood with censoring, as in `bootstrap`. If pull-offs depend by
        more than half on how hard the sphere was pressed, ``pressed_low`` … ``pressed_high`` are the means of the ends
        of their ranges. The attribute
        ``sentence`` states the result, its errors and the next step, a line each.

    Raises
    ------
    ValueError
        If ``ds`` contains no force, or no place adheres.

    Examples
    --------
    >>> import xarray as xr
    >>> import roughxr
    >>> pull = xr.Dataset({"pull_off_force": ("subregion", [388.0, 575.0, 817.0])})
    >>> print(roughxr.answer(roughxr.schema.label(pull)).sentence)
    Mean pull-off 590 nN (95 % interval 230 … 1610 nN, 3 places) for the surface as scanned.
    Debris on less than 63 % of the surface may be missed by 3 places; the interval excludes it.
    Next: solve more places, or scan a larger area, since 3 places, 3 of them independent, give a wide interval.
    """
    ds = schema.entered_dataset(ds, "result")
    if "quantile_distance" in ds:  # of `fit_pair`
        return ds.assign_attrs(sentence=fit_sentence(ds))
    if "distribution_distance" in ds:  # of `compare`
        return ds.assign_attrs(sentence=comparison_sentence(ds))
    if "recommended" in ds.coords:  # of `regime`
        return ds.assign_attrs(sentence=recommendation(ds))
    if "pull_off_mean" in ds:  # of `extrapolated`
        names = {"pull_off_force", "pressed_pull_off_force"} & set(ds.data_vars)
        as_scanned = ds.assign({name: ds[name] / ds["roughness_factor"] for name in names})
        mean = with_units(with_best_estimate(mean_pull_off(as_scanned), ds))
    else:
        mean = ds if "solved_places" in ds else _without_doubtful_interval(mean_pull_off(ds))  # a run's has errors
    return mean.assign_attrs(sentence="\n".join(answer_lines(mean)))


def _without_doubtful_interval(mean: xr.Dataset) -> xr.Dataset:
    """Return a mean without the interval of its places, if it exceeds a smooth flat's and its error is not known."""
    is_doubtful = float(mean["smooth_share"]) > 1 and np.isnan(mean["mesh_error"]) and "measured" not in mean.attrs
    if not is_doubtful or np.isnan(mean["low"]):
        return mean
    ends = {name: mean[name] * np.nan for name in INTERVAL if name != "independent_places"}
    attributes = {
        "no_interval": "no interval: more than from a smooth flat, and the error of cells or sum is not known",
        "advice": "take adhesive with mesh='auto', which states its error",
    }
    return with_units(mean.assign(ends)).assign_attrs(attributes)


def with_best_estimate(summary: xr.Dataset, estimate: xr.Dataset) -> xr.Dataset:
    """Return an answer with the best estimate of the real surface, its parts, and the step that narrows it most."""
    errors = read_errors(estimate)
    errors.pop(PRESSING, None)  # stated as a range of its own
    scan_errors = {name: error for name, error in errors.items() if ERROR_SOURCES[name].is_of_scan}
    pair_errors = [error for name, error in errors.items() if name not in (UNSEEN, PLACES, *scan_errors)]
    copied = ("finest_shown", "roughness_factor", "roughness_low", "roughness_high", "narrowed_low", "narrowed_high")
    out = summary.assign({name: estimate[name] for name in copied}).assign(
        best_estimate=estimate["pull_off_mean"],
        best_low=estimate["pull_off_low"],
        best_high=estimate["pull_off_high"],
        pair_error=HALF_WIDTH * total_error(pair_errors).std,
        scan_error=HALF_WIDTH * total_error(scan_errors.values()).std,
    )
    attributes = {name: estimate.attrs[name] for name in ("narrowing_source", "unseen_by")}
    return out.assign_attrs(attributes, scan_sources=_largest_sources(scan_errors))


def _largest_sources(errors: Mapping[str, KnownError]) -> str:
    """Return the names of the largest errors of a group, which make most of its variance, the largest first."""
    variances = pd.Series({name: error.std**2 for name, error in errors.items()}).sort_values(ascending=False)
    before = variances.cumsum() - variances
    # part of the variance of a group beyond which errors are not named
    names = [str(name) for name in variances.index[before < 0.9 * variances.sum()]]
    return ", ".join(names[:-1]) + " and " * (len(names) > 1) + "".join(names[-1:])


def best_estimate(run: Mapping[str, xr.Dataset]) -> tuple[float, float, float] | None:
    """Return a run's best estimate and the ends of its interval, nN, or None."""
    return estimated_mean(run.get("statistics/extrapolated"))


#: The sentences of an answer by the real surface, and of one as scanned or measured; and those that end both.
_REAL = ("real", "parts")
_SCANNED = ("mean_as_scanned", "known_by_limits", "by_likelihood", "why_not_real", "largest")
_ENDING = ("bias", "excess", "choice_of_law", "missed_debris", "next_step")

#: Relative half width of an interval below which its source is not named.
_NAMED = 0.05

#: Known bias from which the mean without it is stated.
_LARGE_BIAS = 0.1

#: Ratio of the ends of an interval above which the next step is to narrow it.
_WIDE = 4.0


def answer_lines(summary: xr.Dataset) -> list[str]:
    """Return the sentences of an answer or a run's summary."""
    if "pull_off_force" not in summary:
        return [summary.attrs["missing"]] if "missing" in summary.attrs else []
    values = scalar_values(summary)
    is_real = np.isfinite(values["best_estimate"])
    record = {"scan_sources": "scan and mesh", **summary.attrs, **values, **_mean(summary, values)}
    record |= _places(summary, values) | _limits(summary, values) | _next_step(summary, values)
    if is_real:
        record |= _real(summary, values)
    return render_sentences("answer.toml", (_REAL if is_real else _SCANNED) + _ENDING, record)


def _mean(summary: xr.Dataset, values: Mapping[str, float]) -> dict[str, Any]:
    """Return the mean with its interval as text, and what it is known by."""
    mean, low, high = (values[name] for name in ("pull_off_force", "low", "high"))
    is_limited = not set(LIMITS).isdisjoint(summary.attrs)
    record: dict[str, Any] = {
        "synthetic": schema.is_synthetic(summary),
        "humidity": summary.coords.get("humidity"),
        "bounded": np.isfinite(high - low),
        "is_limited": is_limited,
    }
    if np.isfinite(low) and (is_limited or np.isnan(mean)):
        record["bounds"] = bounds_in_words(low, high)
    elif np.isfinite(low):
        record["mean"], ends = value_and_interval(mean, low, high)
        record["ends"] = ends + ", too few values" * is_too_wide(low, high)
    if is_limited and np.isfinite(mean):
        record["likelihood"] = with_interval(mean, values["likelihood_low"], values["likelihood_high"])
    if np.isfinite(values["pressed_low"]):
        record["pressed_bounds"] = bounds_in_words(values["pressed_low"], values["pressed_high"])
    if source := summary.attrs.get("largest_source"):
        record["largest_name"] = names_in_words("error").get(source, source)
    return record


def _real(summary: xr.Dataset, values: Mapping[str, float]) -> dict[str, Any]:
    """Return the pull-off of the real surface in its unit, and what it is made of."""
    unit, size = prefixed(values["best_estimate"])
    record: dict[str, Any] = {"unit": unit, "best": _printed_best(values), "factor": _printed_factor(values)}
    for name in ("best", "narrowed"):
        record |= {f"{name}_from": values[f"{name}_low"] / size, f"{name}_to": values[f"{name}_high"] / size}
    for name in ("pair", "scan"):
        error = values[f"{name}_error"]
        if error > _NAMED:
            record |= {f"{name}_from": np.exp(-error), f"{name}_to": np.exp(error)}
    record |= {f"pressed_{end}": values[name] / values["pull_off_force"] for end, name in zip(("from", "to"), PRESSED)}
    source = summary.attrs["unseen_by"]
    return record | {"one_scan": source == ONE_SCAN, "unseen_words": names_in_words("unseen")[source]}


def _printed_best(value: Mapping[str, float]) -> str:
    """Return the best estimate to two digits, in its prefixed unit, to three where two are off by more than 2 %."""
    _, size = prefixed(value["best_estimate"])
    best = value["best_estimate"] / size
    text = significant(best)
    return text if abs(float(text) / best - 1) < 0.02 else significant(best, 3)


def _printed_factor(value: Mapping[str, float]) -> str:
    """Return the factor of unseen roughness with as many digits as the printed numbers need to multiply within 3 %."""
    _, size = prefixed(value["pull_off_force"])
    scanned, _ = value_and_interval(value["pull_off_force"], value["low"], value["high"])
    _, best_size = prefixed(value["best_estimate"])
    best = float(_printed_best(value)) * best_size
    texts = [significant(value["roughness_factor"], digits) for digits in (2, 3, 4)]
    printed = size * float(scanned.partition(" ")[0])
    return next((text for text in texts if abs(printed * float(text) / best - 1) < 0.03), texts[0])


def _places(summary: xr.Dataset, values: Mapping[str, float]) -> dict[str, Any]:
    """Return the number of places, of those on debris, and whether they are too few for an interval."""
    record: dict[str, Any] = {"several_places": values["places"] > 1}
    if values["places"] < values["solved_places"]:
        record["more_solved_places"] = values["solved_places"]
    if values["debris_share"] > 0:
        record |= {"some_debris": values["debris_share"], "some_on_debris": values["debris_places"] or None}
    record["is_too_few"] = np.isnan(values["low"]) and np.isfinite(values["independent_places"])
    is_solved = np.isnan(values["debris_share"]) and "measured" not in summary.attrs
    has_interval = np.isfinite(values["low"]) and np.isfinite(values["independent_places"])
    if has_interval and is_solved and values["places"] < FEWEST_SAMPLES:
        record["missed_share"] = missed_share(values["independent_places"])
    return record


def _limits(summary: xr.Dataset, values: Mapping[str, float]) -> dict[str, Any]:
    """Return a large known bias, and a mean above that of a smooth flat with Tabor's parameter of these bodies."""
    record: dict[str, Any] = {"on_cells": "by_front" not in summary.attrs, "short_range": SHORT_RANGE}
    if "switching_tabor" in summary.attrs:
        law = automatic_law(summary.attrs["switching_tabor"])
        record |= {"switching_law": law, "rival_law": ADHESION_LAWS[law].rival}
    bias = summary.attrs.get("known_bias", 0.0)
    if abs(bias) > _LARGE_BIAS:
        record |= {"large_bias": abs(bias), "unbiased": values["pull_off_force"] * (1 - bias)}
    if values["smooth_share"] > 1:
        record["share_above_one"] = values["smooth_share"]
        if {"sphere_radius", "contact_modulus", "work_of_adhesion"} <= set(summary.coords):
            pair = read_pair(summary)
            tabor = max(pair.tabor_parameters(pair.sphere_radius))
            record["small_tabor" if tabor < SHORT_RANGE else "tabor"] = tabor
    return record


def _next_step(summary: xr.Dataset, values: Mapping[str, float]) -> dict[str, Any]:
    """Return whether the interval is wide, and what narrows it most."""
    low, high, independent = (values[name] for name in ("low", "high", "independent_places"))
    is_wide = np.isfinite(independent) and (np.isnan(low) or high > _WIDE * low) and np.isnan(values["best_estimate"])
    if values["narrowed_low"] > 0 and values["best_low"] > 0:
        narrowed, wide = (np.log(values[f"{name}_high"] / values[f"{name}_low"]) for name in ("narrowed", "best"))
        if narrowed > 0.95 * wide:  # no step narrows it by a twentieth
            return {"is_wide": is_wide}
    source = summary.attrs.get("narrowing_source", summary.attrs.get("largest_source", ""))
    remedy = names_in_words("remedy").get(source, "")
    scan_words = _second_scan_words(summary, values["finest_shown"])
    return {"is_wide": is_wide, "remedy": remedy.format(**scan_words)}


def _second_scan_words(summary: xr.Dataset, finest_shown: float) -> dict[str, str]:
    """Return width and pixels of the second scan that is advised, in words."""
    pixel = finest_shown / 2
    radius = summary.coords.get("sphere_radius")
    width = "" if radius is None else f", {format_number(max(float(radius), SECOND_SCAN_WIDTH * pixel), 'nm', 2)} wide"
    return {"width": width, "pixels": format_number(SECOND_SCAN_PIXEL, "nm", 2)}
