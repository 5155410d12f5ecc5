"""Results in words, from their numbers."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..mechanics.bodies.liquid import menisci_of
from ..mechanics.statistics.censoring import RELATIVE_STD
from ..mechanics.statistics.means import estimated_mean
from ..mechanics.studies.extrapolation import TESTED
from ..mechanics.vocabulary.adhesion_laws import ADHESION_LAWS, SHORT_RANGE
from ..mechanics.vocabulary.error_sources import ERROR_SOURCES, MEASURED, ONE_SCAN, PLACES, UNSEEN, UNSEEN_WORDS
from ..mechanics.vocabulary.numbers import (
    format_number,
    format_percent,
    format_quantity,
    is_too_wide,
    value_and_interval,
    with_interval,
)

#: Probability below which samples of one distribution differ as much.
_UNLIKELY = 0.05

#: Scope of a prediction without best estimate.
AS_SCANNED = "The prediction is for the surface as scanned, without the roughness finer than the scan shows."

#: Relative difference of two scatters that counts as none: errors of single predicted pull-offs change theirs as much.
_EQUAL_SCATTER = 0.1

#: Factor of scatters in both directions between which an interval must decide.
_DECIDED_FACTOR = 2.0

#: Range of measured over predicted spread that the surface explains.
_EXPLAINED_SPREAD = 0.7, 1.4


def comparison_sentence(compared: xr.Dataset) -> str:
    """Return the ratio of means, whether the places explain the scatter, and whether both agree, a line each."""
    lines = []
    has_mean = "mean" in compared["statistic"]
    if has_mean:
        mean = compared.sel(statistic="mean")
        ratio, low, high = (float(mean[name]) for name in ("ratio", "ratio_low", "ratio_high"))
        lines.append(f"Measured over predicted mean: {with_interval(ratio, low, high, '')}.")
    lines.append(_scatter_in_words(compared))
    best = estimated_mean(compared)
    if best is None or not has_mean:
        return "\n".join([*lines, _distributions_in_words(compared)])
    return "\n".join([*lines, *_means_in_words(mean, *best)])


def _scatter_in_words(compared: xr.Dataset) -> str:
    """Return whether the places alone explain the relative scatter of the measured forces."""
    predicted, measured = (float(compared[f"{name}_{RELATIVE_STD}"]) for name in ("predicted", "measured"))
    ratio, low, high = (float(compared[f"{RELATIVE_STD}_ratio{end}"]) for end in ("", "_low", "_high"))
    scatter = f"Places alone scatter the forces by {format_percent(predicted)}, measured {format_percent(measured)}"
    undecided = "too few independent forces are known to decide whether roughness explains the scatter"
    if measured == 0:
        return f"{scatter}: the measured forces are all the same, such as a single one that is repeated."
    if not np.isfinite([ratio, low, high]).all():
        return f"{scatter}: {undecided}."
    if high < 1 - _EQUAL_SCATTER:
        decided = "the measured forces scatter less than by roughness"
    elif low > 1 + _EQUAL_SCATTER:
        decided = "the measured forces scatter more than by roughness"
    elif high > _DECIDED_FACTOR**2 * low:
        return f"{scatter}: {undecided}."
    else:
        decided = "roughness explains the scatter"
    ratio_text, ends = value_and_interval(ratio, low, high, "")
    return f"{scatter}: {decided} (ratio {ratio_text}, 95 % interval {ends})."


def _means_in_words(means: xr.Dataset, best: float, low: float, high: float) -> list[str]:
    """Return the effect of the roughness that the scan does not show, and whether the means (nN) agree."""
    ratio = format_number(best / float(means["predicted"]), digits=2)
    overlap = float(means["measured_low"]) <= high and float(means["measured_high"]) >= low
    relation = "overlaps" if overlap else "does not overlap"
    decided = (
        f"they agree, as any mean from {format_quantity(low, digits=2)} to {format_quantity(high, digits=2)} would"
        if overlap
        else "they disagree"
    )
    if not np.isfinite([float(means["measured_low"]), float(means["measured_high"])]).all():
        relation = "cannot be compared with"
        decided = "too few independent forces are measured for an interval"
    elif overlap and is_too_wide(low, high):
        decided = "it is too wide to decide"
    return [
        f"{AS_SCANNED} With it the best estimate is {with_interval(best, low, high)}, {ratio} times the prediction.",
        f"Its interval, by all known errors of the prediction, {relation} that of the measured mean: {decided}. "
        + _measuring_error(float(means.attrs.get("force_std", 0.0))),
    ]


def _measuring_error(force_std: float) -> str:
    """Return whether the measured interval contains an error that all its forces share."""
    if force_std > 0:
        return (
            f"An error of {format_percent(force_std)} (standard deviation) that all measured forces share is included."
        )
    return "Errors of spring constant and sensitivity are not included."


def _distributions_in_words(compared: xr.Dataset) -> str:
    """Return whether the distributions agree; errors common to all places are unknown."""
    distance = format_number(compared["distribution_distance"], digits=2)
    p_value = float(compared["distribution_p_value"])
    decided = "disagree" if p_value < _UNLIKELY else "agree"
    return (
        f"The distributions {decided}: they differ by {distance} at most, and samples of one distribution differ at "
        f"least as much with probability p = {format_number(p_value, digits=2)}. Errors common to all places are not "
        "included."
    )


def recommendation(regime: xr.Dataset) -> str:
    """Return the model that `regime` recommends, and the liquid of the pair."""
    method = {
        "rigid": "`rigid`, the sum over rigid bodies: summits hardly deform",
        "adhesive": f"`adhesive` with law={regime.attrs['law']!r}{_why_the_law(regime)}",
        "superpose": "`superpose`: the range of adhesion is negligible, and the contacts hardly interact",
    }[regime["recommended"].item()]
    sentence = (
        f"The quickest valid method is {method} (Tabor's parameter of the median asperity is "
        f"{format_number(regime['asperity_tabor'])}; between rigid bodies "
        f"{format_percent(regime['share_beyond_contact'])} of the adhesion force acts across gaps outside the contact)."
    )
    yielding = ""
    if regime.get("yields"):
        pressure = format_number(regime["peak_pressure"], "GPa")
        yielding = f"Summits yield under their own adhesion ({pressure}): give a hardness."
    return " ".join(filter(None, [sentence, yielding, liquid_words(regime)]))


def _why_the_law(regime: xr.Dataset) -> str:
    """Return the reason for the law of the simulation."""
    if not ADHESION_LAWS[regime.attrs["law"]].has_range:
        return ": the range of adhesion is negligible, but the contacts interact"
    why = "summits deform by about as much as the range of adhesion"
    if "sphere_maugis" in regime:
        why = "the liquid attracts across gaps"
    elif regime["asperity_tabor"] >= SHORT_RANGE:
        why = "for bodies that yield the adhesive traction must be finite"
    return f", of finite range: {why}"


def liquid_words(ds: xr.Dataset) -> str:
    """Return the liquid of a humid pair and the limits of its law; empty for a dry pair."""
    if "humidity" not in ds.coords:
        return ""
    humidity = f"At {float(ds['humidity']):.3g} relative humidity"
    menisci = menisci_of(ds)
    if menisci is None:
        return (
            f"{humidity} menisci, of {2 * float(ds['kelvin_radius']):.2g} nm, would be thinner than a molecule "
            f"({float(ds['liquid_molecule']):.2g} nm): nothing condenses, and the pair counts as dry."
        )
    sentence = (
        f"{humidity} the liquid fills gaps below {menisci.height:.2g} nm, with a capillary pressure of "
        f"{1e3 * menisci.capillary_pressure:.3g} MPa"
    )
    # Kelvin's radius, nm, below which the liquid is a few molecules thick (water's is 0.28 nm across)
    if menisci.kelvin_radius < 0.75:
        sentence += (
            f"; the Kelvin radius, {menisci.kelvin_radius:.2g} nm, is only a few molecules: the law of bulk liquids "
            "is an extrapolation there"
        )
    if menisci.part < 1:
        sentence += (
            f". Menisci thinner than two molecules count in part, with {100 * menisci.part:.0f} % of that of the bulk"
        )
    return f"{sentence}."


def estimate_notes(estimate: xr.Dataset) -> list[str]:
    """Return what a result of `extrapolated` knows from the scan, and what it assumes of finer roughness."""
    if "reason" in estimate.attrs:
        return [f"The effect of finer roughness is not included: {estimate.attrs['reason']}."]
    shown = float(estimate["finest_shown"])
    source = estimate.attrs["unseen_by"]
    known = f"The scan resolves wavelengths of {format_number(shown, 'nm')} (2 pixels) and longer."
    if "noise_limit" in estimate.attrs:
        noise = format_number(estimate.attrs["noise_limit"], "nm", 2)
        known += f" Noise cannot be distinguished from roughness: it may reach {noise}."
    low, factor, high = (format_number(estimate[f"roughness_{name}"], digits=2) for name in ("low", "factor", "high"))
    assumed = f"Finer roughness multiplies the pull-off by {factor} ({low} … {high}), {UNSEEN_WORDS[source]}."
    shortest, longest = TESTED
    if source != MEASURED and estimate.attrs["shortest"] < shortest < shown:
        assumed += f" Below {shortest:g} nm nothing is measured: an octave is assumed to count a quarter of that above."
    if source == ONE_SCAN and shown > longest:
        assumed += f" Wavelengths above {longest:g} nm could not be tested."
    if all(name in (PLACES, UNSEEN) or ERROR_SOURCES[name].is_of_scan for name in estimate["entry"].values):
        assumed += " The errors of the pair are not included."
    return [known, assumed]


def fit_sentence(fit: xr.Dataset) -> str:
    """Return the result of `fit_pair` and its limits, a line each."""
    work, low, high = (float(fit[f"fitted_work_{name}"]) for name in ("of_adhesion", "low", "high"))
    best = with_interval(work, low, high, "J/m²", name=f"{format_percent(fit.attrs['confidence'])} interval")
    is_found = np.isfinite([work, high]).any()
    opening = f"Work of adhesion at which predicted and measured pull-offs agree: {best if is_found else 'none'}."
    return f"{opening}\nLimits of the fit: {'; '.join(_fit_limits(fit, work, low, high))}."


def _fit_limits(fit: xr.Dataset, work: float, low: float, high: float) -> list[str]:
    """Return the limits of a fit with this work of adhesion and its interval (J/m²)."""
    power = float(fit["modulus_trade"])
    # largest exponent of the contact modulus for a fit that hardly depends on it
    separable = "only weakly" if abs(power) < 0.1 else "so that the fit cannot separate the two"
    modulus = f"contact modulus {format_number(fit.attrs['contact_modulus'], 'GPa')}"
    shown_power = abs(power) if abs(power) < 5e-3 else power
    notes = []
    if np.isfinite(power):
        notes += [f"w depends on the assumed {modulus} to the power {shown_power:.2f}, {separable}"]
    notes += ["the range of adhesion is the assumed one"]
    solved = fit["trial_work_of_adhesion"].values
    covered = f"{solved[0]:.3g} to {solved[-1]:.3g}"
    if low == 0:
        notes += ["fewer than three forces are measured, the others are limits: only the upper end is fitted"]
    elif np.isnan(work):
        notes += [
            f"the best value is at the end of the range tried, {covered} J/m²: check the units of the measured forces "
            "and the pair, or start nearer to it"
        ]
    elif np.isnan(low) or np.isnan(high):
        notes += [f"the interval reaches beyond the values that could be solved, {covered}"]
    left_out = np.atleast_1d(fit.attrs.get("left_out", []))
    if left_out.size:
        notes += [f"left out, since it could not be solved: {', '.join(f'{value:.3g}' for value in left_out)}"]
    spread = float(fit["spread_ratio"])
    if np.isfinite(spread) and not _EXPLAINED_SPREAD[0] < spread < _EXPLAINED_SPREAD[1]:
        predicted = "superposed asperities" if fit.attrs["method"] == "superposed" else "the simulation"
        notes += [f"the measured spread is {spread:.2g} times that by {predicted}, which no work of adhesion explains"]
    is_included = bool(fit.attrs["extrapolated"])
    finer = "roughness finer than the scan is"
    return [*notes, f"{finer} included" if is_included else f"{finer} not included (extrapolation=)"]


def expectation_words(summed: xr.Dataset) -> str:
    """Return the ratio of superposed pull-offs to those of the simulation, or why it is unknown."""
    expected = summed.attrs
    if "expected_low" in expected:
        tested = (
            "in 19 of 20 means over four places and at 9 of 10 single places of self-affine surfaces without debris"
        )
        return (
            f"{expected['expected_ratio']:.2g} times the pull-off of the simulation with adhesion, "
            f"{expected['expected_low']:g} … {expected['expected_high']:g} {tested}"
        )
    reason = {
        "law": f"the ratio was measured for the corrected formulas, not for {expected.get('formulas')!r}",
        "patch": "the patch does not follow the shortest wavelength; use asperities(patch='auto')",
        "pixels": f"the shortest wavelength of the scan spans {expected.get('wavelength_pixels', np.nan):.2g} pixels, "
        "too few to resolve its summits",
    }[expected["unknown_by"]]
    return f"the ratio to the simulation with adhesion is not known: {reason}"
