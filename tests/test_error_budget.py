"""The error budget: what is known of each entry comes out, what was not computed says so, and the total is the sum."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import roughxr
from roughxr import archive, figures
from roughxr.application import report
from roughxr.application.report.run_tables import budget_table
from roughxr.application.report.summary import BUDGET
from roughxr.application.wording import names_in_words, render_sentence
from roughxr.mechanics.studies import budget_changes
from roughxr.mechanics.studies.assumptions import CHANGES, noise_limit
from roughxr.mechanics.studies.budget_changes import mean_change
from roughxr.mechanics.studies.uncertainty_budget import budget_of, error_budget, stated_mesh_error
from roughxr.mechanics.vocabulary import numbers
from roughxr.mechanics.vocabulary.error_sources import (
    CHANGED,
    ERROR_SOURCES,
    KNOWN_RANGE,
    THIN,
    UNKNOWN_RANGE,
    error_of_interval,
    symmetric_error,
    total_error,
)

from .surfaces import as_measured, unpressed
from .verb_calls import unlabelled

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")

QUICK = {"law": "exponential", "mesh": roughxr.Mesh(1, step=0.8)}


@pytest.fixture(scope="module", autouse=True)
def _unpressed():
    with unpressed():
        yield


def pair(heights, radius, work, pixel=10.0):
    x = np.arange(heights.shape[0]) * pixel
    surface = xr.Dataset({"height": (("x", "y"), heights)}, coords={"x": x, "y": x})
    return roughxr.assign_pair(
        roughxr.schema.label(surface), sphere_radius=radius, contact_modulus=40, work_of_adhesion=work
    )


@pytest.fixture(scope="module")
def rough():
    surface = roughxr.scans.synthetic.self_affine((96, 96), 10, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    return roughxr.assign_pair(surface, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.2)


TRIED = {"mesh": [2], "work of adhesion": [0.9, 1.1], "modulus": [1.0], "tip radius": [-1.0]}
HOW = {"places": 2, "preload": 0.0, "mesh": QUICK["mesh"]}


@pytest.fixture(scope="module")
def solved(rough):
    return roughxr.adhesive(rough, subregions=(2, 1), **QUICK)


@pytest.fixture(scope="module")
def budget(rough, solved):
    return budget_of(rough, solved, settings=TRIED, **HOW)


def basis_of_errors(budget):
    """Return how the errors of a budget were computed, in the words of a report."""
    return budget_table({BUDGET: budget})["how it was computed"].drop("all of these")


def test_a_smooth_sphere_depends_on_work_and_radius_in_proportion_and_not_on_the_modulus():
    """JKR's pull-off is 3/2 π w R: the slopes are 1, 1 and 0.

    On contacts of 12 to 18 cells in radius each pull-off is off by up to 0.5 %: of slopes over 50 %, 0.03.
    """
    flat = pair(np.zeros((20, 20)), radius=1500.0, work=0.2)
    tried = {name: [1.5] for name in ("work of adhesion", "sphere radius", "modulus")}
    mesh = roughxr.Mesh(4, step=0.25)
    smooth_budget = error_budget(flat, settings=tried, law="jkr", mesh=mesh, places=1)
    slopes = smooth_budget.slope.to_series()
    assert slopes["work of adhesion"] == pytest.approx(1, abs=0.04)
    assert slopes["sphere radius"] == pytest.approx(1, abs=0.04)
    assert slopes["modulus"] == pytest.approx(0, abs=0.04)
    assert np.isnan(slopes[["places", "mesh", "levelling"]]).all()
    assert float(smooth_budget.pull_off_mean) == pytest.approx(1.5 * np.pi * 0.2 * 1500, rel=0.01)


def test_what_is_not_off_gives_nothing_and_what_was_not_computed_says_why(budget):
    entry = budget.relative_std.to_series()
    why = basis_of_errors(budget)
    assert entry["modulus"] == 0.0  # it was changed by nothing
    assert np.isnan(entry["tip radius"]) and "tip_radius: expected" in why["tip radius"]
    assert np.isnan(entry["levelling"]) and why["levelling"] == "not computed: left out of the settings"
    assert 0.05 < entry["work of adhesion"] < 0.3
    assert all(reason.startswith("not computed") for reason in why[entry.isna()]) and (why != "").all()


def test_an_error_of_numpy_is_no_reason_of_an_entry(rough, monkeypatch):
    monkeypatch.setitem(CHANGES, "tip radius", lambda ds, radius: np.ones(2) + np.ones(3))
    with pytest.raises(ValueError, match="could not be broadcast"):
        error_budget(rough, settings={"tip radius": [10.0]}, places=1, subregions=(1, 1), **QUICK)


def test_noise_sharper_than_the_tip_has_no_entry_of_a_tip(rough):
    """To cut off noise would flatten summits and raise the pull-off, while a tip's effect on a surface lowers it."""
    noise = np.random.default_rng(0).normal(0.0, 1.0, rough.height.shape)
    noisy = rough.assign(height=rough.height + noise).isel(x=slice(48), y=slice(48))
    noisy = noisy.assign_coords(x=noisy.x * 0.2, y=noisy.y * 0.2)  # pixels of 2 nm
    noisy.height.attrs = rough.height.attrs
    options = {"settings": {"tip radius": [10.0]}, "places": 1, "subregions": (1, 1), **QUICK}
    entry = error_budget(noisy, **options).sel(entry="tip radius")
    assert np.isnan(entry.relative_std) and "noise, or a sharper tip" in entry.reason.item()


