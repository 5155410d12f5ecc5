"""How numbers are written for readers: in reports, figures, tables and the shell alike."""

from __future__ import annotations

import math
from typing import SupportsFloat

#: Prefixes of units, the largest first, and their size.
_PREFIXES = {
    "nN": (("mN", 1e6), ("µN", 1e3), ("nN", 1.0), ("pN", 1e-3)),
    "nm": (("mm", 1e6), ("µm", 1e3), ("nm", 1.0)),
    "nm^2": (("µm^2", 1e6), ("nm^2", 1.0)),
    "nN nm": (("µN µm", 1e6), ("nN µm", 1e3), ("nN nm", 1.0)),
    "Pa": (("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3), ("Pa", 1.0)),
}

#: Numbers from the first to below the second are written without a power of ten.
_PLAIN_RANGE = 1e-4, 1e7

#: Largest ratio of the ends of an interval that is printed as numbers; wider ones come from too few values.
_WIDEST = 50.0
_TOO_WIDE = f"wider than a factor of {_WIDEST:.0f}, too few values"

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: SupportsFloat, unit: str = "", digits: int = 3) -> str:
    """Return a number to some significant digits, with its unit; whole places are never dropped; a dash for NaN."""
    value = float(value)
    if math.isnan(value):
        return "–"
    text = _finite(value, digits) if math.isfinite(value) else "∞" if value > 0 else "-∞"
    return f"{text.replace('-', '−')} {unit}".strip()


def _finite(value: float, digits: int) -> str:
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    if value and not _PLAIN_RANGE[0] <= abs(float(f"{mantissa}e{power}")) < _PLAIN_RANGE[1]:
        return f"{float(mantissa):g} × 10{str(int(power)).translate(SUPERSCRIPTS)}"
    text = f"{value:.{max(digits - 1 - int(power), 0)}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def percent(share: SupportsFloat) -> str:
    """Return a share as per cent."""
    return number(100 * float(share), "%", 2)


def prefixed(largest: float, units: str = "nN") -> tuple[str, float]:
    """Return the unit in which such a value has its digits before the point, and that unit's size."""
    known = _PREFIXES.get(units, ((units, 1.0),))
    rounded = float(f"{abs(largest):.3g}") if math.isfinite(largest) else 0.0
    return next(((unit, size) for unit, size in known if rounded >= size), (units, 1.0))


def quantity(value: float, units: str = "nN", digits: int = 3) -> str:
    """Return a value in the prefix that suits it."""
    unit, size = prefixed(value, units)
    return number(value / size, unit, digits)


def sure(value: float, low: float, high: float, units: str = "nN") -> str:
    """Return a value with its 95 % interval, both in the prefix that suits the value."""
    if is_too_wide(low, high):
        return f"{quantity(value, units)} (95 % interval {_TOO_WIDE})"
    unit, size = prefixed(value, units)
    ends = f"{number(low / size)} … {number(high / size, unit)}"
    return f"{number(value / size, unit)} (95 % interval {ends})"


def is_too_wide(low: float, high: float) -> bool:
    """Return whether the ends of an interval are so far from each other that they are no numbers to print."""
    return low > 0 and high > _WIDEST * low


def interval(low: float, high: float, units: str = "", digits: int = 3) -> str:
    """Return the ends of an interval with one unit, the prefix by the upper end."""
    if math.isnan(low) or math.isnan(high):
        return "–"
    if is_too_wide(low, high):
        return _TOO_WIDE
    unit, size = prefixed(max(abs(low), abs(high)), units)
    return f"{number(low / size, digits=digits)} … {number(high / size, unit, digits)}"
