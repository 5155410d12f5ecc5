"""Items of a solve in batches: their size, their order, failures and losses."""

import multiprocessing
import os
import signal
import sys
import threading
import time

import dask
import numpy as np
import psutil
import pytest

from roughxr.jobs.executor import Failure, _Queue, each_finished
from roughxr.jobs.work import Work

SCHEDULERS = ["synchronous", "threads", "processes"]

#: One number.
FLOATS = np.dtype((float, (1,)))


def kept_in(found, sizes=None):
    """Return what puts each item's result, or its failure, in its place, and notes the sizes of batches."""

    def receive(batch, result):
        assert not found.keys() & set(batch)  # nothing comes twice
        found.update(zip(batch, [result] if isinstance(result, Failure) else result))
        if sizes is not None:
            sizes.append(len(batch))

    return receive


def double(k):
    if k == 7:
        raise ZeroDivisionError("seven")
    return np.array([2.0 * k])


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_results_come_as_they_finish_and_failures_as_words(scheduler):
    """Of a batch with one item that fails, only that item is lost."""
    found, sizes = {}, []
    with dask.config.set(scheduler=scheduler, num_workers=2):
        each_finished(Work(double, [(k,) for k in range(60)], FLOATS, ([],)), range(60), kept_in(found, sizes))
    assert sorted(found) == list(range(60))
    assert found.pop(7).reason == "ZeroDivisionError: seven"
    assert all(found[k].item() == 2 * k for k in found)
    assert sizes[0] == 1 < max(sizes)


def wait(k, seconds):
    time.sleep(seconds)
    return np.array([float(k)])


@pytest.mark.parametrize(
    ("seconds", "items", "largest"),
    [(1e-3, 400, 100), (0.02, 200, 25), pytest.param(0.6, 8, 1, marks=pytest.mark.soak)],
)
def test_batches_take_half_a_second_and_less_near_the_end(seconds, items, largest):
    found, sizes = {}, []
    with dask.config.set(scheduler="threads", num_workers=1):
        each_finished(
            Work(wait, [(k,) for k in range(items)], FLOATS, (seconds, [])), range(items), kept_in(found, sizes)
        )
    assert [found[k].item() for k in range(items)] == list(range(items))
    assert sizes[0] == 1
    assert 0.5 * largest <= max(sizes) <= largest
    assert max(sizes[-3:]) <= max(largest // 4, 1)


def test_large_results_come_in_small_batches():
    sizes = []
    work = Work(zeros, [()] * 40, np.dtype((float, (2**18,))), ([],))
    with dask.config.set(scheduler="synchronous"):
        each_finished(work, range(40), kept_in({}, sizes))
    assert max(sizes) == 8  # 16 MiB


def zeros():
    return np.zeros(2**18)


def taken(queue):
    while queue.waiting:
        yield len(queue.take())


def test_a_large_cluster_gets_a_batch_for_each_core():
    """The main process cannot serve thousands of cores with batches of half a second."""
    queue = _Queue(Work(wait, [], np.dtype((float, (8, 12))), (), None), range(100_000), 1000, 0.02)
    queue.seconds.append(0.1)
    assert list(taken(queue)) == [100] * 1000


def test_the_most_expensive_are_begun_first_with_their_neighbours():
    begun, cost = [], np.random.default_rng(0).random(30)
    work = Work(wait, [(k,) for k in range(30)], FLOATS, (0.0, []), lambda: cost)
    wanted = [k for k in range(30) if k % 5]
    with dask.config.set(scheduler="synchronous"):
        each_finished(work, wanted, lambda batch, result: begun.append(batch))
    left = set(wanted)
    for batch in begun:
        assert batch[0] == max(left, key=cost.__getitem__)
        assert left >= set(batch)
        left -= set(batch)
    assert not left


def test_what_stops_this_thread_stops_the_rest():
    with dask.config.set(scheduler="synchronous"), pytest.raises(KeyboardInterrupt):
        each_finished(Work(interrupted, [(), ()], FLOATS, ([],)), range(2), lambda batch, result: None)


def interrupted():
    raise KeyboardInterrupt


def test_an_interrupt_within_a_kernel_is_no_failure_of_an_item():
    """It comes out of Numba as a SystemError, which is an Exception."""
    work = Work(interrupted_kernel, [(0.0,)], FLOATS, ([],))
    with dask.config.set(scheduler="synchronous"), pytest.raises(KeyboardInterrupt):
        each_finished(work, range(1), lambda batch, result: None)


def interrupted_kernel(_):
    error = SystemError("returned a result with an exception set")
    error.__cause__ = KeyboardInterrupt()
    raise SystemError("returned a result with an exception set") from error


def dies(k):
    if k == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.3)
    return np.array([float(k)])


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows kills otherwise")
def test_an_item_that_kills_its_workers_is_given_up():
    found = {}
    with dask.config.set(scheduler="processes", num_workers=1):
        each_finished(Work(dies, [(k,) for k in range(4)], FLOATS, ([],)), range(4), kept_in(found))
    assert found[2].reason == "lost 4 workers"
    assert [found[k].item() for k in (0, 1, 3)] == [0, 1, 3]