def test_the_total_is_the_root_of_the_sum_of_squares(budget):
    deviations = budget.relative_std.values
    assert float(budget.total_std) == pytest.approx(np.sqrt(np.nansum(deviations**2)), rel=1e-12)


def test_entries_are_the_largest_changes(rough, solved, budget):
    ways = ({"work of adhesion": [factor]} for factor in (0.9, 1.1))
    single_changes = [budget_of(rough, solved, settings=way, **HOW).sel(entry="work of adhesion") for way in ways]
    largest = max(single_changes, key=lambda entry: abs(float(entry.pull_off_change)))
    entry = budget.sel(entry="work of adhesion")
    assert float(entry.relative_std) == np.log1p(abs(float(largest.pull_off_change)))
    assert entry.setting == largest.setting


def test_a_known_bias_is_taken_off_the_mean_and_half_of_it_stays(rough, solved, budget):
    mesh = budget.sel(entry="mesh")
    finer = roughxr.adhesive(rough, subregions=(2, 1), law="exponential", mesh=roughxr.Mesh(2, step=0.4))
    assert float(budget.pull_off_mean) == pytest.approx(float(solved.pull_off_force.mean()), rel=1e-12)
    assert float(budget.pull_off_corrected) == pytest.approx(float(finer.pull_off_force.mean()), rel=1e-6)
    assert budget.known_bias.to_series().loc[lambda is_bias: is_bias].index.tolist() == ["mesh"]
    size = np.expm1(float(mesh.relative_std))
    standard_error = float(mesh.standard_error) * (1 + size)  # of the change, not of its logarithm
    assert size == pytest.approx(np.hypot(float(mesh.pull_off_change) / 2, standard_error), rel=1e-12)


def test_an_entry_knows_how_well_it_is_known_and_by_how_many_places():
    """The standard error of a ratio of means is that of many draws of the places."""
    random = np.random.default_rng(3)
    base = random.lognormal(5, 0.5, (4000, 12))
    force = base * random.normal(0.8, 0.2, base.shape)
    changes = [mean_change(*pair, np.ones(12)) for pair in zip(force, base)]
    scatter = np.std([change.value for change in changes])
    assert np.sqrt(np.mean([change.error**2 for change in changes])) == pytest.approx(scatter, rel=0.1)
    assert np.mean([change.value for change in changes]) == pytest.approx(-0.2, abs=0.005)
    force[0, [1, 4]] = np.nan
    assert mean_change(force[0], base[0], np.ones(12)).places == 10
    none = mean_change(force[0][[1, 4]], base[0][[1, 4]], np.ones(2))
    assert none.places == 0 and np.isnan(none.value)


