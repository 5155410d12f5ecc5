"""Runs go on after whatever stopped them, and end with the same file."""

import errno
import functools
import multiprocessing
import os
import re
import signal
import sys
import time
from pathlib import Path

import dask
import filelock
import numpy as np
import psutil
import pytest
import xarray as xr

from roughxr import checkpointed, direct
from roughxr.application import archive, checkpoint
from roughxr.application.checkpoint import item_keys
from roughxr.files.storage import open_locked, open_locked_raw
from roughxr.mechanics.contact import elastic
from roughxr.mechanics.jobs.spread import Tasks
from roughxr.mechanics.scans import regions

from . import a_run

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX's")

SECONDS = 200

#: Children are forked, cheaply, by a server that has imported and compiled everything (``conftest``).
CONTEXT = multiprocessing.get_context("forkserver" if sys.platform != "win32" else "spawn")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Return the file of a run that nothing stopped, and how long it took."""
    a_run.solutions(a_run.surface())  # compiles here, where workers do not do so twice
    finish(tmp_path_factory.mktemp("first") / "run.nc")  # starts the server, which takes longer
    path = tmp_path_factory.mktemp("undisturbed") / "run.nc"
    began = time.monotonic()
    finish(path)
    return path, time.monotonic() - began


def start(path, **options):
    child = CONTEXT.Process(target=a_run.run_in_process, args=(path,), kwargs=options)
    child.start()
    return child


def finish(path, **options):
    child = start(path, **options)
    child.join(SECONDS)
    assert child.exitcode == 0


def kill(process, number=signal.SIGKILL):
    """Send a signal to a child, and end what it leaves behind."""
    workers = workers_of(process)  # of dask's pool
    if process.is_alive():
        os.kill(process.pid, number)
    process.join(SECONDS)
    for worker in workers:
        if worker.is_running():
            worker.kill()


def workers_of(process):
    try:
        return [child for child in psutil.Process(process.pid).children() if "spawn_main" in " ".join(child.cmdline())]
    except psutil.NoSuchProcess:  # it was faster
        return []


def same(path, other):
    """Compare two archives bit by bit, all but the log of what happened when."""
    ours = contents(path)
    theirs = contents(other)
    assert list(ours) == list(theirs)
    for name, ds in ours.items():
        xr.testing.assert_identical(ds, theirs[name])
        for key in ds.variables:
            assert ds[key].values.tobytes() == theirs[name][key].values.tobytes()


@functools.cache
def contents(path):
    """Return all groups of an archive, as they are stored, and its root, but for the log."""
    with open_locked_raw(path) as file:
        names = ["/", *archive.group_names(file)]
    groups = {}
    for name in names:
        with open_locked(path, group=name, mask_and_scale=False, decode_times=False) as ds:
            groups[name] = ds.load()
    groups.pop("log")
    checksums = groups["/"].attrs["checksums"].splitlines()
    groups["/"].attrs["checksums"] = sorted(line for line in checksums if not line.startswith("log "))
    return groups


def only(path):
    """Check that a finished run leaves nothing but its file."""
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def log(path):
    return archive.load(path)["log"].message.values.tolist()


#: Every fourth kills a worker, every other the parent under threads, every fifth twice, every third stores by stages:
#: three do each of it. Of the parent's own processes, each of which imports everything, more are killed in soak.
KILLS = [pytest.param(seed, marks=[] if seed in (1, 2, 5) else pytest.mark.soak) for seed in range(20)]


@pytest.mark.filterwarnings("ignore:.*the run is not finished")
@pytest.mark.parametrize("seed", KILLS)
def test_a_run_killed_at_a_random_moment_goes_on(tmp_path, undisturbed, seed):
    """The parent under threads or processes, or one of its workers; some are killed twice, some store by stages."""
    expected, seconds = undisturbed
    path = tmp_path / "run.nc"
    draw = np.random.default_rng(seed)
    options = {"scheduler": "threads" if seed % 2 else "processes", "stages": seed % 3 == 1}
    for _ in range(1 + (seed % 5 == 0)):
        child = start(path, **options)
        time.sleep(draw.uniform(0.05, 0.9) * seconds)
        workers = workers_of(child)
        if seed % 4 == 2 and workers:
            workers[0].kill()
            child.join(SECONDS)
            assert child.exitcode is not None  # a lost worker ends the run, which keeps what was finished
        else:
            kill(child)
        if path.exists():  # stages that ended can be read
            groups = archive.load(path)
            whole = archive.load(expected)
            for name in set(groups) - {"log"}:
                xr.testing.assert_identical(groups[name].load(), whole[name].load())
    finish(path, stages=options["stages"])
    same(path, expected)
    only(path)


def test_what_was_finished_is_not_computed_again(tmp_path, undisturbed):
    path = tmp_path / "run.nc"
    child = start(path, stops_after=20)
    child.join(SECONDS)
    finish(path)
    kept = [int(line.split(": ")[1].split()[0]) for line in log(path) if line.endswith("kept")]
    assert sum(kept) >= 5
    same(path, undisturbed[0])


def wait_for(path, results):
    """Wait until a run has stored so many batches."""
    until = time.monotonic() + SECONDS
    while len(list(path.with_name(path.name + ".checkpoint").glob("*.npz"))) < results:
        assert time.monotonic() < until
        time.sleep(0.002)


@pytest.mark.parametrize(
    ("size", "says", "resumes"),
    [
        (4096, "run.nc.checkpoint: the checkpoint could not be written .*: make room", "nothing|direct: 0 of"),
        (65536, "run.nc.checkpoint: the checkpoint could not be written .*: make room", "[a-z]+: [1-9]"),
        (1_900_000, "run.nc: could not be written .*: make room", "all computed"),
    ],
)
def test_a_full_disk_is_said_and_survived(small_disk, undisturbed, size, says, resumes, monkeypatch):
    """Too small for the checkpoint at all, for all results, for the archive beside them; trying again says so too."""
    monkeypatch.setattr(checkpoint, "_BETWEEN_FILES", -1.0)  # each batch has its file
    path = small_disk(size) / "run.nc"
    for expected in (says, "run.nc.*could not be .*: make room"):
        with pytest.raises(OSError, match=expected):
            a_run.run(path)
        assert not [file for file in path.parent.iterdir() if ".checkpoint" not in file.name]
    small_disk("64m")
    a_run.run(path)
    same(path, undisturbed[0])
    only(path)
    lines = [*log(path), "resumed", "nothing"]
    assert re.match(resumes, lines[lines.index("resumed") + 1])


def stopped(path):
    """Return the checkpoint of a run that was killed; its lock ended with it."""
    child = start(path, stops_after=20)
    child.join(SECONDS)
    return path.with_name(path.name + ".checkpoint")


def damage(file, how, draw):
    """Cut a file short, flip one of its bits, or overwrite it with noise."""
    content = bytearray(file.read_bytes())
    if how == "cut":
        del content[int(draw.integers(len(content))) :]
    elif how == "flipped":
        content[int(draw.integers(len(content)))] ^= 1 << int(draw.integers(8))
    else:
        content = draw.bytes(len(content))
    file.write_bytes(bytes(content))


def test_damaged_batches_are_computed_anew(tmp_path, undisturbed):
    path = tmp_path / "run.nc"
    draw = np.random.default_rng(0)
    batches = sorted(stopped(path).glob("[!.]*.npz"))
    damaged = {how: batches[start::4] for start, how in enumerate(["cut", "flipped", "noise"])}
    for how, files in damaged.items():
        for file in files:
            damage(file, how, draw)
    (batches[0].parent / "foreign.npz").write_bytes(batches[3].read_bytes())
    finish(path)
    reported = [line for line in log(path) if "damaged or foreign" in line]
    always = 1 + len(damaged["cut"]) + len(damaged["noise"])
    assert always < len(reported) <= always + len(damaged["flipped"])  # some bits mean nothing
    same(path, undisturbed[0])
    only(path)


def test_a_damaged_identity_uses_no_result(tmp_path, undisturbed):
    path = tmp_path / "run.nc"
    (stopped(path) / "identity.json").write_text("{")
    finish(path)
    assert "direct: 0 of 30 subregions kept" in log(path)
    same(path, undisturbed[0])


def test_two_runs_on_one_output(tmp_path, undisturbed):
    """The second is refused; the first goes on undisturbed."""
    path = tmp_path / "run.nc"
    first = start(path)
    wait_for(path, 5)
    with pytest.raises(BlockingIOError, match="another run writes to this output"):
        a_run.run(path)
    first.join(SECONDS)
    assert first.exitcode == 0
    same(path, undisturbed[0])


def test_a_finished_run_is_not_repeated(tmp_path, undisturbed, monkeypatch):
    expected, _ = undisturbed
    before = expected.stat()
    monkeypatch.setattr(a_run, "solutions", lambda ds: pytest.fail("computed again"))
    groups = a_run.run(expected)
    assert expected.stat().st_mtime_ns == before.st_mtime_ns
    assert groups["solutions/contact"].pressure.dtype == float
    only(expected)


def test_other_runs_under_the_same_name_are_refused_with_both_named(tmp_path, undisturbed):
    finished, _ = undisturbed
    stopped(tmp_path / "run.nc")
    for path in (finished, tmp_path / "run.nc"):
        with pytest.raises(ValueError, match=r"settings: delta \[1.0, 2.0, 3.0\], instead of delta \[1.0, 2.5\]"):
            a_run.run(path, arguments=a_run.ARGUMENTS | {"delta": [1.0, 2.5]})
        with pytest.raises(ValueError, match=r"settings: scan surface 3, instead of scan surface 4"):
            a_run.run(path, seed=4)
    only(finished)


def test_a_scheduler_that_is_not_there_leaves_no_trace(tmp_path):
    pytest.importorskip("distributed")
    with (
        dask.config.set({"distributed.comm.timeouts.connect": "200ms"}),
        pytest.raises(OSError, match=r"scheduler 'tcp://127.0.0.1:1': could not be reached"),
    ):
        a_run.run(tmp_path / "run.nc", scheduler="tcp://127.0.0.1:1")
    with pytest.raises(ValueError, match="scheduler: expected"):
        a_run.run(tmp_path / "run.nc", scheduler="cloud")
    assert not list(tmp_path.iterdir())


def test_a_file_that_is_no_run_is_refused_and_kept(tmp_path):
    path = tmp_path / "run.nc"
    path.write_text("a diary")
    with pytest.raises(ValueError, match="expected the archive of a run, found another kind of file"):
        a_run.run(path)
    assert path.read_text() == "a diary"
    only(path)


@pytest.mark.parametrize("scheduler", ["synchronous", "processes"])
def test_every_scheduler_gives_the_same_file(tmp_path, undisturbed, scheduler):
    finish(tmp_path / "run.nc", scheduler=scheduler, workers_by="fork")
    same(tmp_path / "run.nc", undisturbed[0])


def test_a_run_holds_what_the_functions_return(undisturbed):
    groups = archive.load(undisturbed[0])
    with dask.config.set(scheduler="synchronous"):
        expected = a_run.solutions(a_run.surface())
    for name, ds in expected.items():
        xr.testing.assert_identical(groups[name], ds)


def test_a_place_that_two_solves_share_is_solved_once(tmp_path):
    """Of twelve places four were solved before, of the same four under another pair none."""
    ds = a_run.surface()
    places = regions.centres(ds, (4, 3))
    stiffer = ds.assign_coords(contact_modulus=2 * ds["contact_modulus"])

    def compute():
        four_places = direct(ds, delta=[4.0, 6.0], subregions=regions.sample(places, 4))
        all_places = direct(ds, delta=[4.0, 6.0], subregions=places)
        other = direct(stiffer, delta=[4.0, 6.0], subregions=regions.sample(places, 4))
        return {"solutions/few": four_places, "solutions/every": all_places, "solutions/other": other}

    groups = checkpointed(compute, tmp_path / "run.nc", scan=ds, arguments={})
    said = [line for line in groups["log"].message.values.tolist() if line.endswith("kept")]
    assert said == [f"direct: {kept} subregions kept" for kept in ("0 of 4", "4 of 12", "0 of 4")]
    alone = direct(ds, delta=[4.0, 6.0], subregions=places)
    assert groups["solutions/every"].force.values.tobytes() == alone.force.values.tobytes()


def test_results_of_one_second_share_a_file(tmp_path, monkeypatch):
    put = checkpoint.Checkpoint.put
    files = []
    monkeypatch.setattr(checkpoint, "_BETWEEN_FILES", np.inf)
    monkeypatch.setattr(
        checkpoint.Checkpoint, "put", lambda self, items, results: files.append(len(items)) or put(self, items, results)
    )
    a_run.run(tmp_path / "run.nc")
    assert files[:2] == [30, 30]  # both simulations


def test_an_interrupt_stores_all_finished_results(tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    solve = elastic._sweep
    solved = []

    def interrupted(place, *rest):
        if len(solved) == 7:
            raise KeyboardInterrupt
        solved.append(place)
        return solve(place, *rest)

    interrupted.__module__ = solve.__module__
    interrupted.__qualname__ = solve.__qualname__
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(elastic, "_sweep", interrupted)
        a_run.run(path, scheduler="synchronous")
    a_run.run(path)
    assert "direct: 7 of 30 subregions kept" in log(path)


def test_failed_subregions_are_named_and_the_others_kept(tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    good = elastic._sweep

    def bad(place, *rest):
        if place.window.rows.start == 0 and place.window.columns.start == 0:
            raise ZeroDivisionError("a fault")
        return good(place, *rest)

    bad.__module__ = good.__module__
    bad.__qualname__ = good.__qualname__
    with monkeypatch.context() as patch:
        patch.setattr(elastic, "_sweep", bad)
        with pytest.raises(
            RuntimeError, match="direct: 1 of 30 subregions failed, first subregion 0: ZeroDivisionError: a"
        ):
            a_run.run(path)
    a_run.run(path)
    assert any(line == "direct: 29 of 30 subregions kept" for line in log(path))
    assert any("direct: subregion 0 failed" in line for line in log(path))


def test_large_results_stay_on_the_disk(tmp_path, undisturbed, monkeypatch):
    """Where results are too large for memory they are written to the archive from the checkpoint, and are the same."""
    monkeypatch.setattr(checkpoint, "_IN_MEMORY", 0)
    a_run.run(tmp_path / "run.nc")
    same(tmp_path / "run.nc", undisturbed[0])


def test_a_solve_is_known_by_all_that_it_depends_on():
    array = np.arange(12.0).reshape(3, 4)

    def key(shift=0.0, flag=True, rows=slice(0, 3), shared=array, shape=(2,)):
        arguments = [(1.0, flag, rows), (2.0 + shift, None, "text")]
        return tuple(item_keys(Tasks(_note, arguments, np.dtype((float, shape)), (shared, [array]))))

    others = [{"shift": 1e-15}, {"flag": False}, {"rows": slice(0, 2)}, {"shape": (3,)}]
    others += [{"shared": array + np.eye(3, 4) * 1e-15}, {"shared": array.T}, {"shared": array.astype("f4")}]
    keys = [key(**options) for options in ({}, *others)]
    assert len(set(keys)) == len(keys)
    assert key(shared=array.copy()) == keys[0]
    assert key(shared=array[:, :3]) != key(shared=array[:, :3].T)  # of the same shape


def _note(*values):
    return np.zeros(2)


def test_a_finished_run_is_read_where_nothing_can_be_written(tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    groups = a_run.run(path)

    def refuse(*_, **__):
        raise PermissionError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, "mkdir", refuse)
    monkeypatch.setattr(Path, "open", refuse)
    again = a_run.run(path)
    xr.testing.assert_identical(again["solutions/direct"], groups["solutions/direct"])
    with pytest.raises(ValueError, match="other settings"):
        a_run.run(path, arguments={"subregions": (6, 5), "delta": [1.0]})
    with pytest.raises(OSError, match="in which you may write, and call again"):
        a_run.run(tmp_path / "other.nc")


def test_a_file_system_without_locks_is_named_as_the_reason(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(filelock.FileLock, "acquire", refuse)
    with pytest.raises(OSError, match=r"No locks available.*on a file system that locks files"):
        a_run.run(tmp_path / "run.nc")


@pytest.mark.filterwarnings("ignore:.*the run is not finished")
@pytest.mark.parametrize(("interval", "stored"), [(-1.0, [["first"], ["first", "second"]]), (np.inf, [[], []])])
def test_groups_that_are_yielded_are_written_at_intervals_and_at_an_interrupt(interval, stored, tmp_path, monkeypatch):
    monkeypatch.setattr(checkpoint, "_BETWEEN_ADDITIONS", interval)
    path = tmp_path / "run.nc"
    in_archive = []

    def names():
        return list(archive.load(path)) if path.exists() else []

    def compute():
        for name in ("first", "second"):
            yield {name: xr.Dataset({"force": 1.0})}
            in_archive.append(names())
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        checkpointed(compute, path, scan=a_run.surface(), arguments={})
    assert in_archive == stored
    assert names() == ["first", "second"]