def one_dies(k):
    if k == 77:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(1e-3)
    return np.array([float(k)])


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows kills otherwise")
def test_what_is_lost_with_an_item_that_kills_is_computed():
    """The others of its batch, and of those that were computed beside it."""
    found = {}
    with dask.config.set(scheduler="processes", num_workers=2):
        each_finished(Work(one_dies, [(k,) for k in range(500)], FLOATS, ([],)), range(500), kept_in(found))
    assert found.pop(77).reason == "lost 4 workers"
    assert sorted(found) == [k for k in range(500) if k != 77]
    assert all(found[k].item() == k for k in found)


def waits_in_processes(folder):
    with dask.config.set(scheduler="processes", num_workers=2):
        each_finished(Work(leaves_its_number, [(), ()], FLOATS, (folder, [])), range(2), kept_in({}))


def leaves_its_number(folder):
    (folder / str(os.getpid())).touch()
    time.sleep(60)


@pytest.mark.soak
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows kills otherwise")
def test_workers_end_with_the_process_they_work_for(tmp_path):
    """However it ends: killed, it cannot tell them."""
    parent = multiprocessing.get_context("spawn").Process(target=waits_in_processes, args=(tmp_path,))
    parent.start()
    until = time.monotonic() + 60
    while len(numbers := [int(file.name) for file in tmp_path.iterdir()]) < 2:
        assert time.monotonic() < until
        time.sleep(0.05)
    workers = [psutil.Process(number) for number in numbers]
    parent.kill()
    left = psutil.wait_procs(workers, timeout=20)[1]
    for worker in left:
        worker.kill()
    assert not left


def dies_while_it_answers(k, folder):
    """Die once, so many milliseconds after the result is done, which takes longer to send."""
    marker = folder / str(k)
    if not marker.exists():
        marker.touch()
        threading.Timer(k * 1e-3, os.kill, (os.getpid(), signal.SIGKILL)).start()
    return np.full(2**22, float(k))


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows kills otherwise")
def test_a_worker_that_dies_while_it_answers_is_noticed(tmp_path):
    """Half of a message must not be waited for."""
    dtype, found = np.dtype((float, (2**22,))), {}
    work = Work(dies_while_it_answers, [(k,) for k in (1, 4, 16)], dtype, (tmp_path, []))
    with dask.config.set(scheduler="processes", num_workers=1):
        each_finished(work, range(3), kept_in(found))
    assert [float(found[k][-1]) for k in range(3)] == [1, 4, 16]


@pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX's")
def test_what_threads_have_begun_is_handed_over_at_an_interrupt():
    """It is waited for in any case."""
    found = {}
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    work = Work(wait, [(k,) for k in range(9)], FLOATS, (0.7, []))
    with dask.config.set(scheduler="threads", num_workers=2), pytest.raises(KeyboardInterrupt):
        each_finished(work, range(9), kept_in(found))
    assert sorted(found) == [0, 1]
