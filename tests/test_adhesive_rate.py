"""How fast the adhesive simulation of a smooth sphere nears the theory of Johnson, Kendall and Roberts."""

import numpy as np

import roughxr

from .surfaces import glass_pair, scan

RADIUS, W = 3000.0, 2 * 0.6747
CELLS = np.array([2.5, 4.0, 6.0, 10.0])  # to the radius of the contact at zero load


def pull_off_error(cells, places):
    """Return the error of the pull-off at places given in pixels, at so many pixels to the contact's radius."""
    modulus = float(glass_pair(scan(np.zeros((3, 3)))).contact_modulus)
    radius = (9 * np.pi * W * RADIUS**2 / (8 * modulus)) ** (1 / 3)
    pixel, size = radius / cells, 2 * int(2 * cells + 6) + 1
    ds = glass_pair(scan(np.zeros((size, size)), pixel), RADIUS)
    delta = 0.1 * radius**2 / RADIUS
    at = {"delta": [delta], "subregions": tuple(pixel * places.T)}
    cycle = roughxr.adhesive(ds, law="griffith", mesh=1, **at)
    assert cycle.complete.all() and not cycle.truncated.any()
    return cycle.pull_off_force.values / (1.5 * np.pi * W * RADIUS) - 1


def test_the_pull_off_converges_at_first_order_or_faster():
    """The root of the mean squared error over places: that of one place is no power, as rows of pixels let go."""
    places = np.vstack([[(0.0, 0.0), (0.5, 0.5), (0.0, 0.5)], np.random.default_rng(0).uniform(0, 0.5, (13, 2))])
    error = [np.sqrt(np.mean(pull_off_error(cells, places) ** 2)) for cells in CELLS]
    order, _ = np.polyfit(np.log(CELLS), np.log(error), 1)
    assert order <= -1.0
    assert error[-1] < 0.01
