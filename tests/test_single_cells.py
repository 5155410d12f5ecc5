"""Adhesive contacts of one cell, and of two alike: what both solvers find cell by cell has a closed form there."""

import numpy as np
import pytest
from scipy.optimize import brentq

from roughxr.kernels.adhesion import cohesive_laws, equilibrium, path, smooth_laws, smooth_path
from roughxr.kernels.adhesion.constrained_cells import constrain, no_cells
from roughxr.kernels.halfspace.love import love_coefficients
from roughxr.kernels.halfspace.products import coefficients_for
from roughxr.kernels.jit import kernel

W, STRENGTH, HEIGHT = 0.3, 0.2, 0.7
LOVE = love_coefficients(8, 8)

#: Dugdale's law on this mesh: where its plateau and its fall end, nm.
LENGTH, RANGE = (getattr(cohesive_laws.finite_range("dugdale", W, STRENGTH), name) for name in ("length", "range"))

#: Displacements (nm) on all parts of the path: apart, falling traction, plateau, closed by a pull, pressed.
DELTAS = np.array([-2.5, -1.3, -0.8, -0.5, 0.1, 0.55, 0.75, 1.0, 1.5, 2.2])

PLACES = {"one cell": [(1, 2)], "two cells": [(1, 2), (5, 6)]}


def window(places):
    """Return separations that end nowhere but at some places."""
    separation = np.full((7, 9), np.inf)
    separation[tuple(np.transpose(places))] = HEIGHT
    return separation


def compliance(places):
    """Return what a cell sinks under a unit pressure on it and on the other one."""
    return LOVE[0, 0] + (LOVE[4, 4] if len(places) == 2 else 0.0)


def plateau_cell(depth, law, root, compliance):
    """Return pressure and gap of a cell whose depth is δ − S, under a law that falls in a line after its plateau."""
    strength, length, end = root * law.strength, root * law.length, root * law.range
    if depth >= -compliance * strength:
        return depth / compliance, 0.0
    gap = -compliance * strength - depth
    if gap <= length:
        return -strength, gap
    gap = (law.softening * end + depth / compliance) / (law.softening - 1.0 / compliance)
    if gap < end:
        return -law.softening * (end - gap), gap
    return 0.0, -depth


def follow(places, law, **options):
    limits = {"tolerance": 1e-10, "max_iterations": 200, "max_cells": 40}
    return path.follow(window(places), DELTAS, 0.05, law, W, **limits, **options)


def asked(found):
    """Return the states at DELTAS on loading, and on retraction in the same order."""
    states = found.states[found.states[:, path.ASKED] > 0]
    np.testing.assert_array_equal(states[:, path.DELTA], [*DELTAS, *DELTAS[::-1]])
    return states[: DELTAS.size], states[DELTAS.size :][::-1]


@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES)
def test_cells_under_dugdale_s_law_follow_its_three_straight_lines(places):
    """Stiffer than the law's fall, they do so both ways: nothing jumps, and nothing is lost."""
    law, number = cohesive_laws.finite_range("dugdale", W, STRENGTH), len(places)
    found = follow(places, law, fields=True)
    pressures, gaps = np.transpose([plateau_cell(d - HEIGHT, law, 1.0, compliance(places)) for d in DELTAS])
    left = np.array([cohesive_laws.remaining_work(gap, law, 1.0) for gap in gaps])
    for states in asked(found):
        np.testing.assert_allclose(states[:, path.FORCE], number * pressures, atol=1e-9)
        np.testing.assert_array_equal(states[:, path.AREA], number * (gaps == 0.0))
        energies = 0.5 * pressures * (DELTAS - HEIGHT + gaps) - left
        np.testing.assert_allclose(states[:, path.ENERGY], number * energies, atol=1e-9)
        np.testing.assert_allclose(states[:, path.DISSIPATED], 0.0, atol=0.01 * number * W)
        assert states[:, path.OK].all()
        within = gaps < law.range
        np.testing.assert_array_equal(states[within & (gaps < 1.0), path.CONTACTS], number)
    rows, columns = np.transpose(places)
    for p, there, back in zip(pressures, found.pressures, found.pressures[::-1]):
        np.testing.assert_allclose([there[rows, columns], back[rows, columns]], p, atol=1e-9)
        assert np.count_nonzero(there) <= number
    assert found.status == path.CONVERGED
    assert -found.states[:, path.FORCE].min() == pytest.approx(number * STRENGTH, rel=1e-6)
    steps = np.abs(np.diff(found.states[:, path.DELTA]))
    assert steps[2:-1].max() < 0.05 + 1e-9  # before, and after, nothing pulls


