"""Where tasks are computed: this thread, threads, worker processes of this machine, or a cluster."""

from __future__ import annotations

import logging
import sys
import time
import warnings
from collections.abc import Iterator
from concurrent import futures
from contextlib import contextmanager, nullcontext
from typing import Any, Protocol
from weakref import WeakSet

import dask
import dask.local
import dask.multiprocessing
import dask.system
import numpy as np
from dask.local import SynchronousExecutor

_LOCAL = ("threads", "processes", "synchronous")

#: Batches sent in advance for each thread or process: one to compute, and one to continue with.
_BATCHES_AHEAD = 2

#: How often a cluster is asked for its workers, which may come and go, s: asking takes as long as serving a batch.
_ASKING_INTERVAL = 0.5

#: Makes a worker process ignore Ctrl-C, which a terminal sends to all: the main process then ends it in good order.
_DEAF_TO_INTERRUPTS = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"


#: A task lost with its worker is reported at once, not retried as it was: it is sent again in smaller batches. And a
#: worker that dies is always restarted; by default a cluster gives up one that is away 15 s after an earlier death.
_PROCESS_CONFIG = {
    "distributed.scheduler.allowed-failures": 0,
    "distributed.deploy.lost-worker-timeout": "1000 days",
}

#: For a cluster of this machine: even without a dashboard, the scheduler's HTTP server asks for dask's usual port, and
#: a second cluster would warn that it is taken.
NO_DASHBOARD = {"dashboard_address": None, "scheduler_kwargs": {"dashboard_address": "127.0.0.1:0"}}


class Scheduler(Protocol):
    """Something that computes batches.

    The executor of distributed's own client, `Client.get_executor`, does not qualify: a future whose result is lost
    with its worker after it was reported as finished, and whose second try fails, never finishes there.
    """

    serving: float  # seconds that the main process takes to send a batch and receive its result

    @property
    def cores(self) -> int:
        """Number of threads that compute."""

    @property
    def ahead(self) -> int:
        """Number of batches to send in advance."""

    def submit(self, function: Any, *arguments: Any) -> Any:
        """Start ``function(*arguments, shared)`` and return its future."""

    def result(self, future: Any) -> Any:
        """Return the result of a finished future, None where it was lost with its worker."""

    def close(self) -> None:
        """Cancel what has not started."""


@contextmanager
def scheduler_for(shared: tuple, items: int) -> Iterator[Scheduler]:
    """Yield the active scheduler, to which the arguments that all tasks share are sent once.

    A single item is computed in this thread, since starting processes takes seconds.
    """
    client, get = active_client(), dask.base.get_scheduler() if items > 1 else dask.local.get_sync
    if client is None and get is dask.multiprocessing.get:
        with _worker_processes() as client, _closing(_Cluster(client, shared)) as cluster:
            yield cluster
    else:
        here = _Here(shared, get is dask.local.get_sync) if client is None else _Cluster(client, shared)
        with _closing(here):
            yield here


@contextmanager
def _closing(scheduler: Any) -> Iterator[Scheduler]:
    try:
        yield scheduler
    finally:
        scheduler.close()


class _Here:
    """A pool of threads, as many as dask's own scheduler uses, or this thread alone."""

    serving = 0.002

    def __init__(self, shared: tuple, alone: bool):
        self.shared, self.cores = shared, 1 if alone else _workers()
        self.ahead = 1 if alone else _BATCHES_AHEAD * self.cores
        self.executor: Any = SynchronousExecutor() if alone else futures.ThreadPoolExecutor(self.cores)

    def submit(self, function: Any, *arguments: Any) -> futures.Future:
        return self.executor.submit(function, *arguments, self.shared)

    def result(self, future: futures.Future) -> Any:
        return future.result()

    def close(self) -> None:
        """Cancel what has not started, and wait for the rest."""
        self.executor.shutdown(cancel_futures=True)


