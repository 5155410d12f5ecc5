"""What is read of a scan is read once, and nobody's change of it is another's."""

import threading

import numpy as np

import roughxr
from roughxr.scans.cache import MOST_RESULTS, cached

from .surfaces import glass_pair, rough, scan


def test_equal_heights_are_read_once_and_others_anew():
    calls = []

    @cached
    def largest(height, times):
        calls.append(height.shape)
        return times * height.max()

    first = np.arange(6.0).reshape(2, 3)
    assert [largest(first, 2), largest(first.copy(), 2), largest(np.asfortranarray(first), 2)] == [10.0] * 3
    assert len(calls) == 1
    assert largest(first.reshape(3, 2), 2) == 10.0 and largest(first, 3) == 15.0 and len(calls) == 3
    changed = first.copy()
    changed[0, 0] = 7.0
    assert largest(changed, 2) == 14.0
    for k in range(MOST_RESULTS + 1):
        largest(first + k, 5)
    assert len(calls) == 4 + MOST_RESULTS + 1
    largest(first, 5)  # the oldest was given up
    assert len(calls) == 4 + MOST_RESULTS + 2


def test_what_one_changes_in_place_no_other_sees():
    surface = glass_pair(scan(rough(48, seed=78)))
    first = surface.contact.asperities()
    kept = first.copy(deep=True)
    for name in first.variables:
        if first[name].ndim and first[name].values.flags.writeable and first[name].dtype == float and name not in "xy":
            first[name].values[:] = -1.0
    assert roughxr.asperities(surface).equals(kept)


def test_threads_get_the_same(monkeypatch):
    surface, found = glass_pair(scan(rough(48, seed=79))), []
    workers = [threading.Thread(target=lambda: found.append(surface.contact.asperities())) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(found) == 4 and all(one.equals(found[0]) for one in found)
