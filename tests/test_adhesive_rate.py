"""How fast the adhesive simulation of a smooth sphere nears the theory of Johnson, Kendall and Roberts."""

import numpy as np
import pytest

import roughxr

from .surfaces import glass_pair, scan, unpressed

# Surfaces and meshes of these tests are coarse, which warns.
pytestmark = pytest.mark.filterwarnings("ignore::roughxr.mechanics.bodies.pair.ImplausiblePair")

RADIUS = 3000.0
W = 2 * 0.6747
CELLS = np.array([2.5, 4.0, 6.0, 10.0])  # to the radius of the contact at zero load


def pull_off_error(cells, places):
    """Return the error of the pull-off at places given in pixels, at so many pixels to the contact's radius."""
    modulus = float(glass_pair(scan(np.zeros((3, 3)))).contact_modulus)
    radius = (9 * np.pi * W * RADIUS**2 / (8 * modulus)) ** (1 / 3)
    pixel = radius / cells
    size = 2 * int(2 * cells + 6) + 1
    ds = glass_pair(scan(np.zeros((size, size)), pixel), RADIUS)
    delta = 0.1 * radius**2 / RADIUS
    at = {"delta": [delta], "subregions": tuple(pixel * places.T)}
    cycle = roughxr.adhesive(ds, law="jkr", mesh=1, **at)
    assert cycle.complete.all() and not cycle.truncated.any()
    return cycle.pull_off_force.values / (1.5 * np.pi * W * RADIUS) - 1


def test_the_pull_off_converges_at_first_order_or_faster():
    """The root of the mean squared error over places: that of one place is no power, as rows of pixels let go."""
    places = np.vstack([[(0.0, 0.0), (0.5, 0.5), (0.0, 0.5)], np.random.default_rng(0).uniform(0, 0.5, (3, 2))])
    error = [np.sqrt(np.mean(pull_off_error(cells, places) ** 2)) for cells in CELLS]
    order, _ = np.polyfit(np.log(CELLS), np.log(error), 1)
    assert order <= -1.0
    assert error[-1] < 0.01


def two_bumps(pixel, offset):
    """Return unequal summits 200 nm apart under a plane, moved by parts of a pixel."""
    x, y = (
        pixel * (np.arange(-int(half / pixel), int(half / pixel) + 1) + part) for half, part in zip((220, 120), offset)
    )
    summits = [-drop - ((x[:, None] - at) ** 2 + y**2) / (2 * r) for at, r, drop in ((-100, 300, 0), (100, 500, 0.4))]
    bodies = {"sphere_radius": 1e9, "contact_modulus": 40, "work_of_adhesion": 0.2}
    return scan(np.maximum(np.maximum(*summits), -30), pixel).contact.assign_pair(**bodies)


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
@pytest.mark.filterwarnings("ignore::roughxr.mechanics.contact.mesh.UnresolvedContact")
@unpressed()
def test_the_stated_error_of_a_single_mesh_covers_bumps_that_it_was_not_fitted_to():
    """1.5 to 6 cells to a contact's radius at pull-off; from four cells on a quarter or less is stated."""
    options = {"law": "jkr", "subregions": ([0.0], [0.0]), "preload": 100.0, "mesh": 1}
    expected = float(roughxr.adhesive(two_bumps(1.5, (0.0, 0.0)), **options).pull_off_force[0])
    covered = []
    stated = []
    for pixel in (8.0, 5.0, 3.5, 2.5):
        for offset in ((0.0, 0.0), (0.31, 0.17), (0.5, 0.5)):
            cycle = roughxr.adhesive(two_bumps(pixel, offset), **options)
            stated.append((float(cycle.pull_off_resolution[0]), float(cycle.pull_off_error[0])))
            covered.append(abs(float(cycle.pull_off_force[0]) / expected - 1) <= stated[-1][1])
    assert np.mean(covered) >= 0.95
    fine = [error for radius, error in stated if radius > 4]
    assert len(fine) >= 3 and max(fine) < 0.25
