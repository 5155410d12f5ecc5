"""A sphere at rest on asperities, and the moment that holds it there: what is known of one and of two."""

import numpy as np
import pytest

from roughxr.kernels.asperity import rotation
from roughxr.kernels.asperity.laws import asperities_scales, law
from roughxr.kernels.asperity.rotation import HINGE, MOMENT, PULL, PULL_HINGE

SPLINE = law("self_similar").spline


def scales_of(count, work=1.0):
    curvature = np.full(count, 1 / 400)
    return asperities_scales(curvature, curvature, 39.4, work, law("self_similar"))


def moments(x, delta, load=0.0, direction=0.0, work=1.0):
    """Return what is found along one direction for round asperities at x on one line, y = 0."""
    x = np.asarray(x, dtype=float)
    nothing, delta = np.zeros(x.size), np.full(x.size, delta, dtype=float)
    (found,) = rotation.resisting_moments(
        np.array([direction]), x, nothing, nothing, delta, scales_of(x.size, work), load, SPLINE
    )
    return found


def test_one_asperity_is_peeled_about_its_own_edge():
    """The largest |P| a of JKR's branch is 1.087872 P_c a_c, the largest |P| P_c; along any direction."""
    scales = scales_of(1)
    for direction in (0.0, 1.0, 4.0):
        found = moments([0.0], 0.0, direction=direction)
        assert found[MOMENT] == pytest.approx(1.087872 * scales.P[0] * scales.a[0], rel=1e-4)
        assert found[PULL] == pytest.approx(scales.P[0], rel=1e-3)
        assert found[PULL_HINGE] == pytest.approx(scales.a[0], rel=0.05)  # a* = 1 at the largest pull
        assert found[HINGE] > found[PULL_HINGE]


def test_two_far_apart_hold_by_the_distance_between_them():
    """Rolled towards the one at +L the other is lifted off at the lever 2L, by P_c; towards the other side likewise."""
    scales, far = scales_of(1), 2000.0
    for direction in (0.0, np.pi):
        found = moments([-far, far], 0.0, direction=direction)
        assert found[MOMENT] == pytest.approx(2 * far * scales.P[0], rel=0.02)
        assert found[HINGE] == pytest.approx(far, rel=0.02)
        assert found[PULL] == pytest.approx(found[MOMENT] / found[PULL_HINGE], rel=1e-3)


def test_a_load_adds_its_own_moment_about_the_edge():
    free, loaded = (moments([-2000.0, 2000.0], 0.0, load=load) for load in (0.0, 50.0))
    assert loaded[MOMENT] == pytest.approx(free[MOMENT] + 50.0 * free[HINGE], rel=1e-3)


def test_an_edge_never_ahead_of_the_axis_is_tipped_by_no_pull():
    behind = moments([-500.0], 0.0)
    assert behind[PULL] == np.inf and behind[MOMENT] > 0
    assert np.isnan(moments([0.0], -1e3)).all()  # out of touch


@pytest.mark.parametrize("start", [-3.0, 2.0, 60.0])
@pytest.mark.parametrize("load", [-20.0, 0.0, 30.0, 5000.0])
def test_at_rest_the_asperities_carry_the_load(load, start):
    """The first displacement below the start that carries no more: just above it they carry more."""
    scales, offset = scales_of(4), np.array([0.0, 0.5, 1.0, 6.0])
    found = rotation.rest(offset, scales, load, start, SPLINE)
    force, area = rotation.total_force(found, offset, scales, SPLINE)
    assert force == pytest.approx(load, rel=1e-9, abs=1e-6) and area > 0
    for above in (1e-3, 0.1, 1.0):
        assert rotation.total_force(found + above, offset, scales, SPLINE)[0] > load
    assert rotation.total_force(found - 1e-3, offset, scales, SPLINE)[0] < load


def test_nothing_to_rest_on_is_no_place_to_rest():
    assert np.isnan(rotation.rest(np.zeros(0), scales_of(0), 0.0, 0.0, SPLINE))


def test_the_area_of_round_contacts_is_that_of_their_radii():
    """Without adhesion a² = Rδ and P = 4/3 E* √R δ^{3/2}."""
    dry = scales_of(2, work=0.0)
    force, area = rotation.total_force(3.0, np.array([0.0, 1.0]), dry, SPLINE)
    assert area == pytest.approx(np.pi * 200 * (3.0 + 2.0))
    assert force == pytest.approx(4 / 3 * 39.4 * np.sqrt(200) * (3**1.5 + 2**1.5))
