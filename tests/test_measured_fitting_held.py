"""While the work of adhesion is held, roughness tells the range of adhesion, and pressing on the hardness."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.measured.likelihood import Predicted, matching
from roughxr.statistics.sampling import Samples

from .surfaces import glass_pair, rough, scan

TRUE, GRID = 2.0, (3, 3)


def surface(seed, **assigned):
    ds = glass_pair(scan(rough(96, smooth=8.0, seed=seed), pixel=2.0), sphere_radius=500.0)
    return ds.assign_coords({"work_of_adhesion": 0.1, "adhesion_range": 1.0} | assigned)


def measured_on(ds, subregions=GRID):
    return ds.contact.rigid(subregions=subregions, law="exponential", delta=[0.0])


def fit_to(measured, ds, **options):
    options = {"method": "rigid", "subregions": GRID, "delta": [0.0]} | options
    return ds.contact.fit_pair(measured, quantity="adhesion_range", **options)


def test_the_range_is_found_and_its_interval_holds_it():
    ds = surface(3)
    exact = measured_on(ds.assign_coords(adhesion_range=TRUE))
    assert float(fit_to(exact, ds).fitted_adhesion_range) == pytest.approx(TRUE, rel=0.02)
    rng = np.random.default_rng(0)
    places = tuple(rng.uniform(-80, 80, (2, 20)))
    elsewhere = measured_on(ds.assign_coords(adhesion_range=TRUE), places)
    noisy = elsewhere.assign(pull_off_force=elsewhere.pull_off_force * np.exp(0.05 * rng.standard_normal(20)))
    fit = fit_to(noisy, ds)
    low, high = (np.nan_to_num(float(fit[f"fitted_range_{end}"]), nan=nan) for end, nan in (("low", 0), ("high", 99)))
    assert low < TRUE < high and float(fit.force_exponent) > 0.1


def test_what_the_held_work_of_adhesion_takes_from_it_is_told():
    exact = measured_on(surface(3, adhesion_range=TRUE))
    fits = [fit_to(exact, surface(3, work_of_adhesion=work)) for work in (0.1, 0.11)]
    found = float(np.log(fits[1].fitted_adhesion_range / fits[0].fitted_adhesion_range) / np.log(1.1))
    assert found == pytest.approx(float(fits[0].work_trade), rel=0.25)
    assert "fixed at 0.1 J/m²" in fits[0].not_identifiable and found < 0


@pytest.mark.filterwarnings("ignore:rigid. one cell")
def test_a_smooth_sphere_on_a_flat_does_not_tell_the_range():
    flat = glass_pair(scan(np.zeros((96, 96)), pixel=2.0), sphere_radius=500.0)
    flat = flat.assign_coords(work_of_adhesion=0.1, adhesion_range=0.3)
    forces = 2 * np.pi * 0.1 * 500.0 * np.exp(0.05 * np.random.default_rng(0).standard_normal(50))
    measured = xr.Dataset({"pull_off_force": ("subregion", forces)})
    fit = fit_to(measured, flat, subregions=(2, 1))
    assert abs(float(fit.force_exponent)) < 0.05 and np.isnan(fit.work_trade)
    assert "they do not determine it" in fit.not_identifiable


def test_a_range_beyond_those_tried_is_no_number():
    fit = fit_to(measured_on(surface(3, adhesion_range=20.0)), surface(3))
    assert np.isnan(fit.fitted_adhesion_range) and np.isnan(fit.fitted_range_high)
    assert "the best value is at the end of the range tried" in fit.not_identifiable


def test_several_ranges_that_predict_alike_are_said():
    """Forces that first fall and then rise with the number: two stretches of it predict the same."""

    def predict(x):
        spread = 0.1 * np.random.default_rng(1).standard_normal(9)
        return Predicted(Samples(np.exp(2 * np.log(x) ** 2 + spread), None, None, 0))

    measured = Samples(np.exp(1.0 + 0.1 * np.random.default_rng(2).standard_normal(9)), None, None, 0)
    given = {"proportional": False, "reach": 6.0, "confidence": 0.95, "error": 0.0}
    both = matching(measured, predict, 0.9, **given)
    assert both.stretches == 2 and both.low < np.exp(-(0.5**0.5)) < 1 < np.exp(0.5**0.5) < both.high


def test_the_simulation_fits_the_hardness_that_it_predicts_with():
    ds = glass_pair(scan(rough(48, rms=1.0, smooth=3.0, seed=1)), sphere_radius=500.0)
    ds = ds.assign_coords(work_of_adhesion=0.04, adhesion_range=2.0, hardness=1.2)
    options = {"law": "exponential", "mesh": 1, "subregions": (2, 1), "preload": 500.0}
    exact = ds.assign_coords(hardness=0.7).contact.adhesive(**options)
    fit = ds.contact.fit_pair(exact, quantity="hardness", **options)
    assert float(fit.fitted_hardness) == pytest.approx(0.7, rel=0.05)
    assert float(fit.force_exponent) < 0  # what yields more holds more


def test_what_cannot_be_fitted_is_refused():
    forces = xr.Dataset({"pull_off_force": ("subregion", [1.0, 2.0])})
    with pytest.raises(ValueError, match="method: expected one of 'adhesive', 'rigid'"):
        roughxr.fit_pair(surface(0), forces, quantity="adhesion_range", method="superposed")
    with pytest.raises(ValueError, match="expected positive pull-off forces"):
        roughxr.fit_pair(surface(0), -forces, quantity="adhesion_range", method="rigid")
    with pytest.raises(ValueError, match="hardness: expected a value to start from"):
        roughxr.fit_pair(surface(0), forces, quantity="hardness")
