"""Glued cells and laws of cohesion: exact algebra, and the constants of the mesh derived again."""

import numpy as np
import pytest

from roughxr.kernels import cohesion
from roughxr.kernels.glued import (
    approach,
    elastic_energy,
    glue,
    nothing_glued,
    open_cell,
    unglue,
    with_room,
)
from roughxr.kernels.love import love_coefficients

TABLE = love_coefficients(64, 64)


def coefficients(row, column):
    return TABLE[abs(row[:, None] - row), abs(column[:, None] - column)]


def disc(radius, x=0.0, y=0.0):
    n = int(radius) + 2
    i, j = np.meshgrid(np.arange(-n, n + 1), np.arange(-n, n + 1), indexing="ij")
    inside = np.hypot(i + x, j + y) <= radius
    return i[inside], j[inside]


def test_cells_that_come_and_go_leave_the_dense_solution():
    rng = np.random.default_rng(1)
    separation = rng.random((40, 40))
    glued, count, delta = nothing_glued(separation.shape), 0, 0.0
    for turn in range(500):
        if count > 20 and rng.random() < 0.4:
            k = int(rng.integers(count))
            open_cell(k, -glued.pressure[k] / glued.inverse[k, k], glued, count)  # load-free, so it may go
            unglue(k, glued, count)
            count -= 1
        else:
            i, j = np.argwhere(glued.place < 0)[rng.integers((glued.place < 0).sum())]
            at = glued.row[:count], glued.column[:count]
            sunk = TABLE[abs(at[0] - i), abs(at[1] - j)] @ glued.pressure[:count]
            glued = with_room(glued, count)
            glue(i, j, separation[i, j] - delta + sunk, separation[i, j], glued, count, TABLE)
            count += 1
        if turn % 7 == 0:
            approach(0.1, glued, count)
            delta += 0.1
    assert count > 80
    row, column = glued.row[:count], glued.column[:count]
    matrix = coefficients(row, column)
    shape = delta - separation[row, column] + glued.gap[:count]
    pressure = np.linalg.solve(matrix, shape)
    np.testing.assert_allclose(glued.pressure[:count], pressure, atol=1e-10 * abs(pressure).max())
    np.testing.assert_allclose(glued.inverse[:count, :count] @ matrix, np.eye(count), atol=1e-10)
    assert elastic_energy(separation, delta, glued, count) == pytest.approx(0.5 * pressure @ shape)


def test_room_grows_without_losing_anything():
    separation = np.zeros((20, 20))
    glued, count = nothing_glued(separation.shape), 0
    for i in range(20):
        for j in range(20):
            glued = with_room(glued, count)
            glue(i, j, 0.0, 0.0, glued, count, TABLE)
            count += 1
    row, column = glued.row[:count], glued.column[:count]
    np.testing.assert_allclose(glued.inverse[:count, :count] @ coefficients(row, column), np.eye(count), atol=1e-10)


def test_an_edge_row_along_the_grid_resists_with_0_58():
    # strips of unit width: u = −(2/π) ∫ p ln|x|; the constant left out does not act, as all rows may sink together
    rows = 400
    x = np.arange(rows)[:, None] - np.arange(rows)[None, :]
    part = [(x + h) * np.log(abs(x + h)) - (x + h) for h in (0.5, -0.5)]
    matrix = -2 / np.pi * (part[0] - part[1]) + 10.0
    assert np.linalg.inv(matrix)[0, 0] == pytest.approx(0.5801, abs=2e-3)


@pytest.mark.parametrize("radius", [4.5, 8.0, 14.0])
def test_the_front_lies_inside_its_outline(radius):
    insets = []
    for offset in np.random.default_rng(0).random((12, 2)):
        row, column = disc(radius, *offset)
        stiffness = np.linalg.inv(coefficients(row, column)).sum()
        insets.append(np.sqrt(row.size / np.pi) - stiffness / 2)  # a rigid disc of radius a resists with 2 E* a
    assert np.mean(insets) == pytest.approx(cohesion.INSET, abs=0.004)
    assert np.std(insets) < 0.006


def test_one_cell_alone_has_the_same_inset():
    assert np.sqrt(1 / np.pi) - 1 / TABLE[0, 0] / 2 == pytest.approx(cohesion.INSET, abs=0.002)


LAWS = {
    "griffith": cohesion.griffith(0.3),
    "dugdale": cohesion.cohesive("dugdale", 0.3, 0.2),
    "exponential": cohesion.cohesive("exponential", 0.3, 0.2),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("root", [1.0, 0.9])
def test_laws_do_the_work_of_separation(law, root):
    u = np.linspace(0, 1.01 * law.range, 20001)
    t = np.array([cohesion.traction(x, law, root)[0] for x in u])
    work = np.trapezoid(t, u)
    assert work == pytest.approx(0.3 * root**2, rel=2e-5)
    assert cohesion.remaining_work(0.0, law, root) == pytest.approx(work, rel=2e-5)
    k = 7000
    left = cohesion.remaining_work(u[k], law, root)
    assert left == pytest.approx(work - np.trapezoid(t[: k + 1], u[: k + 1]), abs=1e-5)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_one_cell_in_balance_stays_there(law):
    stiffness = 1.1
    for pressure in np.linspace(-3, 1, 41):
        u = cohesion.balance(pressure, 0.4, stiffness, law, 1.0)
        residual = pressure + stiffness * (u - 0.4) + cohesion.traction(u, law, 1.0)[0]
        assert u >= 0
        assert abs(residual) < 1e-9 if u > 0 else residual > -1e-9


def test_a_strength_without_plateau_is_the_griffith_limit():
    griffith = cohesion.griffith(0.3)
    same = cohesion.cohesive("dugdale", 0.3, griffith.strength)
    assert same.length == pytest.approx(0, abs=1e-12)
    assert same.range == pytest.approx(griffith.range)
