"""Roughness against closed forms, Gaussian statistics, and Parseval."""

import numpy as np
import pytest

from roughxr.mechanics.scans.texture_parameters import texture_parameters
from roughxr.scans import level, power_spectrum, roughness

from .surfaces import rough, scan

N = 96
M = 64
PIXEL = 10.0


def waves(amplitude=2.0, periods=6):
    """Return a corrugation along x of a whole number of periods, symmetric about the middle, so that no plane fits."""
    return amplitude * np.cos(2 * np.pi * periods * (np.arange(N) + 0.5) / N)[:, None] * np.ones(M)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.scans.plausibility.ImplausibleScan")
def test_a_corrugation():
    numbers = roughness(scan(waves() + 7, PIXEL))
    assert float(numbers["s_q"]) == pytest.approx(2 / np.sqrt(2))
    assert float(numbers["s_z"]) == pytest.approx(4 * np.cos(np.pi / 16))  # pixels beside the crests
    assert float(numbers["s_sk"]) == pytest.approx(0, abs=1e-12)
    assert float(numbers["s_ku"]) == pytest.approx(1.5)
    assert float(numbers["r_a_datum"]) == pytest.approx(7)
    assert float(numbers["r_q_datum"]) == pytest.approx(np.sqrt(49 + 2))


def test_the_papers_numbers_keep_its_datum_and_the_others_do_not():
    height = 12.84 + rough(64, rms=1.7)
    numbers = roughness(scan(height, PIXEL))
    assert float(numbers["r_a_datum"]) == pytest.approx(np.mean(height))
    assert float(numbers["r_q_datum"]) ** 2 == pytest.approx(np.mean(height) ** 2 + 1.7**2, rel=1e-3)
    assert float(numbers["r_q_datum"]) >= float(numbers["r_a_datum"])
    assert float(numbers["s_q"]) == pytest.approx(float(level(scan(height, PIXEL))["height"].std()))


def test_a_gaussian_surface_has_gaussian_numbers():
    height = np.random.default_rng(0).normal(0, 3, (400, 400))
    numbers = roughness(scan(height, PIXEL))
    assert float(numbers["s_a"] / numbers["s_q"]) == pytest.approx(np.sqrt(2 / np.pi), rel=0.01)
    assert float(numbers["s_sk"]) == pytest.approx(0, abs=0.03)
    assert float(numbers["s_ku"]) == pytest.approx(3, abs=0.06)
    assert float(numbers["s_dq"]) == pytest.approx(np.sqrt(2 * 2) * 3 / PIXEL, rel=0.01)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.scans.plausibility.ImplausibleScan")
@pytest.mark.parametrize("slopes", [(0.3, 0.0), (0.0, -0.4), (0.3, -0.4)])
def test_a_roof_has_its_slope_and_area_exactly_and_a_tilt_none(slopes):
    place = (np.arange(21) - 10) * PIXEL
    roof, height = (slopes[0] * along[:, None] + slopes[1] * along for along in (abs(place), place))
    numbers = roughness(scan(roof, PIXEL))
    assert float(numbers["s_dq"]) == pytest.approx(np.hypot(*slopes))
    assert float(numbers["s_dr"]) == pytest.approx(np.sqrt(1 + np.hypot(*slopes) ** 2) - 1)
    about_plane = roughness(scan(height, PIXEL))
    assert float(about_plane["s_dq"]) < 1e-12 and float(about_plane["s_q"]) < 1e-12


def test_small_slopes_tie_the_area_to_them():
    numbers = roughness(scan(rough(128, rms=0.2), PIXEL))
    assert float(numbers["s_dr"]) == pytest.approx(float(numbers["s_dq"]) ** 2 / 2, rel=1e-3)


def test_parseval_closes_for_pixels_square_or_not():
    ds = scan(rough(90)[:, :70], PIXEL)
    for scaled in (ds, ds.assign_coords(y=("y", ds["y"].values * 1.7, {"units": "nm"}))):
        scaled = level(scaled)
        spectrum = power_spectrum(scaled)
        area = np.prod([scaled.sizes[axis] * float(scaled[axis][1] - scaled[axis][0]) for axis in "xy"])
        assert float((spectrum["psd"] * spectrum["psd_modes"]).sum()) / area == pytest.approx(
            float(roughness(scaled)["s_q"]) ** 2, rel=1e-10
        )
        assert int(spectrum["psd_modes"].sum()) == ds["height"].size


