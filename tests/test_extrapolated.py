"""The surface as it would be: its roughness extrapolated below the scan."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import roughxr
from roughxr import reference, report
from roughxr.contact.adhesive_options import preload_problem
from roughxr.contact.subpixel import AddedRoughness, _finer_boxes, _patches, extrapolated_pull_off, pack_patches
from roughxr.kernels.topography.random_surface import band_rms, k_correlation
from roughxr.report.summary import best_estimate_notes
from roughxr.scans import self_affine_fit, synthetic
from roughxr.scans.fine_scales import known_spectrum
from roughxr.scans.self_affinity import unlike_self_affine
from roughxr.studies import extrapolation
from roughxr.studies.extrapolation import Surface, _two_sides, not_extrapolated, resolved_spectrum

from .surfaces import rigid_pull_off

PAIR = {"sphere_radius": 300, "contact_modulus": 40, "work_of_adhesion": 0.15}


def picture(truth, tip, averaged):
    """Return what a microscope draws with a round tip, on pixels of four cells, sampled or averaged."""
    drawn = roughxr.scans.dilate(truth, tip_radius=tip)
    return drawn.coarsen(x=4, y=4).mean() if averaged else drawn.isel(x=slice(2, None, 4), y=slice(2, None, 4))


def found_unlike(scan):
    return unlike_self_affine(scan, float(resolved_spectrum(scan).shortest_wavelength))


@pytest.fixture(scope="module")
def surface():
    made = synthetic.self_affine((96, 96), 5, rms=1.2, hurst=0.8, rolloff=150, cutoff=20, seed=4)
    return roughxr.assign_pair(made, **PAIR)


@pytest.fixture(scope="module")
def found(surface):
    return roughxr.extrapolated(surface, subregions=(2, 2), seeds=2, shortest=8)


def test_a_surface_without_added_waves_is_that_of_the_simulation(surface):
    """The patches within reach, moved together, against the whole window on cells as large."""
    problem, adhesion = preload_problem(surface)
    centres = roughxr.scans.regions.centres(surface, (2, 2))
    model = known_spectrum(resolved_spectrum(surface))
    tasks = Surface(surface, problem, centres).patches
    end = AddedRoughness(model, 20.0, 20.0)
    mine = [extrapolated_pull_off(*task, 0, float(problem.steps[-1]), 0.0, problem, adhesion, end)[0] for task in tasks]
    whole = roughxr.adhesive(surface, subregions=centres, law="exponential", mesh=2)
    np.testing.assert_allclose(mine, whole.pull_off_force, rtol=0.03)


def test_the_answer_is_the_best_estimate_with_its_interval(found, capsys):
    mean = found.contact.answer()
    assert float(mean.low) == float(found.pull_off_lower) and float(mean.high) == float(found.pull_off_upper)
    assert float(mean.pull_off_force) == float(found.pull_off_mean)
    assert "Best estimate" in capsys.readouterr().out


def test_patches_packed_side_by_side_hold_every_cell_once():
    draw = np.random.default_rng(1)
    sheet = np.where(draw.random((120, 90)) < 0.02, draw.random((120, 90)), np.inf)
    patches = _patches(sheet, 2)
    packed = pack_patches(patches)
    assert len(patches) > 20 and packed.size < sheet.size * 1.5
    for whole in (packed, np.concatenate([one.ravel() for one in patches])):
        np.testing.assert_array_equal(np.sort(whole[np.isfinite(whole)]), np.sort(sheet[np.isfinite(sheet)]))


def test_finer_boxes_hold_what_is_near_and_share_no_point():
    near = np.random.default_rng(2).random((60, 50)) < 0.03
    box = tuple(3.0 * (np.arange(n) + 0.5) for n in near.shape)
    finer = _finer_boxes(box, near, 3.0, 1.0, 2.0)
    points = [(x, y) for part in finer for x in part[0] for y in part[1]]
    assert len(set(points)) == len(points)
    offsets = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    wanted = {(box[0][i] + dx, box[1][j] + dy) for i, j in np.argwhere(near) for dx, dy in offsets}
    assert wanted <= set(points)


def test_the_estimate_lies_below_the_scan_and_inside_its_interval(surface, found):
    shown = roughxr.adhesive(surface, subregions=(2, 2), law="exponential", mesh=2).pull_off_force
    assert float(found.pull_off_lower) < float(found.pull_off_mean) < float(shown.mean())
    assert float(found.pull_off_mean) == pytest.approx(float(found.pull_off_force.mean()))
    below, above = (abs(np.log(float(found[f"pull_off_{end}"] / found.pull_off_mean))) for end in ("lower", "upper"))
    assert below == pytest.approx(1.96 * float(np.sqrt((found.relative_error**2).sum())))
    other = 1.96 * found.relative_error.drop_sel(entry=["spectrum", "finer roughness"])
    waves = found.scale_pull_off.sortby("shortest_kept").values
    took = np.log(waves[-1] / waves[0])
    spectrum = 1.96 * float(found.relative_error.sel(entry="spectrum"))
    assert above == pytest.approx(np.hypot(float(np.sqrt((other**2).sum())), min(spectrum, took)))
    assert {"spectrum", "range of adhesion", "places", "seeds"} <= set(found.entry.values)
    assert float(found.shortest_wavelength) == 8 and found.pull_off_force.dims == ("subregion", "seed")
    assert found.scale_pull_off.values[0] > found.scale_pull_off.values[-1]


def test_the_mean_is_that_over_particles_where_places_hold_shares_of_them(surface, found):
    places = roughxr.scans.regions.centres(surface, (2, 2)).assign_coords(
        landing_share=("subregion", [0.7, 0.1, 0.15, 0.05])
    )
    rested = roughxr.extrapolated(surface, subregions=places, seeds=1, shortest=8)
    first = found.pull_off_force[:, :1]
    np.testing.assert_allclose(rested.pull_off_force, first, rtol=1e-6)
    by_particle = np.average(rested.pull_off_force.mean("seed"), weights=[0.7, 0.1, 0.15, 0.05])
    assert float(rested.pull_off_mean) == pytest.approx(by_particle)
    assert float(first.mean()) != pytest.approx(by_particle, rel=1e-3)


def test_a_seed_is_one_surface_whatever_else_is_asked(surface, found):
    again = roughxr.extrapolated(surface, subregions=([120.0], [120.0]), seeds=1, shortest=8)
    assert float(again.pull_off_force[0, 0]) == pytest.approx(float(found.pull_off_force[0, 0]), rel=0.02)


@pytest.mark.parametrize("failures", [1, 100], ids=["once", "always"])
def test_a_solve_that_fails_is_tried_again_and_reported(surface, found, monkeypatch, failures):
    tried = []

    def failing(height, first, pixel, centre, seed, *rest):
        if centre[0] < 240 and centre[1] < 240 and seed == 1 and rest[-1].shortest == 8:
            tried.append(extrapolated_pull_off(height, first, pixel, centre, seed, *rest))
            return np.full(3, np.nan) if len(tried) <= failures else tried[-1]
        return extrapolated_pull_off(height, first, pixel, centre, seed, *rest)

    monkeypatch.setattr(extrapolation, "extrapolated_pull_off", failing)
    again = roughxr.extrapolated(surface, subregions=(2, 2), seeds=2, shortest=8)
    lost = failures > 1
    assert int(again.failed_solves) == lost == int(again.pull_off_force.isnull().sum())
    assert ("1 of 8 solves failed" in again.attrs["known"]) == lost
    expected = found.pull_off_force.where(again.pull_off_force.notnull())
    if not lost:  # the guess sets how far cells are included
        assert tried[1][0] == pytest.approx(float(expected[0, 1]), rel=5e-3)
        expected[0, 1] = tried[1][0]
    np.testing.assert_allclose(again.pull_off_force, expected, rtol=1e-3)
    assert float(again.pull_off_mean) == pytest.approx(float(expected.mean()), rel=1e-3)


def test_the_waves_that_a_microscope_falsifies_are_replaced():
    """A scan with waves to its pixels is trusted down to four pixels; one that ends before, down to there."""
    jagged = synthetic.self_affine((128, 128), 5, rms=1, hurst=0.5, rolloff=150, seed=1)
    smooth = synthetic.self_affine((128, 128), 5, rms=1, hurst=0.5, rolloff=150, cutoff=13, seed=1)
    assert float(resolved_spectrum(jagged).shortest_wavelength) == 20
    assert float(resolved_spectrum(smooth).shortest_wavelength) == pytest.approx(13, rel=0.05)


def test_the_error_of_the_hurst_exponent_holds_the_truth():
    off = []
    for seed in range(8):
        made = synthetic.self_affine((192, 192), 5, rms=1, hurst=0.6, rolloff=150, seed=seed)
        fitted = roughxr.scans.self_affine_fit(made, shown=20)
        off.append((float(fitted.hurst_exponent) - 0.6) / float(fitted.hurst_error))
    assert np.sum(np.abs(off) < 2) >= 7


@pytest.mark.parametrize("averaged", [False, True])
def test_the_extrapolated_spectrum_is_that_of_the_surface_that_a_microscope_draws(averaged):
    """Its power at half the shortest wave shown, against the truth, lies within twice the stated error."""
    off = []
    for seed in range(6):
        hurst = (0.5, 0.7, 0.9)[seed % 3]
        truth = synthetic.self_affine((480, 480), 2, rms=1.5, hurst=hurst, rolloff=150, cutoff=6, seed=seed)
        model = known_spectrum(resolved_spectrum(picture(truth, 6, averaged)))
        q = 2 * np.pi / 16
        power = 1.5**2 / band_rms(lambda q, H=hurst: k_correlation(q, 1.0, 150, H), 960, 6) ** 2
        off.append(np.log(model.density(q) / (power * k_correlation(q, 1.0, 150, hurst))))
        assert abs(off[-1]) < 2 * (model.error + 2 * model.hurst_error * np.log(2))
    assert abs(np.mean(off)) < 0.3


def test_between_rigid_bodies_the_pull_falls_as_the_mean_potential_over_gaussian_heights():
    """Of Lennard-Jones's law, whose length is long beside the waves, as the added ones raise the standard deviation."""
    ground = synthetic.self_affine((256, 256), 5, rms=0.9, hurst=0.2, rolloff=25, cutoff=20, seed=2)
    ground = roughxr.assign_pair(ground, sphere_radius=5000, contact_modulus=4e2, work_of_adhesion=0.06)
    ground, waves = ground.assign_coords(adhesion_range=3.0), [8, 14, 20]
    model = known_spectrum(roughxr.scans.self_affine_fit(ground))
    sigma = [np.hypot(0.9, band_rms(model.density, model.shown, wave)) for wave in waves]
    left = [reference.gaussian_work(rms=one, length=3.0) for one in sigma]
    how = {"law": "lennard_jones", "subregions": ([640.0], [640.0])}
    pull = [np.mean([rigid_pull_off(ground, wave, seed=seed, **how) for seed in range(3)]) for wave in waves]
    assert left[0] < 0.7 * left[-1]
    np.testing.assert_allclose(pull / pull[-1], np.divide(left, left[-1]), rtol=0.08)


