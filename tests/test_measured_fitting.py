"""The work of adhesion with which forces were made by the simulation is found, and its interval holds it."""

import functools
import warnings

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import roughxr
from roughxr.mechanics.asperity import expectation
from roughxr.mechanics.scans.synthetic import self_affine
from roughxr.mechanics.statistics.sampling import Samples
from roughxr.mechanics.studies import fitting
from roughxr.mechanics.studies.likelihood import Predicted, fit_mean

from .surfaces import glass_pair, rough, scan, unpressed

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")


@pytest.fixture(scope="module", autouse=True)
def _unpressed():
    with unpressed():
        yield


TRUE = 0.3
QUICK = {"mesh": roughxr.Mesh(1, step=0.5), "law": "exponential"}


def surface(seed, work=0.1, rms=1.5):
    ds = self_affine((64, 64), 8.0, rms=rms, hurst=0.8, rolloff=120, cutoff=40, seed=seed)
    pair = {"sphere_radius": 1000, "contact_modulus": 40, "work_of_adhesion": work, "adhesion_range": 0.3}
    return ds.contact.assign_pair(**pair)


def measured_on(ds, seed, n=12, noise=0.05, work=TRUE):
    """Return simulated pull-offs at random places of a surface, with the instrument's noise."""
    rng = np.random.default_rng(seed)
    places = tuple(rng.uniform(-180, 180, (2, n)) + [[float(ds[axis].mean())] for axis in "xy"])
    solution = ds.assign_coords(work_of_adhesion=work).contact.adhesive(subregions=places, **QUICK)
    return solution.assign(pull_off_force=solution.pull_off_force * np.exp(noise * rng.standard_normal(n)))


@functools.cache
def fit_on(seed):
    """Return a surface, the forces measured on it, and their fit."""
    ds = surface(seed)
    measured = measured_on(ds, seed)
    return ds, measured, roughxr.fit_pair(ds, measured, subregions=(3, 3), **QUICK)


@pytest.fixture
def fits():
    """Return the fits on three surfaces."""
    return [fit_on(seed) for seed in range(3)]


def test_only_the_solved_value_nearest_to_the_fit_warns(monkeypatch):
    """The search passes values at which a prediction is doubtful, which says nothing about its result."""

    def doubtful(ds, **options):
        work = float(ds["work_of_adhesion"])
        warnings.warn(f"doubtful at {work:.2g}", stacklevel=1)
        force = xr.DataArray(work * expectation.RATIO * np.linspace(8.0, 12.0, 9), dims="subregion")
        return force.to_dataset(name="pull_off_force")

    monkeypatch.setitem(fitting.METHODS, "superposed", (doubtful, (3, 3)))
    measured = xr.Dataset({"pull_off_force": ("subregion", 0.4 * np.linspace(8.0, 12.0, 9), {"units": "nN"})})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fit = roughxr.fit_pair(surface(0), measured, method="superposed")
    assert fit.trial_work_of_adhesion.size > 3
    assert [str(warning.message) for warning in caught] == ["doubtful at 0.4"]
    assert caught[0].filename == __file__


@pytest.mark.parametrize("count", [3, pytest.param(5, marks=pytest.mark.soak)])
def test_the_interval_holds_the_true_work_of_adhesion_and_the_fit_is_not_biased(count):
    """How often it holds is counted below, without a simulation."""
    fits = [fit_on(seed) for seed in range(count)]
    assert all(fit.fitted_work_low < TRUE < fit.fitted_work_high for *_, fit in fits)
    wide = [float(fit.fitted_work_high / fit.fitted_work_low) for *_, fit in fits]
    assert np.median(wide) < 3
    off = np.log([float(fit.fitted_work_of_adhesion) / TRUE for *_, fit in fits])
    assert abs(off.mean()) < 0.05 + 2 * off.std(ddof=1) / np.sqrt(off.size)
    assert all(fit.method == "adhesive" and fit.law == "exponential" for *_, fit in fits)


