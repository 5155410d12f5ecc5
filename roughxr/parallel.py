"""Many independent tasks as one lazy array, and its computation with progress, on any dask scheduler.

Only dask runs things in parallel here; what a task calls is serial. A task gets plain arrays (or dask arrays
that become plain ones on the worker) and returns one plain array, so that workers need no file and no label.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

import dask
import dask.array as da
import numpy as np
import xarray as xr

#: Batches that many tasks are bundled into at most: a scheduler spends about a millisecond on each.
_MOST_BATCHES = 256


def is_lazy(ds: xr.Dataset) -> bool:
    """Say whether any variable of ``ds`` is a dask array."""
    return bool(ds.chunks)


def spread(
    task: Callable[..., np.ndarray], arguments: Sequence[tuple], shape: tuple[int, ...], *shared: Any
) -> da.Array:
    """Return the lazy stack of ``task(*arguments[k], *shared)``, each of the given shape.

    Parameters
    ----------
    task : callable
        Defined at the top of a module, so that other processes can import it.
    arguments : sequence of tuple
        One per item; dask arrays among them are computed first.
    shape : tuple of int
        Of what one task returns, float64.
    *shared
        What all tasks get, sent once.

    Returns
    -------
    dask.array.Array
        (items, *shape), in chunks of one batch.
    """
    size = -(-len(arguments) // _MOST_BATCHES)
    shared = [dask.delayed(value, pure=False, traverse=False) for value in shared]
    run = dask.delayed(_batch, pure=False)
    batches = [arguments[k : k + size] for k in range(0, len(arguments), size)]
    parts = [da.from_delayed(run(task, list(b), *shared), (len(b), *shape), dtype=float) for b in batches]
    return da.concatenate(parts)


def _batch(task: Callable[..., np.ndarray], arguments: list[tuple], *shared: Any) -> np.ndarray:
    return np.stack([task(*items, *shared) for items in arguments])


def finish(ds: xr.Dataset, *, lazy: bool, progress: bool = False) -> xr.Dataset:
    """Return ``ds`` as it is where its input was lazy, computed where it was not."""
    return ds if lazy else compute(ds, progress=progress)


def compute(ds: xr.Dataset, *, progress: bool = True) -> xr.Dataset:
    """Compute a lazy Dataset, with a progress bar on whichever scheduler is in force.

    Parameters
    ----------
    ds : Dataset
    progress : bool
        Show a bar on standard error: dask's own for the local schedulers (synchronous, threads, processes),
        the cluster's for ``dask.distributed``.

    Returns
    -------
    Dataset
        With NumPy arrays.
    """
    client = _client()
    if not progress:
        return ds.compute()
    if client is None:
        from dask.diagnostics import ProgressBar

        with ProgressBar(out=sys.stderr, dt=0.1 if sys.stderr.isatty() else 10.0):
            return ds.compute()
    from distributed import progress as follow

    running = ds.persist()
    follow(running, notebook=False)
    return running.compute()


def _client() -> Any:
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
