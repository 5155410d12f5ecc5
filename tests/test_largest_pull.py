"""The walk to the largest pull, over a few asperities, beside one that tries every displacement."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from roughxr.kernels.asperity import largest_pull as walk
from roughxr.kernels.asperity.laws import asperities_scales, law
from roughxr.kernels.asperity.superposition import Field
from roughxr.kernels.halfspace.separation import profile_height

from .asperity_loops import asperities_contact

RADIUS, SPHERE, RANGE = 500.0, 0, 1.5
LAWS = ("self_similar", "energy")


def asperities(name, seed, count=9, size=60.0, work=1.0):
    """Return paraboloids at random places, of random shapes and heights, the third of them at the scan's edge."""
    rng = np.random.default_rng(seed)
    A = rng.uniform(1 / 800, 1 / 200, count)
    scales = asperities_scales(A, A * rng.uniform(1.1, 3, count), 39.4, work, law(name, RANGE))
    x, y = rng.uniform(-size, size, (2, count))
    depth = rng.uniform(0, 2, count)
    nobody = np.full((count, 8), -1)
    return Field(x, y, depth - depth.min(), np.zeros(count), np.arange(count) % 3 == 0, nobody, scales)


def offsets(field, x, y):
    return field.depth + np.array(
        [profile_height(r2, RADIUS, SPHERE) for r2 in (field.x - x) ** 2 + (field.y - y) ** 2]
    )


def walked(field, name, x, y):
    """Return the results at centres, a row for each."""
    grid = walk.build_grid(field, law(name, RANGE), RADIUS, SPHERE)
    x, y = (np.atleast_1d(np.asarray(a, dtype=float)) for a in (x, y))
    return walk.pull_offs(x, y, grid, law(name, RANGE).spline, RADIUS, SPHERE)


def forces(field, name, offset, deltas):
    """Return the sum over asperities at displacements, each by its own law."""
    own = np.asarray(deltas)[None, :] - offset[:, None]
    return asperities_contact(own, field.scales, law(name, RANGE).spline).P.sum(axis=0)


def tried(field, name, offset):
    """Return the least force by trying displacements, finely about the lowest."""
    begins = offset + field.scales.end * field.scales.delta
    deltas = np.concatenate([np.linspace(begins.min(), begins.max() + 3, 800), begins + 1e-12, offset])
    found = forces(field, name, offset, deltas)
    lowest = deltas[found.argmin()]
    around = {"bounds": (lowest - 0.05, lowest + 0.05), "method": "bounded", "options": {"xatol": 1e-10}}
    finer = minimize_scalar(lambda delta: forces(field, name, offset, [delta])[0], **around)
    return min(found.min(), finer.fun)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("seed", range(3))
def test_it_is_the_least_of_all_displacements(name, seed):
    field = asperities(name, seed)
    for centre in ((0.0, 10.0), (-60.0, 80.0)):
        (row,) = walked(field, name, *centre)
        offset = offsets(field, *centre)
        delta = row[walk.DELTA]
        assert row[walk.FORCE] == pytest.approx(tried(field, name, offset), rel=1e-9)
        assert row[walk.FORCE] == pytest.approx(forces(field, name, offset, [delta])[0], rel=1e-9)
        held = offset + field.scales.end * field.scales.delta <= delta
        assert row[walk.CONTACTS] == held.sum() > 0
        assert row[walk.AT_EDGE] == field.at_edge[held].sum()
        assert row[walk.FIRST_TOUCH] == pytest.approx(offset.min())
        assert row[walk.EVALUATIONS] > 0


@pytest.mark.parametrize("name", LAWS)
def test_one_alone_pulls_as_its_law_says_wherever_it_stands(name):
    """Units of its own: P* = −1 at δ* = −1/3, by JKR; an ellipse of free shape a little less, and nearby."""
    one = asperities(name, 4, count=1)
    scales = one.scales
    (found,) = walked(one, name, one.x + 120.0, one.y - 90.0)
    offset = profile_height(150.0**2, RADIUS, SPHERE)
    assert found[walk.FORCE] == pytest.approx(-scales.P[0], rel=1e-12 if name == "self_similar" else 0.05)
    assert found[walk.DELTA] == pytest.approx(offset - scales.delta[0] / 3, abs=1e-6 if name == "self_similar" else 0.1)
    assert found[walk.CONTACTS] == found[walk.AT_EDGE] == 1


def test_two_alike_pull_twice_and_one_far_below_adds_nothing():
    one = asperities("self_similar", 4, count=1)
    both = walk._selected(one, np.array([0, 0]))
    far = walk._selected(one, np.array([0, 0]))._replace(depth=np.array([0.0, 200.0]))
    found = [walked(some, "self_similar", one.x, one.y)[0] for some in (one, both, far)]
    single, twice, alone = (row[walk.FORCE] for row in found)
    assert twice == pytest.approx(2 * single, rel=1e-12) and alone == pytest.approx(single, rel=1e-12)
    assert [row[walk.CONTACTS] for row in found] == [1, 2, 1]


def test_where_nothing_adheres_nothing_pulls():
    dry = asperities("self_similar", 1, work=0.0)
    (found,) = walked(dry, "self_similar", 0.0, 0.0)
    assert found[walk.FORCE] == 0 and np.isnan(found[walk.DELTA])


@pytest.mark.parametrize("count", [1, 40])
def test_the_cells_hold_every_asperity_once_and_sum_what_adheres(count):
    field = asperities("self_similar", 7, count=count)
    grid = walk.build_grid(field, law("self_similar"), RADIUS, SPHERE)
    cells, own = grid.cells, grid.field
    np.testing.assert_allclose(np.sort(own.x), np.sort(field.x))
    np.testing.assert_allclose(grid.adhesion, own.scales.P, rtol=1e-5)
    assert (grid.adhesion > own.scales.P).all()  # a bound
    i, j = (((a - low) // cells.side).astype(int) for a, low in ((own.x, cells.x), (own.y, cells.y)))
    assert i.min() == j.min() == 0
    number = np.arange(count)
    assert ((cells.first[i, j] <= number) & (number < cells.first[i, j + 1])).all()
    for row in range(cells.adhesion.shape[0]):
        for column in range(cells.adhesion.shape[1]):
            before = (i < row) & (j < column)
            assert cells.adhesion[row, column] == pytest.approx(grid.adhesion[before].sum(), abs=1e-9)
    assert grid.highest == pytest.approx((own.depth + own.scales.end * own.scales.delta).min())


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("reach", [-1.0, 2.0, 8.0])
def test_those_near_by_are_all_that_begin_below_the_reach_in_order(name, reach):
    field = asperities(name, 3, count=30)
    grid = walk.build_grid(field, law(name, RANGE), RADIUS, SPHERE)
    near = walk.nearby(20.0, -30.0, reach, grid, law(name, RANGE).spline, RADIUS, SPHERE)
    offset = offsets(grid.field, 20.0, -30.0)
    onset = offset + grid.field.scales.end * grid.field.scales.delta
    expected = np.flatnonzero(onset <= reach)
    assert sorted(near.index.tolist()) == expected.tolist() and (reach < 0 or expected.size > 0)
    np.testing.assert_allclose(near.onset, np.sort(onset[expected]))
    np.testing.assert_allclose(near.offset, offset[near.index])
    np.testing.assert_allclose(near.adhesion, np.concatenate([[0.0], np.cumsum(grid.adhesion[near.index])]))
