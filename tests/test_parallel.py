"""Tasks on dask's schedulers: order, progress, failures, views."""

import io
import re
import time

import dask
import numpy as np
import pytest
import xarray as xr

from roughxr.contact.elastic import direct
from roughxr.jobs import checkpoint as checkpoints
from roughxr.jobs import spread
from roughxr.jobs.checkpoint import Checkpoint
from roughxr.jobs.progress import Progress, Stages, progress, say

from .surfaces import glass_pair, rough, scan

SCHEDULERS = ["synchronous", "threads", "processes"]


def total(part, factor):
    if part.size == 1:
        raise ZeroDivisionError("one")
    return np.array([part.sum() * factor])


def parts(array, count):
    return [(array[k::2, : k + 1],) for k in range(1, count + 1)]


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(64, rms=1.5, seed=5)))


@pytest.mark.parametrize("scheduler", SCHEDULERS)
@pytest.mark.parametrize("order", ["C", "F"])
def test_views_give_the_same_results_in_every_process(scheduler, order):
    array = np.asarray(np.random.default_rng(0).standard_normal((20, 30)), order=order)
    with dask.config.set(scheduler=scheduler):
        found = spread.task_results(total, parts(array, 9), (1,), 2.0).compute()
    np.testing.assert_array_equal(found[:, 0], [2.0 * np.ascontiguousarray(part).sum() for (part,) in parts(array, 9)])


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_progress_counts_subregions(surface, scheduler, capsys):
    with dask.config.set(scheduler=scheduler), progress():
        shown = direct(surface, delta=[1.0], subregions=(5, 3))
    assert "15/15 subregions" in capsys.readouterr().err
    xr.testing.assert_identical(shown, direct(surface, delta=[1.0], subregions=(5, 3)))
    assert not capsys.readouterr().err  # told within the block only


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_bar_on_a_terminal_and_lines_elsewhere(monkeypatch):
    """With rate, time left and failures; what an earlier call did counts as done, not for the rate."""
    now = [0.0]
    monkeypatch.setattr("roughxr.jobs.progress.time.monotonic", lambda: now[0])
    shown, lines = Terminal(), io.StringIO()
    for stream in (shown, lines):
        now[0] = 0.0
        with progress(stream):
            bar = Progress(100, done=40)
        for _ in range(30):
            now[0] += 0.5
            bar.add()
        bar.add(2, failed=True)
        bar.close()
    assert shown.getvalue().count("\r") > 20
    assert shown.getvalue().endswith("70/100 subregions, 2 /s, 14 s left, 2 failed\x1b[K\n")
    assert lines.getvalue().splitlines() == [
        "60/100 subregions, 2 /s, 20 s left, 0 failed",
        "70/100 subregions, 2 /s, 14 s left, 2 failed",
    ]
    assert "\r" not in lines.getvalue()


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()])
def test_a_run_is_told_on_one_line_with_the_time_left_over_all_its_stages(monkeypatch, stream):
    now = [0.0]
    monkeypatch.setattr("roughxr.jobs.progress.time.monotonic", lambda: now[0])
    words = {"mesh": "choice of the mesh", "adhesive": "simulation with adhesion"}
    with progress(stream), Stages({"mesh": 30, "adhesive": 300, "pages": 60}, words) as stage:
        stage("mesh")
        stage.expect(adhesive=600, none=1e9)
        stage("adhesive", " at 64 places")
        bar = Progress(64)  # another's bar speaks through the run's line
        for _ in range(32):
            now[0] += 12.0
            bar.add()
        bar.close()
        say("the last loop")
        now[0] += 12.0
        stage("pages")
    told = [line for line in re.split(r"[\r\n]", stream.getvalue().replace("\x1b[K", "")) if line]
    assert told[0] == "stage 1 of 3, about 6 min left: choice of the mesh"
    assert "stage 2 of 3, about 11 min left: simulation with adhesion at 64 places" in told
    found = [line for line in told if "(32/64)" in line]
    assert found and "about 7 min left" in found[-1]  # half of them in 384 s, then a minute of pages
    assert told[-1] == "stage 3 of 3, about 1 min left: pages"
    assert stream.getvalue().count("\n") == (0 if stream.isatty() else len(told))  # one line on a terminal


@pytest.mark.parametrize("terminal", [True, False])
def test_an_answer_narrows_in_the_runs_line_and_is_left_by_a_run_that_is_interrupted(terminal, capsys):
    stream = Terminal() if terminal else io.StringIO()
    with pytest.raises(KeyboardInterrupt), progress(stream), Stages({"one": 10, "two": 10}, {}) as stage:
        stage("one")
        stage.found("pull-off 2 µN by 4 places", "2 µN (1 … 9)")
        stage("two")
        stage.found("pull-off 3 µN by 64 places", "3 µN (2 … 4)")
        raise KeyboardInterrupt
    assert capsys.readouterr().out == "so far: pull-off 3 µN by 64 places\n"
    told = stream.getvalue()
    assert told.count("\n") == (0 if terminal else 6)  # one line on a terminal
    at = "2 µN (1 … 9) | stage 2" if terminal else "pull-off 2 µN by 4 places\nstage 1"
    assert at in told and told.index("2 µN") < told.index("3 µN")


