"""Contact cases small enough to run uncompiled; `test_without_jit` does."""

import numpy as np
import pytest

from roughxr.asperity.catalogue import asperities
from roughxr.asperity.superposition import superpose
from roughxr.kernels.halfspace import displacement_control as kalker

from .surfaces import glass_pair, rough, scan, sphere_gap


def test_a_few_cells_touch():
    """Hertz's force of a sphere, 4/3 E* √R δ^3/2; the contact is two and a half cells in radius."""
    solution = kalker.solve(sphere_gap(9, 9.77), 0.2, 9.77, 39.4)
    assert solution.converged
    assert solution.force == pytest.approx(4 / 3 * 39.4 * np.sqrt(3000.0) * 0.2**1.5, rel=0.05)


def test_a_box_of_cells_touches_by_transforms():
    n = 21
    solution = kalker.solve(np.zeros((n, n)), 1.0, 9.77, 39.4, tolerance=1e-4)
    assert solution.converged
    # a rigid square punch: F = 1.15 · 2 E* (side/2) δ · … within a few per cent of 1.153 E* side δ
    assert solution.force == pytest.approx(1.153 * 39.4 * n * 9.77 * 1.0, rel=0.03)


def test_asperities_add_up():
    """The force is the sum of those of the asperities one by one."""
    catalogue = asperities(glass_pair(scan(rough(24, seed=1))))
    found = superpose(catalogue, delta=[4.0], law="hertz")
    alone = [superpose(catalogue.isel(asperity=[k]), delta=[4.0], law="hertz") for k in range(catalogue.asperity.size)]
    assert int(found.contacts.sum()) > 1
    assert float(found.force.sum()) == pytest.approx(sum(float(one.force.sum()) for one in alone), rel=1e-12)
