"""A run on a real cluster of processes, one of which is lost half-way."""

import os
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import dask
import numpy as np
import psutil
import pytest
import xarray as xr

from roughxr import archive, checkpointed
from roughxr.application import checkpoint
from roughxr.application.runs import several
from roughxr.mechanics.asperity.pull_off_maps import pull_off_map
from roughxr.mechanics.contact.elastic import direct
from roughxr.mechanics.jobs import spread
from roughxr.mechanics.jobs.progress import progress
from roughxr.mechanics.jobs.spread import use_scheduler

from .surfaces import glass_pair, rough, scan

distributed = pytest.importorskip("distributed")

SECONDS = 60

#: Even without a dashboard, the scheduler's HTTP server asks for dask's usual port.
NO_DASHBOARD = {"dashboard_address": None, "scheduler_kwargs": {"dashboard_address": "127.0.0.1:0"}}
OPTIONS = {"subregions": (14, 14), "delta": np.arange(1.0, 9.0)}


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(128, rms=2.0, seed=8)))


@pytest.fixture
def cluster(tmp_path):
    """Yield the address of a `dask scheduler`, and two `dask worker` processes, all on loopback."""
    file = tmp_path / "scheduler.json"
    environment = {**os.environ, "PYTHONPATH": os.getcwd(), "DASK_DISTRIBUTED__WORKER__MEMORY__TERMINATE": "False"}

    def launch(*arguments):
        command = [sys.executable, "-m", "dask", *arguments, "--scheduler-file", str(file), "--no-dashboard"]
        return subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)

    scheduler = launch("scheduler", "--host", "127.0.0.1", "--port", "0")
    workers = [launch("worker", "--nthreads", "1", "--no-nanny", "--host", "127.0.0.1") for _ in range(2)]
    try:
        with distributed.Client(scheduler_file=str(file), timeout=SECONDS, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=SECONDS)
            address = client.scheduler.address
        yield address, workers
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


def solve(path, surface, scheduler):
    def groups():
        return {"solutions/direct": direct(surface, **OPTIONS), "map": pull_off_map(surface, subregions=(40, 40))}

    with use_scheduler(scheduler):
        return checkpointed(groups, path, scan=surface, arguments=OPTIONS)


@pytest.mark.soak
@pytest.mark.filterwarnings("ignore::roughxr.mechanics.asperity.catalogue.DoubtfulAsperities")
def test_a_killed_worker_is_replaced_by_the_other(tmp_path, surface, cluster, monkeypatch):
    """Its subregions are done again elsewhere; the file is that of a local run; no worker opened a NetCDF file."""
    monkeypatch.setattr(checkpoint, "_BETWEEN_FILES", -1.0)  # each batch has its file
    address, workers = cluster
    path = tmp_path / "far.nc"
    opened = []

    def watch_and_kill():
        folder = tmp_path / "far.nc.checkpoint"
        until = time.monotonic() + SECONDS
        while time.monotonic() < until and len(list(folder.glob("*.npz"))) < 60:
            time.sleep(0.005)
        for worker in workers:
            opened.extend(file.path for file in psutil.Process(worker.pid).open_files())
        workers[0].kill()

    killer = threading.Thread(target=watch_and_kill)
    killer.start()
    solve(path, surface, scheduler=address)
    killer.join()
    assert workers[0].wait() != 0
    assert workers[1].poll() is None
    assert not [name for name in opened if name.endswith((".nc", ".npz", ".part"))]
    solve(tmp_path / "near.nc", surface, scheduler="synchronous")
    far = archive.load(path)
    near = archive.load(tmp_path / "near.nc")
    for name in set(near) - {"log"}:
        xr.testing.assert_identical(far[name], near[name])


def test_an_active_client_is_used_and_counts_subregions(surface, capsys):
    options = OPTIONS | {"subregions": (7, 7)}
    expected = direct(surface, **options)
    cluster = distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, protocol="inproc://", **NO_DASHBOARD
    )
    with cluster, distributed.Client(cluster):
        # of windows that are sent, dask would warn
        with progress(), dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 kB"}):
            solved = direct(surface, **options)
        lazy = direct(surface.chunk(), **options)
        assert lazy.chunks
        computed = lazy.compute()
    xr.testing.assert_identical(solved.drop_attrs(), expected.drop_attrs())
    xr.testing.assert_identical(computed.drop_attrs(), expected.drop_attrs())
    assert "49/49" in capsys.readouterr().err


