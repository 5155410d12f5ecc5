"""Tasks on dask's schedulers: order, progress, failures, views."""

import io
import os
import signal
import struct
import sys

import dask
import numpy as np
import pytest
import xarray as xr

from roughxr import parallel
from roughxr.direct import direct
from roughxr.progress import Progress

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
def test_views_travel_as_places_in_one_array(scheduler, order):
    array = np.asarray(np.random.default_rng(0).standard_normal((20, 30)), order=order)
    with dask.config.set(scheduler=scheduler):
        found = parallel.spread(total, parts(array, 9), (1,), 2.0).compute()
    np.testing.assert_array_equal(found[:, 0], [2.0 * part.sum() for (part,) in parts(array, 9)])


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_results_come_as_they_finish_and_failures_as_words(scheduler):
    arguments = [(np.ones((2, 1 + k)),) for k in range(5)] + [(np.ones((1, 1)),)]
    work = parallel.Work(total, arguments, (1,), (3.0, []))
    found = {}
    with dask.config.set(scheduler=scheduler):
        parallel.each_finished(work, work.batches(10), found.__setitem__)
    assert sorted(found) == list(range(6))
    assert [found[k].item() for k in range(5)] == [6.0, 12.0, 18.0, 24.0, 30.0]
    assert found[5] == parallel.Failure("ZeroDivisionError: one")


def dies_while_it_answers(part, marker):
    """Die once, having sent half of a message: as a worker that is killed at the wrong moment."""
    if not marker.exists():
        marker.touch()
        frame = sys._getframe()
        while "result_queue" not in frame.f_locals:
            frame = frame.f_back
        os.write(frame.f_locals["result_queue"]._writer.fileno(), struct.pack("!i", 1000) + b"half")
        os.kill(os.getpid(), signal.SIGKILL)
    return part


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows kills otherwise")
def test_a_worker_that_dies_while_it_answers_is_noticed(tmp_path):
    work = parallel.Work(dies_while_it_answers, [(np.full(1, k),) for k in range(4)], (1,), (tmp_path / "died", []))
    found = {}
    with dask.config.set(scheduler="processes", num_workers=2):
        parallel.each_finished(work, work.batches(4), found.__setitem__)
    assert [found[k].item() for k in range(4)] == [0, 1, 2, 3]


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_progress_counts_subregions(surface, scheduler, capsys):
    with dask.config.set(scheduler=scheduler):
        shown = direct(surface, delta=[1.0], subregions=(5, 3), progress=True)
    assert "15/15 subregions" in capsys.readouterr().err
    xr.testing.assert_identical(shown, direct(surface, delta=[1.0], subregions=(5, 3)))


def test_the_dearest_windows_come_first(surface):
    """`direct` says what its windows cost: where more cells overlap."""

    class Noted:
        def array(self, work):
            self.work = work
            return np.zeros((len(work.arguments), *work.shape))

        def finish(self, ds):
            return ds

    noted = Noted()
    with parallel.kept_by(noted):
        direct(surface, delta=[1.0, 4.0], subregions=(4, 4))
    costs = noted.work.cost()
    areas = direct(surface, delta=[1.0, 4.0], subregions=(4, 4)).contact_area.isel(delta=-1)
    assert np.corrcoef(costs, areas)[0, 1] > 0.8


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_bar_on_a_terminal_and_lines_elsewhere(monkeypatch):
    """With rate, time left and failures; what an earlier session did counts as done, not for the rate."""
    now = [0.0]
    monkeypatch.setattr("roughxr.progress.time.monotonic", lambda: now[0])
    shown, lines = Terminal(), io.StringIO()
    for stream in (shown, lines):
        now[0] = 0.0
        progress = Progress(100, done=40, stream=stream)
        for _ in range(30):
            now[0] += 0.5
            progress.add()
        progress.add(2, failed=True)
        progress.close()
    assert shown.getvalue().count("\r") > 20
    assert shown.getvalue().endswith("70/100 subregions, 2 /s, 14 s left, 2 failed\x1b[K\n")
    assert lines.getvalue().splitlines() == [
        "60/100 subregions, 2 /s, 20 s left, 0 failed",
        "70/100 subregions, 2 /s, 14 s left, 2 failed",
    ]
    assert "\r" not in lines.getvalue()
