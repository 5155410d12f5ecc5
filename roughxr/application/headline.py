"""The result in words: mean pull-off force, its uncertainty, what limits it, and the next step."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from ..mechanics.bodies.pair_record import read_pair
from ..mechanics.statistics.means import (
    INTERVAL,
    PRESSED,
    estimated_mean,
    mean_pull_off,
    scalar_values,
    with_units,
)
from ..mechanics.statistics.uncertainty import FEWEST_SAMPLES, not_shown
from ..mechanics.vocabulary import schema
from ..mechanics.vocabulary.adhesion_laws import SHORT_RANGE
from ..mechanics.vocabulary.error_sources import (
    ERROR_SOURCES,
    HALF_WIDTH,
    ONE_SCAN,
    PLACES,
    PRESSING,
    SECOND_SCAN_PIXEL,
    SECOND_SCAN_WIDTH,
    UNSEEN,
    UNSEEN_WORDS,
    total_std,
)
from ..mechanics.vocabulary.numbers import (
    bounds_in_words,
    number,
    percent,
    prefixed,
    quantity,
    significant,
    value_and_interval,
    with_interval,
)
from ..mechanics.vocabulary.text import sentences_on_lines
from .sentences import comparison_sentence, recommendation

_BY_PRESSING = "by how hard the sphere was pressed"


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
        return ds
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
    return mean.assign_attrs(sentence=sentences_on_lines(headline(mean)))


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
    deviations = estimate["relative_std"].fillna(0.0).to_series()
    copied = ("finest_shown", "roughness_factor", "roughness_low", "roughness_high", "narrowed_low", "narrowed_high")
    deviations = deviations.drop(PRESSING, errors="ignore")  # stated as a range of its own
    scan_deviations = deviations[[ERROR_SOURCES[name].is_of_scan for name in deviations.index]]
    pair_deviations = deviations.drop([UNSEEN, PLACES, *scan_deviations.index], errors="ignore")
    out = summary.assign({name: estimate[name] for name in copied}).assign(
        best_estimate=estimate["pull_off_mean"],
        best_low=estimate["pull_off_low"],
        best_high=estimate["pull_off_high"],
        pair_error=HALF_WIDTH * total_std(pair_deviations) if pair_deviations.size else np.nan,
        scan_error=HALF_WIDTH * total_std(scan_deviations),
    )
    attributes = {name: estimate.attrs[name] for name in ("narrowing_source", "unseen_by")}
    return out.assign_attrs(attributes, scan_sources=_largest_sources(scan_deviations))


def _largest_sources(deviations: pd.Series) -> str:
    """Return the names of the largest errors of a group, which make most of its variance, the largest first."""
    variances = (deviations**2).sort_values(ascending=False)
    before = variances.cumsum() - variances
    # part of the variance of a group beyond which errors are not named
    names = [str(name) for name in variances.index[before < 0.9 * variances.sum()]]
    return ", ".join(names[:-1]) + " and " * (len(names) > 1) + "".join(names[-1:])


def best_estimate(run: Mapping[str, xr.Dataset]) -> tuple[float, float, float] | None:
    """Return a run's best estimate and the ends of its interval, nN, or None."""
    return estimated_mean(run.get("statistics/extrapolated"))


def headline(summary: xr.Dataset) -> str:
    """Return an answer or a run's summary in words, for all doors alike."""
    if "pull_off_force" not in summary:
        return str(summary.attrs.get("missing", ""))
    value = scalar_values(summary)
    opening = _scanned_words(summary, value) if np.isnan(value["best_estimate"]) else _real_words(summary, value)
    return " ".join(filter(None, [*opening, *_limits(summary, value), _next_step(summary, value)]))


def _real_words(summary: xr.Dataset, value: Mapping[str, float]) -> list[str]:
    """Return the pull-off of the real surface, and what it is made of."""
    unit, size = prefixed(value["best_estimate"])
    best = _printed_best(value)
    ends = [significant(value[f"best_{end}"] / size) for end in ("low", "high")]
    errors = "without the errors of the pair of bodies"
    if np.isfinite(value["pair_error"]):
        errors = "all known errors, given the law of attraction"  # of which no error is known
    parts = [f"As scanned {_mean_words(summary, value)}", _unseen_words(summary, value)]
    scan_sources = str(summary.attrs.get("scan_sources", "scan and mesh"))
    for name, source in (("pair_error", "the pair of bodies"), ("scan_error", scan_sources)):
        # relative half width of an interval below which its source is not named
        if value[name] > 0.05:
            low, high = (number(np.exp(sign * value[name]), digits=2) for sign in (-1, 1))
            parts.append(f"× {low} … {high} by {source}")
    if np.isfinite(value["pressed_low"]):
        low, high = (number(value[name] / value["pull_off_force"], digits=2) for name in PRESSED)
        parts.append(f"× {low} … {high} {_BY_PRESSING}")
    interval = f"95 % interval {' … '.join(ends)} {unit}, {errors}"
    return [f"Pull-off force of the real surface{_air(summary)}: {best} {unit} ({interval}).", f"{'; '.join(parts)}."]