@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES)
def test_without_range_cells_stick_from_first_touch_to_the_end_of_the_mesh_s_law(places):
    """By as much as an outline of one cell's area is less tough."""
    law = cohesive_laws.griffith(W)
    with np.errstate(divide="ignore"):  # uncompiled it would warn of the radius of no area, whose energy is 0
        found = follow(places, law)
    root = np.sqrt(1 - law.line / (np.sqrt(1 / np.pi) + law.narrow))
    pressures = np.array([plateau_cell(d - HEIGHT, law, root, compliance(places))[0] for d in DELTAS])
    loading, retraction = asked(found)
    touched = np.where(DELTAS > HEIGHT, pressures, 0.0)
    np.testing.assert_allclose(loading[:, path.FORCE], len(places) * touched, atol=1e-9)
    np.testing.assert_allclose(retraction[:, path.FORCE], len(places) * pressures, atol=1e-9)
    closed = retraction[:, path.DELTA] > HEIGHT
    np.testing.assert_allclose(retraction[closed, path.AREA], len(places))
    np.testing.assert_array_equal(retraction[closed, path.CONTACTS], len(places))
    np.testing.assert_allclose(retraction[closed, path.RESOLUTION], np.sqrt(1 / np.pi))
    assert retraction[0, path.FORCE] == retraction[0, path.ENERGY] == 0.0
    lost, pulled = found.states[-1, path.DISSIPATED], np.trapezoid(*found.states.T[[path.FORCE, path.DELTA]])
    assert lost == pytest.approx(pulled, rel=0.15)
    assert lost == pytest.approx(len(places) * W * root**2, rel=0.15)


@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES)
def test_cells_that_yield_press_with_the_hardness_and_keep_their_dents(places):
    cap, number, sinks = 0.9, len(places), compliance(places)
    law = cohesive_laws.finite_range("dugdale", W, STRENGTH)
    found = follow(places, law, cap=cap, limit=cap, fields=True)
    elastic = np.array([plateau_cell(d - HEIGHT, law, 1.0, sinks)[0] for d in DELTAS])
    loading, retraction = asked(found)
    hard = elastic > cap
    assert hard.sum() == 1
    np.testing.assert_allclose(loading[:, path.FORCE], number * np.minimum(elastic, cap), rtol=2e-3, atol=1e-9)
    dent = DELTAS[-1] - HEIGHT - sinks * cap
    after = [plateau_cell(d - HEIGHT - dent, law, 1.0, sinks)[0] for d in DELTAS]
    np.testing.assert_allclose(retraction[:, path.FORCE], number * np.array(after), atol=2e-3 * number * cap)
    last = found.hard[found.turn - 1]
    np.testing.assert_allclose(last[[path.HARD_FORCE, path.HARD_AREA]], 1.0)
    assert last[path.DENT_AREA] == number
    assert last[path.DENT] == pytest.approx(number * dent, abs=2e-3)
    assert not found.hard[0].any()
    assert found.left[-1][places[0]] == pytest.approx(-dent, abs=2e-3)
    assert np.count_nonzero(found.left[-1]) == number
    plastic = cap * dent * number
    assert loading[-1, path.DISSIPATED] == pytest.approx(plastic, rel=0.03)


def smooth_cell(depth, law, compliance):
    """Return pressure and gap of a cell under a smooth law."""
    if depth / compliance >= -smooth_laws.traction(0.0, law)[0]:
        return depth / compliance, 0.0
    unbalanced = lambda gap: (depth + gap) / compliance + smooth_laws.traction(gap, law)[0]  # noqa: E731
    gap = brentq(unbalanced, 0.0, max(-depth, 0.0) + 1.0, xtol=1e-13)
    return (depth + gap) / compliance, gap


