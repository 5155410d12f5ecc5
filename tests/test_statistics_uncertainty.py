"""Bootstrap intervals hold what they promise where neighbours are alike."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

import roughxr
from roughxr.application import headline
from roughxr.mechanics.statistics.places import correlogram, independent_places
from roughxr.mechanics.statistics.sampling import Samples
from roughxr.mechanics.statistics.uncertainty import (
    Resampling,
    _independent,
    _intervals,
    _small_sample_ends,
    density_intervals,
)
from roughxr.mechanics.vocabulary import schema
from roughxr.statistics import bootstrap, pull_off, reduction

from .fields import field, grid_samples

REPEATS = 200

#: Grids of places by their shape.
LABELLED_GRIDS = {(side, side): grid_samples(np.zeros((side, side))) for side in (3, 4, 6, 8, 12, 16)}


def interval_ends(values, statistics, resamples=199):
    """Return the ends (2, statistic) that `bootstrap` states for a grid of values, NaN where it states none.

    The coverage of thousands of intervals is counted with them; to label each takes longer than to compute it.
    """
    ds = LABELLED_GRIDS[values.shape] if values.ndim == 2 else None
    places = None if ds is None else np.c_[ds.subregion_x.values, ds.subregion_y.values]
    sample = Samples(values.ravel(), None, places, 0)
    count = _independent(sample)
    ends = _intervals(sample, count, list(statistics), Resampling(0.95, resamples, 0))
    return np.full_like(ends, np.nan) if places is not None and count < 3.5 else ends


@pytest.mark.parametrize(("side", "length"), [(3, 0.5), (3, 1.5), (8, 0.5), (8, 1.5), (12, 1.5)])
def test_bootstrap_states_the_ends_whose_coverage_is_counted_here(side, length):
    values = np.exp(0.5 * field(side, length, np.random.default_rng(side)))
    statistics = ["mean", "q50", "q5", "q95", "std"]
    for ds, array in ((grid_samples(values), values), (grid_samples(values).reset_coords(drop=True), values.ravel())):
        stated = bootstrap(ds, statistics=statistics, resamples=199)
        np.testing.assert_array_equal([stated.low, stated.high], interval_ends(array, statistics))


def coverage(side, length, *, law=lambda z: z, truth=(0.0, 0.0), statistics=("mean", "q50"), seed=2):
    """Return the shares of intervals that hold the truth, (statistic)."""
    rng = np.random.default_rng(seed)
    held = []
    for _ in range(REPEATS):
        low, high = interval_ends(law(field(side, length, rng)), statistics)
        held.append((low <= truth) & (truth <= high))
    return np.mean(held, axis=0)


@pytest.mark.parametrize(("side", "length"), [(8, 1.0), (8, 1.5)])
def test_intervals_cover_mean_and_median_of_correlated_places(side, length):
    shares = coverage(side, length)
    assert (shares >= 0.90).all()


def test_intervals_cover_the_mean_of_a_law_as_skewed_as_pull_off_forces():
    """Log-normal with std / mean = 0.66, as the published 1.37 / 2.0 µN; a law twice as skewed is covered less."""
    shares = coverage(8, 1.0, law=lambda z: np.exp(0.6 * z), truth=(np.exp(0.18), 1.0))
    assert (shares >= 0.90).all()


def test_thirty_and_more_values_of_heavy_tails_are_covered_like_fewer():
    """Of 200 intervals of log-normal samples of σ = 1.4, 180 or more hold."""
    draws = np.random.default_rng(36).lognormal(0.0, 1.4, (200, 36))
    mean = np.exp(1.4**2 / 2)
    intervals = [interval_ends(row, ["mean"], resamples=99) for row in draws]
    assert sum(low <= mean <= high for (low,), (high,) in intervals) >= 180


@pytest.mark.parametrize("count", [3, 16, *(pytest.param(n, marks=pytest.mark.soak) for n in (4, 9))])
def test_few_log_normal_places_are_covered_too(count):
    """Of 400 intervals of 95 % fewer than 364 would hold the truth once in a thousand times."""
    draws = np.random.default_rng(count).lognormal(0.0, 0.5, (400, count))
    truth = [np.exp(0.125), np.exp(0.5 * -1.6448536), 1.0, np.exp(0.5 * 1.6448536)]
    held = []
    for row in draws:
        low, high = interval_ends(row, ("mean", "q5", "q50", "q95"), resamples=99)
        held.append((low <= truth) & (truth <= high) & (low > 0))
    assert (np.sum(held, axis=0) >= 364).all()


@pytest.mark.parametrize("summits", [False, True], ids=["Gaussian", "shared summits"])
@pytest.mark.parametrize(("side", "length"), [(3, 0.0), (4, 0.75), (6, 1.5)])
def test_intervals_of_few_independent_places_that_are_given_hold(side, length, summits):
    """Log-normal fields of 4 to 9 independent places; of shared summits, the nearest of random ones gives the force.

    Of 300 intervals of 95 % fewer than 273 hold once in a thousand times; most of each kind are given.
    """
    rng = np.random.default_rng(side)
    lattice = np.argwhere(np.ones((side, side))) + 3.0
    held = 0
    stated = 0
    for _ in range(300):
        z = field(side, max(length, 0.1), rng)
        if summits:
            count = 1 + rng.poisson((side + 6) ** 2 / max(2 * length, 0.5) ** 2)
            nearest = ((lattice[:, None] - rng.uniform(0, side + 6, (count, 2))) ** 2).sum(axis=-1).argmin(axis=1)
            z = rng.normal(size=count)[nearest].reshape(side, side)
        (low,), (high,) = interval_ends(np.exp(0.5 * z), ["mean"], resamples=999)
        stated += bool(np.isfinite(low))
        held += bool(low <= np.exp(0.125) <= high)
    assert held >= 0.93 * stated and stated >= 180


def two_levels(z):
    return np.where(z > 0.5, 3.0, 1.0) * np.exp(0.1 * z)


@pytest.mark.parametrize(
    ("law", "length"),
    [(lambda z: np.exp(0.5 * z), 0.7), (lambda z: 1 + 0.3 * z, 1.5), (two_levels, 0.7), (two_levels, 1.5)],
    ids=["log-normal", "normal", "bimodal", "bimodal of longer correlation"],
)
def test_intervals_hold_quantiles_beyond_the_samples(law, length):
    """Of 8 by 8 places fewer than twenty are independent, so that their extremes fall short of the 95 % quantile."""
    truth = law(norm.ppf([0.05, 0.95]))
    assert (coverage(8, length, law=law, truth=truth, statistics=("q5", "q95")) >= 0.9).all()


def test_too_few_independent_places_give_no_interval_but_a_reason():
    alike = field(3, 4.0, np.random.default_rng(1)) + 10
    intervals = bootstrap(grid_samples(alike), "pull_off_force")
    assert float(intervals.independent_places) < 3.5 and intervals.low.isnull().all() and intervals.high.isnull().all()
    assert "of 9; take a larger grid or a larger scan" in intervals.attrs["no_interval"]
    assert intervals.estimate.notnull().all()
    bare = bootstrap(grid_samples(alike).drop_vars(["subregion_x", "subregion_y"]), "pull_off_force")
    assert bare.low.notnull().all() and "no_interval" not in bare.attrs


def test_mean_median_and_spread_are_covered_on_a_wide_field():
    shares = coverage(16, 1.5, statistics=("mean", "q50", "std"), truth=(0.0, 0.0, 1.0))
    assert (shares >= 0.90).all()


def test_independent_places_are_not_widened():
    shares = coverage(8, 0.2)
    assert (shares >= 0.90).all()
    assert (shares <= 0.99).all()


@pytest.mark.parametrize(
    ("draw", "mean", "std"),
    [
        (lambda rng, n: rng.normal(15, 2, n), 15, 2),
        (lambda rng, n: rng.lognormal(1, 0.5, n), np.exp(1.125), np.exp(1.125) * np.sqrt(np.expm1(0.25))),
        (lambda rng, n: 3 * rng.weibull(2.0, n), 3 * np.sqrt(np.pi) / 2, 3 * np.sqrt(1 - np.pi / 4)),
        (lambda rng, n: rng.gumbel(5, 1.5, n), 5 + 1.5 * np.euler_gamma, 1.5 * np.pi / np.sqrt(6)),
    ],
    ids=["normal", "log-normal", "Weibull", "Gumbel"],
)
def test_ten_thousand_draws_of_each_law_are_recovered(draw, mean, std):
    rng = np.random.default_rng(4)
    held = []
    for _ in range(20):
        ds = xr.Dataset({"height": ("asperity", draw(rng, 10_000), {"units": "nm"})})
        intervals = bootstrap(ds, "height", statistics=("mean", "std"), resamples=99)
        held.append((intervals.low <= [mean, std]) & ([mean, std] <= intervals.high))
        assert float((intervals.high - intervals.low).max()) < 0.12 * std
    # 40 intervals of 95 %: fewer than 33 held would happen once in 10⁴
    assert int(xr.concat(held, "repeat").sum()) >= 33


@pytest.mark.parametrize("length", [0.2, 1.5, 4.0])
@pytest.mark.parametrize("law", [lambda z: np.exp(3 * z), lambda z: np.maximum(z - 1, 0)], ids=["skewed", "mostly 0"])
def test_no_interval_leaves_the_samples_range_but_of_quantiles_that_may_lie_beyond(law, length):
    """A median beside zero and a mean that one place carries: their logarithms must not be widened."""
    ds = grid_samples(law(field(8, length, np.random.default_rng(6))))
    values = ds.pull_off_force.values
    intervals = bootstrap(ds, "pull_off_force", statistics=("mean", "q5", "q50", "q95"), resamples=199)
    fewer = float(intervals.independent_places) * xr.DataArray([np.inf, 0.05, 0.5, 0.05], dims="statistic")
    within = intervals.isel(statistic=np.flatnonzero(fewer > -np.log(0.025)))  # rarer: all samples lie on one side
    assert (within.low >= values.min()).all() and (within.high <= values.max()).all()
    assert (intervals.low <= intervals.estimate).all() and (intervals.estimate <= intervals.high).all()
    spread = bootstrap(ds, "pull_off_force", statistics=("std",), resamples=199)
    assert (spread.high <= np.ptp(values)).all() and (spread.low >= 0).all()


@pytest.mark.parametrize(("length", "side"), [(1.0, 24), (2.0, 48)])
def test_effective_number_is_that_of_the_correlation(length, side):
    places = np.argwhere(np.ones((side, side))).astype(float)
    distance = np.subtract.outer(np.arange(side), np.arange(side))
    exact = (side**2 / np.exp(-(distance**2) / (2 * length**2)).sum()) ** 2  # x and y are independent
    rng = np.random.default_rng(0)
    independent = [independent_places(field(side, length, rng).ravel(), places) for _ in range(20)]
    assert np.median(independent) == pytest.approx(exact, rel=0.25)


@pytest.mark.parametrize("side", [4, 10])
def test_the_correlation_of_a_checkerboard_is_counted(side):
    """Of the pairs one and √2 spacings apart 2n(n − 1) differ and 2(n − 1)² are alike."""
    places = np.argwhere(np.ones((side, side))) * 40.0
    counted = correlogram((-1.0) ** (places.sum(axis=1) / 40), places)
    assert counted.pairs[0] == 2 * (side - 1) * (2 * side - 1)
    assert counted.correlation[0] == pytest.approx(-1 / (2 * side - 1))
    assert counted.pairs[1] == 2 * side * (side - 2) + 4 * (side - 1) * (side - 2)
    assert counted.correlation[1] == pytest.approx((side - 2 * (side - 1)) / (3 * side - 2))
    assert (correlogram(np.ones(side**2), places).correlation == 0).all()


def test_neighbours_at_the_last_end_have_no_bin_of_their_own():
    """On a grid of 4 by 1 the mean spacing is 2, and neighbours lie at 6.5 of it: √(12² + 5²) = 13."""
    places = np.argwhere(np.ones((20, 40))) * [4.0, 1.0]
    assert correlogram(np.sin(places[:, 0] / 30), places).pairs.size == 6


def test_a_varied_parameter_without_entries_is_refused():
    pulls = xr.Dataset({"pull_off_force": (("subregion", "preload"), np.ones((20, 0)))}, {"preload": np.zeros(0)})
    with pytest.raises(ValueError, match="expected at least two finite samples, found none along preload"):
        roughxr.statistics.bootstrap(pulls)


def clustered(rng, count=400, size=1000.0):
    """Return places of which half crowd in a corner."""
    spread = rng.uniform(0, size, (count // 2, 2))
    return np.concatenate([spread, rng.uniform(0, size / 4, (count // 2, 2))])


def test_means_of_crowded_places_are_not_pulled_towards_the_crowd():
    rng = np.random.default_rng(5)
    places = clustered(rng)
    height = rng.normal(10, 1, 400) + np.where((places < 250).all(axis=1), 3.0, 0.0)
    at = {"x": ("asperity", places[:, 0]), "y": ("asperity", places[:, 1])}
    ds = xr.Dataset({"height": ("asperity", height, {"units": "nm"})}, coords=at)
    interval = bootstrap(ds, "height", statistics=["mean"]).isel(statistic=0)
    low, high = (float(interval[end]) for end in ("low", "high"))
    middle = (low + high) / 2
    estimate = float(interval.estimate)
    assert abs(middle - estimate) < 0.2 * (high - low)
    assert low < estimate < high


def test_intervals_are_labelled_and_repeatable():
    ds = grid_samples(field(8, 1.0, np.random.default_rng(0)) + 10)
    intervals = bootstrap(ds, "pull_off_force")
    assert list(intervals.statistic.values) == ["mean", "std", "q5", "q50", "q95"]
    assert intervals.low.dims == ("statistic",) and intervals.low.units == "nN"
    assert intervals.attrs["samples"] == 64 and intervals.attrs["missing"] == 0
    assert float(intervals.independent_places) < 40
    bare = bootstrap(ds.drop_vars(["subregion_x", "subregion_y"]), "pull_off_force")
    assert float(bare.independent_places) == 64
    xr.testing.assert_identical(intervals, bootstrap(ds, "pull_off_force"))
    assert (bootstrap(ds, "pull_off_force", seed=1).low != intervals.low).any()
    assert (intervals.low <= intervals.estimate).all() and (intervals.estimate <= intervals.high).all()


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_missing_places_and_lazy_data_do_not_matter():
    ds = grid_samples(field(8, 1.0, np.random.default_rng(0)) + 10)
    holes = ds.where(ds.pull_off_force > 9)
    kept = ds.isel(subregion=np.flatnonzero(ds.pull_off_force > 9))
    with_holes, without = (bootstrap(part, "pull_off_force") for part in (holes, kept))
    np.testing.assert_array_equal(with_holes.low, without.low)
    assert with_holes.attrs["missing"] == 64 - kept.sizes["subregion"]
    xr.testing.assert_equal(bootstrap(ds.chunk(subregion=16), "pull_off_force"), bootstrap(ds, "pull_off_force"))


def test_reduction_is_a_part_of_the_smooth_spheres_pull():
    sweep = xr.Dataset(
        {"force": (("subregion", "delta"), [[0.0, -1.5 * np.pi, 1.0], [0.0, -3 * np.pi, 1.0]], {"units": "nN"})},
        coords={"delta": [-1.0, 0.0, 1.0], "sphere_radius": 2.0, "work_of_adhesion": 1.0},
    )
    ratio = reduction(pull_off(sweep)).pull_off_ratio
    np.testing.assert_allclose(ratio, [0.5, 1.0])
    assert ratio.units == "1"
    with pytest.raises(ValueError, match="work_of_adhesion > 0"):
        reduction(pull_off(sweep).assign_coords(work_of_adhesion=0.0))


def test_history_has_every_option_that_changes_an_interval():
    ds = grid_samples(field(4, 0.2, np.random.default_rng(0)) + 10)
    options = {"statistics": ["mean", "q50"], "confidence": 0.9, "resamples": 99, "seed": 3, "fewest": 2.0}
    (step,) = schema.history(bootstrap(ds, "pull_off_force", within=ds, **options))
    assert step["arguments"] == {**options, "within": "Dataset (subregion: 16)"}


def test_histogram_bins_have_intervals_about_their_densities():
    ds = grid_samples(field(16, 1.0, np.random.default_rng(3)))
    edges = np.linspace(-3, 3, 13)
    low, high = density_intervals(ds, "pull_off_force", bins=edges)
    density = np.histogram(ds.pull_off_force, edges, density=True)[0]
    assert ((low <= density + 1e-12) & (density <= high + 1e-12)).all() and (low >= 0).all()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"statistics": ["median"]}, "mean, std or q0"),
        ({"statistics": "mean"}, "expected a list of names"),
        ({"statistics": ["q101"]}, "q0 … q100"),
        ({"confidence": 95}, "between 0 and 1"),
        ({"confidence": "95"}, "between 0 and 1"),
        ({"resamples": 10}, "at least 20"),
    ],
)
def test_bad_options_are_refused_in_words(options, says):
    with pytest.raises(ValueError, match=says):
        bootstrap(grid_samples(np.arange(16.0).reshape(4, 4)), "pull_off_force", **options)


@pytest.mark.parametrize("law", [lambda z: z, np.exp], ids=["normal", "log-normal"])
@pytest.mark.parametrize("length", [0.05, 1.0, 1.5, 2.5])
def test_fewer_places_of_a_surface_are_worth_no_more_independent_ones(law, length):
    """Every second place along x and y of the same fields, in the mean over fields as far as that is known."""
    rng = np.random.default_rng(0)
    places = np.argwhere(np.ones((16, 16))) * 100.0
    is_coarse = (places % 200 == 0).all(axis=1)
    independent = []
    for _ in range(30):
        values = law(field(16, length, rng)).ravel()
        independent.append(
            [independent_places(values, places), independent_places(values[is_coarse], places[is_coarse])]
        )
    more = np.diff(independent, axis=1)
    assert more.mean() < 2 * more.std() / np.sqrt(more.size)


def test_part_of_the_places_takes_the_whole_surfaces_correlation():
    ds = grid_samples(field(16, 1.5, np.random.default_rng(8)) + 10)
    part = ds.isel(subregion=np.flatnonzero(np.random.default_rng(0).random(256) < 0.1))
    alone, within = (bootstrap(part, "pull_off_force", within=whole).independent_places for whole in (None, ds))
    assert float(within) == min(float(alone), float(bootstrap(ds, "pull_off_force").independent_places))


def test_one_place_far_out_hides_no_correlation():
    values = field(16, 1.5, np.random.default_rng(8)).ravel()
    places = np.argwhere(np.ones((16, 16))) * 100.0
    outlier = np.where(np.arange(256) == 100, 1e4, values)
    assert independent_places(outlier, places) == pytest.approx(independent_places(values, places), rel=0.1)


def test_what_cannot_be_negative_has_no_interval_below_zero():
    """Forces of which most are none at all, and spreads."""
    for seed in range(20):
        z = field(8, 1.5, np.random.default_rng(seed))
        ds = grid_samples(np.maximum(np.exp(3 * z) - 1, 0), name="force")
        if int((ds.force > 0).sum()) < 3:
            continue
        intervals = bootstrap(ds, "force", statistics=["mean", "std"], resamples=199)
        assert (intervals.low >= 0).all(), seed
        assert ((intervals.low <= intervals.estimate) & (intervals.estimate <= intervals.high)).all()
    below = bootstrap(grid_samples(field(8, 1.5, np.random.default_rng(0))), "pull_off_force", statistics=["mean"])
    assert float(below.low.min()) < 0


def test_each_entry_of_a_varied_parameter_has_its_own_intervals():
    values = np.random.default_rng(3).normal(10.0, 1.0, (3, 2, 30))
    dims = ("sphere_radius", "work_of_adhesion", "subregion")
    ds = xr.Dataset({"pull_off_force": (dims, values, {"units": "nN"})}, {"sphere_radius": [1e3, 2e3, 3e3]})
    varied = bootstrap(ds, "pull_off_force", resamples=99)
    single = bootstrap(ds.isel(sphere_radius=1, work_of_adhesion=0), "pull_off_force", resamples=99)
    for end in ("low", "high", "estimate"):
        np.testing.assert_array_equal(varied[end].isel(sphere_radius=1, work_of_adhesion=0), single[end])
    assert varied.sizes["sphere_radius"] == 3 and varied.estimate.attrs["units"] == "nN"


def test_intervals_of_a_large_map_are_those_of_its_patches():
    places = {axis: (axis, np.arange(160) * 10.0, {"units": "nm"}) for axis in "xy"}
    rng = np.random.default_rng(2)
    patches = np.kron(rng.normal(size=(10, 10)), np.ones((16, 16)))  # 100 independent ones
    ds = xr.Dataset({"pull_off_force": (("x", "y"), np.exp(patches), {"units": "nN"})}, places)
    interval = bootstrap(ds, "pull_off_force", statistics=["mean"], resamples=199).squeeze()
    assert float(interval.estimate) == pytest.approx(np.exp(patches).mean())
    assert 25 < float(interval.independent_places) < 400
    half = np.exp(patches).std() / np.sqrt(100)  # what 100 independent ones leave open
    assert 2 * half < float((interval.high - interval.low).item()) < 8 * half


@pytest.mark.parametrize(
    ("draw", "mean"),
    [
        (lambda rng, n: rng.lognormal(0.0, 1.0, n), np.exp(0.5)),
        (lambda rng, n: rng.lognormal(0.0, 0.4, n), np.exp(0.08)),
        (lambda rng, n: rng.exponential(1.0, n), 1.0),
        (lambda rng, n: rng.gamma(0.5, 2.0, n), 1.0),
        (lambda rng, n: rng.normal(1.0, 0.2, n), 1.0),
    ],
)
@pytest.mark.parametrize("count", [4, 16])
def test_the_mean_of_a_few_is_covered_though_they_show_no_tail(draw, mean, count):
    rng = np.random.default_rng(1)
    samples = (Samples(draw(rng, count), None, None, 0) for _ in range(1000))
    ends = [_small_sample_ends("mean", sample, count, 0.95) for sample in samples]
    assert np.mean([low <= mean <= high for low, high in ends]) > 0.9
    assert np.median([high / low for low, high in ends]) > 1.2


@pytest.mark.parametrize(("count", "widest"), [(3, 25.0), (4, 15.0), (9, 5.0)])
@pytest.mark.parametrize("sigma", [0.3, 0.7])
def test_intervals_of_few_scattered_places_are_no_wider_than_needed(count, widest, sigma):
    """Of 2000 intervals of 95 %, 1850 hold; nine of ten are narrower than a factor at which Cox's alone are not."""
    draws = np.random.default_rng(count).lognormal(0.0, sigma, (2000, count))
    low, high = np.array([_small_sample_ends("mean", Samples(row, None, None, 0), count, 0.95) for row in draws]).T
    truth = np.exp(sigma**2 / 2)
    assert ((low <= truth) & (truth <= high)).sum() >= 1850
    assert np.quantile(high / low, 0.9) < widest