def test_between_stiff_bodies_it_is_the_rigid_sum_over_the_same_waves():
    ground = synthetic.self_affine((96, 96), 4, rms=1, hurst=0.7, rolloff=150, cutoff=40, seed=4)
    pair = {"sphere_radius": 500, "contact_modulus": 4e3, "work_of_adhesion": 0.06, "adhesion_range": 0.4}
    ground = roughxr.assign_pair(ground, **pair)
    how = {"shortest": [10, 20, 40], "seeds": 2, "subregions": ([190.0, 150.0], [190.0, 230.0])}
    bent = roughxr.scale_dependence(ground, **how).pull_off_force.mean(["subregion", "seed"])
    places = how["subregions"]
    rigid = [np.mean([rigid_pull_off(ground, w, seed=s, subregions=places) for s in range(2)]) for w in how["shortest"]]
    assert rigid[0] < 0.5 * rigid[-1]
    np.testing.assert_allclose(bent, rigid, rtol=0.1)


def test_what_cannot_be_extrapolated_says_so(surface):
    flat = roughxr.assign_pair(surface.assign(height=surface.height * 0), **PAIR)
    with pytest.raises(ValueError, match="expected a spectrum to extrapolate"):
        roughxr.extrapolated(flat)
    said = not_extrapolated(surface, "noise to the pixel")
    solved = roughxr.pull_off(roughxr.adhesive(surface, subregions=(2, 1), mesh=roughxr.Mesh(accuracy=None)))
    words = report.headline({"statistics/adhesive": solved, "statistics/extrapolated": said})
    assert "Roughness finer than the pixel is not included: noise to the pixel." in words
    assert np.isnan(said.pull_off_mean) and not bool(said.converged)


