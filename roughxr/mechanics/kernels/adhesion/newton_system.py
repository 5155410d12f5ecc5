"""Linear systems on the cells in or near contact: A on touching cells, 1 − τA on attracting ones.

A change x of the pressures changes the gaps by A x (influence coefficients). Newton's step solves

    (A x)ᵢ = rᵢ   where cells touch,        xⱼ − τⱼ (A x)ⱼ = rⱼ   where they attract,

with τ = −dt/du the slope of the falling traction. GCR (Eisenstat, Elman & Schultz 1983) searches along the residual
until a fifth of it remains, which is enough for Newton's method and takes some four products. The attracting part is
close to the identity, and the touching part is preconditioned by the inverse of A on a periodic box, restricted to the
touching cells. A system that differs in τ alone starts from the directions of the last system. Products are transforms
of a box around the cells, in single precision; up to ``DENSE_LIMIT`` cells the matrix is used.
"""

from typing import NamedTuple

import numpy as np

from ..halfspace.products import DENSE_LIMIT, convolve_cells, multiply, operator
from ..jit import kernel

#: The sides of boxes are multiples of this many cells, so that few transforms of the coefficients are needed.
BOX_MULTIPLE = 16


class Workspace(NamedTuple):
    """Work arrays of GCR."""

    basis: np.ndarray  # (products, count)
    preconditioned: np.ndarray  # (products, count)
    images: np.ndarray  # (products, count) A times the preconditioned


def operator_on(cells, film, last):
    """Return A and its periodic inverse on cells (2, count), which ``last`` stores: every other round has the same."""
    key = cells.tobytes()
    if key not in last:
        last.clear()
        last[key] = operator(*cells, film, dense=cells.shape[1] <= DENSE_LIMIT, multiple=BOX_MULTIPLE, invert=True)
    return last[key]


@kernel
def workspace(products, count):
    """Return work arrays for this many products on this many cells."""
    return Workspace(np.empty((products, count)), np.empty((products, count)), np.empty((products, count)))


@kernel
def _precondition(near, touching, values, out):
    """Write into ``out`` approximate pressures that solve the system for a right side."""
    for k in range(values.size):
        out[k] = values[k] if touching[k] else 0.0
    if near.matrix.size == 0:
        convolve_cells(near.rows, near.columns, near.inverse, out, out)
    for k in range(values.size):
        out[k] = out[k] if touching[k] else values[k]


@kernel(reorder=True)
def _dot(vector, other):
    total = 0.0
    for k in range(vector.size):
        total += vector[k] * other[k]
    return total


@kernel(reorder=True)
def _subtract(values, part, other):
    for k in range(values.size):
        values[k] -= part * other[k]


@kernel
def solve(near, touching, tau, right, part, known, room, x, image):
    """Solve the system to ``part`` of the right side; write the solution into ``x`` and A x into ``image``.

    Start from the first ``known`` directions of ``room``, with their images under A from the last system. Only the
    remaining residual needs new products with A.

    Returns
    -------
    size
        Number of directions, limited by the size of ``room``.
    """
    most = room.images.shape[0]
    left = right.copy()
    h = np.zeros((most, most))
    e = np.zeros(most)
    goal = part * np.sqrt(_dot(right, right))
    for m in range(known):
        _orthogonalise(touching, tau, room, m, h, e, left)
    size = known
    rest = np.sqrt(_dot(left, left))
    while size < most and rest > goal:
        z = room.preconditioned[size]
        _precondition(near, touching, left, z)
        multiply(near, z, room.images[size])
        _orthogonalise(touching, tau, room, size, h, e, left)
        size = size + 1
        rest = np.sqrt(_dot(left, left))
    _combine(h, e, size, room, x, image)
    return size


@kernel
def _orthogonalise(touching, tau, room, m, h, e, left):
    """Orthogonalise the image of the ``m``-th direction, and subtract its part of the residual."""
    z = room.preconditioned[m]
    y = room.images[m]
    new = room.basis[m]
    for k in range(new.size):
        new[k] = y[k] if touching[k] else z[k] - tau[k] * y[k]
    for i in range(m):
        h[i, m] = _dot(room.basis[i], new)
        _subtract(new, h[i, m], room.basis[i])
    h[m, m] = np.sqrt(_dot(new, new))
    for k in range(new.size):
        new[k] /= h[m, m]
    e[m] = _dot(new, left)
    _subtract(left, e[m], new)


@kernel(reorder=True)
def _combine(h, e, size, room, x, image):
    """Solve the triangular system, and combine the directions to the solution."""
    x[:] = 0.0
    image[:] = 0.0
    for m in range(size - 1, -1, -1):
        total = e[m]
        for i in range(m + 1, size):
            total -= h[m, i] * e[i]
        e[m] = total / h[m, m]
        for k in range(x.size):
            x[k] += e[m] * room.preconditioned[m, k]
            image[k] += e[m] * room.images[m, k]