def test_a_chunked_scan_of_this_process_is_not_sent_to_the_scheduler(surface, monkeypatch):
    cluster = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="inproc://", **NO_DASHBOARD
    )
    with cluster, distributed.Client(cluster):
        remote = surface.chunk().persist()
        sent = []
        monkeypatch.setattr(distributed.Client, "get", lambda *arguments, **options: sent.append(arguments))
        leveled = surface.chunk().contact.level()
        lazy = direct(leveled, **OPTIONS)
        assert lazy.chunks and not sent
        monkeypatch.undo()
        xr.testing.assert_identical(remote.contact.level().compute(), leveled.compute())  # its chunks are the cluster's


def test_a_cluster_without_workers_is_told(surface):
    cluster = distributed.LocalCluster(n_workers=0, processes=False, protocol="inproc://", **NO_DASHBOARD)
    with (
        cluster,
        distributed.Client(cluster),
        dask.config.set({"distributed.comm.timeouts.connect": "500ms"}),
        pytest.raises(ConnectionError, match=r"its workers cannot be used \(.*expected at least one 'dask worker'"),
    ):
        direct(surface, **OPTIONS)


def test_a_run_says_that_it_waits_where_its_last_worker_is_lost(monkeypatch):
    monkeypatch.setattr(spread, "_PATIENCE", 0.2)
    with (
        distributed.LocalCluster(n_workers=0, processes=False, protocol="inproc://", **NO_DASHBOARD) as cluster,
        distributed.Client(cluster) as client,
        pytest.warns(UserWarning, match="no worker is left; the run waits for one"),
    ):
        threading.Timer(1.0, cluster.scale, [1]).start()
        future = client.submit(sum, [1, 2])
        assert [result for _, result in spread._as_completed(client, [future])] == [3]


def test_an_error_of_any_kind_at_one_scan_ends_no_batch(monkeypatch):
    def run_one(scan, folder):
        if scan.stem == "bad":
            raise MemoryError("of 40 GiB")
        if scan.stem == "stopped":
            raise SystemError from KeyboardInterrupt()
        if scan.stem == "repelled":
            return types.SimpleNamespace(summary=xr.Dataset(attrs={"missing": "The sphere adheres at no place."}))
        return types.SimpleNamespace(summary={"pull_off_force": 1.0})

    monkeypatch.setattr(several, "_scan_result", lambda run: run)
    scans = {Path(f"{name}.nc"): Path(name) for name in ("good", "bad", "repelled", "better")}
    finished, refused = several.run_each(scans, run_one)
    assert list(finished) == ["good.nc", "better.nc"]
    assert refused == {"bad.nc": "MemoryError: of 40 GiB", "repelled.nc": "The sphere adheres at no place."}
    with pytest.raises(SystemError):
        several.run_each(scans | {Path("stopped.nc"): Path("stopped")}, run_one)


@pytest.mark.parametrize("name", ["index.html.nc", "places.csv.nc", "wafer.xlsx.nc"])
def test_a_scan_with_the_name_of_a_batchs_own_file_is_refused_first(name):
    with pytest.raises(ValueError, match=rf"{name}: expected another name .*: rename the scan"):
        several.scan_folders([name], Path("out/wafer"))


@pytest.mark.parametrize("output", [".", "lot/.."])
def test_a_batch_written_here_names_its_table_after_the_folder(output, tmp_path, monkeypatch):
    folder = tmp_path / "wafer"
    (folder / "lot").mkdir(parents=True)
    monkeypatch.chdir(folder)
    assert several.table_name(Path(output)) == "wafer"
    with pytest.raises(ValueError, match=r"wafer\.xlsx\.nc: expected another name"):
        several.scan_folders(["wafer.xlsx.nc"], Path(output))
