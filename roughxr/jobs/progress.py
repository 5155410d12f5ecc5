"""Progress of a computation, counted in finished subregions: a bar on a terminal, plain lines elsewhere.

It is shown within ``with progress():``. During a run the bar is part of one line, with the stage and the time left over
all stages.
"""

from __future__ import annotations

import shutil
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TextIO

#: Seconds between two reports: on a terminal, and as plain lines.
_ON_TERMINAL, _AS_LINES = 0.1, 10.0

#: Seconds without news after which a run repeats its line: on a terminal, and as plain lines.
_SILENT_ON_TERMINAL, _SILENT_AS_LINES = 1.0, 20.0

_BAR_WIDTH = 24

#: Seconds after the first finished item before a rate is reported: items that finish with it would distort that.
_RATE_DELAY = 1.0

#: Where progress is written, if anywhere, and the stages of a run, which show it in their own line.
_STREAM: ContextVar[TextIO | None] = ContextVar("progress", default=None)
_STAGES: ContextVar[Stages | None] = ContextVar("stages", default=None)


@contextmanager
def progress(stream: TextIO | None = None) -> Iterator[None]:
    """Show the progress of computations within a ``with`` block: how much is finished, how fast, and the time left.

    On a terminal it is a bar, elsewhere a line every ten seconds.

    Parameters
    ----------
    stream : file, optional
        Where to write; by default standard error.

    Yields
    ------
    None

    Examples
    --------
    >>> import roughxr, sys
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, contact_modulus=39.4)
    >>> with roughxr.progress(sys.stdout):
    ...     elastic = roughxr.direct(scan, delta=[10.0], subregions=(2, 2))
    direct: 4/4 subregions, ... /s, 0 s left, 0 failed
    """
    token = _STREAM.set(sys.stderr if stream is None else stream)
    try:
        yield
    finally:
        _STREAM.reset(token)


def is_shown() -> bool:
    """Return whether progress is shown."""
    return _STREAM.get() is not None


def say(words: str) -> None:
    """Write a line, or a detail of a run's stage; nothing where no progress is shown."""
    if stages := _STAGES.get():
        stages.detail(words)
    elif stream := _STREAM.get():
        print(words, file=stream, flush=True)


class Progress:
    """Count of finished items with rate, time left and failures.

    The first items wait while kernels are compiled, up to a minute where nothing is cached. The rate is therefore that
    of items after the first finished one, counted over the latter half of the time since then.
    """

    def __init__(self, total: int, *, done: int = 0, what: str = "subregions", label: str = ""):
        self.total, self.done, self.what, self.label, self.failed = total, done, what, label and f"{label}: ", 0
        self._stages = _STAGES.get()
        if self._stages:
            self._stages.bar = self
        self._stream = None if self._stages else _STREAM.get()
        self._terminal = self._stream is not None and self._stream.isatty()
        self._kept, self._start, self._said = done, time.monotonic(), 0.0
        self._marks: deque[tuple[float, int]] = deque()  # time, and number of items finished by then
        self._first = (0.0, 0)

    def add(self, count: int = 1, *, failed: bool = False) -> None:
        """Count items as finished, or as failed, and report if enough time has passed."""
        if failed:
            self.failed += count
        else:
            self.done += count
        now = time.monotonic()
        self._mark(now)
        if self._stages:
            self._stages.refresh()
        if self._stream is not None and now - max(self._said, self._start) >= (
            _ON_TERMINAL if self._terminal else _AS_LINES
        ):
            self._said = now
            self._tell("")

    def close(self) -> None:
        """Report the final count, and end the line."""
        if self._stages:
            self._stages.bar = None
        if self._stream is not None and self.total:
            self._tell("\n")

    def seconds(self) -> float:
        """Return the time since the start, s."""
        return time.monotonic() - self._start

    def left(self) -> float:
        """Return the time left, s; NaN as long as it is not known."""
        left, settled = self.total - self.done - self.failed, self._settled_rate()
        return 0.0 if not left else left / settled if settled else float("nan")

    def text(self) -> str:
        """Return the report as text."""
        rate = self._settled_rate() or (self.done - self._kept) / max(self.seconds(), 1e-9)
        left = self.left()
        remaining = _duration(left) if left == left else "unknown time"
        return f"{self.done}/{self.total} {self.what}, {rate:.3g} /s, {remaining} left, {self.failed} failed"

    def _mark(self, now: float) -> None:
        """Record the time and the number of finished items, and drop records older than the rate needs."""
        self._marks.append((now, self.done))
        self._first = self._marks[0] if len(self._marks) == 1 else self._first
        while len(self._marks) > 2 and self._marks[1][0] <= (self._first[0] + now) / 2:
            self._marks.popleft()

    def _settled_rate(self) -> float:
        """Return items per second over the latter half of the time since the first finished item, 0 while unknown."""
        if not self._marks or self._marks[-1][0] - self._first[0] < _RATE_DELAY:
            return 0.0
        (begun, before), (last, count) = self._marks[0], self._marks[-1]
        return (count - before) / (last - begun)

    def _tell(self, end: str) -> None:
        assert self._stream is not None
        if not self._terminal:
            self._stream.write(f"{self.label}{self.text()}\n")
        else:
            filled = _BAR_WIDTH * self.done // max(self.total, 1)
            self._stream.write(f"\r{self.label}[{'#' * filled}{'.' * (_BAR_WIDTH - filled)}] {self.text()}\x1b[K{end}")
        self._stream.flush()