def test_a_run_that_ends_well_leaves_its_answer_to_what_it_prints(capsys):
    with Stages({"one": 10}, {}) as stage:
        stage.found("pull-off 2 µN", "2 µN")
    assert capsys.readouterr().out == ""


def test_a_run_with_nothing_new_to_tell_does_not_fall_silent(monkeypatch):
    monkeypatch.setattr("roughxr.jobs.progress._SILENT_AS_LINES", 0.05)
    stream = io.StringIO()
    with progress(stream), Stages({"one": 10}, {}) as stage:
        stage("one")
        time.sleep(0.5)
    count = stream.getvalue().count("stage 1 of 1")
    assert count > 2
    time.sleep(0.2)
    assert stream.getvalue().count("stage 1 of 1") == count  # and ends with the run


#: What the tests' task returns: numbers of several kinds, and an array.
RECORD = np.dtype([("total", float), ("size", int), ("large", bool), ("part", float, (2, 3))])


def record(part, factor):
    return np.array((part.sum() * factor, part.size, part.size > 4, part[:2, :3] * factor), dtype=RECORD)


def records_of(array, lazy=True):
    return spread.task_results(record, [(array[k:],) for k in range(5)], RECORD, 2.0, lazy=lazy)


def check_records(found, array):
    expected = np.stack([record(array[k:], 2.0) for k in range(5)])
    assert found.dtype == RECORD and found.shape == (5,)
    for name in RECORD.names:
        part = found[name]
        assert part.dtype == RECORD[name].base
        np.testing.assert_array_equal(part, expected[name])


@pytest.mark.parametrize("scheduler", SCHEDULERS)
@pytest.mark.parametrize("lazy", [True, False])
def test_results_may_be_records(scheduler, lazy):
    """Of numbers, flags and arrays; each field keeps its type, also where it is lazy."""
    array = np.random.default_rng(0).standard_normal((8, 4))
    with dask.config.set(scheduler=scheduler):
        found = records_of(array, lazy)
        assert bool(dask.is_dask_collection(found)) == lazy
        check_records(found, array)
        check_records(found.compute() if lazy else found, array)


@pytest.mark.parametrize("in_memory", [0, 2**24])
def test_records_are_computed_by_a_run(tmp_path, monkeypatch, in_memory):
    """In memory, or read from the checkpoint."""
    monkeypatch.setattr(checkpoints, "_IN_MEMORY", in_memory)
    array = np.random.default_rng(0).standard_normal((8, 4))
    with Checkpoint(tmp_path / "run.nc") as checkpoint:
        for _ in range(2):
            with spread.computed_by(checkpoints._WithCheckpoints(checkpoint)):
                found = records_of(array)
            assert bool(dask.is_dask_collection(found)) == (in_memory == 0)
            with dask.config.set(scheduler="synchronous"):
                check_records(found, array)


def test_a_lazy_result_may_be_an_array_of_records():
    """As of a task that computes many at once."""
    array = np.ones((8, 4))
    arguments = [(array,), (array,)]
    found = spread.task_results(many, arguments, np.dtype((RECORD, (3,))), 2.0).reshape(-1)
    assert found["part"].shape == (6, 2, 3)
    np.testing.assert_array_equal(found["total"].compute(), 64.0)


def many(part, factor):
    return np.array([record(part, factor)] * 3)


@pytest.mark.parametrize("lazy", [True, False])
def test_other_results_than_were_told_are_refused(lazy):
    """Rather than stretched over the array."""
    with pytest.raises(TypeError, match=r"expected a result of .*\(3,\).*, found one of .*\(1,\)"):
        np.asarray(spread.task_results(total, [(np.ones((2, 2)),)], (3,), 2.0, lazy=lazy))


def test_time_left_is_that_of_what_came_after_compiling(monkeypatch):
    """A hundred items of a second each behind a minute of compilation: the estimate is within a tenth, or none."""
    now = [0.0]
    monkeypatch.setattr("roughxr.jobs.progress.time.monotonic", lambda: now[0])
    bar = Progress(100)
    now[0] = 60.0
    bar.add(2)
    assert "unknown time left" in bar.text()
    for _ in range(97):
        now[0] += 1.0
        bar.add()
        left = 100 - bar.done
        assert f"{left // 60} min {left % 60} s left" in bar.text() or f" {left} s left" in bar.text()
