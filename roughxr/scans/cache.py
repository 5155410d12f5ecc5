"""A cache of what was computed from a scan's heights, so that nothing is computed twice from the same scan."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar

import dask.base
import numpy as np

_T = TypeVar("_T")

#: Results stored of each function. A run's surfaces are its scan, levelled and smoothed.
MOST_RESULTS = 6


def cached(function: Callable[..., _T]) -> Callable[..., _T]:
    """Return a function of heights and plain arguments, computed once for equal ones; results must stay unchanged."""
    results: dict[tuple[str, str], _T] = {}

    @functools.wraps(function)
    def stored(height: np.ndarray, *arguments: Any) -> _T:
        # as it lies in memory, dask takes a square array and its transpose for the same
        key = dask.base.tokenize(np.ascontiguousarray(height)), repr(arguments)
        if (result := results.get(key)) is None:
            result = results[key] = function(height, *arguments)
            while len(results) > MOST_RESULTS:
                results.pop(next(iter(results)), None)
        return result

    return stored