def test_the_total_has_a_standard_error_by_the_places_of_its_changes(rough):
    all_places = roughxr.adhesive(rough, subregions=(3, 3), law="exponential", mesh=HOW["mesh"])
    three_places, nine_places = (
        budget_of(rough, all_places, settings={"work of adhesion": [0.3]}, **HOW | {"places": count})
        for count in (3, 9)
    )
    assert int(three_places.places.sel(entry="work of adhesion")) == 3
    assert int(nine_places.places.sel(entry="work of adhesion")) == 9
    assert float(nine_places.total_standard_error) < float(three_places.total_standard_error)
    assert (three_places.changed_places, three_places.solved_places) == (3, 9)
    total = budget_table({BUDGET: three_places}).loc["all of these"]
    assert "Each change is solved at 3 of 9 places" in total["how it was computed"]


def test_what_a_run_has_solved_on_the_finer_mesh_is_not_solved_again(rough, monkeypatch):
    mesh = roughxr.Mesh(1, None, 0.8)
    all_places = roughxr.adhesive(rough, subregions=(3, 2), law="exponential", mesh=mesh)
    four_places = all_places.isel(subregion=[0, 2, 3, 5])
    finer = roughxr.adhesive(rough, subregions=four_places, law="exponential", mesh=roughxr.Mesh(2, None, 0.4))
    monkeypatch.setattr(budget_changes, "place_cases", None)
    reused = budget_of(rough, all_places, places=2, preload=0.0, mesh=mesh, settings={"mesh": [2]}, finer=finer)
    shift = float(finer.pull_off_force.mean() / four_places.pull_off_force.mean()) - 1
    entry = reused.sel(entry="mesh")
    assert float(entry.pull_off_change) == pytest.approx(shift, rel=1e-12) and int(entry.places) == 4


def test_errors_that_places_state_at_95_per_cent_are_two_standard_deviations():
    """By the front they counted as one, in a budget, and as two in an estimate without one."""
    places = {"pull_off_force": ("subregion", [30.0, 10.0]), "pull_off_error": ("subregion", [0.04, 0.2])}
    assert stated_mesh_error(xr.Dataset(places)).std == pytest.approx((0.75 * 0.04 + 0.25 * 0.2) / 1.96)


@pytest.mark.parametrize(("low", "high"), [(0.0, 3.0), (1.0, np.inf)])
def test_an_interval_to_zero_or_without_end_stays_one_with_another_error(low, high):
    """Of a flow that moves the median sphere, where a good part of the spheres roll off by themselves."""
    with np.errstate(divide="ignore"):
        error = total_error([error_of_interval(2.0, low, high), symmetric_error(0.1)])
    wider_low, wider_high = error.interval(2.0)
    assert wider_low < low or low == wider_low == 0
    assert wider_high > high or high == wider_high == np.inf


def test_the_budget_computes_the_mean_that_the_simulation_does(rough):
    options = {"subregions": (2, 1), "law": "exponential"}
    single_place = error_budget(rough, places=1, settings={"work of adhesion": [1.1]}, **options)
    alone = roughxr.adhesive(rough, **options)
    assert float(single_place.pull_off_mean) == float(alone.pull_off_force.mean())
    assert single_place.places.sel(entry="work of adhesion") == 1
    total = budget_table({BUDGET: single_place}).loc["all of these"]
    assert "places are too few" in total["how it was computed"]


def test_places_that_cannot_be_followed_are_counted(rough, solved, monkeypatch):
    def but_one(cases):
        return np.r_[np.nan, pull_offs(cases)[1:]]

    pull_offs = budget_changes.pull_offs
    monkeypatch.setattr(budget_changes, "pull_offs", but_one)
    lost = budget_of(rough, solved, settings={"work of adhesion": [1.1]}, **HOW)
    assert basis_of_errors(lost)["work of adhesion"] == "work of adhesion × 1.1; 1 place, 1 more have no result"


