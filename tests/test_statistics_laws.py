"""Fitted laws: known parameters found, the right law preferred, goodness of fit that neither flatters nor slanders."""

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from roughxr.mechanics.statistics.laws import fitted_law
from roughxr.statistics import LAWS, fit

KNOWN = {
    "normal": (stats.norm(15, 2), (np.nan, 15, 2)),
    "log_normal": (stats.lognorm(0.5, scale=3), (0.5, 0, 3)),
    "weibull": (stats.weibull_min(1.8, scale=4), (1.8, 0, 4)),
    "gumbel": (stats.gumbel_r(10, 1.5), (np.nan, 10, 1.5)),
}


def sample(law, size, seed=0):
    draws = KNOWN[law][0].rvs(size, random_state=np.random.default_rng(seed))
    return xr.Dataset({"pull_off_force": ("subregion", draws, {"units": "nN"})})


@pytest.mark.parametrize("law", LAWS)
def test_known_laws_are_recovered_and_preferred(law):
    fitted = fit(sample(law, 10_000), "pull_off_force", simulations=0)
    recovered = fitted.sel(law=law)
    shape, location, scale = KNOWN[law][1]
    # the standard errors of these estimates on 10⁴ draws are below 1.2 % of the scale; five of them
    assert float(recovered.location) == pytest.approx(location, abs=0.06 * scale)
    assert float(recovered["scale"]) == pytest.approx(scale, rel=0.06)
    assert np.isnan(shape) == np.isnan(float(recovered["shape"]))
    if np.isfinite(shape):
        assert float(recovered["shape"]) == pytest.approx(shape, rel=0.06)
    assert str(fitted.law[int(fitted.aic.argmin("law"))].values) == law
    assert float(recovered.akaike_weight) > 0.99


def test_goodness_of_fit_is_uniform_for_the_law_itself_and_small_for_another():
    samples = [sample("normal", 60, seed) for seed in range(40)]
    fits = [fit(ds, "pull_off_force", laws=["normal"], simulations=99) for ds in samples]
    chances = [float(fitted.ks_p_value[0]) for fitted in fits]
    assert stats.kstest(chances, "uniform").pvalue > 0.01
    skewed = fit(sample("log_normal", 300), "pull_off_force", laws=["normal", "log_normal"], simulations=99)
    assert float(skewed.ks_p_value.sel(law="normal")) == 0.01 < float(skewed.ks_p_value.sel(law="log_normal"))


def test_density_of_a_fit_integrates_to_one():
    fitted = fit(sample("weibull", 500), "pull_off_force", simulations=0)
    points = np.linspace(-60, 60, 24001)
    for law in LAWS:
        assert np.trapezoid(fitted_law(fitted, law).pdf(points), points) == pytest.approx(1, abs=1e-3)


def test_positive_laws_leave_other_samples_alone():
    ds = xr.Dataset({"height": ("asperity", [-1.0, 0.5, 2.0, 3.0], {"units": "nm"})})
    fitted = fit(ds, "height", simulations=0)
    assert np.isnan(fitted.aic.sel(law=["log_normal", "weibull"])).all() and np.isfinite(fitted.aic.sel(law="normal"))
    assert "not defined" in fitted.attrs["missing"]


def test_bad_input_is_refused_in_words():
    with pytest.raises(ValueError, match="'gumbel'"):
        fit(sample("normal", 9), "pull_off_force", laws=["cauchy"])
    with pytest.raises(ValueError, match="at least three samples, not all equal"):
        fit(xr.Dataset({"height": ("asperity", [1.0, 1.0, 1.0])}), "height")


def test_one_law_is_named_by_a_word():
    ds = xr.Dataset({"height": ("asperity", np.random.default_rng(0).weibull(2.0, 200), {"units": "nm"})})
    assert fit(ds, "height", laws="weibull", simulations=9).law.values.tolist() == ["weibull"]
    with pytest.raises(ValueError, match="found 'weibul'"):
        fit(ds, "height", laws="weibul")


def test_of_a_map_some_pixels_tell_whether_the_fit_is_good():
    """With a word; what the laws' parameters are is learnt from all of them."""
    values = np.random.default_rng(5).gumbel(10.0, 2.0, (120, 120))
    ds = xr.Dataset(
        {"pull_off_force": (("x", "y"), values, {"units": "nN"})}, {axis: np.arange(120.0) for axis in "xy"}
    )
    with pytest.warns(UserWarning, match="14400 samples; ks_p_value is computed from 2000"):
        fitted = fit(ds, "pull_off_force", laws=["normal", "gumbel"], simulations=19)
    assert float(fitted.ks_p_value.sel(law="gumbel")) > 0.05 >= float(fitted.ks_p_value.sel(law="normal"))
    assert fitted.attrs["samples"] == 14400
    assert abs(float(fitted.scale.sel(law="gumbel")) - 2.0) < 0.05
