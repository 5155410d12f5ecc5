"""The table of forces that comes with the package: it is what its script states."""

from pathlib import Path

import numpy as np
import pytest

import roughxr
from roughxr.measured import open_pull_off

TABLE = Path(__file__).parents[1] / "datasets" / "forces.csv"


def test_values_an_empty_table_and_a_file_named_twice_are_no_forces(tmp_path):
    table = tmp_path / "forces.csv"
    table.write_text("force [nN]\n1\n2\n3\n")
    with pytest.raises(roughxr.Refusal, match=r"path: expected each file once, found .*forces.csv twice"):
        open_pull_off([table, table])
    (tmp_path / "empty.csv").write_text("force [nN]\n")
    with pytest.raises(roughxr.UnreadableScan, match=r"expected a table of forces.*a text without numbers, 'force"):
        open_pull_off(tmp_path / "empty.csv")
    for values in ([1.0, 2.0], np.array([1.0, 2.0])):
        with pytest.raises(TypeError, match=r"expected a file, or several, found values .*xr.Dataset\("):
            open_pull_off(values)


def test_the_table_of_forces_is_read_with_its_places_and_the_tutorials_mean():
    measured = open_pull_off(TABLE)
    assert measured.sizes["subregion"] == 64 and measured.pull_off_force.units == "nN"
    assert {"subregion_x", "subregion_y"} <= set(measured.coords)
    assert float(measured.pull_off_force.mean()) == pytest.approx(37.8, abs=0.05)
