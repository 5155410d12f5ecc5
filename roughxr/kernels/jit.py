"""How kernels are compiled: all options in one place.

Compilation happens on the first call, never on import, and is cached on disk. Kernels release the GIL
and are serial: parallelism belongs to dask alone, since two parallel layers at once (``parallel=True``
below dask threads) can abort the process.
"""

from numba import njit

#: Ordinary kernels: IEEE arithmetic, division by zero gives inf or NaN as in NumPy.
_OPTIONS = {"cache": True, "nogil": True, "error_model": "numpy"}

#: What a sum may be allowed for speed: another order, and fused multiply-add. NaN and inf keep their meaning.
_REORDER = {"reassoc", "contract", "arcp", "nsz"}


def kernel(function):
    """Compile ``function`` on its first call."""
    return njit(**_OPTIONS)(function)


def reducing_kernel(function):
    """Compile ``function`` on its first call, letting sums be reordered so that loops over cells vectorise."""
    return njit(fastmath=_REORDER, **_OPTIONS)(function)


def inlined_kernel(function):
    """Compile ``function`` as a part of its callers.

    For long functions called in one place: LLVM optimises all that a function calls anew with each caller, so that
    every level of long functions adds seconds to the first call.
    """
    return njit(inline="always", **_OPTIONS)(function)
