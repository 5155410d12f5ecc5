"""Recorded values as forces: in units of force, or converted by sensitivity and spring constant."""

from __future__ import annotations

import re
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from ...mechanics.vocabulary.refusal import Refusal
from ...mechanics.vocabulary.schema import one_of, refuse_unused
from ...mechanics.vocabulary.text import Argument, Phrase
from ...mechanics.vocabulary.units import converts, factor, positive

PULLS = ("positive", "negative")

#: Advice for recorded values that are not in units of a force.
_ADVICE = Phrase(
    "state ", Argument("sensitivity", ...), " in nN/V; or in nm/V, with ", Argument("spring_constant", ...), " in N/m"
)


class Calibration(NamedTuple):
    """The caller's statements about the recorded values; None for missing ones."""

    units: str | None = None
    sensitivity: Any = None
    spring_constant: Any = None
    pulls: str | None = None


def measurable(values: np.ndarray, target: str, units: str) -> np.ndarray:
    """Return values in nN or nm; raise from 1 N or 1 m on, which no such instrument measures."""
    largest = float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))
    if largest >= 1e9:
        raise Refusal(
            "units",
            f"values below 1 {target[1:]}",
            f"{largest:g} {target} by units {units!r}",
            "prefixes are case-sensitive: m is milli, M is mega; correct the units in the file, or those given",
        )
    return values


def forces(values: np.ndarray, units: str | None, calibration: Calibration) -> tuple[np.ndarray, dict[str, Any]]:
    """Return recorded values as forces in nN, and attributes that describe the conversion."""
    if units and calibration.units and calibration.units != units:
        advice = Phrase("leave ", Argument("units", ...), " out")
        raise Refusal("units", f"{units!r}, as the file states", f"{calibration.units!r}", advice)
    units = units or calibration.units
    if units is None:
        advice = Phrase("give them, such as ", Argument("units", "nN"))
        raise Refusal("units", "those of the forces", "none in the file", advice)
    how: dict[str, Any] = {"measured_units": units}
    if converts(units, "nN"):
        refuse_unused(
            f"values in {units}", sensitivity=calibration.sensitivity, spring_constant=calibration.spring_constant
        )
        return measurable(values * factor(units, "nN"), "nN", units), how
    if converts(units, "nm"):
        refuse_unused(f"values in {units}", sensitivity=calibration.sensitivity)
        stiffness = _stiffness(calibration, units)
        return values * (factor(units, "nm") * stiffness), {**how, "spring_constant": stiffness}
    if not converts(units, "V"):
        raise Refusal("units", "those of a force, of a deflection, or V", f"{units!r}")
    per_volt, per_what = _per_volt(calibration.sensitivity, units)
    how |= {"sensitivity": per_volt, "sensitivity_units": per_what}
    values = values * (factor(units, "V") * per_volt)
    if per_what == "nN/V":
        refuse_unused("values in V with a sensitivity in nN/V", spring_constant=calibration.spring_constant)
        return values, how
    stiffness = _stiffness(calibration, units)
    return values * stiffness, {**how, "spring_constant": stiffness}


def _per_volt(sensitivity: Any, units: str) -> tuple[float, str]:
    """Return the value of one volt and its units, of a force or of a deflection."""
    if sensitivity is None:
        raise Refusal("", "forces", units, _ADVICE)
    has_units(sensitivity)
    try:
        return positive(sensitivity, "nN/V", "sensitivity"), "nN/V"
    except Refusal:
        return positive(sensitivity, "nm/V", "sensitivity"), "nm/V"


def has_units(sensitivity: Any) -> None:
    """Raise for a sensitivity that is a plain number, which could be nN/V as well as nm/V."""
    unitless = re.fullmatch(r"[-+.\deE\s]+", sensitivity) if isinstance(sensitivity, str) else None
    if unitless or isinstance(sensitivity, Real):
        raise Refusal("sensitivity", "its units, such as '12 nN/V' or '50 nm/V'", f"{sensitivity!r}")


def _stiffness(calibration: Calibration, units: str) -> float:
    if calibration.spring_constant is None:
        advice = Phrase("state ", Argument("spring_constant", ...), " in N/m")
        raise Refusal("", "forces", f"a deflection ({units})", advice)
    return positive(calibration.spring_constant, "nN/nm", "spring_constant")


def magnitudes(values: np.ndarray, pulls: str | None) -> tuple[np.ndarray, str]:
    """Return pull-off forces as positive magnitudes, and their sign in the file."""
    if pulls is None:
        if (values < 0).any() and (values > 0).any():
            below = int((values < 0).sum())
            raise Refusal(
                "",
                "pull-off forces of one sign",
                f"{below} below zero and {int((values > 0).sum())} above",
                Phrase(
                    "state the sign of a pull-off, ",
                    Argument("pulls", "positive"),
                    " or ",
                    Argument("pulls", "negative"),
                    ", or for a force-distance curve name the column of the piezo's travel piezo",
                ),
            )
        pulls = "negative" if (values < 0).any() else "positive"
    one_of(pulls, PULLS, "pulls")
    turned = -values if pulls == "negative" else values
    if (turned < 0).any() and not (turned > 0).any():
        other = next(sign for sign in PULLS if sign != pulls)
        advice = Phrase("give ", Argument("pulls", other), ", or none")
        raise Refusal("pulls", f"some {pulls} values", f"only {other} ones", advice)
    return turned, pulls
