"""Paraboloids: recovered to rounding where the surface is one, and honest about it where it is not."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import ndimage

from roughxr.mechanics.kernels.topography.paraboloid import fit_paraboloids, principal
from roughxr.mechanics.kernels.topography.peaks import search

CENTRE = 8  # pixel about which the test surfaces are drawn
SIDE = 2 * CENTRE + 1


def dome(flat, sharp, angle, at=(0.0, 0.0), dx=1.0, dy=1.0, top=0.0):
    """An exact paraboloid: curvatures (nm⁻¹), direction of the flattest (rad), vertex from CENTRE (nm)."""
    x = (np.arange(SIDE) - CENTRE)[:, None] * dx - at[0]
    y = (np.arange(SIDE) - CENTRE)[None, :] * dy - at[1]
    along = x * np.cos(angle) + y * np.sin(angle)
    across = y * np.cos(angle) - x * np.sin(angle)
    return top - 0.5 * (flat * along**2 + sharp * across**2)


def fit_centre(z, dx=1.0, dy=1.0, **options):
    """The fit at CENTRE alone, as plain numbers."""
    fit = fit_paraboloids(z, np.array([CENTRE]), np.array([CENTRE]), dx, dy, **options)
    return type(fit)(*(values[0] for values in fit))


def assert_same_direction(a, b, tolerance=1e-9):
    """Directions have no sense: equal up to half a turn."""
    np.testing.assert_allclose(np.sin(np.subtract(a, b)), 0, atol=tolerance)


def random_surface(seed, shape=(24, 30)):
    return ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal(shape), 1.5)


shapes = st.fixed_dictionaries(
    {
        "flat": st.floats(1e-4, 1e-1),
        "sharp": st.floats(1e-4, 1e-1),
        "angle": st.floats(-np.pi / 2, np.pi / 2, exclude_max=True),
        "dx": st.floats(0.5, 20),
        "dy": st.floats(0.5, 20),
        "top": st.floats(-30, 30),
    }
)


def assert_recovers(fit, shape):
    flat, sharp = sorted((shape["flat"], shape["sharp"]))
    turned = shape["angle"] + (np.pi / 2 if shape["flat"] > shape["sharp"] else 0)
    # what rounding leaves of a curvature, from heights of this size over steps of this size
    heights = abs(shape["top"]) + sharp * 16 * (shape["dx"] ** 2 + shape["dy"] ** 2)
    rounding = 1e-14 * heights / min(shape["dx"], shape["dy"]) ** 2
    np.testing.assert_allclose([fit.curvature_min, fit.curvature_max], [flat, sharp], rtol=1e-9, atol=rounding)
    assert fit.fit_rms <= 1e-13 * heights
    if sharp - flat > 1e-3 * sharp + 1e3 * rounding:
        assert_same_direction(fit.orientation, turned, 1e-6)
    assert -np.pi / 2 <= fit.orientation < np.pi / 2


@given(shapes, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
@settings(deadline=None)
def test_exact_paraboloid_between_pixels(shape, u, v):
    at = u * shape["dx"], v * shape["dy"]
    assume(max(shape["flat"], shape["sharp"]) < 1e2 * min(shape["flat"], shape["sharp"]))
    fit = fit_centre(dome(**shape, at=at), shape["dx"], shape["dy"])
    assert_recovers(fit, shape)
    assert not (fit.vertex_fixed or fit.edge or fit.saddle)
    np.testing.assert_allclose([fit.vertex_x, fit.vertex_y], at, atol=1e-6 * (shape["dx"] + shape["dy"]))
    assert fit.height == pytest.approx(shape["top"], abs=1e-6)


@given(shapes, st.sampled_from([3, 5, 7]))
@settings(deadline=None)
def test_exact_paraboloid_on_a_pixel_by_the_papers_three_coefficients(shape, size):
    fit = fit_centre(dome(**shape), shape["dx"], shape["dy"], size=size, vertex="pixel")
    assert_recovers(fit, shape)
    assert fit.vertex_fixed
    assert (fit.vertex_x, fit.vertex_y, fit.height) == (0, 0, shape["top"])


@pytest.mark.parametrize("degrees", range(-90, 90, 15))
def test_orientation_is_that_of_the_flattest_direction(degrees):
    fit = fit_centre(dome(0.01, 0.04, np.radians(degrees), dx=2, dy=3), 2, 3)
    assert_same_direction(fit.orientation, np.radians(degrees))


def test_orientation_of_pure_cases():
    assert principal(1.0, 2.0, 0.0) == (2, 4, 0)  # flattest along x
    assert principal(2.0, 1.0, 0.0) == (2, 4, -np.pi / 2)  # along y: the half-open end of the interval
    assert principal(1.0, 1.0, 0.0)[:2] == (2, 2)
    # A = B, where arctan(C / (A − B)) fails: depth x² + y² + x y is least along x = −y
    assert principal(1.0, 1.0, 1.0) == pytest.approx((1, 3, -np.pi / 4))


@given(st.integers(0, 2**32 - 1), st.sampled_from(["fitted", "pixel"]))
@settings(deadline=None, max_examples=20)
def test_invariance(seed, vertex):
    z = random_surface(seed)
    ix, iy, _ = search(z)
    dx = 2.0
    dy = 3.0
    fit = fit_paraboloids(z, ix, iy, dx, dy, vertex=vertex)

    def check(other, angle, scale=1, shift=0):
        np.testing.assert_allclose(other.height, scale * fit.height + shift, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(other.curvature_min, scale * fit.curvature_min, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(other.curvature_max, scale * fit.curvature_max, rtol=1e-9)
        np.testing.assert_allclose(other.fit_rms, scale * fit.fit_rms, rtol=1e-9, atol=1e-12)
        assert_same_direction(other.orientation, angle, 1e-7)
        for flag in ("saddle", "edge", "vertex_fixed"):
            np.testing.assert_array_equal(getattr(other, flag), getattr(fit, flag))

    last = z.shape[0] - 1
    check(fit_paraboloids(z + 5, ix, iy, dx, dy, vertex=vertex), fit.orientation, shift=5)
    check(fit_paraboloids(z * 7, ix, iy, dx, dy, vertex=vertex), fit.orientation, scale=7)
    check(fit_paraboloids(z.T, iy, ix, dy, dx, vertex=vertex), np.pi / 2 - fit.orientation)
    check(fit_paraboloids(z[::-1], last - ix, iy, dx, dy, vertex=vertex), -fit.orientation)
    check(fit_paraboloids(z.T[:, ::-1], iy, last - ix, dy, dx, vertex=vertex), np.pi / 2 + fit.orientation)


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=20)
def test_free_fit_is_never_worse_and_stays_near_its_pixel(seed):
    z = random_surface(seed)
    ix, iy, _ = search(z)
    free, fixed = (fit_paraboloids(z, ix, iy, 2, 3, vertex=vertex) for vertex in ("fitted", "pixel"))
    assert (free.fit_rms <= fixed.fit_rms * (1 + 1e-12)).all()
    assert (np.abs(free.vertex_x) <= 2).all() and (np.abs(free.vertex_y) <= 3).all()
    held = free.vertex_fixed
    assert not (free.saddle & ~held).any()
    for free_value, fixed_value in zip(free, fixed):
        np.testing.assert_array_equal(free_value[held], fixed_value[held])


@pytest.mark.parametrize("cut", ["side", "corner", "nan"])
@pytest.mark.parametrize("vertex", ["fitted", "pixel"])
def test_clipped_patch_is_fitted_on_what_is_there(cut, vertex):
    at = (0.3, -0.2) if vertex == "fitted" else (0.0, 0.0)
    z = dome(0.02, 0.05, 0.4, at=at, top=2.0)
    i = j = CENTRE
    if cut == "nan":
        z[CENTRE + 2, CENTRE - 1] = np.nan
    else:
        z = z[CENTRE - 1 :]
        i = 1
        z, j = (z[:, CENTRE - 1 :], 1) if cut == "corner" else (z, CENTRE)
    fit = fit_paraboloids(z, np.array([i]), np.array([j]), 1, 1, vertex=vertex)
    assert fit.edge[0] and not fit.saddle[0]
    np.testing.assert_allclose([fit.curvature_min[0], fit.curvature_max[0]], [0.02, 0.05], rtol=1e-11)
    np.testing.assert_allclose([fit.vertex_x[0], fit.vertex_y[0]], at, atol=1e-11)
    assert_same_direction(fit.orientation[0], 0.4)


def test_too_few_pixels_give_nan():
    z = dome(0.02, 0.05, 0.4)
    z[CENTRE + 1 :] = z[:CENTRE] = np.nan  # a single line tells nothing across itself
    fit = fit_centre(z)
    assert fit.edge and not fit.saddle
    assert np.isnan([fit.height, fit.curvature_min, fit.curvature_max, fit.orientation, fit.fit_rms]).all()
    z[CENTRE, CENTRE] = np.nan
    assert np.isnan(fit_centre(z).height)


def test_saddle_and_far_vertex_hold_the_vertex_at_the_pixel():
    saddle = fit_centre(dome(-0.01, 0.05, 0.3))
    assert saddle.saddle and saddle.vertex_fixed
    assert saddle.curvature_min == pytest.approx(-0.01)
    far = fit_centre(dome(0.02, 0.05, 0.3, at=(1.5, 0.0)))
    assert far.vertex_fixed and (far.vertex_x, far.vertex_y) == (0, 0)


def test_no_peaks():
    none = np.empty(0, int)
    assert fit_paraboloids(np.zeros((5, 5)), none, none, 1, 1).height.shape == (0,)
