"""Arrays for kernels to fill, allocated by the same functions everywhere.

NumPy's own ``zeros``, ``full`` and the like are compiled again for every type and every form of their arguments, some
0.1 s each time; here one function serves all vectors of a type, and one all tables.
"""

import numpy as np

from .jit import kernel


@kernel
def line(size, value):
    """Return a vector of ``size`` times the value, in its type."""
    out = np.empty(size, type(value))
    for k in range(size):
        out[k] = value
    return out


@kernel
def table(rows, columns, value):
    """Return a table (rows, columns) of the value, in its type."""
    out = np.empty((rows, columns), type(value))
    for i in range(rows):
        for j in range(columns):
            out[i, j] = value
    return out
