"""How far a computation is, told by finished subregions: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from typing import TextIO

#: Seconds between two reports: on a terminal, and as plain lines.
_ON_TERMINAL, _AS_LINES = 0.1, 10.0

_BAR = 24


class Progress:
    """Count of finished items with rate, time left and failures.

    Parameters
    ----------
    total : int
        Items to finish.
    done : int
        Items that an earlier call finished: they count as done, not for the rate.
    what : str
        Name of the items.
    stream : file, optional
        Where to tell; nowhere by default.

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

    def add(self, count: int = 1, *, failed: bool = False) -> None:
        """Count items as finished, or as failed, and tell so if it is time to."""
        if failed:
            self.failed += count
        else:
            self.done += count
        now = time.monotonic()
        if self._stream is not None and now - max(self._said, self._start) >= (
            _ON_TERMINAL if self._terminal else _AS_LINES
        ):
            self._said = now
            self._tell("")

    def close(self) -> None:
        """Tell how far it came, and end the line."""
        if self._stream is not None and self.total:
            self._tell("\n")

    def seconds(self) -> float:
        """Return the time since the start, s."""
        return time.monotonic() - self._start

    def text(self) -> str:
        """Return how far it is, in words."""
        rate = (self.done - self._kept) / max(self.seconds(), 1e-9)
        left = self.total - self.done - self.failed
        remaining = _duration(left / rate) if rate > 0 else "unknown time" if left else "0 s"
        return f"{self.done}/{self.total} {self.what}, {rate:.3g} /s, {remaining} left, {self.failed} failed"

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
