"""Files are whole or not there, whatever happens while they are written."""

import os
import signal
import sys

import dask
import dask.array as da
import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr import archive
from roughxr.application.checkpoint import checkpointed
from roughxr.application.cli.file_commands import save_picture
from roughxr.application.tables import to_table
from roughxr.files.storage import atomic_write, remove_leftovers, uninterrupted
from roughxr.scans import to_file

from .surfaces import rough, scan


def test_nothing_is_there_before_the_end(tmp_path):
    path = tmp_path / "new" / "file.txt"
    with atomic_write(path) as temporary:
        temporary.write_text("all of it")
        assert not path.exists()
        assert temporary.parent == path.parent
        assert temporary.suffix == path.suffix
    assert path.read_text() == "all of it"
    assert [file.name for file in path.parent.iterdir()] == ["file.txt"]


@pytest.mark.parametrize("error", [ZeroDivisionError("half way"), RuntimeError("half way"), KeyboardInterrupt()])
def test_a_failure_leaves_what_was_there(tmp_path, error):
    path = tmp_path / "[1].txt"
    path.write_text("before")
    with pytest.raises(type(error)), atomic_write(path) as temporary:
        temporary.write_text("half")
        raise error
    assert path.read_text() == "before"
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_where_nothing_can_be_written_is_said(tmp_path):
    (tmp_path / "file").touch()
    with (
        pytest.raises(ValueError, match=r"file/run.nc: expected a name in a folder, found a file, .*file"),
        atomic_write(tmp_path / "file" / "run.nc"),
    ):
        pass


def test_leftovers_of_a_killed_process_are_removed(tmp_path):
    foreign = [tmp_path / name for name in ("map.part.png", ".film.mp4.0a1b2c3d.part", ".map.png.0a1b2c3d.part.png")]
    for file in foreign:
        file.touch()
    with atomic_write(tmp_path / "map.png") as temporary:
        temporary.touch()
        remove_leftovers(tmp_path, "run.nc")
        assert temporary.exists()
        remove_leftovers(tmp_path)
        assert not temporary.exists() and all(file.exists() for file in foreign)
        temporary.touch()


def noise():
    return xr.Dataset({"height": (("x", "y"), np.random.default_rng(0).random((300, 300)))})


WRITERS = {
    "archive.nc": lambda path: archive.save({"a/b": noise(), "c": noise().chunk(x=100)}, path),
    "scan.gsf": lambda path: to_file(scan(rough(256)), path),
    "table.csv": lambda path: to_table(noise().rename(x="row", y="column"), path),
    "figure.png": lambda path: save_picture(picture(), path),
}


def picture():
    from matplotlib.figure import Figure

    figure = Figure()
    figure.subplots().imshow(rough(256))
    return figure


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_is_reported_and_no_file_remains(small_disk, name):
    path = small_disk(65536) / name
    for _ in range(3):
        with pytest.raises(OSError, match=rf"{name}: could not be written .*: make room"):
            WRITERS[name](path)
        assert not list(path.parent.iterdir())
    small_disk("64m")
    WRITERS[name](path)
    assert [file.name for file in path.parent.iterdir()] == [name]
    if path.suffix == ".nc":
        again = path.with_name("again.nc")
        WRITERS[name](again)
        xr.testing.assert_identical(*(xr.open_datatree(file).load() for file in (path, again)))
        assert os.path.getsize(path) > 65536


@pytest.mark.skipif(sys.platform != "linux", reason="has no folder /proc, in which nobody may write")
def test_a_folder_in_which_nobody_may_write_is_no_full_disk():
    with pytest.raises(OSError, match=r"the checkpoint could not be written .*: choose a folder in which you may"):
        checkpointed(dict, "/proc/x/run.nc", scan=scan(rough(8)), arguments={})


def test_an_interrupt_waits_until_the_file_is_whole(tmp_path):
    path = tmp_path / "a.txt"
    done = []
    with pytest.raises(KeyboardInterrupt), atomic_write(path) as temporary, uninterrupted(), uninterrupted():
        signal.raise_signal(signal.SIGINT)
        temporary.write_text("all of it")
        done.append(True)
    assert done
    assert list(tmp_path.iterdir()) == []
    with uninterrupted():
        pass  # nothing is left waiting


def test_an_interrupt_that_waited_does_not_hide_that_there_was_an_error():
    with pytest.raises(KeyboardInterrupt) as interrupt, uninterrupted():
        signal.raise_signal(signal.SIGINT)
        raise ZeroDivisionError
    assert isinstance(interrupt.value.__context__, ZeroDivisionError)


def test_a_long_write_is_broken_off_between_two_pieces(tmp_path):
    read = []

    def piece(block):
        read.append(1)
        if len(read) == 3:
            signal.raise_signal(signal.SIGINT)
        return block

    lazy = da.zeros((1000, 4), chunks=(1, 4)).map_blocks(piece, meta=np.zeros((0, 0)))
    groups = {"scan": xr.Dataset({"a": (("subregion", "x"), lazy)})}
    with pytest.raises(KeyboardInterrupt), dask.config.set(scheduler="synchronous"):
        archive.save(groups, tmp_path / "a.nc")
    assert len(read) < 10
    assert list(tmp_path.iterdir()) == []
    archive.save(groups, tmp_path / "a.nc")
    assert archive.load(tmp_path / "a.nc")["scan"].a.shape == (1000, 4)


def test_an_error_that_is_none_of_the_disk_is_raised_as_it_is(tmp_path):
    places = roughxr.FailedSubregions("1 of 9 places failed")
    interrupt = RuntimeError("no compiled object yet for <kernel>")  # of Numba, where Ctrl-C was dropped
    for error in (places, interrupt):
        with pytest.raises(RuntimeError) as raised, atomic_write(tmp_path / "run.nc"):
            raise error
        assert raised.value is error and not list(tmp_path.iterdir())
