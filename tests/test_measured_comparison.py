"""Predicted beside measured: ratios and tests that hold at their rates."""

import numpy as np
import pytest
import xarray as xr

import roughxr

from .surfaces import glass_pair, rough, scan

N = 24
STEP = 10.0


def forces(values, places=None):
    ds = xr.Dataset({"pull_off_force": ("subregion", np.ravel(values), {"units": "nN"})})
    if places is None:
        return ds
    return ds.assign_coords({f"subregion_{axis}": ("subregion", np.ravel(x)) for axis, x in zip("xy", places)})


def grid(n=N, origin=(0.0, 0.0)):
    x = np.arange(n) * STEP
    return np.meshgrid(x + origin[0], x + origin[1], indexing="ij")


def field(seed, n=N, smooth=1.0):
    """Return lognormal forces that are alike over some places."""
    return 10 * np.exp(0.3 * rough(n, rms=1.0, smooth=smooth, seed=seed))


def compared_fields(k, factor):
    """Return the comparison of two fields of one law, the measured by a factor larger."""
    pair = forces(field(2 * k), grid()), forces(field(2 * k + 1), grid()) * factor
    return roughxr.compare(*pair, statistics=["mean", "q50"], resamples=99)


@pytest.fixture(scope="module")
def trials():
    """Return comparisons of equal fields."""
    return [compared_fields(k, 1) for k in range(60)]


@pytest.mark.parametrize(("statistic", "widest"), [("mean", 1.35), ("q50", 1.45)])
def test_intervals_of_the_ratio_hold_at_their_rate(trials, statistic, widest):
    """That of a median is of whole samples between two ranks, and wider: it never lies beyond the samples."""
    ratios = [trial.sel(statistic=statistic) for trial in trials]
    held = np.mean([bool(trial.ratio_low < 1 < trial.ratio_high) for trial in ratios])
    assert held >= 0.88  # of 60: three standard errors below 0.95 are 0.87
    assert np.median([trial.ratio_high / trial.ratio_low for trial in ratios]) < widest


def test_two_fields_of_one_law_are_told_apart_no_more_often_than_stated(trials):
    assert np.mean([float(trial.distribution_p_value) < 0.05 for trial in trials]) <= 0.12
    naive = [  # of unknown places: as if all were independent
        float(roughxr.compare(forces(field(2 * k)), forces(field(2 * k + 1)), resamples=20).distribution_p_value)
        for k in range(20)
    ]
    assert np.mean(np.array(naive) < 0.05) > 0.3


def test_laws_that_differ_are_told_apart():
    different = [compared_fields(k, 2) for k in range(15)]
    assert np.mean([float(trial.distribution_p_value) < 0.01 for trial in different]) > 0.9
    assert np.median([float(trial.ratio[0]) for trial in different]) == pytest.approx(2, rel=0.1)


def test_quantiles_stand_beside_one_another():
    compared = roughxr.compare(forces(field(0)), forces(3 * field(0)), resamples=998)
    np.testing.assert_allclose(compared.measured_quantile, 3 * compared.predicted_quantile)
    np.testing.assert_allclose(compared.ratio, 3.0)
    assert roughxr.schema.history(compared)[-1]["arguments"]["resamples"] == 998
    means, scatter, distributions = roughxr.answer(compared).sentence.splitlines()
    assert means.startswith("Measured over predicted mean: 3")
    assert "roughness explains the scatter (ratio 1.00," in scatter and compared.scaled_distance < 0.01
    assert "The distributions disagree: " in distributions


@pytest.mark.parametrize(
    ("ratio", "verdict"), [(0.4, "scatter less"), (1.0, "explains the scatter (ratio"), (2.5, "scatter more")]
)
def test_scatter_of_twenty_forces_is_judged_whatever_their_mean(ratio, verdict):
    """Of 200 draws in tests/benchmarks/scatter_verdict.py at least 95 %."""
    rng = np.random.default_rng(0)
    decided = []
    for _ in range(25):
        predicted = rng.gamma(0.3**-2, 1.0, 64)
        measured = 5 * rng.gamma((0.3 * ratio) ** -2, 1.0, 20)
        compared = roughxr.compare(forces(predicted), forces(measured), statistics=["mean"], resamples=99)
        decided.append(verdict in roughxr.answer(compared).sentence)
    assert np.mean(decided) >= 0.88


def test_four_forces_do_not_decide_on_their_scatter():
    for values in ([9.0, 11.0, 15.0], [30.0, 31.0, 35.0, 40.0]):
        compared = roughxr.compare(forces(field(0)), forces(values), statistics=["mean"], resamples=99)
        assert "too few independent forces are known to decide" in roughxr.answer(compared).sentence


