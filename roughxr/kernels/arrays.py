"""Arrays for kernels to fill, allocated by the same functions everywhere.

NumPy's own ``zeros``, ``full`` and the like are compiled again for every type and every form of their arguments, some
0.1 s each time; here one function serves all vectors of a type, and one all tables. Even ``empty`` takes 0.06 s for
each type and form: `unset` is written where it is called, as Numba writes the arrays that expressions make. It builds
on a function of Numba's that is not public, tried with 0.63 and 0.68; `_unset_plain`, compiled, gives the same arrays.
"""

import numpy as np
from numba import config, types
from numba.core.cgutils import unpack_tuple
from numba.extending import intrinsic
from numba.np.arrayobj import _empty_nd_impl

from .jit import kernel


@intrinsic
def _unset(typing, shape, value):
    array = types.Array(types.unliteral(value), len(shape), "C")

    def write(context, builder, signature, arguments):
        lengths = [
            context.cast(builder, length, kind, types.intp)
            for length, kind in zip(unpack_tuple(builder, arguments[0]), signature.args[0])
        ]
        return _empty_nd_impl(context, builder, array, lengths)._getvalue()

    return array(shape, value), write


def _unset_plain(shape, value):
    return np.empty(shape, type(value))


#: ``unset(shape, value)``: an array of the shape, a tuple of lengths ≥ 0, in the type of the value, its values unset.
unset = _unset_plain if config.DISABLE_JIT else _unset


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
