"""Pull-off forces on baselines with interference: none is left out, none is biased, and the stated errors hold."""

import numpy as np
import pytest

from roughxr.files.curves.baselines import extrapolated_level, last_step, sample_noise
from roughxr.files.curves.force_curves import evaluated_retraction, retraction_pull
from roughxr.measured import curves_pull_off

from .force_curves import (
    SLOW_RETURNS,
    fringes_without_pull,
    retraction_with_fringes,
    retraction_with_slow_return,
    soft_retractions,
)


def evaluated(curves):
    """Return force, error and limit of curves, and their true pull-off forces."""
    results = [evaluated_retraction(z, force, np.inf, 1.0) for z, force, _ in curves]
    names = ("pull_off_force", "pull_off_standard_error", "pull_off_at_most")
    values = [np.array([getattr(result, name) for result in results]) for name in names]
    return *values, np.array([pull for *_, pull in curves])


@pytest.mark.parametrize("shape", ["sine", "chirp", "two"])
@pytest.mark.parametrize("amplitude", [0.005, 0.05, 0.2])
def test_fringes_leave_out_no_curve_and_bias_none(shape, amplitude):
    """Of other curves than those that set the constants; more in tests/benchmarks/made_curves.py."""
    rng = np.random.default_rng(42)
    force, error, limit, true = evaluated([retraction_with_fringes(rng, amplitude, shape=shape) for _ in range(40)])
    measured = np.isfinite(force)
    assert (measured | (limit >= true)).all() and measured.sum() >= 38
    off = (force / true - 1)[measured]
    assert (np.abs(off * true[measured]) < 2 * error[measured]).mean() >= 0.9
    assert abs(off.mean()) < max(0.02, 3 * off.std() / np.sqrt(off.size))


def test_a_map_with_fringes_has_its_true_mean():
    """Ramps of 600 nm with 2.1 N/m and fringes of 3 nN: only the strongest pulls were used, 53 % above the mean."""
    rng = np.random.default_rng(7)
    travel = np.linspace(150.0, -450.0, 1500)
    curves = []
    for pull in rng.gamma(4.7, 10.5, 100) + 3:
        force = np.where(travel > -pull / 2.1, 2.1 * travel, 0.0)
        force += rng.normal(0, 4) + rng.normal(0, 0.01) * travel + rng.normal(0, 0.5, 1500)
        curves.append((travel, force + 3 * np.sin(2 * np.pi * travel / 330 + rng.uniform(0, 6)), pull))
    force, error, _, true = evaluated(curves)
    assert np.isfinite(force).all() and force.mean() == pytest.approx(true.mean(), rel=0.01)
    assert (np.abs(force - true) < 2 * error).mean() > 0.9


@pytest.mark.parametrize("amplitude", [1, 8, 40])
def test_a_jump_is_read_whatever_the_baseline(amplitude):
    """880 nN on interference of any period; 40 nN gave no value, or 1043."""
    z = np.linspace(3400.0, 0.0, 3400)
    rng = np.random.default_rng(0)
    jump = np.interp(z, [0, 2349, 2350, 3400], [0, 0, -880, 3000])
    for period in (150, 300, 600, 900, 2000):
        force = jump + amplitude * np.sin(2 * np.pi * z / period) + rng.normal(0, 2, z.size)
        result = evaluated_retraction(z, force, np.inf, 1.0)
        assert abs(result.pull_off_force - 880) < max(2 * result.pull_off_standard_error, 6)
        assert result.pull_off_standard_error < 5 + amplitude


def test_a_jump_on_a_curved_baseline_is_its_height():
    z = np.linspace(1500.0, 0.0, 3000)
    rng = np.random.default_rng(1)
    jump = np.where(z > 1000, (z - 1050) * 0.4, 0.0)
    force = jump + 30e-6 * z**2 + rng.normal(0, 0.1, z.size)
    result = evaluated_retraction(z, force, np.inf, 1.0)
    assert result.pull_off_force == pytest.approx(20, rel=0.02) and result.pull_off_standard_error < 0.15 * 20


