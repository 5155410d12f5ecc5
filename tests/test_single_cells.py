"""Adhesive contacts of one cell, and of two alike: what the solver finds has a closed form there."""

import numpy as np
import pytest
from scipy.optimize import brentq

from roughxr.mechanics.kernels.adhesion import path as path
from roughxr.mechanics.kernels.adhesion import states as smooth_states
from roughxr.mechanics.kernels.adhesion import traction_laws as smooth_laws
from roughxr.mechanics.kernels.halfspace.love import love_coefficients

HEIGHT = 0.7
LOVE = love_coefficients(8, 8)

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


def asked(path_states):
    """Return the states at DELTAS on loading, and on retraction in the same order."""
    states = path_states.states[path_states.states["prescribed"] > 0]
    np.testing.assert_array_equal(states["delta"], [*DELTAS, *DELTAS[::-1]])
    return states[: DELTAS.size], states[DELTAS.size :][::-1]


def smooth_cell(depth, law, compliance):
    """Return pressure and gap of a cell under a smooth law."""
    if depth / compliance >= -smooth_laws.traction(0.0, law)[0]:
        return depth / compliance, 0.0
    unbalanced = lambda gap: (depth + gap) / compliance + smooth_laws.traction(gap, law)[0]  # noqa: E731
    gap = brentq(unbalanced, 0.0, max(-depth, 0.0) + 1.0, xtol=1e-13)
    return (depth + gap) / compliance, gap


@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES)
@pytest.mark.parametrize("name", ["exponential", "waals"])
def test_cells_under_a_smooth_law_balance_its_traction(name, places, monkeypatch):
    monkeypatch.setattr(smooth_states, "TOLERANCE", 1e-8)
    w = {"exponential": 0.2, "waals": 0.02}[name]  # softer than the cell is
    law = smooth_laws.smooth_law(**{name: (w, 0.8)})
    separation = window(places)
    with np.errstate(invalid="ignore"):  # uncompiled it would warn of what is NaN and not used: directions to nowhere
        (followed,) = path.follow_path(separation, DELTAS, 0.1, law, fields=True)
    pressures, gaps = np.transpose([smooth_cell(d - HEIGHT, law, compliance(places)) for d in DELTAS])
    work = np.array([smooth_laws.remaining_work(gap, law) for gap in gaps])
    energies = 0.5 * pressures * (DELTAS - HEIGHT + gaps) - work
    number = len(places)
    atol = 1e-6 * law.strength
    for states in asked(followed):
        np.testing.assert_allclose(states["force"], number * pressures, atol=atol)
        np.testing.assert_allclose(states["energy"], number * energies, atol=atol)
        np.testing.assert_array_equal(states["contact_area"], number * (gaps == 0.0))
        np.testing.assert_array_equal(states["contact_patches"], number * (gaps == 0.0))
        closed = np.maximum(work, 0.0) / (w - law.cut)
        attracts = pressures < -0.02 * law.strength
        np.testing.assert_allclose(states["resolution"][attracts], np.sqrt(closed[attracts] / np.pi), atol=1e-6)
        np.testing.assert_allclose(states["dissipated"], 0.0, atol=0.06 * number * w)  # of long steps
        assert states["converged"].all()
    rows, columns = np.transpose(places)
    for p, there, back in zip(pressures, followed.pressures, followed.pressures[::-1]):
        np.testing.assert_allclose([there[rows, columns], back[rows, columns]], p, atol=atol)
    largest_traction = max(smooth_laws.traction(gap, law)[0] for gap in np.linspace(0, 2, 2001))
    assert -followed.states["force"].min() == pytest.approx(number * largest_traction, rel=5e-3)


@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES)
def test_cells_under_a_smooth_law_yield_as_they_do_under_any(places):
    law = smooth_laws.smooth_law(exponential=(0.2, 0.8))
    cap = 0.9
    sinks = compliance(places)
    number = len(places)
    separation = window(places)
    deltas = DELTAS[-4:]
    with np.errstate(invalid="ignore"):
        (followed,) = path.follow_path(separation, deltas, 0.5, law, cap=cap, limit=cap, fields=True)
    dent = deltas[-1] - HEIGHT - sinks * cap
    states = followed.states[followed.states["prescribed"] > 0]
    after = [smooth_cell(d - HEIGHT - dent, law, sinks)[0] for d in deltas[::-1]]
    np.testing.assert_allclose(states["force"][deltas.size :], number * np.array(after), atol=5e-3)
    turned = followed.states[followed.first_retraction - 1]
    first = followed.states[0]
    assert turned["yielded_fraction"] == turned["yielded_area_fraction"] == 1.0
    assert turned["yielded_area"] == number
    assert turned["plastic_work"] == pytest.approx(number * dent, abs=5e-3)
    assert not any(first[name] for name in ("yielded_fraction", "yielded_area", "plastic_work"))
    assert followed.residual_heights[-1][places[0]] == pytest.approx(-dent, abs=5e-3)
    assert not followed.residual_heights[0].any()  # not at the first displacement