class _Cluster:
    """The workers of a client.

    Shared arguments are sent once to workers on other machines, and with each batch to those on this one, so that a
    lost worker takes nothing along that others need.
    """

    serving = 0.02

    def __init__(self, client: Any, shared: tuple):
        self.client, self.shared, self.count, self.asked = client, shared, 0, -np.inf
        self.near = isinstance(client.cluster, _distributed("a client needs").LocalCluster)
        self.begun: WeakSet = WeakSet()
        self._send = self._wait_for_a_worker if self.near else self._scatter
        self._send()

    def _wait_for_a_worker(self) -> None:
        with self._in_words():
            self.client.wait_for_workers(1, timeout=dask.config.get("distributed.comm.timeouts.connect"))

    def _scatter(self) -> None:
        with self._in_words():
            self.sent = self.client.scatter(self.shared, broadcast=True, hash=False)

    @contextmanager
    def _in_words(self) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            raise RuntimeError(
                f"{self.client.scheduler.address}: its workers cannot be used ({error}): "
                "expected at least one 'dask worker' with the same roughxr installed"
            ) from error

    @property
    def cores(self) -> int:
        """Number of threads of all workers."""
        if time.monotonic() > self.asked + _ASKING_INTERVAL:
            self.threads, self.asked = max(sum(self.client.nthreads().values()), 1), time.monotonic()
        return self.threads

    @property
    def ahead(self) -> int:
        return _BATCHES_AHEAD * self.cores

    def submit(self, function: Any, *arguments: Any) -> Any:
        self.count += 1
        options = {"pure": False, "priority": -self.count}
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            future = self.client.submit(function, *arguments, self.shared if self.near else self.sent, **options)
        self.begun.add(future)
        return future

    def result(self, future: Any) -> Any:
        """Return a future's result, fetched only now: it may be lost after the future was reported as finished."""
        try:
            return future.result()
        except Exception:
            self._send()  # the shared arguments may have gone with the worker
            return None

    def close(self) -> None:
        self.client.cancel(list(self.begun))


def _workers() -> int:
    return dask.config.get("num_workers", None) or dask.system.CPU_COUNT


def active_client() -> Any:
    """Return the active distributed client, or None; never imports distributed itself."""
    if "distributed" not in sys.modules or dask.config.get("scheduler", None) not in (None, "dask.distributed"):
        return None
    try:
        return sys.modules["distributed"].get_client()
    except ValueError:
        return None


def on(scheduler: str | None) -> Any:
    """Compute on a scheduler by name or address within a block; None keeps the active one. It must answer."""
    if scheduler is None:
        return nullcontext()
    if scheduler == "processes":
        return _worker_processes()
    if scheduler in _LOCAL:
        return dask.config.set(scheduler=scheduler)
    if ":" in scheduler:
        return _client(scheduler)
    raise ValueError(
        f"scheduler: expected {', '.join(map(repr, _LOCAL))} or an address such as 'tcp://node1:8786', "
        f"found {scheduler!r}"
    )


def _client(address: str) -> Any:
    distributed = _distributed("a scheduler's address needs")
    try:
        return distributed.Client(address)
    except (OSError, ValueError) as error:
        raise OSError(
            f"scheduler {address!r}: could not be reached ({error}); "
            "start 'dask scheduler' and give the address that it prints"
        ) from error


@contextmanager
def _worker_processes() -> Iterator[Any]:
    """Yield a client of worker processes on this machine; they end with this process, and restart when they die."""
    distributed = _distributed("worker processes need")
    with (
        dask.config.set(_PROCESS_CONFIG),
        _started(distributed.LocalCluster) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def _started(cluster: Any, tries: int = 3) -> Any:
    """Start worker processes, again if one dies before it is ready, which its nanny does not survive."""
    try:
        return cluster(
            n_workers=_workers(),
            threads_per_worker=1,
            memory_limit=None,
            silence_logs=logging.CRITICAL,
            preload=[_DEAF_TO_INTERRUPTS],
            **NO_DASHBOARD,
        )
    except RuntimeError:
        if tries == 1:
            raise
        return _started(cluster, tries - 1)


def _distributed(needed_by: str) -> Any:
    try:
        import distributed
    except ImportError:
        raise ImportError(f"{needed_by} dask.distributed: pip install distributed") from None
    return distributed
