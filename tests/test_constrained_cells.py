"""Constrained cells, cohesive laws and outlines of contact patches: exact algebra, and the constants derived again."""

import numpy as np
import pytest
from scipy import special

from roughxr.kernels.adhesion import cohesive_laws as cohesion
from roughxr.kernels.adhesion.constrained_cells import (
    approach,
    constrain,
    elastic_energy,
    no_cells,
    open_cell,
    release,
    with_room,
)
from roughxr.kernels.adhesion.contact_patches import contact_patches, lengthening
from roughxr.kernels.asperity import elliptic_jkr
from roughxr.kernels.halfspace.love import love_coefficients

TABLE = love_coefficients(64, 64)


def coefficients(row, column):
    return TABLE[abs(row[:, None] - row), abs(column[:, None] - column)]


def disc(radius, x=0.0, y=0.0):
    n = int(radius) + 2
    i, j = np.meshgrid(np.arange(-n, n + 1), np.arange(-n, n + 1), indexing="ij")
    inside = np.hypot(i + x, j + y) <= radius
    return i[inside], j[inside]


@pytest.mark.parametrize("together", [1, 9])
def test_cells_that_come_and_go_leave_the_dense_solution(together):
    rng = np.random.default_rng(1)
    separation = rng.random((40, 40))
    cells, delta = no_cells(separation.shape), 0.0
    for turn in range(500):
        count, number = int(cells.count[0]), int(rng.integers(1, together + 1))
        if count > 20 and rng.random() < 0.4:
            gone = np.sort(rng.choice(count, number, replace=False))
            loads = np.linalg.solve(cells.inverse[gone][:, gone], cells.pressure[gone])
            for k, change in zip(gone, -loads):
                open_cell(k, change, cells)  # load-free, so they may go
            release(gone, cells)
        else:
            free = np.argwhere(cells.place < 0)
            i, j = free[rng.choice(len(free), number, replace=False)].T.copy()
            at = cells.row[:count], cells.column[:count]
            sunk = TABLE[abs(at[0][:, None] - i), abs(at[1][:, None] - j)].T @ cells.pressure[:count]
            cells = with_room(cells, number)
            constrain(i, j, separation[i, j] - delta + sunk, separation[i, j], cells, TABLE)
        assert (cells.place[cells.row, cells.column][: cells.count[0]] == np.arange(cells.count[0])).all()
        assert (cells.place >= 0).sum() == cells.count[0]
        if turn % 7 == 0:
            approach(0.1, cells)
            delta += 0.1
    count = int(cells.count[0])
    assert count > 80
    row, column = cells.row[:count], cells.column[:count]
    matrix = coefficients(row, column)
    shape = delta - separation[row, column] + cells.gap[:count]
    pressure = np.linalg.solve(matrix, shape)
    np.testing.assert_allclose(cells.pressure[:count], pressure, atol=1e-10 * abs(pressure).max())
    np.testing.assert_allclose(cells.inverse[:count, :count] @ matrix, np.eye(count), atol=1e-10)
    assert elastic_energy(separation, delta, cells) == pytest.approx(0.5 * pressure @ shape)


def test_room_grows_without_losing_anything():
    cells = held([(i, j) for i in range(20) for j in range(19)])
    row, column = np.arange(20), np.full(20, 19)
    cells = with_room(cells, 20)
    constrain(row, column, np.zeros(20), np.zeros(20), cells, TABLE)
    count = int(cells.count[0])
    assert count == 400
    row, column = cells.row[:count], cells.column[:count]
    np.testing.assert_allclose(cells.inverse[:count, :count] @ coefficients(row, column), np.eye(count), atol=1e-10)


def test_an_edge_row_along_the_grid_resists_with_0_58():
    # strips of unit width: u = −(2/π) ∫ p ln|x|; the constant left out does not act, as all rows may sink together
    rows = 400
    x = np.arange(rows)[:, None] - np.arange(rows)[None, :]
    part = [(x + h) * np.log(abs(x + h)) - (x + h) for h in (0.5, -0.5)]
    matrix = -2 / np.pi * (part[0] - part[1]) + 10.0
    assert np.linalg.inv(matrix)[0, 0] == pytest.approx(0.5801, abs=2e-3)


