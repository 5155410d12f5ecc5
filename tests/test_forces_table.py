"""The table of forces that comes with the package: it is what its script states."""

from pathlib import Path

import pytest

from roughxr.measured import open_pull_off

TABLE = Path(__file__).parents[1] / "datasets" / "forces.csv"


def test_the_table_of_forces_is_read_with_its_places_and_the_tutorials_mean():
    measured = open_pull_off(TABLE)
    assert measured.sizes["subregion"] == 64 and measured.pull_off_force.units == "nN"
    assert {"subregion_x", "subregion_y"} <= set(measured.coords)
    assert float(measured.pull_off_force.mean()) == pytest.approx(37.8, abs=0.05)
