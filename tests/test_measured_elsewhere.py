"""One work of adhesion, fitted once, holds on other surfaces if it is theirs, and is found out if it is not."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.scans.synthetic import self_affine

TRUE, QUICK = 0.3, {"mesh": roughxr.Mesh(1, step=0.5), "law": "exponential", "subregions": (3, 3)}


def surface(seed, work=TRUE, n=12, scale=1.0):
    """Return a scan, and pull-offs simulated at random places of it with the instrument's noise."""
    ds = self_affine((64, 64), 8.0, rms=1.2 * scale, hurst=0.8, rolloff=120, cutoff=40, seed=seed)
    pair = {"sphere_radius": 1000, "contact_modulus": 40, "work_of_adhesion": 0.1, "adhesion_range": 0.3}
    ds = ds.contact.assign_pair(**pair)
    rng = np.random.default_rng(seed)
    places = tuple(rng.uniform(-180, 180, (2, n)) + [[float(ds[axis].mean())] for axis in "xy"])
    found = ds.assign_coords(work_of_adhesion=work).contact.adhesive(**QUICK | {"subregions": places})
    return ds, found.assign(pull_off_force=found.pull_off_force * np.exp(0.05 * rng.standard_normal(n)))


@pytest.fixture(scope="module")
def verdicts():
    """Return what fits on four surfaces say of another each, rougher or smoother, and of one of five times w."""
    found = []
    for seed in range(4):
        scale = 1.3 if seed % 2 else 0.8
        surfaces = {"own": surface(seed), "other": surface(50 + seed, scale=scale)}
        surfaces["foreign"] = surface(90 + seed, work=5 * TRUE)
        found.append(roughxr.measured.predict_others(surfaces, fit_on="own", resamples=99, **QUICK))
    return found


def test_the_same_work_of_adhesion_holds_on_other_surfaces(verdicts):
    inside = xr.concat([one.inside.sel(surface="other") for one in verdicts], "trial")
    assert int(inside.sel(statistic="mean").sum()) >= 3 and int(inside.sel(statistic="std").sum()) >= 3
    own = xr.concat([one.inside.sel(surface="own") for one in verdicts], "trial")  # fitted is the mean, not the scatter
    assert bool(own.sel(statistic="mean").all()) and int(own.sel(statistic="std").sum()) >= 3


def test_another_work_of_adhesion_is_found_out(verdicts):
    outside = [not bool(one.inside.sel(surface="foreign", statistic="mean")) for one in verdicts]
    assert all(outside) and "foreign: mean" in verdicts[0].verdict
    assert all(float(one.ratio.sel(surface="foreign", statistic="mean")) > 2 for one in verdicts)


def test_the_interval_holds_what_the_fits_own_ends_predict(verdicts):
    one = verdicts[0]
    other, _ = surface(50, scale=0.8)
    for end in ("low", "high"):
        work = float(one[f"fitted_work_{end}"])
        mean = float(other.assign_coords(work_of_adhesion=work).contact.adhesive(**QUICK).pull_off_force.mean())
        ends = one.sel(surface="other", statistic="mean")
        assert float(ends.predicted_low) <= mean <= float(ends.predicted_high)
    assert one.was_fitted.values.tolist() == [True, False, False] and one.predicted.units == "nN"


def test_superposed_asperities_say_less_of_other_surfaces(verdicts):
    """Their ratio to the simulation differs from surface to surface: the interval is wider by that."""
    both = {"own": surface(0), "other": surface(50, scale=0.8)}
    found = roughxr.measured.predict_others(both, fit_on="own", method="superposed", resamples=99)
    wide, narrow = (
        one.sel(surface="other", statistic="mean").predicted_high / one.sel(surface="other", statistic="mean").predicted
        for one in (found, verdicts[0])
    )
    assert float(wide) > max(float(narrow), np.exp(2**0.5 * 1.96 * 0.46))


