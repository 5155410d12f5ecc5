"""Archives: read back as written, whole or not there."""

import subprocess
import sys

import netCDF4
import numpy as np
import pytest
import xarray as xr

from roughxr import archive, cli
from roughxr.archive import load, save
from roughxr.asperity.superposition import superpose
from roughxr.contact.elastic import direct
from roughxr.scans import to_netcdf
from roughxr.statistics import pull_off
from roughxr.vocabulary.schema import history

from .surfaces import glass_pair, rough, scan


@pytest.fixture(scope="module")
def groups():
    surface = glass_pair(scan(rough(48, seed=2)))
    sweep = superpose(surface, delta=np.arange(-2, 6, 1.0), subregions=(2, 2))
    return {
        "scan": surface,
        "solutions/direct": direct(surface, delta=[2.0, 6.0], subregions=(2, 2), fields=True),
        "solutions/energy": sweep,
        "statistics/energy": pull_off(sweep),
    }


def test_groups_come_back_identical(groups, tmp_path):
    path = save(groups, tmp_path / "run.nc", title="a test")
    with xr.open_datatree(path) as tree:
        assert tree.attrs["title"] == "a test"
        for name, ds in groups.items():
            xr.testing.assert_identical(tree[name].to_dataset(inherit=False).load(), ds)


def test_attributes_say_how_each_group_was_made(groups, tmp_path):
    with xr.open_datatree(save(groups, tmp_path / "run.nc")) as tree:
        step = history(tree["solutions/direct"].to_dataset())[-1]
    assert step["operation"] == "direct"
    assert step["arguments"]["delta"] == [2.0, 6.0]
    assert step["roughxr"]


def test_lazy_groups_are_computed(groups, tmp_path):
    lazy = {"scan": groups["scan"].chunk(x=20)}
    with xr.open_datatree(save(lazy, tmp_path / "lazy.nc")) as tree:
        xr.testing.assert_identical(tree["scan"].to_dataset().load(), groups["scan"])


def test_a_failed_write_leaves_the_old_archive_and_no_rubbish(groups, tmp_path):
    path = save(groups, tmp_path / "run.nc")
    before = path.read_bytes()
    broken = groups["scan"].assign(names=("x", np.array([{}] * 48, dtype=object)))
    with pytest.raises((ValueError, TypeError)):
        save({"scan": broken}, path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_an_archive_of_an_earlier_version_has_no_checksums_and_is_read(groups, tmp_path):
    path = save(groups, tmp_path / "run.nc")
    with netCDF4.Dataset(path, "a") as file:
        file.delncattr("checksums")
    for name, ds in load(path).items():
        xr.testing.assert_identical(ds.load(), groups[name])


def _units(file):
    file["scan"]["height"].units = "um"


def _coordinate(file):
    file["solutions/energy"]["delta"][3] += 1e-9


def _scalar(file):
    file["scan"]["sphere_radius"][...] = 3001.0


def _history(file):
    file["solutions/direct"].history = "[]"


def _checksums(file):
    file.checksums = file.checksums[:-1]


CHANGES = {
    "scan/": _units,
    "solutions/energy/delta": _coordinate,
    "scan/sphere_radius": _scalar,
    "solutions/direct/": _history,
    "checksums": _checksums,
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_was_changed_is_refused_and_named(groups, tmp_path, name, capsys):
    path = save(groups, tmp_path / "run.nc")
    with netCDF4.Dataset(path, "a") as file:
        CHANGES[name](file)
    with pytest.raises(ValueError, match=f"run.nc: .*damaged or changed, at: /?{name};"):
        load(path)
    assert cli.main(["report", str(path)]) == 1
    assert "damaged or changed" in capsys.readouterr().err


def test_a_changed_field_is_refused_where_it_is_used_and_nowhere_else(groups, tmp_path, monkeypatch):
    monkeypatch.setattr(archive, "_CHUNK", 1)  # read place by place, as larger fields are
    path = save({name: ds.chunk() for name, ds in groups.items()}, tmp_path / "run.nc")
    with netCDF4.Dataset(path, "a") as file:
        file["solutions/direct"]["pressure"][2, 1, 20, 20] += 1e-12
    found, expected = load(path)["solutions/direct"], groups["solutions/direct"]
    for part in ({"subregion": 3, "delta": 0}, {"subregion": [0, 1, 3]}, {"subregion": 0, "x": slice(3, 9), "y": 2}):
        xr.testing.assert_identical(found.pressure.isel(part).load(), expected.pressure.isel(part))
    xr.testing.assert_identical(found.gap.load(), expected.gap)
    with pytest.raises(ValueError, match=r"run.nc: .*damaged or changed, at: solutions/direct/pressure;"):
        found.pressure.isel(subregion=slice(1, 3)).load()


def test_attributes_that_netcdf_cannot_hold_are_refused_in_words(groups, tmp_path):
    with pytest.raises(ValueError, match="scan: expected attributes of text, numbers or arrays, found pair="):
        save({"scan": groups["scan"].assign_attrs(pair={"E": 75})}, tmp_path / "run.nc")
    assert list(tmp_path.iterdir()) == []


_OPENED_TWICE = """
import sys, xarray as xr
from roughxr import archive
trees = [xr.open_datatree(sys.argv[1]) for _ in range(5)]
read = archive.load(sys.argv[1])["log"]
with xr.open_dataset(sys.argv[1], group="log") as again:
    assert again.identical(read), (again, read)
print(*(repr(str(message)) for message in read["message"].values))
"""


def test_an_archive_that_is_open_already_can_be_opened_again(tmp_path):
    """Strings of variable length kill the interpreter here: hence another one."""
    messages = ["started", "", "µm, not μm: 表面"]
    log = xr.Dataset({"message": ("line", messages), "time": ("line", [1.0, 2.0, 3.0])}, {"branch": "retraction"})
    path = save({"log": log, "statistics/none": log.isel(line=[])}, tmp_path / "run.nc")
    command = [sys.executable, "-c", _OPENED_TWICE, str(path)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    assert found.stdout.split("\n")[0] == " ".join(map(repr, messages))


def test_text_is_stored_without_strings_of_variable_length(groups, tmp_path):
    named = groups["scan"].assign_coords(place=("x", [f"row {k}" for k in range(48)]))
    for path in (save({"scan": named}, tmp_path / "a.nc"), to_netcdf(named, tmp_path / "b.nc")):
        with netCDF4.Dataset(path) as file:
            holders = [file, *file.groups.values()]
            kinds = {str(v.dtype) for group in holders for v in group.variables.values()}
        assert "<class 'str'>" not in kinds
        assert "|S1" in kinds
