"""Catalogue and reconstruction with labels: what a scan of known shape must give."""

import numpy as np
import pytest
from scipy.special import ellipk  # SciPy takes the parameter e², the kernels the axis ratio

from roughxr.catalogue import asperities
from roughxr.kernels.asperity.ellipse import elliptic_integrals
from roughxr.reconstruction import reconstruct

from .surfaces import glass_pair, rough, scan


def paraboloids(centres, n=81, pixel=5.0, flattest=0.4, curvatures=(0.002, 0.006)):
    """Return the upper envelope of equal paraboloids at the given centres (nm), 10 nm high."""
    x = (np.arange(n) - (n - 1) / 2) * pixel
    surface = np.full((n, n), -np.inf)
    for cx, cy in centres:
        u = (x[:, None] - cx) * np.cos(flattest) + (x[None, :] - cy) * np.sin(flattest)
        v = -(x[:, None] - cx) * np.sin(flattest) + (x[None, :] - cy) * np.cos(flattest)
        surface = np.maximum(surface, 10 - curvatures[0] / 2 * u**2 - curvatures[1] / 2 * v**2)
    return scan(surface, pixel=pixel)


def test_exact_paraboloids_are_recovered_to_rounding():
    centres = [(-91.3, -80.2), (83.1, 77.7), (-74.9, 92.4)]
    found = asperities(paraboloids(centres)).sortby("x")
    assert found.sizes["asperity"] == 3
    np.testing.assert_allclose(np.c_[found.x, found.y], sorted(centres), atol=1e-9)
    np.testing.assert_allclose(found.height, 10, atol=1e-10)
    np.testing.assert_allclose(found.curvature_min, 0.002, rtol=1e-9)
    np.testing.assert_allclose(found.curvature_max, 0.006, rtol=1e-9)
    np.testing.assert_allclose(found.orientation, 0.4, atol=1e-9)
    np.testing.assert_allclose(found.fit_rms, 0, atol=1e-12)
    assert not (found.saddle | found.edge | found.vertex_fixed).any()


def test_axis_ratio_is_that_of_hertz():
    """λ solves B/A = [E − λ²K]/[λ²(K − E)] (eq. 7), here with SciPy's integrals."""
    found = asperities(paraboloids([(1.0, 2.0)]))
    lam = found.axis_ratio.item()
    K, E = elliptic_integrals(lam)
    assert K == pytest.approx(ellipk(1 - lam**2), rel=1e-12)
    assert (E - lam**2 * K) / (lam**2 * (K - E)) == pytest.approx(3.0, rel=1e-9)


def test_catalogue_is_labelled_and_remembers_its_scan():
    found = asperities(glass_pair(scan(rough(40))))
    for name in found.variables:
        assert found[name].attrs["units"], name
    assert float(found.datum_height) == float(scan(rough(40)).height.max())
    assert float(found.patch_radius) == pytest.approx(2.5 * 9.77)
    assert float(found.sphere_radius) == 3000


def test_a_plateau_is_one_peak():
    height = np.zeros((20, 20))
    height[5:8, 9:12] = 1.0
    found = asperities(scan(height))
    assert found.sizes["asperity"] == 1 and int(found.plateau_size[0]) == 9


def test_a_flat_scan_has_no_asperity_and_cannot_be_reconstructed():
    assert asperities(scan(np.zeros((20, 20)))).sizes["asperity"] == 0
    with pytest.raises(ValueError, match="at least one asperity"):
        reconstruct(scan(np.zeros((20, 20))))


def test_the_envelope_of_exact_paraboloids_is_the_surface():
    surface = paraboloids([(-91.3, -80.2), (83.1, 77.7)])
    envelope = reconstruct(surface)
    np.testing.assert_allclose(envelope.height, surface.height, atol=1e-8)
    assert envelope.attrs["residual_rms"] < 1e-8


def test_the_envelope_matches_peaks_and_its_residual_is_told():
    surface = scan(rough(96, smooth=3.0))
    envelope = reconstruct(surface)
    difference = (envelope.height - surface.height).values
    assert envelope.attrs["residual_rms"] == pytest.approx(np.sqrt((difference**2).mean()))
    catalogue = asperities(surface)
    peaks = surface.height.sel(x=catalogue.x, y=catalogue.y, method="nearest")
    above = envelope.height.sel(x=catalogue.x, y=catalogue.y, method="nearest") - peaks
    assert float(np.abs(above).median()) < 0.05 * float(surface.height.std())


def test_a_reach_leaves_the_rest_missing():
    envelope = reconstruct(paraboloids([(0.0, 0.0)]), reach="50 nm")
    known = np.isfinite(envelope.height.values)
    r = np.hypot(*np.meshgrid(envelope.x, envelope.y, indexing="ij"))
    np.testing.assert_array_equal(known, r <= 50)


@pytest.mark.parametrize(
    ("options", "says"),
    [({"patch": 4}, "odd"), ({"patch": 1}, "from 3"), ({"patch": 99}, "to 20"), ({"vertex": "top"}, "'fitted'")],
)
def test_bad_options_are_refused_in_words(options, says):
    with pytest.raises(ValueError, match=says):
        asperities(scan(rough(20)), **options)


def test_missing_pixels_are_refused_in_words():
    height = rough(20)
    height[3, 4] = np.nan
    with pytest.raises(ValueError, match="1 missing pixels of 400"):
        asperities(scan(height))
