"""Errors that are no bugs: invalid input, in fields so that each door can word it, and places that failed."""

from __future__ import annotations

from numbers import Real
from typing import Any


def shown(value: Any) -> str:
    """Return a value as text, its numbers to six digits."""
    if isinstance(value, Real) and not isinstance(value, bool):
        return f"{float(value):.6g}" if not isinstance(value, int) else str(value)
    if isinstance(value, (list, tuple)):
        listed = ", ".join(map(shown, value))
        return f"[{listed}]" if isinstance(value, list) else f"({listed}{',' * (len(value) == 1)})"
    return repr(value)


class Refusal(ValueError):
    """What a function refuses: the input, what was expected, what was found and what to do.

    ``what`` is an argument's name, a file or a quantity, ``where`` are names within it; what was expected and the
    advice are a `Phrase` if they name arguments, as ``mesh=4``. A shell writes all of them as options.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("rough")
    >>> try:
    ...     scan.contact.assign_pair(sphere_radius=-3000, materials="glass")
    ... except roughxr.Refusal as refusal:
    ...     print(refusal.what, "|", refusal.found)
    sphere_radius | -3000
    """

    where: tuple[str, ...] = ()

    def __init__(self, what: object, expected: object, found: object = "", advice: object = ""):
        expected, found = (value if isinstance(value, str) else shown(value) for value in (expected, found))
        super().__init__(what, expected, found, advice)
        self.what = what
        self.expected = expected
        self.found = found
        self.advice = advice

    @property
    def reason(self) -> str:
        """The text without the input's name."""
        found = f", found {self.found}" if str(self.found) else ""
        advice = f"; {self.advice}" if self.advice else ""
        return ": ".join([*self.where, f"expected {self.expected}{found}{advice}"])

    def __str__(self) -> str:
        return f"{self.what}: {self.reason}" if str(self.what) else self.reason


class WrongCall(Refusal, TypeError):
    """Arguments that a function does not take, or needs."""


class FailedSubregions(RuntimeError):
    """Places that could not be solved, with the reason of the first; the others are stored.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=500, materials="glass")
    >>> try:
    ...     pressed = scan.contact.direct(load=[100])
    ... except roughxr.FailedSubregions as failure:
    ...     print(failure)  # call again, with checkpoints only the failed places are solved
    """
