"""Dense systems by Cholesky's factors against NumPy."""

import numpy as np
import pytest

from roughxr.kernels.adhesion.cholesky import solve_in_place


@pytest.mark.parametrize("size", [0, 1, 2, 33, 191, 192, 193, 225, 450])
def test_the_solution_is_numpys(size):
    """Sizes on both sides of a panel's and a tile's edge; what lies beyond the matrix is not touched."""
    random = np.random.default_rng(size)
    whole = random.normal(size=(size, size))
    whole = whole @ whole.T + size * np.eye(size)
    right = random.normal(size=size)
    room, values = np.full((size + 3, size + 3), np.nan), np.full(size + 3, np.nan)
    room[:size, :size], values[:size] = np.tril(whole), right
    assert solve_in_place(room, values, size)
    assert np.allclose(values[:size], np.linalg.solve(whole, right), rtol=1e-10, atol=1e-13)
    assert np.isnan(values[size:]).all()
    assert np.isnan(room[size:]).all()


@pytest.mark.parametrize("place", [0, 100, 300])
def test_a_matrix_that_is_not_positive_definite_is_told(place):
    """One negative eigenvalue, wherever it shows."""
    matrix = np.eye(320)
    matrix[place, place] = -0.5
    assert not solve_in_place(matrix, np.ones(320), 320)
