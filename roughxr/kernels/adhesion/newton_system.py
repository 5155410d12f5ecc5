"""Linear systems on the cells in or near contact: A on touching cells, 1 − τA on attracting ones.

A change x of the pressures changes the gaps by A x (Love's coefficients, ``halfspace.love``). Newton's step solves

    (A x)ᵢ = rᵢ   where cells touch,        xⱼ − τⱼ (A x)ⱼ = rⱼ   where they attract,

with τ = −dt/du the slope of the falling traction. GMRES (Saad & Schultz 1986) reduces the residual to a fifth, which is
enough for Newton's method, with some five products where the state is stable. The attracting part is close to the
identity, and the touching part is preconditioned by the inverse of A on a periodic box, restricted to the cells that
touch. Products are transforms of a box around the cells, in single precision; up to ``DENSE_LIMIT`` cells the matrix is
used.
"""

from typing import NamedTuple

import numpy as np

from ..halfspace.products import DENSE_LIMIT, Operator, divide, multiply
from ..jit import kernel


class Workspace(NamedTuple):
    """Work arrays of GMRES."""

    basis: np.ndarray  # (products + 1, count)
    preconditioned: np.ndarray  # (products, count)
    images: np.ndarray  # (products, count) A times the preconditioned


@kernel
def near_cells(rows, columns, coefficients, product, inverse):
    """Return A on cells at (rows, columns) of the box of two convolutions: with A, and with its periodic inverse."""
    count = rows.size if rows.size <= DENSE_LIMIT else 0
    matrix = np.empty((count, count))
    for k in range(count):
        for m in range(count):
            matrix[k, m] = coefficients[abs(rows[k] - rows[m]), abs(columns[k] - columns[m])]
    return Operator(rows, columns, matrix, [product, inverse])


@kernel
def workspace(products, count):
    """Return work arrays for this many products on this many cells."""
    return Workspace(np.empty((products + 1, count)), np.empty((products, count)), np.empty((products, count)))


@kernel
def _precondition(near, touching, values, out):
    """Write into ``out`` nearly the pressures that solve the system for a right side."""
    for k in range(values.size):
        out[k] = values[k] if touching[k] else 0.0
    if near.matrix.size == 0:
        divide(near, out, out)
    for k in range(values.size):
        if not touching[k]:
            out[k] = values[k]


@kernel(reorder=True)
def _along(vector, other):
    total = 0.0
    for k in range(vector.size):
        total += vector[k] * other[k]
    return total


@kernel(reorder=True)
def _orthogonal(basis, size, vector, h):
    """Remove from ``vector`` its components along the first ``size`` rows of ``basis``, which are written into ``h``.

    The remainder is normalised; returns its length before.
    """
    for i in range(size):
        other, along = basis[i], 0.0
        for k in range(vector.size):
            along += other[k] * vector[k]
        h[i] = along
        for k in range(vector.size):
            vector[k] -= along * other[k]
    square = 0.0
    for k in range(vector.size):
        square += vector[k] * vector[k]
    length = np.sqrt(square)
    for k in range(vector.size):
        vector[k] /= length
    return length


@kernel
def solve(near, touching, tau, right, part, room, x, image):
    """Solve the system to ``part`` of the right side; write the solution into ``x`` and A x into ``image``.

    Returns
    -------
    products
        Their number, limited by the size of ``room``.
    """
    count, most = right.size, room.images.shape[0]
    h, rotations, e = np.zeros((most + 1, most)), np.zeros((most, 2)), np.zeros(most + 1)
    length, size = _first_basis(right, room.basis, x, image), 0
    if length == 0.0:
        return 0
    e[0] = length
    while size < most:
        m = size
        z, y, new, column = room.preconditioned[m], room.images[m], room.basis[m + 1], h[:, m].copy()
        _precondition(near, touching, room.basis[m], z)
        multiply(near, z, y)
        for k in range(count):
            new[k] = y[k] if touching[k] else z[k] - tau[k] * y[k]
        beyond = _orthogonal(room.basis, m + 1, new, column)
        size += 1
        _rotate(column, rotations, e, beyond, m)
        for i in range(size):
            h[i, m] = column[i]
        if abs(e[size]) <= part * length:
            break
    _combine(h, e, size, room, x, image)
    return size


@kernel
def nearest(touching, tau, right, size, room, x, image):
    """Write into ``x`` what nearly solves a system with another ``tau``, from the ``size`` products of the last one.

    Least squares over the directions of which A is known already, so that it costs no product. Returns the part of the
    right side that stays unsolved.
    """
    h, e, column = np.zeros((size, size)), np.zeros(size), np.zeros(size)
    length, left = _first_basis(right, room.basis[size:], x, image), 1.0
    for m in range(size):
        z, y, new = room.preconditioned[m], room.images[m], room.basis[m]
        for k in range(right.size):
            new[k] = y[k] if touching[k] else z[k] - tau[k] * y[k]
        h[m, m] = _orthogonal(room.basis, m, new, column)
        along = _along(new, room.basis[size])
        for i in range(m):
            h[i, m] = column[i]
        e[m] = along * length
        left -= along * along
    _combine(h, e, size, room, x, image)
    return np.sqrt(max(left, 0.0))


@kernel
def _first_basis(right, basis, x, image):
    """Start the basis with the right side; return its length."""
    square = 0.0
    for k in range(right.size):
        x[k], image[k] = 0.0, 0.0
        square += right[k] * right[k]
    length = np.sqrt(square)
    for k in range(right.size):
        basis[0, k] = right[k] / length
    return length


@kernel
def _rotate(column, rotations, e, beyond, m):
    """Bring the m-th column of the Hessenberg matrix to triangular form by Givens rotations."""
    for i in range(m):
        a, b, c, s = column[i], column[i + 1], rotations[i, 0], rotations[i, 1]
        column[i], column[i + 1] = c * a + s * b, c * b - s * a
    whole = np.hypot(column[m], beyond)
    rotations[m, 0], rotations[m, 1] = column[m] / whole, beyond / whole
    column[m] = whole
    e[m + 1] = -rotations[m, 1] * e[m]
    e[m] *= rotations[m, 0]


@kernel(reorder=True)
def _combine(h, e, size, room, x, image):
    """Solve the triangular system, and add up the solution."""
    for m in range(size - 1, -1, -1):
        total = e[m]
        for i in range(m + 1, size):
            total -= h[m, i] * e[i]
        e[m] = total / h[m, m]
        for k in range(x.size):
            x[k] += e[m] * room.preconditioned[m, k]
            image[k] += e[m] * room.images[m, k]
