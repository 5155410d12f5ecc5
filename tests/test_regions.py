"""Contact centres and windows."""

import numpy as np
import pytest

from roughxr.mechanics.scans.regions import centres, extent, windows

from .surfaces import rough, scan


def test_a_grid_of_tiles_has_its_centres_in_their_middle():
    surface = scan(np.zeros((512, 512)), pixel=5000 / 512)
    places = centres(surface, (8, 8))
    x = places.subregion_x.values.reshape(8, 8)
    np.testing.assert_allclose(np.diff(x[:, 0]), 625.0)
    assert x[0, 0] - extent(surface)[0] == pytest.approx(312.5)
    assert places.subregion_y.units == "nm"


def test_without_a_word_there_is_one_centre_in_the_middle():
    place = centres(scan(np.zeros((9, 7))))
    assert (float(place.subregion_x[0]), float(place.subregion_y[0])) == (0.0, 0.0)


def test_centres_travel_with_a_dataset():
    surface = scan(np.zeros((32, 32)))
    there = centres(surface, (2, 2))
    np.testing.assert_array_equal(centres(surface, there).subregion_x, there.subregion_x)
    np.testing.assert_array_equal(centres(surface.assign_coords(there.coords)).subregion_x, there.subregion_x)


@pytest.mark.parametrize("reach", [1.0, 33.0, 200.0, 1e4])
def test_windows_hold_every_pixel_within_reach(reach):
    surface = scan(rough(40))
    where = centres(surface, ([3.3, -180.0], [-51.0, 190.0]))
    places, shape = windows((surface.x.values, surface.y.values), where, reach)
    for window, cx, cy in zip(places, where.subregion_x.values, where.subregion_y.values):
        inside = np.zeros((40, 40), bool)
        inside[window.rows, window.columns] = True
        near = np.hypot(surface.x.values[:, None] - cx, surface.y.values[None, :] - cy) <= reach
        assert not (near & ~inside).any()
        # and what is cut away at the edge leaves the pixels where they belong in the full window
        x = window.origin[0] + 9.77 * (window.missing[0] + np.arange(window.rows.stop - window.rows.start))
        np.testing.assert_allclose(x + cx, surface.x.values[window.rows], atol=1e-9)
        assert window.rows.stop - window.rows.start + window.missing[0] <= shape[0]
