"""Interrupts by Ctrl-C: recognised under other names, and delivered again where Python drops them."""

from __future__ import annotations

import _thread
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

#: Time (s) after which a dropped interrupt is delivered again: the function that dropped it has ended by then.
_DELAY = 0.05

#: What Numba raises where an interrupt was dropped while LLVM handed a compiled kernel over.
_NOT_HANDED_OVER = "no compiled object yet"


def is_interrupt(error: BaseException | None) -> bool:
    """Return whether an error comes from an interrupt, of which Numba's kernels and its compiler make other errors."""
    while isinstance(error, SystemError):  # of a kernel, nested
        error = error.__cause__
    return isinstance(error, KeyboardInterrupt) or str(error).startswith(_NOT_HANDED_OVER)


@contextmanager
def delivered_interrupts() -> Iterator[None]:
    """Deliver interrupts within a block again that arrive in a destructor or a callback, where Python drops them."""
    timers: list[threading.Timer] = []
    report = sys.unraisablehook

    def deliver_again(dropped: Any) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            report(dropped)
            return
        timers.append(threading.Timer(_DELAY, _thread.interrupt_main))
        timers[-1].daemon = True
        timers[-1].start()

    sys.unraisablehook = deliver_again
    try:
        yield
    finally:
        sys.unraisablehook = report
        for timer in timers:
            timer.cancel()
