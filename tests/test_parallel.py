"""Tasks on dask's schedulers: order, progress, failures, views."""

import contextlib
import io
import multiprocessing
import os
import re
import sys
import time

import dask
import numpy as np
import pytest
import xarray as xr

from roughxr.application.runs.stages import Stages
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.jobs import spread
from roughxr.mechanics.jobs.interrupts import delivered_interrupts, is_interrupt
from roughxr.mechanics.jobs.progress import print_line, progress, rough_duration, subregion_bar

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
@pytest.mark.parametrize(("order", "lazy"), [("C", True), ("F", False)])
def test_views_give_the_same_results_in_every_process(scheduler, order, lazy):
    array = np.asarray(np.random.default_rng(0).standard_normal((20, 30)), order=order)
    with dask.config.set(scheduler=scheduler):
        sums = np.asarray(spread.task_results(total, parts(array, 9), (1,), 2.0, lazy=lazy))
    np.testing.assert_array_equal(sums[:, 0], [2.0 * np.ascontiguousarray(part).sum() for (part,) in parts(array, 9)])


@pytest.mark.filterwarnings("ignore::roughxr.mechanics.vocabulary.text.IncompleteResult")
@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_progress_counts_subregions(surface, scheduler, capsys):
    with dask.config.set(scheduler=scheduler), progress():
        shown = direct(surface, delta=[1.0], subregions=(5, 3))
    assert "15/15" in capsys.readouterr().err
    xr.testing.assert_identical(shown, direct(surface, delta=[1.0], subregions=(5, 3)))
    assert not capsys.readouterr().err  # told within the block only


def test_each_stage_is_reported_once_with_the_time_left_and_why_it_grows(monkeypatch):
    now = [0.0]
    titles = {"mesh": "choice of the mesh", "adhesive": "simulation with adhesion"}
    monkeypatch.setattr("roughxr.mechanics.jobs.progress.time.monotonic", lambda: now[0])
    with progress(stream := io.StringIO()), Stages({"mesh": 60, "adhesive": 300, "pages": 60}, titles) as stage:
        stage("mesh")
        now[0] = 60.0
        stage.expect("each place took 14 s", adhesive=900, none=1e9)
        stage("adhesive", " at 64 places")
        subregion_bar(32).close()  # too short to be shown in a file
        bar = subregion_bar(64)
        bar.start_t = bar.last_print_t = bar.start_t - 20.0
        bar.update(8)
        bar.close()
        now[0] = 960.0
        stage("pages")
    lines = [line for line in stream.getvalue().splitlines() if line.startswith("stage")]
    assert [line for line in lines if "left" in line] == [
        "stage 1 of 3, about 7 min left: choice of the mesh",
        "stage 2 of 3, about 16 min left (more than before: each place took 14 s): "
        "simulation with adhesion at 64 places",
        "stage 3 of 3, about 1 min left: pages",
    ]
    assert "stage 2 of 3:  12%" in stream.getvalue() and "8/64" in stream.getvalue()
    assert "/32" not in stream.getvalue()
    assert "\r" not in stream.getvalue() and "" not in stream.getvalue().split("\n")[:-1]


def test_the_places_that_finished_feed_the_time_left_and_the_first_waits_for_the_compiler(monkeypatch):
    """A place takes 3 s after a minute of compiling, the pages 30 s: each line of the bar states the time left so."""
    now = [0.0]
    monkeypatch.setattr("roughxr.mechanics.jobs.progress.time.monotonic", lambda: now[0])
    stages = Stages({"adhesive": 20, "pages": 30}, {"adhesive": "simulation"}, compiling=["adhesive"])
    with progress(stream := io.StringIO()), stages as stage:
        stage("adhesive")
        bar = subregion_bar(64)
        bar.delay = bar.mininterval = bar.miniters = 0
        now[0] = 60.0
        for _ in range(64):
            bar.update()
            now[0] += 3.0
        bar.close()
    first, *lines = stream.getvalue().splitlines()
    assert first == "stage 1 of 2, less than a minute left: simulation, compiling kernels, once on a machine"
    assert "1/64" in lines[0] and "left" not in lines[0]
    for line in lines[1:64]:
        finished = int(re.search(r"(\d+)/64", line)[1])
        assert f"{rough_duration(3.0 * (64 - finished) + 30)} left" in line
    assert "3.00s" not in stream.getvalue() and "<" not in stream.getvalue()  # no second clock, of tqdm


