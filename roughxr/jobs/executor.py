"""Items computed in batches on any of dask's schedulers, their results handed over as they finish.

Sending a batch and storing its result costs the main process up to ten milliseconds, and an item takes from one to many
thousands. So batches grow to about half a second, as the time per item becomes known, and shrink again towards the end.
With batches of one item, two workers were hardly faster than one on items of 7 ms; with these, 1.8 times as fast.
"""

from __future__ import annotations

import statistics
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from queue import SimpleQueue
from typing import Any, NamedTuple

import numpy as np

from .progress import Progress
from .schedulers import Scheduler, scheduler_for
from .work import Work, run_batch

#: The time that a batch should take, s, and the largest size of its result, bytes.
_SECONDS, _BYTES = 0.5, 2**24

#: Number of items whose times predict that of the next: few, since compilation makes a worker's first ones slow.
_TIMED_ITEMS = 15

#: How often an item may be lost with its worker, and by which factor its batch is then smaller each time; at last it is
#: sent alone: so the item that kills its workers is found, and others that were lost with it are computed.
_MOST_LOSSES, _SPLITTING = 3, 16


class Failure(NamedTuple):
    """The result handed over for an item that failed."""

    error: Exception

    @property
    def reason(self) -> str:
        """The error in one line."""
        return str(self.error) if isinstance(self.error, LostError) else f"{type(self.error).__name__}: {self.error}"


class LostError(RuntimeError):
    """An item whose workers died every time it was tried."""


def each_finished(work: Work, items: Sequence[int], receive: Callable[[range, Any], None]) -> Progress:
    """Compute items on the active scheduler, the most expensive first, and hand over each batch as it finishes.

    Items lost with their worker are computed again elsewhere. At Ctrl-C threads finish the batches that they have
    begun, and the results of these are handed over too.
    """
    total, left = (work.each * n for n in (len(work.arguments), len(items)))
    progress = Progress(total, done=total - left, label=work.name)

    def handed_over(batch: range, result: Any) -> None:
        receive(batch, result)
        progress.add(work.each * len(batch), failed=isinstance(result, Failure))

    try:
        with scheduler_for(work.shared, len(items)) as scheduler:
            _until_interrupted(work, _Queue(work, items, scheduler.cores, scheduler.serving), scheduler, handed_over)
    finally:
        progress.close()
    return progress


def _until_interrupted(work: Work, queue: _Queue, scheduler: Scheduler, receive: Callable) -> None:
    """Compute all items; after an interrupt, still wait for the batches that have begun."""
    running: dict[Future, range] = {}
    try:
        _compute(work, queue, scheduler, running, receive)
    except KeyboardInterrupt:
        scheduler.close()
        for future, batch in running.items():
            if future.done() and not future.cancelled() and not future.exception():
                queue.settle(batch, future.result(), receive)
        raise


def _compute(work: Work, queue: _Queue, scheduler: Scheduler, running: dict[Future, range], receive: Callable) -> None:
    """Keep the scheduler busy until all is done; ``running`` holds the batches that are not handed over yet."""
    finished: SimpleQueue[Future] = SimpleQueue()
    while queue.waiting or running:
        while queue.waiting and len(running) < (1 if queue.last else scheduler.ahead):
            batch = queue.take()
            future = scheduler.submit(_attempt, work.task, [work.arguments[k] for k in batch], work.dtype)
            running[future] = batch
            future.add_done_callback(finished.put)
        future = finished.get()
        queue.settle(running[future], scheduler.result(future), receive)
        del running[future]


class _Queue:
    """Waiting items, and an estimate of the time that one takes."""

    def __init__(self, work: Work, items: Sequence[int], cores: int, serving: float):
        self.order = deque(_expensive_first(items, work.cost))
        self.waiting, self.cores, self.total = set(items), cores, len(items)
        self.losses: dict[int, int] = {}
        self.turn = cores * serving  # a batch lasts at least until each core has had its turn
        self.most = max(_BYTES // max(work.dtype.itemsize, 1), 1)
        self.seconds: deque[float] = deque(maxlen=_TIMED_ITEMS)
        self.last: set[int] = set()  # items at their last try: nothing else is computed meanwhile

    def take(self) -> range:
        """Return the most expensive waiting item, with neighbours that together take about half a second."""
        while (first := self.order.popleft()) not in self.waiting:
            pass
        stop, losses = first + 1, self.losses.get(first, 0)
        size = 1 if first in self.last else self._size() / _SPLITTING**losses
        while stop < first + size and stop in self.waiting and self.losses.get(stop, 0) == losses:
            stop += 1
        self.waiting.difference_update(range(first, stop))
        return range(first, stop)

    def _size(self) -> float:
        if not self.seconds:
            return 1
        each = max(statistics.median(self.seconds), 1e-9)
        least = min(self.turn / each, self.total / self.cores)
        most = max(_SECONDS / each, least)
        return min(max(len(self.waiting) / (4 * self.cores), least), most, self.most)

    def settle(self, batch: range, outcome: _Outcome | None, receive: Callable[[range, Any], None]) -> None:
        """Hand over the results of a batch, and put its items that were not computed back into the queue."""
        self.last.difference_update(batch)
        if outcome is None:
            self._lost(batch, receive)
            return
        done = len(outcome.results)
        if done:
            self.seconds.append(outcome.seconds / done)
            receive(batch[:done], outcome.results)
        if outcome.failure:
            receive(batch[done : done + 1], outcome.failure)
        self._again(batch[done + 1 :])

    def _again(self, items: Sequence[int]) -> None:
        self.waiting.update(items)
        self.order.extendleft(reversed(items))

    def _lost(self, batch: range, receive: Callable[[range, Any], None]) -> None:
        for k in batch:
            self.losses[k] = self.losses.get(k, 0) + 1
            if self.losses[k] > _MOST_LOSSES:
                receive(range(k, k + 1), Failure(LostError(f"lost {self.losses[k]} workers")))
        self.last.update(k for k in batch if self.losses[k] == _MOST_LOSSES)
        self._again([k for k in batch if self.losses[k] <= _MOST_LOSSES])


def _expensive_first(items: Sequence[int], cost: Callable[[], np.ndarray] | None) -> list[int]:
    if cost is None or len(items) < 2:
        return list(items)
    costs = cost()
    return sorted(items, key=lambda k: -float(costs[k]))


class _Outcome(NamedTuple):
    """The outcome of a batch: the results of its items up to the first that failed."""

    results: np.ndarray
    seconds: float
    failure: Failure | None


def _attempt(task: Callable, arguments: list[tuple], dtype: np.dtype, shared: tuple) -> _Outcome:
    """Compute the items one after the other until one fails."""
    began, results, failure = time.perf_counter(), [np.empty(0, dtype)], None
    try:
        for item in arguments:
            results.append(run_batch(task, [item], dtype, *shared))
    except Exception as error:
        if is_interrupt(error):
            raise KeyboardInterrupt from error
        failure = Failure(error)
    return _Outcome(np.concatenate(results), time.perf_counter() - began, failure)


def is_interrupt(error: BaseException | None) -> bool:
    """Return whether an error comes from an interrupt; from a kernel, Numba raises it as one or more SystemErrors."""
    while isinstance(error, SystemError):
        error = error.__cause__
    return isinstance(error, KeyboardInterrupt)