@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES)
@pytest.mark.parametrize("name", ["exponential", "van_der_waals"])
def test_cells_under_a_smooth_law_balance_its_traction(name, places):
    w = {"exponential": 0.2, "van_der_waals": 0.02}[name]  # softer than the cell is
    law = smooth_laws.smooth_law(name, w, 0.8)
    separation = window(places)
    with np.errstate(invalid="ignore"):  # uncompiled it would warn of what is NaN and not used: directions to nowhere
        (found,) = smooth_path.follow_smooth(
            separation, DELTAS, 0.1, coefficients_for(separation.shape), law, tolerance=1e-8, fields=True
        )
    pressures, gaps = np.transpose([smooth_cell(d - HEIGHT, law, compliance(places)) for d in DELTAS])
    left = np.array([smooth_laws.remaining_work(gap, law) for gap in gaps])
    energies = 0.5 * pressures * (DELTAS - HEIGHT + gaps) - left
    number, atol = len(places), 1e-6 * law.strength
    for states in asked(found):
        np.testing.assert_allclose(states[:, path.FORCE], number * pressures, atol=atol)
        np.testing.assert_allclose(states[:, path.ENERGY], number * energies, atol=atol)
        np.testing.assert_array_equal(states[:, path.AREA], number * (gaps == 0.0))
        np.testing.assert_array_equal(states[:, path.CONTACTS], number * (gaps == 0.0))
        closed, attracts = np.maximum(left, 0.0) / (w - law.cut), pressures < -0.02 * law.strength
        np.testing.assert_allclose(states[attracts, path.RESOLUTION], np.sqrt(closed[attracts] / np.pi), atol=1e-6)
        np.testing.assert_allclose(states[:, path.DISSIPATED], 0.0, atol=0.06 * number * w)  # of long steps
        assert states[:, path.OK].all()
    rows, columns = np.transpose(places)
    for p, there, back in zip(pressures, found.pressures, found.pressures[::-1]):
        np.testing.assert_allclose([there[rows, columns], back[rows, columns]], p, atol=atol)
    most = max(smooth_laws.traction(gap, law)[0] for gap in np.linspace(0, 2, 2001))
    assert -found.states[:, path.FORCE].min() == pytest.approx(number * most, rel=5e-3)


@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES)
def test_cells_under_a_smooth_law_yield_as_they_do_under_any(places):
    law, cap, sinks, number = smooth_laws.smooth_law("exponential", 0.2, 0.8), 0.9, compliance(places), len(places)
    separation, deltas = window(places), DELTAS[-4:]
    with np.errstate(invalid="ignore"):
        (found,) = smooth_path.follow_smooth(
            separation, deltas, 0.5, coefficients_for(separation.shape), law, cap=cap, limit=cap, fields=True
        )
    dent = deltas[-1] - HEIGHT - sinks * cap
    states = found.states[found.states[:, path.ASKED] > 0]
    after = [smooth_cell(d - HEIGHT - dent, law, sinks)[0] for d in deltas[::-1]]
    np.testing.assert_allclose(states[deltas.size :, path.FORCE], number * np.array(after), atol=5e-3)
    turned, first = found.hard[found.turn - 1], found.hard[0]
    np.testing.assert_allclose(turned[[path.HARD_FORCE, path.HARD_AREA]], 1.0)
    assert turned[path.DENT_AREA] == number
    assert turned[path.DENT] == pytest.approx(number * dent, abs=5e-3)
    assert not first.any()
    assert found.left[-1][places[0]] == pytest.approx(-dent, abs=5e-3)
    assert not found.left[0].any()  # not at the first displacement


@kernel
def admissible(problem, cells, size):
    return equilibrium._admissible(problem, cells, size)


@pytest.mark.parametrize(
    ("gap", "change", "part"),
    [
        (0.4, -0.5, 0.8),  # closes
        (0.4, -0.3, 1.0),
        (0.4, 2.0, (LENGTH - 0.4) / 2.0),  # leaves the plateau
        (LENGTH + 0.2, -0.4, 0.5),  # returns to it
        (LENGTH + 0.2, 0.8, (RANGE - LENGTH - 0.2) / 0.8),  # passes the end of the range
        (RANGE + 0.3, -0.5, 0.6),
        (RANGE + 0.3, 0.5, 1.0),
    ],
)
def test_a_step_is_shortened_to_where_the_first_cell_changes_its_regime(gap, change, part):
    law = cohesive_laws.finite_range("dugdale", W, STRENGTH)
    cells = no_cells((7, 9))
    i, j = np.ascontiguousarray(np.transpose(PLACES["two cells"]))
    constrain(i, j, np.array([0.1, gap]), np.full(2, HEIGHT), cells, LOVE)
    nothing = np.zeros((7, 9))
    work = {"open": np.array([0, 1]), "matrix": np.zeros((2, 2)), "step": np.array([0.01, change])}
    limits = {"tolerance": 1e-9, "max_iterations": 9, "max_cells": 9, "cap": np.inf, "limit": np.inf}
    fields = {"separation": window(PLACES["two cells"]), "roots": nothing + 1.0, "dent": nothing, "stays": nothing}
    body = equilibrium.Problem(coefficients=LOVE, law=law, w=W, **limits, **fields, **work)
    assert admissible(body, cells, 2) == pytest.approx(part, rel=1e-6)
