"""What a contact may look like before it is solved: on fields of which the answer is known cell by cell."""

import numpy as np
import pytest

from roughxr.kernels.halfspace import warm_start
from roughxr.kernels.jit import kernel


@kernel
def extrapolated(depth, step, pressure, displacement, ahead, cap, row, column):
    return warm_start.extrapolated(depth, step, pressure, displacement, ahead, cap, row, column)


@kernel
def half_deep(depth, slack):
    return warm_start.half_deep(depth, slack)


@kernel
def coarser(depth):
    return warm_start.coarser(depth)


@kernel
def refined(pressure, displacement, depth, cap):
    return warm_start.refined(pressure, displacement, depth, cap)


def plane(rows, columns, cell=1.0):
    """Return a plane at the centres of cells of a side, the corner of the first at the origin."""
    i, j = (np.arange(n) + 0.5 for n in (rows, columns))
    return cell * (3.0 * i[:, None] - 2.0 * j) + 1.0


def test_pressures_go_on_along_the_line_through_two_solutions():
    """From δ = 1 and 3 to 4: half of the way between them, again; not below 0, not above the cap."""
    rng = np.random.default_rng(0)
    slope, start = rng.uniform(-1, 1, (12, 13)), rng.uniform(0, 4, (12, 13))
    pressure = np.stack([np.maximum(start + slope * delta, 0.0) for delta in (1.0, 3.0)])
    found = extrapolated(np.zeros((8, 9)), 1.0, pressure, np.zeros((2, 12, 13)), 0.5, 5.0, 2, 1)
    first, last = pressure[:, 2:10, 1:10]
    np.testing.assert_allclose(found.pressure, np.clip(last + 0.5 * (last - first), 0, 5.0))
    assert ((found.pressure == 0) & (last > 0)).any() and (found.pressure == 5.0).any()
    alone = extrapolated(np.zeros((8, 9)), 1.0, pressure[1:], np.zeros((1, 12, 13)), np.nan, 9.0, 2, 1)
    np.testing.assert_array_equal(alone.pressure, last)


def test_cells_touch_that_did_or_that_penetrate_by_a_tenth_of_the_step():
    """Displaced by 1 and 2 before, by 3 next: the gap is 3 less the depth; what is not closed by then is left out."""
    depth = np.array([[2.0, 2.9, 3.1, 3.3, 4.0]])
    displacement = np.stack([np.full((1, 5), 1.0), np.full((1, 5), 2.0)])
    pressure = np.zeros((2, 1, 5))
    pressure[1, 0, 1] = 0.5
    found = extrapolated(depth, 2.0, pressure, displacement, 1.0, 9.0, 0, 0)
    assert found.touching.tolist() == [[False, True, False, True, True]]
    assert found.possible.tolist() == [[False, True, True, True, True]]
    capped = extrapolated(depth, 2.0, pressure, displacement, 1.0, 0.9, 0, 0)
    assert capped.touching.tolist() == [[False, False, False, True, True]]  # it yields: its gap is not held at zero


def test_a_displacement_known_once_stays_and_one_that_is_not_known_is_possible():
    """It counts as grown by half the step, 1 nm, where it is asked what touches, and penetrates by 0.2 nm at least."""
    depth = np.array([[1.9, 2.1, 3.1, 3.3, 9.0]])
    displacement = np.array([[[2.0, 2.0, 2.0, 2.0, np.nan]]])
    found = extrapolated(depth, 2.0, np.zeros((1, 1, 5)), displacement, np.nan, 9.0, 0, 0)
    assert found.touching.tolist() == [[False, False, False, True, False]]
    assert found.possible.tolist() == [[False, True, True, True, True]]


def test_few_cells_start_from_those_deeper_than_half():
    depth = np.array([[-0.3, -0.1, 0.9, 1.1, 2.0]])
    found = half_deep(depth, 0.2)
    assert found.touching.tolist() == [[False, False, False, True, True]]
    assert found.possible.tolist() == [[False, True, True, True, True]]
    assert not found.pressure.any()


@pytest.mark.parametrize("shape", [(24, 32), (21, 35)])
def test_larger_cells_hold_the_means_of_four_while_they_are_many(shape):
    levels = coarser(plane(*shape) + 1000.0)
    assert [level.shape for level in levels[:2]] == [shape, tuple((n + 1) // 2 for n in shape)]
    sizes = [level.size for level in levels]
    assert sizes[-1] <= warm_start.DENSE_LIMIT < sizes[-2]
    n, m = (size // 2 for size in shape)
    np.testing.assert_allclose(levels[1][:n, :m], plane(n, m, 2.0) + 1000.0)
    rows, columns = (size % 2 for size in shape)
    continued = np.pad(levels[0], ((0, rows), (0, columns)), mode="edge")
    pairs = continued.reshape(n + rows, 2, m + columns, 2)
    np.testing.assert_allclose(levels[1], pairs.mean(axis=(1, 3)))
    assert len(coarser(plane(3, 200) + 1000.0)) == 1  # too narrow
    assert len(coarser(-plane(24, 32) - 1000.0)) == 1  # of which none overlap


def test_a_coarse_solution_is_read_between_its_cells_with_half_its_pressures():
    coarse = plane(6, 8, 2.0)
    depth = plane(12, 16) - np.where(np.indices((12, 16)).sum(axis=0) % 2, 2.0, -2.0)
    inner = slice(1, -1), slice(1, -1)
    pressure = np.zeros((6, 8))
    pressure[2, 3], pressure[4, 1] = 10.0, 6.0
    found = refined(pressure, coarse, depth, 4.0)
    np.testing.assert_allclose(found.pressure, np.minimum(np.kron(0.5 * pressure, np.ones((2, 2))), 4.0))
    gap = np.where(np.indices((12, 16)).sum(axis=0) % 2, 2.0, -2.0)
    pressed, free = found.pressure > 0, found.pressure < 4.0
    np.testing.assert_array_equal(
        found.touching[inner], ((gap < 0) | (pressed & (found.pressure > gap)) & free)[inner] & free[inner]
    )
    margin = 0.05 * depth.max()
    np.testing.assert_array_equal(found.possible[inner], (found.touching | (gap < margin))[inner])
    assert (found.touching & (gap > 0)).any() and not found.touching[inner].all()