def test_at_most_five_of_a_hundred_self_affine_surfaces_are_refused():
    refused = 0
    for seed in range(100):
        draw = np.random.default_rng(seed)
        made = {"rms": draw.uniform(0.7, 3), "hurst": draw.uniform(0.4, 0.95), "rolloff": draw.uniform(80, 250)}
        cell = draw.choice([1.0, 2.0])
        truth = synthetic.self_affine((256, 256), cell, cutoff=4, seed=seed, **made)
        seen = picture(truth, draw.uniform(5, 10), bool(draw.integers(2)))
        refused += bool(found_unlike(seen.assign(height=seen.height + draw.normal(0, 0.05, seen.height.shape))))
    assert refused <= 5


def test_debris_on_a_self_affine_surface_does_not_count():
    assert not found_unlike(roughxr.open_sample("glass"))


def grains(seed):
    """Return round grains of 20 nm, their tops at different heights, on cells of 1 nm."""
    draw, at = np.random.default_rng(seed), np.arange(256.0)
    tops = zip(*draw.uniform(0, 256, (2, 300)), draw.normal(0, 3, 300))
    height = np.max([z - ((at[:, None] - x) ** 2 + (at - y) ** 2) / 40 for x, y, z in tops], axis=0)
    return synthetic.self_affine((256, 256), 1, rms=1, hurst=0.5, rolloff=99, seed=0).assign(
        height=(("x", "y"), height)
    )


