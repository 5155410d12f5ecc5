"""The catalogue of a scan that does not fit into memory: the same, chunk by chunk, each read once."""

import importlib
import threading
import weakref

import dask
import dask.array as da
import numpy as np
import pytest
import xarray as xr

from roughxr.asperity.catalogue import asperities
from roughxr.asperity.maps import pull_off_map
from roughxr.asperity.superposition import superpose
from roughxr.jobs.schedulers import NO_DASHBOARD, active_client
from roughxr.scans import level
from roughxr.scans.wavelength import later, waves

from .surfaces import glass_pair, rough, scan

module = importlib.import_module("roughxr.asperity.catalogue")  # the package gives the function of this name


@pytest.fixture
def small_tiles(monkeypatch):
    """Let chunks of a few pixels be tiles of their own."""
    monkeypatch.setattr(module, "_TILE_SIDE", 1)


CHUNKINGS = [
    {"x": 1},
    {"y": 1},
    {"x": 7},
    {"y": 11},
    {"x": 16, "y": 9},
    {"x": (1, 30, 2, 15), "y": (40, 1, 1, 10)},
    {"x": 48, "y": 52},
]


@pytest.mark.parametrize("chunks", CHUNKINGS, ids=str)
@pytest.mark.parametrize("step", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("options", [{}, {"patch": 9}, {"patch": 3, "vertex": "pixel"}, {"patch": "20 nm"}], ids=str)
def test_the_same_for_every_chunking(small_tiles, chunks, step, options):
    height = rough(52, smooth=1.5)[:48]
    surface = glass_pair(scan(np.round(height / step) * step if step else height, title="a scan"))
    xr.testing.assert_identical(asperities(surface.chunk(chunks), **options), asperities(surface, **options))


def test_the_same_with_tiles_as_they_come():
    surface = scan(rough(600)[:, :520])
    for chunks in ({"x": 1}, {"x": 256, "y": 100}, {"x": 300}):
        xr.testing.assert_identical(asperities(surface.chunk(chunks)), asperities(surface))


@pytest.mark.parametrize("dims", [("x", "y"), ("y", "x")])
def test_other_units_and_numbers_are_converted_on_the_way(small_tiles, dims):
    surface = scan(np.round(rough(40, smooth=1.5) * 4))
    counts = (surface.height.transpose(*dims).astype("int16") * 1000).assign_attrs(units="pm")
    surface = surface.assign(height=counts)
    xr.testing.assert_identical(asperities(surface.chunk(x=11, y=17)), asperities(surface))


@pytest.mark.parametrize(
    ("chunks", "least", "tiles"),
    [
        ((512,) * 3, 256, (512,) * 3),
        ((1,) * 7, 3, (3, 4)),
        ((5, 1, 1, 9), 3, (5, 11)),
        ((2,), 3, (2,)),
        ((1, 1, 5), 3, (7,)),
        ((100, 1), 3, (101,)),
    ],
)
def test_tiles_are_whole_chunks(chunks, least, tiles):
    assert module._joined_sizes(chunks, least) == tiles


class Chunks:
    """A lazy scan that counts how often its chunks are made, and how many of them are alive at once."""

    def __init__(self, height, chunk):
        self.made, self.alive, self.most, self.lock = 0, 0, 0, threading.Lock()
        source = np.array(height)
        places = da.map_blocks(
            lambda block_info=None: self._made(
                source[tuple(slice(*part) for part in block_info[None]["array-location"])]
            ),
            chunks=tuple((chunk,) * (n // chunk) for n in source.shape),
            dtype=float,
        )
        self.scan = scan(np.zeros_like(source)).assign(height=(("x", "y"), places, {"units": "nm"}))

    def _made(self, part):
        with self.lock:
            self.made += 1
            self.alive += 1
            self.most = max(self.most, self.alive)
        out = part.copy()
        weakref.finalize(out, self._gone)
        return out

    def _gone(self):
        with self.lock:
            self.alive -= 1


@pytest.mark.parametrize(
    ("scheduler", "workers", "most"), [("synchronous", 1, 2), ("threads", 2, 4)], ids=["one", "two threads"]
)
@pytest.mark.parametrize("levelled", [False, True])
def test_each_chunk_is_read_once_and_let_go(small_tiles, scheduler, workers, most, levelled):
    """64 chunks; levelling reads them once more, for its fit."""
    height = rough(256)
    lazy = Chunks(height, 32)
    with dask.config.set(scheduler=scheduler, num_workers=workers):
        found = asperities(level(lazy.scan) if levelled else lazy.scan, patch=5)
    assert lazy.made == 64 * (1 + levelled)
    assert lazy.alive == 0 and lazy.most <= most
    expected = asperities(level(lazy.scan).compute() if levelled else scan(height), patch=5)
    xr.testing.assert_identical(found, expected)


@pytest.mark.parametrize("smooth", [0.8, 3.0], ids=["splined", "on its pixels"])
def test_the_patch_that_suits_costs_a_second_look_and_no_more(small_tiles, smooth):
    """The spectrum wants all of a scan of 128 × 128 pixels before its summits are sought."""
    height = rough(128, smooth=smooth)
    lazy = Chunks(height, 32)
    with dask.config.set(scheduler="synchronous"):
        found = asperities(lazy.scan)
    assert lazy.made == 2 * 16 and lazy.alive == 0
    xr.testing.assert_identical(found, asperities(scan(height)))


def test_only_parts_of_a_large_scan_are_looked_at_twice():
    height, steps = rough(2048, smooth=2.0), (1.0, 1.0)
    lazy = Chunks(height, 256)
    with dask.config.set(scheduler="synchronous"):
        found = later(lazy.scan.height.data, steps).compute()
    assert lazy.made < 64 and found == waves(height, steps)


@pytest.mark.parametrize("solve", [pull_off_map, superpose])
def test_solves_of_a_lazy_scan_read_it_the_same_way(small_tiles, solve):
    lazy = Chunks(rough(128), 32)
    options = {"subregions": (2, 2)} | ({"delta": [1.0, 5.0]} if solve is superpose else {})
    found = solve(glass_pair(lazy.scan), **options)
    assert lazy.made == 0
    with dask.config.set(scheduler="synchronous"):
        found = found.compute()
    assert lazy.made == 2 * 16 and lazy.alive == 0
    expected = solve(glass_pair(scan(rough(128))), **options)
    of_the_patch = [name for name in expected.attrs if name.startswith("expect")]
    assert of_the_patch and not any(name in found.attrs for name in of_the_patch)
    xr.testing.assert_identical(found, expected.drop_attrs(deep=False).assign_attrs(found.attrs))


@pytest.mark.parametrize("scheduler", ["synchronous", "threads", "processes"])
def test_the_same_on_every_scheduler(small_tiles, scheduler):
    surface = scan(np.round(rough(60, smooth=2.0) * 2))
    with dask.config.set(scheduler=scheduler):
        xr.testing.assert_identical(asperities(surface.chunk(x=20, y=33)), asperities(surface))


def test_the_same_on_a_cluster(small_tiles):
    distributed = pytest.importorskip("distributed")
    surface = scan(np.round(rough(60, smooth=2.0) * 2))
    quiet = {"n_workers": 1, "threads_per_worker": 2, "processes": False, **NO_DASHBOARD}
    with distributed.LocalCluster(**quiet) as cluster, distributed.Client(cluster):
        assert active_client() is not None
        xr.testing.assert_identical(asperities(surface.chunk(x=20, y=33)), asperities(surface))


def test_missing_pixels_are_refused_in_the_same_words(small_tiles):
    height = rough(40)
    height[3, 4] = height[30, 30] = np.nan
    for surface in (scan(height), scan(height).chunk(x=20, y=10)):
        with pytest.raises(ValueError, match="2 missing pixels of 1600; fill them first"):
            asperities(surface)


def test_a_lazy_scan_of_one_height_has_no_asperity(small_tiles):
    flat = scan(np.full((40, 40), 3.0))
    found = asperities(flat.chunk(x=10, y=10))
    assert found.sizes["asperity"] == 0 and float(found.datum_height) == 3.0
    xr.testing.assert_identical(found, asperities(flat))
