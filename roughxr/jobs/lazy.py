"""Many independent tasks as one array, lazy or computed at once, on any dask scheduler."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from typing import Any, Protocol

import dask
import dask.array as da
import dask.callbacks
import numpy as np
import xarray as xr

from .executor import Failure, active_client, each_finished
from .progress import Progress
from .work import Work, in_memory, run_batch, stacked, without_views

#: Batches that many tasks are bundled into at most: a scheduler spends about a millisecond on each.
_MOST_BATCHES = 256

#: Begins the keys of batches in a graph, whose third part says how many subregions they hold.
_KEY = "subregions"


class Keeper(Protocol):
    """What may stand in for the lazy array: it computes the work its own way, such as with checkpoints."""

    def array(self, work: Work) -> Any:
        """Return the stacked results, a NumPy or dask array along items."""

    def finish(self, ds: xr.Dataset) -> xr.Dataset:
        """Return a labelled result ready for use."""


_KEEPER: ContextVar[Keeper | None] = ContextVar("keeper", default=None)


@contextmanager
def kept_by(keeper: Keeper) -> Iterator[None]:
    """Let ``keeper`` compute the results of all solves within the block."""
    token = _KEEPER.set(keeper)
    try:
        yield
    finally:
        _KEEPER.reset(token)


def is_lazy(ds: xr.Dataset) -> bool:
    """Say whether any variable of ``ds`` is a dask array."""
    return bool(ds.chunks)


def spread(
    task: Callable[..., np.ndarray],
    arguments: Sequence[tuple],
    dtype: Any,
    *shared: Any,
    cost: Callable[[], np.ndarray] | None = None,
    each: int = 1,
    lazy: bool = True,
    progress: bool = False,
) -> Any:
    """Return the stack of ``task(*arguments[k], *shared)``, each of the given type.

    Parameters
    ----------
    task : callable
        Defined at the top of a module, so that other processes can import it.
    arguments : sequence of tuple
        One per item; dask arrays among them are computed first. Views of one array travel as that array, once.
    dtype : dtype or tuple of int
        Of what one task returns: a record of a structured dtype, an array such as ``np.dtype((record, (3, 4)))``, or
        the shape of an array of float64.
    *shared
        What all tasks get, sent once.
    cost : callable, optional
        Returns what each item costs, in any unit: a run begins with the dearest, so that its tail is short.
    each : int
        Subregions in one item, for the report of progress.
    lazy : bool
        Leave it to be computed; else compute it now, so that labels and slices cost no tasks of their own: on
        small solves they would double the time.
    progress : bool
        Tell of it while it is computed now.

    Returns
    -------
    dask.array.Array or ndarray
        Results along items, in chunks of one batch where it is lazy; what `kept_by` puts in its place, where that is
        in force.
    """
    arguments, shared = without_views(arguments, shared)
    dtype = dtype if isinstance(dtype, np.dtype) else np.dtype((float, dtype))
    work = Work(task, arguments, dtype, shared, cost, each)
    if (keeper := _KEEPER.get()) is not None:
        return keeper.array(work)
    return _lazy(work) if lazy else _now(in_memory(work), progress)


def _now(work: Work, progress: bool) -> np.ndarray:
    results = np.empty(len(work.arguments), work.dtype)
    bar = Progress(len(work.arguments) * work.each, stream=sys.stderr if progress else None)

    def receive(batch: range, result: Any) -> None:
        if isinstance(result, Failure):
            raise result.error
        results[batch.start : batch.stop] = result
        bar.add(len(batch) * work.each)

    try:
        each_finished(work, range(len(work.arguments)), receive)
    finally:
        bar.close()
    return results


def _lazy(work: Work) -> da.Array:
    shared = [dask.delayed(value, pure=False, traverse=False) for value in work.shared]
    parts = []
    for items in work.batches(_MOST_BATCHES):
        name = f"{_KEY}-{dask.base.tokenize(object())}-{len(items) * work.each}"
        parts.append((_batch(work, items)(*shared, dask_key_name=name), len(items)))
    return stacked(parts, work.dtype)


def _batch(work: Work, items: range) -> Any:
    """Return the delayed call of one batch, its arguments searched by dask only if there are dask arrays among them."""
    arguments = [work.arguments[k] for k in items]
    if any(dask.is_dask_collection(value) for item in arguments for value in item):
        return partial(dask.delayed(run_batch, pure=False), work.task, arguments, work.dtype)
    return dask.delayed(partial(run_batch, work.task, arguments, work.dtype), pure=False, traverse=False)


def finish(ds: xr.Dataset, *, lazy: bool, progress: bool = False) -> xr.Dataset:
    """Return ``ds`` as it is where its input was lazy, computed where it was not."""
    keeper = _KEEPER.get()
    if keeper is not None:
        return keeper.finish(ds)
    return ds if lazy else compute(ds, progress=progress)


def compute(ds: xr.Dataset, *, progress: bool = True) -> xr.Dataset:
    """Compute a lazy Dataset, with progress by finished subregions on whichever scheduler is in force.

    Parameters
    ----------
    ds : Dataset
    progress : bool
        Tell on standard error how many subregions are finished, how fast, and how long it still takes: as a bar
        on a terminal, as a line from time to time elsewhere. The same on all of dask's schedulers: synchronous,
        threads, processes and ``dask.distributed``.

    Returns
    -------
    Dataset
        With NumPy arrays.
    """
    sizes = {key: int(key.rsplit("-", 1)[1]) for key in _batch_keys(ds)}
    if not progress or not sizes:
        return ds.compute()
    bar = Progress(sum(sizes.values()), stream=sys.stderr)
    try:
        if (client := active_client()) is None:
            with dask.callbacks.Callback(posttask=lambda key, *_: bar.add(sizes.get(key, 0))):
                return ds.compute(optimize_graph=False)  # fused batches would lose their names
        return _computed_on(client, ds, sizes, bar)
    finally:
        bar.close()


def _batch_keys(ds: xr.Dataset) -> list[str]:
    graph = ds.__dask_graph__() or {}
    return [key for key in graph if isinstance(key, str) and key.startswith(f"{_KEY}-")]


def _computed_on(client: Any, ds: xr.Dataset, sizes: dict[str, int], bar: Progress) -> xr.Dataset:
    """Compute on a cluster: first the batches, counted as they come, then what is made of them."""
    from dask.delayed import Delayed
    from distributed import as_completed

    graph = ds.__dask_graph__()
    batches = client.persist([Delayed(key, graph) for key in sizes], optimize_graph=False)
    futures = [future for batch in batches for future in client.futures_of(batch)]
    for future in as_completed(futures):
        bar.add(sizes.get(future.key, 0), failed=future.status != "finished")
    return ds.compute(optimize_graph=False)
