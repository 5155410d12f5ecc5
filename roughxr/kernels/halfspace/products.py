"""Displacement of a half space under pressures on square cells: the product u = A p, computed in one of two ways.

    u(m) = Σ A(m − n) p(n),     A Love's coefficients (``love``), p pressure and u displacement of the cells, both in nm

Both work on compact vectors, the values of the cells of interest wherever they lie in a box, followed by one entry that
stays zero. Cells have unit side and the half space unit modulus: the caller scales. Few cells are summed with the
matrix of Love's coefficients between them; many are convolved in their box (``products.transforms``).

Two precisions: whole boxes are convolved in double precision, which decides whether a solution is accurate; the
product of the cells by transforms is accurate to some 1e-6 of its largest value, which is enough for search directions,
in two thirds of the time. Sources: Love (1929) for A, see ``transforms`` for the convolution.
"""

from typing import NamedTuple

import numpy as np
import scipy.fft

from ..arrays import unset
from ..jit import kernel
from .love import love_coefficients
from .transforms import Convolution, Transfer, convolution, convolve, even_length, transfer_of

#: Up to this many cells the dense matrix (half a megabyte) is faster than transforms of the cells' box.
DENSE_LIMIT = 250

#: From this many cells on, an inverse by transforms is a better preconditioner than a few neighbours.
LONG_RANGE = 1000

#: Transformed coefficients are kept for padded boxes of up to this many cells, to be used again.
_LARGEST_CACHED = 256**2


class Operator(NamedTuple):
    """A for one list of cells: a matrix, or a convolution.

    Convolutions are in a list, since numba takes named tuples apart into their arrays' numbers, here some ninety, and
    puts them together again wherever they are handed on.
    """

    rows: np.ndarray  # of the cells, counted from the first row that holds any
    columns: np.ndarray
    matrix: np.ndarray  # (count, count), or (0, 0)
    convolutions: list[Convolution]  # in single precision: with A, then for many cells with nearly A's inverse


def coefficients_for(shape):
    """Return Love's coefficients for all boxes within ``shape``, padded, in one of few sizes."""
    size = table_size(max(shape))
    return love_coefficients(size, size)


