"""Arrays for kernels to fill, allocated by the same functions everywhere.

NumPy's own ``zeros``, ``full`` and the like are compiled again for every type and every form of their arguments, some
0.1 s each time; here one function serves all vectors of a type, and one all tables.
"""

import numpy as np

from .jit import kernel


@kernel
def unset(shape, value):
    """Return an array of the shape, a tuple of lengths ≥ 0, in the type of the value, its values unset."""
    return np.empty(shape, type(value))


@kernel
def line(size, value):
    """Return a vector of ``size`` times the value, in its type."""
    out = unset((size,), value)
    for k in range(size):
        out[k] = value
    return out


@kernel
def table(rows, columns, value):
    """Return a table (rows, columns) of the value, in its type."""
    out = unset((rows, columns), value)
    for i in range(rows):
        for j in range(columns):
            out[i, j] = value
    return out


@kernel
def lowest(values):
    """Return the least of a vector; inf where there is none."""
    least = np.inf
    for value in values:
        least = min(least, value)
    return least


@kernel
def ascending(values):
    """Return the order that sorts a vector, equal values as they stand: sorted runs are merged, two by two."""
    order, merged, width = unset((values.size,), 0), unset((values.size,), 0), 1
    for k in range(values.size):
        order[k] = k
    while width < values.size:
        for low in range(0, values.size, 2 * width):
            middle, high = min(low + width, values.size), min(low + 2 * width, values.size)
            i, j = low, middle
            for k in range(low, high):
                if i < middle and (j == high or values[order[i]] <= values[order[j]]):
                    merged[k], i = order[i], i + 1
                else:
                    merged[k], j = order[j], j + 1
        order, merged, width = merged, order, 2 * width
    return order


@kernel
def median(values):
    """Return the median of a vector that is not empty."""
    order, count = ascending(values), values.size
    return 0.5 * (values[order[(count - 1) // 2]] + values[order[count // 2]])
