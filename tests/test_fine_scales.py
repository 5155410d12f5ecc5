"""What a scan does not show, added from a seed; and what it shows, cut off."""

import numpy as np
import pytest
import xarray as xr
from scipy.signal.windows import blackmanharris

import roughxr
from roughxr.scans.synthetic import self_affine

from .surfaces import glass_pair, rotated, scan

PIXEL = 5000 / 512


@pytest.fixture(scope="module")
def shown():
    """A self-affine surface whose wavelengths above 24 nm the scan shows."""
    return glass_pair(self_affine((128, 128), PIXEL, rms=1.8, hurst=0.5, rolloff=200, cutoff=24, seed=3))


def half(ds):
    """Return the fit of the Hurst exponent that the surface has."""
    return roughxr.scans.self_affine_fit(ds, hurst=0.5)


@pytest.fixture(scope="module")
def finer(shown):
    return roughxr.scans.add_fine_roughness(shown, shortest=10, seed=1, spectrum=half(shown))


def density(ds):
    return roughxr.scans.power_spectrum(ds)


@pytest.mark.parametrize(("hurst", "rolloff", "seed"), [(0.2, 100, 1), (0.5, 200, 2), (0.8, 300, 3), (0.8, 2000, 4)])
@pytest.mark.parametrize("cutoff", [24, None])
def test_the_hurst_exponent_is_found_again(hurst, rolloff, seed, cutoff):
    surface = self_affine((512, 512), PIXEL, rms=1.8, hurst=hurst, rolloff=rolloff, cutoff=cutoff, seed=seed)
    fit = roughxr.scans.self_affine_fit(surface)
    assert float(fit.hurst_exponent) == pytest.approx(hurst, abs=0.1)
    assert fit.rolloff_wavelength.units == "nm"


def test_added_waves_go_on_where_the_scan_ends_with_the_power_that_the_surface_has():
    """The truth is a surface on fine pixels; the scan sees it smoothed, every fourth pixel."""
    truth = self_affine((768, 768), 2.5, rms=2, hurst=0.6, rolloff=200, cutoff=10, seed=5)
    coarse = roughxr.scans.smooth(truth, shortest=30).isel(x=slice(1, None, 4), y=slice(1, None, 4))
    again = roughxr.scans.add_fine_roughness(
        coarse, shortest=10, seed=2, mesh=4, spectrum=roughxr.scans.self_affine_fit(coarse, hurst=0.6)
    )
    wanted = density(truth)
    extended = density(again)
    for low, high in ((10, 14), (14, 20), (20, 29)):
        inside = (2 * np.pi / wanted.wavevector[1:] > low) & (2 * np.pi / wanted.wavevector[1:] < high)
        power = [float((s.psd * s.psd_modes)[1:][inside.values].sum()) for s in (extended, wanted)]
        assert power[0] / power[1] == pytest.approx(1, abs=0.1)


def test_long_waves_stay_as_they_were(shown, finer):
    n = finer.sizes["x"] // shown.sizes["x"]
    before = roughxr.scans.add_fine_roughness(shown, shortest=30, seed=1, mesh=n)  # nothing to add: interpolated alone
    assert before.attrs["fine_rms"] == 0
    added = (finer.height - before.height).values  # not periodic over the map: windowed, a mode spreads over four
    window = blackmanharris(added.shape[0])
    rows = np.abs(np.fft.rfft2(added * np.multiply.outer(window, window))) ** 2
    per_nm = np.hypot(np.fft.fftfreq(added.shape[0], PIXEL / n)[:, None], np.fft.rfftfreq(added.shape[1], PIXEL / n))
    longest = finer.attrs["fine_longest"]
    margin = 6 / (added.shape[0] * PIXEL / n)
    outside = (per_nm < 1 / longest - margin) | (per_nm > 1 / 10 + margin)
    assert rows[outside].max() < 1e-8 * rows.max()


