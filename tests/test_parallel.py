"""Tasks on dask's schedulers: order, progress, failures, views."""

import io

import dask
import numpy as np
import pytest
import xarray as xr

from roughxr.contact.elastic import direct
from roughxr.jobs import lazy as parallel
from roughxr.jobs.progress import Progress

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
    """With rate, time left and failures; what an earlier call did counts as done, not for the rate."""
    now = [0.0]
    monkeypatch.setattr("roughxr.jobs.progress.time.monotonic", lambda: now[0])
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
