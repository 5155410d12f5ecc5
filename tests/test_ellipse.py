"""The ellipse: elliptic integrals, its shape, and Hertz's contact."""

import numpy as np
import pytest
from scipy import integrate, special

from roughxr.mechanics.kernels.asperity.ellipse import (
    associate_integrals,
    axis_ratio,
    curvature_ratio,
    elliptic_integrals,
    hertz,
    shape,
)

E_STAR = 39.407  # GPa


@pytest.mark.parametrize("lam", [1.0, 1 - 1e-12, 0.99, 0.5, 0.1, 1e-3, 1e-6])
def test_elliptic_integrals_agree_with_scipy(lam):
    expected = special.ellipkm1(lam**2), special.ellipe(1 - lam**2)
    np.testing.assert_allclose(elliptic_integrals(lam), expected, rtol=3e-15)


@pytest.mark.parametrize("lam", [1.0, 0.7, 0.05])
def test_associate_integrals_are_what_they_are_called(lam):
    def over_delta(f):
        def integrand(t):
            return f(t) ** 2 / np.sqrt(1 - (1 - lam**2) * np.sin(t) ** 2)

        return integrate.quad(integrand, 0, np.pi / 2)[0]

    np.testing.assert_allclose(associate_integrals(lam), [over_delta(np.cos), over_delta(np.sin)], rtol=1e-12)


@pytest.mark.parametrize("ratio", [1.0, 1 + 1e-14, 1 + 1e-9, 1.001, 1.5, 10.0, 1e3, 1e6, 1e9])
def test_axis_ratio_inverts_equation_7(ratio):
    assert curvature_ratio(axis_ratio(ratio)) == pytest.approx(ratio, rel=3e-15)


def test_axis_ratio_leaves_the_circle_smoothly():
    assert axis_ratio(1.0) == 1.0
    steps = np.array([1e-10, 1e-7, 1e-4])
    slopes = [(axis_ratio(1 + h) - 1) / h for h in steps]
    np.testing.assert_allclose(slopes, -2 / 3, atol=1e-4)


@pytest.mark.parametrize("A, B", [(0.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (2.0, 1.0), (0.0, 0.0), (np.nan, 1.0)])
def test_what_is_no_peak_has_no_shape(A, B):
    assert np.isnan(shape(A, B))
    assert np.isnan(hertz(1.0, A, B, E_STAR).P)


@pytest.mark.parametrize(
    "ratio, lam, c, delta, p0",
    [
        (1.0, 1, 1, 1, 1),
        (1.5, 0.76329879, 0.997730, 0.997724, 1.004556),
        (2.0, 0.63059570, 0.993436, 0.993393, 1.013259),
        (5.0, 0.34599909, 0.966886, 0.965815, 1.069669),
        (10.0, 0.22224952, 0.937098, 0.933330, 1.138753),
    ],
)
def test_ellipse_beside_the_sphere_of_equal_load(ratio, lam, c, delta, p0):
    """Relative to the sphere of Re = 1/(2√(AB)) under the same load."""
    sphere = hertz(1.0, 0.5, 0.5, E_STAR)
    A = 0.5 / np.sqrt(ratio)
    B = 0.5 * np.sqrt(ratio)
    depth = (sphere.P / hertz(1.0, A, B, E_STAR).P) ** (2 / 3)
    ellipse = hertz(depth, A, B, E_STAR)
    assert ellipse.b / ellipse.a == pytest.approx(lam, abs=5.1e-9)
    assert np.sqrt(ellipse.a * ellipse.b) / sphere.a == pytest.approx(c, abs=5.1e-7)
    assert depth == pytest.approx(delta, abs=5.1e-7)
    assert ellipse.p0 / sphere.p0 == pytest.approx(p0, abs=5.1e-7)


def test_hertz_satisfies_johnsons_relations():
    delta = 3.0
    A = 1 / 400
    B = 1 / 90
    P, a, b, area, p0 = hertz(delta, A, B, E_STAR)
    lam = b / a
    K = special.ellipkm1(lam**2)
    E = special.ellipe(1 - lam**2)
    assert area == pytest.approx(np.pi * a * b)
    assert p0 == pytest.approx(3 * P / (2 * np.pi * a * b))
    assert delta == pytest.approx(p0 * b * K / E_STAR)
    assert delta == pytest.approx(A * a**2 + B * b**2)
    assert a**3 == pytest.approx(3 * P / (2 * np.pi * E_STAR * A) * (K - E) / (1 - lam**2))


@pytest.mark.parametrize("delta", [0.0, -1.0])
def test_no_contact_without_overlap(delta):
    assert hertz(delta, 0.01, 0.02, E_STAR) == (0, 0, 0, 0, 0)
