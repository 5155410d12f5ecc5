"""Dense systems, by Cholesky's factors and by conjugate gradients, against NumPy."""

import numpy as np
import pytest

from roughxr.kernels.adhesion.cholesky import invert, solve_in_place
from roughxr.kernels.adhesion.conjugate_gradients import solve_nearly


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


@pytest.mark.parametrize("size", [0, 1, 2, 33])
def test_the_inverse_is_numpys(size):
    whole = spd(size)
    found = whole.copy()
    invert(found)
    assert np.allclose(found, np.linalg.inv(whole), rtol=1e-10, atol=1e-13)


def spd(size):
    random = np.random.default_rng(size)
    whole = random.normal(size=(size, size))
    return whole @ whole.T + size * np.eye(size)


@pytest.mark.parametrize("part", [1e-2, 1e-8])
def test_conjugate_gradients_leave_no_more_than_the_part_asked_for(part):
    size, whole = 150, spd(150)
    right = np.random.default_rng(7).normal(size=size)
    room, values = np.full((size + 3, size + 3), np.nan), np.full(size + 3, np.nan)
    room[:size, :size], values[:size] = np.tril(whole), right
    assert solve_nearly(room, values, size, part)
    left = (right - whole @ values[:size]) / np.sqrt(np.diag(whole))
    assert np.linalg.norm(left) <= 1.0001 * part * np.linalg.norm(right / np.sqrt(np.diag(whole)))
    assert np.isnan(values[size:]).all()


def test_conjugate_gradients_find_one_direction_of_negative_curvature():
    """In a well conditioned matrix with a single negative eigenvalue; the right side points along the direction."""
    random = np.random.default_rng(3)
    vectors, _ = np.linalg.qr(random.normal(size=(200, 200)))
    for lowest in (-0.5, -0.05):
        values = np.r_[lowest, np.linspace(0.5, 2.0, 199)]
        whole = (vectors * values) @ vectors.T
        right = random.normal(size=200)
        found = right.copy()
        assert not solve_nearly(np.tril(whole), found, 200, 1e-3)
        assert found @ whole @ found <= 1e-6 * (found @ found)
        assert found @ right > 0
