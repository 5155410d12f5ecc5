"""A pool of worker processes in which a death never goes unnoticed.

Python's own pool ends with `BrokenProcessPool` when a worker dies, but for one moment: killed while it sends a result,
a worker leaves half a message behind, for whose other half the pool would wait for ever. Here a thread looks after the
workers, and where one has died and the pool does not notice, ends the pool so that it does.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial

import dask
import dask.multiprocessing

#: How often the workers are looked at, and how long the pool has to notice a death by itself, s.
_EVERY, _GRACE = 0.5, 2.0


@contextmanager
def pool() -> Iterator[ProcessPoolExecutor]:
    """Give a pool like the one that dask makes for its scheduler of processes, under watch.

    Yields
    ------
    ProcessPoolExecutor
        For `dask.multiprocessing.get`; raises ``BrokenProcessPool`` when a worker has died.
    """
    initializer = dask.config.get("multiprocessing.initializer", None)
    executor = ProcessPoolExecutor(
        dask.config.get("num_workers", None) or dask.multiprocessing.CPU_COUNT,
        mp_context=dask.multiprocessing.get_context(),
        initializer=partial(dask.multiprocessing.initialize_worker_process, user_initializer=initializer),
    )
    done = threading.Event()
    threading.Thread(target=_watch, args=(executor, done), daemon=True).start()
    try:
        yield executor
    finally:
        executor.shutdown(cancel_futures=True)
        done.set()


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