def _unseen_words(summary: xr.Dataset, value: Mapping[str, float]) -> str:
    """Return the effect of unseen roughness: a factor that multiplies the mean as printed to the best estimate."""
    ends = " … ".join(significant(value[f"roughness_{end}"]) for end in ("low", "high"))
    finer = f"roughness finer than {number(value['finest_shown'], 'nm', 2)}"
    factor = _printed_factor(value)
    source = summary.attrs["unseen_by"]
    if source != ONE_SCAN:
        return f"× {factor} ({ends}) by {finer}, {UNSEEN_WORDS[source]}"
    return f"× {factor} ({ends}, {UNSEEN_WORDS[source]}) by {finer}, which the scan does not show"


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


def _scanned_words(summary: xr.Dataset, value: Mapping[str, float]) -> list[str]:
    """Return the mean as scanned with its errors, and why there is no estimate of the real surface."""
    errors = ""
    others = ""
    if np.isfinite(value["pressed_low"]):
        errors = f"; {bounds_in_words(value['pressed_low'], value['pressed_high'])}, {_BY_PRESSING}"
        others = " other"
    if np.isfinite(value["total_error"]):
        errors += f"; ± {percent(value['total_error'])} with all{others} known errors"
    elif np.isfinite(error := value["mesh_error"]):
        cells = f"overestimated by about {percent(error)} due to the size of cells"
        errors += f"; {cells}" if "rigid" in summary.attrs else f"; ± {percent(error)} numerical error"
    mean = _mean_words(summary, value, "95 % interval").removesuffix(")")
    surface_words = "for the surface as scanned"
    if "measured" in summary.attrs:
        surface_words = "as measured"
    elif schema.is_synthetic(summary):
        surface_words = "for the synthetic surface"
    sentences = [f"Mean pull-off {mean}{errors}) {surface_words}{_air(summary)}.", _limit_words(summary, value)]
    sentences.append(str(summary.attrs.get("not_extrapolated", "")))
    if source := summary.attrs.get("largest_source"):
        label = ERROR_SOURCES[source].label or source
        sentences.append(f"The largest uncertainty is the {label} (± {percent(value['largest_error'])}).")
    return sentences


def _mean_words(summary: xr.Dataset, value: Mapping[str, float], name: str = "") -> str:
    """Return the mean as scanned with its interval and number of places."""
    mean = value["pull_off_force"]
    places = _places_in_words(summary)
    if np.isfinite(value["low"]) and ("limits" in summary.attrs or np.isnan(mean)):
        counted = f"{name}, {places}" if name else places
        return f"{bounds_in_words(value['low'], value['high'])} ({counted})"
    if np.isnan(value["low"]):
        return f"{quantity(mean)} ({places})"
    words = with_interval(mean, value["low"], value["high"], why_wide=", too few values", name=name)
    return f"{words.removesuffix(')')}, {places})"


def _limit_words(summary: xr.Dataset, value: Mapping[str, float]) -> str:
    """Return a sentence on the forces that are limits, and on the mean by a likelihood; empty without limits."""
    if "limits" not in summary.attrs:
        return ""
    limits = f"Known by limits: {summary.attrs['limits']}"
    if np.isnan(value["low"]):
        by_law = f"; the mean is by a likelihood with censoring, of a {summary.attrs['law']} law"
        return f"{limits}{by_law if np.isfinite(value['pull_off_force']) else ''}."
    sentence = f"{limits}; the interval holds wherever they lie."
    if np.isnan(value["pull_off_force"]):
        return sentence
    mean = with_interval(value["pull_off_force"], value["likelihood_low"], value["likelihood_high"])
    return f"{sentence} By a likelihood with censoring, of a {summary.attrs['law']} law: {mean}."


def _air(summary: xr.Dataset) -> str:
    """Return the humidity of the air, empty for a dry pair."""
    return f" at {percent(summary['humidity'])} relative humidity" if "humidity" in summary.coords else ""


