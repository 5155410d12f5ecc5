"""Roughness against closed forms, Gaussian statistics, and Parseval."""

import numpy as np
import pytest

from roughxr.scans import autocorrelation, level, power_spectrum, roughness

from .surfaces import rough, scan

N, M, PIXEL = 96, 64, 10.0


def waves(amplitude=2.0, periods=6):
    """Return a corrugation along x of a whole number of periods."""
    return amplitude * np.sin(2 * np.pi * periods * np.arange(N) / N)[:, None] * np.ones(M)


def test_a_corrugation():
    found = roughness(scan(waves() + 7, PIXEL), reference="mean")
    assert float(found["s_q"]) == pytest.approx(2 / np.sqrt(2))
    assert float(found["s_z"]) == pytest.approx(4)
    assert float(found["s_sk"]) == pytest.approx(0, abs=1e-12)
    assert float(found["s_ku"]) == pytest.approx(1.5)
    assert float(found["r_a_datum"]) == pytest.approx(7)
    assert float(found["r_q_datum"]) == pytest.approx(np.sqrt(49 + 2))


def test_the_papers_numbers_keep_its_datum_and_the_others_do_not():
    height = 12.84 + rough(64, rms=1.7)
    found = roughness(scan(height, PIXEL), reference="mean")
    assert float(found["r_a_datum"]) == pytest.approx(np.mean(height))
    assert float(found["r_q_datum"]) ** 2 == pytest.approx(np.mean(height) ** 2 + 1.7**2, rel=1e-3)
    assert float(found["r_q_datum"]) >= float(found["r_a_datum"])
    assert float(found["s_q"]) == pytest.approx(1.7, rel=1e-3)


def test_a_gaussian_surface_has_gaussian_numbers():
    height = np.random.default_rng(0).normal(0, 3, (400, 400))
    found = roughness(scan(height, PIXEL), spectra=False)
    assert float(found["s_a"] / found["s_q"]) == pytest.approx(np.sqrt(2 / np.pi), rel=0.01)
    assert float(found["s_sk"]) == pytest.approx(0, abs=0.03)
    assert float(found["s_ku"]) == pytest.approx(3, abs=0.06)
    assert float(found["s_dq"]) == pytest.approx(np.sqrt(2 * 2) * 3 / PIXEL, rel=0.01)


@pytest.mark.parametrize("slopes", [(0.3, 0.0), (0.0, -0.4), (0.3, -0.4)])
def test_a_tilt_has_its_slope_and_area_exactly(slopes):
    place = np.arange(20) * PIXEL
    height = slopes[0] * place[:, None] + slopes[1] * place
    found = roughness(scan(height, PIXEL), reference="mean", spectra=False)
    assert float(found["s_dq"]) == pytest.approx(np.hypot(*slopes))
    assert float(found["s_dr"]) == pytest.approx(np.sqrt(1 + np.hypot(*slopes) ** 2) - 1)
    about_plane = roughness(scan(height, PIXEL), spectra=False)
    assert float(about_plane["s_dq"]) < 1e-12 and float(about_plane["s_q"]) < 1e-12


def test_small_slopes_tie_the_area_to_them():
    found = roughness(scan(rough(128, rms=0.2), PIXEL), spectra=False)
    assert float(found["s_dr"]) == pytest.approx(float(found["s_dq"]) ** 2 / 2, rel=1e-3)


def test_parseval_closes_for_pixels_square_or_not():
    ds = scan(rough(90)[:, :70], PIXEL)
    for scaled in (ds, ds.assign_coords(y=("y", ds["y"].values * 1.7, {"units": "nm"}))):
        found = roughness(scaled, spectra=True)
        area = float(found["size_x"] * found["size_y"])
        assert float((found["psd"] * found["psd_modes"]).sum()) / area == pytest.approx(
            float(found["s_q"]) ** 2, rel=1e-10
        )
        assert int(found["psd_modes"].sum()) == ds["height"].size
        assert float(found["acf"][0]) == pytest.approx(float(found["s_q"]) ** 2, rel=1e-10)