def test_waves_are_nested_and_the_same_on_any_mesh_and_window(shown):
    """The same waves stay and finer ones are added; a part of the scan, or other cells, show the same surface."""
    spectrum = roughxr.scans.self_affine_fit(shown)
    make = {"seed": 3, "spectrum": spectrum}
    coarse = roughxr.scans.add_fine_roughness(shown, shortest=14, mesh=3, **make).height
    fine = roughxr.scans.add_fine_roughness(
        shown, shortest=14, mesh=9, **make
    ).height  # every third cell's centre is shared
    bare = [roughxr.scans.add_fine_roughness(shown, shortest=40, mesh=n, **make).height for n in (3, 9)]
    same = (fine - bare[1]).values[1::3, 1::3] - (coarse - bare[0]).values
    assert np.abs(same).max() < 1e-9
    cut = shown.isel(x=slice(40, 80), y=slice(30, 90))
    part, its_bare = (roughxr.scans.add_fine_roughness(cut, shortest=low, mesh=3, **make) for low in (14, 40))
    inner, bare_inner = (surface.sel(x=part.x, y=part.y, method="nearest") for surface in (coarse, bare[0]))
    off = (part.height - its_bare.height - inner + bare_inner).values
    assert np.abs(off).max() < 1e-9
    off = (its_bare.height - bare_inner).values[24:-24, 24:-24]  # what lies between pixels hangs on those around
    assert np.abs(off).max() < 0.005 * float(shown.height.std())
    shorter = roughxr.scans.add_fine_roughness(shown, shortest=9, mesh=9, **make).height
    added = (shorter - fine).values
    window = blackmanharris(added.shape[0])
    rows = np.abs(np.fft.rfft2(added * np.multiply.outer(window, window))) ** 2
    per_nm = np.hypot(np.fft.fftfreq(added.shape[0], PIXEL / 9)[:, None], np.fft.rfftfreq(added.shape[1], PIXEL / 9))
    assert rows[per_nm < 1 / 14 - 6 / (128 * PIXEL)].max() < 1e-6 * rows.max()


def test_rms_is_that_of_the_extrapolated_spectrum(shown, finer):
    """The variance between two wavelengths is the integral of C(q) q dq/2π over them."""
    model = roughxr.scans.self_affine_fit(shown, hurst=0.5)
    q = np.linspace(2 * np.pi / finer.attrs["fine_longest"], 2 * np.pi / 10, 20001)
    psd = float(model.psd_plateau) * (1 + (float(model.rolloff_wavelength) * q / (2 * np.pi)) ** 2) ** -1.5
    expected = np.sqrt(np.trapezoid(psd * q / (2 * np.pi), q))
    assert finer.attrs["fine_rms"] == pytest.approx(expected, rel=0.03)


def test_a_seed_is_one_surface_and_every_surface_keeps_the_pair(shown, finer):
    again, other = (roughxr.scans.add_fine_roughness(shown, shortest=10, seed=s, spectrum=half(shown)) for s in (1, 2))
    xr.testing.assert_identical(again, finer)
    assert np.abs(other.height - finer.height).max() > 0.1
    assert float(finer.sphere_radius) == 3000
    assert float(finer.x[0] - 0.5 * (finer.x[1] - finer.x[0])) == pytest.approx(float(shown.x[0]) - PIXEL / 2)
    assert roughxr.schema.history(finer)[-1]["operation"] == "add_fine_roughness"


def test_a_lazy_scan_gives_the_same(shown, finer):
    lazy = shown.chunk(x=50, y=64)
    from_lazy = roughxr.scans.add_fine_roughness(lazy, shortest=10, seed=1, spectrum=half(lazy))
    np.testing.assert_array_equal(from_lazy.height.values, finer.height.values)
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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"shortest": -1}, "shortest"),
        ({"shortest": 10, "seed": 1.5}, "seed"),
        ({"shortest": 3, "mesh": 2}, "mesh: expected pixels of at most half"),
    ],
)
def test_what_is_wrong_is_said(shown, options, message):
    with pytest.raises(ValueError, match=message):
        roughxr.scans.add_fine_roughness(shown, **{"seed": 1, **options})
    with pytest.raises(ValueError, match="hurst: expected a number from 0 to 1"):
        roughxr.scans.self_affine_fit(shown, hurst=1.2)
    with pytest.raises(ValueError, match="at least two pixels"):
        roughxr.scans.self_affine_fit(shown, shown=12)


