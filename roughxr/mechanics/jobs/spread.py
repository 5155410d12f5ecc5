"""Parallel computation of independent tasks on dask's schedulers: plain arrays in, one array of results out.

A task solves one subregion, or a fixed number of small ones. Its function is serial, and uses no files and no labelled
arrays. Tasks are computed at once, later as a dask array, or by a checkpointed run. The scheduler is the active
``distributed.Client``, which retries lost tasks itself, else the one that dask is configured for, else threads.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from functools import partial
from typing import Any, NamedTuple

import dask
import dask.array as da
import dask.callbacks
import dask.multiprocessing
import dask.threaded
import numpy as np
import xarray as xr
from dask.base import get_scheduler
from dask.delayed import Delayed
from dask.system import CPU_COUNT

from ..vocabulary.refusal import Refusal
from ..vocabulary.text import warn
from .interrupts import is_interrupt
from .progress import subregion_bar

#: Time (s) without a result after which workers are counted.
_PATIENCE = 15.0

#: Time (s) between two looks for results.
_POLL = 0.02

_LOCAL = ("threads", "processes", "synchronous")


def _forget_threads() -> None:
    """Let a forked process start threads of its own: those of dask's pool ended with the fork."""
    dask.threaded.default_pool = None
    dask.threaded.pools.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_threads)


