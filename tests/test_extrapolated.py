"""The real surface: the effect of roughness finer than the scan, from one scan and from a second, finer one."""

import warnings

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import figures, report
from roughxr.application.cli import main
from roughxr.application.report.summary import best_estimate_notes
from roughxr.application.runs import analysis, parts
from roughxr.application.sentences import estimate_notes
from roughxr.mechanics.scans import synthetic
from roughxr.mechanics.studies import extrapolation
from roughxr.mechanics.studies.assumptions import CHANGES, noise_limit, range_deviation
from roughxr.mechanics.studies.extrapolation import (
    one_scan_factor,
    pixel_series,
    real_pull_off,
    unseen_octaves,
    without_estimate,
)
from roughxr.mechanics.studies.finer_scan import second_scan
from roughxr.mechanics.vocabulary.error_sources import SECOND_SCAN_NOISE, UNSEEN
from roughxr.scans import ImplausibleScan

from .surfaces import as_measured, unpressed

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = [
    pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities"),
    pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact"),
]


@pytest.fixture(scope="module", autouse=True)
def _unpressed():
    with unpressed():
        yield


PAIR = {"sphere_radius": 300, "materials": "glass"}
QUICK = {"subregions": (3, 3), "mesh": 2, "places": 1}


def image(surface, pixels, tip=8.0):
    """Return a surface as a tip shows it on pixels of so many of its own."""
    dilated = roughxr.scans.dilate(surface, tip_radius=tip)
    return dilated.isel(x=slice(pixels // 2, None, pixels), y=slice(pixels // 2, None, pixels))


def on_cells_of_2_nm(surface, **options):
    """Solve surfaces with pixels of 2 and 8 nm on equal cells, without refinement."""
    return roughxr.adhesive(surface, **{"mesh": round(roughxr.schema.pixel(surface)[0] / 2)} | options)


@pytest.fixture(scope="module")
def ratios_by_second_scans():
    """Ratios of pull-offs by the heights of second scans that were solved."""
    return {}


@pytest.fixture
def solved_once(ratios_by_second_scans, monkeypatch):
    """Solve each second scan once for all tests, at six places, on equal cells."""
    solve = extrapolation.second_scan_ratio

    def stored_ratio(second, law):
        key = law, *(surface.height.values.tobytes() for surface in (second.finer, second.noisier, *second.as_shown))
        if key not in ratios_by_second_scans:
            ratios_by_second_scans[key] = solve(second, law)
        return ratios_by_second_scans[key]

    monkeypatch.setattr(extrapolation, "_SECOND_PLACES", (3, 2))
    monkeypatch.setattr(extrapolation, "adhesive", on_cells_of_2_nm)
    monkeypatch.setattr(extrapolation, "second_scan_ratio", stored_ratio)


@pytest.fixture(scope="module")
def true_surface():
    made = synthetic.self_affine((320, 320), 2, rms=1.5, hurst=0.8, rolloff=150, cutoff=6, seed=4)
    return roughxr.level(as_measured(made))


@pytest.fixture(scope="module")
def scan(true_surface):
    return image(true_surface, 4).contact.assign_pair(**PAIR)


@pytest.fixture(scope="module")
def scanned(scan):
    return roughxr.adhesive(scan, subregions=(3, 3), mesh=2)


@pytest.fixture(scope="module")
def truth(true_surface):
    return on_cells_of_2_nm(true_surface.contact.assign_pair(**PAIR), subregions=(3, 3))


@pytest.fixture(scope="module")
def fine(true_surface):
    return image(true_surface, 1, tip=5.0).isel(x=slice(160), y=slice(160))


@pytest.fixture(scope="module")
def grains():
    """A surface of round grains with sharp valleys."""
    made = synthetic.self_affine((320, 320), 2, rms=1.5, hurst=0.8, rolloff=60, cutoff=12, seed=2)
    return roughxr.level(made.assign(height=-abs(made.height)))


@pytest.fixture(scope="module")
def real(scan):
    return roughxr.extrapolated(scan, **QUICK)


def test_with_nothing_unseen_it_is_the_pull_off_as_scanned(scan, scanned, monkeypatch):
    monkeypatch.setattr(extrapolation, "budget_of", lambda *_, **__: None)
    monkeypatch.setattr(extrapolation, "pixel_series", lambda *_: xr.Dataset())
    resolved = roughxr.extrapolated(scan, shortest=2 * 8, **QUICK)
    np.testing.assert_allclose(resolved.pull_off_force, scanned.pull_off_force, rtol=1e-9)
    assert float(resolved.roughness_factor) == 1 and float(resolved.relative_std.sel(entry=UNSEEN)) == 0


def test_the_factor_multiplies_the_mean_of_all_places(scanned, real):
    mean = float(scanned.pull_off_force.mean())
    assert float(real.scanned_mean) == pytest.approx(mean, rel=1e-9)
    assert float(real.pull_off_mean) == pytest.approx(mean * float(real.roughness_factor), rel=1e-9)
    assert float(real.pull_off_mean) == pytest.approx(float(real.pull_off_force.mean()), rel=1e-9)


def test_the_interval_holds_all_errors_and_is_wider_than_that_of_the_mean_as_scanned(scanned, real):
    needed = {"places", UNSEEN, "work of adhesion", "range of adhesion", "modulus", "sphere radius", "tip radius"}
    assert needed | {"mesh"} <= set(real.entry.values)
    mean = roughxr.answer(scanned)
    others = 1.96 * float(np.sqrt((real.relative_std.drop_sel(entry=["places", UNSEEN]) ** 2).sum()))
    for end, mean_end in (("low", mean.low), ("high", mean.high)):
        places = float(np.log(mean_end / mean.pull_off_force))
        unseen = float(np.log(real[f"roughness_{end}"] / real.roughness_factor))
        half = float(np.log(real[f"pull_off_{end}"] / real.pull_off_mean))
        assert abs(half) == pytest.approx(np.hypot.reduce([places, unseen, others]), rel=1e-6) and abs(half) > abs(
            places
        )


def test_unseen_roughness_grows_with_the_pixels_and_with_the_octaves_below(scan, scanned):
    def unseen(surface, **how):
        out = real_pull_off(surface, scanned, None, **how)
        return float(out.roughness_factor), float(out.relative_std.sel(entry=UNSEEN))

    factors, errors = zip(*(unseen(scan, shortest=end) for end in (5, 2)), unseen(scan))
    coarse = scan.assign_coords(x=2 * scan.x, y=2 * scan.y)
    factors += (unseen(coarse)[0],)
    errors += (unseen(coarse)[1],)
    assert 1 > factors[0] and all(np.diff(factors) < 0) and all(np.diff(errors) > 0)


def test_octaves_that_are_not_seen_add_and_untested_ones_count_a_quarter_each():
    assert unseen_octaves(32, 8) == pytest.approx(2)
    added = [unseen_octaves(256, end) - unseen_octaves(256, 2 * end) for end in (16, 8, 3, 1.5, 0.75)]
    assert added[:2] == pytest.approx([1, 1])
    np.testing.assert_allclose(added[3:], np.divide(added[2:-1], 4))
    assert unseen_octaves(8, 8) == unseen_octaves(8, 16) == 0
    assert unseen_octaves(4, 0.5) == unseen_octaves(16, 14) == extrapolation._FEWEST_OCTAVES


def test_finer_roughness_lowers_a_force_far_more_than_it_raises_it():
    two, three = (one_scan_factor(octaves) for octaves in (2, 3))
    for unseen in (two, three):
        assert unseen.log + 1.96 * unseen.error.above == pytest.approx(extrapolation._HIGHEST)
    lowest = [unseen.log - 1.96 * unseen.error.below for unseen in (two, three)]
    assert lowest[1] == pytest.approx(1.5 * lowest[0]) and lowest[1] < -3


def test_an_assigned_work_without_a_range_has_a_range_known_to_a_factor_of_two(scan):
    chemical = scan.drop_vars("hamaker_constant")
    assigned = chemical.assign_coords(adhesion_range=0.4)
    assert [range_deviation(ds) for ds in (scan, chemical, assigned)] == [1.25, 2, 1.25]


def test_a_second_scan_that_shows_no_finer_roughness_changes_nothing(true_surface, monkeypatch):
    """Without wavelengths below two pixels of the first scan, both sides of the ratio are one surface."""
    monkeypatch.setattr(extrapolation, "_SECOND_PLACES", (2, 1))
    monkeypatch.setattr(extrapolation, "adhesive", on_cells_of_2_nm)
    smooth = roughxr.scans.smooth(true_surface, shortest=40).isel(x=slice(160), y=slice(160))
    first = image(roughxr.scans.smooth(true_surface, shortest=40), 4, tip=0.1).contact.assign_pair(**PAIR)
    with pytest.warns(UserWarning, match="it shows no more than the first scan"):
        second = second_scan(first, smooth)
    log, _ = extrapolation.second_scan_ratio(second, "exponential")
    assert abs(log) < 0.05


def test_with_a_second_scan_the_truth_lies_inside_an_interval_narrower_than_with_one(
    true_surface, scan, scanned, truth, fine, solved_once
):
    truth = truth.pull_off_force.mean()
    for shortest in (6, None):
        how = {"shortest": shortest}
        alone, with_second = (real_pull_off(scan, scanned, None, finer=second, **how) for second in (None, fine))
        assert with_second.pull_off_low < truth < with_second.pull_off_high
        assert abs(np.log(with_second.pull_off_mean / truth)) < abs(np.log(with_second.scanned_mean / truth))
        assert width(with_second, "roughness") <= width(alone, "roughness") * (1.001 if shortest else 0.8)
        assert "by a second scan" in estimate_notes(with_second)[1]


def test_the_interval_of_the_real_surface_contains_ranges_by_pressing(scan, scanned):
    """A third of the places hold five times as much once pressed."""
    mesh_error = xr.full_like(scanned.pull_off_force, 0.1).drop_attrs()
    settled = scanned.assign(pressed_pull_off_force=scanned.pull_off_force, pull_off_error=mesh_error)
    times = xr.where(scanned.subregion_x == scanned.subregion_x.max(), 5.0, 1.0)
    pressed = settled.assign(pressed_pull_off_force=scanned.pull_off_force * times)
    once, ranges = (real_pull_off(scan, solved, None) for solved in (settled, pressed))
    ratio = float(pressed.pressed_pull_off_force.mean() / scanned.pull_off_force.mean())
    assert ratio > 1.5 and float(ranges.pull_off_high / ranges.pull_off_mean) > ratio
    assert float(ranges.pull_off_low) == pytest.approx(float(once.pull_off_low))
    assert f"× 1 … {ratio:.2g} by how hard the sphere was pressed" in roughxr.answer(ranges).sentence
    assert [float(roughxr.answer(estimate).scan_error) for estimate in (once, ranges)] == pytest.approx([0.1, 0.1])


def test_an_unknown_error_of_the_mesh_is_missing_and_not_zero(scan, scanned):
    mesh_error = xr.full_like(scanned.pull_off_force, np.nan).drop_attrs()
    unknown = real_pull_off(scan, scanned.assign(pull_off_error=mesh_error), None)
    assert np.isnan(unknown.relative_std.sel(entry="mesh")) and np.isfinite(unknown.pull_off_high)


def width(estimate, name="pull_off"):
    return float(np.log(estimate[f"{name}_high"] / estimate[f"{name}_low"]))


def test_the_promised_interval_is_that_with_the_second_scan_at_the_default_end(scan, scanned, fine, solved_once):
    alone, with_second = (real_pull_off(scan, scanned, None, finer=second) for second in (None, fine))
    if alone.attrs["narrowing_source"] == UNSEEN:
        assert width(alone, "narrowed") == pytest.approx(width(with_second), rel=0.1)
    promised_std = float(alone.remaining_std.sel(entry=UNSEEN))
    assert promised_std == pytest.approx(float(with_second.relative_std.sel(entry=UNSEEN)), rel=0.1)


def noisy(surface, noise):
    return surface.assign(height=surface.height + np.random.default_rng(1).normal(0, noise, surface.height.shape))


@pytest.mark.filterwarnings("ignore::roughxr.scans.ImplausibleScan")
def test_a_worse_scan_is_never_narrower(true_surface, fine, monkeypatch):
    monkeypatch.setattr(extrapolation, "second_scan_ratio", lambda *arguments: (np.log(0.7), 0.1))

    def widths(surface):
        paired = surface.contact.assign_pair(**PAIR)
        solved = roughxr.adhesive(paired, subregions=(3, 3), mesh=round(roughxr.schema.pixel(surface)[0] / 4))
        alone, with_second = (real_pull_off(paired, solved, None, finer=second) for second in (None, fine))
        return np.array([width(alone), width(alone, "roughness"), width(with_second, "roughness")])

    usual = widths(image(true_surface, 4))
    worse = {
        "blunter tip": image(true_surface, 4, tip=12.0),
        "larger pixels": image(true_surface, 8),
        "more noise": noisy(image(true_surface, 4), 0.2),
    }
    for name, surface in worse.items():
        assert (widths(surface) >= usual * (1 - 1e-9)).all(), name


@pytest.mark.filterwarnings("ignore::roughxr.scans.ImplausibleScan")
def test_a_worse_second_scan_is_never_narrower(true_surface, scan, scanned, fine, solved_once):
    def widths(surface):
        estimate = real_pull_off(scan, scanned, None, finer=surface.isel(x=surface.x < 320, y=surface.y < 320))
        return np.array([width(estimate), width(estimate, "roughness")])

    usual = widths(fine)
    worse = {
        "blunter tip": image(true_surface, 1, tip=12.0),
        "larger pixels": image(true_surface, 2, tip=5.0),
        "more noise": noisy(fine, 0.2),
    }
    for name, surface in worse.items():
        assert (widths(surface) >= usual * (1 - 1e-9)).all(), name


def test_a_second_scan_by_the_shell_is_as_wide_as_promised(scan, fine, solved_once, tmp_path, capsys, monkeypatch):
    needed = ("asperities", "adhesive", "extrapolated")
    monkeypatch.setattr(analysis, "PARTS", [part for part in parts.PARTS if part.name in needed])
    scan.drop_vars(set(scan.coords) - {"x", "y"}).to_netcdf(tmp_path / "scan.nc")
    fine.to_netcdf(tmp_path / "fine.nc")
    command = ["run", str(tmp_path / "scan.nc"), "--finer", str(tmp_path / "fine.nc"), "-o", str(tmp_path / "run.nc")]
    command += ["--sphere-radius", "300", "--materials", "glass", "--level", "none", "-q"]
    command += ["--subregions", "3", "3", "--mesh", "2", "--budget", "0"]  # for speed: the scan's errors stay the same
    assert main(command) == 0
    groups = roughxr.archive.load(tmp_path / "run.nc")
    alone = real_pull_off(groups["scan"], groups["solutions/adhesive"], None)  # as a run without --finer
    with_second = groups["statistics/extrapolated"]
    assert alone.attrs["narrowing_source"] == UNSEEN
    assert width(with_second) == pytest.approx(width(alone, "narrowed"), rel=0.1)
    low, high = (f"{float(with_second[f'pull_off_{end}']):.2g}" for end in ("low", "high"))
    assert f"(95 % interval {low} … {high} nN" in capsys.readouterr().out


def test_noise_of_a_second_scan_is_cut_off_and_an_entry(scan, scanned, truth, fine, solved_once):
    rougher = noisy(fine, 0.2)
    quiet, loud = (second_scan(scan, surface) for surface in (fine, rougher))
    assert quiet.shown_wavelength < loud.shown_wavelength < 16
    assert float((loud.finer.height - quiet.finer.height).std()) < 0.7 * 0.2
    estimates = [real_pull_off(scan, scanned, None, finer=surface, shortest=6) for surface in (fine, rougher)]
    true_mean = float(truth.pull_off_force.mean())
    assert abs(np.log(float(estimates[1].pull_off_mean) / true_mean)) < 0.45
    assert width(estimates[1]) >= width(estimates[0])
    assert float(estimates[1].relative_std.sel(entry=SECOND_SCAN_NOISE)) > 0


@pytest.mark.parametrize(
    ("change", "doubt"),
    [
        (lambda fine: fine.assign(height=-fine.height), "skewness of curvatures"),
        (lambda fine: fine.assign(height=1.9 * fine.height), "rms of slopes"),
        (lambda fine: fine.assign_coords(x=0.6 * fine.x, y=0.6 * fine.y), "rms of curvatures"),
        (lambda fine: fine.assign(height=fine.height + 0.3 * fine.x), "tilt"),
    ],
)
def test_a_second_scan_that_differs_from_the_first_is_doubted_with_figures(grains, change, doubt):
    first = image(grains, 4).contact.assign_pair(**PAIR)
    fine = image(grains, 1, tip=5.0).isel(x=slice(160), y=slice(160))
    with warnings.catch_warnings():
        warnings.simplefilter("error", ImplausibleScan)
        second_scan(first, fine)
    with pytest.warns(ImplausibleScan, match=f"{doubt} .* instead of .* to "):
        second_scan(first, change(fine))


def test_a_slightly_skewed_second_scan_upside_down_is_doubted():
    made = synthetic.self_affine((320, 320), 2, rms=1.5, hurst=0.8, rolloff=60, cutoff=12, seed=2)
    bumps = roughxr.level(made.assign(height=made.height + 0.1 * made.height**2))
    first = image(bumps, 4).contact.assign_pair(**PAIR)
    fine = image(bumps, 1, tip=5.0).isel(x=slice(120), y=slice(120))
    with warnings.catch_warnings():
        warnings.simplefilter("error", ImplausibleScan)
        second_scan(first, fine)
    with pytest.warns(ImplausibleScan, match="skewness of heights −0.8.* instead of 0.4.* to 0.8"):
        second_scan(first, fine.assign(height=-fine.height))


def test_a_tilted_second_scan_is_levelled(scan, fine):
    tilted = fine.assign(height=fine.height + 0.05 * fine.x)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImplausibleScan)
        same, levelled = (second_scan(scan, surface).finer.height for surface in (fine, tilted))
    np.testing.assert_allclose(levelled, same, atol=1e-6)


def measured_ratio(ratio, spread):
    """Return what `extrapolated` reads of a result of `compare`: a ratio, whose 95 % interval spans a factor."""
    ends = {"ratio": ratio, "ratio_low": ratio / spread, "ratio_high": ratio * spread}
    return xr.Dataset({name: ("statistic", [value]) for name, value in ends.items()}, {"statistic": ["mean"]})


def test_a_measured_factor_takes_the_place_of_that_of_one_scan(scan, scanned):
    measured = real_pull_off(scan, scanned, None, measured=measured_ratio(0.5, 1.1))
    assert float(measured.roughness_factor) == pytest.approx(0.5)
    error = np.hypot(np.log(1.1) / 1.96, extrapolation._TRANSFER_ERROR)
    assert float(measured.relative_std.sel(entry=UNSEEN)) == pytest.approx(error)
    assert "by measured pull-offs" in estimate_notes(measured)[1]
    unsure = real_pull_off(scan, scanned, None, measured=measured_ratio(0.5, 1.1), force_std=0.5)
    assert unsure.relative_std.sel(entry=UNSEEN) > measured.relative_std.sel(entry=UNSEEN)


@pytest.mark.filterwarnings("ignore:.* have a range and not one pull-off")  # of a coarse mesh
def test_measured_forces_of_one_probe_predict_a_smaller_sphere_of_another_material(true_surface, scan, scanned, truth):
    measured = roughxr.compare(scanned, truth, statistics=["mean"])
    other = {"sphere_radius": 150, "materials": "polystyrene"}
    fine, coarse = (
        surface.contact.assign_pair(**other).contact.adhesive(subregions=(3, 3), mesh=mesh)
        for surface, mesh in ((true_surface, 1), (scan, 2))
    )
    expected = float(fine.pull_off_force.mean())
    calibrated = real_pull_off(scan.contact.assign_pair(**other), coarse, None, measured=measured, shortest=6)
    assert calibrated.pull_off_low < expected < calibrated.pull_off_high
    assert abs(np.log(calibrated.pull_off_mean / expected)) < abs(np.log(calibrated.scanned_mean / expected))


def test_what_is_no_comparison_with_an_interval_is_refused(scan, scanned):
    wrong = {"expected a result of `compare` with the mean": scanned, "found none": measured_ratio(0.5, np.nan)}
    for message, measured in wrong.items():
        with pytest.raises(ValueError, match=f"measured: .*{message}"):
            real_pull_off(scan, scanned, None, measured=measured)


def test_a_particle_at_rest_takes_the_same_ratio_as_a_probe(true_surface, scan, scanned, monkeypatch):
    at_rest = scanned.assign_coords(landing_share=("subregion", [1 / 9] * 9))
    monkeypatch.setattr(extrapolation, "second_scan_ratio", lambda *arguments: (np.log(0.7), 0.1))
    resting, probe = (
        real_pull_off(scan, places, None, finer=true_surface, shortest=6) for places in (at_rest, scanned)
    )
    assert float(resting.roughness_factor) == pytest.approx(float(probe.roughness_factor))
    assert resting.relative_std.sel(entry=UNSEEN) == probe.relative_std.sel(entry=UNSEEN)
    assert "by a second scan" in estimate_notes(resting)[1]


def test_a_second_scan_is_refused_where_it_is_not_finer_too_small_or_of_another_surface(true_surface, scan, scanned):
    fine = true_surface.isel(x=slice(160), y=slice(160))
    wrong = {
        "expected pixels smaller than 8 nm, found 8 nm": scan,
        "expected a side of 80 nm or more": fine.isel(x=slice(20), y=slice(20)),
        "have heights of rms": fine.assign(height=5 * fine.height),
        "have slopes of rms": fine.assign(height=fine.height + 3 * np.sin(fine.x / 3) * np.sin(fine.y / 3)),
        "expected no missing pixels, found 160 of": fine.assign(height=fine.height.where(fine.x != fine.x[3])),
    }
    for message, finer in wrong.items():
        with pytest.raises(ValueError, match=f"finer: .*{message}"):
            real_pull_off(scan, scanned, None, finer=finer)


def test_noise_is_bounded_by_neighbouring_lines():
    """White noise alone is its own bound, and a smooth surface adds nothing; roughness is taken for noise at most."""
    smooth = synthetic.self_affine((128, 128), 4, rms=1, hurst=0.8, rolloff=400, cutoff=120, seed=1)
    noise = np.random.default_rng(3).normal(0, 0.1, smooth.height.shape)
    assert noise_limit(smooth.assign(height=0 * smooth.height + noise)) == pytest.approx(0.1, rel=0.05)
    assert noise_limit(smooth.assign(height=smooth.height + noise)) == pytest.approx(0.1, rel=0.1)
    rough = synthetic.self_affine((128, 128), 4, rms=1, hurst=0.8, rolloff=100, cutoff=10, seed=1)
    assert noise_limit(rough.assign(height=rough.height + noise)) > 0.1


def test_noise_beyond_the_range_of_adhesion_is_a_caution_and_below_it_an_entry(scan, scanned, real):
    assert noise_limit(scan) > 0.3 and "noise" not in real.entry
    assert "Noise cannot be distinguished from roughness" in estimate_notes(real)[0]
    flatter = scan.assign(height=0.05 * scan.height)
    clean = real_pull_off(flatter, scanned, None)
    assert "Noise" not in estimate_notes(clean)[0] and "noise_limit" not in clean.attrs
    assert "The errors of the pair are not included." in estimate_notes(clean)[1]
    assert "The errors of the pair" not in estimate_notes(real)[1]
    noisy = CHANGES["noise"](flatter, 1.0)
    added = float((noisy.height - flatter.height).std())
    assert added == pytest.approx(noise_limit(flatter), rel=0.05)


def test_refusals_state_their_reason(scan, scanned):
    with pytest.raises(ValueError, match="expected roughness, found a flat scan"):
        real_pull_off(scan.assign(height=0 * scan.height), scanned, None)
    with pytest.raises(ValueError, match="expected enough independent places for an interval, found 1 that adhere"):
        roughxr.extrapolated(scan, **QUICK | {"subregions": (1, 1)})
    resting = scanned.assign_coords(landing_share=("subregion", [1 / 9] * 9))
    with pytest.raises(ValueError, match="finer: expected a second scan for resting positions, found none"):
        real_pull_off(scan, resting, None)


def test_the_pixel_series_is_the_pull_off_on_every_second_and_fourth_pixel(scan, scanned, real):
    np.testing.assert_allclose(real.pixel_size, [8, 16, 32])
    assert float(real.pull_off_on_pixels[0]) == pytest.approx(float(scanned.pull_off_force.mean()))
    second = scan.isel(x=slice(1, None, 2), y=slice(1, None, 2))
    expected = float(roughxr.adhesive(second, subregions=scanned, mesh=4).pull_off_force.mean())
    assert float(real.pull_off_on_pixels[1]) == pytest.approx(expected, rel=0.02)
    assert pixel_series(scan, scanned.assign_coords(landing_share=("subregion", [1 / 9] * 9)), 0.0, None).sizes == {}
    drawn = figures.force_over_pixel(real)
    np.testing.assert_allclose(drawn.lines[0].get_ydata(), real.pull_off_on_pixels)


def test_the_result_is_a_distribution_over_places(real):
    np.testing.assert_allclose(real.contact.pull_off().pull_off_force, real.pull_off_force)
    assert real.contact.plot() is not None
    assert real.contact.pdf("pull_off_force") is not None
    quantiles = roughxr.statistics.bootstrap(real, "pull_off_force", statistics=["q50"])
    assert float(quantiles.estimate[0]) == pytest.approx(float(real.pull_off_force.median()))
    assert real.pull_off_force.dims == ("subregion",)


def test_the_answer_is_the_best_estimate_with_its_interval(real):
    mean = real.contact.answer()
    assert float(mean.best_low) == float(real.pull_off_low) and float(mean.best_high) == float(real.pull_off_high)
    assert float(mean.best_estimate) == float(real.pull_off_mean)
    assert float(mean.pull_off_force) == pytest.approx(float(real.scanned_mean))
    assert mean.sentence.startswith("Pull-off force of the real surface: ")


def test_the_answer_names_a_second_scan_where_it_narrows_the_interval(real):
    assert best_estimate_notes({"statistics/extrapolated": real}) == estimate_notes(real)
    assert "The interval narrows most with a second scan" in real.contact.answer().sentence


def test_an_advised_second_scan_has_finer_pixels_than_the_scan(true_surface, truth, real):
    assert "a second scan, 300 nm wide on pixels of 2 nm" in real.contact.answer().sentence  # pixels of 8 nm
    fine = real_pull_off(true_surface.contact.assign_pair(**PAIR), truth, None)  # pixels of 2 nm
    assert float(fine.relative_std.sel(entry=UNSEEN)) > 0
    assert "a second scan" not in fine.contact.answer().sentence


def test_a_run_without_an_estimate_says_why(scan, scanned):
    missing = without_estimate(scan, "resting positions")
    assert best_estimate_notes({"statistics/extrapolated": missing}) == []
    headline = report.headline({"statistics/adhesive": roughxr.pull_off(scanned), "statistics/extrapolated": missing})
    assert "The effect of finer roughness is not included: resting positions." in headline


def test_the_error_of_the_hurst_exponent_holds_the_truth():
    off = []
    for seed in range(8):
        made = synthetic.self_affine((192, 192), 5, rms=1, hurst=0.6, rolloff=150, seed=seed)
        fitted = roughxr.scans.self_affine_fit(made, shown=20)
        off.append((float(fitted.hurst_exponent) - 0.6) / float(fitted.hurst_standard_error))
    assert np.sum(np.abs(off) < 2) >= 7