def _duration(seconds: float) -> str:
    """Return a time in words: 12 s, 3 min 20 s, 5 h 10 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


class Stages:
    """The stages of a run, shown on one line: which of how many, how far it has come, and the time left of the run.

    ``expected`` holds the stages in order and about how long each takes (s), ``words`` their names in words.
    """

    def __init__(self, expected: Mapping[str, float], words: Mapping[str, str]):
        self.bar: Progress | None = None
        self._stream: TextIO | None = None
        self._expected, self._names, self._terminal = dict(expected), words, False
        self._name, self._words, self._detail, self._begun, self._said = "", "", "", time.monotonic(), 0.0
        self._found, self._short = "", ""
        self._lock, self._ended = threading.Lock(), threading.Event()

    def __enter__(self) -> Stages:
        self._stream = _STREAM.get()
        self._token = _STAGES.set(None if self._stream is None else self)
        if self._stream is not None:
            self._terminal = self._stream.isatty()
            threading.Thread(target=self._keep_telling, daemon=True).start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_) -> None:
        self._ended.set()
        _STAGES.reset(self._token)
        self.clear()
        if kind and self._found:
            print(f"so far: {self._found}", flush=True)

    def clear(self) -> None:
        """Take the line off a terminal, before something else is printed."""
        if self._stream is not None and self._terminal:
            self._stream.write("\r\x1b[K")
            self._stream.flush()

    def __call__(self, name: str, more: str = "") -> None:
        """Begin a stage; ``more`` is added to its name."""
        self._expected.setdefault(name, 0.0)
        self._name, self._words = name, self._names.get(name, name) + more
        self._detail, self.bar, self._begun = "", None, time.monotonic()
        self._tell()

    def expect(self, **seconds: float) -> None:
        """Replace the times that stages are expected to take, s."""
        self._expected |= {name: value for name, value in seconds.items() if name in self._expected}

    def detail(self, words: str) -> None:
        """Show what the stage is at."""
        self._detail = words
        self.refresh()

    def found(self, words: str, short: str) -> None:
        """Show the answer as far as it is known, on a terminal in short at the head of the line.

        A run that is interrupted or fails prints it as its answer.
        """
        self._found, self._short = words, short
        if self._stream is not None and not self._terminal:
            with self._lock:
                self._stream.write(f"{words}\n")
        self._tell()

    def passed(self) -> float:
        """Return the time since the stage began, s."""
        return time.monotonic() - self._begun

    def later(self) -> list[str]:
        """Return the stages after this one in words."""
        names = list(self._expected)
        return [self._names[name] for name in names[names.index(self._name) + 1 :]] if self._name in names else []

    def refresh(self) -> None:
        """Show the line again if enough time has passed."""
        if time.monotonic() - self._said >= (_ON_TERMINAL if self._terminal else _AS_LINES):
            self._tell()

    def text(self) -> str:
        """Return the line."""
        names, bar = list(self._expected), self.bar
        at = f"{bar.done}/{bar.total}" if bar and bar.total > 1 else ""
        where = ", ".join(filter(None, (self._detail, at)))
        stage = f"stage {names.index(self._name) + 1} of {len(names)}, {self._left()}"
        return f"{stage}: {self._words}{where and f' ({where})'}"

    def _left(self) -> str:
        """Return the time left over all stages in words."""
        names, passed = list(self._expected), self.passed()
        later = sum(self._expected[name] for name in names[names.index(self._name) + 1 :])
        of_bar = self.bar.left() if self.bar else float("nan")
        here = max(self._expected[self._name] - passed, of_bar if of_bar == of_bar else 0.0)
        longer = passed > 60 and here <= 0 and not of_bar > 0
        return about(later + here) + " left" + (" after this stage, which takes longer than most" if longer else "")

    def _tell(self) -> None:
        if self._stream is None or not self._name:
            return
        with self._lock:
            self._said, line = time.monotonic(), self.text()
            if self._terminal:
                width, line = shutil.get_terminal_size().columns - 1, f"{self._short and self._short + ' | '}{line}"
                self._stream.write(f"\r{line[:width]}\x1b[K")
            else:
                self._stream.write(f"{line}\n")
            self._stream.flush()

    def _keep_telling(self) -> None:
        """Show the line from time to time, also where nothing finishes, until the last stage ends."""
        silent = _SILENT_ON_TERMINAL if self._terminal else _SILENT_AS_LINES
        while not self._ended.wait(silent / 4):
            if time.monotonic() - self._said >= silent:
                self._tell()


def about(seconds: float) -> str:
    """Return a time that is roughly known in words."""
    if seconds < 60:
        return "less than a minute"
    return f"about {round(seconds / 60)} min" if seconds < 5400 else f"about {seconds / 3600:.2g} h"
