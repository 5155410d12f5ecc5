"""Values with their errors and intervals as text."""

from __future__ import annotations

import math

from ...mechanics.vocabulary.numbers import PLAIN_RANGE, format_number, prefixed

#: Largest ratio of the ends of an interval that is printed as numbers: wider ones are estimated from too few values.
_WIDEST = 50.0

#: Text in place of the ends of a wider interval.
_TOO_WIDE = f"wider than a factor of {_WIDEST:.0f}"


def with_error(value: float, error: float, *others: float, unit: str = "") -> tuple[str, ...]:
    """Return a value, its error and other values of the same kind to the second digit of the error.

    Each has at least one and at most three digits.
    """
    numbers = (value, error, *others)
    largest = max(abs(value), abs(error))
    if not (math.isfinite(largest) and error > 0):
        return tuple(format_number(part, unit) for part in numbers)
    place = max(_power(error, 2) - 1, _power(largest, 3) - 2)
    return tuple(_to_place(part, place, unit) for part in numbers)


def _power(value: float, digits: int) -> int:
    """Return the power of ten of the first digit, after rounding."""
    return int(f"{abs(value):.{digits - 1}e}".partition("e")[2])


def _to_place(value: float, place: int, unit: str) -> str:
    """Return a number rounded to a power of ten, or to its first digit where it is smaller."""
    if value and math.isfinite(value) and PLAIN_RANGE[0] <= abs(value) < PLAIN_RANGE[1]:
        place = min(place, _power(value, 1))
        text = f"{round(value, -place):.{max(-place, 0)}f}".replace("-", "−")
        return f"{text} {unit}".strip()
    return format_number(value, unit)


def with_interval(
    value: float,
    low: float,
    high: float,
    units: str = "nN",
    *,
    why_wide: str = "",
    name: str = "95 % interval",
) -> str:
    """Return a value with its interval, both in one unit, the interval's name, and why it is too wide for numbers."""
    value_text, ends = value_and_interval(value, low, high, units)
    reason = why_wide * is_too_wide(low, high)
    lead = name if math.isfinite(high - low) else "no interval:"
    return f"{value_text} ({f'{lead} {ends}'.lstrip()}{reason})"


def value_and_interval(value: float, low: float, high: float, units: str = "nN") -> tuple[str, str]:
    """Return a value and its interval as text, both in one unit."""
    unit, size = prefixed(value, units)
    error = (high - low) / 2
    if not math.isfinite(error):
        return format_number(float(f"{value / size:.3g}"), unit), "–" if math.isnan(
            value
        ) else "too few independent places"
    if is_too_wide(low, high):
        return format_number(value / size, unit, 2), _TOO_WIDE
    value_text, _, lower, upper = with_error(value / size, error / size, low / size, high / size, unit=unit)
    return value_text, f"{lower.removesuffix(unit).rstrip()} … {upper}"


def bounds_in_words(low: float, high: float, units: str = "nN") -> str:
    """Return the ends between which a value lies, in one unit; a dash if unknown."""
    unit, size = prefixed(high if math.isfinite(high) else low, units)
    if math.isinf(high):
        return f"above {format_number(low / size, unit)}"
    if math.isnan(high):
        return "–"
    lower, upper = (format_number(end / size, digits=2) for end in (low, high))
    return f"{lower} … {upper} {unit}"


def is_too_wide(low: float, high: float) -> bool:
    """Return whether an interval is too wide to be printed as numbers."""
    return low > 0 and high > _WIDEST * low