def test_what_predicts_nothing_is_refused():
    own = surface(0)
    with pytest.raises(ValueError, match="expected at least one other than 'own'"):
        roughxr.measured.predict_others({"own": own}, fit_on="own")
    with pytest.raises(ValueError, match="fit_on: expected one of 'own', 'other'"):
        roughxr.measured.predict_others({"own": own, "other": own}, fit_on="third")
    wild = xr.Dataset({"pull_off_force": ("subregion", np.exp([-15.0, -10.0, 5.0, 10.0, 20.0, 25.0]))})
    with pytest.raises(ValueError, match="whose forces tell the work of adhesion, found 'own'"):
        roughxr.measured.predict_others(
            {"own": (own[0], wild), "other": own}, fit_on="own", method="superposed", resamples=99
        )


def continuation(scan, factor, spread):
    """Return what `continued` would say: a mean of so many times that of the picture, known to so large a factor."""
    mean = factor * float(scan.contact.adhesive(**QUICK).pull_off_force.mean())
    ends = {"pull_off_mean": mean, "pull_off_lower": mean / spread, "pull_off_upper": mean * spread}
    return xr.Dataset(ends, {"work_of_adhesion": scan.work_of_adhesion})


def test_the_verdict_counts_what_the_scans_do_not_show():
    """On the other surface unseen waves take two thirds off the forces: without them it would look foreign."""
    (own, pulls), (other, its_own) = surface(0), surface(50)
    both = {"own": (own, pulls), "other": (other, its_own.assign(pull_off_force=its_own.pull_off_force / 3))}
    options = {"fit_on": "own", "resamples": 99, **QUICK}
    told = {"own": continuation(own, 1.0, 1.02), "other": continuation(other, 1 / 3, 1.02)}
    unsure = told | {"other": continuation(other, 1.0, 4.0)}
    bare, counted, wide = (
        roughxr.measured.predict_others(both, below=below, **options) for below in (None, told, unsure)
    )
    inside = [bool(one.inside.sel(surface="other", statistic="mean")) for one in (bare, counted, wide)]
    assert inside == [False, True, True]
    assert (
        "finer than the scans is not included" in bare.verdict and "finer than the scans is included" in counted.verdict
    )
    at = {"surface": "other", "statistic": "mean"}
    np.testing.assert_allclose(counted.predicted.sel(at), bare.predicted.sel(at) / 3, rtol=0.01)
    assert float((wide.predicted_high / wide.predicted).sel(at)) > 4
    with pytest.raises(ValueError, match="below: expected every surface, found none for other"):
        roughxr.measured.predict_others(both, below={"own": told["own"]}, **options)


def test_a_fit_with_what_the_scan_does_not_show():
    """Forces that unseen waves halve need more adhesion than the picture tells; the interval grows by their error."""
    own, pulls = surface(0)
    told = continuation(own, 0.5, 3.0)
    bare, more = (own.contact.fit_pair(pulls, below=below, **QUICK) for below in (None, told))
    halved = own.contact.fit_pair(pulls.assign(pull_off_force=2 * pulls.pull_off_force), **QUICK)
    np.testing.assert_allclose(more.fitted_work_of_adhesion, halved.fitted_work_of_adhesion, rtol=0.01)
    unsure, sure = (np.log(float(one.fitted_work_high / one.fitted_work_of_adhesion)) for one in (more, halved))
    exponent = float(more.force_exponent)
    assert unsure * exponent == pytest.approx(np.hypot(sure * exponent, np.log(3.0)), rel=0.15)
    assert "is not included" in bare.not_identifiable and "is included" in more.not_identifiable
    for wrong in (told.assign_coords(work_of_adhesion=0.2), told * np.nan, xr.Dataset()):
        with pytest.raises(ValueError, match="below: expected what `continued` finds"):
            own.contact.fit_pair(pulls, below=wrong, **QUICK)


def test_what_continued_finds_is_taken_as_it_is():
    scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=300, materials="glass")
    options = {"subregions": (2, 2), "law": "exponential", "mesh": 1}
    pulls = scan.contact.adhesive(**options)
    below = scan.contact.continued(subregions=(2, 2), seeds=1, shortest=10)
    found, bare = (scan.contact.fit_pair(pulls, below=one, **options) for one in (below, None))
    assert float(found.fitted_work_of_adhesion) > float(bare.fitted_work_of_adhesion)
    assert float(found.fitted_work_low) < float(found.fitted_work_of_adhesion)
