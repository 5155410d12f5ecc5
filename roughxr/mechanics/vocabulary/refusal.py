"""Errors that are no bugs: invalid input, in fields so that each door can word it, and places that failed."""

from __future__ import annotations


class Refusal(ValueError):
    """What a function refuses: the input, what was expected, what was found and what to do.

    ``what`` is an argument's name, a file or a quantity, ``advice`` may name arguments with their values, as
    ``mesh=4``; a shell writes both as options.
    """

    def __init__(self, what: object, expected: object, found: object = "", advice: object = ""):
        super().__init__(what, expected, found, advice)
        self.what = what
        self.expected = expected
        self.found = found
        self.advice = advice
        self.reason = f"expected {expected}"  # the text without the input's name
        self.reason += f", found {found}" if str(found) else ""
        self.reason += f"; {advice}" if advice else ""

    def __str__(self) -> str:
        return f"{self.what}: {self.reason}" if str(self.what) else self.reason


class FailedSubregions(RuntimeError):
    """Places that could not be solved, with the reason of the first; the others are stored."""
