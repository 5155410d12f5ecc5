"""Archives: read back as written, whole or not there."""

import datetime
import os
import shutil

import h5py
import numpy as np
import pytest
import xarray as xr

from roughxr.application import archive, cli
from roughxr.archive import load, save
from roughxr.mechanics.asperity.superposition import superpose
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.vocabulary.schema import history
from roughxr.statistics import pull_off

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


def test_a_folder_with_one_archive_is_loaded_and_a_bare_dataset_not_saved(groups, tmp_path):
    save(groups, tmp_path / "run.nc")
    assert load(tmp_path).keys() == load(tmp_path / "run.nc").keys()
    with pytest.raises(ValueError, match="groups: expected Datasets by the names of their groups, found Dataset"):
        save(next(iter(groups.values())), tmp_path / "other.nc")


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


def test_a_file_that_is_cut_short_is_refused(groups, tmp_path, capsys):
    path = save(groups, tmp_path / "run.nc")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert cli.main(["report", str(path)]) == 1
    assert "damaged, cut short or overwritten" in capsys.readouterr().err


def test_a_damaged_field_is_refused_where_it_is_read_and_nowhere_else(groups, tmp_path, monkeypatch):
    monkeypatch.setattr(archive, "_CHUNK", 1)  # read place by place, as larger fields are
    monkeypatch.setattr(archive, "_COMPRESSED", {})
    path = save(groups, tmp_path / "run.nc")
    expected = groups["solutions/direct"]
    content = path.read_bytes()
    plane = expected.gap.isel(subregion=2, delta=1).values.tobytes()
    where = content.index(plane)
    path.write_bytes(content[: where + 80] + bytes([content[where + 80] ^ 1]) + content[where + 81 :])
    loaded = load(path)["solutions/direct"]
    for part in ({"subregion": 3, "delta": 0}, {"subregion": [0, 1, 3]}, {"subregion": 0, "x": slice(3, 9), "y": 2}):
        xr.testing.assert_identical(loaded.gap.isel(part).load(), expected.gap.isel(part))
    xr.testing.assert_identical(loaded.pressure.load(), expected.pressure)
    with pytest.raises(ValueError, match=r"run.nc: .*damaged"):
        loaded.gap.isel(subregion=slice(1, 3)).load()


@pytest.mark.parametrize("group", ["scan", "solutions/direct"])
def test_any_changed_byte_of_a_group_without_its_fields_is_noticed(groups, tmp_path, group):
    """As the library does not: a single value, an attribute, and an axis, each written anew with its own checksum."""
    path = save(groups, tmp_path / "run.nc")
    for name, change in {"attrs": "history", "scalar": "sphere_radius", "axis": "x"}.items():
        changed = shutil.copy(path, tmp_path / f"{name}.nc")
        with h5py.File(changed, "a") as file:
            if name == "attrs":
                file[group].attrs[change] = file[group].attrs[change] + b" "
            else:
                file[group][change][...] = file[group][change][...] * (1 + 1e-15)
        with pytest.raises(ValueError, match=f"{name}.nc: .*damaged.*{group} is not as it was written"):
            load(changed)
    assert set(load(path)) == set(groups)


def test_a_field_whose_part_lies_at_another_position_is_refused(groups, tmp_path):
    """One key of HDF5's index changed: the number of parts stays right, and the library reads NaN in silence."""
    path = save(groups, tmp_path / "run.nc")
    with h5py.File(path) as file:
        field = file["solutions/direct/gap"]
        places = []
        field.id.chunk_iter(lambda chunk: places.append(chunk.chunk_offset))
        key = np.array([*places[3], 0], "<u8").tobytes()
    content = path.read_bytes()
    wrong = np.array([places[3][0], places[3][1] + 2**20, *places[3][2:], 0], "<u8").tobytes()
    path.write_bytes(content.replace(key, wrong))
    lazy = load(path)["solutions/direct"].gap
    with pytest.raises(ValueError, match="solutions/direct/gap lacks parts"):
        lazy.load()