def test_a_window_keeps_the_power_of_white_noise():
    height = np.random.default_rng(3).normal(0, 1, (256, 256))
    spectrum = power_spectrum(scan(height, PIXEL), window="hann")
    area = (256 * PIXEL) ** 2
    assert float((spectrum["psd"] * spectrum["psd_modes"]).sum()) / area == pytest.approx(1, rel=0.02)


def test_missing_pixels_count_for_nothing():
    height = rough(64)
    ds = scan(height, PIXEL)
    ds["height"][10:12, 20] = np.nan
    holed, whole = (roughness(surface).merge(power_spectrum(surface)) for surface in (ds, scan(height, PIXEL)))
    assert float(holed["s_q"]) == pytest.approx(float(whole["s_q"]), rel=0.01)
    assert float(holed["s_dq"]) == pytest.approx(float(whole["s_dq"]), rel=0.01)
    long = holed["wavevector"] < 0.2 * float(holed["wavevector"].max())
    np.testing.assert_allclose(holed["psd"][long][1:], whole["psd"][long][1:], rtol=0.15)


def test_too_many_missing_pixels_leave_no_spectrum():
    height = rough(64)
    height[:10, :10] = np.nan
    with pytest.warns(UserWarning, match="no spectrum: .* missing pixels"):
        spectrum = power_spectrum(scan(height, PIXEL))
    assert spectrum["psd"].isnull().all()


def rough_texture(lengths, seed=0, shape=(160, 128)):
    from scipy.ndimage import gaussian_filter

    height = gaussian_filter(np.random.default_rng(seed).normal(size=shape), lengths, mode="wrap")
    return height - height.mean()


def test_a_gaussian_surface_has_its_autocorrelation_length_and_aspect():
    """Of white noise smoothed by a Gaussian of width σ the autocorrelation is exp(−r²/4σ²): 0.2 at 2σ √ln 5."""
    texture = texture_parameters(rough_texture((6.0, 3.0), shape=(800, 600)), (2.0, 2.0))
    expected = 2 * 3.0 * np.sqrt(np.log(5)) * 2.0
    assert texture[0] == pytest.approx(expected, rel=0.1) and texture[1] == pytest.approx(0.5, rel=0.15)


@pytest.mark.parametrize("angle", [0.3, 2.4])
def test_the_texture_direction_is_that_of_a_wave(angle):
    x, y = np.meshgrid(np.arange(200.0), np.arange(160.0), indexing="ij")
    wave = np.sin(2 * np.pi * 0.1 * (x * np.cos(angle) + y * np.sin(angle)))
    assert texture_parameters(wave, (1.0, 1.0))[2] == pytest.approx(angle, abs=0.05)


def test_a_linear_height_distribution_is_all_core():
    """Its material ratio curve is a line; of heights cut off at a plateau there are no peaks."""
    line = np.linspace(0, 10, 10_000).reshape(100, 100)
    np.testing.assert_allclose(texture_parameters(line, (1.0, 1.0))[3:], [10, 0, 0], atol=1e-6)
    plateau = np.minimum(line, 6.0)
    core, peaks, valleys = texture_parameters(plateau, (1.0, 1.0))[3:]
    assert core == pytest.approx(0, abs=1e-6) and peaks == pytest.approx(0, abs=1e-6)
    assert valleys == pytest.approx(6.0, rel=1e-3)  # a triangle of 60 % of the area


def test_missing_pixels_leave_the_texture_unknown_but_not_the_core():
    height = rough_texture((3.0, 3.0))
    whole = texture_parameters(height, (1.0, 1.0))
    height[3, 4] = np.nan
    holed = texture_parameters(height, (1.0, 1.0))
    assert np.isnan(holed[:3]).all()
    np.testing.assert_allclose(holed[3:], whole[3:], rtol=0.01)


def test_parameters_of_the_texture_are_those_of_surfalize():
    surfalize = pytest.importorskip("surfalize", minversion="0.17.1", reason="an independent implementation")
    for lengths in ((3.0, 3.0), (6.0, 2.0)):
        height = rough_texture(lengths)
        surface = surfalize.Surface(height.T[::-1].copy(), 5.0, 5.0)
        expected = [surface.Sal(), surface.Str(), np.radians(surface.Std()), surface.Sk(), surface.Spk(), surface.Svk()]
        np.testing.assert_allclose(texture_parameters(height, (5.0, 5.0)), expected, rtol=5e-3)