def test_a_mean_above_a_smooth_flat_without_a_known_error_has_no_interval():
    """Of one mesh of unknown error: the interval of the places held neither the mesh nor the doubt."""
    forces = np.random.default_rng(1).lognormal(0.0, 0.3, 16)
    bodies = {"sphere_radius": 100.0, "contact_modulus": 1e-3, "work_of_adhesion": 1.0}
    pull = xr.Dataset({"pull_off_force": ("subregion", 700.0 * forces, {"units": "nN"})}, bodies)
    pull["pull_off_error"] = ("subregion", np.full(16, np.nan))
    doubtful = roughxr.schema.label(pull).contact.answer()
    assert doubtful.smooth_share > 1 and np.isnan(doubtful.low) and np.isnan(doubtful.high)
    assert "the error of cells or sum is not known" in doubtful.sentence and "independent" not in doubtful.sentence
    assert "mesh='auto'" in doubtful.sentence and "should hold" not in doubtful.sentence
    certain = roughxr.schema.label(pull.assign(pull_off_error=("subregion", np.full(16, 0.1)))).contact.answer()
    assert certain.low < certain.pull_off_force < certain.high
    assert "where the surface ripples or fits the sphere" in certain.sentence
    below = roughxr.schema.label(pull.assign(pull_off_force=pull.pull_off_force / 100)).contact.answer()
    assert np.isfinite(below.low)


