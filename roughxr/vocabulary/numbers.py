"""How numbers are written for readers: in reports, figures, tables and the shell alike."""

from __future__ import annotations

import math

#: Prefixes of units, the largest first, and their size.
_PREFIXES = {
    "nN": (("mN", 1e6), ("µN", 1e3), ("nN", 1.0), ("pN", 1e-3)),
    "nm": (("mm", 1e6), ("µm", 1e3), ("nm", 1.0)),
    "Pa": (("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3), ("Pa", 1.0)),
}

#: Numbers from the first to below the second are written without a power of ten.
_PLAIN = 1e-4, 1e7

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, unit: str = "", digits: int = 3) -> str:
    """Return a number to some significant digits, with its unit; whole places are never dropped; a dash for NaN.

    Examples
    --------
    >>> number(2.04, "µN", 2), number(float("nan"), "nm"), number(-0.5), number(99.96, "%"), number(1263.0)
    ('2 µN', '–', '−0.5', '100 %', '1263')
    >>> number(6.5e-20, "J"), number(0.0), number(0.99996), number(float("inf"))
    ('6.5 × 10⁻²⁰ J', '0', '1', '∞')
    """
    value = float(value)
    if math.isnan(value):
        return "–"
    text = _finite(value, digits) if math.isfinite(value) else "∞" if value > 0 else "-∞"
    return f"{text.replace('-', '−')} {unit}".strip()


def _finite(value: float, digits: int) -> str:
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    if value and not _PLAIN[0] <= abs(float(f"{mantissa}e{power}")) < _PLAIN[1]:
        return f"{float(mantissa):g} × 10{str(int(power)).translate(_RAISED)}"
    text = f"{value:.{max(digits - 1 - int(power), 0)}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def percent(share: float, digits: int = 2) -> str:
    """Return a share as per cent.

    Examples
    --------
    >>> percent(0.9999), percent(0.0042), percent(1.0), percent(float("nan")), percent(12.3)
    ('100 %', '0.42 %', '100 %', '–', '1230 %')
    """
    return number(100 * share, "%", digits)


def prefixed(largest: float, units: str = "nN") -> tuple[str, float]:
    """Return the unit in which such a value has its digits before the point, and that unit's size.

    Examples
    --------
    >>> prefixed(6.011), prefixed(2000.0), prefixed(0.0), prefixed(999.96), prefixed(12842.0, "nm"), prefixed(3, "GPa")
    (('nN', 1.0), ('µN', 1000.0), ('nN', 1.0), ('µN', 1000.0), ('µm', 1000.0), ('GPa', 1.0))
    """
    known = _PREFIXES.get(units, ((units, 1.0),))
    rounded = float(f"{abs(largest):.3g}") if math.isfinite(largest) else 0.0
    return next(((unit, size) for unit, size in known if rounded >= size), (units, 1.0))


def quantity(value: float, units: str = "nN", digits: int = 3) -> str:
    """Return a value in the prefix that suits it.

    Examples
    --------
    >>> quantity(6.011), quantity(1263.0), quantity(0.0126), quantity(-26.2e3), quantity(float("nan"))
    ('6.01 nN', '1.26 µN', '12.6 pN', '−26.2 µN', '–')
    """
    unit, size = prefixed(value, units)
    return number(value / size, unit, digits)


def sure(value: float, low: float, high: float, units: str = "nN") -> str:
    """Return a value with its 95 % interval, both in the prefix that suits the value.

    Examples
    --------
    >>> sure(871.0, 156.0, 4850.0)
    '871 nN (95 % interval 156 … 4850 nN)'
    """
    unit, size = prefixed(value, units)
    ends = f"{number(low / size)} … {number(high / size, unit)}"
    return f"{number(value / size, unit)} (95 % interval {ends})"


def interval(low: float, high: float, units: str = "", digits: int = 3) -> str:
    """Return the ends of an interval with one unit, the prefix by the upper end.

    Examples
    --------
    >>> interval(388.0, 1817.0, "nN"), interval(-0.1, 0.25), interval(float("nan"), 1.0)
    ('0.388 … 1.82 µN', '−0.1 … 0.25', '–')
    """
    if math.isnan(low) or math.isnan(high):
        return "–"
    unit, size = prefixed(max(abs(low), abs(high)), units)
    return f"{number(low / size, digits=digits)} … {number(high / size, unit, digits)}"
