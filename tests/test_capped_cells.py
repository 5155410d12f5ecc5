"""Constrained cells that yield: the conditions of the cap, by dense algebra, however many give way together."""

import numpy as np
import pytest

from roughxr.kernels.adhesion import capped_cells, cohesive_laws
from roughxr.kernels.adhesion.constrained_cells import constrain, displacement_at, no_cells, open_cell, release
from roughxr.kernels.adhesion.equilibrium import Problem
from roughxr.kernels.halfspace.love import love_coefficients

TABLE = love_coefficients(16, 16)
SHAPE, DELTA, CAP = (9, 9), 2.0, 0.3


def problem(room):
    """Return a cap on a bowl, on which so many cells can give way together."""
    separation = np.full(SHAPE, np.inf)
    i, j = np.indices((7, 7)) - 3
    separation[1:-1, 1:-1] = 0.15 * (i**2 + 1.3 * j**2 + 0.2 * i)
    nothing, size = np.zeros(SHAPE), np.zeros(room)
    work = {"open": size.astype(np.int64), "matrix": np.zeros((room, room)), "step": size}
    limits = {"tolerance": 1e-9, "max_iterations": 100, "max_cells": 81, "cap": CAP, "limit": CAP}
    law = cohesive_laws.griffith(0.3)
    fields = {"roots": np.ones(SHAPE), "dent": nothing.copy(), "stays": nothing}
    return Problem(separation=separation, coefficients=TABLE, law=law, w=0.3, **limits, **fields, **work)


def closed(body, within):
    """Return the cells that lie within a depth, all at no gap."""
    cells = no_cells(SHAPE)
    i, j = np.ascontiguousarray(np.argwhere(body.separation < DELTA - within).T)
    constrain(i, j, body.separation[i, j] - DELTA, body.separation[i, j], cells, TABLE)  # nothing presses yet
    for k in range(cells.count[0]):
        open_cell(k, -cells.gap[k], cells)
    return cells


def members(cells):
    count = int(cells.count[0])
    return cells.row[:count], cells.column[:count], cells.pressure[:count]


@pytest.mark.parametrize("room", [1, 81], ids=["one by one", "together"])
def test_pressures_stay_below_the_cap_and_reach_it_where_cells_gave_way(room):
    body = problem(room)
    first, cells = body.separation.copy(), closed(body, 0.5)
    assert (members(cells)[2] > CAP).sum() > 3
    assert not capped_cells.bears(capped_cells.OVER, body, cells)
    capped_cells.begin_to_yield(body)
    capped_cells.give_way(body, DELTA, cells)
    row, column, pressure = members(cells)
    dent = body.dent[row, column]
    matrix = TABLE[abs(row[:, None] - row), abs(column[:, None] - column)]
    np.testing.assert_allclose(matrix @ pressure, DELTA - first[row, column] - dent, atol=1e-9)
    np.testing.assert_allclose(body.separation[row, column], first[row, column] + dent)
    assert dent.min() == 0.0 < dent.max() and body.dent.sum() == pytest.approx(dent.sum())
    assert pressure.max() <= CAP * (1 + 1e-8)
    np.testing.assert_allclose(pressure[dent > 0], CAP, rtol=1e-8)
    assert capped_cells.bears(1e-8, body, cells) and not capped_cells.left_open(body, cells)


def test_what_gave_way_before_stays_and_what_did_so_too_far_comes_back():
    """Dents of this step return until the cap is reached, those of earlier ones do not, though nothing bears there."""
    body = problem(81)
    body.stays[4, 3] = body.dent[4, 3] = 1.4
    body.dent[4, 4] = 1.2
    body.separation[:] += body.dent
    cells = closed(body, 0.2)
    _, _, pressure = members(cells)
    assert pressure[cells.place[4, 4]] < CAP
    assert not capped_cells.bears(capped_cells.OVER, body, cells)
    capped_cells.give_way(body, DELTA, cells)
    assert body.dent[4, 3] == 1.4 and 0.0 <= body.dent[4, 4] < 1.2
    assert capped_cells.bears(1e-8, body, cells)
    capped_cells.begin_to_yield(body)
    np.testing.assert_array_equal(body.stays, body.dent)


def test_an_open_cell_that_gave_way_in_this_step_went_too_far():
    """It comes back until it touches: as far as its gap."""
    body = problem(81)
    cells = closed(body, 0.5)
    i, j = cells.row[0], cells.column[0]
    assert not capped_cells.left_open(body, cells)
    open_cell(0, -cells.pressure[0] / cells.inverse[0, 0], cells)  # free of load, so that it may go
    body.dent[i, j] = 0.9
    assert not capped_cells.left_open(body, cells)
    release(np.array([0]), cells)
    assert capped_cells.left_open(body, cells)
    gap = body.separation[i, j] - DELTA + displacement_at(i, j, cells, TABLE)
    body.separation[i, j] += 0.4 - gap
    before = body.separation[i, j]
    capped_cells.give_way(body, DELTA, cells)
    assert body.dent[i, j] == pytest.approx(0.5)
    assert body.separation[i, j] == pytest.approx(before - 0.4)
