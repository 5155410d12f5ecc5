"""A cache of results computed from a scan's heights."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar

import dask.base
import numpy as np

_T = TypeVar("_T")

#: Number of results stored of each function: a run's surfaces are its scan, levelled and smoothed.
MOST_RESULTS = 6


def cached(function: Callable[..., _T]) -> Callable[..., _T]:
    """Cache a function of heights and plain arguments; results must not be changed."""
    results: dict[tuple[str, str], _T] = {}

    @functools.wraps(function)
    def stored(height: np.ndarray, *arguments: Any) -> _T:
        # contiguous, since dask gives a square array and its transpose equal keys
        key = dask.base.tokenize(np.ascontiguousarray(height)), repr(arguments)
        if (result := results.get(key)) is None:
            result = results[key] = function(height, *arguments)
            while len(results) > MOST_RESULTS:
                results.pop(next(iter(results)), None)
        return result

    return stored
