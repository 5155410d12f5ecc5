"""The envelope: equal to the maximum over all paraboloids, written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from roughxr.mechanics.kernels.topography.envelope import asperity_rows, upper_envelope
from roughxr.mechanics.kernels.topography.paraboloid import fit_paraboloids
from roughxr.mechanics.kernels.topography.peaks import search

X = np.arange(37) * 10.0
Y = np.arange(23) * 15.0


def random_asperities(seed, count=40):
    """Vertices in and around the scan, curvatures over many decades: caps, needles and endless ridges."""
    rng = np.random.default_rng(seed)
    first, second = 10 ** rng.uniform(-12, -1, (2, count))
    return {
        "x": rng.uniform(-100, X[-1] + 100, count),
        "y": rng.uniform(-100, Y[-1] + 100, count),
        "height": rng.normal(15, 2, count),
        "curvature_min": np.minimum(first, second),
        "curvature_max": np.maximum(first, second),
        "orientation": rng.uniform(-np.pi / 2, np.pi / 2, count),
    }


def by_definition(asperities):
    """max over i of z_i − (Â x̂² + B̂ ŷ²), one asperity after another over the whole scan."""
    surface = np.full((X.size, Y.size), np.nan)
    for x, y, z, flat, sharp, angle in zip(*asperities.values()):
        if not flat > 0:
            continue
        u = (X - x)[:, None]
        v = (Y - y)[None, :]
        along = u * np.cos(angle) + v * np.sin(angle)
        across = v * np.cos(angle) - u * np.sin(angle)
        paraboloid = z - 0.5 * (flat * along**2 + sharp * across**2)
        surface = np.fmax(surface, paraboloid)
    return surface


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 4, 40]))
@settings(deadline=None, max_examples=30)
def test_equals_its_definition(seed, count):
    asperities = random_asperities(seed, count)
    surface = upper_envelope(X, Y, asperity_rows(**asperities))
    np.testing.assert_allclose(surface, by_definition(asperities), rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("flat", [1e-300, 1e-12, 1e-3])
def test_ridges_of_one_height_are_nowhere_lost(flat):
    """Level along their crest to the last digit: the case where rounding could drop all of them."""
    asperities = random_asperities(2) | {"height": np.full(40, 15.0), "curvature_min": np.full(40, flat)}
    asperities["curvature_max"] = np.full(40, 1e-2)
    asperities["orientation"] = np.repeat([0.0, -np.pi / 2, 0.3, 0.3], 10)
    surface = upper_envelope(X, Y, asperity_rows(**asperities))
    np.testing.assert_allclose(surface, by_definition(asperities), rtol=1e-9)


def test_saddles_and_failed_fits_are_left_out():
    asperities = random_asperities(3)
    asperities["curvature_min"][:5] = [0, -1e-3, np.nan, -np.inf, -1]
    asperities["height"][5] = np.nan
    rows = asperity_rows(**asperities)
    assert len(rows) == 34
    assert np.isfinite(upper_envelope(X, Y, rows)).all()


def test_no_asperity_no_surface():
    rows = asperity_rows(**{name: values[:0] for name, values in random_asperities(4).items()})
    assert np.isnan(upper_envelope(X, Y, rows)).all()
    assert upper_envelope(X[:0], Y, rows).shape == (0, Y.size)


def test_symmetries():
    asperities = random_asperities(5)
    surface = upper_envelope(X, Y, asperity_rows(**asperities))
    turned = asperities | {"x": asperities["y"], "y": asperities["x"]}
    turned["orientation"] = np.pi / 2 - asperities["orientation"]
    np.testing.assert_allclose(upper_envelope(Y, X, asperity_rows(**turned)).T, surface, rtol=1e-10)
    mirrored = asperities | {"x": X[-1] - asperities["x"], "orientation": -asperities["orientation"]}
    np.testing.assert_allclose(upper_envelope(X, Y, asperity_rows(**mirrored))[::-1], surface, rtol=1e-10)
    raised = asperities | {"height": asperities["height"] + 7}
    np.testing.assert_allclose(upper_envelope(X, Y, asperity_rows(**raised)), surface + 7, rtol=1e-10)
    doubled = asperities | {n: 2 * asperities[n] for n in ("height", "curvature_min", "curvature_max")}
    np.testing.assert_allclose(upper_envelope(X, Y, asperity_rows(**doubled)), 2 * surface, rtol=1e-10)


def test_envelope_of_one_dome_is_the_dome():
    """Peaks, fit and envelope together give a paraboloid back to rounding."""
    u = (X - 183.0)[:, None]
    v = (Y - 160.0)[None, :]
    z = 20 - (1e-3 * u**2 + 2e-3 * v**2 - 1e-3 * u * v)
    ix, iy, _ = search(z)
    fit = fit_paraboloids(z, ix, iy, 10, 15)
    vertex = X[ix] + fit.vertex_x, Y[iy] + fit.vertex_y
    rows = asperity_rows(*vertex, fit.height, fit.curvature_min, fit.curvature_max, fit.orientation)
    np.testing.assert_allclose(upper_envelope(X, Y, rows), z, rtol=1e-10, atol=1e-10)


def test_touches_the_fitted_summits_of_a_random_surface():
    z = ndimage.gaussian_filter(np.random.default_rng(7).standard_normal((X.size, Y.size)), 2)
    ix, iy, _ = search(z)
    fit = fit_paraboloids(z, ix, iy, 10, 15, vertex="pixel")
    rows = asperity_rows(X[ix], Y[iy], fit.height, fit.curvature_min, fit.curvature_max, fit.orientation)
    surface = upper_envelope(X, Y, rows)
    kept = fit.curvature_min > 0
    assert (surface[ix, iy][kept] >= fit.height[kept]).all()
