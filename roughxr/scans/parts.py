"""Rectangles of a lazy scan as dask tasks that share its chunks: each is made once, wherever it is wanted."""

from __future__ import annotations

from collections.abc import Callable
from itertools import accumulate, pairwise
from typing import Any

import dask
import dask.array as da
import numpy as np
from dask.graph_manipulation import clone


def taker(height: da.Array, *, apart: bool = False) -> Callable[[tuple[slice, slice]], Any]:
    """Return a function that gives the heights of a rectangle as a task."""
    blocks = (clone(height) if apart else height).to_delayed()
    bounds = [list(pairwise((0, *accumulate(sizes)))) for sizes in height.chunks]
    join = dask.delayed(_joined, pure=False)

    def take(part: tuple[slice, slice]) -> Any:
        rows, columns = (
            [
                (k, *_within(bound, wanted))
                for k, bound in enumerate(each)
                if bound[0] < wanted.stop and wanted.start < bound[1]
            ]
            for each, wanted in zip(bounds, part)
        )
        pieces = [[(blocks[i, j], a, b, c, d) for j, c, d in columns] for i, a, b in rows]
        return join(pieces)

    return take


def _within(bound: tuple[int, int], wanted: slice) -> tuple[int, int]:
    """Return where a chunk's wanted part begins and ends, counted from the chunk's own first pixel."""
    return max(wanted.start - bound[0], 0), min(wanted.stop, bound[1]) - bound[0]


def _joined(pieces: list[list[tuple]]) -> np.ndarray:
    return np.block([[np.asarray(block)[a:b, c:d] for block, a, b, c, d in row] for row in pieces])
