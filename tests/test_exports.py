"""Tables for resuspension models and for anyone with pandas."""

import io

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import roughxr
from roughxr import archive, particles, roughness
from roughxr.application.tables import to_table
from roughxr.mechanics.vocabulary import schema
from roughxr.particles import to_dem

from .surfaces import rough, scan


@pytest.fixture
def pull():
    values = {
        "pull_off_force": ("subregion", [300.0, 100, np.nan, 200, 200]),
        "pull_off_delta": ("subregion", np.zeros(5)),
    }
    pair = {"sphere_radius": 1000.0, "contact_modulus": 40.0, "work_of_adhesion": 0.1}
    places = {"subregion_x": ("subregion", np.arange(5.0)), "subregion_y": ("subregion", np.zeros(5))}
    return schema.label(xr.Dataset(values, coords=pair | places))


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
def test_resuspension_table_is_the_distribution(pull):
    head = to_dem(pull, code="rock_n_roll")
    forces = pd.read_csv(io.StringIO(head), comment="#")
    assert forces.columns.tolist() == ["force_nN", "cdf", "force_over_smooth"]
    assert forces.force_nN.tolist() == [100, 200, 300] and forces.cdf.tolist() == [0.25, 0.75, 1.0]
    np.testing.assert_allclose(forces.force_over_smooth, forces.force_nN / (1.5 * np.pi * 0.1 * 1000))
    assert "5 places; pull-off forces: 4; without adhesion: 1" in head and "sphere radius [nm]: 1000" in head
    assert "smooth sphere's pull-off force: 471.239 nN" in head


def test_a_solution_that_is_no_pull_off_is_refused():
    with pytest.raises(ValueError, match="pull_off"):
        to_dem(xr.Dataset({"force": ("subregion", [1.0])}), code="rock_n_roll")


def test_csv_comes_back_as_it_was(pull, tmp_path):
    table = pd.read_csv(to_table(pull, tmp_path / "pull.csv"))
    np.testing.assert_array_equal(table["pull_off_force [nN]"], pull.pull_off_force)
    assert {"subregion", "subregion_x [nm]", "sphere_radius [nm]", "pull_off_delta [nm]"} <= set(table)
    assert len(table) == 5


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_a_catalogue_and_a_sweep_are_tables_too(tmp_path):
    scan = roughxr.scans.synthetic.self_affine((48, 48), 10, rms=1, hurst=0.8, rolloff=100, seed=1)
    catalogue = roughxr.asperities(scan)
    table = pd.read_csv(to_table(catalogue, tmp_path / "asperities.csv"))
    np.testing.assert_allclose(table["curvature_max [1/nm]"], catalogue.curvature_max)
    scan = roughxr.assign_pair(scan, sphere_radius=500, contact_modulus=40)
    sweep = roughxr.direct(scan, delta=[1, 2], subregions=(2, 2))
    assert len(pd.read_csv(to_table(sweep, tmp_path / "direct.csv"))) == 8
    fields = roughxr.direct(scan, delta=[1, 2], subregions=(2, 2), fields=True)
    with pytest.raises(ValueError, match="fields of several places: pressure"):
        to_table(fields, tmp_path / "fields.csv")


def test_a_map_is_a_table_and_a_picture_for_gwyddion(tmp_path):
    """Each pixel at its place; the picture's first row is the largest y, and its units are SI."""
    gsffile = pytest.importorskip("gsffile", reason="GSF files need the extra roughxr[afm]")
    values = np.arange(12.0).reshape(3, 4)
    axes = {"x": ("x", [5.0, 15.0, 25.0], {"units": "nm"}), "y": ("y", [5.0, 15.0, 25.0, 35.0], {"units": "nm"})}
    pull = xr.Dataset({"pull_off_force": (("x", "y"), values, {"units": "nN"})}, axes)
    table = pd.read_csv(to_table(pull, tmp_path / "pull.csv")).set_index(["x [nm]", "y [nm]"])
    assert table.loc[(15.0, 35.0), "pull_off_force [nN]"] == 7.0
    rows, header = gsffile.read_gsf(roughxr.scans.to_file(pull, tmp_path / "pull.gsf", name="pull_off_force"))
    np.testing.assert_allclose(rows, 1e-9 * values.T[::-1], rtol=1e-6)
    assert header["ZUnits"] == "N" and header["XReal"] == 3e-8
    with pytest.raises(ValueError, match=r"pull_off_force.*found 'gap'"):
        roughxr.scans.to_file(pull, tmp_path / "pull.gsf", name="gap")


def test_text_in_a_csv_is_no_formula(tmp_path):
    names = ["=1+1", "+cmd", "-2", "@SUM(A1)", "quartz", "µ = 3"]
    ds = xr.Dataset({"name": ("k", names), "force": ("k", [-1.0, 2, 3, 4, 5, 6], {"units": "nN"})})
    read = pd.read_csv(to_table(ds, tmp_path / "a.csv"))
    assert read["name"].tolist() == ["'=1+1", "'+cmd", "'-2", "'@SUM(A1)", "quartz", "µ = 3"]
    assert read["force [nN]"].tolist()[0] == -1.0


@pytest.mark.parametrize("suffix", [".csv", ".xlsx"])
def test_control_characters_of_a_title_do_not_stop_a_table(suffix, tmp_path):
    table = to_table(xr.Dataset({"scan": ("place", ["a\x01b", "plain"])}), tmp_path / f"places{suffix}")
    read = pd.read_csv(table) if suffix == ".csv" else pd.read_excel(table)
    assert read["scan"].tolist() == [r"a\x01b", "plain"]


def test_scalars_are_a_table_too(tmp_path):
    numbers = roughness(scan(rough(32)))
    shown = to_table(numbers)
    assert shown.loc["s_q", "value"] == float(numbers.s_q)
    assert shown.loc["s_q", "units"] == "nm"
    assert set(shown.index) == set(numbers.data_vars)
    assert pd.read_csv(to_table(numbers, tmp_path / "a.csv"), index_col="quantity").value.s_q == shown.value.s_q


def test_what_is_handed_on_says_what_it_stands_for_and_one_condition_at_a_time(tmp_path):
    scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    held = roughxr.rolling(scan, directions=8, subregions=(2, 2))
    load = roughxr.particles.critical_load(held, "wall_shear", particle_density=2500)
    lines = particles.to_dem(held, code="lammps", classes=1)
    assert "without settling" in lines and "as the scan shows it" in lines
    assert "differs from the cumulative distribution" in lines
    assert "result of critical_load" in repr(load.contact)
    varied = xr.concat([held, held], "sphere_radius").assign_coords(sphere_radius=[1e3, 2e3])
    for hand_on in (particles.parameters, lambda ds: particles.to_dem(ds, code="lammps")):
        with pytest.raises(ValueError, match="several along sphere_radius; take one by isel"):
            hand_on(varied)
    path = archive.save({"detachment/load": load}, tmp_path / "one.nc")
    assert "xarray.open_datatree: detachment/load" in xr.open_dataset(path).attrs["comment"]
    with pytest.raises(ValueError, match="'silica/dolomite'; for another material"):
        scan.contact.assign_pair(sphere_radius=3000, materials="silica/dolomite")


def test_a_variable_is_a_table_of_its_own():
    force = xr.DataArray([1.0, 2.0], {"delta": [0.0, 1.0]}, "delta", "force")
    assert roughxr.to_table(force).columns.tolist() == force.contact.to_table().columns.tolist() == ["force"]
