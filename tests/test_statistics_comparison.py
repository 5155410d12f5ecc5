"""Superposition set beside the direct simulation."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.statistics import force_ratio


def solution(force, delta, **more):
    force = np.atleast_2d(np.asarray(force, float))
    extra = {name: (("subregion", "delta"), np.atleast_2d(values)) for name, values in more.items()}
    return xr.Dataset({"force": (("subregion", "delta"), force), **extra}, coords={"delta": np.asarray(delta, float)})


def test_parting_is_after_the_last_agreement():
    delta = [1, 2, 3, 4]
    direct = solution([[1, 2, 3, 4], [1, 2, 3, 4], [0, 0, 3, 4], [0, 0, 0, 0]], delta)
    other = solution([[1, 2.1, 4, 8], [1, 2, 3.2, 4.3], [0, 0, 9, 16], [0, 0, 0, 0]], delta)
    ratio = force_ratio(other, direct)
    np.testing.assert_array_equal(ratio.divergence_delta, [3, np.nan, 3, np.nan])
    np.testing.assert_allclose(ratio.agreeing, [1, 1, 1 / 3, 1 / 3])
    assert ratio.divergence_delta.units == "nm" and ratio.attrs["agree_within"] == 0.1
    assert np.isnan(ratio.force_difference[3]).all()
    np.testing.assert_allclose(ratio.mean_difference, [0, 0.1 / 4, 7.2 / 9, 16.3 / 12], atol=1e-12)
    assert float(ratio.mean_divergence_delta) == 3


def test_nothing_is_relative_to_no_force():
    ratio = force_ratio(solution([[1, 1], [0, 1]], [1, 2]), solution([[0, 1], [0, 1]], [1, 2]))
    np.testing.assert_array_equal(ratio.mean_difference, [np.nan, 0])
    np.testing.assert_array_equal(ratio.force_difference, [[np.nan, 0], [np.nan, 0]])
    np.testing.assert_array_equal(ratio.agreeing, [np.nan, 1])


def test_the_superposed_sweep_is_read_at_the_direct_displacements():
    fine = np.linspace(0, 4, 41)
    contacts = np.full((1, 41), 4.0)
    other = solution(2 * fine, fine, contacts=contacts, contacts_overlapping=contacts / 4)
    ratio = force_ratio(other, solution([2, 6], [1, 3]))
    np.testing.assert_allclose(ratio.force_difference, [[0, 0]], atol=1e-12)
    np.testing.assert_allclose(ratio.overlap_fraction, [0.25, 0.25])


def test_solutions_that_cannot_be_compared_are_refused_in_words():
    reference = solution([[1, 2]], [1, 2])
    with pytest.raises(ValueError, match="same contact centres"):
        force_ratio(solution([[1, 2], [1, 2]], [1, 2]), reference)
    with pytest.raises(ValueError, match="datum: expected the same for both"):
        force_ratio(reference.assign_attrs(datum="first_contact"), reference)
    for far in ([11, 12], [-5, -4]):
        with pytest.raises(ValueError, match="ranges that overlap"):
            force_ratio(reference, solution([[1, 2]], far))
    for near in ([0.5, 1.5], [1.5, 2.5]):
        assert np.isfinite(force_ratio(reference, solution([[1, 2]], near)).force_difference).sum() == 1


def test_ratios_of_both_methods_on_the_twin_cross_one_near_ten_nanometres():
    """The mean of the paper's own sum does, while single places disagree; on the paper's linear axes see `test_cli`."""
    scan = roughxr.open_sample("glass")
    scan = roughxr.assign_pair(scan, sphere_radius=3000, young_modulus=75, poisson_ratio=0.22)
    catalogue = roughxr.asperities(scan, patch="paper")
    centres = roughxr.scans.regions.centres(scan, (8, 8))
    places = centres.isel(subregion=np.flatnonzero(~centres.on_debris))
    direct = roughxr.direct(scan, delta=[10.0, 12.0], subregions=places)
    superposed = roughxr.superpose(
        catalogue, delta=np.arange(8, 14, 0.1), subregions=places, law="hertz", formulation="published"
    )
    ratio = force_ratio(superposed, direct)
    assert abs(float(ratio.mean_difference.sel(delta=10))) < 0.1
    assert float(ratio.agreeing.sel(delta=10)) < 0.5
    assert float(ratio.mean_difference.sel(delta=12)) > 0.3
    assert float(ratio.agreeing.sel(delta=12)) < 0.1
