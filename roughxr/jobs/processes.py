"""A pool of worker processes in which a death never goes unnoticed, nor that of the process they work for.

Python's own pool ends with `BrokenProcessPool` when a worker dies, but for one moment: killed while it sends a result,
a worker leaves half a message behind, for whose other half the pool would wait for ever. Here a thread looks after the
workers, and where one has died and the pool does not notice, ends the pool so that it does. A thread in each worker
ends it when the process is killed that it works for: it would wait for the next task for ever.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import dask
import dask.multiprocessing

#: How often the workers are looked at, and how long the pool has to notice a death by itself, s.
_EVERY, _GRACE = 0.5, 2.0


class Pool(ProcessPoolExecutor):
    """A pool like the one that dask makes for its scheduler of processes, under watch.

    Parameters
    ----------
    processes : int

    Raises
    ------
    concurrent.futures.process.BrokenProcessPool
        From every future that is not done when a worker dies.
    """

    def __init__(self, processes: int):
        super().__init__(
            processes,
            mp_context=dask.multiprocessing.get_context(),
            initializer=partial(_begin, dask.config.get("multiprocessing.initializer", None)),
        )
        self._done = threading.Event()
        threading.Thread(target=_watch, args=(self, self._done), daemon=True).start()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the workers, and then the watch."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        self._done.set()


def _begin(user_initializer: Callable[[], None] | None) -> None:
    """Make ready a worker, as dask does."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    dask.multiprocessing.initialize_worker_process(user_initializer=user_initializer)


def _end_with_parent() -> None:
    multiprocessing.parent_process().join()
    os._exit(1)


def _watch(executor: ProcessPoolExecutor, done: threading.Event) -> None:
    """End a pool that has not noticed the death of a worker."""
    while not done.wait(_EVERY):
        # private, but the same from Python 3.9 to 3.14, and without them all is as it is without a watch
        workers = list((getattr(executor, "_processes", None) or {}).values())
        if all(worker.exitcode in (None, 0) for worker in workers) or done.wait(_GRACE):
            continue
        if not getattr(executor, "_broken", True):
            _end(executor, workers)
        return


def _end(executor: ProcessPoolExecutor, workers: list) -> None:
    """Close all ends of the pipe on which the pool waits: those of the workers and its own."""
    for worker in workers:
        with contextlib.suppress(Exception):
            worker.kill()
    with contextlib.suppress(Exception):
        executor._result_queue._writer.close()
