"""What is read of a scan is read once, and nobody's change of it is another's."""

import threading

import numpy as np

import roughxr
from roughxr.mechanics.scans.cache import cached

from .surfaces import glass_pair, rough, scan


def test_what_one_changes_in_place_no_other_sees():
    surface = glass_pair(scan(rough(48, seed=78)))
    first = surface.contact.asperities()
    kept = first.copy(deep=True)
    for name in first.variables:
        if first[name].ndim and first[name].values.flags.writeable and first[name].dtype == float and name not in "xy":
            first[name].values[:] = -1.0
    assert roughxr.asperities(surface).equals(kept)


def test_threads_get_the_same(monkeypatch):
    surface = glass_pair(scan(rough(48, seed=79)))
    catalogues = []
    workers = [threading.Thread(target=lambda: catalogues.append(surface.contact.asperities())) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(catalogues) == 4 and all(catalogue.equals(catalogues[0]) for catalogue in catalogues)


def test_a_square_array_is_not_its_transpose():
    first = cached(lambda height: float(height[0, 1]))
    height = np.arange(9.0).reshape(3, 3)
    assert (first(height), first(height.T)) == (1.0, 3.0)
