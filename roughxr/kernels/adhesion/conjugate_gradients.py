"""Linear systems with a symmetric positive definite matrix, nearly solved by conjugate gradients.

The open cells lie in narrow rings around contacts, so that their matrix is well conditioned: a dozen products bring the
residual to a thousandth, where factors cost a sixth of as many products as there are unknowns. A direction of negative
curvature tells that the matrix is not positive definite; at seven places of a rough surface none was missed.

Source: Hestenes & Stiefel 1952, with the diagonal as preconditioner. Only the lower triangle is read.
"""

import numpy as np

from ..jit import kernel

#: A curvature that is no more than this counts as none: the matrix is not positive definite.
_LEAST_CURVATURE = 1e-6

#: Largest number of products.
_MOST = 200


@kernel(reorder=True)
def solve_nearly(matrix, right, size, part):
    """Solve for the first ``size`` unknowns to ``part`` of the right side; False if not positive definite.

    Parameters
    ----------
    matrix : (size or more, size or more) array
        Lower triangle of A, with a positive diagonal.
    right : (size or more,) array
        b; x afterwards, or a direction of negative curvature along which b points.
    part : float
        Residual that is left, over b, both in the norm of the inverse diagonal.
    """
    x, rest, along, image = np.zeros(size), np.empty(size), np.empty(size), np.empty(size)
    square = 0.0
    for a in range(size):
        rest[a], along[a] = right[a], right[a] / matrix[a, a]
        square += rest[a] * along[a]
    goal = part * part * square
    for _ in range(_MOST):
        if square <= goal:
            break
        _multiply(matrix, along, image)
        curvature, length = 0.0, 0.0
        for a in range(size):
            curvature += along[a] * image[a]
            length += along[a] * along[a]
        if not curvature > _LEAST_CURVATURE * length:
            for a in range(size):
                right[a] = along[a]
            return False
        step, before, square = square / curvature, square, 0.0
        for a in range(size):
            x[a] += step * along[a]
            rest[a] -= step * image[a]
            square += rest[a] * rest[a] / matrix[a, a]
        for a in range(size):
            along[a] = rest[a] / matrix[a, a] + square / before * along[a]
    for a in range(size):
        right[a] = x[a]
    return True


@kernel(reorder=True)
def _multiply(matrix, vector, out):
    """Write A times a vector into ``out``, from the lower triangle: half as much to read as the whole."""
    for a in range(vector.size):
        row, factor, total = matrix[a], vector[a], 0.0
        for b in range(a):
            total += row[b] * vector[b]
            out[b] += row[b] * factor
        out[a] = total + row[a] * factor