def test_a_window_keeps_the_power_of_white_noise():
    height = np.random.default_rng(3).normal(0, 1, (256, 256))
    found = power_spectrum(scan(height, PIXEL), window="hann")
    area = (256 * PIXEL) ** 2
    assert float((found["psd"] * found["psd_modes"]).sum()) / area == pytest.approx(1, rel=0.02)


def test_the_autocorrelation_is_the_mean_product():
    height = rough(24)[:, :20]
    ds = scan(height, PIXEL)
    found = autocorrelation(ds)
    sums, counts = np.zeros(found.sizes["lag"]), np.zeros(found.sizes["lag"])
    for i in range(-12, 13):
        for j in range(-10, 11):
            ring = round(np.hypot(i, j))
            if np.hypot(i, j) * PIXEL > 10 * PIXEL:
                continue
            a = height[max(0, -i) : 24 - max(0, i), max(0, -j) : 20 - max(0, j)]
            b = height[max(0, i) : 24 - max(0, -i), max(0, j) : 20 - max(0, -j)]
            sums[ring] += np.mean(a * b)
            counts[ring] += 1
    np.testing.assert_allclose(found["acf"], sums / counts, rtol=1e-10, atol=1e-12)


def test_the_correlation_length_of_a_smooth_surface():
    found = autocorrelation(level(scan(rough(512, smooth=4.0), PIXEL)))
    expected = np.exp(-((found["lag"] / (2 * 4.0 * PIXEL)) ** 2))
    close = found["lag"] < 120
    np.testing.assert_allclose((found["acf"] / found["acf"][0])[close], expected[close], atol=0.08)


def test_missing_pixels_count_for_nothing():
    height = rough(64)
    ds = scan(height, PIXEL)
    ds["height"][10:12, 20] = np.nan
    found, whole = (roughness(each, spectra=True) for each in (ds, scan(height, PIXEL)))
    assert float(found["s_q"]) == pytest.approx(float(whole["s_q"]), rel=0.01)
    assert float(found["s_dq"]) == pytest.approx(float(whole["s_dq"]), rel=0.01)
    long = found["wavevector"] < 0.2 * float(found["wavevector"].max())
    np.testing.assert_allclose(found["psd"][long][1:], whole["psd"][long][1:], rtol=0.15)
    np.testing.assert_allclose(found["acf"], whole["acf"], atol=0.02 * float(whole["acf"][0]))


def test_the_correlation_with_missing_pixels_is_the_mean_over_known_pairs():
    height = np.random.default_rng(3).standard_normal((9, 7))
    height[np.random.default_rng(4).random(height.shape) < 0.2] = np.nan
    sums, pairs = np.zeros(4), np.zeros(4)
    for i, j in np.ndindex(height.shape):
        for k, m in np.ndindex(height.shape):
            lag, product = np.hypot(k - i, m - j), height[i, j] * height[k, m]
            if lag <= 3 and np.isfinite(product) and (k - i, m - j) >= (0, 0):
                sums[int(np.rint(lag))] += product
                pairs[int(np.rint(lag))] += 1
    found = autocorrelation(scan(height, PIXEL))["acf"]
    assert float(found[0]) == pytest.approx(sums[0] / pairs[0])
    assert np.isfinite(found).all()


def test_too_many_missing_pixels_leave_no_spectrum():
    height = rough(64)
    height[:10, :10] = np.nan
    with pytest.warns(UserWarning, match="no spectrum: .* missing pixels"):
        found = roughness(scan(height, PIXEL), spectra=True)
    assert found["psd"].isnull().all() and found["acf"].notnull().all()


def test_the_autocorrelation_of_a_transposed_scan_is_the_same():
    """Lags along y alone were counted twice, those along x once: 5 % on a scan with grooves."""
    ds = scan(rough(24, seed=3))
    turned = ds.rename(x="y", y="x").transpose("x", "y")
    np.testing.assert_allclose(autocorrelation(turned).acf, autocorrelation(ds).acf, rtol=1e-12)