def test_the_largest_errors_of_the_scan_name_their_group():
    """They were named "mesh, tip and levelling" where interpolation or noise made nearly all."""
    deviations = {"places": 0.1, "unseen roughness": 0.3, "mesh": 0.01, "interpolation": 0.2, "noise": 0.12}
    deviations |= {"levelling": 0.005, "work of adhesion": 0.2}
    values = {"pull_off_mean": 10.0, "pull_off_low": 4.0, "pull_off_high": 25.0}
    values |= {"finest_shown": 20.0, "roughness_factor": 0.7, "roughness_low": 0.3, "roughness_high": 1.1}
    values |= {"narrowed_low": 6.0, "narrowed_high": 20.0}
    columns = {name: ("entry", list(deviations.values())) for name in ("relative_std", "remaining_std")}
    attrs = {"narrowing_source": "unseen roughness", "unseen_by": "one scan"}
    estimate = xr.Dataset(values | columns, {"entry": list(deviations)}, attrs)
    answered = headline.with_best_estimate(xr.Dataset({"pull_off_force": 14.0}), estimate)
    assert answered.attrs["scan_sources"] == "interpolation and noise"
    alone = estimate.assign(relative_std=estimate.relative_std.where(estimate.entry != "noise", 0.0))
    assert headline.with_best_estimate(xr.Dataset(), alone).attrs["scan_sources"] == "interpolation"
