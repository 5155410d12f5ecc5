"""A cache of what was computed from a scan's heights, so that nothing is computed twice from the same scan."""

from __future__ import annotations

import functools
import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

_T = TypeVar("_T")

#: Results stored of each function, those last used. A run's surfaces are its scan, levelled and smoothed.
MOST_RESULTS = 6


def cached(function: Callable[..., _T]) -> Callable[..., _T]:
    """Return a function of heights and plain arguments, computed once for equal ones; results must stay unchanged."""
    results: OrderedDict[tuple, Any] = OrderedDict()
    lock = threading.Lock()

    @functools.wraps(function)
    def stored(height: np.ndarray, *arguments: Any) -> _T:
        key = _digest(height), repr(arguments)
        with lock:
            if key in results:
                results.move_to_end(key)
                return results[key]
        result = function(height, *arguments)
        with lock:
            results[key] = result
            while len(results) > MOST_RESULTS:
                results.popitem(last=False)
        return result

    return stored


def _digest(height: np.ndarray) -> str:
    """Return a hash of the heights, their shape and type."""
    height = np.asarray(height)
    digest = hashlib.blake2b(f"{height.shape} {height.dtype}".encode(), digest_size=16)
    digest.update(np.ascontiguousarray(height).data)
    return digest.hexdigest()
