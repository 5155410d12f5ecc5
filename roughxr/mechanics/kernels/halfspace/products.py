"""Displacement of a half space under pressures on square cells: the product u = A p, computed in one of two ways.

    u(m) = Σ A(m − n) p(n),     A influence coefficients (``love``, ``layered``), p pressure and u displacement, in nm

Cells have unit side and the half space unit modulus: the caller scales. Whole boxes are convolved in double precision,
and these products decide whether a solution is accurate. Solvers work on compact vectors: the values of the chosen
cells of a box, followed by one entry that stays zero. For few cells the product uses the matrix of coefficients;
many are convolved in their box (``transforms``) in single precision, accurate to some 1e-6 of the largest value: enough
for search directions, in two thirds of the time. Source: Love (1929) for A.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.fft

from ..jit import kernel
from .layered import influence_coefficients
from .transforms import Convolution, convolution, convolve, convolved, even_length, kernel_transform

#: Up to this many cells the dense matrix (half a megabyte) is faster than transforms of the cells' box.
DENSE_LIMIT = 250

#: Number of transforms of small padded boxes that are stored.
_MOST_STORED = 256

#: Cells of a small box.
_SMALL = 256**2

#: Number of transforms of larger boxes that are stored.
_MOST_LARGE = 12


class Operator(NamedTuple):
    """A for one list of cells: a matrix, or a convolution."""

    rows: np.ndarray  # of the cells, counted from the first row and column that hold any
    columns: np.ndarray
    matrix: np.ndarray  # (count, count), or (0, 0)
    product: Convolution  # with A
    inverse: Convolution  # with an approximate inverse of A, if requested; else empty


#: In place of a convolution that is not used.
_NO_CONVOLUTION = Convolution(*(np.empty((0, 0), kind) for kind in (np.float32, np.float32, *2 * (np.complex64,))))


def coefficients_for(shape, film=None):
    """Return influence coefficients for all padded boxes within ``shape``, in one of few sizes."""
    size = table_size(max(shape))
    return influence_coefficients(size, size, film)


def table_size(cells):
    """Return the side of a table of coefficients for boxes of up to this many cells along a side.

    Boxes are padded to ``even_length`` of twice their side, and `kernel_transform` reads offsets up to half of that.
    """
    size = scipy.fft.next_fast_len(cells, real=True) + 1
    return 1 << (max(size, 32) - 1).bit_length() if size <= 512 else -(-size // 256) * 256


def _transfer(rows, columns, film, kind):
    """Return A's transform on a padded box, or the inverse of the transform, in the precision of ``kind``."""
    return (_small_transfer if rows * columns <= _SMALL else _large_transfer)(rows, columns, film, kind)


def _new_transfer(rows, columns, film, kind):
    if kind == "double":
        return kernel_transform(rows, columns, coefficients_for((rows // 2, columns // 2), film))
    transfer = _transfer(rows, columns, film, "double")
    if kind == "inverse":
        if film is not None:  # cut off at the box it may be negative at long wavelengths
            transfer = np.maximum(transfer, 1e-4 * transfer.max())
        transfer = 1.0 / ((rows * columns) ** 2 * transfer)
    return transfer.astype(np.float32)


_small_transfer, _large_transfer = lru_cache(_MOST_STORED)(_new_transfer), lru_cache(_MOST_LARGE)(_new_transfer)


def surface_convolution(rows, columns, film):
    """Return the convolution with A, in single precision, in a box of this many rows and columns."""
    return convolution(rows, _transfer(even_length(2 * rows - 1), even_length(2 * columns - 1), film, "single"))


def inverse_convolution(rows, columns, film):
    """Return the convolution with the inverse of A on a periodic box, in single precision."""
    return convolution(rows, _transfer(even_length(rows), even_length(columns), film, "inverse"))


def displaced(pressure, film=None):
    """Return the displacement of every cell of a box under the pressures in it, in double precision."""
    rows, columns = pressure.shape
    return convolved(pressure, _transfer(even_length(2 * rows - 1), even_length(2 * columns - 1), film, "double"))


def surface_displacement(pressure, dx, contact_modulus, film=None):
    """Return the displacement (nm) of whole windows (…, nx, ny) under pressures (GPa) on their dx × dx cells."""
    shape = pressure.shape
    windows = np.asarray(pressure, dtype=float).reshape(-1, *shape[-2:])
    out = np.array([displaced(window, film) for window in windows]).reshape(shape)
    return out * (dx / contact_modulus)


def operator(rows, columns, film=None, *, dense, multiple=1, invert=False):
    """Return the operator of the cells at (rows, columns), the rows ascending; as a matrix if ``dense``.

    The sides of its box are multiples of ``multiple`` cells. With ``invert`` a convolution has an inverse.
    """
    rows = rows - rows[0]
    columns = columns - columns.min()
    shape = tuple(multiple * (int(cells.max()) // multiple + 1) for cells in (rows, columns))
    if dense:
        matrix = matrix_between(rows, columns, coefficients_for(shape, film))
        return Operator(rows, columns, matrix, _NO_CONVOLUTION, _NO_CONVOLUTION)
    inverse = inverse_convolution(*shape, film) if invert else _NO_CONVOLUTION
    return Operator(rows, columns, np.empty((0, 0)), surface_convolution(*shape, film), inverse)


@kernel
def matrix_between(rows, columns, coefficients):
    """Return the coefficients between cells."""
    matrix = np.empty((rows.size, rows.size))
    for k in range(rows.size):
        for m in range(k + 1):
            matrix[k, m] = coefficients[abs(rows[k] - rows[m]), abs(columns[k] - columns[m])]
            matrix[m, k] = matrix[k, m]
    return matrix


@kernel
def multiply(operator, pressure, out):
    """Write the displacement of the cells under ``pressure`` (compact) into ``out`` (compact)."""
    if operator.matrix.size:
        _multiply(operator.matrix, pressure, out)
    else:
        convolve_cells(operator.rows, operator.columns, operator.product, pressure, out)


@kernel
def convolve_cells(rows, columns, convolution, values, out):
    """Write the convolution of compact values into ``out`` (compact)."""
    box = convolution.box
    box[:] = 0.0
    for k in range(rows.size):
        box[rows[k], columns[k]] = values[k]
    convolve(convolution)
    for k in range(rows.size):
        out[k] = box[rows[k], columns[k]]


@kernel(reorder=True)
def _multiply(matrix, pressure, out):
    """Sum the matrix rows of loaded cells only: an active set leaves about half of the cells free."""
    count = matrix.shape[0]
    out[:] = 0.0
    for k in range(count):
        p = pressure[k]
        if p != 0.0:
            for m in range(count):
                out[m] += p * matrix[k, m]
