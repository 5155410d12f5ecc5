"""Debris found by rule: all of it, hardly anything else, and every statistic with and without."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from datasets.make_glass import particle_centres
from roughxr.statistics import debris


def tiles(heights):
    """Return a catalogue of one asperity in each tile, and the tiles' centres."""
    at = np.arange(len(heights)) * 100.0
    places = {"x": ("asperity", at), "y": ("asperity", 0 * at)}
    catalogue = xr.Dataset({"height": ("asperity", heights, {"units": "nm"})}, coords=places)
    return catalogue, xr.Dataset(coords={"subregion_x": ("subregion", at), "subregion_y": ("subregion", 0 * at)})


def test_the_six_particles_of_the_twin_are_found_and_nothing_else():
    scan = roughxr.open_sample("glass")
    centres = roughxr.scans.regions.centres(scan, (8, 8))
    flags = debris(roughxr.asperities(scan), centres)
    nearest = {
        int(np.hypot(centres.subregion_x - x, centres.subregion_y - y).argmin("subregion"))
        for x, y in particle_centres()
    }
    assert set(np.flatnonzero(flags)) == nearest and len(nearest) == 6
    assert 20 < flags.threshold_value < 26 and flags.threshold_units == "nm"
    assert "6 median absolute deviations" in flags.comment


@pytest.mark.parametrize("law", ["normal", "gumbel"])
def test_clean_tiles_are_hardly_ever_flagged(law):
    rng = np.random.default_rng(1)
    draws = getattr(rng, law)(20.0, 1.0, (200, 64))
    flagged = np.mean([debris(*tiles(row)).values.mean() for row in draws])
    assert flagged < (0.001 if law == "normal" else 0.012)


def test_particles_of_ten_deviations_are_always_found_among_up_to_a_third():
    rng = np.random.default_rng(2)
    for count in (1, 6, 20):
        heights = rng.normal(20, 1, 64)
        heights[:count] += 10
        assert np.flatnonzero(debris(*tiles(heights))).tolist() == list(range(count))


def test_an_empty_tile_is_no_debris():
    catalogue, centres = tiles([1.0, 1.1])
    places = ("subregion", [0.0, 100, 5000])
    centres = xr.Dataset(coords={"subregion_x": places, "subregion_y": ("subregion", [0.0, 0, 0])})
    assert not debris(catalogue, centres).any()


def test_single_asperities_are_judged_too():
    catalogue, _ = tiles([14.0, 15, 16, 27])
    assert debris(catalogue).dims == ("asperity",) and debris(catalogue).values.tolist() == [False] * 3 + [True]


def test_equal_values_are_no_debris_of_the_few_that_differ():
    values = np.r_[np.zeros(60), np.linspace(0.1, 1.0, 40), 50.0]
    flags = debris(xr.Dataset({"height": ("asperity", values, {"units": "nm"})}))
    assert flags.values.tolist() == [False] * 100 + [True]
