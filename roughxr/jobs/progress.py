"""Progress of a computation, shown by tqdm within ``with progress():``.

Each solve is a bar of finished subregions with the time left. Within a run each stage is a line with the time left of
the run, and names the bars of its solves.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar, Token
from typing import TextIO, cast

from tqdm import tqdm

#: Where progress is shown, if anywhere, and the stage of a run.
_STREAM: ContextVar[TextIO | None] = ContextVar("progress", default=None)
_STAGE: ContextVar[str] = ContextVar("stage", default="")


@contextmanager
def progress(stream: TextIO | None = None) -> Iterator[None]:
    """Show the progress of computations within a ``with`` block: how much is finished, how fast, and the time left.

    Parameters
    ----------
    stream : file, optional
        Where to write; by default standard error.

    Yields
    ------
    None

    Examples
    --------
    >>> import io, roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> with roughxr.progress(stream := io.StringIO()):
    ...     elastic = roughxr.direct(scan, delta=[40.0], subregions=(2, 2))
    >>> "4/4" in stream.getvalue()
    True
    """
    stream = sys.stderr if stream is None else stream
    token = _STREAM.set(stream if stream.isatty() else cast(TextIO, _Lines(stream)))
    try:
        yield
    finally:
        _STREAM.reset(token)


class _Lines:
    """A stream that is no terminal: each state of a bar is a line of its own."""

    def __init__(self, stream: TextIO):
        self.stream = stream

    def write(self, text: str) -> None:
        """Write text with line feeds in place of carriage returns, without empty lines."""
        self.stream.writelines(f"{line.rstrip()}\n" for line in text.splitlines() if line.strip())

    def __getattr__(self, name: str):
        return getattr(self.stream, name)


def print_line(line: str) -> None:
    """Write a line, if progress is shown."""
    if stream := _STREAM.get():
        if stream.isatty():
            tqdm.write(line, file=stream)
        else:
            stream.write(line)
        stream.flush()


def subregion_bar(total: int, *, done: int = 0, label: str = "") -> tqdm:
    """Return a bar of finished subregions, of which some were finished by an earlier call."""
    stream = _STREAM.get()
    stage = _STAGE.get()
    # seconds between two updates of a bar: on a terminal, and in a file
    interval = 0.1 if stream is not None and stream.isatty() else 10.0
    return tqdm(
        desc=stage or label,
        total=total,
        initial=done,
        unit="subregion",
        file=stream,
        disable=stream is None,
        leave=not stage,
        mininterval=interval,
        delay=interval if stage else 0.0,  # no bar of a short solve between the lines of stages
        dynamic_ncols=True,
    )


class Stages:
    """The stages of a run in order, with the expected duration (s) and the name of each.

    A call begins a stage. If the run is interrupted or fails, the latest preliminary answer is printed.
    """

    def __init__(self, expected: Mapping[str, float], words: Mapping[str, str]):
        self._expected = dict(expected)
        self._words = words
        self._name = ""
        self._answer = ""
        self._begun = time.monotonic()
        self._time_left = TimeLeft()
        self._why = ""
        self._token: Token[str] | None = None

    def __enter__(self) -> Stages:
        self._token = _STAGE.set("")
        return self

    def __exit__(self, kind: type[BaseException] | None, *_) -> None:
        if self._token is not None:
            _STAGE.reset(self._token)
            self._token = None
        if kind and self._answer:
            print(f"so far: {self._answer}", flush=True)

    def __call__(self, name: str, more: str = "") -> None:
        """Begin a stage; ``more`` is added to its name."""
        self._expected.setdefault(name, 0.0)
        self._name = name
        self._begun = time.monotonic()
        names = list(self._expected)
        where = f"stage {names.index(name) + 1} of {len(names)}"
        time_left = self._time_left(sum(self._expected[later] for later in names[names.index(name) :]), self._why)
        print_line(f"{where}, {time_left}: {self._words.get(name, name)}{more}")
        if self._token is not None:  # within a run, whose end removes the name again
            _STAGE.set(where)

    def expect(self, why: str, **seconds: float) -> None:
        """Replace the expected durations of stages, s, and state why they may be longer than before."""
        self._why = why
        self._expected |= {name: value for name, value in seconds.items() if name in self._expected}

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
        # growth of a time left that is stated
        grew = seconds > 1.2 * self._seconds and rough_duration(seconds) != rough_duration(self._seconds)
        self._seconds = seconds if grew else min(seconds, self._seconds)
        return f"{rough_duration(self._seconds)} left" + f" (more than before: {why})" * grew


def rough_duration(seconds: float) -> str:
    """Return a duration in words, rounded."""
    if seconds < 60:
        return "less than a minute"
    return f"about {round(seconds / 60)} min" if seconds < 5400 else f"about {seconds / 3600:.2g} h"