def of_steps(seed):
    base = synthetic.self_affine((512, 512), 1, rms=1.5, hurst=0.9, rolloff=200, cutoff=20, seed=seed)
    return base.assign(height=0.8 * np.floor(base.height / 0.8))


def of_noise(seed):
    base = synthetic.self_affine((512, 512), 1, rms=0.2, hurst=0.9, rolloff=200, seed=seed)
    return base.assign(height=base.height + np.random.default_rng(seed).normal(0, 0.5, base.height.shape))


@pytest.mark.parametrize(
    ("make", "why"), [(grains, "curvature of skewness -"), (of_steps, "no power law"), (of_noise, "no power law")]
)
def test_other_surfaces_are_told_from_self_affine_ones(make, why):
    assert all(why in found_unlike(picture(make(seed), 8, averaged=False)) for seed in range(4))


@pytest.fixture(scope="module")
def measured():
    """Return a part of a measured map, whose summits are rounder than its valleys."""
    scan = roughxr.level(roughxr.open_sample("rough").isel(x=slice(128), y=slice(128)).load())
    return roughxr.assign_pair(scan, sphere_radius=500, materials="glass")


def test_a_measured_map_has_an_estimate_between_the_scan_and_the_scan_with_roughness_added(measured):
    given = {"subregions": (2, 1), "seeds": 1}
    estimate = roughxr.extrapolated(measured, shortest=8, **given)
    scanned = roughxr.extrapolated(measured, shortest=2 * float(measured.x[1] - measured.x[0]), **given)
    assert estimate.pull_off_lower < estimate.pull_off_mean < scanned.pull_off_mean < estimate.pull_off_upper
    assert "lies between both, nearer to the scan, which shows a" in estimate.attrs["assumed"]


