"""Displacement of a half space under pressures on square cells: two engines for one product u = A p.

Both work on compact vectors, the values of the cells of interest wherever they lie in a box, followed by
one entry that stays zero. Cells have unit side and the half space unit modulus: the caller scales.
``DenseProduct`` keeps the matrix of Love's coefficients between the cells; ``FourierProduct`` convolves in
the box. ``product`` chooses.
"""

from functools import lru_cache

import numpy as np
import scipy.fft

from .jit import kernel, reducing_kernel
from .love import love_coefficients

#: Up to this many cells the dense matrix (2 MB, second-level cache) beats transforms of the cells' box.
DENSE_LIMIT = 500


class FourierProduct:
    """u = A p by zero-padded real transforms of the cells' bounding box: exact, not periodic.

    Only rows that hold cells are transformed along y, both ways, which saves a quarter of the work; the
    transformed coefficients are real, since the coefficients are even, and kept per padded shape.
    """

    def __init__(self, rows, columns):
        self._shape = (int(rows.max()) + 1, int(columns.max()) + 1)
        self._padded = tuple(scipy.fft.next_fast_len(2 * n - 1, real=True) for n in self._shape)
        self._transfer = _transfer(self._padded)
        self._cells = rows * self._shape[1] + columns
        self._box = np.zeros(self._shape)

    def __call__(self, pressure, out):
        """Write the displacement of the cells under ``pressure`` (compact) into ``out`` (compact)."""
        _scatter(pressure, self._cells, self._box.reshape(-1))
        spectrum = scipy.fft.rfft(self._box, self._padded[1], axis=1)
        spectrum = scipy.fft.fft(spectrum, self._padded[0], axis=0)
        spectrum *= self._transfer
        spectrum = scipy.fft.ifft(spectrum, axis=0, overwrite_x=True)
        box = scipy.fft.irfft(spectrum[: self._shape[0]], self._padded[1], axis=1)
        _gather(box, self._cells, self._shape[1], out)
        return out


class DenseProduct:
    """u = A p by the matrix of coefficients between the cells."""

    def __init__(self, rows, columns):
        coefficients = love_coefficients(*_rounded(int(rows.max()) + 1, int(columns.max()) + 1))
        self._matrix = _between(rows, columns, coefficients)

    def __call__(self, pressure, out):
        """Write the displacement of the cells under ``pressure`` (compact) into ``out`` (compact)."""
        _multiply(self._matrix, pressure, out)
        return out


def product(rows, columns):
    """Return the faster engine for the cells at (rows, columns) of a box that starts at (0, 0)."""
    return (DenseProduct if rows.size <= DENSE_LIMIT else FourierProduct)(rows, columns)


def surface_displacement(pressure, dx, contact_modulus):
    """Return the displacement (nm) of a whole window under pressures (GPa) on its dx × dx cells."""
    rows, columns = np.divmod(np.arange(pressure.size), pressure.shape[1])
    out = np.empty(pressure.size)
    FourierProduct(rows, columns)(pressure.ravel(), out)
    return out.reshape(pressure.shape) * (dx / contact_modulus)


def _transfer(padded):
    """Return the transformed coefficients; many small ones are kept, few large ones (16 MB at 2048²)."""
    return (_small_transfer if padded[0] * padded[1] <= 256**2 else _large_transfer)(padded)


def _transform(padded):
    """Return the real transform of the coefficients at all offsets that fit into the padded box."""
    rows, columns = (np.minimum(np.arange(n), n - np.arange(n)) for n in padded)
    table = love_coefficients(*_rounded(padded[0] // 2 + 1, padded[1] // 2 + 1))
    return scipy.fft.rfft2(table[np.ix_(rows, columns)]).real.copy()


_small_transfer = lru_cache(maxsize=512)(_transform)
_large_transfer = lru_cache(maxsize=3)(_transform)


def _rounded(rows, columns):
    """Return a square power of two that holds the shape, so that few coefficient tables are ever made."""
    size = 1 << (max(rows, columns, 32) - 1).bit_length()
    return size, size


@kernel
def _scatter(values, cells, box):
    for k in range(cells.size):
        box[cells[k]] = values[k]


@kernel
def _gather(box, cells, width, values):
    for k in range(cells.size):
        values[k] = box[cells[k] // width, cells[k] % width]


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
