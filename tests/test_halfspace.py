"""Love's coefficients and the two engines of the product, against quadrature and each other; separations."""

import numpy as np
import pytest
from scipy.integrate import dblquad

from roughxr.mechanics.kernels.halfspace.love import love_coefficients
from roughxr.mechanics.kernels.halfspace.products import multiply, operator, surface_displacement
from roughxr.mechanics.kernels.halfspace.separation import map_separation, sphere_separation


@pytest.mark.parametrize("offset", [(1, 0), (2, 1), (5, 3)])
def test_love_coefficient_is_boussinesq_over_the_square(offset):
    i, j = offset
    expected, _ = dblquad(lambda y, x: 1 / np.hypot(x, y), i - 0.5, i + 0.5, j - 0.5, j + 0.5)
    assert love_coefficients(8, 8)[i, j] == pytest.approx(expected / np.pi, rel=1e-10)


def test_the_loaded_square_sinks_most_and_the_far_field_is_a_point_load():
    table = love_coefficients(512, 512)
    assert table[0, 0] == pytest.approx(4 * np.arcsinh(1) / np.pi, rel=1e-14)
    i = 300
    j = 400
    assert table[i, j] == pytest.approx(1 / (np.pi * 500), rel=1e-6)


def printed_coefficients(n):
    """Eqs. 41–42 of Cheng, Dunn & Brach in their logarithms, with a₁ = m − i + 0.5: another writing of Love."""
    i, j = np.mgrid[0:n, 0:n].astype(float)
    a1 = i + 0.5
    b1 = j + 0.5
    a2 = a1 - 1
    b2 = b1 - 1

    def log(x1, x2, y1, y2):
        return np.log((x1 + np.hypot(y1, x1)) / (x2 + np.hypot(y2, x2)))

    first = a1 * log(b1, b2, a1, a1) - a2 * log(b1, b2, a2, a2)
    second = b1 * log(a1, a2, b1, b1) - b2 * log(a1, a2, b2, b2)
    return (first + second) / np.pi


def test_coefficients_equal_the_printed_logarithms():
    np.testing.assert_allclose(love_coefficients(32, 32), printed_coefficients(32), rtol=1e-11)


@pytest.mark.parametrize("dense", [False, True], ids=["transforms", "matrix"])
@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (7, 3), (40, 25)])
def test_engines_agree_with_the_plain_sum(shape, dense):
    rng = np.random.default_rng(1)
    cells = np.flatnonzero(rng.random(shape).ravel() < 0.6) if np.prod(shape) > 1 else np.array([0])
    rows, columns = np.divmod(cells, shape[1])
    pressure = np.append(rng.standard_normal(cells.size), 0.0)
    table = printed_coefficients(max(shape))
    expected = table[abs(rows[:, None] - rows), abs(columns[:, None] - columns)] @ pressure[:-1]
    out = np.zeros(cells.size + 1)
    multiply(operator(rows, columns, dense=dense), pressure, out)
    np.testing.assert_allclose(out[:-1], expected, atol=(1e-13 if dense else 1e-6) * np.abs(pressure).sum())
    assert out[-1] == 0


@pytest.mark.parametrize("shape", [(1, 1), (13, 40), (400, 500)], ids=["one cell", "in one piece", "in strips"])
def test_a_whole_box_is_displaced_exactly(shape):
    pressure = np.zeros(shape)
    rng = np.random.default_rng(3)
    i, j = (rng.integers(0, n, 40) for n in pressure.shape)
    pressure[i, j] = rng.standard_normal(40)
    table = printed_coefficients(max(pressure.shape))
    expected = sum(
        pressure[k, m] * table[abs(np.arange(pressure.shape[0]) - k)[:, None], abs(np.arange(pressure.shape[1]) - m)]
        for k, m in zip(*np.nonzero(pressure))
    )
    np.testing.assert_allclose(surface_displacement(pressure, 1.0, 1.0), expected, atol=1e-12)


def test_displacement_scales_with_pixel_and_modulus():
    pressure = np.random.default_rng(2).random((6, 9))
    once = surface_displacement(pressure, 1.0, 1.0)
    np.testing.assert_allclose(surface_displacement(pressure, 3.0, 7.0), once * 3 / 7, rtol=1e-12)


def test_a_sphere_s_separation_is_the_circle_s():
    """At 3-4-5 distances from the axis, on a surface whose datum is not its highest point; beside the sphere: inf."""
    x = np.array([-4.0, 0.0, 3.0])
    y = np.array([0.0, 4.0])
    height = np.array([[0.5, 0.0], [0.2, -1.0], [0.0, 0.1]])
    above = 2.0 - height
    ball = np.array([[2.0, np.inf], [0.0, 2.0], [1.0, np.inf]])
    np.testing.assert_allclose(sphere_separation(height, 2.0, x, y, 5.0), above + ball)
    near = sphere_separation(np.zeros((1, 1)), 0.0, np.array([1e-3]), np.zeros(1), 1e6)
    assert near[0, 0] == pytest.approx(0.5e-12, rel=1e-9)  # no cancellation


@pytest.mark.parametrize("pixel", [1e-3, 1.0, 1e3])
def test_a_map_is_read_linearly_and_ends_at_its_rim(pixel):
    """Its highest point touches; what lies beyond its rim by rounding, in whatever unit, is on it."""
    map_x = pixel * np.arange(4)
    map_y = pixel * np.arange(-1, 2)
    heights = 0.5 * np.arange(4)[:, None] - 0.25 * np.arange(3)
    x = pixel * np.array([-1e-3, -1e-7, 0.4, 3.0 + 1e-7, 3.0 + 1e-3])
    y = pixel * np.array([-1.0 - 1e-7, 0.5, 1.1])
    surface = np.linspace(0.0, 1.4, 15).reshape(5, 3)
    separation = map_separation(surface, 3.0, x, y, map_x, map_y, heights)
    rises = 1.5 - (0.5 * np.array([0.0, 0.4, 3.0])[:, None] - 0.25 * np.array([0.0, 1.5]))
    np.testing.assert_allclose(separation[1:4, :2], 3.0 - surface[1:4, :2] + rises, rtol=0, atol=1e-6)
    assert np.isinf(separation[[0, 4]]).all() and np.isinf(separation[:, 2]).all()
