"""The items of a solve, computed in batches on any of dask's schedulers, and handed over as they finish.

Sending a batch and keeping its result cost the main process up to ten milliseconds, while an item takes one or many
thousand. So batches grow, as it turns out what an item takes, to about half a second, and shrink again towards the
end: with batches of one item, two workers were hardly faster than one on items of 7 ms; with these 1.8 times.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, NamedTuple, Protocol

import dask
import dask.local
import dask.multiprocessing
import dask.system
import numpy as np
from dask.local import SynchronousExecutor

from . import processes as workers
from .work import Work, run_batch

#: What a batch should take, s, and the most that its result may hold, bytes.
_SECONDS, _BYTES = 0.5, 2**24

#: In what time the main process serves a batch, s, here and on a cluster: batches last until each core had its turn.
_SERVED_HERE, _SERVED_FAR = 0.002, 0.02

#: Batches sent ahead for each thread or process: one to compute, one to go on with.
_AHEAD = 2

#: Items whose times tell what the next will take: few, since compiling makes a worker's first ones slow.
_TIMED = 15

#: An item may be lost with its workers so often. Each time it goes in a batch smaller by this factor, and at last
#: alone: so the one that ends its workers is found, and the others that were lost with it are computed.
_MOST_LOSSES, _FEWER = 3, 16


class Failure(NamedTuple):
    """What is handed over for an item that failed."""

    error: Exception

    @property
    def reason(self) -> str:
        """The error in a line."""
        return str(self.error) if isinstance(self.error, LostError) else f"{type(self.error).__name__}: {self.error}"


class LostError(RuntimeError):
    """An item whose workers died, each in its turn."""


def each_finished(work: Work, items: Sequence[int], receive: Callable[[range, Any], None]) -> None:
    """Compute items on the scheduler in force, the dearest first, and hand over each batch as it comes.

    What was lost with its worker is computed again elsewhere.

    Parameters
    ----------
    work : Work
    items : sequence of int
        Those of ``work.arguments`` that are wanted.
    receive : callable
        Called in this process as ``receive(batch, result)`` with a range of items and their array, or one item and
        its `Failure`. Nothing else keeps the result.
    """
    with _pool(work, len(items)) as pool:
        queue, running = _Queue(work, items, pool.cores, pool.serving), {}
        while queue.waiting or running:
            while queue.waiting and len(running) < (1 if queue.last else pool.ahead):
                batch = queue.take()
                running[pool.submit([work.arguments[k] for k in batch])] = batch
            for done, outcome in pool.finished(running):
                queue.settle(running.pop(done), outcome, receive)


class _Queue:
    """Items that wait, and what is known of how long one takes."""

    def __init__(self, work: Work, items: Sequence[int], cores: int, serving: float):
        self.order = deque(_dearest_first(items, work.cost))
        self.waiting, self.losses, self.turn = set(items), {}, cores * serving
        self.most, self.cores, self.total = max(_BYTES // max(work.dtype.itemsize, 1), 1), cores, len(items)
        self.seconds: deque[float] = deque(maxlen=_TIMED)
        self.last: set[int] = set()  # items at their last try: nothing else is computed meanwhile

    def take(self) -> range:
        """Return the dearest that waits, and neighbours with it for about half a second."""
        while (first := self.order.popleft()) not in self.waiting:
            pass
        stop, losses = first + 1, self.losses.get(first, 0)
        size = 1 if first in self.last else self._size() / _FEWER**losses
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
        """Hand over what a batch came to; let its items wait again that did not have their turn."""
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


def _dearest_first(items: Sequence[int], cost: Callable[[], np.ndarray] | None) -> list[int]:
    if cost is None or len(items) < 2:
        return list(items)
    costs = cost()
    return sorted(items, key=lambda k: -float(costs[k]))


class _Outcome(NamedTuple):
    """What a batch came to: the results of its items up to the first that failed."""

    results: np.ndarray
    seconds: float
    failure: Failure | None


def _attempt(task: Callable, arguments: list[tuple], dtype: np.dtype, *shared: Any) -> _Outcome:
    """Compute one item after the other until one fails."""
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
    """Say whether an error comes of an interrupt: one within a kernel leaves Numba as a SystemError, or several."""
    while isinstance(error, SystemError):
        error = error.__cause__
    return isinstance(error, KeyboardInterrupt)


class _Pool(Protocol):
    """Where batches are computed."""

    cores: int
    ahead: int
    serving: float

    def submit(self, arguments: list[tuple]) -> Any:
        """Begin a batch and return its future."""

    def finished(self, running: dict) -> list[tuple[Any, Any]]:
        """Return at least one finished future with its outcome, None where its worker was lost."""


@contextmanager
def _pool(work: Work, items: int) -> Iterator[_Pool]:
    """Give the pool of the scheduler in force."""
    client = active_client()
    pool = _Here(work, items) if client is None else _Cluster(client, work)
    try:
        yield pool
    finally:
        pool.close()


class _Here:
    """Threads, processes, or this thread alone, in the number that dask's local schedulers use.

    A single item is computed in this thread: to start processes takes seconds.
    """

    serving = _SERVED_HERE

    def __init__(self, work: Work, items: int):
        self.work, self.get = work, dask.base.get_scheduler() if items > 1 else dask.local.get_sync
        alone = self.get is dask.local.get_sync
        self.cores = 1 if alone else dask.config.get("num_workers", None) or dask.system.CPU_COUNT
        self.ahead = 1 if alone else _AHEAD * self.cores
        self._open()

    def _open(self) -> None:
        if self.get is dask.local.get_sync:
            self.executor = SynchronousExecutor()
        elif self.get is dask.multiprocessing.get:
            self.executor = workers.Pool(self.cores)
        else:
            self.executor = futures.ThreadPoolExecutor(self.cores)

    def submit(self, arguments: list[tuple]) -> futures.Future:
        """Begin a batch and return its future."""
        try:
            return self.executor.submit(_attempt, self.work.task, arguments, self.work.dtype, *self.work.shared)
        except BrokenProcessPool as error:
            broken = futures.Future()
            broken.set_exception(error)
            return broken

    def finished(self, running: dict) -> list[tuple[futures.Future, Any]]:
        """Wait for a batch; where a process died, begin with new ones once all that it took along are told."""
        done = futures.wait(running, return_when=futures.FIRST_COMPLETED).done
        if any(_is_lost(future) for future in done):
            done = futures.wait(running).done
            self.close()
            self._open()
        return [(future, None if _is_lost(future) else future.result()) for future in done]

    def close(self) -> None:
        """Let go of what has not begun, and wait for what has."""
        self.executor.shutdown(cancel_futures=True)


def _is_lost(future: futures.Future) -> bool:
    return isinstance(future.exception(), BrokenProcessPool)


class _Cluster:
    """The workers of an active client; what all batches share is sent to them once."""

    serving = _SERVED_FAR

    def __init__(self, client: Any, work: Work):
        from distributed import as_completed

        self.client, self.work, self.begun, self.asked = client, work, 0, -np.inf
        self.completed = as_completed(with_results=True, raise_errors=False)
        self._share()

    def _share(self) -> None:
        try:
            self.shared = self.client.scatter(list(self.work.shared), broadcast=True, hash=False)
        except Exception as error:
            raise RuntimeError(
                f"{self.client.scheduler.address}: nothing can be sent to its workers ({error}): "
                "expected at least one 'dask worker', where roughxr is installed as here"
            ) from error

    @property
    def cores(self) -> int:
        """Threads of all workers, which may come and go; asking takes as long as serving a batch."""
        if time.monotonic() > self.asked + _SECONDS:
            self.threads, self.asked = max(sum(self.client.nthreads().values()), 1), time.monotonic()
        return self.threads

    @property
    def ahead(self) -> int:
        """Batches to have sent."""
        return _AHEAD * self.cores

    def submit(self, arguments: list[tuple]) -> Any:
        """Begin a batch and return its future."""
        self.begun += 1
        options = {"pure": False, "priority": -self.begun}
        future = self.client.submit(_attempt, self.work.task, arguments, self.work.dtype, *self.shared, **options)
        self.completed.add(future)
        return future

    def finished(self, running: dict) -> list[tuple[Any, Any]]:
        """Wait for a batch; what was shared may have gone with a worker that was lost."""
        future, outcome = next(self.completed)
        if future.status != "finished":
            self._share()
            outcome = None
        return [(future, outcome)]

    def close(self) -> None:
        """Let go of what has not finished."""
        self.client.cancel([future for future in self.completed.futures])


def active_client() -> Any:
    """Return the active distributed client, or None; never imports distributed by itself."""
    if "distributed" not in sys.modules or dask.config.get("scheduler", None) not in (
        None,
        "dask.distributed",
    ):
        return None
    try:
        return sys.modules["distributed"].get_client()
    except ValueError:
        return None