def table_size(cells):
    """Return the side of a table of coefficients for boxes of up to so many cells along a side.

    Boxes are padded to ``even_length`` of twice their side, and `transfer_of` reads offsets up to half of that.
    """
    size = scipy.fft.next_fast_len(cells, real=True) + 1
    return 1 << (max(size, 32) - 1).bit_length() if size <= 512 else -(-size // 256) * 256


@kernel
def no_transfers():
    """Return an empty list for `known_transfer` to keep transformed coefficients in."""
    return [Transfer(0, 0, unset((1, 1), 0.0), unset((1, 1), np.float32(0)))]


@kernel
def known_transfer(rows, columns, coefficients, known):
    """Return the transformed coefficients of the padded box, from the list or computed."""
    for transfer in known:
        if transfer.rows == rows and transfer.columns == columns:
            return transfer
    transfer = transfer_of(rows, columns, coefficients)
    if rows * columns <= _LARGEST_CACHED:
        known.append(transfer)
    return transfer


@kernel
def whole_box(shape, coefficients, known):
    """Return the convolution of a whole box in double precision."""
    rows, columns = even_length(2 * shape[0] - 1), even_length(2 * shape[1] - 1)
    transfer = known_transfer(rows, columns, coefficients, known)
    return convolution(shape[0], columns, transfer.double, np.complex128(0))


@kernel
def displace(pressure, whole, out):
    """Write into ``out`` the displacement of every cell of a whole box under the pressures in it."""
    rows, columns = pressure.shape
    for i in range(rows):
        for j in range(whole.box.shape[1]):
            whole.box[i, j] = pressure[i, j] if j < columns else 0.0
    convolve(whole)
    for i in range(rows):
        for j in range(columns):
            out[i, j] = whole.box[i, j]


@kernel
def operator(rows, columns, coefficients, known, dense):
    """Return the operator of the cells at (rows, columns), integers; by a matrix where ``dense``."""
    rows, columns = _from_first(rows), _from_first(columns)
    shape = (1, 1) if dense else (largest(rows) + 1, largest(columns) + 1)
    high, wide = even_length(2 * shape[0] - 1), even_length(2 * shape[1] - 1)
    transfer = known_transfer(high, wide, coefficients, known)
    convolutions = [convolution(shape[0], wide, transfer.single, np.complex64(0))]
    if rows.size > LONG_RANGE and not dense:
        high, wide = even_length(shape[0]), even_length(shape[1])
        transfer = known_transfer(high, wide, coefficients, known)
        convolutions.append(convolution(shape[0], wide, _inverse(transfer), np.complex64(0)))
    matrix = _between(rows, columns, rows.size if dense else 0, coefficients)
    return Operator(rows, columns, matrix, convolutions)


@kernel
def _from_first(places):
    first, out = np.int64(2**62), unset((places.size,), 0)
    for k in range(places.size):
        first = min(first, places[k])
    for k in range(places.size):
        out[k] = places[k] - first
    return out


@kernel
def largest(places):
    last = 0
    for k in range(places.size):
        last = max(last, places[k])
    return last


@kernel
def _inverse(periodic):
    """Return the inverse of transformed coefficients, like these divided by the number of cells."""
    (rows, columns), count = periodic.single.shape, periodic.rows * periodic.columns
    out = unset((rows, columns), np.float32(0))
    for i in range(rows):
        for j in range(columns):
            out[i, j] = 1.0 / (count * count * periodic.double[i, j])
    return out


@kernel
def multiply(operator, pressure, out):
    """Write the displacement of the cells under ``pressure`` (compact) into ``out`` (compact)."""
    if operator.matrix.size:
        _multiply(operator.matrix, pressure, out)
    else:
        _multiply_in_box(operator.rows, operator.columns, operator.convolutions[0], pressure, out)


@kernel
def divide(operator, displacement, out):
    """Write into ``out`` (compact) nearly the pressures that cause a displacement of the cells (compact)."""
    _multiply_in_box(operator.rows, operator.columns, operator.convolutions[1], displacement, out)


@kernel
def _multiply_in_box(rows, columns, convolution, values, out):
    box = convolution.box
    for i in range(box.shape[0]):
        for j in range(box.shape[1]):
            box[i, j] = 0.0
    for k in range(rows.size):
        box[rows[k], columns[k]] = values[k]
    convolve(convolution)
    for k in range(rows.size):
        out[k] = box[rows[k], columns[k]]


def surface_displacement(pressure, dx, contact_modulus):
    """Return the displacement (nm) of whole windows (…, nx, ny) under pressures (GPa) on their dx × dx cells."""
    shape = pressure.shape
    windows = np.ascontiguousarray(pressure, dtype=float).reshape(-1, *shape[-2:])
    return _displacements(windows, coefficients_for(shape[-2:])).reshape(shape) * (dx / contact_modulus)


@kernel
def _displacements(windows, coefficients):
    out = np.empty_like(windows)
    whole = whole_box(windows.shape[1:], coefficients, no_transfers())
    for k in range(windows.shape[0]):
        displace(windows[k], whole, out[k])
    return out


@kernel
def _between(rows, columns, count, coefficients):
    """Return the coefficients between the first cells."""
    matrix = unset((count, count), 0.0)
    for k in range(count):
        for m in range(k + 1):
            matrix[k, m] = coefficients[abs(rows[k] - rows[m]), abs(columns[k] - columns[m])]
            matrix[m, k] = matrix[k, m]
    return matrix


@kernel(reorder=True)
def _multiply(matrix, pressure, out):
    """Sum the matrix rows of loaded cells only: an active set leaves about half of the cells free."""
    count = matrix.shape[0]
    for k in range(out.size):
        out[k] = 0.0
    for k in range(count):
        p = pressure[k]
        if p != 0.0:
            for m in range(count):
                out[m] += p * matrix[k, m]