def _limits(summary: xr.Dataset, value: Mapping[str, float]) -> list[str]:
    """Return sentences on a known bias above 10 %, and on a mean above that of a smooth flat."""
    sentences = []
    mean = value["pull_off_force"]
    if abs(bias := summary.attrs.get("known_bias", 0.0)) > 0.1:
        sentence = (
            f"The mean as scanned without its known bias, {percent(abs(bias))}, is {quantity(mean * (1 - bias))}."
        )
        sentences.append(sentence)
    if value["smooth_share"] > 1:
        share = percent(value["smooth_share"])
        words = f"The mean as scanned is {share} of the pull-off from a smooth flat, {_excess_words(summary)}."
        sentences.append(words)
    sentences.append(str(summary.attrs.get("law_choice", "")))
    is_solved = np.isnan(value["debris_share"]) and "measured" not in summary.attrs
    has_interval = np.isfinite(value["low"]) and np.isfinite(value["independent_places"])
    if has_interval and is_solved and value["places"] < FEWEST_SAMPLES:
        sentences.append(not_shown(int(value["places"]), value["independent_places"]))
    return sentences


def _excess_words(summary: xr.Dataset) -> str:
    """Return whether these bodies can hold more than JKR's sphere on a smooth flat."""
    if "rigid" in summary.attrs:
        return "possible only for a surface shaped to fit the sphere: use adhesive, or a finer mesh"
    if not {"sphere_radius", "contact_modulus", "work_of_adhesion"} <= set(summary.coords):
        return "possible for stiff bodies, and for soft ones where the surface ripples or fits the sphere"
    pair = read_pair(summary)
    tabor = max(pair.tabor_parameters(pair.sphere_radius))
    parameter = f"Tabor's parameter of the sphere is {number(tabor, digits=2)}"
    if tabor < SHORT_RANGE:
        return f"possible for bodies as stiff as these ({parameter})"
    words = f"which soft bodies ({parameter}) hold where the surface ripples or fits the sphere"
    return words if "by_front" in summary.attrs else f"{words}: compare with a finer mesh"


def _places_in_words(summary: xr.Dataset) -> str:
    """Return the number of places, and whether they are too few for an interval."""
    adhering = int(summary["places"])
    count = int(summary["solved_places"])
    text = f"{adhering} place{'s' * (adhering > 1)}" + f" of {count}" * (adhering < count)
    if summary.get("debris_share", 0.0) > 0:
        on_debris = number(summary["debris_places"]) if summary["debris_places"] > 0 else "none"
        text += f", {on_debris} of them on debris ({percent(summary['debris_share'])} of the area)"
    is_too_few = (
        "independent_places" in summary and np.isnan(summary["low"]) and summary["independent_places"].notnull()
    )
    reason = summary.attrs.get("no_interval", "too few independent ones for an interval")
    return text + f", {reason}" * bool(is_too_few)


def _next_step(summary: xr.Dataset, value: Mapping[str, float]) -> str:
    """Return one sentence on the next step; empty if the errors suggest none, or nothing can be measured again."""
    if schema.is_synthetic(summary):
        return ""
    if advice := summary.attrs.get("advice", ""):
        return f"Next: {advice}."
    low, high, independent = (value[name] for name in ("low", "high", "independent_places"))
    # ratio of the ends of an interval above which the next step is to narrow it
    if np.isfinite(independent) and (np.isnan(low) or high > 4.0 * low) and np.isnan(value["best_estimate"]):
        effect = "are too few for an interval" if np.isnan(low) else "give a wide interval"
        counts = f"{number(value['places'])} places, {number(independent, digits=2)} of them independent,"
        steps = "solve more places, or scan a larger area"
        if "limits" in summary.attrs:
            steps = "measure with less noise or a softer cantilever, or more places"
        elif "measured" in summary.attrs:
            steps = "measure more places, or a larger area"
        return f"Next: {steps}, since {counts} {effect}."
    source = summary.attrs.get("narrowing_source", summary.attrs.get("largest_source", ""))
    remedy = ERROR_SOURCES[source].remedy if source else ""
    if not remedy:
        return ""
    if value["narrowed_low"] > 0 and value["best_low"] > 0:
        narrowed, wide = (np.log(value[f"{name}_high"] / value[f"{name}_low"]) for name in ("narrowed", "best"))
        if narrowed > 0.95 * wide:  # no step narrows it by a twentieth
            return ""
    sentence = f"The interval narrows most with {remedy.format(**_second_scan_words(summary, value['finest_shown']))}"
    if np.isfinite(value["narrowed_low"]):
        unit, size = prefixed(value["best_estimate"])
        ends = " … ".join(significant(value[f"narrowed_{end}"] / size) for end in ("low", "high"))
        sentence += f" (to some {ends} {unit})"
    return f"{sentence}."


def _second_scan_words(summary: xr.Dataset, finest_shown: float) -> dict[str, str]:
    """Return width and pixels of the second scan that is advised, in words."""
    pixel = finest_shown / 2
    radius = summary.coords.get("sphere_radius")
    width = "" if radius is None else f", {number(max(float(radius), SECOND_SCAN_WIDTH * pixel), 'nm', 2)} wide"
    return {"width": width, "pixels": number(SECOND_SCAN_PIXEL, "nm", 2)}