def test_a_tail_with_fringes_states_a_large_error():
    """A retraction of soft matter without a jump; its far fifth shows one fringe and a half."""
    z = np.linspace(3000.0, 0.0, 1500)
    rng = np.random.default_rng(2)
    values = []
    for _ in range(20):
        force = np.interp(z, [0, 700, 1900, 2600, 3000], [0, 0, -850, 0, 2500])
        force += 20 * np.sin(2 * np.pi * z / 480 + rng.uniform(0, 6)) + rng.normal(0, 2.5, z.size)
        result = evaluated_retraction(z, force, np.inf, 1.0)
        values.append((result.pull_off_force, result.pull_off_standard_error, result.pull_off_at_most))
    force, error, limit = np.array(values).T
    measured = np.isfinite(force)
    assert (measured | (limit > 850)).all() and measured.mean() > 0.5
    assert (np.abs(force - 850) < 2 * error)[measured].mean() >= 0.85


@pytest.mark.parametrize(("pull", "slope"), [(2.0, 0.5), (4.0, 0.1), (4.0, 2.0), (6.0, 2.0)])
def test_the_limit_of_a_weak_pull_holds(pull, slope):
    """Pulls of up to six times the noise, with minima of some to many samples."""
    rng = np.random.default_rng(3)
    x = np.arange(1500) - 600.0
    results = []
    for _ in range(40):
        shifted = x - rng.uniform()
        force = np.where(shifted < 0, np.minimum(-pull - slope * shifted, 100.0), 0.0)
        results.append(evaluated_retraction(-x, force + rng.normal(0, 1, x.size), np.inf, 1.0))
    limit = np.array([result.pull_off_at_most for result in results])
    assert (limit[np.isfinite(limit)] >= pull).mean() >= 0.95 if np.isfinite(limit).any() else True
    assert all(np.isfinite(result.pull_off_force) or np.isfinite(result.pull_off_at_most) for result in results)
    assert pull >= 4 or np.isfinite(limit).all()


@pytest.mark.parametrize("amplitude", [1, 3, 30])
def test_interference_without_a_pull_gives_a_limit(amplitude):
    """Of other curves than those that set the constants: 12 % gave a force by the tilt of a wave's flank."""
    rng = np.random.default_rng(61)
    curves = [fringes_without_pull(rng, amplitude) for _ in range(150)]
    assert np.mean([retraction_pull(z, force, 1.0).is_measured for z, force in curves]) < 0.03
    results = [evaluated_retraction(z, force, np.inf, 1.0) for z, force in curves[:8]]
    assert all(np.isfinite(result.pull_off_force) or result.pull_off_at_most > 0 for result in results)


def test_a_pull_that_was_never_pressed_is_read():
    """The selection would depend on the force: only strong pulls are never pressed at a given travel."""
    z = np.linspace(2000.0, 0.0, 2000)
    rng = np.random.default_rng(4)
    force = np.where(z > 1500, (z - 1500) * 0.01 - 6.0, 0.0) + rng.normal(0, 0.02, z.size)
    result = evaluated_retraction(z, force, np.inf, 1.0)
    assert abs(result.pull_off_force - 6.0) < 3 * result.pull_off_standard_error and np.isnan(result.contact_point)


def test_a_level_is_extrapolated_along_the_polynomial_that_it_follows():
    x = np.arange(3000.0)
    for force in (np.full(x.size, 2.0), 3.0 - x / 500, (x / 1000 - 1) ** 2):
        noisy = force + np.random.default_rng(5).normal(0, 0.01, x.size)
        level, error = extrapolated_level(noisy, 40, 0.01)
        exact = 2.0 * np.polyval(np.polyfit(x, force, 2), -40.0) / 2
        assert abs(level - exact) < 3 * error < 0.05
    assert np.isnan(extrapolated_level(x[:6], 1, 0.1)[0])


