"""Displacement of a half space under pressures on square cells: two engines for one product u = A p.

Both work on compact vectors, the values of the cells of interest wherever they lie in a box, followed by one entry that
stays zero. Cells have unit side and the half space unit modulus: the caller scales. Few cells are summed with the
matrix of Love's coefficients between them; many are convolved in their box, zero-padded so that nothing wraps around:
exact, not periodic. Only rows that hold cells are transformed along y, both ways, which saves a quarter of the work,
and the transformed coefficients are real, since the coefficients are even.

Two precisions: ``multiply`` is what solutions are held against, ``multiply_single`` is right to some 1e-6 of its
largest value, which is enough for search directions, in two thirds of the time. SciPy's transforms run inside compiled
code by way of rocket-fft: no Python in the loop and no lock held, which halves the time on small boxes and lets threads
scale.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.fft

from .jit import kernel, reducing_kernel
from .love import love_coefficients

#: From this many cells on, an inverse by transforms preconditions better than a few neighbours do.
LONG_RANGE = 1000

#: Up to this many cells the dense matrix (half a megabyte) beats transforms of the cells' box.
DENSE_LIMIT = 250


class Operator(NamedTuple):
    """A for one list of cells: a matrix, or a box and the transformed coefficients (the others are empty)."""

    matrix: np.ndarray  # (count, count), or (0, 0)
    places: np.ndarray  # index of each cell in the flattened box
    box: np.ndarray  # scratch
    single_box: np.ndarray  # the same in single precision
    transfer: np.ndarray  # real, (rows, columns // 2 + 1) of the padded box
    single_transfer: np.ndarray
    columns: int  # of the padded box
    inverse: np.ndarray  # inverse transformed coefficients of the periodic box, for many cells
    period: int  # columns of the periodic box


_EMPTY = np.zeros((1, 1)), np.zeros((1, 1), np.float32)


def operator(rows, columns):
    """Return the faster engine for the cells at (rows, columns), whole numbers, of a box that starts at (0, 0)."""
    shape = int(rows.max()) + 1, int(columns.max()) + 1
    places = rows * shape[1] + columns
    if rows.size <= DENSE_LIMIT:
        matrix = _between(rows, columns, love_coefficients(*_rounded(*shape)))
        return Operator(matrix, places, *_EMPTY, *_EMPTY, 1, np.zeros((0, 0), np.float32), 1)
    padded = _padded(shape)
    boxes = np.zeros(shape), np.zeros(shape, np.float32)
    inverse, period = np.zeros((0, 0), np.float32), 1
    if rows.size > LONG_RANGE:
        periodic = tuple(scipy.fft.next_fast_len(n, real=True) for n in shape)
        inverse, period = 1 / _transfers(periodic)[1], periodic[1]
    return Operator(np.zeros((0, 0)), places, *boxes, *_transfers(padded), padded[1], inverse, period)


@kernel
def divide_single(operator, displacement, out):
    """Write into ``out`` (compact) nearly the pressures that cause a displacement of the cells (compact)."""
    _multiply_in_box(operator.places, operator.single_box, operator.inverse, operator.period, displacement, out)


@kernel
def multiply(operator, pressure, out):
    """Write the displacement of the cells under ``pressure`` (compact) into ``out`` (compact)."""
    if operator.matrix.size:
        _multiply(operator.matrix, pressure, out)
    else:
        _multiply_in_box(operator.places, operator.box, operator.transfer, operator.columns, pressure, out)


@kernel
def multiply_single(operator, pressure, out):
    """Do as ``multiply``, transforms in single precision."""
    if operator.matrix.size:
        _multiply(operator.matrix, pressure, out)
    else:
        _multiply_in_box(
            operator.places, operator.single_box, operator.single_transfer, operator.columns, pressure, out
        )


@kernel
def _multiply_in_box(places, box, transfer, columns, pressure, out):
    flat, width = box.reshape(-1), box.shape[1]
    for k in range(places.size):
        flat[places[k]] = pressure[k]
    displaced = _convolve(box, transfer, columns)
    for k in range(places.size):
        out[k] = displaced[places[k] // width, places[k] % width]


def convolve(pressure):
    """Return the displacement of every cell of a box under the pressures in it (2-D)."""
    padded = _padded(pressure.shape)
    return _convolve(pressure, _transfers(padded)[0], padded[1])[:, : pressure.shape[1]]


def surface_displacement(pressure, dx, contact_modulus):
    """Return the displacement (nm) of a whole window under pressures (GPa) on its dx × dx cells."""
    return convolve(np.ascontiguousarray(pressure)) * (dx / contact_modulus)


@kernel
def _convolve(box, transfer, columns):
    """Return the displacement in the box; columns beyond the box's own are padding."""
    spectrum = scipy.fft.fft(scipy.fft.rfft(box, columns, 1), transfer.shape[0], 0)
    spectrum *= transfer
    return scipy.fft.irfft(scipy.fft.ifft(spectrum, transfer.shape[0], 0)[: box.shape[0]], columns, 1)


def _padded(shape):
    return tuple(scipy.fft.next_fast_len(2 * n - 1, real=True) for n in shape)


def _transfers(padded):
    """Return the transformed coefficients in both precisions; many small ones are kept, few large."""
    return (_small_transfers if padded[0] * padded[1] <= 256**2 else _large_transfers)(padded)


def _transform(padded):
    """Return the real transform of the coefficients at all offsets that fit into the padded box."""
    rows, columns = (np.minimum(np.arange(n), n - np.arange(n)) for n in padded)
    table = love_coefficients(*_rounded(padded[0] // 2 + 1, padded[1] // 2 + 1))
    transfer = scipy.fft.rfft2(table[np.ix_(rows, columns)]).real.copy()
    return transfer, transfer.astype(np.float32)


_small_transfers = lru_cache(maxsize=512)(_transform)
_large_transfers = lru_cache(maxsize=3)(_transform)


def _rounded(rows, columns):
    """Return a square power of two that holds the shape, so that few coefficient tables are ever made."""
    size = 1 << (max(rows, columns, 32) - 1).bit_length()
    return size, size


@kernel
def _between(rows, columns, coefficients):
    count = rows.size
    matrix = np.empty((count, count))
    for k in range(count):
        for m in range(k + 1):
            matrix[k, m] = coefficients[abs(rows[k] - rows[m]), abs(columns[k] - columns[m])]
            matrix[m, k] = matrix[k, m]
    return matrix


@reducing_kernel
def _multiply(matrix, pressure, out):
    """Sum the matrix rows of loaded cells only: an active set leaves about half of the cells free."""
    count = matrix.shape[0]
    out[:] = 0.0
    for k in range(count):
        p = pressure[k]
        if p != 0.0:
            for m in range(count):
                out[m] += p * matrix[k, m]
