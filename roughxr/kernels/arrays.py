"""Arrays that kernels fill, asked for in one way.

NumPy's own ``zeros``, ``full`` and their like are compiled anew for every type and every way of asking for it, some
0.1 s each time; here one function serves all lines of a type, and one all tables.
"""

import numpy as np

from .jit import kernel


@kernel(inner=True)
def line(size, value):
    """Return ``size`` times the value, in its type."""
    out = np.empty(size, type(value))
    for k in range(size):
        out[k] = value
    return out


@kernel(inner=True)
def table(rows, columns, value):
    """Return (rows, columns) times the value, in its type."""
    out = np.empty((rows, columns), type(value))
    for i in range(rows):
        for j in range(columns):
            out[i, j] = value
    return out
