"""Progress of a computation, shown by tqdm within ``with progress():``.

Each solve is a bar of finished subregions with the time left. Within a run the bars of its solves are named by its
stage, and show the time left of the run.
"""

from __future__ import annotations

import logging
import math
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Protocol, TextIO, cast

from tqdm import tqdm

#: For messages in Python, where no progress is shown.
_LOGGER = logging.getLogger("roughxr")

#: Where progress is shown, if anywhere.
_STREAM: ContextVar[TextIO | None] = ContextVar("progress", default=None)


class Run(Protocol):
    """A run in progress, which names the bars of its solves."""

    bar: PlaceBar | None  # of its last solve

    @property
    def where(self) -> str:
        """Its stage."""

    def left(self) -> float:
        """Return its time left, s."""


#: The run in progress, if any.
RUN: ContextVar[Run | None] = ContextVar("run", default=None)


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
    """Log a line, and write it where progress is shown."""
    _LOGGER.info(line)
    if stream := _STREAM.get():
        if stream.isatty():
            tqdm.write(line, file=stream)
        else:
            stream.write(line)
        stream.flush()


class PlaceBar(tqdm):
    """A bar of finished subregions. The time left follows from those after the first, which waits for the compiler."""

    places = 0  # subregions that were not finished by an earlier call
    _finished = 0
    _first_finished = 0  # at the first update
    _first_time = math.nan
    _last_time = math.nan

    def update(self, n: float | None = 1) -> bool | None:
        """Count subregions that finished."""
        self._finished += int(n or 0)
        self._last_time = time.monotonic()
        if not self._first_finished:
            self._first_finished = self._finished
            self._first_time = self._last_time
        run = RUN.get()
        seconds = self.left()
        if math.isfinite(seconds):
            seconds = seconds if run is None else run.left()
            self.set_postfix_str(f"{rough_duration(seconds)} left", refresh=False)
        return super().update(n)

    def pace(self) -> float:
        """Return the time that a subregion takes, s; NaN before some have finished after the first."""
        later = self._finished - self._first_finished
        return (self._last_time - self._first_time) / later if later else math.nan

    def left(self) -> float:
        """Return the time until the last subregion has finished, s; NaN before some have finished after the first."""
        return (self.places - self._finished) * self.pace()


def subregion_bar(total: int, *, done: int = 0, label: str = "") -> PlaceBar:
    """Return a bar of finished subregions, of which some were finished by an earlier call."""
    stream = _STREAM.get()
    run = RUN.get()
    # seconds between two updates of a bar: on a terminal, and in a file
    interval = 0.1 if stream is not None and stream.isatty() else 10.0
    bar = PlaceBar(
        desc=label if run is None else run.where,
        total=total,
        initial=done,
        file=stream,
        disable=stream is None,
        leave=run is None,
        mininterval=interval,
        delay=0.0 if run is None else interval,  # no bar of a short solve between the lines of stages
        dynamic_ncols=True,
        bar_format="{desc}: {percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} [{elapsed}{postfix}]",
    )
    bar.places = total - done
    if run is not None:
        run.bar = bar
    return bar


def rough_duration(seconds: float) -> str:
    """Return a duration in words, rounded."""
    if seconds < 60:
        return "less than a minute"
    return f"about {round(seconds / 60)} min" if seconds < 5400 else f"about {seconds / 3600:.2g} h"
