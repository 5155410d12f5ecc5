"""Several scans of one surface: their mean has an interval that holds what differs from scan to scan."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.statistics.pooling import random_effects

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")


def several(rng, *, scans=4, places=100, within=2.0, between=1.0, mean=20.0):
    values = mean + between * rng.standard_normal((scans, 1)) + within * rng.standard_normal((scans, places))
    return xr.Dataset({"pull_off_force": (("scan", "subregion"), values, {"units": "nN"})})


def test_the_interval_holds_the_surfaces_mean_at_its_nominal_rate():
    rng = np.random.default_rng(0)
    held = []
    naive = []
    for _ in range(80):
        ds = several(rng)
        pooled = roughxr.statistics.pooled(ds, "pull_off_force", statistics=["mean"], resamples=99).squeeze()
        held.append(bool(pooled.pooled_low < 20 < pooled.pooled_high))
        forces = ds.pull_off_force.values.ravel()
        naive.append(abs(forces.mean() - 20) < 1.96 * forces.std() / np.sqrt(forces.size))
    assert np.mean(held) >= 0.9 and np.mean(naive) < 0.5


def effects_of_scans(ds):
    """Return what scans of 100 places each have in common, by their means and standard errors."""
    values = ds.pull_off_force.values
    return random_effects(values.mean(axis=1), values.std(axis=1, ddof=1) / 10, confidence=0.95)


def test_what_is_left_between_scans_is_found_and_nothing_where_there_is_nothing():
    rng = np.random.default_rng(1)
    apart, alike = (
        [effects_of_scans(several(rng, scans=8, between=between)) for _ in range(30)] for between in (1.0, 0.0)
    )
    assert np.sqrt(np.mean([effects.between**2 for effects in apart])) == pytest.approx(1.0, rel=0.2)
    assert np.median([effects.between for effects in alike]) < 0.1
    assert np.mean([effects.p_value < 0.05 for effects in apart]) > 0.9
    assert np.mean([effects.p_value < 0.05 for effects in alike]) < 0.2


def test_scatter_between_scans_is_beyond_the_standard_errors_of_their_means():
    """Without errors of the means it would be 1.2 times as large."""
    ds = several(np.random.default_rng(2), scans=8, between=0.3)
    pooled = roughxr.statistics.pooled(ds, "pull_off_force", statistics=["mean"], resamples=199).squeeze()
    effects = effects_of_scans(ds)
    assert float(pooled.between_std) == pytest.approx(effects.between, rel=0.05)
    assert float(pooled.between_p_value) == pytest.approx(effects.p_value, abs=0.01)


def test_of_equal_errors_it_is_the_analysis_of_variance():
    estimate = np.array([1.0, 2.0, 4.0, 5.0])
    error = np.full(4, 0.5)
    effects = random_effects(estimate, error, confidence=0.95)
    assert effects.mean == pytest.approx(3.0)
    assert effects.between**2 == pytest.approx(estimate.var(ddof=1) - 0.25)
    assert effects.high - effects.mean == pytest.approx(3.1824463 * estimate.std(ddof=1) / 2)
    same = random_effects(np.full(4, 2.0), error, confidence=0.95)
    assert (same.mean, same.between, same.p_value) == (2.0, 0.0, 1.0)
    assert same.high - same.mean == pytest.approx(3.1824463 * 0.25)  # no narrower than the errors ask for


def test_forces_of_scans_that_differ_much_have_no_interval_below_zero():
    pooled = roughxr.statistics.pooled(xr.Dataset({"pull_off_force": ("scan", [752.0, 990.0])}), "pull_off_force")
    low, mean, high = (float(pooled[name][0]) for name in ("pooled_low", "pooled", "pooled_high"))
    assert 0 < low < 752 and 990 < high and low * high == pytest.approx(mean**2)
    values = xr.Dataset({"height": ("scan", [-752.0, 990.0])})
    assert float(roughxr.statistics.pooled(values, "height").pooled_low[0]) < -752


def test_a_worse_scan_counts_for_less():
    alike, worse = (
        random_effects(np.array([1.0, 1.1, 2.0]), np.array(e), confidence=0.9) for e in ([1] * 3, [1, 1, 9])
    )
    assert worse.mean < alike.mean


@pytest.fixture(scope="module")
def scans():
    """Return three scans of one surface, one of them smaller, with a pair."""
    made = [self_affine((n, n), 10, rms=1, hurst=0.8, rolloff=200, seed=k) for k, n in enumerate((64, 64, 48))]
    return [scan.contact.assign_pair(sphere_radius=2000, contact_modulus=40, work_of_adhesion=0.1) for scan in made]


def each(scans, solve, **options):
    """Return the results for several scans along ``scan``."""
    return xr.concat([solve(scan, **options) for scan in scans], "scan", join="outer")


def test_the_pooled_mean_lies_between_those_of_the_scans(scans):
    pooled = roughxr.statistics.pooled(
        each(scans, roughxr.pull_off_map, subregions=(4, 4)), "pull_off_force", resamples=99
    )
    assert pooled.estimate.dims == ("scan", "statistic") and pooled.pooled.units == "nN"
    mean = pooled.sel(statistic="mean")
    assert float(mean.estimate.min()) <= float(mean.pooled) <= float(mean.estimate.max())


def test_scans_of_fewer_places_are_pooled_by_those_they_have(scans):
    parts = [scan.contact.pull_off_map(subregions=grid) for scan, grid in zip(scans, ((4, 4), (4, 4), (3, 3)))]
    maps = xr.concat(parts, "scan", join="outer")
    assert int(maps.pull_off_force.isnull().sum()) == 7
    pooled = roughxr.statistics.pooled(maps, "pull_off_force", statistics=["mean"], resamples=99)
    np.testing.assert_allclose(pooled.estimate[:, 0], [float(part.pull_off_force.mean()) for part in parts])


def test_roughness_is_pooled_over_scans_and_pull_off_over_placements(scans):
    table = each(scans, roughxr.roughness)
    pooled = roughxr.statistics.pooled(table, "s_q").squeeze()
    values = table.s_q.values
    assert float(pooled.pooled) == pytest.approx(values.mean())
    assert float(pooled.between_std) == pytest.approx(values.std(ddof=1)) and np.isnan(pooled.between_p_value)
    placed = several(np.random.default_rng(0)).rename(scan="placement")
    assert (
        roughxr.statistics.pooled(placed, "pull_off_force", over="placement", resamples=99).pooled_over == "placement"
    )


def test_what_cannot_be_pooled_is_refused():
    ds = several(np.random.default_rng(0))
    with pytest.raises(ValueError, match="expected at least two, found 1"):
        roughxr.statistics.pooled(ds.isel(scan=[0]), "pull_off_force")
    with pytest.raises(ValueError, match="expected a variable along 'scan', found"):
        roughxr.statistics.pooled(ds.rename(scan="other"), "pull_off_force")
    with pytest.raises(ValueError, match="expected a variable along 'scan', found variables pull_off_force"):
        roughxr.statistics.pooled(ds, "force")
    at_speeds = ds.expand_dims(friction_velocity=[1.0, 2.0])
    with pytest.raises(ValueError, match="found also friction_velocity; select one"):
        roughxr.statistics.pooled(at_speeds, "pull_off_force")


def law_of(q, rms=2.0, hurst=0.8, rolloff=400.0, cutoff=45.0, side=2560.0):
    """Return the spectrum (nm⁴) that `self_affine` draws from."""
    falling = lambda q: (1 + (q * rolloff / (2 * np.pi)) ** 2) ** (-1 - hurst)  # noqa: E731
    waves = 2 * np.pi / side * np.arange(-100, 101)
    modes = np.hypot(waves[:, None], waves)
    inside = (modes > 0) & (modes <= 2 * np.pi / cutoff)
    return rms**2 * side**2 / falling(modes[inside]).sum() * falling(q)


def test_scans_of_several_sizes_are_one_spectrum():
    scans = []
    for seed in range(4):
        whole = self_affine((512, 512), 5, rms=2.0, hurst=0.8, rolloff=400, cutoff=45, seed=seed)
        coarse = whole.isel(x=slice(None, None, 4), y=slice(None, None, 4))
        scans += [scan.contact.level() for scan in (coarse, whole.isel(x=slice(64, 192), y=slice(256, 384)))]
    spectrum = roughxr.scans.combined_spectrum(scans)
    assert int(spectrum.psd_scans[0]) == 4 and spectrum.psd_scans.max() == 8 and int(spectrum.psd_scans[-1]) == 4
    off = spectrum.psd / law_of(spectrum.wavevector) - 1
    shown = (spectrum.wavevector < 2 * np.pi / 60).values  # above the cut-off, and what the window smears of it
    assert shown.sum() > 10 and bool((abs(off) < 0.15 + 5 / np.sqrt(spectrum.psd_modes))[shown].all())
    assert abs(float(off[shown].weighted(spectrum.psd_modes[shown]).mean())) < 0.1
    assert int(spectrum.psd_between_std.notnull().sum()) == int((spectrum.psd_scans > 1).sum())


def test_one_scan_is_its_own_spectrum_and_what_it_cannot_tell_is_left_out(scans):
    spectrum = roughxr.scans.combined_spectrum(scans[:1])
    rings = roughxr.scans.power_spectrum(scans[0], window="hann")
    kept = rings.where((rings.wavevector > 2 * np.pi / 320) & (rings.wavevector <= 2 * np.pi / 40), drop=True)
    assert float((spectrum.psd * spectrum.psd_modes).sum()) == pytest.approx(float((kept.psd * kept.psd_modes).sum()))
    blunt = roughxr.scans.combined_spectrum(scans, shortest="100 nm")
    assert float(blunt.wavevector.max()) < 2 * np.pi / 100
    with pytest.raises(ValueError, match="longest wavelength of some scan, found 10000 nm"):
        roughxr.scans.combined_spectrum(scans, shortest=1e4)
    with pytest.raises(ValueError, match="scans: expected at least one"):
        roughxr.scans.combined_spectrum([])


def test_what_it_takes_to_leave_keeps_the_places_of_each_scan(scans):
    held = each(scans, roughxr.rolling, subregions=(2, 2), directions=8)
    resuspended = held.contact.resuspension(friction_velocity=[0.1, 10.0], particle_density=2200)
    load = held.contact.critical_load(particle_density=2200)
    for detached in (resuspended, load):
        np.testing.assert_array_equal(detached.subregion_x.transpose("scan", "subregion"), held.subregion_x)
    assert resuspended.attrs["places"] == 12
