"""Pull-off forces that are known by their limits are results: bounds, likelihoods with censoring, every door."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import statistics
from roughxr.application.cli import main
from roughxr.measured import curves_pull_off
from roughxr.mechanics.statistics.censoring import least_spread_values, likelihood_estimates, most_spread_values
from roughxr.mechanics.statistics.laws import LAWS, fitted_parameters, log_likelihood
from roughxr.mechanics.statistics.uncertainty import density_intervals

from .force_curves import weak_retractions
from .surfaces import glass_pair, rough, scan


def with_limits(values, limit):
    """Return pull-off forces of which those below a limit are known by it alone."""
    is_known = values > limit
    force = ("subregion", np.where(is_known, values, np.nan), {"units": "nN"})
    at_most = ("subregion", np.where(is_known, np.nan, limit), {"units": "nN"})
    return xr.Dataset({"pull_off_force": force, "pull_off_at_most": at_most}, attrs={"measured": "table"})


@pytest.fixture(scope="module")
def weak():
    """64 curves, most of which give a limit, and their pulls."""
    rng = np.random.default_rng(3)
    pulls = rng.exponential(5.0, 64)
    return curves_pull_off(weak_retractions(rng, pulls)), pulls


def test_intervals_of_weak_pulls_contain_their_mean(weak):
    measured, pulls = weak
    assert int(measured.pull_off_at_most.notnull().sum()) > 30
    mean = statistics.bootstrap(measured, statistics=["mean"]).squeeze()
    assert mean.low < pulls.mean() < mean.high and mean.likelihood_low < pulls.mean() < mean.likelihood_high
    assert float(mean.estimate) == pytest.approx(pulls.mean(), rel=0.2)
    assert float(measured.pull_off_force.mean()) > 1.5 * pulls.mean()
    assert "Weibull" in mean.attrs["law"] and mean.attrs["limits_below"] > 30


def test_a_likelihood_with_censoring_covers_the_mean():
    inside = []
    for seed in range(8):
        values = np.random.default_rng(seed).exponential(1.0, 64)
        limit = np.log(2.5)  # 60 % lie below
        bounds = np.array([np.where(values < limit, 0, values), np.maximum(values, limit)])
        _, low, high = likelihood_estimates(bounds, ["mean"], 64.0, 0.95).values[:, 0]
        inside.append(low <= 1 <= high)
    assert sum(inside) >= 7


def test_a_reading_below_the_detection_limit_is_a_limit_of_the_likelihood():
    """Noise lets some of the pulls below the limit be read: taken as known beside the others, they raise the mean."""
    readings = np.random.default_rng(5).exponential(4.0, 64)
    few_read = (readings > 5) | (np.arange(64) % 4 == 0)
    made = with_limits(np.where(few_read, readings, 0.0), 1e-9).assign(pull_off_at_most=("subregion", [np.nan] * 64))
    made["pull_off_at_most"] = made.pull_off_at_most.where(few_read, 5.0).assign_attrs(units="nN")
    made["detection_limit"] = ("subregion", np.full(64, 5.0), {"units": "nN"})
    ends = [
        statistics.bootstrap(forces, statistics=["mean"]).squeeze().likelihood_high
        for forces in (made, with_limits(readings, 5.0))
    ]
    assert float(ends[0]) == pytest.approx(float(ends[1]), rel=1e-6)


def test_censored_parameters_have_the_highest_likelihood():
    values = np.random.default_rng(0).weibull(1.5, 60)
    bounds = np.array([np.where(values < 0.7, 0, values), np.maximum(values, 0.7)])
    shape, _, scale = fitted_parameters(LAWS["weibull"], bounds)
    near = np.array([[0.97, 1], [1.03, 1], [1, 0.97], [1, 1.03]]) * (shape, scale)
    highest = log_likelihood(LAWS["weibull"], (shape, 0.0, scale), bounds)
    assert (log_likelihood(LAWS["weibull"], (near[:, 0], np.zeros(4), near[:, 1]), bounds) < highest).all()


def test_bounds_hold_wherever_the_limited_forces_lie():
    rng = np.random.default_rng(1)
    values = rng.lognormal(0.0, 0.6, 80)
    names = ["mean", "q25", "q50", "q95"]
    bounds = statistics.bootstrap(with_limits(values, 1.0), statistics=names, resamples=200)
    for _ in range(5):
        placed = np.where(values > 1.0, values, rng.uniform(0, 1, 80))
        exact = statistics.bootstrap(
            xr.Dataset({"pull_off_force": ("subregion", placed)}), statistics=names, resamples=200
        )
        assert (bounds.low <= exact.estimate).all() and (bounds.high >= exact.estimate).all()
        quantiles = {"statistic": slice(1, None)}  # whose ends grow with every value
        assert (bounds.low <= exact.low + 1e-9).isel(quantiles).all()
        assert (bounds.high >= exact.high - 1e-9).isel(quantiles).all()


def test_values_within_bounds_have_no_smaller_or_larger_spread():
    rng = np.random.default_rng(2)
    low = rng.uniform(0, 1, 9)
    bounds = np.array([low, low + rng.uniform(0, 1, 9) * (rng.uniform(size=9) < 0.7)])
    spreads = rng.uniform(bounds[0], bounds[1], (4000, 9)).std(axis=1)
    corners = np.array(np.meshgrid(*bounds.T)).reshape(9, -1).T
    assert least_spread_values(bounds).std() <= spreads.min()
    assert most_spread_values(bounds).std() == pytest.approx(corners.std(axis=1).max())


def test_curves_that_all_give_limits_have_an_answer():
    rng = np.random.default_rng(0)
    mean = curves_pull_off(weak_retractions(rng, np.zeros(12))).contact.answer()
    # a jump is seen from some four times the noise of 1 nN on
    assert float(mean.low) == 0 and 3 < float(mean.high) < 6 and np.isnan(mean.pull_off_force)
    assert "as measured" in mean.sentence and "12 of 12 below" in mean.sentence
    assert "surface as scanned" not in mean.sentence


def test_saturated_curves_leave_the_mean_without_an_upper_end():
    values = np.random.default_rng(0).lognormal(0, 0.3, 40)
    ds = xr.Dataset({"pull_off_force": ("subregion", np.where(values < 1.5, values, np.nan), {"units": "nN"})})
    ds["pull_off_at_least"] = ("subregion", np.where(values < 1.5, np.nan, 1.5), {"units": "nN"})
    table = statistics.bootstrap(ds, statistics=["mean", "q50"])
    assert np.isinf(table.high.sel(statistic="mean")) and np.isfinite(table.high.sel(statistic="q50"))
    assert table.low.sel(statistic="mean") < values.mean() < table.likelihood_high.sel(statistic="mean")


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_distributions_contain_limited_forces(weak):
    density = statistics.pdf(weak[0])
    edges = density.attrs["bin_edges"]
    assert edges[0] == 0 and float(density.values @ np.diff(edges)) == pytest.approx(1)
    steps = statistics.cdf(weak[0])
    assert (steps <= steps.cdf_high).all() and float(steps.cdf_high[0]) > 0.4 and float(steps[-1]) == 1
    assert np.isnan(statistics.fit(weak[0], simulations=0).ks_distance).all()
    assert "pull_off_force" not in statistics.summary(weak[0])
    label = weak[0].contact.plot().get_legend_handles_labels()[1]
    assert any("of 64 below" in entry for entry in label)


def test_compared_ratios_contain_the_true_one_with_limits(weak):
    measured, pulls = weak
    predicted = xr.Dataset({"pull_off_force": ("subregion", 2 * pulls, {"units": "nN"})})
    compared = roughxr.compare(predicted, measured, statistics=["mean", "q50"])
    assert (compared.ratio_low < 0.5).all() and (compared.ratio_high > 0.5).all()
    assert compared.distribution_distance < 0.5 and compared.attrs["measured_limits_below"] > 30
    same = roughxr.compare(predicted.assign(pull_off_force=predicted.pull_off_force / 2), measured, statistics=["mean"])
    assert same.distribution_distance < 0.1 and same.distribution_p_value > 0.5
    only_limits = with_limits(pulls, 1000.0)
    bounded = roughxr.compare(predicted, only_limits, statistics=["mean"]).squeeze()
    assert float(bounded.ratio_low) == 0 and np.isfinite(bounded.ratio_high) and np.isnan(bounded.ratio)


def test_a_fit_to_forces_with_limits_finds_the_work_of_adhesion():
    surface = glass_pair(scan(rough(48, seed=1)))
    true = float(surface.work_of_adhesion)
    made = surface.contact.pull_off_map(subregions=(6, 6))
    forces = made.pull_off_force.values.ravel()
    measured = with_limits(forces, np.quantile(forces, 0.4))
    fitted = surface.contact.fit_pair(measured, method="superposed", subregions=(6, 6))
    bias = np.log(1.25)  # superposed forces are divided by 0.8
    assert abs(np.log(float(fitted.fitted_work_of_adhesion) / true) + bias) < 0.4
    assert fitted.fitted_work_low < true < fitted.fitted_work_high and np.isnan(fitted.spread_ratio)
    bounded = surface.contact.fit_pair(with_limits(forces, forces.max() + 1), method="superposed", subregions=(6, 6))
    assert np.isnan(bounded.fitted_work_of_adhesion) and float(bounded.fitted_work_low) == 0
    assert float(bounded.fitted_work_high) > true and "only the upper end" in roughxr.answer(bounded).sentence


def test_limits_survive_a_table_and_are_printed(weak, tmp_path, capsys):
    path = tmp_path / "pulls.csv"
    roughxr.to_table(weak[0], path)
    read = roughxr.open_pull_off(path)
    xr.testing.assert_allclose(read.pull_off_at_most.drop_attrs(), weak[0].pull_off_at_most.drop_attrs())
    assert main(["measured", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "of 64 below" in printed and "likelihood with censoring" in printed
    single = tmp_path / "one.csv"
    single.write_text("pull_off_force [nN],pull_off_at_most [nN]\n,0.12\n")
    assert main(["measured", str(single)]) == 0
    assert "pull-off force: 0 … 120 pN" in capsys.readouterr().out


def saturated(forces, limit, **places):
    """Return pull-off forces of which those above a limit are known by it alone."""
    is_known = forces < limit
    force = ("subregion", np.where(is_known, forces, np.nan), {"units": "nN"})
    at_least = ("subregion", np.where(is_known, np.nan, limit), {"units": "nN"})
    return xr.Dataset({"pull_off_force": force, "pull_off_at_least": at_least}, places, {"measured": "table"})


def test_a_force_above_a_limit_is_in_no_bin():
    """It was counted as equal to its limit: the last bin before it grew with every saturated curve."""
    measured = saturated(np.array([1.0, 2.0, 3.0, 4.0, 6.0, 7.0, 8.0, 9.0]), 5.0)
    density = statistics.pdf(measured, bins=[0.0, 2.5, 5.0])
    assert (density.values * 2.5).tolist() == [0.25, 0.25] and float(density.cdf[-1]) == 0.5
    low, high = density_intervals(measured, "pull_off_force", bins=[0.0, 2.5, 5.0])
    assert (low <= density.values).all() and (density.values <= high).all()
    drawn = measured.contact.plot(bins=[0.0, 2.5, 5.0])
    assert drawn.dataLim.y1 == pytest.approx(0.1)


@pytest.mark.parametrize("limited", ["below", "above"])
def test_few_independent_places_with_limits_have_no_interval(limited, capsys, tmp_path):
    """One slow change over all places: an interval to 1e29 nN by the likelihood was stored, and one promised."""
    x, y = (10.0 * axis.ravel() for axis in np.meshgrid(np.arange(6.0), np.arange(6.0)))
    forces = 5.0 * np.exp(np.sin(x / 60) + np.cos(y / 70))
    places = {name: ("subregion", at, {"units": "nm"}) for name, at in (("subregion_x", x), ("subregion_y", y))}
    limit = float(np.median(forces))
    measured = saturated(forces, limit, **places) if limited == "above" else with_limits(forces, limit)
    measured = measured.assign_coords(places)
    mean = statistics.bootstrap(measured, statistics=["mean"]).squeeze()
    assert mean.independent_places < 3.5 and mean.estimate > 0
    assert all(np.isnan(mean[end]) for end in ("low", "high", "likelihood_low", "likelihood_high"))
    sentence = measured.contact.answer().sentence
    assert "too few independent ones for an interval" in sentence
    assert "wherever they lie" not in sentence and "95 % interval" not in sentence and "–" not in sentence
    roughxr.to_table(measured, tmp_path / "forces.csv")
    assert main(["measured", str(tmp_path / "forces.csv")]) == 0
    printed = capsys.readouterr().out
    assert "too few independent places for an interval" in printed and "wherever" not in printed
