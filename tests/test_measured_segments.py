"""Approach and retraction are the ramps of a recorded curve, whatever holds, creep and modulation surround them."""

import numpy as np
import pytest

import roughxr
from roughxr.files.curves.segments import approach_and_retraction

from . import force_curves as made

TIME = np.arange(300)

#: Travel of each segment, nm: the hold at the surface creeps by 5 nm or is modulated, the far hold drifts.
TRAVELS = {
    "approach": np.linspace(0.0, 1000.0, 500),
    "creep": 1000.0 + 5.0 * TIME / 299,
    "relaxation": 1000.0 - 5.0 * TIME / 299,
    "modulation": 1000.0 + 10.0 * np.sin(TIME / 5.0),
    "retraction": np.linspace(1005.0, 0.0, 500),
    "far hold": -0.5 * TIME / 299,
}

ORDERS = [
    (*hold_at_surface, *far)
    for hold_at_surface in ((), ("creep",), ("relaxation",), ("modulation",))
    for far in ((), ("far hold",))
]


def recorded(hold_at_surface_and_far):
    """Return piezo, number of the segment, and the samples of approach and retraction of a curve with holds."""
    names = ["approach", *(name for name in hold_at_surface_and_far if name != "far hold"), "retraction"]
    names += ["far hold"] * ("far hold" in hold_at_surface_and_far)
    piezo = np.concatenate([TRAVELS[name] for name in names])
    number = np.concatenate([np.full(TRAVELS[name].size, k) for k, name in enumerate(names)])
    ramps = [np.flatnonzero(number == names.index(name)) for name in ("approach", "retraction")]
    return piezo, number, ramps


@pytest.mark.parametrize("holds", ORDERS, ids=" ".join)
def test_holds_of_the_file_belong_to_neither_ramp(holds):
    piezo, number, ramps = recorded(holds)
    for branch, expected in zip(approach_and_retraction(piezo, number), ramps):
        np.testing.assert_array_equal(branch, expected)


@pytest.mark.parametrize("noise", [0.0, 0.5])
@pytest.mark.parametrize("holds", ORDERS, ids=" ".join)
def test_holds_that_the_file_does_not_mark_are_left_out_within_a_tenth_of_the_ramp(holds, noise):
    piezo, _, ramps = recorded(holds)
    piezo = piezo + np.random.default_rng(0).normal(0, noise, piezo.size)
    for branch, expected in zip(approach_and_retraction(piezo), ramps):
        assert abs(branch[0] - expected[0]) <= 50 and abs(branch[-1] - expected[-1]) <= 50


def test_modulation_during_the_ramps_does_not_end_them():
    piezo, number, ramps = recorded(())
    piezo = piezo + 8.0 * np.sin(0.7 * np.arange(piezo.size))
    for branch, expected in zip(approach_and_retraction(piezo, number), ramps):
        np.testing.assert_array_equal(branch, expected)


def test_a_sine_has_no_holds():
    travel = -np.cos(np.linspace(0.0, 2 * np.pi, 1001))
    approach, retraction = approach_and_retraction(travel)
    assert (approach[0], approach[-1], retraction[0], retraction[-1]) == (0, 500, 501, 1000)


def test_a_slow_start_that_travels_is_no_hold():
    """The pull may lie in the first tenth of the travel, at a tenth of the speed."""
    piezo = np.concatenate([np.linspace(3000.0, 2700.0, 500), np.linspace(2699.0, 0.0, 500)])
    assert approach_and_retraction(piezo)[1].size == 1000


def test_a_pause_within_the_retraction_is_taken_out():
    pieces = [np.linspace(0, 1000, 400), np.linspace(1000, 700, 200), np.full(100, 700.0), np.linspace(700, 0, 300)]
    number = np.repeat(np.arange(4), [piece.size for piece in pieces])
    _, retraction = approach_and_retraction(np.concatenate(pieces), number)
    np.testing.assert_array_equal(retraction, np.flatnonzero((number == 1) | (number == 3)))


def test_the_last_whole_cycle_of_several_is_taken():
    piezo, number, ramps = recorded(())
    two_cycles = np.concatenate([piezo, piezo]), np.concatenate([number, number + 2])
    for branch, expected in zip(approach_and_retraction(*two_cycles), ramps):
        np.testing.assert_array_equal(branch, expected + piezo.size)


def test_a_missing_branch_is_none():
    piezo, _, (approach, retraction) = recorded(())
    assert approach_and_retraction(piezo[approach])[1] is None
    assert approach_and_retraction(piezo[retraction])[0] is None
    assert approach_and_retraction(np.full(9, np.nan)) == (None, None)


def test_a_jpk_curve_with_two_pauses_keeps_its_pull(tmp_path):
    """A hold that creeps on, and a far hold that drifts away from the surface, both named pauses by the file."""
    pytest.importorskip("afmformats", reason="microscopes' curves need the extra roughxr[curves]")
    rng = np.random.default_rng(0)
    (there, pushed), (back, drawn) = made.cycle(rng)
    hold = there[-1] + np.linspace(0, 5, 300), np.full(300, pushed[-1])
    far = back[-1] - np.linspace(0, 60, 300), np.full(300, drawn[-1]) + rng.normal(0, 1, 300)
    styles = ("extend", "pause", "retract", "pause")
    made.write_jpk(tmp_path / "holds.jpk-force-map", [[(there, pushed), hold, (back, drawn), far]], styles=styles)
    curves = roughxr.measured.open_curves(tmp_path / "holds.jpk-force-map").isel(subregion=0)
    for branch, expected in (("loading", there), ("retraction", back)):
        np.testing.assert_allclose(curves.piezo.sel(branch=branch).dropna("sample"), expected, atol=1e-6)
    pull = roughxr.measured.curves_pull_off(curves).isel(subregion=0)
    assert abs(float(pull.pull_off_force) - made.PULL) < 3 * float(pull.pull_off_standard_error)
