"""Weak adhesion hardly deforms the bodies: the pull-off over the work of adhesion is that of rigid bodies."""

import numpy as np
import pytest

import roughxr
from roughxr.mechanics.scans.synthetic import self_affine

from . import surfaces

RANGE = 0.3

#: Works of adhesion (J/m²) from nearly none to those usual in liquids.
WORKS = (1e-5, 3e-5, 1e-4, 3e-4, 1e-3)


def rough():
    """Return a rough surface of few pixels."""
    return self_affine((24, 24), 8.0, rms=1.2, hurst=0.8, rolloff=100, seed=11)


def rigid_limit(scan, radius, place):
    """Return the pull-off of rigid bodies by the exponential law over the work of adhesion, nm: that at first touch."""
    x, y = np.meshgrid(scan.x - place[0], scan.y - place[1], indexing="ij")
    separation = radius - np.sqrt(radius**2 - np.minimum(x**2 + y**2, radius**2)) - scan.height.values
    gap = separation - separation.min()
    pixel = float(scan.x[1] - scan.x[0])
    return np.exp(-gap / RANGE).sum() * pixel**2 / RANGE


def pull_off(scan, radius, work, place, **mesh):
    """Return the pull-off at one place over the work of adhesion, nm."""
    pair = {"sphere_radius": radius, "young_modulus": 70, "poisson_ratio": 0.2, "work_of_adhesion": work}
    places = {"subregions": ([place[0]], [place[1]])}
    mesh = roughxr.Mesh(1, None, **mesh)
    solution = scan.contact.assign_pair(**pair).contact.adhesive(law="exponential", mesh=mesh, **places)
    return float(solution.pull_off_force[0]) / work


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("radius", [300.0, 20.0], ids=["sphere", "sharp tip"])
def test_weak_adhesion_pulls_off_as_rigid_bodies(radius):
    """Whatever the step: stiff bodies pull most at first touch, within a fraction of it."""
    scan = rough()
    place = (68.0, 96.0)
    expected = rigid_limit(scan, radius, place)
    for work in WORKS:
        assert pull_off(scan, radius, work, place) == pytest.approx(expected, rel=0.01)
    assert pull_off(scan, radius, 1e-4, place, step=1.0) == pytest.approx(expected, rel=0.01)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_sphere_of_weak_adhesion_pulls_off_as_bradley():
    """2πwR on a plane that does not deform, here 2 nm from the middle of a pixel."""
    flat = surfaces.scan(np.zeros((41, 41)), 2.0)
    for work in WORKS[::2]:
        assert pull_off(flat, 300.0, work, (1.0, 1.0)) == pytest.approx(2 * np.pi * 300.0, rel=0.01)
