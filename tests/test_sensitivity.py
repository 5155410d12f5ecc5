"""Sensitivity: what is known to matter does, by as much as is known; what cannot matter does not."""

import numpy as np
import pytest

import roughxr
from roughxr.studies.sensitivities import SETTINGS, sensitivity


@pytest.fixture(scope="module")
def scan():
    surface = roughxr.scans.synthetic.self_affine((96, 96), 10, rms=1, hurst=0.8, rolloff=200, cutoff=60, seed=1)
    return roughxr.assign_pair(surface, sphere_radius=500, contact_modulus=40, work_of_adhesion=0.2)


@pytest.fixture(scope="module")
def found(scan):
    return sensitivity(scan, subregions=(4, 4))


def cases(found, factor):
    return found.isel(case=np.flatnonzero(found.factor == factor))


def test_every_factor_is_tried_and_labelled(found):
    assert found.factor.values[0] == "base"
    assert list(dict.fromkeys(found.factor.values[1:].tolist())) == list(SETTINGS)
    assert found.pull_off_mean.units == "nN" and (found.pull_off_mean_low < found.pull_off_mean).all()
    assert (found.unbracketed == 0).all()


def test_the_base_window_is_the_base(scan):
    found = sensitivity(scan, subregions=(4, 4), settings={"fit window": ["auto", 5]})
    assert float(found.pull_off_mean[1]) == float(found.pull_off_mean[0]) != float(found.pull_off_mean[2])


@pytest.mark.parametrize("option", [{"law": "no such law"}, {"preload": "7 parrots"}, {"mesh": 2}])
def test_what_superposition_does_not_use_is_refused(scan, option):
    (name,) = option
    refused = f"{name}: (not used with method='superpose'|expected .*nN)"
    with pytest.raises(ValueError, match=refused):
        sensitivity(scan, **option)


def test_more_surface_energy_and_a_softer_body_stick_more(found):
    base = float(found.pull_off_mean[0])
    for factor, order in (("surface energy", 1), ("modulus", -1)):
        low, high = cases(found, factor).pull_off_mean.values[::order]
        assert low < base < high


def test_one_smooth_summit_follows_jkr_in_energy_and_not_in_modulus():
    x = (np.arange(41) - 20) * 5.0
    height = -(x[:, None] ** 2 + x**2) / (2 * 300.0)
    axes = {"x": x, "y": x}
    surface = roughxr.schema.label(roughxr.scans.synthetic.xr.Dataset({"height": (("x", "y"), height)}, coords=axes))
    pair = roughxr.assign_pair(surface, sphere_radius=600, contact_modulus=40, work_of_adhesion=0.1)
    tried = {"surface energy": [2.0], "modulus": [2.0]}
    found = sensitivity(pair, subregions=(np.array([-1.0, 1.0]), np.array([0.0, 0.0])), settings=tried)
    force = found.pull_off_mean.values
    assert force[0] == pytest.approx(1.5 * np.pi * 0.1 * 200, rel=0.01)
    np.testing.assert_allclose(force[1:] / force[0], [2, 1], rtol=0.01)


def test_levelling_a_tilted_scan_is_said_to_matter(scan):
    tilted = scan.assign(height=scan.height + 0.01 * scan.x)
    found = sensitivity(tilted, subregions=(4, 4), settings={"levelling": ["plane", "quadratic"]})
    assert found.setting.values.tolist() == ["as given", "plane", "quadratic"]
    assert (np.abs(found.pull_off_mean[1:] / found.pull_off_mean[0] - 1) > 1e-3).all()


def test_a_tip_blunter_than_the_asperities_is_flagged(scan):
    found = sensitivity(scan, subregions=(4, 4), settings={"tip radius": [1.0, 2000.0]})
    assert found.sharper_than_tip.values[1] < 0.05 and found.sharper_than_tip.values[2] > 0.95


def test_bad_input_is_refused_in_words(scan):
    with pytest.raises(ValueError, match="'fit window'"):
        sensitivity(scan, settings={"weather": [1]})
    with pytest.raises(ValueError, match="work_of_adhesion > 0"):
        sensitivity(scan.assign_coords(work_of_adhesion=0.0))
