"""Results in words: the values of their sentences, which stand in the folder of wording."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..mechanics.bodies.liquid import menisci_of
from ..mechanics.statistics.censoring import RELATIVE_STD
from ..mechanics.statistics.means import estimated_mean
from ..mechanics.studies.extrapolation import TESTED
from ..mechanics.vocabulary.adhesion_laws import ADHESION_LAWS, SHORT_RANGE
from ..mechanics.vocabulary.error_sources import ERROR_SOURCES, MEASURED, ONE_SCAN, PLACES, UNSEEN
from ..mechanics.vocabulary.numbers import format_number, format_percent, format_quantity
from .wording import names_in_words, render_sentence, render_sentences
from .wording.intervals import is_too_wide, value_and_interval, with_interval

#: Probability below which samples of one distribution differ as much.
_UNLIKELY = 0.05

#: Relative difference of two scatters that counts as none: errors of single predicted pull-offs change theirs as much.
_EQUAL_SCATTER = 0.1

#: Factor of scatters in both directions between which an interval must decide.
_DECIDED_FACTOR = 2.0

#: Range of measured over predicted spread that the surface explains.
_EXPLAINED_SPREAD = 0.7, 1.4

#: Largest exponent of the contact modulus for a fit that hardly depends on it.
_WEAK_POWER = 0.1

#: Exponent of the contact modulus, of either sign, that is printed as zero without a sign.
_ZERO_POWER = 5e-3

#: Kelvin's radius, nm, below which the liquid is a few molecules thick (water's is 0.28 nm across).
_FEW_MOLECULES = 0.75


def comparison_sentence(compared: xr.Dataset) -> str:
    """Return the ratio of means, whether the places explain the scatter, and whether both agree, a line each."""
    values = _scatter_values(compared)
    conclusion = ["distributions"]
    if "mean" in compared["statistic"]:
        means = compared.sel(statistic="mean")
        ratio, low, high = (float(means[f"ratio{end}"]) for end in ("", "_low", "_high"))
        values["ratio_of_means"] = with_interval(ratio, low, high, "")
        best = estimated_mean(compared)
        if best is not None:
            values |= _agreement_values(means, *best)
            conclusion = ["estimate", "agreement"]
    p_value = float(compared["distribution_p_value"])
    values |= {"distance": compared["distribution_distance"], "p_value": p_value, "differ": p_value < _UNLIKELY}
    return "\n".join(render_sentences("comparison.toml", ["ratio", "scatter", *conclusion], values))


def _scatter_values(compared: xr.Dataset) -> dict[str, Any]:
    """Return the relative scatters of predicted and measured forces, and what their ratio decides."""
    predicted, measured = (float(compared[f"{name}_{RELATIVE_STD}"]) for name in ("predicted", "measured"))
    ratio, low, high = (float(compared[f"{RELATIVE_STD}_ratio{end}"]) for end in ("", "_low", "_high"))
    scatters_less = high < 1 - _EQUAL_SCATTER
    scatters_more = low > 1 + _EQUAL_SCATTER
    is_wide = high > _DECIDED_FACTOR**2 * low and not (scatters_less or scatters_more)
    ratio_text, ends = value_and_interval(ratio, low, high, "")
    return {
        "predicted_scatter": format_percent(predicted),
        "measured_scatter": format_percent(measured),
        "is_one_value": measured == 0,
        "is_undecided": is_wide or not np.isfinite([ratio, low, high]).all(),
        "scatters_less": scatters_less,
        "scatters_more": scatters_more,
        "scatter_ratio": ratio_text,
        "scatter_ends": ends,
    }


def _agreement_values(means: xr.Dataset, best: float, low: float, high: float) -> dict[str, Any]:
    """Return a best estimate (nN) beside the predicted mean, and whether it agrees with the measured one."""
    measured_low, measured_high = float(means["measured_low"]), float(means["measured_high"])
    force_std = float(means.attrs.get("force_std", 0.0))
    return {
        "best_estimate": with_interval(best, low, high),
        "factor": best / float(means["predicted"]),
        "no_interval": not np.isfinite([measured_low, measured_high]).all(),
        "is_apart": not (measured_low <= high and measured_high >= low),
        "is_wide": is_too_wide(low, high),
        "low": format_quantity(low, digits=2),
        "high": format_quantity(high, digits=2),
        "force_std": force_std if force_std > 0 else None,
    }


def recommendation(regime: xr.Dataset) -> str:
    """Return the model that `regime` recommends, and the liquid of the pair."""
    model = regime["recommended"].item()
    law = regime.attrs["law"]
    values = {
        "rigid": model == "rigid",
        "superpose": model == "superpose",
        "law": law,
        "has_range": ADHESION_LAWS[law].has_range,
        "sphere_maugis": "sphere_maugis" in regime,
        "is_short_range": bool(regime["asperity_tabor"] >= SHORT_RANGE),
        "yields": bool(regime.get("yields")),
        "asperity_tabor": format_number(regime["asperity_tabor"]),
        "share_beyond_contact": regime["share_beyond_contact"],
        "peak_pressure": regime["peak_pressure"],
        **_liquid_values(regime),
    }
    return " ".join(render_sentences("regime.toml", ["recommended", "yielding", "liquid"], values))


def liquid_words(ds: xr.Dataset) -> str:
    """Return the liquid of a humid pair and the limits of its law; empty for a dry pair."""
    return render_sentence("regime.toml", "liquid", _liquid_values(ds))


def _liquid_values(ds: xr.Dataset) -> dict[str, Any]:
    """Return the humidity and the menisci of a pair, or why none form; empty for a dry pair."""
    if "humidity" not in ds.coords:
        return {}
    menisci = menisci_of(ds)
    if menisci is None:
        thickness = 2 * float(ds["kelvin_radius"])
        return {
            "humidity": ds["humidity"],
            "too_thin": thickness,
            "liquid_molecule": float(ds["liquid_molecule"]),
        }
    return {
        "humidity": ds["humidity"],
        "meniscus_height": menisci.height,
        "megapascal": 1e3 * menisci.capillary_pressure,
        "small_radius": menisci.kelvin_radius if menisci.kelvin_radius < _FEW_MOLECULES else None,
        "per_cent": 100 * menisci.part if menisci.part < 1 else None,
    }


def estimate_notes(estimate: xr.Dataset) -> list[str]:
    """Return what a result of `extrapolated` knows from the scan, and what it assumes of finer roughness."""
    if "reason" in estimate.attrs:
        return render_sentences("estimate.toml", ["not_included"], estimate.attrs)
    shown = float(estimate["finest_shown"])
    source = estimate.attrs["unseen_by"]
    shortest, longest = TESTED
    is_unmeasured = source != MEASURED and estimate.attrs["shortest"] < shortest < shown
    entries = estimate["entry"].values
    values = {
        "finest_shown": shown,
        "noise_limit": estimate.attrs.get("noise_limit"),
        **{name: estimate[f"roughness_{name}"] for name in ("low", "factor", "high")},
        "source": names_in_words("unseen")[source],
        "shortest_measured": shortest if is_unmeasured else None,
        "longest_tested": longest if source == ONE_SCAN and shown > longest else None,
        "no_pair": all(name in (PLACES, UNSEEN) or ERROR_SOURCES[name].is_of_scan for name in entries),
    }
    return render_sentences("estimate.toml", ["resolved", "assumed"], values)


def fit_sentence(fit: xr.Dataset) -> str:
    """Return the result of `fit_pair` and its limits, a line each."""
    return "\n".join(render_sentences("fit.toml", ["work", "limits"], {**_fit_values(fit), **_work_values(fit)}))


def _work_values(fit: xr.Dataset) -> dict[str, Any]:
    """Return the fitted work of adhesion (J/m²) with its interval, and where it ends."""
    work, low, high = (float(fit[f"fitted_work_{name}"]) for name in ("of_adhesion", "low", "high"))
    solved = fit["trial_work_of_adhesion"].values
    interval = f"{format_percent(fit.attrs['confidence'])} interval"
    best = with_interval(work, low, high, "J/m²", name=interval)
    return {
        "work_with_interval": best if np.isfinite([work, high]).any() else None,
        "only_upper_end": low == 0,
        "beyond_range": np.isnan(work),
        "is_open": np.isnan(low) or np.isnan(high),
        "solved_works": f"{solved[0]:.3g} to {solved[-1]:.3g}",
        "left_out": ", ".join(f"{value:.3g}" for value in np.atleast_1d(fit.attrs.get("left_out", []))),
    }


def _fit_values(fit: xr.Dataset) -> dict[str, Any]:
    """Return what a fit depends on, and what it does not explain."""
    power = float(fit["modulus_trade"])
    spread = float(fit["spread_ratio"])
    is_explained = _EXPLAINED_SPREAD[0] < spread < _EXPLAINED_SPREAD[1]
    return {
        "contact_modulus": fit.attrs["contact_modulus"],
        "power": abs(power) if abs(power) < _ZERO_POWER else power,
        "is_separable": abs(power) < _WEAK_POWER,
        "unexplained_spread": None if is_explained or not np.isfinite(spread) else spread,
        "superposed": fit.attrs["method"] == "superposed",
        "extrapolated": bool(fit.attrs["extrapolated"]),
    }
