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

#: Answers kept for each question, those asked for last. A run's surfaces are its scan, levelled and smoothed.
KEPT = 6


def once(function: Callable[..., _T]) -> Callable[..., _T]:
    """Return a function of heights and plain arguments, computed once for equal ones; its result is not to change."""
    kept: OrderedDict[tuple, Any] = OrderedDict()
    lock = threading.Lock()

    @functools.wraps(function)
    def asked(height: np.ndarray, *arguments: Any) -> _T:
        key = _digest(height), repr(arguments)
        with lock:
            if key in kept:
                kept.move_to_end(key)
                return kept[key]
        answer = function(height, *arguments)
        with lock:
            kept[key] = answer
            while len(kept) > KEPT:
                kept.popitem(last=False)
        return answer

    return asked


def _digest(height: np.ndarray) -> str:
    """Return what tells these heights from any others."""
    height = np.asarray(height)
    digest = hashlib.blake2b(f"{height.shape} {height.dtype}".encode(), digest_size=16)
    digest.update(np.ascontiguousarray(height).data)
    return digest.hexdigest()
