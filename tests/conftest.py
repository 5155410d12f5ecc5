"""What several tests need."""

import contextlib
import multiprocessing
import signal
import subprocess
import sys
from pathlib import Path

import dask
import pytest

#: Compiles on import, which is for the children of ``test_runs`` alone, not for whoever looks for doctests.
collect_ignore = ["a_run_compiled.py"]

#: Files in the order in which they begin, the others after them: what takes longest does not come last, and of two
#: that compile much each compiles another part, which the rest find compiled.
_FIRST = ("test_adhesive", "test_runs", "test_direct", "test_cli", "test_figures")


def pytest_collection_modifyitems(items):
    """Let the longest files begin first, so that no worker is left alone with one."""
    order = {name: k for k, name in enumerate(_FIRST)}
    items.sort(key=lambda item: order.get(item.path.stem, len(order)))


def pytest_configure():
    """Let Ctrl-C reach tests that a shell started in the background."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


#: What the server that forks worker processes has imported and compiled already; one serves all tests of a process.
PRELOADED = ["distributed", "tests.a_run_compiled"]


@pytest.fixture(scope="session", autouse=True)
def _forked_workers():
    """Let the tests' own worker processes be forked by a server, in a tenth of the time that it takes to spawn them.

    Those of the processes that tests start (``a_run``, the command line) are spawned, as everywhere else.
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
    """Yield a function that gives a folder's disk so many bytes, and makes it at the first call; needs root."""
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