@pytest.mark.parametrize("side", [2, 6])
def test_the_error_of_places_is_the_standard_error_of_the_mean(rough, solved, side):
    """s/√n of independent places, of four as of many: Student's factor widens intervals, not a standard deviation."""
    values = np.random.default_rng(1).lognormal(2, 0.7, side**2)
    grid = roughxr.scans.regions.centres(rough, (side, side))
    like = solved.isel(subregion=[0] * side**2).drop_vars(["subregion", "subregion_x", "subregion_y"])
    solved = like.assign(pull_off_force=("subregion", values)).assign_coords(grid.coords)
    sampled = budget_of(rough, solved, settings={}, **HOW)
    ends = roughxr.statistics.bootstrap(solved, "pull_off_force", statistics=["mean"])
    expected = values.std(ddof=1) / np.sqrt(float(ends.independent_places)) / values.mean()
    assert float(sampled.relative_std.sel(entry="places")) == pytest.approx(expected, rel=1e-12)
    assert float(sampled.pull_off_mean) == pytest.approx(values.mean())
    single_place = budget_of(rough, solved.isel(subregion=[0]), settings={}, **HOW)
    assert basis_of_errors(single_place)["places"] == ("not computed: needs at least two places that adhere, found 1")


def test_a_budget_survives_its_archive(budget, tmp_path):
    groups = {"statistics/error_budget": budget}
    assert unlabelled(budget) == []
    back = archive.load(archive.save(groups, tmp_path / "budget.nc"))
    for name, ds in groups.items():
        xr.testing.assert_identical(back[name].load(), ds)


def test_bad_input_is_refused_in_words(rough):
    with pytest.raises(ValueError, match="'fit window'"):
        error_budget(rough, settings={"fit window": [3]})
    with pytest.raises(ValueError, match=r"settings: expected a list for 'levelling', such as \['quadratic'\]"):
        error_budget(rough, settings={"levelling": "quadratic"})
    with pytest.raises(ValueError, match=r"levelling: expected one of .*'none', found 'planes'"):
        roughxr.run(rough, "run", levelling="planes")
    with pytest.raises(ValueError, match="work_of_adhesion > 0"):
        error_budget(rough.assign_coords(work_of_adhesion=0.0))


def test_bars_stand_for_entries_and_words_for_what_is_missing(budget):
    ax = figures.error_budget(budget, ax=Figure().subplots())
    widths = [bar.get_width() for bar in ax.patches]
    assert widths[:-1] == pytest.approx(100 * budget.relative_std.fillna(0).values)
    missing = int(budget.relative_std.isnull().sum())
    assert [text.get_text() for text in ax.texts].count("not computed") == missing > 0
    labels = dict(zip(budget.entry.values.tolist(), (text.get_text() for text in ax.texts)))
    assert labels["mesh"].endswith("subtracted") and labels["work of adhesion"][0] in "+−" and "±" in labels["places"]
    assert widths[-1] == pytest.approx(100 * float(budget.total_std))


def test_the_page_says_for_which_surface_and_on_how_many_pixels(rough, solved, budget):
    pull_off = as_measured(roughxr.pull_off(solved))
    run = {"scan": as_measured(rough), "solutions/adhesive": solved, "statistics/adhesive": pull_off}
    run |= {"statistics/error_budget": budget}
    headline = report.headline(run)
    assert "does not resolve roughness finer than" in headline and "with all known errors" in headline
    biased = run | {"statistics/error_budget": budget.assign(pull_off_corrected=0.75 * budget.pull_off_mean)}
    mean = numbers.format_quantity(0.75 * float(solved.contact.pull_off().pull_off_force.mean()))
    assert f"without its known bias, 25 %, is {mean}." in report.headline(biased)
    table = report.tables(run)["Error budget of the mean pull-off"]
    assert table.index[-1] == "all of these" and " ± " in table["error [%]"]["work of adhesion"]
    basis = table["how it was computed"]
    assert "The total is known to ± " in basis["all of these"]
    assert "smaller by a factor of 2" in basis["mesh"] and "0.5 times its size" in basis["mesh"]
    assert "equivalent to 2 independent ones" in basis["places"]