class Tasks(NamedTuple):
    """Many independent tasks ``task(*arguments[k], *shared)``, each returning an array of one type."""

    task: Callable[..., np.ndarray]  # at the top of a module, so that other processes can import it
    arguments: Sequence[tuple]  # one per item
    dtype: np.dtype  # of the result of one task: a record, or a subarray as in ``np.dtype((float, (3, 4)))``
    shared: tuple  # further arguments, the same for all tasks
    each: int = 1  # subregions in one item
    name: str = "solve"  # in logs and messages

    def batches(self, items: Sequence[Any]) -> list[Sequence[Any]]:
        """Return items in batches of a fixed size."""
        # largest number of batches into which tasks are bundled: a scheduler spends about a millisecond on each
        size = -(-len(self.arguments) // 256)
        return [items[k : k + size] for k in range(0, len(items), size)]


class Failure(NamedTuple):
    """The result of a batch that failed."""

    error: Exception

    @property
    def reason(self) -> str:
        """The error in one line."""
        return f"{type(self.error).__name__}: {self.error}"


#: The object that computes the tasks of a checkpointed run, with methods ``array(work)`` and ``finish(ds)``.
_EXECUTOR: ContextVar[Any] = ContextVar("executor", default=None)


@contextmanager
def compute_with(executor: Any) -> Iterator[None]:
    """Compute the tasks of all solves within the block by ``executor``, for example with checkpoints."""
    token = _EXECUTOR.set(executor)
    try:
        yield
    finally:
        _EXECUTOR.reset(token)


def is_lazy(ds: xr.Dataset) -> bool:
    """Return whether any variable of ``ds`` is a dask array."""
    return bool(ds.chunks)


def task_results(
    task: Callable[..., np.ndarray],
    arguments: Sequence[tuple],
    dtype: Any,
    *shared: Any,
    each: int = 1,
    name: str = "solve",
    lazy: bool = False,
) -> Any:
    """Return the stacked results of ``task(*arguments[k], *shared)``: an array, or lazy in chunks of one batch.

    ``task`` is at the top of a module, for other processes to import; ``dtype`` is the type of a record, or the
    shape of a float64 result; ``each`` counts the subregions of an item.
    """
    dtype = dtype if isinstance(dtype, np.dtype) else np.dtype((float, dtype))
    work = Tasks(task, arguments, dtype, shared, each, name)
    if (executor := _EXECUTOR.get()) is not None:
        return executor.array(work)
    if lazy:
        items = work.batches(range(len(arguments)))
        return concatenate(list(zip(_delayed(work, items, _batch_results), map(len, items))), dtype)
    results = np.empty(len(arguments), dtype)

    def receive(items: Sequence[int], result: Any) -> None:
        if isinstance(result, Failure):
            raise result.error
        results[items] = result

    compute_each(work, range(len(arguments)), receive)
    return results


def finish(ds: xr.Dataset) -> xr.Dataset:
    """Return a labelled result, within a checkpointed run with its scalars in memory."""
    executor = _EXECUTOR.get()
    return ds if executor is None else executor.finish(ds)


def concatenate(batches: Sequence[tuple[Any, int]], dtype: np.dtype) -> da.Array:
    """Return one lazy array of delayed batches, each given with its number of results."""
    return da.concatenate([da.from_delayed(batch, (count, *dtype.shape), dtype=dtype.base) for batch, count in batches])


def compute_each(work: Tasks, items: Sequence[int], receive: Callable[[Sequence[int], Any], None]) -> None:
    """Compute items on the active scheduler; call ``receive(items, result)`` in this thread as each batch finishes."""
    total, remaining = (work.each * n for n in (len(work.arguments), len(items)))
    batches = work.batches(items)
    with subregion_bar(total, done=total - remaining, label=work.name) as bar:

        def finished(batch: Sequence[int], result: Any) -> None:
            receive(batch, result)
            bar.update(work.each * len(batch))

        if (client := active_client()) is not None:
            _compute_on(client, _delayed(work, batches, _attempt), batches, finished)
        else:
            _compute_locally(work, batches, finished)


def _compute_locally(work: Tasks, batches: Sequence[Sequence[int]], finished: Callable) -> None:
    """Compute batches as plain tasks, which cost a local scheduler a sixth of the time of delayed ones."""
    get = get_scheduler() or dask.threaded.get
    # bytes of results that a local scheduler keeps in memory at once: it returns them together
    at_once = max((2**28) // max(work.dtype.itemsize, 1), 1)
    with dask.callbacks.Callback(posttask=lambda key, result, *_: finished(batches[key], result)):
        for first in range(0, len(batches), at_once):
            arguments = {k: [work.arguments[m] for m in batches[k]] for k in range(len(batches))[first:][:at_once]}
            tasks = {k: (partial(_attempt, work.task, a, work.dtype, *work.shared),) for k, a in arguments.items()}
            get(tasks, list(tasks))


def _compute_on(client: Any, tasks: list[Delayed], batches: Sequence[Sequence[int]], finished: Callable) -> None:
    _expect_workers(client)
    # each window of the scan is sent once, with its task: scattered instead, it would be lost with a worker
    with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TB"}):
        # how often a cluster computes a lost batch again
        futures = client.compute(tasks, traverse=False, optimize_graph=False, retries=3)
    batch_of = dict(zip((future.key for future in futures), batches))
    try:
        for future, result in _as_completed(client, futures):
            finished(batch_of[future.key], result)
            future.release()
    finally:
        client.cancel([future for future in futures if not future.done()])


def _as_completed(client: Any, futures: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
    """Yield futures and their results (or failures) as they finish; say so while they wait without workers."""
    # with results: one that is lost with its worker before it is fetched is waited for here, not in silence
    completed = sys.modules["distributed"].as_completed(futures, with_results=True, raise_errors=False)
    last = time.monotonic()
    while completed.count():
        if completed.has_ready():
            future, result = next(completed)
            if future.status == "error":  # such as a worker that was killed at every attempt
                result = Failure(result[1])
            elif future.status == "cancelled":
                result = Failure(result)
            yield future, result
        elif time.monotonic() - last < _PATIENCE:
            time.sleep(_POLL)
            continue
        elif not client.scheduler_info()["workers"]:
            warn(
                f"{client.scheduler.address}: no worker is left; the run waits for one (dask worker "
                f"{client.scheduler.address}), or interrupt it: finished places are kept"
            )
        last = time.monotonic()


def _expect_workers(client: Any) -> None:
    try:
        client.wait_for_workers(1, timeout=dask.config.get("distributed.comm.timeouts.connect"))
    except Exception as error:
        raise ConnectionError(
            f"{client.scheduler.address}: its workers cannot be used ({error}): "
            "expected at least one 'dask worker' with the same roughxr installed"
        ) from error


def _delayed(work: Tasks, batches: Sequence[Sequence[int]], function: Callable) -> list[Delayed]:
    """Return each batch as a delayed value."""
    shared = [dask.delayed(value, pure=False, traverse=False) for value in work.shared]
    arguments = ([work.arguments[k] for k in items] for items in batches)
    functions = (partial(function, work.task, values, work.dtype) for values in arguments)  # not searched by dask
    return [dask.delayed(bound, pure=False, traverse=False)(*shared) for bound in functions]


def _batch_results(task: Callable[..., np.ndarray], arguments: list[tuple], dtype: np.dtype, *shared: Any):
    """Return the stacked results of one batch; arrays are contiguous, as in other processes, for equal results."""
    out = np.empty(len(arguments), dtype)
    for k, items in enumerate(arguments):
        result = task(*map(contiguous, items), *shared)
        if (result.dtype, result.shape) != (dtype.base, dtype.shape):
            raise TypeError(f"expected a result of {dtype}, found one of {np.dtype((result.dtype, result.shape))}")
        out[k] = result
    return out


def contiguous(value: Any) -> Any:
    """Return an array, or the arrays of a record, in C order; any other value unchanged."""
    if isinstance(value, tuple) and hasattr(value, "_make"):
        return value._make(map(contiguous, value))
    return np.ascontiguousarray(value) if isinstance(value, np.ndarray) and value.ndim else value


def _attempt(*arguments: Any) -> Any:
    """Return the results of one batch, or its failure."""
    try:
        return _batch_results(*arguments)
    except Exception as error:
        if is_interrupt(error):
            raise KeyboardInterrupt from error
        return Failure(error)


def active_client() -> Any:
    """Return the active distributed client, or None; never imports distributed itself."""
    if "distributed" not in sys.modules or dask.config.get("scheduler", None) not in (None, "dask.distributed"):
        return None
    try:
        return sys.modules["distributed"].get_client()
    except ValueError:
        return None


@contextmanager
def _on_processes() -> Iterator[None]:
    """Compute on the same processes within a block; dask would start others for each result, which takes seconds."""
    workers = dask.config.get("num_workers", None) or CPU_COUNT
    end_at_interrupt = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # without a traceback
    pool = ProcessPoolExecutor(workers, dask.multiprocessing.get_context(), end_at_interrupt)
    with pool, dask.config.set(scheduler=partial(dask.multiprocessing.get, pool=pool)):
        yield


def use_scheduler(scheduler: str | None) -> Any:
    """Compute on a scheduler, by name or address, within a block; None keeps the active one."""
    if scheduler is None and (dask.config.get("scheduler", None) or "distributed" in sys.modules):
        return nullcontext()
    if scheduler is None:
        return dask.config.set(scheduler=dask.threaded.get)  # else dask imports distributed to ask for a client
    if scheduler == "processes":
        return _on_processes()
    if scheduler in _LOCAL:
        return dask.config.set(scheduler=scheduler)
    if ":" not in scheduler:
        raise Refusal(
            "scheduler", f"{', '.join(map(repr, _LOCAL))} or an address such as 'tcp://node1:8786'", f"{scheduler!r}"
        )
    try:
        import distributed
    except ImportError:
        raise ImportError("a scheduler's address needs dask.distributed: pip install distributed") from None
    try:
        return distributed.Client(scheduler)
    except (OSError, ValueError) as error:
        raise OSError(
            f"scheduler {scheduler!r}: could not be reached ({error}); "
            "start 'dask scheduler' and give the address that it prints"
        ) from error
