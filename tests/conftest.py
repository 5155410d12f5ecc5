"""What several tests need."""

import subprocess
import sys
from pathlib import Path

import pytest

#: Files in the order in which they begin, the others after them: what takes longest does not come last, and of two
#: that compile much each compiles another part, which the rest find compiled.
_FIRST = ("test_adhesive", "test_direct", "test_runs", "test_cli", "test_figures")


def pytest_collection_modifyitems(items):
    """Let the longest files begin first, so that no worker is left alone with one."""
    order = {name: k for k, name in enumerate(_FIRST)}
    items.sort(key=lambda item: order.get(item.path.stem, len(order)))


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
