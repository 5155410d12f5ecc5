"""The limit of a curve without a visible pull is the smallest pull that would be detected in it."""

import numpy as np
import pytest

from roughxr.files.curves.baselines import sample_noise
from roughxr.files.curves.force_curves import evaluated_retraction, retraction_pull
from roughxr.files.curves.sharp_steps import contact_end, sharpest_step
from roughxr.measured import curves_pull_off

from .force_curves import soft_retractions

NOISE = 0.006

#: Samples of the contact, and of the tension after it.
CONTACT, TENSION = 500, 75


@pytest.mark.parametrize(("drift", "period"), [(0.0, 5000.0), (0.05, 3000.0), (0.15, 9000.0), (0.15, 2000.0)])
def test_a_step_is_found_on_slow_drift_and_none_without_a_pull(drift, period):
    """A pull of 8 standard deviations of the noise, on drift of up to 25; by its depth, 5 of 48 were found."""
    for pull in (0.0, 0.05):
        curves = soft_retractions(np.random.default_rng(4), np.full(20, pull), drift, period)
        steps = [sharpest_step(force, sample_noise(force)) for force in curves.force.values]
        if pull == 0:
            assert steps == [None] * 20
            continue
        assert all(abs(step.first - CONTACT - TENSION) < 20 for step in steps)
        assert np.mean([step.height for step in steps]) == pytest.approx(pull, rel=0.03)


def test_the_contact_ends_within_the_height_of_the_drift():
    """Up to 170 samples early, where a contact of 0.15 nN is no higher than a crest; or late, never far out."""
    curves = soft_retractions(np.random.default_rng(5), np.zeros(20), 0.15, 4000.0)
    ends = np.array([contact_end(force) for force in curves.force.values])
    assert ((ends > CONTACT - 180) & (ends <= 1200)).all()


@pytest.mark.parametrize(("drift", "period", "tension"), [(0.03, 7000.0, "root"), (0.1, 6000.0, "ramp")])
def test_pulls_of_the_size_of_the_limit_are_detected(drift, period, tension):
    """On drifts and shapes of the tension that set no constant."""
    rng = np.random.default_rng(6)
    curves = soft_retractions(rng, np.zeros(6), drift, period)
    limits = [
        evaluated_retraction(curves.piezo.values, force, np.inf, 1.0).pull_off_at_most for force in curves.force.values
    ]
    limit = float(np.median(limits))
    assert 2 * NOISE < limit < 10 * NOISE and max(limits) < np.ptp(curves.force.values)
    pulled = soft_retractions(rng, np.full(40, limit), drift, period, tension=tension)
    detected = [retraction_pull(pulled.piezo.values, force, 1.0).is_measured for force in pulled.force.values]
    assert np.mean(detected) >= 0.95


def test_the_likelihood_of_soft_curves_with_drift_contains_the_mean():
    """Half of the pulls are below the limit; with limits of 2 nN the likelihood gave twice the mean."""
    rng = np.random.default_rng(7)
    true = rng.exponential(0.06, 32)
    measured = curves_pull_off(soft_retractions(rng, true, 0.15, 5000.0))
    force = measured.pull_off_force.values
    is_measured = np.isfinite(force)
    assert 0.2 < is_measured.mean() < 0.95
    assert (true <= measured.pull_off_at_most.values)[~is_measured].mean() > 0.9
    off = np.abs(force - true)[is_measured]
    assert (off < 2 * measured.pull_off_standard_error.values[is_measured]).all()
    answer = measured.contact.answer()
    assert float(answer.likelihood_low) <= true.mean() <= float(answer.likelihood_high)


def test_the_pull_of_a_line_that_falls_further_than_the_force_recovers_is_none():
    """Drift of 9 µm: a line through its far flank, extrapolated, gave 0.59 ± 0.03 nN without a pull."""
    curves = soft_retractions(np.random.default_rng(2), np.zeros(60), 0.15, 9000.0)
    assert not any(retraction_pull(curves.piezo.values, force, 1.0).is_measured for force in curves.force.values)


def with_slips(force, size, ends, length=40):
    """Return forces with tensions that grow over samples before each end, and are lost there."""
    out = force.copy()
    for end in ends:
        out[..., end - length : end] -= size * np.linspace(0, 1, length)
    return out


def test_a_slip_among_slips_of_its_height_is_no_pull():
    """Of real gels that slip in contact and after it, the highest slip was the pull-off force; here of 12 curves."""
    curves = soft_retractions(np.random.default_rng(21), np.zeros(12), 0.05, 3000.0)
    ends = [430, 480, 540]
    for size, last in ((0.04, 0.04), (0.04, 0.15)):
        forces = with_slips(with_slips(curves.force.values, size, ends[:2]), last, ends[2:])
        results = [evaluated_retraction(curves.piezo.values, force, np.inf, 1.0) for force in forces]
        measured = [result for result in results if np.isfinite(result.pull_off_force)]
        if last == size:
            assert len(measured) <= 1
            assert min(result.pull_off_at_most for result in results if result not in measured) > last
            continue
        assert len(measured) == 12
        assert all(abs(result.pull_off_force - last) < 2 * result.pull_off_standard_error for result in measured)


@pytest.mark.parametrize("seed", range(3))
def test_a_slip_above_the_baseline_is_no_pull(seed):
    """A surface that slips while it is pressed, far in contact: 0.08 ± 0.005 nN without adhesion."""
    z = np.linspace(5000.0, 0.0, 5000)
    force = np.where(z > 4700, 0.01 * (z - 4700) + 0.4, 0.4 * np.exp((z - 4700) / 60.0))
    force -= np.where((z > 4680) & (z < 4710), 0.12 * (4710 - z) / 30, 0.0)
    force += np.random.default_rng(seed).normal(0, 0.008, z.size)
    result = evaluated_retraction(z, force, np.inf, 1.0)
    assert np.isnan(result.pull_off_force) and 0.02 < result.pull_off_at_most < 0.08