def test_the_profile_is_least_at_the_fit(fits):
    for *_, fit in fits:
        at = fit.quantile_distance.idxmin()
        steps = np.log(fit.trial_work_of_adhesion).diff("trial_work_of_adhesion").max()
        assert abs(np.log(at / fit.fitted_work_of_adhesion)) < steps


def test_a_fit_states_its_result_in_a_sentence_and_shows_it_in_a_figure(fits):
    fit = fits[0][-1]
    opening = "Work of adhesion at which predicted and measured pull-offs agree: 0."
    assert fit.contact.answer().sentence.startswith(opening)
    axes = fit.contact.plot(ax=Figure().subplots())
    drawn = {line.get_label(): line for line in axes.lines}
    assert drawn["fit"].get_xdata()[0] == float(fit.fitted_work_of_adhesion)
    np.testing.assert_array_equal(drawn["tried"].get_ydata(), fit.quantile_distance)
    assert "answer" in dir(fit.contact) and "work of adhesion" in axes.get_xlabel()


@pytest.mark.parametrize("work", [0.03, 0.1, 0.5])
def test_forces_without_noise_at_the_same_places_give_it_back(work):
    ds = surface(3)
    exact = ds.assign_coords(work_of_adhesion=work).contact.adhesive(subregions=(2, 2), **QUICK)
    fit = roughxr.fit_pair(ds, exact, subregions=(2, 2), **QUICK)
    assert float(fit.fitted_work_of_adhesion) == pytest.approx(work, rel=0.02)
    assert float(fit.spread_ratio) == pytest.approx(1, rel=0.05)
    assert float(fit.fitted_work_low) < work < float(fit.fitted_work_high)


def test_superposed_asperities_are_held_to_their_ratio_to_the_simulation(fits):
    """Forces that the simulation made: the quick fit is near, and its interval, much wider, holds the truth."""
    quick = [roughxr.fit_pair(ds, measured, method="superposed") for ds, measured, _ in fits]
    for (*_, fit), other in zip(fits, quick):
        assert float(other.fitted_work_low) < TRUE < float(other.fitted_work_high)
        assert float(other.fitted_work_high / other.fitted_work_low) > float(fit.fitted_work_high / fit.fitted_work_low)
        assert float(other.fitted_work_high / other.fitted_work_low) > 1.4 / 0.3  # the ratio's own interval
    ds = surface(3)
    summed = ds.assign_coords(work_of_adhesion=TRUE).contact.pull_off_map(subregions=(8, 8))
    as_simulated = summed.assign(pull_off_force=summed.pull_off_force / expectation.RATIO)
    fit = roughxr.fit_pair(ds, as_simulated, method="superposed")
    assert float(fit.fitted_work_of_adhesion) == pytest.approx(TRUE, rel=0.01)


def test_what_the_modulus_takes_from_it_is_told():
    ds = surface(3)
    exact = ds.assign_coords(work_of_adhesion=TRUE).contact.pull_off_map(subregions=(8, 8))
    moduli = (20.0, 28.0)
    fits = [
        roughxr.fit_pair(ds.assign_coords(contact_modulus=modulus), exact, method="superposed") for modulus in moduli
    ]
    trade = float(np.log(fits[1].fitted_work_of_adhesion / fits[0].fitted_work_of_adhesion) / np.log(1.4))
    assert trade == pytest.approx(float(fits[0].modulus_trade), abs=0.1)
    assert "contact modulus 20 GPa to the power" in roughxr.answer(fits[0]).sentence
    apart = "so that the fit cannot separate the two" in roughxr.answer(fits[0]).sentence
    assert apart == (abs(float(fits[0].modulus_trade)) >= 0.1)


def test_a_spread_that_no_surface_explains_is_said():
    wide = xr.Dataset({"pull_off_force": ("subregion", np.exp(np.random.default_rng(0).normal(5, 3, 50)))})
    fit = roughxr.fit_pair(surface(3), wide, method="superposed")
    assert "which no work of adhesion explains" in roughxr.answer(fit).sentence


