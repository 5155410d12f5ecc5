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


def test_every_array_has_the_checksum_of_hdf5(groups, tmp_path):
    with netCDF4.Dataset(save(groups, tmp_path / "run.nc")) as file:
        nodes = [file[name] for name in groups]
        arrays = [one for node in nodes for one in node.variables.values() if one.ndim]
        assert arrays and all(one.filters()["fletcher32"] for one in arrays)


def test_a_file_that_is_cut_short_is_refused(groups, tmp_path, capsys):
    path = save(groups, tmp_path / "run.nc")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert cli.main(["report", str(path)]) == 1
    assert "damaged, cut short or overwritten" in capsys.readouterr().err


def test_a_damaged_field_is_refused_where_it_is_read_and_nowhere_else(groups, tmp_path, monkeypatch):
    monkeypatch.setattr(archive, "_CHUNK", 1)  # read place by place, as larger fields are
    monkeypatch.setattr(archive, "_COMPRESSED", {})
    path, expected = save(groups, tmp_path / "run.nc"), groups["solutions/direct"]
    content, plane = path.read_bytes(), expected.gap.isel(subregion=2, delta=1).values.tobytes()
    where = content.index(plane)
    path.write_bytes(content[: where + 80] + bytes([content[where + 80] ^ 1]) + content[where + 81 :])
    found = load(path)["solutions/direct"]
    for part in ({"subregion": 3, "delta": 0}, {"subregion": [0, 1, 3]}, {"subregion": 0, "x": slice(3, 9), "y": 2}):
        xr.testing.assert_identical(found.gap.isel(part).load(), expected.gap.isel(part))
    xr.testing.assert_identical(found.pressure.load(), expected.pressure)
    with pytest.raises(ValueError, match=r"run.nc: .*damaged"):
        found.gap.isel(subregion=slice(1, 3)).load()


@pytest.mark.parametrize("attrs", [{"area/pixel": 1.0}, {"a/b": "text"}])
def test_an_attribute_with_a_slash_is_refused(groups, tmp_path, attrs):
    with pytest.raises(ValueError, match="scan: expected attribute names without '/', found"):
        save({"scan": groups["scan"].assign_attrs(attrs)}, tmp_path / "run.nc")
    with pytest.raises(ValueError, match="scan: expected attribute names without '/', found"):
        save({"scan": groups["scan"].assign(height=groups["scan"].height.assign_attrs(attrs))}, tmp_path / "run.nc")
    assert list(tmp_path.iterdir()) == []


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
