"""The work of adhesion that is fitted on one surface holds on it and on another."""

import numpy as np
import pytest
import xarray as xr

import roughxr

from .surfaces import glass_pair, rough, scan

TRUE = 0.3


def surface(seed, work=0.1):
    return glass_pair(scan(rough(96, smooth=2.0, seed=seed)), sphere_radius=500.0).assign_coords(work_of_adhesion=work)


def measured_on(ds, seed, n=64, noise=0.05):
    """Return pull-offs at random places of a surface, with the instrument's noise."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-400, 400, (2, n))
    found = ds.assign_coords(work_of_adhesion=TRUE).contact.pull_off_map(subregions=tuple(places))
    return found.assign(pull_off_force=found.pull_off_force * np.exp(noise * rng.standard_normal(n)))


@pytest.fixture(scope="module")
def fits():
    found = []
    for seed in range(10):
        ds = surface(seed)
        found.append((ds, roughxr.fit_pair(ds, measured_on(ds, seed), resamples=99)))
    return found


def test_the_interval_holds_the_true_work_of_adhesion(fits):
    held = [bool(fit.fitted_work_low < TRUE < fit.fitted_work_high) for _, fit in fits]
    assert sum(held) >= 8
    wide = [float(fit.fitted_work_high / fit.fitted_work_low) for _, fit in fits]
    assert np.median(wide) < 2


def test_what_is_fitted_on_one_surface_holds_on_another(fits):
    held = []
    for seed, (_, fit) in enumerate(fits[:6]):
        other = surface(100 + seed)
        measured = measured_on(other, 100 + seed)
        ends = [
            other.assign_coords(work_of_adhesion=float(fit[name])).contact.pull_off_map(subregions=(8, 8))
            for name in ("fitted_work_low", "fitted_work_high")
        ]
        compared = [one.contact.compare(measured, statistics=["mean"], resamples=99, shift=None) for one in ends]
        held.append(float(compared[0].ratio_high[0]) > 1 > float(compared[1].ratio_low[0]))
        assert 0.6 < float(fit.spread_ratio) < 1.6
    assert sum(held) >= 5


def test_the_profile_is_least_at_the_fit(fits):
    for _, fit in fits[:3]:
        at = fit.quantile_distance.idxmin()
        steps = np.log(fit.trial_work_of_adhesion).diff("trial_work_of_adhesion").max()
        assert abs(np.log(at / fit.fitted_work_of_adhesion)) < steps


def test_forces_without_noise_at_the_same_places_give_it_back():
    ds = surface(3)
    exact = ds.assign_coords(work_of_adhesion=TRUE).contact.pull_off_map(subregions=(8, 8))
    fit = roughxr.fit_pair(ds, exact, subregions=(8, 8), resamples=20)
    assert float(fit.fitted_work_of_adhesion) == pytest.approx(TRUE, rel=0.01)
    assert float(fit.spread_ratio) == pytest.approx(1, rel=0.02)


def test_what_the_modulus_takes_from_it_is_told():
    ds = surface(3)
    exact = ds.assign_coords(work_of_adhesion=TRUE).contact.pull_off_map(subregions=(8, 8))
    fits = [
        roughxr.fit_pair(ds.assign_coords(contact_modulus=modulus), exact, resamples=20)
        for modulus in (39.4, 39.4 * 1.4)
    ]
    found = float(np.log(fits[1].fitted_work_of_adhesion / fits[0].fitted_work_of_adhesion) / np.log(1.4))
    assert found == pytest.approx(float(fits[0].modulus_trade), abs=0.1)
    assert "contact modulus 39.4 GPa to the power" in fits[0].not_identifiable


def test_a_spread_that_no_surface_explains_is_said():
    ds = surface(3)
    wide = xr.Dataset({"pull_off_force": ("subregion", np.exp(np.random.default_rng(0).normal(5, 3, 50)))})
    fit = roughxr.fit_pair(ds, wide, resamples=20)
    assert "which no work of adhesion explains" in fit.not_identifiable


def test_the_simulation_fits_what_it_predicts():
    ds = glass_pair(scan(rough(64, rms=0.5, smooth=4.0, seed=1)), sphere_radius=500.0)
    ds = ds.assign_coords(work_of_adhesion=0.04, adhesion_range=2.0)
    options = {"law": "exponential", "refine": 1, "subregions": (2, 1)}
    exact = ds.assign_coords(work_of_adhesion=0.05).contact.adhesive(**options)
    fit = roughxr.fit_pair(ds, exact, resamples=20, method="adhesive", **options)
    assert float(fit.fitted_work_of_adhesion) == pytest.approx(0.05, rel=0.05)
    assert fit.method == "adhesive"


def test_places_without_a_pull_off_are_not_left_out(monkeypatch):
    monkeypatch.setattr("roughxr.contact.cycle.MOST_CELLS", 10)
    ds = surface(3, work=0.3)
    options = {"law": "exponential", "refine": 1, "subregions": (2, 1)}
    forces = xr.Dataset({"pull_off_force": ("subregion", [200.0, 300.0])})
    with pytest.warns(UserWarning, match="cells"), pytest.raises(ValueError, match="a pull-off at every place"):
        roughxr.fit_pair(ds, forces, method="adhesive", **options)


def test_forces_at_zero_are_asked_about():
    bad = xr.Dataset({"pull_off_force": ("subregion", [0.0, 2.0, 3.0])})
    with pytest.raises(ValueError, match="expected positive pull-off forces, found 1 of 3"):
        roughxr.fit_pair(surface(0), bad)
    with pytest.raises(ValueError, match="method: expected one of"):
        roughxr.fit_pair(surface(0), bad, method="guess")
    with pytest.raises(ValueError, match="expected contact_modulus"):
        roughxr.fit_pair(scan(rough(32)), bad)