def test_the_fit_of_the_scan_itself_changes_nothing_where_it_is_not_self_affine(measured):
    """Only a finer measurement tells more than the scan; a larger shortest wavelength may be stated."""
    given = {"subregions": (2, 1), "seeds": 1, "shortest": 20}
    usual = roughxr.extrapolated(measured, **given)
    fitted = roughxr.extrapolated(measured, spectrum=self_affine_fit(measured), **given)
    for name in ("pull_off_mean", "pull_off_lower", "pull_off_upper"):
        assert float(fitted[name]) == pytest.approx(float(usual[name]), rel=1e-6)
    assert fitted.attrs["assumed"] == usual.attrs["assumed"] and "lies between both" in usual.attrs["assumed"]
    blunt = roughxr.extrapolated(measured, spectrum=self_affine_fit(measured, shown=250), **given)
    assert float(blunt.longest_added) == 250 > 1.5 * float(usual.longest_added)
    assert "lies between both" in blunt.attrs["assumed"]


def test_the_fit_of_a_finer_scan_is_used_from_the_shortest_wavelength_of_the_coarser(measured):
    """Also where the latter is not self-affine; nothing is missing between both."""
    fine = synthetic.self_affine((256, 256), 2.0, rms=0.5, hurst=0.6, rolloff=120.0, seed=3)
    fit = self_affine_fit(fine, shown=8)
    out = roughxr.extrapolated(measured, subregions=(2, 1), seeds=1, shortest=20, spectrum=fit)
    model, longest = known_spectrum(fit), float(resolved_spectrum(measured).shortest_wavelength)
    assert float(out.longest_added) == pytest.approx(longest)
    assert float(out.added_rms) == pytest.approx(band_rms(model.density, longest, 20), rel=0.01)
    assert "spectrum down to 8 nm" in out.attrs["known"] and "lies between both" not in out.attrs["assumed"]
    at = 2 * np.pi / np.array([0.99 * longest, 30.0, 9.0, 3.0])
    tilted = known_spectrum(fit, longest)._replace(tilt=1.0)
    np.testing.assert_allclose(tilted.density(at), model._replace(tilt=1.0).density(at), rtol=1e-3)


@pytest.mark.parametrize("kind", ["self-affine", "measured"])
def test_no_place_is_solved_twice(surface, measured, monkeypatch, kind):
    solved = []

    def recorded(height, first, pixel, centre, seed, depth, pull, problem, adhesion, below):
        key = (centre, seed if below.shortest < below.longest else 0, below.shortest, below.spectrum.tilt)
        solved.append((*key, adhesion.length, problem.hardness, height.tobytes()))
        return extrapolated_pull_off(height, first, pixel, centre, seed, depth, pull, problem, adhesion, below)

    monkeypatch.setattr(extrapolation, "extrapolated_pull_off", recorded)
    roughxr.extrapolated(surface if kind == "self-affine" else measured, subregions=(3, 2), seeds=2, shortest=20)
    assert len(solved) == len(set(solved)) > 12


def test_octaves_that_would_take_too_long_are_part_of_the_interval(surface, monkeypatch):
    given = {"subregions": (3, 2), "seeds": 1, "accuracy": 0.3}
    monkeypatch.setattr(extrapolation, "_MOST_CELLS", 10**9)
    whole = roughxr.extrapolated(surface, **given)
    monkeypatch.setattr(extrapolation, "_MOST_CELLS", 0)
    ended = roughxr.extrapolated(surface, **given)
    assert bool(whole.converged) and not bool(ended.converged)
    assert float(ended.shortest_wavelength) == pytest.approx(0.5 * float(ended.longest_added))
    assert float(ended.shortest_wavelength) > 1.4 * float(whole.shortest_wavelength)
    assert ended.pull_off_lower < whole.pull_off_mean < ended.pull_off_upper
    assert float(ended.pull_off_mean) < float(ended.scale_pull_off[-1])
    assert "would take too long" in ended.attrs["assumed"] and "too long" not in whole.attrs["assumed"]


@given(st.floats(1e-3, 2), st.floats(0, 1), st.integers(1, 12))
def test_later_octaves_change_the_pull_off_between_amplitude_and_energy(change, hurst, octaves):
    mean, error = extrapolation._rest(change, hurst, octaves)
    series = [sum(change * 2 ** (-power * max(hurst, 0.3) * (k + 1)) for k in range(octaves)) for power in (1, 2)]
    assert mean + error == pytest.approx(series[0]) and mean - error == pytest.approx(series[1])