def test_a_sharp_minimum_has_the_error_of_its_sampling():
    """A few samples on two steep flanks miss the lowest force by up to half a step, with two of them nearly equal."""
    rng = np.random.default_rng(9)
    x = np.arange(1500.0)
    off = []
    for _ in range(60):
        lowest = 600 + rng.uniform()
        flanks = np.where(x < lowest, 0.4 * (lowest - x), 0.5 * (x - lowest)) - 20
        force = np.minimum(flanks, np.where(x < lowest, 100.0, 0.0)) + rng.normal(0, 0.005, x.size)
        result = evaluated_retraction(-x, force, np.inf, 1.0)
        off.append((result.pull_off_force - 20) / result.pull_off_standard_error)
    assert (np.abs(off) < 2).mean() >= 0.95 and np.sqrt(np.mean(np.square(off))) > 0.2


def test_waves_are_the_error_of_a_jump_beside_them():
    """One period after the jump: the level beside the jump and the mean of the free part differ by the waves."""
    z = np.linspace(1200.0, 0.0, 1200)
    rng = np.random.default_rng(10)
    for phase in np.linspace(0, 6, 7):
        wave = 6e-4 * np.sin(2 * np.pi * z / 400 + phase)
        force = np.where(z > 490, 3e-5 * (z - 490) - 0.0129, 0.0) + wave + rng.normal(0, 5e-5, z.size)
        result = evaluated_retraction(z, force, np.inf, 1.0)
        assert 3e-4 < result.pull_off_standard_error < 9e-4
        by_mean = force[z < 490].mean() - force.min()
        assert abs(result.pull_off_force - by_mean) < 2 * result.pull_off_standard_error


def test_a_late_loss_of_tension_is_a_step_but_interference_is_none():
    rng = np.random.default_rng(6)
    x = np.arange(2000)
    step = np.where(x < 800, -5.0, 0.0) + rng.normal(0, 2.0, x.size)
    count, height = last_step(step, 2.0)
    assert abs(count - 800) < 60 and height == pytest.approx(5.0, rel=0.3)
    wave = 5.0 * np.sin(2 * np.pi * x / 700) + rng.normal(0, 2.0, x.size)
    assert last_step(wave, 2.0) == (0, 0.0) == last_step(rng.normal(0, 2.0, x.size), 2.0)


def test_the_noise_of_rounded_forces_is_at_least_that_of_rounding():
    smooth = np.sin(np.arange(2000) / 300)
    assert sample_noise(np.round(smooth, 2)) == pytest.approx(0.01 / np.sqrt(12)) and sample_noise(smooth) < 1e-5
    noisy = smooth + np.random.default_rng(8).normal(0, 0.1, 2000)
    assert sample_noise(noisy) == pytest.approx(0.1, rel=0.1)


@pytest.mark.parametrize("slope", [0.02, 0.5, 2.0])
def test_pulls_just_above_their_limit_are_not_overestimated(slope):
    """A steep contact, then a tail of weak tension: the lowest of many samples is lower than the force by noise."""
    z = np.linspace(2000.0, 0.0, 2000)
    pulls = []
    for seed in range(40):
        force = np.where(z > 1500, (z - 1500) * slope - 6.0, -6.0 * np.exp(-(1500 - z) / 60))
        force += np.random.default_rng(seed).normal(0, 1, z.size)
        pulls.append(evaluated_retraction(z, force, np.inf, 1.0).pull_off_force)
    assert abs(np.nanmean(pulls) - 6.0) < 0.5


def jumping(rng, pull=20.0, noise=0.05):
    """Return piezo and force of a retraction on a spring of 1 N/m that ends with a jump from a pull."""
    z = np.linspace(1000.0, 0.0, 2000)
    return z, np.where(z > 700 - pull, z - 700, 0.0) + rng.normal(0, noise, z.size)


def test_a_jump_is_read_on_waves_that_rise_after_it():
    """Waves of 30 % of the pull in all phases; where they rise after the jump, the limit was seven times the pull."""
    for phase in np.linspace(0, 6, 13):
        z, force = jumping(np.random.default_rng(11))
        result = evaluated_retraction(z, force + 6 * np.sin(2 * np.pi * z / 250 + phase), np.inf, 1.0)
        assert abs(result.pull_off_force - 20) < 2 * result.pull_off_standard_error < 14


