"""Formatting of numbers with units, for reports, figures, tables and the command line."""

from __future__ import annotations

import math
from typing import SupportsFloat

#: Units with prefixes, the largest first, and their size in the unit of the table.
_PREFIXES = {
    "nN": (("mN", 1e6), ("µN", 1e3), ("nN", 1.0), ("pN", 1e-3)),
    "nm": (("mm", 1e6), ("µm", 1e3), ("nm", 1.0)),
    "nm^2": (("µm^2", 1e6), ("nm^2", 1.0)),
    "nN nm": (("µN µm", 1e6), ("nN µm", 1e3), ("nN nm", 1.0)),
    "Pa": (("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3), ("Pa", 1.0)),
}

#: Range of numbers that are written without a power of ten.
PLAIN_RANGE = 1e-4, 1e7

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def format_number(value: SupportsFloat, unit: str = "", digits: int = 3) -> str:
    """Return a number to some significant digits, at least to whole numbers, with its unit; a dash for NaN."""
    value = float(value)
    if math.isnan(value):
        return "–"
    text = _format_finite(value, digits) if math.isfinite(value) else "∞" if value > 0 else "-∞"
    return f"{text.replace('-', '−')} {unit}".strip()


def _format_finite(value: float, digits: int) -> str:
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    if value and not PLAIN_RANGE[0] <= abs(float(f"{mantissa}e{power}")) < PLAIN_RANGE[1]:
        return f"{float(mantissa):g} × 10{str(int(power)).translate(SUPERSCRIPTS)}"
    text = f"{value:.{max(digits - 1 - int(power), 0)}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def significant(value: SupportsFloat, digits: int = 2) -> str:
    """Return a number to some significant digits with the zeros among them."""
    value = float(value)
    power = f"{value:.{digits - 1}e}".partition("e")[2]
    if not math.isfinite(value) or not PLAIN_RANGE[0] <= abs(value) < PLAIN_RANGE[1]:
        return format_number(value, digits=digits)
    return f"{value:.{max(digits - 1 - int(power), 0)}f}"


def format_percent(share: SupportsFloat) -> str:
    """Return a share as per cent."""
    return format_number(100 * float(share), "%", 2)


def prefixed(largest: float, units: str = "nN") -> tuple[str, float]:
    """Return the largest unit in which a value is at least one, and that unit's size."""
    choices = _PREFIXES.get(units, ((units, 1.0),))
    rounded = float(f"{abs(largest):.3g}") if math.isfinite(largest) else 0.0
    return next(((unit, size) for unit, size in choices if rounded >= size), (units, 1.0))


def format_quantity(value: float, units: str = "nN", digits: int = 3) -> str:
    """Return a value in the unit with the appropriate prefix."""
    unit, size = prefixed(value, units)
    return format_number(value / size, unit, digits)
