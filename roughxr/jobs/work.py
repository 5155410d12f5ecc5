"""Many independent tasks, described so that they can be sent to other processes: plain arrays in, one plain array out.

Only dask runs anything in parallel; the function of a task is serial, and uses no files and no labels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import dask
import dask.array as da
import numpy as np


class Work(NamedTuple):
    """Many independent tasks ``task(*arguments[k], *shared)``, each returning an array of one type."""

    task: Callable[..., np.ndarray]  # at the top of a module, so that other processes can import it
    arguments: Sequence[tuple]  # one per item
    dtype: np.dtype  # of what one task returns: a record, or a subarray as in ``np.dtype((float, (3, 4)))``
    shared: tuple  # further arguments, the same for all tasks, sent once
    cost: Callable[[], np.ndarray] | None = None  # per item, in any unit: the most expensive are begun first
    each: int = 1  # subregions in one item
    name: str = "solve"  # in logs and messages

    def batches(self, most: int) -> list[range]:
        """Return the items in at most ``most`` batches of consecutive items."""
        size = max(-(-len(self.arguments) // most), 1)
        return [range(k, min(k + size, len(self.arguments))) for k in range(0, len(self.arguments), size)]


class _View(NamedTuple):
    """A part of the n-th of the arrays that are sent once."""

    n: int
    offset: int  # bytes
    shape: tuple[int, ...]
    strides: tuple[int, ...]


def without_views(arguments: Sequence[tuple], shared: tuple) -> tuple[list[tuple], tuple]:
    """Return the arguments with views replaced by ``_View``s, and the shared ones followed by the views' arrays."""
    owners: dict[int, tuple[int, np.ndarray]] = {}

    def described(value):
        owner = value.base if isinstance(value, np.ndarray) else None
        if not isinstance(owner, np.ndarray) or owner.dtype != value.dtype or not owner.flags.forc:
            return value
        n, _ = owners.setdefault(id(owner), (len(owners), owner))
        offset = value.__array_interface__["data"][0] - owner.__array_interface__["data"][0]
        return _View(n, offset, value.shape, value.strides)

    plain = [tuple(described(value) for value in items) for items in arguments]
    return plain, (*shared, [owner for _, owner in owners.values()])


def run_batch(task: Callable[..., np.ndarray], arguments: list[tuple], dtype: np.dtype, *shared: Any) -> np.ndarray:
    """Return the stacked results of one batch."""
    *given, owners = shared

    def restored(value):
        if not isinstance(value, _View):
            return value
        return np.ndarray(value.shape, owners[value.n].dtype, _buffer(owners[value.n]), value.offset, value.strides)

    out = np.empty(len(arguments), dtype)
    for k, items in enumerate(arguments):
        result = task(*map(restored, items), *given)
        if (result.dtype, result.shape) != (dtype.base, dtype.shape):
            raise TypeError(f"expected a result of {dtype}, found one of {np.dtype((result.dtype, result.shape))}")
        out[k] = result
    return out


def _buffer(owner: np.ndarray) -> np.ndarray:
    """Return the memory of an array that owns it as a flat array, in memory order."""
    return owner.ravel(order="K").view()


def in_memory(work: Work) -> Work:
    """Return a work whose dask arrays are computed; where there are none, dask's search for them is skipped."""
    if not any(dask.is_dask_collection(value) for values in (*work.arguments, work.shared) for value in values):
        return work
    arguments, shared = dask.compute(list(work.arguments), work.shared)
    return work._replace(arguments=arguments, shared=shared)


def stacked(batches: Sequence[tuple[Any, int]], dtype: np.dtype) -> da.Array:
    """Return one lazy array of delayed batches, given with the number of results in each."""
    return da.concatenate([da.from_delayed(batch, (count, *dtype.shape), dtype=dtype.base) for batch, count in batches])