def test_an_error_that_all_forces_share_widens_the_ratio_and_no_scatter():
    datasets = forces(field(0)), forces(field(1))
    alone, shared = (roughxr.compare(*datasets, force_std=part, resamples=99) for part in (0.0, "10 %"))
    half_width, expected = (np.log(ds.ratio_high / ds.ratio).sel(statistic="mean").item() for ds in (shared, alone))
    assert half_width == pytest.approx(np.hypot(expected, 0.196), rel=1e-6)
    assert shared.relative_std_ratio_high == alone.relative_std_ratio_high
    assert shared.distribution_p_value == alone.distribution_p_value
    with pytest.raises(roughxr.Refusal, match="force_std: expected a relative error from 0 to below 1, found 3"):
        roughxr.compare(*datasets, force_std=3)


def test_a_force_that_is_repeated_has_no_scatter_to_explain():
    compared = roughxr.compare(forces(field(0)), forces([30.0] * 12), statistics=["mean"], resamples=99)
    assert "the measured forces are all the same" in roughxr.answer(compared).sentence


def test_wrong_forces_and_estimates_are_refused():
    predicted = forces(field(0)).assign_coords(sphere_radius=500.0)
    with pytest.raises(roughxr.Refusal, match="extrapolation: expected a result of `extrapolated`, found Dataset"):
        roughxr.compare(predicted, forces(field(1)), extrapolation=predicted)
    with pytest.raises(roughxr.Refusal, match=r"predicted: expected forces of a pair of bodies.*exchange both"):
        roughxr.compare(forces(field(1)), predicted)


def test_relative_scatter_has_no_unit_and_an_interval_of_limits_too():
    values = 10 * np.random.default_rng(1).gamma(9, 1.0, 200)
    complete = forces(values).contact.bootstrap(statistics=["relative_std"]).squeeze()
    assert complete.low < 1 / 3 < complete.high and complete.estimate.units == "1"
    limit = np.quantile(values, 0.2)
    measured = forces(np.where(values < limit, np.nan, values))
    measured["pull_off_at_most"] = ("subregion", np.where(values < limit, limit, np.nan))
    limited = measured.contact.bootstrap(statistics=["relative_std"]).squeeze()
    assert limited.low < complete.low and limited.high > complete.high
    assert limited.likelihood_low < 1 / 3 < limited.likelihood_high
    with pytest.raises(ValueError, match="relative_std alone, since it has no unit"):
        forces(values).contact.bootstrap(statistics=["mean", "relative_std"])


def test_a_map_is_compared_as_its_places():
    surface = glass_pair(scan(rough(32, seed=1)))
    predicted = surface.contact.pull_off_map()
    measured = forces(predicted.pull_off_force.values, np.meshgrid(surface.x, surface.y, indexing="ij"))
    compared = roughxr.compare(predicted, measured, statistics=["mean"], resamples=20)
    assert float(compared.ratio[0]) == pytest.approx(1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"statistics": ["mode"]}, "statistics: expected mean"),
    ],
)
def test_options_out_of_range_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        roughxr.compare(forces(field(0), grid()), forces(field(0), grid()), resamples=20, **options)


def test_what_is_no_pull_off_is_named():
    solution = xr.Dataset({"force": (("subregion", "delta"), [[1.0, 2.0]])}, {"delta": [0.0, 1.0]})
    with pytest.raises(ValueError, match="predicted: expected a variable 'pull_off_force', found force; take"):
        roughxr.compare(solution, forces([1.0, 2.0]))
    with pytest.raises(ValueError, match="measured: expected an xarray"):
        roughxr.compare(forces([1.0, 2.0]), [1.0, 2.0])


def test_the_history_of_a_comparison_contains_the_best_estimate():
    """Two verdicts had one history."""
    forces = np.random.default_rng(0).gamma(9, 1.0, (2, 50))
    predicted, measured = (xr.Dataset({"pull_off_force": ("subregion", row, {"units": "nN"})}) for row in forces)
    estimate = xr.Dataset({"pull_off_mean": 12.0, "pull_off_low": 8.0, "pull_off_high": 16.0})
    estimate.attrs["title"] = "the scan's best estimate"
    alone, with_estimate = (roughxr.compare(predicted, measured, extrapolation=e) for e in (None, estimate))
    measured_name = {"measured": "Dataset (subregion: 50)"}
    assert roughxr.schema.history(alone)[-1]["arguments"] == measured_name
    stated = roughxr.schema.history(with_estimate)[-1]["arguments"]
    assert stated == measured_name | {"extrapolation": "the scan's best estimate"}
