"""The one call through which solves have their tasks computed: now, later as a dask array, or by a checkpointed run."""

from __future__ import annotations

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
from dask.delayed import Delayed

from ..vocabulary.verbs import verb
from .executor import Failure, each_finished
from .progress import Progress, is_shown
from .schedulers import active_client
from .work import Work, in_memory, run_batch, stacked, without_views

#: Largest number of batches into which tasks are bundled: a scheduler spends about a millisecond on each.
_MOST_BATCHES = 256

#: Name of the annotation that tells how many subregions a batch of the graph holds.
_SUBREGIONS = "subregions"


class Executor(Protocol):
    """Computes the tasks of all solves, and decides where their results are kept."""

    def array(self, work: Work) -> Any:
        """Return the results, a NumPy or dask array along items."""

    def finish(self, ds: xr.Dataset) -> xr.Dataset:
        """Return a labelled result that is ready for use."""


_EXECUTOR: ContextVar[Executor | None] = ContextVar("executor", default=None)


@contextmanager
def computed_by(executor: Executor) -> Iterator[None]:
    """Let ``executor`` compute the tasks of all solves within the block, for example with checkpoints."""
    token = _EXECUTOR.set(executor)
    try:
        yield
    finally:
        _EXECUTOR.reset(token)


def is_lazy(ds: xr.Dataset) -> bool:
    """Return whether any variable of ``ds`` is a dask array."""
    return bool(ds.chunks)


def spread(
    task: Callable[..., np.ndarray],
    arguments: Sequence[tuple],
    dtype: Any,
    *shared: Any,
    cost: Callable[[], np.ndarray] | None = None,
    each: int = 1,
    name: str = "solve",
    lazy: bool = True,
) -> Any:
    """Return the stacked results of ``task(*arguments[k], *shared)``: an array, lazy in chunks of one batch.

    ``task`` is at the top of a module, for other processes to import; ``dtype`` is the type of a record, or the
    shape of a float64 result; ``cost`` orders the items, the most expensive first; ``each`` counts the subregions of an
    item. Small solves are computed at once (``lazy=False``): tasks for labels and slices would double their time.
    """
    arguments, shared = without_views(arguments, shared)
    dtype = dtype if isinstance(dtype, np.dtype) else np.dtype((float, dtype))
    work = Work(task, arguments, dtype, shared, cost, each, name)
    if (executor := _EXECUTOR.get()) is not None:
        return executor.array(work)
    return _lazy(work) if lazy else _now(in_memory(work))


def _now(work: Work) -> np.ndarray:
    results = np.empty(len(work.arguments), work.dtype)

    def receive(batch: range, result: Any) -> None:
        if isinstance(result, Failure):
            raise result.error
        results[batch.start : batch.stop] = result

    each_finished(work, range(len(work.arguments)), receive)
    return results


def _lazy(work: Work) -> da.Array:
    shared = [dask.delayed(value, pure=False, traverse=False) for value in work.shared]
    return stacked([(_batch(work, items, shared), len(items)) for items in work.batches(_MOST_BATCHES)], work.dtype)


def _batch(work: Work, items: range, shared: list) -> Delayed:
    """Return the delayed results of one batch, annotated with its number of subregions."""
    arguments = [work.arguments[k] for k in items]
    if any(dask.is_dask_collection(value) for item in arguments for value in item):
        batch = dask.delayed(run_batch, pure=False)(work.task, arguments, work.dtype, *shared)
    else:  # else dask would search the arguments for collections
        bound = partial(run_batch, work.task, arguments, work.dtype)
        batch = dask.delayed(bound, pure=False, traverse=False)(*shared)
    layers = batch.__dask_graph__().layers
    layers[batch.__dask_layers__()[0]].annotations = {_SUBREGIONS: len(items) * work.each}
    return batch


def finish(ds: xr.Dataset, *, lazy: bool) -> xr.Dataset:
    """Return ``ds`` as it is where its input was lazy, computed where it was not."""
    if (executor := _EXECUTOR.get()) is not None:
        return executor.finish(ds)
    return ds if lazy else compute(ds)


@verb
def compute(ds: xr.Dataset) -> xr.Dataset:
    """Compute a lazy Dataset on any of dask's schedulers; within `progress`, with a count of finished subregions.

    Parameters
    ----------
    ds : Dataset

    Returns
    -------
    Dataset
        With NumPy arrays.

    Examples
    --------
    >>> from roughxr import assign_pair, direct
    >>> from roughxr.scans import synthetic
    >>> scan = synthetic.self_affine((16, 16), 10, rms=1, hurst=0.8, rolloff=80, seed=1)
    >>> scan = assign_pair(scan, sphere_radius=500, contact_modulus=40)
    >>> later = direct(scan.chunk(x=8), delta=[1.0, 2.0])
    >>> bool(later.chunks), bool(compute(later).chunks)
    (True, False)
    """
    counts = _subregions_of(ds)
    if not counts or not is_shown():
        return ds.compute()
    bar = Progress(sum(counts.values()))
    try:
        if (client := active_client()) is None:
            with dask.callbacks.Callback(posttask=lambda key, *_: bar.add(counts.get(key, 0))):
                return ds.compute(optimize_graph=False)  # fused batches would lose their keys
        return _computed_on(client, ds, counts, bar)
    finally:
        bar.close()


def _subregions_of(ds: xr.Dataset) -> dict[str, int]:
    """Return how many subregions each batch of a lazy Dataset holds, by the batch's key."""
    layers = getattr(ds.__dask_graph__(), "layers", {}).values()
    counted = ((key, layer.annotations) for layer in layers if layer.annotations for key in layer)
    return {key: found[_SUBREGIONS] for key, found in counted if _SUBREGIONS in found}


def _computed_on(client: Any, ds: xr.Dataset, counts: dict[str, int], bar: Progress) -> xr.Dataset:
    """Compute on a cluster: first the batches, counted as they finish, then the rest of the graph."""
    from distributed import as_completed

    graph = ds.__dask_graph__()
    batches = client.persist([Delayed(key, graph) for key in counts], optimize_graph=False)
    futures = [future for batch in batches for future in client.futures_of(batch)]
    for future in as_completed(futures):
        bar.add(counts.get(future.key, 0), failed=future.status != "finished")
    return ds.compute(optimize_graph=False)