def test_the_speed_of_this_machine_shows_in_the_stages_to_come(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("roughxr.mechanics.jobs.progress.time.monotonic", lambda: now[0])
    with progress(stream := io.StringIO()), Stages({"one": 60, "two": 60, "three": 600}, {}) as stage:
        for name, duration in (("one", 200), ("two", 200), ("three", 0)):
            stage(name)
            now[0] += duration
    assert [line.split(": ")[0] for line in stream.getvalue().splitlines()] == [
        "stage 1 of 3, about 12 min left",
        "stage 2 of 3, about 33 min left (more than before",
        "stage 3 of 3, about 32 min left",
    ]


def test_a_bar_and_a_message_are_lines_of_their_own_in_a_file():
    """A bar is drawn, a message comes while it stands, and another state follows."""
    with progress(stream := io.StringIO()):
        bar = subregion_bar(4, label="places")
        bar.update(2)
        bar.refresh()
        print_line("Mean pull-off 60 nN")
        bar.close()
    lines = stream.getvalue().split("\n")
    assert "Mean pull-off 60 nN" in lines and "\r" not in stream.getvalue()
    assert all(line.startswith("places: ") for line in lines[:-1] if line != "Mean pull-off 60 nN")


def test_stages_are_messages_of_a_logger(caplog):
    caplog.set_level("INFO", logger="roughxr")
    with Stages({"one": 10}, {"one": "pull-off"}) as stage:
        stage("one")
    assert [record.getMessage() for record in caplog.records] == ["stage 1 of 1, less than a minute left: pull-off"]


@pytest.mark.parametrize("fails", [True, False])
def test_the_answer_so_far_is_left_by_a_run_that_is_interrupted(fails, capsys):
    with contextlib.suppress(KeyboardInterrupt), progress(stream := io.StringIO()), Stages({"one": 10}, {}) as stage:
        stage("one")
        stage.answer("pull-off 2 µN by 4 places")
        stage.answer("pull-off 3 µN by 64 places")
        stage.answer("pull-off 3 µN by 64 places")
        if fails:
            raise KeyboardInterrupt
    assert capsys.readouterr().out == "so far: pull-off 3 µN by 64 places\n" * fails
    assert stream.getvalue().count("4 places") == 2  # each answer once


@pytest.mark.parametrize("lazy", [True, False])
def test_other_results_than_were_told_are_refused(lazy):
    """Rather than stretched over the array."""
    with pytest.raises(TypeError, match=r"expected a result of .*\(3,\).*, found one of .*\(1,\)"):
        np.asarray(spread.task_results(total, [(np.ones((2, 2)),)], (3,), 2.0, lazy=lazy))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork:DeprecationWarning")
def test_a_process_that_forks_after_a_solve_solves_on_threads_of_its_own(surface):
    """The threads of dask's pool end with the fork: to wait for them would take for ever."""
    options = {"delta": [2.0], "subregions": (2, 2)}
    expected = direct(surface, **options).force.values
    context = multiprocessing.get_context("fork")
    queue = context.SimpleQueue()
    child = context.Process(target=lambda: queue.put(direct(surface, **options).force.values))
    child.start()
    child.join(60)
    alive = child.is_alive()
    child.kill()
    assert not alive
    np.testing.assert_array_equal(queue.get(), expected)


class Dropping:
    """What Python drops: an error in a destructor."""

    def __init__(self, error):
        self.error = error

    def __del__(self):
        raise self.error


def test_an_interrupt_that_a_destructor_drops_arrives_later(monkeypatch):
    reported = []
    monkeypatch.setattr(sys, "unraisablehook", lambda dropped: reported.append(dropped.exc_type))
    with pytest.raises(KeyboardInterrupt), delivered_interrupts():
        Dropping(KeyboardInterrupt())
        for _ in range(1000):  # until it arrives, between two of them
            time.sleep(0.01)
    with delivered_interrupts():
        Dropping(ValueError())
    assert reported == [ValueError]


def test_an_interrupt_is_known_by_the_errors_of_kernels_and_their_compiler():
    outer = SystemError("a kernel")
    outer.__cause__ = SystemError("within it")
    outer.__cause__.__cause__ = KeyboardInterrupt()
    assert is_interrupt(outer) and is_interrupt(RuntimeError("no compiled object yet for <Library 'shape'>"))
    assert not is_interrupt(RuntimeError("of a place")) and not is_interrupt(SystemError("of Python"))
