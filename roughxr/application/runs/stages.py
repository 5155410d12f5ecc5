"""The stages of a run: a line for each, with the time left of the run."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Mapping
from contextvars import Token

from ...mechanics.jobs.progress import RUN, PlaceBar, Run, print_line, rough_duration

#: Added to the name of a stage whose kernels are not stored yet.
_COMPILING = ", compiling kernels, once on a machine"

#: Duration (s) of stages from which the speed of this machine is known as well as it was assumed.
_FEW_SECONDS = 10.0


class Stages:
    """The stages of a run in order, with the expected duration (s) and the name of each.

    A call begins a stage. ``compiling`` are the stages whose kernels are compiled in the expected duration. If the run
    is interrupted or fails, the latest preliminary answer is printed.
    """

    def __init__(self, expected: Mapping[str, float], words: Mapping[str, str], compiling: Collection[str] = ()):
        self.bar: PlaceBar | None = None  # of the stage's last solve
        self._expected = dict(expected)
        self._words = words
        self._compiling = compiling
        self._name = ""
        self._answer = ""
        self._begun = time.monotonic()
        self._passed: dict[str, float] = {}  # s, of stages that have ended
        self._measured: set[str] = set()  # stages whose expected duration is that on this machine
        self._time_left = TimeLeft()
        self._why = "this machine is slower than most"
        self._token: Token[Run | None] | None = None

    def __enter__(self) -> Stages:
        self._token = RUN.set(self)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_) -> None:
        if self._token is not None:
            RUN.reset(self._token)
            self._token = None
        if kind and self._answer:
            print(f"so far: {self._answer}", flush=True)

    def __call__(self, name: str, more: str = "") -> None:
        """Begin a stage; ``more`` is added to its name."""
        if self._name:
            self._passed[self._name] = self.passed()
        self._expected.setdefault(name, 0.0)
        self._name = name
        self._begun = time.monotonic()
        self.bar = None
        compiling = _COMPILING if name in self._compiling else ""
        time_left = self._time_left(self.left(), self._why)
        print_line(f"{self.where}, {time_left}: {self._words.get(name, name)}{more}{compiling}")

    @property
    def where(self) -> str:
        """The number of the stage in words."""
        names = list(self._expected)
        return f"stage {names.index(self._name) + 1} of {len(names)}" if self._name else ""

    def expect(self, why: str, **seconds: float) -> None:
        """Replace the expected durations of stages, s, and state why they may be longer than before."""
        self._why = why
        known = {name: value for name, value in seconds.items() if name in self._expected}
        self._expected |= known
        self._measured |= set(known)
        if self._name in known and (grown := self._time_left.if_grown(self.left(), why)):
            print_line(f"{self.where}, {grown}: {self._words.get(self._name, self._name)}")

    def left(self) -> float:
        """Return the time left of the run, s: of its bar by the places that finished, of later stages as expected."""
        names = list(self._expected)
        later = names[names.index(self._name) + 1 :] if self._name else names
        speed = self._speed()
        expected = {name: self._expected[name] * (1.0 if name in self._measured else speed) for name in names}
        left = sum(expected[name] for name in later)
        if not self._name:
            return left
        stage_left = max(expected[self._name] - self.passed(), 0.0)
        if self.bar is None or not math.isfinite(bar_left := self.bar.left()):
            return left + stage_left
        is_main = self.bar.places * self.bar.pace() > 0.5 * expected[self._name]
        return left + (bar_left if is_main else max(bar_left, stage_left))

    def _speed(self) -> float:
        """Return the duration of the stages that have ended over the expected one, near 1 for short ones."""
        ended = [name for name in self._passed if name not in self._measured]
        passed = sum(self._passed[name] for name in ended)
        return (_FEW_SECONDS + passed) / (_FEW_SECONDS + sum(self._expected[name] for name in ended))

    def pace(self) -> float:
        """Return the time that each place of the last bar took, s; 0 where it had none."""
        pace = math.nan if self.bar is None else self.bar.pace()
        return pace if math.isfinite(pace) else 0.0

    def answer(self, words: str) -> None:
        """Print a preliminary answer of the run."""
        if words != self._answer:
            print_line(words)
        self._answer = words

    def passed(self) -> float:
        """Return the time since the stage began, s."""
        return time.monotonic() - self._begun

    def later(self) -> list[str]:
        """Return the stages after this one in words."""
        names = list(self._expected)
        return [self._words[name] for name in names[names.index(self._name) + 1 :]] if self._name in names else []


class TimeLeft:
    """The time left in words: it shrinks, or states why it grew."""

    def __init__(self):
        self._seconds = math.inf

    def __call__(self, seconds: float, why: str) -> str:
        """Return the time left in words; ``why`` it may be longer than at the call before."""
        if grown := self.if_grown(seconds, why):
            return grown
        self._seconds = min(seconds, self._seconds)
        return f"{rough_duration(self._seconds)} left"

    def if_grown(self, seconds: float, why: str) -> str:
        """Return the time left in words if it is longer than before, else nothing."""
        # growth of a time left that is stated
        if not seconds > 1.2 * self._seconds or rough_duration(seconds) == rough_duration(self._seconds):
            return ""
        self._seconds = seconds
        return f"{rough_duration(seconds)} left (more than before: {why})"
