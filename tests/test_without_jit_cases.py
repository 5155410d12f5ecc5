"""Contact cases small enough to run uncompiled; `test_without_jit` does."""

import numpy as np
import pytest

from roughxr.asperity.catalogue import asperities
from roughxr.asperity.superposition import superpose
from roughxr.bodies.pair import assign_pair
from roughxr.contact.adhesion import adhesive
from roughxr.contact.mesh import Mesh

from . import half_space as kalker
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


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")  # compiled, 0/0 is NaN without a word
def test_a_stiff_sphere_is_pulled_by_the_sum_of_the_attraction():
    """w/ρ exp(−gap/ρ) over the cells, the sphere's lowest point at the surface; E* = 1 TPa gives way by nothing."""
    reach, work, radius, pixel = 3.0, 0.02, 200.0, 10.0
    pair = {"sphere_radius": radius, "contact_modulus": 1000.0, "work_of_adhesion": work, "adhesion_range": reach}
    flat = assign_pair(scan(np.zeros((11, 11)), pixel), **pair)
    found = adhesive(flat, delta=[0.1], law="exponential", mesh=Mesh(1, accuracy=None, step=0.1))
    gap = radius - np.sqrt(radius**2 - 2 * radius * sphere_gap(11, pixel, radius))
    assert bool(found.converged.all())
    assert found.pull_off_force.item() == pytest.approx(
        (work / reach * np.exp(-gap / reach)).sum() * pixel**2, rel=2e-3
    )
