"""Progress of a computation, counted in finished subregions: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import TextIO

#: Seconds between two reports: on a terminal, and as plain lines.
_ON_TERMINAL, _AS_LINES = 0.1, 10.0

_BAR = 24

#: Seconds after the first finished item before a rate is reported: items that finish with the first one say nothing.
_SETTLED = 1.0


class Progress:
    """Count of finished items with rate, time left and failures.

    The first items wait while kernels are compiled, up to a minute where nothing is cached. The rate is therefore that
    of items after the first finished one, counted over the latter half of the time since then.

    Examples
    --------
    >>> import sys
    >>> progress = Progress(4, what="tiles", stream=sys.stdout)
    >>> progress.add(4)
    >>> progress.close()
    4/4 tiles, ... /s, 0 s left, 0 failed
    """

    def __init__(self, total: int, *, done: int = 0, what: str = "subregions", stream: TextIO | None = None):
        self.total, self.done, self.what, self.failed = total, done, what, 0
        self._kept, self._stream, self._start, self._said = done, stream, time.monotonic(), 0.0
        self._terminal = stream is not None and stream.isatty()
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
        if self._stream is not None and now - max(self._said, self._start) >= (
            _ON_TERMINAL if self._terminal else _AS_LINES
        ):
            self._said = now
            self._tell("")

    def close(self) -> None:
        """Report the final count, and end the line."""
        if self._stream is not None and self.total:
            self._tell("\n")

    def seconds(self) -> float:
        """Return the time since the start, s."""
        return time.monotonic() - self._start

    def text(self) -> str:
        """Return the report as text."""
        settled = self._settled_rate()
        rate = settled or (self.done - self._kept) / max(self.seconds(), 1e-9)
        left = self.total - self.done - self.failed
        remaining = _duration(left / settled) if settled and left else "unknown time" if left else "0 s"
        return f"{self.done}/{self.total} {self.what}, {rate:.3g} /s, {remaining} left, {self.failed} failed"

    def _mark(self, now: float) -> None:
        """Record the time and the number of finished items, and drop records older than the rate needs."""
        self._marks.append((now, self.done))
        self._first = self._marks[0] if len(self._marks) == 1 else self._first
        while len(self._marks) > 2 and self._marks[1][0] <= (self._first[0] + now) / 2:
            self._marks.popleft()

    def _settled_rate(self) -> float:
        """Return items per second over the latter half of the time since the first finished item, 0 while unknown."""
        if not self._marks or self._marks[-1][0] - self._first[0] < _SETTLED:
            return 0.0
        (begun, before), (last, count) = self._marks[0], self._marks[-1]
        return (count - before) / (last - begun)

    def _tell(self, end: str) -> None:
        if not self._terminal:
            self._stream.write(self.text() + "\n")
        else:
            filled = _BAR * self.done // max(self.total, 1)
            self._stream.write(f"\r[{'#' * filled}{'.' * (_BAR - filled)}] {self.text()}\x1b[K{end}")
        self._stream.flush()


def _duration(seconds: float) -> str:
    """Return a time in words: 12 s, 3 min 20 s, 5 h 10 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def stages(progress: bool, total: int) -> Callable[[str], None]:
    """Return a function that tells the stage that begins, its number, and the time since the first.

    Examples
    --------
    >>> stages(False, 3)("nothing")
    """
    tell, begun, number = teller(progress), time.monotonic(), 0

    def say(what: str) -> None:
        nonlocal number, total
        number += 1
        total = max(total, number)
        passed = _duration(time.monotonic() - begun)
        tell(f"stage {number} of {total}: {what}" + f" ({passed} so far)" * (number > 1))

    return say


def teller(progress: bool) -> Callable[[str], None]:
    """Return a function that writes a line to standard error, or that does nothing.

    Examples
    --------
    >>> teller(False)("nothing")
    """
    import sys

    return (lambda what: print(what, file=sys.stderr, flush=True)) if progress else (lambda what: None)
