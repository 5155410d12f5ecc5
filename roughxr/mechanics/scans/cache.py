"""A cache of results computed from a scan's heights."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar

import dask.base
import numpy as np

_T = TypeVar("_T")


def cached(function: Callable[..., _T]) -> Callable[..., _T]:
    """Cache a function of heights and plain arguments; results must not be changed."""
    results: dict[tuple[str, str], _T] = {}

    @functools.wraps(function)
    def stored(height: np.ndarray, *arguments: Any) -> _T:
        # contiguous, since dask gives a square array and its transpose equal keys
        key = dask.base.tokenize(np.ascontiguousarray(height)), repr(arguments)
        if (result := results.get(key)) is None:
            result = results[key] = function(height, *arguments)
            # number of results stored of each function: a run's surfaces are its scan, levelled and smoothed
            while len(results) > 6:
                results.pop(next(iter(results)), None)
        return result

    return stored
