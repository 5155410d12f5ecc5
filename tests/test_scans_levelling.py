"""Backgrounds are taken off to rounding, and particles do not bend them."""

import numpy as np
import pytest
import xarray as xr

from roughxr.scans import level

from .surfaces import rough, scan

PIXEL = 12.5


def with_background(order, seed=0, n=40, m=56):
    """Return (a rough scan, the same on a polynomial of total degree ``order``)."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-1, 1, n)[:, None]
    y = np.linspace(-1, 1, m)
    terms = [(i, j) for i in range(order + 1) for j in range(order + 1 - i)]
    background = sum(rng.normal(0, 50) * x**i * y**j for i, j in terms)
    return background, scan(background, PIXEL)


@pytest.mark.parametrize(("order", "method"), [(1, "plane"), (2, "quadratic"), (3, "cubic")])
def test_a_polynomial_is_removed_to_rounding(order, method):
    background, ds = with_background(order)
    assert float(abs(level(ds, method=method)["height"]).max()) < 1e-10 * np.ptp(background) + 1e-12


def test_a_levelled_scan_has_no_tilt_and_is_levelled_already():
    ds = scan(rough(64) + np.linspace(0, 90, 64)[:, None], PIXEL)
    once = level(ds)
    assert float(abs(once["height"].mean())) < 1e-12
    np.testing.assert_allclose(level(once)["height"], once["height"], atol=1e-12)
    slopes = np.polynomial.polynomial.polyfit(ds["x"], once["height"].mean("y"), 1)
    assert abs(slopes[1]) < 1e-12


def test_particles_do_not_bend_the_background():
    background, ds = with_background(2)
    particles = np.zeros(background.shape, dtype=bool)
    particles[3:9, 4:12] = particles[30:33, 40:50] = True
    ds["height"] = ds["height"] + 200.0 * particles
    mask = ds["height"].copy(data=particles)
    bent = level(ds, method="quadratic")["height"]
    assert float(abs(bent.where(~mask)).max()) > 10
    flat = level(ds, method="quadratic", exclude=mask)["height"]
    np.testing.assert_allclose(flat, 200.0 * particles, atol=1e-8)


def test_missing_pixels_stay_missing_and_do_not_count():
    _, ds = with_background(1)
    ds["height"][5:9, 7] = np.nan
    flat = level(ds)["height"]
    assert int(flat.isnull().sum()) == 4
    assert float(abs(flat).max()) < 1e-10


@pytest.mark.parametrize("method", ["median", "median_difference"])
def test_lines_at_different_heights_are_brought_together(method):
    jumps = np.random.default_rng(1).normal(0, 20, 48)
    flat = level(scan(rough(48, rms=0.5) + jumps, PIXEL), method=method)["height"]
    rows = flat.diff("y").median("x") if method == "median_difference" else flat.median("x")
    assert float(abs(rows).max()) < 1e-12
    assert float(flat.std()) < 1.0


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.scans.plausibility.ImplausibleScan")
def test_particles_do_not_shift_their_lines():
    ds = scan(np.zeros((40, 30)) + np.arange(30) ** 2, PIXEL)
    particles = ds["height"].copy(data=np.zeros((40, 30), dtype=bool))
    particles[5:30, 10:14] = True  # most of these lines
    ds["height"] = ds["height"] + 100 * particles
    flat = level(ds, method="median", exclude=particles)["height"]
    np.testing.assert_allclose(flat, 100.0 * particles)


@pytest.mark.parametrize("method", ["plane", "quadratic", "median"])
def test_a_chunked_scan_is_chunked_again(method):
    _, ds = with_background(3)
    ds["height"][3, 4] = np.nan
    levelled = level(ds.chunk(x=7, y=11), method=method)
    assert levelled.height.chunksizes["x"][0] == 7 and level(ds, method=method).height.chunks is None
    xr.testing.assert_identical(levelled.compute(), level(ds, method=method))


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"method": "flat"}, "method: expected one of 'plane', .*found 'flat'"),
        ({"exclude": np.ones((3, 3))}, "exclude: expected bool"),
        ({"exclude": np.ones((40, 56), dtype=bool)}, "too few that are neither missing nor excluded"),
    ],
)
def test_options_that_do_not_fit(options, match):
    _, ds = with_background(1)
    with pytest.raises(ValueError, match=match):
        level(ds, **options)


def test_a_mask_of_another_place_is_refused():
    _, ds = with_background(1)
    mask = (ds["height"] > 0).assign_coords(x=ds["x"] + 1000)
    with pytest.raises(ValueError, match="x"):
        level(ds, exclude=mask)
