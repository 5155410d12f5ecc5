"""One work of adhesion, fitted once, holds on other surfaces if it is theirs, and is found out if it is not."""

import numpy as np
import pytest
import xarray as xr

import roughxr

from .surfaces import glass_pair, rough, scan

TRUE = 0.3


def surface(seed, work=TRUE, n=64, scale=1.0):
    """Return a scan, and pull-offs at random places of it with the instrument's noise."""
    ds = glass_pair(scan(rough(96, rms=2.0 * scale, smooth=2.0, seed=seed)), sphere_radius=500.0)
    rng = np.random.default_rng(seed)
    places = tuple(rng.uniform(-400, 400, (2, n)))
    found = ds.assign_coords(work_of_adhesion=work).contact.pull_off_map(subregions=places)
    return ds.assign_coords(work_of_adhesion=0.1), found.assign(
        pull_off_force=found.pull_off_force * np.exp(0.05 * rng.standard_normal(n))
    )


@pytest.fixture(scope="module")
def verdicts():
    """Return what fits on five surfaces say of another each, rougher or smoother, and of one of three times w."""
    found = []
    for seed in range(5):
        scale = 1.3 if seed % 2 else 0.8
        surfaces = {"own": surface(seed), "other": surface(50 + seed, scale=scale)}
        surfaces["foreign"] = surface(90 + seed, work=3 * TRUE)
        found.append(roughxr.predict_others(surfaces, fit_on="own", resamples=99))
    return found


def test_the_same_work_of_adhesion_holds_on_other_surfaces(verdicts):
    inside = xr.concat([one.inside.sel(surface="other") for one in verdicts], "trial")
    assert int(inside.sel(statistic="mean").sum()) >= 4 and int(inside.sel(statistic="std").sum()) >= 4
    assert all(bool(one.inside.sel(surface="own").all()) for one in verdicts)


def test_another_work_of_adhesion_is_found_out(verdicts):
    outside = [not bool(one.inside.sel(surface="foreign", statistic="mean")) for one in verdicts]
    assert all(outside) and "foreign: mean" in verdicts[0].verdict
    assert all(float(one.ratio.sel(surface="foreign", statistic="mean")) > 2 for one in verdicts)


def test_the_interval_holds_what_the_fits_own_ends_predict(verdicts):
    one = verdicts[0]
    other, _ = surface(50, scale=0.8)
    for end in ("low", "high"):
        work = float(one[f"fitted_work_{end}"])
        mean = float(
            other.assign_coords(work_of_adhesion=work).contact.pull_off_map(subregions=(8, 8)).pull_off_force.mean()
        )
        ends = one.sel(surface="other", statistic="mean")
        assert float(ends.predicted_low) <= mean <= float(ends.predicted_high)
    assert one.was_fitted.values.tolist() == [True, False, False] and one.predicted.units == "nN"


def test_what_predicts_nothing_is_refused():
    own = surface(0)
    with pytest.raises(ValueError, match="expected another beside 'own'"):
        roughxr.predict_others({"own": own}, fit_on="own")
    with pytest.raises(ValueError, match="fit_on: expected one of 'own', 'other'"):
        roughxr.predict_others({"own": own, "other": own}, fit_on="third")
    wild = xr.Dataset({"pull_off_force": ("subregion", np.exp(np.random.default_rng(0).normal(5, 4, 6)))})
    with pytest.raises(ValueError, match="whose forces tell the work of adhesion, found 'own'"):
        roughxr.predict_others({"own": (own[0], wild), "other": own}, fit_on="own", resamples=99)