def test_an_error_budget_states_the_preload_and_the_noise_that_were_added(rough, solved):
    budget = budget_of(rough, solved, settings={"preload": [0.1], "noise": [0.5]}, **HOW)
    run = {"scan": rough, "solutions/adhesive": solved, "statistics/adhesive": roughxr.pull_off(solved)}
    basis = budget_table(run | {BUDGET: budget})["how it was computed"]
    added = numbers.format_quantity(0.1 * float(budget.pull_off_mean))
    assert basis["preload"] == f"preload + {added}, 0.1 times the mean pull-off; 2 places"
    noise = numbers.format_number(0.5 * noise_limit(rough), "nm", 2)
    assert basis["noise"].startswith(f"noise of {noise} added, 0.5 times the most that neighbouring lines allow")
    run["solutions/adhesive"] = solved.assign(pull_off_resolution=0.7 * solved.mesh)
    assert any("a radius of 0.7 pixels" in said for said in report.cautions(run))
    assert report.headline({"scan": rough}) == ""


def test_every_source_of_error_has_a_remedy_but_the_law_of_menisci():
    assert set(ERROR_SOURCES) - set(names_in_words("remedy")) == {THIN}
    assert set(CHANGES) | {"mesh", "preload", "interpolation"} == set(CHANGED)


@pytest.mark.parametrize("source", ERROR_SOURCES)
def test_every_source_of_error_is_worded(source):
    facts = {"setting": "2", "number_of_places": 3, "finest_shown": 10.0, "added_preload": 5.0, "bias_part": 0.5}
    assert render_sentence("errors.toml", source, facts)


@pytest.mark.parametrize("stated_range", [{}, {"adhesion_range": 0.5}])
def test_budget_and_best_estimate_take_the_same_deviations(stated_range):
    """The range is less certain if the work alone is known."""
    flat = roughxr.scans.synthetic.self_affine((40, 40), 10, rms=0.6, hurst=0.8, rolloff=80, cutoff=60, seed=1)
    stated = {"sphere_radius": 300, "contact_modulus": 10, "work_of_adhesion": 0.03, "hardness": 3.0, **stated_range}
    ds = roughxr.assign_pair(flat, **stated)
    options = {"subregions": (3, 2), "places": 1, **QUICK}
    budget = error_budget(ds, **options)
    estimate = roughxr.extrapolated(as_measured(ds), **options)
    names = [name for name in budget.entry.values if name in CHANGES and budget.relative_std.sel(entry=name) >= 0]
    assert {"range of adhesion", "hardness", "work of adhesion", "sphere radius"} <= set(names)
    for name in names:
        expected = float(budget.relative_std.sel(entry=name))
        assert expected == np.log1p(abs(float(budget.pull_off_change.sel(entry=name)))), name
        assert float(estimate.relative_std.sel(entry=name)) == pytest.approx(expected, rel=1e-6, abs=1e-9), name
    deviation = KNOWN_RANGE if stated_range else UNKNOWN_RANGE
    by_slope = abs(float(budget.slope.sel(entry="range of adhesion"))) * np.log(deviation)
    assert float(estimate.relative_std.sel(entry="range of adhesion")) == pytest.approx(by_slope, rel=1e-6)


def test_the_accuracy_in_the_last_row_is_that_of_the_total_without_unseen_roughness(budget):
    """It stood as that of the total, most of which is the entry of unseen roughness, known to no accuracy."""
    values = {"pull_off_mean": 10.0, "pull_off_low": 4.0, "pull_off_high": 25.0, "finest_shown": 20.0}
    estimate = xr.Dataset(values | {"relative_std": ("entry", [0.5])}, {"entry": ["unseen roughness"]})
    run = {BUDGET: budget, "statistics/extrapolated": estimate}
    total = report.tables(run)["Error budget of the mean pull-off"].loc["all of these"]
    assert "±" not in total["error [%]"] and float(total["error [%]"]) > 50
    seen = numbers.format_percent(budget.total_std)
    assert (
        f"Without roughness finer than 20 nm the total is {seen}, which is known to ±" in total["how it was computed"]
    )


def test_a_scan_that_is_noise_has_no_headline_but_the_reason(rough, solved):
    heights = np.random.default_rng(2).normal(0.0, 1.0, rough.height.shape)
    run = {
        "scan": rough.assign(height=rough.height.copy(data=heights)),
        "statistics/adhesive": solved.contact.pull_off(),
    }
    headline = report.headline(run)
    assert headline.startswith("No pull-off force is stated") and "as in noise" in headline and " nN" not in headline
    assert report.headline(run | {"scan": rough}).startswith("Mean pull-off")
