"""The self-affine fit of a scan's spectrum, and a scan without its shortest wavelengths."""

import numpy as np
import pytest

import roughxr
from roughxr.mechanics.scans.synthetic import self_affine

from .surfaces import glass_pair, scan

PIXEL = 5000 / 512


@pytest.fixture(scope="module")
def shown():
    """A self-affine surface whose wavelengths above 24 nm the scan shows."""
    return glass_pair(self_affine((128, 128), PIXEL, rms=1.8, hurst=0.5, rolloff=200, cutoff=24, seed=3))


@pytest.mark.parametrize(("hurst", "rolloff", "seed"), [(0.2, 100, 1), (0.5, 200, 2), (0.8, 300, 3), (0.8, 2000, 4)])
@pytest.mark.parametrize("cutoff", [24, None])
def test_the_hurst_exponent_is_found_again(hurst, rolloff, seed, cutoff):
    surface = self_affine((512, 512), PIXEL, rms=1.8, hurst=hurst, rolloff=rolloff, cutoff=cutoff, seed=seed)
    fit = roughxr.scans.self_affine_fit(surface)
    assert float(fit.hurst_exponent) == pytest.approx(hurst, abs=0.1)
    assert fit.rolloff_wavelength.units == "nm"


def test_a_lazy_scan_gives_the_same(shown):
    lazy = shown.chunk(x=50, y=64)
    smoothed = roughxr.scans.smooth(lazy, shortest=60)
    np.testing.assert_array_equal(smoothed.height.values, roughxr.scans.smooth(shown, shortest=60).height.values)
    fits = roughxr.scans.self_affine_fit(lazy), roughxr.scans.self_affine_fit(shown)
    assert fits[0].equals(fits[1])


def test_smoothing_is_a_projection_that_keeps_what_is_long(shown):
    once = roughxr.scans.smooth(shown, shortest=80)
    np.testing.assert_allclose(roughxr.scans.smooth(once, shortest=80).height, once.height, atol=1e-11)
    np.testing.assert_allclose(once.height.mean(), shown.height.mean(), atol=1e-12)
    np.testing.assert_allclose(roughxr.scans.smooth(shown, shortest=PIXEL).height, shown.height, atol=1e-11)
    n = 64
    wave = np.cos(np.pi * 8 * (np.arange(n) + 0.5) / n)[:, None] * np.ones(n)  # 16 pixels long
    kept, gone = (roughxr.scans.smooth(scan(wave, 10.0), shortest=s).height.values for s in (159, 161))
    np.testing.assert_allclose(kept, wave, atol=1e-12)
    np.testing.assert_allclose(gone, 0, atol=1e-12)


def test_debris_does_not_spoil_the_spectrum():
    """The twin's background has H = 0.4; six particles stand on it."""
    assert float(roughxr.scans.self_affine_fit(roughxr.open_sample("glass")).hurst_exponent) == pytest.approx(
        0.4, abs=0.06
    )


def test_what_is_wrong_is_said(shown):
    with pytest.raises(ValueError, match="hurst: expected a number from 0 to 1"):
        roughxr.scans.self_affine_fit(shown, hurst=1.2)
    with pytest.raises(ValueError, match="at least two pixels"):
        roughxr.scans.self_affine_fit(shown, shown=12)
    with pytest.raises(ValueError, match="twice the scan"):
        roughxr.scans.smooth(scan(np.zeros((32, 32))), shortest="1 um")
    holes = np.random.default_rng(1).standard_normal((32, 32))
    holes[3, 3] = np.nan
    with pytest.raises(ValueError, match="missing pixels"):
        roughxr.scans.smooth(scan(holes), shortest=100)
