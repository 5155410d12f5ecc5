"""Fixtures and the order of the test files."""

import contextlib
import gc
import multiprocessing
import os
import signal
import subprocess
import sys
from pathlib import Path

import dask
import pytest

# Linear algebra on all cores, beside another worker, spends its time waiting for cores: thirty times as much.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# Compiled Python is stored beside the compiled kernels: else each process of the tests compiles the package anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

#: Compiles on import, which is for the children of ``test_runs`` alone, not for whoever looks for doctests.
collect_ignore = ["a_run_compiled.py"]

#: Files that run first, in this order: the longest, and beside those that compile a kernel some that do not need it,
#: since two workers that need it at once both compile it.
_FIRST = (
    "test_adhesive",
    "test_statistics_uncertainty",
    "test_curve_fit",
    "test_scans_damage",
    "test_container",
    "test_extrapolated",
    "test_runs",
    "test_direct",
    "test_soft_bodies",
    "test_report",
    "test_cli",
    "test_examples",
    "test_resting",
    "test_layered_verbs",
    "test_humidity",
    "test_figures",
    "test_measured_fitting",
    "test_error_budget",
    "test_site",
    "test_yielding_adhesive",
    "test_identities",
)


def pytest_collection_modifyitems(items):
    """Put the longest files first, so that all workers end at about the same time."""
    order = {name: k for k, name in enumerate(_FIRST)}
    items.sort(key=lambda item: order.get(item.path.stem, len(order)))


def pytest_collection_finish():
    """Let the garbage collector look at what tests make alone, and seldom: it took a tenth of their time."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


def pytest_configure():
    """Let Ctrl-C reach tests that a shell started in the background."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


#: Modules that the server of forked worker processes imports and compiles once for all tests.
PRELOADED = ["distributed", "tests.a_run_compiled"]


@pytest.fixture(scope="session", autouse=True)
def _forked_workers():
    """Fork the tests' worker processes from a server, in a tenth of the time of spawning.

    Processes that tests start themselves (``a_run``, the command line) spawn theirs, as users' programs do.
    """
    if sys.platform == "win32":
        yield
        return
    ways = {"distributed.worker.multiprocessing-method": "forkserver", "multiprocessing.context": "forkserver"}
    with dask.config.set(ways):
        with contextlib.suppress(ImportError):
            from distributed.utils import get_mp_context

            get_mp_context()  # writes a list of its own, once
        multiprocessing.set_forkserver_preload(PRELOADED)
        yield


@pytest.fixture
def shared_scans():
    """Return the folder of real AFM files, which lies beside the checkout where there is one."""
    folder = Path(__file__).resolve().parents[2] / "shared" / "scans"
    if not folder.is_dir():
        pytest.skip("no folder of real AFM files beside the checkout")
    return folder


@pytest.fixture
def small_disk(tmp_path):
    """Yield a function that mounts or resizes a small disk of some bytes and returns its folder; needs root."""
    folder = tmp_path / "disk"
    folder.mkdir()

    def hold(size):
        again = "remount," if folder.is_mount() else ""
        command = ["mount", "-t", "tmpfs", "-o", f"{again}size={size}", "tmpfs", str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.skip(f"a small disk cannot be mounted here: {done.stderr.strip()}")
        return folder

    if sys.platform != "linux":
        pytest.skip("a small disk is a tmpfs, which is Linux's")
    yield hold
    if folder.is_mount():
        subprocess.run(["umount", "--lazy", str(folder)], check=True)