def test_samples_missing_before_a_jump_widen_its_error():
    z, force = jumping(np.random.default_rng(12))
    lowest = int(np.argmin(force))
    force[lowest - 7 : lowest + 1] = np.nan
    result = evaluated_retraction(z, force, np.inf, 1.0)
    assert abs(result.pull_off_force - 20) < 2 * result.pull_off_standard_error < 6


def test_noise_of_the_height_changes_no_pull():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        z, force = jumping(rng)
        quiet = evaluated_retraction(z, force, np.inf, 1.0)
        noisy = evaluated_retraction(z + rng.normal(0, 2, z.size), force, np.inf, 1.0)
        assert noisy.pull_off_force == pytest.approx(quiet.pull_off_force, rel=0.005)


def test_a_force_of_the_opposite_sign_is_no_pull():
    z, force = jumping(np.random.default_rng(13))
    result = evaluated_retraction(z, -force, np.inf, 1.0)
    assert np.isnan(result.pull_off_force) and "opposite sign" in result.reason


def test_a_piezo_of_the_opposite_sign_gives_no_limit():
    z, force = jumping(np.random.default_rng(14))
    approach = np.where(z > 700, z - 700, 0.0) + 0.01 * (force - force.mean())
    result = evaluated_retraction(z, approach[::-1], np.inf, 1.0)
    assert np.isnan(result.pull_off_at_most) and "the piezo may have the opposite sign" in result.reason


def test_a_stated_stretch_is_the_baseline():
    """A bend of 5 nN beside the contact is no baseline where the stretch beyond it is stated."""
    rng = np.random.default_rng(12)
    z = np.linspace(50.0, -950.0, 2000)
    errors = []
    for pull in (8.0, 12.0, 20.0, 30.0):
        force = np.where(z > -pull / 2.0, 2.0 * z, 0.0) + 0.003 * z + 5.0 * np.exp(-(((z + 350.0) / 80.0) ** 2))
        result = evaluated_retraction(z, force + rng.normal(0, 0.1, z.size), np.inf, (0.0, 0.4))
        assert result.baseline_tilt == pytest.approx(0.003, abs=3e-4)
        errors.append((result.pull_off_force - pull) / result.pull_off_standard_error)
    assert np.abs(errors).max() < 3


@pytest.mark.parametrize("baseline", [(0.4, 0.2), (0.0, 1.2), (-0.1, 0.5), (0.1, 0.2, 0.3), 0.0])
def test_a_stretch_outside_the_travel_is_refused(baseline):
    curves = soft_retractions(np.random.default_rng(0), np.zeros(1), 0.0, 5000.0)
    with pytest.raises(ValueError, match="baseline: expected"):
        curves_pull_off(curves, baseline=baseline)


@pytest.mark.parametrize("kind", SLOW_RETURNS)
def test_the_readings_of_a_slow_return_lie_within_the_stated_error(kind):
    """A tilted line, and the level far out; of either alone, 74 %, 62 % and 56 % of pulls lay within two errors."""
    rng = np.random.default_rng(71)
    force, error, limit, true = evaluated([retraction_with_slow_return(rng, kind) for _ in range(40)])
    measured = np.isfinite(force)
    assert measured.sum() >= 36 and (limit > 0.85 * true)[~measured].all()
    assert (np.abs(force - true) < 2 * error)[measured].mean() > 0.85
    assert np.median((error / true)[measured]) < 0.3


def test_the_lowest_sample_of_a_plateau_is_within_its_error():
    """The lowest of many samples is lower than the plateau by noise; 94 % lay within two errors."""
    rng = np.random.default_rng(32)
    true = rng.uniform(0.05, 0.4, 120)
    curves = soft_retractions(rng, true, 0.0, 5000.0)
    z = curves.piezo.values
    force, error, _, true = evaluated([(z, force, pull) for force, pull in zip(curves.force.values, true)])
    assert (np.abs(force - true) < 2 * error).mean() > 0.96