def test_nothing_to_continue_is_said():
    with pytest.raises(ValueError, match="flat"):
        roughxr.scans.add_fine_roughness(scan(np.zeros((32, 32))), shortest=10, seed=1)
    with pytest.raises(ValueError, match="twice the scan"):
        roughxr.scans.smooth(scan(np.zeros((32, 32))), shortest="1 um")
    holes = np.random.default_rng(1).standard_normal((32, 32))
    holes[3, 3] = np.nan
    with pytest.raises(ValueError, match="missing pixels"):
        roughxr.scans.add_fine_roughness(scan(holes), shortest=10, seed=1)
    with pytest.raises(ValueError, match="missing pixels"):
        roughxr.scans.smooth(scan(holes), shortest=100)


def test_the_spectrum_of_a_larger_scan_can_be_given(shown):
    part = shown.isel(x=slice(40), y=slice(40))
    whole = roughxr.scans.self_affine_fit(shown)
    fine = roughxr.scans.add_fine_roughness(part, shortest=10, seed=1, spectrum=whole)
    assert fine.attrs["fine_hurst"] == float(whole.hurst_exponent)


def test_debris_does_not_spoil_the_spectrum():
    """The twin's background has H = 0.4; six particles stand on it."""
    assert float(roughxr.scans.self_affine_fit(roughxr.open_sample("glass")).hurst_exponent) == pytest.approx(
        0.4, abs=0.06
    )


def drawn_out(seed, by=2.0):
    """Return a self-affine surface whose waves are drawn out along x."""
    narrow = self_affine((int(256 / by), 256), 4, rms=1.5, hurst=0.7, rolloff=150, seed=seed).height.values
    long = np.fft.irfft(np.fft.rfft(narrow, axis=0), 256, axis=0) * by
    whole = self_affine((256, 256), 4, rms=1.5, hurst=0.7, rolloff=150, seed=seed)
    return whole.assign(height=whole.height.copy(data=long))


def slopes(added):
    return np.array([np.std(np.diff(added, axis=axis)) for axis in (0, 1)])


def added_to(ds):
    spectrum = roughxr.scans.self_affine_fit(ds, shown=24)
    fine = roughxr.scans.add_fine_roughness(ds, shortest=17, seed=1, mesh=1, spectrum=spectrum)
    return (fine.height - roughxr.scans.smooth(fine, shortest=24).height).values[20:-20, 20:-20]


def test_waves_are_added_with_the_lay_of_those_that_are_shown():
    """The ratio of slopes across and along, of a surface drawn out by two; and turned as its scan is turned."""
    for seed in range(3):
        truth = drawn_out(seed)
        seen = roughxr.scans.smooth(truth, shortest=24)
        fits = [roughxr.scans.self_affine_fit(surface, shown=24) for surface in (seen, rotated(seen))]
        assert float(fits[1].lay_strength) == pytest.approx(float(fits[0].lay_strength), rel=1e-6)
        lays = [float(fit.lay_direction) for fit in fits]
        assert abs(np.sin(np.radians(lays[0]))) < 0.15 and abs(lays[0] - lays[1]) == pytest.approx(90, abs=1e-6)
        along, across = slopes(added_to(seen))
        turned_along, turned_across = slopes(added_to(rotated(seen)))
        fine_heights = (roughxr.scans.smooth(truth, shortest=17).height - seen.height).values[20:-20, 20:-20]
        assert 0.8 < across / along / np.divide(*slopes(fine_heights)[::-1]) < 1.15
        assert turned_along / turned_across == pytest.approx(across / along, rel=0.1)


def test_by_chance_no_lay_is_found():
    fits = [
        roughxr.scans.self_affine_fit(self_affine((64, 64), 5, rms=1, hurst=0.6, rolloff=100, seed=seed), shown=20)
        for seed in range(30)
    ]
    assert sum(float(fit.lay_strength) > 0 for fit in fits) <= 2