def power_law(x, scatter, slope=1.2, seed=0, n=9):
    return np.exp(slope * np.log(x) + scatter * np.random.default_rng(seed).standard_normal(n))


def fitted(measured, predict, start=1.0, **options):
    options = {"confidence": 0.95, "error": 0.0} | options
    return fit_mean(Samples(measured, None, None, 0), predict, start, **options)


def test_the_interval_is_students_and_covers_as_often_as_it_says():
    """Places drawn anew on both sides, by the thousand: 95 % within four standard deviations of that count."""
    held = 0
    for seed in range(400):
        measured = power_law(2.0, 0.5, seed=seed, n=7)
        fit = fitted(
            measured, lambda x, seed=seed: Predicted(Samples(power_law(x, 0.3, seed=10**6 + seed), *[None] * 2, 0))
        )
        held += fit.low < 2.0 < fit.high
    assert abs(held / 400 - 0.95) < 4 * np.sqrt(0.95 * 0.05 / 400)


def test_errors_that_all_forces_share_widen_the_interval():
    measured = power_law(2.0, 0.01)
    none, probe_error, theirs = (
        fitted(measured, lambda x, e=e: Predicted(Samples(power_law(x, 0.01), None, None, 0), e), error=of)
        for e, of in ((np.nan, 0.0), (np.nan, 0.1), (0.1, 0.0))
    )
    assert np.log(probe_error.high / probe_error.low) == pytest.approx(2 * 1.96 * 0.1 / 1.2, rel=0.05)
    assert (probe_error.low, probe_error.high) == pytest.approx((theirs.low, theirs.high), rel=0.01)
    assert np.log(none.high / none.low) < 0.3 * np.log(probe_error.high / probe_error.low)


def test_a_value_that_cannot_be_solved_is_left_out_and_told():
    def predict(x):
        if x > 2.1:
            raise roughxr.Refusal("scan", "a pull-off at every place", "none")
        return Predicted(Samples(power_law(x, 0.3), None, None, 0))

    fit = fitted(power_law(2.0, 0.3, seed=5), predict)
    assert fit.left_out and min(fit.left_out) > 2.1 and np.isnan(fit.high) and fit.values[-1] > 1.8
    assert fit.low < fit.value < 2.1
    beyond = fitted(power_law(9.0, 0.01, seed=5), predict)
    assert np.isnan([beyond.value, beyond.low, beyond.high]).all()


def test_an_error_of_numpy_is_no_value_that_cannot_be_solved():
    def predict(x):
        return Predicted(Samples(np.ones(2) + np.ones(3), None, None, 0))

    with pytest.raises(ValueError, match="could not be broadcast"):
        fitted(power_law(2.0, 0.3, seed=5), predict)


def test_places_without_a_pull_off_are_not_left_out(monkeypatch):
    monkeypatch.setattr("roughxr.mechanics.contact.cycle.MOST_CELLS", 10)
    ds = glass_pair(scan(rough(96, smooth=2.0, seed=3)), sphere_radius=500.0).assign_coords(work_of_adhesion=0.3)
    options = {"law": "exponential", "mesh": 1, "subregions": (2, 1)}
    forces = xr.Dataset({"pull_off_force": ("subregion", [200.0, 300.0])})
    with pytest.warns(UserWarning, match="cells"), pytest.raises(ValueError, match="a pull-off at every place"):
        roughxr.fit_pair(ds, forces, **options)


def test_forces_at_zero_are_asked_about():
    bad = xr.Dataset({"pull_off_force": ("subregion", [0.0, 2.0, 3.0])})
    with pytest.raises(ValueError, match="expected positive pull-off forces, found 1 of 3"):
        roughxr.fit_pair(surface(0), bad)
    with pytest.raises(ValueError, match="method: expected one of"):
        roughxr.fit_pair(surface(0), bad, method="guess")
    with pytest.raises(ValueError, match="force_std: expected a relative error"):
        roughxr.fit_pair(surface(0), bad, force_std=15)
    with pytest.raises(ValueError, match="expected contact_modulus"):
        roughxr.fit_pair(scan(rough(32)), bad)
