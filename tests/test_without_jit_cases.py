"""Contact cases small enough to run uncompiled; `test_without_jit` does."""

import numpy as np
import pytest

from roughxr.asperity.superposition import superpose
from roughxr.kernels.halfspace import displacement_control as kalker

from .surfaces import glass_pair, rough, scan, sphere_gap


def test_a_few_cells_touch():
    solution = kalker.solve(sphere_gap(9, 9.77), 0.2, 9.77, 39.4)
    assert solution.converged and solution.force > 0


def test_a_box_of_cells_touches_by_transforms():
    n = 21
    solution = kalker.solve(np.zeros((n, n)), 1.0, 9.77, 39.4, tolerance=1e-4)
    assert solution.converged
    # a rigid square punch: F = 1.15 · 2 E* (side/2) δ · … within a few per cent of 1.153 E* side δ
    assert solution.force == pytest.approx(1.153 * 39.4 * n * 9.77 * 1.0, rel=0.03)


def test_asperities_add_up():
    surface = glass_pair(scan(rough(24, seed=1)))
    found = superpose(surface, delta=[0.0, 4.0])
    assert found.force.shape == (1, 2)