def held(places):
    """Return a set that holds the given cells of a window."""
    cells = no_cells((64, 64))
    i, j = np.array(places).T.copy()
    cells = with_room(cells, i.size)
    constrain(i, j, np.zeros(i.size), np.zeros(i.size), cells, TABLE)
    return cells


def found_in(places, closed=None):
    cells = held(places)
    return contact_patches(np.ones(len(places)) if closed is None else np.asarray(closed, float), cells)


@pytest.mark.parametrize("radius", [2.5, 4.5, 8.0, 14.0])
def test_a_round_contact_has_the_radius_of_its_area(radius):
    row, column = disc(radius, 0.3, 0.1)
    found = found_in(list(zip(row + 30, column + 30)))
    assert found.area.size == 1
    assert found.radius[0] == pytest.approx(np.sqrt(row.size / np.pi), rel=0.01)


def test_contacts_are_told_apart_where_no_side_is_shared():
    square = [(i, j) for i in range(10, 13) for j in range(10, 13)]
    found = found_in([*square, (13, 13), (20, 20), (20, 21)])
    assert sorted(found.area) == [1, 2, 9]
    assert len(set(found.of[:9])) == 1


def test_cells_that_are_hardly_closed_join_no_two_contacts():
    row = [(10, j) for j in range(5, 14)]
    assert found_in(row, [1, 1, 1, 1, 0.5, 1, 1, 1, 1]).area.size == 1
    found = found_in(row, [1, 1, 1, 1, 0.1, 1, 1, 1, 1])
    assert sorted(found.area) == pytest.approx([4.0, 4.1])


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 4])
def test_a_long_contact_shortens_faster_than_a_round_one(angle):
    i, j = np.meshgrid(np.arange(1, 63), np.arange(1, 63), indexing="ij")
    x, y = i - 31.3, j - 31.6
    u, v = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    inside = (u / 24) ** 2 + (v / 8) ** 2 <= 1
    found = found_in(list(zip(i[inside], j[inside])))
    around = 4 * 24 * special.ellipe(1 - (8 / 24) ** 2) / (2 * np.pi * np.sqrt(24 * 8))
    assert found.radius[0] == pytest.approx(np.sqrt(24 * 8) / around ** (5 / 3), rel=0.02)


@pytest.mark.parametrize("ratio", [1.5, 2, 5, 10])
def test_outlines_of_adhesive_ellipses_shorten_by_a_power_of_their_length(ratio):
    s = np.linspace(0.2, 0.6, 2001)
    branch = elliptic_jkr.contact_at("energy", ratio, s)
    outline = 4 * branch.a * special.ellipe(1 - (branch.b / branch.a) ** 2)
    area = np.pi * branch.a * branch.b
    shortening = np.gradient(outline) / np.gradient(area) * np.sqrt(area / np.pi)
    k = np.argmin(branch.P)
    ours = lengthening((branch.b / branch.a)[k]) ** (5 / 3)
    assert ours == pytest.approx(shortening[k], rel=0.02)


def test_what_the_outline_takes_is_the_integral_of_lowered_work():
    cells, law = np.linspace(1e-6, 400, 200001), cohesion.griffith(0.3)
    for g in (1.0, 0.7):
        lowered = 1 - np.array([cohesion.toughness(g * np.sqrt(n / np.pi), law) for n in cells])
        total = np.trapezoid(lowered, cells)
        assert cohesion.line_energy(400.0, g * np.sqrt(400 / np.pi), law) == pytest.approx(total, rel=1e-5)


LAWS = {
    "griffith": cohesion.griffith(0.3),
    "dugdale": cohesion.finite_range("dugdale", 0.3, 0.2),
    "exponential": cohesion.finite_range("exponential", 0.3, 0.2),
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
    same = cohesion.finite_range("dugdale", 0.3, griffith.strength)
    assert same.length == pytest.approx(0, abs=1e-12)
    assert same.range == pytest.approx(griffith.range)