def test_a_field_is_not_read_from_a_file_that_replaced_its_own(groups, tmp_path):
    path = save(groups, tmp_path / "run.nc")
    lazy = load(path)["solutions/direct"]
    save(groups, path)  # by the same calls: the same fields
    xr.testing.assert_identical(lazy.gap.load(), groups["solutions/direct"].gap.load())
    other = groups["solutions/direct"]
    save({"solutions/direct": other.assign(force=2 * other.force, pressure=2 * other.pressure)}, path)
    with pytest.raises(ValueError, match="solutions/direct was replaced after it was loaded; load it again"):
        lazy.pressure.load()


@pytest.mark.parametrize(
    ("attrs", "message"),
    [
        ({"area/pixel": 1.0}, "names that begin with a letter, digit or _ and are free of '/'"),
        ({".hidden": 1.0}, "names that begin with a letter"),
        ({" ": 1.0}, "names that begin with a letter"),
        ({"trailing ": 1.0}, "names that begin with a letter"),
        ({"line\nbreak": 1.0}, "names that begin with a letter"),
        ({3: 1.0}, "names that begin with a letter"),
        ({"phase": 1j}, "attributes of text, numbers or arrays, found phase=1j"),
        ({"phases": np.array([1j])}, "attributes of text, numbers or arrays"),
        ({"day": np.datetime64("2020-01-01")}, "attributes of text, numbers or arrays"),
        ({"day": datetime.date(2020, 1, 1)}, "attributes of text, numbers or arrays"),
        ({"flag": np.True_}, "attributes of text, numbers or arrays"),
        ({"table": [[1.0, 2.0], [3.0, 4.0]]}, "attributes of text, numbers or arrays"),
        ({"pair": {"E": 75}}, "text, numbers or arrays, found pair="),
    ],
)
def test_attributes_that_netcdf_cannot_hold_are_refused_in_words(groups, tmp_path, attrs, message):
    for wrong in (
        groups["scan"].assign_attrs(attrs),
        groups["scan"].assign(height=groups["scan"].height.assign_attrs(attrs)),
    ):
        with pytest.raises(ValueError, match=f"scan: expected .*{message}"):
            save({"scan": wrong}, tmp_path / "run.nc")
    assert list(tmp_path.iterdir()) == []


def test_complex_variables_are_refused_in_words(tmp_path):
    with pytest.raises(ValueError, match="real numbers or text, found phase of type complex128"):
        save({"scan": xr.Dataset({"phase": ("x", [1j])})}, tmp_path / "run.nc")


@pytest.mark.parametrize("checksums", [None, ""])
def test_an_own_archive_without_checksums_is_refused(checksums, groups, tmp_path):
    path = save(groups, tmp_path / "run.nc")
    with h5py.File(path, "a") as file:
        del file.attrs["checksums"]
        if checksums is not None:
            file.attrs["checksums"] = checksums
    with pytest.raises(ValueError, match="it lacks the checksums of its groups"):
        load(path)


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="this system does not list open files")
def test_a_refused_archive_is_closed(groups, tmp_path):
    """Bytes changed at random: whatever the library says of it, the file can be deleted on any system."""
    whole = save({"scan": groups["scan"]}, tmp_path / "run.nc").read_bytes()
    random = np.random.default_rng(3)
    refused = 0
    for k in range(30):
        content = bytearray(whole)
        for place in random.integers(0, len(whole), 16):
            content[place] ^= 255
        path = tmp_path / f"damaged-{k}.nc"
        path.write_bytes(content)
        try:
            load(path)
        except ValueError:
            refused += 1
            opened = [f"/proc/self/fd/{number}" for number in os.listdir("/proc/self/fd")]
            assert str(path) not in [os.readlink(link) for link in opened if os.path.lexists(link)]
    assert refused > 20


def test_an_archive_that_would_fill_the_memory_is_refused_unread(tmp_path):
    """A variable of 8 GB without any stored value, in a file of some kB, in and beside an archive's groups."""
    path = save({"scan": xr.Dataset({"height": ("n", [1.0])})}, tmp_path / "run.nc")
    with h5py.File(path, "a") as file:
        file["scan"].create_dataset("more", (10**9,), "f8", chunks=(10**6,))
    with pytest.raises(ValueError, match=r"run\.nc: .* at most 256 MiB, by its size, found 7.63e\+03 MiB"):
        load(path)
