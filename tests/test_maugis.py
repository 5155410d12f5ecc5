"""Maugis's sphere: published figures, both limits, and the shipped table against the closed form."""

import numpy as np
import pytest

from roughxr.mechanics.kernels.asperity import maugis
from roughxr.mechanics.kernels.asperity.elliptic_table import lookup, mark_at_row

from . import asperity_tables


@pytest.mark.parametrize("parameter", [0.05, 0.13, 0.5, 0.85, 1.0, 1.3, 2.0, 6.0, 30.0])
def test_the_table_holds_the_closed_form(parameter):
    table = maugis.table()
    row = maugis.table_row(parameter)
    P, a, delta = maugis.contact_at(parameter, 1 + np.geomspace(1e-6, 1e7, 20001))
    end = int(np.argmin(delta))
    tabulated_end = mark_at_row(table.marks, row, 0)
    assert tabulated_end == pytest.approx(delta[end], abs=2e-5)
    assert mark_at_row(table.marks, row, 1) == pytest.approx(P.min(), abs=1e-5)
    away = [k for k in range(end) if 1e-3 < delta[k] - tabulated_end < 50]  # the turn itself: square roots
    read = np.array([lookup(table.spline, row, delta[k] - tabulated_end)[:2] for k in away])
    assert np.max(np.abs(read[:, 0] - P[away]) / np.maximum(1, abs(P[away]))) < 1e-3
    assert np.max(np.abs(read[:, 1] - a[away]) / np.maximum(1, a[away])) < 6e-3


@pytest.mark.parametrize("radius, expected", [(3000, 4.9), (100, 1.6), (10, 0.7)])
def test_tabor_parameter_of_glass(radius, expected):
    assert maugis.tabor(0.5 / radius, 0.5 / radius, 39.407, 2 * 0.6421, 0.3) == pytest.approx(expected, abs=0.05)


def test_a_table_made_again_begins_with_hertz_and_keeps_its_rows():
    """Of two cells across: far above its end a branch is Hertz's, and at a row's own parameter the marks are exact."""
    made = asperity_tables.maugis_table(2)
    for row in (0.0, 1.0, 2.0):
        P, a, _ = lookup(made.spline, row, 1e8)
        assert pytest.approx(1e12, rel=2e-3) == P and a == pytest.approx(1e4, rel=2e-3)
    assert mark_at_row(made.marks, 0.0, 1) == pytest.approx(-2 / 3 * maugis.pull_off(maugis.SMALLEST), rel=1e-3)