@given(st.floats(1e-3, 4), st.floats(0, 2), st.sampled_from(["", "steps"]))
def test_the_estimate_and_its_interval_follow_both_sides(ratio, noise, unlike):
    def sides_of(ratio, noise):
        return _two_sides(np.exp(ratio), 1.0, np.exp(-noise), unlike, 0.1)

    sides = sides_of(ratio, noise)
    estimate, (below, above) = ratio - sides.fall, sides.widths()  # ln over that with added roughness
    assert estimate - below < -noise < ratio < estimate + above  # both sides lie inside, with the noise, too
    for worse in (sides_of(1.1 * ratio, noise), sides_of(ratio, noise + 0.1)):
        assert sum(worse.widths()) > below + above
    if unlike:
        assert 0 < sides.fall <= 0.5 and (ratio > 0.05 or sides.fall == pytest.approx(ratio / 2, rel=0.05))
    else:
        assert sides.fall == pytest.approx((ratio + noise) / 2)  # the geometric mean


@pytest.mark.parametrize(("rolloff", "own"), [(250, True), (40, False)])
def test_a_scans_own_slope_is_extrapolated_only_where_it_shows_a_power_law(rolloff, own):
    scan = synthetic.self_affine((128, 128), 5, rms=1, hurst=0.8, rolloff=rolloff, seed=3)
    out = roughxr.extrapolated(roughxr.assign_pair(scan, **PAIR), subregions=(2, 1), seeds=1, shortest=8)
    assert ("lies between both" not in out.attrs["assumed"]) == own


def test_the_first_words_are_both_answers(surface, found):
    solved = roughxr.pull_off(roughxr.adhesive(surface, subregions=(2, 2), mesh=roughxr.Mesh(accuracy=None)))
    words = report.headline({"statistics/adhesive": solved, "statistics/extrapolated": found})
    assert words.startswith("Mean pull-off ") and "best estimate" in words


def test_the_report_states_the_gain_by_a_finer_scan(found):
    """A finer scan removes the errors of the unseen roughness, and no others."""
    many = found.assign(relative_error=xr.where(found.entry == "places", 0.05, found.relative_error))
    known, assumed, interval, measured = best_estimate_notes({"statistics/extrapolated": many})
    assert (known, assumed) == (found.attrs["known"], found.attrs["assumed"]) and "measured surfaces" in measured
    rest = 1.96 * float(np.sqrt((many.relative_error.drop_sel(entry=["spectrum", "finer roughness"]) ** 2).sum()))
    now = float(np.sqrt(found.pull_off_upper / found.pull_off_lower))
    assert f"spans a factor of {now:.3g} to either side" in interval and np.exp(rest) < 0.9 * now
    assert f"it would span a factor of {np.exp(rest):.3g} or more" in interval
    few = found.assign(relative_error=xr.where(found.entry == "places", 3.0, found.relative_error))
    assert "A finer scan would hardly narrow it" in best_estimate_notes({"statistics/extrapolated": few})[2]
    assert best_estimate_notes({"statistics/extrapolated": not_extrapolated(found, "flat")}) == []


def test_pixels_wider_than_the_contact_are_solved_on_cells_that_resolve_it():
    """On cells of an eighth of the shortest wavelength the pull-off was half as large again."""
    scan = synthetic.self_affine((48, 48), 80.0, rms=1.0, hurst=0.8, rolloff=1000, cutoff=400, seed=5)
    scan = scan.contact.assign_pair(sphere_radius=500, materials="glass/silicon")
    places = roughxr.scans.regions.centres(scan, (2, 2))
    fine = roughxr.adhesive(scan, subregions=places, law="exponential", mesh=16).pull_off_force.mean()
    best = roughxr.extrapolated(scan, subregions=places, seeds=1, shortest=160)
    assert float(best.scale_pull_off[0]) == pytest.approx(float(fine), rel=0.02)
